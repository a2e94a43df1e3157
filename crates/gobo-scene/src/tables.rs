//! Tables of the scene file, in the library's units.
use super::{
    Bounds, Camera, Scene, SceneError, defaults,
    document::{CameraTable, MaterialTable, Shades, TextureSource},
    keys::{ABOVE_ZERO, Keys},
    noise::Noise,
    source::SceneText,
};
use glam::{UVec2, Vec3, Vec4};
use gobo::{
    model::{
        Air, ClusterSettings, Fresnel, Lens, MAX_AIR_STEPS, MAX_BLUR, MAX_MAP_SIZE, MAX_SAMPLES,
        MaskSettings, Material, Occlusion, ShadowFilter, ShadowSettings, Tone, Transfer,
        dither::MAX_SCALE,
    },
    records::MAX_TILE,
};
use serde::Deserialize;
use toml::Spanned;

/// Settings of a file without a `[shadow]` table.
pub(super) fn usual_shadow() -> ShadowSettings {
    ShadowSettings { detail: true, soft_detail: true, ..ShadowSettings::default() }
}

pub(super) fn shadow(keys: &Keys<'_>) -> Result<ShadowSettings, SceneError> {
    let usual = usual_shadow();
    let nodes = keys.value("nodes", usual.nodes)?;
    if ![4, 8, 16].contains(&nodes) {
        let help = "a curve has 4, 8 or 16 nodes";
        return Err(keys.fault("nodes", format!("nodes is {nodes}"), help));
    }
    let reach = format!("a blur reaches 0 to {MAX_BLUR} texels");
    Ok(ShadowSettings {
        size: keys.map_size()?.unwrap_or(usual.size),
        receiver: keys.value("receiver", usual.receiver)?,
        nodes,
        filter: filter(keys)?.unwrap_or(usual.filter),
        bias: keys.bias("bias")?.or(usual.bias),
        slope_bias: keys.bias("slope_bias")?.unwrap_or(usual.slope_bias),
        normal_bias: keys.bias("normal_bias")?.unwrap_or(usual.normal_bias),
        pair_budget: keys.whole("pair_budget", usual.pair_budget, 1..=u32::MAX, "at least 1")?,
        texel_budget: keys.whole("texel_budget", usual.texel_budget, 1..=u64::MAX, "at least 1")?,
        curve_budget: keys.whole("curve_budget", usual.curve_budget, 1..=u64::MAX, "at least 1")?,
        curve_memory: usual.curve_memory,
        soften: keys.value("soften", usual.soften)?,
        colored: keys.value("colored", usual.colored)?,
        blur: keys.whole("blur", usual.blur, 0..=MAX_BLUR, &reach)?,
        detail: keys.value("detail", usual.detail)?,
        soft_detail: keys.value("soft_detail", usual.soft_detail)?,
        soft_budget: keys.whole("soft_budget", usual.soft_budget, 1..=u64::MAX, "at least 1")?,
        mips: usual.mips,
    })
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum KindOfFilter {
    None,
    Bilinear,
    Spline,
    Pcf,
    Vogel,
}

/// Shadow filter of one light or all: the compared texels around a receiver.
pub(super) fn filter(keys: &Keys<'_>) -> Result<Option<ShadowFilter>, SceneError> {
    let filter = keys.one("filter", |keys| {
        let taps = |usual, least, most| {
            keys.whole("taps", usual, least..=most, &format!("{least} to {most} taps"))
        };
        let most = ShadowFilter::MAX_RADIUS;
        Ok(match keys.required("kind")? {
            KindOfFilter::None => ShadowFilter::None,
            KindOfFilter::Bilinear => ShadowFilter::Bilinear,
            KindOfFilter::Spline => ShadowFilter::Spline,
            KindOfFilter::Pcf => ShadowFilter::Pcf { taps: taps(5, 2, ShadowFilter::MAX_PCF)? },
            KindOfFilter::Vogel => ShadowFilter::Vogel {
                taps: taps(16, 1, ShadowFilter::MAX_VOGEL)?,
                radius: keys
                    .number("radius", 0.0..=most, &format!("0 to {most} texels"))?
                    .unwrap_or(2.5),
            },
        })
    })?;
    Ok(filter.map(Spanned::into_inner))
}

pub(super) fn mask(keys: &Keys<'_>) -> Result<MaskSettings, SceneError> {
    let usual = MaskSettings::default();
    let (most_taps, most) = (MaskSettings::MAX_TAPS, MaskSettings::MAX_LIMIT);
    let taps = keys.value("taps", usual.taps)?;
    if taps != 1 && !(3..=most_taps).contains(&taps) || taps % 2 == 0 {
        let help = format!("an odd number, 3 to {most_taps}; 1 for no blur");
        return Err(keys.fault("taps", format!("taps is {taps}"), &help));
    }
    let anisotropic = keys.given("anisotropic")?;
    if taps == 1 && anisotropic == Some(true) {
        let help = "remove it, or set taps to 3 or more";
        return Err(keys.fault("anisotropic", "there is no blur: taps is 1", help));
    }
    let number = |key, usual| Ok(keys.number(key, 0.0..=1e6, "0 to 1e6")?.unwrap_or(usual));
    Ok(MaskSettings {
        half: keys.value("half", usual.half)?,
        taps,
        depth_scale: number("depth_scale", usual.depth_scale)?,
        anisotropic: anisotropic.unwrap_or(usual.anisotropic),
        sensitivity: number("sensitivity", usual.sensitivity)?,
        limit: keys.whole("limit", usual.limit, 1..=most, &format!("1 to {most} masks"))?,
    })
}

/// Air of a table; `None` if it neither scatters nor absorbs.
pub(super) fn air(keys: &Keys<'_>) -> Result<Option<Air>, SceneError> {
    for (old, new) in
        [("density", "extinction"), ("density", "scattering"), ("albedo", "scattering")]
    {
        if keys.has(old) && keys.has(new) {
            let help = "density and albedo say what scattering and extinction say: use either two";
            return Err(keys.fault(old, format!("{old} beside {new}"), help));
        }
    }
    let usual = Air::default();
    let albedo = keys.three("albedo", 0.0..=1.0, "from 0 to 1")?.unwrap_or(Vec3::ONE);
    let per_metre = |key| -> Result<Option<Vec3>, SceneError> {
        let Some(Shades(rgb)) = keys.given(key)? else { return Ok(None) };
        keys.check(key, &rgb, 0.0..=1e3, "0 to 1000")?;
        Ok(Some(rgb.into()))
    };
    let density = keys.number("density", 0.0..=1e3, "0 to 1000")?.map(Vec3::splat);
    let (scattering, extinction) = (per_metre("scattering")?, per_metre("extinction")?);
    let extinction = extinction.or(density).or(scattering).unwrap_or(usual.extinction);
    let scattering = scattering.unwrap_or(extinction * albedo);
    let anisotropy = keys.number("anisotropy", -0.95..=0.95, "from -0.95 to 0.95")?;
    let steps = format!("1 to {MAX_AIR_STEPS} steps");
    let air = Air {
        scattering,
        extinction,
        ambient: keys.share("ambient", usual.ambient)?,
        anisotropy: anisotropy.unwrap_or(usual.anisotropy),
        steps: keys.whole("steps", usual.steps, 1..=MAX_AIR_STEPS, &steps)?,
    };
    Ok((scattering + extinction != Vec3::ZERO).then_some(air))
}

pub(super) fn clusters(keys: &Keys<'_>) -> Result<ClusterSettings, SceneError> {
    let usual = ClusterSettings::default();
    let within = |key, usual, least, most| {
        keys.whole(key, usual, least..=most, &format!("{key} is {least} to {most}"))
    };
    let tile = within("tile", usual.tile, 16, MAX_TILE)?;
    if tile % 16 != 0 {
        return Err(keys.fault("tile", format!("tile is {tile}"), "tile is a multiple of 16"));
    }
    Ok(ClusterSettings {
        tile,
        slices: within("slices", usual.slices, 1, ClusterSettings::MAX_SLICES)?,
        near: keys.number("near", ABOVE_ZERO..=1e7, "a distance above 0")?,
        budget: within("budget", usual.budget, 0, ClusterSettings::MAX_BUDGET)?,
    })
}

pub(super) fn camera(keys: &Keys<'_>) -> Result<CameraTable, SceneError> {
    let fov_y = keys.angle("fov_y")?;
    let size = keys.array::<u32, 2>("size")?.map(UVec2::from);
    if let Some(size) = size
        && (size.min_element() < 1 || size.max_element() > MAX_MAP_SIZE)
    {
        let help = format!("a picture is 1 to {MAX_MAP_SIZE} pixels wide and high");
        return Err(keys.fault("size", format!("size is {size}"), &help));
    }
    let shift = keys.array::<f32, 2>("shift")?.unwrap_or_default();
    keys.check("shift", &shift, -0.5..=0.5, "-0.5 to 0.5 pixels")?;
    let samples = format!("a pixel has 1 to {MAX_SAMPLES} samples");
    let exposure = keys.number("exposure", -32.0..=32.0, "from -32 to 32 stops")?;
    let occlusion = match keys.given::<toml::Value>("occlusion")? {
        None | Some(toml::Value::Boolean(true)) => Occlusion::Usual,
        Some(toml::Value::Boolean(false)) => Occlusion::None,
        Some(toml::Value::Float(_) | toml::Value::Integer(_)) => {
            let radius = keys.number("occlusion", ABOVE_ZERO..=1e7, "a radius above 0")?;
            radius.map_or(Occlusion::None, Occlusion::Radius)
        }
        Some(other) => {
            let help = "write true, false or a radius [m]";
            return Err(keys.fault("occlusion", format!("occlusion is {other}"), help));
        }
    };
    Ok(CameraTable {
        eye: keys.vector("eye")?,
        target: keys.vector("target")?,
        up: keys.direction("up")?,
        fov_y,
        size,
        exposure,
        samples: keys.whole("samples", defaults::SAMPLES, 1..=MAX_SAMPLES, &samples)?,
        shift: shift.into(),
        occlusion,
        bloom: keys.share("bloom", 0.0)?,
        shutter: keys.share("shutter", 0.0)?,
        lens: Lens {
            radius: keys.number("lens", 0.0..=1e4, "a radius from 0 to 10000 [m]")?.unwrap_or(0.0),
            focus: keys.number("focus", ABOVE_ZERO..=1e7, "a distance above 0")?,
        },
        tone: keys.value("tone", Tone::Neutral)?,
    })
}

/// Camera of a table; missing values default to those of `base`. Without `base` the eye is placed so that
/// `bounds`, or the contents of a single file, fill the picture.
pub(super) fn placed_camera(
    source: &SceneText<'_>,
    table: &Spanned<CameraTable>,
    base: Option<Camera>,
    bounds: &Bounds,
    alone: Option<&Scene>,
) -> Result<Camera, SceneError> {
    let given = table.get_ref();
    let mut camera = base.unwrap_or_else(|| defaults::camera(bounds));
    camera.fov_y = given.fov_y.unwrap_or(camera.fov_y);
    camera.size = given.size.unwrap_or(camera.size);
    camera.target = given.target.unwrap_or(camera.target);
    camera.up = given.up.unwrap_or(camera.up);
    match (given.eye, base, alone) {
        (Some(eye), ..) => camera.eye = eye,
        (None, Some(_), _) => {}
        (None, None, None) => camera.eye = defaults::eye(&camera, bounds),
        (None, None, Some(scene)) => {
            camera = defaults::framed(camera, scene, given.target.is_some());
        }
    }
    let fault = |key, message, help| Err(source.error_at(&table.span(), key, message, help));
    let Some(forward) = (camera.target - camera.eye).try_normalize() else {
        return fault("eye", "eye and target are the same", "move one of them");
    };
    if forward.cross(camera.up).length() < 1e-4 {
        if given.up.is_some() {
            return fault("up", "up is along the view", "turn one of them");
        }
        camera.up = Vec3::Z;
    }
    Ok(camera)
}

pub(super) fn material(keys: &Keys<'_>) -> Result<MaterialTable, SceneError> {
    let usual = Material::default();
    let name = keys.required("name")?;
    let transfer: Transfer = keys.value("transfer", Transfer::default())?;
    let tint = keys.array("tint")?.unwrap_or([1.0; 4]);
    let most = transfer.max_color();
    keys.check("tint", &tint[..3], 0.0..=most, &format!("from 0 to {most}"))?;
    keys.check("tint", &tint[3..], 0.0..=1.0, "from 0 to 1")?;
    let cell = format!("a cell of a pattern is 1 to {MAX_SCALE} texels");
    let attenuation_color = keys.three("attenuation_color", 0.0..=1.0, "from 0 to 1")?;
    let attenuation_distance =
        keys.number("attenuation_distance", ABOVE_ZERO..=f32::MAX, "above 0")?;
    if attenuation_color.is_some() && attenuation_distance.is_none() {
        let help = "give it an attenuation_distance [m]";
        return Err(keys.fault("attenuation_color", "colour without a distance", help));
    }
    let filters = !transfer.is_opaque() && transfer != Transfer::None;
    if attenuation_distance.is_some() && !filters {
        let message = "a volume of a material that does not filter";
        let help = "use another transfer, such as \"filter\"";
        return Err(keys.fault("attenuation_distance", message, help));
    }
    let catcher = keys.value("catcher", usual.catcher)?;
    if catcher && !transfer.is_opaque() {
        let help = "give it transfer = \"opaque\"";
        return Err(keys.fault("catcher", "a catcher that is not opaque", help));
    }
    let (ior, fresnel) = glass(keys, filters)?;
    let dispersion = keys.number("dispersion", 0.0..=20.0, "from 0 to 20")?;
    if dispersion.is_some() && !matches!(fresnel, Fresnel::Face { .. }) {
        let message = "dispersion of what does not refract light";
        let help = "give the material an ior, and neither thin nor an opaque transfer";
        return Err(keys.fault("dispersion", message, help));
    }
    let far_side = far_side(keys, transfer, catcher)?;
    let texture = keys.given("texture")?;
    if let Some(TextureSource::Noise(noise)) = &texture {
        check_noise(keys, noise)?;
    }
    let material = Material {
        name,
        transfer,
        shape: keys.value("shape", usual.shape)?,
        profile: keys.value("profile", usual.profile)?,
        tint: Vec4::from(tint),
        texture: None,
        reflectivity: keys.share("reflectivity", usual.reflectivity)?,
        cutoff: keys.share("cutoff", usual.cutoff)?,
        pattern: keys.value("pattern", usual.pattern)?,
        pattern_scale: keys.whole("scale", usual.pattern_scale, 1..=MAX_SCALE, &cell)?,
        emission: keys.three("emission", 0.0..=f32::MAX, "0 or more")?.unwrap_or_default(),
        emissive_texture: None,
        transmission: keys.share("transmission", usual.transmission)?,
        roughness: keys.share("roughness", usual.roughness)?,
        metallic: keys.share("metallic", usual.metallic)?,
        ior,
        fresnel,
        dispersion: dispersion.unwrap_or(0.0),
        far_side: usual.far_side,
        details: usual.details,
        frost: keys.share("frost", usual.frost)?,
        attenuation_color: attenuation_color.unwrap_or(Vec3::ONE),
        attenuation_distance: attenuation_distance.unwrap_or(f32::INFINITY),
        receives: keys.value("receives", usual.receives)?,
        visible: keys.value("visible", usual.visible)?,
        catcher,
        casts: keys.value("casts", usual.casts)?,
        // Tables of splats set the meaning of opacity and the kind of shadow.
        gaussian: usual.gaussian,
        neutral: usual.neutral,
        // Only glTF files set it.
        unlit: usual.unlit,
    };
    Ok(MaterialTable {
        material,
        far_side,
        texture,
        radius: keys.number("radius", ABOVE_ZERO..=1e7, "above 0")?,
    })
}

/// Index of refraction of the rays in the picture, and the reflection.
fn glass(keys: &Keys<'_>, filters: bool) -> Result<(f32, Fresnel), SceneError> {
    let given = keys.number("ior", 1.0..=3.0, "1 to 3")?;
    let thin = keys.value("thin", false)?;
    match given {
        None if thin => Err(keys.fault("thin", "thin glass without an ior", "give it an ior")),
        None => Ok((1.0, Fresnel::None)),
        Some(ior) if !filters => Ok((ior, Fresnel::None)),
        Some(ior) if thin => Ok((1.0, Fresnel::Pane { ior })),
        Some(ior) => Ok((ior, Fresnel::Face { ior })),
    }
}

/// Share of diffusely transmitted light, and its colour.
fn far_side(
    keys: &Keys<'_>,
    transfer: Transfer,
    catcher: bool,
) -> Result<Option<(f32, Vec3)>, SceneError> {
    let share = keys.share("diffuse_transmission", 0.0)?;
    let color = keys.three("diffuse_transmission_color", 0.0..=1.0, "from 0 to 1")?;
    if share == 0.0 {
        return match color {
            Some(_) => {
                let message = "colour without a share that passes";
                let help = "give it a diffuse_transmission above 0";
                Err(keys.fault("diffuse_transmission_color", message, help))
            }
            None => Ok(None),
        };
    }
    if !matches!(transfer, Transfer::Opaque | Transfer::Cutout) || catcher {
        let message = "light passes diffusely through what is opaque or cutout, and no catcher";
        let help = "give it transfer = \"opaque\"";
        return Err(keys.fault("diffuse_transmission", message, help));
    }
    Ok(Some((share, color.unwrap_or(Vec3::ONE))))
}

fn check_noise(keys: &Keys<'_>, noise: &Noise) -> Result<(), SceneError> {
    let Noise { size, cells, scroll: [x, y], evolve, .. } = *noise;
    let fault = |name, value: &dyn std::fmt::Display, help: &str| {
        Err(keys.fault("texture", format!("{name} is {value}"), help))
    };
    for (name, value, most) in [("size", size, Noise::MAX_SIZE), ("cells", cells, Noise::MAX_CELLS)]
    {
        if !(1..=most).contains(&value) {
            return fault(name, &value, &format!("{name} is 1 to {most}"));
        }
    }
    for (name, value) in [("scroll", x), ("scroll", y), ("evolve", evolve)] {
        if !value.is_finite() || value.abs() > 1e3 {
            return fault(name, &value, "speeds are finite, up to 1000");
        }
    }
    Ok(())
}

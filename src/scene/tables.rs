//! Validation of the scene file's tables, and conversion to the library's units.
use super::{
    Bounds, Camera, SceneError, defaults,
    document::{AirTable, CameraTable, ClustersTable, MaterialTable, ShadowTable, TextureSource},
    document_motion::Shades,
    look_up,
    noise::Noise,
    source::SceneText,
};
use crate::{
    model::{
        Air, ClusterSettings, MAX_AIR_STEPS, MAX_BLUR, MAX_MAP_SIZE, MAX_SAMPLES, MIN_MAP_SIZE,
        Material, ShadowSettings, Transfer, dither::MAX_SCALE,
    },
    records::MAX_TILE,
};
use glam::{UVec2, Vec3, Vec4};
use std::ops::RangeInclusive;
use toml::Spanned;

/// A table being validated.
pub(super) struct Table<'a, T> {
    pub source: &'a SceneText<'a>,
    pub table: &'a Spanned<T>,
}

impl<T> Table<'_, T> {
    /// An error at the value of `key`, or at the table without it.
    pub(super) fn fault(&self, key: &str, message: impl Into<String>, help: &str) -> SceneError {
        self.source.error_at(&self.table.span(), key, message, help)
    }

    /// A number in a range; the range is also given in words.
    pub(super) fn number(
        &self,
        key: &str,
        value: f32,
        valid: impl Fn(f32) -> bool,
        range: &str,
    ) -> Result<f32, SceneError> {
        if value.is_finite() && valid(value) {
            return Ok(value);
        }
        Err(self.fault(key, format!("{key} is {value}"), &format!("{key} must be {range}")))
    }

    pub(super) fn share(&self, key: &str, value: f32) -> Result<f32, SceneError> {
        self.number(key, value, |v| (0.0..=1.0).contains(&v), "from 0 to 1")
    }

    /// A bias [m] or [texels]: no scene is larger.
    pub(super) fn bias(&self, key: &str, value: f32) -> Result<f32, SceneError> {
        self.number(key, value, |v| (0.0..=1e7).contains(&v), "0 to 1e7")
    }

    pub(super) fn vector(&self, key: &str, value: [f32; 3]) -> Result<Vec3, SceneError> {
        for v in value {
            self.number(key, v, |v| v.abs() <= 1e7, "finite and within 1e7")?;
        }
        Ok(value.into())
    }

    pub(super) fn direction(&self, key: &str, value: [f32; 3]) -> Result<Vec3, SceneError> {
        let vector = self.vector(key, value)?;
        // Squares of short vectors would vanish.
        (vector / vector.abs().max_element())
            .try_normalize()
            .ok_or_else(|| self.fault(key, format!("{key} has no length"), "give it a direction"))
    }

    /// Converts [degrees] to [radians]; the limits keep its tangent finite in 32 bits.
    pub(super) fn angle(&self, key: &str, degrees: f32) -> Result<f32, SceneError> {
        let valid = |v| (0.01..=179.9).contains(&v);
        Ok(self.number(key, degrees, valid, "between 0 and 180 (0.01 to 179.9)")?.to_radians())
    }

    pub(super) fn map_size(&self, value: u32) -> Result<u32, SceneError> {
        if (MIN_MAP_SIZE..=MAX_MAP_SIZE).contains(&value) {
            return Ok(value);
        }
        let help = format!("a map is {MIN_MAP_SIZE} to {MAX_MAP_SIZE} texels wide");
        Err(self.fault("size", format!("size is {value}"), &help))
    }
}

pub(super) fn shadow(
    source: &SceneText<'_>,
    table: &Spanned<ShadowTable>,
) -> Result<ShadowSettings, SceneError> {
    let check = Table { source, table };
    let ShadowTable {
        size,
        receiver,
        nodes,
        filter,
        bias,
        slope_bias,
        normal_bias,
        pair_budget,
        texel_budget,
        soften,
        colored,
        blur,
    } = table.get_ref();
    let usual = ShadowSettings::default();
    let nodes = nodes.unwrap_or(usual.nodes);
    if ![4, 8, 16].contains(&nodes) {
        return Err(check.fault(
            "nodes",
            format!("nodes is {nodes}"),
            "a curve has 4, 8 or 16 nodes",
        ));
    }
    let pair_budget = pair_budget.unwrap_or(usual.pair_budget);
    if pair_budget == 0 {
        return Err(check.fault("pair_budget", "pair_budget is 0", "at least 1"));
    }
    let texel_budget = texel_budget.unwrap_or(usual.texel_budget);
    if texel_budget == 0 {
        return Err(check.fault("texel_budget", "texel_budget is 0", "at least 1"));
    }
    let blur = blur.unwrap_or(usual.blur);
    if blur > MAX_BLUR {
        let help = format!("a blur reaches 0 to {MAX_BLUR} texels");
        return Err(check.fault("blur", format!("blur is {blur}"), &help));
    }
    Ok(ShadowSettings {
        size: check.map_size(size.unwrap_or(usual.size))?,
        receiver: receiver.unwrap_or(usual.receiver),
        nodes,
        filter: look_up::filter(source, filter.as_ref())?.unwrap_or(usual.filter),
        bias: check.bias("bias", bias.unwrap_or(usual.bias))?,
        slope_bias: check.bias("slope_bias", slope_bias.unwrap_or(usual.slope_bias))?,
        normal_bias: check.bias("normal_bias", normal_bias.unwrap_or(usual.normal_bias))?,
        pair_budget,
        texel_budget,
        soften: soften.unwrap_or(usual.soften),
        colored: colored.unwrap_or(usual.colored),
        blur,
        mips: usual.mips,
    })
}

/// Air of a table; `None` if it neither scatters nor absorbs.
pub(super) fn air(
    source: &SceneText<'_>,
    table: &Spanned<AirTable>,
) -> Result<Option<Air>, SceneError> {
    let check = Table { source, table };
    let AirTable { density, albedo, scattering, extinction, ambient, anisotropy, steps } =
        table.get_ref();
    for (old, is_given, new, replaced) in [
        ("density", density.is_some(), "extinction", extinction.is_some()),
        ("density", density.is_some(), "scattering", scattering.is_some()),
        ("albedo", albedo.is_some(), "scattering", scattering.is_some()),
    ] {
        if is_given && replaced {
            let message = format!("{old} beside {new}");
            let help = "density and albedo say what scattering and extinction say: use either two";
            return Err(check.fault(old, message, help));
        }
    }
    let usual = Air::default();
    let albedo = albedo.unwrap_or([1.0; 3]);
    for v in albedo {
        check.share("albedo", v)?;
    }
    let per_metre = |key, Shades(rgb): Shades| -> Result<Vec3, SceneError> {
        for v in rgb {
            check.number(key, v, |v| (0.0..=1e3).contains(&v), "0 to 1000")?;
        }
        Ok(rgb.into())
    };
    let density = density.map(|v| per_metre("density", Shades([v; 3]))).transpose()?;
    let scattering = scattering.map(|v| per_metre("scattering", v)).transpose()?;
    let extinction = extinction.map(|v| per_metre("extinction", v)).transpose()?;
    let extinction = extinction.or(density).or(scattering).unwrap_or(usual.extinction);
    let scattering = scattering.unwrap_or(extinction * Vec3::from(albedo));
    let ambient = check.share("ambient", ambient.unwrap_or(usual.ambient))?;
    let g = anisotropy.unwrap_or(usual.anisotropy);
    let within = |v: f32| v.abs() <= 0.95;
    let anisotropy = check.number("anisotropy", g, within, "from -0.95 to 0.95")?;
    let steps = steps.unwrap_or(usual.steps);
    if !(1..=MAX_AIR_STEPS).contains(&steps) {
        let help = format!("1 to {MAX_AIR_STEPS} steps");
        return Err(check.fault("steps", format!("steps is {steps}"), &help));
    }
    let air = Air { scattering, extinction, ambient, anisotropy, steps };
    Ok((scattering + extinction != Vec3::ZERO).then_some(air))
}

pub(super) fn clusters(
    source: &SceneText<'_>,
    table: &Spanned<ClustersTable>,
) -> Result<ClusterSettings, SceneError> {
    let check = Table { source, table };
    let ClustersTable { tile, slices, near, budget } = *table.get_ref();
    let usual = ClusterSettings::default();
    let within = |key: &str, value: Option<u32>, usual: u32, range: RangeInclusive<u32>| {
        let value = value.unwrap_or(usual);
        if range.contains(&value) {
            return Ok(value);
        }
        let help = format!("{key} is {} to {}", range.start(), range.end());
        Err(check.fault(key, format!("{key} is {value}"), &help))
    };
    let tile = within("tile", tile, usual.tile, 16..=MAX_TILE)?;
    if tile % 16 != 0 {
        return Err(check.fault("tile", format!("tile is {tile}"), "tile is a multiple of 16"));
    }
    let near = near.map(|v| check.number("near", v, |v| v > 0.0 && v <= 1e7, "a distance above 0"));
    Ok(ClusterSettings {
        tile,
        slices: within("slices", slices, usual.slices, 1..=ClusterSettings::MAX_SLICES)?,
        near: near.transpose()?,
        budget: within("budget", budget, usual.budget, 0..=ClusterSettings::MAX_BUDGET)?,
    })
}

/// Camera of a table; `base` gives missing values; without it the eye is where `bounds` fill the picture.
pub(super) fn camera(
    source: &SceneText<'_>,
    table: &Spanned<CameraTable>,
    base: Option<Camera>,
    bounds: &Bounds,
) -> Result<Camera, SceneError> {
    let check = Table { source, table };
    let CameraTable { eye, target, up, fov_y, size, .. } = table.get_ref();
    let mut camera = base.unwrap_or_else(|| defaults::camera(bounds));
    if let Some(degrees) = *fov_y {
        camera.fov_y = check.angle("fov_y", degrees)?;
    }
    if let Some([width, height]) = *size {
        if !(1..=MAX_MAP_SIZE).contains(&width) || !(1..=MAX_MAP_SIZE).contains(&height) {
            let help = format!("a picture is 1 to {MAX_MAP_SIZE} pixels wide and high");
            return Err(check.fault("size", format!("size is [{width}, {height}]"), &help));
        }
        camera.size = UVec2::new(width, height);
    }
    if let Some(target) = *target {
        camera.target = check.vector("target", target)?;
    }
    if let Some(eye) = *eye {
        camera.eye = check.vector("eye", eye)?;
    } else if base.is_none() {
        camera.eye = defaults::eye(&camera, bounds);
    }
    if let Some(up) = *up {
        camera.up = check.direction("up", up)?;
    }
    let Some(forward) = (camera.target - camera.eye).try_normalize() else {
        return Err(check.fault("eye", "eye and target are the same", "move one of them"));
    };
    if forward.cross(camera.up).length() < 1e-4 {
        if up.is_some() {
            return Err(check.fault("up", "up is along the view", "turn one of them"));
        }
        camera.up = Vec3::Z;
    }
    Ok(camera)
}

/// Samples per pixel of the picture.
pub(super) fn samples(
    source: &SceneText<'_>,
    table: &Spanned<CameraTable>,
) -> Result<u32, SceneError> {
    let samples = table.get_ref().samples.unwrap_or(1);
    if (1..=MAX_SAMPLES).contains(&samples) {
        return Ok(samples);
    }
    let help = format!("a pixel has 1 to {MAX_SAMPLES} samples");
    Err(Table { source, table }.fault("samples", format!("samples is {samples}"), &help))
}

pub(super) fn exposure(
    source: &SceneText<'_>,
    table: &Spanned<CameraTable>,
) -> Result<f32, SceneError> {
    let stops = table.get_ref().exposure.unwrap_or(0.0);
    let within = |v: f32| v.abs() <= 32.0;
    Table { source, table }.number("exposure", stops, within, "from -32 to 32 stops")
}

/// Material of a table, and the source of its texture.
pub(super) fn material(
    source: &SceneText<'_>,
    table: &Spanned<MaterialTable>,
) -> Result<(Material, Option<TextureSource>), SceneError> {
    let check = Table { source, table };
    let given = table.get_ref();
    let usual = Material::default();
    let transfer = given.transfer.unwrap_or_default();
    let [r, g, b, a] = given.tint.unwrap_or([1.0; 4]);
    let most = transfer.max_color();
    for v in [r, g, b] {
        let range = format!("from 0 to {most}");
        check.number("tint", v, |v| (0.0..=most).contains(&v), &range)?;
    }
    if let Some(radius) = given.radius {
        check.number("radius", radius, |v| v > 0.0 && v <= 1e7, "above 0")?;
    }
    let emission = given.emission.unwrap_or([0.0; 3]);
    for v in emission {
        check.number("emission", v, |v| v >= 0.0, "0 or more")?;
    }
    let pattern_scale = given.scale.unwrap_or(usual.pattern_scale);
    if !(1..=MAX_SCALE).contains(&pattern_scale) {
        let help = format!("a cell of a pattern is 1 to {MAX_SCALE} texels");
        return Err(check.fault("scale", format!("scale is {pattern_scale}"), &help));
    }
    let attenuation_color = given.attenuation_color.unwrap_or([1.0; 3]);
    for v in attenuation_color {
        check.share("attenuation_color", v)?;
    }
    let attenuation_distance = match given.attenuation_distance {
        None if given.attenuation_color.is_some() => {
            let help = "give it an attenuation_distance [m]";
            return Err(check.fault("attenuation_color", "colour without a distance", help));
        }
        None => f32::INFINITY,
        Some(v) => check.number("attenuation_distance", v, |v| v > 0.0, "above 0")?,
    };
    if attenuation_distance.is_finite() && (transfer.is_opaque() || transfer == Transfer::None) {
        let message = "a volume of a material that does not filter";
        let help = "use another transfer, such as \"filter\"";
        return Err(check.fault("attenuation_distance", message, help));
    }
    if let Some(TextureSource::Noise(noise)) = &given.texture {
        noise_values(&check, noise)?;
    }
    let share = |key, value: Option<f32>, usual| check.share(key, value.unwrap_or(usual));
    let material = Material {
        name: given.name.clone(),
        transfer,
        shape: given.shape.unwrap_or_default(),
        profile: given.profile.unwrap_or_default(),
        tint: Vec4::new(r, g, b, check.share("tint", a)?),
        texture: None,
        reflectivity: share("reflectivity", given.reflectivity, usual.reflectivity)?,
        cutoff: share("cutoff", given.cutoff, usual.cutoff)?,
        pattern: given.pattern.unwrap_or_default(),
        pattern_scale,
        emission: emission.into(),
        emissive_texture: None,
        transmission: share("transmission", given.transmission, usual.transmission)?,
        roughness: share("roughness", given.roughness, usual.roughness)?,
        metallic: share("metallic", given.metallic, usual.metallic)?,
        attenuation_color: attenuation_color.into(),
        attenuation_distance,
        receives: given.receives.unwrap_or_default(),
        visible: given.visible.unwrap_or(usual.visible),
        casts: given.casts.unwrap_or(usual.casts),
    };
    Ok((material, given.texture.clone()))
}

fn noise_values(check: &Table<'_, MaterialTable>, noise: &Noise) -> Result<(), SceneError> {
    let Noise { size, cells, scroll, evolve, .. } = *noise;
    for (name, value, most) in [("size", size, Noise::MAX_SIZE), ("cells", cells, Noise::MAX_CELLS)]
    {
        if !(1..=most).contains(&value) {
            let message = format!("{name} is {value}");
            return Err(check.fault("texture", message, &format!("{name} is 1 to {most}")));
        }
    }
    for (name, value) in [("scroll", scroll[0]), ("scroll", scroll[1]), ("evolve", evolve)] {
        if !value.is_finite() || value.abs() > 1e3 {
            let message = format!("{name} is {value}");
            return Err(check.fault("texture", message, "speeds are finite, up to 1000"));
        }
    }
    Ok(())
}

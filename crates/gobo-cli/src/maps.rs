//! The maps of a frame as files: arrays, previews and a description of the views.
use super::{
    curves::{Curves, Fault, Span, Take},
    failure::Failure,
    files, npy,
    output::Fill,
};
use gobo::{
    glam::{DMat4, Mat4, Vec3},
    model::{Light, LightKind, View},
    records::ViewMaps,
};
use image::{DynamicImage, GrayImage, ImageFormat, RgbImage};
use serde::Serialize;
use std::{
    io::{self, Cursor},
    path::Path,
};

/// One entry of `views.json`.
#[derive(Serialize)]
struct ViewEntry<'a> {
    light: &'a str,
    view: &'a str,
    kind: &'static str,
    /// Width and height [texels].
    size: [u32; 2],
    /// Nodes of its curve, if it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    nodes: Option<usize>,
    /// Near plane [m].
    near: f32,
    /// Far plane [m].
    far: f32,
    /// Position of a spot or point light, world space [m].
    #[serde(skip_serializing_if = "Option::is_none")]
    position: Option<[f64; 3]>,
    /// Direction in which a directional light travels, world space.
    #[serde(skip_serializing_if = "Option::is_none")]
    direction: Option<[f32; 3]>,
    /// Columns of the matrix.
    clip_from_world: [f64; 16],
    /// Columns of the matrix.
    view_from_world: [f64; 16],
}

/// File names of the lights: unique and valid. A name that had to change is reported.
pub(crate) fn light_names(lights: &[Light]) -> Vec<String> {
    let mut names = Vec::with_capacity(lights.len());
    let mut unique = files::Unique::default();
    for (index, light) in lights.iter().enumerate() {
        let safe = |c: char| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' };
        let mut name: String = light.name.chars().take(64).map(safe).collect();
        if name.is_empty() {
            name = format!("light{index}");
        }
        let name = unique.of(&name);
        if !light.name.is_empty() && name != light.name {
            let shown: String = light.name.chars().take(64).collect();
            tracing::warn!("the maps of light {shown:?} are named {name:?}");
        }
        names.push(name);
    }
    names
}

/// Writes all maps of a frame by name. `left`: gives the texels of curves that `maps` lack, by the number of
/// the view; `origin`: [`gobo::model::Scene::origin`].
pub(super) fn write(
    mut write: impl FnMut(&str, Fill<'_>) -> Result<(), Failure>,
    maps: &[ViewMaps],
    left: impl Fn(usize, Take<'_>) -> Result<(), Fault>,
    lights: &[Light],
    names: &[String],
    origin: Vec3,
) -> Result<(), Failure> {
    let (stems, json) = described(maps, lights, names, origin);
    for ((number, maps), stem) in of_lights(maps, lights).zip(stems) {
        let curve = maps.curve.as_ref();
        let give = |take: Take<'_>| match curve {
            Some(curve) if !curve.packed.is_empty() => take(curve),
            _ => left(number, take),
        };
        let curves = curve.map(|curve| Curves { nodes: curve.nodes, give: &give });
        Arrays::of(maps, curves).write(&mut write, &stem)?;
    }
    write("views.json", &mut |out| out.write_all(json.as_bytes()))
}

/// Starts of the views' file names, and `views.json`.
pub(super) fn described(
    maps: &[ViewMaps],
    lights: &[Light],
    names: &[String],
    origin: Vec3,
) -> (Vec<String>, String) {
    let mut stems = Vec::with_capacity(maps.len());
    let mut entries = Vec::with_capacity(maps.len());
    for (_, ViewMaps { view, curve, .. }) in of_lights(maps, lights) {
        let light = view.light.expect("it is a light's");
        let nodes = curve.as_ref().map(|curve| curve.nodes);
        entries.push(ViewEntry { nodes, ..describe(view, &lights[light], &names[light], origin) });
        stems.push(format!("{}.{}", names[light], view.name));
    }
    (stems, serde_json::to_string_pretty(&entries).expect("plain data is JSON"))
}

/// The maps of the lights' views.
pub(super) fn of_lights<'a>(
    maps: &'a [ViewMaps],
    lights: &[Light],
) -> impl Iterator<Item = (usize, &'a ViewMaps)> {
    let count = lights.len();
    let is_of_light = move |maps: &ViewMaps| maps.view.light.is_some_and(|light| light < count);
    maps.iter().enumerate().filter(move |(_, maps)| is_of_light(maps))
}

/// The maps of one view, texels row by row.
pub(super) struct Arrays<'a> {
    /// Width and height [texels].
    pub size: [u32; 2],
    pub filter: &'a [[f32; 3]],
    pub nearest: &'a [f32],
    pub opaque: &'a [f32],
    /// Opaque depths per channel; empty without coloured dithering.
    pub colored: &'a [[f32; 3]],
    pub curves: Option<Curves<'a>>,
    /// Refracted light of caustics; empty without.
    pub caustics: Vec<[f32; 4]>,
}

impl<'a> Arrays<'a> {
    fn of(maps: &'a ViewMaps, curves: Option<Curves<'a>>) -> Self {
        let ViewMaps { view, filter, nearest, opaque, colored, .. } = maps;
        let size = view.size.to_array();
        let caustics = maps.thrown_light();
        Self { size, filter, nearest, opaque, colored, curves, caustics }
    }

    /// Writes the arrays and their previews; `stem`: start of their names.
    pub(super) fn write(
        &self,
        write: &mut impl FnMut(&str, Fill<'_>) -> Result<(), Failure>,
        stem: &str,
    ) -> Result<(), Failure> {
        let &Self { size: [width, height], filter, nearest, opaque, colored, curves, .. } = self;
        let (rows, columns) = (height as usize, width as usize);
        let mut save = |map: &str, array: Fill<'_>, preview: DynamicImage| {
            let preview = std::thread::scope(|scope| {
                let preview = scope.spawn(|| png(&preview));
                write(&format!("{stem}.{map}.npy"), array)?;
                Ok::<_, Failure>(preview.join().expect("8-bit images are PNG"))
            })?;
            write(&format!("{stem}.{map}.png"), &mut |out| out.write_all(&preview))
        };
        let mut save_colors = |map: &str, colors: &[[f32; 3]]| {
            let preview = filter_preview(width, height, colors);
            let values = || colors.as_flattened().iter().copied();
            save(map, &mut |out| npy::write(out, &[rows, columns, 3], values()), preview)
        };
        save_colors("filter", filter)?;
        if !colored.is_empty() {
            save_colors("colored", colored)?;
        }
        if !self.caustics.is_empty() {
            let colors: Vec<_> = self.caustics.iter().map(|&[r, g, b, _]| [r, g, b]).collect();
            let preview = filter_preview(width, height, &colors);
            let values = || self.caustics.as_flattened().iter().copied();
            save("caustics", &mut |out| npy::write(out, &[rows, columns, 4], values()), preview)?;
        }
        for (map, depths) in [("nearest", nearest), ("opaque", opaque)] {
            let preview = depth_preview(width, height, depths);
            let values = || depths.iter().copied();
            save(map, &mut |out| npy::write(out, &[rows, columns], values()), preview)?;
        }
        curves.map_or(Ok(()), |curves| write_curves(write, stem, [rows, columns], curves))
    }
}

/// Writes curves and their preview, some texels at a time.
fn write_curves(
    write: &mut impl FnMut(&str, Fill<'_>) -> Result<(), Failure>,
    stem: &str,
    [rows, columns]: [usize; 2],
    curves: Curves<'_>,
) -> Result<(), Failure> {
    let name = format!("{stem}.curve.npy");
    let (mut span, mut lost) = (Span::NONE, None);
    let written = write(&name, &mut |out| match curves.write(out, [rows, columns]) {
        Ok(found) => {
            span = found;
            Ok(())
        }
        Err(Fault::Write(error)) => Err(error),
        Err(Fault::Device(error)) => {
            let message = error.to_string();
            lost = Some(error);
            Err(io::Error::other(message))
        }
    });
    lost.map_or(Ok(()), |error| Err(Failure::from(error)))?;
    written?;
    let shown = curves.preview(span, |light| light.map(srgb)).map_err(|fault| match fault {
        Fault::Write(error) => Failure::file(Path::new(&name), error),
        Fault::Device(error) => error.into(),
    })?;
    let image = RgbImage::from_raw(columns as u32, rows as u32, shown.into_flattened());
    let preview = png(&DynamicImage::from(image.expect("a map has all its texels")));
    write(&format!("{stem}.curve.png"), &mut |out| out.write_all(&preview))
}

fn describe<'a>(view: &'a View, light: &Light, name: &'a str, origin: Vec3) -> ViewEntry<'a> {
    let shadow = light.all_shadows().nth(view.shadow_index(light));
    let (kind, position, direction) = match shadow.map_or(light.kind, |shadow| shadow.kind) {
        LightKind::Directional { direction } => ("directional", None, Some(direction)),
        LightKind::Spot { position, .. } => ("spot", Some(position), None),
        LightKind::Point { position } => ("point", Some(position), None),
    };
    // Far from the origin, 32 bits are not precise enough.
    let is_near = origin == Vec3::ZERO;
    let origin = origin.as_dvec3();
    let from_world = DMat4::from_translation(-origin);
    let columns = |matrix: Mat4| {
        if is_near {
            return matrix.to_cols_array().map(short);
        }
        (matrix.as_dmat4() * from_world).to_cols_array()
    };
    let place = |p: Vec3| {
        if is_near { p.to_array().map(short) } else { (p.as_dvec3() + origin).to_array() }
    };
    ViewEntry {
        light: name,
        view: view.name,
        kind,
        size: view.size.to_array(),
        nodes: None,
        near: view.near,
        far: view.far,
        position: position.map(place),
        direction: direction.map(|d| d.to_array()),
        clip_from_world: columns(view.clip_from_world()),
        view_from_world: columns(view.view_from_world),
    }
}

/// The number with the shortest decimal that represents `v`.
fn short(v: f32) -> f64 {
    v.to_string().parse().unwrap_or(f64::from(v))
}

/// Preview in sRGB; light amplified above 1 by `gain` casters is white.
fn filter_preview(width: u32, height: u32, filter: &[[f32; 3]]) -> DynamicImage {
    let bytes = filter.as_flattened().iter().map(|&linear| srgb(linear)).collect();
    DynamicImage::from(RgbImage::from_raw(width, height, bytes).expect("a map has all its texels"))
}

/// Preview: black at the least depth of the file, 80% grey at the greatest below 1, white without a surface
/// (depth 1).
fn depth_preview(width: u32, height: u32, depths: &[f32]) -> DynamicImage {
    let something = |&&depth: &&f32| depth < 1.0;
    let (min, max) = depths
        .iter()
        .filter(something)
        .fold((f32::INFINITY, f32::NEG_INFINITY), |(min, max), &d| (min.min(d), max.max(d)));
    let range = (max - min).max(f32::MIN_POSITIVE);
    let grey = |&depth: &f32| {
        if depth < 1.0 { ((depth - min) / range * 204.0).round() as u8 } else { 255 }
    };
    let bytes = depths.iter().map(grey).collect();
    DynamicImage::from(GrayImage::from_raw(width, height, bytes).expect("a map has all its texels"))
}

fn srgb(linear: f32) -> u8 {
    // True of most texels.
    if linear >= 1.0 {
        return 255;
    }
    let linear = linear.max(0.0);
    let encoded =
        if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
    (encoded * 255.0).round() as u8
}

/// Encodes a PNG file.
pub(crate) fn png(image: &DynamicImage) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image
        .write_to(&mut bytes, ImageFormat::Png)
        .expect("8-bit images are PNG, and memory is there");
    bytes.into_inner()
}

#[cfg(test)]
mod tests {
    use super::*;
    use gobo::{
        model::{Bounds, Shadow},
        view::light_views,
    };

    fn named(name: &str) -> Light {
        Light {
            name: name.to_owned(),
            kind: LightKind::Point { position: Vec3::ZERO },
            ..Light::default()
        }
    }

    #[test]
    fn file_names_are_harmless_and_unique() {
        let lights = ["sun", "../etc/a.b", "", "Sun", "sun", "灯"].map(named);
        let expected = ["sun", "___etc_a_b", "light2", "Sun_2", "sun_3", "_"];
        assert_eq!(light_names(&lights), expected);
    }

    #[test]
    fn a_further_shadow_is_described_by_its_own_kind() {
        let mut lamp = named("lamp");
        let spot = LightKind::Spot { position: Vec3::Y, direction: Vec3::NEG_Y, angle: 1.0 };
        lamp.shadows =
            vec![Shadow { kind: spot, near: None, far: None, size: None, cascades: None }];
        let bounds = Bounds::EMPTY.with_sphere(Vec3::ZERO, 2.0);
        let views = light_views(0, &lamp, 16, None, &bounds).unwrap();
        let described = views.iter().map(|view| describe(view, &lamp, "lamp", Vec3::ZERO));
        let places: Vec<_> =
            described.map(|entry| (entry.kind, entry.view, entry.position)).collect();
        assert_eq!(places[5], ("point", "nz", Some([0.0; 3])));
        assert_eq!(places[6], ("spot", "s1_0", Some([0.0, 1.0, 0.0])));
    }

    #[test]
    fn previews_span_their_range() {
        let grey = depth_preview(4, 1, &[0.25, 0.5, 0.75, 1.0]).into_luma8().into_raw();
        assert_eq!(grey, [0, 102, 204, 255]);
        assert_eq!(depth_preview(1, 1, &[0.5]).into_luma8().into_raw(), [0]);
        assert_eq!(depth_preview(1, 1, &[1.0]).into_luma8().into_raw(), [255]);
        let rgb = filter_preview(1, 1, &[[0.0, 0.5, 16.0]]).into_rgb8().into_raw();
        assert_eq!(rgb, [0, 188, 255]);
    }
}

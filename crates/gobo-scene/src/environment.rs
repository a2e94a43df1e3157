//! The `[environment]` table: two colours, a sky, or an image.
use super::{
    SceneError, defaults, document::EnvironmentTable, images, keys::Keys, limits, loader::Loader,
    read,
};
use glam::{UVec2, Vec3};
use gobo::model::{Environment, Sky, SunDisc};
use image::{
    ImageDecoder,
    codecs::{hdr::HdrDecoder, openexr::OpenExrDecoder},
};
use std::{io::Cursor, panic::catch_unwind, sync::Arc};
use toml::Spanned;

/// Longest side of an image \[texels\].
const MAX_SIDE: u32 = 8192;

impl Loader<'_> {
    /// `takes_sun`: whether the sun of an image becomes a light.
    pub(super) fn environment(
        &mut self,
        table: &Spanned<EnvironmentTable>,
        takes_sun: bool,
    ) -> Result<(), SceneError> {
        let given = table.get_ref();
        if let Some(file) = &given.file {
            let path = self.folder.join(file);
            let bytes = read::bytes(&path).map_err(|e| self.named_by(&table.span(), "file", e))?;
            let (size, texels) = decode(&bytes)
                .map_err(|(message, help)| SceneError::invalid(&path, message, &help))
                .map_err(|e| self.named_by(&table.span(), "file", e))?;
            let (turn, intensity) = (given.rotation, given.intensity);
            let environment = if takes_sun {
                let (environment, sun) =
                    Environment::of_image_without_sun(size, &texels, turn, intensity);
                self.scene.lights.extend(sun.map(|sun| defaults::sun_of_image(&sun)));
                environment
            } else {
                Environment::of_image(size, &texels, turn, intensity)
            };
            self.scene.environment = Some(Arc::new(environment));
        } else if let Some(sky) = &given.sky {
            self.scene.environment = Some(Arc::new(Environment::of_sky(sky, given.intensity)));
        }
        self.scene.ambient = given.ambient.unwrap_or(self.scene.ambient);
        self.scene.background = given.background.unwrap_or(self.scene.background);
        Ok(())
    }
}

pub(super) fn table(keys: &Keys<'_>) -> Result<EnvironmentTable, SceneError> {
    let file = keys.given("file")?;
    let first = |known: &[&'static str]| known.iter().copied().find(|key| keys.has(key));
    let of_sky = first(&["zenith", "horizon", "ground", "sun"]);
    let is_sky = of_sky.is_some() || keys.has("intensity");
    if let Some(key) = of_sky.filter(|_| file.is_some()) {
        let help = "an image holds the whole sky: use either";
        return Err(keys.fault(key, format!("{key} beside file"), help));
    }
    if let Some(key) = first(&["ambient", "background"]).filter(|_| file.is_some() || is_sky) {
        let help = "a sky or an image lights by itself: remove ambient and background";
        return Err(keys.fault(key, format!("{key} beside a sky or an image"), help));
    }
    if keys.has("rotation") && file.is_none() {
        let help = "it turns the image of `file`; a sky has no sides";
        return Err(keys.fault("rotation", "rotation without a file", help));
    }
    let usual = Sky::default();
    let sky = Sky {
        zenith: light(keys, "zenith")?.unwrap_or(usual.zenith),
        horizon: light(keys, "horizon")?.unwrap_or(usual.horizon),
        ground: light(keys, "ground")?.unwrap_or(usual.ground),
        sun: keys.one("sun", sun)?.map(Spanned::into_inner),
    };
    let intensity = keys.number("intensity", 0.0..=f32::MAX, "0 or more")?;
    let rotation = keys.number("rotation", f32::MIN..=f32::MAX, "finite")?;
    Ok(EnvironmentTable {
        ambient: light(keys, "ambient")?,
        background: light(keys, "background")?,
        sky: is_sky.then_some(sky),
        file,
        rotation: rotation.unwrap_or(0.0).to_radians(),
        intensity: intensity.unwrap_or(1.0),
    })
}

fn sun(keys: &Keys<'_>) -> Result<SunDisc, SceneError> {
    const COLOR: Vec3 = Vec3::new(20.0, 18.5, 16.0);
    let angle = keys.number("angle", 0.1..=60.0, "0.1 to 60 degrees")?.unwrap_or(1.5);
    Ok(SunDisc {
        direction: keys.need("direction", keys.direction("direction")?)?,
        color: light(keys, "color")?.unwrap_or(COLOR),
        angle: angle.to_radians(),
    })
}

fn light(keys: &Keys<'_>, key: &'static str) -> Result<Option<Vec3>, SceneError> {
    let rgb = keys.array::<f32, 3>(key)?;
    if rgb.iter().flatten().all(|v| v.is_finite() && *v >= 0.0) {
        return Ok(rgb.map(Vec3::from));
    }
    let message = format!("{key} is {:?}", rgb.unwrap_or_default());
    Err(keys.fault(key, message, "light is finite and not negative"))
}

/// Largest radiance of a texel, far above the sun's.
const BRIGHTEST: f32 = 1e9;

type Image = (UVec2, Vec<[f32; 3]>);

/// Start of an `OpenEXR` file.
const EXR: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// Decodes a Radiance image or `OpenEXR`.
fn decode(bytes: &[u8]) -> Result<Image, (String, String)> {
    let help = || format!("use a Radiance .hdr or an OpenEXR of at most {MAX_SIDE} texels a side");
    if bytes.starts_with(&EXR) {
        // Its decoder may panic on damaged files.
        let read = catch_unwind(|| {
            let decoder = OpenExrDecoder::new(Cursor::new(bytes)).map_err(|e| e.to_string())?;
            texels(decoder)
        });
        let read = read.unwrap_or_else(|_| Err("the image is damaged".to_owned()));
        return read.map_err(|message| (message, help()));
    }
    let bad = |error: &dyn std::fmt::Display| (error.to_string(), help());
    images::check_header(bytes, bytes.len() as u64).map_err(|message| (message, help()))?;
    let decoder = HdrDecoder::new(Cursor::new(bytes)).map_err(|error| bad(&error))?;
    texels(decoder).map_err(|message| (message, help()))
}

fn texels(decoder: impl ImageDecoder) -> Result<Image, String> {
    let (width, height) = decoder.dimensions();
    if width == 0 || height == 0 || width > MAX_SIDE || height > MAX_SIDE {
        return Err(format!("the image has {width} x {height} texels"));
    }
    // The decoded image and the copy that is kept.
    if !limits::has_memory(28 * u64::from(width) * u64::from(height)) {
        return Err(format!("no memory for {width} x {height} texels"));
    }
    let image = image::DynamicImage::from_decoder(decoder).map_err(|error| error.to_string())?;
    // Negative radiance, which renderers write, and NaN become 0.
    let light = |c: f32| if c > 0.0 { c.min(BRIGHTEST) } else { 0.0 };
    let texels = image.into_rgb32f().pixels().map(|pixel| pixel.0.map(light)).collect();
    Ok((UVec2::new(width, height), texels))
}

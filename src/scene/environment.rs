//! The `[environment]` table: two colours, a sky, or an image.
use super::{
    SceneError,
    document::{EnvironmentTable, SunTable},
    limits,
    loader::Loader,
    read,
    tables::Table,
};
use crate::model::{Environment, Sky, SunDisc};
use glam::{UVec2, Vec3};
use image::{ImageDecoder as _, codecs::hdr::HdrDecoder};
use std::{io::Cursor, sync::Arc};
use toml::Spanned;

/// Longest side of an image [texels].
const MAX_SIDE: u32 = 8192;

impl Loader<'_> {
    pub(super) fn environment(
        &mut self,
        table: &Spanned<EnvironmentTable>,
    ) -> Result<(), SceneError> {
        let check = Table { source: self.source, table };
        let given = table.get_ref();
        let colors = [
            ("ambient", given.ambient),
            ("background", given.background),
            ("zenith", given.zenith),
            ("horizon", given.horizon),
            ("ground", given.ground),
        ];
        for (key, rgb) in colors {
            light(&check, key, rgb.unwrap_or_default())?;
        }
        check_kinds(&check)?;
        let intensity = given.intensity.unwrap_or(1.0);
        let intensity = check.number("intensity", intensity, |v| v >= 0.0, "0 or more")?;
        let rotation =
            check.number("rotation", given.rotation.unwrap_or(0.0), |_| true, "finite")?;
        let color = |given: Option<[f32; 3]>, usual| given.map_or(usual, Vec3::from);
        if let Some(file) = &given.file {
            let path = self.folder.join(file);
            let bytes = read::bytes(&path).map_err(|e| self.named_by(&table.span(), "file", e))?;
            let (size, texels) = decode(&bytes)
                .map_err(|(message, help)| SceneError::invalid(&path, message, &help))
                .map_err(|e| self.named_by(&table.span(), "file", e))?;
            let turn = rotation.to_radians();
            let environment = Environment::of_image(size, &texels, turn, intensity);
            self.scene.environment = Some(Arc::new(environment));
        } else if given.is_sky() {
            let usual = Sky::default();
            let sky = Sky {
                zenith: color(given.zenith, usual.zenith),
                horizon: color(given.horizon, usual.horizon),
                ground: color(given.ground, usual.ground),
                sun: given.sun.as_ref().map(|table| self.sun(table)).transpose()?,
            };
            self.scene.environment = Some(Arc::new(Environment::of_sky(&sky, intensity)));
        }
        self.scene.ambient = color(given.ambient, self.scene.ambient);
        self.scene.background = color(given.background, self.scene.background);
        Ok(())
    }

    fn sun(&self, table: &Spanned<SunTable>) -> Result<SunDisc, SceneError> {
        const COLOR: [f32; 3] = [20.0, 18.5, 16.0];
        let check = Table { source: self.source, table };
        let SunTable { direction, color, angle } = *table.get_ref();
        let angle = angle.unwrap_or(1.5);
        let valid = |v| (0.1..=60.0).contains(&v);
        Ok(SunDisc {
            direction: check.direction("direction", direction)?,
            color: light(&check, "color", color.unwrap_or(COLOR))?,
            angle: check.number("angle", angle, valid, "0.1 to 60 degrees")?.to_radians(),
        })
    }
}

impl EnvironmentTable {
    fn is_sky(&self) -> bool {
        let colors = [self.zenith, self.horizon, self.ground];
        colors.iter().any(Option::is_some) || self.sun.is_some() || self.intensity.is_some()
    }
}

/// Checks that all keys belong to one kind of environment.
fn check_kinds(check: &Table<'_, EnvironmentTable>) -> Result<(), SceneError> {
    let given = check.table.get_ref();
    let two = [("ambient", given.ambient.is_some()), ("background", given.background.is_some())];
    let sky = [
        ("zenith", given.zenith.is_some()),
        ("horizon", given.horizon.is_some()),
        ("ground", given.ground.is_some()),
        ("sun", given.sun.is_some()),
    ];
    let first =
        |keys: &[(&'static str, bool)]| keys.iter().find(|(_, is)| *is).map(|(key, _)| *key);
    let has_file = given.file.is_some();
    if let Some(key) = first(&sky).filter(|_| has_file) {
        let help = "an image holds the whole sky: use either";
        return Err(check.fault(key, format!("{key} beside file"), help));
    }
    if let Some(key) = first(&two).filter(|_| has_file || given.is_sky()) {
        let help = "a sky or an image lights by itself: remove ambient and background";
        return Err(check.fault(key, format!("{key} beside a sky or an image"), help));
    }
    if given.rotation.is_some() && !has_file {
        let help = "it turns the image of `file`; a sky has no sides";
        return Err(check.fault("rotation", "rotation without a file", help));
    }
    Ok(())
}

fn light<T>(check: &Table<'_, T>, key: &str, rgb: [f32; 3]) -> Result<Vec3, SceneError> {
    if rgb.iter().all(|v| v.is_finite() && *v >= 0.0) {
        return Ok(rgb.into());
    }
    Err(check.fault(key, format!("{key} is {rgb:?}"), "light is finite and not negative"))
}

type Image = (UVec2, Vec<[f32; 3]>);

/// Decodes a Radiance image.
fn decode(bytes: &[u8]) -> Result<Image, (String, String)> {
    let help = || format!("use a Radiance .hdr of at most {MAX_SIDE} texels a side");
    let bad = |error: &dyn std::fmt::Display| (error.to_string(), help());
    let decoder = HdrDecoder::new(Cursor::new(bytes)).map_err(|error| bad(&error))?;
    let (width, height) = decoder.dimensions();
    if width == 0 || height == 0 || width > MAX_SIDE || height > MAX_SIDE {
        return Err((format!("the image has {width} x {height} texels"), help()));
    }
    // As it is decoded, and as it is kept.
    if !limits::has_memory(24 * u64::from(width) * u64::from(height)) {
        return Err((format!("no memory for {width} x {height} texels"), help()));
    }
    let image = image::DynamicImage::from_decoder(decoder).map_err(|error| bad(&error))?;
    let texels = image.into_rgb32f().pixels().map(|pixel| pixel.0).collect();
    Ok((UVec2::new(width, height), texels))
}

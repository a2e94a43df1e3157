//! Thin films of glTF materials (`KHR_materials_iridescence`): their reflectance at normal incidence.
use serde_json::Value;
use std::f32::consts::PI;

/// Thin film on a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Film {
    /// Covered share of the surface.
    factor: f32,
    /// Index of refraction.
    ior: f32,
    /// Thickness \[nm\].
    thickness: f32,
}

/// Wavelengths of red, green and blue \[nm\].
const WAVELENGTHS: [f32; 3] = [650.0, 550.0, 450.0];

/// Reflectance of a polished surface at normal incidence without a film (Schlick 1994, index 1.5).
const BARE: f32 = 0.04;

/// Films by material; `None` without one.
pub(crate) fn films(root: &Value) -> Vec<Option<Film>> {
    let of_material = |material: &Value| {
        let film = material.get("extensions")?.get("KHR_materials_iridescence")?;
        let number = |key: &str, usual: f32, range: std::ops::RangeInclusive<f32>| {
            let value = film.get(key).and_then(Value::as_f64).map_or(usual, |value| value as f32);
            value.clamp(*range.start(), *range.end())
        };
        let factor = number("iridescenceFactor", 0.0, 0.0..=1.0);
        let [least, most] = [("Minimum", 100.0), ("Maximum", 400.0)]
            .map(|(end, usual)| number(&format!("iridescenceThickness{end}"), usual, 0.0..=1e5));
        // The maximum without a texture; the mean with one.
        let is_textured = film.get("iridescenceThicknessTexture").is_some();
        let thickness = if is_textured { (least + most) / 2.0 } else { most };
        let ior = number("iridescenceIor", 1.3, 1.0..=5.0);
        (factor > 0.0).then_some(Film { factor, ior, thickness })
    };
    let materials = root.get("materials").and_then(Value::as_array).into_iter().flatten();
    materials.map(of_material).collect()
}

impl Film {
    /// Reflectivity of a material of index `base` in air: the film's reflectance minus that of a polished
    /// surface.
    pub(crate) fn reflectivity(&self, base: f32) -> f32 {
        let all = WAVELENGTHS.map(|wavelength| self.mirrored(base, wavelength));
        let mean = all.iter().sum::<f32>() / all.len() as f32;
        self.factor * ((mean - BARE) / (1.0 - BARE)).clamp(0.0, 1.0)
    }

    /// Reflectance at a wavelength \[nm\] and normal incidence: the sum over all paths between the film's two
    /// faces (Airy 1833).
    pub(crate) fn mirrored(&self, base: f32, wavelength: f32) -> f32 {
        let amplitude = |from: f32, to: f32| (from - to) / (from + to);
        let (top, bottom) = (amplitude(1.0, self.ior), amplitude(self.ior, base));
        let phase = 4.0 * PI * self.ior * self.thickness / wavelength;
        let (both, cross) = (top * bottom, 2.0 * top * bottom * phase.cos());
        (top * top + bottom * bottom + cross) / (1.0 + both * both + cross)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sum of the amplitudes of paths with 0, 1, 2 ... round trips in the film, one by one.
    fn summed(film: &Film, base: f32, wavelength: f32) -> f32 {
        let reflected = |from: f32, to: f32| f64::from((from - to) / (from + to));
        let passed = |from: f32, to: f32| f64::from(2.0 * from / (from + to));
        let phase = 4.0 * std::f64::consts::PI * f64::from(film.ior * film.thickness / wavelength);
        let (mut re, mut im) = (reflected(1.0, film.ior), 0.0);
        let mut size = passed(1.0, film.ior) * reflected(film.ior, base) * passed(film.ior, 1.0);
        for turn in 1..200 {
            let angle = phase * f64::from(turn);
            re += size * angle.cos();
            im += size * angle.sin();
            size *= reflected(film.ior, base) * reflected(film.ior, 1.0);
        }
        (re * re + im * im) as f32
    }

    #[test]
    fn films_mirror_the_sum_of_all_ways() {
        for (ior, thickness) in [(2.0, 300.01), (1.3, 100.0), (1.7, 0.0), (2.5, 812.0)] {
            let film = Film { factor: 1.0, ior, thickness };
            for base in [1.0, 1.5, 2.2] {
                for wavelength in WAVELENGTHS {
                    let [found, exact] =
                        [film.mirrored(base, wavelength), summed(&film, base, wavelength)];
                    assert!((found - exact).abs() < 1e-4, "{film:?} {base}: {found} {exact}");
                }
            }
        }
        // A film without thickness has no effect.
        let none = Film { factor: 1.0, ior: 1.7, thickness: 0.0 };
        assert!(none.reflectivity(1.5) < 1e-4);
    }

    #[test]
    fn films_are_read_from_their_materials() {
        let root = serde_json::json!({"materials": [{}, {"extensions": {"KHR_materials_iridescence":
            {"iridescenceFactor": 0.5, "iridescenceIor": 2, "iridescenceThicknessMaximum": 300}}},
            {"extensions": {"KHR_materials_iridescence": {}}}]});
        let film = Film { factor: 0.5, ior: 2.0, thickness: 300.0 };
        assert_eq!(films(&root), [None, Some(film), None]);
        let whole = Film { factor: 1.0, ..film };
        assert_eq!(2.0 * film.reflectivity(1.0), whole.reflectivity(1.0));
        assert!((0.1..0.2).contains(&whole.reflectivity(1.0)), "{}", whole.reflectivity(1.0));
    }
}

//! Validation of a host's casters before they are used.
use crate::{
    error::{Error, Input},
    model::{Casters, Particle, Shape, Triangle},
    records::MAX_MATERIALS,
};

impl Casters<'_> {
    /// Checks that all indices are in range and all positions finite.
    pub(crate) fn check(&self) -> Result<(), Error> {
        let Self { particles, gaussians, triangles, materials, textures, .. } = self;
        if materials.len() > MAX_MATERIALS {
            return Err(Error::Limit {
                limit: "materials of a scene",
                have: MAX_MATERIALS as u64,
                need: materials.len() as u64,
                remedy: "merge materials that are alike",
            });
        }
        let known = |material: u32| (material as usize) < materials.len();
        let no_material = "its material is not among the materials";
        find(Input::Particle, particles, |particle| match particle {
            Particle { material, .. } if !known(*material) => Some(no_material),
            Particle { center, .. } if !center.is_finite() => Some("its centre must be finite"),
            Particle { radius, .. } if !(*radius > 0.0 && radius.is_finite()) => {
                Some("its radius must be above 0 and finite")
            }
            Particle { material, .. } if materials[*material as usize].shape == Shape::Gaussian => {
                Some("its material's shape is that of Gaussians")
            }
            _ => None,
        })?;
        find(Input::Gaussian, gaussians, |gaussian| {
            let Some(material) = materials.get(gaussian.material as usize) else {
                return Some(no_material);
            };
            if material.shape != Shape::Gaussian {
                return Some("its material's shape must be `Gaussian`");
            }
            gaussian.problem(material.transfer.max_color(), material.gaussian)
        })?;
        find(Input::Triangle, triangles, |triangle| match triangle {
            Triangle { material, .. } if !known(*material) => Some(no_material),
            Triangle { positions, .. } if !positions.iter().all(|p| p.is_finite()) => {
                Some("its corners must be finite")
            }
            _ => None,
        })?;
        find(Input::Material, materials, |material| {
            let named = [material.texture, material.emissive_texture];
            let unknown = named.iter().flatten().any(|&index| index as usize >= textures.len());
            unknown.then_some("its texture is not among the textures")
        })?;
        find(Input::Texture, textures, |texture| {
            let size = u64::from(texture.width) * u64::from(texture.height) * 4;
            (size == 0 || texture.rgba.len() as u64 != size)
                .then_some("it must have width times height times 4 bytes, and some")
        })
    }
}

/// Error of the first of `items` that has a problem.
fn find<T>(
    what: Input,
    items: &[T],
    problem: impl Fn(&T) -> Option<&'static str>,
) -> Result<(), Error> {
    let found = items.iter().enumerate().find_map(|(index, item)| Some((index, problem(item)?)));
    found.map_or(Ok(()), |(index, problem)| Err(what.invalid(index, problem)))
}

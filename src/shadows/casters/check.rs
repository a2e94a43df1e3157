//! Validation of a host's casters before they are used.
use crate::{
    error::{Error, Input},
    model::{
        Brick, Casters, FARTHEST, GaussianOpacity, Material, Particle, Shape, Transfer, Triangle,
    },
    records::MAX_MATERIALS,
};
use glam::{Vec3, Vec4};

const NO_MATERIAL: &str = "its material is not among the materials";

impl Casters<'_> {
    /// Checks that all indices are in range, all positions finite, and all numbers of materials in their
    /// ranges.
    pub fn check(&self) -> Result<(), Error> {
        let Self { particles, gaussians, triangles, grids, strands, materials, textures, .. } =
            self;
        let (have, need) = (MAX_MATERIALS as u64, materials.len() as u64);
        let remedy = "merge materials that are alike";
        Error::check_limit("materials of a scene", have, need, remedy)?;
        find(Input::Particle, particles, |particle| particle_problem(particle, materials))?;
        find(Input::Strand, strands, |strand| {
            let Some(material) = materials.get(strand.material as usize) else {
                return Some(NO_MATERIAL);
            };
            strand_material_problem(material)
                .or_else(|| strand.problem(material.transfer.max_color()))
        })?;
        find(Input::Gaussian, gaussians, |gaussian| {
            let Some(material) = materials.get(gaussian.material as usize) else {
                return Some(NO_MATERIAL);
            };
            if material.shape != Shape::Gaussian {
                return Some("its material's shape must be `Gaussian`");
            }
            gaussian.problem(material.transfer.max_color(), material.gaussian)
        })?;
        find(Input::Triangle, triangles, |triangle| match triangle {
            Triangle { material, .. } if *material as usize >= materials.len() => Some(NO_MATERIAL),
            Triangle { positions, normals, .. }
                if !positions.iter().chain(normals).all(|v| v.is_finite()) =>
            {
                Some("its corners and normals must be finite")
            }
            Triangle { uvs, .. } if !uvs.iter().all(|uv| uv.is_finite()) => {
                Some("its texture coordinates must be finite")
            }
            _ => None,
        })?;
        find(Input::Grid, grids, |grid| {
            let problem = || grid.bricks.iter().find_map(Brick::problem);
            let of_material = || match materials.get(grid.material as usize) {
                None => Some(NO_MATERIAL),
                Some(material) => material_problem(material),
            };
            grid.problem().or_else(of_material).or_else(problem)
        })?;
        find(Input::Material, materials, |material| {
            let named = [material.texture, material.emissive_texture];
            let far = material.far_side.is_some_and(|far| far as usize >= materials.len());
            let unknown = named.iter().flatten().any(|&index| index as usize >= textures.len());
            let out_of_range = || range_problem(material);
            let details = material.details.is_some_and(|index| index as usize >= materials.len());
            let problem = far.then_some("the material of its far side is not among the materials");
            let missing = "the material of its details is not among the materials";
            let problem = problem.or(details.then_some(missing));
            let unknown = unknown.then_some("its texture is not among the textures");
            problem.or(unknown).or_else(out_of_range)
        })?;
        find(Input::Texture, textures, |texture| {
            let size = u64::from(texture.width) * u64::from(texture.height) * 4;
            (size == 0 || texture.rgba.len() as u64 != size)
                .then_some("it must have width times height times 4 bytes, and some")
        })
    }
}

/// Reason why a particle cannot have its material.
fn particle_problem(particle: &Particle, materials: &[Material]) -> Option<&'static str> {
    let &Particle { center, radius, color, rotation, material, .. } = particle;
    let Some(material) = materials.get(material as usize) else { return Some(NO_MATERIAL) };
    let most = Vec4::from((Vec3::splat(material.transfer.max_color()), 1.0));
    match material.shape {
        Shape::Brick => Some("its material is for grids"),
        _ if !center.abs().cmple(Vec3::splat(FARTHEST)).all() => {
            Some("its centre must be finite and within 1e7 m")
        }
        _ if !(radius > 0.0 && radius <= FARTHEST) => {
            Some("its radius must be above 0 and at most 1e7 m")
        }
        _ if !(color.cmpge(Vec4::ZERO).all() && color.cmple(most).all()) => {
            Some("its colour and alpha must be 0 to 1; colours of `gain` 0 to 16")
        }
        _ if !rotation.is_finite() => Some("its rotation must be finite"),
        Shape::Gaussian => Some("its material's shape is that of Gaussians"),
        Shape::Capsule => Some("its material's shape is that of strands"),
        _ => None,
    }
}

/// The first number of a material that is out of its range.
fn range_problem(material: &Material) -> Option<&'static str> {
    let is_share = |number: f32| (0.0..=1.0).contains(&number);
    let is_color = |color: Vec3, most: f32| {
        color.cmpge(Vec3::ZERO).all() && color.cmple(Vec3::splat(most)).all()
    };
    let &Material {
        tint,
        reflectivity,
        cutoff,
        transmission,
        roughness,
        metallic,
        frost,
        ior,
        fresnel,
        ..
    } = material;
    let shares = [tint.w, reflectivity, cutoff, transmission, roughness, metallic, frost];
    let distance = material.attenuation_distance;
    let is_density = match material.gaussian {
        GaussianOpacity::Medium { density } => density >= 0.0 && density.is_finite(),
        _ => true,
    };
    [
        (is_color(tint.truncate(), material.transfer.max_color()), {
            "its tint must be 0 to 1; of `gain` 0 to 16"
        }),
        (shares.into_iter().all(is_share), {
            "its alpha, reflectivity, cutoff, transmission, roughness, metallic and frost must be 0 to 1"
        }),
        (
            (1..=64).contains(&material.pattern_scale),
            "a cell of its pattern is 1 to 64 texels wide",
        ),
        (is_color(material.emission, f32::MAX), "its emission must be finite and not negative"),
        (is_color(material.attenuation_color, 1.0), "its attenuation must be 0 to 1"),
        (distance > 0.0, "its attenuation distance must be above 0"),
        (
            [ior, fresnel.ior()].iter().all(|ior| (1.0..=3.0).contains(ior)),
            "its index of refraction must be 1 to 3",
        ),
        ((0.0..=20.0).contains(&material.dispersion), "its dispersion must be 0 to 20"),
        (is_density, "the density of its Gaussians must be finite and not negative"),
    ]
    .into_iter()
    .find_map(|(is_met, problem)| (!is_met).then_some(problem))
}

/// Reason why a grid cannot have the material.
pub(super) fn material_problem(material: &Material) -> Option<&'static str> {
    if material.shape != Shape::Brick {
        return Some("its material must have the shape `Brick`");
    }
    let absorbs = matches!(material.transfer, Transfer::Filter | Transfer::None);
    let is_plain = material.texture.is_none() && material.reflectivity == 0.0;
    (!(absorbs && is_plain))
        .then_some("its material must filter or have no transfer, without texture and reflectivity")
}

/// Reason why a strand cannot have the material.
fn strand_material_problem(material: &Material) -> Option<&'static str> {
    if material.shape != Shape::Capsule {
        return Some("its material's shape must be `Capsule`");
    }
    let is_plain = material.texture.is_none() && material.reflectivity == 0.0;
    (!is_plain).then_some("its material must have no texture and no reflectivity")
}

/// Error for the first of `items` that has a problem.
fn find<T>(
    what: Input,
    items: &[T],
    problem: impl Fn(&T) -> Option<&'static str>,
) -> Result<(), Error> {
    let found = items.iter().enumerate().find_map(|(index, item)| Some((index, problem(item)?)));
    found.map_or(Ok(()), |(index, problem)| Err(what.invalid(index, problem)))
}

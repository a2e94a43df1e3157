//! Features of the casters of each class, to which kernels are specialised.
use crate::shadows::host_inputs::HostInputs;
use crate::{
    model::{
        CLASSES, Class, FAINTEST, Fresnel, Gaussian, Material, Particle, Receives, Shape, Transfer,
        Triangle,
    },
    stage::features::{Features, Flags},
};

/// Features of casters that may have no kernels of their own.
const NOT_SIMPLE: Flags = Flags::NOT_PLAIN.union(Flags::NOT_SPLATS);

pub(super) fn features_of(
    particles: &[Particle],
    gaussians: &[Gaussian],
    triangles: &[Triangle],
    materials: &[Material],
) -> [Features; CLASSES] {
    let mut features = [Features::NONE; CLASSES];
    // Whether triangles, and whether other casters, use a material.
    let mut used = vec![[false; 2]; materials.len()];
    for particle in particles {
        let material = &materials[particle.material as usize];
        used[particle.material as usize][1] = true;
        add_opacity(&mut features, material, particle.color.w);
    }
    for gaussian in gaussians {
        let material = &materials[gaussian.material as usize];
        used[gaussian.material as usize][1] = true;
        add_opacity(&mut features, material, gaussian.most_opacity(material.gaussian));
    }
    for triangle in triangles {
        let material = &materials[triangle.material as usize];
        used[triangle.material as usize][0] = true;
        // Alpha of the faintest corner.
        let alpha = triangle.colors.map(|color| color.0[3]).into_iter().min().unwrap_or(255);
        add_opacity(&mut features, material, f32::from(alpha) / 255.0);
        let of_class = &mut features[Class::of(material) as usize];
        add(of_class, [(Flags::HAS_VERTEX_COLORS, triangle.is_colored())]);
    }
    for (material, used) in materials.iter().zip(used) {
        for is_particle in [false, true].into_iter().filter(|&kind| used[usize::from(kind)]) {
            add_features(&mut features, material, is_particle);
        }
    }
    let owners = asks_for_owners(materials);
    for features in features.iter_mut().filter(|_| owners) {
        features.flags |= Flags::HAS_OWNERS | NOT_SIMPLE;
    }
    features
}

/// Adds all features that the materials of the host's sets and grids may have.
pub(super) fn add_host_features(
    features: &mut [Features; CLASSES],
    materials: &[Material],
    inputs: &HostInputs<'_>,
) {
    let owners = asks_for_owners(materials);
    for grid in inputs.grids {
        let material = &materials[grid.grid.material as usize];
        add_features(features, material, true);
        add(&mut features[Class::of(material) as usize], [(NOT_SIMPLE, owners)]);
    }
    for set in inputs.casters.iter().filter(|set| set.count.capacity() > 0) {
        for material in set.materials.iter().map(|&index| &materials[index as usize]) {
            add_features(features, material, true);
            let faintest = material.opacity(set.least_alpha);
            let features = &mut features[Class::of(material) as usize];
            let is_faint = faintest < FAINTEST && !material.transfer.is_opaque();
            add(features, [(Flags::FAINT, is_faint), (NOT_SIMPLE, owners)]);
        }
    }
}

/// Adds the features of an emitter's particles.
pub(super) fn add_emitted_features(
    features: &mut [Features; CLASSES],
    materials: &[Material],
    material: u32,
    least_alpha: f32,
) {
    let material = &materials[material as usize];
    add_features(features, material, true);
    add_opacity(features, material, least_alpha);
    let owners = asks_for_owners(materials);
    add(&mut features[Class::of(material) as usize], [(NOT_SIMPLE, owners)]);
}

/// Whether some receiver is tinted by all casters except its own object's.
pub(super) fn asks_for_owners(materials: &[Material]) -> bool {
    materials.iter().any(|m| m.visible && m.receives == Receives::Others)
}

/// Sets [`Flags::FAINT`] for a caster of opacity `alpha`.
fn add_opacity(features: &mut [Features; CLASSES], material: &Material, alpha: f32) {
    let is_faint = material.is_faint(alpha) && !material.transfer.is_opaque();
    add(&mut features[Class::of(material) as usize], [(Flags::FAINT, is_faint)]);
}

fn add_features(features: &mut [Features; CLASSES], material: &Material, is_particle: bool) {
    let (transfer, shape) = (material.transfer, material.shape);
    let is_solid = !is_particle && transfer == Transfer::Opaque;
    add(
        &mut features[Class::of(material) as usize],
        [
            (Flags::HAS_PARTICLES, is_particle),
            (Flags::HAS_TRIANGLES, !is_particle),
            (Flags::HAS_TEXTURES, material.texture.or(material.emissive_texture).is_some()),
            (Flags::HAS_PUFFS, is_particle && shape == Shape::Puff),
            (Flags::HAS_QUADS, is_particle && shape == Shape::Quad),
            (Flags::HAS_BRICKS, is_particle && shape == Shape::Brick),
            (Flags::HAS_GAUSSIANS, is_particle && shape == Shape::Gaussian),
            (Flags::HAS_CAPSULES, is_particle && shape == Shape::Capsule),
            (Flags::HAS_FACING, is_particle && matches!(shape, Shape::Disc | Shape::Quad)),
            (Flags::HAS_MEDIA, is_particle && material.is_medium()),
            (Flags::HAS_FRESNEL, !is_particle && material.fresnel != Fresnel::None),
            (Flags::HAS_DITHER, transfer == Transfer::Dither),
            (Flags::HAS_GAIN, transfer == Transfer::Gain),
            (Flags::HAS_OVER, transfer == Transfer::Over),
            (Flags::HAS_VOLUMES, !is_particle && material.is_volume()),
            (Flags::NOT_SOLID, !is_solid),
            (Flags::NOT_PLAIN, !(is_particle && material.is_plain_disc())),
            (Flags::NOT_SPLATS, !(is_particle && material.is_plain_splat())),
        ],
    );
}

fn add<const N: usize>(features: &mut Features, flags: [(Flags, bool); N]) {
    for (flag, _) in flags.into_iter().filter(|&(_, is)| is) {
        features.flags |= flag;
    }
}

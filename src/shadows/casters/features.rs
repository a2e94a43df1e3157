//! Features of the casters of each class, to which kernels are specialised.
use crate::shadows::host_inputs::HostCasters;
use crate::{
    model::{CLASSES, Class, FAINTEST, Material, Particle, Receives, Shape, Transfer, Triangle},
    stage::features::Features,
};

pub(super) fn features_of(
    particles: &[Particle],
    triangles: &[Triangle],
    materials: &[Material],
) -> [Features; CLASSES] {
    let mut features = [Features::NONE; CLASSES];
    for particle in particles {
        let material = &materials[particle.material as usize];
        add_features(&mut features, material, true);
        add_opacity(&mut features, material, particle.color.w);
    }
    for triangle in triangles {
        let material = &materials[triangle.material as usize];
        add_features(&mut features, material, false);
        add_opacity(&mut features, material, 1.0);
    }
    let owners = asks_for_owners(materials);
    for features in features.iter_mut().filter(|_| owners) {
        features.owners = true;
        features.plain = false;
    }
    features
}

/// Adds all features that the materials of the host's sets may have.
pub(super) fn add_host_features(
    features: &mut [Features; CLASSES],
    materials: &[Material],
    host: &[HostCasters<'_>],
) {
    let owners = asks_for_owners(materials);
    for set in host.iter().filter(|set| set.count.capacity() > 0) {
        for material in set.materials.iter().map(|&index| &materials[index as usize]) {
            add_features(features, material, true);
            let faintest = material.opacity(set.least_alpha);
            let features = &mut features[Class::of(material) as usize];
            features.faint |= faintest < FAINTEST && !material.transfer.is_opaque();
            features.plain &= !owners;
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
    features[Class::of(material) as usize].plain &= !asks_for_owners(materials);
}

/// Whether some receiver is tinted by all casters except its own object's.
pub(super) fn asks_for_owners(materials: &[Material]) -> bool {
    materials.iter().any(|m| m.visible && m.receives == Receives::Others)
}

/// Sets `faint` for a caster of opacity `alpha`.
fn add_opacity(features: &mut [Features; CLASSES], material: &Material, alpha: f32) {
    features[Class::of(material) as usize].faint |=
        material.is_faint(alpha) && !material.transfer.is_opaque();
}

fn add_features(features: &mut [Features; CLASSES], material: &Material, is_particle: bool) {
    let features = &mut features[Class::of(material) as usize];
    features.particles |= is_particle;
    features.triangles |= !is_particle;
    features.textures |= material.texture.or(material.emissive_texture).is_some();
    features.puffs |= is_particle && material.shape == Shape::Puff;
    features.quads |= is_particle && material.shape == Shape::Quad;
    features.dither |= material.transfer == Transfer::Dither;
    features.gain |= material.transfer == Transfer::Gain;
    features.over |= material.transfer == Transfer::Over;
    features.volumes |= !is_particle && material.is_volume();
    features.solid &= !is_particle && material.transfer == Transfer::Opaque;
    features.plain &= is_particle && material.is_plain_disc();
}

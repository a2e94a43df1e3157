//! What the casters of each class have, so that kernels can leave out the rest.
use crate::{
    model::{CLASSES, Class, Material, Particle, Receives, Shape, Transfer, Triangle},
    stage::hits::Features,
};

pub(super) fn features_of(
    particles: &[Particle],
    triangles: &[Triangle],
    materials: &[Material],
) -> [Features; CLASSES] {
    let mut features = [Features::NONE; CLASSES];
    for particle in particles {
        add_features(&mut features, &materials[particle.material as usize], true);
    }
    for triangle in triangles {
        add_features(&mut features, &materials[triangle.material as usize], false);
    }
    let owners = asks_for_owners(materials);
    for features in features.iter_mut().filter(|_| owners) {
        features.owners = true;
        features.plain = false;
    }
    features
}

/// Whether some receiver is tinted by all casters but its own.
pub(super) fn asks_for_owners(materials: &[Material]) -> bool {
    materials.iter().any(|m| m.visible && m.receives == Receives::Others)
}

fn add_features(features: &mut [Features; CLASSES], material: &Material, is_particle: bool) {
    let features = &mut features[Class::of(material) as usize];
    features.particles |= is_particle;
    features.triangles |= !is_particle;
    features.textures |= material.texture.is_some();
    features.puffs |= is_particle && material.shape == Shape::Puff;
    features.quads |= is_particle && material.shape == Shape::Quad;
    features.dither |= material.transfer == Transfer::Dither;
    features.gain |= material.transfer == Transfer::Gain;
    features.over |= material.transfer == Transfer::Over;
    features.volumes |= !is_particle && material.is_volume();
    features.solid &= !is_particle && material.transfer == Transfer::Opaque;
    features.plain &= is_particle && material.is_plain_disc();
}

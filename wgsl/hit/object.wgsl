// Id of the object that a footprint belongs to.

import package::features::{HAS_CAPSULES, HAS_GAUSSIANS, HAS_TRIANGLES};
import package::records::capsule::is_capsule;
import package::records::caster::particle_object;
import package::records::footprint::{Footprint, caster_of, setup_of};
import package::records::gaussian::is_gaussian;
import package::records::setup::setup_texel;

fn object_of(footprint: Footprint) -> u32 {
    if HAS_TRIANGLES && footprint.is_triangle {
        return setup_texel(setup_of(footprint), 6u).w;
    }
    if (HAS_GAUSSIANS && is_gaussian(footprint)) || (HAS_CAPSULES && is_capsule(footprint)) {
        // The further record of a Gaussian or capsule begins like a particle's, with the id at the same
        // offset.
        return particle_object(particle_object(caster_of(footprint)));
    }
    return particle_object(caster_of(footprint));
}

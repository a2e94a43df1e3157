// Casters, Gaussians and densities in layouts of our own. A host's own text replaces this file.

import package::bind::read::{host_casters, host_gaussians};
import package::bind::sampled::host_voxels;
import package::records::host::{Caster, Gaussian};

// Casters in a buffer with the layout of `Caster`. A host's own text replaces this file.
fn load_caster(index: u32) -> Caster {
    return host_casters[index];
}

// Gaussians in a buffer with the layout of `Gaussian`. A host's own text replaces this file.
fn load_gaussian(index: u32) -> Gaussian {
    return host_gaussians[index];
}

// Densities in the first channel of a volume texture. A host's own text may replace this file.
fn load_density(voxel: vec3<u32>) -> f32 {
    return textureLoad(host_voxels, voxel, 0).r;
}

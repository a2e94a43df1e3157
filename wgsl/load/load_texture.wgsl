// Densities in the first channel of a volume texture. A host's own text may replace this file.

import package::bind::sampled::host_voxels;

fn load_density(voxel: vec3<u32>) -> f32 {
    return textureLoad(host_voxels, voxel, 0).r;
}

// Order of tiles: a workgroup takes the tile of its own index.

fn tile_number(workgroup: vec3<u32>, workgroups: vec3<u32>) -> u32 {
    return workgroup.y * workgroups.x + workgroup.x;
}

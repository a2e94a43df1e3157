// Order of tiles: a workgroup takes the tile of its own index.

import package::records::dispatch::workgroup_number;

fn tile_number(workgroup: vec3<u32>, workgroups: vec3<u32>) -> u32 {
    return workgroup_number(workgroup, workgroups);
}

// Texels in a column of an invocation whose casters are all of one simple kind: four. A workgroup's 64 invocations fill a
// subgroup of any GPU, and smaller subgroups have smaller blocks and visit fewer casters.

const COLUMN_TEXELS: u32 = 4u;
const FOURS: u32 = 1u; // of texels

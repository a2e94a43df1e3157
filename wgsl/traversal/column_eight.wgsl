// Texels in a column of an invocation whose casters are all of one simple kind: eight, which share what a visit costs
// beside its texels. For software adapters, and where every invocation visits every pair.

const COLUMN_TEXELS: u32 = 8u;
const FOURS: u32 = 2u; // of texels

// Texels in a column of an invocation whose casters are all of one simple kind: eight, which share the costs
// of a visit that don't depend on the texel. For software adapters.

const COLUMN_TEXELS: u32 = 8u;

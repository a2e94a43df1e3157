// Texels in a column of an invocation whose casters are all of one simple kind: eight, which share what a
// visit costs beside its texels. For software adapters.

const COLUMN_TEXELS: u32 = 8u;

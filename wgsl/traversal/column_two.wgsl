// Texels in a column of an invocation whose casters are all of one simple kind: two. So 32 lanes hold a
// square block, and smaller subgroups a smaller one, which fewer casters touch.

const COLUMN_TEXELS: u32 = 2u;

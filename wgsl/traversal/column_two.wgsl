// Texels in a column of an invocation whose casters are all of one simple kind: two. 32 lanes have a square
// block, and smaller subgroups smaller ones, which fewer casters touch.

const COLUMN_TEXELS: u32 = 2u;

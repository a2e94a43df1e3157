// Fours of texels in a column of an invocation whose casters are all of one simple kind: two, which share what a visit
// costs beside its texels. For software adapters, and where every invocation visits every pair.

const FOURS: u32 = 2u;

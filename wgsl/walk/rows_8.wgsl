//

const ROWS: u32 = 8u; // texels that an invocation holds, in a column

//

const ROWS: u32 = 1u; // texels that an invocation holds, in a column

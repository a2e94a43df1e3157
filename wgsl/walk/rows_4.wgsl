//

const ROWS: u32 = 4u; // texels that an invocation holds, in a column

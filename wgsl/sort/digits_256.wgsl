// Digits of at most 8 bits: few passes.

const DIGITS: u32 = 256u;

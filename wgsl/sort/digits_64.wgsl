// Digits of at most 6 bits: few counters, which compile fast.

const DIGITS: u32 = 64u;

// What a kernel does for each of some texels it does in a loop. Written out it is faster, but some
// compilers take a minute for that. Rust: `Config::rolled` in src/pipeline/mod.rs.
override ROLLED: bool;

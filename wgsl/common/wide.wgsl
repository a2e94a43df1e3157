// Subgroups may have more than 32 lanes. Rust: `Config::wide` in src/pipeline/mod.rs.
override WIDE: bool;

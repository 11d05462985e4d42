//! The `invertex` binary.
fn main() {}

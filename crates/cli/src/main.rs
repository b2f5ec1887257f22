//! The `meniscus` program.
fn main() {}

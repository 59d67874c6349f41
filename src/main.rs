//! The `ssct` command.
fn main() {}

//! Tests that the header in the repository is what cbindgen makes of the sources. If the variable SSCT_WRITE_DOCS is
//! set, as `make docs` sets it, the test writes the header instead.

#![allow(clippy::unwrap_used)]

use std::path::Path;

#[test]
fn the_header_is_what_the_sources_say() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(root.join("cbindgen.toml")).unwrap();
    // From the file and its modules: given the crate, cbindgen has Cargo fetch the dependencies of every platform.
    let source = root.join("src/lib.rs");
    let bindings = cbindgen::Builder::new().with_src(source).with_config(config).generate().unwrap();
    let mut bytes = Vec::new();
    bindings.write(&mut bytes);
    let generated = String::from_utf8(bytes).unwrap();
    let file = root.join("include/ssct.h");
    if std::env::var_os("SSCT_WRITE_DOCS").is_some() {
        std::fs::write(&file, generated).unwrap();
        return;
    }
    let stored = std::fs::read_to_string(&file).unwrap_or_default();
    assert!(stored == generated, "{} is stale: `make docs` writes it anew", file.display());
}

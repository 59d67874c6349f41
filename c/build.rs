//! Gives the shared library its soname. Without a soname, programs would look for the library in the folder where it
//! lay when they were linked.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    if std::env::var("CARGO_CFG_TARGET_OS").is_ok_and(|system| system == "linux") {
        println!("cargo::rustc-cdylib-link-arg=-Wl,-soname,libssct_c.so");
    }
}

//! Names the library that LAPACK's routines are taken from. Where the linker does not find it,
//! `RUSTFLAGS="-L FOLDER"` says where it is.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    if std::env::var_os("CARGO_FEATURE_LAPACK").is_some() {
        println!("cargo:rustc-link-lib=openblas");
    }
}

//! What the program is compiled by, for `ondine bench` to say.

use std::process::Command;

fn main() {
    let rustc = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".to_owned());
    let told = Command::new(rustc).arg("-vV").output();
    let told = told.map_or_else(
        |_| String::new(),
        |output| String::from_utf8_lossy(&output.stdout).into_owned(),
    );
    let release = told.lines().next().unwrap_or("unknown").to_owned();
    let llvm = told.lines().find(|line| line.starts_with("LLVM version"));
    let flags = std::env::var("CARGO_ENCODED_RUSTFLAGS").unwrap_or_default();
    let level = std::env::var("OPT_LEVEL").unwrap_or_default();
    for (name, value) in [
        ("RUSTC", release),
        (
            "LLVM",
            llvm.unwrap_or_default().replace("LLVM version: ", ""),
        ),
        ("OPT_LEVEL", level),
        ("RUSTFLAGS", flags.replace('\x1f', " ")),
    ] {
        println!("cargo:rustc-env=ONDINE_{name}={value}");
    }
    println!("cargo:rerun-if-changed=tools/build.rs");
}

//! The instruction sets that this program was compiled for, and those that the machine has.
//!
//! `wide` chooses when it is compiled, so a program for too little is slow, and one for too much dies of an illegal
//! instruction: better to say so, once, before anything is computed.

/// `(name, compiled for)` of each set, by the names of `rustc --print target-features`.
macro_rules! compiled {
    ($($name:literal),+) => { [$(($name, cfg!(target_feature = $name))),+] };
}

/// The sets that matter here, small to large.
const COMPILED: &[(&str, bool)] = &compiled!(
    "neon", "sse2", "sse4.1", "sse4.2", "avx", "f16c", "bmi1", "bmi2", "lzcnt", "movbe", "avx2",
    "fma", "avx512f"
);

/// What the program was compiled for, as in `x86_64 sse2 avx avx2 fma`.
pub(super) fn target_features() -> String {
    let sets = COMPILED
        .iter()
        .filter(|(_, compiled)| *compiled)
        .map(|(name, _)| *name);
    std::iter::once(std::env::consts::ARCH)
        .chain(sets)
        .collect::<Vec<_>>()
        .join(" ")
}

/// Compares program and machine.
///
/// # Errors
/// A message where the machine lacks an instruction set that the program uses. `Ok` with advice where the machine could
/// do more.
pub(super) fn check() -> Result<Option<String>, String> {
    let needed = COMPILED
        .iter()
        .filter(|(_, compiled)| *compiled)
        .map(|(name, _)| *name);
    if let Some(flags) = machine_flags() {
        let missing = missing(needed, &flags);
        if !missing.is_empty() {
            return Err(format!(
                "this program was compiled for a processor with {}, which this one lacks; build it here with \
                 RUSTFLAGS=-Ctarget-cpu=native cargo build --release",
                missing.join(", ")
            ));
        }
    }
    Ok(can_do_more().then(|| {
        "this program was compiled without AVX2 and FMA, which this processor has: it runs at a fraction of its speed; \
         build it with the .cargo/config.toml of its repository, or with RUSTFLAGS=-Ctarget-cpu=x86-64-v3"
            .to_owned()
    }))
}

#[cfg(target_arch = "x86_64")]
fn can_do_more() -> bool {
    let compiled = cfg!(target_feature = "avx2") && cfg!(target_feature = "fma");
    !compiled && is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma")
}

#[cfg(not(target_arch = "x86_64"))]
fn can_do_more() -> bool {
    false
}

/// The processor's flags as Linux tells them. Not `is_x86_feature_detected!`, which takes what the program was compiled
/// for as granted and never looks.
#[cfg(all(target_arch = "x86_64", target_os = "linux"))]
fn machine_flags() -> Option<String> {
    let cpuinfo = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = cpuinfo.lines().find(|line| line.starts_with("flags"))?;
    Some(line.split_once(':')?.1.to_owned())
}

#[cfg(not(all(target_arch = "x86_64", target_os = "linux")))]
fn machine_flags() -> Option<String> {
    None
}

/// Those of `needed` that a processor with these flags lacks.
fn missing<'a>(needed: impl Iterator<Item = &'a str>, flags: &str) -> Vec<&'a str> {
    let has = |flag: &str| flags.split_whitespace().any(|word| word == flag);
    needed
        .filter(|&name| match name {
            "sse4.1" => !has("sse4_1"),
            "sse4.2" => !has("sse4_2"),
            "lzcnt" => !has("abm"),
            _ => !has(name),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_processor_of_2012_lacks_what_v3_needs() {
        let ivy_bridge = "fpu sse2 ssse3 sse4_1 sse4_2 popcnt aes avx f16c rdrand";
        let needed = ["sse2", "sse4.2", "avx", "f16c", "lzcnt", "avx2", "fma"];
        assert_eq!(
            missing(needed.into_iter(), ivy_bridge),
            ["lzcnt", "avx2", "fma"]
        );
    }

    #[test]
    fn the_machine_that_runs_this_test_has_what_it_was_compiled_for() {
        assert!(check().is_ok());
        assert!(target_features().starts_with(std::env::consts::ARCH));
    }
}

//! Every benchmark, in one program with two faces. Criterion times each case:
//!
//! ```sh
//! cargo bench                     # all
//! cargo bench -- stages/shade/    # those whose name has this in it
//! ```
//!
//! and valgrind counts its instructions, which are the same on a busy machine: `--count NAME` runs one case once, where
//! `tools/count_instructions.py` has its counters on; `--count --list` names those that can be counted.
//!
//! Everything is done by one thread, unless a name says otherwise, and nothing is drawn by chance.

mod common;
mod count;
mod film;
mod render;
mod sh;
mod stages;
mod tree;

use common::case::Case;
use criterion::{Criterion, Throughput};
use std::process::ExitCode;

/// The files of cases.
fn files() -> [(&'static str, Vec<Case>); 5] {
    [
        ("stages", stages::cases()),
        ("render", render::cases()),
        ("tree", tree::cases()),
        ("sh", sh::cases()),
        ("film", film::cases()),
    ]
}

fn main() -> ExitCode {
    // What asks for threads gets this one.
    rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .use_current_thread()
        .build_global()
        .expect("nothing has asked for threads yet");
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().position(|word| word == "--count") {
        Some(at) => count::run(arguments.get(at + 1), &files()),
        None => {
            time(&files());
            ExitCode::SUCCESS
        }
    }
}

/// Criterion's face.
fn time(files: &[(&str, Vec<Case>)]) {
    let mut criterion = Criterion::default().configure_from_args();
    for (file, cases) in files {
        let mut group = criterion.benchmark_group(*file);
        for case in cases {
            group
                .sample_size(case.pace.samples())
                .warm_up_time(case.pace.warm_up())
                .measurement_time(case.pace.measurement());
            case.show(&mut |elements, work| {
                group.throughput(Throughput::Elements(elements as u64));
                group.bench_function(&case.name, |bencher| bencher.iter(&mut *work));
            });
        }
        group.finish();
    }
    criterion.final_summary();
}

//! The benchmark suite: its images are right, a wrong one is no score, and what changed is told from noise.

mod common;

mod bench {
    mod changes;
    mod proofs;
}

use ondine::bench::{CASES, Look, Plan, Report, Suite, run};
use ondine::wavefront::{self, Context, Wave, Workspace};
use std::sync::OnceLock;
use std::sync::atomic::AtomicBool;

/// The box alone, each thing once.
fn plan(scaling: bool) -> Plan {
    Plan {
        suite: Suite::Quick,
        cases: CASES.iter().filter(|case| case.name == "box").collect(),
        scaling,
        threads: vec![2],
        repeats: 1,
        target_features: String::new(),
    }
}

/// Runs it.
fn report_of(scaling: bool, trace: &(impl Fn(&Context, &Wave, &mut Workspace) + Sync)) -> Report {
    let look = Look {
        stop: &AtomicBool::new(false),
        progress: &|_, _| (),
    };
    run(&plan(scaling), trace, &look)
        .unwrap()
        .expect("it was not stopped")
}

/// That of this program, with everything.
fn right() -> &'static Report {
    static RIGHT: OnceLock<Report> = OnceLock::new();
    RIGHT.get_or_init(|| report_of(true, &wavefront::trace))
}

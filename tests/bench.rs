//! The benchmark suite: its images are right, a wrong one is no score, and what changed is told from noise.

mod common;

mod bench {
    mod changes;
    mod proofs;
}

use ondine::bench::{Look, Plan, Report, Suite, run};
use ondine::wavefront::{Context, Wave, Workspace};
use std::sync::atomic::AtomicBool;

/// Runs some scenes of the quick suite, each thing once.
fn report_of(scenes: &[&str], trace: &(impl Fn(&Context, &Wave, &mut Workspace) + Sync)) -> Report {
    let plan = Plan {
        suite: Suite::Quick,
        cases: Suite::Quick
            .cases()
            .filter(|case| scenes.contains(&case.name))
            .collect(),
        threads: vec![2],
        repeats: 1,
        target_features: String::new(),
    };
    let look = Look {
        stop: &AtomicBool::new(false),
        progress: &|_, _| (),
    };
    run(&plan, trace, &look)
        .unwrap()
        .expect("it was not stopped")
}

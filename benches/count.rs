//! The face that valgrind looks at: one case, once.

use crate::common::case::Case;
use std::hint::black_box;
use std::process::ExitCode;

/// Runs the case of that name, or lists the names of all that can be counted.
pub fn run(name: Option<&String>, files: &[(&str, Vec<Case>)]) -> ExitCode {
    let Some(name) = name else {
        return refuse("--count takes the name of a case, or --list");
    };
    let counted = files.iter().flat_map(|(file, cases)| {
        let cases = cases.iter().filter(|case| case.counted);
        cases.map(move |case| (format!("{file}/{}", case.name), case))
    });
    if name == "--list" {
        counted.for_each(|(name, _)| println!("{name}"));
        return ExitCode::SUCCESS;
    }
    let Some((_, case)) = counted.into_iter().find(|(known, _)| known == name) else {
        return refuse(&format!(
            "no case {name} is counted; `--count --list` names those that are"
        ));
    };
    case.show(&mut |elements, work| {
        // What is done but once, such as growing a list, is done here.
        work();
        count_instructions(work);
        println!("elements {elements}");
    });
    ExitCode::SUCCESS
}

/// Counters are on from here to the end of it: `tools/count_instructions.py` knows it by its name.
#[inline(never)]
fn count_instructions(work: &mut dyn FnMut()) {
    work();
    // A call that is the last thing would be a jump.
    black_box(());
}

fn refuse(why: &str) -> ExitCode {
    eprintln!("{why}");
    ExitCode::from(2)
}

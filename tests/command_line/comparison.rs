//! `ondine compare`.

use super::refusals::refuses;
use crate::{folder, ondine};

fn render(folder: &tempfile::TempDir, seed: u32, more: &str) {
    let line =
        format!("render cornell --size 64x64 --spp 16 --seed {seed} -o {seed}.exr --no-png {more}");
    assert_eq!(ondine(folder, &line).code, 0);
}

#[test]
fn images_of_two_seeds_are_consistent_and_of_fewer_bounces_biased() {
    let folder = folder();
    render(&folder, 1, "");
    render(&folder, 2, "");
    render(&folder, 3, "--path-length 3");
    let run = ondine(&folder, "compare 1.exr 2.exr");
    assert_eq!(run.code, 0, "{}", run.stdout);
    assert!(run.stdout.starts_with("consistent: "), "{}", run.stdout);
    let run = ondine(&folder, "compare 1.exr 3.exr");
    assert_eq!(run.code, 1, "{}", run.stdout);
    assert!(run.stdout.starts_with("biased: "), "{}", run.stdout);
    let run = ondine(&folder, "compare 1.exr 1.exr");
    assert_eq!(run.code, 0, "{}", run.stdout);
    assert!(run.stdout.starts_with("bit-equal: "), "{}", run.stdout);

    let json = ondine(&folder, "compare 1.exr 2.exr --json").json();
    assert_eq!(json["verdict"], "consistent");
    assert_eq!(json["image"]["channels"][3]["channel"], "luminance");
    assert!(json["metrics"]["expected_mse"].as_f64().unwrap() > 0.0);
    // A bias that is tolerated is none.
    let run = ondine(&folder, "compare 1.exr 3.exr --tolerance 1");
    assert_eq!(run.code, 0, "{}", run.stdout);
}

#[test]
fn what_cannot_be_compared_exits_with_2() {
    let folder = folder();
    render(&folder, 1, "");
    render(&folder, 2, "--crop 0,0,32,32");
    refuses(
        &folder,
        "compare 1.exr 2.exr",
        &["64x64", "32x32", "same pixels"],
    );
    refuses(
        &folder,
        "compare 1.exr none.exr",
        &["none.exr", "cannot read"],
    );
    refuses(
        &folder,
        "compare 1.exr 1.exr --layer albedo",
        &["\"albedo\"", "1.exr"],
    );
    refuses(
        &folder,
        "compare 1.exr 1.exr --alpha 2",
        &["--alpha", "1e-12 to 0.5"],
    );
    refuses(
        &folder,
        "compare 1.exr 1.exr --tolerance -1",
        &["--tolerance", "0 to 1"],
    );
}

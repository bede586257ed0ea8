//! What cannot be done: exit code 2, a line that says where, what and what to do, and no file.

use crate::{folder, names, ondine};
use std::time::{Duration, Instant};

/// Runs, and asserts a refusal in one line with these words, that leaves nothing new.
#[track_caller]
pub(super) fn refuses(folder: &tempfile::TempDir, line: &str, words: &[&str]) {
    let before = names(folder.path());
    let run = ondine(folder, line);
    assert_eq!(run.code, 2, "{line}: {}{}", run.stdout, run.stderr);
    assert_eq!(run.stdout, "", "{line}");
    assert!(run.stderr.starts_with("error: "), "{line}: {}", run.stderr);
    assert_eq!(run.stderr.lines().count(), 1, "{line}: {}", run.stderr);
    for word in words {
        assert!(run.stderr.contains(word), "{}\nlacks {word:?}", run.stderr);
    }
    assert_eq!(names(folder.path()), before, "{line}");
}

#[test]
fn an_argument_out_of_its_range_is_refused_with_the_range() {
    let folder = folder();
    let cases: &[(&str, &[&str])] = &[
        ("--size 0x0", &["width is 0", "1 to 65535"]),
        ("--size 99999x1", &["width is 99999", "1 to 65535"]),
        ("--size 12", &["--size", "640x480"]),
        ("--size -1x5", &["--size", "640x480"]),
        ("--crop 0,0,9999,4", &["0,0,9999,4", "256"]),
        ("--crop 5,5,5,9", &["--crop", "x0 < x1"]),
        ("--crop -1,0,4,4", &["--crop", "x0,y0,x1,y1"]),
        ("--exposure NaN", &["--exposure", "-64 to 64"]),
        ("--exposure inf", &["--exposure", "-64 to 64"]),
        ("--time -1", &["--time", "above 0"]),
        ("--time NaN", &["--time", "above 0"]),
        ("--time 0", &["--time", "above 0"]),
        ("--time 1e300", &["--time", "at most"]),
        ("--threads 0", &["threads is 0", "1 to 1024"]),
        ("--wave 3", &["wave size is 3", "16 to"]),
        (
            "--seed 18446744073709551616",
            &["--seed", "too large", "18446744073709551615"],
        ),
        ("--seed -1", &["--seed", "from 0"]),
        ("--spp 0", &["spp", "is 0", "1 to"]),
        ("--path-length 0", &["path length is 0", "1 to"]),
        ("--camera nobody", &["nobody", "it has camera"]),
        (
            "--strategy cosin",
            &["uniform, cosine, light, mis", "similar"],
        ),
        ("--sampler halton", &["pcg, sobol"]),
        ("--aov albdo", &["did you mean", "albedo, normal, depth"]),
        ("--sppp 4", &["--sppp", "--spp"]),
        ("-o x.png", &["-o x.png", "use -o x.exr"]),
    ];
    for (arguments, words) in cases {
        refuses(&folder, &format!("render cornell {arguments}"), words);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn more_than_memory_holds_is_refused_before_it_is_asked_for() {
    let folder = folder();
    let line = "render cornell --size 65535x65535";
    refuses(&folder, line, &["GiB", "--size", "--crop"]);
    let line = "render cornell --size 8192x8192 --threads 1024 --wave 1048576";
    refuses(&folder, line, &["GiB", "--wave", "--threads"]);
}

#[test]
fn a_name_that_is_nothing_is_refused_with_what_was_meant() {
    let folder = folder();
    std::fs::write(folder.path().join("note.txt"), "hello").unwrap();
    refuses(&folder, "render cornel", &["did you mean \"cornell\""]);
    refuses(&folder, "render nothing.toml", &["no file", "cornell"]);
    refuses(
        &folder,
        "render note.txt",
        &["note.txt", "not a scene file"],
    );
    refuses(&folder, "render .", &["not a scene file"]);
    refuses(&folder, "scenes cornel", &["did you mean \"cornell\""]);
    refuses(&folder, "info nothing.exr", &["nothing.exr: cannot read"]);
    refuses(&folder, "info cornell --crop 0,0,1,1", &["--crop"]);
    refuses(&folder, "rendr", &["render"]);
    refuses(&folder, "render", &["<SCENE>"]);
}

#[test]
fn a_scene_that_cannot_be_rendered_is_refused_at_its_place() {
    let folder = folder();
    let right = ondine(&folder, "scenes cornell").stdout;
    let path = folder.path().join("bad.toml");
    let cases = [
        ("radius = 0.35", "radus = 0.35", "did you mean"),
        ("material = \"blue\"", "material = \"blu\"", "did you mean"),
        ("radius = 0.35", "radius = nan", "bad.toml:"),
        ("radius = 0.35", "radius = -0.35", "above 0"),
        ("width = 256", "width = 0", "1"),
        ("version = 1", "version = 2", "version"),
        ("[camera]", "[camera", "TOML"),
    ];
    for (from, to, word) in cases {
        let line = right.lines().position(|line| line.contains(from)).unwrap() + 1;
        std::fs::write(&path, right.replacen(from, to, 1)).unwrap();
        refuses(
            &folder,
            "render bad.toml",
            &[&format!("bad.toml:{line}:"), word],
        );
        refuses(
            &folder,
            "info bad.toml",
            &[&format!("bad.toml:{line}:"), word],
        );
    }
    let end = right.find("[materials.white]").unwrap();
    std::fs::write(&path, &right[..end]).unwrap();
    refuses(
        &folder,
        "render bad.toml",
        &["bad.toml:", "empty", "[[lights]]"],
    );
    std::fs::write(&path, "").unwrap();
    refuses(&folder, "render bad.toml", &["bad.toml:1:1", "version = 1"]);
    std::fs::write(&path, [0xff, 0xfe]).unwrap();
    refuses(&folder, "render bad.toml", &["bad.toml:1:1", "UTF-8"]);
}

#[test]
fn an_output_that_cannot_be_written_is_refused_before_the_render() {
    let folder = folder();
    std::fs::create_dir(folder.path().join("folder.exr")).unwrap();
    std::fs::create_dir(folder.path().join("picture.png")).unwrap();
    let hours = "render cornell --size 1024x1024 --spp 1000000";
    let begin = Instant::now();
    let cases: &[(&str, &[&str])] = &[
        ("-o missing/a.exr", &["missing/a.exr", "mkdir -p missing"]),
        ("-o folder.exr", &["folder.exr", "folder"]),
        ("-o picture.exr", &["picture.png", "folder"]),
        ("-o .", &["use -o ./image.exr"]),
        #[cfg(target_os = "linux")]
        ("-o /proc/a.exr", &["/proc/a.exr", "cannot write"]),
    ];
    for (output, words) in cases {
        refuses(&folder, &format!("{hours} {output}"), words);
    }
    assert!(begin.elapsed() < Duration::from_secs(20));
    std::fs::write(folder.path().join("old.exr"), "old").unwrap();
    refuses(
        &folder,
        &format!("{hours} -o old.exr --camera nobody"),
        &["camera"],
    );
    let old = std::fs::read(folder.path().join("old.exr")).unwrap();
    assert_eq!(
        old, b"old",
        "what was there stays until there is something better"
    );
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_an_error_and_leaves_nothing() {
    let Some(disk) = crate::small_disk::SmallDisk::new() else {
        eprintln!(
            "SKIPPED: a_full_disk_is_an_error_and_leaves_nothing: may not mount a tmpfs here"
        );
        return;
    };
    refuses(
        &disk.0,
        "render cornell --size 128x128 --spp 1",
        &["cornell.exr", "No space left", "nothing was written"],
    );
    assert!(names(disk.0.path()).is_empty());
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_stdout_is_an_error() {
    let folder = folder();
    let full = std::fs::OpenOptions::new()
        .write(true)
        .open("/dev/full")
        .unwrap();
    let output = crate::command(folder.path(), "scenes cornell")
        .stdout(full)
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("stdout"));
}

//! The page that `compare --html` writes.

use crate::{command, folder, names};
use ondine::film::Raster;
use ondine::lanes::Rgb;
use std::path::Path;
use tempfile::TempDir;

fn write(folder: &TempDir, name: &str, width: usize, pixels: Vec<Rgb>) {
    let image = Raster::new(width, pixels).unwrap();
    image.write_exr(&folder.path().join(name)).unwrap();
}

/// Writes two images, compares them and gives the page, and the exit code.
fn page(folder: &TempDir, images: [&str; 2], options: &[&str]) -> (i32, String) {
    let output = command(folder.path(), "compare --html page.html")
        .args(images.map(|name| format!("./{name}")))
        .args(options)
        .output()
        .unwrap();
    let page = std::fs::read_to_string(folder.path().join("page.html")).unwrap_or_default();
    (output.status.code().unwrap(), page)
}

/// A ramp that some pixels of are brighter than white.
fn ramp(pixels: usize, scale: f32) -> Vec<Rgb> {
    (0..pixels)
        .map(|i| {
            [i as f32, 1.0 + (i % 7) as f32, (i % 3) as f32]
                .map(|x| x * scale)
                .into()
        })
        .collect()
}

#[test]
fn a_name_is_never_markup() {
    let folder = folder();
    let evil = "a<img src=x onerror=alert(1)>\"'&.exr";
    write(&folder, evil, 20, ramp(400, 1.0));
    write(&folder, "b.exr", 20, ramp(400, 1.5));
    let (code, page) = page(&folder, [evil, "b.exr"], &[]);
    assert!(code < 2, "{code}");
    assert!(!page.contains("<img src=x"));
    assert!(page.contains("a&lt;img src=x onerror=alert(1)&gt;&quot;&#39;&amp;.exr"));
}

#[test]
fn a_page_holds_all_it_needs() {
    let folder = folder();
    write(&folder, "a.exr", 40, ramp(1200, 1.0));
    write(&folder, "b.exr", 40, ramp(1200, 1.1));
    let (_, page) = page(&folder, ["a.exr", "b.exr"], &[]);
    for id in [
        "reference",
        "test",
        "reference-bright",
        "test-bright",
        "relative",
        "flip",
    ] {
        assert!(page.contains(&format!("id=\"image-{id}\"")), "{id}");
    }
    for start in ["http:", "https:", "{{", "url("] {
        // The name of SVG's elements is no address that is asked for.
        let found = page.replace("http://www.w3.org/2000/svg", "");
        assert!(!found.contains(start), "{start}");
    }
    assert_eq!(page.matches("<script").count(), 2);
}

#[test]
fn images_of_any_size_and_value_have_a_page() {
    for (width, height) in [(1, 1), (1, 50), (70, 1), (3, 2)] {
        for scale in [0.0, -1.0, 1e-30, 1e30] {
            for options in [&[][..], &["--no-flip"]] {
                let folder = folder();
                write(&folder, "a.exr", width, ramp(width * height, scale));
                write(&folder, "b.exr", width, ramp(width * height, scale * 1.5));
                let (code, page) = page(&folder, ["a.exr", "b.exr"], options);
                assert!(code < 2, "{width}x{height} {scale}: {code}");
                assert!(page.ends_with("</html>\n"));
                assert_eq!(page.contains("image-flip"), options.is_empty());
            }
        }
    }
}

#[test]
fn a_large_image_is_shown_smaller() {
    let folder = folder();
    write(&folder, "a.exr", 40_000, ramp(80_000, 1.0));
    let (code, page) = page(&folder, ["a.exr", "a.exr"], &["--no-flip"]);
    assert_eq!(code, 0);
    assert!(page.contains("Bit-equal"));
    assert!(page.contains("mean of 3 × 3"));
    assert!(page.contains("width=\"13334\" height=\"1\""));
}

#[test]
fn a_page_that_cannot_be_written_leaves_nothing() {
    let folder = folder();
    write(&folder, "a.exr", 4, ramp(16, 1.0));
    let output = command(folder.path(), "compare a.exr a.exr --html none/page.html")
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(
        said.contains("none/page.html: cannot write") && said.trim().lines().count() == 1,
        "{said}"
    );
    assert_eq!(names(folder.path()), ["a.exr"]);
    assert!(!Path::new("none").exists());
}

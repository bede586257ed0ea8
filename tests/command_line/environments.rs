//! Projection of environments and shading by the double sum, as their users meet them.

use super::refusals::refuses;
use crate::{folder, names, ondine};
use exr::prelude::write_rgb_file;
use std::path::Path;

/// A smooth sky with a bright spot, or whatever `pixel` changes it to.
fn write_sky(
    path: &Path,
    size: (usize, usize),
    pixel: impl Fn(usize, usize) -> Option<f32> + Sync,
) {
    write_rgb_file(path, size.0, size.1, |x, y| {
        let up = 1.0 - y as f32 / size.1 as f32;
        let spot = if (x, y) == (40, 10) { 5000.0 } else { 0.0 };
        let blue = pixel(x, y).unwrap_or(up);
        (0.2 + spot, 0.5 * up, blue)
    })
    .unwrap();
}

fn sky(folder: &tempfile::TempDir, name: &str) {
    write_sky(&folder.path().join(name), (128, 64), |_, _| None);
}

/// The blue of each pixel.
fn blue(path: &Path) -> Vec<f32> {
    let image = exr::prelude::read_first_rgba_layer_from_file(
        path,
        |size, _| (size.width(), vec![0.0; size.area()]),
        |(width, pixels), at, (_, _, b, _): (f32, f32, f32, f32)| {
            pixels[at.y() * *width + at.x()] = b;
        },
    );
    image.unwrap().layer_data.channel_data.pixels.1
}

#[test]
fn a_projection_is_the_same_file_on_stdout_in_json_and_with_any_threads() {
    let folder = folder();
    sky(&folder, "sky.exr");
    let stdout = ondine(&folder, "sh project sky.exr --bands 4").stdout;
    let run = ondine(
        &folder,
        "sh project sky.exr --bands 4 -o a.json --threads 1",
    );
    assert!(
        run.stdout.contains("25 coefficients to l_max = 4"),
        "{}",
        run.stdout
    );
    let file = std::fs::read_to_string(folder.path().join("a.json")).unwrap();
    assert_eq!(file, stdout);
    let report = ondine(
        &folder,
        "sh project sky.exr --bands 4 -o a.csv --threads 3 --json",
    )
    .json();
    let file: serde_json::Value = serde_json::from_str(&file).unwrap();
    for key in [
        "format",
        "convention",
        "quantity",
        "unit",
        "l_max",
        "coefficients",
        "source",
    ] {
        assert_eq!(report[key], file[key], "{key}");
    }
    assert_eq!(report["outputs"], serde_json::json!(["a.csv"]));
    let csv = std::fs::read_to_string(folder.path().join("a.csv")).unwrap();
    assert_eq!(
        csv.lines().filter(|line| !line.starts_with('#')).count(),
        26
    );
    assert_eq!(names(folder.path()), ["a.csv", "a.json", "sky.exr"]);
}

#[test]
fn the_light_is_turned_as_an_object_would_be_and_convolved_last() {
    let folder = folder();
    sky(&folder, "sky.exr");
    let project = |arguments: &str| {
        let line = format!("sh project sky.exr --bands 1 --json {arguments}");
        ondine(&folder, &line).json()["coefficients"].clone()
    };
    let at = |list: &serde_json::Value, k: usize| list[k][2].as_f64().unwrap();
    let (plain, turned) = (project(""), project("--rotate 90,0,0"));
    // About x, what was up comes to the front: y to z.
    assert!((at(&turned, 2) - at(&plain, 1)).abs() < 1e-14);
    assert!((at(&turned, 1) + at(&plain, 2)).abs() < 1e-14);
    let cosine = project("--rotate 90,0,0 --lobe cosine");
    let pi = std::f64::consts::PI;
    assert!((at(&cosine, 0) / at(&plain, 0) - pi).abs() < 1e-13);
    assert!((at(&cosine, 2) / at(&plain, 1) - 2.0 * pi / 3.0).abs() < 1e-13);
    let line = "sh project sky.exr --bands 1 --json --lobe cosine";
    assert_eq!(ondine(&folder, line).json()["quantity"], "irradiance");
}

#[test]
fn a_reconstruction_lies_beside_the_original_and_says_what_is_negative() {
    let folder = folder();
    sky(&folder, "sky.exr");
    let line = "sh project sky.exr --bands 8 --reconstruct out.exr";
    let kept = ondine(&folder, &format!("{line} --json")).json();
    assert_eq!(names(folder.path()), ["out.exr", "out.png", "sky.exr"]);
    let made = &kept["reconstruction"];
    assert_eq!(
        (&made["window"], &made["clamped"]),
        (&"none".into(), &false.into())
    );
    assert!(made["least"].as_f64().unwrap() < 0.0);
    let smooth = blue(&folder.path().join("out.exr"));
    assert_eq!(smooth.len(), 128 * 64);
    // The spot is not in blue, which is linear in θ, and comes back but for the poles, where that has a tip.
    let original = blue(&folder.path().join("sky.exr"));
    let middle = 64 * 30..64 * 34;
    for (a, b) in smooth[middle.clone()].iter().zip(&original[middle]) {
        assert!((a - b).abs() < 0.03, "{a} {b}");
    }
    let decoder = png::Decoder::new(std::io::BufReader::new(
        std::fs::File::open(folder.path().join("out.png")).unwrap(),
    ));
    assert_eq!(decoder.read_info().unwrap().info().size(), (256, 64));

    let run = ondine(&folder, line);
    assert!(
        run.stdout.contains("% of the pixels negative, kept"),
        "{}",
        run.stdout
    );
    let run = ondine(&folder, &format!("{line} --clamp --window hanning"));
    assert!(run.stdout.contains("window hanning"), "{}", run.stdout);
    let clamped = ondine(&folder, "sh project out.exr --bands 8 --json").json();
    assert_eq!(clamped["width"], 128);
}

#[test]
fn an_image_that_is_no_environment_is_refused_at_its_pixel() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let at = |wrong: f32| move |x, y| ((x, y) == (3, 5)).then_some(wrong);
    write_sky(&path("nan.exr"), (16, 8), at(f32::NAN));
    write_sky(&path("negative.exr"), (16, 8), at(-0.5));
    write_sky(&path("square.exr"), (16, 16), |_, _| None);
    std::fs::write(path("text.exr"), "hello").unwrap();
    let bytes = std::fs::read(path("square.exr")).unwrap();
    std::fs::write(path("cut.exr"), &bytes[..bytes.len() / 2]).unwrap();
    sky(&folder, "sky.exr");
    let cases: &[(&str, &[&str])] = &[
        (
            "nan.exr --bands 2",
            &["nan.exr: pixel (3, 5) has B = NaN", "repair"],
        ),
        (
            "negative.exr --bands 2",
            &["negative.exr: pixel (3, 5) has B = -0.5", "repair"],
        ),
        (
            "square.exr --bands 2",
            &["square.exr: is 16×16 pixels", "resize it to 32×16"],
        ),
        (
            "text.exr --bands 2",
            &["text.exr: is not an EXR image", "convert"],
        ),
        ("cut.exr --bands 2", &["cut.exr:"]),
        ("none.exr --bands 2", &["none.exr: cannot read"]),
        ("sky.exr", &["--bands"]),
        ("sky.exr --bands 129", &["--bands", "0 to 128"]),
        ("sky.exr --bands -1", &["--bands", "0 to 128"]),
        (
            "sky.exr --bands 2 --lobe square",
            &["square", "cosine, or phong:N"],
        ),
        ("sky.exr --bands 2 --lobe phong:nan", &["0 to 1000000"]),
        ("sky.exr --bands 2 --rotate 1,2", &["three angles"]),
        ("sky.exr --bands 2 --rotate 1,2,3,x", &["three angles"]),
        ("sky.exr --bands 2 --rotate 0,0,inf", &["three angles"]),
        ("sky.exr --bands 2 --window hanning", &["--reconstruct"]),
        ("sky.exr --bands 2 --clamp", &["--reconstruct"]),
        (
            "sky.exr --bands 2 --reconstruct out.png",
            &["--reconstruct out.png: ", "use --reconstruct out.exr"],
        ),
        (
            "sky.exr --bands 2 --reconstruct sky.exr",
            &["sky.exr: this file is read"],
        ),
        (
            "sky.exr --bands 2 -o out.png --reconstruct out.exr",
            &["out.png: two outputs", "name another with -o"],
        ),
        (
            "sky.exr --bands 2 -o ./out.exr --reconstruct out.exr",
            &["out.exr: two outputs", "name another with -o"],
        ),
        (
            "sky.exr --bands 2 -o no/a.json",
            &["no/a.json", "mkdir -p no"],
        ),
    ];
    for (arguments, words) in cases {
        refuses(&folder, &format!("sh project {arguments}"), words);
    }
}

#[test]
fn a_shaded_sphere_is_written_and_no_thread_changes_a_bit() {
    let folder = folder();
    let line = "sh shade --light grace --bsdf lambert --size 33x20 --albedo 0.5";
    let report = ondine(&folder, &format!("{line} --threads 1 -o a.exr --json")).json();
    assert_eq!(
        (&report["l_max"], &report["coefficients"]),
        (&2.into(), &9.into())
    );
    assert_eq!(
        ondine(&folder, &format!("{line} --threads 3 -o b.exr")).code,
        0
    );
    assert_eq!(names(folder.path()), ["a.exr", "a.png", "b.exr", "b.png"]);
    let bytes = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    assert_eq!(bytes("a.exr"), bytes("b.exr"));
    let picture = blue(&folder.path().join("a.exr"));
    assert_eq!((picture.len(), picture[0]), (33 * 20, 0.0));
    // Seen from +z, the middle of the sphere looks there: albedo/π times the irradiance of the published formula.
    let (l00, l10, l20) = (0.54161, -0.26940, -0.14733);
    let irradiance = 0.886227 * l00 + 2.0 * 0.511664 * l10 + (0.743125 - 0.247708) * l20;
    let wanted = 0.5 * irradiance / std::f64::consts::PI;
    let middle = 0.5 * f64::from(picture[9 * 33 + 16] + picture[10 * 33 + 16]);
    assert!((middle - wanted).abs() < 2e-3, "{middle} {wanted}");
}

#[test]
fn any_light_shades_any_shape() {
    let folder = folder();
    sky(&folder, "sky.exr");
    assert_eq!(
        ondine(&folder, "sh project sky.exr --bands 6 -o light.csv").code,
        0
    );
    // A tetrahedron.
    std::fs::write(
        folder.path().join("shape.obj"),
        "v 0 1 0\nv -1 -1 1\nv 1 -1 1\nv 0 -1 -1\nf 1 2 3\nf 1 3 4\nf 1 4 2\nf 2 4 3\n",
    )
    .unwrap();
    let shade = |arguments: &str| {
        let line = format!("sh shade --size 24x24 --json --bsdf {arguments}");
        ondine(&folder, &line).json()
    };
    let report = shade("phong:20 --light light.csv --shape shape.obj -o a.exr");
    assert_eq!(
        (&report["l_max"], &report["bsdf"]),
        (&6.into(), &"phong:20".into())
    );
    shade("phong:20 --light sky.exr --bands 6 --shape shape.obj -o b.exr");
    let [a, b] = ["a.exr", "b.exr"].map(|name| blue(&folder.path().join(name)));
    assert_eq!(a, b);
    assert!(a.iter().any(|&blue| blue > 0.1), "the shape is seen");
    assert_eq!(shade("lambert --light sky.exr --shape cornell")["l_max"], 8);
}

#[test]
fn what_a_texture_cuts_out_is_shaded_whole() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let file = std::fs::File::create(path("hole.png")).unwrap();
    let mut encoder = png::Encoder::new(file, 1, 1);
    encoder.set_color(png::ColorType::Grayscale);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(&[0]).unwrap();
    writer.finish().unwrap();
    std::fs::write(path("quad.mtl"), "newmtl leaf\nmap_d hole.png\n").unwrap();
    let quad = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\n";
    let face = "f 1/1 2/1 3/1 4/1\n";
    let leaf = format!("mtllib quad.mtl\n{quad}usemtl leaf\n{face}");
    let [leaf, plain] = [leaf, format!("{quad}{face}")].map(|text| {
        std::fs::write(path("quad.obj"), text).unwrap();
        let line = "sh shade --size 8x8 --bsdf lambert --light grace --shape quad.obj";
        assert_eq!(ondine(&folder, line).code, 0);
        blue(&path("shade.exr"))
    });
    assert_eq!(leaf, plain);
    assert!(leaf.iter().any(|&blue| blue > 0.0), "the quad is seen");
}

#[test]
fn negative_light_is_counted_and_threads_are_in_the_singular() {
    let folder = folder();
    sky(&folder, "sky.exr");
    changed(&folder, "below.json", [-1.0; 3]);
    let line = "sh shade --size 8x8 --bsdf lambert --light below.json --threads 1";
    let text = ondine(&folder, line).stdout;
    assert!(text.contains("% of the pixels are negative\n"), "{text}");
    assert!(text.contains(" with 1 thread\n"), "{text}");
    let text = ondine(
        &folder,
        "sh project sky.exr --bands 0 --threads 1 -o a.json",
    )
    .stdout;
    assert!(text.contains("\n1 coefficient to l_max = 0 in "), "{text}");
    assert!(text.contains(" with 1 thread\n"), "{text}");
}

/// The light of the sky, to degree 1, with another mean.
fn changed(folder: &tempfile::TempDir, name: &str, mean: [f64; 3]) {
    let json = ondine(folder, "sh project sky.exr --bands 1").stdout;
    let mut light: serde_json::Value = serde_json::from_str(&json).unwrap();
    light["coefficients"][0] = mean.to_vec().into();
    std::fs::write(folder.path().join(name), light.to_string()).unwrap();
}

#[test]
fn light_under_which_images_would_overflow_is_refused() {
    let folder = folder();
    sky(&folder, "sky.exr");
    changed(&folder, "huge.json", [1e300, 0.0, 0.0]);
    changed(&folder, "large.json", [4e9, 0.0, 0.0]);
    write_sky(&folder.path().join("max.exr"), (16, 8), |_, _| Some(3e38));
    let too_large = |file: &'static str, value: &'static str| {
        [file, value, "2^32 is the greatest", "another unit"]
    };
    let shade = |light: &str| format!("sh shade --size 8x8 --bsdf lambert --light {light}");
    let huge = too_large("huge.json: has a coefficient of", "1e300");
    refuses(&folder, &shade("huge.json"), &huge);
    let max = too_large("max.exr: has a coefficient of", "e39");
    refuses(&folder, &shade("max.exr"), &max);
    refuses(&folder, "sh project max.exr --bands 2 -o a.json", &max);
    assert_eq!(ondine(&folder, &shade("large.json")).code, 0);
    let picture = blue(&folder.path().join("shade.exr"));
    assert!(picture.iter().all(|blue| blue.is_finite()));
}

#[test]
fn what_cannot_be_shaded_is_refused() {
    let folder = folder();
    sky(&folder, "sky.exr");
    let convolved = "sh project sky.exr --bands 2 --lobe cosine -o cosine.json";
    assert_eq!(ondine(&folder, convolved).code, 0);
    let right = ondine(&folder, "sh project sky.exr --bands 1").stdout;
    let wrong = right.replace("\"l_max\": 1", "\"l_max\": 2");
    std::fs::write(folder.path().join("count.json"), wrong).unwrap();
    std::fs::write(folder.path().join("cut.json"), &right[..100]).unwrap();
    let grid = "sh probe cornell --grid 0,0,0:0,0,1:1,1,2 --spp 16 -o grid.json";
    assert_eq!(ondine(&folder, grid).code, 0);
    let cases: &[(&str, &[&str])] = &[
        (
            "--light grid.json --bsdf lambert",
            &["grid.json: holds a grid of probes", "--at x,y,z"],
        ),
        (
            "--light gracee --bsdf lambert",
            &["\"gracee\"", "grace, eucalyptus"],
        ),
        ("--light grace --bsdf phong", &["--bsdf", "phong:N"]),
        (
            "--light grace --bsdf lambert --bands 3",
            &["degree 2", "--bands 2"],
        ),
        (
            "--light grace --bsdf lambert --albedo 2",
            &["--albedo", "0 to 1"],
        ),
        (
            "--light grace --bsdf lambert --size 0x4",
            &["0x4", "1 to 65535"],
        ),
        (
            "--light grace --bsdf lambert --size 65535x65535",
            &["at most"],
        ),
        (
            "--light grace --bsdf lambert --shape cub",
            &["cub", "built-in"],
        ),
        ("--light grace --bsdf lambert -o a.png", &["use -o a.exr"]),
        (
            "--light sky.exr --bsdf lambert -o sky.exr",
            &["sky.exr: this file is read"],
        ),
        (
            "--light cosine.json --bsdf lambert",
            &["convolved with cosine"],
        ),
        (
            "--light count.json --bsdf lambert",
            &["count.json", "4 rows", "needs 9"],
        ),
        ("--light cut.json --bsdf lambert", &["cut.json:3:"]),
    ];
    for (arguments, words) in cases {
        refuses(&folder, &format!("sh shade {arguments}"), words);
    }
}

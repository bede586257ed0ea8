//! `ondine sh`.

use super::refusals::refuses;
use crate::{folder, ondine};
use serde_json::Value;
use std::path::Path;

/// A NumPy file with this header and these numbers.
fn npy(path: &Path, dtype: &str, shape: &str, bytes: &[u8]) {
    let header = format!("{{'descr': '{dtype}', 'fortran_order': False, 'shape': {shape}, }}\n");
    let mut file = b"\x93NUMPY\x01\x00".to_vec();
    file.extend((header.len() as u16).to_le_bytes());
    file.extend(header.as_bytes());
    file.extend(bytes);
    std::fs::write(path, file).unwrap();
}

fn bytes(numbers: &[f32]) -> Vec<u8> {
    numbers
        .iter()
        .flat_map(|number| number.to_le_bytes())
        .collect()
}

/// `count` unit directions, on a spiral.
fn spiral(count: usize) -> Vec<f32> {
    (0..count)
        .flat_map(|i| {
            let z = 1.0 - (2 * i + 1) as f64 / count as f64;
            let (r, (sin, cos)) = ((1.0 - z * z).sqrt(), (2.4 * i as f64).sin_cos());
            [r * cos, r * sin, z].map(|c| c as f32)
        })
        .collect()
}

#[test]
fn the_basis_is_written_for_numpy_with_the_same_bits_for_any_threads() {
    let folder = folder();
    npy(
        &folder.path().join("d.npy"),
        "<f4",
        "(5000, 3)",
        &bytes(&spiral(5000)),
    );
    let written = |threads: usize| {
        let line = format!(
            "sh basis d.npy --bands 5 -o v{threads}.npy --threads {threads} --repeat 1 --json"
        );
        let json = ondine(&folder, &line).json();
        assert_eq!(json["l_max"], 5);
        assert_eq!(json["coefficients"], 36);
        assert_eq!(json["points"], 5000);
        assert!(json["points_per_s"].as_f64().unwrap() > 1000.0);
        std::fs::read(folder.path().join(format!("v{threads}.npy"))).unwrap()
    };
    let one = written(1);
    let (header, values) = one.split_at(one.len() - 5000 * 36 * 4);
    assert_eq!(header.len() % 64, 0);
    assert!(
        String::from_utf8_lossy(header)
            .contains("'<f4', 'fortran_order': False, 'shape': (5000, 36)")
    );
    let first: [u8; 4] = values[..4].try_into().unwrap();
    assert!((f32::from_le_bytes(first) - 0.282_094_8).abs() < 1e-7);
    assert_eq!(one, written(2));
    assert_eq!(one, written(7));
    let text = ondine(&folder, "sh basis d.npy --bands 5 --threads 1 --repeat 1").stdout;
    assert!(
        text.contains("5000 directions, 36 values each (l_max 5)"),
        "{text}"
    );
}

#[test]
fn directions_in_64_bits_are_taken_and_nearly_unit_ones_are_made_unit() {
    let folder = folder();
    let near: Vec<u8> = [0.0, 0.0006, -1.0004_f64]
        .iter()
        .flat_map(|c| c.to_le_bytes())
        .collect();
    npy(&folder.path().join("d.npy"), "<f8", "(1, 3)", &near);
    assert_eq!(ondine(&folder, "sh basis d.npy --bands 1 -o v.npy").code, 0);
    let file = std::fs::read(folder.path().join("v.npy")).unwrap();
    let (values, _) = file[file.len() - 16..].as_chunks::<4>();
    let [_, y, z, x] = [0, 1, 2, 3].map(|k| f32::from_le_bytes(values[k]));
    assert!((x.hypot(y).hypot(z) - 0.488_602_5).abs() < 1e-6);
}

#[test]
fn directions_that_are_none_are_refused_with_their_row() {
    let folder = folder();
    let write = |dtype: &str, shape: &str, bytes: &[u8]| {
        npy(&folder.path().join("d.npy"), dtype, shape, bytes)
    };
    let line = "sh basis d.npy --bands 2 -o v.npy";
    let mut numbers = spiral(4);
    for (bad, word) in [
        (f32::NAN, "NaN"),
        (f32::INFINITY, "inf"),
        (0.0, "length"),
        (2.0, "length"),
    ] {
        numbers[6..9].fill(bad);
        write("<f4", "(4, 3)", &bytes(&numbers));
        refuses(&folder, line, &["d.npy: row 2", word, "length 1"]);
    }
    let good = bytes(&spiral(4));
    for (dtype, shape, words) in [
        ("<f4", "(3, 4)", "(3, 4)"),
        ("<f4", "(12,)", "(12,)"),
        ("<f4", "(2, 2, 3)", "(2, 2, 3)"),
        ("<f4", "(-4, 3)", "(-4, 3)"),
        ("<f4", "(99999999999999999999, 3)", "[n, 3]"),
        ("<i4", "(4, 3)", "<i4"),
        (">f4", "(4, 3)", ">f4"),
        ("<c8", "(4, 3)", "<c8"),
        ("<f4", "(18446744073709551615, 3)", "ends in row 4"),
        ("<f4", "(5, 3)", "ends in row 4 of 5"),
        ("<f8", "(4, 3)", "ends in row 2 of 4"),
        ("<f4", "(3, 3)", "goes on after its last number"),
        ("é", "é", "holds"),
        (&"(".repeat(3000), "(4, 3)", "numpy.save"),
        (&" ".repeat(6000), "(4, 3)", "header of"),
    ] {
        write(dtype, shape, &good);
        refuses(&folder, line, &["d.npy: ", words]);
    }
    write("<f4", "(0, 3)", &[]);
    refuses(&folder, line, &["d.npy: holds no directions"]);
    let path = folder.path().join("d.npy");
    for file in [
        &b""[..],
        b"\x93NUMPY",
        b"\x93NUMPY\x01\x00\x76",
        b"\x93NUMPY\x01\x00\x76\x00{'descr'",
        b"\x93NUMPY\x02\x00\xff\xff\xff\xff{",
        b"P6 3 3 255 and so on",
    ] {
        std::fs::write(&path, file).unwrap();
        refuses(&folder, line, &["d.npy: ", "numpy.save"]);
    }
    refuses(
        &folder,
        "sh basis none.npy --bands 2",
        &["none.npy: cannot read"],
    );
    refuses(&folder, "sh basis . --bands 2", &["cannot read"]);
}

#[test]
fn arguments_of_the_basis_out_of_their_range_are_refused() {
    let folder = folder();
    npy(
        &folder.path().join("d.npy"),
        "<f4",
        "(4, 3)",
        &bytes(&spiral(4)),
    );
    let cases: &[(&str, &[&str])] = &[
        ("", &["--bands"]),
        ("--bands 129", &["--bands", "0 to 128"]),
        ("--bands -1", &["--bands", "0 to 128"]),
        ("--bands x", &["--bands", "0 to 128"]),
        ("--bands 2 --threads 0", &["--threads", "1 to 1024"]),
        ("--bands 2 --repeat 0", &["--repeat", "1 to"]),
        ("--bands 2 -o missing/v.npy", &["missing/v.npy", "mkdir"]),
        ("--bands 2 -o .", &["folder"]),
        (
            "--bands 2 -o d.npy",
            &["d.npy: this file is read", "another"],
        ),
        ("--bands 2 -o ./d.npy", &["d.npy: this file is read"]),
    ];
    for (arguments, words) in cases {
        refuses(&folder, &format!("sh basis d.npy {arguments}"), words);
    }
    let directions = std::fs::read(folder.path().join("d.npy")).unwrap();
    assert!(directions.ends_with(&bytes(&spiral(4))));
    // What cannot be written is known before the work.
    let line = "sh basis none.npy --bands 2 -o missing/v.npy";
    refuses(&folder, line, &["mkdir -p missing"]);
}

fn numbers(value: &Value) -> Vec<f64> {
    let list = value
        .as_array()
        .unwrap_or_else(|| panic!("{value} is no list"));
    list.iter().map(|number| number.as_f64().unwrap()).collect()
}

#[test]
fn lobes_are_exact_and_estimated_with_the_same_bits_for_any_threads() {
    let folder = folder();
    let line = "sh lobe --exponent 1,5 --bands 6 --estimate 30000 --seed 4 --json --threads";
    let json = ondine(&folder, &format!("{line} 1")).json();
    assert_eq!(json["l_max"], 6);
    for lobe in json["lobes"].as_array().unwrap() {
        let exact = numbers(&lobe["exact"]);
        assert!((exact[0] - 0.886_226_925_452_758).abs() < 1e-15);
        let estimates = lobe["estimates"].as_array().unwrap();
        let names: Vec<_> = estimates
            .iter()
            .map(|estimate| &estimate["sampling"])
            .collect();
        assert_eq!(names, ["uniform", "stratified", "cosine-power"]);
        for estimate in estimates {
            assert!((28_000..=30_000).contains(&estimate["samples"].as_u64().unwrap()));
            let errors = numbers(&estimate["standard_errors"]);
            for ((value, exact), error) in
                numbers(&estimate["values"]).iter().zip(&exact).zip(errors)
            {
                assert!((value - exact).abs() <= 4.0 * error + 1e-7, "{estimate}");
            }
        }
        assert!(
            estimates[2]["z"][0].is_null(),
            "degree 0 has no variance: {lobe}"
        );
    }
    assert_eq!(ondine(&folder, &format!("{line} 2")).json(), json);
    assert_eq!(ondine(&folder, &format!("{line} 5")).json(), json);
}

#[test]
fn z_scores_of_a_hundred_seeds_are_standard_normal() {
    const SEEDS: u32 = 100;
    let folder = folder();
    let mut squares = std::collections::BTreeMap::<String, [f64; 3]>::new();
    for seed in 0..SEEDS {
        let line = format!(
            "sh lobe --exponent 5 --bands 3 --estimate 8000 --seed {seed} --json --threads 1"
        );
        for estimate in ondine(&folder, &line).json()["lobes"][0]["estimates"]
            .as_array()
            .unwrap()
        {
            let name = estimate["sampling"].as_str().unwrap().to_owned();
            let sums = squares.entry(name).or_default();
            for (sum, z) in sums.iter_mut().zip(&estimate["z"].as_array().unwrap()[1..]) {
                *sum += z.as_f64().unwrap().powi(2);
            }
        }
    }
    assert_eq!(squares.len(), 3);
    for (name, sums) in squares {
        for sum in sums {
            // χ² with 100 degrees of freedom is outside with probability 0.001 (59.0 has p = 0.9996, 149.4 has 0.0010).
            assert!((59.0..149.4).contains(&sum), "{name}: {sum}");
        }
    }
}

/// Of z-scores, which are standard normal: outside with probability 0.001 for each.
fn are_independent(a: &[f64], b: &[f64], what: &str) {
    let products = a.iter().zip(b).map(|(a, b)| a * b);
    let mean = products.sum::<f64>() / a.len() as f64;
    let most = 3.29 / (a.len() as f64).sqrt();
    assert!(mean.abs() < most, "{what}: correlation {mean}");
}

#[test]
fn estimates_of_other_exponents_samplings_sizes_and_seeds_are_independent() {
    const SEEDS: u64 = 60;
    let folder = folder();
    // Of degree 1.
    let z = |arguments: &str, seed: u64| -> Vec<f64> {
        let line = format!("sh lobe --bands 1 --json --seed {seed} {arguments}");
        let json = ondine(&folder, &line).json();
        let lobes = json["lobes"].as_array().unwrap().iter();
        let estimates = lobes.flat_map(|lobe| lobe["estimates"].as_array().unwrap());
        estimates
            .map(|made| made["z"][1].as_f64().unwrap())
            .collect()
    };
    let many = "--exponent 5,6 --estimate 8192 --sampling uniform,stratified";
    let small: Vec<_> = (0..SEEDS).map(|seed| z(many, seed)).collect();
    let of = |index: usize| small.iter().map(|z| z[index]).collect::<Vec<_>>();
    let five = of(0);
    are_independent(&five, &of(2), "exponents");
    are_independent(&five, &of(1), "samplings");
    are_independent(&five[1..], &five[..59], "seeds");

    // Sizes whose low bits are the same.
    let of = |size: u32| {
        let line = format!("--exponent 5 --sampling uniform --estimate {size}");
        let all = (0..SEEDS).map(|seed| z(&line, seed)[0]);
        all.collect::<Vec<_>>()
    };
    are_independent(&of(1 << 20), &of(1 << 21), "sizes");
}

#[test]
fn one_of_a_kind_is_said_in_the_singular() {
    let folder = folder();
    npy(
        &folder.path().join("d.npy"),
        "<f4",
        "(1, 3)",
        &bytes(&[0.0, 0.0, 1.0]),
    );
    let text = ondine(&folder, "sh basis d.npy --bands 0 --threads 1").stdout;
    assert!(
        text.starts_with("1 direction, 1 value each (l_max 0): "),
        "{text}"
    );
    assert!(text.contains(" with 1 thread ("), "{text}");
}

#[test]
fn the_report_is_shown_beside_what_it_should_have_said() {
    let folder = folder();
    let run = ondine(
        &folder,
        "sh lobe --exponent 1,5,10,50,2 --bands 6 --convention report --estimate 4000",
    );
    assert_eq!(run.code, 0, "{}", run.stderr);
    for word in [
        "|cos|", "POW 3", "2.506628", "2.475616", "1.023327", "sqrt(2)", "noise",
    ] {
        assert!(run.stdout.contains(word), "{}\nlacks {word}", run.stdout);
    }
    let json = ondine(
        &folder,
        "sh lobe --exponent 10 --bands 4 --convention report --estimate 200000 --json",
    )
    .json();
    let lobe = &json["lobes"][0];
    for (value, want) in numbers(&lobe["exact"])
        .iter()
        .zip([2.5066, 0.0, 4.3115, 0.0, 3.0851])
    {
        assert!((value - want).abs() < 5.1e-5, "{value} is not {want}");
    }
    assert_eq!(lobe["printed"][0]["name"], "POW 2");
    for estimate in lobe["estimates"].as_array().unwrap() {
        for z in estimate["z"].as_array().unwrap() {
            assert!(z.as_f64().is_none_or(|z| z.abs() < 4.0), "{estimate}");
        }
    }
}

#[test]
fn plots_are_written_of_coefficients_and_of_their_convergence() {
    let folder = folder();
    let line = "sh lobe --exponent 1,5 --bands 6 -o plot.svg --json";
    let svg = || std::fs::read_to_string(folder.path().join("plot.svg")).unwrap();
    ondine(&folder, line).json();
    assert!(svg().contains("n = 5") && svg().contains("degree l"));
    ondine(
        &folder,
        &format!("{line} --estimate 4096 --sampling uniform,cosine-power"),
    )
    .json();
    assert!(svg().contains("uniform: standard error") && svg().contains("10³"));
    assert!(!svg().contains("stratified"));
    // Lines of estimates are by sampling, however many exponents there are.
    let line = "sh lobe --exponent 1,2,3,4,5,6,7 --bands 2 -o plot.svg --estimate 256 --json";
    ondine(&folder, line).json();
    assert!(svg().contains("7 Phong lobes"));
}

#[test]
fn arguments_of_lobes_out_of_their_range_are_refused() {
    let folder = folder();
    let cases: &[(&str, &[&str])] = &[
        ("--bands 6", &["--exponent"]),
        ("--exponent 1", &["--bands"]),
        ("--exponent -1 --bands 6", &["--exponent", "0 to 1e6"]),
        ("--exponent 1,,2 --bands 6", &["--exponent", "0 to 1e6"]),
        ("--exponent nan --bands 6", &["--exponent", "0 to 1e6"]),
        ("--exponent inf --bands 6", &["--exponent", "0 to 1e6"]),
        ("--exponent 1e7 --bands 6", &["--exponent", "0 to 1e6"]),
        ("--exponent one --bands 6", &["--exponent", "0 to 1e6"]),
        ("--exponent 1 --bands 200", &["--bands", "0 to 128"]),
        (
            "--exponent 1 --bands 6 --estimate 3",
            &["--estimate", "16 to"],
        ),
        (
            "--exponent 1 --bands 6 --sampling unifrm",
            &["unifrm", "uniform"],
        ),
        (
            "--exponent 1 --bands 6 --convention other",
            &["orthonormal, report"],
        ),
        (
            "--exponent 1 --bands 6 -o missing/p.svg",
            &["mkdir -p missing"],
        ),
        (
            "--exponent 1 --bands 6 -o p.png",
            &["-o p.png: the plot is an SVG file; use -o p.svg"],
        ),
        ("--exponent 1 --bands 6 -o .", &["use -o ./plot.svg"]),
        (
            "--exponent 1,2,3,4,5,6,7 --bands 6 -o p.svg",
            &["-o p.svg: 7 lines", "at most 6 exponents"],
        ),
        (
            "--exponent 1 --bands 6 --threads 0",
            &["--threads", "1 to 1024"],
        ),
    ];
    for (arguments, words) in cases {
        refuses(&folder, &format!("sh lobe {arguments}"), words);
    }
}

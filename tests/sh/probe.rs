//! Files of coefficients.

use crate::common::{Random, mutations};
use crate::draws::random_coefficients;
use ondine::error::Result;
use ondine::sh::{CONVENTION, Lobe, MAX_DEGREE, PUBLISHED, Probe, published};
use std::path::Path;

fn probe(degree: usize) -> Probe {
    let mut probe = Probe::radiance(random_coefficients(&mut Random::new(7), degree)).unwrap();
    probe.coefficients[0] = [1e-300, -0.1, 123_456_789.123_456_79];
    probe
}

#[test]
fn what_is_written_and_read_again_has_the_same_bits() {
    let mut with_errors = probe(3).convolved(Lobe::Phong(12.5)).unwrap();
    with_errors.standard_errors = Some(vec![[0.1, 0.0, 1e-9]; 16]);
    with_errors.source = Some("a \"sky\", #1: é\\".to_owned());
    let cosine = probe(0).convolved(Lobe::Cosine).unwrap();
    for probe in [probe(0), probe(8), probe(MAX_DEGREE), with_errors, cosine] {
        let json = probe.to_json().unwrap();
        assert_eq!(Probe::from_json("a.json", &json).unwrap(), probe);
        let csv = probe.to_csv().unwrap();
        assert_eq!(Probe::from_csv("a.csv", &csv).unwrap(), probe);
        let windows = csv.replace('\n', "\r\n");
        assert_eq!(Probe::from_csv("a.csv", &windows).unwrap(), probe);
    }
}

#[test]
fn a_file_says_what_its_numbers_mean() {
    let json: serde_json::Value = serde_json::from_str(&probe(2).to_json().unwrap()).unwrap();
    assert_eq!(json["format"], "ondine-sh");
    assert_eq!(json["version"], 1);
    assert_eq!(json["convention"], CONVENTION);
    assert_eq!(json["quantity"], "radiance");
    assert_eq!(json["unit"], "W sr^-1 m^-2");
    assert_eq!(json["l_max"], 2);
    assert_eq!(json["coefficients"].as_array().unwrap().len(), 9);
    let cosine = probe(2).convolved(Lobe::Cosine).unwrap();
    let csv = cosine.to_csv().unwrap();
    assert!(csv.contains("# quantity: irradiance\n# unit: W m^-2\n# lobe: cosine\n"));
    assert!(csv.contains("\nl,m,r,g,b\n0,0,"));
}

#[track_caller]
fn refused(result: Result<Probe>, words: &[&str]) {
    let message = result.unwrap_err().to_string();
    assert_eq!(message.lines().count(), 1, "{message}");
    for word in words {
        assert!(message.contains(word), "{message}\nlacks {word:?}");
    }
}

#[test]
fn wrong_json_is_refused_with_place_and_remedy() {
    let right = probe(1).to_json().unwrap();
    let cases: &[(&str, &str, &[&str])] = &[
        (
            "\"ondine-sh\"",
            "\"other\"",
            &["format \"other\"", "ondine-sh"],
        ),
        (
            "\"version\": 1",
            "\"version\": 2",
            &["version 2", "version 1"],
        ),
        (
            "without the Condon",
            "with the Condon",
            &["convention", "convert"],
        ),
        (
            "\"radiance\"",
            "\"luminance\"",
            &["quantity \"luminance\"", "\"radiance\""],
        ),
        (
            "\"l_max\": 1",
            "\"l_max\": 2",
            &["4 rows", "needs 9", "l_max = 1"],
        ),
        ("\"l_max\": 1", "\"l_max\": 1000", &["1000", "at most 128"]),
        (
            "\"l_max\": 1",
            "\"l_max\": 18446744073709551615",
            &["at most 128"],
        ),
        ("\"l_max\": 1", "\"l_max\": -1", &["p.json:7:"]),
        (
            "  \"l_max\": 1,\n",
            "",
            &["p.json:", "missing field `l_max`"],
        ),
        ("1e-300", "1e999", &["p.json:9:", "out of range"]),
        ("1e-300", "NaN", &["p.json:9:"]),
        ("1e-300", "null", &["p.json:9:"]),
        ("1e-300, ", "", &["p.json:9:"]),
        (
            "    [1e-300, -0.1, 123456789.12345679],\n",
            "",
            &["3 rows", "not (l_max + 1)^2"],
        ),
        (
            "\"unit\"",
            "\"lobe\": \"square\", \"unit\"",
            &["\"square\"", "phong:N"],
        ),
        (
            "\"unit\"",
            "\"lobe\": \"phong:-1\", \"unit\"",
            &["0 to 1000000"],
        ),
        (
            "\"unit\"",
            "\"lobe\": \"cosine\", \"unit\"",
            &["\"radiance\" with lobe"],
        ),
    ];
    for (from, to, words) in cases {
        assert!(right.contains(from), "{from}");
        let wrong = right.replacen(from, to, 1);
        let words = [&["p.json"], *words].concat();
        refused(Probe::from_json("p.json", &wrong), &words);
    }
    let cut = &right[..right.len() / 2];
    let line = cut.lines().count();
    refused(
        Probe::from_json("p.json", cut),
        &[&format!("p.json:{line}:"), "EOF"],
    );
    refused(
        Probe::from_json("p.json", &"[".repeat(100_000)),
        &["p.json:1:"],
    );
}

#[test]
fn wrong_csv_is_refused_with_place_and_remedy() {
    let right = probe(1).to_csv().unwrap();
    let line = right
        .lines()
        .position(|line| line.starts_with("0,0,"))
        .unwrap()
        + 1;
    let first = format!("p.csv:{line}:");
    let second = format!("p.csv:{}:", line + 1);
    let header = format!("p.csv:{}:1", line - 1);
    let cases: &[(&str, &str, &[&str])] = &[
        ("# format: ondine-sh\n", "", &["format", "add a line"]),
        ("# version: 1", "# version: one", &["\"one\""]),
        ("# quantity: radiance", "# quantity: power", &["\"power\""]),
        ("l,m,r,g,b", "l,m,red,green,blue", &[&header, "l,m,r,g,b"]),
        ("1e-300", "x", &[&format!("{first}5"), "\"x\" is no number"]),
        ("1e-300", "nan", &["l = 0, m = 0", "red = NaN", "finite"]),
        ("1e-300", "inf", &["red = inf", "finite"]),
        ("1e-300,", "", &[&first, "as many values"]),
        ("\n1,-1,", "\n1,0,", &[&second, "l = 1, m = -1 comes next"]),
    ];
    for (from, to, words) in cases {
        assert!(right.contains(from), "{from}");
        let words = [&["p.csv"], *words].concat();
        refused(
            Probe::from_csv("p.csv", &right.replacen(from, to, 1)),
            &words,
        );
    }
    let last = right.trim_end().rfind('\n').unwrap();
    refused(
        Probe::from_csv("p.csv", &right[..=last]),
        &["ends before the row l = 1, m = 1", "leave all of them out"],
    );
    let header = right.find("0,0,").unwrap();
    refused(
        Probe::from_csv("p.csv", &right[..header]),
        &["ends before the row l = 0, m = 0"],
    );
    refused(Probe::from_csv("p.csv", ""), &["p.csv"]);
}

#[test]
fn an_empty_file_and_a_grid_are_refused_for_what_they_are() {
    refused(Probe::from_json("p.json", ""), &["p.json:1:1: ", "EOF"]);
    let grid = r#"{"format": "ondine-sh-grid", "version": 1, "probes": []}"#;
    refused(
        Probe::from_json("p.json", grid),
        &["p.json: holds a grid", "ondine sh probe SCENE --at x,y,z"],
    );
}

#[test]
fn damaged_files_are_refused_or_read_and_nothing_else() {
    let probe = probe(2);
    for (text, csv) in [(probe.to_json(), false), (probe.to_csv(), true)] {
        for damaged in mutations(11, text.unwrap().as_bytes(), 4000) {
            let text = String::from_utf8_lossy(&damaged);
            let read = match csv {
                true => Probe::from_csv("p", &text),
                false => Probe::from_json("p", &text),
            };
            if let Ok(probe) = read {
                assert_eq!(probe.coefficients.len(), (probe.degree + 1).pow(2));
                assert!(probe.coefficients.iter().flatten().all(|c| c.is_finite()));
            }
        }
    }
}

#[test]
fn what_cannot_be_read_again_is_not_written() {
    let mut wrong = probe(1);
    wrong.coefficients[2][1] = f64::NAN;
    let message = wrong.to_json().unwrap_err().to_string();
    assert!(
        message.contains("l = 1, m = 0 has green = NaN"),
        "{message}"
    );
    assert!(Probe::radiance(vec![[0.0; 3]; 5]).is_err());
    assert!(Probe::radiance(Vec::new()).is_err());
    let mut lines = probe(0);
    lines.source = Some("two\nlines".to_owned());
    assert!(lines.to_csv().is_err());
    assert!(lines.to_json().is_ok());
}

#[test]
fn a_file_that_is_not_there_or_no_text_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    refused(
        Probe::read(&folder.path().join("no.json")),
        &["no.json", "cannot read"],
    );
    let path = folder.path().join("image.json");
    std::fs::write(&path, [0x76, 0x2f, 0x31, 0x01, 0xff]).unwrap();
    refused(
        Probe::read(&path),
        &["image.json", "UTF-8", "ondine sh project"],
    );
    std::fs::write(&path, vec![b' '; (1 << 24) + 1]).unwrap();
    refused(Probe::read(&path), &["image.json", "16 MiB"]);
    let path = folder.path().join("right.CSV");
    std::fs::write(&path, probe(2).to_csv().unwrap()).unwrap();
    assert_eq!(Probe::read(&path).unwrap(), probe(2));
    let text = |path| probe(2).to_text(path).unwrap();
    assert_eq!(text(&path), probe(2).to_csv().unwrap());
    assert_eq!(text(Path::new("a.json")), probe(2).to_json().unwrap());
}

#[test]
fn published_probes_have_nine_coefficients_and_their_source() {
    for name in PUBLISHED {
        let probe = published(name).unwrap();
        assert_eq!((probe.degree, probe.coefficients.len()), (2, 9));
        assert!(
            probe
                .source
                .unwrap()
                .contains("Ramamoorthi & Hanrahan 2001")
        );
        // Light comes from above.
        assert!(probe.coefficients[1].iter().all(|&c| c > 0.0), "{name}");
    }
    assert_eq!(
        published("grace").unwrap().coefficients[8],
        [0.21205, -0.05432, -0.30374]
    );
    assert_eq!(published("Grace"), None);
}

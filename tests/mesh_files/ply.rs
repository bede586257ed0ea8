//! PLY: three encodings, one mesh.

use super::common::mutations;
use glam::{Vec2, Vec3};
use ondine::scene::ply::{Loaded, read};
use std::path::Path;

/// A square of a triangle and a quad, with normals, texture coordinates, and what is to be skipped.
const HEADER: &str = "comment a bent sheet
obj_info skipped
element camera 1
property list uchar short ids
property double focal
element vertex 5
property uchar red
property float x
property double y
property short z
property float nx
property float ny
property float nz
property float s
property float t
element face 2
property int material
property list uchar int vertex_indices
property list uint float weights
element edge 1
property int vertex1
end_header
";

fn ascii() -> Vec<u8> {
    let body = "2 7 -8 35.5
255 0 0 0 0 0 2 0 0
255 1 0 0 0 0 1 1 0
255 1 1 0 0 0 1 1 1
255 0 1 0 0 0 1 0 1
255 0.5 2 1 0 0 1 0.5 2
3 4 0 1 2 3 0
-1 3 3 2 4 2 0.5 1.5
9
";
    format!("ply\nformat ascii 1.0\n{HEADER}{body}").into_bytes()
}

/// A number of a record, written in either order of bytes.
#[derive(Clone, Copy)]
enum Word {
    Byte(u8),
    Short(i16),
    Int(i32),
    Float(f32),
    Double(f64),
}

fn binary(big: bool) -> Vec<u8> {
    use Word::{Byte, Double, Float, Int, Short};
    let mut words = vec![Byte(2), Short(7), Short(-8), Double(35.5)];
    for [x, y, z, length] in [
        [0.0, 0.0, 0.0, 2.0],
        [1.0, 0.0, 0.0, 1.0],
        [1.0, 1.0, 0.0, 1.0],
        [0.0, 1.0, 0.0, 1.0],
        [0.5, 2.0, 1.0, 1.0],
    ] {
        words.extend([Byte(255), Float(x), Double(y.into()), Short(z as i16)]);
        words.extend([Float(0.0), Float(0.0), Float(length), Float(x), Float(y)]);
    }
    words.extend([Int(3), Byte(4), Int(0), Int(1), Int(2), Int(3), Int(0)]);
    words.extend([Int(-1), Byte(3), Int(3), Int(2), Int(4)]);
    words.extend([Int(2), Float(0.5), Float(1.5), Int(9)]);
    let endian = if big { "big" } else { "little" };
    let mut bytes = format!("ply\nformat binary_{endian}_endian 1.0\n{HEADER}").into_bytes();
    for word in words {
        let mut little = match word {
            Byte(value) => vec![value],
            Short(value) => value.to_le_bytes().to_vec(),
            Int(value) => value.to_le_bytes().to_vec(),
            Float(value) => value.to_le_bytes().to_vec(),
            Double(value) => value.to_le_bytes().to_vec(),
        };
        if big {
            little.reverse();
        }
        bytes.extend(little);
    }
    bytes
}

fn load(bytes: &[u8]) -> Result<Loaded, String> {
    read(bytes, Path::new("a.ply")).map_err(|error| error.to_string())
}

#[track_caller]
fn refuses(bytes: &[u8], words: &str) {
    match load(bytes) {
        Ok(_) => panic!("read without complaint"),
        Err(message) => {
            assert!(message.starts_with("a.ply: "), "{message}");
            assert!(message.contains(words), "{message}\nlacks {words:?}");
            assert!(!message.contains('\n'), "{message:?} is not one line");
        }
    }
}

/// A triangle, in ascii, with one thing replaced.
#[track_caller]
fn refuses_triangle(from: &str, to: &str, words: &str) {
    let right = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        element face 1\nproperty list uchar int vertex_index\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    load(right.as_bytes()).expect("a triangle");
    assert!(right.contains(from), "{from:?} is not in the file");
    refuses(right.replacen(from, to, 1).as_bytes(), words);
}

#[test]
fn three_encodings_are_one_mesh() {
    for bytes in [ascii(), binary(false), binary(true)] {
        let Loaded { mesh, dropped } = load(&bytes).expect("a mesh");
        assert_eq!(dropped, 0);
        assert_eq!(mesh.name, "a.ply");
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]];
        let more = [[0.0, 1.0, 0.0], [0.5, 2.0, 1.0]];
        let positions: Vec<Vec3> = corners.into_iter().chain(more).map(Vec3::from).collect();
        assert_eq!(mesh.positions, positions);
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [3, 2, 4]]);
        assert_eq!(mesh.normals, [Vec3::Z; 5]);
        let uvs: Vec<Vec2> = positions.iter().map(|p| p.truncate()).collect();
        assert_eq!(mesh.uvs, uvs);
    }
}

#[test]
fn a_triangle_without_an_area_is_left_out_and_counted() {
    let mut text = String::from_utf8(ascii()).expect("text");
    text = text.replace("-1 3 3 2 4 2", "-1 3 3 2 2 2");
    let loaded = load(text.as_bytes()).expect("a mesh");
    assert_eq!((loaded.mesh.triangles.len(), loaded.dropped), (2, 1));
}

#[test]
fn a_truncated_file_is_refused_wherever_it_ends() {
    for whole in [ascii(), binary(false), binary(true)] {
        for end in 0..whole.len() - 1 {
            let message = load(&whole[..end]).expect_err("half a file");
            assert!(message.starts_with("a.ply: "), "{message}");
        }
    }
    let whole = binary(false);
    refuses(
        &whole[..whole.len() - 50],
        "face 0 of 2 (counted from 0): the file ends here; it is truncated",
    );
}

#[test]
fn refusals_name_the_place() {
    refuses_triangle("ply", "plx", "line 1: this is not the header");
    refuses_triangle("element face 1", "elephant 1", "line 7: ");
    refuses_triangle("1 0 0", "1 zero 0", "line 11: vertex 1 of 3");
    refuses_triangle("1 0 0", "1 0", "line 11: vertex 1 of 3");
    refuses_triangle("1 0 0", "1e39 0 0", "vertex 1 is at (inf, 0, 0)");
    refuses_triangle("1 0 0", "nan 0 0", "line 11: vertex 1 of 3");
    refuses_triangle(
        "3 0 1 2",
        "3 0 1 3",
        "line 13: face 0 of 1 (counted from 0): it has corner 3, and there are 3 vertices",
    );
    refuses_triangle("3 0 1 2", "3 0 1 -2", "it has a corner below 0");
    refuses_triangle("3 0 1 2", "3 0 1", "line 13: face 0 of 1");
    refuses_triangle(
        "3 0 1 2\n",
        "",
        "line 13: face 0 of 1 (counted from 0): the file ends here",
    );
    refuses_triangle("3 0 1 2", "3 0 1 1", "no triangle with an area");
    refuses_triangle("3 0 1 2", "2 0 1", "no triangle with an area");
    refuses_triangle("float x", "float a", "no properties x, y and z");
    refuses_triangle("uchar int", "uchar float", "not whole numbers");
    refuses_triangle("vertex_index", "corners", "no list vertex_indices");
    refuses_triangle("element face", "element tristrips", "export faces");
}

#[test]
fn nothing_is_allocated_by_what_a_header_says() {
    refuses_triangle(
        "vertex 3",
        "vertex 1099511627776",
        "announces 1099511627776 vertices",
    );
    refuses_triangle(
        "vertex 3",
        "vertex 4000000000",
        "line 14: vertex 4 of 4000000000",
    );
    refuses_triangle("face 1", "face 1099511627776", "face 1 of 1099511627776");
    refuses_triangle("vertex 3", "vertex 99999999999999999999", "line 3: ");
    refuses_triangle("3 0 1 2", "4294967295 0 1 2", "line 13: face 0 of 1");
    // Elements without a byte in any number.
    let endless = binary(false);
    let text = String::from_utf8_lossy(&endless);
    let at = text.find("element edge").expect("edges");
    let mut bytes = endless[..at].to_vec();
    bytes.extend(b"element nothing 18446744073709551615\n");
    bytes.extend(&endless[at..]);
    load(&bytes).expect("a mesh, at once");
}

#[test]
fn a_damaged_file_is_refused_or_read_and_never_a_panic() {
    let (mut read, mut refused) = (0, 0);
    for (seed, whole) in [ascii(), binary(false), binary(true)].iter().enumerate() {
        for bytes in mutations(seed as u64, whole, 5000) {
            match load(&bytes) {
                Ok(_) => read += 1,
                Err(message) => {
                    assert!(!message.contains('\n'), "{message:?}");
                    refused += 1;
                }
            }
        }
    }
    assert!(
        read > 500 && refused > 1000,
        "{read} read, {refused} refused"
    );
}

//! Where shapes are put.

use super::*;
use glam::Vec3;

fn near(a: Vec3, b: Vec3) -> bool {
    (a - b).length() < 1e-6
}

fn put(shape: &str, transform: &str) -> Shape {
    let text = format!("{shape}\ntransform = {transform}");
    accepts("sphere = { center = [0, 0, 0], radius = 1 }", &text).objects[0].shape
}

const SPHERE: &str = "sphere = { center = [1, 0, 0], radius = 2 }";
const QUAD: &str = "quad = { corner = [0, 0, 0], u = [1, 0, 0], v = [0, 2, 0] }";

#[test]
fn a_shape_is_scaled_then_turned_about_x_y_z_then_moved() {
    let shape = put(
        SPHERE,
        "{ translate = [0, 0, 5], rotate_degrees = [90, 90, 0], scale = 3 }",
    );
    // (3, 0, 0) stays on the x axis, then turns to −z.
    let Shape::Sphere { center, radius } = shape else {
        panic!("{shape:?}");
    };
    assert!(near(center, Vec3::new(0.0, 0.0, 2.0)), "{center}");
    assert_eq!(radius, 6.0);

    let shape = put(QUAD, "{ rotate_degrees = [90, 0, 90], scale = [1, 2, 1] }");
    let Shape::Quad { u, v, .. } = shape else {
        panic!("{shape:?}");
    };
    // Exact, as they are multiples of 90 degrees.
    assert_eq!((u, v), (Vec3::Y, Vec3::new(0.0, 0.0, 4.0)));
}

#[test]
fn a_mirrored_quad_keeps_its_normal_on_its_side() {
    let shape = put(QUAD, "{ scale = [-1, 1, 1] }");
    let Shape::Quad { u, v, .. } = shape else {
        panic!("{shape:?}");
    };
    assert_eq!(u.cross(v).normalize(), Vec3::Z);
}

#[test]
fn a_transform_that_cannot_be_is_refused() {
    let refuses = |transform: &str, place: &str, words: &[&str]| {
        let text = format!("{SPHERE}\ntransform = {transform}");
        refuses(
            "sphere = { center = [0, 0, 0], radius = 1 }",
            &text,
            place,
            words,
        );
    };
    refuses("{ scale = [1, 2, 1] }", "11:13", &["write scale = s"]);
    refuses("{ scale = 0 }", "11:23", &["flattens the shape"]);
    refuses(
        "{ scale = 1e9, translate = [1e9, 0, 0] }",
        "11:13",
        &["beyond coordinates of ±1e9"],
    );
    refuses(
        "{ rotate = [0, 0, 0] }",
        "11:15",
        &["did you mean \"rotate_degrees\"?"],
    );
    refuses("[0, 0, 0]", "11:13", &["a table, as in transform = {"]);
}

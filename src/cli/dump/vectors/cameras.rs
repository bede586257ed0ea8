//! Camera rays.

use super::page::{Case, Section, Topic};
use super::{PAIRS, pair, vector, wide};
use crate::scene::camera::Camera;
use crate::scene::description::{self, Filter};
use glam::Vec3;

const WIDTH: u32 = 320;
const HEIGHT: u32 = 240;

/// Columns and rows: corners, the middle.
const PIXELS: [[u32; 2]; 4] = [[0, 0], [319, 0], [160, 120], [17, 239]];

const LENS: [f32; 2] = [0.25, 0.875];

pub(super) fn topic() -> Topic {
    let pinhole = description::Camera {
        position: Vec3::new(0.5, 1.0, 3.0),
        look_at: Vec3::new(-0.25, 0.5, -1.0),
        up: Vec3::Y,
        vertical_fov: 50.0,
        aperture_radius: 0.0,
        focus_distance: 3.25,
    };
    let thin_lens = description::Camera {
        aperture_radius: 0.125,
        ..pinhole
    };
    Topic {
        name: "cameras",
        about: "Camera rays: specification, section 6. All are of an image of 320 x 240 pixels, seen by a camera at (0.5, 1, 3) \
                that looks at (-0.25, 0.5, -1) with +y up, a vertical field of 50 degrees and a focus distance of 3.25. u is \
                the pair of the pixel filter, v that of the lens.",
        sections: vec![
            section("box", "A pinhole, box filter.", &pinhole, Filter::Box),
            section("tent", "A pinhole, tent filter.", &pinhole, Filter::Tent),
            section(
                "gaussian",
                "A pinhole, Gaussian filter.",
                &pinhole,
                Filter::Gaussian,
            ),
            section(
                "lens",
                "A lens of radius 0.125, box filter.",
                &thin_lens,
                Filter::Box,
            ),
        ],
    }
}

fn section(
    name: &'static str,
    about: &'static str,
    camera: &description::Camera,
    filter: Filter,
) -> Section {
    let camera = Camera::new(camera, WIDTH, HEIGHT, filter);
    let cases = PIXELS
        .into_iter()
        .flat_map(|pixel| PAIRS[1..6].iter().map(move |&u| (pixel, u)));
    let case = |(pixel, u): ([u32; 2], [f32; 2])| {
        let [x, y] = pixel.map(|n| wide(n as f32));
        let (origin, direction) = camera.rays(x, y, pair(u), pair(LENS));
        Case::new()
            .whole("column", pixel[0])
            .whole("row", pixel[1])
            .floats("u", &u)
            .floats("v", &LENS)
            .floats("origin", &vector(origin))
            .floats("direction", &vector(direction))
    };
    Section::new(name, about, cases.map(case).collect())
}

//! Cameras, film, sampler, integrator, filter.

use super::*;
use glam::Vec3;
use ondine::lanes::{Vec3x8, f32x8};
use ondine::scene::camera::Camera;
use ondine::scene::description::Filter;

/// Where the middle of the only object, or of its mesh, is in the image: −1 to 1, right and up.
#[track_caller]
fn seen_at(scene: &Description) -> (f32, f32) {
    let [object] = scene.objects.as_slice() else {
        panic!("one object");
    };
    let middle = match object.shape {
        Shape::Sphere { center, .. } => center,
        Shape::Quad { corner, u, v } => corner + 0.5 * (u + v),
        Shape::Mesh { transform, .. } => transform.translation.into(),
    };
    let (width, height) = (scene.film.width, scene.film.height);
    let camera = Camera::new(&scene.cameras[0].camera, width, height, Filter::Box);
    let ray = |x: f32, y: f32| {
        let half = f32x8::splat(0.5);
        let (_, direction) =
            camera.rays(f32x8::splat(x), f32x8::splat(y), (half, half), (half, half));
        let Vec3x8 { x, y, z } = direction;
        Vec3::new(x.to_array()[0], y.to_array()[0], z.to_array()[0])
    };
    let (w, h) = (width as f32 - 1.0, height as f32 - 1.0);
    let forward = ray(w / 2.0, h / 2.0);
    let onto_plane = |d: Vec3| d / d.dot(forward);
    let right = onto_plane(ray(w, h / 2.0)) - forward;
    let up = onto_plane(ray(w / 2.0, 0.0)) - forward;
    let at = onto_plane(middle - scene.cameras[0].camera.position) - forward;
    (
        at.dot(right) / right.length_squared(),
        at.dot(up) / up.length_squared(),
    )
}

/// By the definition: the point in camera space, +x right, +y up, +z forward, over its depth.
#[test]
fn what_pbrt_shows_on_the_right_is_on_the_right() {
    // No transformation: camera space is the world.
    let scene = read_whole(
        "Film \"rgb\" \"integer xresolution\" 101 \"integer yresolution\" 101\n\
         Camera \"perspective\" \"float fov\" 90\nWorldBegin\n\
         Translate 1 0.5 2\nShape \"sphere\" \"float radius\" .1",
    );
    let (right, up) = seen_at(&scene);
    close([right, up], [0.505, 0.2525]);
}

#[test]
fn mirrored_or_not_the_image_is_that_of_pbrts_camera_space() {
    for (transformation, to_camera) in [
        (
            "LookAt 1 2 3  0 0 0  0 1 0",
            // PBR 4th ed., sec. 3.9.4: right = up × dir in a left-handed world.
            look_at([1.0, 2.0, 3.0], [0.0; 3], [0.0, 1.0, 0.0], 1.0),
        ),
        (
            "Scale -1 1 1 LookAt 1 2 3  0 0 0  0 1 0",
            look_at([1.0, 2.0, 3.0], [0.0; 3], [0.0, 1.0, 0.0], -1.0),
        ),
    ] {
        let scene = read_whole(&format!(
            "Film \"rgb\" \"integer xresolution\" 301 \"integer yresolution\" 201\n\
             {transformation}\nCamera \"perspective\" \"float fov\" 60\nWorldBegin\n\
             Translate 0.3 0.4 -0.2\nShape \"sphere\" \"float radius\" .1"
        ));
        let [x, y, z] = to_camera([0.3, 0.4, -0.2]);
        let tan = 30f32.to_radians().tan();
        let expected = [x / z / (tan * 301.0 / 201.0), y / z / tan];
        let (right, up) = seen_at(&scene);
        // `seen_at` takes the middle of the outermost pixels for the edge.
        close([right * 300.0 / 301.0, up * 200.0 / 201.0], expected);
        let Shape::Sphere { center, .. } = scene.objects[0].shape else {
            panic!("a sphere");
        };
        // Where the transformation mirrors, the file's coordinates are kept.
        assert_eq!(center.x > 0.0, transformation.starts_with("Scale"));
    }
}

fn look_at(eye: [f32; 3], at: [f32; 3], up: [f32; 3], sign: f32) -> impl Fn([f32; 3]) -> [f32; 3] {
    let (eye, at, up) = (Vec3::from(eye), Vec3::from(at), Vec3::from(up));
    let forward = (at - eye).normalize();
    let right = up.cross(forward).normalize();
    let up = forward.cross(right);
    move |point| {
        let d = Vec3::from(point) - eye;
        [sign * d.dot(right), d.dot(up), d.dot(forward)]
    }
}

#[test]
fn a_field_of_view_is_that_of_the_shorter_side() {
    let fov = |film: &str, more: &str| {
        read(&format!(
            "Film \"rgb\" {film}\nCamera \"perspective\" \"float fov\" 40 {more}\nWorldBegin"
        ))
        .cameras[0]
            .camera
            .vertical_fov
    };
    let wide = "\"integer xresolution\" 200 \"integer yresolution\" 100";
    let high = "\"integer xresolution\" 100 \"integer yresolution\" 200";
    let vertical = |half: f32| 2.0 * (20f32.to_radians().tan() * half).atan().to_degrees();
    close([fov(wide, ""), fov(high, "")], [40.0, vertical(2.0)]);
    close(
        [fov(wide, "\"float screenwindow\" [-1 1 -.5 .5]")],
        [vertical(0.5)],
    );
}

#[test]
fn a_lens_is_in_units_of_the_world() {
    let scene = read_whole(
        "Scale .5 .5 .5 LookAt 0 0 -4 0 0 0 0 1 0\n\
         Camera \"perspective\" \"float lensradius\" .1 \"float focaldistance\" 3\nWorldBegin",
    );
    let camera = scene.cameras[0].camera;
    close(
        [
            camera.aperture_radius,
            camera.focus_distance,
            camera.vertical_fov,
        ],
        [0.2, 6.0, 90.0],
    );
    close(camera.position.to_array(), [0.0, 0.0, -4.0]);
    assert!(camera.look_at.z > -4.0);
}

#[test]
fn film_sampler_integrator_and_filter_set_the_defaults() {
    let scene = read_whole(
        "Film \"rgb\" \"integer xresolution\" [ 30 ] \"integer yresolution\" [ 20 ] \"string filename\" \"a.exr\"\n\
         Sampler \"halton\" \"integer pixelsamples\" 12\nIntegrator \"volpath\" \"integer maxdepth\" 7\n\
         PixelFilter \"triangle\" \"float xradius\" 1 \"float yradius\" 1\nWorldBegin",
    );
    assert_eq!(
        (scene.film.width, scene.film.height, scene.film.filter),
        (30, 20, Filter::Tent)
    );
    assert_eq!(
        (scene.render.spp, scene.render.path_length),
        (Some(12), Some(8))
    );
    let bare = read_whole("WorldBegin");
    assert_eq!(
        (bare.film.width, bare.film.height, bare.film.filter),
        (1280, 720, Filter::Gaussian)
    );
    assert_eq!((bare.render.spp, bare.render.path_length), (None, Some(6)));
}

#[test]
fn what_a_camera_or_filter_cannot_do_is_told() {
    let scene = read(
        "Camera \"orthographic\"\nPixelFilter \"mitchell\"\nFilm \"rgb\" \"float iso\" 200 \"string sensor\" \"canon_eos_5d\"\nWorldBegin",
    );
    assert_eq!(
        scene.warnings,
        [
            "a.pbrt:2:1: the pixel filter \"mitchell\" of this size is not supported; the image is filtered by gaussian",
            "a.pbrt:3:1: the film's sensor, iso is not used: pixels are radiance, and the PNG has --exposure",
            "a.pbrt:1:1: the camera \"orthographic\" is not supported; a perspective one stands in its place",
        ]
    );
}

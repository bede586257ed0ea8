//! Lights, and what they shine with.

use super::*;
use glam::Vec3;
use ondine::scene::description::{Environment, LatLong, Punctual};
use std::f32::consts::PI;

#[track_caller]
fn punctual(text: &str) -> Punctual {
    let scene = read_whole(&format!("WorldBegin {text}"));
    let [light] = scene.punctual.as_slice() else {
        panic!("one light");
    };
    assert!(scene.environment.is_none());
    *light
}

#[test]
fn area_lights_shine_with_l_times_scale() {
    let scene = read_whole(
        "WorldBegin AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [1 2 3] \"float scale\" 2 \"bool twosided\" true\n\
         Shape \"sphere\" AttributeEnd Shape \"sphere\"",
    );
    assert_eq!((scene.lights.len(), scene.objects.len()), (1, 1));
    let light = &scene.lights[0];
    assert_eq!(light.radiance.to_array(), [2.0, 4.0, 6.0]);
    assert!(light.two_sided);
    assert_eq!(light.material, Some(scene.objects[0].material));
}

#[test]
fn a_reversed_sphere_emits_inwards() {
    let scene =
        read_whole("WorldBegin AreaLightSource \"diffuse\" ReverseOrientation Shape \"sphere\"");
    let Shape::Mesh { mesh, .. } = scene.lights[0].shape else {
        panic!("a mesh");
    };
    let mesh = &scene.meshes[mesh];
    let [a, b, c] = mesh.triangles[1000].map(|corner| mesh.positions[corner as usize]);
    assert!((b - a).cross(c - a).dot(a) < 0.0);
}

#[test]
fn point_spot_and_distant_lights_stand_where_their_transformation_puts_them() {
    assert_eq!(
        punctual(
            "Translate 0 0 1 LightSource \"point\" \"rgb I\" [1 2 3] \"point3 from\" [1 0 0] \"float scale\" 2"
        ),
        Punctual::Point {
            position: Vec3::new(1., 0., 1.),
            intensity: Rgb::new(2., 4., 6.)
        }
    );
    assert_eq!(
        punctual(
            "Rotate 90 0 1 0 LightSource \"distant\" \"rgb L\" [1 1 2] \"point3 from\" [0 5 0] \"point3 to\" [0 0 0]"
        ),
        Punctual::Distant {
            direction: Vec3::NEG_Y,
            irradiance: Rgb::new(1., 1., 2.)
        }
    );
    let Punctual::Spot {
        position,
        direction,
        intensity,
        cos_inner,
        cos_outer,
    } = punctual(
        "LightSource \"spot\" \"float coneangle\" 60 \"float conedeltaangle\" 15 \"point3 from\" [0 1 0] \"point3 to\" [0 0 0]",
    )
    else {
        panic!("a spot");
    };
    assert_eq!(
        (position, direction, intensity),
        (Vec3::Y, Vec3::NEG_Y, Rgb::WHITE)
    );
    close([cos_inner, cos_outer], [0.5f32.sqrt(), 0.5]);
}

#[test]
fn power_and_illuminance_set_the_scale() {
    let Punctual::Point { intensity, .. } = punctual("LightSource \"point\" \"float power\" 100")
    else {
        panic!("a point light");
    };
    close(intensity.to_array(), [100.0 / (4.0 * PI); 3]);
    let Punctual::Distant { irradiance, .. } =
        punctual("LightSource \"distant\" \"float illuminance\" 7")
    else {
        panic!("a distant light");
    };
    close(irradiance.to_array(), [7.0; 3]);
    let scene = read_whole("WorldBegin LightSource \"infinite\" \"float illuminance\" 7");
    let Some(Environment::Constant(radiance)) = scene.environment else {
        panic!("constant");
    };
    close(radiance.to_array(), [7.0 / PI; 3]);
}

#[test]
fn spectra_have_a_luminance_of_one() {
    let color = |spectrum: &str| {
        let Punctual::Point { intensity, .. } =
            punctual(&format!("LightSource \"point\" {spectrum}"))
        else {
            panic!("a point light");
        };
        intensity
    };
    let flat: String = (0..=40).map(|k| format!("{} 5 ", 380 + 10 * k)).collect();
    for spectrum in [
        "\"blackbody I\" 3000",
        "\"blackbody I\" 9000",
        "\"spectrum I\" \"stdillum-A\"",
        &format!("\"spectrum I\" [{flat}]"),
    ] {
        let luminance = color(spectrum).luminance();
        assert!((luminance - 1.0).abs() < 1e-5, "{spectrum}: {luminance}");
    }
    // An incandescent lamp: illuminant A is a radiator at 2856 K.
    let (a, b) = (
        color("\"blackbody I\" 2856"),
        color("\"spectrum I\" \"stdillum-A\""),
    );
    for (a, b) in a.to_array().into_iter().zip(b.to_array()) {
        assert!((a - b).abs() < 0.05, "{a} is not {b}");
    }
    assert!(a.r > a.g && a.g > a.b);
    // Daylight is near the white of sRGB.
    for channel in color("\"blackbody I\" 6504").to_array() {
        assert!((channel - 1.0).abs() < 0.06, "{channel}");
    }
    close(
        color("\"spectrum I\" \"stdillum-D65\"").to_array(),
        [1.0; 3],
    );
}

#[test]
fn constant_skies_add_up() {
    let scene = read_whole(
        "WorldBegin LightSource \"infinite\" \"rgb L\" [1 2 3] LightSource \"infinite\" \"rgb L\" [1 1 1] \"float scale\" .5",
    );
    let Some(Environment::Constant(radiance)) = scene.environment else {
        panic!("constant");
    };
    assert_eq!(radiance.to_array(), [1.5, 2.5, 3.5]);
}

/// The pixel of a lat-long image that a direction of the world falls into.
fn pixel(image: &LatLong, d: Vec3) -> [f32; 3] {
    let x = d.x.atan2(-d.z) / (2.0 * PI);
    let x = ((x - x.floor()) * image.width as f32) as usize;
    let y = (d.y.acos() / PI * image.height as f32) as usize;
    image.pixels[y.min(image.height - 1) * image.width + x.min(image.width - 1)].to_array()
}

/// A direction of the middle of a pixel of the equal-area octahedral map: PBR 4th ed., sec. 3.8.3,
/// `EqualAreaSquareToSphere`.
fn square_to_sphere(u: f64, v: f64) -> [f64; 3] {
    let (u, v) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    let (up, vp) = (u.abs(), v.abs());
    let signed = 1.0 - (up + vp);
    let d = signed.abs();
    let r = 1.0 - d;
    let phi = (if r == 0.0 { 1.0 } else { (vp - up) / r + 1.0 }) * std::f64::consts::FRAC_PI_4;
    let z = (1.0 - r * r).copysign(signed);
    let scale = r * (2.0 - r * r).sqrt();
    [
        phi.cos().copysign(u) * scale,
        phi.sin().copysign(v) * scale,
        z,
    ]
}

fn write_image(
    folder: &Folder,
    name: &str,
    (width, height): (usize, usize),
    color: impl Sync + Fn(usize, usize) -> (f32, f32, f32),
) {
    exr::prelude::write_rgb_file(folder.path(name), width, height, color).unwrap();
}

#[test]
fn an_octahedral_sky_shines_from_where_pbrt_has_it() {
    const SIDE: usize = 32;
    for (transformation, to_world) in [
        ("", (|d| d) as fn([f64; 3]) -> [f64; 3]),
        // z up becomes y up.
        ("Rotate -90 1 0 0", |[x, y, z]| [x, z, -y]),
        ("Scale -1 1 1 Rotate -90 1 0 0", |[x, y, z]| [-x, z, -y]),
    ] {
        let folder = Folder::new(&format!(
            "Scale -1 1 1 Camera \"perspective\" WorldBegin {transformation}\nLightSource \"infinite\" \"string filename\" \"sky.exr\" \"float scale\" 2"
        ));
        write_image(&folder, "sky.exr", (SIDE, SIDE), |x, y| {
            (x as f32, y as f32, 1.0)
        });
        let scene = read_folder(&folder);
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        let Some(Environment::Image {
            image,
            rotate_degrees,
        }) = &scene.environment
        else {
            panic!("an image");
        };
        assert_eq!((image.width, image.height, *rotate_degrees), (64, 32, 0.0));
        for y in 0..SIDE {
            for x in 0..SIDE {
                let part = |at: usize| (at as f64 + 0.5) / SIDE as f64;
                let direction = to_world(square_to_sphere(part(x), part(y)));
                let direction = Vec3::from(direction.map(|c| c as f32)).normalize();
                // Around the poles a pixel of the lat-long image is a wedge of several.
                let side = (direction.x.powi(2) + direction.z.powi(2)).sqrt();
                if side < 0.3 {
                    continue;
                }
                let [r, g, b] = pixel(image, direction);
                let seam = [x, y].iter().any(|at| !(2..=SIDE - 3).contains(at));
                assert_eq!(b, 2.0);
                if !seam {
                    let far = (r / 2.0 - x as f32).abs().max((g / 2.0 - y as f32).abs());
                    assert!(far <= 2.0, "({x}, {y}) is ({}, {})", r / 2.0, g / 2.0);
                }
            }
        }
    }
}

#[test]
fn a_sky_keeps_its_energy() {
    let folder = Folder::new(
        "WorldBegin LightSource \"infinite\" \"string filename\" \"sky.exr\" LightSource \"infinite\" \"rgb L\" [0 0 1]",
    );
    // All of it in a patch of 6 × 6 of 64 × 64 equal areas.
    write_image(&folder, "sky.exr", (64, 64), |x, y| {
        let lit = (40..46).contains(&x) && (20..26).contains(&y);
        (if lit { 100.0 } else { 0.0 }, 0.0, 0.0)
    });
    let scene = read_folder(&folder);
    let Some(Environment::Image { image, .. }) = &scene.environment else {
        panic!("an image");
    };
    let mut sum = 0.0;
    for (index, pixel) in image.pixels.iter().enumerate() {
        assert_eq!(pixel.b, 1.0);
        let theta = |row: usize| std::f64::consts::PI * row as f64 / image.height as f64;
        let row = index / image.width;
        let solid =
            (theta(row).cos() - theta(row + 1).cos()) * std::f64::consts::TAU / image.width as f64;
        sum += f64::from(pixel.r) * solid;
    }
    let expected = 100.0 * 36.0 / 4096.0 * 4.0 * std::f64::consts::PI;
    assert!(
        (sum / expected - 1.0).abs() < 0.03,
        "{sum} is not {expected}"
    );
}

#[test]
fn a_lat_long_sky_is_read_and_told() {
    let folder = Folder::new(
        "Scale -1 1 1 Camera \"perspective\" WorldBegin\nLightSource \"infinite\" \"string filename\" \"sky.exr\"",
    );
    write_image(&folder, "sky.exr", (32, 16), |_, y| (y as f32, 0.0, 0.0));
    let scene = read_folder(&folder);
    assert_eq!(
        scene.warnings,
        [
            "a.pbrt:2:1: the image is 32×16, and pbrt-v4 has square ones (equal-area octahedral); it is read as a lat-long image, z up"
        ]
    );
    let Some(Environment::Image { image, .. }) = &scene.environment else {
        panic!("an image");
    };
    assert!(pixel(image, Vec3::Z)[0] <= 1.0 && pixel(image, Vec3::NEG_Z)[0] >= 14.0);
}

#[test]
fn an_unlit_scene_gets_a_sky_and_one_without_a_camera_a_view() {
    let scene = read_whole("WorldBegin Translate 5 6 7 Shape \"sphere\"");
    assert!(matches!(
        scene.environment,
        Some(Environment::Gradient { .. })
    ));
    close(scene.cameras[0].camera.look_at.to_array(), [5.0, 6.0, 7.0]);
}

#[test]
fn lights_that_are_not_supported_are_told() {
    let scene = read(
        "WorldBegin\nLightSource \"projection\"\nLightSource \"goniometric\" \"string filename\" \"a.exr\"\n\
         AreaLightSource \"diffuse\" \"float power\" 3 \"spectrum L\" \"mylamp.spd\"\n\
         ObjectBegin \"o\"\nShape \"sphere\"\nLightSource \"point\"\nObjectEnd",
    );
    assert_eq!(scene.punctual.len(), 1);
    assert_eq!(
        scene.warnings,
        [
            "a.pbrt:2:1: the light \"projection\" is not supported; it is left out",
            "a.pbrt:3:1: a goniometric light is not supported; it shines alike in all directions",
            "a.pbrt:4:1: the power of an area light is not supported; its L and scale are used",
            "a.pbrt:4:1: the spectrum \"mylamp.spd\" is not known; the light is white",
            "a.pbrt:6:1: area lights in objects are not supported; the shape does not emit",
            "a.pbrt:7:1: lights in objects are not supported; they are left out",
        ]
    );
}

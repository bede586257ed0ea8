//! The same bits, and the same image from every strategy, where there is everything that meshes bring.

use crate::render::*;
use crate::{add, add_light, ball, empty, sheet};
use glam::{Affine2, Affine3A, Quat, Vec3};
use ondine::dump::table::Table;
use ondine::film::{AovSet, Film, Region};
use ondine::lanes::Rgb;
use ondine::material::Material;
use ondine::render::Settings;
use ondine::scene::description::{
    Alpha, Description, Environment, Image, Maps, NamedMaterial, Object, Pixels, Punctual,
    SamplerKind, Shape, Strategy, Texture, Wrap,
};
use std::sync::Arc;

const CAMERA: &str = "position = [0.3, 1.2, 4.0]\nlook_at = [0.0, 0.2, 0.0]\nvertical_fov = 45.0";

/// A checkerboard of two by two texels, repeated `times`: its alpha is 0 or 1, its colours two.
pub fn checkers(times: f32) -> Texture {
    let pixels = vec![
        [255, 200, 90, 255],
        [90, 140, 255, 0],
        [90, 140, 255, 0],
        [255, 200, 90, 255],
    ];
    Texture {
        image: Arc::new(Image {
            file: "checkers".into(),
            width: 2,
            height: 2,
            pixels: Pixels::Linear8(pixels),
        }),
        wrap: [Wrap::Repeat; 2],
        nearest: true,
        transform: Affine2::from_scale(glam::Vec2::splat(times)),
    }
}

pub fn material(description: &mut Description, material: Material, maps: Maps) -> usize {
    description.materials.push(NamedMaterial {
        name: format!("material {}", description.materials.len()),
        material,
        maps,
    });
    description.materials.len() - 1
}

/// A mesh alone, instances, a mesh that emits with a texture, a sheet with holes, lamps, shapes and a sky.
fn everything() -> Description {
    let mut description = empty(CAMERA);
    description.environment = Some(Environment::Constant(Rgb::new(0.1, 0.15, 0.2)));
    description.textures = vec![
        checkers(3.0),
        Texture {
            nearest: false,
            ..checkers(7.0)
        },
    ];
    let color = Maps {
        color: Some(0),
        ..Maps::default()
    };
    let all = Maps {
        metallic_roughness: Some(0),
        normal: Some((1, 0.3)),
        ..color
    };
    let holes = Maps {
        alpha: Some(Alpha {
            texture: Some(0),
            factor: 1.0,
            cutoff: 0.5,
        }),
        ..color
    };
    let albedo = Rgb::splat(0.8);
    let painted = material(&mut description, Material::Lambert { albedo }, color);
    let pierced = material(&mut description, Material::Lambert { albedo }, holes);
    let glossy = Material::Conductor {
        roughness: 0.4,
        reflectance: Rgb::splat(0.9),
    };
    let glossy = material(&mut description, glossy, Maps::default());
    let principled = Material::Principled {
        base_color: Rgb::splat(0.9),
        metallic: 0.8,
        roughness: 0.9,
        ior: 1.5,
    };
    let principled = material(&mut description, principled, all);
    let glass = material(
        &mut description,
        Material::Glass { ior: 1.4 },
        Maps::default(),
    );
    description.objects.push(Object {
        shape: Shape::Sphere {
            center: Vec3::new(-0.9, 0.3, -0.5),
            radius: 0.4,
        },
        material: 0,
    });
    let floor = sheet(Vec3::new(-3.0, -0.2, 3.0), Vec3::X * 6.0, Vec3::Z * -6.0, 4);
    add(&mut description, &floor, Affine3A::IDENTITY, painted);
    let shared = ball(2, true);
    for i in 0..5 {
        let x = i as f32 * 0.45 - 0.9;
        let place = Affine3A::from_scale_rotation_translation(
            Vec3::new(0.2, 0.25, 0.2),
            Quat::from_rotation_x(x),
            Vec3::new(x, 0.0, 0.8),
        );
        let id = [principled, glossy, 0, glass, principled][i];
        add(&mut description, &shared, place, id);
    }
    let screen = sheet(Vec3::new(-0.7, -0.2, 0.2), Vec3::X * 1.8, Vec3::Y * 1.1, 2);
    add(&mut description, &screen, Affine3A::IDENTITY, pierced);
    let lamp = sheet(Vec3::new(0.2, 1.9, -0.4), Vec3::X * 0.8, Vec3::Z * 0.8, 2);
    add_light(&mut description, &lamp, Affine3A::IDENTITY, Rgb::splat(5.0));
    description.lights[0].texture = Some(0);
    description.lights[0].material = Some(pierced);
    add_light(
        &mut description,
        &ball(1, false),
        Affine3A::from_scale_rotation_translation(
            Vec3::splat(0.15),
            Quat::IDENTITY,
            Vec3::new(1.2, 0.4, 0.4),
        ),
        Rgb::new(6.0, 2.0, 1.0),
    );
    description.punctual = vec![
        Punctual::Point {
            position: Vec3::new(-1.5, 1.0, 1.5),
            intensity: Rgb::splat(1.0),
        },
        Punctual::Spot {
            position: Vec3::new(0.0, 2.5, 1.5),
            direction: Vec3::new(0.0, -1.0, -0.3).normalize(),
            intensity: Rgb::new(0.5, 2.0, 0.5),
            cos_inner: 0.97,
            cos_outer: 0.9,
        },
        Punctual::Distant {
            direction: Vec3::new(0.4, -1.0, -0.6).normalize(),
            irradiance: Rgb::splat(0.3),
        },
    ];
    description
}

#[test]
fn an_image_of_meshes_depends_on_no_thread_wave_crop_or_layer() {
    let description = everything();
    for sampler in [SamplerKind::Pcg, SamplerKind::Sobol] {
        let base = Settings {
            sampler,
            threads: Some(1),
            ..settings(&description, (45, 29), 19)
        };
        let whole = film(&description, &base);
        let hash = whole.image_hash();
        for (threads, wave) in [(2, 2048), (3, 16), (1, 333), (2, 4096)] {
            let settings = Settings {
                threads: Some(threads),
                wave,
                ..base.clone()
            };
            assert_eq!(
                film(&description, &settings).image_hash(),
                hash,
                "{threads}, {wave}"
            );
        }
        let region: Region = "7,3,30,22".parse().expect("a region");
        let part = Settings {
            region,
            ..base.clone()
        };
        let same_part = whole.image_hash_of(region).expect("within");
        assert_eq!(film(&description, &part).image_hash(), same_part);
        let aovs: AovSet = "albedo,normal,depth,bounces".parse().expect("layers");
        let layers = Settings { aovs, ..base };
        assert_eq!(film(&description, &layers).image_hash(), hash);
    }
}

#[test]
fn a_dump_of_meshes_adds_up_to_the_very_pixels_of_the_render() {
    let description = everything();
    let region: Region = "7,3,30,12".parse().expect("a region");
    for strategy in STRATEGIES {
        let settings = Settings {
            strategy,
            region,
            roulette: Some(3),
            ..settings(&description, (45, 29), 19)
        };
        let dump = ondine::dump::trace(&description, &settings, region, 0..19).expect("a dump");
        let film = film(&description, &settings);
        assert_eq!(dump.film.image_hash(), film.image_hash(), "{strategy}");
        let on_meshes = |table: &&Table| table.queue.starts_with("mesh_") && !table.is_empty();
        assert!(dump.tables.iter().filter(on_meshes).count() > 10);
    }
}

/// Mean and variance of the mean of each quarter of the image.
fn quarters(film: &Film, size: usize) -> Vec<[(f64, f64); 3]> {
    let (means, variances) = (film.means(), film.variances());
    let half = size / 2;
    (0..4)
        .map(|quarter| {
            std::array::from_fn(|c| {
                let pixels = (0..half * half).map(|i| {
                    let (x, y) = (quarter % 2 * half + i % half, quarter / 2 * half + i / half);
                    y * size + x
                });
                let n = (half * half) as f64;
                let sum =
                    |of: &[[f32; 3]]| pixels.clone().map(|p| f64::from(of[p][c])).sum::<f64>();
                (sum(&means) / n, sum(&variances) / (n * n))
            })
        })
        .collect()
}

#[test]
fn strategies_agree_on_everything() {
    let description = everything();
    let spp = [4096, 2048, 512, 512];
    let films: Vec<(Strategy, Film)> = (30..)
        .zip(STRATEGIES.into_iter().zip(spp))
        .map(|(seed, (strategy, spp))| {
            let mut settings = settings(&description, (16, 16), spp);
            (settings.strategy, settings.seed) = (strategy, seed);
            settings.path_length = 4;
            (strategy, film(&description, &settings))
        })
        .collect();
    for (i, (strategy, film)) in films.iter().enumerate() {
        for (other, against) in &films[..i] {
            for (quarter, (a, b)) in quarters(film, 16)
                .iter()
                .zip(quarters(against, 16))
                .enumerate()
            {
                for c in 0..3 {
                    let z = (a[c].0 - b[c].0) / (a[c].1 + b[c].1).sqrt();
                    let what = format!("{strategy} and {other}, quarter {quarter}, channel {c}");
                    println!("{what}: {} {} z = {z:.2}", a[c].0, b[c].0);
                    assert!(
                        z.abs() < 4.0,
                        "{what}: {} is not {}, z = {z:.2}",
                        a[c].0,
                        b[c].0
                    );
                }
            }
        }
    }
}

#[test]
fn a_sheet_with_holes_is_the_cells_that_are_there() {
    let side = 4;
    let (corner, u, v) = (Vec3::new(-0.9, -0.2, 0.3), Vec3::X * 1.8, Vec3::Y * 1.4);
    let mut cut = empty(CAMERA);
    cut.textures = vec![checkers(side as f32 / 2.0)];
    let maps = Maps {
        alpha: Some(Alpha {
            texture: Some(0),
            factor: 1.0,
            cutoff: 0.5,
        }),
        ..Maps::default()
    };
    let albedo = Rgb::splat(0.5);
    let pierced = material(&mut cut, Material::Lambert { albedo }, maps);
    let mut cells = cut.clone();
    // Three sheets, one behind the other, so that rays pass several holes.
    for depth in 0..3 {
        let corner = corner - Vec3::Z * depth as f32 * 0.3 + Vec3::X * depth as f32 * 0.1;
        add(
            &mut cut,
            &sheet(corner, u, v, 3),
            Affine3A::IDENTITY,
            pierced,
        );
        for i in 0..side * side {
            let (x, y) = (i % side, i / side);
            if (x + y) % 2 == 0 {
                let step = 1.0 / side as f32;
                let corner = corner + u * (x as f32 * step) + v * (y as f32 * step);
                add(
                    &mut cells,
                    &sheet(corner, u * step, v * step, 1),
                    Affine3A::IDENTITY,
                    0,
                );
            }
        }
    }
    for description in [&mut cut, &mut cells] {
        let floor = sheet(Vec3::new(-3.0, -0.2, 3.0), Vec3::X * 6.0, Vec3::Z * -6.0, 1);
        add(description, &floor, Affine3A::IDENTITY, 0);
        description.environment = Some(Environment::Constant(Rgb::splat(0.4)));
        description.punctual.push(Punctual::Point {
            position: Vec3::new(0.5, 1.0, 2.0),
            intensity: Rgb::splat(4.0),
        });
    }
    let [cut, cells] = [cut, cells].map(|description| {
        let settings = settings(&description, (32, 32), 64);
        film(&description, &settings)
    });
    let (a, b) = (mean_and_error(&cut), mean_and_error(&cells));
    for c in 0..3 {
        // The same paths, but for those that rounding lets pass an edge of a cell or not.
        let off = (a.0[c] - b.0[c]).abs();
        assert!(off < 1e-3 * b.0[c], "{a:?} is not {b:?}");
    }
}

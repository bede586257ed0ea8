//! Eight-lane texture look-ups against the textbook, one lane at a time in double precision.

mod common;

use common::*;
use glam::{Affine2, Vec2};
use ondine::lanes::{Rgb, Vec3x8, WIDTH, f32x8, u32x8};
use ondine::texture::{Image, Pixels, Texture, Textures, Wrap};
use std::sync::Arc;

const NONE: u32 = u32::MAX;
const WRAPS: [Wrap; 3] = [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp];

fn image(width: usize, height: usize, pixels: Pixels) -> Arc<Image> {
    Arc::new(Image {
        file: "test".to_owned(),
        width,
        height,
        pixels,
    })
}

/// Random texels of each format.
fn formats(width: usize, height: usize, seed: u64) -> [Pixels; 3] {
    let mut random = Random::new(seed);
    let mut texels = || -> Vec<[u8; 4]> {
        (0..width * height)
            .map(|_| std::array::from_fn(|_| (random.one() * 256.0) as u8))
            .collect()
    };
    let (srgb, linear) = (texels(), texels());
    let float = (0..width * height)
        .map(|_| std::array::from_fn(|_| 10.0 * random.one()))
        .collect();
    [
        Pixels::Srgb8(srgb),
        Pixels::Linear8(linear),
        Pixels::Float(float),
    ]
}

fn texture(image: &Arc<Image>, wrap: [Wrap; 2], nearest: bool) -> Texture {
    Texture {
        image: Arc::clone(image),
        wrap,
        nearest,
        transform: Affine2::IDENTITY,
    }
}

fn srgb(code: u8) -> f64 {
    let value = f64::from(code) / 255.0;
    if value <= 0.04045 {
        value / 12.92
    } else {
        ((value + 0.055) / 1.055).powf(2.4)
    }
}

fn texel_oracle(image: &Image, column: usize, row: usize) -> [f64; 4] {
    let index = row * image.width + column;
    match &image.pixels {
        Pixels::Srgb8(texels) => {
            let [r, g, b, a] = texels[index];
            [srgb(r), srgb(g), srgb(b), f64::from(a) / 255.0]
        }
        Pixels::Linear8(texels) => texels[index].map(|code| f64::from(code) / 255.0),
        Pixels::Float(texels) => texels[index].map(f64::from),
    }
}

/// The texel at any whole number.
fn wrapped(wrap: Wrap, texel: f64, size: usize) -> usize {
    let size = size as f64;
    let texel = match wrap {
        Wrap::Repeat => texel.rem_euclid(size),
        Wrap::Mirror => {
            let pair = texel.rem_euclid(2.0 * size);
            if pair < size {
                pair
            } else {
                2.0 * size - 1.0 - pair
            }
        }
        Wrap::Clamp => texel.clamp(0.0, size - 1.0),
    };
    texel as usize
}

fn oracle(texture: &Texture, u: f64, v: f64) -> [f64; 4] {
    let image = &texture.image;
    let (x, y) = (u * image.width as f64, v * image.height as f64);
    let texel = |column: f64, row: f64| {
        texel_oracle(
            image,
            wrapped(texture.wrap[0], column, image.width),
            wrapped(texture.wrap[1], row, image.height),
        )
    };
    if texture.nearest {
        return texel(x.floor(), y.floor());
    }
    let (x, y) = (x - 0.5, y - 0.5);
    let (left, top) = (x.floor(), y.floor());
    let mut sum = [0.0; 4];
    for (column, across) in [(left, left + 1.0 - x), (left + 1.0, x - left)] {
        for (row, down) in [(top, top + 1.0 - y), (top + 1.0, y - top)] {
            for (sum, channel) in sum.iter_mut().zip(texel(column, row)) {
                *sum += across * down * channel;
            }
        }
    }
    sum
}

fn rgba(textures: &Textures, ids: u32x8, u: f32x8, v: f32x8) -> [[f32; WIDTH]; 4] {
    let (color, alpha) = textures.sample(ids, u, v);
    [color.r, color.g, color.b, alpha].map(|channel| channel.to_array())
}

/// Each lane against the oracle, to the rounding of a coordinate of that size.
fn agrees(textures: &[Texture], ids: [u32; WIDTH], u: f32x8, v: f32x8, what: &str) {
    let compiled = Textures::new(textures.to_vec());
    let got = rgba(&compiled, u32x8::new(ids), u, v);
    for lane in 0..WIDTH {
        let texture = &textures[ids[lane] as usize];
        let [u, v] = [u, v].map(|c| f64::from(c.to_array()[lane]));
        let want = oracle(texture, u, v);
        // A coordinate within [0, 1] is rounded to 2⁻²⁴, and the slope is a texel's difference by a texel's width.
        let greatest = if matches!(texture.image.pixels, Pixels::Float(_)) {
            10.0
        } else {
            1.0
        };
        let side = texture.image.width.max(texture.image.height) as f64;
        let absolute = 3e-7 * greatest * side;
        for channel in 0..4 {
            let got = f64::from(got[channel][lane]);
            let what = format!("{what} at ({u}, {v}), channel {channel}");
            assert_close(got, want[channel], 1e-6, absolute, &what);
        }
    }
}

#[test]
fn look_ups_agree_with_their_oracle_in_every_format_filter_and_wrap() {
    let mut random = Random::new(100);
    for (width, height) in [(1, 1), (1, 3), (2, 2), (3, 5), (16, 8), (37, 11)] {
        for pixels in formats(width, height, 101) {
            let image = image(width, height, pixels);
            for nearest in [false, true] {
                let textures: Vec<Texture> = WRAPS
                    .iter()
                    .flat_map(|&u| WRAPS.map(|v| texture(&image, [u, v], nearest)))
                    .collect();
                for _ in 0..300 {
                    // From −4 to 4; at nearest, away from borders of texels, where a rounded coordinate may fall either way.
                    let [u, v] = [width, height].map(|side| {
                        let side = side as f32;
                        let texel = (random.eight() * (8.0 * side)).floor();
                        let inside = random.eight() * 0.98 + f32x8::splat(0.01);
                        (texel + inside) / f32x8::splat(side) - f32x8::splat(4.0)
                    });
                    let ids = random.eight().to_array().map(|c| (c * 9.0) as u32);
                    let what = format!("{width} × {height}, nearest {nearest}, ids {ids:?}");
                    agrees(&textures, ids, u, v, &what);
                }
            }
        }
    }
}

#[test]
fn lanes_of_one_batch_may_read_different_images() {
    let mut random = Random::new(102);
    // More than a table keeps by column.
    let textures: Vec<Texture> = (0..20)
        .map(|i| {
            let (width, height) = (1 + 3 * i % 7, 1 + i);
            let pixels = formats(width, height, 103).into_iter().nth(i % 3);
            let image = image(width, height, pixels.expect("three formats"));
            texture(&image, [WRAPS[i % 3], WRAPS[(i / 3) % 3]], false)
        })
        .collect();
    for _ in 0..1000 {
        let ids = random.eight().to_array().map(|c| (c * 20.0) as u32);
        let [u, v] = [random.eight(), random.eight()].map(|c| c * 4.0 - f32x8::splat(2.0));
        agrees(&textures, ids, u, v, "mixed");
    }
}

#[test]
fn no_texture_reads_one_and_so_does_one_that_is_not_there() {
    let black = image(1, 1, Pixels::Linear8(vec![[0; 4]]));
    let empty = image(0, 0, Pixels::Float(Vec::new()));
    let repeat = [Wrap::Repeat; 2];
    let textures = Textures::new(vec![
        texture(&black, repeat, false),
        texture(&empty, repeat, false),
    ]);
    let ids = u32x8::new([NONE, 0, 1, 2, 7, 8, 1 << 31, NONE]);
    let want = [1.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0];
    assert_eq!(rgba(&textures, ids, f32x8::HALF, f32x8::HALF), [want; 4]);
    let none = Textures::default();
    assert_eq!(
        rgba(&none, ids, f32x8::HALF, f32x8::HALF),
        [[1.0; WIDTH]; 4]
    );
}

#[test]
fn all_256_codes_are_decoded_by_the_srgb_curve_and_alpha_is_linear() {
    let texels: Vec<[u8; 4]> = (0..=255).map(|code| [code; 4]).collect();
    let [curve, line] = [Pixels::Srgb8(texels.clone()), Pixels::Linear8(texels)]
        .map(|pixels| texture(&image(256, 1, pixels), [Wrap::Clamp; 2], true));
    let textures = Textures::new(vec![curve, line]);
    for code in 0..=255u8 {
        let u = f32x8::splat((f32::from(code) + 0.5) / 256.0);
        let ids = u32x8::new([0, 1, 0, 1, 0, 1, 0, 1]);
        let [red, _, blue, alpha] = rgba(&textures, ids, u, f32x8::HALF);
        let linear = f32::from(code) / 255.0;
        assert_eq!([red[0], blue[2]], [srgb(code) as f32; 2]);
        assert_eq!([alpha[0], red[1], alpha[1]], [linear; 3]);
    }
}

#[test]
fn the_top_row_is_where_v_is_0_and_columns_go_with_u() {
    let texel = |r, g| [r, g, 0.0, 1.0];
    let corners = vec![
        texel(0.0, 0.0),
        texel(1.0, 0.0),
        texel(0.0, 1.0),
        texel(1.0, 1.0),
    ];
    let image = image(2, 2, Pixels::Float(corners));
    let textures = Textures::new(vec![texture(&image, [Wrap::Clamp; 2], false)]);
    let u = f32x8::new([0.0, 1.0, 0.0, 1.0, 0.5, 0.25, 0.375, 0.75]);
    let v = f32x8::new([0.0, 0.0, 1.0, 1.0, 0.5, 0.25, 0.25, 0.625]);
    let [r, g, ..] = rgba(&textures, u32x8::ZERO, u, v);
    assert_eq!(r, [0.0, 1.0, 0.0, 1.0, 0.5, 0.0, 0.25, 1.0]);
    assert_eq!(g, [0.0, 0.0, 1.0, 1.0, 0.5, 0.0, 0.0, 0.75]);
}

#[test]
fn huge_coordinates_wrap_exactly() {
    let pixels = formats(4, 4, 104).into_iter().next().expect("a format");
    let image = image(4, 4, pixels);
    let textures: Vec<Texture> = WRAPS.map(|wrap| texture(&image, [wrap; 2], true)).into();
    // Exact in f32; odd numbers of eighths are centres of texels.
    let exact = [
        8_000_001.0f32,
        -8_000_001.0,
        7_999_999.0,
        -7_999_995.0,
        3e9,
        -3e9,
        f32::MAX,
        f32::MIN,
    ]
    .map(|eighths| eighths / 8.0);
    for id in 0..3 {
        agrees(
            &textures,
            [id; WIDTH],
            f32x8::new(exact),
            f32x8::splat(0.125),
            "huge",
        );
    }
}

#[test]
fn every_coordinate_has_a_value() {
    let strange = [
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        -0.0,
        -1e-30,
        -1e-9,
        f32::MAX,
        1.0 - 0.5 * f32::EPSILON,
    ];
    for (width, height) in [(1, 1), (3, 7), (64, 5)] {
        let texels = (0..width * height).map(|i| [i as f32 + 1.0; 4]).collect();
        let image = image(width, height, Pixels::Float(texels));
        let most = (width * height) as f32;
        for nearest in [false, true] {
            let textures = Textures::new(WRAPS.map(|w| texture(&image, [w; 2], nearest)).into());
            for id in 0..3 {
                for other in strange {
                    let (a, b) = (f32x8::new(strange), f32x8::splat(other));
                    for (u, v) in [(a, b), (b, a)] {
                        let [r, ..] = rgba(&textures, u32x8::splat(id), u, v);
                        assert!(r.iter().all(|r| (1.0..=most).contains(r)), "{u} {v}: {r:?}");
                    }
                }
            }
        }
    }
}

#[test]
fn what_rounds_up_to_the_next_period_stays_in_the_last_texel() {
    let texels = (0..3).map(|i| [i as f32; 4]).collect();
    let image = image(3, 1, Pixels::Float(texels));
    let textures = Textures::new(vec![texture(&image, [Wrap::Repeat; 2], true)]);
    let [r, ..] = rgba(
        &textures,
        u32x8::ZERO,
        f32x8::splat(-1e-9),
        f32x8::splat(0.5),
    );
    assert_eq!(r, [2.0; WIDTH]);
}

#[test]
fn transforms_go_from_the_mesh_to_the_image() {
    let pixels = formats(8, 8, 105).into_iter().nth(2).expect("a format");
    let image = image(8, 8, pixels);
    let transform =
        Affine2::from_scale_angle_translation(Vec2::new(2.0, 0.5), 0.7, Vec2::new(0.25, -0.125));
    let turned = Texture {
        transform,
        ..texture(&image, [Wrap::Repeat, Wrap::Mirror], false)
    };
    let textures = Textures::new(vec![turned.clone()]);
    let mut random = Random::new(106);
    for _ in 0..1000 {
        let (u, v) = random.pair();
        let got = rgba(&textures, u32x8::ZERO, u, v);
        for lane in 0..WIDTH {
            let uv = glam::DVec2::new(u.to_array()[lane].into(), v.to_array()[lane].into());
            let at = transform.matrix2.as_dmat2() * uv + transform.translation.as_dvec2();
            let want = oracle(&turned, at.x, at.y);
            for channel in 0..4 {
                let got = f64::from(got[channel][lane]);
                assert_close(got, want[channel], 1e-6, 5e-5, "turned");
            }
        }
    }
}

#[test]
fn a_part_of_a_look_up_is_that_part() {
    let pixels = formats(5, 3, 107).into_iter().next().expect("a format");
    let textures = Textures::new(vec![texture(
        &image(5, 3, pixels),
        [Wrap::Mirror; 2],
        false,
    )]);
    let mut random = Random::new(108);
    let ids = u32x8::new([0, NONE, 0, 0, 0, 0, 0, NONE]);
    for _ in 0..100 {
        let (u, v) = random.pair();
        let [r, g, b, a] = rgba(&textures, ids, u, v);
        let color = textures.color(ids, u, v);
        let (roughness, metallic) = textures.roughness_metallic(ids, u, v);
        assert_eq!([color.r, color.g, color.b].map(|c| c.to_array()), [r, g, b]);
        assert_eq!(textures.alpha(ids, u, v).to_array(), a);
        assert_eq!([roughness, metallic].map(|c| c.to_array()), [g, b]);
    }
}

#[test]
fn the_mean_of_an_image_is_linear() {
    let codes = vec![[255, 0, 10, 7], [0, 0, 200, 255], [0, 0, 0, 0]];
    let mean = image(3, 1, Pixels::Srgb8(codes)).mean();
    assert_close(f64::from(mean.r), 1.0 / 3.0, 1e-7, 0.0, "red");
    assert_eq!(mean.g, 0.0);
    assert_close(
        f64::from(mean.b),
        (srgb(10) + srgb(200)) / 3.0,
        1e-7,
        0.0,
        "blue",
    );
    assert_eq!(image(0, 0, Pixels::Float(vec![])).mean(), Rgb::WHITE);
}

#[test]
fn tangent_space_normals_are_decoded_scaled_and_stay_above() {
    let texel = |r: f32, g: f32, b: f32| [r, g, b, 1.0];
    let texels = vec![
        texel(0.5, 0.5, 1.0),
        texel(0.75, 0.25, 0.9),
        texel(1.0, 0.5, 0.5),
        texel(0.0, 0.0, 0.0),
    ];
    let image = image(4, 1, Pixels::Float(texels.clone()));
    let textures = Textures::new(vec![texture(&image, [Wrap::Clamp; 2], true)]);
    let u = f32x8::new(std::array::from_fn(|i| ((i % 4) as f32 + 0.5) / 4.0));
    let ids = u32x8::new([0, 0, 0, 0, NONE, 0, 0, NONE]);
    for scale in [0.0, 0.5, 1.0, 4.0] {
        let normals: Vec3x8 = textures.normal(ids, f32x8::splat(scale), u, f32x8::HALF);
        for i in 0..WIDTH {
            let got = lane(&normals, i);
            if i == 4 || i == 7 {
                assert_eq!(got, [0.0, 0.0, 1.0]);
                continue;
            }
            let [x, y, z, _] = texels[i % 4].map(|c| 2.0 * f64::from(c) - 1.0);
            let scale = f64::from(scale);
            let want = unit([x * scale, y * scale, z.max(1e-3)]);
            for c in 0..3 {
                assert_close(
                    got[c],
                    want[c],
                    1e-6,
                    1e-6,
                    &format!("lane {i}, scale {scale}"),
                );
            }
            assert!(got[2] > 0.0);
        }
    }
}

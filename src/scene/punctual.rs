//! Lights without a surface: points, spots, and those so far away that their rays are parallel.

use super::alias::{Alias, chances};
use super::description::Punctual;
use super::light::LightSampleX8;
use crate::lanes::{Rgb, Rgbx8, Table, Vec3x8, f32x8, square, u32x8};
use crate::shape::NO_PRIMITIVE;
use glam::Vec3;
use std::f64::consts::PI;

/// The lights of a scene that no ray can meet.
#[derive(Clone, Debug, Default)]
pub struct Punctuals {
    /// Position (3; 0 of a distant light), 1 if distant, intensity or irradiance (3).
    places: Table,
    /// Way of its light (3), slope and offset of a spot's falloff, 1 ÷ chance among all lights, and among these.
    ways: Table,
    /// Which of these alone.
    choice: Alias,
    /// By luminance, W.
    powers: Vec<f64>,
    /// The id of the first, among all lights.
    first: u32,
}

impl Punctuals {
    /// From their descriptions and the radius of a sphere around the scene.
    pub(super) fn new(lights: &[Punctual], scene_radius: f32) -> Self {
        let powers = lights.iter().map(|light| power(light, scene_radius));
        let mut all = Self {
            powers: powers.collect(),
            ..Self::default()
        };
        let chances = chances(&all.powers);
        let (mut places, mut ways) = (Vec::new(), Vec::new());
        for (light, &chance) in lights.iter().zip(&chances) {
            let (at, way, Rgb { r, g, b }, [slope, offset]) = parameters(light);
            let distant = if light.position().is_some() { 0.0 } else { 1.0 };
            places.push([at.x, at.y, at.z, distant, r, g, b, 0.0]);
            ways.push([
                way.x,
                way.y,
                way.z,
                slope,
                offset,
                0.0,
                inverse(chance),
                0.0,
            ]);
        }
        all.places = Table::new(places);
        all.ways = Table::new(ways);
        all.choice = Alias::new(&chances);
        all
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.powers.is_empty()
    }

    /// By luminance, W.
    pub(super) fn powers(&self) -> &[f64] {
        &self.powers
    }

    /// Takes note of the chances among all lights, of which these are those from `first` on.
    pub(super) fn choose_among_all(&mut self, first: usize, chances: &[f64]) {
        self.first = first as u32;
        let mut rows = self.ways.rows().to_vec();
        for (row, &chance) in rows.iter_mut().zip(&chances[first..]) {
            row[5] = inverse(chance);
        }
        self.ways = Table::new(rows);
    }

    /// Overwrites the samples of those ids, among all lights, that are of these.
    #[inline]
    pub(super) fn sample_among_all(&self, id: u32x8, from: Vec3x8, sample: &mut LightSampleX8) {
        let first = u32x8::splat(self.first);
        let own = f32x8::from_bits(id.simd_ge(first));
        if !own.any() {
            return;
        }
        let (mine, among_all, _) = self.at(id - first, from);
        *sample = LightSampleX8 {
            direction: Vec3x8::select(own, mine.direction, sample.direction),
            distance: own.select(mine.distance, sample.distance),
            radiance: Rgbx8::select(own, mine.radiance, sample.radiance),
            inverse_pdf: own.select(mine.inverse_pdf & among_all, sample.inverse_pdf),
            primitive: own.select(mine.primitive, sample.primitive),
            is_punctual: own,
        };
    }

    /// One of these by power, as seen from `from`; the density counts that choice alone.
    #[inline]
    pub fn sample(&self, from: Vec3x8, choice: f32x8) -> LightSampleX8 {
        let (id, _) = self.choice.choose(choice);
        let (sample, _, among_these) = self.at(id, from);
        LightSampleX8 {
            inverse_pdf: sample.inverse_pdf & among_these,
            ..sample
        }
    }

    /// Whether none has power.
    pub fn is_dark(&self) -> bool {
        self.choice.is_empty()
    }

    /// Those of these ids as seen from `from`, with 1 ÷ chance among all lights and among these. `inverse_pdf` is a mask of
    /// the places from where they are seen at all.
    #[inline]
    fn at(&self, id: u32x8, from: Vec3x8) -> (LightSampleX8, f32x8, f32x8) {
        let [px, py, pz, distant, r, g, b, _] = self.places.gather(id);
        let [wx, wy, wz, slope, offset, among_all, among_these, _] = self.ways.gather(id);
        let distant = distant.simd_gt(f32x8::ZERO);
        let way = Vec3x8::new(wx, wy, wz);
        let to_light = Vec3x8::new(px, py, pz) - from;
        let squared = to_light.length_squared();
        let distance = squared.sqrt();
        let direction = to_light * (f32x8::ONE / distance);
        // The square of a linear ramp in the cosine (glTF 2.0, KHR_lights_punctual).
        let ramp = (-direction.dot(way)).mul_add(slope, offset);
        let falloff = square(ramp.fast_max(f32x8::ZERO).fast_min(f32x8::ONE)) / squared;
        let sample = LightSampleX8 {
            direction: Vec3x8::select(distant, -way, direction),
            distance: distant.select(f32x8::splat(f32::INFINITY), distance),
            radiance: Rgbx8::new(r, g, b) * distant.select(f32x8::ONE, falloff),
            inverse_pdf: distant | squared.simd_gt(f32x8::ZERO),
            primitive: u32x8::splat(NO_PRIMITIVE),
            is_punctual: f32x8::splat(f32::from_bits(u32::MAX)),
        };
        (sample, among_all, among_these)
    }
}

/// Position (0 of a distant light), way of its light, intensity or irradiance, slope and offset of a spot's falloff.
fn parameters(light: &Punctual) -> (Vec3, Vec3, Rgb, [f32; 2]) {
    match *light {
        Punctual::Point {
            position,
            intensity,
        } => (position, Vec3::ZERO, intensity, [0.0, 1.0]),
        Punctual::Spot {
            position,
            direction,
            intensity,
            cos_inner,
            cos_outer,
        } => {
            let slope = 1.0 / (cos_inner - cos_outer).max(LEAST_RAMP);
            (position, direction, intensity, [slope, -cos_outer * slope])
        }
        Punctual::Distant {
            direction,
            irradiance,
        } => (Vec3::ZERO, direction, irradiance, [0.0, 1.0]),
    }
}

/// Least width of the ramp of a spot's falloff, as KHR_lights_punctual has it.
const LEAST_RAMP: f32 = 0.001;

/// Emitted power by luminance, W; of a distant light, on the disk that the scene covers.
fn power(light: &Punctual, scene_radius: f32) -> f64 {
    match *light {
        Punctual::Point { intensity, .. } => 4.0 * PI * f64::from(intensity.luminance()),
        Punctual::Spot {
            intensity,
            cos_inner,
            cos_outer,
            ..
        } => {
            // ∫ ramp² over the ramp is a third of its width.
            let [inner, outer] = [cos_inner, cos_outer].map(f64::from);
            let cap = 1.0 - inner + (inner - outer) / 3.0;
            2.0 * PI * cap * f64::from(intensity.luminance())
        }
        Punctual::Distant { irradiance, .. } => {
            PI * f64::from(scene_radius).powi(2) * f64::from(irradiance.luminance())
        }
    }
}

/// 1 ÷ a chance; 0 for what is never chosen.
fn inverse(chance: f64) -> f32 {
    if chance > 0.0 {
        (1.0 / chance) as f32
    } else {
        0.0
    }
}

//! The double sum beside what rays find of the same: images, and how far apart they are by degree.

use crate::error::{Error, Result};
use crate::film::{Film, Raster};
use crate::lanes::Rgb;
use crate::material::Material;
use crate::render::double_sum::{DoubleSum, Estimator};
use crate::render::{Control, Rendered, Settings};
use crate::scene::description::{Description, Environment, Harmonics, LatLong, NamedMaterial};
use crate::sh::{Lobe, Probe};
use serde::Serialize;
use std::f64::consts::PI;
use std::sync::Arc;

/// Regions on a side of the image, for the test of agreement.
const REGIONS: usize = 12;
/// The fewest regions that tell anything.
pub(super) const LEAST_REGIONS: usize = 12;
/// The fewest samples of a pixel, and of a region that counts: with fewer the spread of the samples is no measure of the
/// error. Of 960 comparisons (four lights, four lobes, 16 to 100 pixels a side, 2 to 32 samples) regions of 32 to 63 samples
/// were up to 6 standard errors off and those of 4 to 7 up to 59; of 29,000 regions from these numbers up, none beyond 4.7.
pub(super) const LEAST_SPP: usize = 4;
pub(super) const LEAST_SAMPLES: u64 = 64;
/// Of the root mean square of the light: what single precision leaves apart where there is no noise.
const ROUNDING: f64 = 2e-6;
/// The linear value of middle grey on a screen.
const GREY: f32 = 0.214;
/// What the root mean square of a difference is in its picture.
const VISIBLE: f64 = 0.06;

/// What is compared.
pub(super) struct Subject {
    /// Its light is replaced, and its materials.
    pub object: Description,
    pub light: Probe,
    /// Where the light's coefficients are those of an image.
    pub image: Option<Arc<LatLong>>,
    pub lobe: Lobe,
}

/// An image that rays found.
pub(super) struct View {
    pub name: &'static str,
    pub film: Arc<Film>,
    /// Root mean square of the object's pixels, and of their standard errors.
    pub rms: f64,
    pub noise: f64,
}

/// The double sum up to a degree, beside each view.
#[derive(Debug, Serialize)]
pub(super) struct Row {
    pub l: usize,
    /// Root mean square of the difference over that of the view, in the order of the views.
    pub relative_rms: Vec<f64>,
}

/// Whether the first view and the whole double sum differ by noise alone.
#[derive(Debug, Serialize)]
pub(super) struct Agreement {
    pub estimator: &'static str,
    /// Of the image, with enough of the object in them.
    pub regions: usize,
    /// Of (mean difference / its standard error) of regions and channels: 0 and 1 where only noise is between them.
    pub mean_z: f64,
    pub variance_z: f64,
    pub greatest_z: f64,
    /// None where too few regions tell.
    pub agrees: Option<bool>,
}

/// The finished comparison.
pub(super) struct Comparison {
    pub views: Vec<View>,
    pub rows: Vec<Row>,
    pub agreement: Agreement,
    /// Pixels that the object covers wholly: those that count.
    pub covered: Vec<bool>,
    /// The double sum of all degrees.
    pub sum: Arc<Film>,
}

/// Where light is looked for, for a view.
#[derive(Clone, Copy)]
struct Way {
    name: &'static str,
    estimator: Estimator,
    material: Material,
    whole_image: bool,
}

impl Subject {
    /// Images that are rendered for a comparison.
    pub fn images(&self) -> u64 {
        (self.ways().len() + self.light.degree + 3) as u64
    }

    /// The most images that are held at a time: those of rays, the double sum, and the one that is rendered.
    pub fn held(&self) -> usize {
        self.ways().len() + 2
    }

    fn ways(&self) -> Vec<Way> {
        let white = Material::Lambert { albedo: Rgb::WHITE };
        let band_limited = |name, estimator, material| Way {
            name,
            estimator,
            material,
            whole_image: false,
        };
        let (first, other) = match self.lobe {
            Lobe::Cosine => (
                band_limited("path traced", Estimator::PathTracer, white),
                None,
            ),
            Lobe::Phong(exponent) => {
                let phong = Material::Phong {
                    diffuse: Rgb::BLACK,
                    specular: Rgb::WHITE,
                    exponent: exponent as f32,
                };
                (
                    band_limited("lobe rays", Estimator::Lobe, white),
                    Some(band_limited("phong material", Estimator::PathTracer, phong)),
                )
            }
        };
        let whole = self.image.as_ref().map(|_| Way {
            name: match first.estimator {
                Estimator::PathTracer => "path traced, whole image",
                Estimator::Lobe => "lobe rays, whole image",
            },
            whole_image: true,
            ..first
        });
        std::iter::once(first).chain(whole).chain(other).collect()
    }

    /// The scene of a way; in one without light, only what is covered shows.
    fn scene(&self, way: Way) -> Description {
        let environment = match (&self.image, way.whole_image) {
            (Some(image), true) => Environment::Image {
                image: Arc::clone(image),
                rotate_degrees: 0.0,
            },
            _ => Environment::Harmonics(Harmonics {
                source: String::new(),
                probe: self.light.clone(),
                rotate_degrees: 0.0,
                clamp: false,
            }),
        };
        let materials = self.object.materials.iter().map(|named| NamedMaterial {
            material: way.material,
            maps: Default::default(),
            name: named.name.clone(),
        });
        Description {
            materials: materials.collect(),
            lights: Vec::new(),
            punctual: Vec::new(),
            environment: Some(environment),
            ..self.object.clone()
        }
    }

    /// Renders all, or none where it was interrupted.
    ///
    /// # Errors
    /// Those of rendering, and [`Error::Usage`] where there is nothing to compare: no pixel shows the object alone, no light
    /// reaches it, or there is more than a film holds.
    pub fn compare(&self, settings: &Settings, control: &Control) -> Result<Option<Comparison>> {
        let ways = self.ways();
        let scenes: Vec<Description> = ways.iter().map(|&way| self.scene(way)).collect();
        let (first, scene) = (ways[0], &scenes[0]);

        let dark = Description {
            environment: None,
            ..scene.clone()
        };
        let even = Probe::radiance(vec![[(4.0 * PI).sqrt(); 3]])?;
        let rendered = DoubleSum::new(&even, self.lobe)?.render(&dark, settings, control)?;
        let Some(film) = whole(rendered)? else {
            return Ok(None);
        };
        let covered: Vec<bool> = film.means().iter().map(|pixel| pixel[0] > 0.9999).collect();
        if !covered.contains(&true) {
            return Err(Error::Usage(format!(
                "{} covers no pixel of {}x{} wholly; choose a greater --size, or an object that the camera sees",
                self.object.name, settings.width, settings.height
            )));
        }

        let mut views = Vec::new();
        for (way, scene) in ways.iter().zip(&scenes) {
            let rendered = way.estimator.render(self.lobe, scene, settings, control)?;
            let Some(film) = whole(rendered)? else {
                return Ok(None);
            };
            let squares = film.means().into_iter().map(|pixel| pixel.map(square));
            let rms = root_mean(squares, &covered);
            if rms == 0.0 {
                return Err(Error::Usage(format!(
                    "{}: no light of the environment reaches it ({}); choose an open --shape",
                    self.object.name, way.name
                )));
            }
            views.push(View {
                name: way.name,
                rms,
                noise: root_mean(
                    film.variances().into_iter().map(|v| v.map(f64::from)),
                    &covered,
                ),
                film,
            });
        }

        let mut rows = Vec::new();
        let mut sum = None;
        for l in 0..=self.light.degree {
            let partial = DoubleSum::new(&self.light.clone().truncated(l), self.lobe)?;
            // Only the picture of the whole sum shows the sky, and compiling one takes longer than an image.
            let last = l == self.light.degree;
            let behind = if last { scene } else { &dark };
            let Some(film) = whole(partial.render(behind, settings, control)?)? else {
                return Ok(None);
            };
            let apart = |view: &View| {
                let pixels = view.film.means().into_iter().zip(film.means());
                let squares = pixels.map(|(a, b)| std::array::from_fn(|c| square(a[c] - b[c])));
                root_mean(squares, &covered) / view.rms
            };
            rows.push(Row {
                l,
                relative_rms: views.iter().map(apart).collect(),
            });
            sum = last.then_some(film);
        }
        let double_sum = DoubleSum::new(&self.light, self.lobe)?;
        let difference = double_sum.difference(first.estimator, scene, settings, control)?;
        let (Some(difference), Some(sum)) = (whole(difference)?, sum) else {
            return Ok(None);
        };
        Ok(Some(Comparison {
            agreement: Agreement::of(&views[0], &difference, &covered),
            views,
            rows,
            covered,
            sum,
        }))
    }
}

/// The film, unless the render was interrupted.
fn whole(rendered: Rendered) -> Result<Option<Arc<Film>>> {
    match rendered.film.rejected() {
        0 => Ok((!rendered.interrupted).then_some(rendered.film)),
        rejected => Err(Error::Usage(format!(
            "{rejected} samples are not finite or not below 2^32, and a mean without them is none; choose another unit for the \
             light"
        ))),
    }
}

fn square(value: f32) -> f64 {
    f64::from(value) * f64::from(value)
}

/// The root of the mean over channels of covered pixels.
fn root_mean(pixels: impl Iterator<Item = [f64; 3]>, covered: &[bool]) -> f64 {
    let pixels = pixels.zip(covered).filter(|(_, covered)| **covered);
    let (mut sum, mut count) = (0.0, 0.0_f64);
    for (pixel, _) in pixels {
        sum += pixel.iter().sum::<f64>();
        count += 3.0;
    }
    (sum / count.max(1.0)).sqrt()
}

/// Sums over the pixels of a region.
#[derive(Clone, Copy, Default)]
struct Region {
    pixels: f64,
    samples: u64,
    difference: [f64; 3],
    variance: [f64; 3],
}

impl Region {
    /// Mean difference over its standard error. Where there is no noise, as when a furnace is sampled by the cosine, rounding
    /// is the error.
    fn scores(&self, rounding: f64) -> [f64; 3] {
        let least = self.pixels * rounding;
        std::array::from_fn(|c| self.difference[c] / (self.variance[c] + least * least).sqrt())
    }
}

impl Agreement {
    fn of(view: &View, difference: &Film, covered: &[bool]) -> Self {
        let region = difference.region();
        let (width, height) = (region.width() as usize, region.height() as usize);
        let mut regions = vec![Region::default(); REGIONS * REGIONS];
        let pixels = difference.means().into_iter().zip(difference.variances());
        for (i, (mean, variance)) in pixels.enumerate().filter(|(i, _)| covered[*i]) {
            let (x, y) = (i % width, i / width);
            let sums = &mut regions[y * REGIONS / height * REGIONS + x * REGIONS / width];
            sums.pixels += 1.0;
            sums.samples += u64::from(difference.count(region.x0 + x as u32, region.y0 + y as u32));
            for c in 0..3 {
                sums.difference[c] += f64::from(mean[c]);
                sums.variance[c] += f64::from(variance[c]);
            }
        }
        let scores: Vec<[f64; 3]> = regions
            .iter()
            .filter(|region| region.samples >= LEAST_SAMPLES)
            .map(|region| region.scores(ROUNDING * view.rms))
            .collect();
        let all = || scores.iter().flatten();
        let n = all().count() as f64;
        let greatest = all().map(|z| z.abs()).reduce(f64::max).unwrap_or(f64::NAN);
        let variance = all().map(|z| z * z).sum::<f64>() / n;
        // Channels go together: as many numbers as regions. Their mean square is χ²/n, of variance 2/n.
        let most = 1.0 + 4.0 * (2.0 / scores.len() as f64).sqrt();
        let tells = scores.len() >= LEAST_REGIONS && variance.is_finite();
        Self {
            estimator: view.name,
            regions: scores.len(),
            mean_z: all().sum::<f64>() / n,
            variance_z: variance,
            greatest_z: greatest,
            agrees: tells.then_some(variance < most && greatest < 5.0),
        }
    }
}

impl Comparison {
    /// The double sum, then each view and its difference from the sum, and what those differences are multiplied with:
    /// grey is none.
    pub fn strip(&self) -> Result<(Raster, Vec<u32>)> {
        let width = self.sum.region().width() as usize;
        let sums = self.sum.means();
        let seen = sums
            .iter()
            .zip(&self.covered)
            .filter(|(_, covered)| **covered);
        let brightest = seen
            .flat_map(|(pixel, _)| *pixel)
            .fold(f32::MIN_POSITIVE, f32::max);
        let shown = |pixel: [f32; 3]| Rgb::from(pixel.map(|value| value / brightest));
        let raster = |pixels: Vec<Rgb>| Raster::new(width, pixels);

        let mut images = vec![raster(sums.iter().map(|&pixel| shown(pixel)).collect())?];
        let mut gains = Vec::new();
        let last = self.rows.last();
        for (index, view) in self.views.iter().enumerate() {
            let apart = last.map_or(0.0, |row| row.relative_rms[index]) * view.rms;
            let gain = VISIBLE * f64::from(brightest) / apart.max(f64::MIN_POSITIVE);
            let gain = libm::exp2(libm::floor(libm::log2(gain)).clamp(0.0, 16.0)) as u32;
            let means = view.film.means();
            let difference = means.iter().zip(&sums).zip(&self.covered);
            let difference = difference.map(|((a, b), &covered)| {
                let scale = if covered {
                    gain as f32 / brightest
                } else {
                    0.0
                };
                Rgb::from(std::array::from_fn(|c| (a[c] - b[c]).mul_add(scale, GREY)))
            });
            images.push(raster(means.iter().map(|&pixel| shown(pixel)).collect())?);
            images.push(raster(difference.collect())?);
            gains.push(gain);
        }
        let images: Vec<&Raster> = images.iter().collect();
        Ok((Raster::strip(&images)?, gains))
    }
}

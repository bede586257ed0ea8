//! Light probes: points that look all around, and keep the light that arrives as spherical harmonics.
//!
//! A probe is a sensor like a camera, and its waves are those of a render. In place of the film each path's radiance is
//! projected: `4π L(d) Yₗₘ(d)` for a direction d drawn uniformly over the sphere. ∫ Yₗₘ is 0 for l > 0, so there a constant may
//! be taken from L without a change of the mean: the mean radiance, and only what differs from it makes noise (control
//! variates: Owen 2013, "Monte Carlo theory, methods and examples", sec. 8.9). Light that is the same from everywhere has
//! no other coefficient, to rounding.
//!
//! The samples come in [`SETS`] sets with
//! independent random numbers: their means estimate the coefficients, and their spread the standard errors, whether samples
//! within a set are independent or not.

use super::{Control, Settings, all_processors, workers};
use crate::error::{Error, Result};
use crate::film::AovSet;
use crate::film::exact::accepts;
use crate::lanes::{WIDTH, f32x8, u32x8};
use crate::scene::Scene;
use crate::scene::description::{Description, MAX_SIDE};
use crate::scene::sensor::{Sensor, probe_directions};
use crate::sh::{Basis, MAX_DEGREE, Probe, coefficients};
use crate::stats::Stats;
use crate::wavefront::{self, Context, Tally, Wave, Workspace};
use glam::Vec3;
use std::f64::consts::PI;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;
use wide::f64x4;

/// Independent sets of samples: standard errors have one degree of freedom less.
pub const SETS: u32 = 16;

/// The most coefficients of all probes: with their errors they take 800 MB.
const MOST_COEFFICIENTS: usize = 1 << 24;

/// The light that arrives at a point.
#[derive(Clone, Debug)]
pub struct Baked {
    /// World space.
    pub position: Vec3,
    /// Radiance, with standard errors: (coefficient − true value) / error follows Student's t with [`SETS`] − 1 degrees of
    /// freedom.
    pub probe: Probe,
}

/// Probes, and what they took.
#[derive(Clone, Debug)]
pub struct BakedProbes {
    /// In the order of their positions; those that [`Control::stop`] left undone are missing at the end.
    pub probes: Vec<Baked>,
    /// Samples of each.
    pub spp: u32,
    /// Samples kept out, for they were not finite or 2³² and more.
    pub rejected: u64,
    /// What it took.
    pub stats: Stats,
}

/// The light that arrives at points of a scene, to a degree. Of the settings, those of the film and the tile are not looked
/// at; samples per pixel are samples of each probe, rounded up to a multiple of [`SETS`].
///
/// The coefficients are a function of scene, settings and seed alone, whatever the number of threads and the size of waves.
///
/// # Errors
/// [`Error::Usage`] for a setting out of its range, a position that is not finite, no position or more than 65,535, more
/// coefficients than memory should hold, or when workers cannot be started.
pub fn bake(
    description: &Description,
    positions: &[Vec3],
    degree: usize,
    settings: &Settings,
    control: &Control,
) -> Result<BakedProbes> {
    settings.check()?;
    check(positions, degree)?;
    let begin = Instant::now();
    let threads = settings.threads.unwrap_or_else(all_processors);
    let pool = workers(threads)?;
    let scene = pool.install(|| Scene::compile_with(description, settings.bvh));
    let sampler = settings.random_numbers();
    let ctx = Context {
        aovs: AovSet::default(),
        ..settings.context(&scene, Sensor::Probes(positions), &sampler)
    };
    let plan = Plan::new(settings);
    let build = begin.elapsed();

    let basis = Basis::new(degree);
    let slots: Vec<Mutex<Slot>> = positions.iter().map(|_| Mutex::default()).collect();
    let next = AtomicUsize::new(0);
    let begin = Instant::now();
    let tallies = pool.broadcast(|_| {
        let mut ws = Workspace::new(plan.largest_wave(), &scene, ctx.aovs);
        let mut values = vec![f32x8::ZERO; coefficients(degree)];
        while !control.stop.load(Ordering::Relaxed) {
            let task = next.fetch_add(1, Ordering::Relaxed);
            let (probe, run) = (task / plan.runs(), task % plan.runs());
            let Some(slot) = slots.get(probe) else {
                break;
            };
            let mut sets = plan.sets(run, degree);
            for wave in plan.waves(probe, run) {
                wavefront::trace(&ctx, &wave, &mut ws);
                for (set, radiance) in sets
                    .iter_mut()
                    .zip(ws.radiance.chunks_exact(wave.samples as usize))
                {
                    set.add(
                        &ctx,
                        &basis,
                        (probe, wave.first_sample),
                        radiance,
                        &mut values,
                    );
                }
                ws.tally.added();
                (control.progress)(wave.paths() as u64);
            }
            let mut slot = slot.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
            slot.finish(sets);
        }
        ws.tally
    });
    let render = begin.elapsed();

    let mut tally = Tally::default();
    tallies.iter().for_each(|each| tally.merge(each));
    let source = format!(
        "{}, a probe of {} samples",
        description.name,
        plan.samples * SETS
    );
    let (mut probes, mut rejected) = (Vec::with_capacity(positions.len()), 0);
    for (slot, &position) in slots.into_iter().zip(positions) {
        let slot = slot
            .into_inner()
            .unwrap_or_else(|poisoned| poisoned.into_inner());
        let Some(estimates) = slot.estimates else {
            break;
        };
        rejected += slot.rejected;
        let (coefficients, standard_errors) = estimates.into_iter().unzip();
        let probe = Probe {
            standard_errors: Some(standard_errors),
            source: Some(source.clone()),
            ..Probe::radiance(coefficients)?
        };
        probes.push(Baked { position, probe });
    }
    Ok(BakedProbes {
        probes,
        spp: plan.samples * SETS,
        rejected,
        stats: Stats {
            threads,
            build,
            render,
            tally,
        },
    })
}

fn check(positions: &[Vec3], degree: usize) -> Result<()> {
    let wrong = |message: String| Err(Error::Usage(message));
    if degree > MAX_DEGREE {
        return wrong(format!(
            "the greatest degree (bands) is {degree}; it can be 0 to {MAX_DEGREE}"
        ));
    }
    if positions.is_empty() || positions.len() > MAX_SIDE as usize {
        return wrong(format!(
            "{} probes are asked for; there can be 1 to {MAX_SIDE} at a time",
            positions.len()
        ));
    }
    let count = positions.len() * coefficients(degree);
    if count > MOST_COEFFICIENTS {
        return wrong(format!(
            "{} probes of degree {degree} have {count} coefficients, and {MOST_COEFFICIENTS} are the most at a time; ask for \
             fewer probes or bands",
            positions.len()
        ));
    }
    match positions.iter().position(|position| !position.is_finite()) {
        Some(at) => wrong(format!(
            "probe {at} (counted from 0) is at {}; coordinates are finite numbers",
            positions[at]
        )),
        None => Ok(()),
    }
}

/// How the samples of a probe are cut into waves: runs of sets, and each run's samples in turn. A worker takes a run.
#[derive(Clone, Copy, Debug)]
struct Plan {
    /// Of each set.
    samples: u32,
    /// Of a wave: whole batches, so that sample numbers and lanes go together in waves of any size.
    samples_of_wave: u32,
    sets_of_run: u32,
}

impl Plan {
    fn new(settings: &Settings) -> Self {
        let samples = settings.spp.div_ceil(SETS);
        let whole_batches = settings.wave / WIDTH as u32 * WIDTH as u32;
        Self {
            samples,
            samples_of_wave: samples.min(whole_batches),
            sets_of_run: (settings.wave / samples).clamp(1, SETS),
        }
    }

    fn runs(&self) -> usize {
        SETS.div_ceil(self.sets_of_run) as usize
    }

    fn largest_wave(&self) -> usize {
        self.sets_of_run as usize * self.samples_of_wave as usize
    }

    fn first_set(&self, run: usize) -> u32 {
        run as u32 * self.sets_of_run
    }

    fn sets(&self, run: usize, degree: usize) -> Vec<Set> {
        let first = self.first_set(run);
        let end = (first + self.sets_of_run).min(SETS);
        (first..end)
            .map(|number| Set::new(number, degree))
            .collect()
    }

    fn waves(&self, probe: usize, run: usize) -> impl Iterator<Item = Wave> {
        let Self {
            samples,
            samples_of_wave,
            sets_of_run,
        } = *self;
        let x = self.first_set(run);
        let firsts = (0..samples).step_by(samples_of_wave as usize);
        firsts.map(move |first_sample| Wave {
            x,
            y: probe as u32,
            width: sets_of_run.min(SETS - x),
            height: 1,
            first_sample,
            samples: samples_of_wave.min(samples - first_sample),
        })
    }
}

/// Σ L(d) Yₗₘ(d) and Σ Yₗₘ(d) over the samples of a set.
struct Set {
    number: u32,
    kept: u32,
    rejected: u64,
    /// For each coefficient, of each channel and of the basis alone, by lane: samples are added in their order, whatever the
    /// waves.
    sums: Vec<[[f64x4; 2]; 4]>,
}

impl Set {
    fn new(number: u32, degree: usize) -> Self {
        Self {
            number,
            kept: 0,
            rejected: 0,
            sums: vec![[[f64x4::ZERO; 2]; 4]; coefficients(degree)],
        }
    }

    /// Adds the paths of consecutive samples. `values` is room for the basis.
    fn add(
        &mut self,
        ctx: &Context,
        basis: &Basis,
        (probe, first_sample): (usize, u32),
        radiance: &[[f32; 4]],
        values: &mut [f32x8],
    ) {
        for (batch, paths) in radiance.chunks(WIDTH).enumerate() {
            let first = first_sample + (batch * WIDTH) as u32;
            let sample = u32x8::splat(first) + u32x8::new([0, 1, 2, 3, 4, 5, 6, 7]);
            let pixel = u32x8::splat((probe as u32) << 16 | self.number);
            let path = ctx.sampler.path_key(pixel, sample);
            basis.evaluate(&probe_directions(ctx.sampler, path), values);

            let mut channels = [[0.0; WIDTH]; 4];
            for (lane, path) in paths.iter().enumerate() {
                if path[..3].iter().all(|&x| accepts(x)) {
                    self.kept += 1;
                    (0..3).for_each(|c| channels[c][lane] = path[c]);
                    channels[3][lane] = 1.0;
                } else {
                    self.rejected += 1;
                }
            }
            let channels = channels.map(f32x8::new);
            for (sums, &value) in self.sums.iter_mut().zip(&*values) {
                for (sum, channel) in sums.iter_mut().zip(channels) {
                    let [a, b, c, d, e, f, g, h] = (value * channel).to_array().map(f64::from);
                    sum[0] += f64x4::new([a, b, c, d]);
                    sum[1] += f64x4::new([e, f, g, h]);
                }
            }
        }
    }

    /// The sums of each coefficient.
    fn totals(&self) -> impl Iterator<Item = [f64; 4]> {
        self.sums
            .iter()
            .map(|sums| sums.map(|[low, high]| (low + high).reduce_add()))
    }

    /// The coefficients that the set estimates, with the mean radiance as the others found it: theirs is independent of the
    /// set's samples, so the estimate is right in the mean, as with its own it would not be.
    fn estimates(&self, others: [f64; 3]) -> Vec<[f64; 3]> {
        let scale = 4.0 * PI / f64::from(self.kept.max(1));
        let totals = self.totals().enumerate();
        let estimate = |(i, [r, g, b, basis]): (usize, [f64; 4])| {
            let control = if i == 0 { 0.0 } else { basis };
            let [x, y, z] = others.map(|mean| mean * control);
            [r - x, g - y, b - z].map(|sum| sum * scale)
        };
        totals.map(estimate).collect()
    }
}

/// Mean radiance of all sets but one.
fn mean_of_others(sets: &[Set], number: u32) -> [f64; 3] {
    let mut sums = [0.0; 4];
    let others = sets.iter().filter(|set| set.number != number);
    // Y₀₀ is constant.
    for total in others.filter_map(|set| set.totals().next()) {
        (0..4).for_each(|i| sums[i] += total[i]);
    }
    let [r, g, b, basis] = sums;
    [r, g, b].map(|sum| if basis > 0.0 { sum / basis } else { 0.0 })
}

/// A probe: its sets until all are there, then what they say.
#[derive(Default)]
struct Slot {
    sets: Vec<Set>,
    rejected: u64,
    /// Each coefficient and its standard error.
    estimates: Option<Vec<([f64; 3], [f64; 3])>>,
}

impl Slot {
    fn finish(&mut self, sets: Vec<Set>) {
        self.sets.extend(sets);
        if self.sets.len() < SETS as usize {
            return;
        }
        let mut sets = std::mem::take(&mut self.sets);
        sets.sort_by_key(|set| set.number);
        self.rejected = sets.iter().map(|set| set.rejected).sum();
        let estimates: Vec<Vec<[f64; 3]>> = sets
            .iter()
            .map(|set| set.estimates(mean_of_others(&sets, set.number)))
            .collect();
        let n = f64::from(SETS);
        let mut sum = vec![[0.0; 3]; estimates[0].len()];
        for estimates in &estimates {
            for (sum, estimate) in sum.iter_mut().zip(estimates) {
                (0..3).for_each(|c| sum[c] += estimate[c]);
            }
        }
        let mean: Vec<[f64; 3]> = sum.iter().map(|sum| sum.map(|sum| sum / n)).collect();
        let mut squares = vec![[0.0; 3]; mean.len()];
        for estimates in &estimates {
            for ((square, mean), estimate) in squares.iter_mut().zip(&mean).zip(estimates) {
                for c in 0..3 {
                    let off = estimate[c] - mean[c];
                    square[c] += off * off;
                }
            }
        }
        let error = |square: f64| (square / (n * (n - 1.0))).sqrt();
        let errors = squares.into_iter().map(|square| square.map(error));
        self.estimates = Some(mean.into_iter().zip(errors).collect());
    }
}

//! Raw arguments: what can be typed. What it means together is for the commands to check.

use super::{batch, bench, compare, dump, merge, sh};
use crate::bvh::Quality;
pub(super) use crate::film::parse_size as size;
use crate::film::tonemap::{Operator, Tonemap};
use crate::film::{AovSet, Region, Shard};
use crate::render::DEFAULT_WAVE;
use crate::scene::builtin;
use crate::scene::cache::Cache;
use crate::scene::description::{Description, SamplerKind, Strategy, choices};
use crate::scene::toml::Change;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, Parser, Subcommand};
use std::ops::Range;
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::Arc;
use std::time::Duration;

const EXAMPLES: &str = "\
Examples:
  ondine render cornell                    a first picture: cornell.exr and cornell.png
  ondine scenes cornell > room.toml        a scene file to start from
  ondine render room.toml --spp 1024 -o room-fine.exr
  ondine info room-fine.exr                what it holds

Exit codes: 0 done, 1 the answer is no (compare, dump --check, bench) or a job failed (batch), 2 bad input or usage, 130 interrupted.";

const RENDER_EXAMPLES: &str = "\
Examples:
  ondine render cornell --size 1024x1024 --spp 256
  ondine render room.toml --time 60                      the best image of one minute
  ondine render room.toml --crop 100,80,228,176 -o part.exr
  ondine render room.toml --aov albedo,normal,depth --tonemap aces --exposure -0.5
  ondine render room.toml --set materials.ball.roughness=0.2 --set 'lights.0.radiance=[20, 18, 15]'
  ondine render model.glb --set 'camera.position=[1, 2, 3]' --set materials.Wood.roughness=0.4
  ondine render room.toml --json | jq .mpaths_per_s
  ondine render room.toml --spp 4096 --resume            again after a kill: it goes on
  ondine render room.toml --shard 3/16 -o part-3.exr     one part; `ondine merge part-*.exr -o room.exr`

The image depends on scene, settings and seed alone: threads and wave size do not change a bit of it.
Ctrl-C writes what there is and exits with 130; a second Ctrl-C quits at once.";

const RAYS_FORMATS: &str = "\
Examples:
  ondine rays bunny.ply primary.f32 --threads 1
  ondine rays bunny.ply shadow.f32 --kind any --json | jq .mrays_per_s

Rays pass through the queues and kernels of a render. Time is that of tracing alone.";

/// Ondine, a wavefront path tracer for the CPU: eight-lane stages, exact film, the same bits every time.
#[derive(Debug, Parser)]
#[command(name = "ondine", version, after_help = EXAMPLES, max_term_width = 110)]
pub(super) struct Arguments {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// Render a scene to an OpenEXR image and a PNG
    Render(RenderArgs),
    /// Show a scene in the browser while it is rendered
    #[cfg(feature = "view")]
    View(super::view::ViewArgs),
    /// Render the jobs of a file: scenes, cameras, parameters
    Batch(batch::BatchArgs),
    /// Put parts of an image together, bit for bit the whole
    Merge(merge::MergeArgs),
    /// Tell noise from bias in two images of one scene
    Compare(compare::CompareArgs),
    /// Show what a scene or an OpenEXR image holds
    Info(InfoArgs),
    /// Measure how fast given rays meet a mesh
    Rays(RaysArgs),
    /// Measure this machine and this build, with proof that the images are right
    Bench(bench::BenchArgs),
    /// Spherical harmonics: the basis, lobes, environments, shading, probes
    #[command(subcommand)]
    Sh(sh::Command),
    /// List the built-in scenes, or print one as a scene file
    Scenes(ScenesArgs),
    /// Write what passes between the stages, for a port to be held to
    Dump(Box<dump::DumpArgs>),
}

/// Render a scene to an OpenEXR image and a PNG
#[derive(Args, Debug)]
#[command(after_help = RENDER_EXAMPLES)]
pub(super) struct RenderArgs {
    /// A scene (.toml, .gltf, .glb, .pbrt), meshes (.obj, .ply), or the name of a built-in scene (see `ondine scenes`)
    pub scene: String,

    /// Samples per pixel [default: the scene's, or 64; as many as fit with --time]
    #[arg(long, value_name = "N", help_heading = "Image",
          allow_negative_numbers = true, value_parser = whole::<u32>)]
    pub spp: Option<u32>,
    #[command(flatten)]
    pub changes: ChangeArgs,
    #[command(flatten)]
    pub settings: SettingsArgs,
    /// Render only these pixels of the image; x1,y1 lies past the last
    #[arg(
        long,
        value_name = "x0,y0,x1,y1",
        help_heading = "Image",
        allow_hyphen_values = true
    )]
    pub crop: Option<Region>,

    /// Render one part of N, for `ondine merge` to put together; K from 1
    #[arg(
        long,
        value_name = "K/N",
        help_heading = "Parts",
        allow_hyphen_values = true
    )]
    pub shard: Option<Shard>,
    /// Render these samples of each pixel, counted from 0; the last is not among them, and says what --spp would
    #[arg(long, value_name = "a..b", help_heading = "Parts", allow_hyphen_values = true,
          value_parser = samples, conflicts_with_all = ["spp", "time"])]
    pub samples: Option<Range<u32>>,
    /// Refuse to render where the scene's hash is another: what was planned with it must not change
    #[arg(long, value_name = "HASH", help_heading = "Parts")]
    pub scene_hash: Option<String>,
    /// Go on from the checkpoint, or from OUT.exr itself; what is there already is not rendered again
    #[arg(long, help_heading = "Parts")]
    pub resume: bool,
    /// Write OUT.checkpoint.exr every so many seconds, for --resume to go on from [default: 60 with --resume]
    #[arg(long, value_name = "SECONDS", help_heading = "Parts",
          allow_negative_numbers = true, value_parser = seconds)]
    pub checkpoint: Option<Duration>,

    /// The image to write [default: SCENE.exr in this folder]; the PNG goes beside it
    #[arg(short, long, value_name = "OUT.exr", help_heading = "Output")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub picture: PictureArgs,
    /// Extra layers of the EXR: albedo, normal, depth of the first surface met; bounces: radiance by path length
    #[arg(long, value_name = "LIST", help_heading = "Output")]
    pub aov: Option<AovSet>,
    /// Print one JSON object on stdout instead of a summary
    #[arg(long, help_heading = "Output")]
    pub json: bool,
    /// Show no progress bar
    #[arg(short, long, help_heading = "Output")]
    pub quiet: bool,

    /// Stop after this many seconds, with the samples traced by then
    #[arg(long, value_name = "SECONDS", help_heading = "Running",
          allow_negative_numbers = true, value_parser = seconds)]
    pub time: Option<Duration>,
    #[command(flatten)]
    pub workers: WorkerArgs,
}

/// How the work is done: no bit of an image depends on it.
#[derive(Args, Debug)]
pub(super) struct WorkerArgs {
    /// Worker threads [default: one for each processor]
    #[arg(long, value_name = "N", help_heading = "Running",
          allow_negative_numbers = true, value_parser = whole::<usize>)]
    pub threads: Option<usize>,
    /// How trees of triangles are built: fast, or best (slower to build, faster to trace); changes the speed alone
    #[arg(long, default_value = "fast", help_heading = "Running", value_parser = choice::<Quality>(&["fast", "best"]))]
    pub bvh: Quality,
    /// Paths that a worker carries at a time; changes the speed alone
    #[arg(long, value_name = "N", default_value_t = DEFAULT_WAVE, help_heading = "Running",
          allow_negative_numbers = true, value_parser = whole::<u32>)]
    pub wave: u32,
}

/// Other values for what a scene says.
#[derive(Args, Debug)]
pub(super) struct ChangeArgs {
    /// Another value for what the scene says, as in materials.ball.roughness=0.2; of what is no .toml scene, cameras and
    /// materials can be changed; may be given several times
    #[arg(long = "set", value_name = "KEY=VALUE", help_heading = "Image")]
    set: Vec<String>,
}

impl ChangeArgs {
    /// The scene, changed.
    ///
    /// # Errors
    /// As [`builtin::open_changed`].
    pub fn open(&self, scene: &str) -> crate::error::Result<Description> {
        builtin::open_changed(scene, &self.parse()?, &mut Cache::default())
    }

    /// The changes.
    ///
    /// # Errors
    /// As [`Change::parse`].
    pub fn parse(&self) -> crate::error::Result<Vec<Arc<Change>>> {
        let set = self.set.iter();
        set.map(|text| Change::parse(text).map(Arc::new)).collect()
    }
}

/// The picture beside an image.
#[derive(Args, Clone, Copy, Debug)]
pub(super) struct PictureArgs {
    /// Write no PNG
    #[arg(long, help_heading = "Output")]
    pub no_png: bool,
    /// Tone curve of the PNG
    #[arg(long, value_name = "CURVE", default_value = "linear", help_heading = "Output",
          value_parser = choice::<Operator>(&["linear", "reinhard", "aces"]))]
    pub tonemap: Operator,
    /// Exposure of the PNG: radiance times 2^EV
    #[arg(long, value_name = "EV", default_value = "0", help_heading = "Output",
          allow_negative_numbers = true, value_parser = exposure)]
    pub exposure: f32,
}

/// What decides the bits of an image, beside the scene and the samples.
#[derive(Args, Debug)]
pub(super) struct SettingsArgs {
    /// Width and height in pixels [default: the scene's]
    #[arg(long, value_name = "WxH", help_heading = "Image",
          allow_hyphen_values = true, value_parser = size)]
    pub size: Option<(u32, u32)>,
    /// The camera, by its name in the scene [default: the scene's first]
    #[arg(long, value_name = "NAME", help_heading = "Image")]
    pub camera: Option<String>,
    /// Seed of the random numbers [default: the scene's, or 0]
    #[arg(long, value_name = "N", help_heading = "Image",
          allow_negative_numbers = true, value_parser = whole::<u64>)]
    pub seed: Option<u64>,

    /// Greatest number of edges of a path: 1 sees lights only, 2 is direct light [default: the scene's, or 5]
    #[arg(long, value_name = "N", help_heading = "Light transport",
          allow_negative_numbers = true, value_parser = whole::<u32>)]
    pub path_length: Option<u32>,
    /// How light is looked for [default: the scene's, or mis]
    #[arg(long, help_heading = "Light transport", value_parser = choice::<Strategy>(&["uniform", "cosine", "light", "mis"]))]
    pub strategy: Option<Strategy>,
    /// Where random numbers come from [default: the scene's, or sobol]
    #[arg(long, help_heading = "Light transport", value_parser = choice::<SamplerKind>(&["pcg", "sobol"]))]
    pub sampler: Option<SamplerKind>,
    /// First path edge at which Russian roulette may end a path [default: the scene's, or none]
    #[arg(long, value_name = "EDGE", help_heading = "Light transport",
          allow_negative_numbers = true, value_parser = whole::<u32>)]
    pub roulette: Option<u32>,
}

/// Show what a scene or an OpenEXR image holds
#[derive(Args, Debug)]
pub(super) struct InfoArgs {
    /// An OpenEXR image, a scene or mesh file, or the name of a built-in scene
    pub file: String,
    /// Give the image hash of these pixels alone, as if only they had been rendered
    #[arg(long, value_name = "x0,y0,x1,y1", allow_hyphen_values = true)]
    pub crop: Option<Region>,
    /// Print one JSON object on stdout
    #[arg(long)]
    pub json: bool,
}

/// List the built-in scenes, or print one as a scene file
#[derive(Args, Debug)]
pub(super) struct ScenesArgs {
    /// Print the text of this scene
    pub name: Option<String>,
}

/// Measure how fast given rays meet a mesh
#[derive(Args, Debug)]
#[command(after_help = RAYS_FORMATS)]
pub(super) struct RaysArgs {
    /// The mesh: a PLY file
    pub mesh: PathBuf,
    /// The rays: little-endian 32-bit floats, eight a ray: ox oy oz tmin dx dy dz tmax
    pub rays: PathBuf,
    /// What to look for: the closest hit, or whether there is any
    #[arg(long, default_value = "closest", value_parser = choice::<RayKind>(&["closest", "any"]))]
    pub kind: RayKind,
    /// How the tree is built: fast, or best (slower to build, faster to trace where triangles are long)
    #[arg(long, default_value = "fast", value_parser = choice::<Quality>(&["fast", "best"]))]
    pub bvh: Quality,
    /// Worker threads [default: one for each processor]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = threads)]
    pub threads: Option<usize>,
    /// Measured runs, after one to warm up
    #[arg(long, value_name = "N", default_value_t = 7, allow_negative_numbers = true, value_parser = repeats)]
    pub repeat: usize,
    /// Write what each ray met: f32 distance, u32 triangle; a miss is inf and 0xffffffff
    #[arg(long, value_name = "OUT")]
    pub hits: Option<PathBuf>,
    /// Print one JSON object instead of a summary
    #[arg(long)]
    pub json: bool,
}

/// What rays look for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RayKind {
    Closest,
    Any,
}

choices!(RayKind, "kind of ray": "closest" = Closest, "any" = Any);

/// One of a few names, which the help lists.
pub(super) fn choice<T>(names: &'static [&'static str]) -> impl TypedValueParser<Value = T>
where
    T: FromStr<Err = crate::error::Error> + Clone + Send + Sync + 'static,
{
    PossibleValuesParser::new(names).try_map(|name| name.parse::<T>())
}

/// A whole number that the type holds; whether it is a sensible one is checked with the other settings.
pub(super) fn whole<T: FromStr + Bounds>(text: &str) -> Result<T, String> {
    text.parse().map_err(|_| {
        let unsigned = !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
        let what = if unsigned {
            "it is too large"
        } else {
            "it is not a whole number"
        };
        format!("{what}; write one from 0 to {}", T::MAX)
    })
}

/// The greatest value of a type.
pub(super) trait Bounds {
    const MAX: u64;
}

impl Bounds for u32 {
    const MAX: u64 = u32::MAX as u64;
}

impl Bounds for u64 {
    const MAX: u64 = u64::MAX;
}

impl Bounds for usize {
    const MAX: u64 = usize::MAX as u64;
}

pub(super) fn threads(text: &str) -> Result<usize, String> {
    within(text, 1, 1024)
}

pub(super) fn repeats(text: &str) -> Result<usize, String> {
    within(text, 1, 1_000_000)
}

pub(super) fn within(text: &str, low: usize, high: usize) -> Result<usize, String> {
    whole(text)
        .ok()
        .filter(|number| (low..=high).contains(number))
        .ok_or_else(|| format!("write a whole number from {low} to {high}"))
}

pub(super) fn exposure(text: &str) -> Result<f32, String> {
    text.parse()
        .ok()
        .filter(|&exposure| Tonemap::can_expose(exposure))
        .ok_or_else(|| {
            "an exposure is a number from -64 to 64; 1 doubles the brightness".to_owned()
        })
}

pub(super) fn seconds(text: &str) -> Result<Duration, String> {
    /// About thirty years.
    const LONGEST: f64 = 1e9;
    text.parse()
        .ok()
        .filter(|&seconds| seconds > 0.0 && seconds <= LONGEST)
        .map(Duration::from_secs_f64)
        .ok_or_else(|| "a time is a number of seconds above 0 and at most 1e9".to_owned())
}

/// A range of sample indices, not empty.
pub(super) fn samples(text: &str) -> std::result::Result<Range<u32>, String> {
    text.split_once("..")
        .and_then(|(from, to)| Some(from.trim().parse().ok()?..to.trim().parse().ok()?))
        .filter(|samples: &Range<u32>| !samples.is_empty())
        .ok_or_else(|| "write the first sample and the one past the last, as in 0..16".to_owned())
}

//! A batch for several machines: a folder of plain files, with a command line for each shard of each image, that Slurm or
//! anything else which runs command lines can work off. Each line may be run again: what is there is not rendered twice.

use super::plan::{Job, Ready};
use super::scripts;
use crate::error::{Error, Result};
use crate::film::exr;
use crate::film::{Coverage, Shard, hexadecimal, write_whole};
use crate::scene::builtin;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::io::Write;
use std::path::{Path, PathBuf};

/// The version of `plan.json`.
const VERSION: u32 = 1;
/// Tasks of a job array: Slurm's `MaxArraySize` is 1001 unless set otherwise, and the first is 1.
const MOST_TASKS: usize = 1000;
/// Greatest number of shards of an image.
pub const MOST_SHARDS: u32 = 65_536;

/// What `plan.json` says.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Plan {
    version: u32,
    /// The folder, absolute.
    pub folder: PathBuf,
    /// Lines of `commands.txt` that a task of the array runs.
    pub lines_per_task: usize,
    /// The images, whose shards are the lines, in this order.
    pub images: Vec<PlannedImage>,
}

/// An image of a plan.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct PlannedImage {
    /// Its place in the job file.
    pub index: usize,
    /// Its output as the job file names it.
    pub name: String,
    /// The image, absolute.
    pub output: PathBuf,
    /// The hash of its scene.
    pub scene_hash: String,
    /// How many shards it has.
    pub shards: u32,
    /// The beginning of their files' names, which no image of other settings has.
    pub part: String,
    /// What makes a shard, before `--shard`.
    render: Vec<String>,
    /// What the PNG is to be like; none where there is none.
    picture: Vec<String>,
}

impl PlannedImage {
    fn new(job: &Job, ready: &Ready, shards: u32) -> Result<Self> {
        let output = absolute(&ready.exr)?;
        let render = arguments(job, ready)?;
        let pixels = ready.settings.region.pixels() as u64;
        let blocks = Coverage::of_samples(0..ready.settings.spp, pixels).len();
        let mut hasher = Sha256::new();
        for part in [ready.scene_hash(), &job.name]
            .into_iter()
            .chain(render.iter().map(String::as_str))
        {
            hasher.update(part);
            hasher.update([0]);
        }
        let digest = hexadecimal(&hasher.finalize());
        let stem = Path::new(&job.name).with_extension("");
        let stem = super::template::safe(&stem.display().to_string());
        Ok(Self {
            index: job.index,
            name: job.name.clone(),
            output,
            scene_hash: ready.scene_hash().to_owned(),
            // A shard has one block at least.
            shards: u32::try_from(blocks).unwrap_or(u32::MAX).min(shards),
            part: format!("{stem}-{}", &digest[..12]),
            render,
            picture: match ready.png {
                None => vec!["--no-png".to_owned()],
                Some(tonemap) => vec![
                    format!("--tonemap={}", tonemap.operator),
                    format!("--exposure={}", tonemap.exposure),
                ],
            },
        })
    }

    /// The command line of a shard.
    pub(super) fn render_words(&self, program: &str, parts: &Path, shard: Shard) -> Vec<String> {
        let tail = [
            format!("--shard={shard}"),
            "--resume".to_owned(),
            "--no-png".to_owned(),
            "--quiet".to_owned(),
            format!("--output={}", self.file(parts, shard).display()),
        ];
        let head = [program.to_owned(), "render".to_owned()];
        let words = head.iter().chain(&self.render).chain(&tail);
        words.cloned().collect()
    }

    /// What the merging has after the parts.
    pub(super) fn merge_words(&self) -> Vec<String> {
        let output = format!("--output={}", self.output.display());
        std::iter::once(output)
            .chain(self.picture.clone())
            .collect()
    }

    /// Where a shard's file is, below the folder of all.
    pub fn file(&self, parts: &Path, shard: Shard) -> PathBuf {
        let name = format!("{}.{}-of-{}.exr", self.part, shard.number(), shard.of());
        parts.join(name)
    }
}

/// What tells `ondine render` of a job, all of it: a default that changes later changes no image of the plan.
fn arguments(job: &Job, ready: &Ready) -> Result<Vec<String>> {
    let settings = &ready.settings;
    let scene = match Path::new(&*job.scene).is_file() || builtin::find(&job.scene).is_none() {
        true => absolute(Path::new(&*job.scene))?.display().to_string(),
        false => job.scene.to_string(),
    };
    let mut words = vec![scene];
    for change in job.changes.iter() {
        if change.value.contains('\n') {
            return Err(Error::Usage(format!(
                "{}: a command line has no room for a value of several lines; write it in one",
                change.origin
            )));
        }
        words.push(format!("--set={}={}", change.key, change.value));
    }
    let mut add = |option: &str, value: String| words.push(format!("--{option}={value}"));
    add("camera", settings.camera.clone().unwrap_or_default());
    add("size", format!("{}x{}", settings.width, settings.height));
    add("crop", settings.region.to_string());
    add("spp", settings.spp.to_string());
    add("seed", settings.seed.to_string());
    add("path-length", settings.path_length.to_string());
    add("strategy", settings.strategy.to_string());
    add("sampler", settings.sampler.to_string());
    if let Some(edge) = settings.roulette {
        add("roulette", edge.to_string());
    }
    if settings.aovs != Default::default() {
        add("aov", settings.aovs.to_string());
    }
    Ok(words)
}

fn absolute(path: &Path) -> Result<PathBuf> {
    std::path::absolute(path).map_err(|source| Error::Read {
        path: path.to_owned(),
        source,
    })
}

impl Plan {
    /// For so many shards of each image, in `folder`. Nothing is written.
    ///
    /// # Errors
    /// [`Error::Usage`] for a job that no command line can tell.
    pub fn new<'a>(
        jobs: impl IntoIterator<Item = (&'a Job, &'a Ready)>,
        folder: &Path,
        shards: u32,
    ) -> Result<Self> {
        let images = jobs
            .into_iter()
            .map(|(job, ready)| PlannedImage::new(job, ready, shards))
            .collect::<Result<Vec<_>>>()?;
        let mut plan = Self {
            version: VERSION,
            folder: absolute(folder)?,
            lines_per_task: 1,
            images,
        };
        plan.lines_per_task = plan.shards().count().div_ceil(MOST_TASKS).max(1);
        Ok(plan)
    }

    /// Where the shards' files are.
    pub fn parts(&self) -> PathBuf {
        self.folder.join("parts")
    }

    /// Every shard, one for each line of `commands.txt`.
    pub fn shards(&self) -> impl Iterator<Item = (&PlannedImage, Shard)> {
        let of = |image| move |shard| (image, shard);
        let images = self.images.iter();
        images.flat_map(move |image| Shard::all(image.shards).map(of(image)))
    }

    /// How many tasks the array has.
    pub fn tasks(&self) -> usize {
        self.shards().count().div_ceil(self.lines_per_task)
    }

    /// Writes the folder; `program` is what its command lines run. Shards of an earlier plan stay, and are used where the
    /// image is the same.
    ///
    /// # Errors
    /// [`Error::Usage`] for a folder of other files, [`Error::Write`].
    pub fn write(&self, program: &Path) -> Result<()> {
        let json = self.folder.join("plan.json");
        let occupied =
            std::fs::read_dir(&self.folder).is_ok_and(|mut found| found.next().is_some());
        if occupied && !json.exists() {
            return Err(Error::Usage(format!(
                "--plan {}: this folder has other files, and no plan; name a new one",
                self.folder.display()
            )));
        }
        for folder in [
            self.parts(),
            self.folder.join("logs"),
            self.folder.join("merged"),
        ] {
            std::fs::create_dir_all(&folder).map_err(|source| Error::Write {
                path: folder.clone(),
                source,
            })?;
        }
        for (name, text) in scripts::files(self, &absolute(program)?) {
            write_whole(&self.folder.join(name), |file| {
                file.write_all(text.as_bytes())
            })?;
        }
        // Last: with it the folder is a plan.
        write_whole(&json, |file| {
            serde_json::to_writer_pretty(&mut *file, self)?;
            file.write_all(b"\n")
        })
    }

    /// Reads `plan.json` of a folder.
    ///
    /// # Errors
    /// [`Error::Read`], [`Error::Format`].
    pub fn read(folder: &Path) -> Result<Self> {
        let path = folder.join("plan.json");
        let bytes = std::fs::read(&path).map_err(|source| Error::Read {
            path: path.clone(),
            source,
        })?;
        let wrong = |why: String| {
            Error::format(
                &path,
                format!(
                    "this is no plan of this program ({why}); make it anew with `ondine batch JOBS.toml --plan`"
                ),
            )
        };
        let plan: Self =
            serde_json::from_slice(&bytes).map_err(|error| wrong(error.to_string()))?;
        let all = 1..=MOST_SHARDS;
        if plan.version != VERSION
            || plan.lines_per_task == 0
            || plan.images.iter().any(|image| !all.contains(&image.shards))
        {
            return Err(wrong("of another version".to_owned()));
        }
        // The folder may have been moved since.
        Ok(Self {
            folder: absolute(folder)?,
            ..plan
        })
    }

    /// What is there of it.
    pub fn progress(&self) -> Progress {
        let parts = self.parts();
        let mut progress = Progress::default();
        let mut line = 0;
        for image in &self.images {
            let mut header = None;
            let mut whole = true;
            for shard in Shard::all(image.shards) {
                line += 1;
                let path = image.file(&parts, shard);
                match part(&path, image, shard) {
                    Ok(found) => header = Some(found),
                    Err(what) => {
                        whole = false;
                        let task = (line - 1) / self.lines_per_task + 1;
                        progress.lacking.push(Lacking {
                            name: image.name.clone(),
                            shard: shard.to_string(),
                            task,
                            what,
                        });
                    }
                }
            }
            let merged = whole && header.is_some_and(|of| is_merged(&image.output, &of));
            if !merged {
                progress.unmerged.push(image.name.clone());
            }
        }
        progress.shards = line;
        progress
    }
}

/// What there is of a plan, and what is not.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Progress {
    /// How many there are to be.
    pub shards: usize,
    /// Shards that are missing or damaged.
    pub lacking: Vec<Lacking>,
    /// Images whose shards have not been put together.
    pub unmerged: Vec<String>,
}

/// A shard that is not there.
#[derive(Clone, Debug, Serialize)]
pub struct Lacking {
    /// The image, by its output in the job file.
    pub name: String,
    /// K/N.
    pub shard: String,
    /// The task of the array that makes it.
    pub task: usize,
    /// What is wrong with it.
    pub what: String,
}

impl Progress {
    /// The tasks of what is lacking, as `sbatch -a` takes them: `3,7-9`.
    pub fn tasks(&self) -> String {
        let mut ranges: Vec<(usize, usize)> = Vec::new();
        for lacking in &self.lacking {
            match ranges.last_mut() {
                Some((_, last)) if lacking.task <= *last + 1 => *last = lacking.task,
                _ => ranges.push((lacking.task, lacking.task)),
            }
        }
        let range = |&(first, last): &(usize, usize)| match first == last {
            true => first.to_string(),
            false => format!("{first}-{last}"),
        };
        ranges.iter().map(range).collect::<Vec<_>>().join(",")
    }
}

/// The header of a shard that is whole; what is wrong with it otherwise.
fn part(
    path: &Path,
    image: &PlannedImage,
    shard: Shard,
) -> std::result::Result<exr::ImageHeader, String> {
    if !path.exists() {
        return Err("missing".to_owned());
    }
    let found = exr::read_header(path).map_err(|error| format!("damaged: {error}"))?;
    let metadata = &found.metadata;
    if metadata.scene_hash != image.scene_hash || metadata.shard != Some(shard) {
        return Err(format!("{} is another image", path.display()));
    }
    match metadata.blocks.contains(&metadata.all_blocks().part(shard)) {
        true => Ok(found),
        false => Err("not finished".to_owned()),
    }
}

/// Whether an image is whole, and the one that a shard is of.
fn is_merged(output: &Path, shard: &exr::ImageHeader) -> bool {
    exr::read_header(output).is_ok_and(|found| {
        let metadata = &found.metadata;
        found.difference(shard).is_none()
            && metadata.spp == shard.metadata.spp
            && metadata.blocks.contains(&metadata.all_blocks())
    })
}

//! A batch for several machines: a folder of plain files, with a command line for each shard of each image, that Slurm or
//! anything else which runs command lines can work off. Each line may be run again: what is there is not rendered twice.

use super::plan::{Job, Ready};
use super::scenes::Scenes;
use super::scripts;
use crate::error::{Error, Result};
use crate::film::{Coverage, Shard, hexadecimal, write_whole};
use crate::scene::builtin;
use crate::scene::toml::Change;
use crate::scene::toml::names::quoted;
use glob::Pattern;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The version of `plan.json`.
const VERSION: u32 = 1;
/// Tasks of a job array: Slurm's `MaxArraySize` is 1001 unless set otherwise, and the first is 1.
const MOST_TASKS: usize = 1000;
/// Greatest number of shards of an image.
pub const MOST_SHARDS: u32 = 65_536;

/// Bytes of an output's name that the names of its shards begin with, at most.
const MOST_STEM: usize = 100;

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
    /// Where the folder was when its scripts were written, if it was moved since: that is where they work.
    #[serde(skip)]
    pub moved_from: Option<PathBuf>,
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
        in_a_line("the output", &output)?;
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
        let mut stem = super::template::safe(&stem.display().to_string());
        // A name can have 255 bytes, and this one comes from a path. The digest tells apart.
        let end = (0..=MOST_STEM)
            .rev()
            .find(|&end| stem.is_char_boundary(end));
        stem.truncate(end.unwrap_or(0));
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

    /// What has become of the scene since, if its shards can no longer be rendered.
    pub(super) fn change_of_scene(&self, scenes: &mut Scenes) -> Option<String> {
        let scene = self.scene();
        let changes = self
            .render
            .iter()
            .filter_map(|word| word.strip_prefix("--set="));
        let changes = changes.map(|text| Change::parse(text).map(Arc::new));
        let opened = changes
            .collect::<Result<Vec<_>>>()
            .and_then(|changes| scenes.open(scene, &changes));
        match opened {
            Ok(found) if found.hash == self.scene_hash => None,
            Ok(_) => Some(format!("{scene} was changed since")),
            Err(error) => Some(error.to_string()),
        }
    }

    /// The scene, as a command line names it.
    pub(super) fn scene(&self) -> &str {
        self.render.first().map_or("", String::as_str)
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

    /// The command line that puts the shards together, unless that is done. It names them by a pattern: no line could have
    /// thousands of paths.
    pub(super) fn merge_words(&self, program: &str, parts: &Path) -> Vec<String> {
        let parts = Pattern::escape(&parts.join(&self.part).display().to_string());
        let words = [
            program.to_owned(),
            "merge".to_owned(),
            "--skip-done".to_owned(),
            format!("{parts}.*-of-{}.exr", self.shards),
            format!("--output={}", self.output.display()),
        ];
        words.into_iter().chain(self.picture.clone()).collect()
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
        true => in_a_line("the scene", &absolute(Path::new(&*job.scene))?)?,
        false => job.scene.to_string(),
    };
    let mut words = vec![scene];
    for change in job.changes.iter() {
        // The origin shows the value as the job file has it, in several lines.
        if change.value.contains(char::is_control) {
            return Err(Error::Usage(format!(
                "set {} has a line break or another control character in its value, for which a command line has no room; \
                 write it in one line, with blanks",
                change.key
            )));
        }
        words.push(format!("--set={}={}", change.key, change.value));
    }
    let camera = settings.camera.clone().unwrap_or_default();
    // Whoever wrote the scene could have a command run otherwise.
    if camera.contains(char::is_control) {
        return Err(Error::Usage(format!(
            "{}: the camera {} has a line break or another control character in its name, for which a command line has no \
             room; rename it",
            job.scene,
            quoted(&camera)
        )));
    }
    words.push(format!("--camera={camera}"));
    words.push(format!("--scene-hash={}", ready.scene_hash()));
    words.extend(settings.words());
    Ok(words)
}

/// A path as a word of a line.
///
/// # Errors
/// [`Error::Usage`] where it would end the line, or is no text; `what` it is.
fn in_a_line(what: &str, path: &Path) -> Result<String> {
    match path.to_str() {
        Some(text) if !text.contains(char::is_control) => Ok(text.to_owned()),
        _ => Err(Error::Usage(format!(
            "--plan: {what} {} has a line break, another control character or bytes that are no UTF-8 in its path, for which \
             a command line has no room; rename it",
            quoted(&path.to_string_lossy())
        ))),
    }
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
    /// [`Error::Usage`] for a job or a folder that no command line can tell.
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
            moved_from: None,
        };
        in_a_line("the folder", &plan.folder)?;
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
    /// [`Error::Usage`] for a folder of other files and a program that no command line can name, [`Error::Write`].
    pub fn write(&self, program: &Path) -> Result<()> {
        let program = in_a_line("this program", &absolute(program)?)?;
        let json = self.folder.join("plan.json");
        let occupied =
            std::fs::read_dir(&self.folder).is_ok_and(|mut found| found.next().is_some());
        if occupied && !json.exists() {
            return Err(Error::Usage(format!(
                "--plan {}: this folder has other files, and no plan; name a new one",
                self.folder.display()
            )));
        }
        for folder in [self.parts(), self.folder.join("logs")] {
            std::fs::create_dir_all(&folder).map_err(|source| Error::Write {
                path: folder.clone(),
                source,
            })?;
        }
        for (name, text) in scripts::files(self, &program) {
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
        let here = absolute(folder)?;
        let same = matches!((here.canonicalize(), plan.folder.canonicalize()), (Ok(one), Ok(other)) if one == other);
        Ok(Self {
            moved_from: (!same).then_some(plan.folder),
            folder: here,
            ..plan
        })
    }
}

//! What there is of a plan for several machines, and which of its tasks make the rest.

use super::cluster::{Plan, PlannedImage};
use super::scenes::Scenes;
use crate::film::Shard;
use crate::film::exr::{self, ImageHeader};
use serde::Serialize;
use std::collections::HashSet;
use std::path::Path;

/// What there is of a plan, and what is not.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Progress {
    /// How many shards there are to be.
    pub shards: usize,
    /// Shards that are missing or damaged.
    pub lacking: Vec<Lacking>,
    /// Images whose shards have not been put together.
    pub unmerged: Vec<String>,
    /// Why the plan cannot be worked off to its end, if so.
    pub obsolete: Option<String>,
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
    /// That of a plan: files alone say what is there. Of shards that wait to be merged all pixels are read: damage that a merge would find has to be known.
    pub fn of(plan: &Plan) -> Self {
        let parts = plan.parts();
        let mut progress = Self {
            obsolete: plan
                .moved_from
                .as_ref()
                .map(|old| format!("its scripts work in {}, where it was", old.display())),
            ..Self::default()
        };
        // Scenes of shards that are lacking: one image of each is looked at, as opening them takes time.
        let mut scenes = Scenes::default();
        let mut looked_at = HashSet::new();
        for image in &plan.images {
            let first = progress.shards;
            let lacking_before = progress.lacking.len();
            progress.shards += image.shards as usize;
            let mut lack = |shard: Shard, what| {
                let line = first + shard.number() as usize - 1;
                progress.lacking.push(Lacking {
                    name: image.name.clone(),
                    shard: shard.to_string(),
                    task: line / plan.lines_per_task + 1,
                    what,
                });
            };
            let mut header = None;
            let mut whole = true;
            for shard in Shard::all(image.shards) {
                match part(&image.file(&parts, shard), image, shard) {
                    Ok(found) => header = Some(found),
                    Err(what) => {
                        whole = false;
                        lack(shard, what);
                    }
                }
            }
            if whole && header.is_some_and(|of| is_merged(&image.output, &of)) {
                continue;
            }
            for shard in Shard::all(image.shards).filter(|_| whole) {
                if let Err(error) = exr::read(&image.file(&parts, shard)) {
                    lack(shard, format!("damaged: {error}"));
                }
            }
            progress.unmerged.push(image.name.clone());
            let is_lacking = progress.lacking.len() > lacking_before;
            if is_lacking && progress.obsolete.is_none() && looked_at.insert(image.scene()) {
                progress.obsolete = image.change_of_scene(&mut scenes);
            }
        }
        progress
    }

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
fn part(path: &Path, image: &PlannedImage, shard: Shard) -> Result<ImageHeader, String> {
    if !path.exists() {
        return Err("missing".to_owned());
    }
    let found = exr::read_header(path).map_err(|error| format!("damaged: {error}"))?;
    let metadata = &found.metadata;
    if metadata.scene_hash != image.scene_hash || metadata.shard != Some(shard) {
        return Err(format!("{} is another image; delete it", path.display()));
    }
    match metadata.blocks.contains(&metadata.all_blocks().part(shard)) {
        true => Ok(found),
        false => Err("not finished".to_owned()),
    }
}

/// Whether an image is whole, and the one that a shard is of.
fn is_merged(output: &Path, shard: &ImageHeader) -> bool {
    exr::read_header(output).is_ok_and(|found| {
        let metadata = &found.metadata;
        found.difference(shard).is_none()
            && metadata.spp == shard.metadata.spp
            && metadata.blocks.contains(&metadata.all_blocks())
    })
}

//! Looks on while waves are traced, and keeps every record of every queue.

use super::Numbering;
use super::table::Table;
use crate::lanes::{Batch, Fields, Queue, Rgb, WIDTH};
use crate::material::Kind;
use crate::record;
use crate::wavefront::observe::{Observer, Step};
use crate::wavefront::queues::{Arrival, ArrivalX8, ShadowRayX8};
use crate::wavefront::{Context, Stage, Workspace, accumulate};
use std::collections::BTreeMap;

record! {
    /// The light of an encounter, term by term, and what the path has with it.
    pub struct Received, ReceivedX8 {
        /// The light.
        arrival: Arrival,
        /// Radiance of the path so far, this light included.
        radiance: Rgb,
    }
}

record! {
    /// What became of a shadow ray.
    pub struct Visibility, VisibilityX8 {
        /// 1 where it reached its light, else 0.
        visible: u32,
        /// As in [`PathRay`](crate::wavefront::queues::PathRay).
        path: u32,
    }
}

record! {
    /// What a path has once its shadow ray is done.
    pub struct Total, TotalX8 {
        /// Radiance of the path so far.
        radiance: Rgb,
        /// As in [`PathRay`](crate::wavefront::queues::PathRay).
        path: u32,
    }
}

/// Tables by edge and by their order in an edge.
type Tables = BTreeMap<(u32, Place), Table>;

/// The queues of an edge, in the order in which they are filled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Place {
    CameraRays,
    Vertices(Kind),
    MeshVertices(Kind),
    Encounters,
    MeshEncounters,
    Received,
    Rays,
    ShadowRays,
    Visible,
    Total,
}

impl Place {
    fn stage(self) -> Stage {
        match self {
            Place::CameraRays => Stage::Generate,
            Place::Vertices(_) | Place::MeshVertices(_) => Stage::Intersect,
            Place::Encounters | Place::MeshEncounters | Place::Visible => Stage::Intersect,
            Place::Rays => Stage::Shade,
            Place::ShadowRays => Stage::Nee,
            Place::Received | Place::Total => Stage::Accumulate,
        }
    }

    fn queue(self) -> String {
        match self {
            Place::CameraRays | Place::Rays => "rays".to_owned(),
            Place::Vertices(kind) => format!("vertices.{}", kind.name()),
            Place::MeshVertices(kind) => format!("mesh_vertices.{}", kind.name()),
            Place::Encounters | Place::Received => "encounters".to_owned(),
            Place::MeshEncounters => "mesh_encounters".to_owned(),
            Place::ShadowRays | Place::Total => "shadow_rays".to_owned(),
            Place::Visible => "visible".to_owned(),
        }
    }
}

/// Keeps the records of waves.
#[derive(Debug)]
pub(super) struct Recorder {
    tables: Tables,
    /// That of the wave that is being traced.
    pub number: Numbering,
    /// Bytes that it keeps, and may keep.
    kept: usize,
    room: usize,
}

impl Recorder {
    pub fn new(room: usize) -> Self {
        Self {
            tables: Tables::new(),
            number: Numbering::default(),
            kept: 0,
            room,
        }
    }

    /// Whether there was more than there is room for; then it has stopped keeping.
    pub fn is_full(&self) -> bool {
        self.kept > self.room
    }

    /// All that was kept, in the order of the loop.
    pub fn finish(self) -> Vec<Table> {
        let mut tables: Vec<Table> = self.tables.into_values().collect();
        tables.iter_mut().for_each(Table::sort);
        tables
    }

    /// Bytes that it keeps of an edge.
    fn bytes(&self, edge: u32) -> usize {
        let tables = self
            .tables
            .range((edge, Place::CameraRays)..=(edge, Place::Total));
        tables.map(|(_, table)| table.bytes()).sum()
    }

    fn table<R: Fields>(&mut self, edge: u32, place: Place) -> (&mut Table, Numbering) {
        let table = self
            .tables
            .entry((edge, place))
            .or_insert_with(|| Table::new::<R>(edge, place.stage(), place.queue()));
        (table, self.number)
    }

    fn keep<B: Batch<Record: Fields>>(&mut self, edge: u32, place: Place, queue: &Queue<B>) {
        let (table, number) = self.table::<B::Record>(edge, place);
        table.extend(queue, number);
    }

    /// The terms of the light of encounters, and what the paths have with it.
    fn receive<B: Batch>(
        &mut self,
        edge: u32,
        encounters: &Queue<B>,
        arrival: impl Fn(&B) -> ArrivalX8,
        radiance: &[[f32; 4]],
    ) {
        let (table, number) = self.table::<Received>(edge, Place::Received);
        for index in 0..encounters.len() {
            let arrival = arrival(encounters.batch(index / WIDTH)).lane(index % WIDTH);
            let record = Received {
                arrival,
                radiance: radiance_of(radiance, arrival.path),
            };
            table.push(&record, number);
        }
    }

    /// What became of shadow rays.
    fn arrive(
        &mut self,
        edge: u32,
        shadow_rays: &Queue<ShadowRayX8>,
        visible: &[u8],
        radiance: &[[f32; 4]],
    ) {
        let paths = || (0..shadow_rays.len()).map(|index| (index, shadow_rays.get(index).path));
        let (table, number) = self.table::<Visibility>(edge, Place::Visible);
        for (index, path) in paths() {
            let bits = visible.get(index / WIDTH).copied().unwrap_or_default();
            let visible = u32::from(bits >> (index % WIDTH) & 1);
            table.push(&Visibility { visible, path }, number);
        }
        let (table, number) = self.table::<Total>(edge, Place::Total);
        for (_, path) in paths() {
            let radiance = radiance_of(radiance, path);
            table.push(&Total { radiance, path }, number);
        }
    }
}

fn radiance_of(radiance: &[[f32; 4]], path: u32) -> Rgb {
    let [r, g, b, _] = radiance[path as usize];
    Rgb::new(r, g, b)
}

impl Observer for Recorder {
    fn see(&mut self, ctx: &Context, edge: u32, step: Step, ws: &Workspace) {
        if !self.is_full() {
            let before = self.bytes(edge);
            self.look(ctx, edge, step, ws);
            self.kept += self.bytes(edge) - before;
        }
    }
}

impl Recorder {
    fn look(&mut self, ctx: &Context, edge: u32, step: Step, ws: &Workspace) {
        match step {
            Step::Generated => self.keep(edge, Place::CameraRays, &ws.rays),
            Step::Met { only_lights } => {
                // What is met on the last edge scatters no more.
                if edge < ctx.path_length {
                    for &kind in &ctx.scene.kinds {
                        let queue = &ws.vertices[kind as usize];
                        self.keep(edge, Place::Vertices(kind), queue);
                    }
                    for &kind in ctx.scene.meshes.iter().flat_map(|meshes| &meshes.kinds) {
                        let queue = &ws.mesh_vertices[kind as usize];
                        self.keep(edge, Place::MeshVertices(kind), queue);
                    }
                }
                self.keep(edge, Place::Encounters, &ws.encounters);
                let emits = ctx.scene.meshes.as_ref().is_some_and(|meshes| meshes.emits);
                if emits && !only_lights {
                    self.keep(edge, Place::MeshEncounters, &ws.mesh_encounters);
                }
            }
            Step::AddedEncounters => {
                let arrival = |batch: &_| accumulate::arrival(ctx, batch);
                self.receive(edge, &ws.encounters, arrival, &ws.radiance);
                let arrival = |batch: &_| accumulate::mesh_arrival(ctx, batch);
                self.receive(edge, &ws.mesh_encounters, arrival, &ws.radiance);
            }
            Step::Scattered => {
                if edge < ctx.path_length {
                    self.keep(edge, Place::Rays, &ws.next_rays);
                }
                self.keep(edge, Place::ShadowRays, &ws.shadow_rays);
            }
            Step::AddedShadowRays => {
                self.arrive(edge, &ws.shadow_rays, &ws.visible, &ws.radiance);
            }
        }
    }
}

//! Each stage alone, on one core: its queues are those that the stages before it fill for one wave, a whole scene on
//! 11 × 11 pixels with 16 samples each. The scene is the Cornell box; where a name has `meshes` in it, it is a landscape of
//! triangles under a lamp of triangles.
//!
//! Elements are what the stage works on: rays, vertices, shadow rays, encounters or samples. A stage's queues stay in the
//! cache from one run to the next, as they do in a render from one stage to the next.

use crate::common::case::{Case, Face, Pace};
use crate::common::{Setup, TILE, wave};
use ondine::film::{AovSet, BLOCK, Film, Layers, MAX_SAMPLES, Region};
use ondine::lanes::{Queue, Rgb};
use ondine::material::{
    Bsdf, Conductor, Glass, Kind, Lambert, Material, Mirror, Phong, Principled,
};
use ondine::scene::description::SamplerKind;
use ondine::scene::meshes::Meshes;
use ondine::wavefront::queues::{MeshVertexX8, Surface, VertexX8};
use ondine::wavefront::{Context, Workspace, accumulate, generate, intersect, nee, shade, trace};
use std::hint::black_box;

const SAMPLERS: [SamplerKind; 2] = [SamplerKind::Pcg, SamplerKind::Sobol];
const GREY: Rgb = Rgb::new(0.5, 0.5, 0.5);

/// In the order of the loop.
pub fn cases() -> Vec<Case> {
    let mut cases: Vec<Case> = SAMPLERS.map(generate).into();
    cases.extend(intersect());
    cases.extend(intersect_meshes());
    for sampler in SAMPLERS {
        let on = || Place::shapes(sampler);
        cases.push(shade::<Lambert, _>(on()));
        cases.push(shade::<Mirror, _>(on()));
        cases.push(shade::<Glass, _>(on()));
        cases.push(shade::<Phong, _>(on()));
        cases.push(shade::<Conductor, _>(on()));
        cases.push(shade::<Principled, _>(on()));
        cases.push(nee::<Lambert, _>(on()));
        cases.push(nee::<Phong, _>(on()));
        cases.push(nee::<Conductor, _>(on()));
        cases.push(nee::<Principled, _>(on()));
    }
    let on = || Place::meshes(SamplerKind::Sobol);
    cases.push(shade::<Lambert, _>(on()));
    cases.push(shade::<Glass, _>(on()));
    cases.push(shade::<Principled, _>(on()));
    cases.push(nee::<Lambert, _>(on()));
    cases.push(nee::<Principled, _>(on()));
    cases.extend(accumulate());
    cases
}

/// What there is to everything a scene is made of.
fn material(kind: Kind) -> Material {
    match kind {
        Kind::Lambert => Material::Lambert { albedo: GREY },
        Kind::Mirror => Material::Mirror { reflectance: GREY },
        Kind::Glass => Material::Glass { ior: 1.5 },
        Kind::Phong => Material::Phong {
            diffuse: GREY,
            specular: GREY,
            exponent: 50.0,
        },
        Kind::Conductor => Material::Conductor {
            roughness: 0.2,
            reflectance: GREY,
        },
        Kind::Principled => Material::Principled {
            base_color: GREY,
            metallic: 0.0,
            roughness: 0.4,
            ior: 1.5,
        },
    }
}

fn case(name: impl Into<String>, prepare: impl Fn(Face) + 'static) -> Case {
    Case::new(name, Pace::Quick, prepare)
}

fn cornell() -> Setup {
    Setup::cornell(TILE, SamplerKind::Sobol, None)
}

fn landscape() -> Setup {
    Setup::landscape(TILE, SamplerKind::Sobol, None)
}

fn meshes(setup: &Setup) -> &Meshes {
    setup.scene.meshes.as_ref().expect("a scene with meshes")
}

/// Queues with the camera rays of the wave, and room for all layers.
fn camera_rays(setup: &Setup) -> Workspace {
    let ctx = setup.context();
    let wave = wave(0, 0);
    let layers = AovSet {
        depth: true,
        ..AovSet::default()
    };
    let mut ws = Workspace::new(wave.paths(), &setup.scene, layers);
    ws.start(wave.paths());
    generate::rays(&ctx, &wave, &mut ws.rays);
    ws
}

/// Queues with the camera rays of the wave and what they meet.
fn first_edge(setup: &Setup) -> Workspace {
    let mut ws = camera_rays(setup);
    closest(&setup.context(), &mut ws);
    ws
}

/// Queues with the shadow rays of the camera's vertices, and the rays that go on from there and what they meet.
fn second_edge(setup: &Setup) -> Workspace {
    let ctx = setup.context();
    let mut ws = first_edge(setup);
    let (next, shadows) = (&mut ws.next_rays, &mut ws.shadow_rays);
    let on_shapes = &ws.vertices[Lambert::KIND as usize];
    let on_meshes = &ws.mesh_vertices[Lambert::KIND as usize];
    shade::shade::<Lambert, _>(&ctx, 1, on_shapes, next);
    shade::shade::<Lambert, _>(&ctx, 1, on_meshes, next);
    nee::sample_lights::<Lambert, _>(&ctx, 1, on_shapes, shadows);
    nee::sample_lights::<Lambert, _>(&ctx, 1, on_meshes, shadows);
    visible(&ctx, &mut ws);
    ws.swap_rays();
    closest(&ctx, &mut ws);
    ws
}

fn closest(ctx: &Context, ws: &mut Workspace) {
    match ctx.scene.meshes.as_ref() {
        Some(meshes) => intersect::meshes::closest(ctx, meshes, false, ws),
        None => {
            let (vertices, encounters) = (&mut ws.vertices, &mut ws.encounters);
            intersect::closest(ctx.scene, ctx.enclosed, &ws.rays, vertices, encounters);
        }
    }
}

fn visible(ctx: &Context, ws: &mut Workspace) {
    intersect::visible(ctx.scene, &ws.shadow_rays, &mut ws.visible);
    if let Some(meshes) = ctx.scene.meshes.as_ref() {
        intersect::meshes::visible(meshes, &ws.shadow_rays, &mut ws.visible, &mut ws.tracing);
    }
}

fn generate(sampler: SamplerKind) -> Case {
    case(format!("generate/{sampler}"), move |face| {
        let setup = Setup::cornell(TILE, sampler, None);
        let ctx = setup.context();
        let mut ws = camera_rays(&setup);
        let wave = wave(0, 0);
        face(wave.paths(), &mut || {
            ws.rays.clear();
            generate::rays(&ctx, black_box(&wave), &mut ws.rays);
        });
    })
}

/// What rays meet, those that `edge` has made.
fn closest_of(name: &str, setup: fn() -> Setup, edge: fn(&Setup) -> Workspace) -> Case {
    case(name, move |face| {
        let setup = setup();
        let ctx = setup.context();
        let mut ws = edge(&setup);
        face(ws.rays.len(), &mut || closest(&ctx, black_box(&mut ws)));
    })
}

fn intersect() -> [Case; 5] {
    [
        closest_of("intersect/closest/camera", cornell, first_edge),
        closest_of("intersect/closest/bounce", cornell, second_edge),
        case("intersect/lights", |face| {
            let setup = cornell();
            let mut ws = second_edge(&setup);
            face(ws.rays.len(), &mut || {
                intersect::lights(&setup.scene, black_box(&ws.rays), &mut ws.encounters);
            });
        }),
        case("intersect/shadow", |face| {
            let setup = cornell();
            let mut ws = second_edge(&setup);
            face(ws.shadow_rays.len(), &mut || {
                intersect::visible(&setup.scene, black_box(&ws.shadow_rays), &mut ws.visible);
            });
        }),
        case("intersect/first-hits", |face| {
            let setup = cornell();
            let mut ws = camera_rays(&setup);
            face(ws.rays.len(), &mut || {
                intersect::first_hits(&setup.scene, black_box(&ws.rays), &mut ws.first_hits);
            });
        }),
    ]
}

fn intersect_meshes() -> [Case; 6] {
    let lattice = || Setup::lattice(TILE, SamplerKind::Sobol);
    [
        closest_of("intersect/meshes/closest/camera", landscape, first_edge),
        closest_of("intersect/meshes/closest/bounce", landscape, second_edge),
        closest_of("intersect/meshes/closest/holes", lattice, first_edge),
        shadow_of("intersect/meshes/shadow", landscape),
        shadow_of("intersect/meshes/shadow/holes", lattice),
        case("intersect/meshes/first-hits", |face| {
            let setup = landscape();
            let ctx = setup.context();
            let mut ws = camera_rays(&setup);
            face(ws.rays.len(), &mut || {
                intersect::meshes::first_hits(&ctx, meshes(&setup), black_box(&mut ws));
            });
        }),
    ]
}

/// Shadow rays among meshes, after all of them have passed the shapes.
fn shadow_of(name: &str, setup: fn() -> Setup) -> Case {
    case(name, move |face| {
        let setup = setup();
        let ctx = setup.context();
        let mut ws = second_edge(&setup);
        intersect::visible(ctx.scene, &ws.shadow_rays, &mut ws.visible);
        let passed = ws.visible.clone();
        face(ws.shadow_rays.len(), &mut || {
            ws.visible.copy_from_slice(&passed);
            let (rays, visible) = (black_box(&ws.shadow_rays), &mut ws.visible);
            intersect::meshes::visible(meshes(&setup), rays, visible, &mut ws.tracing);
        });
    })
}

/// Where vertices are.
struct Place<V> {
    name: &'static str,
    sampler: SamplerKind,
    setup: fn(u32, SamplerKind, Option<Material>) -> Setup,
    vertices: fn(&Workspace, Kind) -> &Queue<V>,
}

impl Place<VertexX8> {
    fn shapes(sampler: SamplerKind) -> Self {
        Self {
            name: "",
            sampler,
            setup: Setup::cornell,
            vertices: |ws, kind| &ws.vertices[kind as usize],
        }
    }
}

impl Place<MeshVertexX8> {
    fn meshes(sampler: SamplerKind) -> Self {
        Self {
            name: "meshes/",
            sampler,
            setup: Setup::landscape,
            vertices: |ws, kind| &ws.mesh_vertices[kind as usize],
        }
    }
}

impl<V> Place<V> {
    fn case(self, stage: &str, kind: Kind, work: fn(&Context, &Queue<V>, Face)) -> Case
    where
        V: Surface + 'static,
    {
        let name = format!("{stage}/{}{}/{}", self.name, kind.name(), self.sampler);
        case(name, move |face| {
            let setup = (self.setup)(TILE, self.sampler, Some(material(kind)));
            let ws = first_edge(&setup);
            work(&setup.context(), (self.vertices)(&ws, kind), face);
        })
    }
}

fn shade<B: Bsdf, V: Surface + 'static>(place: Place<V>) -> Case {
    place.case("shade", B::KIND, |ctx, vertices, face| {
        let mut rays = Queue::with_capacity(vertices.len());
        face(vertices.len(), &mut || {
            rays.clear();
            shade::shade::<B, _>(ctx, 1, black_box(vertices), &mut rays);
        });
    })
}

fn nee<B: Bsdf, V: Surface + 'static>(place: Place<V>) -> Case {
    place.case("nee", B::KIND, |ctx, vertices, face| {
        let mut shadow_rays = Queue::with_capacity(vertices.len());
        face(vertices.len(), &mut || {
            shadow_rays.clear();
            nee::sample_lights::<B, _>(ctx, 1, black_box(vertices), &mut shadow_rays);
        });
    })
}

fn accumulate() -> [Case; 5] {
    // Every ray of the edge that heads for the lamp, whatever is between: more than `closest` finds.
    let towards_lamp = |setup: &Setup| {
        let mut ws = second_edge(setup);
        intersect::lights(&setup.scene, &ws.rays, &mut ws.encounters);
        ws
    };
    [
        case("accumulate/shadow-rays", |face| {
            let mut ws = second_edge(&cornell());
            face(ws.shadow_rays.len(), &mut || {
                accumulate::visible(black_box(&ws.shadow_rays), &ws.visible, &mut ws.radiance);
            });
        }),
        case("accumulate/encounters", move |face| {
            let setup = cornell();
            let ctx = setup.context();
            let mut ws = towards_lamp(&setup);
            face(ws.encounters.len(), &mut || {
                accumulate::encounters(&ctx, black_box(&ws.encounters), &mut ws.radiance);
            });
        }),
        case("accumulate/mesh-encounters", |face| {
            let setup = landscape();
            let ctx = setup.context();
            let mut ws = second_edge(&setup);
            face(ws.mesh_encounters.len(), &mut || {
                let encounters = black_box(&ws.mesh_encounters);
                accumulate::mesh_encounters(&ctx, encounters, &mut ws.radiance);
            });
        }),
        case("accumulate/last-edge", move |face| {
            let setup = cornell();
            let ctx = setup.context();
            let mut ws = towards_lamp(&setup);
            face(ws.encounters.len(), &mut || {
                ws.shadow_rays.clear();
                accumulate::shadowed(&ctx, black_box(&ws.encounters), &mut ws.shadow_rays);
            });
        }),
        case("accumulate/film", film),
    ]
}

/// Samples of a block, one for each path, as a render gives them to the film.
fn film(face: Face) {
    let new_film = || {
        let region = Region::full(TILE, TILE);
        Film::new(TILE, TILE, region, AovSet::default()).expect("a region")
    };
    let setup = cornell();
    let wave = wave(0, 0);
    let mut ws = camera_rays(&setup);
    trace(&setup.context(), &wave, &mut ws);
    let (mut film, mut samples) = (new_film(), 0);
    face(wave.paths(), &mut || {
        if samples > MAX_SAMPLES - BLOCK {
            (film, samples) = (new_film(), 0);
        }
        let radiance = black_box(&ws.radiance[..wave.paths()]);
        film.add(wave.tile(), wave.samples, radiance, Layers::default());
        samples += BLOCK;
    });
}

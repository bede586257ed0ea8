//! Each stage alone, on one core: its queues are those that the stages before it fill for one wave, the whole Cornell
//! box on 11 × 11 pixels with 16 samples each.
//!
//! Criterion's elements are what the stage works on: rays, vertices, shadow rays, encounters or samples. A stage's
//! queues stay in the cache from one run to the next, as they do in a render from one stage to the next.

mod common;

use common::{Setup, TILE, wave};
use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main};
use ondine::film::{AovSet, BLOCK, Film, Layers, MAX_SAMPLES, Region};
use ondine::lanes::Rgb;
use ondine::material::{Bsdf, Conductor, Glass, Lambert, Material, Mirror, Phong, Principled};
use ondine::scene::description::SamplerKind;
use ondine::wavefront::{Context, Workspace, accumulate, generate, intersect, nee, shade};
use std::hint::black_box;
use std::time::Duration;

const SAMPLERS: [SamplerKind; 2] = [SamplerKind::Pcg, SamplerKind::Sobol];
const GREY: Rgb = Rgb::new(0.5, 0.5, 0.5);
const LAMBERT: Material = Material::Lambert { albedo: GREY };
const MIRROR: Material = Material::Mirror { reflectance: GREY };
const GLASS: Material = Material::Glass { ior: 1.5 };
const PHONG: Material = Material::Phong {
    diffuse: GREY,
    specular: GREY,
    exponent: 50.0,
};
const CONDUCTOR: Material = Material::Conductor {
    roughness: 0.2,
    reflectance: GREY,
};
const PRINCIPLED: Material = Material::Principled {
    base_color: GREY,
    metallic: 0.0,
    roughness: 0.4,
    ior: 1.5,
};

fn group<'a>(criterion: &'a mut Criterion, name: &str) -> BenchmarkGroup<'a, WallTime> {
    let mut group = criterion.benchmark_group(name);
    group
        .sample_size(20)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(1));
    group
}

/// Runs `stage`, which works on `elements` records.
fn bench(
    group: &mut BenchmarkGroup<WallTime>,
    name: &str,
    elements: usize,
    mut stage: impl FnMut(),
) {
    assert!(elements > 0, "{name} has nothing to work on");
    group.throughput(Throughput::Elements(elements as u64));
    group.bench_function(name, |bencher| bencher.iter(&mut stage));
}

/// Queues with the camera rays of the wave and what they meet.
fn first_edge(setup: &Setup) -> Workspace {
    let ctx = setup.context();
    let wave = wave(0, 0);
    let mut ws = Workspace::new(wave.paths(), &setup.scene, AovSet::default());
    ws.start(wave.paths());
    generate::rays(&ctx, &wave, &mut ws.rays);
    closest(&ctx, ctx.enclosed, &mut ws);
    ws
}

/// Queues with the shadow rays of the camera's vertices, and the rays that go on from there and what they meet.
fn second_edge(setup: &Setup) -> Workspace {
    let ctx = setup.context();
    let mut ws = first_edge(setup);
    let vertices = &ws.vertices[Lambert::KIND as usize];
    shade::shade::<Lambert, _>(&ctx, 1, vertices, &mut ws.next_rays);
    nee::sample_lights::<Lambert, _>(&ctx, 1, vertices, &mut ws.shadow_rays);
    intersect::visible(ctx.scene, &ws.shadow_rays, &mut ws.visible);
    ws.swap_rays();
    closest(&ctx, true, &mut ws);
    ws
}

fn closest(ctx: &Context, inside: bool, ws: &mut Workspace) {
    let (vertices, encounters) = (&mut ws.vertices, &mut ws.encounters);
    intersect::closest(ctx.scene, inside, &ws.rays, vertices, encounters);
}

fn generate(criterion: &mut Criterion) {
    let mut group = group(criterion, "generate");
    for sampler in SAMPLERS {
        let setup = Setup::cornell(TILE, sampler, None);
        let ctx = setup.context();
        let mut ws = first_edge(&setup);
        let wave = wave(0, 0);
        bench(&mut group, &sampler.to_string(), wave.paths(), || {
            ws.rays.clear();
            generate::rays(&ctx, black_box(&wave), &mut ws.rays);
        });
    }
}

fn intersect(criterion: &mut Criterion) {
    let mut group = group(criterion, "intersect");
    let setup = Setup::cornell(TILE, SamplerKind::Sobol, None);
    let ctx = setup.context();

    let mut ws = first_edge(&setup);
    bench(&mut group, "closest/camera", ws.rays.len(), || {
        closest(&ctx, ctx.enclosed, black_box(&mut ws));
    });
    let mut ws = second_edge(&setup);
    bench(&mut group, "closest/bounce", ws.rays.len(), || {
        closest(&ctx, true, black_box(&mut ws));
    });
    bench(&mut group, "lights", ws.rays.len(), || {
        intersect::lights(ctx.scene, black_box(&ws.rays), &mut ws.encounters);
    });
    bench(&mut group, "shadow", ws.shadow_rays.len(), || {
        intersect::visible(ctx.scene, black_box(&ws.shadow_rays), &mut ws.visible);
    });
}

fn shade(criterion: &mut Criterion) {
    let mut group = group(criterion, "shade");
    for sampler in SAMPLERS {
        shade_kind::<Lambert>(&mut group, "lambert", sampler, LAMBERT);
        shade_kind::<Mirror>(&mut group, "mirror", sampler, MIRROR);
        shade_kind::<Glass>(&mut group, "glass", sampler, GLASS);
        shade_kind::<Phong>(&mut group, "phong", sampler, PHONG);
        shade_kind::<Conductor>(&mut group, "conductor", sampler, CONDUCTOR);
        shade_kind::<Principled>(&mut group, "principled", sampler, PRINCIPLED);
    }
}

fn shade_kind<B: Bsdf>(
    group: &mut BenchmarkGroup<WallTime>,
    kind: &str,
    sampler: SamplerKind,
    material: Material,
) {
    let setup = Setup::cornell(TILE, sampler, Some(material));
    let ctx = setup.context();
    let mut ws = first_edge(&setup);
    let vertices = &ws.vertices[B::KIND as usize];
    bench(group, &format!("{kind}/{sampler}"), vertices.len(), || {
        ws.next_rays.clear();
        shade::shade::<B, _>(&ctx, 1, black_box(vertices), &mut ws.next_rays);
    });
}

fn nee(criterion: &mut Criterion) {
    let mut group = group(criterion, "nee");
    for sampler in SAMPLERS {
        nee_kind::<Lambert>(&mut group, "lambert", sampler, LAMBERT);
        nee_kind::<Phong>(&mut group, "phong", sampler, PHONG);
        nee_kind::<Conductor>(&mut group, "conductor", sampler, CONDUCTOR);
        nee_kind::<Principled>(&mut group, "principled", sampler, PRINCIPLED);
    }
}

fn nee_kind<B: Bsdf>(
    group: &mut BenchmarkGroup<WallTime>,
    kind: &str,
    sampler: SamplerKind,
    material: Material,
) {
    let setup = Setup::cornell(TILE, sampler, Some(material));
    let ctx = setup.context();
    let mut ws = first_edge(&setup);
    let vertices = &ws.vertices[B::KIND as usize];
    bench(group, &format!("{kind}/{sampler}"), vertices.len(), || {
        ws.shadow_rays.clear();
        nee::sample_lights::<B, _>(&ctx, 1, black_box(vertices), &mut ws.shadow_rays);
    });
}

fn accumulate(criterion: &mut Criterion) {
    let mut group = group(criterion, "accumulate");
    let setup = Setup::cornell(TILE, SamplerKind::Sobol, None);
    let ctx = setup.context();
    let mut ws = second_edge(&setup);

    bench(&mut group, "shadow rays", ws.shadow_rays.len(), || {
        accumulate::visible(black_box(&ws.shadow_rays), &ws.visible, &mut ws.radiance);
    });
    // Every ray of the edge that heads for the lamp, whatever is between: more than `closest` finds.
    intersect::lights(ctx.scene, &ws.rays, &mut ws.encounters);
    bench(&mut group, "encounters", ws.encounters.len(), || {
        accumulate::encounters(&ctx, black_box(&ws.encounters), &mut ws.radiance);
    });
    bench(&mut group, "last edge", ws.encounters.len(), || {
        ws.shadow_rays.clear();
        accumulate::shadowed(&ctx, black_box(&ws.encounters), &mut ws.shadow_rays);
    });

    let new_film = || {
        let region = Region::full(TILE, TILE);
        Film::new(TILE, TILE, region, AovSet::default()).expect("a region")
    };
    // One sample each, as a render gives them.
    let wave = wave(0, 0);
    ondine::wavefront::trace(&ctx, &wave, &mut ws);
    let (mut film, mut samples) = (new_film(), 0);
    bench(&mut group, "film", wave.paths(), || {
        if samples > MAX_SAMPLES - BLOCK {
            (film, samples) = (new_film(), 0);
        }
        film.add(
            wave.tile(),
            wave.samples,
            black_box(&ws.radiance),
            Layers::default(),
        );
        samples += BLOCK;
    });
}

criterion_group!(benches, generate, intersect, shade, nee, accumulate);
criterion_main!(benches);

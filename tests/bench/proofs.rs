//! References, and what is held to them.

use crate::{report_of, right};
use ondine::bench::proof::prove;
use ondine::bench::{CASES, Case};
use ondine::compare::Verdict;
use ondine::lanes::{Table, Vec3x8, f32x8, u32x8};
use ondine::material::{Bsdf, EvalX8, Kind, Lambert, ModulationX8, SampleX8};
use ondine::render::{Control, Rendered, Settings, render};
use ondine::scene::builtin;
use ondine::scene::description::Description;
use ondine::wavefront::{
    self, Context, Wave, Workspace, accumulate, generate, intersect, nee, shade,
};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

fn rendered(description: &Description, side: u32, spp: u32) -> Rendered {
    let mut settings = Settings::of(description);
    settings.set_size(side, side);
    settings.spp = spp;
    settings.path_length = 6;
    let control = Control {
        stop: &AtomicBool::new(false),
        progress: &|_| (),
    };
    render(description, &settings, &control).unwrap()
}

/// The scenes that a test has time for.
fn small() -> impl Iterator<Item = &'static Case> {
    CASES.iter().filter(|case| case.triangles() < 1_000_000)
}

#[test]
fn every_scene_is_what_its_reference_shows() {
    for case in small() {
        let image = rendered(&case.description().unwrap(), 128, 32);
        let found = prove(case, &image.film).unwrap();
        assert_eq!(
            found.verdict,
            Verdict::Consistent,
            "{}: {}",
            case.name,
            found.summary
        );
        let bias = found.detectable.expect("enough light");
        assert!(
            bias < 0.05,
            "{}: a bias of {bias} would go unseen",
            case.name
        );
    }
}

#[test]
fn a_scene_is_not_taken_for_another() {
    let [a, b] =
        ["mesh-1e4", "mesh-1e5"].map(|name| small().find(|case| case.name == name).unwrap());
    let image = rendered(&a.description().unwrap(), 128, 32);
    assert_eq!(prove(b, &image.film).unwrap().verdict, Verdict::Biased);
    let odd = rendered(&a.description().unwrap(), 100, 16);
    assert!(
        prove(a, &odd.film)
            .unwrap_err()
            .to_string()
            .contains("100x100")
    );
}

#[test]
fn a_scene_that_is_exported_is_the_same_scene() {
    let folder = tempfile::tempdir().unwrap();
    for case in small() {
        case.export(folder.path()).unwrap();
        let file = folder.path().join(format!("{}.toml", case.name));
        let written = builtin::open(file.to_str().unwrap()).unwrap();
        let [a, b] = [written, case.description().unwrap()]
            .map(|scene| rendered(&scene, 32, 16).film.image_hash());
        assert_eq!(a, b, "{}", case.name);
    }
}

/// A matte surface whose light is weighted by the cosine twice.
#[derive(Clone, Copy)]
struct Broken(Lambert);

impl Bsdf for Broken {
    const KIND: Kind = Kind::Lambert;
    const SPECULAR: bool = false;
    const TRANSMISSIVE: bool = false;

    fn load(table: &Table, ids: u32x8) -> Self {
        Self(Lambert::load(table, ids))
    }
    fn modulate(self, by: &ModulationX8) -> Self {
        Self(self.0.modulate(by))
    }
    fn eval(&self, wo: Vec3x8, wi: Vec3x8) -> EvalX8 {
        let right = self.0.eval(wo, wi);
        EvalX8 {
            value: right.value * wi.z.max(f32x8::ZERO),
            ..right
        }
    }
    fn sample(&self, wo: Vec3x8, direction: (f32x8, f32x8), lobe: f32x8) -> SampleX8 {
        self.0.sample(wo, direction, lobe)
    }
}

/// The loop of `wavefront::trace`, for a room of matte walls alone, made of the same stages.
fn trace<B: Bsdf>(ctx: &Context, wave: &Wave, ws: &mut Workspace) {
    ws.start(wave.paths());
    generate::rays(ctx, wave, &mut ws.rays);
    for edge in 1..=ctx.path_length {
        ws.tally.begin(edge, ws.rays.len());
        ws.next_rays.clear();
        ws.shadow_rays.clear();
        if edge == ctx.path_length {
            intersect::lights(ctx.scene, &ws.rays, &mut ws.encounters);
            accumulate::shadowed(ctx, &ws.encounters, &mut ws.shadow_rays);
        } else {
            let (vertices, encounters) = (&mut ws.vertices, &mut ws.encounters);
            intersect::closest(ctx.scene, ctx.enclosed, &ws.rays, vertices, encounters);
            accumulate::encounters(ctx, &ws.encounters, &mut ws.radiance);
            let vertices = &ws.vertices[B::KIND as usize];
            shade::shade::<B, _>(ctx, edge, vertices, &mut ws.next_rays);
            nee::sample_lights::<B, _>(ctx, edge, vertices, &mut ws.shadow_rays);
        }
        intersect::visible(ctx.scene, &ws.shadow_rays, &mut ws.visible);
        accumulate::visible(&ws.shadow_rays, &ws.visible, &mut ws.radiance);
        ws.tally.shadows(ws.shadow_rays.len());
        ws.swap_rays();
    }
}

#[test]
fn a_broken_cosine_has_no_score() {
    let right = right();
    assert!(!right.is_wrong(), "{:?}", right.score);
    // The same loop with the right cosine has the same bits, so that it is the cosine that is found.
    let own = report_of(false, &trace::<Lambert>);
    assert_eq!(
        own.cases[0].proof.image_hash,
        right.cases[0].proof.image_hash
    );
    let wrong = report_of(false, &trace::<Broken>);
    assert!(wrong.is_wrong());
    assert_eq!(wrong.score.value, None);
    assert!(
        wrong.score.withheld[0].starts_with("box: biased"),
        "{:?}",
        wrong.score
    );
}

#[test]
fn an_image_that_changes_from_run_to_run_has_no_score() {
    let waves = AtomicU64::new(0);
    // An image is made of 4418 waves: too little for a bias, and never twice the same.
    let drifting = |ctx: &Context, wave: &Wave, ws: &mut Workspace| {
        wavefront::trace(ctx, wave, ws);
        let drift = waves.fetch_add(1, Ordering::Relaxed) / 1000;
        let sums = ws.radiance.iter_mut();
        sums.for_each(|sum| sum[0] *= 1.0 + drift as f32 * f32::EPSILON);
    };
    let report = report_of(false, &drifting);
    let proof = &report.cases[0].proof;
    assert!(!proof.same_bits && proof.consistent, "{proof:?}");
    assert_eq!(report.score.value, None);
    assert!(report.score.withheld[0].contains("differ from one run to the next"));
}

#[test]
fn what_was_measured_adds_up() {
    let report = right();
    let case = &report.cases[0];
    assert_eq!(case.paths, 512 * 512 * 32);
    let edges: u64 = case
        .bounces
        .iter()
        .map(|bounce| bounce.rays + bounce.shadow_rays)
        .sum();
    assert_eq!(edges, case.rays);
    assert_eq!(case.bounces.len(), 6);
    assert_eq!(case.bounces[0].rays, case.paths);
    let intersected = case
        .stages
        .iter()
        .find(|stage| stage.name == "intersect")
        .unwrap();
    assert_eq!(intersected.items, case.rays);
    // All threads are busy in the stages, but for taking waves; never longer than the loop.
    let threads = report.threads as f64;
    let busy: f64 = case
        .stages
        .iter()
        .map(|stage| stage.thread_s.median())
        .sum();
    assert!(busy <= 1.01 * threads * case.render_s.median());
    assert_eq!(
        report.score.withheld,
        ["not all scenes of the suite were run"]
    );
    assert!(!report.is_wrong());
    for scaling in report.threads_scaling.iter().chain(&report.wave_scaling) {
        assert_eq!(scaling.case, "box");
        assert!(scaling.points.iter().all(|point| point.mpaths_per_s > 0.0));
    }
    let written = serde_json::to_string(report).unwrap();
    assert_eq!(
        serde_json::from_str::<ondine::bench::Report>(&written).unwrap(),
        *report
    );
}

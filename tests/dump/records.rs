//! What is recorded is what a render does, each record once.

use crate::render::*;
use crate::{region, traced};
use ondine::dump::budget;
use ondine::dump::table::{PATH, Table};
use ondine::lanes::Number;
use ondine::npy::Numbers;
use ondine::render::Settings;
use ondine::scene::builtin as open;
use ondine::scene::description::{Description, SamplerKind};

/// Shapes, materials of all kinds, a sky, meshes.
fn scenes() -> [Description; 4] {
    let still_life = format!("{}/scenes/still-life.glb", env!("CARGO_MANIFEST_DIR"));
    [
        builtin("cornell"),
        builtin("materials"),
        builtin("sky"),
        open::open(&still_life).expect("a scene"),
    ]
}

/// 37 samples are three blocks, the last ragged.
fn small(description: &Description, sampler: SamplerKind) -> Settings {
    Settings {
        sampler,
        ..settings(description, (45, 29), 37)
    }
}

#[test]
fn a_dump_adds_up_to_the_very_pixels_of_the_render() {
    for description in scenes() {
        for sampler in [SamplerKind::Pcg, SamplerKind::Sobol] {
            let settings = small(&description, sampler);
            let dump = traced(&description, &settings, "16,8,29,17", 0..37);
            let part = Settings {
                region: region("16,8,29,17"),
                ..settings
            };
            let film = film(&description, &part);
            let what = format!("{}, {sampler}", description.name);
            assert_eq!(dump.film.image_hash(), film.image_hash(), "{what}");
            assert_eq!(dump.blocks.len(), 3 * 13 * 9);
        }
    }
}

#[test]
fn no_bit_of_a_record_depends_on_the_tile_or_the_samples_around_it() {
    let mut compared = 0;
    for description in scenes() {
        let settings = small(&description, SamplerKind::Sobol);
        // Wider than a wave, and samples that begin within a block.
        let wide = traced(&description, &settings, "0,3,45,5", 5..35);
        let one = traced(&description, &settings, "7,4,8,5", 20..21);
        let number = wide.paths().position(|path| path == [7, 4, 20]);
        let number = number.expect("the path") as u32;
        for table in &one.tables {
            let other = wide.table(table.edge, table.stage.name(), &table.queue);
            let other = other.expect("the same queue");
            let (record, same) = (table.of(0), other.of(number));
            assert_eq!(record.is_some(), same.is_some(), "{}", table.queue);
            for field in &table.fields {
                if let (Some(record), Some(same)) = (record, same)
                    && field.name != PATH
                {
                    let bits =
                        |all: Vec<f32>| all.into_iter().map(f32::to_bits).collect::<Vec<_>>();
                    assert_eq!(
                        bits(record.floats(field.name)),
                        bits(same.floats(field.name)),
                        "{}, edge {}, {}, {}",
                        description.name,
                        table.edge,
                        table.queue,
                        field.name
                    );
                    compared += 1;
                }
            }
        }
    }
    assert!(compared > 200, "{compared} fields");
}

fn paths(table: &Table) -> Vec<u32> {
    let array = table.arrays().find(|(field, _)| field.name == PATH);
    match array.expect("paths").1.numbers {
        Numbers::U32(paths) => paths,
        other => panic!("{}", other.dtype()),
    }
}

#[test]
fn a_path_has_a_record_at_most_in_each_queue_and_they_ascend() {
    for description in scenes() {
        let settings = small(&description, SamplerKind::Pcg);
        let dump = traced(&description, &settings, "3,3,20,20", 0..20);
        for table in &dump.tables {
            let paths = paths(table);
            assert!(paths.is_sorted_by(|a, b| a < b), "{}", table.queue);
            assert!(paths.last().is_none_or(|&last| last < 17 * 17 * 20));
        }
    }
}

#[test]
fn a_path_has_a_vertex_on_an_edge_where_it_has_a_ray_and_scatters_from_a_vertex_alone() {
    for description in scenes() {
        let settings = small(&description, SamplerKind::Pcg);
        let dump = traced(&description, &settings, "3,3,20,20", 0..20);
        let mut vertices = 0;
        for edge in 1..settings.path_length {
            let rays = match edge {
                1 => dump.table(1, "generate", "rays"),
                edge => dump.table(edge - 1, "shade", "rays"),
            };
            let Some(rays) = rays.filter(|rays| !rays.is_empty()) else {
                break;
            };
            let mut hit: Vec<u32> = (dump.tables.iter())
                .filter(|table| table.edge == edge && table.queue.contains("vertices."))
                .flat_map(paths)
                .collect();
            hit.sort();
            vertices += hit.len();
            assert!(hit.is_sorted_by(|a, b| a < b), "a path met two things");
            assert!(hit.iter().all(|&path| rays.of(path).is_some()));
            for (stage, queue) in [("shade", "rays"), ("nee", "shadow_rays")] {
                let table = dump.table(edge, stage, queue).expect("a queue");
                let from = |path: &u32| hit.binary_search(path).is_ok();
                assert!(paths(table).iter().all(from), "{stage}, {queue}");
            }
        }
        assert!(vertices > 2000, "{vertices} vertices");
    }
}

#[test]
fn every_field_has_a_name_of_its_own_a_meaning_and_a_budget() {
    let mut queues = 0;
    for description in scenes() {
        let settings = small(&description, SamplerKind::Sobol);
        let dump = traced(&description, &settings, "3,3,20,20", 0..4);
        for table in &dump.tables {
            let mut names: Vec<&str> = table.fields.iter().map(|field| field.name).collect();
            for field in &table.fields {
                let budget = budget::of(field.name, table.edge);
                let budget = budget.unwrap_or_else(|| panic!("{} has no budget", field.name));
                let exact = budget.ulp == 0.0;
                assert_eq!(exact, field.number == Number::Integer, "{}", field.name);
                assert!(!field.doc.is_empty(), "{}", field.name);
            }
            names.sort();
            names.dedup();
            assert_eq!(names.len(), table.fields.len(), "{}", table.queue);
            queues += 1;
        }
    }
    assert!(queues > 100, "{queues}");
}

//! The paths of a pixel, vertex by vertex, for people.

use super::Dump;
use super::table::{Record, Table};
use crate::scene::NONE;
use crate::scene::description::{Description, Shape};
use std::fmt::Write;

/// All paths of a dump, one after the other, and what they come to.
pub fn text(dump: &Dump, description: &Description) -> String {
    let mut text = String::new();
    for (path, [x, y, sample]) in (0..).zip(dump.paths()) {
        line(&mut text, format_args!("pixel {x},{y}, sample {sample}"));
        edges(&mut text, dump, description, path);
        let radiance = dump.radiance[path as usize];
        line(
            &mut text,
            format_args!("  radiance {}\n", triple(&radiance)),
        );
    }
    for (x, y) in dump.tile.coordinates() {
        let (count, mean) = (dump.film.count(x, y), dump.film.mean(x, y));
        let of = if count == 1 { "sample" } else { "samples" };
        line(
            &mut text,
            format_args!("pixel {x},{y}: mean of {count} {of} {}", triple(&mean)),
        );
    }
    text
}

fn edges(text: &mut String, dump: &Dump, description: &Description, path: u32) {
    let mut rays = dump.table(1, "generate", "rays");
    for edge in 1.. {
        let Some(ray) = rays.and_then(|rays| rays.of(path)) else {
            break;
        };
        let of = |stage: &str, queue: &str| dump.table(edge, stage, queue)?.of(path);
        let (origin, direction) = (ray.floats("origin"), ray.floats("direction"));
        line(
            text,
            format_args!(
                "  edge {edge}: from {} along {}, throughput {}, pdf {}",
                triple(&origin),
                triple(&direction),
                triple(&ray.floats("throughput")),
                ray.float("pdf"),
            ),
        );
        let vertex = (dump.tables.iter())
            .filter(|table| table.edge == edge && table.queue.contains("vertices."))
            .find_map(|table| Some((table, table.of(path)?)));
        if let Some((table, vertex)) = vertex {
            hit(text, description, table, vertex, &origin);
        }
        let met = of("intersect", "encounters").or_else(|| of("intersect", "mesh_encounters"));
        if let Some(met) = met {
            let light = light(description, met.integer("light"));
            let distance = met.float("distance");
            line(text, format_args!("    meets {light}, distance {distance}"));
        }
        let shadow = of("nee", "shadow_rays");
        if let Some(light) = of("accumulate", "encounters") {
            // On the last edge, a shadow ray asks whether it is so.
            let adds = if vertex.is_none() && shadow.is_some() {
                "carries"
            } else {
                "adds"
            };
            line(
                text,
                format_args!(
                    "      emitted {}, density of light sampling {}, weight {}: {adds} {}",
                    triple(&light.floats("emitted")),
                    light.float("light_pdf"),
                    light.float("weight"),
                    triple(&light.floats("contribution")),
                ),
            );
        }
        if vertex.is_none() && met.is_none() {
            line(text, format_args!("    meets nothing that it looks for"));
        }
        if let Some(shadow) = shadow {
            let visible = of("intersect", "visible").is_some_and(|ray| ray.integer("visible") == 1);
            line(
                text,
                format_args!(
                    "    shadow ray from {} along {}, distance {}: {} {}",
                    triple(&shadow.floats("origin")),
                    triple(&shadow.floats("direction")),
                    shadow.float("distance"),
                    if visible {
                        "visible, adds"
                    } else {
                        "blocked, or it would add"
                    },
                    triple(&shadow.floats("contribution")),
                ),
            );
        }
        rays = dump.table(edge, "shade", "rays");
    }
}

fn hit(text: &mut String, description: &Description, table: &Table, vertex: Record, from: &[f32]) {
    let id = vertex.integer("material");
    let name = description.materials.get(id as usize);
    let name = name.map_or("?", |material| material.name.as_str());
    let kind = table.queue.rsplit('.').next().unwrap_or_default();
    let on = if table.queue.starts_with("mesh") {
        " on a mesh"
    } else {
        ""
    };
    let position = vertex.floats("position");
    let squared: f64 = position
        .iter()
        .zip(from)
        .map(|(&a, &b)| (f64::from(a) - f64::from(b)).powi(2))
        .sum();
    line(
        text,
        format_args!(
            "    meets {name:?} ({kind}){on} at {}, normal {}, distance {}",
            triple(&position),
            triple(&vertex.floats("normal")),
            libm::sqrt(squared) as f32,
        ),
    );
}

fn light(description: &Description, id: u32) -> String {
    if id == NONE {
        return "the sky".to_owned();
    }
    let shape = match description.lights.get(id as usize).map(|light| light.shape) {
        Some(Shape::Sphere { .. }) => "a sphere",
        Some(Shape::Quad { .. }) => "a quad",
        _ => "a mesh",
    };
    format!("light {id} ({shape})")
}

fn triple(numbers: &[f32]) -> String {
    let number = |&x: &f32| match x.abs() {
        small if small > 0.0 && small < 1e-4 => format!("{x:e}"),
        _ => x.to_string(),
    };
    let all: Vec<String> = numbers.iter().map(number).collect();
    format!("({})", all.join(", "))
}

fn line(text: &mut String, what: std::fmt::Arguments) {
    // A String takes everything.
    let _ = writeln!(text, "{what}");
}

//! Parts of a scene as TOML, such that reading them gives the same bits.

use super::keys::{material_key, materials_named};
use crate::material::{Material, Parameter};
use crate::scene::description::{Camera, Description};
use glam::Vec3;

/// A finite number in the fewest digits that are read as the same 32 bits, with a decimal point or an exponent:
/// `1.0`, `0.1`, `-0.0`, `1e-7`.
pub fn float(value: f32) -> String {
    // Decimals are read straight to 32 bits, which Rust's shortest ones are made for.
    format!("{value:?}")
}

/// A camera as the table of one, in one line: `{ position = [...], look_at = [...], ... }`; all of its keys are there.
pub fn camera(camera: &Camera) -> String {
    format!(
        "{{ position = {}, look_at = {}, up = {}, vertical_fov = {}, aperture_radius = {}, focus_distance = {} }}",
        point(camera.position),
        point(camera.look_at),
        point(camera.up),
        float(camera.vertical_fov),
        float(camera.aperture_radius),
        float(camera.focus_distance)
    )
}

/// A material without its textures as the table of one, in one line: `{ type = "lambert", albedo = [0.8, 0.8, 0.8] }`; all of
/// its keys are there.
pub fn material(material: &Material) -> String {
    let parameters = parameters(material).map(|(key, value)| format!("{key} = {value}"));
    let parameters: Vec<String> = parameters.collect();
    let kind = material.kind().name();
    format!("{{ type = \"{kind}\", {} }}", parameters.join(", "))
}

/// The changes, each as `KEY=VALUE`, that turn the materials of a name into this one; their textures are those of
/// [`maps_kept`](super::maps_kept). None are needed where it is this one already; `None` where no such material can be changed.
pub fn material_changes(
    description: &Description,
    name: &str,
    material: &Material,
) -> Option<Vec<String>> {
    let key = material_key(description, name)?;
    let named: Vec<_> = materials_named(description, name)
        .filter_map(|index| description.materials.get(index))
        .collect();
    let before = match named[..] {
        [only] if only.material.kind() == material.kind() => only,
        _ => return Some(vec![format!("{key}={}", self::material(material))]),
    };
    // A .toml scene says a texture in the place of the colour.
    let has_scale = description.written.is_some() && before.maps.color.is_some();
    let changed = parameters(material)
        .zip(parameters(&before.material))
        .filter(|(new, old)| new != old);
    let changes =
        changed.map(
            |((parameter, value), _)| match has_scale && COLORS.contains(&parameter) {
                true => format!("{key}.{parameter}.scale={value}"),
                false => format!("{key}.{parameter}={value}"),
            },
        );
    Some(changes.collect())
}

/// What a type's colour is called, which a texture multiplies.
const COLORS: [&str; 4] = ["albedo", "reflectance", "diffuse", "base_color"];

/// What a material says besides its type: keys and values.
fn parameters(material: &Material) -> impl Iterator<Item = (&'static str, String)> {
    let text = |value: Parameter| match value {
        Parameter::Number(number) => float(number),
        Parameter::Color(color) => list(color.to_array()),
    };
    let parameters = material.parameters().into_iter();
    parameters.map(move |(key, value)| (key, text(value)))
}

fn point(point: Vec3) -> String {
    list(point.to_array())
}

fn list(values: [f32; 3]) -> String {
    format!("[{}]", values.map(float).join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::toml::reader::{Source, Table};
    use rand_pcg::Pcg32;
    use rand_pcg::rand_core::Rng;

    #[test]
    fn a_float_is_read_as_the_bits_it_was_written_from() {
        let mut random = Pcg32::new(1, 1);
        let edges = [0.0, -0.0, 1.0, 0.1, 1e-7, 16_777_216.0, f32::MIN_POSITIVE];
        let mut values = [&edges[..], &[f32::from_bits(1), f32::MAX, f32::MIN]].concat();
        values.extend((0..100_000).map(|_| f32::from_bits(random.next_u32())));
        values.retain(|value| value.is_finite());
        let texts: Vec<String> = values.iter().map(|&value| float(value)).collect();
        let text = format!("x = [{}]", texts.join(", "));
        let source = Source {
            file: "a.toml",
            text: &text,
        };
        let document = source.document().unwrap();
        let list = Table::root(&source, &document).get("x").unwrap();
        let items = list.one_or_more().unwrap();
        assert_eq!(items.len(), values.len());
        for (item, value) in items.iter().zip(values) {
            let read = item.number().unwrap();
            assert_eq!(read.to_bits(), value.to_bits(), "{value:e}");
        }
        assert_eq!(texts[..5], ["0.0", "-0.0", "1.0", "0.1", "1e-7"]);
    }
}

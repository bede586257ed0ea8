//! BSDFs: directions drawn from them, and their values.

use super::page::{Case, Section, Topic};
use super::{one, pair, unit, vector, wide};
use crate::lanes::{Rgb, Rgbx8, Table, Vec3x8, u32x8};
use crate::material::{
    Bsdf, Conductor, Glass, Lambert, Material, Mirror, ModulationX8, Phong, Principled,
};
use glam::Vec3;

const COLOR: Rgb = Rgb::new(0.75, 0.5, 0.25);

pub(super) fn topic() -> Topic {
    Topic {
        name: "bsdfs",
        about: "BSDFs in the local frame, whose normal is +z: specification, section 8. wo and wi point away from the surface. \
                parameters are what is computed of the material before a path is traced. sample: wi, drawn by u and lobe; weight is \
                BSDF times |cos| over pdf; an infinite pdf (null) is a discrete choice. eval: value is BSDF times |cos|. pdf is per \
                steradian. maps, where there are any, are factors of textures: colour, metallic, roughness.",
        sections: vec![
            section::<Lambert>(
                "lambert",
                "Albedo (0.75, 0.5, 0.25).",
                &Material::Lambert { albedo: COLOR },
            ),
            section::<Mirror>(
                "mirror",
                "Reflectance (0.75, 0.5, 0.25).",
                &Material::Mirror { reflectance: COLOR },
            ),
            section::<Glass>(
                "glass",
                "Index of refraction 1.5; wo.z below 0 is inside.",
                &Material::Glass { ior: 1.5 },
            ),
            section::<Phong>(
                "phong",
                "Diffuse (0.375, 0.25, 0.125), specular 0.5, exponent 32.",
                &phong(32.0),
            ),
            section::<Phong>(
                "phong_sharp",
                "The same with an exponent of 10000.",
                &phong(10_000.0),
            ),
            section::<Conductor>(
                "conductor",
                "Reflectance (0.75, 0.5, 0.25), roughness 0.25.",
                &conductor(0.25),
            ),
            section::<Conductor>(
                "conductor_smooth",
                "The same with a roughness of 0.001.",
                &conductor(0.001),
            ),
            section::<Principled>(
                "principled",
                "Base colour (0.75, 0.5, 0.25), metallic 0, roughness 0.5, index 1.5.",
                &principled(0.0, 0.5),
            ),
            section::<Principled>(
                "principled_metal",
                "The same with metallic 1, roughness 0.25.",
                &principled(1.0, 0.25),
            ),
            mapped::<Phong>("phong_mapped", "phong with maps.", &phong(32.0)),
            mapped::<Principled>(
                "principled_mapped",
                "Metallic 0.75, roughness 0.5, with maps.",
                &principled(0.75, 0.5),
            ),
        ],
    }
}

fn phong(exponent: f32) -> Material {
    Material::Phong {
        diffuse: Rgb::new(0.375, 0.25, 0.125),
        specular: Rgb::splat(0.5),
        exponent,
    }
}

fn conductor(roughness: f32) -> Material {
    Material::Conductor {
        roughness,
        reflectance: COLOR,
    }
}

fn principled(metallic: f32, roughness: f32) -> Material {
    Material::Principled {
        base_color: COLOR,
        metallic,
        roughness,
        ior: 1.5,
    }
}

/// Where light goes to.
fn outgoing(transmissive: bool) -> Vec<Vec3> {
    let above = [Vec3::Z, unit(0.5, -0.25, 1.0), unit(3.0, 1.0, 0.25)];
    let below = above.map(|v| -v);
    let below = if transmissive { &below[..] } else { &[] };
    [&above, below].concat()
}

/// Random numbers: of the direction (2), of the lobe.
const DRAWS: [[f32; 3]; 4] = [
    [0.5, 0.25, 0.0],
    [0.125, 0.875, 0.0625],
    [0.75, 0.0625, 0.5],
    [0.9375, 0.6875, 0.9375],
];

fn section<B: Bsdf>(name: &'static str, about: &'static str, material: &Material) -> Section {
    cases::<B>(name, about, material, None)
}

fn mapped<B: Bsdf>(name: &'static str, about: &'static str, material: &Material) -> Section {
    cases::<B>(name, about, material, Some([0.5, 0.75, 1.0, 0.5, 0.75]))
}

fn cases<B: Bsdf>(
    name: &'static str,
    about: &'static str,
    material: &Material,
    maps: Option<[f32; 5]>,
) -> Section {
    let row = material.row();
    let bsdf = B::load(&Table::new(vec![row]), u32x8::ZERO);
    let mut parameters = Case::new().floats("parameters", &row);
    let mut mapped = bsdf;
    if let Some(factors) = maps {
        let [r, g, b, metallic, roughness] = factors.map(wide);
        mapped = bsdf.modulate(&ModulationX8::new(Rgbx8::new(r, g, b), metallic, roughness));
        parameters = parameters.floats("maps", &factors);
    }
    let mut cases = vec![parameters];
    let outgoing = outgoing(B::TRANSMISSIVE);
    for &wo in &outgoing {
        cases.extend(DRAWS.map(|draw| sample(&mapped, wo, draw)));
    }
    if !B::SPECULAR {
        let incoming = [
            Vec3::Z,
            unit(-0.5, 0.25, 1.0),
            unit(-3.0, -1.0, 0.5),
            unit(0.25, 0.5, -0.5),
        ];
        for &wo in &outgoing {
            cases.extend(incoming.map(|wi| eval(&mapped, wo, wi)));
        }
    }
    Section::new(name, about, cases)
}

fn sample(bsdf: &impl Bsdf, wo: Vec3, [u, v, lobe]: [f32; 3]) -> Case {
    let sample = bsdf.sample(Vec3x8::splat(wo), pair([u, v]), wide(lobe));
    Case::new()
        .text("call", "sample")
        .floats("wo", &wo.to_array())
        .floats("u", &[u, v])
        .float("lobe", lobe)
        .floats("wi", &vector(sample.wi))
        .floats("weight", &sample.weight.lane(0).to_array())
        .float("pdf", one(sample.pdf))
}

fn eval(bsdf: &impl Bsdf, wo: Vec3, wi: Vec3) -> Case {
    let eval = bsdf.eval(Vec3x8::splat(wo), Vec3x8::splat(wi));
    Case::new()
        .text("call", "eval")
        .floats("wo", &wo.to_array())
        .floats("wi", &wi.to_array())
        .floats("value", &eval.value.lane(0).to_array())
        .float("pdf", one(eval.pdf))
}

//! Materials: the closest match, and what is told of it.

use super::*;

#[track_caller]
fn whole(text: &str) -> Material {
    let (scene, material) = material(text);
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    material
}

#[track_caller]
fn told(text: &str, warning: &str) -> Material {
    let (scene, material) = material(text);
    assert_eq!(scene.warnings, [format!("a.pbrt:2:1: {warning}")]);
    material
}

fn gray(value: f32) -> Material {
    Material::Lambert {
        albedo: Rgb::splat(value),
    }
}

#[test]
fn a_diffuse_material_is_matte() {
    assert_eq!(whole(""), gray(0.5));
    assert_eq!(whole("Material \"diffuse\""), gray(0.5));
    let albedo = Rgb::new(0.1, 0.2, 1.0);
    assert_eq!(
        whole("Material \"diffuse\" \"rgb reflectance\" [.1 .2 3]"),
        Material::Lambert { albedo }
    );
    // A flat spectrum is grey.
    let Material::Lambert { albedo } =
        whole("Material \"diffuse\" \"spectrum reflectance\" [300 .4 900 .4]")
    else {
        panic!("matte");
    };
    close(albedo.to_array(), [0.4; 3]);
}

#[test]
fn a_conductor_is_a_mirror_or_rough_by_the_root_of_its_roughness() {
    let reflectance = Rgb::new(1.0, 0.782, 0.344);
    let gold = "\"spectrum eta\" \"metal-Au-eta\" \"spectrum k\" \"metal-Au-k\"";
    assert_eq!(
        whole(&format!("Material \"conductor\" {gold}")),
        Material::Mirror { reflectance }
    );
    for (text, roughness) in [
        ("\"float roughness\" .25", 0.5),
        (
            "\"float roughness\" .25 \"bool remaproughness\" false",
            0.25,
        ),
        ("\"float uroughness\" .04 \"float vroughness\" .04", 0.2),
    ] {
        assert_eq!(
            whole(&format!("Material \"conductor\" {gold} {text}")),
            Material::Conductor {
                roughness,
                reflectance
            }
        );
    }
    // (η − 1)² / (η + 1)² without absorption.
    let Material::Mirror { reflectance } =
        whole("Material \"conductor\" \"rgb eta\" [3 1 2] \"rgb k\" [0 0 0]")
    else {
        panic!("a mirror");
    };
    close(reflectance.to_array(), [0.25, 0.0, 1.0 / 9.0]);
    let reflectance = Rgb::splat(0.9);
    assert_eq!(
        whole("Material \"conductor\" \"rgb reflectance\" [.9 .9 .9]"),
        Material::Mirror { reflectance }
    );
}

#[test]
fn a_dielectric_is_glass() {
    assert_eq!(
        whole("Material \"dielectric\""),
        Material::Glass { ior: 1.5 }
    );
    assert_eq!(
        whole("Material \"dielectric\" \"float eta\" 1.33"),
        Material::Glass { ior: 1.33 }
    );
    assert_eq!(
        whole("Material \"dielectric\" \"spectrum eta\" \"glass-BK7\""),
        Material::Glass { ior: 1.5168 }
    );
    assert_eq!(
        told(
            "Material \"dielectric\" \"float roughness\" .1",
            "rough glass is not supported; it is smooth"
        ),
        Material::Glass { ior: 1.5 }
    );
}

#[test]
fn coats_are_principled() {
    let Material::Principled {
        base_color,
        metallic,
        roughness,
        ior,
    } = whole(
        "Material \"coateddiffuse\" \"rgb reflectance\" [.2 .3 .4] \"float roughness\" .0625 \"float eta\" 1.4",
    )
    else {
        panic!("principled");
    };
    close(base_color.to_array(), [0.2, 0.3, 0.4]);
    // Alpha is the root of pbrt's roughness, and the square of glTF's.
    close([metallic, roughness, ior], [0.0, 0.5, 1.4]);
    let Material::Principled { metallic, .. } = told(
        "Material \"coatedconductor\" \"float conductor.roughness\" .1",
        "the material \"coatedconductor\" is not supported; the metal stands without its coat",
    ) else {
        panic!("principled");
    };
    assert_eq!(metallic, 1.0);
}

#[test]
fn what_has_no_match_is_told() {
    assert_eq!(
        told(
            "Material \"hair\"",
            "the material \"hair\" is not supported; it is matte"
        ),
        gray(0.5)
    );
    assert_eq!(
        told(
            "Material \"diffusetransmission\"",
            "the material \"diffusetransmission\" is not supported; it reflects, and nothing passes through"
        ),
        gray(0.25)
    );
    let scene = read(
        "WorldBegin\nMaterial \"interface\"\nShape \"sphere\"\nMaterial \"thindielectric\"\nShape \"sphere\"",
    );
    assert!(scene.objects.is_empty());
    assert_eq!(
        scene.warnings,
        [
            "a.pbrt:3:1: surfaces of thin glass or of nothing are left out; light passes straight through"
        ]
    );
    let scene = read(
        "WorldBegin\nMaterial \"diffuse\" \"float roughnes\" 1 \"texture displacement\" \"d\"\nShape \"sphere\"",
    );
    assert_eq!(
        scene.warnings,
        [
            "a.pbrt:2:1: displacement is not supported; the surface stays as it is",
            "a.pbrt:2:20: \"roughnes\" of the material \"diffuse\" is not used",
        ]
    );
}

#[test]
fn named_materials_may_be_defined_after_they_are_used() {
    let scene = read_whole(
        "WorldBegin NamedMaterial \"a\" Shape \"sphere\" MakeNamedMaterial \"a\" \"string type\" \"dielectric\"",
    );
    assert_eq!(scene.materials[0].material, Material::Glass { ior: 1.5 });
    assert_eq!(scene.materials[0].name, "a");
}

#[test]
fn of_a_mix_the_heavier_part_stands() {
    let mix = |amount: &str| {
        told(
            &format!(
                "MakeNamedMaterial \"m\" \"string type\" \"mix\" \"string materials\" [\"a\" \"b\"] \"float amount\" {amount} MakeNamedMaterial \"a\" \"string type\" \"diffuse\" MakeNamedMaterial \"b\" \"string type\" \"dielectric\" NamedMaterial \"m\""
            ),
            "a mix of materials is not supported; the one with more weight stands alone",
        )
    };
    assert_eq!(mix(".2"), gray(0.5));
    assert_eq!(mix(".8"), Material::Glass { ior: 1.5 });
}

#[test]
fn a_material_is_there_once_for_all_its_shapes() {
    let shapes = "Shape \"sphere\"\n".repeat(5);
    let scene = read_whole(&format!(
        "WorldBegin Material \"dielectric\" {shapes} Material \"dielectric\" {shapes}"
    ));
    assert_eq!((scene.objects.len(), scene.materials.len()), (10, 2));
}

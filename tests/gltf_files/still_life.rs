//! `scenes/still-life.glb`, as `tools/still_life.py` writes it.

use super::*;
use ondine::material::Material;

fn still_life() -> Description {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    read_in(&scenes, "still-life.glb").expect("a scene")
}

#[test]
fn the_still_life_is_read_whole() {
    let scene = still_life();
    // Table, two walls, vase, ball, twenty beads; beads and walls share a mesh.
    assert_eq!((scene.objects.len(), scene.meshes.len()), (25, 6));
    assert_eq!((scene.lights.len(), scene.materials.len()), (1, 6));
    // Tiles, stripes, finish, dents.
    assert_eq!(scene.textures.len(), 4);
    assert_eq!(scene.cameras[0].name, "camera");
    assert_eq!((scene.film.width, scene.film.height), (512, 384));
    let glass = |material: &Material| matches!(material, Material::Glass { .. });
    assert!(scene.materials.iter().any(|named| glass(&named.material)));
    let [warning] = &scene.warnings[..] else {
        panic!("{:?}", scene.warnings);
    };
    assert!(
        warning.contains(": transmission is rendered as "),
        "{warning}"
    );
}

#[test]
fn its_normals_are_on_the_front_of_its_triangles() {
    for mesh in &still_life().meshes {
        for &corners in &mesh.triangles {
            let [a, b, c] = corners.map(|corner| mesh.positions[corner as usize]);
            let front = (b - a).cross(c - a).normalize();
            for corner in corners {
                let normal = mesh.normals[corner as usize];
                assert!(
                    front.dot(normal) > 0.5,
                    "{}: {front} and {normal}",
                    mesh.name
                );
            }
        }
    }
}

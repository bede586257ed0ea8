//! The built-in scenes, and no panic whatever is done to them.

use super::*;

#[test]
fn every_scene_of_the_folder_is_built_in_and_read() {
    let mut files: Vec<String> = std::fs::read_dir("scenes")
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| {
            path.extension()
                .is_some_and(|extension| extension == "toml")
        })
        .map(|path| path.file_stem().unwrap().to_str().unwrap().to_owned())
        .collect();
    let mut names: Vec<_> = builtin::ALL.iter().map(|scene| scene.name).collect();
    files.sort();
    names.sort_unstable();
    assert_eq!(files, names);
    for scene in builtin::ALL {
        let description = scene.load().unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(description.name, scene.name);
        assert!(description.objects.len() + description.lights.len() < 64);
        assert!(description.render.spp.is_some() && description.render.path_length.is_some());
        assert!(
            scene.text.starts_with("# ") && scene.title().len() > 20,
            "{}",
            scene.title()
        );
    }
}

#[test]
fn a_scene_that_does_not_exist_is_refused_with_those_that_do() {
    assert_eq!(builtin::open("cornell").unwrap().name, "cornell");
    for (scene, words) in [
        (
            "cornel",
            "did you mean \"cornell\"? Built-in scenes: cornell, mirror,",
        ),
        (
            "my/cornel.toml",
            "no built-in scene \"my/cornel.toml\"; did you mean \"cornell\"?",
        ),
        ("", "Built-in scenes: cornell,"),
        (
            "castle.GLB",
            "there is no file and no built-in scene \"castle.GLB\"",
        ),
        (
            "Cargo.lock",
            "is not a scene file; scenes are .toml, .pbrt, .gltf, .glb, .obj and .ply files",
        ),
    ] {
        let message = builtin::open(scene).unwrap_err().to_string();
        assert!(message.contains(words), "{message}");
    }
}

#[test]
fn errors_in_a_built_in_scene_would_name_it() {
    let error = toml::parse("version = 1", "built-in scene x", None).unwrap_err();
    assert!(error.to_string().starts_with("built-in scene x:1:1: "));
}

#[test]
fn cornell_is_the_scene_of_the_reference_image() {
    let scene = builtin::open("cornell").unwrap();
    let camera = scene.cameras[0].camera;
    assert_eq!(camera.position.to_array(), [0.0, 0.0, 2.95]);
    assert_eq!(camera.look_at.to_array(), [0.0, 0.0, -1.0]);
    assert_eq!(camera.up.to_array(), [0.0, 1.0, 0.0]);
    assert_eq!(
        (
            camera.vertical_fov,
            camera.aperture_radius,
            camera.focus_distance
        ),
        (50.0, 0.0, 3.3)
    );
    assert_eq!(
        (scene.film.width, scene.film.height, scene.film.filter),
        (256, 256, Filter::Box)
    );
    assert_eq!(
        (scene.render.spp, scene.render.path_length),
        (Some(64), Some(6))
    );
    assert_eq!(scene.render.strategy, Some(Strategy::Mis));
    assert_eq!(scene.render.sampler, Some(SamplerKind::Sobol));
    let lambert = |name: &str| {
        let named = scene
            .materials
            .iter()
            .find(|material| material.name == name)
            .unwrap();
        let Material::Lambert { albedo } = named.material else {
            panic!("{name} is not matte");
        };
        albedo.to_array()
    };
    assert_eq!(lambert("white"), [0.73, 0.73, 0.73]);
    assert_eq!(lambert("red"), [0.65, 0.05, 0.05]);
    assert_eq!(lambert("green"), [0.12, 0.45, 0.15]);
    assert_eq!(lambert("blue"), [0.3, 0.4, 0.73]);
    let quad = |corner: [f32; 3], u: [f32; 3], v: [f32; 3]| Shape::Quad {
        corner: corner.into(),
        u: u.into(),
        v: v.into(),
    };
    let sphere = |center: [f32; 3], radius| Shape::Sphere {
        center: center.into(),
        radius,
    };
    let expected = [
        (quad([-1., -1., 3.], [2., 0., 0.], [0., 0., -4.]), "white"),
        (quad([-1., 1., -1.], [2., 0., 0.], [0., 0., 4.]), "white"),
        (quad([-1., -1., -1.], [2., 0., 0.], [0., 2., 0.]), "white"),
        (quad([1., -1., 3.], [-2., 0., 0.], [0., 2., 0.]), "white"),
        (quad([-1., -1., 3.], [0., 0., -4.], [0., 2., 0.]), "red"),
        (quad([1., -1., -1.], [0., 0., 4.], [0., 2., 0.]), "green"),
        (sphere([-0.42, -0.65, -0.35], 0.35), "white"),
        (sphere([0.42, -0.7, 0.25], 0.3), "blue"),
    ];
    assert_eq!(scene.objects.len(), expected.len());
    for (object, (shape, material)) in scene.objects.iter().zip(expected) {
        assert_eq!(object.shape, shape);
        assert_eq!(scene.materials[object.material].name, material);
    }
    let [light] = scene.lights.as_slice() else {
        panic!("one light");
    };
    assert_eq!(light.shape, sphere([0.0, 0.7, 0.0], 0.15));
    assert_eq!(light.radiance, Rgb::new(20.0, 18.0, 15.0));
    assert!(light.material.is_none() && !light.two_sided && scene.environment.is_none());
}

#[test]
fn no_damage_to_a_scene_file_makes_its_reader_panic() {
    let mut random = Pcg32::new(1, 2);
    let mut read_still = 0;
    for round in 0..20_000 {
        let scene = builtin::ALL[round % builtin::ALL.len()];
        let bytes = mutated(scene.text.as_bytes(), &mut random);
        match read(&String::from_utf8_lossy(&bytes)) {
            Ok(_) => read_still += 1,
            Err(Error::Scene { place, .. }) => assert!(place.line >= 1 && place.column >= 1),
            Err(error) => panic!("{error} names no place"),
        }
    }
    // Most damage is in comments or digits, or is refused: both happen, or the edits test nothing.
    assert!((500..18_000).contains(&read_still), "{read_still}");
}

#[test]
fn deep_nesting_and_endless_names_are_refused_not_run_into() {
    let deep = "[".repeat(100_000);
    refuses_text(
        &format!("version = {deep}"),
        "1:91",
        &["not valid TOML", "recurs"],
    );
    let dotted = "a.".repeat(100_000);
    assert!(refusal(&format!("version = 1\n{dotted}a = 1")).contains("recursion limit"));
    // As deep as the parser lets through: dotted keys in nested inline tables.
    let keys = "a.".repeat(70);
    let nested = format!(
        "{}1{}",
        format!("{{ {keys}a = ").repeat(70),
        " }".repeat(70)
    );
    refuses_text(
        &format!("version = 1\na = {nested}"),
        "2:1",
        &["unknown key \"a\""],
    );
    let long = "x".repeat(5_000_000);
    assert!(refusal(&format!("version = 1\n{long} = 1")).len() < 400);
    assert!(refusal(&RIGHT.replace("\"white\"", &format!("\"{long}\""))).len() < 400);
}

//! Light sources seen directly: their sides, their materials, what shadows them.

use crate::render::*;
use ondine::scene::description::Description;

fn looking(position: [f64; 3], look_at: [f64; 3], rest: &str) -> Description {
    scene(&format!(
        "[camera]\nposition = {position:?}\nlook_at = {look_at:?}\nup = [0.0, 1.0, 0.0]\nvertical_fov = 10.0\n\
         [materials.half]\ntype = \"lambert\"\nalbedo = [0.5, 0.5, 0.5]\n{rest}"
    ))
}

/// Every pixel of an image in which paths of that many edges see but one radiance, for every strategy.
fn assert_all(description: &Description, edges: u32, want: f32, what: &str) {
    for strategy in STRATEGIES {
        let mut settings = settings(description, (8, 8), 5);
        (settings.strategy, settings.path_length) = (strategy, edges);
        for pixel in film(description, &settings).means() {
            assert_eq!(
                pixel,
                [want, 2.0 * want, 0.5 * want],
                "{what}, {strategy}, {edges} edges"
            );
        }
    }
}

#[test]
fn quads_emit_on_the_side_of_cross_u_v_and_on_both_if_told() {
    let quad = "[[lights]]\nquad = { corner = [-5.0, -5.0, 0.0], u = [10.0, 0.0, 0.0], v = [0.0, 10.0, 0.0] }\nradiance = [3.0, 6.0, 1.5]\n";
    let both = format!("{quad}two_sided = true\n");
    for edges in [1, 2, 4] {
        for (z, light, want) in [
            (4.0, quad, 3.0),
            (-4.0, quad, 0.0),
            (4.0, &both, 3.0),
            (-4.0, &both, 3.0),
        ] {
            let description = looking([0.0, 0.0, z], [0.0; 3], light);
            assert_all(&description, edges, want, &format!("from {z}"));
        }
    }
}

#[test]
fn spheres_emit_outwards_and_inwards_if_told() {
    let sphere = "[[lights]]\nsphere = { center = [0.0, 0.0, 0.0], radius = 2.0 }\nradiance = [3.0, 6.0, 1.5]\n";
    let both = format!("{sphere}two_sided = true\n");
    for edges in [1, 2, 4] {
        for (z, light, want) in [
            (6.0, sphere, 3.0),
            (1.0, sphere, 0.0),
            (6.0, &both, 3.0),
            (1.0, &both, 3.0),
        ] {
            let description = looking([0.0, 0.0, z], [0.0; 3], light);
            assert_all(&description, edges, want, &format!("from {z}"));
        }
    }
}

#[test]
fn the_dark_side_of_a_light_hides_what_is_behind_it() {
    let rest = "[[lights]]\nquad = { corner = [5.0, -5.0, 0.0], u = [-10.0, 0.0, 0.0], v = [0.0, 10.0, 0.0] }\nradiance = [3.0, 6.0, 1.5]\n\
                [environment]\nconstant = [1.0, 2.0, 0.5]\n";
    for edges in [1, 2, 4] {
        assert_all(
            &looking([0.0, 0.0, 4.0], [0.0; 3], rest),
            edges,
            0.0,
            "behind",
        );
        assert_all(
            &looking([0.0, 0.0, 4.0], [0.0, 0.0, 9.0], rest),
            edges,
            1.0,
            "sky",
        );
    }
}

#[test]
fn a_light_with_a_material_scatters_and_one_without_does_not() {
    let sphere = "[environment]\nconstant = [1.0, 1.0, 1.0]\n\
                  [[lights]]\nsphere = { center = [0.0, 0.0, 0.0], radius = 2.0 }\nradiance = [3.0, 6.0, 1.5]\n";
    let scattering = format!("{sphere}material = \"half\"\n");
    for strategy in STRATEGIES {
        for (text, edges, reflected) in [
            (sphere, 1, 0.0),
            (sphere, 3, 0.0),
            (&scattering, 1, 0.0),
            (&scattering, 2, 0.5),
            (&scattering, 4, 0.5),
        ] {
            let description = looking([0.0, 0.0, 6.0], [0.0; 3], text);
            let mut settings = settings(&description, (16, 16), 1024);
            (settings.strategy, settings.path_length) = (strategy, edges);
            let want = [3.0, 6.0, 1.5].map(|e| e + reflected);
            let what = format!("{strategy}, {edges} edges, reflects {reflected}");
            assert_mean(&film(&description, &settings), want, 1e-2, &what);
        }
    }
}

#[test]
fn a_path_of_one_edge_sees_emitters_only_and_a_second_edge_adds_their_light() {
    let rest = "[[objects]]\nquad = { corner = [-9.0, 0.0, 9.0], u = [18.0, 0.0, 0.0], v = [0.0, 0.0, -18.0] }\nmaterial = \"half\"\n\
                [[lights]]\nsphere = { center = [0.0, 30.0, 0.0], radius = 5.0 }\nradiance = [3.0, 6.0, 1.5]\n";
    let description = looking([0.0, 3.0, 3.0], [0.0; 3], rest);
    assert_all(&description, 1, 0.0, "floor");
    for strategy in STRATEGIES {
        let mut settings = settings(&description, (16, 16), 256);
        settings.strategy = strategy;
        let mut lit = |edges| {
            settings.path_length = edges;
            film(&description, &settings).means()
        };
        // Nothing but the lamp sees the floor: further edges add nothing, to the last bit.
        let direct = lit(2);
        assert!(direct.iter().map(|p| p[0]).sum::<f32>() > 0.0);
        if strategy != ondine::scene::description::Strategy::Mis {
            assert_eq!(direct, lit(3), "{strategy}");
        }
        assert_eq!(lit(4), lit(6), "{strategy}");
    }
}

#[test]
fn a_wall_between_a_light_and_a_floor_casts_a_shadow_and_the_light_itself_does_not() {
    let floor = "[[objects]]\nquad = { corner = [-9.0, 0.0, 9.0], u = [18.0, 0.0, 0.0], v = [0.0, 0.0, -18.0] }\nmaterial = \"half\"\n\
                 [[lights]]\nquad = { corner = [-1.0, 4.0, -1.0], u = [2.0, 0.0, 0.0], v = [0.0, 0.0, 2.0] }\nradiance = [3.0, 6.0, 1.5]\n";
    let shade = "[[objects]]\nquad = { corner = [-6.0, 3.5, -6.0], u = [12.0, 0.0, 0.0], v = [0.0, 0.0, 12.0] }\nmaterial = \"half\"\n";
    let open = looking([0.0, 3.0, 3.0], [0.0; 3], floor);
    let shaded = looking([0.0, 3.0, 3.0], [0.0; 3], &format!("{floor}{shade}"));
    for strategy in STRATEGIES {
        for (description, dark) in [(&open, false), (&shaded, true)] {
            let mut settings = settings(description, (8, 8), 2048);
            (settings.strategy, settings.path_length) = (strategy, 2);
            let means = film(description, &settings).means();
            assert!(
                means.iter().all(|p| (p[0] == 0.0) == dark),
                "{strategy}, shaded: {dark}"
            );
        }
    }
}

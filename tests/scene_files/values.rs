//! What a value may be: colours, materials, cameras, settings.

use super::*;

#[test]
fn colours_are_physical() {
    refuses(
        "[5, 5, 5]",
        "[5, 5, -0.1]",
        "14:19",
        &["b of radiance", "at least 0", "-0.1"],
    );
    refuses(
        "[0.8, 0.8, 0.8]",
        "[0.8, 1.1, 0.8]",
        "8:16",
        &["g of albedo", "from 0 to 1", "1.1"],
    );
    refuses("[0.8, 0.8, 0.8]", "[-1, 1, 0.8]", "8:11", &["r of albedo"]);
    accepts("[0.8, 0.8, 0.8]", "[0, 1, 1.0]");
    accepts("[5, 5, 5]", "[0, 0, 1e30]");
}

const ALBEDO: &str = "type = \"lambert\"\nalbedo = [0.8, 0.8, 0.8]";

#[test]
fn a_phong_material_reflects_no_more_than_it_gets() {
    let phong = |diffuse: &str, specular: &str, n: &str| {
        format!("type = \"phong\"\ndiffuse = {diffuse}\nspecular = {specular}\nexponent = {n}")
    };
    let red = "[0.1, 0.1, 0.1]";
    refuses(
        ALBEDO,
        &phong(red, "[0.1, 0.95, 0]", "5"),
        "9:12",
        &["diffuse + specular is 1.05 in green", "lower either"],
    );
    refuses(ALBEDO, &phong(red, red, "-1"), "10:12", &["at least 0"]);
    accepts(ALBEDO, &phong("[0.7, 0.1, 0.9]", "[0.3, 0.9, 0.1]", "0"));
    refuses(
        ALBEDO,
        "type = \"phong\"\ndiffuse = [0, 0, 0]",
        "6:1",
        &["has no specular; add specular ="],
    );
}

#[test]
fn every_material_has_its_own_ranges() {
    for roughness in ["0", "-0.5", "1.5"] {
        let conductor =
            format!("type = \"conductor\"\nreflectance = [1, 1, 1]\nroughness = {roughness}");
        refuses(
            ALBEDO,
            &conductor,
            "9:13",
            &["above 0 and at most 1", "mirror"],
        );
    }
    for ior in ["0", "-1.5"] {
        refuses(
            ALBEDO,
            &format!("type = \"glass\"\nior = {ior}"),
            "8:7",
            &["above 0", "1.5"],
        );
    }
    let inverted = accepts(ALBEDO, "type = \"glass\"\nior = 0.66");
    assert_eq!(
        inverted.materials[0].material,
        Material::Glass { ior: 0.66 }
    );
    refuses(
        ALBEDO,
        "type = \"mirror\"",
        "6:1",
        &["a mirror material has no reflectance; add"],
    );
    refuses(
        ALBEDO,
        "albedo = [1, 1, 1]",
        "6:1",
        &["[materials.white] has no type; add type ="],
    );
    refuses(
        "\"lambert\"",
        "\"lambrt\"",
        "7:8",
        &["did you mean \"lambert\"?", "conductor"],
    );
    refuses(
        "\"lambert\"",
        "\"velvet\"",
        "7:8",
        &["unknown material type \"velvet\".", "Use lambert"],
    );
}

#[test]
fn cameras_look_somewhere_with_a_right_side() {
    refuses(
        "look_at = [0, 0, 0]",
        "look_at = [0, 0, 3]",
        "4:11",
        &["the same point as position", "move either"],
    );
    let up = |up: &str| format!("vertical_fov = 50\nup = {up}");
    refuses(
        "vertical_fov = 50",
        &up("[0, 0, 2]"),
        "6:6",
        &["parallel", "write up = [0.0, 1.0, 0.0]"],
    );
    refuses(
        "vertical_fov = 50",
        &up("[0, 0, 0]"),
        "6:6",
        &["no direction"],
    );
    refuses(
        "look_at = [0, 0, 0]",
        "look_at = [0, 9, 3]",
        "4:11",
        &["parallel", "write up = [0.0, 0.0, -1.0]"],
    );
    for fov in ["0", "180", "-5", "200"] {
        refuses(
            "vertical_fov = 50",
            &format!("vertical_fov = {fov}"),
            "5:16",
            &["above 0 and below 180 degrees"],
        );
    }
    refuses(
        "vertical_fov = 50",
        "vertical_fov = 50\naperture_radius = -1",
        "6:19",
        &["at least 0"],
    );
    refuses(
        "vertical_fov = 50",
        "vertical_fov = 50\nfocus_distance = 0",
        "6:18",
        &["above 0"],
    );
    refuses(
        "vertical_fov = 50\n",
        "",
        "2:1",
        &["[camera] has no vertical_fov; add vertical_fov = 50.0"],
    );
}

#[test]
fn cameras_keep_the_order_of_the_file() {
    let body = "position = [0, 0, 3]\nlook_at = [0, 0, 0]\nvertical_fov = 50\n";
    let several = format!("[cameras.zoe]\n{body}[cameras.adam]\n{body}[cameras.mia]\n{body}");
    let scene = accepts(&format!("[camera]\n{body}"), &several);
    let names: Vec<_> = scene
        .cameras
        .iter()
        .map(|camera| camera.name.as_str())
        .collect();
    assert_eq!(names, ["zoe", "adam", "mia"]);
    refuses_appended(
        "[cameras.b]\n",
        "15:2",
        &["both [camera] and [cameras]", "rename [camera]"],
    );
    refuses(
        &format!("[camera]\n{body}"),
        "",
        "1:1",
        &["no camera; add [camera]"],
    );
    refuses(
        &format!("[camera]\n{body}"),
        "[cameras]\n",
        "2:2",
        &["[cameras] is empty"],
    );
    refuses("[camera]", "[[camera]]", "2:1", &["a table", "[camera]"]);
}

#[test]
fn film_and_render_settings_have_ranges() {
    let film = |w: &str, h: &str| format!("[film]\nwidth = {w}\nheight = {h}\n");
    refuses_appended(&film("0", "4"), "16:9", &["from 1 to 65535", "this is 0"]);
    refuses_appended(&film("4", "65536"), "17:10", &["from 1 to 65535"]);
    refuses_appended(
        &film("4.0", "4"),
        "16:9",
        &["a whole number without a decimal point"],
    );
    refuses_appended(&film("4", "99999999999999999999999"), "17:10", &["65535"]);
    refuses_appended(
        "[film]\nwidth = 4\n",
        "15:1",
        &["[film] has no height; add height = 256"],
    );
    refuses_appended(
        &format!("{}filter = \"gauss\"\n", film("4", "4")),
        "18:10",
        &["gaussian", "did you mean"],
    );
    for (setting, column, word) in [
        ("spp = 0", 7, "from 1"),
        ("path_length = 0", 15, "from 1"),
        ("path_length = 10001", 15, "to 10000"),
        ("spp = 134217729", 7, "to 134217728"),
        ("strategy = \"mix\"", 12, "did you mean \"mis\"?"),
        ("sampler = \"halton\"", 11, "Known: pcg, sobol"),
        ("seed = -1", 8, "from 0 to 18446744073709551615"),
        ("roulette = 0", 12, "from 1"),
        ("spp = true", 7, "true or false"),
    ] {
        let text = format!("[render]\n{setting}\n");
        refuses_appended(&text, &format!("16:{column}"), &[word]);
    }
    let settings = "spp = 7\npath_length = 1\nstrategy = \"light\"\nsampler = \"pcg\"\nseed = 18446744073709551615\nroulette = 2\n";
    let scene = read(&format!(
        "{RIGHT}[render]\n{settings}[film]\nwidth = 65535\nheight = 1\nfilter = \"tent\"\n"
    ))
    .unwrap();
    assert_eq!(scene.render.seed, Some(u64::MAX));
    assert_eq!(scene.render.roulette, Some(2));
    assert_eq!(scene.render.strategy, Some(Strategy::Light));
    assert_eq!(scene.render.sampler, Some(SamplerKind::Pcg));
    assert_eq!(scene.film.filter, Filter::Tent);
}

#[test]
fn choices_are_written_as_they_are_read() {
    for (name, strategy) in Strategy::NAMES {
        assert_eq!(name.parse::<Strategy>().unwrap(), *strategy);
        assert_eq!(strategy.to_string(), *name);
    }
    assert_eq!(Strategy::NAMES.len(), 4);
    assert_eq!(SamplerKind::Sobol.to_string(), "sobol");
    assert_eq!(format!("{:>6}", Filter::Box), "   box");
    let error = "cosin".parse::<Strategy>().unwrap_err().to_string();
    assert_eq!(
        error,
        "unknown strategy \"cosin\"; did you mean \"cosine\"? Known: uniform, cosine, light, mis"
    );
}

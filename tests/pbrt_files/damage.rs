//! No damage to a file makes its reader panic.

use super::*;
use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;

const SCENES: [&str; 3] = [
    "Scale -1 1 1\nLookAt 0 1 5  0 0 0  0 1 0\nCamera \"perspective\" \"float fov\" [ 40 ] \"float lensradius\" .1\n\
     Film \"rgb\" \"integer xresolution\" 40 \"integer yresolution\" 30\nSampler \"stratified\" \"integer xsamples\" 4\n\
     PixelFilter \"gaussian\" \"float xradius\" 2\nIntegrator \"path\" \"integer maxdepth\" 4\nWorldBegin\n\
     LightSource \"infinite\" \"rgb L\" [.1 .2 .3] \"float scale\" 2\nLightSource \"spot\" \"blackbody I\" 3000 \"float coneangle\" 20\n\
     Material \"conductor\" \"spectrum eta\" \"metal-Au-eta\" \"float roughness\" .1\nShape \"sphere\" \"float radius\" 2 \"float zmin\" -1\n",
    "WorldBegin\nObjectBegin \"o\"\nShape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0] \"integer indices\" [0 1 2 2 1 3] \"point2 uv\" [0 0 1 0 0 1 1 1]\nObjectEnd\n\
     AttributeBegin\nRotate 30 0 1 0\nObjectInstance \"o\"\nAttributeEnd\nTransformBegin\nConcatTransform [1 0 0 0 0 2 0 0 0 0 3 0 4 5 6 1]\nObjectInstance \"o\"\nTransformEnd\n",
    "WorldBegin\nTexture \"c\" \"spectrum\" \"checkerboard\" \"rgb tex1\" [1 0 0] \"float uscale\" 4\nTexture \"s\" \"spectrum\" \"scale\" \"texture tex\" \"c\" \"float scale\" .5\n\
     MakeNamedMaterial \"m\" \"string type\" \"coateddiffuse\" \"texture reflectance\" \"s\" \"float eta\" 1.3\nNamedMaterial \"m\"\nReverseOrientation\n\
     AreaLightSource \"diffuse\" \"spectrum L\" [400 1 500 2 600 3] \"bool twosided\" true\nShape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 1]\nShape \"disk\" \"float innerradius\" .2 \"float alpha\" .7\n",
];

fn mutated(original: &[u8], random: &mut Pcg32) -> Vec<u8> {
    const WORDS: [&str; 14] = [
        " ",
        "\"",
        "[",
        "]",
        "-",
        "1e38",
        "0",
        "-1",
        "AttributeEnd\n",
        "ObjectEnd\n",
        "\"o\"",
        "\n",
        "\\",
        "\u{e9}",
    ];
    let mut below = |limit: usize| random.next_u32() as usize % limit.max(1);
    let mut bytes = original.to_vec();
    for _ in 0..=below(3) {
        let at = below(bytes.len());
        let end = (at + 1 + below(6)).min(bytes.len());
        match below(5) {
            0 => bytes[at] ^= 1 << below(8),
            1 => drop(bytes.drain(at..end)),
            2 => drop(bytes.splice(at..at, WORDS[below(WORDS.len())].bytes())),
            3 => bytes.truncate(at.max(1)),
            _ => {
                // A token in another's place.
                let word = WORDS[below(WORDS.len())];
                drop(bytes.splice(at..end, word.bytes()));
            }
        }
        if bytes.is_empty() {
            bytes.push(b'#');
        }
    }
    bytes
}

#[test]
fn no_damage_to_a_scene_makes_its_reader_panic() {
    let mut random = Pcg32::new(5, 7);
    let folder = Folder::new("");
    let mut read_still = 0;
    const ROUNDS: usize = 12_000;
    for round in 0..ROUNDS {
        let bytes = mutated(SCENES[round % SCENES.len()].as_bytes(), &mut random);
        std::fs::write(folder.path("a.pbrt"), &bytes).unwrap();
        match folder.read() {
            Ok(_) => read_still += 1,
            Err(Error::Scene { place, .. }) => assert!(place.line >= 1 && place.column >= 1),
            Err(error) => panic!("{error} names no place"),
        }
    }
    // Both happen, or the edits test nothing.
    assert!(
        (ROUNDS / 20..ROUNDS * 19 / 20).contains(&read_still),
        "{read_still}"
    );
}

#[test]
fn the_scenes_that_are_damaged_are_right() {
    for scene in SCENES {
        read(scene);
    }
}

//! The scenes of the suites. Each is a text, and what is generated for it; nothing is read from a file.

use super::landscape::{landscape, sky, unit};
use crate::error::Result;
use crate::film::write_whole;
use crate::scene::builtin;
use crate::scene::description::{Description, Environment, LatLong, Object, Shape};
use crate::scene::mesh::Mesh;
use crate::scene::toml;
use glam::Affine3A;
use std::fmt::Write as _;
use std::io::{self, Cursor, Write};
use std::path::Path;
use std::sync::Arc;

/// What all that is generated comes from.
const SEED: u32 = 2014;
/// Lanterns of the scene of many lights.
const LANTERNS: u32 = 128;
/// Triangles of the ground below the sky.
const SKY_TRIANGLES: usize = 100_000;

/// How much is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Suite {
    /// About a minute on two cores.
    Quick,
    /// A mesh of ten million triangles, more samples, all wave sizes: about ten minutes on two cores, and 4 GB of memory.
    Full,
}

crate::scene::description::choices!(Suite, "suite": "quick" = Quick, "full" = Full);

/// A scene of a suite, and how it is rendered.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// Its name in reports.
    pub name: &'static str,
    /// What it shows, in a few words.
    pub title: &'static str,
    /// Pixels on a side.
    pub side: u32,
    /// Samples per pixel in the quick suite; the full one has four times as many.
    pub spp: u32,
    /// Whether the quick suite has it.
    pub is_quick: bool,
    /// Means and variances of 64 × 64 cells of its image.
    pub reference: &'static [u8],
    scene: Kind,
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    Builtin(&'static str),
    Landscape(usize),
    Lanterns,
    Sky,
}

/// Edges of all paths.
pub const PATH_LENGTH: u32 = 6;

macro_rules! cases {
    ($($name:literal $side:literal $spp:literal $quick:literal $title:literal $scene:expr;)+) => {
        &[$(Case {
            name: $name,
            title: $title,
            side: $side,
            spp: $spp,
            is_quick: $quick,
            reference: include_bytes!(concat!("references/", $name, ".npy")),
            scene: $scene,
        }),+]
    };
}

/// Every scene, in the order of reports: its name, side, samples, whether it is quick, what it shows.
pub const CASES: &[Case] = cases! {
    "box"       512 32 true  "the Cornell box"                            Kind::Builtin("cornell");
    "materials" 512 16 true  "a box of every material"                    Kind::Builtin("materials");
    "mesh-1e4"  256 16 true  "mountains of ten thousand triangles"        Kind::Landscape(10_000);
    "mesh-1e5"  256 16 true  "mountains of a hundred thousand triangles"  Kind::Landscape(100_000);
    "mesh-1e6"  256 16 true  "mountains of a million triangles"           Kind::Landscape(1_000_000);
    "mesh-1e7"  256 16 false "mountains of ten million triangles"         Kind::Landscape(10_000_000);
    "lights"    256 16 true  "128 lanterns over a floor"                  Kind::Lanterns;
    "sky"       256 16 true  "metal and plastic in the mountains, under an image of the sky" Kind::Sky;
};

impl Suite {
    /// Its scenes.
    pub fn cases(self) -> impl Iterator<Item = &'static Case> {
        CASES.iter().filter(move |case| self.has(case))
    }

    /// Whether a scene is one of them.
    pub fn has(self, case: &Case) -> bool {
        case.is_quick || self == Suite::Full
    }

    /// Samples per pixel of a scene.
    pub fn spp(self, case: &Case) -> u32 {
        match self {
            Suite::Quick => case.spp,
            Suite::Full => 4 * case.spp,
        }
    }
}

/// A scene's text and what was generated for it.
struct Made {
    text: String,
    mesh: Option<Mesh>,
    sky: Option<LatLong>,
}

impl Case {
    /// About how many triangles it has.
    pub fn triangles(&self) -> usize {
        match self.scene {
            Kind::Landscape(triangles) => triangles,
            Kind::Sky => SKY_TRIANGLES,
            Kind::Builtin(_) | Kind::Lanterns => 0,
        }
    }

    fn make(&self) -> Made {
        let (text, mesh, sky) = match self.scene {
            Kind::Builtin(name) => {
                let text = builtin::find(name).map_or("", |scene| scene.text);
                (text.to_owned(), None, None)
            }
            Kind::Landscape(triangles) => {
                (MOUNTAINS.to_owned(), Some(landscape(SEED, triangles)), None)
            }
            Kind::Lanterns => (lanterns(), None, None),
            Kind::Sky => (
                UNDER_THE_SKY.to_owned(),
                Some(landscape(SEED, SKY_TRIANGLES)),
                Some(sky(SEED)),
            ),
        };
        Made { text, mesh, sky }
    }

    /// The scene.
    ///
    /// # Errors
    /// None that a test of this crate would not have met.
    pub fn description(&self) -> Result<Description> {
        let Made {
            mut text,
            mesh,
            sky,
        } = self.make();
        let name = format!("benchmark scene {}", self.name);
        if sky.is_some() {
            // A scene without any light would be refused.
            text += "\n[environment]\nconstant = [1.0, 1.0, 1.0]\n";
        }
        let mut description = toml::parse(&text, &name, None)?;
        if let Some(mesh) = mesh {
            description.objects.push(Object {
                shape: Shape::Mesh {
                    mesh: description.meshes.len(),
                    transform: Affine3A::IDENTITY,
                },
                // The first that the text names is the ground's.
                material: 0,
            });
            description.meshes.push(Arc::new(mesh));
        }
        if let Some(sky) = sky {
            description.environment = Some(Environment::Image {
                image: Arc::new(sky),
                rotate_degrees: 0.0,
            });
        }
        Ok(description)
    }

    /// Writes the scene as files for any renderer: `NAME.toml`, and where it has them `NAME.ply` and `NAME.exr`.
    ///
    /// # Errors
    /// [`Error::Write`](crate::error::Error::Write).
    pub fn export(&self, folder: &Path) -> Result<()> {
        let Made {
            mut text,
            mesh,
            sky,
        } = self.make();
        let name = self.name;
        if let Some(mesh) = mesh {
            write_whole(&folder.join(format!("{name}.ply")), |file| {
                write_ply(&mesh, file)
            })?;
            let _ = write!(
                text,
                "\n[[objects]]\nmesh = {{ file = \"{name}.ply\" }}\nmaterial = \"ground\"\n"
            );
        }
        if let Some(sky) = sky {
            write_whole(&folder.join(format!("{name}.exr")), |file| {
                write_sky(&sky, file)
            })?;
            let _ = write!(text, "\n[environment]\nimage = \"{name}.exr\"\n");
        }
        write_whole(&folder.join(format!("{name}.toml")), |file| {
            file.write_all(text.as_bytes())
        })
    }
}

fn write_ply(mesh: &Mesh, file: &mut impl Write) -> io::Result<()> {
    write!(
        file,
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        mesh.positions.len(),
        mesh.triangles.len()
    )?;
    for number in mesh.positions.iter().flat_map(|p| p.to_array()) {
        file.write_all(&number.to_le_bytes())?;
    }
    for triangle in &mesh.triangles {
        file.write_all(&[3])?;
        for corner in triangle {
            file.write_all(&corner.to_le_bytes())?;
        }
    }
    Ok(())
}

fn write_sky(sky: &LatLong, file: &mut impl Write) -> io::Result<()> {
    use ::exr::prelude::{Image, SpecificChannels, WritableImage};
    let pixel = |at: ::exr::math::Vec2<usize>| {
        let color = sky.pixels[at.y() * sky.width + at.x()];
        (color.r, color.g, color.b)
    };
    let channels = SpecificChannels::rgb(pixel);
    let image = Image::from_channels((sky.width, sky.height), channels);
    let mut bytes = Vec::new();
    image
        .write()
        .to_buffered(Cursor::new(&mut bytes))
        .map_err(io::Error::other)?;
    file.write_all(&bytes)
}

const MOUNTAINS: &str = r#"version = 1

[camera]
position = [0.0, 1.0, 2.1]
look_at = [0.0, 0.2, 0.0]
vertical_fov = 42.0

[materials.ground]
type = "lambert"
albedo = [0.5, 0.45, 0.4]

[[lights]] # the sun, low enough for long shadows
sphere = { center = [6.0, 5.0, 2.0], radius = 0.4 }
radiance = [700.0, 610.0, 480.0]

[environment]
gradient = { zenith = [0.2, 0.4, 0.9], horizon = [0.8, 0.8, 0.85], ground = [0.2, 0.18, 0.15] }
"#;

const UNDER_THE_SKY: &str = r#"version = 1

[camera]
position = [0.0, 1.0, 2.1]
look_at = [0.0, 0.4, 0.0]
vertical_fov = 42.0

[materials.ground]
type = "lambert"
albedo = [0.45, 0.42, 0.36]

[materials.metal]
type = "conductor"
roughness = 0.3
reflectance = [0.95, 0.8, 0.5]

[materials.plastic]
type = "principled"
base_color = [0.1, 0.3, 0.6]
metallic = 0.0
roughness = 0.4

[materials.chalk]
type = "lambert"
albedo = [0.8, 0.8, 0.8]

[[objects]]
sphere = { center = [-0.75, 0.75, 0.0], radius = 0.3 }
material = "metal"

[[objects]]
sphere = { center = [0.0, 0.75, 0.0], radius = 0.3 }
material = "plastic"

[[objects]]
sphere = { center = [0.75, 0.75, 0.0], radius = 0.3 }
material = "chalk"
"#;

/// A hall without a roof, with lanterns at random.
fn lanterns() -> String {
    let mut text = String::from(HALL);
    for i in 0..LANTERNS {
        let random = |k: u32| unit(SEED + k, i);
        let (x, z) = (4.0 * random(0) - 2.0, 4.0 * random(1) - 2.5);
        let (y, radius) = (0.12 + 0.9 * random(2), 0.02 + 0.03 * random(3));
        let [r, g, b] = [4, 5, 6].map(|k| 2.0 + 22.0 * random(k));
        let _ = write!(
            text,
            "\n[[lights]]\nsphere = {{ center = [{x:?}, {y:?}, {z:?}], radius = {radius:?} }}\nradiance = [{r:?}, {g:?}, {b:?}]\n"
        );
    }
    text
}

const HALL: &str = r#"version = 1

[camera]
position = [0.0, 1.3, 4.2]
look_at = [0.0, 0.4, 0.0]
vertical_fov = 42.0

[materials.floor]
type = "phong"
diffuse = [0.4, 0.4, 0.42]
specular = [0.2, 0.2, 0.2]
exponent = 40

[materials.wall]
type = "lambert"
albedo = [0.6, 0.6, 0.62]

[[objects]] # floor
quad = { corner = [-3.0, 0.0, 3.0], u = [6.0, 0.0, 0.0], v = [0.0, 0.0, -6.0] }
material = "floor"

[[objects]] # back wall
quad = { corner = [-3.0, 0.0, -3.0], u = [6.0, 0.0, 0.0], v = [0.0, 2.5, 0.0] }
material = "wall"

[[objects]]
sphere = { center = [-0.9, 0.4, 0.3], radius = 0.4 }
material = "wall"

[[objects]]
sphere = { center = [0.9, 0.4, 0.3], radius = 0.4 }
material = "wall"
"#;

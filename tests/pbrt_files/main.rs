//! What is read of pbrt-v4 scenes, what is told of the rest, and what is refused, with its place.

mod cameras;
mod changes;
mod damage;
mod directives;
mod lights;
mod materials;
mod refusals;
mod shapes;
mod textures;

use ondine::error::Error;
use ondine::lanes::Rgb;
use ondine::material::Material;
use ondine::scene::description::{Description, Shape};
use ondine::scene::pbrt;
use tempfile::TempDir;

/// A folder with `a.pbrt` in it, and the files that it names.
struct Folder(TempDir);

impl Folder {
    fn new(scene: &str) -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        folder.with("a.pbrt", scene)
    }

    fn with(self, name: &str, content: impl AsRef<[u8]>) -> Self {
        std::fs::write(self.path(name), content).unwrap();
        self
    }

    fn path(&self, name: &str) -> std::path::PathBuf {
        self.0.path().join(name)
    }

    fn read(&self) -> Result<Description, Error> {
        pbrt::load(&self.path("a.pbrt"))
    }

    /// A message without the folder's name.
    fn plain(&self, message: &str) -> String {
        message.replace(&format!("{}/", self.0.path().display()), "")
    }
}

#[track_caller]
fn read(scene: &str) -> Description {
    read_folder(&Folder::new(scene))
}

#[track_caller]
fn read_folder(folder: &Folder) -> Description {
    let mut description = folder.read().unwrap_or_else(|error| panic!("{error}"));
    for warning in &mut description.warnings {
        *warning = folder.plain(warning);
    }
    description
}

/// Reads a scene of which nothing is left out.
#[track_caller]
fn read_whole(scene: &str) -> Description {
    let description = read(scene);
    assert!(
        description.warnings.is_empty(),
        "{:?}",
        description.warnings
    );
    description
}

#[track_caller]
fn refuses(scene: &str, message: &str) {
    refuses_folder(&Folder::new(scene), message);
}

#[track_caller]
fn refuses_folder(folder: &Folder, message: &str) {
    match folder.read() {
        Ok(_) => panic!("read without complaint"),
        Err(error) => assert_eq!(folder.plain(&error.to_string()), message),
    }
}

#[track_caller]
fn close(a: impl AsRef<[f32]>, b: impl AsRef<[f32]>) {
    let (a, b) = (a.as_ref(), b.as_ref());
    assert_eq!(a.len(), b.len());
    for (x, y) in a.iter().zip(b) {
        assert!(
            (x - y).abs() <= 1e-5 * (1.0 + y.abs()),
            "{a:?}\nis not\n{b:?}"
        );
    }
}

/// A material that the only object has.
#[track_caller]
fn material(text: &str) -> (Description, Material) {
    let scene = read(&format!("WorldBegin\n{text}\nShape \"sphere\""));
    let [object] = scene.objects.as_slice() else {
        panic!("one object");
    };
    let material = scene.materials[object.material].material;
    (scene, material)
}

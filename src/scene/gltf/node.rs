//! Nodes: where meshes, cameras and lights stand.

use super::file::AGAIN;
use super::mesh::Part;
use super::{LONGER_SIDE, Reader};
use crate::error::Result;
use crate::lanes::Rgb;
use crate::scene::description::{
    Camera, Light, MOST_OBJECTS, NamedCamera, Object, Punctual, Shape,
};
use glam::{Affine3A, DAffine3, DMat4, DQuat, DVec3, Vec3};
use gltf::camera::Projection;
use gltf::khr_lights_punctual::Kind;
use gltf::scene::Transform;
use gltf::{Accessor, Node};

/// Greatest coordinate of a point of a scene.
const FARTHEST: f32 = 1e9;
/// Sine of the smallest angle between a camera's up and its axis.
const PARALLEL: f64 = 1e-4;

impl<'a> Reader<'a> {
    /// Visits the nodes of the default scene, parents first, in file order.
    pub(super) fn nodes(&mut self) -> Result<()> {
        let document = &self.file.document;
        let mut stack: Vec<(Node<'a>, DAffine3)> =
            match document.default_scene().or(document.scenes().next()) {
                Some(scene) => scene
                    .nodes()
                    .map(|node| (node, DAffine3::IDENTITY))
                    .collect(),
                None => {
                    let mut is_child = vec![false; document.nodes().len()];
                    for child in document.nodes().flat_map(|node| node.children()) {
                        is_child[child.index()] = true;
                    }
                    let roots = document.nodes().filter(|node| !is_child[node.index()]);
                    roots.map(|node| (node, DAffine3::IDENTITY)).collect()
                }
            };
        stack.reverse();
        let mut visited = vec![false; document.nodes().len()];
        while let Some((node, parent)) = stack.pop() {
            let place = format!("nodes[{}]", node.index());
            // Sharing nodes would let a small file describe 2ⁿ of them; a cycle, infinitely many.
            if std::mem::replace(&mut visited[node.index()], true) {
                let message = "it has two parents or is its own ancestor, and nodes form trees; copy the node, or share its mesh";
                return Err(self.file.error(place, message));
            }
            let world = parent * self.local(&node, &place)?;
            if !world.is_finite() {
                return Err(self
                    .file
                    .error(place, format!("its transform is not finite; {AGAIN}")));
            }
            self.node(&node, world, &place)?;
            let first = stack.len();
            stack.extend(node.children().map(|child| (child, world)));
            stack[first..].reverse();
        }
        Ok(())
    }

    fn local(&self, node: &Node, place: &str) -> Result<DAffine3> {
        match node.transform() {
            Transform::Matrix { matrix } => {
                let columns = matrix.map(|column| column.map(f64::from));
                Ok(DAffine3::from_mat4(DMat4::from_cols_array_2d(&columns)))
            }
            Transform::Decomposed {
                translation,
                rotation,
                scale,
            } => self.composed(translation, rotation, scale, place),
        }
    }

    fn composed(
        &self,
        translation: [f32; 3],
        rotation: [f32; 4],
        scale: [f32; 3],
        place: &str,
    ) -> Result<DAffine3> {
        let rotation = DQuat::from_array(rotation.map(f64::from));
        if !(rotation.is_finite() && rotation.length_squared() > 0.0) {
            return Err(self
                .file
                .error(place, format!("its rotation has no direction; {AGAIN}")));
        }
        let [translation, scale] =
            [translation, scale].map(|v| DVec3::from_array(v.map(f64::from)));
        Ok(DAffine3::from_scale_rotation_translation(
            scale,
            rotation.normalize(),
            translation,
        ))
    }

    fn node(&mut self, node: &Node<'a>, world: DAffine3, place: &str) -> Result<()> {
        if let Some(mesh) = node.mesh() {
            if node.skin().is_some() {
                self.notes
                    .tell(place, "skins are left out: meshes keep their own shape");
            }
            let parts = self.parts(&mesh)?;
            for local in self.instances(node, place)? {
                for part in &parts {
                    self.add(part, world * local, place)?;
                }
            }
        }
        if let Some(camera) = node.camera() {
            self.camera(node, &camera, world, place)?;
        }
        if let Some(light) = node.light() {
            self.light(&light, world)?;
        }
        Ok(())
    }

    /// The transforms of EXT_mesh_gpu_instancing; one identity without it.
    fn instances(&self, node: &Node<'a>, place: &str) -> Result<Vec<DAffine3>> {
        const NAME: &str = "EXT_mesh_gpu_instancing";
        let Some(attributes) = node
            .extension_value(NAME)
            .and_then(|value| value.get("attributes"))
        else {
            return Ok(vec![DAffine3::IDENTITY]);
        };
        let place = format!("{place}.extensions.{NAME}.attributes");
        let translations = self.attribute(attributes, "TRANSLATION", &place)?;
        let rotations = self.attribute(attributes, "ROTATION", &place)?;
        let scales = self.attribute(attributes, "SCALE", &place)?;
        let counts = [
            translations.as_ref().map(Vec::len),
            rotations.as_ref().map(Vec::len),
            scales.as_ref().map(Vec::len),
        ];
        let count = counts.into_iter().flatten().next().unwrap_or(0);
        if counts.into_iter().flatten().any(|other| other != count) {
            let message =
                format!("they have different counts, and each instance needs one of each; {AGAIN}");
            return Err(self.file.error(place, message));
        }
        let of = |index: usize| {
            self.composed(
                translations.as_ref().map_or([0.0; 3], |all| all[index]),
                rotations
                    .as_ref()
                    .map_or([0.0, 0.0, 0.0, 1.0], |all| all[index]),
                scales.as_ref().map_or([1.0; 3], |all| all[index]),
                &place,
            )
        };
        (0..count).map(of).collect()
    }

    fn attribute<const N: usize>(
        &self,
        attributes: &serde_json::Value,
        name: &str,
        place: &str,
    ) -> Result<Option<Vec<[f32; N]>>> {
        let Some(value) = attributes.get(name) else {
            return Ok(None);
        };
        let place = format!("{place}.{name}");
        let index = value.as_u64().and_then(|index| usize::try_from(index).ok());
        let accessor: Option<Accessor> =
            index.and_then(|index| self.file.document.accessors().nth(index));
        let accessor = accessor.ok_or_else(|| {
            self.file.error(
                &place,
                format!("it names something that is not there; {AGAIN}"),
            )
        })?;
        self.file.vectors(&accessor, &place).map(Some)
    }

    fn add(&mut self, part: &Part, world: DAffine3, place: &str) -> Result<()> {
        let transform = single(world);
        let corners = [part.low, part.high];
        let is_far = (0..8).any(|corner| {
            let at = |axis: usize| corners[corner >> axis & 1][axis];
            !is_near(transform.transform_point3(Vec3::new(at(0), at(1), at(2))))
        });
        if is_far {
            let message =
                format!("its mesh reaches beyond ±1e9; {AGAIN}, nearer to the origin or smaller");
            return Err(self.file.error(place, message));
        }
        if !(transform.matrix3.determinant() != 0.0 && transform.inverse().is_finite()) {
            self.notes
                .tell(place, "meshes that their node flattens are left out");
            return Ok(());
        }
        let shape = Shape::Mesh {
            mesh: part.mesh,
            transform,
        };
        let material = part.surface.material;
        if self.description.objects.len() + self.description.lights.len() >= MOST_OBJECTS {
            let message = format!(
                "there are more than {MOST_OBJECTS} meshes to place; export fewer instances"
            );
            return Err(self.file.error(place, message));
        }
        match part.surface.emission {
            None => self.description.objects.push(Object { shape, material }),
            Some(emission) => self.description.lights.push(Light {
                shape,
                radiance: emission.radiance,
                two_sided: emission.two_sided,
                material: Some(material),
                texture: emission.texture,
            }),
        }
        Ok(())
    }

    /// A camera looks along −z of its node, its up is +y (glTF 2.0, sec. 3.10).
    fn camera(
        &mut self,
        node: &Node,
        camera: &gltf::Camera,
        world: DAffine3,
        place: &str,
    ) -> Result<()> {
        let wrong = |what: &str, message: &str| {
            let place = format!("cameras[{}].perspective.{what}", camera.index());
            Err(self.file.error(place, format!("{message}; {AGAIN}")))
        };
        let perspective = match camera.projection() {
            Projection::Perspective(perspective) => perspective,
            Projection::Orthographic(_) => {
                self.notes.tell(place, "orthographic cameras are left out");
                return Ok(());
            }
        };
        let vertical_fov = f64::from(perspective.yfov()).to_degrees() as f32;
        if !(vertical_fov > 0.0 && vertical_fov < 180.0) {
            return wrong(
                "yfov",
                &format!(
                    "it is {}, and a camera sees more than 0 and less than pi",
                    perspective.yfov()
                ),
            );
        }
        let position = world.translation;
        let forward = world.transform_vector3(DVec3::NEG_Z).normalize_or_zero();
        let up = world.transform_vector3(DVec3::Y).normalize_or_zero();
        if !(forward.cross(up).length() >= PARALLEL
            && position.abs().max_element() <= f64::from(FARTHEST))
        {
            let message = format!("its camera is flattened or beyond ±1e9; {AGAIN}");
            return Err(self.file.error(place, message));
        }
        if let Some(aspect) = perspective.aspect_ratio() {
            if !(aspect > 0.0 && aspect.is_finite()) {
                return wrong(
                    "aspectRatio",
                    &format!("it is {aspect}, and a ratio of sides is above 0"),
                );
            }
            if self.description.cameras.is_empty() {
                let side =
                    |ratio: f32| (LONGER_SIDE as f32 * ratio.min(1.0)).round().max(1.0) as u32;
                self.description.film.width = side(aspect);
                self.description.film.height = side(1.0 / aspect);
            }
        }
        // As far away as the camera from the origin: rounding does not turn it.
        let look_at = position + forward * position.abs().max_element().max(1.0);
        let number = camera.index();
        let name = node
            .name()
            .or(camera.name())
            .map_or(format!("camera {number}"), str::to_owned);
        let name = self.unique(name);
        self.description.cameras.push(NamedCamera {
            name,
            camera: Camera {
                position: position.as_vec3(),
                look_at: look_at.as_vec3(),
                up: up.as_vec3(),
                vertical_fov,
                aperture_radius: 0.0,
                focus_distance: 1.0,
            },
        });
        Ok(())
    }

    /// The name, with a number after it where another camera has it.
    fn unique(&self, name: String) -> String {
        let taken = |name: &String| {
            self.description
                .cameras
                .iter()
                .any(|camera| camera.name == *name)
        };
        let mut numbered = (2..).map(|number| format!("{name} {number}"));
        if !taken(&name) {
            return name;
        }
        numbered.find(|name| !taken(name)).unwrap_or(name)
    }

    /// KHR_lights_punctual: lights shine along −z of their node.
    fn light(&mut self, light: &gltf::khr_lights_punctual::Light, world: DAffine3) -> Result<()> {
        let place = format!("extensions.KHR_lights_punctual.lights[{}]", light.index());
        let color = light.color().map(|channel| channel * light.intensity());
        if color
            .iter()
            .any(|channel| !(channel.is_finite() && *channel >= 0.0))
        {
            let message =
                format!("its light is {color:?}, and light is finite and at least 0; {AGAIN}");
            return Err(self.file.error(place, message));
        }
        if color == [0.0; 3] {
            return Ok(());
        }
        let intensity = Rgb::from(color);
        let position = world.translation.as_vec3();
        let direction = world
            .transform_vector3(DVec3::NEG_Z)
            .normalize_or_zero()
            .as_vec3();
        if !is_near(position) || direction == Vec3::ZERO {
            return Err(self.file.error(
                place,
                format!("its node is flattened or beyond ±1e9; {AGAIN}"),
            ));
        }
        self.description.punctual.push(match light.kind() {
            Kind::Point => Punctual::Point {
                position,
                intensity,
            },
            Kind::Directional => Punctual::Distant {
                direction,
                irradiance: intensity,
            },
            Kind::Spot {
                inner_cone_angle: inner,
                outer_cone_angle: outer,
            } => {
                if !(0.0 <= inner && inner <= outer && outer <= std::f32::consts::FRAC_PI_2) {
                    let message = format!("its cone is from {inner} to {outer}, and angles grow from 0 to pi / 2; {AGAIN}");
                    return Err(self.file.error(place, message));
                }
                let cos_outer = libm::cosf(outer);
                Punctual::Spot {
                    position,
                    direction,
                    intensity,
                    // Exporters write cones without a soft edge.
                    cos_inner: libm::cosf(inner).max(cos_outer.next_up()),
                    cos_outer,
                }
            }
        });
        Ok(())
    }
}

/// Whether a point can be part of a scene; not if it is not finite.
fn is_near(point: Vec3) -> bool {
    point.to_array().iter().all(|c| c.abs() <= FARTHEST)
}

fn single(transform: DAffine3) -> Affine3A {
    let [x, y, z] = [0, 1, 2].map(|axis| transform.matrix3.col(axis).as_vec3());
    Affine3A::from_cols(
        x.into(),
        y.into(),
        z.into(),
        transform.translation.as_vec3a(),
    )
}

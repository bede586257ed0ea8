//! Scenes whose radiance is known in closed form or by quadrature, through the whole renderer.

#[path = "../common/mod.rs"]
mod common;
mod furnaces;
mod irradiance;
#[path = "../common/render.rs"]
mod render;
mod skies;
mod sources;

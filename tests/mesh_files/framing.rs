//! The camera of files that have none.

use glam::Vec3;
use ondine::scene::framing::frame;

#[test]
fn the_whole_box_is_in_the_image() {
    for (low, high) in [
        (Vec3::ZERO, Vec3::ONE),
        (Vec3::new(-1.0, 0.0, -50.0), Vec3::new(1.0, 300.0, 50.0)),
        (Vec3::splat(1e6), Vec3::new(1e6 + 1e3, 1e6 + 1.0, 1e6 + 1.0)),
        (Vec3::splat(-1e-4), Vec3::splat(1e-4)),
    ] {
        let camera = frame(low, high);
        let forward = (camera.look_at - camera.position).normalize();
        let right = forward.cross(camera.up).normalize();
        let up = right.cross(forward);
        let half = (0.5 * camera.vertical_fov).to_radians().tan();
        for corner in 0..8 {
            let pick = |axis: usize| {
                if corner >> axis & 1 == 0 {
                    low[axis]
                } else {
                    high[axis]
                }
            };
            let to = Vec3::new(pick(0), pick(1), pick(2)) - camera.position;
            let depth = to.dot(forward);
            assert!(depth > 0.0);
            let (x, y) = (to.dot(right) / depth / half, to.dot(up) / depth / half);
            assert!(x.abs() < 1.0 && y.abs() < 1.0, "{low} {high}: ({x}, {y})");
        }
        assert!(camera.position.y > low.y, "from above");
    }
}

#[test]
fn a_point_is_framed_too() {
    for at in [Vec3::ZERO, Vec3::splat(1e8)] {
        let camera = frame(at, at);
        assert!((camera.look_at - camera.position).length() > 0.0);
    }
}

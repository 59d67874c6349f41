//! Tests the map for Mitsuba on a frame of its layout: a floor and a ball, whose depth is counted from the near plane.

use super::files::{Part, floats, write_exr};
use super::named_channels;
use crate::common::folder::Folder;
use crate::common::repository;
use glam::DVec3;
use ssct_scenes::gbuffer_map::GBufferMap;

/// Size of the frame in pixels.
const SIZE: [u32; 2] = [160, 90];

/// The surface that a pixel shows. `from_near` is the distance along the ray from the near plane, 0 for sky; place and
/// normal are in the renderer's world. The number `shape` is 1 for the ball, 2 for the floor and 0 for sky.
#[derive(Clone, Copy)]
struct VisibleSurface {
    from_near: f64,
    place: DVec3,
    normal: DVec3,
    shape: f64,
}

/// Traces pixel (`x`, `y`) of the scene of `mitsuba_scene.py`, in its own right-handed world, through the camera of the
/// map.
fn visible_surface(x: u32, y: u32) -> VisibleSurface {
    let (eye, target, near) = (DVec3::new(2.5, 1.6, -5.0), DVec3::new(0.0, 0.6, 0.0), 0.5);
    let forward = (target - eye).normalize();
    let right = forward.cross(DVec3::Y).normalize();
    let up = right.cross(forward);
    let tan_half_fov = 30_f64.to_radians().tan();
    let [width, height] = SIZE.map(f64::from);
    let across = ((f64::from(x) + 0.5) / width * 2.0 - 1.0) * tan_half_fov;
    let above = (1.0 - (f64::from(y) + 0.5) / height * 2.0) * tan_half_fov * height / width;
    let ray = forward + across * right + above * up;
    let centre = DVec3::new(0.0, 0.9, 0.0);
    let from_centre = eye - centre;
    // The ball is hit where a t² + 2 b t + c = 0.
    let (a, b, c) = (ray.length_squared(), from_centre.dot(ray), from_centre.length_squared() - 0.81);
    let ball_t = if b * b > a * c { (-b - (b * b - a * c).sqrt()) / a } else { f64::INFINITY };
    let floor_t = if ray.y < 0.0 { -eye.y / ray.y } else { f64::INFINITY };
    let z = ball_t.min(floor_t);
    let place = eye + z * ray;
    if !z.is_finite() || place.abs().max_element() > 6.0 {
        return VisibleSurface { from_near: 0.0, place: DVec3::ZERO, normal: DVec3::ZERO, shape: 0.0 };
    }
    let (normal, shape) = if ball_t < floor_t { ((place - centre) / 0.9, 1.0) } else { (DVec3::Y, 2.0) };
    VisibleSurface { from_near: (z - near) * ray.length(), place, normal, shape }
}

/// The frame read by the map agrees with its own places of surfaces. If the map named another kind of depth, the check
/// would name the right one. No other renderer counts depth from the near plane.
#[test]
fn the_map_of_mitsuba_counts_depth_from_the_near_plane() {
    let pixels: Vec<VisibleSurface> =
        (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| visible_surface(x, y))).collect();
    let channel = |value: &dyn Fn(&VisibleSurface) -> f64| floats(pixels.iter().map(value));
    let names = ["depth.T", "normal.X", "normal.Y", "normal.Z", "place.X", "place.Y", "place.Z", "shape.I"];
    let samples = [
        channel(&|s| s.from_near),
        channel(&|s| s.normal.x),
        channel(&|s| s.normal.y),
        channel(&|s| s.normal.z),
        channel(&|s| s.place.x),
        channel(&|s| s.place.y),
        channel(&|s| s.place.z),
        channel(&|s| s.shape),
    ];
    let folder = Folder::new();
    write_exr(&folder.path("frame.exr"), SIZE, vec![Part::new(named_channels(&names, samples))]);
    let grey = ["R", "G", "B"];
    write_exr(
        &folder.path("lit.exr"),
        SIZE,
        vec![Part::new(named_channels(&grey, [0, 1, 2].map(|_| channel(&|_| 0.5))))],
    );
    let map = GBufferMap::load(&repository().join("examples/gbuffer-maps/mitsuba.toml")).unwrap();
    let file = folder.path("frame.exr");
    let data = map.read(&file).unwrap();
    // The file has the places of surfaces, and the check computes them from depth and camera, too.
    assert_eq!(map.check(&file, &data).unwrap(), None);
    let [floor, ball] = [data.index(80, 80), data.index(80, 45)];
    assert!((data.reflectivity[floor] - 0.8).abs() < 1e-6 && data.reflectivity[ball] == 0.0);
    assert_eq!(data.depth[data.index(2, 2)], 0.0, "what meets nothing is sky");

    let text = std::fs::read_to_string(repository().join("examples/gbuffer-maps/mitsuba.toml")).unwrap();
    folder.write("wrong.toml", text.replace("distance-from-near", "distance"));
    let wrong_map = GBufferMap::load(&folder.path("wrong.toml")).unwrap();
    let message = wrong_map.check(&file, &wrong_map.read(&file).unwrap()).unwrap().unwrap();
    assert!(message.contains("with kind = \"distance-from-near\" in [depth] it would be 0 %"), "{message}");
}

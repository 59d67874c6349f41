//! Tests cameras of maps: one lens said in every way, in the conventions of the graphics interfaces, with a shift.

use super::files::{Part, floats, write_exr};
use super::named_channels;
use crate::common::folder::Folder;
use glam::{DMat4, DVec3, DVec4, Mat4};
use ssct_scenes::gbuffer_map::GBufferMap;
use ssct_scenes::{Camera, Lens};

/// Size of the frame in pixels.
const SIZE: [u32; 2] = [8, 4];
/// Distance of the near plane in metres.
const NEAR: f64 = 0.5;
/// Distance of the far plane in metres.
const FAR: f64 = 40.0;
/// The angle of view from top to bottom, in radians.
const FOV: f64 = 0.9;
/// Width over height of the image.
const ASPECT: f64 = 2.0;
/// Pixels to the right and down by which the picture is shifted.
const SHIFT: [f64; 2] = [0.75, -0.5];

/// Returns the view depths of the 32 pixels, in metres. Pixel 5 lies beyond the far plane, so that it is sky.
fn depths() -> Vec<f64> {
    (0..32).map(|i| if i == 5 { FAR * 2.0 } else { NEAR + 0.9 * f64::from(i) }).collect()
}

/// Reads a frame whose depth channel has some values, by a map with the given lines in three of its sections. Returns
/// the camera and the reversed depths.
fn read(conventions: &str, camera: &str, depth: &str, values: impl Iterator<Item = f64>) -> (Camera, Vec<f32>) {
    let folder = Folder::new();
    // A channel with one value in all pixels.
    let flat = |value: f64| floats(vec![value; 32]);
    let channels = named_channels(&["d", "zero", "one"], [floats(values), flat(0.0), flat(1.0)]);
    write_exr(&folder.path("f.exr"), SIZE, vec![Part::new(channels)]);
    let map = format!(
        "[conventions]\n{conventions}\n[camera]\n{camera}\n[depth]\nchannel = \"d\"\n{depth}\n[normal]\nspace = \
         \"view\"\n\
         channels = [\"zero\", \"zero\", \"one\"]\n[roughness]\nvalue = 0\nkind = \"lobe\"\n[reflectivity]\nvalue = 1\n\
         [[color]]\nvalue = 1\n"
    );
    folder.write("map.toml", map);
    let data = GBufferMap::load(&folder.path("map.toml")).unwrap().read(&folder.path("f.exr")).unwrap();
    (data.camera, data.depth)
}

/// Checks that two cameras show points at the same places and depths.
fn assert_same_camera(a: &Camera, b: &Camera) {
    for point in [DVec3::new(0.3, -0.2, 1.0), DVec3::new(-4.0, 2.0, 7.0), DVec3::new(5.0, 5.0, 39.0)] {
        let [a, b] = [a, b].map(|camera| (camera.view_to_clip_reversed().as_dmat4()).project_point3(point));
        assert!(a.distance(b) < 2e-6, "{point}: {a} {b}");
    }
    assert!(a.world_to_view.abs_diff_eq(b.world_to_view, 1e-5), "{} {}", a.world_to_view, b.world_to_view);
}

/// Returns the values of [`depths`] for a channel.
fn view_z() -> impl Iterator<Item = f64> {
    depths().into_iter()
}

/// Angles in degrees and radians, along either axis, and focal lengths give one camera and the same depths. So do
/// centimetres, and depths with the other sign. Each way has a formula of its own.
#[test]
fn a_lens_can_be_said_in_every_way() {
    let planes = format!("near = {NEAR}\nfar = {FAR}");
    let linear = "kind = \"view-z\"";
    let (first_camera, depth) = read("", &format!("fov-y-rad = {FOV}\n{planes}"), linear, view_z());
    let reversed = |z: f64| if z >= FAR { 0.0 } else { NEAR * (FAR - z) / (z * (FAR - NEAR)) };
    assert!(depth.iter().zip(depths()).all(|(d, z)| (f64::from(*d) - reversed(z)).abs() < 1e-6), "{depth:?}");
    let fov_x = 2.0 * ((0.5 * FOV).tan() * ASPECT).atan();
    let sensor_width_mm = 36.0;
    let focal_length_mm = 0.5 * sensor_width_mm / ((0.5 * FOV).tan() * ASPECT);
    for lens in [
        format!("fov-y-deg = {}", FOV.to_degrees()),
        format!("fov-x-rad = {fov_x}"),
        format!("fov-x-deg = {}", fov_x.to_degrees()),
        format!("focal-length-mm = {focal_length_mm}\nsensor-width-mm = {sensor_width_mm}"),
        format!("focal-length-mm = {focal_length_mm}\nsensor-height-mm = {}\naspect = 2", sensor_width_mm / ASPECT),
    ] {
        let (camera, depth_found) = read("", &format!("{lens}\n{planes}"), linear, view_z());
        assert_same_camera(&camera, &first_camera);
        assert!(depth_found == depth, "{lens}");
    }
    // In centimetres, with distances in metres: the units of the camera are those of the conventions.
    let centimetres = format!("fov-y-rad = {FOV}\nnear = {}\nfar = {}", NEAR * 100.0, FAR * 100.0);
    let (camera, depth_found) =
        read("metres-per-unit = 0.01", &centimetres, "kind = \"view-z\"\nscale = 100", view_z());
    assert_same_camera(&camera, &first_camera);
    assert!(depth_found.iter().zip(&depth).all(|(a, b)| (a - b).abs() < 1e-6));
    // A depth that points the other way.
    let (_, depth_found) =
        read("", &format!("fov-y-rad = {FOV}\n{planes}"), "kind = \"view-z\"\nscale = -1", view_z().map(|z| -z));
    assert!(depth_found == depth);
}

/// Matrices of projection for four kinds of depth, three view spaces and two directions of clip space give the camera
/// that a lens with a shift gives. Two wrong signs may cancel in one combination.
#[test]
fn a_matrix_of_each_interface_is_the_lens_with_its_shift() {
    let planes = format!("near = {NEAR}\nfar = {FAR}");
    let shifted = format!("fov-y-rad = {FOV}\n{planes}\nshift-px = [{}, {}]", SHIFT[0], SHIFT[1]);
    let (expected, depth) = read("", &shifted, "kind = \"view-z\"", view_z());
    // A point straight ahead appears where the shift takes the middle of the image.
    let ahead = expected.view_to_clip_reversed().project_point3(glam::Vec3::Z * 3.0);
    let [width, height] = SIZE.map(f64::from);
    let pixel = [(f64::from(ahead.x) * 0.5 + 0.5) * width, (0.5 - 0.5 * f64::from(ahead.y)) * height];
    assert!((pixel[0] - 4.0 - SHIFT[0]).abs() < 1e-6 && (pixel[1] - 2.0 - SHIFT[1]).abs() < 1e-6, "{pixel:?}");
    let scale_y = 1.0 / (0.5 * FOV).tan();
    // The shift in clip space.
    let (shift_x, shift_y) = (2.0 * SHIFT[0] / width, -2.0 * SHIFT[1] / height);
    // Kinds of depth: the name, the elements M_22 and M_23 of the matrix, the stored depth as a function of z, and
    // whether the map must give the planes.
    let standard = |z: f64| FAR * (z - NEAR) / (z * (FAR - NEAR));
    type Depth<'a> = (&'a str, [f64; 2], Box<dyn Fn(f64) -> f64 + 'a>, bool);
    let kinds: [Depth; 4] = [
        ("standard", [FAR / (FAR - NEAR), -NEAR * FAR / (FAR - NEAR)], Box::new(standard), false),
        ("reversed", [-NEAR / (FAR - NEAR), NEAR * FAR / (FAR - NEAR)], Box::new(|z| 1.0 - standard(z)), false),
        ("reversed", [0.0, NEAR], Box::new(|z| NEAR / z), true),
        (
            "minus-one-to-one",
            [(FAR + NEAR) / (FAR - NEAR), -2.0 * NEAR * FAR / (FAR - NEAR)],
            Box::new(|z| 2.0 * standard(z) - 1.0),
            false,
        ),
    ];
    let world = DMat4::from_rotation_y(0.4) * DMat4::from_translation(DVec3::new(1.0, -2.0, 0.5));
    for (kind, [m_22, m_23], stored_depth, needs_planes) in &kinds {
        for (view, forward, up) in [("left", 1.0, 1.0), ("right", -1.0, 1.0), ("right-y-down", 1.0, -1.0)] {
            for clip_y in ["up", "down"] {
                // `flip` is the sign of y in clip space relative to this program's view space, and flip · up that
                // relative to theirs.
                let flip = if clip_y == "up" { 1.0 } else { -1.0 };
                let clip = DMat4::from_cols(
                    DVec4::new(scale_y / ASPECT, 0.0, 0.0, 0.0),
                    DVec4::new(0.0, flip * up * scale_y, 0.0, 0.0),
                    DVec4::new(shift_x, flip * shift_y, *m_22, 1.0) * forward,
                    DVec4::new(0.0, 0.0, *m_23, 0.0),
                );
                let to_their_view = DMat4::from_scale(DVec3::new(1.0, up, forward));
                let far = if *needs_planes { format!("far = {FAR}\nnear = {NEAR}\n") } else { String::new() };
                let [projection, place] =
                    [clip, to_their_view * world].map(|m| format!("{:?}", m.transpose().to_cols_array_2d()));
                let camera = format!("{far}projection = {projection}\nworld-to-view = {place}");
                let conventions = format!("view = \"{view}\"\nclip-y = \"{clip_y}\"\nmatrices = \"rows\"");
                let kind_key = format!("kind = \"{kind}\"");
                let (camera, depth_found) =
                    read(&conventions, &camera, &kind_key, depths().into_iter().map(|z| stored_depth(z.min(FAR))));
                let expected = Camera { world_to_view: world.as_mat4(), ..expected };
                assert_same_camera(&camera, &expected);
                assert!((camera.lens.far_m / expected.lens.far_m - 1.0).abs() < 1e-4, "{kind} {view}");
                // Standard depth in 32 bits is rounded by 2⁻²⁵, twice as much where its range is twice as large.
                let close = |(a, b): (&f32, &f32)| (a - b).abs() < 3e-7 + 2e-6 * b;
                assert!(depth_found.iter().zip(&depth).all(close), "{kind} {view}: {depth_found:?} {depth:?}");
            }
        }
    }
    // Reversed depth between the camera's own planes is read without any change of bits, also with a shift.
    let values = || (0..32).map(|i| f64::from(i) / 32.0);
    let (_, depth_found) = read("", &shifted, "kind = \"reversed\"", values());
    assert!(depth_found.iter().map(|d| f64::from(*d)).eq(values()), "{depth_found:?}");
    // The depth buffer has other planes than the camera.
    let lens = format!("fov-y-rad = {FOV}\n{planes}\nshift-px = [{}, {}]", SHIFT[0], SHIFT[1]);
    let (_, depth_found) = read("", &lens, "kind = \"reversed\"\nnear = 0.25\nfar = inf", view_z().map(|z| 0.25 / z));
    assert!(depth_found.iter().zip(&depth).all(|(a, b)| (a - b).abs() < 1e-6), "{depth_found:?} {depth:?}");
}

/// One camera, given by its eye with a target or a direction, is the same in worlds of other handedness, with z up and
/// in centimetres. Another up vector gives another camera.
#[test]
fn a_camera_can_stand_and_be_upright_in_every_world() {
    let lens = format!("fov-y-rad = {FOV}\nnear = {NEAR}\nfar = {FAR}");
    let world_to_view = |conventions: &str, pose: &str| {
        read(conventions, &format!("{lens}\n{pose}"), "kind = \"view-z\"", view_z()).0.world_to_view
    };
    let (eye, look_at) = (glam::Vec3::new(1.0, 2.0, 3.0), glam::Vec3::new(-2.0, 1.0, 7.0));
    let expected = Camera::new(eye, look_at, ssct_scenes::Lens::default(), ASPECT as f32).world_to_view;
    let forward = "forward = [-3, -1, 4]";
    assert_eq!(world_to_view("", "eye = [1, 2, 3]\nlook-at = [-2, 1, 7]"), expected);
    let check = |found: Mat4| assert!(found.abs_diff_eq(expected, 1e-6), "{found} {expected}");
    check(world_to_view("", &format!("eye = [1, 2, 3]\n{forward}")));
    check(world_to_view("", &format!("eye = [1, 2, 3]\n{forward}\nup = [0, 5, 0]")));
    check(world_to_view("world = \"right\"", "eye = [1, 2, -3]\nlook-at = [-2, 1, -7]"));
    check(world_to_view("world = \"right-z-up\"", "eye = [1, 3, 2]\nlook-at = [-2, 7, 1]\nup = [0, 0, 1]"));
    check(world_to_view(
        "world = \"left-z-up\"\nmetres-per-unit = 0.01",
        "eye = [300, 100, 200]\nlook-at = [700, -200, 100]",
    ));
    let leaning = world_to_view("", &format!("eye = [1, 2, 3]\n{forward}\nup = [1, 1, 0]"));
    assert!(!leaning.abs_diff_eq(expected, 0.1) && (leaning.determinant() - 1.0).abs() < 1e-5);
}

/// Metres from the lower to the upper side of an orthographic image.
const HEIGHT: f64 = 6.0;

/// Height, width and matrices of an orthographic lens give one camera and the same depths, in metres and in
/// centimetres.
#[test]
fn an_orthographic_lens_can_be_said_in_every_way() {
    let planes = format!("near = {NEAR}\nfar = {FAR}");
    let linear = "kind = \"view-z\"";
    let reversed = |z: f64| if z >= FAR { 0.0 } else { (FAR - z) / (FAR - NEAR) };
    let (first_camera, depth) = read("", &format!("orthographic-height = {HEIGHT}\n{planes}"), linear, view_z());
    assert_eq!(first_camera.lens, Lens::orthographic(HEIGHT as f32, NEAR as f32, FAR as f32));
    assert!(depth.iter().zip(depths()).all(|(d, z)| (f64::from(*d) - reversed(z)).abs() < 1e-6), "{depth:?}");
    let wide = format!("orthographic-width = {}\n{planes}", HEIGHT * ASPECT);
    // Rays of sight are parallel, so that a distance along one is a difference of z.
    let (camera, depth_found) = read("", &wide, "kind = \"distance\"", view_z());
    assert_same_camera(&camera, &first_camera);
    assert!(depth_found == depth);
    let centimetres = format!("orthographic-height = {}\nnear = {}\nfar = {}", HEIGHT * 1e2, NEAR * 1e2, FAR * 1e2);
    let (camera, depth_found) =
        read("metres-per-unit = 0.01", &centimetres, "kind = \"view-z\"\nscale = 100", view_z());
    assert_same_camera(&camera, &first_camera);
    assert!(depth_found.iter().zip(&depth).all(|(a, b)| (a - b).abs() < 1e-6));
    // By the matrix of projection: two handednesses, three kinds of depth, a shifted window, in metres and in
    // centimetres.
    let shifted = format!("orthographic-height = {HEIGHT}\n{planes}\nshift-px = [{}, {}]", SHIFT[0], SHIFT[1]);
    let (expected, _) = read("", &shifted, linear, view_z());
    let [width, height] = SIZE.map(f64::from);
    // The shift in clip space.
    let (shift_x, shift_y) = (2.0 * SHIFT[0] / width, -2.0 * SHIFT[1] / height);
    // Kinds of depth: the name, the line a + b z along which depth rises from `least_depth` to 1, and `least_depth`.
    for (kind, a, b, least_depth) in
        [("standard", -NEAR, 1.0, 0.0), ("reversed", FAR, -1.0, 0.0), ("minus-one-to-one", -NEAR, 1.0, -1.0)]
    {
        for (view, forward) in [("left", 1.0), ("right", -1.0)] {
            for unit in [1.0, 0.01] {
                let range = (FAR - NEAR) / (1.0 - least_depth);
                let stored_depth = |z: f64| least_depth + (a + b * z) / range;
                let clip = DMat4::from_cols(
                    DVec4::new(unit * 2.0 / (HEIGHT * ASPECT), 0.0, 0.0, 0.0),
                    DVec4::new(0.0, unit * 2.0 / HEIGHT, 0.0, 0.0),
                    DVec4::new(0.0, 0.0, unit * forward * b / range, 0.0),
                    DVec4::new(shift_x, shift_y, least_depth + a / range, 1.0),
                );
                let projection = format!("projection = {:?}", clip.transpose().to_cols_array_2d());
                let conventions = format!("view = \"{view}\"\nmatrices = \"rows\"\nmetres-per-unit = {unit}");
                let depth_kind = format!("kind = \"{kind}\"");
                let (camera, depth_found) =
                    read(&conventions, &projection, &depth_kind, view_z().map(|z| stored_depth(z.min(FAR))));
                assert_same_camera(&camera, &expected);
                assert!(
                    depth_found.iter().zip(&depth).all(|(a, b)| (a - b).abs() < 1e-6),
                    "{kind} {view}: {depth_found:?}"
                );
            }
        }
    }
}

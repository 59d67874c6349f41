//! Compares the analytic highlights of `area-light` with quadrature: the lobe of each pixel is sampled by a grid of
//! directions, and each direction is tested against the shape of the light.

use crate::common::{Builder, camera, gpu};
use glam::{DVec3, Vec3};
use ssct::methods::{Setup, Wants, find};
use ssct_ground::math::phong;
use ssct_lab::stage::image::render;
use ssct_lab::stage::{Shot, Stage, gbuffer};
use ssct_scenes::{AreaLight, AreaShape, Material, Scene};
use ssct_truth::reference::first_hits::{FirstHits, Receiver};
use ssct_truth::reference::lobe::lobe_direction;

/// Size of the image in pixels.
const EXTENT: [u32; 2] = [64, 48];
/// The grid has SIDE × SIDE directions.
const SIDE: u32 = 28;
/// The light's radiance in linear RGB. The three values differ, so that swapped channels are noticed.
const RADIANCE: Vec3 = Vec3::new(1.0, 0.5, 2.0);

/// Returns whether a ray from a point meets a light from the side on which it shines. `direction` has length 1.
fn ray_meets_light(shape: &AreaShape, from: DVec3, direction: DVec3) -> bool {
    match *shape {
        AreaShape::Sphere { centre, radius } => passes_within(centre.as_dvec3() - from, direction, f64::from(radius)),
        AreaShape::Capsule { a, b, radius } => {
            // A golden-section search along the segment finds its nearest approach to the ray, since the distance from
            // a ray is convex along a line.
            let (a, b) = (a.as_dvec3() - from, b.as_dvec3() - from);
            let distance = |t: f64| {
                let p = a.lerp(b, t);
                (p - direction * p.dot(direction).max(0.0)).length()
            };
            let (mut low, mut high, golden) = (0.0, 1.0, 0.5 * (5_f64.sqrt() - 1.0));
            for _ in 0..16 {
                let (x, y) = (high - golden * (high - low), low + golden * (high - low));
                if distance(x) < distance(y) { high = y } else { low = x }
            }
            distance(0.5 * (low + high)) <= f64::from(radius)
        }
        AreaShape::Cuboid { centre, half_u, half_v, half_w } => {
            let (u, v) = (half_u.as_dvec3(), half_v.as_dvec3());
            let halves = [u, v, u.cross(v).normalize() * f64::from(half_w)];
            let centre = centre.as_dvec3() - from;
            lies_ahead(&halves.map(|h| within_slab(centre, direction, h.normalize(), h.length())))
        }
        AreaShape::Cylinder { a, b, radius } => {
            let (a, b) = (a.as_dvec3() - from, b.as_dvec3() - from);
            let (centre, axis) = (0.5 * (a + b), (b - a).normalize());
            let slab = within_slab(centre, direction, axis, 0.5 * a.distance(b));
            lies_ahead(&[slab, within_tube(centre, direction, axis, f64::from(radius))])
        }
        AreaShape::Rectangle { centre, half_u, half_v } => {
            let (centre, u, v) = (centre.as_dvec3() - from, half_u.as_dvec3(), half_v.as_dvec3());
            let normal = u.cross(v);
            let t = centre.dot(normal) / direction.dot(normal);
            let from_centre = direction * t - centre;
            t > 0.0
                && direction.dot(normal) < 0.0
                && from_centre.dot(u).abs() <= u.length_squared()
                && from_centre.dot(v).abs() <= v.length_squared()
        }
    }
}

/// Returns the interval [enter, leave] of distances t for which the point t · `direction` lies within a slab: |(p −
/// centre) · axis| ≤ half. The axis has length 1. If the ray misses the slab, the interval is empty: enter > leave.
fn within_slab(centre: DVec3, direction: DVec3, axis: DVec3, half: f64) -> [f64; 2] {
    let (offset, rate) = (centre.dot(axis), direction.dot(axis));
    if rate == 0.0 {
        return if offset.abs() <= half {
            [f64::NEG_INFINITY, f64::INFINITY]
        } else {
            [f64::INFINITY, f64::NEG_INFINITY]
        };
    }
    let [a, b] = [-half, half].map(|side| (offset + side) / rate);
    [a.min(b), a.max(b)]
}

/// Returns the interval [enter, leave] of distances at which a ray from the origin lies within an endless tube around
/// the line through `centre` along `axis`. If the ray misses the tube, the interval is empty: enter > leave.
fn within_tube(centre: DVec3, direction: DVec3, axis: DVec3, radius: f64) -> [f64; 2] {
    let across = |v: DVec3| v - axis * v.dot(axis);
    let (centre_across, direction_across) = (across(centre), across(direction));
    let (middle, square) = (centre_across.dot(direction_across), direction_across.length_squared());
    let root = middle * middle - square * (centre_across.length_squared() - radius * radius);
    if root < 0.0 {
        return [f64::INFINITY, f64::NEG_INFINITY];
    }
    [-root.sqrt(), root.sqrt()].map(|r| (middle + r) / square)
}

/// Returns whether the intersection of all intervals, which are distances along a ray, has a part at a distance of 0 or
/// more.
fn lies_ahead(intervals: &[[f64; 2]]) -> bool {
    let start = intervals.iter().map(|i| i[0]).fold(0.0, f64::max);
    start <= intervals.iter().map(|i| i[1]).fold(f64::INFINITY, f64::min)
}

/// Returns whether a ray from the origin meets a sphere whose centre lies ahead of the ray's start. `direction` has
/// length 1.
fn passes_within(centre: DVec3, direction: DVec3, radius: f64) -> bool {
    let along = centre.dot(direction);
    along > 0.0 && (centre - direction * along).length() <= radius
}

/// Returns the share of a receiver's lobe that a light fills, from 0 to 1, by quadrature. A receiver is the surface
/// point of a pixel.
fn share(shape: &AreaShape, receiver: &Receiver) -> f64 {
    let (axis, exponent) = (receiver.mirror(), phong::exponent(receiver.roughness));
    let side = f64::from(SIDE);
    let cells = (0..SIDE * SIDE).map(|k| [f64::from(k % SIDE), f64::from(k / SIDE)].map(|v| (v + 0.5) / side));
    let lit_cells = cells.filter(|u| {
        let direction = lobe_direction(axis, exponent, *u);
        receiver.is_above(direction) && ray_meets_light(shape, receiver.position, direction)
    });
    lit_cells.count() as f64 / (side * side)
}

/// Returns a black mirror floor under a light of this shape.
fn lit_by(shape: AreaShape) -> Scene {
    let mut b = Builder::new("area light");
    let floor = b.mirror();
    b.quad(floor, Vec3::new(-10.0, 0.0, -4.0), Vec3::X * 20.0, Vec3::Z * 24.0, Vec3::Y);
    b.0.area_lights = vec![AreaLight { shape, radiance: RADIANCE }];
    b.0
}

/// Returns the error of the share that the device computes, over the pixels that any of the light reaches: first its
/// root mean square, then its greatest value. Both are absolute, since shares lie between 0 and 1.
fn errors(shape: AreaShape, roughness: f32) -> (f64, f64) {
    let scene = lit_by(shape);
    let gpu = gpu();
    let mut stage = Stage::new(&gpu, &scene).unwrap();
    let camera = camera(Vec3::new(0.0, 1.5, 0.0), Vec3::new(0.0, 0.6, 4.0), EXTENT);
    let materials: Vec<Material> = scene.materials.iter().map(|m| Material { roughness, ..m.clone() }).collect();
    let shot =
        Shot::new(&mut stage, find("area-light").unwrap(), &Setup::new(EXTENT), Wants::REFLECTION, camera, materials)
            .unwrap();
    let reflection = render(&mut stage, &shot, false).unwrap().reflection;
    gpu.check_validation().unwrap();
    let receivers = FirstHits::from_gbuffer(&gbuffer::read(&mut stage.context, &shot).unwrap()).receivers;
    let (mut sum, mut most, mut count) = (0.0, 0.0_f64, 0);
    for (texel, receiver) in reflection.texels().zip(&receivers) {
        let Some(receiver) = receiver else {
            assert_eq!(texel, [0.0; 4], "a highlight where nothing reflects");
            continue;
        };
        let found = f64::from(texel[0] / RADIANCE.x);
        // One share is multiplied by the radiance in all channels, and 16-bit floats round each product.
        assert!((texel[1] - RADIANCE.y * texel[0]).abs() < 2e-3 && (texel[2] - RADIANCE.z * texel[0]).abs() < 4e-3);
        let expected = share(&shape, receiver);
        if expected > 0.0 || found > 1e-3 {
            sum += (found - expected).powi(2);
            most = most.max((found - expected).abs());
            count += 1;
        }
    }
    assert!(count > 20, "{shape:?} is seen in {count} pixels only");
    ((sum / f64::from(count)).sqrt(), most)
}

/// Prints and bounds the errors of a shape. Each element of `bounds` is a roughness, the bound of the root mean square
/// error, and the bound of the greatest error.
fn check_errors(shape: AreaShape, bounds: [(f32, f64, f64); 4]) {
    for (roughness, rms_bound, most_bound) in bounds {
        let (rms, most) = errors(shape, roughness);
        println!("{shape:?}, roughness {roughness}: RMS {rms:.4}, greatest {most:.3}");
        assert!(rms < rms_bound && most < most_bound, "{shape:?}, {roughness}: {rms}, {most}");
    }
}

// The bounds lie somewhat above the measured errors (shaders-glsl/area_light/ERRATA.md), which the formula and the
// quadrature make together. The quadrature alone errs by about 0.01 where an edge of the light crosses the lobe.
// The capsule's greatest errors lie at its round ends.

/// The highlight of a sphere of 0.5 m above the floor equals the quadrature of the lobe within the bounds, at four
/// roughnesses. The formula approximates the lobe, and its error grows where the lobe is narrow.
#[test]
fn a_sphere_fills_its_share_of_the_lobe() {
    let shape = AreaShape::Sphere { centre: Vec3::new(0.4, 1.2, 5.0), radius: 0.5 };
    check_errors(shape, [(0.02, 0.05, 0.3), (0.1, 0.04, 0.08), (0.3, 0.04, 0.08), (0.8, 0.03, 0.08)]);
}

/// The highlight of a thin slanting capsule over the floor equals the quadrature within the bounds, at four
/// roughnesses. The formula is least exact at the capsule's round ends.
#[test]
fn a_capsule_fills_its_share_of_the_lobe() {
    let shape = AreaShape::Capsule { a: Vec3::new(-1.5, 0.8, 4.0), b: Vec3::new(1.0, 1.6, 6.0), radius: 0.15 };
    check_errors(shape, [(0.02, 0.03, 0.2), (0.1, 0.03, 0.2), (0.3, 0.03, 0.2), (0.8, 0.02, 0.1)]);
}

/// The highlight of a rectangle that faces the camera at an angle equals the quadrature within the bounds, at four
/// roughnesses.
#[test]
fn a_rectangle_fills_its_share_of_the_lobe() {
    let shape = AreaShape::Rectangle {
        centre: Vec3::new(0.2, 1.4, 6.0),
        half_u: Vec3::new(1.0, 0.0, 0.4),
        half_v: Vec3::new(0.0, -0.6, 0.0),
    };
    check_errors(shape, [(0.02, 0.05, 0.3), (0.1, 0.04, 0.1), (0.3, 0.04, 0.1), (0.8, 0.04, 0.1)]);
}

/// Two cylinders at four roughnesses each: their highlights equal the quadrature. The thick one has wider bounds, since
/// the formula takes its flat ends, of which one is seen, as ellipses.
#[test]
fn a_cylinder_fills_its_share_of_the_lobe() {
    let thin = AreaShape::Cylinder { a: Vec3::new(-1.5, 0.8, 4.0), b: Vec3::new(1.0, 1.6, 6.0), radius: 0.15 };
    check_errors(thin, [(0.02, 0.03, 0.2), (0.1, 0.03, 0.2), (0.3, 0.03, 0.2), (0.8, 0.02, 0.1)]);
    // A cylinder that is as wide as it is long, seen from one of its ends.
    let thick = AreaShape::Cylinder { a: Vec3::new(0.2, 1.2, 4.5), b: Vec3::new(0.6, 1.4, 5.5), radius: 0.5 };
    check_errors(thick, [(0.02, 0.15, 0.7), (0.1, 0.09, 0.4), (0.3, 0.06, 0.25), (0.8, 0.03, 0.15)]);
}

/// The highlight of a turned box over the floor equals the quadrature within the bounds, at four roughnesses. The
/// formula must join the faces that are seen.
#[test]
fn a_cuboid_fills_its_share_of_the_lobe() {
    let shape = AreaShape::Cuboid {
        centre: Vec3::new(0.3, 1.2, 5.0),
        half_u: Vec3::new(0.5, 0.0, 0.3),
        half_v: Vec3::new(0.0, 0.4, 0.0),
        half_w: 0.35,
    };
    check_errors(shape, [(0.02, 0.05, 0.3), (0.1, 0.05, 0.2), (0.3, 0.06, 0.25), (0.8, 0.04, 0.1)]);
}

/// A capsule and a cylinder behind the camera give no highlight. Each crosses the plane of a ray behind the ray's
/// start, where the formula's angles along the tube wrap around.
#[test]
fn a_tube_behind_the_viewer_is_not_seen() {
    let (a, b, radius) = (Vec3::new(-3.0, 1.0, -10.0), Vec3::new(3.0, 1.0, -10.0), 0.5);
    let gpu = gpu();
    for shape in [AreaShape::Capsule { a, b, radius }, AreaShape::Cylinder { a, b, radius }] {
        let scene = lit_by(shape);
        let mut stage = Stage::new(&gpu, &scene).unwrap();
        let camera = camera(Vec3::new(0.0, 1.5, 0.0), Vec3::new(0.0, 0.6, 4.0), EXTENT);
        let materials = scene.materials.iter().map(|m| Material { roughness: 0.3, ..m.clone() }).collect();
        let method = find("area-light").unwrap();
        let shot = Shot::new(&mut stage, method, &Setup::new(EXTENT), Wants::REFLECTION, camera, materials).unwrap();
        let reflection = render(&mut stage, &shot, false).unwrap().reflection;
        let brightest = reflection.values.iter().copied().fold(0.0, f32::max);
        assert!(brightest < 1e-3, "{shape:?}: {brightest}");
    }
}

/// A sphere beyond the end of the floor, whose lower half lies below the floor's plane, gives the light of its upper
/// half alone. Without the cut at the horizon its highlight would be twice as bright.
#[test]
fn a_light_half_below_the_horizon_gives_what_is_above_it() {
    let shape = AreaShape::Sphere { centre: Vec3::new(0.0, 0.3, 25.0), radius: 3.0 };
    check_errors(shape, [(0.02, 0.05, 0.3), (0.1, 0.06, 0.2), (0.3, 0.06, 0.2), (0.8, 0.06, 0.2)]);
}

/// On a floor of roughness 0, a pixel is bright exactly where its mirror ray meets the light, for each kind of shape.
/// The sixth shape is a rectangle that is turned away, and no pixel shows it.
#[test]
fn a_mirror_shows_the_light_itself_and_a_rectangle_is_dark_from_behind() {
    let shapes = [
        AreaShape::Sphere { centre: Vec3::new(0.4, 1.2, 5.0), radius: 0.5 },
        AreaShape::Capsule { a: Vec3::new(-1.5, 0.8, 4.0), b: Vec3::new(1.0, 1.6, 6.0), radius: 0.2 },
        AreaShape::Rectangle {
            centre: Vec3::new(0.2, 1.4, 6.0),
            half_u: Vec3::new(1.0, 0.0, 0.4),
            half_v: Vec3::new(0.0, -0.6, 0.0),
        },
        AreaShape::Cylinder { a: Vec3::new(-1.5, 0.8, 4.0), b: Vec3::new(1.0, 1.6, 6.0), radius: 0.2 },
        AreaShape::Cuboid {
            centre: Vec3::new(0.3, 1.2, 5.0),
            half_u: Vec3::new(0.5, 0.0, 0.3),
            half_v: Vec3::new(0.0, 0.4, 0.0),
            half_w: 0.35,
        },
        // A rectangle that shines away from the floor.
        AreaShape::Rectangle {
            centre: Vec3::new(0.2, 1.4, 6.0),
            half_u: Vec3::new(1.0, 0.0, 0.4),
            half_v: Vec3::new(0.0, 0.6, 0.0),
        },
    ];
    let gpu = gpu();
    for (index, shape) in shapes.into_iter().enumerate() {
        let scene = lit_by(shape);
        let camera = camera(Vec3::new(0.0, 1.5, 0.0), Vec3::new(0.0, 0.6, 4.0), EXTENT);
        let mut stage = Stage::new(&gpu, &scene).unwrap();
        let method = find("area-light").unwrap();
        let shot =
            Shot::new(&mut stage, method, &Setup::new(EXTENT), Wants::REFLECTION, camera, scene.materials.clone())
                .unwrap();
        let reflection = render(&mut stage, &shot, false).unwrap().reflection;
        let receivers = FirstHits::from_gbuffer(&gbuffer::read(&mut stage.context, &shot).unwrap()).receivers;
        let (mut lit_pixels, mut wrong) = (0, 0);
        for (texel, receiver) in reflection.texels().zip(&receivers) {
            let Some(receiver) = receiver else { continue };
            let expected = ray_meets_light(&shape, receiver.position, receiver.mirror());
            lit_pixels += u32::from(expected);
            wrong += u32::from((texel[0] > 0.5 * RADIANCE.x) != expected);
        }
        println!("{shape:?}: {lit_pixels} pixels, {wrong} wrong");
        assert!(if index < 5 { lit_pixels > 20 } else { lit_pixels == 0 }, "{shape:?}: {lit_pixels}");
        // The G-buffer's 16-bit normals move rays by up to a pixel at the edge of the light, hence 5 % of its pixels.
        assert!(f64::from(wrong) <= 0.05 * f64::from(lit_pixels), "{shape:?}: {wrong} of {lit_pixels}");
    }
}

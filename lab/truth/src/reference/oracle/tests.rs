//! Tests with rays that can be followed by hand. The lens is the default: 74° vertical, near 0.1 m, far 1000 m.

use super::*;
use crate::reference::ray::MissReason;
use crate::reference::testing::{depth_of, flat_wall, floor_and_wall, gbuffer_from};
use glam::Vec3;

/// Returns an image of a row of square pixels with the given view depths in metres (infinite for sky). All normals face
/// the camera.
fn row(depths_m: &[f64]) -> GBufferData {
    gbuffer_from(depths_m.len() as u32, 1, |x, _| depth_of(depths_m[x as usize]), |_, _| Vec3::NEG_Z)
}

/// Returns a miss; `behind` says whether the ray ends behind a block.
fn miss(reason: MissReason, behind: bool) -> Outcome {
    Outcome::Miss { reason, behind }
}

const SKY: f64 = f64::INFINITY;

#[test]
fn a_floor_mirrors_the_wall() {
    let gbuffer = floor_and_wall(160, 90);
    let oracle = Oracle::new(&gbuffer);
    let half_height = f64::from(gbuffer.camera.lens.fov_y_radians().unwrap() / 2.0).tan();
    for (x, y) in [(80, 65), (10, 62), (150, 70), (79, 75)] {
        let ndc = [2.0 * (f64::from(x) + 0.5) / 160.0 - 1.0, 1.0 - 2.0 * (f64::from(y) + 0.5) / 90.0];
        let (slope_x, slope_y) = (ndc[0] * half_height * 160.0 / 90.0, ndc[1] * half_height);
        // The camera ray (slope_x, slope_y, 1) hits the floor at z = −1 / slope_y. The mirrored ray rises, and meets
        // the wall at z = 5 at the height −2 − 5 slope_y and at x = 5 slope_x.
        let wall_place = [5.0 * slope_x, -2.0 - 5.0 * slope_y];
        let expected = [
            (0.5 + 0.5 * wall_place[0] / (5.0 * half_height * 160.0 / 90.0)) * 160.0,
            (0.5 - 0.5 * wall_place[1] / (5.0 * half_height)) * 90.0,
        ];
        let trace = oracle.trace(x, y);
        let Outcome::Hit { pixel, position } = trace.outcome else { panic!("({x}, {y}): {trace:?}") };
        assert_eq!(pixel, expected.map(|v| v as u32));
        assert!((position.x - expected[0]).abs() < 1e-4 && (position.y - expected[1]).abs() < 1e-4, "{position}");
        assert!((position.z - f64::from(depth_of(5.0))).abs() < 1e-12);
        assert_eq!(trace.steps, y - pixel[1], "it must go straight up, pixel by pixel");
    }
}

#[test]
fn rays_leave_the_screen() {
    // A ray straight up from the lowest row leaves by the upper side of the screen, and is in front of the wall all the
    // way.
    let gbuffer = floor_and_wall(160, 90);
    let lowest_slope = -(89.0 / 90.0) * f64::from(gbuffer.camera.lens.fov_y_radians().unwrap() / 2.0).tan();
    assert!(-2.0 - 5.0 * lowest_slope > 0.0 && 5.0 * lowest_slope.abs() < 5.0 * 0.7536);
    let oracle = Oracle::new(&gbuffer);
    let up = oracle.trace_direction(80, 89, DVec3::Y);
    assert_eq!((up.outcome, up.steps), (miss(MissReason::LeftScreen, false), 89));
    // A ray that runs along the wall, at the wall's depth, is inside the block of the next pixel.
    let along = oracle.trace_direction(80, 10, DVec3::X);
    assert!(matches!(along.outcome, Outcome::Hit { pixel: [81, 10], .. }) && along.steps == 1, "{along:?}");
}

#[test]
fn rays_towards_the_camera_end_at_the_near_plane() {
    // The middle pixel of a wall faces the camera, so that its ray never leaves the pixel.
    let gbuffer = flat_wall(9, 9, 5.0);
    let straight = Oracle::new(&gbuffer).trace(4, 4);
    assert_eq!((straight.outcome, straight.steps), (miss(MissReason::Near, false), 0));
    // A ray from the floor pixel below the middle towards a point 0.05 m beside the eye, nearer than the near plane.
    let gbuffer = floor_and_wall(90, 90);
    let oracle = Oracle::new(&gbuffer);
    let start = oracle.rays.position(45, 80).expect("floor");
    let near_eye = oracle.trace_direction(45, 80, DVec3::new(0.05, 0.0, 0.0) - start);
    assert_eq!(near_eye.outcome, miss(MissReason::Near, false));
    assert!(near_eye.steps > 10, "it must cross the screen first: {near_eye:?}");
}

#[test]
fn rays_away_from_the_camera_go_behind_things_and_end_far() {
    let gbuffer = flat_wall(9, 9, 5.0);
    let away = Oracle::new(&gbuffer).trace_direction(4, 4, DVec3::Z);
    assert_eq!((away.outcome, away.steps), (miss(MissReason::Far, true), 0), "it must end behind its own pixel");
}

#[test]
fn a_ray_passes_behind_a_thin_pole_and_meets_a_thick_one() {
    // The ray runs along +x from column 0, 4 m away. The pole is 3 m away. Alone in front of the sky it is T = 0.004 ·
    // 3 = 0.012 m thick. Column 8 is 3.99 m away with T = 0.01596 m, so that 4 m is inside its block.
    let thin = row(&[4.0, SKY, SKY, SKY, 3.0, SKY, SKY, SKY, 3.99]);
    let trace = Oracle::new(&thin).trace_direction(0, 0, DVec3::X);
    let Outcome::Hit { pixel: [8, 0], position } = trace.outcome else { panic!("{trace:?}") };
    assert_eq!(trace.steps, 8);
    assert!((position - DVec3::new(8.0, 0.5, f64::from(depth_of(4.0)))).length() < 1e-9, "the entry: {position}");
    // With a neighbour at 4.2 m and nothing on the other side, the pole is 1.2 + 0.012 m thick and extends to 4.212 m.
    let thick = row(&[4.0, SKY, SKY, SKY, 3.0, 4.2, SKY, SKY, 3.99]);
    let trace = Oracle::new(&thick).trace_direction(0, 0, DVec3::X);
    assert!(matches!(trace.outcome, Outcome::Hit { pixel: [4, 0], .. }), "{trace:?}");
    // With neighbours at 4.2 m and 5 m the pole stands far before both, and is as thin as without neighbours.
    let between = row(&[4.0, SKY, SKY, 4.2, 3.0, 5.0, SKY, SKY, 3.99]);
    let trace = Oracle::new(&between).trace_direction(0, 0, DVec3::X);
    assert!(matches!(trace.outcome, Outcome::Hit { pixel: [8, 0], .. }), "{trace:?}");
    // With a neighbour at 3.9 m, the pole extends only to 3.912 m. The neighbour, whose own only neighbour is the pole,
    // is 0.9 + 0.0156 m thick.
    let thinner = row(&[4.0, SKY, SKY, SKY, 3.0, 3.9, SKY, SKY, SKY]);
    let trace = Oracle::new(&thinner).trace_direction(0, 0, DVec3::X);
    assert!(matches!(trace.outcome, Outcome::Hit { pixel: [5, 0], .. }), "{trace:?}");
}

#[test]
fn the_flag_says_whether_a_ray_ended_behind_something() {
    let gbuffer = row(&[4.0, SKY, SKY, 1.0]);
    assert_eq!(Oracle::new(&gbuffer).trace_direction(0, 0, DVec3::X).outcome, miss(MissReason::LeftScreen, true));
    let gbuffer = row(&[4.0, SKY, 1.0, SKY]);
    assert_eq!(Oracle::new(&gbuffer).trace_direction(0, 0, DVec3::X).outcome, miss(MissReason::LeftScreen, false));
}

#[test]
fn a_ray_that_comes_out_of_a_block_hits_its_front_from_inside() {
    // Column 1 is 3 m away and 1.012 m thick, because its only neighbour is at 4 m. A ray from column 0 that is 3.2 m
    // away where it enters column 1, and 2.9 m away where it leaves it, crosses the front in that column.
    let gbuffer = row(&[4.0, 3.0, SKY, SKY]);
    let oracle = Oracle::new(&gbuffer);
    let depth_at = |view_z_m| f64::from(depth_of(view_z_m));
    let slope = depth_at(2.9) - depth_at(3.2);
    let segment = Segment {
        start: DVec3::new(0.5, 0.5, depth_at(3.2) - 0.5 * slope),
        delta: DVec3::new(3.5, 0.0, 3.5 * slope),
        direction: DVec3::X,
        end: MissReason::LeftScreen,
    };
    let Outcome::Hit { pixel: [1, 0], position } = oracle.trace_segment(&segment).outcome else { panic!() };
    let column_share = (depth_at(3.0) - depth_at(3.2)) / slope;
    assert!((position - DVec3::new(1.0 + column_share, 0.5, depth_at(3.0))).length() < 1e-9, "{position}");
}

#[test]
fn a_ray_through_a_corner_goes_across_it() {
    // The ray runs along the diagonal. At its own depth it does not meet blocks in the pixels beside the diagonal, but
    // meets one on the diagonal.
    let depth = depth_of(2.0);
    // An image of sky, except for the listed pixels, which have the ray's depth.
    let image_showing = |pixels: &'static [(u32, u32)]| {
        gbuffer_from(3, 3, move |x, y| if pixels.contains(&(x, y)) { depth } else { 0.0 }, |_, _| Vec3::NEG_Z)
    };
    let start = DVec3::new(0.5, 0.5, f64::from(depth));
    let (delta, direction) = (DVec3::new(2.5, 2.5, 0.0), DVec3::new(1.0, -1.0, 0.0).normalize());
    let diagonal = Segment { start, delta, direction, end: MissReason::LeftScreen };
    let beside = image_showing(&[(0, 0), (1, 0), (0, 1), (2, 1), (1, 2)]);
    let trace = Oracle::new(&beside).trace_segment(&diagonal);
    assert_eq!((trace.outcome, trace.steps), (miss(MissReason::LeftScreen, false), 2));
    let ahead = image_showing(&[(0, 0), (2, 2)]);
    let trace = Oracle::new(&ahead).trace_segment(&diagonal);
    assert_eq!(trace.outcome, Outcome::Hit { pixel: [2, 2], position: DVec3::new(2.0, 2.0, start.z) });
}

#[test]
fn sky_neither_sends_rays_nor_stops_them() {
    let gbuffer = row(&[4.0, SKY, SKY, SKY]);
    let oracle = Oracle::new(&gbuffer);
    assert_eq!(oracle.trace(2, 0), Trace::NO_RAY);
    let across = oracle.trace_direction(0, 0, DVec3::new(1.0, 0.0, 0.2));
    assert_eq!((across.outcome, across.steps), (miss(MissReason::LeftScreen, false), 3));
}

#[test]
fn one_pixel_hits_nothing() {
    let gbuffer = flat_wall(1, 1, 3.0);
    let oracle = Oracle::new(&gbuffer);
    for (direction, reason, behind) in [
        (DVec3::X, MissReason::LeftScreen, false),
        (DVec3::NEG_Y, MissReason::LeftScreen, false),
        (DVec3::NEG_Z, MissReason::Near, false),
        (DVec3::Z, MissReason::Far, true),
    ] {
        let trace = oracle.trace_direction(0, 0, direction);
        assert_eq!((trace.outcome, trace.steps), (miss(reason, behind), 0), "{direction}");
    }
}

/// Returns how a ray along a row of pixels ends by version 1 and by version 2. The row has the given view depths, and
/// the ray runs from the depth `start_m` to `end_m`. `direction` is the direction that is compared with normals.
fn ends_of(depths_m: &[f64], [start_m, end_m]: [f64; 2], direction: DVec3) -> [Outcome; 2] {
    let gbuffer = row(depths_m);
    let length_px = depths_m.len() as f64 - 0.5;
    let depth_at = |m: f64| f64::from(depth_of(m));
    let segment = Segment {
        start: DVec3::new(0.5, 0.5, depth_at(start_m)),
        delta: DVec3::new(length_px, 0.0, depth_at(end_m) - depth_at(start_m)),
        direction,
        end: MissReason::LeftScreen,
    };
    [OracleVersion::V1, OracleVersion::V2]
        .map(|version| Oracle::new(&gbuffer).of_version(version).trace_segment(&segment).outcome)
}

/// Returns whether a ray hits the pixel in this column of a row.
fn hits(outcome: Outcome, pixel: u32) -> bool {
    matches!(outcome, Outcome::Hit { pixel: hit_pixel, .. } if hit_pixel == [pixel, 0])
}

#[test]
fn the_second_version_hits_only_from_in_front() {
    let behind = miss(MissReason::LeftScreen, true);
    let ends_at = |depths_m: &[f64], ray_m: f64| ends_of(depths_m, [ray_m, ray_m], DVec3::X);
    // Columns 2 and 3 show a surface at 2 m, with T = 0.008 m. After a nearer surface, a ray at 2.004 m comes from
    // behind.
    let [first_version, second_version] = ends_at(&[1.0, 1.0, 2.0, 2.0], 2.004);
    assert!(hits(first_version, 2), "{first_version:?}");
    assert_eq!(second_version, behind);
    // After a farther surface or sky, the ray is at the edge of the surface and also passes. It hits if it runs against
    // the normal (0, 0, −1) and is not too deep in the block. The limit is the thickness times the cosine between ray
    // and reversed normal, here 0.4.
    let ends_against_normal =
        |depths_m: &[f64], ray_m: f64| ends_of(depths_m, [ray_m, ray_m], DVec3::new(0.84_f64.sqrt(), 0.0, 0.4));
    for previous_m in [9.0, SKY] {
        let [first_version, second_version] = ends_at(&[SKY, previous_m, 2.0, 2.0], 2.004);
        assert!(hits(first_version, 2), "{previous_m} {first_version:?}");
        assert_eq!(second_version, behind, "{previous_m}");
        for (ray_m, is_hit) in [(2.003, true), (2.0035, false)] {
            let [first_version, second_version] = ends_against_normal(&[SKY, previous_m, 2.0, 2.0], ray_m);
            assert!(
                hits(first_version, 2) && hits(second_version, 2) == is_hit,
                "{previous_m} {ray_m} {first_version:?} {second_version:?}"
            );
        }
    }
    // On a slope of 0.5 m per pixel, T is the slope plus 0.4 % of the depth; the side is joined to the previous pixel.
    let [first_version, second_version] = ends_at(&[SKY, 3.0, 2.5, 2.0, 1.5], 2.85);
    assert!(hits(first_version, 2) && hits(second_version, 2), "{first_version:?} {second_version:?}");
    // A ray hits a front that it crosses, whatever it passed before.
    let [first_version, second_version] = ends_of(&[1.0, 1.0, 2.0, 2.0], [1.5, 2.4], DVec3::X);
    assert!(hits(first_version, 2) && hits(second_version, 2), "{first_version:?} {second_version:?}");
}

#[test]
fn the_second_version_leaves_the_surface_that_a_ray_begins_on() {
    // All normals are (0, 0, −1). The ray sinks into the block beside the start and crosses the front of column 3.
    let ends_along = |direction| ends_of(&[2.0, 2.0, SKY, 2.025, 2.025], [2.0, 2.04], direction);
    let [first_version, second_version] = ends_along(DVec3::new(0.9, 0.0, -0.1));
    assert!(hits(first_version, 1) && hits(second_version, 3), "{first_version:?} {second_version:?}");
    // On the same segment, a ray whose direction enters the surface hits the first block in the second version, too.
    let [first_version, second_version] = ends_along(DVec3::new(0.9, 0.0, 0.1));
    assert!(hits(first_version, 1) && hits(second_version, 1), "{first_version:?} {second_version:?}");
}

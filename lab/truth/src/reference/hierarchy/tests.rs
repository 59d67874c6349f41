//! The hierarchy and the oracle must agree on the hit pixel, the hit position and the reason of a miss for
//! every ray in many G-buffers that are chosen to be difficult.

use super::*;
use crate::reference::Oracle;
use crate::reference::ray::MissReason;
use crate::reference::testing::{
    DEPTH_KINDS, DIRECTION_KINDS, Random, SIZES, direction_of_kind, floor_and_wall, gbuffer_from, random_depths,
    random_gbuffer,
};
use glam::Vec3;
use rayon::prelude::*;

/// Returns a random segment with exact coordinates: it may run along pixel edges, through corners and at the depths of
/// pixels.
fn exact_segment(random: &Random, gbuffer: &GBufferData) -> Segment {
    let start = [gbuffer.width, gbuffer.height].map(|side| f64::from(random.below(2 * side)) / 2.0);
    let end = [gbuffer.width, gbuffer.height].map(|side| f64::from(random.below(2 * side + 1)) / 2.0);
    let diagonal = (end[0] - start[0]).abs().min((end[1] - start[1]).abs());
    // A third of the segments run diagonally through corners, and a third run straight up or down.
    let end = match random.below(3) {
        0 => [0, 1].map(|i| start[i] + diagonal * (end[i] - start[i]).signum()),
        1 => [start[0], end[1]],
        _ => end,
    };
    let depth = || f64::from(gbuffer.depth[random.below(gbuffer.depth.len() as u32) as usize]);
    // Some segments keep one depth from start to end.
    let (start_depth, end_depth) = (depth(), if random.unit() < 0.3 { None } else { Some(depth()) });
    let start = DVec3::new(start[0], start[1], start_depth);
    let delta = DVec3::new(end[0], end[1], end_depth.unwrap_or(start_depth)) - start;
    Segment { start, delta, direction: random.direction(), end: MissReason::LeftScreen }
}

/// Asserts that two traces end alike: in the same pixel at the same place, except for rounding, or by the same miss.
/// `describe_ray` describes the ray in the message of a failure.
fn assert_agree(found: Trace, truth: Trace, describe_ray: impl Fn() -> String) {
    match (found.outcome, truth.outcome) {
        (
            Outcome::Hit { pixel: found_pixel, position: found_place },
            Outcome::Hit { pixel: true_pixel, position: true_place },
        ) => {
            assert_eq!(found_pixel, true_pixel, "{}", describe_ray());
            assert!(
                (found_place - true_place).abs().cmple(1e-9 * true_place.abs()).all(),
                "{found_place} {true_place} {}",
                describe_ray()
            );
        }
        (found_miss, true_miss) => assert_eq!(found_miss, true_miss, "{}", describe_ray()),
    }
}

/// Traces `rays` rays of the random G-buffer number `case` with both traversals and compares their ends. Even cases use
/// version 1 of the oracle and odd cases version 2. Returns the number of rays and the number of hits.
fn compare(case: u64, rays: u64) -> [u64; 2] {
    let random = Random::new(7, case);
    let (depths_kind, gbuffer) = random_gbuffer(case, &random);
    let size = [gbuffer.width, gbuffer.height];
    let version = if case.is_multiple_of(2) { OracleVersion::V1 } else { OracleVersion::V2 };
    let (oracle, hierarchy) = (Oracle::new(&gbuffer).of_version(version), Hierarchy::new(&gbuffer).of_version(version));
    let mut hits = 0;
    for ray in 0..rays {
        let (x, y) = (random.below(size[0]), random.below(size[1]));
        // A kind of direction, or `DIRECTION_KINDS` for the mirror ray, or one more for an exact segment.
        let ray_kind = random.below(DIRECTION_KINDS + 2);
        let [found, truth] = if ray_kind == DIRECTION_KINDS {
            [hierarchy.trace(x, y), oracle.trace(x, y)]
        } else if ray_kind > DIRECTION_KINDS {
            let segment = exact_segment(&random, &gbuffer);
            [hierarchy.trace_segment(&segment), oracle.trace_segment(&segment)]
        } else {
            let direction = hierarchy
                .rays()
                .position(x, y)
                .map_or(DVec3::ZERO, |start| direction_of_kind(ray_kind, &random, hierarchy.rays(), start));
            [hierarchy.trace_direction(x, y, direction), oracle.trace_direction(x, y, direction)]
        };
        assert_agree(found, truth, || {
            format!("case {case}, {size:?}, depths {depths_kind}, ray {ray} of kind {ray_kind}, ({x}, {y})")
        });
        hits += u64::from(truth.position().is_some());
    }
    [rays, hits]
}

/// Compares `rays` rays in each of `case_count` random G-buffers, and asserts that enough rays hit and enough miss.
fn agree(case_count: u64, rays: u64) {
    let counts: Vec<_> = (0..case_count).into_par_iter().map(|case| compare(case, rays)).collect();
    let [rays, hits] = [0, 1].map(|i| counts.iter().map(|count| count[i]).sum::<u64>());
    println!("{rays} rays agree, {hits} of them hits");
    assert!(hits > rays / 10 && hits < rays * 9 / 10, "{hits} of {rays} hit: too few of one kind to prove much");
}

/// Compares 2.16 million rays over 1080 G-buffers: each image size with each kind of depths, six times.
#[test]
fn two_million_rays_agree_with_the_oracle() {
    agree(6 * SIZES.len() as u64 * u64::from(DEPTH_KINDS), 2000);
}

#[test]
#[ignore = "36 million rays: run it after a change of either traversal"]
fn thirty_million_rays_agree_with_the_oracle() {
    agree(20 * SIZES.len() as u64 * u64::from(DEPTH_KINDS), 10_000);
}

#[test]
fn cells_cover_the_pixels_that_shift_to_them() {
    let random = Random::new(3, 0);
    for size in SIZES {
        let depth = random_depths(6, &random, size);
        let gbuffer = gbuffer_from(size[0], size[1], |x, y| depth[(y * size[0] + x) as usize], |_, _| Vec3::Z);
        let levels = Hierarchy::new(&gbuffer).levels;
        let top = levels.last().map(|level| [level.width, level.height]);
        assert_eq!(top, Some([1, 1]));
        for (level, cells) in levels.iter().enumerate() {
            let mut expected = vec![DepthBlock::EMPTY; cells.texels.len()];
            for y in 0..size[1] {
                for x in 0..size[0] {
                    let cell = &mut expected[((y >> level) * cells.width + (x >> level)) as usize];
                    *cell = cell.union(levels[0].texels[gbuffer.index(x, y)]);
                }
            }
            assert_eq!(cells.texels, expected, "{size:?} level {level}");
        }
    }
}

#[test]
fn it_takes_a_fraction_of_the_oracles_steps() {
    let gbuffer = floor_and_wall(641, 479);
    let (oracle, hierarchy) = (Oracle::new(&gbuffer), Hierarchy::new(&gbuffer));
    let [mut hierarchy_steps, mut oracle_steps] = [0, 0];
    for y in (300..479).step_by(7) {
        let (found, truth) = (hierarchy.trace(400, y), oracle.trace(400, y));
        assert_agree(found, truth, || format!("row {y}"));
        hierarchy_steps += found.steps;
        oracle_steps += truth.steps;
    }
    assert!(hierarchy_steps * 5 < oracle_steps, "{hierarchy_steps} steps, the oracle {oracle_steps}");
}

/// Tests that `possible_ends` without any rounding has the oracle's end as its last end.
#[test]
fn an_exact_ray_has_only_the_oracles_end() {
    let mut hits = 0;
    for case in 0..120 {
        let random = Random::new(9, case);
        let (_, gbuffer) = random_gbuffer(case, &random);
        let (oracle, hierarchy) = (Oracle::new(&gbuffer), Hierarchy::new(&gbuffer));
        for _ in 0..100 {
            let (x, y, direction_kind) =
                (random.below(gbuffer.width), random.below(gbuffer.height), random.below(DIRECTION_KINDS));
            let rays = hierarchy.rays();
            let direction = rays
                .position(x, y)
                .map_or(DVec3::ZERO, |start| direction_of_kind(direction_kind, &random, rays, start));
            let Some(segment) = rays.segment(x, y, direction) else { continue };
            let truth = oracle.trace_segment(&segment).position_px();
            let ends = hierarchy.possible_ends(&segment, 0.0);
            match (truth, ends.last().expect("an end")) {
                (Some(true_place), Some(found_place)) => assert!(
                    (0..2).all(|i| (true_place[i] - found_place[i]).abs() < 1e-9),
                    "case {case}, {true_place:?}, {found_place:?}"
                ),
                (true_place, found_place) => assert!(
                    true_place.is_none() && found_place.is_none(),
                    "case {case}, {true_place:?}, {found_place:?}"
                ),
            }
            hits += u32::from(truth.is_some());
        }
    }
    assert!(hits > 1000, "{hits}");
}

#[test]
fn a_ray_through_a_corner_may_touch_either_pixel_beside_it() {
    let gbuffer = gbuffer_from(3, 3, |x, y| if (x, y) == (1, 0) { 0.5 } else { 0.0 }, |_, _| Vec3::NEG_Z);
    let hierarchy = Hierarchy::new(&gbuffer);
    let ends_towards = |delta_x: f64, delta_y: f64| {
        let segment = Segment {
            start: DVec3::new(0.5, 0.5, 0.5),
            delta: DVec3::new(delta_x, delta_y, 0.0),
            direction: DVec3::X,
            end: MissReason::LeftScreen,
        };
        hierarchy.possible_ends(&segment, 1e-6)
    };
    // The first two rays pass through the corner or within rounding of it, and the last two clearly to either side of
    // it.
    for delta_x in [2.5, 2.5 - 1e-6] {
        let ends = ends_towards(delta_x, 2.5);
        let hits: Vec<_> = ends.iter().flatten().collect();
        assert!(matches!(hits[..], [[x, y]] if (x - 1.0).abs() + (y - 1.0).abs() < 1e-5), "{ends:?}");
        assert!(ends.contains(&None));
    }
    assert!(matches!(ends_towards(2.5, 2.4)[..], [Some(_)]));
    assert_eq!(ends_towards(2.4, 2.5), [None]);
}

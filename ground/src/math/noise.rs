//! Lattice noise and cells that repeat, from an integer hash, so that the bits are the same on every machine.
//!
//! Coordinates are in lattice units. Every function repeats after a whole number of lattice units, so that the patterns tile.

use glam::{IVec2, Vec2};

/// A hash of a lattice point: three odd multipliers, followed by MurmurHash3's 32-bit finaliser.
fn hash(point: IVec2, seed: u32) -> u32 {
    finish(column(point.x) ^ row(point.y, seed))
}

/// The part of a hash that all points of a column share.
fn column(x: i32) -> u32 {
    (x as u32).wrapping_mul(0x9E37_79B1)
}

/// The part of a hash that all points of a row share.
fn row(y: i32, seed: u32) -> u32 {
    (y as u32).wrapping_mul(0x85EB_CA77) ^ seed.wrapping_mul(0xC2B2_AE3D)
}

fn finish(mut h: u32) -> u32 {
    h ^= h >> 16;
    h = h.wrapping_mul(0x85EB_CA6B);
    h ^= h >> 13;
    h = h.wrapping_mul(0xC2B2_AE35);
    h ^ (h >> 16)
}

/// A pseudo-random number, 0 ≤ u < 1, for a lattice point.
pub fn unit(point: IVec2, seed: u32) -> f32 {
    unit_of(hash(point, seed))
}

fn unit_of(hash: u32) -> f32 {
    // The upper 24 bits fit a signed integer, which processors convert in fewer steps than an unsigned one.
    (hash >> 8) as i32 as f32 / 16_777_216.0
}

/// 0 below `low`, 1 above `high`, smooth between.
pub fn smoothstep(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Value noise in 0…1 with a continuous slope, repeating after `period` lattice units.
pub fn value(point: Vec2, period: IVec2, seed: u32) -> f32 {
    let [(x, fx), (y, fy)] = [split(point.x), split(point.y)];
    let [(left, right), (lower, upper)] = [neighbours(x, period.x), neighbours(y, period.y)];
    let columns = [column(left), column(right)];
    let along = |y: i32| {
        let row = row(y, seed);
        let [left, right] = columns.map(|column| unit_of(finish(column ^ row)));
        left + (right - left) * fx
    };
    let [lower, upper] = [along(lower), along(upper)];
    lower + (upper - lower) * fy
}

/// The lattice point below a coordinate, and the weight of the next point. The code avoids `f32::floor`, since that is a call on
/// processors that may lack SSE 4.1, and a pattern needs millions of these numbers.
fn split(x: f32) -> (i32, f32) {
    let towards_zero = x as i32;
    let cell = towards_zero - i32::from(towards_zero as f32 > x);
    let f = x - cell as f32;
    (cell, f * f * f * (f * (f * 6.0 - 15.0) + 10.0))
}

/// A lattice coordinate within the period. Most coordinates lie there already, and are not divided, since a division takes longer
/// than all else here.
fn wrapped(cell: i32, period: i32) -> i32 {
    if (0..period).contains(&cell) { cell } else { cell.rem_euclid(period) }
}

/// A lattice coordinate within the period, and the next one. The first coordinate follows the last.
fn neighbours(cell: i32, period: i32) -> (i32, i32) {
    let near = wrapped(cell, period);
    (near, if near + 1 == period { 0 } else { near + 1 })
}

/// Sum of octaves of [`value`], each with twice the frequency and half the weight of the previous; 0…1.
pub fn fractal(point: Vec2, period: IVec2, octaves: u32, seed: u32) -> f32 {
    let (mut sum, mut weights) = (0.0, 0.0);
    for octave in 0..octaves {
        let scale = 1 << octave;
        let weight = 1.0 / scale as f32;
        sum += weight * value(point * scale as f32, period * scale, seed.wrapping_add(octave));
        weights += weight;
    }
    sum / weights
}

/// The Voronoi cell that contains a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VoronoiCell {
    /// The lattice point of the cell within the period; hash it for properties of the cell, such as its tone.
    pub id: IVec2,
    /// Distance to the nearest border with another cell, in the unit of `cell_size`.
    pub border: f32,
}

/// Finds the Voronoi cell of a point, with one jittered site per lattice cell. Odd rows are shifted by half a
/// cell, as in masonry. `jitter` is 0…1; `period.y` must be even.
pub fn cells(position: Vec2, cell_size: Vec2, period: IVec2, jitter: f32, seed: u32) -> VoronoiCell {
    let row = (position.y / cell_size.y).floor() as i32;
    let column = (position.x / cell_size.x).floor() as i32;
    // The sites around the point: two rows above and below, and three columns to the left but two to the right, since odd rows are
    // shifted to the right.
    let mut around = [[(IVec2::ZERO, Vec2::ZERO); 6]; 5];
    for (iy, sites) in (row - 2..).zip(&mut around) {
        let shift = if iy & 1 == 1 { 0.5 } else { 0.0 };
        let y = wrapped(iy, period.y);
        for (ix, site) in (column - 3..).zip(sites) {
            let id = IVec2::new(wrapped(ix, period.x), y);
            let random = Vec2::new(unit(id, seed), unit(id, seed ^ 0x55)) - 0.5;
            let middle = Vec2::new(ix as f32 + 0.5 + shift, iy as f32 + 0.5);
            *site = (id, (middle + random * jitter) * cell_size);
        }
    }
    let mut nearest = (IVec2::ZERO, Vec2::ZERO, f32::INFINITY);
    for (id, point) in around[1..4].iter().flat_map(|row| &row[1..5]) {
        let distance = point.distance_squared(position);
        if distance < nearest.2 {
            nearest = (*id, *point, distance);
        }
    }
    let mut border = f32::INFINITY;
    for (_, point) in around.as_flattened() {
        let apart = *point - nearest.1;
        if apart.length_squared() > 1e-8 {
            let middle = 0.5 * (*point + nearest.1);
            border = border.min((middle - position).dot(apart.normalize()));
        }
    }
    VoronoiCell { id: nearest.0, border: border.max(0.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_repeats_after_its_period_and_stays_in_range() {
        for k in 0..500_u32 {
            let position = Vec2::new(unit(IVec2::new(k as i32, 0), 1), unit(IVec2::new(k as i32, 1), 1));
            let position = position * Vec2::new(4.0, 6.0);
            let period = IVec2::new(4, 6);
            let here = fractal(position, period, 4, 7);
            assert!((0.0..=1.0).contains(&here));
            let there = fractal(position + period.as_vec2(), period, 4, 7);
            assert!((here - there).abs() < 1e-4, "{position}: {here} and {there}");
        }
    }

    #[test]
    fn noise_varies() {
        let row: Vec<f32> = (0..256).map(|k| unit(IVec2::new(k, 3), 5)).collect();
        let mean = row.iter().sum::<f32>() / 256.0;
        let variance = row.iter().map(|x| (x - mean).powi(2)).sum::<f32>() / 256.0;
        assert!((mean - 0.5).abs() < 0.08, "mean {mean}");
        assert!((variance - 1.0 / 12.0).abs() < 0.02, "variance {variance}");
    }

    #[test]
    fn cells_without_jitter_have_known_borders() {
        // Square unit cells with odd rows shifted by half a cell: from the middle of a cell in row 0, the
        // nearest neighbours are left and right, and their borders are half a cell away.
        let cell = cells(Vec2::new(2.5, 0.5), Vec2::ONE, IVec2::new(8, 8), 0.0, 3);
        assert_eq!(cell.id, IVec2::new(2, 0));
        assert!((cell.border - 0.5).abs() < 1e-5, "{}", cell.border);
        let cell = cells(Vec2::new(2.9, 0.5), Vec2::ONE, IVec2::new(8, 8), 0.0, 3);
        assert!((cell.border - 0.1).abs() < 1e-5, "{}", cell.border);
    }
}

//! Lattice noise and cells that repeat, from an integer hash, so that the bits are the same on every machine.
//!
//! Coordinates are in lattice units. Every function repeats after a whole number of lattice units, so that the patterns tile.

use glam::{IVec2, Vec2};
use std::ops::Range;

/// A hash of a lattice point: three odd multipliers, followed by MurmurHash3's 32-bit finaliser.
fn hash(point: IVec2, seed: u32) -> u32 {
    let column = (point.x as u32).wrapping_mul(0x9E37_79B1);
    let row = (point.y as u32).wrapping_mul(0x85EB_CA77) ^ seed.wrapping_mul(0xC2B2_AE3D);
    let mut h = column ^ row;
    h ^= h >> 16;
    h = h.wrapping_mul(0x85EB_CA6B);
    h ^= h >> 13;
    h = h.wrapping_mul(0xC2B2_AE35);
    h ^ (h >> 16)
}

/// A pseudo-random number, 0 ≤ u < 1, for a lattice point.
pub fn unit(point: IVec2, seed: u32) -> f32 {
    // The upper 24 bits fit a signed integer, which processors convert in fewer steps than an unsigned one.
    (hash(point, seed) >> 8) as i32 as f32 / 16_777_216.0
}

/// Returns 0 at `low` and before it, 1 at `high` and beyond it, and a smooth cubic between.
pub fn smoothstep(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Value noise in 0…1 with a continuous slope, which repeats after `period` lattice units.
pub fn value(point: Vec2, period: IVec2, seed: u32) -> f32 {
    let ((x, right_weight), (y, upper_weight)) = (split(point.x), split(point.y));
    let ((left, right), (lower, upper)) = (neighbours(x, period.x), neighbours(y, period.y));
    let on_row = |y: i32| {
        let (left, right) = (unit(IVec2::new(left, y), seed), unit(IVec2::new(right, y), seed));
        left + (right - left) * right_weight
    };
    let (lower, upper) = (on_row(lower), on_row(upper));
    lower + (upper - lower) * upper_weight
}

/// Returns the lattice point below a coordinate, and the weight of the next point (Perlin 2002). The code avoids
/// `f32::floor`, which is a slow call if it is compiled for processors without SSE 4.1.
fn split(x: f32) -> (i32, f32) {
    let towards_zero = x as i32;
    let cell = towards_zero - i32::from(towards_zero as f32 > x);
    let f = x - cell as f32;
    (cell, f * f * f * (f * (f * 6.0 - 15.0) + 10.0))
}

/// Moves a lattice coordinate by whole periods to 0…`period` − 1. Most coordinates lie there already and are not
/// divided, since a division takes longer than the comparison.
fn wrapped(cell: i32, period: i32) -> i32 {
    if (0..period).contains(&cell) { cell } else { cell.rem_euclid(period) }
}

/// Returns a lattice coordinate within the period, and the one after it; after the last comes the first.
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

/// The noise of [`fractal`], to the bit, at the middles of the texels in `rows` and `columns` of an image that shows
/// one period with `side` × `side` texels; row by row. Many rows of texels lie between the same two rows of lattice
/// points, along which the noise is computed once.
pub fn fractal_image(
    (period, octaves, seed): (IVec2, u32, u32),
    side: usize,
    rows: Range<usize>,
    columns: Range<usize>,
) -> Vec<f32> {
    let mut sums = vec![0.0; rows.len() * columns.len()];
    let mut weights = 0.0;
    for octave in 0..octaves {
        let (scale, seed) = (1 << octave, seed.wrapping_add(octave));
        let weight = 1.0 / scale as f32;
        // Returns the lattice coordinates below and above a texel's middle, and the weight of the upper one.
        let place = |texel: usize, period: i32| {
            let uv = (texel as f32 + 0.5) / side as f32;
            let (cell, weight) = split(uv * period as f32 * scale as f32);
            (neighbours(cell, period * scale), weight)
        };
        let column_places: Vec<_> = columns.clone().map(|column| place(column, period.x)).collect();
        let noise_on_row = |y: i32| -> Vec<f32> {
            let lattice: Vec<f32> = (0..period.x * scale).map(|x| unit(IVec2::new(x, y), seed)).collect();
            let between = |&((left, right), weight): &((i32, i32), f32)| {
                let (left, right) = (lattice[left as usize], lattice[right as usize]);
                left + (right - left) * weight
            };
            column_places.iter().map(between).collect()
        };
        // The lattice row whose noise is known, with the noise on it and on the next row.
        let (mut known_row, mut lower_noise, mut upper_noise) = (-1, Vec::new(), Vec::new());
        for (row_sums, row) in sums.chunks_exact_mut(columns.len()).zip(rows.clone()) {
            let ((lower, upper), share) = place(row, period.y);
            if known_row != lower {
                (known_row, lower_noise, upper_noise) = (lower, noise_on_row(lower), noise_on_row(upper));
            }
            for ((sum, lower), upper) in row_sums.iter_mut().zip(&lower_noise).zip(&upper_noise) {
                *sum += weight * (lower + (upper - lower) * share);
            }
        }
        weights += weight;
    }
    sums.iter_mut().for_each(|sum| *sum /= weights);
    sums
}

/// The Voronoi cell that contains a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VoronoiCell {
    /// The lattice point of the cell within the period; hash it for properties of the cell, such as its tone.
    pub id: IVec2,
    /// Distance to the nearest border with another cell, in the unit of `size`.
    pub border: f32,
}

/// Finds the Voronoi cell of a point, with one jittered site per lattice cell. Odd rows are shifted by half a cell, as in masonry.
/// `size` is the width and height of a lattice cell, `jitter` is 0…1, and `period.y` must be even.
pub fn cell(position: Vec2, size: Vec2, period: IVec2, jitter: f32, seed: u32) -> VoronoiCell {
    cell_among(position, size, period, |id| offset(id, jitter, seed))
}

/// Returns how far the site of a lattice cell lies from its middle: at most `jitter` / 2 lattice units along each axis.
fn offset(id: IVec2, jitter: f32, seed: u32) -> Vec2 {
    (Vec2::new(unit(id, seed), unit(id, seed ^ 0x55)) - 0.5) * jitter
}

/// Voronoi cells as [`cell`] finds them, with sites that are computed once and not at every texel of an image.
#[derive(Debug, Clone)]
pub struct VoronoiCells {
    size: Vec2,
    period: IVec2,
    /// The offsets of the sites within the period, row by row.
    offsets: Vec<Vec2>,
}

impl VoronoiCells {
    /// Computes the sites of all lattice cells; the parameters are those of [`cell`].
    pub fn new(size: Vec2, period: IVec2, jitter: f32, seed: u32) -> Self {
        let ids = (0..period.y).flat_map(|y| (0..period.x).map(move |x| IVec2::new(x, y)));
        Self { size, period, offsets: ids.map(|id| offset(id, jitter, seed)).collect() }
    }

    /// Finds the Voronoi cell of a point, with the same bits as the function [`cell`].
    pub fn cell(&self, position: Vec2) -> VoronoiCell {
        cell_among(position, self.size, self.period, |id| self.offsets[(id.y * self.period.x + id.x) as usize])
    }
}

/// Finds the Voronoi cell of a point. `offset` gives how far a site lies from the middle of its lattice cell.
fn cell_among(position: Vec2, size: Vec2, period: IVec2, offset: impl Fn(IVec2) -> Vec2) -> VoronoiCell {
    let row = (position.y / size.y).floor() as i32;
    let column = (position.x / size.x).floor() as i32;
    // The sites around the point: two rows above and below, and three columns to the left but two to the right, since
    // odd rows are shifted to the right. Coordinates stand in arrays of their own, so several are computed at once.
    let mut ids = [[IVec2::ZERO; 6]; 5];
    let (mut xs, mut ys) = ([[0.0; 6]; 5], [[0.0; 6]; 5]);
    for (i, site_row) in (0..5).zip(row - 2..) {
        let shift = if site_row & 1 == 1 { 0.5 } else { 0.0 };
        let y = wrapped(site_row, period.y);
        for (j, site_column) in (0..6).zip(column - 3..) {
            ids[i][j] = IVec2::new(wrapped(site_column, period.x), y);
            let offset = offset(ids[i][j]);
            xs[i][j] = (site_column as f32 + 0.5 + shift + offset.x) * size.x;
            ys[i][j] = (site_row as f32 + 0.5 + offset.y) * size.y;
        }
    }
    // The nearest site is among the inner ones; the outer ones only give borders.
    let (mut id, mut nearest, mut least_distance) = (IVec2::ZERO, Vec2::ZERO, f32::INFINITY);
    for (i, j) in (1..4).flat_map(|i| (1..5).map(move |j| (i, j))) {
        let site = Vec2::new(xs[i][j], ys[i][j]);
        let distance = site.distance_squared(position);
        if distance < least_distance {
            (id, nearest, least_distance) = (ids[i][j], site, distance);
        }
    }
    let mut borders = [f32::INFINITY; 30]; // distances to the lines midway between the nearest site and each other site
    for ((border, &x), &y) in borders.iter_mut().zip(xs.as_flattened()).zip(ys.as_flattened()) {
        let apart = [x - nearest.x, y - nearest.y];
        let squared = apart[0] * apart[0] + apart[1] * apart[1];
        let inverse = 1.0 / squared.sqrt();
        let [to_x, to_y] = [0.5 * (x + nearest.x) - position.x, 0.5 * (y + nearest.y) - position.y];
        let distance = to_x * (apart[0] * inverse) + to_y * (apart[1] * inverse);
        let is_other_site = squared > 1e-8;
        *border = if is_other_site { distance } else { f32::INFINITY };
    }
    let border = borders.into_iter().fold(f32::INFINITY, f32::min);
    VoronoiCell { id, border: border.max(0.0) }
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
    fn an_image_has_the_noise_of_each_point() {
        let (period, side, rows, columns) = (IVec2::new(5, 9), 64, 10..64, 3..40);
        let image = fractal_image((period, 3, 7), side, rows.clone(), columns.clone());
        let texels = rows.flat_map(|y| columns.clone().map(move |x| Vec2::new(x as f32, y as f32)));
        for (texel, here) in texels.zip(image) {
            let uv = (texel + 0.5) / side as f32;
            assert_eq!(fractal(uv * period.as_vec2(), period, 3, 7).to_bits(), here.to_bits(), "{uv}");
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
        let cells = VoronoiCells::new(Vec2::ONE, IVec2::new(8, 8), 0.0, 3);
        let cell = cells.cell(Vec2::new(2.5, 0.5));
        assert_eq!(cell.id, IVec2::new(2, 0));
        assert!((cell.border - 0.5).abs() < 1e-5, "{}", cell.border);
        let cell = cells.cell(Vec2::new(2.9, 0.5));
        assert!((cell.border - 0.1).abs() < 1e-5, "{}", cell.border);
    }

    #[test]
    fn cells_with_sites_computed_once_are_those_of_the_function() {
        let period = IVec2::new(6, 4);
        let cells = VoronoiCells::new(Vec2::new(0.5, 0.25), period, 0.75, 11);
        for position in
            (0..200).map(|k| Vec2::new(unit(IVec2::new(k, 0), 1) * 4.0 - 0.5, unit(IVec2::new(k, 1), 1) * 2.0 - 0.5))
        {
            assert_eq!(cells.cell(position), cell(position, Vec2::new(0.5, 0.25), period, 0.75, 11), "{position}");
        }
    }
}

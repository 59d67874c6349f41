//! The thesis's figures 4.1 to 4.3: a Hi-Z chain as tables of numbers, with the texels from which each cell was made.

use super::{COLORS, Svg, depth_text};
use glam::Vec2;
use ssct_truth::reference::{Level, hi_z};

/// Side of a cell in pixels.
const CELL: f32 = 46.0;
/// Room between two levels, in pixels.
const GAP: f32 = 56.0;
/// Room at both sides of the drawing, in pixels.
const MARGIN: f32 = 16.0;
/// Room above the levels, for titles, in pixels.
const HEAD: f32 = 30.0;
/// Room below the levels, for notes, in pixels.
const FOOT: f32 = 92.0;
/// Side of the square that marks a fetch.
const MARK: f32 = 9.0;

/// The texels from which a cell is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fetches {
    /// Two by two, also where the level below has an odd side (figures 4.1 and 4.2).
    Neighbours,
    /// Eq. 4.1: where the side is odd, the second texel is two texels further (figure 4.3).
    Offset,
}

impl Fetches {
    /// Returns the four texels, as column and row, of the level below from which the cell at `x`, `y` is made. The
    /// texel at the edge stands for texels beyond the edge.
    fn texels(self, [x, y]: [u32; 2], below: &Level<f32>) -> [[u32; 2]; 4] {
        let offset = |side| if self == Self::Offset { hi_z::offset(side) } else { 1 };
        let (dx, dy) = (offset(below.width), offset(below.height));
        [(0, 0), (dx, 0), (0, dy), (dx, dy)]
            .map(|(dx, dy)| [(2 * x + dx).min(below.width - 1), (2 * y + dy).min(below.height - 1)])
    }
}

/// Makes the chain of minima over a depth buffer by [`Fetches::Neighbours`], against which the thesis warns.
pub fn undersized(depth: &Level<f32>) -> Vec<Level<f32>> {
    let reduce = |below: &Level<f32>| {
        let (width, height) = below.coarser()?;
        let least = |x, y| {
            let read = Fetches::Neighbours.texels([x, y], below).map(|[x, y]| below.at_clamped(x, y));
            read.into_iter().fold(f32::INFINITY, f32::min)
        };
        Some(Level::from_fn(width, height, least))
    };
    std::iter::successors(Some(depth.clone()), reduce).collect()
}

/// Draws a chain of minima, finest level first, at most its first four levels. Squares mark the texels of a cell, and a frame of the same
/// colour marks the cell. Texels that no cell reads are crossed out. A cell that misses the least depth of its area also shows this depth.
pub fn chain(levels: &[Level<f32>], fetches: Fetches) -> String {
    let levels = &levels[..levels.len().min(4)];
    let width: f32 = levels.iter().map(|l| column_width(l) + GAP).sum();
    let height = levels.first().map_or(0.0, |l| l.height as f32 * CELL);
    let mut svg = Svg::new(Vec2::new(width - GAP + 2.0 * MARGIN, height + HEAD + FOOT));
    let (low, high) = depth_range(levels);
    // The left side of the current level's drawing.
    let mut left = MARGIN;
    // The number of cells that miss the least depth of their area, and whether there are texels that no cell reads.
    let (mut wrong, mut unread) = (0, false);
    for (n, level) in levels.iter().enumerate() {
        let corner = Vec2::new(left, HEAD);
        let title = format!("level {n}: {} × {}", level.width, level.height);
        svg.text(corner + Vec2::new(0.0, -10.0), 14.0, "", &title);
        for y in 0..level.height {
            for x in 0..level.width {
                let z = level.at_clamped(x, y);
                let cell_corner = corner + CELL * Vec2::new(x as f32, y as f32);
                let shade = (250.0 - 110.0 * (z - low) / (high - low).max(1e-9)) as u8;
                let fill = format!(r##"fill="rgb({shade},{shade},{shade})" stroke="#888" stroke-width="0.5""##);
                svg.rect(cell_corner, Vec2::splat(CELL), &fill);
                let middle = cell_corner + Vec2::new(0.5 * CELL, 0.5 * CELL + 5.0);
                svg.text(middle, 14.0, r#"text-anchor="middle""#, &depth_text(z));
                if n > 0 {
                    wrong += u32::from(draw_frame(&mut svg, cell_corner, level, [x, y], z, &levels[0]));
                }
            }
        }
        if let Some(above) = levels.get(n + 1) {
            unread |= draw_marks(&mut svg, corner, level, above, fetches);
        }
        left += column_width(level) + GAP;
    }
    let mut notes = vec![
        "Standard depth (0 near, 1 far). Small squares: texels that are fetched; the frame of their colour:",
        "the cell made of them.",
    ];
    if unread {
        notes.push("Crossed out: read by no cell.");
    }
    let lost = format!("Red: the least depth in a cell's area, where the cell holds more ({wrong} cells).");
    if wrong > 0 {
        notes.push(&lost);
    }
    for (n, note) in notes.into_iter().enumerate() {
        svg.text(Vec2::new(MARGIN, HEAD + height + 26.0 + 18.0 * n as f32), 13.0, "", note);
    }
    svg.finish()
}

/// The least and the greatest depth of all levels.
fn depth_range(levels: &[Level<f32>]) -> (f32, f32) {
    let depths = levels.iter().flat_map(|l| &l.texels);
    depths.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), z| (low.min(*z), high.max(*z)))
}

/// Width of a level's drawing, with room for its title.
fn column_width(level: &Level<f32>) -> f32 {
    (level.width as f32 * CELL).max(96.0)
}

/// Returns the colour of the cell at `x`, `y`. It repeats after three cells, so that all eight neighbours differ from
/// it.
fn cell_color([x, y]: [u32; 2]) -> &'static str {
    COLORS[(x % 3 + 3 * (y % 3)) as usize]
}

/// Draws the frame of a cell of depth `z`, whose upper left corner in the drawing is `corner`. If the least depth of
/// `finest` in the cell's area is less than `z`, also draws that depth and returns true.
fn draw_frame(svg: &mut Svg, corner: Vec2, level: &Level<f32>, cell: [u32; 2], z: f32, finest: &Level<f32>) -> bool {
    let frame = format!(r#"fill="none" stroke="{}" stroke-width="3""#, cell_color(cell));
    svg.rect(corner + 2.0, Vec2::splat(CELL - 4.0), &frame);
    let least = least_within(level, cell, finest);
    if least < z {
        let below = corner + Vec2::new(0.5 * CELL, CELL - 7.0);
        svg.text(below, 11.0, r##"text-anchor="middle" fill="#c00" font-weight="bold""##, &depth_text(least));
    }
    least < z
}

/// Returns the least depth of the finest level in the area of the cell at `x`, `y` of `level`.
fn least_within(level: &Level<f32>, [x, y]: [u32; 2], finest: &Level<f32>) -> f32 {
    // The texels of the finest level, `side` long, that cell n of `count` cells covers, if only in part.
    let span = |n: u32, count: u32, side: u32| n * side / count..((n + 1) * side).div_ceil(count);
    let rows = span(y, level.height, finest.height);
    rows.flat_map(|j| span(x, level.width, finest.width).map(move |i| finest.at_clamped(i, j)))
        .fold(f32::INFINITY, f32::min)
}

/// Draws squares on texels that the level above fetches, and crosses on all others; returns whether there are crosses.
fn draw_marks(svg: &mut Svg, corner: Vec2, level: &Level<f32>, above: &Level<f32>, fetches: Fetches) -> bool {
    let mut read = vec![false; level.texels.len()];
    for y in 0..above.height {
        for x in 0..above.width {
            let mut texels = fetches.texels([x, y], level).to_vec();
            texels.dedup();
            for [i, j] in texels {
                read[(j * level.width + i) as usize] = true;
                // Up to four cells read one texel, so each of them has its mark in another corner of the texel.
                let mark_place = Vec2::new((x % 2) as f32, (y % 2) as f32);
                let mark_corner =
                    corner + CELL * Vec2::new(i as f32, j as f32) + 3.0 + mark_place * (CELL - MARK - 6.0);
                svg.rect(mark_corner, Vec2::splat(MARK), &format!(r#"fill="{}""#, cell_color([x, y])));
            }
        }
    }
    for (n, _) in read.iter().enumerate().filter(|(_, read)| !**read) {
        let cell_corner = corner + CELL * Vec2::new((n as u32 % level.width) as f32, (n as u32 / level.width) as f32);
        svg.line(cell_corner, cell_corner + CELL, r##"stroke="#c00" stroke-opacity="0.45""##);
        svg.line(
            cell_corner + Vec2::new(CELL, 0.0),
            cell_corner + Vec2::new(0.0, CELL),
            r##"stroke="#c00" stroke-opacity="0.45""##,
        );
    }
    read.contains(&false)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_that_misses_the_least_depth_of_its_area_shows_this_depth_in_red() {
        // The nearest of five texels is the last (lost without Eq. 4.1) or the second (lost with Eq. 4.1).
        let depth = |nearest: u32| Level::from_fn(5, 1, |x, _| if x == nearest { 0.25 } else { 0.75 });
        let without = |nearest| chain(&undersized(&depth(nearest)), Fetches::Neighbours);
        assert!(without(4).contains("fill=\"#c00\" font-weight=\"bold\">.250</text>"));
        assert!(!without(0).contains("font-weight"));
        let offset = |nearest| {
            let minima = hi_z::chain(&depth(nearest));
            let minima = minima.iter().map(|l| Level::from_fn(l.width, l.height, |x, y| l.at_clamped(x, y).min));
            chain(&minima.collect::<Vec<_>>(), Fetches::Offset)
        };
        assert!(offset(1).contains("font-weight") && !offset(4).contains("font-weight"));
    }
}

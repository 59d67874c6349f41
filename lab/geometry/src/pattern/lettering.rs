//! Capital letters and digits for signs, as strokes: each letter is a set of polylines on a grid of four by six units,
//! with y downwards. Strokes are equally wide everywhere and have round ends, like bent glass tubes.

use glam::Vec2;

/// Width and height of a letter in its own units.
const LETTER: Vec2 = Vec2::new(4.0, 6.0);
/// Space between two letters, in the same units: x in a line of text, and y between stacked letters.
const GAP: Vec2 = Vec2::new(1.9, 2.1);

/// A polyline: x and y of its points on the grid of a letter.
type Stroke = &'static [(f32, f32)];

/// A line of text, or letters stacked on top of one another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Text {
    /// Capital letters, digits, space and `>` (an arrow); any other character is blank.
    pub letters: &'static str,
    /// Whether the letters are stacked vertically.
    pub stacked: bool,
}

impl Text {
    /// Width and height in units of the letters' grid.
    pub fn size(&self) -> Vec2 {
        let count = self.letters.chars().count() as f32;
        let steps = (count - 1.0).max(0.0);
        if self.stacked {
            Vec2::new(LETTER.x, LETTER.y * count + GAP.y * steps)
        } else {
            Vec2::new(LETTER.x * count + GAP.x * steps, LETTER.y)
        }
    }

    /// Returns the distance from a point to the nearest stroke, in units of the grid; the text's top left is the
    /// origin. Letters farther than one gap from the point are ignored; if all are, the distance is infinite.
    pub fn distance(&self, point: Vec2) -> f32 {
        let step = if self.stacked { Vec2::new(0.0, LETTER.y + GAP.y) } else { Vec2::new(LETTER.x + GAP.x, 0.0) };
        let letters = self.letters.chars().enumerate();
        letters
            // Each letter, with the point relative to the letter's own top left.
            .map(|(index, letter)| (point - step * index as f32, letter))
            .filter(|(local, _)| local.cmpgt(-GAP).all() && local.cmplt(LETTER + GAP).all())
            .flat_map(|(local, letter)| strokes(letter).iter().map(move |stroke| distance_to_stroke(local, stroke)))
            .fold(f32::INFINITY, f32::min)
    }
}

/// Returns the distance from a point to a stroke, in units of the grid.
fn distance_to_stroke(point: Vec2, stroke: Stroke) -> f32 {
    stroke
        .windows(2)
        .map(|ends| distance_to_segment(point, ends[0].into(), ends[1].into()))
        .fold(f32::INFINITY, f32::min)
}

/// Returns the distance from a point to the line segment from `a` to `b`.
pub fn distance_to_segment(point: Vec2, a: Vec2, b: Vec2) -> f32 {
    let along = ((point - a).dot(b - a) / (b - a).length_squared().max(1e-12)).clamp(0.0, 1.0);
    point.distance(a.lerp(b, along))
}

/// Returns the strokes of a letter; none for a character without a drawing.
#[rustfmt::skip]
fn strokes(letter: char) -> &'static [Stroke] {
    match letter {
        'A' => &[&[(0.0, 6.0), (2.0, 0.0), (4.0, 6.0)], &[(0.8, 4.0), (3.2, 4.0)]],
        'B' => &[&[(0.0, 3.0), (3.0, 3.0), (4.0, 4.0), (4.0, 5.0), (3.0, 6.0), (0.0, 6.0), (0.0, 0.0), (2.8, 0.0),
            (3.6, 0.8), (3.6, 2.2), (2.8, 3.0)]],
        'C' => &[&[(4.0, 1.0), (3.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.0, 5.0), (1.0, 6.0), (3.0, 6.0), (4.0, 5.0)]],
        'E' => &[&[(4.0, 0.0), (0.0, 0.0), (0.0, 6.0), (4.0, 6.0)], &[(0.0, 3.0), (3.0, 3.0)]],
        'F' => &[&[(4.0, 0.0), (0.0, 0.0), (0.0, 6.0)], &[(0.0, 3.0), (3.0, 3.0)]],
        'H' => &[&[(0.0, 0.0), (0.0, 6.0)], &[(4.0, 0.0), (4.0, 6.0)], &[(0.0, 3.0), (4.0, 3.0)]],
        'I' => &[&[(2.0, 0.0), (2.0, 6.0)], &[(0.8, 0.0), (3.2, 0.0)], &[(0.8, 6.0), (3.2, 6.0)]],
        'K' => &[&[(0.0, 0.0), (0.0, 6.0)], &[(4.0, 0.0), (0.0, 3.4)], &[(1.4, 2.4), (4.0, 6.0)]],
        'L' => &[&[(0.0, 0.0), (0.0, 6.0), (4.0, 6.0)]],
        'M' => &[&[(0.0, 6.0), (0.0, 0.0), (2.0, 3.2), (4.0, 0.0), (4.0, 6.0)]],
        'N' => &[&[(0.0, 6.0), (0.0, 0.0), (4.0, 6.0), (4.0, 0.0)]],
        'O' => &[&[(1.0, 0.0), (3.0, 0.0), (4.0, 1.0), (4.0, 5.0), (3.0, 6.0), (1.0, 6.0), (0.0, 5.0), (0.0, 1.0),
            (1.0, 0.0)]],
        'P' => &[&[(0.0, 6.0), (0.0, 0.0), (3.0, 0.0), (4.0, 1.0), (4.0, 2.2), (3.0, 3.2), (0.0, 3.2)]],
        'R' => &[&[(0.0, 6.0), (0.0, 0.0), (3.0, 0.0), (4.0, 1.0), (4.0, 2.2), (3.0, 3.2), (0.0, 3.2)],
            &[(2.0, 3.2), (4.0, 6.0)]],
        'S' => &[&[(4.0, 1.0), (3.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.0, 2.0), (1.0, 3.0), (3.0, 3.0), (4.0, 4.0),
            (4.0, 5.0), (3.0, 6.0), (1.0, 6.0), (0.0, 5.0)]],
        'T' => &[&[(0.0, 0.0), (4.0, 0.0)], &[(2.0, 0.0), (2.0, 6.0)]],
        'U' => &[&[(0.0, 0.0), (0.0, 5.0), (1.0, 6.0), (3.0, 6.0), (4.0, 5.0), (4.0, 0.0)]],
        'X' => &[&[(0.0, 0.0), (4.0, 6.0)], &[(4.0, 0.0), (0.0, 6.0)]],
        '1' => &[&[(1.0, 1.2), (2.4, 0.0), (2.4, 6.0)]],
        '2' => &[&[(0.0, 1.2), (1.0, 0.0), (3.0, 0.0), (4.0, 1.0), (4.0, 2.2), (0.0, 6.0), (4.0, 6.0)]],
        '3' => &[&[(0.0, 0.6), (1.0, 0.0), (3.0, 0.0), (4.0, 1.0), (4.0, 2.0), (3.0, 2.9), (1.6, 2.9)],
            &[(3.0, 2.9), (4.0, 4.0), (4.0, 5.0), (3.0, 6.0), (1.0, 6.0), (0.0, 5.2)]],
        '4' => &[&[(3.0, 6.0), (3.0, 0.0), (0.0, 4.2), (4.0, 4.2)]],
        '7' => &[&[(0.0, 0.0), (4.0, 0.0), (1.4, 6.0)]],
        '>' => &[&[(0.0, 3.0), (4.0, 3.0)], &[(2.2, 1.2), (4.0, 3.0), (2.2, 4.8)]],
        _ => &[],
    }
}

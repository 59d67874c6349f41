//! Images that cover a surface once, from edge to edge: signs, paintings, panes and stained glass. No image is
//! symmetric, so that a mirrored reflection is noticed.

use super::lettering::{Text, distance_to_segment};
use glam::{IVec2, Vec2, Vec3, Vec4};
use ssct_ground::math::atan2;
use ssct_ground::math::noise::{cell, fractal, smoothstep, unit};
use std::f32::consts::{FRAC_PI_2, PI, TAU};

/// An image that can be generated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Picture {
    /// Letters on a coloured ground, cut to a shape.
    Sign(&'static Sign),
    /// A painting on a wall.
    Painting(Painting),
    /// A window as seen from the street: four panes in a white frame.
    Pane {
        /// Whether the room behind the window is lit.
        lit: bool,
    },
    /// A shop window: shelves with goods in warm light, a counter on the right.
    Shop,
    /// A church window that ends in a pointed arch; transparent outside it.
    Lancet {
        /// Number of the design, which includes the colours of the glass.
        design: u32,
    },
    /// A round church window with twelve petals; transparent outside it.
    Rose,
}

/// A painting.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Painting {
    /// Hills under a low sun on the left, with a poplar on the right.
    Landscape,
    /// A sailing ship, its bow to the right.
    Ship,
    /// Coloured fields between black bars.
    Fields,
    /// A face that looks to the left.
    Portrait,
}

/// The outline of a sign.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SignOutline {
    /// A plate with rounded corners.
    Plate,
    /// A plate whose right side runs out into the tip of an arrow.
    Arrow,
    /// A plate whose lower end is cut at a slant.
    Slant,
}

/// A sign. Colours are linear.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sign {
    /// The text.
    pub text: Text,
    /// The outline.
    pub cut: SignOutline,
    /// Colour of the letters.
    pub ink: Vec3,
    /// Colour of the ground.
    pub ground: Vec3,
    /// Whether lamps run along the border, as on cinemas.
    pub bulbs: bool,
    /// Size in texels, with the aspect ratio of the surface.
    pub size: [u32; 2],
}

impl Picture {
    /// Width and height in texels.
    pub fn size(self) -> [u32; 2] {
        match self {
            Self::Sign(sign) => sign.size,
            Self::Painting(Painting::Portrait) => [256, 320],
            Self::Painting(_) => [384, 256],
            Self::Pane { .. } => [128, 192],
            Self::Shop => [256, 320],
            Self::Lancet { .. } => [144, 384],
            Self::Rose => [384, 384],
        }
    }

    /// Whether the image has holes.
    pub fn has_alpha(self) -> bool {
        matches!(self, Self::Sign(_) | Self::Lancet { .. } | Self::Rose)
    }

    /// Returns the linear colour and the coverage (0 to 1) at a point of the image; (0, 0) is the top left, (1, 1) the
    /// bottom right.
    pub fn sample(self, uv: Vec2) -> Vec4 {
        match self {
            Self::Sign(sign) => sign.sample(uv),
            Self::Painting(painting) => painting.sample(uv).extend(1.0),
            Self::Pane { lit } => pane(uv, lit).extend(1.0),
            Self::Shop => shop(uv).extend(1.0),
            Self::Lancet { design } => lancet(uv, design),
            Self::Rose => rose(uv),
        }
    }

    /// The name of the picture, which becomes part of its images' names.
    pub fn label(self) -> String {
        match self {
            Self::Sign(sign) => format!("sign {}", sign.text.letters),
            Self::Painting(painting) => format!("painting {painting:?}"),
            Self::Pane { lit } => format!("pane {}", if lit { "lit" } else { "dark" }),
            Self::Shop => "shop".to_owned(),
            Self::Lancet { design } => format!("lancet {design}"),
            Self::Rose => "rose".to_owned(),
        }
    }
}

impl Sign {
    /// Returns the linear colour and the coverage at a point of the image. Lengths are in units of the sign's shorter
    /// side.
    fn sample(&self, uv: Vec2) -> Vec4 {
        let size = Vec2::new(self.size[0] as f32, self.size[1] as f32) / self.size[0].min(self.size[1]) as f32;
        let point = uv * size;
        let rim = self.rim_distance(point, size);
        // Letters fill the sign except for a margin, the tip of an arrow and the slanted end.
        let text_area = match self.cut {
            SignOutline::Plate => size,
            SignOutline::Arrow => size - Vec2::new(0.45, 0.0),
            SignOutline::Slant => size - Vec2::new(0.0, 0.45),
        };
        let text = self.text.size();
        let margin = if self.bulbs { 0.4 } else { 0.28 };
        let scale = ((text_area - margin) / text).min_element();
        let corner = 0.5 * (text_area - text * scale);
        // The distance to the nearest stroke, in units of the letters' grid.
        let to_stroke = self.text.distance((point - corner) / scale);
        let glow = 0.35 * smoothstep(1.6, 0.3, to_stroke);
        let letter = smoothstep(0.62, 0.42, to_stroke);
        let mut colour = self.ground.lerp(self.ink, glow.max(letter));
        // A line runs along the rim, and lamps 0.125 apart if there are any.
        let line = smoothstep(0.012, 0.0, (rim - 0.035).abs() - 0.012);
        colour = colour.lerp(self.ink, line);
        if self.bulbs {
            let lamp = (point / 0.125).fract_gl() - 0.5;
            let on_border = smoothstep(0.02, 0.0, (rim - 0.0625).abs() - 0.06);
            let lamps = smoothstep(0.36, 0.28, lamp.length()) * on_border;
            colour = colour.lerp(Vec3::new(1.0, 0.86, 0.55), lamps);
        }
        colour.extend(smoothstep(-0.004, 0.004, rim))
    }

    /// Returns the distance inwards from the sign's edge, negative outside. The distance, the point and the sign's size
    /// are in units of its shorter side.
    fn rim_distance(&self, point: Vec2, size: Vec2) -> f32 {
        let half = 0.5 * size;
        // A plate has corners with a radius of 0.08; `beyond` is measured from the middles of these corners.
        let plate = |half: Vec2, offset: Vec2| {
            let beyond = offset.abs() - half + 0.08;
            0.08 - beyond.max(Vec2::ZERO).length() - beyond.max_element().min(0.0)
        };
        let body = plate(half, point - half);
        match self.cut {
            SignOutline::Plate => body,
            // Two half planes bound the tip. Their edges meet in the middle of the right edge, each at 45°. The factors
            // 1 / √2 and, for the slant, 1 / √(1 + 0.45²) turn the equations of the lines into distances.
            SignOutline::Arrow => body.min((size.x - point.x - (point.y - half.y).abs()) * 0.707),
            SignOutline::Slant => body.min((size.y - 0.45 * (size.x - point.x) - point.y) * 0.912),
        }
    }
}

impl Painting {
    /// Returns the linear colour at a point of the image, with brush strokes.
    fn sample(self, uv: Vec2) -> Vec3 {
        let strokes = 0.88 + 0.24 * fractal(uv * Vec2::new(14.0, 30.0), IVec2::new(64, 64), 3, 401);
        let painted = match self {
            Self::Landscape => landscape(uv),
            Self::Ship => ship(uv),
            Self::Fields => fields(uv),
            Self::Portrait => portrait(uv),
        };
        (painted * strokes).clamp(Vec3::ZERO, Vec3::ONE)
    }
}

/// Returns `colour` inside a shape and `background` outside. `inside` is the distance to the shape's outline, positive
/// inside; the colours blend within 0.004 of the outline.
fn paint_over(background: Vec3, colour: Vec3, inside: f32) -> Vec3 {
    background.lerp(colour, smoothstep(-0.004, 0.004, inside))
}

/// Returns roughly the distance from a point to the outline of an ellipse, positive inside.
fn ellipse(point: Vec2, centre: Vec2, radii: Vec2) -> f32 {
    (1.0 - ((point - centre) / radii).length()) * radii.min_element()
}

/// Returns the distance from a point to the nearest edge line of a convex polygon, positive inside. The corners, (x, y)
/// with y downwards, run clockwise on the screen.
fn polygon(point: Vec2, corners: &[(f32, f32)]) -> f32 {
    (0..corners.len())
        .map(|edge| {
            let (start, end): (Vec2, Vec2) = (corners[edge].into(), corners[(edge + 1) % corners.len()].into());
            (end - start).normalize_or_zero().perp_dot(point - start)
        })
        .fold(f32::INFINITY, f32::min)
}

/// Returns the linear colour of the painting of hills under a low sun, before brush strokes. From back to front it
/// shows sky, sun, three ranges of hills, a path and a poplar.
fn landscape(uv: Vec2) -> Vec3 {
    let wave = |x: f32, seed: u32| fractal(Vec2::new(x, 0.5), IVec2::new(64, 1), 4, seed);
    let sky = Vec3::new(0.95, 0.62, 0.22).lerp(Vec3::new(0.16, 0.36, 0.72), smoothstep(0.55, 0.0, uv.y));
    let mut colour =
        paint_over(sky, Vec3::new(1.0, 0.93, 0.6), ellipse(uv, Vec2::new(0.24, 0.34), Vec2::new(0.065, 0.095)));
    colour = paint_over(colour, Vec3::new(0.30, 0.32, 0.52), uv.y - 0.62 + 0.36 * wave(uv.x * 3.0, 409));
    colour = paint_over(colour, Vec3::new(0.14, 0.30, 0.16), uv.y - 0.74 + 0.26 * wave(uv.x * 4.0 + 9.0, 419));
    colour = paint_over(colour, Vec3::new(0.42, 0.48, 0.10), uv.y - 0.84 + 0.16 * wave(uv.x * 5.0 + 20.0, 421));
    let path_middle_x = 0.36 + 0.3 * (uv.y - 0.8) + 0.05 * (uv.y * 30.0).sin();
    colour = paint_over(
        colour,
        Vec3::new(0.80, 0.66, 0.42),
        (0.5 * (uv.y - 0.76) - (uv.x - path_middle_x).abs()).min(uv.y - 0.78),
    );
    paint_over(colour, Vec3::new(0.05, 0.15, 0.06), ellipse(uv, Vec2::new(0.80, 0.52), Vec2::new(0.05, 0.34)))
}

/// Returns the linear colour of the painting of a sailing ship, before brush strokes. From back to front it shows sky
/// with clouds, sea, mast, two sails, a pennant, the hull and nearer waves.
fn ship(uv: Vec2) -> Vec3 {
    let swell = 0.012 * (uv.x * 38.0).sin() + 0.02 * (uv.x * 11.0 + 1.0).sin();
    let cloud = smoothstep(0.5, 0.75, fractal(uv * Vec2::new(4.0, 9.0), IVec2::splat(64), 4, 431));
    let mut colour = Vec3::new(0.42, 0.62, 0.80).lerp(Vec3::splat(0.92), 0.8 * cloud);
    colour = paint_over(colour, Vec3::new(0.04, 0.22, 0.34) * (0.8 + 1.2 * uv.y), uv.y - 0.72 - swell);
    colour = paint_over(
        colour,
        Vec3::new(0.22, 0.10, 0.05),
        0.008 - distance_to_segment(uv, Vec2::new(0.5, 0.14), Vec2::new(0.5, 0.7)),
    );
    let sail = Vec3::new(0.95, 0.90, 0.78);
    colour = paint_over(colour, sail, polygon(uv, &[(0.49, 0.16), (0.485, 0.60), (0.24, 0.60)]));
    colour = paint_over(colour, sail * 0.85, polygon(uv, &[(0.515, 0.20), (0.76, 0.60), (0.515, 0.60)]));
    colour = paint_over(colour, Vec3::new(0.75, 0.06, 0.05), polygon(uv, &[(0.5, 0.09), (0.62, 0.12), (0.5, 0.15)]));
    let hull = polygon(uv, &[(0.24, 0.64), (0.84, 0.62), (0.72, 0.77), (0.32, 0.77)]);
    colour = paint_over(colour, Vec3::new(0.30, 0.11, 0.05), hull);
    paint_over(colour, Vec3::new(0.04, 0.20, 0.32) * 1.5, uv.y - 0.75 - swell)
}

/// Returns the linear colour of the painting of coloured fields between black bars, before brush strokes.
fn fields(uv: Vec2) -> Vec3 {
    let colour = match (uv.x, uv.y) {
        (x, y) if x < 0.34 && y < 0.58 => Vec3::new(0.78, 0.05, 0.04),
        (x, y) if x > 0.72 && y > 0.7 => Vec3::new(0.95, 0.75, 0.06),
        (x, y) if (0.34..0.72).contains(&x) && y > 0.7 => Vec3::new(0.05, 0.12, 0.55),
        (x, y) if x > 0.84 && y < 0.3 => Vec3::new(0.05, 0.12, 0.55),
        _ => Vec3::new(0.90, 0.88, 0.82),
    };
    // The distances to the three bars from edge to edge, and to the three bars that end at another one.
    let long = [(uv.x - 0.34).abs(), (uv.y - 0.7).abs(), (uv.x - 0.72).abs()];
    let short = [
        if uv.x < 0.34 { (uv.y - 0.58).abs() } else { 1.0 },
        if uv.y < 0.7 { (uv.x - 0.84).abs() } else { 1.0 },
        if uv.x > 0.72 { (uv.y - 0.3).abs() } else { 1.0 },
    ];
    let nearest = long.into_iter().chain(short).fold(1.0, f32::min);
    paint_over(colour, Vec3::splat(0.02), 0.014 - nearest)
}

/// Returns the linear colour of the painting of a face, before brush strokes. From back to front it shows the ground,
/// hair, clothes, collar, neck, face, hair over the forehead, eyes with brows, nose and mouth.
fn portrait(uv: Vec2) -> Vec3 {
    let ground = Vec3::new(0.10, 0.16, 0.10) + 0.22 * smoothstep(0.9, 0.0, uv.distance(Vec2::new(0.2, 0.25)));
    let hair = Vec3::new(0.12, 0.05, 0.02);
    let skin = Vec3::new(0.86, 0.60, 0.42) * (1.25 - 0.7 * uv.x);
    let mut colour = paint_over(ground, hair, ellipse(uv, Vec2::new(0.57, 0.36), Vec2::new(0.25, 0.27)));
    colour = paint_over(colour, Vec3::new(0.36, 0.05, 0.06), ellipse(uv, Vec2::new(0.56, 1.04), Vec2::new(0.42, 0.34)));
    colour = paint_over(colour, Vec3::new(0.92, 0.88, 0.80), ellipse(uv, Vec2::new(0.50, 0.76), Vec2::new(0.15, 0.07)));
    colour = paint_over(colour, skin * 0.8, ellipse(uv, Vec2::new(0.53, 0.66), Vec2::new(0.09, 0.14)));
    colour = paint_over(colour, skin, ellipse(uv, Vec2::new(0.48, 0.42), Vec2::new(0.17, 0.22)));
    colour = paint_over(colour, hair, ellipse(uv, Vec2::new(0.60, 0.27), Vec2::new(0.19, 0.12)));
    let dark = Vec3::new(0.05, 0.03, 0.03);
    for x in [0.39, 0.53] {
        colour = paint_over(colour, Vec3::splat(0.9), ellipse(uv, Vec2::new(x, 0.41), Vec2::new(0.04, 0.018)));
        colour = paint_over(colour, dark, ellipse(uv, Vec2::new(x - 0.014, 0.41), Vec2::new(0.016, 0.018)));
        colour = paint_over(
            colour,
            hair,
            0.008 - distance_to_segment(uv, Vec2::new(x - 0.05, 0.375), Vec2::new(x + 0.04, 0.365)),
        );
    }
    colour =
        paint_over(colour, skin * 0.65, 0.008 - distance_to_segment(uv, Vec2::new(0.45, 0.41), Vec2::new(0.415, 0.50)));
    paint_over(colour, Vec3::new(0.62, 0.14, 0.12), ellipse(uv, Vec2::new(0.45, 0.56), Vec2::new(0.055, 0.016)))
}

/// Returns the linear colour of four panes in a frame. Behind them is a lit room with a lamp or dark glass, each with a
/// curtain on the left.
fn pane(uv: Vec2, lit: bool) -> Vec3 {
    let frame = Vec3::splat(0.62);
    let edge = (0.5 - (uv - 0.5).abs()).min_element();
    let bars = (uv.x - 0.5).abs().min((uv.y - 0.34).abs());
    let folds = 0.75 + 0.25 * (uv.x * 150.0).sin();
    let curtain = smoothstep(0.02, -0.02, uv.x - 0.3 + 0.14 * uv.y);
    let glass = if lit {
        let room = Vec3::new(0.95, 0.66, 0.28) * (0.55 + 0.6 * smoothstep(0.8, 0.0, uv.distance(Vec2::new(0.68, 0.3))));
        let lamp = paint_over(room, Vec3::new(1.0, 0.95, 0.8), ellipse(uv, Vec2::new(0.7, 0.24), Vec2::new(0.1, 0.05)));
        lamp.lerp(Vec3::new(0.85, 0.42, 0.18) * folds, curtain)
    } else {
        Vec3::new(0.018, 0.024, 0.032).lerp(Vec3::new(0.14, 0.13, 0.12) * folds, curtain)
    };
    paint_over(paint_over(glass, frame, 0.028 - bars), frame, 0.055 - edge).clamp(Vec3::ZERO, Vec3::ONE)
}

/// Returns the linear colour of a shop window: shelves with goods on the left, and a counter under a lamp on the right.
/// From back to front it shows the room, floor, goods on boards, counter, its top, and the lamp on its cord.
fn shop(uv: Vec2) -> Vec3 {
    let lamp = Vec2::new(0.74, 0.30);
    let room = Vec3::new(0.62, 0.40, 0.20) * (0.25 + 0.75 * smoothstep(0.75, 0.0, uv.distance(lamp)));
    let mut colour = paint_over(room, Vec3::new(0.10, 0.06, 0.035), uv.y - 0.86);
    // The shelves are a grid of goods: `id` is the column and row of one, and `inside` the place in its cell, 0 to 1.
    let in_cells = Vec2::new(uv.x * 14.0, (uv.y - 0.16) * 6.0);
    let (id, inside) = (in_cells.floor().as_ivec2(), in_cells - in_cells.floor());
    let on_shelves = uv.x > 0.06 && uv.x < 0.50 && uv.y > 0.16 && uv.y < 0.83;
    if on_shelves {
        let goods = Vec3::new(unit(id, 479), unit(id, 487), unit(id, 491)) * Vec3::new(0.8, 0.55, 0.4) + 0.05;
        let inside_goods = (0.42 - (inside.x - 0.5).abs()).min(inside.y - (0.25 + 0.5 * unit(id, 499)));
        colour = paint_over(Vec3::new(0.13, 0.075, 0.04), goods * (0.5 + 0.7 * uv.x), 0.1 * inside_goods);
        colour = paint_over(colour, Vec3::new(0.34, 0.20, 0.10), 0.015 * (inside.y - 0.92) * 10.0);
    }
    colour = paint_over(
        colour,
        Vec3::new(0.30, 0.14, 0.06),
        (uv.y - 0.62).min(uv.x - 0.60).min(0.96 - uv.x).min(0.88 - uv.y),
    );
    colour = paint_over(
        colour,
        Vec3::new(0.75, 0.60, 0.40),
        (0.012 - (uv.y - 0.62).abs()).min(uv.x - 0.58).min(0.98 - uv.x),
    );
    colour = paint_over(colour, Vec3::new(0.02, 0.02, 0.02), (0.004 - (uv.x - lamp.x).abs()).min(lamp.y - uv.y));
    paint_over(colour, Vec3::new(1.0, 0.92, 0.70), ellipse(uv, lamp, Vec2::new(0.10, 0.045)).min(lamp.y + 0.02 - uv.y))
        .clamp(Vec3::ZERO, Vec3::ONE)
}

/// Returns the linear colour of pieces of coloured glass in lead. The pieces are Voronoi cells, and `point` is in units
/// of the grid's cells. `tone` gives the colour of a piece: from 0 to 1 it runs from blue through red and gold to
/// green.
fn glass(point: Vec2, grid: IVec2, tone: impl Fn(IVec2) -> f32, seed: u32) -> Vec3 {
    const COLOURS: [Vec3; 5] = [
        Vec3::new(0.06, 0.14, 0.85),
        Vec3::new(0.10, 0.45, 0.90),
        Vec3::new(0.90, 0.07, 0.06),
        Vec3::new(1.0, 0.72, 0.10),
        Vec3::new(0.12, 0.65, 0.18),
    ];
    let cell = cell(point, Vec2::ONE, grid, 0.8, seed);
    let colour = COLOURS[((tone(cell.id) * 5.0) as usize).min(4)];
    let brightness = 0.7 + 0.3 * unit(cell.id, seed + 1);
    let streaks = 0.85 + 0.15 * fractal(point * 3.0, grid * 3, 2, seed + 2);
    Vec3::splat(0.012).lerp(colour * brightness * streaks, smoothstep(0.045, 0.085, cell.border))
}

/// Returns the linear colour and the coverage of a lancet window: a figure in a cloak on a ground of small panes, in a
/// pointed arch with a stone border. `p` is the point with x from −0.75 to 0.75, and y from 0 at the top to 4.
fn lancet(uv: Vec2, design: u32) -> Vec4 {
    let point = Vec2::new((uv.x - 0.5) * 1.5, uv.y * 4.0);
    // The arch lies inside two circles around the points where its sides begin to bend (y = 1.3); below, the sides are
    // straight. `rim` is the distance inwards from its outline.
    let sides = 0.75 - point.x.abs();
    let rim = if point.y < 1.3 { 1.5 - Vec2::new(point.x.abs() + 0.75, point.y - 1.3).length() } else { sides }
        .min(4.0 - point.y);
    let figure = polygon(point, &[(-0.05, 1.3), (0.36, 1.9), (0.46, 3.5), (-0.48, 3.5), (-0.38, 1.9)]);
    let lead = Vec3::splat(0.012);
    let mut colour = if figure > 0.0 {
        let cloak = |id: IVec2| 0.41 + 0.2 * (design % 3) as f32 + 0.18 * unit(id, 449);
        paint_over(
            lead,
            glass(Vec2::new(point.x + 2.0, point.y) * 3.1, IVec2::splat(64), cloak, 457 + design),
            figure - 0.01,
        )
    } else {
        let ground =
            glass(Vec2::new(point.x + 2.0, point.y) * 4.2, IVec2::splat(64), |id| 0.39 * unit(id, 443 + design), 439);
        let halo = ellipse(point, Vec2::new(-0.05, 1.25), Vec2::new(0.30, 0.30));
        paint_over(paint_over(ground, Vec3::new(1.0, 0.78, 0.2), halo), lead, figure + 0.03)
    };
    colour =
        paint_over(colour, Vec3::new(0.95, 0.68, 0.50), ellipse(point, Vec2::new(-0.06, 1.26), Vec2::new(0.15, 0.19)));
    // The figure holds a staff in one hand, so that its left and right differ.
    let (head, foot) = (Vec2::new(0.52, 1.1), Vec2::new(0.42, 3.5));
    colour = paint_over(colour, Vec3::new(1.0, 0.85, 0.35), 0.035 - distance_to_segment(point, head, foot));
    colour = paint_over(colour, lead, 0.012 - (point.y - 3.55).abs());
    let stone = Vec3::new(0.42, 0.38, 0.31);
    paint_over(colour, stone, 0.09 - rim).extend(smoothstep(-0.01, 0.01, rim))
}

/// Returns the linear colour and the coverage of a rose window of stained glass: twelve petals around a hub, in colours
/// that run once around the circle. `r` is the distance from the middle, 1 at the edge, and `turn` the angle, from 0 to
/// 1.
fn rose(uv: Vec2) -> Vec4 {
    let point = (uv - 0.5) * 2.0;
    let (radius, turn) = (point.length(), atan2(point.x, -point.y) / TAU + 0.5);
    let pieces = Vec2::new(turn * 48.0, radius * 11.0);
    let tone = |id: IVec2| ((id.x as f32 / 48.0) * 0.999 + 0.12 * unit(id, 461)).fract();
    let colour = glass(pieces, IVec2::new(48, 64), tone, 463);
    let stone = Vec3::new(0.46, 0.41, 0.33);
    // Stone surrounds three kinds of openings: twelve petals with round ends, a ring of round lobes, and a hub. The
    // number `opening` is the distance inwards from the outline of the nearest opening.
    let spoke = (turn * 12.0).fract() - 0.5;
    let across = (spoke / 12.0 * TAU).sin() * radius;
    let from_round_end = Vec2::new(across, radius - 0.62);
    let petal_half = 0.62 * (PI / 12.0).sin();
    let petal =
        if radius > 0.62 { petal_half - from_round_end.length() } else { petal_half * (radius / 0.62) - across.abs() };
    let from_lobe = Vec2::new(((turn * 12.0 + 0.5).fract() - 0.5) / 12.0 * TAU, radius - 0.86);
    let opening = (petal - 0.018)
        .min(radius - 0.26)
        .max(0.075 - from_lobe.length())
        .max(0.19 - radius * (1.0 + 0.12 * (6.0 * turn * TAU + FRAC_PI_2).sin()));
    paint_over(stone, colour, opening).extend(smoothstep(-0.005, 0.005, 0.985 - radius))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIGN: Sign = Sign {
        text: Text { letters: "CINEMA", stacked: false },
        cut: SignOutline::Arrow,
        ink: Vec3::ONE,
        ground: Vec3::ZERO,
        bulbs: false,
        size: [384, 96],
    };

    /// Every kind of picture.
    fn every_picture() -> Vec<Picture> {
        let mut pictures = vec![Picture::Sign(&SIGN), Picture::Shop, Picture::Rose];
        pictures
            .extend([Painting::Landscape, Painting::Ship, Painting::Fields, Painting::Portrait].map(Picture::Painting));
        pictures.extend([true, false].map(|lit| Picture::Pane { lit }));
        pictures.extend([0, 1, 2].map(|design| Picture::Lancet { design }));
        pictures
    }

    /// The mean of a function over an image of 48 × 48 points.
    fn mean(value: impl Fn(Vec2) -> f32) -> f32 {
        let uv = |k: u32| (Vec2::new((k % 48) as f32, (k / 48) as f32) + 0.5) / 48.0;
        (0..48 * 48).map(|k| value(uv(k))).sum::<f32>() / (48.0 * 48.0)
    }

    /// Mirrored along x or along y, each picture differs from itself by more than 0.012 in the mean.
    #[test]
    fn no_picture_is_its_own_mirror_image() {
        for picture in every_picture() {
            let flipped = |uv: Vec2, x: bool| if x { Vec2::new(1.0 - uv.x, uv.y) } else { Vec2::new(uv.x, 1.0 - uv.y) };
            for x in [true, false] {
                let difference =
                    mean(|uv| (picture.sample(uv) - picture.sample(flipped(uv, x))).truncate().abs().element_sum());
                assert!(difference > 0.012, "{picture:?}, x {x}: {difference}");
            }
        }
    }

    #[test]
    fn colours_and_coverage_lie_between_0_and_1_and_only_cut_pictures_are_transparent() {
        for picture in every_picture() {
            let outside = mean(|uv| {
                let sample = picture.sample(uv);
                assert!(sample.min_element() >= 0.0 && sample.max_element() <= 1.001, "{picture:?} {uv}: {sample}");
                1.0 - sample.w
            });
            assert_eq!(outside > 0.0, picture.has_alpha(), "{picture:?}: {outside}");
            assert!(outside < 0.4, "{picture:?}: {outside}");
        }
    }

    #[test]
    fn letters_are_placed_correctly() {
        // The upright of an L is on its left, and its foot is at the bottom.
        let text = Text { letters: "LX", stacked: false };
        assert_eq!(text.size(), Vec2::new(9.9, 6.0));
        assert!(text.distance(Vec2::new(0.0, 3.0)) < 1e-6 && text.distance(Vec2::new(2.0, 6.0)) < 1e-6);
        assert!(text.distance(Vec2::new(3.0, 2.0)) > 2.0);
        assert!(text.distance(Vec2::new(7.9, 3.0)) < 1e-5, "the middle of the X");
        let stacked = Text { letters: "LX", stacked: true };
        assert_eq!(stacked.size(), Vec2::new(4.0, 14.1));
        assert!(stacked.distance(Vec2::new(2.0, 11.1)) < 1e-5);
    }
}

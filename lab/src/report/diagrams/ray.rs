//! The thesis's figure 4.6: a ray's way through the Hi-Z cells, from the side and on the screen, and the
//! level at each of its iterations.

use super::{COLORS, Svg, depth_text};
use glam::{Vec2, Vec3, Vec3Swizzles};
use ssct_truth::reference::Level;
use ssct_truth::reference::hi_z::MinMax;
use ssct_truth::reference::hi_z_ray_trace::{HiZTrace, Step};

/// Width of the whole drawing in pixels.
const WIDTH: f32 = 900.0;
/// Height of the profile in pixels.
const PROFILE: f32 = 330.0;
/// Height in pixels of the two drawings below the profile.
const LOWER: f32 = 300.0;
/// Height in pixels between the profile and the drawings below it, for text.
const GAP: f32 = 98.0;
/// Room in pixels at the left of the profile.
const LEFT: f32 = 66.0;
/// Room in pixels above the profile.
const TOP: f32 = 34.0;

/// Draws the traversal of a Hi-Z chain by one ray, as SVG.
pub fn ray(trace: &HiZTrace, chain: &[Level<MinMax>]) -> String {
    let mut svg = Svg::new(Vec2::new(WIDTH, TOP + PROFILE + GAP + LOWER));
    draw_profile(&mut svg, trace, chain);
    let top = TOP + PROFILE + GAP;
    draw_levels(&mut svg, trace, Vec2::new(LEFT, top));
    draw_screen(&mut svg, trace, chain, Vec2::new(0.5 * WIDTH + 40.0, top));
    svg.finish()
}

/// The colour of cells of a level.
fn level_color(level: u32) -> &'static str {
    COLORS[level as usize % COLORS.len()]
}

/// The mapping of a drawing that shows depth over the distance on the screen from the ray's start.
struct Profile {
    /// The start of the ray: texture coordinates and depth.
    from: Vec3,
    /// The direction of the ray on the screen in pixels, of length 1.
    along: Vec2,
    /// Width and height of the screen in pixels.
    pixels: Vec2,
    /// The distance in pixels at the right border of the drawing.
    length: f32,
    /// The depths at the lower and at the upper border of the drawing.
    depth: [f32; 2],
}

impl Profile {
    /// Makes a mapping that has room for the whole ray, and for all depths that the ray and the cells have.
    fn new(trace: &HiZTrace, chain: &[Level<MinMax>]) -> Self {
        let pixels = Vec2::new(chain[0].width as f32, chain[0].height as f32);
        let on_screen = (trace.last() - trace.from).xy() * pixels;
        let far = trace.steps.iter().map(|s| s.minimum_plane.max(s.ray.z)).fold(trace.from.z, f32::max);
        let room = 0.08 * (far - trace.from.z);
        let depth = [trace.from.z - room, far + room];
        Self {
            from: trace.from,
            along: on_screen.normalize_or_zero(),
            pixels,
            length: on_screen.length() * 1.04,
            depth,
        }
    }

    /// The distance in pixels from the ray's start to a point of the ray, which is given by its texture coordinates.
    fn distance(&self, uv: Vec2) -> f32 {
        ((uv - self.from.xy()) * self.pixels).dot(self.along)
    }

    /// The point of the drawing, in its pixels, for a distance in pixels from the ray's start and a depth.
    fn point(&self, distance: f32, depth: f32) -> Vec2 {
        let share = (depth - self.depth[0]) / (self.depth[1] - self.depth[0]);
        Vec2::new(LEFT + distance / self.length * (WIDTH - LEFT - 24.0), TOP + PROFILE * (1.0 - share.clamp(0.0, 1.0)))
    }

    /// The distances in pixels from the ray's start at which its line enters and leaves a cell, limited to the drawing;
    /// `count` cells cover the screen.
    fn span(&self, cell: Vec2, count: Vec2) -> [f32; 2] {
        let (low, high) = (cell / count * self.pixels, (cell + 1.0) / count * self.pixels);
        let start = self.from.xy() * self.pixels;
        let mut span = [0.0, self.length];
        for axis in 0..2 {
            if self.along[axis].abs() < 1e-6 {
                continue;
            }
            let ends = [low[axis], high[axis]].map(|edge| (edge - start[axis]) / self.along[axis]);
            span[0] = span[0].max(ends[0].min(ends[1]));
            span[1] = span[1].min(ends[0].max(ends[1]));
        }
        span
    }
}

/// Draws the profile: the depth buffer under the ray, the cells that were read, and the points of the ray.
fn draw_profile(svg: &mut Svg, trace: &HiZTrace, chain: &[Level<MinMax>]) {
    let profile = Profile::new(trace, chain);
    let (corner, size) = (Vec2::new(LEFT, TOP), Vec2::new(WIDTH - LEFT - 24.0, PROFILE));
    svg.text(Vec2::new(LEFT, TOP - 12.0), 15.0, "", "From the side: depth over the way on the screen");
    svg.rect(corner, size, r##"fill="#dfe9f3" stroke="#888""##);
    // The depth buffer under the ray: everything behind its surface is closed.
    let finest = &chain[0];
    let bar_count = profile.length.ceil() as usize * 2;
    for n in 0..bar_count {
        let [start, end] = [n, n + 1].map(|n| n as f32 / bar_count as f32 * profile.length);
        let pixel = profile.from.xy() * profile.pixels + profile.along * (0.5 * (start + end));
        let z = finest.at_clamped(pixel.x.max(0.0) as u32, pixel.y.max(0.0) as u32).min;
        let bar_corner = profile.point(start, profile.depth[1]);
        let bar_size = profile.point(end, z) - bar_corner + Vec2::new(0.4, 0.0);
        svg.rect(bar_corner, bar_size, r##"fill="#9a9a9a""##);
    }
    for step in &trace.steps {
        draw_cell(svg, &profile, step);
    }
    // The ray itself, and a point where each iteration left it.
    let drawn = |ray: Vec3| profile.point(profile.distance(ray.xy()), ray.z);
    let points = [trace.from, trace.entered].into_iter().chain(trace.steps.iter().map(|s| s.ray));
    svg.polyline(points.map(drawn), r##"fill="none" stroke="#111" stroke-width="1.6""##);
    for (n, step) in trace.steps.iter().enumerate() {
        let point = drawn(step.ray);
        svg.circle(
            point,
            Vec2::splat(3.2),
            &format!(r##"fill="{}" stroke="#111" stroke-width="0.6""##, level_color(step.level)),
        );
        // A number is left out if its point is so near to the point before that it would cover the number there.
        let is_crowded = n > 0 && drawn(trace.steps[n - 1].ray).distance(point) < 9.0;
        if !is_crowded {
            svg.text(point + Vec2::new(4.0, 13.0), 10.0, "", &(n + 1).to_string());
        }
    }
    // The depths at the lower and at the upper border.
    for z in profile.depth {
        let position = profile.point(0.0, z) + Vec2::new(-6.0, if z == profile.depth[0] { 0.0 } else { 10.0 });
        svg.text(position, 12.0, r#"text-anchor="end""#, &depth_text(z));
    }
    let foot = TOP + PROFILE + 18.0;
    svg.text(Vec2::new(LEFT, foot), 12.0, "", "the pixel");
    let right = Vec2::new(WIDTH - 24.0, foot);
    svg.text(right, 12.0, r#"text-anchor="end""#, &format!("{:.0} pixels on", profile.length));
    let note = "Dark: the depth buffer. Frames: the cells that were read, from their minimum depth on, coloured by level; \
                points: where";
    svg.text(Vec2::new(LEFT, foot + 18.0), 12.0, "", note);
    let note = "each iteration left the ray, numbered.";
    svg.text(Vec2::new(LEFT, foot + 34.0), 12.0, "", note);
}

/// Draws the cell that the iteration `step` read, from its minimum depth to the greatest depth of the profile. Nothing
/// is drawn if the ray's line misses the cell.
fn draw_cell(svg: &mut Svg, profile: &Profile, step: &Step) {
    let [enters, leaves] = profile.span(step.cell, step.cell_count);
    if leaves <= enters {
        return;
    }
    let corner = profile.point(enters, profile.depth[1]);
    let size = profile.point(leaves, step.minimum_plane) - corner;
    let color = level_color(step.level);
    let attributes = format!(r#"fill="{color}" fill-opacity="0.12" stroke="{color}" stroke-width="1.4""#);
    svg.rect(corner, size.max(Vec2::ZERO), &attributes);
}

/// Draws a plot of the level that each iteration reads; `corner` is its upper left corner.
fn draw_levels(svg: &mut Svg, trace: &HiZTrace, corner: Vec2) {
    let most = trace.steps.iter().map(|s| s.level).max().unwrap_or(0).max(1);
    let size = Vec2::new(0.5 * WIDTH - 60.0, LOWER - 40.0);
    svg.text(corner + Vec2::new(0.0, -12.0), 15.0, "", "Level that each iteration reads");
    svg.rect(corner, size, r##"fill="none" stroke="#888""##);
    let step = size.x / trace.steps.len().max(1) as f32;
    let place = |n: usize, level: u32| {
        corner + Vec2::new((n as f32 + 0.5) * step, size.y * (0.94 - 0.86 * level as f32 / most as f32))
    };
    for level in 0..=most {
        let start = Vec2::new(corner.x, place(0, level).y);
        svg.line(start, start + Vec2::new(size.x, 0.0), r##"stroke="#ddd""##);
        svg.text(start + Vec2::new(-8.0, 4.0), 12.0, r#"text-anchor="end""#, &level.to_string());
    }
    let points = trace.steps.iter().enumerate().map(|(n, s)| place(n, s.level));
    svg.polyline(points, r##"fill="none" stroke="#111""##);
    for (n, s) in trace.steps.iter().enumerate() {
        svg.circle(place(n, s.level), Vec2::splat(3.6), &format!(r#"fill="{}""#, level_color(s.level)));
    }
    let last = trace.steps.len();
    let foot = corner.y + size.y + 18.0;
    svg.text(Vec2::new(corner.x, foot), 12.0, "", "iteration 1");
    svg.text(Vec2::new(corner.x + size.x, foot), 12.0, r#"text-anchor="end""#, &last.to_string());
}

/// Draws the cells that were read, and the ray, where they lie on the screen; `corner` is the screen's upper left
/// corner in the drawing.
fn draw_screen(svg: &mut Svg, trace: &HiZTrace, chain: &[Level<MinMax>], corner: Vec2) {
    let pixels = Vec2::new(chain[0].width as f32, chain[0].height as f32);
    let room = Vec2::new(WIDTH - corner.x - 24.0, LOWER - 40.0);
    let scale = (room / pixels).min_element();
    svg.text(
        corner + Vec2::new(0.0, -12.0),
        15.0,
        "",
        &format!("On the screen ({} × {}): from dark to white", pixels.x, pixels.y),
    );
    svg.rect(corner, pixels * scale, r##"fill="#f4f4f4" stroke="#888""##);
    // Coarse cells come first, or they would hide fine cells.
    let mut cells: Vec<&Step> = trace.steps.iter().collect();
    cells.sort_by_key(|s| std::cmp::Reverse(s.level));
    for step in cells {
        let size = pixels / step.cell_count * scale;
        let color = level_color(step.level);
        let attributes = format!(r#"fill="{color}" fill-opacity="0.25" stroke="{color}""#);
        svg.rect(corner + step.cell * size, size, &attributes);
    }
    let place = |r: Vec3| corner + r.xy() * pixels * scale;
    svg.line(place(trace.from), place(trace.last()), r##"stroke="#111" stroke-width="1.4""##);
    svg.circle(place(trace.from), Vec2::splat(3.0), r##"fill="#111""##);
    svg.circle(place(trace.last()), Vec2::splat(3.0), r##"fill="#fff" stroke="#111""##);
}

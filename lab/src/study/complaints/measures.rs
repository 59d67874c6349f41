//! The numbers that measure complaints: how far a variant's images, or their changes from frame to frame, differ from
//! the true reflection over a region. In these functions `frames` or `film` has the frames of a case, and `variant` is
//! the index of a variant.

use super::frames::SeenFrame;
use glam::{DVec3, Vec3};
use ssct_truth::metrics::flicker::{self, finite_or_black};

/// Threshold on the difference of two linear colours, root mean square over the channels, above which a pixel is wrong.
pub const WRONG: f32 = 0.1;

/// A function that says whether a pixel, given by its index in a frame, belongs to the region of a measure.
pub type Region = fn(&SeenFrame, usize) -> bool;

impl SeenFrame {
    /// Returns the width of the image in pixels.
    fn width(&self) -> usize {
        self.screen.width as usize
    }

    /// Returns the reflecting pixels within `reach` pixels of a pixel along each axis, including the pixel itself.
    fn reflecting_around(&self, pixel: usize, reach: usize) -> impl Iterator<Item = usize> + '_ {
        self.pixels_around(pixel, reach).filter(|i| self.screen.reflects(*i))
    }

    /// Returns all pixels within `reach` pixels of a pixel along each axis, including the pixel itself.
    fn pixels_around(&self, pixel: usize, reach: usize) -> impl Iterator<Item = usize> + '_ {
        let (x, y) = (pixel % self.width(), pixel / self.width());
        let within = |position: usize, side: usize| position.saturating_sub(reach)..=(position + reach).min(side - 1);
        let columns = within(x, self.width());
        let rows = within(y, self.screen.height as usize);
        rows.flat_map(move |y| columns.clone().map(move |x| y * self.width() + x))
    }

    /// Whether the mirror rays of all reflecting pixels within `reach` pixels of a pixel end on the mesh where its own
    /// ends.
    pub fn is_alike_around(&self, pixel: usize, reach: usize) -> bool {
        self.reflecting_around(pixel, reach).all(|i| self.end_meshes[i] == self.end_meshes[pixel])
    }

    /// Returns the place of a reflecting pixel's surface in the world, in metres; the origin for any other pixel.
    pub fn place(&self, pixel: usize) -> DVec3 {
        self.places[pixel].unwrap_or_default()
    }

    /// Returns the indices of the reflecting pixels of a region.
    pub fn pixels(&self, region: Region) -> impl Iterator<Item = usize> + '_ {
        (0..self.truth.len()).filter(move |i| self.screen.reflects(*i) && region(self, *i))
    }
}

/// Selects all reflecting pixels.
pub fn everywhere(_: &SeenFrame, _: usize) -> bool {
    true
}

/// Selects reflecting pixels that show no edge: the mirror rays of the pixel and its reflecting neighbours end on one
/// mesh.
pub fn no_edge(seen: &SeenFrame, pixel: usize) -> bool {
    seen.is_alike_around(pixel, 1)
}

/// Selects reflecting pixels within a twelfth of the image's width of a surface close to the camera.
pub fn near_close_surface(seen: &SeenFrame, pixel: usize) -> bool {
    // A reversed depth is about the near plane's distance divided by the view depth, if the far plane is far.
    let near = seen.screen.camera.lens.near_m;
    seen.pixels_around(pixel, seen.width() / 12).any(|i| seen.screen.depth[i] > near / CLOSE_M)
}

/// Distance in metres below which a surface is close to the camera.
const CLOSE_M: f32 = 2.0;

/// Selects reflecting pixels that show no edge, and whose mirror ray ends at a point that the screen shows.
pub fn no_edge_and_shown(seen: &SeenFrame, pixel: usize) -> bool {
    no_edge(seen, pixel) && seen.end_is_shown[pixel]
}

/// Whether two colours differ by more than [`WRONG`], or their difference is NaN.
fn is_wrong(a: Vec3, b: Vec3) -> bool {
    let difference = ((a - b).length_squared() / 3.0).sqrt();
    difference.is_nan() || difference > WRONG
}

/// Returns the percentage of items that are true; 0 without items.
fn percent(items: impl Iterator<Item = bool>) -> f64 {
    let (mut count, mut count_true) = (0_u32, 0_u32);
    for is_true in items {
        count += 1;
        count_true += u32::from(is_true);
    }
    if count == 0 { 0.0 } else { 100.0 * f64::from(count_true) / f64::from(count) }
}

/// Returns the percentage of a region's reflecting pixels whose colour is wrong in a frame.
pub fn percent_wrong(seen: &SeenFrame, variant: usize, region: Region) -> f64 {
    percent(seen.pixels(region).map(|i| is_wrong(seen.reflections[variant][i], seen.truth[i])))
}

/// Returns the percentage of a region's pixels that are wrong in the last frame.
pub fn percent_wrong_at_last(frames: &[SeenFrame], variant: usize, region: Region) -> f64 {
    frames.last().map_or(0.0, |seen| percent_wrong(seen, variant, region))
}

/// Returns the difference between the greatest and the least of some numbers, which must be at least 0.
fn spread(values: impl Iterator<Item = f64> + Clone) -> f64 {
    values.clone().fold(0.0, f64::max) - values.fold(f64::INFINITY, f64::min)
}

/// Returns the percentage of a region's pixels that are wrong in the worst frame, minus the percentage in the best
/// frame.
pub fn spread_of_wrong(frames: &[SeenFrame], variant: usize, region: Region) -> f64 {
    spread(frames.iter().map(|seen| percent_wrong(seen, variant, region)))
}

/// Returns the percentage of a region's pixels whose colour differs from their colour in the first frame by more than
/// [`WRONG`], in the later frame in which most do. All frames have one size, so that a pixel has one index in all of
/// them.
pub fn changed_from_first(frames: &[SeenFrame], variant: usize, region: Region) -> f64 {
    let percentage = |seen: &SeenFrame| {
        let first = &frames[0].reflections[variant];
        percent(seen.pixels(region).map(|i| is_wrong(seen.reflections[variant][i], first[i])))
    };
    frames.iter().skip(1).map(percentage).fold(0.0, f64::max)
}

/// Returns the root mean square error over a region in the last frame, in percent of the root mean square of the true
/// reflection there.
pub fn error_at_last(frames: &[SeenFrame], variant: usize, region: Region) -> f64 {
    let Some(seen) = frames.last() else { return 0.0 };
    let square = |v: Vec3| f64::from(v.length_squared());
    let error: f64 =
        seen.pixels(region).map(|i| square(finite_or_black(seen.reflections[variant][i]) - seen.truth[i])).sum();
    let truth: f64 = seen.pixels(region).map(|i| square(seen.truth[i])).sum();
    if truth == 0.0 { 0.0 } else { 100.0 * (error / truth).sqrt() }
}

/// Returns how much redder the given pixels are than in the true reflection, in percent of the redness of `color`. The
/// redness of a colour is its red minus its green. The result is the mean over the pixels; a pixel that is less red
/// counts as 0.
pub fn excess_of_red(seen: &SeenFrame, variant: usize, pixels: impl Iterator<Item = usize>, color: Vec3) -> f64 {
    let redness = |color: Vec3| f64::from(color.x - color.y);
    let (mut sum, mut count) = (0.0, 0_u32);
    for i in pixels {
        sum += (redness(finite_or_black(seen.reflections[variant][i])) - redness(seen.truth[i])).max(0.0);
        count += 1;
    }
    if count == 0 { 0.0 } else { 100.0 * sum / (f64::from(count) * redness(color)) }
}

/// A function that computes differences of colour, second image minus first. Its arguments are two frames, and their
/// two images by one variant or by the truth.
pub type Changes = fn([&SeenFrame; 2], [&[Vec3]; 2]) -> Vec<Vec3>;

/// Returns the change of each pixel that reflects in both frames, which have one size.
pub fn pixel_changes([before, now]: [&SeenFrame; 2], images: [&[Vec3]; 2]) -> Vec<Vec3> {
    let both = now.pixels(everywhere).filter(|i| before.screen.reflects(*i));
    both.map(|i| finite_or_black(images[1][i]) - finite_or_black(images[0][i])).collect()
}

/// Columns and rows of the grid on which frames of several sizes are compared.
const GRID: [usize; 2] = [60, 34];

/// Returns the change of the mean colour of each cell of a grid over the image, so that frames may differ in size.
/// Cells without reflecting pixels in one of the frames are left out.
pub fn cell_changes(frames: [&SeenFrame; 2], images: [&[Vec3]; 2]) -> Vec<Vec3> {
    let [before, now] = [0, 1].map(|side| cell_means(frames[side], images[side]));
    before.into_iter().zip(now).filter_map(|(before, now)| Some(now? - before?)).collect()
}

/// Returns the mean colour of the reflecting pixels in each cell of the grid, row by row; `None` for a cell without
/// any.
fn cell_means(seen: &SeenFrame, image: &[Vec3]) -> Vec<Option<Vec3>> {
    let mut sums = vec![(Vec3::ZERO, 0.0_f32); GRID[0] * GRID[1]];
    let [width, height] = [seen.width(), seen.screen.height as usize];
    for i in seen.pixels(everywhere) {
        let [column, row] = [GRID[0] * (i % width) / width, GRID[1] * (i / width) / height];
        let (sum, count) = &mut sums[row * GRID[0] + column];
        *sum += finite_or_black(image[i]);
        *count += 1.0;
    }
    sums.into_iter().map(|(sum, count)| (count > 0.0).then(|| sum / count)).collect()
}

/// Sums over the pairs of consecutive frames of a film.
#[derive(Default)]
struct ChangeSums {
    /// Sum of the mean absolute differences between the method's changes and the true changes.
    error: f64,
    /// Sum of the mean absolute values of the true changes.
    true_change: f64,
    /// Sum of the mean colours of the true reflection.
    true_light: f64,
    /// Sum of the mean colours of the method's reflection.
    method_light: f64,
}

impl ChangeSums {
    /// Computes the sums of a variant's film; `changes` finds the changes between two consecutive frames.
    fn over_frames(film: &[SeenFrame], variant: usize, changes: Changes) -> Self {
        let mut sums = Self::default();
        for pair in film.windows(2) {
            let frames = [&pair[0], &pair[1]];
            let method_changes = changes(frames, frames.map(|seen| &seen.reflections[variant][..]));
            let true_changes = changes(frames, frames.map(|seen| &seen.truth[..]));
            sums.error += flicker::mean(&method_changes, |index, change| change - true_changes[index]);
            sums.true_change += flicker::mean(&true_changes, |_, change| change);
            let now = &pair[1];
            let light = |image: &[Vec3]| {
                let colors: Vec<Vec3> = now.pixels(everywhere).map(|i| finite_or_black(image[i])).collect();
                flicker::mean(&colors, |_, color| color)
            };
            sums.true_light += light(&now.truth);
            sums.method_light += light(&now.reflections[variant]);
        }
        sums
    }

    /// Returns how far the method's changes differ from the true changes, in percent of the sum `whole`. `None` if
    /// `whole` is 0, or if the method shows less than half of the true light: a missing reflection never flickers.
    fn percent_of(&self, whole: f64) -> Option<f64> {
        let shows_enough = self.method_light >= 0.5 * self.true_light;
        (whole > 0.0 && shows_enough).then_some(100.0 * self.error / whole)
    }
}

/// Returns how far changes from frame to frame differ from the true changes: the mean absolute difference over changes
/// and channels, in percent of the mean absolute true change.
pub fn change_error(film: &[SeenFrame], variant: usize, changes: Changes) -> Option<f64> {
    let sums = ChangeSums::over_frames(film, variant, changes);
    sums.percent_of(sums.true_change)
}

/// Returns how far changes from frame to frame differ from the true changes, in percent of the true mean colour. This
/// is for films whose true reflection hardly changes, so that the changes themselves are no scale.
pub fn change_error_at_rest(film: &[SeenFrame], variant: usize, changes: Changes) -> Option<f64> {
    let sums = ChangeSums::over_frames(film, variant, changes);
    sums.percent_of(sums.true_light)
}

/// Greatest channel of a colour that counts as black.
const BLACK: f32 = 0.02;

/// Returns the percentage of a region's pixels, in the worst frame, that are NaN, infinite or black where the true
/// reflection is so bright that black would be wrong.
pub fn blackened(frames: &[SeenFrame], variant: usize, region: Region) -> f64 {
    let is_black = |color: Vec3| !(color.is_finite() && color.max_element() > BLACK);
    let percentage = |seen: &SeenFrame| {
        percent(
            seen.pixels(region).map(|i| is_black(seen.reflections[variant][i]) && is_wrong(Vec3::ZERO, seen.truth[i])),
        )
    };
    frames.iter().map(percentage).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ssct_scenes::{Camera, GBufferData, Lens, Surface};

    /// Makes a frame of 4×2 reflecting pixels, with a true reflection and the reflection by one variant, both grey.
    fn grey_frame(truth: [f32; 8], reflection: [f32; 8]) -> SeenFrame {
        let colors = |values: [f32; 8]| values.map(Vec3::splat).to_vec();
        let screen = GBufferData {
            width: 4,
            height: 2,
            camera: Camera::new(Vec3::ZERO, Vec3::Z, Lens::default(), 2.0),
            depth: vec![0.01; 8],
            normal: vec![Vec3::NEG_Z; 8],
            reflectivity: vec![1.0; 8],
            roughness: vec![0.0; 8],
            color: vec![Vec3::ZERO; 8],
            surface: vec![Surface::Lit; 8],
        };
        let end_meshes = ["a", "a", "a", "b"].repeat(2).into_iter().map(str::to_owned).collect();
        SeenFrame {
            screen,
            truth: colors(truth),
            end_meshes,
            end_is_shown: vec![true; 8],
            places: vec![None; 8],
            reflections: vec![colors(reflection)],
        }
    }

    /// A reflection that is 0.5 in each pixel.
    const HALF: [f32; 8] = [0.5; 8];
    /// A reflection that is wrong in two pixels of eight, if `HALF` is the truth.
    const TWO_WRONG: [f32; 8] = [0.5, 0.5, 0.5, 0.7, 0.5, 0.5, f32::NAN, 0.59];

    #[test]
    fn wrong_pixels_are_those_that_differ_or_are_no_number() {
        assert_eq!(percent_wrong(&grey_frame(HALF, HALF), 0, everywhere), 0.0);
        assert_eq!(percent_wrong(&grey_frame(HALF, TWO_WRONG), 0, everywhere), 25.0);
        // The pixels of the third and the fourth column show an edge.
        assert_eq!(percent_wrong(&grey_frame(HALF, TWO_WRONG), 0, no_edge), 0.0);
        assert_eq!(spread_of_wrong(&[grey_frame(HALF, TWO_WRONG), grey_frame(HALF, HALF)], 0, everywhere), 25.0);
    }

    #[test]
    fn later_frames_are_compared_with_the_first() {
        let frame = |reflection| grey_frame(HALF, reflection);
        assert_eq!(changed_from_first(&[frame(HALF), frame(HALF)], 0, everywhere), 0.0);
        assert_eq!(changed_from_first(&[frame(TWO_WRONG), frame(HALF), frame(TWO_WRONG)], 0, everywhere), 25.0);
    }

    #[test]
    fn an_error_is_a_share_of_the_truth_and_an_excess_counts_only_redder_pixels() {
        let error = error_at_last(&[grey_frame(HALF, [0.25; 8])], 0, everywhere);
        assert!((error - 50.0).abs() < 1e-4, "{error}");
        let mut red = grey_frame(HALF, HALF);
        red.reflections[0][2] = Vec3::new(0.5, 0.1, 0.5);
        red.reflections[0][3] = Vec3::new(0.1, 0.5, 0.5);
        let excess = excess_of_red(&red, 0, 0..4, Vec3::X);
        assert!((excess - 10.0).abs() < 1e-4, "0.4 in one of four: {excess}");
    }

    #[test]
    fn black_and_infinite_pixels_and_nans_count_unless_the_truth_is_black() {
        let reflection = [0.0, f32::NAN, f32::INFINITY, 0.5, 0.5, 0.5, 0.5, 0.0];
        let truth = [0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.0];
        assert_eq!(blackened(&[grey_frame(truth, reflection), grey_frame(HALF, HALF)], 0, everywhere), 37.5);
    }

    #[test]
    fn changes_are_compared_with_true_changes_and_an_absent_reflection_has_no_number() {
        let film =
            |reflections: [[f32; 8]; 2]| [grey_frame([0.4; 8], reflections[0]), grey_frame([0.5; 8], reflections[1])];
        let change = |reflections| change_error(&film(reflections), 0, pixel_changes);
        assert_eq!(change([[0.4; 8], [0.5; 8]]), Some(0.0));
        let shaking = change([[0.4; 8], [0.7; 8]]).unwrap();
        assert!((shaking - 200.0).abs() < 1e-3, "0.3 where 0.1 is right: {shaking}");
        assert_eq!(change([[0.0; 8]; 2]), None, "nothing never flickers");
        let at_rest = change_error_at_rest(&film([[0.4; 8], [0.6; 8]]), 0, cell_changes).unwrap();
        assert!((at_rest - 20.0).abs() < 1e-3, "0.1 of 0.5: {at_rest}");
    }
}

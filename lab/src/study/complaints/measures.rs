//! The numbers that measure complaints: how far a variant's images, or their changes from frame to frame, differ from
//! the true reflection over a region. In these functions `all` has the frames of a case, and `variant` is the index of
//! a variant.

use super::frames::SeenFrame;
use glam::{DVec3, Vec3};
use ssct_truth::metrics::flicker::{self, sound};

/// Threshold on the difference of two linear colours, root mean square over the channels, above which a pixel is wrong.
pub const WRONG: f32 = 0.1;

/// A function that says whether a pixel, given by its index in a frame, belongs to the region of a measure.
pub type Region = fn(&SeenFrame, usize) -> bool;

impl SeenFrame {
    /// Width of the image in pixels.
    fn width(&self) -> usize {
        self.screen.width as usize
    }

    /// Returns the reflecting pixels within `reach` pixels of a pixel along each axis, including the pixel itself.
    fn around(&self, pixel: usize, reach: usize) -> impl Iterator<Item = usize> + '_ {
        self.all_around(pixel, reach).filter(|i| self.screen.reflects(*i))
    }

    /// Returns all pixels within `reach` pixels of a pixel along each axis, including the pixel itself.
    fn all_around(&self, pixel: usize, reach: usize) -> impl Iterator<Item = usize> + '_ {
        let (x, y) = (pixel % self.width(), pixel / self.width());
        let within = |position: usize, side: usize| position.saturating_sub(reach)..=(position + reach).min(side - 1);
        let columns = within(x, self.width());
        let rows = within(y, self.screen.height as usize);
        rows.flat_map(move |y| columns.clone().map(move |x| y * self.width() + x))
    }

    /// Whether the pixel shows no edge: the mirror rays of the pixel and its reflecting neighbours end on one mesh.
    pub fn is_inner(&self, pixel: usize) -> bool {
        self.is_alike_around(pixel, 1)
    }

    /// Whether the mirror rays of all reflecting pixels within `reach` pixels of a pixel end on the mesh where its own
    /// ends.
    pub fn is_alike_around(&self, pixel: usize, reach: usize) -> bool {
        self.around(pixel, reach).all(|i| self.ends[i] == self.ends[pixel])
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

/// Selects reflecting pixels that show no edge.
pub fn inner(seen: &SeenFrame, pixel: usize) -> bool {
    seen.is_inner(pixel)
}

/// Selects reflecting pixels within a twelfth of the image's width of a surface close to the camera.
pub fn beside_what_is_close(seen: &SeenFrame, pixel: usize) -> bool {
    // A reversed depth is about the near plane's distance divided by the view depth, if the far plane is far.
    let near = seen.screen.camera.lens.near_m;
    seen.all_around(pixel, seen.width() / 12).any(|i| seen.screen.depth[i] > near / CLOSE_M)
}

/// Distance in metres below which a surface is close to the camera.
const CLOSE_M: f32 = 2.0;

/// Selects reflecting pixels that show no edge, and whose mirror ray ends at a point that the screen shows.
pub fn inner_and_shown(seen: &SeenFrame, pixel: usize) -> bool {
    seen.is_inner(pixel) && seen.shown[pixel]
}

/// Whether two colours differ by more than [`WRONG`], or their difference is NaN.
fn is_wrong(a: Vec3, b: Vec3) -> bool {
    let difference = ((a - b).length_squared() / 3.0).sqrt();
    difference.is_nan() || difference > WRONG
}

/// Returns the percentage of items that are true; 0 without items.
fn percent(items: impl Iterator<Item = bool>) -> f64 {
    let (counted, all) = items.fold((0, 0), |(counted, all), is_true| (counted + usize::from(is_true), all + 1));
    if all == 0 { 0.0 } else { 100.0 * f64::from(counted as u32) / f64::from(all) }
}

/// Returns the percentage of a region's reflecting pixels whose colour is wrong in a frame.
pub fn wrong(seen: &SeenFrame, variant: usize, region: Region) -> f64 {
    wrong_of(seen, variant, seen.pixels(region))
}

/// Returns the percentage of the given pixels, by their indices, whose colour is wrong in a frame.
pub fn wrong_of(seen: &SeenFrame, variant: usize, pixels: impl Iterator<Item = usize>) -> f64 {
    percent(pixels.map(|i| is_wrong(seen.made[variant][i], seen.truth[i])))
}

/// Returns the percentage of a region's pixels that are wrong in the last frame.
pub fn wrong_at_last(all: &[SeenFrame], variant: usize, region: Region) -> f64 {
    all.last().map_or(0.0, |seen| wrong(seen, variant, region))
}

/// Returns the difference between the greatest and the least of some numbers, which must be at least 0.
fn spread(values: impl Iterator<Item = f64> + Clone) -> f64 {
    values.clone().fold(0.0, f64::max) - values.fold(f64::INFINITY, f64::min)
}

/// Returns the percentage of a region's pixels that are wrong in the worst frame, minus the percentage in the best
/// frame.
pub fn spread_of_wrong(all: &[SeenFrame], variant: usize, region: Region) -> f64 {
    spread(all.iter().map(|seen| wrong(seen, variant, region)))
}

/// Returns the percentage of a region's pixels whose colour differs from their colour in the first frame by more than
/// [`WRONG`], in the later frame in which most do. All frames have one size, so that a pixel has one index in all of
/// them.
pub fn differing(all: &[SeenFrame], variant: usize, region: Region) -> f64 {
    let percentage = |seen: &SeenFrame| {
        let first = &all[0].made[variant];
        percent(seen.pixels(region).map(|i| is_wrong(seen.made[variant][i], first[i])))
    };
    all.iter().skip(1).map(percentage).fold(0.0, f64::max)
}

/// Returns the root mean square error over a region in the last frame, in percent of the root mean square of the true
/// reflection there.
pub fn error_at_last(all: &[SeenFrame], variant: usize, region: Region) -> f64 {
    let Some(seen) = all.last() else { return 0.0 };
    let square = |v: Vec3| f64::from(v.length_squared());
    let error: f64 = seen.pixels(region).map(|i| square(sound(seen.made[variant][i]) - seen.truth[i])).sum();
    let truth: f64 = seen.pixels(region).map(|i| square(seen.truth[i])).sum();
    if truth == 0.0 { 0.0 } else { 100.0 * (error / truth).sqrt() }
}

/// Returns how much redder the given pixels are than in the true reflection, in percent of the redness of `color`. The
/// redness of a colour is its red minus its green. The result is the mean over the pixels; a pixel that is less red
/// counts as 0.
pub fn excess(seen: &SeenFrame, variant: usize, pixels: impl Iterator<Item = usize>, color: Vec3) -> f64 {
    let redness = |color: Vec3| f64::from(color.x - color.y);
    let (mut sum, mut count) = (0.0, 0_u32);
    for i in pixels {
        sum += (redness(sound(seen.made[variant][i])) - redness(seen.truth[i])).max(0.0);
        count += 1;
    }
    if count == 0 { 0.0 } else { 100.0 * sum / (f64::from(count) * redness(color)) }
}

/// A function that computes differences of colour, second image minus first. Its arguments are two frames, and their
/// two images by one variant or by the truth.
pub type Changes = fn([&SeenFrame; 2], [&[Vec3]; 2]) -> Vec<Vec3>;

/// Returns the change of each pixel that reflects in both frames, which have one size.
pub fn of_pixels([before, now]: [&SeenFrame; 2], images: [&[Vec3]; 2]) -> Vec<Vec3> {
    let both = now.pixels(everywhere).filter(|i| before.screen.reflects(*i));
    both.map(|i| sound(images[1][i]) - sound(images[0][i])).collect()
}

/// Columns and rows of the grid on which frames of several sizes are compared.
const GRID: [usize; 2] = [60, 34];

/// Returns the change of the mean colour of each cell of a grid over the image, so that frames may differ in size.
/// Cells without reflecting pixels in one of the frames are left out.
pub fn of_cells(frames: [&SeenFrame; 2], images: [&[Vec3]; 2]) -> Vec<Vec3> {
    let [before, now] = [0, 1].map(|n| means(frames[n], images[n]));
    before.into_iter().zip(now).filter_map(|(before, now)| Some(now? - before?)).collect()
}

/// Returns the mean colour of the reflecting pixels in each cell of the grid, row by row; `None` for a cell without
/// any.
fn means(seen: &SeenFrame, image: &[Vec3]) -> Vec<Option<Vec3>> {
    let mut sums = vec![(Vec3::ZERO, 0.0_f32); GRID[0] * GRID[1]];
    let [width, height] = [seen.width(), seen.screen.height as usize];
    for i in seen.pixels(everywhere) {
        let [column, row] = [GRID[0] * (i % width) / width, GRID[1] * (i / width) / height];
        let (sum, count) = &mut sums[row * GRID[0] + column];
        *sum += sound(image[i]);
        *count += 1.0;
    }
    sums.into_iter().map(|(sum, count)| (count > 0.0).then(|| sum / count)).collect()
}

/// Sums over the pairs of consecutive frames of a film.
#[derive(Default)]
struct ChangeSums {
    /// Sum of the mean absolute differences between the method's changes and the true changes.
    off: f64,
    /// Sum of the mean absolute values of the true changes.
    own: f64,
    /// Sums of the mean colours of the true reflection, and of the method's reflection.
    bright: [f64; 2],
}

impl ChangeSums {
    /// Computes the sums of a variant's film; `changes` finds the changes between two consecutive frames.
    fn over_frames(all: &[SeenFrame], variant: usize, changes: Changes) -> Self {
        let mut sums = Self::default();
        for pair in all.windows(2) {
            let frames = [&pair[0], &pair[1]];
            let made_changes = changes(frames, frames.map(|seen| &seen.made[variant][..]));
            let true_changes = changes(frames, frames.map(|seen| &seen.truth[..]));
            sums.off += flicker::mean(&made_changes, |n, change| change - true_changes[n]);
            sums.own += flicker::mean(&true_changes, |_, change| change);
            for (sum, image) in sums.bright.iter_mut().zip([&pair[1].truth, &pair[1].made[variant]]) {
                let colors: Vec<Vec3> = pair[1].pixels(everywhere).map(|i| sound(image[i])).collect();
                *sum += flicker::mean(&colors, |_, color| color);
            }
        }
        sums
    }

    /// Returns how far the method's changes are off the true changes, in percent of the sum `whole`. `None` if `whole`
    /// is 0, or if the method shows less than half of the true light, since a missing reflection never flickers.
    fn percent_of(&self, whole: f64) -> Option<f64> {
        let [true_light, made_light] = self.bright;
        (whole > 0.0 && made_light >= 0.5 * true_light).then_some(100.0 * self.off / whole)
    }
}

/// Returns how far changes from frame to frame differ from the true changes: the mean absolute difference over changes
/// and channels, in percent of the mean absolute true change.
pub fn off_change(all: &[SeenFrame], variant: usize, changes: Changes) -> Option<f64> {
    let sums = ChangeSums::over_frames(all, variant, changes);
    sums.percent_of(sums.own)
}

/// Returns how far changes from frame to frame differ from the true changes, in percent of the true mean colour. This
/// is for films whose true reflection hardly changes, so that the changes themselves are no scale.
pub fn off_change_at_rest(all: &[SeenFrame], variant: usize, changes: Changes) -> Option<f64> {
    let sums = ChangeSums::over_frames(all, variant, changes);
    sums.percent_of(sums.bright[0])
}

/// Greatest channel of a colour that counts as black.
const BLACK: f32 = 0.02;

/// Returns the percentage of a region's pixels, in the worst frame, that are NaN, infinite or black where the true
/// reflection is not dark.
pub fn blackened(all: &[SeenFrame], variant: usize, region: Region) -> f64 {
    let is_black = |color: Vec3| !(color.is_finite() && color.max_element() > BLACK);
    let percentage = |seen: &SeenFrame| {
        percent(seen.pixels(region).map(|i| is_black(seen.made[variant][i]) && !is_dark(seen.truth[i])))
    };
    all.iter().map(percentage).fold(0.0, f64::max)
}

/// Whether a colour of the true reflection is so dark that black in its place would not be wrong.
fn is_dark(truth: Vec3) -> bool {
    !is_wrong(Vec3::ZERO, truth)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ssct_scenes::{Camera, GBufferData, Lens, Surface};

    /// Makes a frame of 4×2 reflecting pixels, with a true reflection and the reflection by one variant, both grey.
    fn seen(truth: [f32; 8], made: [f32; 8]) -> SeenFrame {
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
        let ends = ["a", "a", "a", "b"].repeat(2).into_iter().map(str::to_owned).collect();
        SeenFrame {
            screen,
            truth: colors(truth),
            ends,
            shown: vec![true; 8],
            places: vec![None; 8],
            made: vec![colors(made)],
        }
    }

    /// A reflection that is 0.5 in each pixel.
    const HALF: [f32; 8] = [0.5; 8];
    /// A reflection that is wrong in two pixels of eight, if `HALF` is the truth.
    const OFF: [f32; 8] = [0.5, 0.5, 0.5, 0.7, 0.5, 0.5, f32::NAN, 0.59];

    #[test]
    fn wrong_pixels_are_those_that_differ_or_are_no_number() {
        assert_eq!(wrong(&seen(HALF, HALF), 0, everywhere), 0.0);
        assert_eq!(wrong(&seen(HALF, OFF), 0, everywhere), 25.0);
        // The pixels of the third and the fourth column show an edge.
        assert_eq!(wrong(&seen(HALF, OFF), 0, inner), 0.0);
        assert_eq!(spread_of_wrong(&[seen(HALF, OFF), seen(HALF, HALF)], 0, everywhere), 25.0);
    }

    /// Tests that later frames are compared with the first.
    #[test]
    fn settings_that_must_not_matter_are_held_against_the_first() {
        let frame = |made| seen(HALF, made);
        assert_eq!(differing(&[frame(HALF), frame(HALF)], 0, everywhere), 0.0);
        assert_eq!(differing(&[frame(OFF), frame(HALF), frame(OFF)], 0, everywhere), 25.0);
    }

    /// Tests an error in percent of the truth, and an excess of red, for which pixels that are less red do not count.
    #[test]
    fn an_error_is_relative_and_an_excess_counts_what_is_redder_alone() {
        let error = error_at_last(&[seen(HALF, [0.25; 8])], 0, everywhere);
        assert!((error - 50.0).abs() < 1e-4, "{error}");
        let mut red = seen(HALF, HALF);
        red.made[0][2] = Vec3::new(0.5, 0.1, 0.5);
        red.made[0][3] = Vec3::new(0.1, 0.5, 0.5);
        let excess = excess(&red, 0, 0..4, Vec3::X);
        assert!((excess - 10.0).abs() < 1e-4, "0.4 in one of four: {excess}");
    }

    /// Tests that black, NaN and infinite pixels count unless the true reflection is black.
    #[test]
    fn black_counts_where_the_truth_is_not() {
        let made = [0.0, f32::NAN, f32::INFINITY, 0.5, 0.5, 0.5, 0.5, 0.0];
        let truth = [0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.0];
        assert_eq!(blackened(&[seen(truth, made), seen(HALF, HALF)], 0, everywhere), 37.5);
    }

    /// Tests that changes are compared with the true changes, and that a method that shows nothing has no number.
    #[test]
    fn changes_are_held_against_the_truths_and_nothing_has_none() {
        let film = |made: [[f32; 8]; 2]| [seen([0.4; 8], made[0]), seen([0.5; 8], made[1])];
        let change = |made| off_change(&film(made), 0, of_pixels);
        assert_eq!(change([[0.4; 8], [0.5; 8]]), Some(0.0));
        let shaking = change([[0.4; 8], [0.7; 8]]).unwrap();
        assert!((shaking - 200.0).abs() < 1e-3, "0.3 where 0.1 is right: {shaking}");
        assert_eq!(change([[0.0; 8]; 2]), None, "nothing never flickers");
        let at_rest = off_change_at_rest(&film([[0.4; 8], [0.6; 8]]), 0, of_cells).unwrap();
        assert!((at_rest - 20.0).abs() < 1e-3, "0.1 of 0.5: {at_rest}");
    }
}

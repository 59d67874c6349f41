//! Checks whether the normals of a G-buffer agree with the slopes of its depth.
//!
//! With a wrong lens, wrong axes or a wrong kind of depth, reflections are drawn in wrong places. Each of these
//! mistakes also tilts the slopes, which are computed from depth, but not the normals, which are stored separately.
//! Slopes and normals then disagree. Pixels are compared where the depth is smooth in both directions. Normal maps make
//! single pixels disagree, too; a wrong convention is recognised because another reading of the map makes normals and
//! slopes agree much better.

use crate::{Camera, FieldOfView, GBufferData};
use glam::{DVec2, DVec3};

/// Greatest angle between the normal of a pixel and that of its slope at which the two agree.
const TOLERATED_DEGREES: f64 = 8.0;

/// Angle between normal and slope beyond which they count as unrelated. A normal map tilts normals by less.
const UNRELATED_DEGREES: f64 = 45.0;

/// Greatest mean angle between normals and slopes at which a lens counts as right, so that no other lens is tried.
const RIGHT_DEGREES: f64 = 0.1;

/// Greatest angle that counts in a mean; larger angles count as this one.
const MOST_COUNTED_DEGREES: f64 = 30.0;

/// Greatest number of compared pixels, roughly.
const MOST_SAMPLES: usize = 20_000;

/// Least number of compared pixels for a meaningful comparison.
const FEWEST_SAMPLES: usize = 100;

/// Number of samples in the search for a lens.
const LENS_SAMPLES: usize = 1500;

/// Greatest second difference of depth between a pixel and its neighbours, as a share of the first differences. A pixel
/// with a greater one is not compared, since its depth is not smooth.
const MOST_BEND_SHARE: f64 = 0.1;

/// A point in the image, in normalised device coordinates, and its view-space z in metres.
type ImagePoint = (DVec2, f64);

/// A pixel that is compared: its point in the image, the points of four neighbours, and its view-space normal.
#[derive(Debug, Clone, Copy)]
struct Sample {
    middle: ImagePoint,
    left: ImagePoint,
    right: ImagePoint,
    up: ImagePoint,
    down: ImagePoint,
    normal: DVec3,
}

/// The mapping from view space to the image: ndc = scale · xy / w + shift, where w is z in a perspective and 1 in an
/// orthographic projection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LensMapping {
    scale: DVec2,
    shift: DVec2,
    is_orthographic: bool,
}

impl LensMapping {
    /// Takes scale and shift from the projection matrix of a camera.
    pub(super) fn new(camera: &Camera) -> Self {
        let clip = camera.view_to_clip_reversed().as_dmat4();
        let is_orthographic = camera.kind().is_orthographic();
        let shift = if is_orthographic { clip.w_axis } else { clip.z_axis };
        let scale = DVec2::new(clip.x_axis.x, clip.y_axis.y);
        Self { scale, shift: DVec2::new(shift.x, shift.y), is_orthographic }
    }

    /// Returns the view-space point that a point of the image shows.
    pub(super) fn point(&self, (ndc, z): ImagePoint) -> DVec3 {
        let w = if self.is_orthographic { 1.0 } else { z };
        ((ndc - self.shift) / self.scale * w).extend(z)
    }

    /// Returns the angle, in degrees, between the normal of a pixel and that of the surface through its four
    /// neighbours.
    fn degrees_apart(&self, sample: &Sample) -> f64 {
        let offset = |from: ImagePoint, to: ImagePoint| self.point(to) - self.point(from);
        let slope_normal = offset(sample.left, sample.right).cross(offset(sample.down, sample.up));
        let sight = if self.is_orthographic { DVec3::Z } else { self.point(sample.middle) };
        // The sign selects the side of the surface that the camera sees.
        let sign = if slope_normal.dot(sight) > 0.0 { -1.0 } else { 1.0 };
        (sign * slope_normal).angle_between(sample.normal).to_degrees()
    }
}

/// Returns the view-space z, in metres, of a reversed depth above 0.
pub(super) fn view_z(camera: &Camera, reversed: f64) -> f64 {
    let numbers = camera.projection_numbers();
    numbers.kind.z_at(numbers.depth.map(f64::from), reversed)
}

/// The pixels in which normals are compared with the slopes of depth, and the lens with which points are computed.
#[derive(Debug, Clone)]
pub(super) struct Slopes {
    lens: LensMapping,
    size: [u32; 2],
    samples: Vec<Sample>,
}

impl Slopes {
    /// Collects the pixels of a G-buffer that can be compared; `depth` is reversed, and `normals` are in view space.
    pub(super) fn new(camera: &Camera, size: [u32; 2], depth: &[f32], normals: &[glam::Vec3]) -> Self {
        let [width, height] = size.map(|side| side as usize);
        // Distance of the compared neighbours in pixels. It is greater in large images, so that the rounding of 16-bit
        // depth tilts the slope less.
        let neighbour_px = (width.max(height) / 240).clamp(1, 8);
        let image_point = |x: usize, y: usize| {
            let pixel = y * width + x;
            let reversed = f64::from(depth[pixel]);
            (reversed > 0.0).then(|| (super::pixel_ndc(size, pixel), view_z(camera, reversed)))
        };
        let sample_of_pixel = |x: usize, y: usize| {
            let normal = normals[y * width + x].as_dvec3();
            let middle = image_point(x, y)?;
            let [left, right] = [image_point(x - neighbour_px, y)?, image_point(x + neighbour_px, y)?];
            let [up, down] = [image_point(x, y - neighbour_px)?, image_point(x, y + neighbour_px)?];
            let (_, z) = middle;
            // True if depth is not smooth between two opposite neighbours: an edge, or a strongly curved surface.
            let bends = |(_, z_before): ImagePoint, (_, z_after): ImagePoint| {
                let first_differences = (z_before - z).abs() + (z_after - z).abs();
                let second_difference = (z_before + z_after - 2.0 * z).abs();
                second_difference > MOST_BEND_SHARE * first_differences + 1e-3 * z
            };
            let is_comparable = normal.length() > 1e-3 && !bends(left, right) && !bends(up, down);
            is_comparable.then_some(Sample { middle, left, right, up, down, normal })
        };
        let sample_step = ((width * height / MOST_SAMPLES) as f64).sqrt().ceil().max(1.0) as usize;
        let inner_coordinates = |side: usize| (neighbour_px..side.saturating_sub(neighbour_px)).step_by(sample_step);
        let pixels = inner_coordinates(height).flat_map(|y| inner_coordinates(width).map(move |x| (x, y)));
        let samples = pixels.filter_map(|(x, y)| sample_of_pixel(x, y)).collect();
        Self { lens: LensMapping::new(camera), size, samples }
    }

    /// Collects the pixels of `data` that can be compared.
    pub(super) fn of_data(data: &GBufferData) -> Self {
        Self::new(&data.camera, [data.width, data.height], &data.depth, &data.normal)
    }

    /// Returns the share of the compared pixels that disagree; `None` if too few can be compared.
    pub(super) fn share_disagreeing(&self) -> Option<f64> {
        self.share_beyond(TOLERATED_DEGREES)
    }

    /// Returns the share of the compared pixels whose normals are unrelated to their slopes; `None` if too few can be
    /// compared.
    pub(super) fn share_unrelated(&self) -> Option<f64> {
        self.share_beyond(UNRELATED_DEGREES)
    }

    /// Returns the mean angle between normals and slopes in degrees; an angle counts at most
    /// [`MOST_COUNTED_DEGREES`].
    pub(super) fn mean_degrees(&self) -> f64 {
        mean_degrees(&self.lens, &self.samples)
    }

    /// Returns the share of the compared pixels whose normals and slopes are more than `degrees` apart; `None` for
    /// fewer than [`FEWEST_SAMPLES`] pixels.
    fn share_beyond(&self, degrees: f64) -> Option<f64> {
        let is_within = |sample: &&Sample| self.lens.degrees_apart(sample) <= degrees;
        let within = self.samples.iter().filter(is_within).count();
        (self.samples.len() >= FEWEST_SAMPLES).then(|| 1.0 - within as f64 / self.samples.len() as f64)
    }

    /// Searches for the lens with which normals and slopes agree best. Returns this lens, written as keys and values of
    /// a map, and the comparison with it; `None` if no pixel can be compared.
    pub(super) fn best_lens(&self, camera: &Camera) -> Option<(String, Self)> {
        let samples: Vec<Sample> = {
            let step = (self.samples.len() / LENS_SAMPLES).max(1);
            self.samples.iter().step_by(step).copied().collect()
        };
        let mean_angle_with = |lens: &LensMapping| mean_degrees(lens, &samples);
        let scaled = search_lens(self.lens, &mean_angle_with, &[LensStep::Scale]);
        let stretched = search_lens(self.lens, &mean_angle_with, &[LensStep::Scale, LensStep::Aspect]);
        // A cropped picture is most often one corner of a whole picture. Its shift may be missed by a search that
        // starts without a shift, so that searches start from the four corners, too.
        let shifted = [[0.0, 0.0], [-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]].map(|shift| {
            let start = LensMapping { shift: self.lens.shift + DVec2::from(shift), ..self.lens };
            search_lens(start, &mean_angle_with, &[LensStep::Scale, LensStep::ShiftX, LensStep::ShiftY])
        });
        let mut best = scaled;
        // A lens with steps of more kinds is taken only if it halves the mean angle, and if the best lens so far is not
        // right yet.
        for candidate in [stretched].into_iter().chain(shifted) {
            if mean_angle_with(&best) > RIGHT_DEGREES && mean_angle_with(&candidate) < 0.5 * mean_angle_with(&best) {
                best = candidate;
            }
        }
        (!samples.is_empty()).then(|| (self.lens_keys(camera, &best), Self { lens: best, ..self.clone() }))
    }

    /// Writes a lens as keys and values of a map. The aspect and the shift are left out if they hardly differ from
    /// those of this comparison's lens.
    fn lens_keys(&self, camera: &Camera, lens: &LensMapping) -> String {
        let mut keys = match camera.lens.opening {
            FieldOfView::Height(_) => format!("orthographic-height = {:.3}", 2.0 / lens.scale.y),
            FieldOfView::Angle(_) => format!("fov-y-deg = {:.1}", 2.0 * (1.0 / lens.scale.y).atan().to_degrees()),
        };
        let aspect = lens.scale.y / lens.scale.x;
        if (aspect / (self.lens.scale.y / self.lens.scale.x) - 1.0).abs() > 0.02 {
            keys += &format!(" and aspect = {aspect:.3}");
        }
        let shift_change = lens.shift - self.lens.shift;
        if shift_change.abs().max_element() > 0.02 {
            let [width, height] = self.size.map(f64::from);
            let shift = [0.5 * lens.shift.x * width, -0.5 * lens.shift.y * height];
            keys += &format!(" and shift-px = [{:.0}, {:.0}]", shift[0], shift[1]);
        }
        keys
    }
}

/// Returns the mean angle, in degrees, between normals and slopes with a lens; no angle counts more than
/// [`MOST_COUNTED_DEGREES`].
fn mean_degrees(lens: &LensMapping, samples: &[Sample]) -> f64 {
    let sum: f64 = samples.iter().map(|sample| lens.degrees_apart(sample).min(MOST_COUNTED_DEGREES)).sum();
    sum / samples.len().max(1) as f64
}

/// A kind of step in the search for a lens: the number that changes.
#[derive(Debug, Clone, Copy)]
enum LensStep {
    Scale,
    Aspect,
    ShiftX,
    ShiftY,
}

impl LensStep {
    /// Returns the lens after a step of this kind: a step of 1 multiplies a scale by √2, or shifts by half an image.
    fn apply(self, lens: LensMapping, step: f64) -> LensMapping {
        let factor = 2.0_f64.powf(0.5 * step);
        let LensMapping { mut scale, mut shift, is_orthographic } = lens;
        match self {
            Self::Scale => scale *= factor,
            Self::Aspect => scale.x *= factor,
            Self::ShiftX => shift.x += step,
            Self::ShiftY => shift.y += step,
        }
        LensMapping { scale, shift, is_orthographic }
    }
}

/// Searches for the lens of the least `error`, from `start` by steps of the given kinds. Each round takes the best of
/// all combinations of steps, and halves the steps if no combination is better. Combinations are needed since two
/// steps can compensate each other: each alone raises the error, and only the two together lower it.
fn search_lens(start: LensMapping, error: &impl Fn(&LensMapping) -> f64, kinds: &[LensStep]) -> LensMapping {
    /// Greatest number of rounds, far more than a search that converges takes.
    const MOST_ROUNDS: usize = 60;
    /// The search ends when steps are smaller than this.
    const LEAST_STEP: f64 = 1.0 / 512.0;
    let (mut best, mut least_error) = (start, error(&start));
    let mut step_size = 1.0;
    for _ in 0..MOST_ROUNDS {
        if step_size < LEAST_STEP {
            break;
        }
        // A step of each kind goes back, stays or goes forward: −1, 0 or 1. A combination is a number in base 3, with
        // one digit for each kind.
        let combinations = 3_u32.pow(kinds.len() as u32);
        let direction = |combination: u32, digit: usize| f64::from(combination / 3_u32.pow(digit as u32) % 3) - 1.0;
        let lens_after = |combination: u32| {
            let digits = kinds.iter().enumerate();
            let lens =
                digits.fold(best, |lens, (digit, kind)| kind.apply(lens, step_size * direction(combination, digit)));
            (lens, error(&lens))
        };
        match (0..combinations).map(lens_after).min_by(|(_, a), (_, b)| a.total_cmp(b)) {
            Some((lens, lens_error)) if lens_error < least_error => (best, least_error) = (lens, lens_error),
            _ => step_size *= 0.5,
        }
    }
    best
}

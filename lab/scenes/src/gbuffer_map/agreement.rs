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

/// Angle between normal and slope beyond which they count as unrelated; a normal map tilts normals less.
const GROSS_DEGREES: f64 = 45.0;

/// Greatest mean angle between normals and slopes at which a lens counts as right, so that no other lens is tried.
const RIGHT_DEGREES: f64 = 0.1;

/// Larger angles count as this angle in means.
const MOST_COUNTED_DEGREES: f64 = 30.0;

/// Number of pixels that are compared, at least roughly.
const MOST_SAMPLES: usize = 20_000;

/// Least number of compared pixels for a meaningful comparison.
const FEWEST_SAMPLES: usize = 100;

/// Number of samples in the search for a lens.
const LENS_SAMPLES: usize = 1500;

/// Greatest bend of the depth between a pixel and its neighbours, as a share of the rise. A pixel with a greater bend
/// is not compared.
const MOST_BEND: f64 = 0.1;

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
        let side = if slope_normal.dot(sight) > 0.0 { -1.0 } else { 1.0 };
        (side * slope_normal).angle_between(sample.normal).to_degrees()
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
        // In large images, neighbours at a greater distance are taken. The rounding of 16-bit depth then tilts the
        // slope less.
        let reach = (width.max(height) / 240).clamp(1, 8);
        let image_point = |x: usize, y: usize| {
            let pixel = y * width + x;
            let reversed = f64::from(depth[pixel]);
            (reversed > 0.0).then(|| (super::pixel_ndc(size, pixel), view_z(camera, reversed)))
        };
        let sample = |x: usize, y: usize| {
            let normal = normals[y * width + x].as_dvec3();
            let middle = image_point(x, y)?;
            let [left, right] = [image_point(x - reach, y)?, image_point(x + reach, y)?];
            let [up, down] = [image_point(x, y - reach)?, image_point(x, y + reach)?];
            let (_, z) = middle;
            let bends = |(_, before): ImagePoint, (_, after): ImagePoint| {
                let rise = (before - z).abs() + (after - z).abs();
                (before + after - 2.0 * z).abs() > MOST_BEND * rise + 1e-3 * z
            };
            let is_comparable = normal.length() > 1e-3 && !bends(left, right) && !bends(up, down);
            is_comparable.then_some(Sample { middle, left, right, up, down, normal })
        };
        let step = ((width * height / MOST_SAMPLES) as f64).sqrt().ceil().max(1.0) as usize;
        let inner = |side: usize| (reach..side.saturating_sub(reach)).step_by(step);
        let samples = inner(height).flat_map(|y| inner(width).map(move |x| (x, y)));
        let samples = samples.filter_map(|(x, y)| sample(x, y)).collect();
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
        self.share_beyond(GROSS_DEGREES)
    }

    /// Returns the mean angle between normals and slopes in degrees, in which outliers are limited.
    pub(super) fn mean_degrees(&self) -> f64 {
        mean_degrees(&self.lens, &self.samples)
    }

    /// Returns the share of the compared pixels whose normals and slopes are more than `degrees` apart; `None` for
    /// fewer than [`FEWEST_SAMPLES`] pixels.
    fn share_beyond(&self, degrees: f64) -> Option<f64> {
        let is_near = |sample: &&Sample| self.lens.degrees_apart(sample) <= degrees;
        let near = self.samples.iter().filter(is_near).count();
        (self.samples.len() >= FEWEST_SAMPLES).then(|| 1.0 - near as f64 / self.samples.len() as f64)
    }

    /// Searches for the lens with which normals and slopes agree best. Returns this lens, written as keys and values of
    /// a map, and the comparison with it; `None` if no pixel can be compared.
    pub(super) fn best_lens(&self, camera: &Camera) -> Option<(String, Self)> {
        let samples: Vec<Sample> = {
            let step = (self.samples.len() / LENS_SAMPLES).max(1);
            self.samples.iter().step_by(step).copied().collect()
        };
        let badness = |lens: &LensMapping| mean_degrees(lens, &samples);
        let scaled = search_lens(self.lens, &badness, &[LensStep::Scale]);
        let stretched = search_lens(self.lens, &badness, &[LensStep::Scale, LensStep::Aspect]);
        // A cropped picture is most often one corner of a whole picture. Its shift may be missed by a search that
        // starts without a shift, so that searches start from the four corners, too.
        let shifted = [[0.0, 0.0], [-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]].map(|shift| {
            let start = LensMapping { shift: self.lens.shift + DVec2::from(shift), ..self.lens };
            search_lens(start, &badness, &[LensStep::Scale, LensStep::ShiftX, LensStep::ShiftY])
        });
        let mut best = scaled;
        // A lens with steps of more kinds is taken only if it halves the mean angle, and if the best lens so far is not
        // right yet.
        for other in [stretched].into_iter().chain(shifted) {
            if badness(&best) > RIGHT_DEGREES && badness(&other) < 0.5 * badness(&best) {
                best = other;
            }
        }
        (!samples.is_empty()).then(|| (self.lens_keys(camera, &best), Self { lens: best, ..self.clone() }))
    }

    /// Writes a lens as keys and values of a map. The aspect and the shift are left out if they hardly differ from
    /// those of this comparison's lens.
    fn lens_keys(&self, camera: &Camera, lens: &LensMapping) -> String {
        let mut words = match camera.lens.opening {
            FieldOfView::Height(_) => format!("orthographic-height = {:.3}", 2.0 / lens.scale.y),
            FieldOfView::Angle(_) => format!("fov-y-deg = {:.1}", 2.0 * (1.0 / lens.scale.y).atan().to_degrees()),
        };
        let aspect = lens.scale.y / lens.scale.x;
        if (aspect / (self.lens.scale.y / self.lens.scale.x) - 1.0).abs() > 0.02 {
            words += &format!(" and aspect = {aspect:.3}");
        }
        let shift_change = lens.shift - self.lens.shift;
        if shift_change.abs().max_element() > 0.02 {
            let [width, height] = self.size.map(f64::from);
            let shift = [0.5 * lens.shift.x * width, -0.5 * lens.shift.y * height];
            words += &format!(" and shift-px = [{:.0}, {:.0}]", shift[0], shift[1]);
        }
        words
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

/// Searches for the lens of the least badness, from `start` by steps of the given kinds. Each round takes the best of
/// all combinations of steps, and halves the steps if no combination is better. Combinations are needed since two
/// steps can compensate each other: each alone raises the badness, and only the two together lower it.
fn search_lens(start: LensMapping, badness: &impl Fn(&LensMapping) -> f64, kinds: &[LensStep]) -> LensMapping {
    /// Greatest number of rounds, far more than a search that converges takes.
    const MOST_ROUNDS: usize = 60;
    /// The search ends when steps are smaller than this.
    const LEAST_STEP: f64 = 1.0 / 512.0;
    let (mut best, mut least) = (start, badness(&start));
    let mut size = 1.0;
    for _ in 0..MOST_ROUNDS {
        if size < LEAST_STEP {
            break;
        }
        // A step of each kind goes back, stays or goes forward: −1, 0 or 1. A combination is a number in base 3, with
        // one digit for each kind.
        let combinations = 3_u32.pow(kinds.len() as u32);
        let step = |combination: u32, place: usize| f64::from(combination / 3_u32.pow(place as u32) % 3) - 1.0;
        let stepped = |combination: u32| {
            let steps = kinds.iter().enumerate();
            let lens = steps.fold(best, |lens, (place, kind)| kind.apply(lens, size * step(combination, place)));
            (lens, badness(&lens))
        };
        match (0..combinations).map(stepped).min_by(|(_, a), (_, b)| a.total_cmp(b)) {
            Some((lens, lower)) if lower < least => (best, least) = (lens, lower),
            _ => size *= 0.5,
        }
    }
    best
}

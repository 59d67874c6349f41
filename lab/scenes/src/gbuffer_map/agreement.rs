//! Checks whether the normals of a G-buffer agree with the slopes of its depth.
//!
//! A wrong lens, wrong axes or a wrong kind of depth give a picture whose reflections float. Each of these mistakes
//! also tilts the slopes, which follow from depth, but not the normals, which are stored separately. Slopes and normals
//! then disagree. Pixels are compared where the depth is smooth in both directions. Normal maps make single pixels
//! disagree; a wrong convention is recognised because another reading of the map makes normals and slopes agree much
//! better.

use crate::{Camera, FieldOfView, GBufferData};
use glam::{DVec2, DVec3};

/// Greatest angle between the normal of a pixel and the normal of its slope at which both count as equal.
const TOLERATED_DEGREES: f64 = 8.0;

/// Angle between normal and slope from which both are unrelated, even with a normal map.
const GROSS_DEGREES: f64 = 45.0;

/// Greatest mean angle between normals and slopes at which a lens counts as right, so that no other lens is tried.
const RIGHT_DEGREES: f64 = 0.1;

/// Greatest angle that counts in means; larger angles count as this.
const MOST_COUNTED_DEGREES: f64 = 30.0;

/// Number of pixels that are compared, or little more.
const MOST_SAMPLES: usize = 20_000;

/// Least number of compared pixels for a meaningful comparison.
const FEWEST_SAMPLES: usize = 100;

/// Number of samples in the search for a lens.
const LENS_SAMPLES: usize = 1500;

/// Greatest bend of the depth between a pixel and its neighbours, as a share of the rise. A pixel with a greater bend
/// is not compared.
const MOST_BENT: f64 = 0.1;

/// A place in the image, in normalised device coordinates, with its view-space z.
type ImagePoint = (DVec2, f64);

/// A pixel that is compared: its place, the places of four neighbours, and its view-space normal.
#[derive(Debug, Clone, Copy)]
struct Sample {
    middle: ImagePoint,
    left: ImagePoint,
    right: ImagePoint,
    up: ImagePoint,
    down: ImagePoint,
    normal: DVec3,
}

/// The mapping between image and view space: ndc = scale · xy / w + shift, where w is z in a perspective and 1 in an
/// orthographic projection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LensMapping {
    scale: DVec2,
    shift: DVec2,
    is_orthographic: bool,
}

impl LensMapping {
    /// How a camera maps x and y of view space to its image: a scale and a shift, which a perspective multiplies by z.
    pub(super) fn new(camera: &Camera) -> Self {
        let clip = camera.view_to_clip_reversed().as_dmat4();
        let is_orthographic = camera.kind().is_orthographic();
        let shift = if is_orthographic { clip.w_axis } else { clip.z_axis };
        let scale = DVec2::new(clip.x_axis.x, clip.y_axis.y);
        Self { scale, shift: DVec2::new(shift.x, shift.y), is_orthographic }
    }

    /// The view-space point at a place of the image.
    pub(super) fn point(&self, (ndc, z): ImagePoint) -> DVec3 {
        let w = if self.is_orthographic { 1.0 } else { z };
        ((ndc - self.shift) / self.scale * w).extend(z)
    }

    /// The angle, in degrees, between the normal of a pixel and the normal of the surface through its four neighbours.
    fn degrees_apart(&self, sample: &Sample) -> f64 {
        let along = |a: ImagePoint, b: ImagePoint| self.point(b) - self.point(a);
        let across = along(sample.left, sample.right).cross(along(sample.down, sample.up));
        let sight = if self.is_orthographic { DVec3::Z } else { self.point(sample.middle) };
        // The sign selects the side of the surface that the camera sees.
        let side = if across.dot(sight) > 0.0 { -1.0 } else { 1.0 };
        (side * across).angle_between(sample.normal).to_degrees()
    }
}

/// The view-space z of a reversed depth above 0.
pub(super) fn view_z(camera: &Camera, reversed: f64) -> f64 {
    let numbers = camera.projection_numbers();
    numbers.kind.z_at(numbers.depth.map(f64::from), reversed)
}

/// Compares normals with the slopes of depth.
#[derive(Debug, Clone)]
pub(super) struct Slopes {
    opened: LensMapping,
    size: [u32; 2],
    samples: Vec<Sample>,
}

impl Slopes {
    /// Collects the pixels of a G-buffer that can be compared; `depth` is reversed, and `normals` are in view space.
    pub(super) fn new(camera: &Camera, size: [u32; 2], depth: &[f32], normals: &[glam::Vec3]) -> Self {
        let [width, height] = size.map(|side| side as usize);
        // Farther neighbours keep the rounding of 16-bit depth below the slope in large images.
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
            let bends = |a: ImagePoint, b: ImagePoint| {
                let rise = (a.1 - middle.1).abs() + (b.1 - middle.1).abs();
                (a.1 + b.1 - 2.0 * middle.1).abs() > MOST_BENT * rise + 1e-3 * middle.1
            };
            let usable = normal.length() > 1e-3 && !bends(left, right) && !bends(up, down);
            usable.then_some(Sample { middle, left, right, up, down, normal })
        };
        let step = ((width * height / MOST_SAMPLES) as f64).sqrt().ceil().max(1.0) as usize;
        let inner = |side: usize| (reach..side.saturating_sub(reach)).step_by(step);
        let samples = inner(height).flat_map(|y| inner(width).map(move |x| (x, y)));
        let samples = samples.filter_map(|(x, y)| sample(x, y)).collect();
        Self { opened: LensMapping::new(camera), size, samples }
    }

    /// Collects the pixels of `data` that can be compared.
    pub(super) fn of_data(data: &GBufferData) -> Self {
        Self::new(&data.camera, [data.width, data.height], &data.depth, &data.normal)
    }

    /// The share of the compared pixels that disagree; `None` if too few can be compared.
    pub(super) fn disagreeing(&self) -> Option<f64> {
        self.share_beyond(TOLERATED_DEGREES)
    }

    /// The share of the compared pixels whose normals are unrelated to their slopes; `None` if too few can be compared.
    pub(super) fn unrelated(&self) -> Option<f64> {
        self.share_beyond(GROSS_DEGREES)
    }

    /// The mean angle between normals and slopes in degrees. Far outliers, as in normal maps, count no more than near ones.
    pub(super) fn mean_degrees(&self) -> f64 {
        mean_degrees(&self.opened, &self.samples)
    }

    /// The share of the compared pixels whose normals and slopes are more than `degrees` apart; `None` for fewer than
    /// [`FEWEST_SAMPLES`] pixels.
    fn share_beyond(&self, degrees: f64) -> Option<f64> {
        let is_near = |sample: &&Sample| self.opened.degrees_apart(sample) <= degrees;
        let near = self.samples.iter().filter(is_near).count();
        (self.samples.len() >= FEWEST_SAMPLES).then(|| 1.0 - near as f64 / self.samples.len() as f64)
    }

    /// Searches for the lens with which normals and slopes agree best. Returns this lens, written as keys and values of
    /// a map, and the comparison with it; `None` if no pixel can be compared.
    pub(super) fn best_lens(&self, camera: &Camera) -> Option<(String, Self)> {
        let few: Vec<Sample> = {
            let step = (self.samples.len() / LENS_SAMPLES).max(1);
            self.samples.iter().step_by(step).copied().collect()
        };
        let badness = |opened: &LensMapping| mean_degrees(opened, &few);
        let same_pixels = search(self.opened, &badness, &[LensChange::Scale]);
        let other_pixels = search(self.opened, &badness, &[LensChange::Scale, LensChange::Aspect]);
        // A cropped picture is most often one corner of a whole one, which a search from the middle may miss.
        let shifted = [[0.0, 0.0], [-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]].map(|shift| {
            let start = LensMapping { shift: self.opened.shift + DVec2::from(shift), ..self.opened };
            search(start, &badness, &[LensChange::Scale, LensChange::ShiftX, LensChange::ShiftY])
        });
        let mut best = same_pixels;
        // A lens with more changes is believed only if it is much better, and if the best lens so far leaves something to
        // improve.
        for other in [other_pixels].into_iter().chain(shifted) {
            if badness(&best) > RIGHT_DEGREES && badness(&other) < 0.5 * badness(&best) {
                best = other;
            }
        }
        (!few.is_empty()).then(|| (self.words(camera, &best), Self { opened: best, ..self.clone() }))
    }

    /// The lens `opened` as keys and values of a map. Its aspect and its shift are left out where they hardly differ
    /// from those of this comparison's lens.
    fn words(&self, camera: &Camera, opened: &LensMapping) -> String {
        let mut words = match camera.lens.opening {
            FieldOfView::Height(_) => format!("orthographic-height = {:.3}", 2.0 / opened.scale.y),
            FieldOfView::Angle(_) => format!("fov-y-deg = {:.1}", 2.0 * (1.0 / opened.scale.y).atan().to_degrees()),
        };
        let aspect = opened.scale.y / opened.scale.x;
        if (aspect / (self.opened.scale.y / self.opened.scale.x) - 1.0).abs() > 0.02 {
            words += &format!(" and aspect = {aspect:.3}");
        }
        let moved = opened.shift - self.opened.shift;
        if moved.abs().max_element() > 0.02 {
            let [width, height] = self.size.map(f64::from);
            let shift = [0.5 * opened.shift.x * width, -0.5 * opened.shift.y * height];
            words += &format!(" and shift-px = [{:.0}, {:.0}]", shift[0], shift[1]);
        }
        words
    }
}

/// The mean angle between the normals and slopes of some samples in degrees.
fn mean_degrees(opened: &LensMapping, samples: &[Sample]) -> f64 {
    let sum: f64 = samples.iter().map(|sample| opened.degrees_apart(sample).min(MOST_COUNTED_DEGREES)).sum();
    sum / samples.len().max(1) as f64
}

/// A change of a lens during a search.
#[derive(Debug, Clone, Copy)]
enum LensChange {
    Scale,
    Aspect,
    ShiftX,
    ShiftY,
}

impl LensChange {
    /// The lens after a step: scales double in two steps of 1, shifts move by half an image.
    fn by(self, opened: LensMapping, step: f64) -> LensMapping {
        let factor = 2.0_f64.powf(0.5 * step);
        let LensMapping { mut scale, mut shift, is_orthographic } = opened;
        match self {
            Self::Scale => scale *= factor,
            Self::Aspect => scale.x *= factor,
            Self::ShiftX => shift.x += step,
            Self::ShiftY => shift.y += step,
        }
        LensMapping { scale, shift, is_orthographic }
    }
}

/// Searches for the lens of the least badness. Each round takes the best of all combinations of steps, and halves the
/// steps if no combination is better. Combinations are needed since two changes can compensate each other: each alone
/// raises the badness, and only both together lower it.
fn search(start: LensMapping, badness: &impl Fn(&LensMapping) -> f64, changes: &[LensChange]) -> LensMapping {
    /// Greatest number of rounds, far more than a search that converges takes.
    const MOST_ROUNDS: usize = 60;
    /// The search ends as soon as steps are smaller than this.
    const LEAST_STEP: f64 = 1.0 / 512.0;
    let mut best = (start, badness(&start));
    let mut size = 1.0;
    for _ in 0..MOST_ROUNDS {
        if size < LEAST_STEP {
            break;
        }
        // Each change takes a step back, no step, or a step forward.
        let ways = 3_u32.pow(changes.len() as u32);
        let digit = |way: u32, place: usize| f64::from(way / 3_u32.pow(place as u32) % 3) - 1.0;
        let stepped = |way: u32| {
            let steps = changes.iter().enumerate();
            let lens = steps.fold(best.0, |lens, (place, change)| change.by(lens, size * digit(way, place)));
            (lens, badness(&lens))
        };
        match (0..ways).map(stepped).min_by(|a, b| a.1.total_cmp(&b.1)) {
            Some(nearer) if nearer.1 < best.1 => best = nearer,
            _ => size *= 0.5,
        }
    }
    best.0
}

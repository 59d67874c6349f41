//! Checks a frame for consistency. Normals are compared with the slopes of the depth and, if the map has positions of
//! surfaces, positions are compared with depth and camera. The check also tries other readings of the map, and finds
//! the reading with which the frame agrees best.

use super::GBufferMap;
use super::agreement::{LensMapping, Slopes, view_z};
use super::axes::MapConventions;
use super::files::{MapFiles, OpenFiles};
use super::keys::MapKeys;
use super::readings::other_readings;
use super::source::{MapSource, SourceRules};
use crate::{Camera, GBufferData};
use glam::{DVec3, Vec3};
use ssct_ground::Result;
use std::path::Path;

/// Share of pixels that may disagree without a message, since some do at edges and with normal maps.
const TOLERATED_DISAGREEMENT: f64 = 0.05;

/// Greatest share of the disagreement that another reading of the map may leave if it is to be believed.
const MUCH_BETTER: f64 = 0.5;

/// Share of unrelated normals or wrong positions from which a message is given even if no other reading is better.
const ALARMING_SHARE: f64 = 0.4;

/// Greatest distance of a position from the point that depth and camera give for its pixel, as a share of the distance
/// of that point from the camera. The share exceeds the rounding of 16-bit floats.
const TOLERATED_OFFSET: f64 = 0.01;

/// The channels of a map with the positions of surfaces.
#[derive(Debug, Clone)]
pub(super) struct MapPosition {
    source: MapSource,
    /// True if the positions are in world space, false if they are in view space.
    is_world: bool,
}

impl MapPosition {
    /// Takes the keys of the section `[position]`.
    pub fn take(mut keys: MapKeys) -> Result<Self> {
        let is_world = keys.required_word("space", &[("view", false), ("world", true)])?;
        let source = MapSource::take(&mut keys, SourceRules { counts: &[3], ..SourceRules::EXACT })?;
        keys.finish()?;
        Ok(Self { source, is_world })
    }

    /// Returns true if the positions are in world space. They can then be compared only if the camera's place is known.
    pub fn are_in_world(&self) -> bool {
        self.is_world
    }

    /// Returns the share of the pixels with a surface whose position disagrees with depth and camera.
    fn share_wrong<'a>(&'a self, files: &mut MapFiles<'a>, conventions: &MapConventions, frame: &Frame) -> Result<f64> {
        let planes = self.source.read(files)?;
        let lens = LensMapping::new(&frame.camera);
        let to_view = frame.camera.world_to_view.as_dmat4();
        let (mut wrong_count, mut compared_count) = (0_usize, 0_usize);
        for (pixel, depth) in frame.depth.iter().enumerate().filter(|(_, depth)| **depth > 0.0) {
            let ndc = super::pixel_ndc(frame.size, pixel);
            let expected = lens.point((ndc, view_z(&frame.camera, f64::from(*depth))));
            let stored = planes.three(pixel);
            let stored_in_view = match self.is_world {
                true => to_view.transform_point3(conventions.place(stored)),
                false => conventions.view * DVec3::from(stored) * conventions.metres,
            };
            compared_count += 1;
            // A position that is NaN is not near, so that it counts as wrong.
            let is_near = expected.distance(stored_in_view) <= TOLERATED_OFFSET * expected.length();
            wrong_count += usize::from(!is_near);
        }
        Ok(if compared_count == 0 { 0.0 } else { wrong_count as f64 / compared_count as f64 })
    }
}

/// A frame, decoded by one reading of a map: reversed depth, and normals in view space.
struct Frame {
    size: [u32; 2],
    camera: Camera,
    depth: Vec<f32>,
    normal: Vec<Vec3>,
}

/// Shares of a frame that disagree: normals with slopes, and positions with pixels.
#[derive(Debug, Clone, Copy)]
struct Disagreement {
    /// Share of the normals that disagree with the slopes.
    wrong_normals: f64,
    /// Share of the normals that are unrelated to the slopes.
    unrelated_normals: f64,
    /// The mean angle between normals and slopes in degrees.
    mean_degrees: f64,
    /// Share of the positions that disagree with depth and camera; 0 if the map has no positions.
    wrong_places: f64,
}

impl Disagreement {
    /// Makes the disagreement from a comparison of normals with slopes and from `wrong_places`, the share of wrong
    /// positions. If too few pixels can be compared, all normals count as wrong, so that such a reading is never
    /// preferred.
    fn new(slopes: &Slopes, wrong_places: f64) -> Self {
        match slopes.share_disagreeing().zip(slopes.share_unrelated()) {
            Some((wrong_normals, unrelated_normals)) => {
                Self { wrong_normals, unrelated_normals, mean_degrees: slopes.mean_degrees(), wrong_places }
            }
            None => Self { wrong_normals: 1.0, unrelated_normals: 1.0, mean_degrees: f64::INFINITY, wrong_places },
        }
    }

    /// Returns true if this reading agrees better than another: if fewer positions are wrong or, with equally many, if
    /// the mean angle is smaller.
    fn agrees_better(self, other: Self) -> bool {
        // Readings that mirror the same axes differ by rounding alone. The factor keeps the first of them.
        self.wrong_places < other.wrong_places
            || (self.wrong_places == other.wrong_places && self.mean_degrees < 0.99 * other.mean_degrees)
    }

    /// Returns the sum of the shares of wrong normals and wrong positions.
    fn sum(self) -> f64 {
        self.wrong_normals + self.wrong_places
    }

    /// Returns the larger of the shares of wrong normals and wrong positions.
    fn worst(self) -> f64 {
        self.wrong_normals.max(self.wrong_places)
    }

    /// Returns the shares in words. If the map has no positions, their share is left out.
    fn describe(self, has_places: bool) -> String {
        let percent = |share: f64| format!("{:.0} %", 100.0 * share);
        let slopes =
            format!("normals disagree with the slopes of the depth in {} of the pixels", percent(self.wrong_normals));
        if !has_places {
            return slopes;
        }
        format!("{slopes} and places of [position] with depth and camera in {}", percent(self.wrong_places))
    }
}

/// Returns the message about a G-buffer without a map whose normals and depth disagree; `None` if they agree.
pub fn disagreement(data: &GBufferData) -> Option<String> {
    let slopes = Slopes::of_data(data);
    let share = slopes.share_disagreeing()?;
    if share <= TOLERATED_DISAGREEMENT {
        return None;
    }
    let stated = Disagreement::new(&slopes, 0.0);
    let best_lens = slopes.best_lens(&data.camera).map(|(words, fitted)| (words, Disagreement::new(&fitted, 0.0)));
    message(stated, best_lens, false)
}

/// Returns the message about the disagreement `stated` of a map as it stands, if another reading is much better or more
/// than [`ALARMING_SHARE`] is wrong. `best` is the best other reading, in words, with its disagreement; `has_places` is
/// true if the map has positions.
fn message(stated: Disagreement, best: Option<(String, Disagreement)>, has_places: bool) -> Option<String> {
    let is_better = |other: &Disagreement| other.sum() <= MUCH_BETTER * stated.sum();
    let description = stated.describe(has_places);
    match best.filter(|(_, other)| is_better(other)) {
        Some((words, other)) if stated.worst() > TOLERATED_DISAGREEMENT => {
            Some(format!("{description}; with {words} it would be {:.0} %", 100.0 * other.worst()))
        }
        _ if stated.unrelated_normals.max(stated.wrong_places) > ALARMING_SHARE => {
            let question = "is the picture a panorama or a cropped one, or is the lens, the camera's place or the kind \
                            of depth wrong?";
            Some(format!(
                "{description}, and no other reading of lens, axes or depth that was tried is much better; {question}"
            ))
        }
        _ => None,
    }
}

impl GBufferMap {
    /// Checks a frame that was read for consistency. Returns a message if more than a few normals disagree with the
    /// slopes of the depth, or more than a few positions disagree with depth and camera. The message has the share of
    /// such pixels, and the change of the map that would make most of them agree.
    ///
    /// # Errors
    /// The errors of [`Self::read`].
    pub fn check(&self, main: &Path, data: &GBufferData) -> Result<Option<String>> {
        let slopes = Slopes::of_data(data);
        let share = slopes.share_disagreeing();
        if share.is_none_or(|share| share <= TOLERATED_DISAGREEMENT) && self.position.is_none() {
            return Ok(None);
        }
        let (stated, mut open_files) = self.disagreement(main, OpenFiles::default());
        let stated = stated?;
        if stated.worst() <= TOLERATED_DISAGREEMENT {
            return Ok(None);
        }
        let mut best: Option<(String, Disagreement)> = None;
        for reading in other_readings(self) {
            let (other, files_after) = reading.map.disagreement(main, open_files);
            open_files = files_after;
            // A reading that gives no camera or no depth is skipped.
            let Ok(other) = other else { continue };
            if best.as_ref().is_none_or(|(_, best_so_far)| other.agrees_better(*best_so_far)) {
                best = Some((reading.words, other));
            }
        }
        // A lens is fitted, and must be clearly better than mere changes of conventions. The fit is only tried without
        // positions, which would reveal a wrong lens by themselves.
        if self.position.is_none() {
            let fit = slopes.best_lens(&data.camera);
            let fitted_lens = fit.map(|(words, fitted)| (words, Disagreement::new(&fitted, stated.wrong_places)));
            let is_clearly_better = |other: &Disagreement| {
                best.as_ref().is_none_or(|(_, best_so_far)| other.mean_degrees < MUCH_BETTER * best_so_far.mean_degrees)
            };
            if let Some(lens_reading) = fitted_lens.filter(|(_, other)| is_clearly_better(other)) {
                best = Some(lens_reading);
            }
        }
        Ok(message(stated, best, self.position.is_some()))
    }

    /// Returns the disagreement of a frame that this map decodes. `open_files` were read before. They are returned,
    /// with those that this map read, so that the next reading of the map need not read them again.
    fn disagreement(&self, main: &Path, open_files: OpenFiles) -> (Result<Disagreement>, OpenFiles) {
        let mut files = MapFiles::with_open(&self.path, main, self.arrangement(), open_files);
        let measured = self.measure(&mut files);
        (measured, files.into_open())
    }

    /// Decodes a frame by this map, and measures how much its normals, depth and positions disagree.
    fn measure<'a>(&'a self, files: &mut MapFiles<'a>) -> Result<Disagreement> {
        let planes = self.depth.read(files)?;
        let size = files.size();
        let (camera, depth_coding) = self.camera.get(&self.conventions, &self.depth, files)?;
        let depth = self.depth.to_reversed(&planes, &camera, depth_coding, self.conventions.metres, size)?;
        let normal = self.normals.read(files, &self.conventions, &camera, &depth)?;
        let frame = Frame { size, camera, depth, normal };
        let slopes = Slopes::new(&frame.camera, size, &frame.depth, &frame.normal);
        let wrong_places = match &self.position {
            Some(position) => position.share_wrong(files, &self.conventions, &frame)?,
            None => 0.0,
        };
        Ok(Disagreement::new(&slopes, wrong_places))
    }
}

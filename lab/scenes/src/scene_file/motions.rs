//! Reads the motions of a scene file, which move and turn meshes from key frame to key frame.

use crate::motion::{Changes, Interpolation, Keys, Motion, Mover, MovingNode, Rest};
use crate::obj::Handedness;
use crate::source_text::SourceText;
use crate::{Aabb, Scene};
use glam::{DMat4, DQuat, DVec3, Quat, Vec3};
use serde::Deserialize;
use ssct_ground::Result;
use std::sync::Arc;
use toml::Spanned;

/// Turns from one key frame to the next must be less than this, since the interpolation goes the shorter way around.
const HALF_TURN_DEG: f32 = 180.0;

/// A `[motion.NAME]` section.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MotionSection {
    /// Name of the meshes that move.
    mesh: Spanned<String>,
    /// Point that the meshes turn about; by default the middle of their bounds.
    pivot: Option<Spanned<[f32; 3]>>,
    /// Axis of the turns; by default +y.
    axis: Option<Spanned<[f32; 3]>>,
    #[serde(default)]
    key: Vec<Spanned<KeySection>>,
}

/// A key frame of a motion: time in seconds, offset in metres, and turn in degrees.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct KeySection {
    time: f32,
    offset: Option<Spanned<[f32; 3]>>,
    turn_deg: Option<f32>,
}

impl SourceText<'_> {
    /// Reads and checks the motion `name` of a section, in a scene whose meshes are loaded. Positions and offsets of
    /// the section are in `coordinates`, and are multiplied by `extra_scale`.
    ///
    /// # Errors
    /// [`Error::Malformed`](ssct_ground::Error::Malformed) with file and line.
    pub(super) fn motion(
        &self,
        name: &str,
        section: &MotionSection,
        scene: &Scene,
        extra_scale: f32,
        coordinates: Handedness,
    ) -> Result<Motion> {
        let MotionSection { mesh, pivot, axis, key } = section;
        let moved_meshes = || scene.meshes.iter().filter(|candidate| candidate.name == *mesh.get_ref());
        if moved_meshes().next().is_none() {
            return Err(
                self.error(mesh.span(), format!("motion {name} moves {:?}, and no mesh has this name", mesh.get_ref()))
            );
        }
        let bounds = moved_meshes().fold(Aabb::default(), |bounds, mesh| bounds.union(mesh.bounds));
        let pivot = match pivot {
            Some(pivot) => coordinates.mirrored(self.place("pivot", pivot, extra_scale)?),
            None => 0.5 * (bounds.min + bounds.max),
        };
        let axis = match axis {
            Some(axis) => match self.vector("axis", axis)?.try_normalize() {
                Some(unit) => coordinates.mirrored(unit),
                None => return Err(self.error(axis.span(), "axis must not be zero")),
            },
            None => Vec3::Y,
        };
        let (mut times, mut offsets, mut turns_deg) = (Vec::new(), Vec::new(), Vec::new());
        for section in key {
            let KeySection { time, offset, turn_deg } = section.get_ref();
            let offset = match offset {
                Some(offset) => self.place("offset", offset, extra_scale)?,
                None => Vec3::ZERO,
            };
            let degrees = turn_deg.unwrap_or(0.0);
            if turns_deg.last().is_some_and(|previous: &f32| (degrees - previous).abs() >= HALF_TURN_DEG) {
                let message = "turn_deg must change by less than 180 from one key frame to the next";
                return Err(self.error(section.span(), message));
            }
            times.push(*time);
            offsets.push((coordinates.mirrored(offset) + pivot).to_array());
            turns_deg.push(degrees);
        }
        // The turn of a key frame as a quaternion.
        let turn =
            |degrees: f32| Quat::from_axis_angle(axis, coordinates.mirrored_angle(degrees.to_radians())).to_array();
        let turns = turns_deg.into_iter().map(turn).collect();
        let span = key.first().map_or(mesh.span(), Spanned::span);
        let motion_error = |clause: &str| self.error(span.clone(), format!("motion {name} {clause}"));
        let offsets = Keys::new(times.clone(), offsets, Interpolation::Linear).map_err(motion_error)?;
        let turns = Keys::new(times, turns, Interpolation::Linear).map_err(motion_error)?;
        // The inner node moves the pivot to the origin. The outer node turns the meshes there, and moves them to the
        // pivot plus the offset.
        let nodes = vec![
            MovingNode {
                rest: Rest::Parts(DVec3::ZERO, DQuat::IDENTITY, DVec3::ONE),
                changes: Changes { offset: Some(Arc::new(offsets)), turn: Some(Arc::new(turns)), size: None },
            },
            MovingNode::still(Rest::Matrix(DMat4::from_translation(-pivot.as_dvec3()))),
        ];
        let mover = Mover { meshes: vec![mesh.get_ref().clone()], root: DMat4::IDENTITY, nodes, rest: DMat4::IDENTITY };
        Ok(Motion { name: name.to_owned(), movers: vec![mover] })
    }
}

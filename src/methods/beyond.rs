//! The captures and triangles of the scene in which an effect follows rays beyond the screen.

use super::capture::{CaptureImages, Renewal};
use super::setup::{CaptureCount, Tracer};
use super::{EffectParams, Fallback, MethodInfo, SceneInput, captures, environment, pccm, planar};
use crate::error::{Error, Result};
use crate::gpu::FrameContext;
use crate::passes::scene_data::SceneData;
use crate::passes::triangle_scene::{TriangleBuffers, TriangleReading, TriangleTable};
use glam::Vec3;
use ssct_ground::scene::capture::WantedCaptures;
use ssct_ground::scene::{Capture, Material};

impl Fallback {
    /// Returns the method that shows where a reflection fades or misses; `None` without a fallback.
    pub fn method(self) -> Option<&'static MethodInfo> {
        match self {
            Self::None => None,
            Self::Environment => Some(&environment::INFO),
            Self::Pccm => Some(&pccm::INFO),
            Self::Captures => Some(&captures::INFO),
            Self::Planar => Some(&planar::INFO),
        }
    }
}

/// How shaders read the triangles of the scene, and the table of their materials, `None` before the scene is prepared.
pub(super) struct PreparedTriangles {
    pub(super) reading: TriangleReading,
    pub(super) table: Option<TriangleTable>,
}

impl PreparedTriangles {
    /// Returns the buffers of a scene's triangles, where the meshes stand now. Fails if the triangles are not ready,
    /// and for more lights or triangles than the effect was made for.
    pub(super) fn buffers<'t>(&'t self, data: &'t SceneData) -> Result<TriangleBuffers<'t>> {
        let (lights, max_lights) = (data.light_count(), self.reading.lights);
        if lights > max_lights {
            let message =
                format!("the scene has {lights} lights now, and this effect was made for {max_lights}: make it anew");
            return Err(Error::Usage(message));
        }
        let structure = data.ray_structure().filter(|_| self.reading.queries);
        let has_tracer = structure.is_some() == self.reading.queries;
        let (Some((geometry, images)), Some(table), true) = (data.triangles(), &self.table, has_tracer) else {
            let message = "the scene's triangles are not ready: SceneData::prepare_triangles comes before each frame";
            return Err(Error::Usage(message.into()));
        };
        // A mesh that moves for the first time takes more room, which may be more than shaders can read as texels.
        if self.reading.geometry_texels && !geometry.reading(images, lights).geometry_texels {
            let message =
                "the scene's triangles are more now than this device can read as the effect does: make it anew";
            return Err(Error::Usage(message.into()));
        }
        Ok(geometry.buffers(images, table).with_ray_structure(structure))
    }
}

/// The captures of a scene, with the places, the size of the faces and the materials from which they are made.
pub(super) struct CaptureSet {
    /// Where the scene is captured; empty for captures that the caller gives.
    pub(super) places: Vec<Capture>,
    /// Width and height of the faces.
    pub(super) face: [u32; 2],
    pub(super) images: Option<CaptureImages>,
    pub(super) materials: Vec<Material>,
    /// The passes that draw captures again; `None` for captures that stay as they are.
    pub(super) renewal: Option<Renewal>,
    /// Whether the set is a single capture, which follows the camera and is drawn anew in each frame.
    pub(super) follows_camera: bool,
}

impl CaptureSet {
    /// Makes the set for captures that the caller gives: the images now, or with the input of each frame.
    pub(super) fn from_caller(face: [u32; 2], images: Option<CaptureImages>) -> Self {
        Self { places: Vec::new(), face, images, materials: Vec::new(), renewal: None, follows_camera: false }
    }
}

/// Prepares the triangles of a scene for a method that follows rays among them; returns `None` for other methods. Fails
/// if the method is to follow rays among triangles that are not known.
pub(super) fn triangles_for(
    context: &mut FrameContext,
    info: &MethodInfo,
    effect: &EffectParams,
    scene: Option<&SceneInput>,
) -> Result<Option<TriangleReading>> {
    if !effect.is_among_triangles(info, scene.is_some()) {
        return Ok(None);
    }
    let unknown = || {
        Error::Usage(format!(
            "the method {} follows rays among the triangles of the scene, which are not known here; a G-buffer alone does \
             not have them",
            info.name
        ))
    };
    let queries = effect.tracer == Tracer::Query;
    let reading = scene.ok_or_else(unknown)?.data.prepare_triangles(context, queries)?;
    Ok(Some(reading.ok_or_else(unknown)?))
}

/// Returns the captures in which a method or its fallback follows rays, and the milliseconds that finding their places
/// took. There are none if neither of the two follows rays in captures, or if the scene has no place for a capture.
/// Fails if captures are wanted and there is no scene.
pub(super) fn captures_for(
    info: &MethodInfo,
    effect: &EffectParams,
    scene: Option<&SceneInput>,
) -> Result<(Vec<Capture>, f64)> {
    // A method or a fallback that looks into captures alone gets as many as the scene needs if the user asks for none.
    let fallback_takes_captures = effect.fallback.method().is_some_and(|m| m.takes_captures);
    let method_takes_captures =
        info.takes_captures && (!info.is_screen_space() || effect.captures_wanted() != CaptureCount::None);
    if !method_takes_captures && !fallback_takes_captures {
        return Ok((Vec::new(), 0.0));
    }
    let Some(scene) = scene else {
        return Err(Error::Usage("captures need the scene; a G-buffer alone does not show it".into()));
    };
    let side = effect.capture_side.texels();
    let sized = |c: &Capture| Capture { resolution: side.unwrap_or(c.resolution), ..*c };
    if effect.captures_wanted() == CaptureCount::Camera {
        // Each frame moves this capture to the camera.
        return Ok((vec![sized(&Capture::placed_at(Vec3::ZERO))], 0.0));
    }
    let placed = scene.data.captures(effect.captures_wanted().wanted().unwrap_or(WantedCaptures::Auto));
    Ok((placed.captures.iter().map(sized).collect(), placed.time_ms))
}

//! Captures and triangles of the scene, in which an effect looks beyond the screen.

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
    /// The method that shows where a reflection fades or misses; `None` without a fallback.
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

/// How the triangles of the scene are read, and the table of the materials that they show.
pub(super) struct PreparedTriangles {
    pub(super) reading: TriangleReading,
    pub(super) table: Option<TriangleTable>,
}

impl PreparedTriangles {
    /// Returns the triangles of a scene where they stand now.
    ///
    /// # Errors
    /// [`Error::Usage`] if the triangles are not ready, and for more lights than the effect was made for.
    pub(super) fn bound<'t>(&'t self, data: &'t SceneData) -> Result<TriangleBuffers<'t>> {
        let (lights, most) = (data.light_count(), self.reading.lights);
        if lights > most {
            let message =
                format!("the scene has {lights} lights now, and this effect was made for {most}: make it anew");
            return Err(Error::Usage(message));
        }
        let ready = data.triangles().zip(self.table.as_ref());
        let structure = data.ray_structure().filter(|_| self.reading.queries);
        let is_ready = structure.is_some() == self.reading.queries;
        let ((geometry, images), table) = ready.filter(|_| is_ready).ok_or_else(|| {
            let message = "the scene's triangles are not ready: SceneData::prepare_triangles comes before each frame";
            Error::Usage(message.into())
        })?;
        // Meshes that move take room of their own, so that there may be more triangles now.
        if self.reading.geometry_texels && !geometry.reading(images, lights).geometry_texels {
            let message =
                "the scene's triangles are more now than this device can read as the effect does: make it anew";
            return Err(Error::Usage(message.into()));
        }
        Ok(geometry.bound(images, table).queried(structure))
    }
}

/// Captures of a scene, with the places, the size and the materials that they are made of.
pub(super) struct CaptureSet {
    /// Where the scene is captured; empty for captures that come from elsewhere.
    pub(super) places: Vec<Capture>,
    /// Width and height of the faces.
    pub(super) face: [u32; 2],
    pub(super) images: Option<CaptureImages>,
    pub(super) materials: Vec<Material>,
    /// The passes that draw captures again; `None` for captures that neither move nor change.
    pub(super) renewal: Option<Renewal>,
    /// True if the only capture follows the camera and is redrawn every frame.
    pub(super) at_camera: bool,
}

impl CaptureSet {
    /// Makes the set for captures that the caller brings along: their images at once, or with each input.
    pub(super) fn from_elsewhere(face: [u32; 2], images: Option<CaptureImages>) -> Self {
        Self { places: Vec::new(), face, images, materials: Vec::new(), renewal: None, at_camera: false }
    }
}

/// Prepares the triangles of a scene for a method that follows rays among them; returns `None` for other methods.
///
/// # Errors
/// [`Error::Usage`] if the method is to follow rays among triangles that are not known.
pub(super) fn triangles_for(
    context: &mut FrameContext,
    info: &MethodInfo,
    effect: &EffectParams,
    scene: Option<&SceneInput>,
) -> Result<Option<TriangleReading>> {
    if !effect.is_among_triangles(info, scene.is_some()) {
        return Ok(None);
    }
    let refused = || {
        Error::Usage(format!(
            "the method {} follows rays among the triangles of the scene, which are not known here; a G-buffer alone does \
             not have them",
            info.name
        ))
    };
    let queries = effect.tracer == Tracer::Query;
    let reading = scene.ok_or_else(refused)?.data.prepare_triangles(context, queries)?;
    Ok(Some(reading.ok_or_else(refused)?))
}

/// Returns the captures of a scene that a method and its fallback look into, and the milliseconds that finding their places took.
/// There are none if neither follows rays in captures, or if the scene has no place for a capture.
///
/// # Errors
/// [`Error::Usage`] if captures are wanted and there is no scene.
pub(super) fn captures_taken(
    info: &MethodInfo,
    effect: &EffectParams,
    scene: Option<&SceneInput>,
) -> Result<(Vec<Capture>, f64)> {
    let behind = effect.fallback.method().is_some_and(|m| m.takes_captures);
    let is_all = !info.is_screen_space() && info.takes_captures;
    let is_asked_for = effect.captures_wanted() != CaptureCount::None && (behind || info.takes_captures);
    // A method that looks into captures alone takes them without being asked.
    if !is_asked_for && !behind && !is_all {
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

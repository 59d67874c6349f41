//! A rendered G-buffer on the host, and a method's hits, as the references and metrics take them.

use super::stage::Shot;
use crate::error::Result;
use crate::gpu::{FrameContext, Pixels};
use crate::passes::PathCode;
use crate::scene::GBufferData;
use glam::Vec3;

/// Reads back the G-buffer and the lit colour of the last frame of a shot.
pub fn read_gbuffer(context: &mut FrameContext, shot: &Shot) -> Result<GBufferData> {
    let images = shot.gbuffer.gbuffer();
    let depth = context.read(images.depth.all())?;
    let normal = context.read(images.normal.all())?;
    let material = context.read(images.material.all())?;
    let color = context.read(images.color.level(0))?;
    Ok(GBufferData {
        width: depth.width,
        height: depth.height,
        camera: shot.camera,
        depth: depth.values,
        normal: normal.texels().map(Vec3::from_slice).collect(),
        reflectivity: material.texels().map(|t| t[0]).collect(),
        roughness: material.texels().map(|t| t[1]).collect(),
        color: color.texels().map(Vec3::from_slice).collect(),
    })
}

/// Where a published method takes its rays to have hit, in continuous pixel coordinates; `None` for
/// a miss. `hits` is the image of [`crate::passes::Hits`].
pub fn hit_positions(hits: &Pixels) -> Vec<Option<[f64; 2]>> {
    let size = [f64::from(hits.width), f64::from(hits.height)];
    let position = |t: &[f32]| [f64::from(t[0]) * size[0], f64::from(t[1]) * size[1]];
    hits.texels().map(|t| PathCode::from_channel(t[3]).is_some_and(PathCode::is_hit).then(|| position(t))).collect()
}

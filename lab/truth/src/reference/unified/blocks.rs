//! Twin of `pyramid.comp` for one pixel.

use super::{Block, NEVER, Parameters};
use glam::IVec2;
use ssct_ground::math::constants;
use ssct_scenes::GBufferData;

/// Twin of `DepthBlock`: returns the block of a pixel, from its reversed depth and those of its four neighbours;
/// empty for sky. The block is as thick as the span of the surface in depth over the pixel, plus a small share of the
/// view depth.
pub(super) fn depth_block(gbuffer: &GBufferData, parameters: &Parameters, pixel: IVec2) -> Block {
    let depth_at = |pixel: IVec2| {
        let is_inside = pixel.cmpge(IVec2::ZERO).all() && pixel.cmplt(parameters.size).all();
        if is_inside { gbuffer.depth[gbuffer.index(pixel.x as u32, pixel.y as u32)] } else { 0.0 }
    };
    let depth = depth_at(pixel);
    if depth <= 0.0 {
        return Block::EMPTY;
    }
    // An orthographic depth is linear in metres, and shares of depth are then shares of the height of the view.
    let is_linear = parameters.kind.is_orthographic();
    let thin_limit = constants::THIN as f32 * if is_linear { parameters.reach * parameters.depth_offset } else { 1.0 };
    // How far the neighbour stands behind the pixel, as a share of its own view depth, or in depth if that is linear.
    let depth_behind = |dx, dy| {
        let neighbour = depth_at(pixel + IVec2::new(dx, dy));
        let reciprocal = if is_linear { 1.0 } else { 1.0 / (neighbour + parameters.depth_offset) };
        if neighbour > 0.0 { (depth - neighbour) * reciprocal } else { -NEVER }
    };
    // The span along an axis, from the neighbours on both sides: the smaller difference. It is 0 without a neighbour,
    // and for a surface that stands far before both, since it is thinner than two pixels.
    let depth_span = |first: f32, second: f32| {
        let least = first.abs().min(second.abs());
        if least < NEVER && first.min(second) <= thin_limit { least } else { 0.0 }
    };
    let span_sum =
        depth_span(depth_behind(-1, 0), depth_behind(1, 0)) + depth_span(depth_behind(0, -1), depth_behind(0, 1));
    let depth_share = constants::SHARE_OF_DEPTH as f32;
    if is_linear {
        let thickness = span_sum + depth_share * (parameters.reach * parameters.depth_offset);
        return Block { front: depth, back: depth - thickness };
    }
    let thickness = span_sum + depth_share;
    let scale = 1.0 / (1.0 + thickness);
    Block { front: depth, back: (depth - parameters.depth_offset * thickness) * scale }
}

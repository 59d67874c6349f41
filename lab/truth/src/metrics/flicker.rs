//! Flicker: how much an image changes from one frame to the next at the same places of a surface, which may have moved
//! over the screen (docs/definitions.md, "Films").

use glam::{DMat4, DVec3, Vec3};
use ssct_scenes::GBufferData;

/// Returns the colour, or black if a channel is not finite.
pub fn finite_or_black(color: Vec3) -> Vec3 {
    if color.is_finite() { color } else { Vec3::ZERO }
}

/// A pixel of a frame, with the place in the previous frame that shows the same point of its surface.
pub struct SamePlace {
    /// Index of the pixel in this frame.
    pixel: usize,
    /// Place [x, y] in the previous frame, in pixels; pixel centres are at one half.
    previous_place: [f64; 2],
}

/// Pairs reflecting pixels of the frame `now` with the places where the previous frame `before` shows the same points.
/// A point is paired only if the four pixels of `before` around its place reflect, too, and show the same surface. The
/// surface itself is taken to stand still.
pub fn pairs(before: &GBufferData, now: &GBufferData) -> Vec<SamePlace> {
    // A frame's matrices from view to clip space, from clip to view space, and from world to view space.
    let matrices = |data: &GBufferData| {
        let projection = data.view_to_clip();
        (projection, projection.inverse(), data.camera.world_to_view.as_dmat4())
    };
    let (_, now_to_view, world_to_view_now) = matrices(now);
    let (to_clip_before, before_to_view, world_to_view_before) = matrices(before);
    let now_to_before: DMat4 = world_to_view_before * world_to_view_now.inverse();
    let mut pairs = Vec::new();
    for y in 0..now.height {
        for x in 0..now.width {
            let index = now.index(x, y);
            if !now.reflects(index) {
                continue;
            }
            let depth = f64::from(now.depth[index]);
            // The surface point in the view space of the previous camera.
            let position = now_to_before.transform_point3(now.unproject(
                f64::from(x) + 0.5,
                f64::from(y) + 0.5,
                depth,
                &now_to_view,
            ));
            let Some(place) = before.project(position, &to_clip_before) else { continue };
            // The first of the 2 × 2 pixels whose centres are around the place.
            let corner = [place.x - 0.5, place.y - 0.5].map(f64::floor);
            let inside = corner[0] >= 0.0
                && corner[1] >= 0.0
                && corner[0] + 1.0 < f64::from(before.width)
                && corner[1] + 1.0 < f64::from(before.height);
            if !inside {
                continue;
            }
            let neighbours_match = (0..4).all(|neighbour| {
                let (px, py) = (corner[0] as u32 + neighbour % 2, corner[1] as u32 + neighbour / 2);
                let neighbour_index = before.index(px, py);
                let neighbour_position = before.unproject(
                    f64::from(px) + 0.5,
                    f64::from(py) + 0.5,
                    f64::from(before.depth[neighbour_index]),
                    &before_to_view,
                );
                before.reflects(neighbour_index) && is_same_surface(neighbour_position, position)
            });
            if neighbours_match {
                pairs.push(SamePlace { pixel: index, previous_place: [place.x, place.y] });
            }
        }
    }
    pairs
}

/// Returns whether the view depths of two points differ by at most 2 % of the depth of `b`. The tolerance is that of
/// docs/definitions.md, "World agreement", for places that the screen shows.
fn is_same_surface(a: DVec3, b: DVec3) -> bool {
    (a.z - b.z).abs() <= 0.02 * b.z
}

/// Returns, for each pair, its colour in the image `now` minus the interpolated colour at its place in the image
/// `before`. Both images are `width` pixels wide, rows from the top.
pub fn changes(pairs: &[SamePlace], before: &[Vec3], now: &[Vec3], width: u32) -> Vec<Vec3> {
    pairs.iter().map(|pair| now[pair.pixel] - bilinear(before, width, pair.previous_place)).collect()
}

/// Returns the mean absolute value of `measure` over all changes and channels; 0 without changes. `measure` gets the
/// index of a change and the change, and returns the colour difference to average.
pub fn mean(changes: &[Vec3], measure: impl Fn(usize, Vec3) -> Vec3) -> f64 {
    let channel_mean = |(index, change): (usize, &Vec3)| f64::from(measure(index, *change).abs().element_sum()) / 3.0;
    let sum: f64 = changes.iter().enumerate().map(channel_mean).sum();
    if changes.is_empty() { 0.0 } else { sum / changes.len() as f64 }
}

/// Interpolates bilinearly between the four pixels around the place [x, y], in pixels. All four must be in the image.
fn bilinear(image: &[Vec3], width: u32, [x, y]: [f64; 2]) -> Vec3 {
    // Pixel centres are at one half, so that the shifted coordinates are whole there.
    let (x, y) = (x - 0.5, y - 0.5);
    let (fraction_x, fraction_y) = ((x - x.floor()) as f32, (y - y.floor()) as f32);
    let texel = |dx: usize, dy: usize| image[(y as usize + dy) * width as usize + x as usize + dx];
    texel(0, 0).lerp(texel(1, 0), fraction_x).lerp(texel(0, 1).lerp(texel(1, 1), fraction_x), fraction_y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::testing::floor_and_wall;

    #[test]
    fn a_still_camera_pairs_each_pixel_with_itself() {
        let data = floor_and_wall(32, 24);
        let same_places = pairs(&data, &data);
        assert!(same_places.len() > 32 * 24 / 2, "{} pairs", same_places.len());
        for pair in &same_places {
            let x = (pair.pixel % 32) as f64 + 0.5;
            assert!((pair.previous_place[0] - x).abs() < 1e-6, "{} and {x}", pair.previous_place[0]);
        }
        let image: Vec<Vec3> = (0..32 * 24).map(|i| Vec3::splat(i as f32)).collect();
        let mean_change = mean(&changes(&same_places, &image, &image, 32), |_, change| change);
        assert!(mean_change < 1e-2, "{mean_change}");
    }

    #[test]
    fn what_changes_flickers_by_as_much() {
        let data = floor_and_wall(32, 24);
        let grey_image = |grey: f32| vec![Vec3::splat(grey); 32 * 24];
        let color_changes = changes(&pairs(&data, &data), &grey_image(0.25), &grey_image(0.75), 32);
        assert!((mean(&color_changes, |_, change| change) - 0.5).abs() < 1e-6);
        assert!(mean(&color_changes, |_, change| change - 0.5) < 1e-6);
    }
}

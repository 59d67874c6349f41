//! Makes G-buffers of which only a part reflects, for several benches.

use ssct_scenes::GBufferData;

/// Returns a copy of a G-buffer in which only a rectangle in the middle reflects. `share` is the rectangle's share of
/// all pixels.
pub fn masked(data: &GBufferData, share: f64) -> GBufferData {
    let mut masked = data.clone();
    let [width, height] = [data.width, data.height].map(|side| (f64::from(side) * share.sqrt()).round() as u32);
    let [left, top] = [(data.width - width) / 2, (data.height - height) / 2];
    for (pixel, reflectivity) in masked.reflectivity.iter_mut().enumerate() {
        let (x, y) = (pixel as u32 % data.width, pixel as u32 / data.width);
        if !((left..left + width).contains(&x) && (top..top + height).contains(&y)) {
            *reflectivity = 0.0;
        }
    }
    masked
}

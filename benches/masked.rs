//! G-buffers of which a part reflects, which several benches time.

use ssct_scenes::GBufferData;

/// A copy of a G-buffer in which only a rectangle in the middle reflects. `share` is the rectangle's share of all
/// pixels.
pub fn masked(data: &GBufferData, share: f64) -> GBufferData {
    let mut masked = data.clone();
    let [w, h] = [data.width, data.height].map(|n| (f64::from(n) * share.sqrt()).round() as u32);
    let [left, top] = [(data.width - w) / 2, (data.height - h) / 2];
    for (i, reflectivity) in masked.reflectivity.iter_mut().enumerate() {
        let (x, y) = (i as u32 % data.width, i as u32 / data.width);
        if !((left..left + w).contains(&x) && (top..top + h).contains(&y)) {
            *reflectivity = 0.0;
        }
    }
    masked
}

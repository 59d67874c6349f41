//! placeholder until merge
use glam::Vec3;
pub fn radiance(d: Vec3) -> Vec3 {
    Vec3::new(0.3, 0.5, 0.8) * (0.5 + 0.5 * d.y)
}
pub fn cube_map(size: u32) -> [Vec<[f32; 4]>; 6] {
    std::array::from_fn(|_| vec![[0.4, 0.6, 0.9, 1.0]; (size * size) as usize])
}

//! Draws a scene of unlit surfaces and mirrors by testing each ray against every triangle. Reflections are compared
//! with this picture as the truth. The code uses nothing of `ssct` or of Bevy's renderer.

use bevy::math::{Mat4, Vec2, Vec3};

/// The look of a triangle, which is the same from every direction.
#[derive(Clone)]
pub enum Look {
    /// One linear colour.
    Color(Vec3),
    /// A texture, at the texture coordinates `places` of the triangle.
    Texture(std::sync::Arc<Texture>),
    /// A perfect mirror.
    Mirror,
}

/// A texture of linear colours, which repeats and is interpolated between four texels.
pub struct Texture {
    pub width: usize,
    pub height: usize,
    pub texels: Vec<Vec3>,
}

/// A triangle in the world. Each corner has its texture coordinates in `places`.
#[derive(Clone)]
pub struct Triangle {
    pub corners: [Vec3; 3],
    pub places: [Vec2; 3],
    pub look: Look,
}

/// The hit of a ray on a triangle: its distance, and its barycentric weights for the three corners.
struct RayHit<'a> {
    distance: f32,
    weights: Vec3,
    triangle: &'a Triangle,
}

/// Says what gives a pixel its colour.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Seen {
    /// A surface other than a mirror, or the sky, seen without a mirror.
    Directly,
    /// A surface in a mirror.
    Mirrored,
    /// The sky in a mirror.
    MirroredSky,
}

/// Draws a picture, row by row: the linear colour of each pixel, and what gives it that colour. `sky` returns the light
/// that comes from a direction of the world. The matrices are those of the camera, with z towards the viewer.
pub fn picture(
    triangles: &[Triangle],
    sky: impl Fn(Vec3) -> Vec3 + Sync,
    [width, height]: [usize; 2],
    clip_from_view: Mat4,
    world_from_view: Mat4,
) -> Vec<(Vec3, Seen)> {
    let scale = Vec2::new(1.0 / clip_from_view.x_axis.x, 1.0 / clip_from_view.y_axis.y);
    let pixel = |index: usize| {
        let ndc = Vec2::new((index % width) as f32 + 0.5, (index / width) as f32 + 0.5)
            / Vec2::new(width as f32, height as f32);
        let ndc = ndc * Vec2::new(2.0, -2.0) + Vec2::new(-1.0, 1.0);
        let direction = world_from_view.transform_vector3((ndc * scale).extend(-1.0)).normalize();
        let eye = world_from_view.w_axis.truncate();
        let Some(first) = nearest(triangles, eye, direction) else { return (sky(direction), Seen::Directly) };
        if !matches!(first.triangle.look, Look::Mirror) {
            return (first.color(), Seen::Directly);
        }
        let normal = first.triangle.normal();
        let start = eye + first.distance * direction;
        let mirrored = direction - 2.0 * direction.dot(normal) * normal;
        // The reflected ray begins a little off the mirror, so that it does not hit the mirror itself.
        let start = start + 1e-4 * normal * mirrored.dot(normal).signum();
        let hit = nearest(triangles, start, mirrored);
        hit.map_or_else(|| (sky(mirrored), Seen::MirroredSky), |hit| (hit.color(), Seen::Mirrored))
    };
    // The pixels are divided into as many parts as the processor runs threads.
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let pixel_count = width * height;
    let part_size = pixel_count.div_ceil(threads);
    let pixel = &pixel;
    std::thread::scope(|scope| {
        let draw_part = |first: usize| {
            let end = (first + part_size).min(pixel_count);
            scope.spawn(move || (first..end).map(pixel).collect::<Vec<_>>())
        };
        let running: Vec<_> = (0..pixel_count).step_by(part_size).map(draw_part).collect();
        running.into_iter().flat_map(|thread| thread.join().unwrap_or_default()).collect()
    })
}

/// Returns the nearest hit of a ray, by the method of Möller and Trumbore (1997), whose letters the variables have;
/// `None` if it misses every triangle.
fn nearest(triangles: &[Triangle], origin: Vec3, direction: Vec3) -> Option<RayHit<'_>> {
    let mut best: Option<RayHit> = None;
    for triangle in triangles {
        let [a, b, c] = triangle.corners;
        let (edge_ab, edge_ac) = (b - a, c - a);
        let p = direction.cross(edge_ac);
        let determinant = edge_ab.dot(p);
        let from_a = origin - a;
        let u = from_a.dot(p) / determinant;
        let q = from_a.cross(edge_ab);
        let v = direction.dot(q) / determinant;
        let distance = edge_ac.dot(q) / determinant;
        let is_hit = u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance > 0.0;
        if is_hit && best.as_ref().is_none_or(|best| distance < best.distance) {
            best = Some(RayHit { distance, weights: Vec3::new(1.0 - u - v, u, v), triangle });
        }
    }
    best
}

impl Triangle {
    /// The unit normal, on the side from which the corners run counter-clockwise.
    fn normal(&self) -> Vec3 {
        let [a, b, c] = self.corners;
        (b - a).cross(c - a).normalize()
    }
}

impl RayHit<'_> {
    /// The linear colour of the surface at the hit. A mirror that is seen in a mirror is black, since rays are
    /// reflected once.
    fn color(&self) -> Vec3 {
        match &self.triangle.look {
            Look::Color(color) => *color,
            Look::Mirror => Vec3::ZERO,
            Look::Texture(texture) => {
                let [a, b, c] = self.triangle.places;
                texture.color_at(self.weights.x * a + self.weights.y * b + self.weights.z * c)
            }
        }
    }
}

impl Texture {
    /// The colour at texture coordinates, interpolated between the four nearest texels.
    fn color_at(&self, place: Vec2) -> Vec3 {
        let size = Vec2::new(self.width as f32, self.height as f32);
        let position = (place - place.floor()) * size - 0.5;
        let (low, weight) = (position.floor(), position - position.floor());
        let texel = |x: f32, y: f32| {
            let wrapped = Vec2::new(x, y).rem_euclid(size);
            self.texels[wrapped.y as usize * self.width + wrapped.x as usize]
        };
        let row = |y: f32| texel(low.x, y).lerp(texel(low.x + 1.0, y), weight.x);
        row(low.y).lerp(row(low.y + 1.0), weight.y)
    }
}

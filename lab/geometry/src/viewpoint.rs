//! Chooses a lens, a view and a light for a scene that defines none.

use glam::Vec3;
use ssct_ground::scene::{Aabb, FieldOfView, Lens, Light, Scene, Vertex, View};

/// The number of horizontal directions that are examined.
const AZIMUTHS: usize = 16;

/// The least distance of the near plane, in metres, even for tiny scenes.
const LEAST_NEAR_M: f32 = 1e-6;

/// Returns the default lens, with a nearer near plane for a small scene and a farther far plane for a large one.
pub fn lens(bounds: Aabb) -> Lens {
    let lens = Lens::default();
    let diagonal = (bounds.max - bounds.min).length();
    Lens { near_m: lens.near_m.min(diagonal * 1e-2).max(LEAST_NEAR_M), far_m: lens.far_m.max(diagonal * 4.0), ..lens }
}

/// Makes a view named `default`, which looks towards the centre of the scene's bounds.
///
/// In an interior the eye lies in the horizontal direction in which the first surface is farthest from the centre, at
/// 0.8 of the distance to that surface. Otherwise the eye is outside, in front and slightly above, far enough away for
/// the bounding sphere to fit into the image.
pub fn default_view(scene: &Scene) -> View {
    let bounds = scene.bounds();
    let centre = 0.5 * (bounds.min + bounds.max);
    let directions = directions();
    // The first two directions are down and up.
    let mut below_and_above = first_hits(scene, &rays_from(centre, &directions));
    let around = below_and_above.split_off(2);
    let directions = &directions[2..];
    let eye = if is_interior(&below_and_above, &around) {
        let horizontal_hits = directions.iter().zip(&around).take(AZIMUTHS).filter(|(_, hit)| hit.distance.is_finite());
        let farthest = horizontal_hits.max_by(|(_, a), (_, b)| a.distance.total_cmp(&b.distance));
        farthest.map(|(direction, hit)| centre + 0.8 * hit.distance * *direction)
    } else {
        None
    };
    let eye = eye.filter(|eye| eye.distance(centre) > 2.0 * scene.lens.near_m).unwrap_or_else(|| {
        let radius = 0.5 * (bounds.max - bounds.min).length();
        let distance = match scene.lens.opening {
            FieldOfView::Angle(fov) => 1.05 * radius / (0.5 * fov).sin(),
            FieldOfView::Height(_) => 1.05 * radius + scene.lens.near_m,
        };
        centre + distance * Vec3::new(0.35, 0.35, -1.0).normalize()
    });
    View { name: "default".into(), eye, look_at: centre, ..View::default() }
}

/// Returns true if the centre of the scene's bounds is in a room or a court.
pub fn is_enclosed(scene: &Scene) -> bool {
    let bounds = scene.bounds();
    let mut below_and_above = first_hits(scene, &rays_from(0.5 * (bounds.min + bounds.max), &directions()));
    let around = below_and_above.split_off(2);
    is_interior(&below_and_above, &around)
}

/// Returns the directions down and up, then [`AZIMUTHS`] horizontal ones, and as many that rise and that fall.
fn directions() -> Vec<Vec3> {
    let sideways = [0.0, 0.5, -0.5].iter().flat_map(|&height| directions_around(height));
    [Vec3::NEG_Y, Vec3::Y].into_iter().chain(sideways).collect()
}

/// Makes a ray from `origin` in each of the directions.
fn rays_from(origin: Vec3, directions: &[Vec3]) -> Vec<Ray> {
    directions.iter().map(|&direction| Ray { origin, direction }).collect()
}

/// Returns true if a centre is in a room or a court, judged by the first surfaces below, above and around it. In a
/// room, the surfaces below and above face the centre, and at least half of those around. In a court, the surface below
/// faces the centre, and at least seven eighths of those around. Rays between separate objects meet nothing, so that
/// objects around an empty place make no room.
fn is_interior(below_and_above: &[Hit], around: &[Hit]) -> bool {
    let facing_around = around.iter().filter(|hit| hit.facing).count();
    match below_and_above {
        [below, above] if below.facing && above.facing => 2 * facing_around >= around.len(),
        [below, _] if below.facing => 8 * facing_around >= 7 * around.len(),
        _ => false,
    }
}

/// Returns the light for a scene that has none. It comes from above and behind, over the left shoulder of the default
/// view.
pub fn default_light() -> Light {
    Light::Directional { direction: Vec3::new(-0.3, -1.0, 0.25).normalize(), energy: 1.0 }
}

/// Returns unit vectors in [`AZIMUTHS`] directions around, each with `height` as the ratio of y to horizontal length.
fn directions_around(height: f32) -> impl Iterator<Item = Vec3> {
    (0..AZIMUTHS).map(move |index| {
        let (sin, cos) = (index as f32 / AZIMUTHS as f32 * std::f32::consts::TAU).sin_cos();
        Vec3::new(sin, height, cos).normalize()
    })
}

/// A ray from a place in a direction.
#[derive(Debug, Clone, Copy)]
pub struct Ray {
    /// Start, in metres.
    pub origin: Vec3,
    /// Direction, of any length.
    pub direction: Vec3,
}

/// The first surface on a ray; the distance is infinite if there is none.
#[derive(Clone, Copy)]
pub struct Hit {
    /// Distance as a multiple of the direction's length.
    pub distance: f32,
    /// Whether the ray meets the front of the surface.
    pub facing: bool,
    /// The normal of the triangle, of any length.
    pub normal: Vec3,
}

/// Finds the first surface on each ray by testing every triangle of the scene.
pub fn first_hits(scene: &Scene, rays: &[Ray]) -> Vec<Hit> {
    let mut hits = vec![Hit { distance: f32::INFINITY, facing: false, normal: Vec3::ZERO }; rays.len()];
    let position = |v: &Vertex| Vec3::from(v.position);
    for mesh in &scene.meshes {
        for triangle in mesh.indices.chunks_exact(3) {
            let [a, b, c] = [0, 1, 2].map(|i| position(&mesh.vertices[triangle[i] as usize]));
            let normal = (b - a).cross(c - a);
            for (hit, &Ray { origin, direction }) in hits.iter_mut().zip(rays) {
                let along_normal = normal.dot(direction);
                let distance = normal.dot(a - origin) / along_normal;
                if !(distance > 0.0 && distance < hit.distance) {
                    continue;
                }
                let point = origin + distance * direction;
                let is_inside_edge = |start: Vec3, end: Vec3| (end - start).cross(point - start).dot(normal) >= 0.0;
                if is_inside_edge(a, b) && is_inside_edge(b, c) && is_inside_edge(c, a) {
                    *hit = Hit { distance, facing: along_normal < 0.0, normal };
                }
            }
        }
    }
    hits
}

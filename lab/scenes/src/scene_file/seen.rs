//! Warnings about views of a scene file that see almost nothing: a view stands outside of a room, sees no surface, or
//! sees one flat surface alone. The usual reason is that the places are in other coordinates than the file says.

use crate::obj::Handedness;
use crate::{Camera, Scene, Vertex, View};
use glam::Vec3;
use ssct_geometry::viewpoint::{self, Hit, Ray};
use ssct_ground::math::frustum::Frustum;

/// Numbers of rays of a view, across and down.
const ACROSS: u32 = 9;
const DOWN: u32 = 5;

/// Greatest distance of surfaces from a plane in which they lie, as a share of the scene's diagonal.
const ONE_PLANE: f32 = 1e-3;

/// Least cosine of the angle between normals that count as equal.
const ALIKE: f32 = 0.9999;

/// The warnings about the first `count` views of a scene, without the file's name. `unsaid` are the coordinates in which places
/// are read if the file does not name any.
pub(super) fn warnings(scene: &Scene, count: usize, unsaid: Option<Handedness>) -> Vec<String> {
    let views = &scene.views[..count.min(scene.views.len())];
    let found = wrong(scene, views).into_iter().zip(views);
    let warning = |(what, view): (Option<&str>, &View)| {
        Some(format!("[view.{}] {}{}", view.name, what?, unsaid.map_or(String::new(), hint)))
    };
    found.filter_map(warning).collect()
}

/// The fault of each view of a scene, as the end of a sentence: the view sees nothing, only one flat surface, or a room from
/// outside. `None` for a view without a fault.
pub fn wrong(scene: &Scene, views: &[View]) -> Vec<Option<&'static str>> {
    let bounds = scene.bounds();
    let diagonal = (bounds.max - bounds.min).length();
    let is_outside = |eye: Vec3| !(eye.cmpge(bounds.min).all() && eye.cmple(bounds.max).all());
    let is_room = views.iter().any(|view| is_outside(view.eye)) && viewpoint::is_enclosed(scene);
    // A room without a front wall, or a court from above, shows the fronts of its surfaces.
    let sees_a_front = |view: &View| {
        let ray = Ray { origin: view.eye, direction: view.look_at - view.eye };
        viewpoint::first_hits(scene, &[ray]).iter().any(|hit| hit.facing)
    };
    let judged = |view: &View| {
        if is_room && is_outside(view.eye) && !sees_a_front(view) {
            return Some("stands outside of the room and sees no front of its walls");
        }
        next_to_nothing(scene, view, ONE_PLANE * diagonal)
    };
    views.iter().map(judged).collect()
}

/// The end of a warning about a view of a file that does not name its coordinates.
fn hint(read_as: Handedness) -> String {
    let (word, other) = match read_as {
        Handedness::Left => ("left", Handedness::Right),
        Handedness::Right => ("right", Handedness::Left),
    };
    format!("; the file's places are read as {word}-handed: if they are not, write {}", other.key())
}

/// The fault of a view that sees nothing, or one flat surface alone; `None` for any other view. `tolerance` is the greatest
/// distance of points from their plane, in metres.
fn next_to_nothing(scene: &Scene, view: &View, tolerance: f32) -> Option<&'static str> {
    let camera = view.camera(scene, [16, 9]);
    let frustum = Frustum::new(&(camera.view_to_clip() * camera.world_to_view));
    if !scene.meshes.iter().any(|mesh| frustum.may_see(mesh.bounds.min, mesh.bounds.max)) {
        return Some("sees no surface of the scene");
    }
    let mut plane = None;
    // Rays are traced column by column, since most views show more than one surface in the first column.
    for column in rays(&camera).chunks(DOWN as usize) {
        for (ray, hit) in column.iter().zip(viewpoint::first_hits(scene, column)) {
            let (point, normal) = (place(ray, &hit)?, hit.normal.normalize_or_zero());
            let (first, across) = *plane.get_or_insert((point, normal));
            if normal.dot(across).abs() < ALIKE || (point - first).dot(across).abs() > tolerance {
                return None;
            }
        }
    }
    let (first, across): (Vec3, Vec3) = plane?;
    // A scene of one flat surface has nothing else to show.
    let is_off = |v: &Vertex| (Vec3::from(v.position) - first).dot(across).abs() > tolerance;
    scene.meshes.iter().flat_map(|m| &m.vertices).any(is_off).then_some("sees nothing but one flat surface")
}

/// The point where a ray meets a surface; `None` if the ray meets none.
fn place(ray: &Ray, hit: &Hit) -> Option<Vec3> {
    hit.distance.is_finite().then(|| ray.origin + hit.distance * ray.direction)
}

/// Rays from the near plane through the whole picture, column by column.
fn rays(camera: &Camera) -> Vec<Ray> {
    let to_world = (camera.view_to_clip() * camera.world_to_view).as_dmat4().inverse();
    let pixels = (0..ACROSS).flat_map(|x| (0..DOWN).map(move |y| (x, y)));
    let ndc = |n: u32, count: u32| f64::from(2 * n + 1) / f64::from(count) - 1.0;
    let ray = |(x, y): (u32, u32)| {
        let [from, to] = [0.0, 0.5]
            .map(|depth| to_world.project_point3(glam::DVec3::new(ndc(x, ACROSS), ndc(y, DOWN), depth)).as_vec3());
        Ray { origin: from, direction: to - from }
    };
    pixels.map(ray).collect()
}

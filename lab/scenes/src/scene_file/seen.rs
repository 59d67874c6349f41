//! Finds views of a scene file that see almost nothing: a view stands outside of a room, sees no surface, or sees only
//! one flat surface. The usual reason is that positions are in other coordinates than the file says.

use crate::obj::Handedness;
use crate::{Camera, Scene, Vertex, View};
use glam::Vec3;
use ssct_geometry::viewpoint::{self, Hit, Ray};
use ssct_ground::math::frustum::Frustum;

/// Number of columns of rays that are traced for a view.
const COLUMNS: u32 = 9;
/// Number of rays in a column.
const ROWS: u32 = 5;

/// Greatest distance from a plane at which points count as lying in it, as a share of the scene's diagonal.
const PLANE_TOLERANCE: f32 = 1e-3;

/// Least cosine of the angle between normals that count as equal.
const LEAST_COSINE: f32 = 0.9999;

/// Returns the warnings about the first `count` views of a scene, without the file's name. `assumed` are the
/// coordinates in which positions were read if the file names no coordinates; it is `None` if the file names them.
pub(super) fn warnings(scene: &Scene, count: usize, assumed: Option<Handedness>) -> Vec<String> {
    let views = &scene.views[..count.min(scene.views.len())];
    let faults = faults(scene, views).into_iter().zip(views);
    let warning = |(fault, view): (Option<&str>, &View)| {
        Some(format!("[view.{}] {}{}", view.name, fault?, assumed.map_or(String::new(), hint)))
    };
    faults.filter_map(warning).collect()
}

/// Returns the fault of each view of a scene, as the end of a sentence: it sees nothing, only one flat surface, or a
/// room from outside. The result is `None` for a view without a fault.
pub fn faults(scene: &Scene, views: &[View]) -> Vec<Option<&'static str>> {
    let bounds = scene.bounds();
    let diagonal_m = (bounds.max - bounds.min).length();
    let is_outside = |eye: Vec3| !(eye.cmpge(bounds.min).all() && eye.cmple(bounds.max).all());
    let is_room = views.iter().any(|view| is_outside(view.eye)) && viewpoint::is_enclosed(scene);
    // A view from outside is right if it sees fronts of surfaces: in a room without a front wall, or in a court from
    // above.
    let sees_front_of_surface = |view: &View| {
        let ray = Ray { origin: view.eye, direction: view.look_at - view.eye };
        viewpoint::first_hits(scene, &[ray]).iter().any(|hit| hit.facing)
    };
    let fault = |view: &View| {
        if is_room && is_outside(view.eye) && !sees_front_of_surface(view) {
            return Some("stands outside of the room and sees no front of its walls");
        }
        fault_of_picture(scene, view, PLANE_TOLERANCE * diagonal_m)
    };
    views.iter().map(fault).collect()
}

/// Returns the end of a warning about a file that does not name its coordinates. It says that positions were read
/// in the coordinates `read_as`, and how to change this.
fn hint(read_as: Handedness) -> String {
    let (word, other) = match read_as {
        Handedness::Left => ("left", Handedness::Right),
        Handedness::Right => ("right", Handedness::Left),
    };
    format!("; the file's places are read as {word}-handed: if they are not, write {}", other.toml_line())
}

/// Returns the fault of a view that sees nothing, or only one flat surface; `None` for any other view. `tolerance_m` is
/// the greatest distance from a plane, in metres, at which points count as lying in it.
fn fault_of_picture(scene: &Scene, view: &View, tolerance_m: f32) -> Option<&'static str> {
    let camera = view.camera(scene, [16, 9]);
    let frustum = Frustum::new(&(camera.view_to_clip() * camera.world_to_view));
    if !scene.meshes.iter().any(|mesh| frustum.may_see(mesh.bounds.min, mesh.bounds.max)) {
        return Some("sees no surface of the scene");
    }
    // A point and the normal of the first surface that a ray hits.
    let mut plane = None;
    // Rays are traced column by column, since most views show more than one surface in the first column.
    for column in rays(&camera).chunks(ROWS as usize) {
        for (ray, hit) in column.iter().zip(viewpoint::first_hits(scene, column)) {
            // A view with a ray that hits nothing has no fault: this ray sees the sky.
            let (point, normal) = (hit_point(ray, &hit)?, hit.normal.normalize_or_zero());
            let (plane_point, plane_normal) = *plane.get_or_insert((point, normal));
            let distance = (point - plane_point).dot(plane_normal).abs();
            if normal.dot(plane_normal).abs() < LEAST_COSINE || distance > tolerance_m {
                return None;
            }
        }
    }
    let (plane_point, plane_normal): (Vec3, Vec3) = plane?;
    // If all of the scene lies in one plane, the view cannot see more.
    let is_off_plane = |v: &Vertex| (Vec3::from(v.position) - plane_point).dot(plane_normal).abs() > tolerance_m;
    scene.meshes.iter().flat_map(|mesh| &mesh.vertices).any(is_off_plane).then_some("sees nothing but one flat surface")
}

/// Returns the point where a ray hits a surface; `None` if it hits none.
fn hit_point(ray: &Ray, hit: &Hit) -> Option<Vec3> {
    hit.distance.is_finite().then(|| ray.origin + hit.distance * ray.direction)
}

/// Returns rays that begin on the near plane and cover the whole picture, column by column.
fn rays(camera: &Camera) -> Vec<Ray> {
    let to_world = (camera.view_to_clip() * camera.world_to_view).as_dmat4().inverse();
    let cells = (0..COLUMNS).flat_map(|x| (0..ROWS).map(move |y| (x, y)));
    // Returns the normalised device coordinate of the middle of a cell.
    let ndc = |number: u32, count: u32| f64::from(2 * number + 1) / f64::from(count) - 1.0;
    let ray = |(x, y): (u32, u32)| {
        // A depth of 0 is the near plane.
        let [from, to] = [0.0, 0.5]
            .map(|depth| to_world.project_point3(glam::DVec3::new(ndc(x, COLUMNS), ndc(y, ROWS), depth)).as_vec3());
        Ray { origin: from, direction: to - from }
    };
    cells.map(ray).collect()
}

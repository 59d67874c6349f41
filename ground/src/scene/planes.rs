//! Finds the planes of many of a scene's triangles, where a mirrored camera can render a reflection (thesis §3.1.2).

use super::{Scene, Surface};
use glam::{DVec3, Vec3, Vec4};
use std::collections::HashMap;

/// How far a triangle may be from a plane and still belong to it, in metres.
pub const TOLERANCE_M: f32 = 5e-4;
/// How much a triangle's unit normal may differ from the plane's.
const NORMAL_TOLERANCE: f64 = 1e-3;
/// Groups smaller than this, in square metres, are not worth rendering a mirrored scene for.
const AREA_MIN_M2: f32 = 0.01;

/// Triangles of one material that lie in one plane and face the same side.
#[derive(Debug, Clone, PartialEq)]
pub struct CoplanarGroup {
    /// The plane in world space: the unit normal given by the triangles' winding, and the offset w, so that n ·
    /// x + w is the distance of a point in front of the plane.
    pub plane: Vec4,
    /// Index into [`Scene::materials`].
    pub material: usize,
    /// Sum of the triangles' areas in square metres.
    pub area_m2: f32,
    /// The triangles' corners in world space.
    pub triangles: Vec<[Vec3; 3]>,
}

/// Finds the coplanar groups of a scene's lit meshes, largest first. Groups below 0.01 m² are left out.
///
/// Triangles are grouped by their plane rounded to the tolerances. A plane that lies between two rounded values
/// may therefore give two groups, which [`merged`] joins.
pub fn coplanar_groups(scene: &Scene) -> Vec<CoplanarGroup> {
    let mut groups: HashMap<(usize, [i64; 4]), CoplanarGroup> = HashMap::new();
    let is_lit = |material: usize| scene.materials.get(material).is_none_or(|m| m.surface == Surface::Lit);
    for mesh in scene.meshes.iter().filter(|m| is_lit(m.material)) {
        for corners in mesh.indices.chunks_exact(3) {
            let triangle = [0, 1, 2].map(|i| Vec3::from(mesh.vertices[corners[i] as usize].position));
            let [a, b, c] = triangle.map(|p| p.as_dvec3());
            let cross = (b - a).cross(c - a); // twice as long as the triangle's area
            let Some(normal) = cross.try_normalize() else { continue };
            let offset = -normal.dot((a + b + c) / 3.0);
            let group = groups.entry((mesh.material, rounded(normal, offset))).or_insert_with(|| CoplanarGroup {
                plane: normal.extend(offset).as_vec4(),
                material: mesh.material,
                area_m2: 0.0,
                triangles: Vec::new(),
            });
            group.area_m2 += 0.5 * cross.length() as f32;
            group.triangles.push(triangle);
        }
    }
    largest_first(groups.into_values().filter(|g| g.area_m2 >= AREA_MIN_M2).collect())
}

/// Joins groups that lie in one plane, whatever their materials, and keeps the largest `count`, largest first.
/// A joined group has the plane and the material of its largest part.
pub fn merged<'a>(groups: impl Iterator<Item = &'a CoplanarGroup>, count: usize) -> Vec<CoplanarGroup> {
    let mut joined: Vec<CoplanarGroup> = Vec::new();
    for group in groups {
        match joined.iter_mut().find(|known| is_same_plane(known, group)) {
            Some(known) => {
                known.area_m2 += group.area_m2;
                known.triangles.extend_from_slice(&group.triangles);
            }
            None => joined.push(group.clone()),
        }
    }
    let mut joined = largest_first(joined);
    joined.truncate(count);
    joined
}

/// Returns a plane's normal and offset in whole steps of the tolerances: nearly equal planes have equal numbers.
fn rounded(normal: DVec3, offset: f64) -> [i64; 4] {
    let steps = |value: f64, step: f64| (value / step).round() as i64;
    let [x, y, z] = normal.to_array().map(|v| steps(v, NORMAL_TOLERANCE));
    [x, y, z, steps(offset, f64::from(TOLERANCE_M))]
}

/// Whether the first triangle of `group` lies in the plane of `known` and faces the same way.
fn is_same_plane(known: &CoplanarGroup, group: &CoplanarGroup) -> bool {
    let normal = known.plane.truncate();
    let is_near = |p: &Vec3| (normal.dot(*p) + known.plane.w).abs() <= 2.0 * TOLERANCE_M;
    let faces_the_same_way = normal.distance(group.plane.truncate()) <= 2.0 * NORMAL_TOLERANCE as f32;
    faces_the_same_way && group.triangles.first().is_some_and(|t| t.iter().all(is_near))
}

/// Sorts by area. Ties are ordered by material and plane, so that the order does not depend on that of a hash map.
fn largest_first(mut groups: Vec<CoplanarGroup>) -> Vec<CoplanarGroup> {
    let key = |g: &CoplanarGroup| (g.material, g.plane.to_array().map(f32::to_bits));
    groups.sort_by(|a, b| b.area_m2.total_cmp(&a.area_m2).then_with(|| key(a).cmp(&key(b))));
    groups
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Material, Mesh, Vertex};

    fn quad(corner: Vec3, u: Vec3, v: Vec3, material: usize) -> Mesh {
        let vertex = |p: Vec3| Vertex { position: p.to_array(), normal: [0.0; 3], uv: [0.0; 2], tangent: [0.0; 4] };
        let vertices = vec![vertex(corner), vertex(corner + u), vertex(corner + u + v), vertex(corner + v)];
        Mesh { vertices, indices: vec![0, 1, 2, 0, 2, 3], material, ..Mesh::default() }
    }

    #[test]
    fn triangles_are_grouped_by_plane_side_and_material() {
        let floor = |x: f32, material| quad(Vec3::new(x, 0.0, 0.0), Vec3::Z * 2.0, Vec3::X, material);
        let scene = Scene {
            meshes: vec![
                floor(0.0, 0),
                floor(5.0, 0),
                floor(9.0, 1),
                quad(Vec3::Y, Vec3::Z, Vec3::X, 0),          // higher
                quad(Vec3::ZERO, Vec3::X, Vec3::Z * 0.5, 0), // facing down
                quad(Vec3::ZERO, Vec3::Z * 4.0, Vec3::X, 2), // a window
            ],
            materials: vec![
                Material::default(),
                Material::default(),
                Material { surface: Surface::Sky, ..Material::default() },
            ],
            ..Scene::default()
        };
        let groups = coplanar_groups(&scene);
        let found: Vec<_> = groups.iter().map(|g| (g.material, g.plane.y, g.plane.w, g.area_m2)).collect();
        assert_eq!(found, [(0, 1.0, 0.0, 4.0), (1, 1.0, 0.0, 2.0), (0, 1.0, -1.0, 1.0), (0, -1.0, 0.0, 0.5)]);
        let joined = merged(groups.iter(), 2);
        let found: Vec<_> = joined.iter().map(|g| (g.area_m2, g.triangles.len(), g.plane.w)).collect();
        assert_eq!(found, [(6.0, 6, 0.0), (1.0, 2, -1.0)]);
    }

    #[test]
    fn triangles_of_a_tilted_plane_are_joined_despite_rounding() {
        // Many small triangles of a plane that is parallel to no axis; each corner is rounded to f32 separately.
        let (u, v) = (Vec3::new(0.8, 0.1, 0.3).normalize(), Vec3::new(-0.2, 0.9, 0.4).normalize());
        let corner = |i: u32, j: u32| Vec3::new(7.0, -3.0, 11.0) + u * i as f32 * 0.1 + v * j as f32 * 0.1;
        let meshes = (0..1600).map(|k| quad(corner(k % 40, k / 40), u * 0.1, v * 0.1, 0)).collect();
        let scene = Scene { meshes, materials: vec![Material::default()], ..Scene::default() };
        let groups = merged(coplanar_groups(&scene).iter(), 8);
        let share = groups[0].triangles.len() as f32 / 3200.0;
        assert!(share > 0.99, "{share} of the triangles in {} groups", groups.len());
    }
}

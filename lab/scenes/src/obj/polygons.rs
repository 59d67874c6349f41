//! Makes triangles with normals, in world space, from the groups and polygons that tobj finds.

use super::text::Statements;
use super::{Handedness, ObjOptions};
use crate::{MAX_COORDINATE_M, Vertex};
use glam::{DVec2, DVec3, Vec3};
use ssct_geometry::assemble::{MeshPart, Triangle, normals_point_behind};
use ssct_ground::{Error, Result};
use std::collections::HashMap;
use std::io::Read;
use std::path::Path;

/// The mesh of one group of an OBJ file while it is built. A vertex whose normal is zero has no normal yet.
struct GroupPart {
    mesh_part: MeshPart,
    /// Smoothing group of each triangle; 0 means no group.
    smoothing: Vec<u32>,
}

/// Builds the parts of the file at `path` from its normalised statements. Errors and warnings name that path.
pub(super) fn build(
    path: &Path,
    statements: Statements,
    options: &ObjOptions,
    warnings: &mut Vec<String>,
) -> Result<Vec<MeshPart>> {
    let Statements { vertices, faces, material_names, smoothing, .. } = statements;
    // The statements name materials by their indices; tobj gets a library with these names.
    let materials: Vec<_> = (0..material_names.len())
        .map(|index| tobj::Material { name: index.to_string(), ..Default::default() })
        .collect();
    let by_name = materials.iter().enumerate().map(|(index, material)| (material.name.clone(), index));
    let library = Ok((materials.clone(), by_name.collect()));
    let tobj_options = tobj::LoadOptions { single_index: true, ..Default::default() };
    let (models, _) =
        tobj::load_obj_buf(&mut vertices.as_bytes().chain(faces.as_bytes()), &tobj_options, |_| library.clone())
            .map_err(|e| Error::malformed(path, None, format!("cannot be read: {e}")))?;
    drop((vertices, faces));

    let mut smoothing = smoothing.into_iter();
    let mut groups = Vec::new();
    let mut without_area = 0;
    for tobj::Model { mesh, name } in models.into_iter().filter(|model| !model.mesh.indices.is_empty()) {
        let corners = world_vertices(path, &mesh, options)?;
        let material = mesh.material_id.unwrap_or_default();
        let mesh_part = MeshPart { name, material, triangles: Vec::new(), has_tangents: false };
        let mut group = GroupPart { mesh_part, smoothing: Vec::new() };
        let mut start = 0;
        // tobj lists no numbers of corners (arities) if all faces of a group are triangles.
        let arities = match mesh.face_arities.is_empty() {
            true => vec![3; mesh.indices.len() / 3],
            false => mesh.face_arities.iter().map(|&arity| arity as usize).collect(),
        };
        for arity in arities {
            let polygon: Vec<Vertex> =
                mesh.indices[start..start + arity].iter().map(|&index| corners[index as usize]).collect();
            start += arity;
            without_area += group.push(&polygon, smoothing.next().unwrap_or(0), options.handedness);
        }
        groups.push(group);
    }
    if groups.iter().all(|group| group.mesh_part.triangles.is_empty()) {
        return Err(Error::malformed(path, None, "no face of this file has an area"));
    }
    if without_area > 0 {
        let (plural, were) = if without_area == 1 { ("triangle", "was") } else { ("triangles", "were") };
        warnings.push(format!("{}: {without_area} {plural} without area {were} left out", path.display()));
    }
    groups.retain(|group| !group.mesh_part.triangles.is_empty());
    fill_normals(&mut groups);
    Ok(groups.into_iter().map(|group| group.mesh_part).collect())
}

/// Returns the vertices of a group in world space, in metres. A normal that is missing or has no length becomes zero.
fn world_vertices(path: &Path, mesh: &tobj::Mesh, options: &ObjOptions) -> Result<Vec<Vertex>> {
    let mirror = match options.handedness {
        Handedness::Right => Vec3::new(1.0, 1.0, -1.0),
        Handedness::Left => Vec3::ONE,
    };
    // Adding zero turns −0 into 0, so that welding finds equal bits.
    let to_world = |xyz: &[f32], factor: Vec3| Vec3::new(xyz[0], xyz[1], xyz[2]) * factor + Vec3::ZERO;
    let positions = mesh.positions.chunks_exact(3);
    let attributes = mesh.normals.chunks_exact(3).zip(mesh.texcoords.chunks_exact(2));
    let vertices = positions.zip(attributes).map(|(position, (normal, uv))| {
        let position = to_world(position, mirror * options.load.scale);
        if position.abs().max_element() > MAX_COORDINATE_M {
            let message = format!("a vertex lies more than {MAX_COORDINATE_M:e} m from the origin");
            return Err(Error::malformed(path, None, message));
        }
        let normal = to_world(normal, mirror).as_dvec3().normalize_or_zero().as_vec3();
        // tobj marks a corner without texture coordinates by NaN.
        let uv = if uv[0].is_nan() { [0.0, 0.0] } else { [uv[0] + 0.0, 1.0 - uv[1]] };
        let position = position.to_array();
        Ok(Vertex { position, normal: normal.to_array(), uv, tangent: [0.0; 4] })
    });
    vertices.collect()
}

impl GroupPart {
    /// Adds the triangles of a polygon. The winding of a triangle is reversed if its stated normals point behind it.
    /// Triangles without area are left out, and their number is returned. `smoothing` is the smoothing group of the
    /// polygon.
    fn push(&mut self, polygon: &[Vertex], smoothing: u32, handedness: Handedness) -> usize {
        let mut without_area = 0;
        let positions: Vec<DVec3> = polygon.iter().map(position).collect();
        for [a, b, c] in triangulate(&positions) {
            let (b, c) = if handedness == Handedness::Right { (c, b) } else { (b, c) };
            let mut triangle = [polygon[a], polygon[b], polygon[c]];
            let edges = [1, 2, 0].map(|end| position(&triangle[end]) - position(&triangle[(end + 2) % 3]));
            let longest_squared = edges.iter().map(|edge| edge.length_squared()).fold(0.0, f64::max);
            let cross = twice_area(&triangle);
            if cross.length() <= 1e-7 * longest_squared {
                without_area += 1;
                continue;
            }
            if normals_point_behind(&triangle, cross.normalize()) {
                triangle.swap(1, 2);
            }
            self.mesh_part.triangles.push(triangle);
            self.smoothing.push(smoothing);
        }
        without_area
    }
}

/// Gives every vertex that lacks a normal the normal of its smoothing group or of its face.
///
/// Within a group, a vertex gets the mean of the normals of the faces at its position. Faces are weighted by their
/// angle at the vertex; weights by area would depend on the diagonal that splits a quad.
fn fill_normals(parts: &mut [GroupPart]) {
    let key = |v: &Vertex, group: u32| (v.position.map(f32::to_bits), group);
    // The weighted sums of face normals, by the bits of the position and the smoothing group; group 0 means no group.
    let mut normal_sums: HashMap<([u32; 3], u32), DVec3> = HashMap::new();
    for part in parts.iter() {
        let smoothed = part.mesh_part.triangles.iter().zip(&part.smoothing).filter(|(_, group)| **group != 0);
        for (triangle, &group) in smoothed {
            let face_normal = twice_area(triangle).normalize();
            for (corner, vertex) in triangle.iter().enumerate().filter(|(_, vertex)| vertex.normal == [0.0; 3]) {
                *normal_sums.entry(key(vertex, group)).or_default() += angle(triangle, corner) * face_normal;
            }
        }
    }
    for part in parts {
        for (triangle, &group) in part.mesh_part.triangles.iter_mut().zip(&part.smoothing) {
            let face_normal = twice_area(triangle).normalize();
            let stated = *triangle;
            // Sets each normal that the file does not state to the normal that `normal_of` returns.
            let fill = |triangle: &mut Triangle, normal_of: &dyn Fn(&Vertex) -> DVec3| {
                for (vertex, stated) in triangle.iter_mut().zip(&stated).filter(|(_, vertex)| vertex.normal == [0.0; 3])
                {
                    // Adding zero turns −0 into 0, so that welding finds equal bits.
                    vertex.normal = (normal_of(stated).as_vec3().normalize() + Vec3::ZERO).to_array();
                }
            };
            fill(triangle, &|vertex| {
                let mean_normal =
                    normal_sums.get(&key(vertex, group)).map_or(face_normal, |sum| sum.normalize_or_zero());
                // At a sharp fold, the mean may point behind the face.
                if mean_normal.dot(face_normal) > 0.0 { mean_normal } else { face_normal }
            });
            // If stated normals lean behind the face, the sum with a mean normal that is almost perpendicular to the
            // face may point to its back.
            if normals_point_behind(triangle, face_normal) {
                fill(triangle, &|_| face_normal);
            }
        }
    }
}

/// Returns the position of a vertex, in 64 bits.
fn position(vertex: &Vertex) -> DVec3 {
    Vec3::from(vertex.position).as_dvec3()
}

/// Returns (b − a) × (c − a) for the corners of a triangle: its normal, with twice its area as the length.
fn twice_area(triangle: &Triangle) -> DVec3 {
    let [a, b, c] = triangle.each_ref().map(position);
    (b - a).cross(c - a)
}

/// Returns the angle of a triangle at a corner (0, 1 or 2), in radians.
fn angle(triangle: &Triangle, corner: usize) -> f64 {
    let [apex, next, last] = [0, 1, 2].map(|offset| position(&triangle[(corner + offset) % 3]));
    (next - apex).angle_between(last - apex)
}

/// Cuts a polygon of n corners into n − 2 triangles of the same orientation, given as indices of corners. A convex
/// polygon becomes a fan. From other polygons ears are cut off: triangles at a corner that contain no other corner. If
/// no ear is left, because the polygon crosses itself, the remainder becomes a fan.
fn triangulate(polygon: &[DVec3]) -> Vec<[usize; 3]> {
    let fan = |corners: &[usize]| -> Vec<[usize; 3]> {
        corners[1..].windows(2).map(|pair| [corners[0], pair[0], pair[1]]).collect()
    };
    let mut corners: Vec<usize> = (0..polygon.len()).collect();
    if polygon.len() <= 3 {
        return fan(&corners);
    }
    let projected = project(polygon);
    // Positive if the corners a, b and c turn to the left, and negative if they turn to the right.
    let turn = |a: usize, b: usize, c: usize| {
        #[cfg(test)]
        tests::TURNS.set(tests::TURNS.get() + 1);
        (projected[b] - projected[a]).perp_dot(projected[c] - projected[b])
    };
    let count = polygon.len();
    if (0..count).all(|corner| turn(corner, (corner + 1) % count, (corner + 2) % count) >= 0.0) {
        return fan(&corners);
    }
    let mut triangles = Vec::with_capacity(count - 2);
    // Returns true if the triangle at the corner number `tip` of the remaining polygon is an ear.
    let is_ear = |corners: &[usize], tip: usize| {
        let count = corners.len();
        let [a, b, c] = [corners[(tip + count - 1) % count], corners[tip], corners[(tip + 1) % count]];
        let is_inside = |other: usize| {
            let is_apart = [a, b, c].iter().all(|&corner| projected[corner] != projected[other]);
            is_apart && turn(a, b, other) >= 0.0 && turn(b, c, other) >= 0.0 && turn(c, a, other) >= 0.0
        };
        turn(a, b, c) > 0.0 && !corners.iter().any(|&other| is_inside(other))
    };
    // In a polygon that does not cross itself, cutting off an ear can change only whether its two neighbours are ears.
    // The work therefore grows with the square of the number of corners.
    let mut ears: Vec<bool> = (0..count).map(|tip| is_ear(&corners, tip)).collect();
    while corners.len() > 3 {
        let Some(ear) = ears.iter().position(|&ear| ear) else { break };
        let count = corners.len();
        triangles.push([corners[(ear + count - 1) % count], corners[ear], corners[(ear + 1) % count]]);
        corners.remove(ear);
        ears.remove(ear);
        for neighbour in [(ear + count - 2) % (count - 1), ear % (count - 1)] {
            ears[neighbour] = is_ear(&corners, neighbour);
        }
    }
    triangles.extend(fan(&corners));
    triangles
}

/// Projects the polygon to its own plane, whose normal is that of Newell's method. The projected corners run
/// counter-clockwise.
fn project(polygon: &[DVec3]) -> Vec<DVec2> {
    let next = polygon.iter().cycle().skip(1);
    let normal: DVec3 = polygon.iter().zip(next).map(|(a, b)| (a - polygon[0]).cross(b - polygon[0])).sum();
    let normal = normal.try_normalize().unwrap_or(DVec3::Z);
    let (x, y) = normal.any_orthonormal_pair();
    polygon.iter().map(|corner| DVec2::new((corner - polygon[0]).dot(x), (corner - polygon[0]).dot(y))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    thread_local! {
        /// Number of times that [`triangulate`] computed the turn of three corners.
        pub static TURNS: Cell<u64> = const { Cell::new(0) };
    }

    /// Tests a triangle with two stated normals at 111 degrees from the face's normal, which an author may want. The
    /// mean normal at the third corner, to which two other faces contribute, is almost perpendicular to that of the
    /// face. The sum of the three normals would be at 126 degrees from it.
    #[test]
    fn means_do_not_turn_a_face_to_its_back() {
        let corner =
            |position: [f32; 3], normal: [f32; 3]| Vertex { position, normal, uv: [0.0; 2], tangent: [0.0; 4] };
        let (lean, none) = ([0.9950372, 0.0, -0.09950372], [0.0; 3]);
        let shared = [0.0, 1.0, 0.0];
        let triangles = vec![
            [corner([0.0; 3], lean), corner(shared, none), corner([1.0, 1.0, -0.5], lean)],
            // A face in the same plane, with reversed winding and an angle of a little less than 90 degrees at the
            // shared corner.
            [corner(shared, none), corner([0.1, 0.0, -0.05], none), corner([1.0, 1.0, -0.5], none)],
            // A face perpendicular to both.
            [corner(shared, none), corner([0.447, 1.0, 0.894], none), corner([0.0, 2.0, 0.0], none)],
        ];
        let mesh_part = MeshPart { name: String::new(), material: 0, triangles, has_tangents: false };
        let mut parts = [GroupPart { mesh_part, smoothing: vec![1; 3] }];
        fill_normals(&mut parts);
        let triangle = &parts[0].mesh_part.triangles[0];
        let face = twice_area(triangle).normalize();
        assert!(!normals_point_behind(triangle, face), "{triangle:?}");
        assert_eq!((triangle[0].normal, triangle[2].normal), (lean, lean), "what is stated stays");
        assert!(Vec3::from(triangle[1].normal).as_dvec3().dot(face) > 0.999, "{triangle:?}");
    }

    /// Returns the sum of the areas of the triangles of a flat polygon, and the same sum with signs. The two are equal
    /// if all triangles have the same orientation.
    fn area(polygon: &[DVec3], triangles: &[[usize; 3]]) -> (f64, f64) {
        let cross = |&[a, b, c]: &[usize; 3]| (polygon[b] - polygon[a]).cross(polygon[c] - polygon[a]);
        let sum: DVec3 = triangles.iter().map(cross).sum();
        (0.5 * triangles.iter().map(|triangle| cross(triangle).length()).sum::<f64>(), 0.5 * sum.length())
    }

    #[test]
    fn a_concave_polygon_is_covered_once() {
        let arrow = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.0, 1.0], [0.0, 4.0]];
        let polygon = arrow.map(|[x, y]| DVec3::new(x, 3.0, -y));
        let triangles = triangulate(&polygon);
        assert_eq!(triangles.len(), 3);
        let (unsigned, signed) = area(&polygon, &triangles);
        // The shoelace formula gives 10; overlapping triangles would sum to more.
        assert!((unsigned - 10.0).abs() < 1e-9 && (signed - 10.0).abs() < 1e-9, "{unsigned} {signed}");
    }

    #[test]
    fn a_dart_is_cut_along_its_inner_diagonal() {
        let dart = [[0.0, 0.0], [2.0, 1.0], [4.0, 0.0], [2.0, 4.0]];
        for start in 0..4 {
            let polygon: Vec<_> =
                (0..4).map(|corner| dart[(corner + start) % 4]).map(|[x, y]| DVec3::new(x, y, 0.0)).collect();
            let (unsigned, signed) = area(&polygon, &triangulate(&polygon));
            assert!((unsigned - signed).abs() < 1e-9, "start {start}: {unsigned} {signed}");
        }
    }

    /// Makes a spiral of two arms, which has few ears at any time.
    fn spiral(corners: usize) -> Vec<DVec3> {
        let arm = |corner: usize, radius: f64| {
            let angle = corner as f64 * 0.2;
            DVec3::new(angle.cos(), angle.sin(), 0.0) * (radius + 0.3 * angle)
        };
        let half = corners / 2;
        (0..half).map(|corner| arm(corner, 1.0)).chain((0..half).rev().map(|corner| arm(corner, 1.5))).collect()
    }

    #[test]
    fn a_spiral_of_many_corners_is_covered_once() {
        let polygon = spiral(1024);
        let triangles = triangulate(&polygon);
        assert_eq!(triangles.len(), 1022);
        let (unsigned, signed) = area(&polygon, &triangles);
        assert!((unsigned - signed).abs() < 1e-6 * signed, "{unsigned} {signed}");
    }

    #[test]
    fn the_work_of_a_cut_grows_with_the_square_of_the_corners() {
        let [few, many] = [256, 1024].map(|corners| {
            TURNS.set(0);
            triangulate(&spiral(corners));
            TURNS.get()
        });
        // Four times the corners take 16 times the work; a cubic algorithm would take 64 times the work.
        assert!(many < 20 * few, "{few} turns for 256 corners, {many} for 1024");
    }

    #[test]
    fn any_polygon_gives_two_fewer_triangles_than_corners() {
        let crossing = [[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0], [1.0, 5.0]];
        let polygon = crossing.map(|[x, y]| DVec3::new(x, y, 0.0));
        assert_eq!(triangulate(&polygon).len(), 3);
        assert_eq!(triangulate(&[DVec3::ONE; 6]).len(), 4);
    }
}

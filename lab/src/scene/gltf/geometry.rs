//! Triangles of a primitive, in the world.

use super::data::Data;
use super::materials::Coordinates;
use super::{MAX_TRIANGLES, Notes};
use crate::error::Result;
use crate::scene::assemble::{MeshPart, Triangle};
use crate::scene::{MAX_COORDINATE_M, Vertex};
use glam::{DMat3, DMat4, DVec3, Vec3};
use gltf::Semantic;
use gltf::mesh::{Mode, Primitive};

/// A placement of meshes in the world.
pub(super) struct ToWorld {
    /// To the world, which is left-handed.
    to_world: DMat4,
    /// The cofactors of its linear part, which turn normals.
    cofactors: DMat3,
    /// −1 if it mirrors, 1 otherwise.
    sign: f64,
}

impl ToWorld {
    pub(super) fn new(to_world: DMat4) -> Self {
        let linear = DMat3::from_mat4(to_world);
        let [x, y, z] = [linear.x_axis, linear.y_axis, linear.z_axis];
        let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
        let sign = if linear.determinant() < 0.0 { -1.0 } else { 1.0 };
        Self { to_world, cofactors, sign }
    }

    /// A unit normal in the world; zero if there is none.
    fn normal(&self, local: [f32; 3]) -> DVec3 {
        (self.sign * (self.cofactors * Vec3::from(local).as_dvec3())).normalize_or_zero()
    }

    /// A tangent in the world. The bitangent w · n × t turns with the surface, so that w follows a mirroring.
    fn tangent(&self, [x, y, z, w]: [f32; 4]) -> [f32; 4] {
        let along = self.to_world.transform_vector3(DVec3::new(x.into(), y.into(), z.into())).normalize_or_zero();
        let w = if f64::from(w) * self.sign < 0.0 { -1.0 } else { 1.0 };
        // Adding zero turns −0 into 0, so that welding finds equal bits.
        (along.as_vec3() + Vec3::ZERO).extend(w).to_array()
    }
}

/// The triangles of a primitive that is placed in the world, or nothing if it has none. `triangles` counts those of the
/// file.
pub(super) fn part(
    data: &Data,
    (primitive, name, material): (&Primitive, &str, usize),
    coordinates: &Coordinates,
    placement: &ToWorld,
    triangles: &mut usize,
    notes: &mut Notes,
) -> Result<Option<MeshPart>> {
    if matches!(primitive.mode(), Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) {
        notes.add("lines", "points and lines are not drawn".to_owned());
        return Ok(None);
    }
    if primitive.morph_targets().next().is_some() {
        notes.add("morphs", "morph targets are not supported; meshes have their base shape".to_owned());
    }
    if primitive.get(&Semantic::Colors(0)).is_some() {
        notes.add("colours", "colours of vertices are not supported and were ignored".to_owned());
    }
    let Some(positions) = primitive.get(&Semantic::Positions) else { return Ok(None) };
    let positions: Vec<[f32; 3]> = data.vectors(&positions, &Semantic::Positions)?;
    let count = positions.len();
    let normals = attribute::<3>(data, primitive, Semantic::Normals, count)?;
    // Without normals, tangents mean nothing (glTF 2.0, 3.7.2.1).
    let tangents = match normals {
        Some(_) => attribute::<4>(data, primitive, Semantic::Tangents, count)?,
        None => None,
    };
    let uvs = attribute::<2>(data, primitive, Semantic::TexCoords(coordinates.set), count)?;
    let indices = match primitive.indices() {
        Some(accessor) => data.indices(&accessor)?,
        None => (0..count as u32).collect(),
    };
    let corners = corners(primitive.mode(), &indices);
    *triangles += corners.len();
    if *triangles > MAX_TRIANGLES {
        return Err(data.error(format!("places more than {MAX_TRIANGLES} triangles in the world")));
    }
    let place = |i: usize| {
        let position = placement.to_world.transform_point3(Vec3::from(positions[i]).as_dvec3());
        if !position.is_finite() || position.abs().max_element() > f64::from(MAX_COORDINATE_M) {
            let message = format!("mesh {name}: a vertex lies more than {MAX_COORDINATE_M:e} m from the origin");
            return Err(data.error(message));
        }
        let uv = uvs.as_ref().map_or(Ok([0.0; 2]), |all| {
            let uv = coordinates.place(all[i]);
            let finite = uv.iter().all(|v| v.is_finite());
            if finite { Ok(uv) } else { Err(data.error(format!("mesh {name}: a texture coordinate is not finite"))) }
        })?;
        Ok(Vertex {
            position: (position.as_vec3() + Vec3::ZERO).to_array(),
            normal: normals.as_ref().map_or(DVec3::ZERO, |all| placement.normal(all[i])).as_vec3().to_array(),
            uv,
            tangent: tangents.as_ref().map_or([0.0; 4], |all| placement.tangent(all[i])),
        })
    };
    let vertices = (0..count).map(place).collect::<Result<Vec<_>>>()?;
    let outside = |v: f32| !(-1e-3..=1.001).contains(&v);
    if coordinates.clamps && vertices.iter().any(|v| v.uv.iter().any(|v| outside(*v))) {
        notes.add("clamps", "images that are clamped or mirrored at their border are repeated instead".to_owned());
    }
    let mut part = MeshPart {
        name: name.to_owned(),
        material,
        triangles: Vec::with_capacity(corners.len()),
        has_tangents: tangents.is_some(),
    };
    for triangle in corners {
        let [a, b, c] = triangle.map(|i| vertices.get(i as usize).copied());
        let (Some(a), Some(b), Some(c)) = (a, b, c) else {
            return Err(data.error(format!("mesh {name}: an index is not below the {count} vertices")));
        };
        let triangle = if placement.sign < 0.0 { [a, c, b] } else { [a, b, c] };
        match finished(triangle) {
            Some(triangle) => part.triangles.push(triangle),
            None => notes.add("area", "triangles without area were left out".to_owned()),
        }
    }
    Ok(Some(part).filter(|p| !p.triangles.is_empty()))
}

fn attribute<const N: usize>(
    data: &Data,
    primitive: &Primitive,
    semantic: Semantic,
    count: usize,
) -> Result<Option<Vec<[f32; N]>>> {
    let Some(accessor) = primitive.get(&semantic) else { return Ok(None) };
    let all = data.vectors(&accessor, &semantic)?;
    if all.len() != count {
        let (what, index) = (semantic.to_string(), accessor.index());
        return Err(data.error(format!("accessor {index} of {what} has {} elements for {count} vertices", all.len())));
    }
    Ok(Some(all))
}

/// The corners of the triangles of a mode, each in the order of its front.
fn corners(mode: Mode, indices: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => {
            let turned = |(k, w): (usize, &[u32])| if k % 2 == 0 { [w[0], w[1], w[2]] } else { [w[0], w[2], w[1]] };
            indices.windows(3).enumerate().map(turned).collect()
        }
        Mode::TriangleFan => {
            let (Some((first, rest)), 3..) = (indices.split_first(), indices.len()) else { return Vec::new() };
            rest.windows(2).map(|w| [*first, w[0], w[1]]).collect()
        }
        _ => indices.as_chunks::<3>().0.to_vec(),
    }
}

/// The triangle with unit normals on the side of its front; `None` if it has no area.
fn finished(mut triangle: Triangle) -> Option<Triangle> {
    let at = |i: usize| Vec3::from(triangle[i].position).as_dvec3();
    let edges = [at(1) - at(0), at(2) - at(1), at(0) - at(2)];
    let cross = edges[0].cross(-edges[2]);
    let longest = edges.iter().map(|e| e.length_squared()).fold(0.0, f64::max);
    if cross.length() <= 1e-7 * longest {
        return None;
    }
    let stated: DVec3 = triangle.iter().map(|v| Vec3::from(v.normal).as_dvec3()).sum();
    let turned = stated.dot(cross) < 0.0;
    let flat = cross.normalize().as_vec3();
    for vertex in &mut triangle {
        let mut normal = Vec3::from(vertex.normal);
        if turned {
            normal = -normal;
            vertex.tangent[3] = -vertex.tangent[3];
        }
        let sound = normal.is_finite() && normal != Vec3::ZERO;
        vertex.normal = (if sound { normal } else { flat } + Vec3::ZERO).to_array();
    }
    Some(triangle)
}

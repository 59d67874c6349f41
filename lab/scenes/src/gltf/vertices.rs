//! The vertices of a primitive: reads attributes, morph targets and skin, and places each vertex in the world.

use super::Notes;
use super::data::{Data, Vectors};
use super::materials::Coordinates;
use crate::{MAX_COORDINATE_M, Vertex};
use bytemuck::Zeroable;
use glam::{DMat3, DMat4, DVec3, Vec3};
use gltf::Semantic;
use gltf::mesh::Primitive;
use ssct_geometry::bounded;
use ssct_ground::Result;
use std::collections::HashMap;
use std::collections::hash_map::Entry;

/// A transform of vertices from a mesh to the world.
#[derive(Debug, Clone, Copy)]
pub(super) struct ToWorld {
    /// Matrix from the mesh to the world, which is left-handed.
    to_world: DMat4,
    /// Cofactors of the matrix's linear part, which transform normals.
    cofactors: DMat3,
    /// −1 if the matrix mirrors, 1 otherwise.
    mirror_sign: f64,
}

impl ToWorld {
    /// Computes the cofactors of a matrix to the world, and the sign of its determinant.
    pub(super) fn new(to_world: DMat4) -> Self {
        let linear = DMat3::from_mat4(to_world);
        let [x, y, z] = [linear.x_axis, linear.y_axis, linear.z_axis];
        let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
        let mirror_sign = if linear.determinant() < 0.0 { -1.0 } else { 1.0 };
        Self { to_world, cofactors, mirror_sign }
    }

    /// Transforms a normal to a unit normal in the world; zero stays zero.
    fn normal(&self, local: DVec3) -> DVec3 {
        (self.mirror_sign * (self.cofactors * local)).normalize_or_zero()
    }

    /// Transforms a tangent, with the sign w of its bitangent, to a unit tangent in the world. The bitangent w · n × t
    /// is transformed with the surface, so that a mirroring changes the sign of w.
    fn tangent(&self, [x, y, z, w]: [f32; 4]) -> [f32; 4] {
        let direction = self.to_world.transform_vector3(DVec3::new(x.into(), y.into(), z.into())).normalize_or_zero();
        let w = if f64::from(w) * self.mirror_sign < 0.0 { -1.0 } else { 1.0 };
        // Adding zero turns −0 into 0, so that welding finds equal bits.
        (direction.as_vec3() + Vec3::ZERO).extend(w).to_array()
    }
}

/// How the vertices of a mesh are placed in the world.
pub(super) enum MeshPlacement {
    /// The transform of the node places all vertices.
    Node(ToWorld),
    /// The joints of a skin place each vertex; these are their matrices from the mesh to the world. The node's own
    /// transform is ignored (glTF 2.0, 3.7.3.3).
    Skin(Vec<DMat4>),
}

/// A mesh that a node places.
pub(super) struct PlacedMesh<'a> {
    /// Name in messages and labels.
    pub(super) name: &'a str,
    pub(super) placement: &'a MeshPlacement,
    /// Weight of each morph target.
    pub(super) weights: &'a [f32],
    /// Offset that is subtracted from every position in the world, in metres.
    pub(super) origin: DVec3,
}

/// A vertex in the world.
#[derive(Debug, Clone, Copy)]
pub(super) struct PlacedVertex {
    pub(super) vertex: Vertex,
    /// Position before rounding to 32-bit floats.
    pub(super) position: DVec3,
    /// −1 if the placement mirrors, 1 otherwise.
    pub(super) mirror_sign: f64,
}

impl Default for PlacedVertex {
    fn default() -> Self {
        Self { vertex: Vertex::zeroed(), position: DVec3::ZERO, mirror_sign: 1.0 }
    }
}

/// The vertices of a primitive that were placed so far. If the primitive draws only a few of many vertices, a map takes
/// less memory than a list of all.
pub(super) enum PlacedVertices {
    /// An entry for each vertex of the primitive, by index.
    All(Vec<Option<PlacedVertex>>),
    /// The vertices that were placed, by index.
    Few(HashMap<u32, PlacedVertex>),
}

impl PlacedVertices {
    /// Makes an empty store for a primitive with `count` vertices and `triangles` triangles. With more than 12 vertices
    /// for each triangle, the primitive draws few of them.
    pub(super) fn new(count: usize, triangles: usize) -> Self {
        if count <= 12 * triangles { Self::All(vec![None; count]) } else { Self::Few(HashMap::new()) }
    }

    /// Returns the vertex with an index. When it is first needed, it is placed by calling `place`.
    pub(super) fn get(&mut self, index: u32, place: impl FnOnce() -> Result<PlacedVertex>) -> Result<PlacedVertex> {
        Ok(match self {
            Self::All(vertices) => match vertices.get_mut(index as usize) {
                Some(Some(placed)) => *placed,
                Some(vacant) => *vacant.insert(place()?),
                // `place` returns an error, since there is no such vertex.
                None => place()?,
            },
            Self::Few(vertices) => match vertices.entry(index) {
                Entry::Occupied(placed) => *placed.get(),
                Entry::Vacant(vacant) => *vacant.insert(place()?),
            },
        })
    }
}

/// A morph target with its weight: offsets that are added to positions and normals.
struct Morph<'a> {
    weight: f64,
    positions: Option<Vectors<'a, 3>>,
    normals: Option<Vectors<'a, 3>>,
}

/// The vertices of a primitive as the file has them, with their placement.
pub(super) struct MeshVertices<'a> {
    data: &'a Data<'a>,
    mesh: &'a PlacedMesh<'a>,
    coordinates: &'a Coordinates,
    pub(super) count: usize,
    pub(super) has_tangents: bool,
    positions: Vectors<'a, 3>,
    normals: Option<Vectors<'a, 3>>,
    tangents: Option<Vectors<'a, 4>>,
    uvs: Option<Vectors<'a, 2>>,
    morphs: Vec<Morph<'a>>,
    /// Sets of joints that move each vertex. A set has the indices of four joints, and then their weights.
    influences: Vec<[Vectors<'a, 4>; 2]>,
}

impl<'a> MeshVertices<'a> {
    /// Finds the attributes of a primitive; `None` for a primitive without positions, which is not drawn.
    pub(super) fn new(
        data: &'a Data,
        primitive: &Primitive,
        mesh: &'a PlacedMesh,
        coordinates: &'a Coordinates,
    ) -> Result<Option<Self>> {
        let Some(accessor) = primitive.get(&Semantic::Positions) else { return Ok(None) };
        let positions = data.vectors::<3>(&accessor, &Semantic::Positions)?;
        data.check_claim(accessor.index(), &positions.elements)?;
        let count = positions.len();
        let normals = attribute::<3>(data, primitive, Semantic::Normals, count)?;
        // Without normals, tangents have no meaning (glTF 2.0, 3.7.2.1).
        let tangents = match normals {
            Some(_) => attribute::<4>(data, primitive, Semantic::Tangents, count)?,
            None => None,
        };
        let uvs = attribute::<2>(data, primitive, Semantic::TexCoords(coordinates.set), count)?;
        let morphs = morphs(data, primitive, mesh.weights, count)?;
        let influences = match mesh.placement {
            MeshPlacement::Node(_) => Vec::new(),
            MeshPlacement::Skin(_) => influences(data, primitive, count)?,
        };
        let has_tangents = tangents.is_some();
        Ok(Some(Self {
            data,
            mesh,
            coordinates,
            count,
            has_tangents,
            positions,
            normals,
            tangents,
            uvs,
            morphs,
            influences,
        }))
    }

    /// Places the vertex at an index in the world.
    ///
    /// # Errors
    /// [`Error::Malformed`](ssct_ground::Error::Malformed) for an index without a vertex, and for a position that is
    /// not finite or out of range.
    pub(super) fn place(&self, index: usize, notes: &mut Notes) -> Result<PlacedVertex> {
        let malformed =
            |problem: String| self.data.error(format!("mesh {}: {problem}", bounded::printable_name(self.mesh.name)));
        if index >= self.count {
            return Err(malformed(format!("an index is not below the {} vertices", self.count)));
        }
        let placement = self.placement(index).map_err(malformed)?;
        let position = placement.to_world.transform_point3(self.position(index)) - self.mesh.origin;
        if !position.is_finite() {
            return Err(malformed(format!("the position of vertex {index} is not a number")));
        }
        if position.abs().max_element() > f64::from(MAX_COORDINATE_M) {
            return Err(malformed(format!("a vertex lies more than {MAX_COORDINATE_M:e} m from the origin")));
        }
        let mut uv = self.uvs.as_ref().map_or([0.0; 2], |uvs| self.coordinates.transform_uv(uvs.get(index)));
        if uv.iter().any(|coordinate| !coordinate.is_finite()) {
            notes.add("no coordinates", "texture coordinates that are not finite count as 0".to_owned());
            uv = [0.0; 2];
        }
        let normal = self.normal(index);
        if !normal.is_finite() {
            notes.add("no normals", "normals that are not finite became those of their triangles".to_owned());
        }
        let vertex = Vertex {
            position: (position.as_vec3() + Vec3::ZERO).to_array(),
            normal: placement.normal(normal).as_vec3().to_array(),
            uv,
            tangent: self.tangents.as_ref().map_or([0.0; 4], |tangents| placement.tangent(tangents.get(index))),
        };
        Ok(PlacedVertex { vertex, position, mirror_sign: placement.mirror_sign })
    }

    /// Returns the position of a vertex in the mesh, including morph targets.
    fn position(&self, index: usize) -> DVec3 {
        let offset = |morph: &Morph| Some(morph.weight * vector_at(morph.positions.as_ref()?, index));
        self.morphs.iter().filter_map(offset).fold(vector_at(&self.positions, index), |sum, offset| sum + offset)
    }

    /// Returns the normal of a vertex in the mesh, including morph targets; zero if there is none.
    fn normal(&self, index: usize) -> DVec3 {
        let Some(normals) = &self.normals else { return DVec3::ZERO };
        let offset = |morph: &Morph| Some(morph.weight * vector_at(morph.normals.as_ref()?, index));
        self.morphs.iter().filter_map(offset).fold(vector_at(normals, index), |sum, offset| sum + offset)
    }

    /// Returns the transform of a vertex: that of the node or, with a skin, the weighted mean of its joints' matrices.
    /// Weights need not add up to 1; if all are 0, the first joint is used.
    fn placement(&self, vertex: usize) -> std::result::Result<ToWorld, String> {
        let joints = match self.mesh.placement {
            MeshPlacement::Node(node) => return Ok(*node),
            MeshPlacement::Skin(joints) => joints,
        };
        let (mut weighted_sum, mut weight_sum) = (DMat4::ZERO, 0.0);
        let mut first_joint = None;
        for [indices, weights] in &self.influences {
            for (index, weight) in indices.get(vertex).into_iter().zip(weights.get(vertex)) {
                let Some(joint) = joints.get(index as usize) else {
                    return Err(format!("vertex {vertex} has joint {index}, and the skin has {} joints", joints.len()));
                };
                first_joint.get_or_insert(*joint);
                if weight > 0.0 && weight.is_finite() {
                    weighted_sum += f64::from(weight) * *joint;
                    weight_sum += f64::from(weight);
                }
            }
        }
        let mean =
            if weight_sum > 0.0 { weighted_sum * (1.0 / weight_sum) } else { first_joint.unwrap_or(DMat4::IDENTITY) };
        Ok(ToWorld::new(mean))
    }
}

/// Returns the vector of an accessor at an index, in 64 bits.
fn vector_at(vectors: &Vectors<3>, index: usize) -> DVec3 {
    Vec3::from(vectors.get(index)).as_dvec3()
}

/// Reads the morph targets of a primitive with `count` vertices. Targets whose weight is 0 or not finite are left out.
fn morphs<'a>(data: &'a Data, primitive: &Primitive, weights: &[f32], count: usize) -> Result<Vec<Morph<'a>>> {
    let mut morphs = Vec::new();
    for (target, &weight) in primitive.morph_targets().zip(weights) {
        if weight == 0.0 || !weight.is_finite() {
            continue;
        }
        let read = |accessor: Option<gltf::Accessor>, semantic: Semantic| {
            accessor.map(|accessor| one_for_each_vertex::<3>(data, &accessor, &semantic, count)).transpose()
        };
        let positions = read(target.positions(), Semantic::Positions)?;
        let normals = read(target.normals(), Semantic::Normals)?;
        morphs.push(Morph { weight: f64::from(weight), positions, normals });
    }
    Ok(morphs)
}

/// Reads the joints and weights of a skinned primitive with `count` vertices. The result has a pair for each set: the
/// indices of four joints for each vertex, and their weights.
fn influences<'a>(data: &'a Data, primitive: &Primitive, count: usize) -> Result<Vec<[Vectors<'a, 4>; 2]>> {
    let mut influences = Vec::new();
    for set in 0.. {
        let joints = attribute::<4>(data, primitive, Semantic::Joints(set), count)?;
        let weights = attribute::<4>(data, primitive, Semantic::Weights(set), count)?;
        match joints.zip(weights) {
            Some((joints, weights)) => influences.push([joints, weights]),
            None => break,
        }
    }
    Ok(influences)
}

/// Reads the vectors of an attribute of a primitive with `count` vertices; `None` if the primitive lacks the attribute.
fn attribute<'a, const N: usize>(
    data: &'a Data,
    primitive: &Primitive,
    semantic: Semantic,
    count: usize,
) -> Result<Option<Vectors<'a, N>>> {
    primitive.get(&semantic).map(|accessor| one_for_each_vertex(data, &accessor, &semantic, count)).transpose()
}

/// Reads the vectors of an accessor, which must have one vector for each of `count` vertices.
fn one_for_each_vertex<'a, const N: usize>(
    data: &'a Data,
    accessor: &gltf::Accessor,
    semantic: &Semantic,
    count: usize,
) -> Result<Vectors<'a, N>> {
    let vectors = data.vectors(accessor, semantic)?;
    if vectors.len() != count {
        let (name, index, elements) = (semantic.to_string(), accessor.index(), vectors.len());
        return Err(data.error(format!("accessor {index} of {name} has {elements} elements for {count} vertices")));
    }
    Ok(vectors)
}

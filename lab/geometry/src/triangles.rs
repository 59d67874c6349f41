//! All triangles of a scene, ready for rays: the hierarchy of [`super::bvh`] and the mesh of each triangle. Rays pass
//! through the holes of alpha masks, and through single-sided materials from behind.

use super::bvh::{Intersector, TriangleBvh, TriangleHit, WorldRay};
use super::texture::bilinear;
use glam::{DVec2, Vec3};
use ssct_ground::scene::{Material, Scene, Vertex};

/// The triangles of a scene, with materials that may be those of one view.
pub struct Triangles<'a> {
    scene: &'a Scene,
    materials: &'a [Material],
    origins: Vec<TriangleRef>,
    bvh: TriangleBvh,
}

/// Where a triangle comes from: its mesh, and its place there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TriangleRef {
    /// Index into [`Scene::meshes`].
    pub mesh: u32,
    /// Index of the triangle in its mesh; its three vertex indices start at 3 · `triangle`.
    pub triangle: u32,
}

impl<'a> Triangles<'a> {
    /// Builds the hierarchy over all triangles of a scene. `materials` replace the scene's own, with the same indices.
    pub fn new(scene: &'a Scene, materials: &'a [Material]) -> Self {
        let mut origins = Vec::with_capacity(scene.triangle_count());
        let mut corners = Vec::with_capacity(scene.triangle_count());
        for (mesh_index, mesh) in scene.meshes.iter().enumerate() {
            for (triangle, indices) in mesh.indices.as_chunks::<3>().0.iter().enumerate() {
                origins.push(TriangleRef { mesh: mesh_index as u32, triangle: triangle as u32 });
                corners.push(indices.map(|i| Vec3::from(mesh.vertices[i as usize].position)));
            }
        }
        Self { scene, materials, origins, bvh: TriangleBvh::new(corners) }
    }

    /// Returns the closest hit of a ray. The ray passes where an alpha mask is below ½, and through single-sided
    /// materials from behind.
    pub fn closest(&self, ray: &WorldRay) -> Option<TriangleHit> {
        self.bvh.closest(ray, &|hit| self.stops_ray(ray, hit))
    }

    /// Returns true if a ray hits anything in its range; it passes where [`Triangles::closest`] lets it pass.
    pub fn any(&self, ray: &WorldRay) -> bool {
        self.bvh.any(ray, &|hit| self.stops_ray(ray, hit))
    }

    /// Returns the mesh of the triangle that was hit, and the triangle's index there.
    pub fn origin(&self, hit: &TriangleHit) -> TriangleRef {
        self.origins[hit.triangle as usize]
    }

    /// The corners of every triangle, in metres.
    pub fn all(&self) -> &[[Vec3; 3]] {
        self.bvh.triangles()
    }

    /// The corners of the triangle that was hit, in metres.
    pub fn corners(&self, hit: &TriangleHit) -> [Vec3; 3] {
        self.all()[hit.triangle as usize]
    }

    /// The material and the vertices of the triangle that was hit.
    pub fn surface(&self, hit: &TriangleHit) -> (&'a Material, [&'a Vertex; 3]) {
        let origin = self.origin(hit);
        let mesh = &self.scene.meshes[origin.mesh as usize];
        let first_index = 3 * origin.triangle as usize;
        (
            &self.materials[mesh.material],
            [0, 1, 2].map(|corner| &mesh.vertices[mesh.indices[first_index + corner] as usize]),
        )
    }

    /// Returns true if the surface stops the ray at the hit. A single-sided triangle does not stop a ray from behind,
    /// and the alpha mask has a hole where it is below ½.
    fn stops_ray(&self, ray: &WorldRay, hit: &TriangleHit) -> bool {
        let mesh = &self.scene.meshes[self.origin(hit).mesh as usize];
        let material = &self.materials[mesh.material];
        if material.single_sided {
            let [a, b, c] = self.corners(hit).map(|p| p.as_dvec3());
            if (b - a).cross(c - a).dot(ray.direction) > 0.0 {
                return false;
            }
        }
        let Some(mask) = material.alpha_mask else { return true };
        let (_, vertices) = self.surface(hit);
        bilinear(&self.scene.textures[mask], interpolate_uv(&vertices, hit)).x >= 0.5
    }
}

/// Returns the texture coordinates at the hit on a triangle, interpolated between its vertices.
pub fn interpolate_uv(vertices: &[&Vertex; 3], hit: &TriangleHit) -> DVec2 {
    vertices
        .iter()
        .zip(hit.barycentrics)
        .map(|(vertex, weight)| weight * DVec2::new(f64::from(vertex.uv[0]), f64::from(vertex.uv[1])))
        .sum()
}

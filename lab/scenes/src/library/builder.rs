//! Builds the meshes of the built-in scenes from planar polygons and smooth parametric surfaces, with normals,
//! tangents and texture coordinates at true scale.
//!
//! The front of a surface is the side to which the normals point. Seen from the front, the surface's parameter s and
//! the image's u grow to the right, and the parameter t and the image's up direction point upwards.

use crate::{Aabb, Mesh, Vertex};
use glam::{Vec2, Vec3};
use std::f32::consts::TAU;

/// Half the step, in the parameters s and t, of the central differences from which normals are computed.
const STEP: f32 = 1.0 / 256.0;

/// A mesh under construction.
pub struct MeshBuilder {
    name: String,
    material: usize,
    /// Width of the surface, in metres, that one image covers.
    image_m: f32,
    /// Whether images are turned by 90°.
    turned: bool,
    vertices: Vec<Vertex>,
    indices: Vec<u32>,
}

/// The unit normal of a surface, and the directions that are right and up when it is seen from the front.
#[derive(Clone, Copy)]
struct Axes {
    normal: Vec3,
    right: Vec3,
    up: Vec3,
}

impl MeshBuilder {
    /// Makes an empty mesh of a material whose images cover `image_m` metres.
    pub fn new(name: impl Into<String>, material: usize, image_m: f32) -> Self {
        Self { name: name.into(), material, image_m, turned: false, vertices: Vec::new(), indices: Vec::new() }
    }

    /// Sets the mesh to turn images by 90°, so that their right direction points up.
    pub fn turned(mut self) -> Self {
        self.turned = true;
        self
    }

    /// Makes an empty mesh of the same material with another name.
    pub fn renamed(&self, name: &str) -> Self {
        Self { turned: self.turned, ..Self::new(name, self.material, self.image_m) }
    }

    /// Returns true if the mesh has no triangles yet.
    pub fn is_empty(&self) -> bool {
        self.indices.is_empty()
    }

    /// Returns the finished mesh, with its bounds.
    pub fn build(self) -> Mesh {
        let bounds = Aabb::around(&self.vertices);
        Mesh { name: self.name, vertices: self.vertices, indices: self.indices, material: self.material, bounds }
    }

    /// Adds a flat, convex polygon whose normal points to the side of `facing`, whatever the order of its corners.
    /// Texture coordinates are computed from positions in the world, so that images continue across neighbours in one
    /// plane. On walls the image's up direction is +y, on floors and ceilings +z. A polygon without area is left out.
    pub fn polygon(&mut self, corners: &[Vec3], facing: Vec3) {
        // The vector area of the polygon, doubled: its direction is that of the normal.
        let area: Vec3 = (2..corners.len()).map(|k| (corners[k - 1] - corners[0]).cross(corners[k] - corners[0])).sum();
        if area.length_squared() < 1e-14 {
            return;
        }
        let is_front = area.dot(facing) >= 0.0;
        let normal = if is_front { area.normalize() } else { -area.normalize() };
        let axes = plane_axes(normal);
        let first = self.vertices.len() as u32;
        for &corner in corners {
            let uv_m = Vec2::new(corner.dot(axes.right), corner.dot(axes.up));
            self.push(corner, uv_m, axes);
        }
        for k in 2..corners.len() as u32 {
            let (b, c) = if is_front { (k - 1, k) } else { (k, k - 1) };
            self.triangle(first, first + b, first + c);
        }
    }

    /// Adds a band of flat quadrilaterals between two polylines with equally many points. The normals point to the side
    /// of `facing`.
    pub fn band(&mut self, lower: &[Vec3], upper: &[Vec3], facing: Vec3) {
        for (lower_edge, upper_edge) in lower.windows(2).zip(upper.windows(2)) {
            self.polygon(&[lower_edge[0], lower_edge[1], upper_edge[1], upper_edge[0]], facing);
        }
    }

    /// Adds a box with its faces outwards, from its least to its greatest corner.
    pub fn cuboid(&mut self, min: Vec3, max: Vec3) {
        self.cuboid_without(min, max, &[]);
    }

    /// Adds a box like [`Self::cuboid`], without the faces in the directions `open`.
    pub fn cuboid_without(&mut self, min: Vec3, max: Vec3, open: &[Vec3]) {
        let (centre, half) = (0.5 * (min + max), 0.5 * (max - min));
        for (axis, b, c) in [(Vec3::X, Vec3::Y, Vec3::Z), (Vec3::Y, Vec3::Z, Vec3::X), (Vec3::Z, Vec3::X, Vec3::Y)] {
            for outward in [axis, -axis] {
                if !open.contains(&outward) {
                    let corner = |along_b: f32, along_c: f32| centre + (outward + along_b * b + along_c * c) * half;
                    let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
                    self.polygon(&corners, outward);
                }
            }
        }
    }

    /// Adds a rectangle with rectangular holes in the plane through `origin` that the unit vectors `right` and `up`
    /// span. `extent` and `holes` are in metres along these vectors. The rectangle faces a viewer who sees `right` and
    /// `up` pointing right and up. It is cut along all edges of its holes, so that corners of its parts meet only other
    /// corners.
    pub fn panel(&mut self, [origin, right, up]: [Vec3; 3], extent: Rect, holes: &[Rect]) {
        // The coordinates of cuts along one axis, in order: both ends, and the edges of holes between them.
        let cuts = |low: f32, high: f32, edges: &dyn Fn(&Rect) -> [f32; 2]| {
            let mut coordinates = vec![low, high];
            coordinates.extend(holes.iter().flat_map(edges).filter(|edge| (low..high).contains(edge)));
            coordinates.sort_by(f32::total_cmp);
            coordinates.dedup();
            coordinates
        };
        let columns = cuts(extent.min.x, extent.max.x, &|rect| [rect.min.x, rect.max.x]);
        let rows = cuts(extent.min.y, extent.max.y, &|rect| [rect.min.y, rect.max.y]);
        for x in columns.windows(2) {
            for y in rows.windows(2) {
                let middle = Vec2::new(0.5 * (x[0] + x[1]), 0.5 * (y[0] + y[1]));
                if !holes.iter().any(|hole| hole.contains(middle)) {
                    let point = |x: f32, y: f32| origin + x * right + y * up;
                    let corners = [point(x[0], y[0]), point(x[1], y[0]), point(x[1], y[1]), point(x[0], y[1])];
                    self.polygon(&corners, up.cross(right));
                }
            }
        }
    }

    /// Adds a rectangle that shows one whole image. The vectors lead from the centre to the middle of the right and of
    /// the upper edge, as seen by a viewer of the upright image.
    pub fn picture(&mut self, centre: Vec3, half_right: Vec3, half_up: Vec3) {
        let (right, up) = (half_right.normalize(), half_up.normalize());
        let axes = Axes { normal: up.cross(right), right, up };
        let first = self.vertices.len() as u32;
        for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            // The u of the corner, and its negated v, since v grows downwards.
            let uv = 0.5 * Vec2::new(1.0 + x, y - 1.0);
            self.push(centre + x * half_right + y * half_up, uv * self.image_m, axes);
        }
        self.triangle(first, first + 2, first + 1);
        self.triangle(first, first + 3, first + 2);
    }

    /// Adds a round, smooth tube along a path, open at its ends, with `steps` cells around it and along it. `path`
    /// gives the centre and the radius, in metres, for t from 0 to 1. `across` is any direction that the path never
    /// follows.
    pub fn tube(&mut self, steps: [u32; 2], across: Vec3, path: impl Fn(f32) -> (Vec3, f32)) {
        let (centres, radii): (Vec<Vec3>, Vec<f32>) = (0..=16).map(|k| path(k as f32 / 16.0)).unzip();
        let length: f32 = centres.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
        let greatest_radius = radii.into_iter().fold(0.0, f32::max);
        self.surface(Vec3::ZERO, steps, |s, t| {
            let (centre, radius) = path(t);
            let along = (path(t + STEP).0 - path(t - STEP).0).normalize_or(Vec3::Y);
            let side = (across - along * along.dot(across)).normalize_or(along.any_orthonormal_vector());
            let (sin, cos) = (TAU * s).sin_cos();
            let outward = cos * side + sin * side.cross(along);
            (centre + radius * outward, Vec2::new(s * TAU * greatest_radius, t * length))
        });
    }

    /// Adds a regular polygon in a horizontal plane, which is a disc if it has many corners. It faces up or down like
    /// `facing`.
    pub fn disc(&mut self, centre: Vec3, radius: f32, corners: u32, facing: Vec3) {
        let rim: Vec<Vec3> = (0..corners)
            .map(|k| {
                let (sin, cos) = (TAU * k as f32 / corners as f32).sin_cos();
                centre + Vec3::new(radius * cos, 0.0, radius * sin)
            })
            .collect();
        self.polygon(&rim, facing);
    }

    /// Adds a smooth surface over 0 ≤ s, t ≤ 1, with the given numbers of columns and rows of cells.
    ///
    /// `shape` takes s and t, and gives a position relative to `origin` and texture coordinates in metres (right and
    /// up). It is also called slightly outside 0…1, for the normals. Where the surface closes to a point, the normal is
    /// computed at a point slightly closer to the middle.
    pub fn surface(&mut self, origin: Vec3, [columns, rows]: [u32; 2], shape: impl Fn(f32, f32) -> (Vec3, Vec2)) {
        let first = self.vertices.len() as u32;
        for j in 0..=rows {
            for i in 0..=columns {
                let (s, t) = (i as f32 / columns as f32, j as f32 / rows as f32);
                let (position, uv_m) = shape(s, t);
                self.push(origin + position, uv_m, surface_axes(&shape, s, t));
            }
        }
        for j in 0..rows {
            for i in 0..columns {
                let lower = first + j * (columns + 1) + i;
                let upper = lower + columns + 1;
                self.triangle(lower, upper, lower + 1);
                self.triangle(lower + 1, upper, upper + 1);
            }
        }
    }

    /// Adds a surface of revolution about the vertical through `base`, with `steps` cells around and upwards. `profile`
    /// gives the radius and the height above `base`; it must run upwards from t = 0 to t = 1, so that the outside is
    /// the front.
    pub fn revolve(&mut self, base: Vec3, steps: [u32; 2], profile: impl Fn(f32) -> Vec2) {
        let points: Vec<Vec2> = (0..=32).map(|k| profile(k as f32 / 32.0)).collect();
        let length: f32 = points.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
        let greatest_radius = points.iter().fold(0.0_f32, |greatest, point| greatest.max(point.x));
        // A whole number of images goes around, so that they meet without a seam.
        let around_m = (TAU * greatest_radius / self.image_m).round().max(1.0) * self.image_m;
        self.surface(base, steps, |s, t| {
            let Vec2 { x: radius, y: height } = profile(t);
            let (sin, cos) = (TAU * s).sin_cos();
            (Vec3::new(radius * cos, height, radius * sin), Vec2::new(s * around_m, t * length))
        });
    }

    /// Adds an upright cylinder of `segments` sides with its end caps; `base` is the middle of the lower one.
    pub fn cylinder(&mut self, base: Vec3, radius: f32, height: f32, segments: u32) {
        self.revolve(base, [segments, 1], |t| Vec2::new(radius, height * t));
        self.disc(base + height * Vec3::Y, radius, segments, Vec3::Y);
        self.disc(base, radius, segments, Vec3::NEG_Y);
    }

    /// Adds a sphere with `around` columns and `along` rows of cells.
    pub fn sphere(&mut self, centre: Vec3, radius: f32, [around, along]: [u32; 2]) {
        self.revolve(centre, [around, along], |t| {
            let (sin, cos) = (std::f32::consts::PI * t).sin_cos();
            Vec2::new(radius * sin, -radius * cos)
        });
    }

    /// Adds a vertex. `uv_m` are the texture coordinates of the vertex, to the right and up, in metres of the
    /// surface. `axes` are the normal and the image's directions at the vertex.
    fn push(&mut self, position: Vec3, uv_m: Vec2, axes: Axes) {
        let (uv_m, right, up) =
            if self.turned { (Vec2::new(uv_m.y, -uv_m.x), axes.up, -axes.right) } else { (uv_m, axes.right, axes.up) };
        let bitangent_sign = if axes.normal.cross(right).dot(up) < 0.0 { -1.0 } else { 1.0 };
        self.vertices.push(Vertex {
            position: position.to_array(),
            normal: axes.normal.to_array(),
            uv: [uv_m.x / self.image_m, -uv_m.y / self.image_m],
            tangent: right.extend(bitangent_sign).to_array(),
        });
    }

    /// Adds a triangle between three vertices, unless its area is almost 0.
    fn triangle(&mut self, a: u32, b: u32, c: u32) {
        let position = |vertex: u32| Vec3::from(self.vertices[vertex as usize].position);
        if (position(b) - position(a)).cross(position(c) - position(a)).length_squared() > 1e-14 {
            self.indices.extend([a, b, c]);
        }
    }
}

/// A rectangle in a plane, with sides along its x and y, in metres.
#[derive(Debug, Clone, Copy)]
pub struct Rect {
    /// Lower left corner.
    pub min: Vec2,
    /// Upper right corner.
    pub max: Vec2,
}

impl Rect {
    /// Makes a rectangle from its ranges in x and y.
    pub fn new(x: [f32; 2], y: [f32; 2]) -> Self {
        Self { min: Vec2::new(x[0], y[0]), max: Vec2::new(x[1], y[1]) }
    }

    /// Returns true if a point lies inside, and not on the border.
    fn contains(&self, point: Vec2) -> bool {
        point.cmpgt(self.min).all() && point.cmplt(self.max).all()
    }
}

/// Returns the range between two numbers, the lesser first.
pub fn ordered(a: f32, b: f32) -> [f32; 2] {
    [a.min(b), a.max(b)]
}

/// Returns the axes of a plane with this unit normal; up points towards +y, or towards +z if the plane is horizontal.
fn plane_axes(normal: Vec3) -> Axes {
    let above = if normal.y.abs() > 0.999 { Vec3::Z } else { Vec3::Y };
    let right = normal.cross(above).normalize();
    Axes { normal, right, up: right.cross(normal) }
}

/// Computes the normal of a surface at (s, t), and the directions on it that are right and up in its image, from
/// central differences. `shape` gives the position and the texture coordinates at (s, t).
fn surface_axes(shape: &impl Fn(f32, f32) -> (Vec3, Vec2), s: f32, t: f32) -> Axes {
    // The differences of the position and of the texture coordinates from (s − ds, t − dt) to (s + ds, t + dt).
    let difference = |s: f32, t: f32, ds: f32, dt: f32| {
        let ((ahead, ahead_uv), (behind, behind_uv)) = (shape(s + ds, t + dt), shape(s - ds, t - dt));
        (ahead - behind, ahead_uv - behind_uv)
    };
    // The differences over a step in s, then over a step in t.
    let slopes = |s: f32, t: f32| (difference(s, t, STEP, 0.0), difference(s, t, 0.0, STEP));
    // Where the surface closes to a point, one slope is almost 0, or both are almost parallel.
    let is_closed = |a: Vec3, b: Vec3| b.cross(a).length() < 1e-3 * a.length_squared().max(b.length_squared());
    let ((mut by_s, mut uv_by_s), (mut by_t, mut uv_by_t)) = slopes(s, t);
    if is_closed(by_s, by_t) {
        ((by_s, uv_by_s), (by_t, uv_by_t)) = slopes(s + (0.5 - s) * 0.03, t + (0.5 - t) * 0.03);
    }
    let normal = by_t.cross(by_s).normalize_or(Vec3::Y);
    // `right` and `image_up` are the directions on the surface in which the texture coordinates grow.
    let orientation = uv_by_s.perp_dot(uv_by_t).signum();
    let right = (by_s * uv_by_t.y - by_t * uv_by_s.y) * orientation;
    let image_up = (by_t * uv_by_s.x - by_s * uv_by_t.x) * orientation;
    let right = (right - normal * normal.dot(right)).normalize_or(normal.any_orthonormal_vector());
    let up = normal.cross(right);
    Axes { normal, right, up: if up.dot(image_up) < 0.0 { -up } else { up } }
}

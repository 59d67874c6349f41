//! Builds the meshes of the built-in scenes from planar polygons and smooth parametric surfaces, with normals,
//! tangents and texture coordinates at true scale.
//!
//! "Seen from the front" means seen from the side to which the normals point. On every surface seen from the
//! front, s and the image's u run to the right, and t and the image's up direction run upwards.

use crate::{Aabb, Mesh, Vertex};
use glam::{Vec2, Vec3};
use std::f32::consts::TAU;

/// Half the step, in the surface's parameters, of the central differences that give a surface its normals.
const STEP: f32 = 1.0 / 256.0;

/// A mesh under construction.
pub struct MeshBuilder {
    name: String,
    material: usize,
    /// Width of surface in metres that one image covers.
    image_m: f32,
    /// Whether images are turned by 90°.
    turned: bool,
    vertices: Vec<Vertex>,
    indices: Vec<u32>,
}

/// The right and up directions of a surface seen from the front.
#[derive(Clone, Copy)]
struct Axes {
    normal: Vec3,
    right: Vec3,
    up: Vec3,
}

impl MeshBuilder {
    /// An empty mesh of a material whose images cover `image_m` metres.
    pub fn new(name: impl Into<String>, material: usize, image_m: f32) -> Self {
        Self { name: name.into(), material, image_m, turned: false, vertices: Vec::new(), indices: Vec::new() }
    }

    /// Turns images by 90°, so that their right direction points up.
    pub fn turned(mut self) -> Self {
        self.turned = true;
        self
    }

    /// An empty mesh of the same material with another name.
    pub fn renamed(&self, name: &str) -> Self {
        Self { turned: self.turned, ..Self::new(name, self.material, self.image_m) }
    }

    /// Whether the mesh has no triangles yet.
    pub fn is_empty(&self) -> bool {
        self.indices.is_empty()
    }

    /// Finishes the mesh.
    pub fn build(self) -> Mesh {
        let bounds = Aabb::around(&self.vertices);
        Mesh { name: self.name, vertices: self.vertices, indices: self.indices, material: self.material, bounds }
    }

    /// A flat, convex polygon whose normal points to the side of `facing`, whatever the order of its corners.
    /// Texture coordinates are world coordinates, so that neighbours in one plane continue each other. On walls
    /// the image's up direction is +y, on floors and ceilings +z. A polygon without area is left out.
    pub fn polygon(&mut self, corners: &[Vec3], facing: Vec3) {
        let area: Vec3 = (2..corners.len()).map(|k| (corners[k - 1] - corners[0]).cross(corners[k] - corners[0])).sum();
        if area.length_squared() < 1e-14 {
            return;
        }
        let front = area.dot(facing) >= 0.0;
        let normal = if front { area.normalize() } else { -area.normalize() };
        let axes = plane_axes(normal);
        let first = self.vertices.len() as u32;
        for &corner in corners {
            let metres = Vec2::new(corner.dot(axes.right), corner.dot(axes.up));
            self.push(corner, metres, axes);
        }
        for k in 2..corners.len() as u32 {
            let (b, c) = if front { (k - 1, k) } else { (k, k - 1) };
            self.triangle(first, first + b, first + c);
        }
    }

    /// A band of flat quadrilaterals between two polylines with equally many points; it faces `facing`.
    pub fn band(&mut self, lower: &[Vec3], upper: &[Vec3], facing: Vec3) {
        for (a, b) in lower.windows(2).zip(upper.windows(2)) {
            self.polygon(&[a[0], a[1], b[1], b[0]], facing);
        }
    }

    /// A box with its faces outwards.
    pub fn cuboid(&mut self, min: Vec3, max: Vec3) {
        self.cuboid_but(min, max, &[]);
    }

    /// A box with its faces outwards, without the faces in the directions `open`.
    pub fn cuboid_but(&mut self, min: Vec3, max: Vec3, open: &[Vec3]) {
        let (centre, half) = (0.5 * (min + max), 0.5 * (max - min));
        for (a, b, c) in [(Vec3::X, Vec3::Y, Vec3::Z), (Vec3::Y, Vec3::Z, Vec3::X), (Vec3::Z, Vec3::X, Vec3::Y)] {
            for outward in [a, -a] {
                if !open.contains(&outward) {
                    let corner = |p: f32, q: f32| centre + (outward + p * b + q * c) * half;
                    let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
                    self.polygon(&corners, outward);
                }
            }
        }
    }

    /// A rectangle with rectangular holes in the plane through `origin` that the unit vectors `right` and `up` span.
    /// The sides of the rectangle are in metres along these vectors. The rectangle faces a viewer who sees `right` and
    /// `up` pointing right and up. The rectangle is cut along all edges of its holes, so that corners meet only at
    /// corners.
    pub fn panel(&mut self, [origin, right, up]: [Vec3; 3], extent: Rect, holes: &[Rect]) {
        let cuts = |low: f32, high: f32, edges: &dyn Fn(&Rect) -> [f32; 2]| {
            let mut all = vec![low, high];
            all.extend(holes.iter().flat_map(edges).filter(|x| (low..high).contains(x)));
            all.sort_by(f32::total_cmp);
            all.dedup();
            all
        };
        let columns = cuts(extent.min.x, extent.max.x, &|r| [r.min.x, r.max.x]);
        let rows = cuts(extent.min.y, extent.max.y, &|r| [r.min.y, r.max.y]);
        for x in columns.windows(2) {
            for y in rows.windows(2) {
                let middle = Vec2::new(0.5 * (x[0] + x[1]), 0.5 * (y[0] + y[1]));
                if !holes.iter().any(|r| r.contains(middle)) {
                    let point = |a: f32, b: f32| origin + a * right + b * up;
                    let corners = [point(x[0], y[0]), point(x[1], y[0]), point(x[1], y[1]), point(x[0], y[1])];
                    self.polygon(&corners, up.cross(right));
                }
            }
        }
    }

    /// A rectangle that shows one whole image, upright for a viewer who sees the two half vectors pointing
    /// right and up.
    pub fn picture(&mut self, centre: Vec3, half_right: Vec3, half_up: Vec3) {
        let (right, up) = (half_right.normalize(), half_up.normalize());
        let axes = Axes { normal: up.cross(right), right, up };
        let first = self.vertices.len() as u32;
        for (a, b) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            let image = 0.5 * Vec2::new(1.0 + a, b - 1.0);
            self.push(centre + a * half_right + b * half_up, image * self.image_m, axes);
        }
        self.triangle(first, first + 2, first + 1);
        self.triangle(first, first + 3, first + 2);
    }

    /// A round, smooth tube along a path, open at its ends. `path` gives the centre and radius for t from 0 to 1.
    /// `across` is any direction that the path never follows.
    pub fn tube(&mut self, steps: [u32; 2], across: Vec3, path: impl Fn(f32) -> (Vec3, f32)) {
        let points: Vec<(Vec3, f32)> = (0..=16).map(|k| path(k as f32 / 16.0)).collect();
        let length: f32 = points.windows(2).map(|p| p[0].0.distance(p[1].0)).sum();
        let thickest = points.iter().fold(0.0_f32, |r, p| r.max(p.1));
        self.surface(Vec3::ZERO, steps, |s, t| {
            let (centre, radius) = path(t);
            let along = (path(t + STEP).0 - path(t - STEP).0).normalize_or(Vec3::Y);
            let side = (across - along * along.dot(across)).normalize_or(along.any_orthonormal_vector());
            let (sin, cos) = (TAU * s).sin_cos();
            let out = cos * side + sin * side.cross(along);
            (centre + radius * out, Vec2::new(s * TAU * thickest, t * length))
        });
    }

    /// A disc or regular polygon in a horizontal plane, which faces up or down, as `facing` does.
    pub fn disc(&mut self, centre: Vec3, radius: f32, corners: u32, facing: Vec3) {
        let rim: Vec<Vec3> = (0..corners)
            .map(|k| {
                let (sin, cos) = (TAU * k as f32 / corners as f32).sin_cos();
                centre + Vec3::new(radius * cos, 0.0, radius * sin)
            })
            .collect();
        self.polygon(&rim, facing);
    }

    /// A smooth surface over 0 ≤ s, t ≤ 1, with the given numbers of columns and rows.
    ///
    /// `shape` gives a position relative to `origin` and texture coordinates in metres (right and up). `shape` is also
    /// called slightly outside 0…1, for the normals. Where the surface closes to a point, the normal is taken slightly
    /// closer to the middle.
    pub fn surface(&mut self, origin: Vec3, [columns, rows]: [u32; 2], shape: impl Fn(f32, f32) -> (Vec3, Vec2)) {
        let first = self.vertices.len() as u32;
        for j in 0..=rows {
            for i in 0..=columns {
                let (s, t) = (i as f32 / columns as f32, j as f32 / rows as f32);
                let (position, metres) = shape(s, t);
                self.push(origin + position, metres, surface_axes(&shape, s, t));
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

    /// A surface of revolution about the vertical through `base`. `profile` gives the radius and the height above `base`; the
    /// profile must run upwards from t = 0 to t = 1, so that the outside is the front.
    pub fn revolve(&mut self, base: Vec3, steps: [u32; 2], profile: impl Fn(f32) -> Vec2) {
        let points: Vec<Vec2> = (0..=32).map(|k| profile(k as f32 / 32.0)).collect();
        let length: f32 = points.windows(2).map(|p| p[0].distance(p[1])).sum();
        let radius = points.iter().fold(0.0_f32, |r, p| r.max(p.x));
        let around = (TAU * radius / self.image_m).round().max(1.0) * self.image_m;
        self.surface(base, steps, |s, t| {
            let p = profile(t);
            let (sin, cos) = (TAU * s).sin_cos();
            (Vec3::new(p.x * cos, p.y, p.x * sin), Vec2::new(s * around, t * length))
        });
    }

    /// An upright cylinder with its end caps.
    pub fn cylinder(&mut self, base: Vec3, radius: f32, height: f32, segments: u32) {
        self.revolve(base, [segments, 1], |t| Vec2::new(radius, height * t));
        self.disc(base + height * Vec3::Y, radius, segments, Vec3::Y);
        self.disc(base, radius, segments, Vec3::NEG_Y);
    }

    /// A sphere with `around` columns and `along` rows.
    pub fn sphere(&mut self, centre: Vec3, radius: f32, [around, along]: [u32; 2]) {
        self.revolve(centre, [around, along], |t| {
            let (sin, cos) = (std::f32::consts::PI * t).sin_cos();
            Vec2::new(radius * sin, -radius * cos)
        });
    }

    /// Adds a vertex. `metres` are the texture coordinates of the vertex, to the right and up, in metres of the
    /// surface.
    fn push(&mut self, position: Vec3, metres: Vec2, axes: Axes) {
        let (metres, right, up) = if self.turned {
            (Vec2::new(metres.y, -metres.x), axes.up, -axes.right)
        } else {
            (metres, axes.right, axes.up)
        };
        let side = if axes.normal.cross(right).dot(up) < 0.0 { -1.0 } else { 1.0 };
        self.vertices.push(Vertex {
            position: position.to_array(),
            normal: axes.normal.to_array(),
            uv: [metres.x / self.image_m, -metres.y / self.image_m],
            tangent: right.extend(side).to_array(),
        });
    }

    /// Adds a triangle between three vertices, unless its area is almost 0.
    fn triangle(&mut self, a: u32, b: u32, c: u32) {
        let position = |k: u32| Vec3::from(self.vertices[k as usize].position);
        if (position(b) - position(a)).cross(position(c) - position(a)).length_squared() > 1e-14 {
            self.indices.extend([a, b, c]);
        }
    }
}

/// A rectangle in a plane, in metres.
#[derive(Debug, Clone, Copy)]
pub struct Rect {
    /// Lower left corner.
    pub min: Vec2,
    /// Upper right corner.
    pub max: Vec2,
}

impl Rect {
    /// A rectangle from its ranges in x and y.
    pub fn new(x: [f32; 2], y: [f32; 2]) -> Self {
        Self { min: Vec2::new(x[0], y[0]), max: Vec2::new(x[1], y[1]) }
    }

    /// Whether a point lies inside, and not on the border.
    fn contains(&self, point: Vec2) -> bool {
        point.cmpgt(self.min).all() && point.cmplt(self.max).all()
    }
}

/// The axes of a plane: up is +y, or +z if the plane is horizontal.
fn plane_axes(normal: Vec3) -> Axes {
    let above = if normal.y.abs() > 0.999 { Vec3::Z } else { Vec3::Y };
    let right = normal.cross(above).normalize();
    Axes { normal, right, up: right.cross(normal) }
}

/// The axes of a surface at a point, from central differences of its position and texture coordinates.
fn surface_axes(shape: &impl Fn(f32, f32) -> (Vec3, Vec2), s: f32, t: f32) -> Axes {
    let difference = |s: f32, t: f32, ds: f32, dt: f32| {
        let (ahead, behind) = (shape(s + ds, t + dt), shape(s - ds, t - dt));
        (ahead.0 - behind.0, ahead.1 - behind.1)
    };
    let slopes = |s: f32, t: f32| (difference(s, t, STEP, 0.0), difference(s, t, 0.0, STEP));
    // Where the surface closes to a point, one slope is almost 0, or both are almost parallel.
    let closed = |a: Vec3, b: Vec3| b.cross(a).length() < 1e-3 * a.length_squared().max(b.length_squared());
    let (mut along, mut up) = slopes(s, t);
    if closed(along.0, up.0) {
        (along, up) = slopes(s + (0.5 - s) * 0.03, t + (0.5 - t) * 0.03);
    }
    let normal = up.0.cross(along.0).normalize_or(Vec3::Y);
    // `right` and `image_up` are the directions on the surface in which the texture coordinates grow.
    let scale = along.1.perp_dot(up.1).signum();
    let right = (along.0 * up.1.y - up.0 * along.1.y) * scale;
    let image_up = (up.0 * along.1.x - along.0 * up.1.x) * scale;
    let right = (right - normal * normal.dot(right)).normalize_or(normal.any_orthonormal_vector());
    let up = normal.cross(right);
    Axes { normal, right, up: if up.dot(image_up) < 0.0 { -up } else { up } }
}

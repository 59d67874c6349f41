//! Renders the images of impostors: objects of a scene are drawn orthographically onto a rectangle, lit by the scene's
//! lights, and the image is transparent around the objects. An impostor therefore shows exactly the object that it
//! replaces.

use glam::{Vec2, Vec3, Vec4};
use rayon::prelude::*;
use ssct_ground::math::{display_byte, srgb_to_linear};
use ssct_ground::scene::{Encoding, Impostor, Mesh, Scene, Texture, Vertex};

/// Number of samples along each side of a texel.
const OVERSAMPLED: u32 = 2;
/// Greatest number of texels of a material's image, along each side, that one sample averages.
const FOOTPRINT_MAX: f32 = 4.0;

/// An impostor whose image has not been rendered yet.
pub struct ImpostorFrame {
    /// Name of the impostor.
    pub name: &'static str,
    /// Centre of the rectangle, in metres.
    pub centre: Vec3,
    /// From the centre to the middle of the right edge, as a viewer in front of the image sees it, in metres.
    pub half_right: Vec3,
    /// From the centre to the middle of the upper edge, in metres.
    pub half_up: Vec3,
    /// Width of the image in texels; the height follows from the aspect ratio.
    pub width: u32,
}

/// Adds an impostor with its image to the scene. The image shows the meshes whose names `meshes` lists, seen along the
/// rectangle's normal.
pub fn add(scene: &mut Scene, meshes: &[&str], frame: &ImpostorFrame) {
    let height_over_width = frame.half_up.length() / frame.half_right.length();
    let extent = [frame.width, ((frame.width as f32 * height_over_width).round() as u32).max(1)];
    let mut impostor = Impostor {
        name: frame.name.to_owned(),
        centre: frame.centre,
        half_u: frame.half_right,
        half_v: -frame.half_up,
        texture: scene.textures.len(),
    };
    let shown_meshes: Vec<&Mesh> = scene.meshes.iter().filter(|m| meshes.contains(&m.name.as_str())).collect();
    let samples =
        ImpostorCanvas::new(scene, &impostor, extent.map(|texels| texels * OVERSAMPLED)).draw_samples(&shown_meshes);
    let texture = Texture {
        name: format!("impostor {}", frame.name),
        width: extent[0],
        height: extent[1],
        rgba: downsample(&samples, extent),
        encoding: Encoding::Srgb,
    };
    impostor.texture = scene.textures.len();
    scene.textures.push(texture);
    scene.impostors.push(impostor);
}

/// The drawing surface: the rectangle of an impostor, divided into samples.
struct ImpostorCanvas<'a> {
    scene: &'a Scene,
    impostor: &'a Impostor,
    /// Numbers of columns and rows of samples.
    size: [u32; 2],
    /// The linear value of each byte of an image in sRGB.
    srgb_values: [f32; 256],
    /// The value of each byte of an image that is linear.
    linear_values: [f32; 256],
    /// Unit normal of the rectangle.
    normal: Vec3,
}

/// A triangle on the canvas.
struct PlacedTriangle<'a> {
    mesh: &'a Mesh,
    corners: [&'a Vertex; 3],
    /// Column, row and height of each corner, as [`ImpostorCanvas::place_point`] gives them.
    places: [Vec3; 3],
    /// Twice the triangle's area, in samples; its sign is that of the winding on the canvas.
    area: f32,
}

/// The highest triangle at a sample.
#[derive(Clone, Copy)]
struct HighestTriangle<'a> {
    /// Height above the rectangle, in metres.
    height: f32,
    triangle: &'a PlacedTriangle<'a>,
    /// Barycentric weights of the corners at the sample.
    weights: Vec3,
}

impl<'a> ImpostorCanvas<'a> {
    /// Makes a canvas of `size` samples (columns and rows) over the rectangle of an impostor.
    fn new(scene: &'a Scene, impostor: &'a Impostor, size: [u32; 2]) -> Self {
        let linear_values: [f32; 256] = std::array::from_fn(|byte| byte as f32 / 255.0);
        Self {
            scene,
            impostor,
            size,
            srgb_values: linear_values.map(srgb_to_linear),
            linear_values,
            normal: impostor.normal(),
        }
    }

    /// Draws the meshes, and returns the linear colour of each sample, row by row, or `None` where no triangle covers
    /// it. Rows are drawn in parallel. A sample is shaded once, when its highest triangle is known.
    fn draw_samples(&self, meshes: &[&Mesh]) -> Vec<Option<Vec3>> {
        let triangles: Vec<PlacedTriangle> = meshes
            .iter()
            .flat_map(|mesh| mesh.indices.chunks_exact(3).map(move |indices| self.place_triangle(mesh, indices)))
            .filter(|triangle| triangle.area.abs() >= 1e-9)
            .collect();
        let colors_of_row = |y: u32| {
            let middle = y as f32 + 0.5;
            let mut row = vec![None; self.size[0] as usize];
            for triangle in &triangles {
                let top = triangle.places.iter().fold(f32::INFINITY, |least, place| least.min(place.y));
                let bottom = triangle.places.iter().fold(f32::NEG_INFINITY, |most, place| most.max(place.y));
                if top <= middle && middle <= bottom {
                    self.draw_in_row(&mut row, middle, triangle);
                }
            }
            row.into_iter().map(|highest| highest.map(|highest| self.color(&highest))).collect::<Vec<_>>()
        };
        (0..self.size[1]).into_par_iter().flat_map_iter(colors_of_row).collect()
    }

    /// Places a triangle on the canvas; `indices` are its three indices into the vertices of `mesh`.
    fn place_triangle<'m>(&self, mesh: &'m Mesh, indices: &[u32]) -> PlacedTriangle<'m> {
        let corners = [0, 1, 2].map(|k| &mesh.vertices[indices[k] as usize]);
        let places = corners.map(|v| self.place_point(Vec3::from(v.position)));
        let [a, b, c] = places.map(|p| p.truncate());
        PlacedTriangle { mesh, corners, places, area: (b - a).perp_dot(c - a) }
    }

    /// Returns the column and row of a point in world space, in samples, and its height above the rectangle, in metres.
    fn place_point(&self, point: Vec3) -> Vec3 {
        let offset = point - self.impostor.centre;
        // The position along one side of the rectangle, which has `count` samples; the centre is at half of them.
        let along = |half: Vec3, count: u32| (0.5 + 0.5 * offset.dot(half) / half.length_squared()) * count as f32;
        Vec3::new(
            along(self.impostor.half_u, self.size[0]),
            along(self.impostor.half_v, self.size[1]),
            offset.dot(self.normal),
        )
    }

    /// Draws the part of a triangle that lies in one row: each sample that it covers gets it if it is the highest so
    /// far. `middle` is the middle of the row, in samples from the top.
    fn draw_in_row<'t>(&self, row: &mut [Option<HighestTriangle<'t>>], middle: f32, triangle: &'t PlacedTriangle<'t>) {
        let places = &triangle.places;
        let [a, b, c] = places.map(|p| p.truncate());
        let left = a.x.min(b.x).min(c.x).floor().max(0.0) as usize;
        let right = (a.x.max(b.x).max(c.x).ceil().max(0.0) as usize).min(row.len());
        for (x, sample) in row.iter_mut().enumerate().take(right).skip(left) {
            let point = Vec2::new(x as f32 + 0.5, middle);
            let weights =
                Vec3::new((c - b).perp_dot(point - b), (a - c).perp_dot(point - c), (b - a).perp_dot(point - a))
                    / triangle.area;
            if weights.min_element() < 0.0 {
                continue;
            }
            let height = weights.dot(Vec3::new(places[0].z, places[1].z, places[2].z));
            if sample.is_none_or(|highest| highest.height < height) && !self.is_hole(triangle, weights) {
                *sample = Some(HighestTriangle { height, triangle, weights });
            }
        }
    }

    /// Returns true if the alpha mask of a triangle has a hole at the point with these barycentric weights.
    fn is_hole(&self, triangle: &PlacedTriangle, weights: Vec3) -> bool {
        let mask = self.scene.materials[triangle.mesh.material].alpha_mask;
        mask.is_some_and(|mask| self.average(&self.scene.textures[mask], triangle.uv(weights), 0.0).x < 0.5)
    }

    /// Returns the lit linear colour of the highest triangle at a sample. Its normal map is left out.
    fn color(&self, HighestTriangle { triangle, weights, .. }: &HighestTriangle) -> Vec3 {
        let material = &self.scene.materials[triangle.mesh.material];
        let [a, b, c] = triangle.corners.map(|v| Vec2::from(v.uv));
        // The side of the square in texture coordinates whose area is that of one sample.
        let footprint = ((b - a).perp_dot(c - a) / triangle.area).abs().sqrt();
        let uv = triangle.uv(*weights);
        let albedo_map = material.albedo_map.map(|index| &self.scene.textures[index]);
        let map_color = albedo_map.map_or(Vec3::ONE, |map| self.average(map, uv, footprint));
        let position = triangle.mix(*weights, |v| Vec3::from(v.position));
        let normal = triangle.mix(*weights, |v| Vec3::from(v.normal)).normalize_or(self.normal);
        let towards_viewer = if normal.dot(self.normal) < 0.0 { -normal } else { normal };
        let mut shading = 0.0;
        for light in &self.scene.lights {
            shading += light.shading(position, towards_viewer);
            // No light takes anything away, and more than 1 counts as 1.
            if shading >= 1.0 {
                break;
            }
        }
        // A fifth of the light is ambient (docs/definitions.md, "Surfaces").
        material.albedo * map_color * (0.2 + 0.8 * shading.min(1.0))
    }

    /// Returns the mean colour of an image over a square around `uv` with sides of `footprint`, both in texture coordinates,
    /// from at most [`FOOTPRINT_MAX`]² texels. The image repeats, and its values come decoded: linear and from 0 to 1.
    fn average(&self, texture: &Texture, uv: Vec2, footprint: f32) -> Vec3 {
        let size = Vec2::new(texture.width as f32, texture.height as f32);
        // The number of texels along each side of the square.
        let count = (footprint * size.max_element()).round().clamp(1.0, FOOTPRINT_MAX) as i32;
        let corner = uv * size - 0.5 * (count - 1) as f32;
        let (width, height) = (texture.width as i32, texture.height as i32);
        let first = [(corner.x.floor() as i32).rem_euclid(width), (corner.y.floor() as i32).rem_euclid(height)];
        // Most texels lie inside the image and need no division, which would take longer than the rest.
        let wrap = |texel: i32, size: i32| if texel < size { texel } else { texel % size };
        let decoded = match texture.encoding {
            Encoding::Srgb => &self.srgb_values,
            Encoding::Linear => &self.linear_values,
        };
        let mut sum = Vec3::ZERO;
        for y in 0..count {
            let row = (wrap(first[1] + y, height) * width) as usize;
            for x in 0..count {
                let texel = 4 * (row + wrap(first[0] + x, width) as usize);
                if let [r, g, b] = texture.rgba[texel..texel + 3] {
                    sum += Vec3::new(decoded[usize::from(r)], decoded[usize::from(g)], decoded[usize::from(b)]);
                }
            }
        }
        sum / (count * count) as f32
    }
}

impl PlacedTriangle<'_> {
    /// Returns an attribute at the point with these barycentric weights, interpolated between the corners.
    fn mix(&self, weights: Vec3, attribute: impl Fn(&Vertex) -> Vec3) -> Vec3 {
        (0..3).map(|k| weights[k] * attribute(self.corners[k])).sum()
    }

    /// Returns the texture coordinates at the point with these barycentric weights.
    fn uv(&self, weights: Vec3) -> Vec2 {
        self.mix(weights, |v| Vec2::from(v.uv).extend(0.0)).truncate()
    }
}

/// Reduces samples to an image of `width` × `height` texels, as sRGB bytes with alpha. The colour is the mean of the
/// covered samples, and alpha is the share of covered samples. Texels without covered samples get the mean colour of
/// the image, so that filtering adds no dark seam.
fn downsample(samples: &[Option<Vec3>], [width, height]: [u32; 2]) -> Vec<u8> {
    let stride = width * OVERSAMPLED;
    // Sums the colours of the covered samples of a texel; the fourth component is the number of these samples.
    let texel_sum = |x: u32, y: u32| {
        let mut sum = Vec4::ZERO;
        for k in 0..OVERSAMPLED * OVERSAMPLED {
            let (column, row) = (x * OVERSAMPLED + k % OVERSAMPLED, y * OVERSAMPLED + k / OVERSAMPLED);
            if let Some(colour) = samples[(row * stride + column) as usize] {
                sum += colour.extend(1.0);
            }
        }
        sum
    };
    let sums: Vec<Vec4> = (0..width * height).map(|k| texel_sum(k % width, k / width)).collect();
    let total: Vec4 = sums.iter().sum();
    let mean = total.truncate() / total.w.max(1.0);
    let samples_per_texel = (OVERSAMPLED * OVERSAMPLED) as f32;
    sums.iter()
        .flat_map(|sum| {
            let colour = if sum.w > 0.0 { sum.truncate() / sum.w } else { mean };
            let [r, g, b] = colour.to_array().map(display_byte);
            [r, g, b, (sum.w / samples_per_texel * 255.0).round() as u8]
        })
        .collect()
}

//! Unfolds captures into crosses of six faces, so that the window can show them as images and draw rays over them.

use glam::{Vec2, Vec3};
use ssct::gpu::FrameContext;
use ssct::passes::pyramid;
use ssct::passes::{Captures, Content};
use ssct_lab::error::Result;
use ssct_lab::report::captures::{CROSS, FACES_IN_CROSS};
use ssct_scenes::{Capture, sky};

/// A kind of image that a capture has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CubePart {
    /// The lit colour at any level, over the sky.
    Color,
    /// The reversed depth.
    Depth,
    /// The normal in the view space of each face.
    Normal,
}

/// The kinds of images with their names.
const PARTS: [(CubePart, &str); 3] =
    [(CubePart::Color, "color"), (CubePart::Depth, "depth"), (CubePart::Normal, "normal")];

/// An image of a capture, which the window can show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CubeImage {
    /// The index of the capture, counted from 0.
    pub capture: usize,
    /// The kind of the image.
    pub part: CubePart,
}

impl CubeImage {
    /// Returns all images of `count` captures.
    pub fn all(count: usize) -> impl Iterator<Item = Self> {
        (0..count).flat_map(|capture| PARTS.map(|(part, _)| Self { capture, part }))
    }

    /// Finds an image by its name; `None` if it is not the name of a capture's image.
    pub fn find(name: &str) -> Option<Self> {
        let (number, part) = name.strip_prefix("capture-")?.split_once('-')?;
        let part = PARTS.iter().find(|(_, n)| *n == part)?.0;
        Some(Self { capture: number.parse::<usize>().ok()?.checked_sub(1)?, part })
    }

    /// Returns the name of the image, such as `capture-1-color`; names count captures from 1.
    pub fn name(self) -> String {
        let part = PARTS.iter().find(|(part, _)| *part == self.part).map_or("", |(_, name)| name);
        format!("capture-{}-{part}", self.capture + 1)
    }

    /// Returns the meaning of the image's numbers.
    pub fn content(self) -> Content {
        match self.part {
            CubePart::Color => Content::Color,
            CubePart::Depth => Content::ReversedDepth,
            CubePart::Normal => Content::Normal,
        }
    }

    /// Returns the number of the image's mip levels.
    pub fn levels(self, captures: &Captures) -> u32 {
        if self.part == CubePart::Color { captures.color.levels() } else { 1 }
    }

    /// Reads a mip level of the image, and returns it as a cross in a picture of `extent` pixels: RGBA texels, rows
    /// from the top, black outside the faces.
    pub fn read(
        self,
        context: &mut FrameContext,
        captures: &Captures,
        level: u32,
        extent: [u32; 2],
    ) -> Result<Vec<[f32; 4]>> {
        let first_layer = 6 * self.capture as u32;
        // Sides in texels of a face at level 0, and at the level that is read.
        let [full_side, _] = captures.color.extent();
        let level = level.min(self.levels(captures) - 1);
        let side = (full_side >> level).max(1);
        let layers = context.read(match self.part {
            CubePart::Color => captures.color.level(level),
            CubePart::Depth => captures.pyramid.level(0),
            CubePart::Normal => captures.normal.level(0),
        })?;
        let strip = pyramid::strip([full_side; 2]);
        let rows = pyramid::size([full_side; 2], strip)[1];
        let cross = Cross::new(extent);
        let texel = |i: u32| {
            let pixel = Vec2::new((i % extent[0]) as f32, (i / extent[0]) as f32) + 0.5;
            let Some((face, uv)) = cross.face_at(pixel) else { return [0.0, 0.0, 0.0, 1.0] };
            let [x, y] = uv.to_array().map(|v| ((v * side as f32) as u32).min(side - 1));
            // In `layers`, the layers of the image lie one below the other.
            let layer = first_layer + face as u32;
            match self.part {
                CubePart::Color => {
                    // The alpha is the share that is not sky.
                    let color = layers.texel(x, layer * side + y);
                    let sky_color = sky::radiance(sky::face_direction(face, uv.x, uv.y)) * (1.0 - color[3]);
                    (Vec3::from_slice(color) + sky_color).extend(1.0).to_array()
                }
                CubePart::Depth => {
                    // Fronts stand in strips of columns (`shaders-glsl/unified/pyramid.glsl`).
                    let front = layers.texel((y << strip) | (x % (1 << strip)), layer * rows + (x >> strip))[0];
                    [front.max(0.0), 0.0, 0.0, 1.0]
                }
                CubePart::Normal => Vec3::from_slice(layers.texel(x, layer * side + y)).extend(1.0).to_array(),
            }
        };
        Ok((0..extent[0] * extent[1]).map(texel).collect())
    }
}

/// The cross of a cube's faces in a picture: in the middle, and as large as the picture allows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cross {
    /// The side of a face, in pixels.
    side: f32,
    /// The upper left corner of the cross, in pixels.
    corner: Vec2,
}

impl Cross {
    /// Makes the cross for a picture of `extent` pixels.
    pub fn new(extent: [u32; 2]) -> Self {
        let [columns, rows] = CROSS.map(|n| n as f32);
        let size = Vec2::new(extent[0] as f32, extent[1] as f32);
        let side = (size.x / columns).min(size.y / rows);
        Self { side, corner: 0.5 * (size - side * Vec2::new(columns, rows)) }
    }

    /// Returns the face (0…5) at a point of the picture in pixels, and the texture coordinates in the face; `None`
    /// outside the cross.
    fn face_at(&self, point: Vec2) -> Option<(usize, Vec2)> {
        let position = (point - self.corner) / self.side;
        let face = FACES_IN_CROSS.iter().position(|place| place.map(|n| n as f32) == position.floor().to_array())?;
        Some((face, position.fract()))
    }

    /// Returns the face (0…5) that shows a direction in world axes, and the point of the picture that shows it, in
    /// pixels.
    pub fn face_and_point(&self, direction: Vec3) -> (usize, Vec2) {
        let size = direction.abs();
        let face_by_sign = |component: f32, face: usize| if component >= 0.0 { face } else { face + 1 };
        let (face, greatest) = if size.x >= size.y && size.x >= size.z {
            (face_by_sign(direction.x, 0), size.x)
        } else if size.y >= size.z {
            (face_by_sign(direction.y, 2), size.y)
        } else {
            (face_by_sign(direction.z, 4), size.z)
        };
        // The texture coordinates of a face are linear in the direction, whose greatest component is 1.
        let on_face = direction / greatest.max(f32::MIN_POSITIVE);
        let [middle, right, down] = [(0.5, 0.5), (1.0, 0.5), (0.5, 1.0)].map(|(u, v)| sky::face_direction(face, u, v));
        // The texture coordinate towards the middle of a side.
        let coordinate_towards = |axis: Vec3| 0.5 + 0.5 * (on_face - middle).dot(axis - middle);
        let [x, y] = FACES_IN_CROSS[face].map(|n| n as f32);
        (face, self.corner + self.side * Vec2::new(x + coordinate_towards(right), y + coordinate_towards(down)))
    }

    /// Returns the lines by which a capture shows a sequence of points in the world: points of the picture in pixels,
    /// with a new line where the sequence passes into another face.
    pub fn polylines(&self, capture: &Capture, points: &[Vec3]) -> Vec<Vec<Vec2>> {
        // Each line with its face.
        let mut lines: Vec<(usize, Vec<Vec2>)> = Vec::new();
        for point in points.iter().filter(|p| **p != capture.position) {
            let (face, position) = self.face_and_point(*point - capture.position);
            match lines.last_mut().filter(|(last, _)| *last == face) {
                Some((_, line)) => line.push(position),
                None => lines.push((face, vec![position])),
            }
        }
        lines.into_iter().map(|(_, line)| line).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_image_is_found_by_its_name_and_by_no_other() {
        for image in CubeImage::all(3) {
            assert_eq!(CubeImage::find(&image.name()), Some(image));
        }
        for other in ["hi-z", "capture-0-color", "capture-1", "capture-x-depth", "capture-2-flow"] {
            assert_eq!(CubeImage::find(other), None, "{other}");
        }
    }

    #[test]
    fn a_direction_lies_where_the_face_shows_it() {
        let cross = Cross::new([403, 290]);
        for face in 0..6 {
            for uv in [Vec2::new(0.5, 0.5), Vec2::new(0.1, 0.8), Vec2::new(0.9, 0.3)] {
                let (chosen, position) = cross.face_and_point(7.0 * sky::face_direction(face, uv.x, uv.y));
                let (found, found_uv) = cross.face_at(position).unwrap();
                assert!(
                    [chosen, found] == [face; 2] && found_uv.distance(uv) < 1e-4,
                    "{face}: {chosen}, {found}, {found_uv}"
                );
            }
        }
        assert_eq!(cross.face_at(Vec2::new(20.0, 20.0)), None);
    }
}

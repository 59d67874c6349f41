//! Places of captures and the share that they see, as records, as a table and as a map; and pictures of captures.

use super::diagrams::COLORS;
use super::images::{Rgb, display, picture};
use super::svg::Svg;
use super::tables;
use glam::{Vec2, Vec3, Vec3Swizzles};
use serde::Serialize;
use ssct::gpu::Pixels;
use ssct::passes::Content;
use ssct_geometry::placement::Placement;
use ssct_scenes::{GBufferData, Surface, sky};

/// A capture of a scene.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CaptureRecord {
    /// Always `capture`.
    pub kind: &'static str,
    /// The scene's name.
    pub scene: String,
    /// Who chose the place: `file` or `placement`.
    pub from: &'static str,
    /// World position in metres.
    pub place: [f32; 3],
    /// Distance of the near plane in metres.
    pub near_m: f32,
    /// Width and height of a face in texels.
    pub resolution: u32,
    /// The share, 0…1, that this capture and those before it see of what mirrors show beyond the screen.
    pub seen: f32,
}

/// Makes a record of each capture, in the order of the captures.
pub fn records(scene: &str, placement: &Placement) -> Vec<CaptureRecord> {
    let record = |(index, (capture, seen)): (usize, (&ssct_scenes::Capture, &f32))| CaptureRecord {
        kind: "capture",
        scene: scene.to_owned(),
        from: if index < placement.from_file { "file" } else { "placement" },
        place: capture.position.to_array(),
        near_m: capture.near_m,
        resolution: capture.resolution,
        seen: *seen,
    };
    placement.captures.iter().zip(&placement.seen).enumerate().map(record).collect()
}

/// Returns a table of captures as text, with one row for each capture; captures are numbered from 1.
pub fn text(records: &[CaptureRecord]) -> String {
    let mut rows = vec![["capture", "place", "near", "resolution", "from", "seen so far"].map(str::to_owned).to_vec()];
    rows.extend(records.iter().enumerate().map(|(index, r)| {
        let [x, y, z] = r.place;
        vec![
            (index + 1).to_string(),
            format!("{x:.2}, {y:.2}, {z:.2}"),
            format!("{} m", r.near_m),
            format!("6 x {0}x{0}", r.resolution),
            r.from.to_owned(),
            format!("{:.1} %", 100.0 * r.seen),
        ]
    }));
    tables::aligned(&rows)
}

/// The longer side of a map's drawing in pixels, without the border.
const MAP_SIDE: f32 = 800.0;
/// The width in pixels of the empty border around a map.
const MAP_BORDER: f32 = 24.0;

/// Draws a map as SVG: the places where people can stand, seen from above and coloured by the height of their floor,
/// and the captures with their numbers. x runs to the right, z up.
pub fn map(placement: &Placement) -> String {
    let places = placement.stands.iter().copied().chain(placement.captures.iter().map(|c| c.position));
    let (min, max) = places.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(min, max), p| (min.min(p), max.max(p)));
    let extent = (max - min).max(Vec3::splat(1e-3));
    let scale = MAP_SIDE / extent.xz().max_element();
    let point = |p: Vec3| Vec2::new(MAP_BORDER + scale * (p.x - min.x), MAP_BORDER + scale * (max.z - p.z));
    let mut svg = Svg::new(scale * extent.xz() + 2.0 * MAP_BORDER);
    for stand in &placement.stands {
        // Floors half a metre apart have different colours.
        let color = COLORS[(2.0 * (stand.y - min.y)).round() as usize % COLORS.len()];
        svg.circle(point(*stand), Vec2::splat(2.0), &format!("fill=\"{color}\" fill-opacity=\"0.5\""));
    }
    for (index, capture) in placement.captures.iter().enumerate() {
        let centre = point(capture.position);
        svg.circle(centre, Vec2::splat(11.0), "fill=\"#fff\" stroke=\"#000\" stroke-width=\"2\"");
        svg.text(centre + Vec2::new(0.0, 5.0), 14.0, "text-anchor=\"middle\"", &(index + 1).to_string());
        let height = format!("y {:.1} m", capture.position.y);
        svg.text(centre + Vec2::new(0.0, 24.0), 11.0, "text-anchor=\"middle\"", &height);
    }
    svg.finish()
}

/// The most pixels along a side of a face in [`CubePictures`].
const PICTURE_SIDE: u32 = 512;

/// Columns and rows of a cube that is laid open as a cross.
pub const CROSS: [u32; 2] = [4, 3];

/// Column and row of each face in the cross, in Vulkan's order: +x, −x, +y, −y, +z, −z. The four sides stand in one
/// row, with +z in the second place; +y is above +z, and −y below it.
pub const FACES_IN_CROSS: [[u32; 2]; 6] = [[2, 1], [0, 1], [1, 0], [1, 2], [1, 1], [3, 1]];

/// The grey of a cross where no face lies.
const EMPTY: u8 = 40;

/// Pictures of a capture, made face by face.
#[derive(Debug, Default)]
pub struct CubePictures {
    /// Each face's number, with a picture of its colour and one of its depth.
    faces: Vec<(usize, [Rgb; 2])>,
}

impl CubePictures {
    /// Adds a face (0…5 in Vulkan's order). From a face with more than 512 texels a side, only every n-th texel is taken. Texels of sky
    /// show the built-in environment.
    pub fn add(&mut self, face: usize, data: &GBufferData) {
        let step = data.width.div_ceil(PICTURE_SIDE);
        let side = data.width / step;
        // Column and row in the face of each texel of the pictures, from the middle of its square of `step` texels a
        // side.
        let texels = || (0..side * side).map(|i| [i % side * step + step / 2, i / side * step + step / 2]);
        let color = |[x, y]: [u32; 2]| {
            let i = data.index(x, y);
            let shown = if data.depth[i] > 0.0 && data.surface[i] == Surface::Lit {
                data.color[i]
            } else {
                let [u, v] = [x, y].map(|c| (c as f32 + 0.5) / data.width as f32);
                sky::radiance(sky::face_direction(face, u, v))
            };
            shown.extend(1.0).to_array()
        };
        let pixels = |channels, values| Pixels { width: side, height: side, channels, values };
        let colors = display(&pixels(4, texels().flat_map(color).collect()));
        let depths = pixels(1, texels().map(|[x, y]| data.depth[data.index(x, y)]).collect());
        self.faces.push((face, [colors, picture(Content::ReversedDepth, &depths, &data.camera.lens)]));
    }

    /// Lays the cube open as a cross; returns a picture of its colour, and one of its depth (near bright, sky black).
    pub fn crosses(self) -> [Rgb; 2] {
        // Each face has two pictures: number 0 of its colour, and number 1 of its depth.
        [0, 1].map(|kind| {
            let side = self.faces.first().map_or(1, |(_, pictures)| pictures[kind].width);
            let [width, height] = CROSS.map(|n| n * side);
            let mut cross = Rgb { width, height, bytes: vec![EMPTY; 3 * (width * height) as usize] };
            for (face, pictures) in &self.faces {
                let [left, top] = FACES_IN_CROSS[*face].map(|n| n * side);
                for (y, row) in pictures[kind].bytes.chunks_exact(3 * side as usize).enumerate() {
                    let start = 3 * ((top as usize + y) * width as usize + left as usize);
                    cross.bytes[start..start + row.len()].copy_from_slice(row);
                }
            }
            cross
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ssct_scenes::Capture;
    use ssct_scenes::capture::face_camera;

    /// Beside an edge of the cross, the two faces show nearly the same direction.
    #[test]
    fn faces_that_touch_in_a_cross_share_an_edge_of_the_cube() {
        let side = 64;
        let count = (side * side) as usize;
        let mut pictures = CubePictures::default();
        for face in 0..6 {
            let direction = |i: u32| {
                let [u, v] = [i % side, i / side].map(|c| (c as f32 + 0.5) / side as f32);
                sky::face_direction(face, u, v).normalize() * 0.5 + 0.5
            };
            pictures.add(
                face,
                &GBufferData {
                    width: side,
                    height: side,
                    camera: face_camera(Vec3::ZERO, face, 0.05),
                    depth: vec![0.5; count],
                    normal: vec![Vec3::ZERO; count],
                    reflectivity: vec![0.0; count],
                    roughness: vec![0.0; count],
                    color: (0..side * side).map(direction).collect(),
                    surface: vec![Surface::Lit; count],
                },
            );
        }
        let [color, depth] = pictures.crosses();
        assert_eq!([color.width, color.height, depth.width, depth.height], [256, 192, 256, 192]);
        let texel = |x: u32, y: u32| {
            let i = 3 * (y * color.width + x) as usize;
            [0, 1, 2].map(|c| i32::from(color.bytes[i + c]))
        };
        let near = |a: [i32; 3], b: [i32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 8);
        for n in 0..side {
            for x in [64, 128, 192] {
                assert!(near(texel(x - 1, 64 + n), texel(x, 64 + n)), "column {x}, row {n}");
            }
            for y in [64, 128] {
                assert!(near(texel(64 + n, y - 1), texel(64 + n, y)), "row {y}, column {n}");
            }
        }
        assert_eq!(texel(0, 0), [i32::from(EMPTY); 3]);
    }

    /// Makes a placement of two captures, of which a scene file gave the first, and of two places where people can
    /// stand.
    fn placement() -> Placement {
        let capture = |x: f32| Capture::placed_at(Vec3::new(x, 1.5, 2.0));
        Placement {
            captures: vec![capture(1.0), capture(-3.0)],
            from_file: 1,
            seen: vec![0.5, 0.75],
            stands: vec![Vec3::new(0.0, 1.5, 0.0), Vec3::new(4.0, 5.5, 1.0)],
        }
    }

    #[test]
    fn records_say_who_chose_each_place() {
        let records = records("hall", &placement());
        assert_eq!(records.iter().map(|r| r.from).collect::<Vec<_>>(), ["file", "placement"]);
        let json = serde_json::to_value(&records[1]).unwrap();
        assert_eq!(json["place"], serde_json::json!([-3.0, 1.5, 2.0]));
        assert_eq!((json["scene"].as_str(), json["seen"].as_f64()), (Some("hall"), Some(0.75)));
        let text = text(&records);
        assert!(text.lines().count() == 3 && text.contains("-3.00, 1.50, 2.00") && text.contains("75.0 %"), "{text}");
    }

    #[test]
    fn a_map_shows_every_place_inside_its_frame() {
        let map = map(&placement());
        assert_eq!(map.matches("<ellipse").count(), 4);
        assert!(map.contains(">1</text>") && map.contains(">2</text>") && !map.contains("NaN"), "{map}");
        // The greatest extent, 7 m along x, fills the drawing: the second capture is at its left, a stand at its right.
        assert!(map.contains("cx=\"24.00\"") && map.contains("cx=\"824.00\""), "{map}");
    }
}

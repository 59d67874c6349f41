//! Generated images that tile: textures for the surfaces of the built-in scenes, and replacements for the textures of
//! the thesis's rooms, which were never published.
//!
//! Each pattern is one function of relief and albedo (in `designs`). The function is sampled into an sRGB albedo image
//! and the tangent-space normal map of the same relief. All images are seamless and identical on every machine and at
//! every call.

mod designs;
mod lettering;
pub mod pictures;

pub use lettering::Text;
pub use pictures::{Painting, Picture, Sign, SignOutline};

use designs::{Design, Grain, Sample, TileLook};
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use ssct_ground::math::display_byte;
use ssct_ground::scene::{Encoding, Texture};

/// Side of a generated image in texels.
pub const SIZE: u32 = 512;

/// Selects one of a pattern's two images.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// sRGB albedo.
    Albedo,
    /// Tangent-space normals, green up, linear.
    Normal,
}

/// How dark the wood is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wood {
    /// Ceilings.
    Pale,
    /// Furniture and frames.
    Middle,
    /// Tops of blocks.
    Dark,
}

/// The colour of a cloth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dye {
    /// Madder red.
    Red,
    /// Moss green.
    Green,
    /// Woad blue.
    Blue,
}

/// A material whose texture can be generated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pattern {
    /// Irregular stone wall with mortar.
    Stones,
    /// Square floor tiles with grout.
    Tiles,
    /// Large floor slabs, rows shifted by half a slab.
    Slabs,
    /// Bricks in running bond.
    Bricks,
    /// Planks with grain.
    Wood(Wood),
    /// Pale cut stone.
    Limestone,
    /// Plaster with stains.
    Plaster,
    /// Even plaster without stains.
    Stucco,
    /// Woven cloth with an ornament.
    Cloth(Dye),
    /// Leaves.
    Foliage,
    /// A wet road, whose hollows are reflecting puddles.
    Asphalt,
    /// Polished squares of white and black marble.
    Marble,
    /// Polished cast floor with stone chips, in large fields.
    Terrazzo,
}

impl Pattern {
    /// Width of the surface that one image covers, in metres, for texture coordinates at true scale.
    pub fn size_m(self) -> f32 {
        match self {
            Self::Stones | Self::Slabs | Self::Plaster | Self::Stucco | Self::Marble | Self::Terrazzo => 2.4,
            Self::Tiles | Self::Wood(_) | Self::Limestone => 1.6,
            Self::Bricks => 1.5,
            Self::Cloth(_) | Self::Foliage => 0.8,
            Self::Asphalt => 3.9,
        }
    }

    /// The pattern as a function of a texel.
    fn design(self) -> Design {
        let size_m = self.size_m();
        match self {
            Self::Stones => designs::stones(size_m),
            Self::Tiles => designs::tiles(size_m, &FLOOR_TILES),
            Self::Slabs => designs::tiles(size_m, &FLOOR_SLABS),
            Self::Bricks => designs::bricks(size_m),
            Self::Wood(wood) => designs::wood(size_m, wood.tone()),
            Self::Limestone => designs::limestone(),
            Self::Plaster => designs::plaster(),
            Self::Stucco => designs::stucco(),
            Self::Cloth(dye) => designs::cloth(dye.albedo()),
            Self::Foliage => designs::foliage(size_m),
            Self::Asphalt => designs::asphalt(),
            Self::Marble => designs::marble(size_m),
            Self::Terrazzo => designs::terrazzo(size_m),
        }
    }

    /// The factor on the reflectivity as a function of a texel; `None` if it is the same everywhere.
    fn reflectivity(self) -> Option<Grain> {
        match self {
            Self::Asphalt => Some(designs::wetness()),
            _ => None,
        }
    }

    /// The name of the pattern, which becomes part of its images' names.
    fn label(self) -> &'static str {
        match self {
            Self::Stones => "stones",
            Self::Tiles => "tiles",
            Self::Slabs => "slabs",
            Self::Bricks => "bricks",
            Self::Wood(Wood::Pale) => "wood-pale",
            Self::Wood(Wood::Middle) => "wood-middle",
            Self::Wood(Wood::Dark) => "wood-dark",
            Self::Limestone => "limestone",
            Self::Plaster => "plaster",
            Self::Stucco => "stucco",
            Self::Cloth(Dye::Red) => "cloth-red",
            Self::Cloth(Dye::Green) => "cloth-green",
            Self::Cloth(Dye::Blue) => "cloth-blue",
            Self::Foliage => "foliage",
            Self::Asphalt => "asphalt",
            Self::Marble => "marble",
            Self::Terrazzo => "terrazzo",
        }
    }
}

/// The look of [`Pattern::Tiles`].
const FLOOR_TILES: TileLook = TileLook {
    count: 4,
    staggered: false,
    tones: [Vec3::new(0.36, 0.30, 0.22), Vec3::new(0.20, 0.15, 0.105)],
    grout: Vec3::new(0.11, 0.10, 0.09),
};

/// The look of [`Pattern::Slabs`].
const FLOOR_SLABS: TileLook = TileLook {
    count: 4,
    staggered: true,
    tones: [Vec3::new(0.27, 0.25, 0.21), Vec3::new(0.16, 0.14, 0.115)],
    grout: Vec3::new(0.075, 0.07, 0.06),
};

/// A texel of an image.
#[derive(Debug, Clone, Copy)]
struct Texel {
    /// The middle of the texel: (0, 0) is the top left of the image and (1, 1) the bottom right.
    uv: Vec2,
    /// Number of the texel, counted row by row from the top left.
    index: usize,
}

impl Texel {
    /// Makes the texel with this number, counted row by row, in an image of `width` × `height` texels.
    fn new(index: u32, [width, height]: [u32; 2]) -> Self {
        let corner = Vec2::new((index % width) as f32, (index / width) as f32);
        Self { uv: (corner + 0.5) / Vec2::new(width as f32, height as f32), index: index as usize }
    }
}

impl Wood {
    /// Linear albedo of the palest grain.
    fn tone(self) -> Vec3 {
        match self {
            Self::Pale => Vec3::new(0.50, 0.33, 0.18),
            Self::Middle => Vec3::new(0.42, 0.235, 0.10),
            Self::Dark => Vec3::new(0.30, 0.13, 0.055),
        }
    }
}

impl Dye {
    /// Linear albedo of the cloth without its ornament.
    fn albedo(self) -> Vec3 {
        match self {
            Self::Red => Vec3::new(0.36, 0.045, 0.035),
            Self::Green => Vec3::new(0.07, 0.20, 0.06),
            Self::Blue => Vec3::new(0.04, 0.09, 0.30),
        }
    }
}

/// Returns the pattern that the file name of a texture suggests (case and folders are ignored): wood, brick, stone or
/// tile. Wood is pale if the name contains "ceiling", dark if it contains a 2, and medium otherwise.
pub fn named(file_name: &str) -> Option<Pattern> {
    let name = file_name.rsplit(['/', '\\']).next().unwrap_or(file_name).to_lowercase();
    let has = |word| name.contains(word);
    if has("wood") {
        let wood = match () {
            () if has("ceiling") => Wood::Pale,
            () if has("2") => Wood::Dark,
            () => Wood::Middle,
        };
        return Some(Pattern::Wood(wood));
    }
    [("brick", Pattern::Bricks), ("stone", Pattern::Stones), ("tile", Pattern::Tiles)]
        .into_iter()
        .find_map(|(word, pattern)| has(word).then_some(pattern))
}

/// Returns the generated image that replaces a texture of this file name; `None` if the name suggests no stone, tile,
/// brick or wood.
pub fn by_name(file_name: &str, role: Role) -> Option<Texture> {
    let (albedo, normal) = images(named(file_name)?);
    Some(match role {
        Role::Albedo => albedo,
        Role::Normal => normal,
    })
}

/// Generates the albedo image and the normal map of a pattern, each of [`SIZE`] × [`SIZE`] texels.
pub fn images(pattern: Pattern) -> (Texture, Texture) {
    let design = pattern.design();
    let samples: Vec<Sample> =
        (0..SIZE * SIZE).into_par_iter().map(|index| design(Texel::new(index, [SIZE, SIZE]))).collect();
    let albedo = image_bytes([SIZE, SIZE], |index| srgba(samples[index as usize].albedo));
    let texel_m = pattern.size_m() / SIZE as f32;
    let normal = image_bytes([SIZE, SIZE], |index| rgba(normal_at(&samples, index, texel_m) * 0.5 + 0.5));
    let texture = |kind: &str, rgba, encoding| Texture {
        name: format!("generated {} {kind}", pattern.label()),
        width: SIZE,
        height: SIZE,
        rgba,
        encoding,
    };
    (texture("albedo", albedo, Encoding::Srgb), texture("normal", normal, Encoding::Linear))
}

/// Generates an image of a pattern's factor on the reflectivity (red, linear), of [`SIZE`] × [`SIZE`] texels; `None` if
/// the factor does not vary.
pub fn reflectivity_image(pattern: Pattern) -> Option<Texture> {
    let factor = pattern.reflectivity()?;
    let name = format!("generated {} reflectivity", pattern.label());
    Some(image(name, [SIZE, SIZE], Encoding::Linear, |texel| rgba(Vec3::splat(factor(texel)))))
}

/// Generates the image of a picture (sRGB with alpha) and, if the picture has holes, its alpha as a mask (red, linear).
pub fn picture_images(picture: Picture) -> (Texture, Option<Texture>) {
    let name = format!("generated {}", picture.label());
    let colour = image(name.clone(), picture.size(), Encoding::Srgb, |texel| {
        let sample = picture.sample(texel.uv);
        let [r, g, b, _] = srgba(sample.truncate());
        [r, g, b, byte(sample.w)]
    });
    let mask = picture.has_alpha().then(|| {
        let grey_of_alpha = |texel: &[u8]| [texel[3], texel[3], texel[3], 255];
        let rgba = colour.rgba.chunks_exact(4).flat_map(grey_of_alpha).collect();
        Texture { name: format!("{name} mask"), rgba, encoding: Encoding::Linear, ..colour }
    });
    (colour, mask)
}

/// Makes an image of `width` × `height` texels; `texel_bytes` returns the RGBA bytes of each of them.
fn image(
    name: String,
    [width, height]: [u32; 2],
    encoding: Encoding,
    texel_bytes: impl Fn(Texel) -> [u8; 4] + Sync,
) -> Texture {
    let rgba = image_bytes([width, height], |index| texel_bytes(Texel::new(index, [width, height])));
    Texture { name, width, height, rgba, encoding }
}

/// Makes the bytes of an image, row by row; `texel_bytes` returns the RGBA bytes of the texel with a number.
fn image_bytes([width, height]: [u32; 2], texel_bytes: impl Fn(u32) -> [u8; 4] + Sync) -> Vec<u8> {
    let mut rgba = vec![0; 4 * (width * height) as usize];
    let texels = rgba.par_chunks_exact_mut(4).zip(0..width * height);
    texels.for_each(|(bytes, index)| bytes.copy_from_slice(&texel_bytes(index)));
    rgba
}

/// Returns the unit normal of a relief at the texel `index` (counted row by row), with x to the right, y up and z out.
/// It comes from central differences, which wrap at the border. `texel_m` is the width of a texel in metres.
fn normal_at(samples: &[Sample], index: u32, texel_m: f32) -> Vec3 {
    let (x, y) = (index % SIZE, index / SIZE);
    let height = |x: u32, y: u32| samples[((y % SIZE) * SIZE + x % SIZE) as usize].height_m;
    let rightward = height(x + 1, y) - height(x + SIZE - 1, y);
    let downward = height(x, y + 1) - height(x, y + SIZE - 1);
    Vec3::new(-rightward, downward, 2.0 * texel_m).normalize()
}

/// Makes the bytes of an opaque texel from three numbers between 0 and 1, without encoding them as sRGB.
fn rgba(colour: Vec3) -> [u8; 4] {
    [byte(colour.x), byte(colour.y), byte(colour.z), 255]
}

/// Makes the bytes of an opaque texel from a linear colour, and encodes them as sRGB.
fn srgba(colour: Vec3) -> [u8; 4] {
    [display_byte(colour.x), display_byte(colour.y), display_byte(colour.z), 255]
}

/// Converts a number from 0 to 1 to the nearest byte from 0 to 255.
fn byte(value: f32) -> u8 {
    // The code avoids `f32::round`, since that is a call on processors that may lack SSE 4.1.
    let scaled = value.clamp(0.0, 1.0) * 255.0;
    let below = scaled as u8;
    below + u8::from(scaled - f32::from(below) >= 0.5)
}

#[cfg(test)]
#[allow(clippy::expect_used)]
mod tests {
    use super::*;
    use std::sync::LazyLock;

    const ALL_PATTERNS: [Pattern; 17] = [
        Pattern::Stones,
        Pattern::Tiles,
        Pattern::Slabs,
        Pattern::Bricks,
        Pattern::Wood(Wood::Pale),
        Pattern::Wood(Wood::Middle),
        Pattern::Wood(Wood::Dark),
        Pattern::Limestone,
        Pattern::Plaster,
        Pattern::Stucco,
        Pattern::Cloth(Dye::Red),
        Pattern::Cloth(Dye::Green),
        Pattern::Cloth(Dye::Blue),
        Pattern::Foliage,
        Pattern::Asphalt,
        Pattern::Marble,
        Pattern::Terrazzo,
    ];

    /// Every pattern with its two images, generated once for all tests.
    static IMAGES: LazyLock<Vec<(Pattern, Texture, Texture)>> = LazyLock::new(|| {
        ALL_PATTERNS
            .into_iter()
            .map(|pattern| {
                let (albedo, normal) = images(pattern);
                (pattern, albedo, normal)
            })
            .collect()
    });

    /// At 400 texels, each pattern has the same height and albedo if it is shifted by one image.
    #[test]
    fn every_pattern_has_period_one() {
        for pattern in ALL_PATTERNS {
            let design = pattern.design();
            // Noise is looked up by the index of a texel, which a shift by a period does not change. The noise itself
            // repeats (ssct_ground::math::noise).
            for texel in (0..400).map(|i| Texel::new(i * 655 + i % 97, [SIZE, SIZE])) {
                let sample = design(texel);
                for period in [Vec2::X, Vec2::Y] {
                    let shifted = design(Texel { uv: texel.uv + period, ..texel });
                    assert!(
                        (sample.height_m - shifted.height_m).abs() < 1e-4
                            && sample.albedo.abs_diff_eq(shifted.albedo, 5e-3),
                        "{pattern:?} at {}: {sample:?} and {shifted:?}",
                        texel.uv
                    );
                }
            }
        }
    }

    /// Across the border, columns and rows differ at most 1.5 times as much as neighbours inside an image.
    #[test]
    fn images_are_as_continuous_across_their_borders_as_inside() {
        // The sum of the differences of red, green and blue between two texels.
        let difference = |image: &Texture, a: [u32; 2], b: [u32; 2]| -> f32 {
            let texel = |[x, y]: [u32; 2]| &image.rgba[((y * SIZE + x) * 4) as usize..][..3];
            texel(a).iter().zip(texel(b)).map(|(&value_a, &value_b)| f32::from(value_a.abs_diff(value_b))).sum()
        };
        for (_, albedo, normal) in IMAGES.iter() {
            for image in [albedo, normal] {
                let between_columns =
                    |x: u32| (0..SIZE).map(|y| difference(image, [x, y], [(x + 1) % SIZE, y])).sum::<f32>();
                let between_rows =
                    |y: u32| (0..SIZE).map(|x| difference(image, [x, y], [x, (y + 1) % SIZE])).sum::<f32>();
                let greatest = |sums: &dyn Fn(u32) -> f32| (0..SIZE - 1).map(sums).fold(0.0, f32::max);
                assert!(between_columns(SIZE - 1) <= 1.5 * greatest(&between_columns), "{image:?}");
                assert!(between_rows(SIZE - 1) <= 1.5 * greatest(&between_rows), "{image:?}");
            }
        }
    }

    /// No colour is nearly white, the mean green is medium, and normals are unit vectors that mostly point out.
    #[test]
    fn colours_are_mid_toned_and_normals_are_unit_and_mostly_straight() {
        for (pattern, albedo, normal) in IMAGES.iter() {
            let texels = (SIZE * SIZE) as f32;
            let brightest = albedo.rgba.chunks(4).flat_map(|texel| &texel[..3]).max();
            assert!(brightest < Some(&235), "{pattern:?}: {brightest:?}");
            let mean = albedo.rgba.chunks(4).map(|texel| f32::from(texel[1])).sum::<f32>() / texels;
            assert!((40.0..190.0).contains(&mean), "{pattern:?}: mean green {mean}");
            let mut sum_of_z = 0.0;
            for texel in normal.rgba.chunks(4) {
                let decoded = Vec3::new(f32::from(texel[0]), f32::from(texel[1]), f32::from(texel[2])) / 127.5 - 1.0;
                assert!((decoded.length() - 1.0).abs() < 0.02 && decoded.z > 0.1, "{pattern:?}: {decoded}");
                sum_of_z += decoded.z;
            }
            assert!(sum_of_z / texels > 0.85, "{pattern:?}: mean z {}", sum_of_z / texels);
        }
    }

    #[test]
    fn normals_lean_away_from_the_slope() {
        // The left edge of a tile rises to the right, so its normal leans left. The upper edge rises downwards
        // in the image, so its normal leans up.
        let tiles = IMAGES.iter().find(|(pattern, ..)| *pattern == Pattern::Tiles);
        let normal = &tiles.expect("tiles").2;
        let tile = SIZE / 4;
        let texel = |x: u32, y: u32| &normal.rgba[((y * SIZE + x) * 4) as usize..][..2];
        assert!(texel(2, tile / 2)[0] < 100);
        assert!(texel(tile - 3, tile / 2)[0] > 156);
        assert!(texel(tile / 2, 2)[1] > 156);
        assert!(texel(tile / 2, tile - 3)[1] < 100);
        assert_eq!(texel(tile / 2, tile / 2), [128, 128]);
    }

    #[test]
    fn names_are_understood_in_any_case_and_with_folders() {
        for (name, pattern) in [
            ("StonesColorMap.jpg", Pattern::Stones),
            ("TilesNormalMap.jpg", Pattern::Tiles),
            ("Bricks4.jpg", Pattern::Bricks),
            ("WoodFloor1.jpg", Pattern::Wood(Wood::Middle)),
            ("WOODFLOOR2.JPG", Pattern::Wood(Wood::Dark)),
            ("stone\\CeilingWood1.jpg", Pattern::Wood(Wood::Pale)),
            ("maps/stone.png", Pattern::Stones),
        ] {
            assert_eq!(named(name), Some(pattern), "{name}");
        }
        assert!(by_name("bricks/white.png", Role::Albedo).is_none());
        let albedo = by_name("stone.png", Role::Albedo).expect("a stone");
        let normal = by_name("stone.png", Role::Normal).expect("a stone");
        assert_eq!((albedo.encoding, normal.encoding), (Encoding::Srgb, Encoding::Linear));
        assert_eq!(albedo.rgba.len(), (SIZE * SIZE * 4) as usize);
    }

    #[test]
    fn images_are_the_same_at_every_call() {
        let (_, albedo, normal) = &IMAGES[0];
        assert_eq!(images(Pattern::Stones), (albedo.clone(), normal.clone()));
    }
}

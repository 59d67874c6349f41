//! Images of materials ([`Texture`]): decodes them from files within limits, samples them, and converts them to alpha
//! masks, reflectivity maps and normal maps (also from height fields).

use super::bounded;
use glam::{DVec2, DVec4, Vec2, Vec3};
use image::imageops::FilterType;
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use ssct_ground::math;
use ssct_ground::{Error, Result};
use std::io::Cursor;
use std::path::Path;
use std::sync::LazyLock;

pub use ssct_ground::scene::texture::{Encoding, Texture};

/// The greatest width and height of an image, in texels; every desktop Vulkan device supports it.
pub const MAX_EXTENT: u32 = 16384;

/// Greatest number of texels that all images of a scene may have together: 4 GiB.
pub const MAX_TEXELS: u64 = 1 << 30;

/// The largest image file that can be read, in bytes.
pub const MAX_FILE_BYTES: u64 = 1 << 30;

/// Number of bytes that any image may unpack to; for more, its file must be long enough ([`bounded::may_unpack`]).
const FREE_BYTES: u64 = 1 << 20;

/// Number of bytes that any WebP image may unpack to, since an image of a single colour has no bits for its texels.
const FREE_WEBP_BYTES: u64 = 4 * 4096 * 4096;

/// The depth of a height field without a bump multiplier, in texels (see [`normal_map_from_height`]).
pub const RELIEF_TEXELS: f32 = 2.0;

/// Value of [`green_correlation`] below which a normal map's green points down. Maps with green up have more than 0,
/// and maps of Crytek's Sponza (green down) mostly less than −0.2; values in between are too weak to decide.
const GREEN_DOWN: f64 = -0.15;

/// The linear value of each byte of an sRGB image.
static LINEAR_OF_SRGB_BYTE: LazyLock<[f64; 256]> =
    LazyLock::new(|| std::array::from_fn(|byte| f64::from(math::srgb_to_linear(byte as f32 / 255.0))));

/// Decodes a PNG, JPEG, TGA, BMP, GIF or WebP file. The format is recognised by the content or, failing that, by the
/// file name.
///
/// # Errors
/// [`Error::Io`] if the file cannot be opened; [`Error::Malformed`] if it is larger than [`MAX_FILE_BYTES`]
/// or for the reasons that [`from_bytes`] lists.
pub fn decode(path: &Path, encoding: Encoding) -> Result<Texture> {
    from_bytes(&bounded::read(path, "an image", MAX_FILE_BYTES)?, path, encoding)
}

/// Decodes the bytes of an image file. Errors name the file by `path`.
///
/// # Errors
/// [`Error::Malformed`] if the bytes are not an image of a supported format, if the image is larger than [`MAX_EXTENT`]
/// on a side, or if it claims more texels than the bytes can hold. The size is checked before memory is allocated for
/// the image.
pub fn from_bytes(bytes: &[u8], path: &Path, encoding: Encoding) -> Result<Texture> {
    let image = decode_bytes(bytes, path)?;
    let (width, height) = (image.width(), image.height());
    let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    Ok(Texture { name, width, height, rgba: image.into_rgba8().into_raw(), encoding })
}

/// Decodes the bytes of an image file to its width and height and its values: red, green, blue and alpha of each texel,
/// from 0 to 1. Values stay as the image encodes them, sRGB or linear, and a 16-bit image keeps all its bits.
///
/// # Errors
/// The errors of [`from_bytes`].
pub fn unit_values(bytes: &[u8], path: &Path) -> Result<([u32; 2], Vec<f32>)> {
    let image = decode_bytes(bytes, path)?;
    let size = [image.width(), image.height()];
    let has_16_bits = image.color().bytes_per_pixel() > image.color().channel_count();
    let values = if has_16_bits {
        image.into_rgba16().into_raw().into_iter().map(|v| f32::from(v) / f32::from(u16::MAX)).collect()
    } else {
        image.into_rgba8().into_raw().into_iter().map(|v| f32::from(v) / f32::from(u8::MAX)).collect()
    };
    Ok((size, values))
}

/// Decodes the bytes of an image file to texels of the image's own format. The size that the file claims is checked
/// before it is decoded.
fn decode_bytes(bytes: &[u8], path: &Path) -> Result<DynamicImage> {
    let malformed = |error: image::ImageError| Error::malformed(path, None, format!("cannot be decoded: {error}"));
    let mut reader = ImageReader::new(Cursor::new(bytes));
    if let Ok(format) = ImageFormat::from_path(path) {
        reader.set_format(format);
    }
    let mut reader = reader.with_guessed_format().map_err(|e| Error::io("read", path, e))?;
    let free_bytes = if reader.format() == Some(ImageFormat::WebP) { FREE_WEBP_BYTES } else { FREE_BYTES };
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_EXTENT);
    limits.max_image_height = Some(MAX_EXTENT);
    // The limit allows 16 bits per channel at the greatest extent.
    limits.max_alloc = Some(8 * u64::from(MAX_EXTENT) * u64::from(MAX_EXTENT));
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(malformed)?;
    let (width, height) = decoder.dimensions();
    if width == 0 || height == 0 || width > MAX_EXTENT || height > MAX_EXTENT {
        let message = format!("the image has {width} x {height} texels; each side must be 1 to {MAX_EXTENT}");
        return Err(Error::malformed(path, None, message));
    }
    if !bounded::may_unpack(bytes.len(), decoder.total_bytes(), free_bytes) {
        let message = format!("an image of {width} x {height} texels cannot come from only {} bytes", bytes.len());
        return Err(Error::malformed(path, None, message));
    }
    DynamicImage::from_decoder(decoder).map_err(malformed)
}

/// The texels of a scene's images, of which there may be [`MAX_TEXELS`].
#[derive(Default)]
pub struct TexelBudget {
    /// Number of texels of the images that fitted.
    used: u64,
}

impl TexelBudget {
    /// Returns whether an image of `width` × `height` texels, shrunk by [`shrink_to_side`], still fits, and counts its
    /// texels if it does. An image that does not fit takes no room from later images.
    pub fn admits(&mut self, width: u32, height: u32, side: u32) -> bool {
        let [width, height] = size_within(width, height, side);
        let used = self.used + u64::from(width) * u64::from(height);
        let fits = used <= MAX_TEXELS;
        if fits {
            self.used = used;
        }
        fits
    }
}

/// Returns the width and height of an image after it is shrunk so that its longer side has at most `side` texels. The
/// shape is kept, and each side stays at least 1.
fn size_within(width: u32, height: u32, side: u32) -> [u32; 2] {
    let greatest = u64::from(width.max(height));
    let scale = |extent: u32| {
        if greatest <= u64::from(side) { extent } else { (u64::from(extent) * u64::from(side) / greatest) as u32 }
    };
    [width, height].map(|extent| scale(extent).max(1))
}

/// Shrinks an image so that no side has more than `side` texels. A triangle filter averages decoded texels, that is,
/// light. An image that is small enough is not changed.
pub fn shrink_to_side(texture: Texture, side: u32) -> Texture {
    let [width, height] = size_within(texture.width, texture.height, side);
    if [width, height] == [texture.width, texture.height] {
        return texture;
    }
    let srgb = texture.encoding == Encoding::Srgb;
    // Every fourth byte is alpha, which is never encoded as sRGB.
    let unpack = |(index, &byte): (usize, &u8)| {
        if srgb && index % 4 != 3 { LINEAR_OF_SRGB_BYTE[usize::from(byte)] as f32 } else { f32::from(byte) / 255.0 }
    };
    let texels: Vec<f32> = texture.rgba.iter().enumerate().map(unpack).collect();
    let Some(image) = image::Rgba32FImage::from_raw(texture.width, texture.height, texels) else { return texture };
    let small = image::imageops::resize(&image, width, height, FilterType::Triangle);
    let pack = |(index, &value): (usize, &f32)| {
        to_byte(if srgb && index % 4 != 3 { math::linear_to_srgb(value) } else { value })
    };
    Texture { rgba: small.as_raw().iter().enumerate().map(pack).collect(), width, height, ..texture }
}

/// Width and height of an encoded image; `None` if the bytes are no image of a supported format.
pub fn dimensions(bytes: &[u8]) -> Option<(u32, u32)> {
    ImageReader::new(Cursor::new(bytes)).with_guessed_format().ok()?.into_dimensions().ok()
}

/// Samples the image with a bilinear filter, as Vulkan's "Texel Filtering" defines VK_FILTER_LINEAR. The image repeats,
/// and texels are decoded to linear values before they are mixed. (0, 0) is the top left corner, (1, 1) the lower right
/// one.
pub fn bilinear(texture: &Texture, uv: DVec2) -> DVec4 {
    let size = DVec2::new(f64::from(texture.width), f64::from(texture.height));
    let position = (uv - uv.floor()) * size - 0.5;
    let (corner, weight) = (position.floor(), position - position.floor());
    let wrap = |index: f64, size: u32| (index as i64).rem_euclid(i64::from(size)) as usize;
    let texel = |dx: f64, dy: f64| {
        linear_texel(texture, wrap(corner.x + dx, texture.width), wrap(corner.y + dy, texture.height))
    };
    let upper = texel(0.0, 0.0).lerp(texel(1.0, 0.0), weight.x);
    let lower = texel(0.0, 1.0).lerp(texel(1.0, 1.0), weight.x);
    upper.lerp(lower, weight.y)
}

/// Returns a texel, red, green, blue and alpha from 0 to 1, decoded to linear values.
fn linear_texel(texture: &Texture, x: usize, y: usize) -> DVec4 {
    let offset = 4 * (y * texture.width as usize + x);
    let rgba: [u8; 4] = std::array::from_fn(|channel| texture.rgba[offset + channel]);
    let unit = rgba.map(|byte| f64::from(byte) / 255.0);
    match texture.encoding {
        Encoding::Linear => DVec4::from(unit),
        Encoding::Srgb => {
            let [r, g, b] = [0, 1, 2].map(|channel| LINEAR_OF_SRGB_BYTE[usize::from(rgba[channel])]);
            DVec4::new(r, g, b, unit[3])
        }
    }
}

/// Converts the image to an alpha mask. All channels get its alpha channel or, if all texels are opaque, its luminance.
pub fn into_mask(texture: Texture) -> Texture {
    let has_alpha = texture.rgba.chunks_exact(4).any(|texel| texel[3] < 255);
    map_to_grey(texture, |texel| if has_alpha { texel[3] } else { to_byte(encoded_luminance(texel)) })
}

/// Converts the image to a map of factors on the reflectivity. All channels get the luminance of the decoded colour,
/// stored linearly.
pub fn into_reflectivity(texture: Texture) -> Texture {
    map_to_grey(texture, |texel| to_byte(luminance(srgb_to_linear(texel))))
}

/// Converts the image to a tangent-space normal map (green up, linear), with its slopes multiplied by `tilt`.
///
/// If the content is a normal map ([`is_normal_map`]), [`tidy_normal_map`] keeps it. Any other image is treated as a
/// height field of depth [`RELIEF_TEXELS`] · `tilt`.
pub fn into_normal_map(texture: Texture, tilt: f32) -> Texture {
    if is_normal_map(&texture) {
        tidy_normal_map(texture, tilt)
    } else {
        normal_map_from_height(&texture, RELIEF_TEXELS * tilt)
    }
}

/// Multiplies the slopes of a normal map by `tilt`. Its unused black texels become flat, and green is inverted if it
/// points down.
pub fn tidy_normal_map(mut texture: Texture, tilt: f32) -> Texture {
    let green_tilt = if green_correlation(&texture) < GREEN_DOWN { -tilt } else { tilt };
    for texel in texture.rgba.chunks_exact_mut(4) {
        if is_unused(texel) {
            texel[..3].copy_from_slice(&encode_vector(Vec3::Z));
        } else if (tilt, green_tilt) != (1.0, 1.0) {
            let vector = decode_vector(texel);
            let scaled = Vec3::new(vector.x * tilt, vector.y * green_tilt, vector.z.max(1e-3));
            texel[..3].copy_from_slice(&encode_vector(scaled.normalize()));
        }
    }
    texture.encoding = Encoding::Linear;
    texture
}

/// Multiplies the slopes of a normal map with green up by a factor. A factor of 1 leaves the bytes as they are.
pub fn scale_normal_map(mut texture: Texture, factor: f32) -> Texture {
    for texel in texture.rgba.chunks_exact_mut(4).filter(|_| factor != 1.0) {
        let vector = decode_vector(texel);
        let scaled = Vec3::new(vector.x * factor, vector.y * factor, vector.z.max(1e-3));
        texel[..3].copy_from_slice(&encode_vector(scaled.normalize_or(Vec3::Z)));
    }
    texture.encoding = Encoding::Linear;
    texture
}

/// Returns true if the content is a normal map rather than a height field or a colour. In a normal map, nine tenths of
/// the texels that are not black (unused) decode to vectors of length 1 ± 0.2 with z > 0. The sum of all vectors is
/// also close to the z axis, which never holds for a grey image.
pub fn is_normal_map(texture: &Texture) -> bool {
    // The sum of the vectors, the number of them that fit a normal map, and the number of texels that are used.
    let (mut sum, mut fitting, mut used) = (Vec3::ZERO, 0_usize, 0_usize);
    for vector in texture.rgba.chunks_exact(4).filter(|texel| !is_unused(texel)).map(decode_vector) {
        sum += vector;
        fitting += usize::from(vector.z > 0.0 && (vector.length() - 1.0).abs() <= 0.2);
        used += 1;
    }
    used > 0 && fitting * 10 >= used * 9 && sum.z > 2.0 * sum.x.abs().max(sum.y.abs())
}

/// Returns how likely green points up in a normal map, from −1 (down) to 1 (up); values near 0 are inconclusive.
///
/// The slopes of a surface have no curl: ∂(∂h/∂x)/∂y = ∂(∂h/∂y)/∂x. The result is the correlation of the two sides,
/// computed as if green were up. If green points down, the right side has the wrong sign.
fn green_correlation(texture: &Texture) -> f64 {
    let (width, height) = (texture.width as usize, texture.height as usize);
    let texel = |x: usize, y: usize| &texture.rgba[4 * (y * width + x)..][..4];
    let slope = |x, y| {
        let vector = decode_vector(texel(x, y));
        (-vector.truncate() / vector.z.max(0.2)).as_dvec2()
    };
    // Sums over texels of the product of both sides of the equation, and of their squares.
    let (mut product, mut left_squared, mut right_squared) = (0.0, 0.0, 0.0);
    for y in 1..height.saturating_sub(1) {
        for x in 1..width.saturating_sub(1) {
            let neighbours = [(x, y - 1), (x, y + 1), (x - 1, y), (x + 1, y)];
            if neighbours.iter().any(|&(x, y)| is_unused(texel(x, y))) {
                continue;
            }
            let [above, below, before, after] = neighbours.map(|(x, y)| slope(x, y));
            let (left, right) = (above.x - below.x, after.y - before.y);
            product += left * right;
            left_squared += left * left;
            right_squared += right * right;
        }
    }
    product / (left_squared * right_squared).sqrt().max(f64::MIN_POSITIVE)
}

/// Replaces each texel by an opaque grey one, whose byte the function `grey_of` computes from the texel's four bytes.
fn map_to_grey(mut texture: Texture, grey_of: impl Fn(&[u8]) -> u8) -> Texture {
    for texel in texture.rgba.chunks_exact_mut(4) {
        let grey = grey_of(texel);
        texel.copy_from_slice(&[grey, grey, grey, 255]);
    }
    texture.encoding = Encoding::Linear;
    texture
}

/// Computes a tangent-space normal map (green up, linear) from a height field, which is the luminance of the image's
/// bytes. The field wraps around. White is `depth_texels` texel widths above black: 2 gives a modest relief, and
/// negative values invert it.
pub fn normal_map_from_height(image: &Texture, depth_texels: f32) -> Texture {
    let (width, height) = (image.width as usize, image.height as usize);
    let heights: Vec<f32> = image.rgba.chunks_exact(4).map(encoded_luminance).collect();
    let mut rgba = Vec::with_capacity(image.rgba.len());
    for y in 0..height {
        let (above, below) = ((y + height - 1) % height * width, (y + 1) % height * width);
        for x in 0..width {
            let (left, right) = ((x + width - 1) % width, (x + 1) % width);
            let slope_right = 0.5 * (heights[y * width + right] - heights[y * width + left]);
            let slope_up = 0.5 * (heights[above + x] - heights[below + x]);
            let slope = Vec2::new(slope_right, slope_up) * depth_texels;
            rgba.extend(encode_vector((-slope).extend(1.0).normalize()));
            rgba.push(255);
        }
    }
    Texture { name: image.name.clone(), width: image.width, height: image.height, rgba, encoding: Encoding::Linear }
}

/// Luminance of a linear colour with the primaries of sRGB (Rec. 709).
pub fn luminance(linear: Vec3) -> f32 {
    linear.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

/// Returns the luminance of a texel's raw bytes, 0…1. Heights and masks are data, so that nothing is decoded.
fn encoded_luminance(texel: &[u8]) -> f32 {
    luminance(Vec3::new(texel[0].into(), texel[1].into(), texel[2].into()) / 255.0)
}

/// Returns the linear colour of a texel whose bytes are sRGB.
fn srgb_to_linear(texel: &[u8]) -> Vec3 {
    let decode = |byte: u8| {
        let encoded = f32::from(byte) / 255.0;
        if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
    };
    Vec3::new(decode(texel[0]), decode(texel[1]), decode(texel[2]))
}

/// Converts a number from 0 to 1 to the nearest byte from 0 to 255.
fn to_byte(unit: f32) -> u8 {
    (unit.clamp(0.0, 1.0) * 255.0).round() as u8
}

/// Returns the vector of a texel of a normal map: bytes from 0 to 255 become −1 to 1.
fn decode_vector(texel: &[u8]) -> Vec3 {
    Vec3::new(texel[0].into(), texel[1].into(), texel[2].into()) / 127.5 - 1.0
}

/// Returns true if a texel is nearly black. Unused parts of normal maps are black, which decodes to no unit vector.
fn is_unused(texel: &[u8]) -> bool {
    texel[..3].iter().all(|&byte| byte <= 8)
}

/// Returns the bytes of a unit vector in a normal map, the inverse of [`decode_vector`].
fn encode_vector(unit: Vec3) -> [u8; 3] {
    (unit * 0.5 + 0.5).to_array().map(to_byte)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_image_that_does_not_fit_takes_no_room_from_later_ones() {
        let mut budget = TexelBudget::default();
        assert!(budget.admits(1 << 15, 1 << 14, u32::MAX), "half of all texels");
        assert!(!budget.admits(1 << 15, (1 << 14) + 1, u32::MAX), "one row too many");
        assert!(budget.admits(1 << 20, 1 << 19, 1 << 15), "shrunk to the other half");
        assert!(!budget.admits(1, 1, u32::MAX), "nothing is left");
    }

    /// Makes a grey image whose bytes are a function of column and row.
    fn grey(width: u32, height: u32, value: impl Fn(u32, u32) -> u8) -> Texture {
        let texels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let rgba = texels.flat_map(|(x, y)| [value(x, y), value(x, y), value(x, y), 255]).collect();
        Texture { name: "grey".into(), width, height, rgba, encoding: Encoding::Srgb }
    }

    /// The normal at a texel of a normal map.
    fn normal_at(map: &Texture, x: u32, y: u32) -> Vec3 {
        let offset = 4 * (y * map.width + x) as usize;
        decode_vector(&map.rgba[offset..offset + 4])
    }

    #[test]
    fn a_flat_height_field_points_straight_out() {
        let map = normal_map_from_height(&grey(4, 4, |_, _| 90), 2.0);
        assert!((normal_at(&map, 1, 2) - Vec3::Z).length() < 0.02);
        assert_eq!(map.encoding, Encoding::Linear);
    }

    #[test]
    fn slopes_lean_away_from_the_rise() {
        let rises_right = normal_map_from_height(&grey(8, 8, |x, _| (x * 30) as u8), 4.0);
        assert!(normal_at(&rises_right, 4, 4).x < -0.2);
        // Row 0 is the top. If heights rise downwards, the normal leans up, and green points up.
        let rises_down = normal_map_from_height(&grey(8, 8, |_, y| (y * 30) as u8), 4.0);
        assert!(normal_at(&rises_down, 4, 4).y > 0.2);
        let inverted = normal_map_from_height(&grey(8, 8, |_, y| (y * 30) as u8), -4.0);
        assert!(normal_at(&inverted, 4, 4).y < -0.2);
    }

    #[test]
    fn grey_images_are_not_normal_maps_but_derived_maps_are() {
        for value in 0..=255 {
            assert!(!is_normal_map(&grey(2, 2, |_, _| value)), "grey {value}");
        }
        let bumps = grey(16, 16, |x, y| ((x * 53 + y * 91) % 256) as u8);
        assert!(!is_normal_map(&bumps));
        assert!(is_normal_map(&normal_map_from_height(&bumps, 2.0)));
    }

    /// A smooth height field of 32 × 32 texels.
    fn bumps() -> Texture {
        let wave = |x: u32, y: u32| (0.4 * x as f32).sin() * (0.3 * y as f32).cos() * 90.0 + 128.0;
        grey(32, 32, |x, y| wave(x, y) as u8)
    }

    /// A factor below 1 flattens the slopes, one above 1 steepens them, and 1 changes no byte.
    #[test]
    fn the_tilt_factor_flattens_or_steepens_the_slopes() {
        let map = normal_map_from_height(&bumps(), 4.0);
        let slope_sum = |map: &Texture| (0..32).map(|x| normal_at(map, x, 7).x.abs()).sum::<f32>();
        assert_eq!(into_normal_map(map.clone(), 1.0), map);
        assert!(slope_sum(&into_normal_map(map.clone(), 0.5)) < 0.7 * slope_sum(&map));
        assert!(slope_sum(&into_normal_map(map.clone(), 2.0)) > 1.3 * slope_sum(&map));
        assert!(slope_sum(&into_normal_map(map.clone(), 0.0)) < 0.2);
    }

    /// A normal map whose green points down is turned, and its black texels become flat.
    #[test]
    fn green_down_is_inverted_and_black_is_flattened() {
        let map = normal_map_from_height(&bumps(), 4.0);
        assert!(green_correlation(&map) > 0.5, "{}", green_correlation(&map));
        let mut map_of_green_down = map.clone();
        map_of_green_down.rgba.chunks_exact_mut(4).for_each(|texel| texel[1] = 255 - texel[1]);
        assert!(green_correlation(&map_of_green_down) < -0.5);
        map_of_green_down.rgba[..4 * 32 * 8].fill(0);
        let turned = into_normal_map(map_of_green_down, 1.0);
        assert!((normal_at(&turned, 3, 3) - Vec3::Z).length() < 0.02);
        for (x, y) in [(3, 12), (17, 20), (30, 30)] {
            let (converted, original) = (normal_at(&turned, x, y), normal_at(&map, x, y));
            assert!((converted - original).length() < 0.03, "{converted} {original}");
        }
    }

    /// A mask takes alpha, or the luminance if all texels are opaque. Reflectivity takes the decoded luminance.
    #[test]
    fn masks_prefer_alpha_and_reflectivity_is_linear() {
        let mut image = grey(1, 2, |_, _| 188);
        assert_eq!(into_mask(image.clone()).rgba, [188, 188, 188, 255].repeat(2));
        image.rgba[3] = 0;
        assert_eq!(into_mask(image.clone()).rgba, [0, 0, 0, 255, 255, 255, 255, 255]);
        // sRGB 188 is half of the linear range.
        assert!(into_reflectivity(image).rgba[0].abs_diff(128) <= 1);
    }
}

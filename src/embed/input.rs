//! Images of another renderer, and the checks of whether they can be used.

use super::camera::ConvertedCamera;
use crate::error::{Error, Result};
use crate::gpu::sync::ImageUse;
use crate::gpu::{Frame, Gpu, Image};
use crate::passes::import::Factor;
use ash::vk;
use ash::vk::Handle;
use glam::Mat3;
use ssct_ground::conventions::{NormalEncoding, NormalSpace};
use ssct_ground::math::constants::{NORMAL_FLOAT, NORMAL_OCTAHEDRAL, NORMAL_OCTAHEDRAL_UNORM, NORMAL_UNORM};

/// An image of the caller. The crate reads one level and one layer of the image, or six layers of a cube map.
#[derive(Debug, Clone, Copy)]
pub struct ImageInput {
    /// The image.
    pub image: vk::Image,
    /// A view of the part that is read. The view of a depth image shows the depth alone.
    pub view: vk::ImageView,
    /// The part that the view shows, with every aspect that a barrier of the image's format needs.
    pub part: vk::ImageSubresourceRange,
    /// The image's format.
    pub format: vk::Format,
    /// Width and height of the part in texels.
    pub extent: [u32; 2],
    /// The usage that the image was made with. It contains `SAMPLED`, or `STORAGE` for an image of triangle numbers.
    pub usage: vk::ImageUsageFlags,
    /// How the caller used the image last.
    pub before: ImageUse,
    /// How the caller uses the image next. The recorded commands leave the image in the layout of that use.
    pub after: ImageUse,
}

impl ImageInput {
    /// A colour image of one level and one layer, sampled before and after in fragment shaders.
    pub fn color(image: vk::Image, view: vk::ImageView, format: vk::Format, extent: [u32; 2]) -> Self {
        let part = vk::ImageSubresourceRange {
            aspect_mask: vk::ImageAspectFlags::COLOR,
            base_mip_level: 0,
            level_count: 1,
            base_array_layer: 0,
            layer_count: 1,
        };
        let (usage, sampled) = (vk::ImageUsageFlags::SAMPLED, ImageUse::FRAGMENT_SAMPLED);
        Self { image, view, part, format, extent, usage, before: sampled, after: sampled }
    }

    /// A depth image of one level and one layer, without stencil.
    pub fn depth(image: vk::Image, view: vk::ImageView, format: vk::Format, extent: [u32; 2]) -> Self {
        let color = Self::color(image, view, format, extent);
        let part = vk::ImageSubresourceRange { aspect_mask: vk::ImageAspectFlags::DEPTH, ..color.part };
        Self { part, ..color }
    }

    /// A whole cube map with one level that is used as colour; the view is an array of its six faces.
    pub fn cube(image: vk::Image, view: vk::ImageView, format: vk::Format, extent: [u32; 2]) -> Self {
        let color = Self::color(image, view, format, extent);
        Self { part: vk::ImageSubresourceRange { layer_count: 6, ..color.part }, ..color }
    }

    /// Returns this input with other uses by the caller before and after.
    #[must_use]
    pub fn used(self, before: ImageUse, after: ImageUse) -> Self {
        Self { before, after, ..self }
    }

    /// Checks an image that shaders sample; `extent` is `None` for a cube map.
    pub(super) fn check(&self, name: &str, extent: Option<[u32; 2]>) -> Result<()> {
        self.check_any(name, extent, (vk::ImageUsageFlags::SAMPLED, "SAMPLED"))?;
        let wrong = |why: String| Err(Error::Usage(format!("the input {name} {why}")));
        let aspects = self.part.aspect_mask;
        if aspects.intersects(vk::ImageAspectFlags::DEPTH) != is_depth_format(self.format) {
            return wrong(format!("has the format {:?} and the aspects {aspects:?}", self.format));
        }
        if is_integer(self.format) {
            return wrong(format!("has the format {:?}, whose texels are no floats for a shader", self.format));
        }
        Ok(())
    }

    /// Checks an image whose pixels have the number of the triangle that they show.
    pub(super) fn check_numbers(&self, name: &str, extent: [u32; 2]) -> Result<()> {
        self.check_any(name, Some(extent), (vk::ImageUsageFlags::STORAGE, "STORAGE"))?;
        if self.format != vk::Format::R32_UINT {
            let format = self.format;
            return Err(Error::Usage(format!("the input {name} has the format {format:?}; it must be R32_UINT")));
        }
        Ok(())
    }

    /// Checks handles, size, usage, layouts, levels and layers of an image of any format. `extent` is `None` for a cube
    /// map, and `usage` is the usage that the image must have been made with.
    fn check_any(
        &self,
        name: &str,
        extent: Option<[u32; 2]>,
        (usage, usage_name): (vk::ImageUsageFlags, &str),
    ) -> Result<()> {
        let wrong = |why: String| Err(Error::Usage(format!("the input {name} {why}")));
        let part = &self.part;
        if self.image.is_null() || self.view.is_null() {
            return wrong("has a null handle".into());
        }
        if let Some([width, height]) = extent.filter(|e| *e != self.extent) {
            let [w, h] = self.extent;
            return wrong(format!("is {w}x{h} pixels; it must be {width}x{height}"));
        }
        if !self.usage.contains(usage) {
            return wrong(format!("was made without the usage {usage_name}, so that no shader can read it"));
        }
        if self.before.layout == vk::ImageLayout::UNDEFINED || self.after.layout == vk::ImageLayout::UNDEFINED {
            return wrong("has the layout UNDEFINED before or after: its content would be lost".into());
        }
        let layers = if extent.is_none() { 6 } else { 1 };
        if part.level_count != 1 || part.layer_count != layers {
            let (level_count, layer_count) = (part.level_count, part.layer_count);
            return wrong(format!("shows {level_count} levels and {layer_count} layers; it must be 1 and {layers}"));
        }
        Ok(())
    }
}

/// The caller's images that a frame reads, each with its input. An image that several inputs share is listed once.
#[derive(Default)]
pub(super) struct BorrowedImages(Vec<(ImageInput, Image)>);

/// The index of an input's image in [`BorrowedImages`].
#[derive(Debug, Clone, Copy)]
pub(super) struct BorrowedIndex(usize);

impl BorrowedImages {
    /// Adds the image of an input, unless an earlier input has the same image.
    ///
    /// # Errors
    /// [`Error::Usage`] if an earlier input is the same image with another use.
    pub fn add(&mut self, gpu: &Gpu, name: &str, input: &ImageInput) -> Result<BorrowedIndex> {
        let viewed_part = |i: &ImageInput| (i.image, i.view, i.part.base_mip_level, i.part.base_array_layer);
        let Some(index) = self.0.iter().position(|(known, _)| viewed_part(known) == viewed_part(input)) else {
            let format = (input.format, input.extent);
            self.0.push((*input, Image::borrowed(gpu, name, (input.image, input.view), input.part, format)));
            return Ok(BorrowedIndex(self.0.len() - 1));
        };
        let known = &self.0[index].0;
        if (known.before, known.after) == (input.before, input.after) {
            return Ok(BorrowedIndex(index));
        }
        Err(Error::Usage(format!(
            "the input {name} is the same image as another input, but declares a different use before or after"
        )))
    }

    /// The image of an input.
    pub fn image(&self, index: BorrowedIndex) -> &Image {
        &self.0[index.0].1
    }

    /// Tells a frame the use in which the caller left each image.
    pub fn begin(&self, frame: &mut Frame) {
        self.0.iter().for_each(|(input, image)| frame.take_over(image, input.before));
    }

    /// Hands each image back to the caller, ready for the next use that its input declares.
    pub fn end(&self, frame: &mut Frame) {
        self.0.iter().for_each(|(input, image)| frame.hand_over(image, input.after));
    }
}

/// Whether a format has depth, with or without stencil.
fn is_depth_format(format: vk::Format) -> bool {
    use vk::Format as F;
    matches!(
        format,
        F::D16_UNORM
            | F::X8_D24_UNORM_PACK32
            | F::D32_SFLOAT
            | F::D16_UNORM_S8_UINT
            | F::D24_UNORM_S8_UINT
            | F::D32_SFLOAT_S8_UINT
    )
}

/// Whether a shader reads the texels of a format as integers, by the name of the format in Vulkan.
fn is_integer(format: vk::Format) -> bool {
    let name = format!("{format:?}");
    !is_depth_format(format) && ["UINT", "SINT"].iter().any(|kind| name.contains(kind))
}

/// Whether a format can hold numbers below 0, by its name in Vulkan.
fn is_signed_format(format: vk::Format) -> bool {
    let name = format!("{format:?}");
    !["UNORM", "UFLOAT", "SRGB"].iter().any(|kind| name.contains(kind))
}

/// The normals of another renderer's G-buffer.
#[derive(Debug, Clone, Copy)]
pub struct NormalInput {
    /// The image of the normals.
    pub image: ImageInput,
    /// The space of the normals.
    pub space: NormalSpace,
    /// How texels hold the normals.
    pub encoding: NormalEncoding,
}

impl NormalInput {
    /// Checks the image, and that its format can hold the signs of encodings that have them.
    pub(super) fn check(&self, extent: [u32; 2]) -> Result<()> {
        self.image.check("normal", Some(extent))?;
        let has_signs = matches!(self.encoding, NormalEncoding::Float | NormalEncoding::Octahedral);
        let format = self.image.format;
        if has_signs && !is_signed_format(format) {
            let encoding = self.encoding;
            return Err(Error::Usage(format!(
                "the input normal is encoded as {encoding:?}, and its format {format:?} holds no number below 0"
            )));
        }
        Ok(())
    }

    /// Returns the code `NORMAL_*` of the encoding, and the matrix from a decoded normal to our view space.
    pub(super) fn code_and_matrix(&self, camera: &ConvertedCamera) -> (i32, Mat3) {
        let code = match self.encoding {
            NormalEncoding::Float => NORMAL_FLOAT,
            NormalEncoding::Unorm => NORMAL_UNORM,
            NormalEncoding::Octahedral => NORMAL_OCTAHEDRAL,
            NormalEncoding::OctahedralUnorm => NORMAL_OCTAHEDRAL_UNORM,
        };
        match self.space {
            NormalSpace::View => (code, camera.their_view_to_ours),
            NormalSpace::World => (code, Mat3::from_mat4(camera.camera.world_to_view)),
        }
    }
}

/// The motion of each pixel: the way over the screen from where its surface is to where the surface was in the frame
/// before. Along it the history finds the reflections of moving surfaces, and of moving things that the screen shows.
#[derive(Debug, Clone, Copy)]
pub struct MotionInput {
    /// The image of the motion: x in red and y in green.
    pub image: ImageInput,
    /// How many pixels one unit of the motion is, x to the right and y down: 1 and 1 for motion in pixels, the image's
    /// width and height for motion in texture coordinates. Negate the second number if y points up, and both if the
    /// motion leads from the frame before to this one.
    pub scale: [f32; 2],
    /// Whether the motion contains the difference of the two frames' jitter. Motion does if it was computed with the
    /// jittered matrices that the images were drawn with.
    pub jittered: bool,
}

impl MotionInput {
    /// Checks the image, that its format has two channels with signs, and the scale.
    pub(super) fn check(&self, extent: [u32; 2]) -> Result<()> {
        self.image.check("motion", Some(extent))?;
        let (format, scale) = (self.image.format, self.scale);
        let has_green = !is_depth_format(format) && format!("{format:?}").contains('G');
        if !has_green {
            return Err(Error::Usage(format!("the input motion has the format {format:?}, which has no green for y")));
        }
        if !is_signed_format(format) {
            return Err(Error::Usage(format!(
                "the input motion has the format {format:?}, which holds no number below 0"
            )));
        }
        if !scale.iter().all(|s| s.is_finite() && *s != 0.0) {
            return Err(Error::Usage(format!(
                "the input motion has the scale {scale:?}; both must be finite and not 0"
            )));
        }
        Ok(())
    }
}

/// Reflectivity or roughness of a frame (docs/definitions.md, "Surfaces").
#[derive(Debug, Clone, Copy)]
pub enum FactorInput {
    /// One value for the whole frame, 0…1.
    Constant(f32),
    /// A channel, 0 to 3 for red to alpha, of an image.
    Channel(ImageInput, u32),
}

impl FactorInput {
    /// Checks the range of the value, or the channel and its image.
    pub(super) fn check(&self, name: &str, extent: [u32; 2]) -> Result<()> {
        match self {
            Self::Constant(value) if (0.0..=1.0).contains(value) => Ok(()),
            Self::Constant(value) => Err(Error::Usage(format!("the input {name} is {value}; it must be 0 to 1"))),
            Self::Channel(_, channel) if *channel > 3 => {
                Err(Error::Usage(format!("the input {name} is in channel {channel}; there are the channels 0 to 3")))
            }
            Self::Channel(image, _) => image.check(name, Some(extent)),
        }
    }

    /// Adds the image of the factor, if there is one, to the borrowed images, and returns the factor with its index.
    pub(super) fn borrow(&self, borrowed: &mut BorrowedImages, gpu: &Gpu, name: &str) -> Result<BorrowedFactor> {
        Ok(match self {
            // A constant is rounded as an image of half floats would round it.
            Self::Constant(value) => BorrowedFactor::Constant(half::f16::from_f32(*value).to_f32()),
            Self::Channel(image, channel) => BorrowedFactor::Channel(borrowed.add(gpu, name, image)?, *channel),
        })
    }
}

/// A [`FactorInput`] whose image is borrowed from the caller.
#[derive(Debug, Clone, Copy)]
pub(super) enum BorrowedFactor {
    Constant(f32),
    Channel(BorrowedIndex, u32),
}

impl BorrowedFactor {
    /// The factor in the form in which the import pass reads it.
    pub fn to_factor(self, borrowed: &BorrowedImages) -> Factor<'_> {
        match self {
            Self::Constant(value) => Factor::Constant(value),
            Self::Channel(index, channel) => Factor::Channel(borrowed.image(index), channel),
        }
    }
}

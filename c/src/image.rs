//! The caller's images and camera.

use crate::border::{Failure, Outcome, copy_struct, sized_structs, value_or};
use crate::vulkan::{
    VkAccessFlags2, VkBool32, VkExtent2D, VkFormat, VkImage, VkImageLayout, VkImageSubresourceRange, VkImageUsageFlags,
    VkImageView, VkPipelineStageFlags2,
};
use ash::vk;
use ssct::{
    CameraInput, ClipY, FactorInput, ImageInput, ImageUse, MotionInput, NormalEncoding, NormalInput, NormalSpace,
};

/// The place of an image's top in clip space: one of SSCT_CLIP_Y_*.
pub type SsctClipY = u32;

/// The image's top is at y = -w, as in Vulkan with a viewport of positive height.
pub const SSCT_CLIP_Y_DOWN: SsctClipY = 0;
/// The image's top is at y = w: the viewport has a negative height.
pub const SSCT_CLIP_Y_UP: SsctClipY = 1;

/// The space of normals: one of SSCT_NORMAL_SPACE_*.
pub type SsctNormalSpace = u32;

/// Your view space.
pub const SSCT_NORMAL_SPACE_VIEW: SsctNormalSpace = 0;
/// Your world space.
pub const SSCT_NORMAL_SPACE_WORLD: SsctNormalSpace = 1;

/// How texels hold unit normals: one of SSCT_NORMAL_ENCODING_*.
pub type SsctNormalEncoding = u32;

/// A texel holds x, y and z without a mapping, in floats or signed normalised numbers.
pub const SSCT_NORMAL_ENCODING_FLOAT: SsctNormalEncoding = 0;
/// A texel holds x, y and z, each mapped from the range -1 to 1 into the range 0 to 1.
pub const SSCT_NORMAL_ENCODING_UNORM: SsctNormalEncoding = 1;
/// A texel holds two numbers from -1 to 1: the place on an octahedron that is unfolded to a square.
pub const SSCT_NORMAL_ENCODING_OCTAHEDRAL: SsctNormalEncoding = 2;
/// A texel holds the place on the octahedron, with both numbers mapped into the range 0 to 1.
pub const SSCT_NORMAL_ENCODING_OCTAHEDRAL_UNORM: SsctNormalEncoding = 3;

/// A common use of an image: one of SSCT_USE_*.
pub type SsctUse = u32;

/// Sampled in fragment shaders, in SHADER_READ_ONLY_OPTIMAL.
pub const SSCT_USE_FRAGMENT_SAMPLED: SsctUse = 0;
/// Sampled in compute shaders, in SHADER_READ_ONLY_OPTIMAL.
pub const SSCT_USE_COMPUTE_SAMPLED: SsctUse = 1;
/// Drawn into as a colour attachment.
pub const SSCT_USE_COLOR_ATTACHMENT: SsctUse = 2;
/// Drawn into as a depth attachment; the layout is for the depth aspect alone.
pub const SSCT_USE_DEPTH_ATTACHMENT: SsctUse = 3;
/// Copied or blitted from.
pub const SSCT_USE_TRANSFER_SOURCE: SsctUse = 4;
/// Copied or blitted to, or cleared.
pub const SSCT_USE_TRANSFER_TARGET: SsctUse = 5;

/// How you use an image before or after the library's commands: its layout, and the pipeline stages and accesses of
/// your use. A struct of zeros means SSCT_USE_FRAGMENT_SAMPLED.
#[repr(C)]
#[derive(Clone, Copy, PartialEq)]
pub struct SsctImageUse {
    /// The image's layout.
    pub layout: VkImageLayout,
    /// Pipeline stages that use the image.
    pub stages: VkPipelineStageFlags2,
    /// How these stages access the image.
    pub access: VkAccessFlags2,
}

/// An image of yours. The library reads one level and one layer of the image, or six layers of a cube map.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct SsctImage {
    /// sizeof(SsctImage).
    pub struct_size: usize,
    /// The image.
    pub image: VkImage,
    /// A view of the part that is read. The view of a depth image shows the depth alone; the view of a cube map is an array of the
    /// six faces.
    pub view: VkImageView,
    /// The image's format.
    pub format: VkFormat,
    /// Width and height of the part in texels.
    pub extent: VkExtent2D,
    /// The part that the view shows, with every aspect that a barrier of the image's format needs. Aspects of 0 stand for all
    /// aspects of the format. A count of 0 stands for one level, for one layer, or for the six layers of a cube map.
    pub part: VkImageSubresourceRange,
    /// The usage that the image was made with: VK_IMAGE_USAGE_SAMPLED_BIT must be in it, or VK_IMAGE_USAGE_STORAGE_BIT for numbers
    /// of triangles. 0 stands for both bits.
    pub usage: VkImageUsageFlags,
    /// How you used the image last.
    pub before: SsctImageUse,
    /// How you use the image next. The recorded commands leave the image in the layout of that use.
    pub after: SsctImageUse,
}

/// The camera of a frame, in your conventions. The library finds in the matrices whether space is left-handed, whether
/// y is up, whether depth is reversed, where the far plane is, and how far a jittered projection is shifted. A matrix
/// is 16 numbers, column by column, and is multiplied by column vectors from the right.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct SsctCamera {
    /// sizeof(SsctCamera).
    pub struct_size: usize,
    /// World to view space: a rotation and a translation.
    pub world_to_view: [f32; 16],
    /// View to clip space: a perspective or an orthographic projection, with the jitter that the images were drawn with. An
    /// orthographic projection has its near plane at the eye or in front of the eye.
    pub view_to_clip: [f32; 16],
    /// The place of the image's top in clip space.
    pub clip_y: SsctClipY,
}

/// The normals of your G-buffer.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct SsctNormals {
    /// sizeof(SsctNormals).
    pub struct_size: usize,
    /// The image of the normals.
    pub image: *const SsctImage,
    /// The space of the normals.
    pub space: SsctNormalSpace,
    /// How texels hold the normals.
    pub encoding: SsctNormalEncoding,
}

/// Reflectivity or roughness of a frame: a channel of an image, or one value.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct SsctFactor {
    /// sizeof(SsctFactor).
    pub struct_size: usize,
    /// The image; NULL for one value.
    pub image: *const SsctImage,
    /// The image's channel, 0 to 3 for red to alpha.
    pub channel: u32,
    /// The value for the whole frame, 0 to 1; read only if `image` is NULL.
    pub value: f32,
}

/// The motion of each pixel: the way over the screen from where its surface is to where the surface was in the frame before, x in
/// red and y in green.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct SsctMotion {
    /// sizeof(SsctMotion).
    pub struct_size: usize,
    /// The image of the motion, in floats or signed normalised numbers.
    pub image: *const SsctImage,
    /// How many pixels one unit of the motion is, x to the right and y down. Give 1 and 1 if the motion is in pixels,
    /// and the image's width and height if the motion is in texture coordinates. Negate the second number if y points
    /// up. Negate both numbers if the motion leads from the frame before to this one.
    pub scale: [f32; 2],
    /// Whether the motion contains the difference of the two frames' jitter. Motion does if it was computed with the
    /// jittered matrices that the images were drawn with.
    pub jittered: VkBool32,
}

sized_structs!(SsctImage, SsctCamera, SsctNormals, SsctFactor, SsctMotion);

/// Returns layout, stages and accesses of a common use of an image; a struct of zeros for a number that is none of
/// SSCT_USE_*.
#[unsafe(no_mangle)]
pub extern "C" fn ssct_image_use(kind: SsctUse) -> SsctImageUse {
    let no_use = SsctImageUse { layout: VkImageLayout::UNDEFINED, stages: 0, access: 0 };
    value_or(no_use, || {
        let known = match kind {
            SSCT_USE_FRAGMENT_SAMPLED => ImageUse::FRAGMENT_SAMPLED,
            SSCT_USE_COMPUTE_SAMPLED => ImageUse::COMPUTE_SAMPLED,
            SSCT_USE_COLOR_ATTACHMENT => ImageUse::COLOR_ATTACHMENT,
            SSCT_USE_DEPTH_ATTACHMENT => ImageUse::DEPTH_ATTACHMENT,
            SSCT_USE_TRANSFER_SOURCE => ImageUse::TRANSFER_SOURCE,
            SSCT_USE_TRANSFER_TARGET => ImageUse::TRANSFER_TARGET,
            other => return Err(none_of("SSCT_USE_*", "kind", other)),
        };
        let ImageUse { layout, stages, access } = known;
        Ok(SsctImageUse { layout, stages: stages.as_raw(), access: access.as_raw() })
    })
}

/// Makes the failure of a field whose value is none of the constants `names`, such as SSCT_CLIP_Y_*.
pub fn none_of(names: &str, field: &str, value: u32) -> Failure {
    Failure::usage(format!("{field} is {value}, which is none of {names}"))
}

impl SsctImageUse {
    /// Converts the use to the Rust interface's type. A struct of zeros becomes [`ImageUse::FRAGMENT_SAMPLED`].
    pub fn to_image_use(self) -> ImageUse {
        let Self { layout, stages, access } = self;
        if layout == VkImageLayout::UNDEFINED && stages == 0 && access == 0 {
            return ImageUse::FRAGMENT_SAMPLED;
        }
        let (stages, access) = (vk::PipelineStageFlags2::from_raw(stages), vk::AccessFlags2::from_raw(access));
        ImageUse { layout, stages, access }
    }
}

/// Copies the caller's image into the Rust interface's type, with defaults for fields that are 0. `layers` is 1, or 6
/// for a cube map.
///
/// # Safety
/// The pointer is NULL or points to such a struct.
pub unsafe fn to_image_input(argument: &str, pointer: *const SsctImage, layers: u32) -> Outcome<ImageInput> {
    // SAFETY: the caller keeps to the contract of this function.
    let SsctImage { image, view, format, extent, mut part, mut usage, before, after, .. } =
        unsafe { copy_struct(argument, pointer) }?;
    if part.aspect_mask.is_empty() {
        part.aspect_mask = aspects(format);
    }
    for (count, default) in [(&mut part.level_count, 1), (&mut part.layer_count, layers)] {
        if *count == 0 {
            *count = default;
        }
    }
    if usage.is_empty() {
        usage = VkImageUsageFlags::SAMPLED | VkImageUsageFlags::STORAGE;
    }
    let extent = [extent.width, extent.height];
    let (before, after) = (before.to_image_use(), after.to_image_use());
    Ok(ImageInput { image, view, part, format, extent, usage, before, after })
}

/// Returns all aspects (colour, depth, stencil) that an image of a format has.
fn aspects(format: VkFormat) -> vk::ImageAspectFlags {
    use vk::ImageAspectFlags as A;
    match format {
        VkFormat::D16_UNORM | VkFormat::X8_D24_UNORM_PACK32 | VkFormat::D32_SFLOAT => A::DEPTH,
        VkFormat::D16_UNORM_S8_UINT | VkFormat::D24_UNORM_S8_UINT | VkFormat::D32_SFLOAT_S8_UINT => {
            A::DEPTH | A::STENCIL
        }
        _ => A::COLOR,
    }
}

/// Converts a constant of the header to the Rust interface's type; fails for a number that is none of SSCT_CLIP_Y_*.
pub fn to_clip_y(field: &str, value: SsctClipY) -> Outcome<ClipY> {
    match value {
        SSCT_CLIP_Y_DOWN => Ok(ClipY::Down),
        SSCT_CLIP_Y_UP => Ok(ClipY::Up),
        other => Err(none_of("SSCT_CLIP_Y_*", field, other)),
    }
}

/// Copies the caller's camera into the Rust interface's type.
///
/// # Safety
/// The contract is that of [`to_image_input`].
pub unsafe fn to_camera_input(pointer: *const SsctCamera) -> Outcome<CameraInput> {
    // SAFETY: the caller keeps to the contract of this function.
    let SsctCamera { world_to_view, view_to_clip, clip_y: y, .. } = unsafe { copy_struct("frame.camera", pointer) }?;
    Ok(CameraInput { world_to_view, view_to_clip, clip_y: to_clip_y("frame.camera.clip_y", y)? })
}

/// Copies the caller's description of normals into the Rust interface's type.
///
/// # Safety
/// The contract is that of [`to_image_input`].
pub unsafe fn to_normal_input(pointer: *const SsctNormals) -> Outcome<NormalInput> {
    // SAFETY: the caller keeps to the contract of this function.
    let (normals, image) = unsafe {
        let normals = copy_struct("frame.normals", pointer)?;
        (normals, to_image_input("frame.normals.image", normals.image, 1)?)
    };
    let space = match normals.space {
        SSCT_NORMAL_SPACE_VIEW => NormalSpace::View,
        SSCT_NORMAL_SPACE_WORLD => NormalSpace::World,
        other => return Err(none_of("SSCT_NORMAL_SPACE_*", "frame.normals.space", other)),
    };
    let encoding = match normals.encoding {
        SSCT_NORMAL_ENCODING_FLOAT => NormalEncoding::Float,
        SSCT_NORMAL_ENCODING_UNORM => NormalEncoding::Unorm,
        SSCT_NORMAL_ENCODING_OCTAHEDRAL => NormalEncoding::Octahedral,
        SSCT_NORMAL_ENCODING_OCTAHEDRAL_UNORM => NormalEncoding::OctahedralUnorm,
        other => return Err(none_of("SSCT_NORMAL_ENCODING_*", "frame.normals.encoding", other)),
    };
    Ok(NormalInput { image, space, encoding })
}

/// Copies the caller's factor into the Rust interface's type: one value if `image` is NULL, else a channel of the image.
///
/// # Safety
/// The contract is that of [`to_image_input`].
pub unsafe fn to_factor_input(argument: &str, pointer: *const SsctFactor) -> Outcome<FactorInput> {
    // SAFETY: the caller keeps to the contract of this function.
    unsafe {
        let factor = copy_struct(argument, pointer)?;
        if factor.image.is_null() {
            return Ok(FactorInput::Constant(factor.value));
        }
        Ok(FactorInput::Channel(to_image_input(&format!("{argument}.image"), factor.image, 1)?, factor.channel))
    }
}

/// Copies the caller's motion into the Rust interface's type; `None` for NULL.
///
/// # Safety
/// The contract is that of [`to_image_input`].
pub unsafe fn to_motion_input(argument: &str, pointer: *const SsctMotion) -> Outcome<Option<MotionInput>> {
    if pointer.is_null() {
        return Ok(None);
    }
    // SAFETY: the caller keeps to the contract of this function.
    unsafe {
        let SsctMotion { image: pointer, scale, jittered, .. } = copy_struct(argument, pointer)?;
        let image = to_image_input(&format!("{argument}.image"), pointer, 1)?;
        Ok(Some(MotionInput { image, scale, jittered: jittered != vk::FALSE }))
    }
}

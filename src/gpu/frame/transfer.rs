//! Copies, blits, clears, uploads and read-backs, each a pass of its own.

use super::Frame;
use crate::error::Result;
use crate::gpu::image::ImageSlice;
use crate::gpu::memory::Buffer;
use crate::gpu::sync::Access;
use ash::vk;

impl Frame<'_> {
    /// Scales one level into another with a linear filter: one step of a hardware mip chain.
    pub fn blit(&mut self, name: &str, from: ImageSlice, to: ImageSlice) -> Result<()> {
        self.blit_between(name, from, to, [layers(&from), layers(&to)], vk::Filter::LINEAR)
    }

    /// Copies each texel of a level into an image of the same size, and converts the texel to the format of that image.
    pub fn convert(&mut self, name: &str, from: ImageSlice, to: ImageSlice) -> Result<()> {
        self.blit_between(name, from, to, [layers(&from), layers(&to)], vk::Filter::NEAREST)
    }

    /// Scales one layer of a level into the same layer of another: a step of the mip chain of one face of a cube map.
    pub fn blit_layer(&mut self, name: &str, from: ImageSlice, to: ImageSlice, layer: u32) -> Result<()> {
        self.blit_between(
            name,
            from,
            to,
            [layer_of(name, &from, layer), layer_of(name, &to, layer)],
            vk::Filter::LINEAR,
        )
    }

    /// Records a pass of one command, which reads an image and writes another.
    fn transfer(&mut self, name: &str, from: ImageSlice, to: ImageSlice, command: impl FnOnce(&Frame)) -> Result<()> {
        self.pass(name, |frame| {
            frame.use_image(from, Access::TransferRead);
            frame.use_image(to, Access::TransferWrite);
            frame.flush();
            command(frame);
            Ok(())
        })
    }

    /// Scales layers of one level into layers of another by a blit with a filter.
    fn blit_between(
        &mut self,
        name: &str,
        from: ImageSlice,
        to: ImageSlice,
        [source, target]: [vk::ImageSubresourceLayers; 2],
        filter: vk::Filter,
    ) -> Result<()> {
        self.transfer(name, from, to, |frame| {
            let corners = |slice: &ImageSlice| {
                let [width, height] = slice.extent();
                [vk::Offset3D::default(), vk::Offset3D { x: width as i32, y: height as i32, z: 1 }]
            };
            let region = vk::ImageBlit2::default()
                .src_subresource(source)
                .src_offsets(corners(&from))
                .dst_subresource(target)
                .dst_offsets(corners(&to));
            let regions = [region];
            let info = vk::BlitImageInfo2::default()
                .src_image(from.image().handle())
                .src_image_layout(vk::ImageLayout::TRANSFER_SRC_OPTIMAL)
                .dst_image(to.image().handle())
                .dst_image_layout(vk::ImageLayout::TRANSFER_DST_OPTIMAL)
                .regions(&regions)
                .filter(filter);
            // SAFETY: both levels are in the layouts named, by the barriers above.
            unsafe { frame.device().cmd_blit_image2(frame.context.commands, &info) };
        })
    }

    /// Copies the bits of one level to another of the same size, whose format may give the bits another meaning.
    pub fn copy(&mut self, name: &str, from: ImageSlice, to: ImageSlice) -> Result<()> {
        assert_eq!(from.extent(), to.extent(), "{name}: a copy does not scale");
        assert_eq!(from.slices().len(), to.slices().len(), "{name}: a copy has as many slices as its source");
        self.copy_between(name, from, to, layers(&to))
    }

    /// Copies the bits of a level into layers of another level.
    fn copy_between(
        &mut self,
        name: &str,
        from: ImageSlice,
        to: ImageSlice,
        target: vk::ImageSubresourceLayers,
    ) -> Result<()> {
        self.transfer(name, from, to, |frame| {
            let regions = [vk::ImageCopy2::default()
                .src_subresource(layers(&from))
                .src_offset(offset(&from))
                .dst_subresource(target)
                .dst_offset(offset(&to))
                .extent(extent(&from))];
            let info = vk::CopyImageInfo2::default()
                .src_image(from.image().handle())
                .src_image_layout(vk::ImageLayout::TRANSFER_SRC_OPTIMAL)
                .dst_image(to.image().handle())
                .dst_image_layout(vk::ImageLayout::TRANSFER_DST_OPTIMAL)
                .regions(&regions);
            // SAFETY: both levels are in the layouts named, by the barriers above.
            unsafe { frame.device().cmd_copy_image2(frame.context.commands, &info) };
        })
    }

    /// Copies the bits of one level into one layer of another of the same size: a cube map's face, in Vulkan's order.
    pub fn copy_to_layer(&mut self, name: &str, from: ImageSlice, to: ImageSlice, layer: u32) -> Result<()> {
        assert_eq!(from.extent(), to.extent(), "{name}: a copy does not scale");
        self.copy_between(name, from, to, one_layer(name, &from, &to, layer))
    }

    /// Fills a colour image's levels with one value.
    pub fn clear(&mut self, name: &str, slice: ImageSlice, value: [f32; 4]) -> Result<()> {
        self.pass(name, |frame| {
            frame.use_image(slice, Access::TransferWrite);
            frame.flush();
            let range = slice.image().range(slice.base_level(), slice.states().count() as u32);
            // SAFETY: the levels are in the layout named, by the barrier above.
            unsafe {
                frame.device().cmd_clear_color_image(
                    frame.context.commands,
                    slice.image().handle(),
                    vk::ImageLayout::TRANSFER_DST_OPTIMAL,
                    &vk::ClearColorValue { float32: value },
                    &[range],
                );
            }
            Ok(())
        })
    }

    /// Fills a buffer with one word.
    pub fn fill(&mut self, name: &str, buffer: &Buffer, word: u32) -> Result<()> {
        self.pass(name, |frame| {
            frame.use_buffer(buffer, Access::TransferWrite);
            frame.flush();
            // SAFETY: the buffer is alive; the whole of it is filled.
            unsafe {
                frame.device().cmd_fill_buffer(frame.context.commands, buffer.handle(), 0, vk::WHOLE_SIZE, word);
            }
            Ok(())
        })
    }

    /// Copies tightly packed texels of all layers from a buffer into a level.
    pub fn upload(&mut self, name: &str, from: &Buffer, to: ImageSlice) -> Result<()> {
        self.pass(name, |frame| {
            frame.use_buffer(from, Access::TransferRead);
            frame.use_image(to, Access::TransferWrite);
            frame.flush();
            let region = whole_slice_copy(&to);
            // SAFETY: the level is in the layout named; the caller sized the buffer for it.
            unsafe {
                frame.device().cmd_copy_buffer_to_image(
                    frame.context.commands,
                    from.handle(),
                    to.image().handle(),
                    vk::ImageLayout::TRANSFER_DST_OPTIMAL,
                    &[region],
                );
            }
            Ok(())
        })
    }

    /// Copies a level into a readback buffer, tightly packed, for the host.
    pub fn download(&mut self, name: &str, from: ImageSlice, to: &Buffer) -> Result<()> {
        self.copy_texels(name, from, (to, 0), Access::HostRead)
    }

    /// Copies all layers of a level into a buffer from byte `first` on, tightly packed, for compute shaders to read.
    pub fn copy_to_buffer(&mut self, name: &str, from: ImageSlice, to: &Buffer, first: u64) -> Result<()> {
        self.copy_texels(name, from, (to, first), Access::ComputeStorageRead)
    }

    /// Copies a level into a buffer from byte `first` on, tightly packed, and makes the buffer ready for an access.
    fn copy_texels(&mut self, name: &str, from: ImageSlice, (to, first): (&Buffer, u64), access: Access) -> Result<()> {
        self.pass(name, |frame| {
            frame.use_image(from, Access::TransferRead);
            frame.use_buffer(to, Access::TransferWrite);
            frame.flush();
            // SAFETY: the level is in the layout named; the caller sized the buffer for it.
            unsafe {
                frame.device().cmd_copy_image_to_buffer(
                    frame.context.commands,
                    from.image().handle(),
                    vk::ImageLayout::TRANSFER_SRC_OPTIMAL,
                    to.handle(),
                    &[whole_slice_copy(&from).buffer_offset(first)],
                );
            }
            frame.use_buffer(to, access);
            frame.flush();
            Ok(())
        })
    }

    /// Copies runs of bytes from one buffer into another, which is then ready for the use `access`. A run has its
    /// offset in the source, its offset in the target, and its length.
    pub fn copy_parts(
        &mut self,
        name: &str,
        (from, to): (&Buffer, &Buffer),
        runs: &[[u64; 3]],
        access: Access,
    ) -> Result<()> {
        let fits = |[first, target, size]: &[u64; 3]| first + size <= from.size() && target + size <= to.size();
        assert!(runs.iter().all(fits), "{name}: both buffers hold every run");
        self.pass(name, |frame| {
            frame.use_buffer(from, Access::TransferRead);
            frame.use_buffer(to, Access::TransferWrite);
            frame.flush();
            let region = |[first, target, size]: &[u64; 3]| {
                vk::BufferCopy::default().src_offset(*first).dst_offset(*target).size(*size)
            };
            let regions: Vec<_> = runs.iter().filter(|[.., size]| *size > 0).map(region).collect();
            // SAFETY: both buffers hold the regions, and there is at least one.
            unsafe { frame.device().cmd_copy_buffer(frame.context.commands, from.handle(), to.handle(), &regions) };
            frame.use_buffer(to, access);
            frame.flush();
            Ok(())
        })
    }

    /// Copies one buffer into another, as far as both reach, and makes the second one ready for a use.
    pub fn copy_buffer(&mut self, name: &str, from: &Buffer, to: &Buffer, access: Access) -> Result<()> {
        self.copy_parts(name, (from, to), &[[0, 0, from.size().min(to.size())]], access)
    }
}

/// Returns layer `layer` of `to`, into which the only layer of `from` is copied.
fn one_layer(name: &str, from: &ImageSlice, to: &ImageSlice, layer: u32) -> vk::ImageSubresourceLayers {
    assert_eq!(from.image().layers(), 1, "{name}: the source has one layer");
    layer_of(name, to, layer)
}

/// Returns one layer of a slice's first level.
fn layer_of(name: &str, slice: &ImageSlice, layer: u32) -> vk::ImageSubresourceLayers {
    assert!(layer < slice.image().layers(), "{name}: no layer {layer}");
    layers(slice).base_array_layer(layer).layer_count(1)
}

/// Returns all layers of a slice's first level.
fn layers(slice: &ImageSlice) -> vk::ImageSubresourceLayers {
    vk::ImageSubresourceLayers {
        aspect_mask: slice.image().shown_aspect(),
        mip_level: slice.base_level(),
        base_array_layer: 0,
        layer_count: slice.image().layers(),
    }
}

/// Returns the texel at which a slice begins; z is the number of a volume's slice.
fn offset(slice: &ImageSlice) -> vk::Offset3D {
    vk::Offset3D { x: 0, y: 0, z: slice.slices().start as i32 }
}

fn extent(slice: &ImageSlice) -> vk::Extent3D {
    let [width, height] = slice.extent();
    vk::Extent3D { width, height, depth: slice.slices().len() as u32 }
}

/// Describes a copy between a whole slice and tightly packed texels in a buffer.
fn whole_slice_copy(slice: &ImageSlice) -> vk::BufferImageCopy {
    vk::BufferImageCopy::default()
        .image_subresource(layers(slice))
        .image_offset(offset(slice))
        .image_extent(extent(slice))
}

//! A renderer that takes reflections from `ssct`, with an instance, device, allocator, images and render pass of its
//! own. It draws a reflecting floor and two spheres, records `unified` into its own command buffer, submits once, and
//! writes the composite as a picture. The lines that reflections need stand between "reflections" marks.
//!
//! ```sh
//! cargo run --example embed -- out.png [FOLDER]    # with a folder, every image is also written there as 32-bit floats
//! ```

mod vulkan;

use ash::vk;
use std::error::Error;
use vulkan::{DEPTH, HALF, Picture, Renderer, SIZE};

/// Returns the matrices `view_to_clip` and `world_to_view`, column by column. View space is right-handed, with y up,
/// and the camera looks along −z. Depth is reversed (1 at the near plane). In Vulkan's viewport y points down, so that
/// the projection negates y.
fn camera() -> ([f32; 16], [f32; 16]) {
    let (near, far, aspect) = (0.1_f32, 200.0_f32, SIZE[0] as f32 / SIZE[1] as f32);
    let scale = 1.0 / (0.5 * 55_f32.to_radians()).tan();
    let (a, b) = (near / (far - near), near * far / (far - near));
    let view_to_clip = [scale / aspect, 0., 0., 0., 0., -scale, 0., 0., 0., 0., a, -1., 0., 0., b, 0.];
    // Two metres above the floor, looking down a little.
    let (sin, cos) = 0.18_f32.sin_cos();
    let (eye_y, eye_z) = (2.0_f32, 6.0_f32);
    let (offset_y, offset_z) = (-(cos * eye_y) + sin * eye_z, -(sin * eye_y) - cos * eye_z);
    let world_to_view = [1., 0., 0., 0., 0., cos, sin, 0., 0., -sin, cos, 0., 0., offset_y, offset_z, 1.];
    (view_to_clip, world_to_view)
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let output = arguments.first().map_or("embed.png", String::as_str);
    let mut renderer = Renderer::new()?;
    let mut picture = |format| renderer.picture(format);
    let images = [picture(HALF)?, picture(HALF)?, picture(HALF)?];
    let depth = picture(DEPTH)?;
    let pass = renderer.pass(&images, &depth)?;
    let [normal, material, color] = &images;
    let (view_to_clip, world_to_view) = camera();

    // ---- reflections ----
    // SAFETY: the handles belong together and outlive the context; the features are those that the device was made with.
    let context = unsafe { ssct::Context::new(renderer.handles()) }?;
    let info = ssct::ReflectionsInfo { extent: SIZE, method: "unified", reflection: false, ..Default::default() };
    let mut reflections = ssct::Reflections::new(&context, &info)?;
    // ---------------------
    let commands = renderer.begin()?;
    renderer.draw(commands, &pass, &view_to_clip, &world_to_view);

    // ---- reflections ----
    // The render pass leaves its images in the layout to sample them, and after the reflections they are copied.
    let sampled = ssct::ImageUse::FRAGMENT_SAMPLED;
    let drawn = ssct::ImageUse { stages: vk::PipelineStageFlags2::ALL_COMMANDS, ..sampled };
    let copied = ssct::ImageUse::TRANSFER_SOURCE;
    let image_input = |p: &Picture| ssct::ImageInput::color(p.image, p.view, HALF, SIZE).used(drawn, copied);
    let input = ssct::FrameInput {
        slot: 0,
        camera: ssct::CameraInput { world_to_view, view_to_clip, clip_y: ssct::ClipY::Down },
        depth: ssct::ImageInput::depth(depth.image, depth.view, DEPTH, SIZE).used(drawn, copied),
        normal: ssct::NormalInput {
            image: image_input(normal),
            space: ssct::NormalSpace::View,
            encoding: ssct::NormalEncoding::Float,
        },
        reflectivity: ssct::FactorInput::Channel(image_input(material), 0),
        roughness: ssct::FactorInput::Channel(image_input(material), 1),
        reflectors: ssct::Reflectors::UNKNOWN,
        color: image_input(color),
        sky: None,
        captures: None,
        triangles: None,
        triangle_numbers: None,
        motion: None,
        timed: false,
        outputs: copied,
    };
    // SAFETY: the command buffer is recording outside the render pass, and is submitted below.
    let recorded = unsafe { reflections.record(commands, &input) }?;
    // ---------------------

    let composite = recorded.composite.ok_or("the composite is on by default")?.image;
    let images_to_read = [
        ("composite", composite, HALF),
        ("normal", normal.image, HALF),
        ("material", material.image, HALF),
        ("color", color.image, HALF),
        ("depth", depth.image, DEPTH),
    ];
    let values_of_images = renderer.submit_and_read(commands, &images_to_read)?;
    vulkan::write_png(output, &values_of_images[0])?;
    if let Some(folder) = arguments.get(1) {
        std::fs::create_dir_all(folder)?;
        for ((name, ..), values) in images_to_read.iter().zip(&values_of_images) {
            let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
            std::fs::write(format!("{folder}/{name}.f32"), bytes)?;
        }
        let numbers: Vec<u8> = view_to_clip.iter().chain(&world_to_view).flat_map(|v| v.to_le_bytes()).collect();
        std::fs::write(format!("{folder}/camera.f32"), numbers)?;
    }
    println!("{output}: {}", recorded.passes.join(", "));

    // ---- reflections ----
    drop((reflections, context)); // before the device
    // ---------------------
    renderer.destroy(images.into_iter().chain([depth]), pass);
    Ok(())
}

//! A renderer on wgpu that takes reflections from `ssct`. It draws the scene of `examples/embed` in a render pass of
//! WGSL, records `unified` into a command buffer of wgpu, and draws the composite to a screen image in another pass,
//! for three frames. The lines that reflections need stand between "reflections" marks here and in `renderer.rs`. All
//! of `lib.rs` is for reflections too; another renderer on wgpu can use that file unchanged.
//!
//! ```sh
//! cargo run -- out.png [FOLDER]    # with a folder, every image is also written there as 32-bit floats
//! ```

mod renderer;

use embed_wgpu::{HALF, NO_VULKAN, Result};
use renderer::{DEPTH, Renderer};
use wgpu::hal::api::Vulkan;

const SIZE: [u32; 2] = [640, 360];
const FRAMES: usize = 3;
const FRAMES_IN_FLIGHT: usize = 2;

/// Returns the matrices `view_to_clip` and `world_to_view`, column by column. View space is right-handed, with y up,
/// and the camera looks along −z. Depth is reversed (1 at the near plane). Clip space has y up, which is the convention
/// of wgpu.
fn camera() -> ([f32; 16], [f32; 16]) {
    let (near, far, aspect) = (0.1_f32, 200.0_f32, SIZE[0] as f32 / SIZE[1] as f32);
    let scale = 1.0 / (0.5 * 55_f32.to_radians()).tan();
    let (a, b) = (near / (far - near), near * far / (far - near));
    let view_to_clip = [scale / aspect, 0., 0., 0., 0., scale, 0., 0., 0., 0., a, -1., 0., 0., b, 0.];
    // Two metres above the floor, looking down a little.
    let (sin, cos) = 0.18_f32.sin_cos();
    let (eye_y, eye_z) = (2.0_f32, 6.0_f32);
    let (offset_y, offset_z) = (-(cos * eye_y) + sin * eye_z, -(sin * eye_y) - cos * eye_z);
    let world_to_view = [1., 0., 0., 0., 0., cos, sin, 0., 0., -sin, cos, 0., 0., offset_y, offset_z, 1.];
    (view_to_clip, world_to_view)
}

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let output = arguments.first().map_or("wgpu.png", String::as_str);
    let (view_to_clip, world_to_view) = camera();
    let renderer = Renderer::new(&view_to_clip, &world_to_view)?;
    let picture = |name, format| renderer.picture(name, SIZE, format);
    let [normal, material, color] = ["normal", "material", "color"].map(|name| picture(name, HALF));
    let depth = picture("depth", DEPTH);
    let screen = picture("screen", wgpu::TextureFormat::Rgba8UnormSrgb);

    // ---- reflections ----
    // SAFETY: the handles belong together and outlive the context; the features are those that the device was made with.
    let context = unsafe {
        ssct::Context::new(embed_wgpu::handles(&renderer.adapter, &renderer.device, wgpu::Features::empty())?)
    }?;
    let defaults = ssct::ReflectionsInfo::default(); // `unified`, with two frames in flight
    let info = ssct::ReflectionsInfo { extent: SIZE, frames_in_flight: FRAMES_IN_FLIGHT, ..defaults };
    let mut reflections = ssct::Reflections::new(&context, &info)?;
    let mut composite = None;
    let mut passes = Vec::new();
    // ---------------------

    let mut submissions = Vec::new();
    for frame in 0..FRAMES {
        if frame >= FRAMES_IN_FLIGHT {
            renderer.wait(Some(&submissions[frame - FRAMES_IN_FLIGHT]))?;
        }
        let drawn = renderer.draw([&normal, &material, &color], &depth);

        // ---- reflections ----
        let material = renderer.input(&material)?;
        let input = ssct::FrameInput {
            slot: frame % FRAMES_IN_FLIGHT,
            camera: ssct::CameraInput { world_to_view, view_to_clip, clip_y: ssct::ClipY::Up },
            depth: renderer.input(&depth)?,
            normal: ssct::NormalInput {
                image: renderer.input(&normal)?,
                space: ssct::NormalSpace::View,
                encoding: ssct::NormalEncoding::Float,
            },
            reflectivity: ssct::FactorInput::Channel(material, 0),
            roughness: ssct::FactorInput::Channel(material, 1),
            reflectors: ssct::Reflectors::UNKNOWN,
            color: renderer.input(&color)?,
            sky: None,
            captures: None,
            triangles: None,
            triangle_numbers: None,
            motion: None,
            timed: false,
            outputs: embed_wgpu::resource(HALF),
        };
        // wgpu refuses an encoder that has both its own commands and raw ones, so that the raw ones get another
        // encoder. wgpu does not see which textures the raw commands read; `draw` has brought all into the state
        // `RESOURCE`.
        let mut encoder = renderer.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        // SAFETY: the command buffer is recording outside rendering. It is submitted below, after the commands that
        // draw its inputs and before those of the next frame. The last frame with this slot has been waited for.
        let recorded = unsafe {
            encoder.as_hal_mut::<Vulkan, _, _>(|encoder| -> Result<_> {
                Ok(reflections.record(encoder.ok_or(NO_VULKAN)?.raw_handle(), &input)?)
            })
        }?;
        let reflected = encoder.finish();
        // The image is the same in every frame, and `record` leaves it in the state in which wgpu takes it over.
        if composite.is_none() {
            let made = recorded.composite.ok_or("the composite is on by default")?;
            composite = Some(renderer.adopt(&made)?);
        }
        let composite = composite.as_ref().ok_or("made above")?;
        passes = recorded.passes;
        // ---------------------

        let shown = renderer.show(composite, &screen);
        submissions.push(renderer.queue.submit([drawn, reflected, shown]));
    }

    let composite = composite.ok_or("no frame was drawn")?;
    // The screen is last, since it becomes the picture and is not written to the folder.
    let pictures = [
        ("composite", &composite),
        ("normal", &normal),
        ("material", &material),
        ("color", &color),
        ("depth", &depth),
        ("screen", &screen),
    ];
    let mut bytes_of_pictures = renderer.read(pictures.iter().map(|(_, picture)| *picture))?;
    let screen_bytes = bytes_of_pictures.pop().ok_or("nothing was read")?;
    image::RgbaImage::from_raw(SIZE[0], SIZE[1], screen_bytes).ok_or("a picture of another size")?.save(output)?;
    if let Some(folder) = arguments.get(1) {
        std::fs::create_dir_all(folder)?;
        for ((name, picture), bytes) in pictures.iter().zip(&bytes_of_pictures) {
            std::fs::write(format!("{folder}/{name}.f32"), embed_wgpu::floats(bytes, picture.texture.format()))?;
        }
        let numbers: Vec<u8> = view_to_clip.iter().chain(&world_to_view).flat_map(|v| v.to_le_bytes()).collect();
        std::fs::write(format!("{folder}/camera.f32"), numbers)?;
    }
    println!("{}", renderer.adapter.get_info().name);
    println!("{output}: {}", passes.join(", "));

    // ---- reflections ----
    drop(composite); // before `reflections`, which own the image
    renderer.wait(None)?;
    drop((reflections, context)); // before the device
    // ---------------------
    Ok(())
}

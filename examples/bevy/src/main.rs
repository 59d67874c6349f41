//! Draws a hall with a mirror for a floor, by Bevy and without a window, with reflections by `ssct` or by Bevy itself,
//! and compares it with the truth.
//!
//! ```sh
//! cargo run -- out.png [OPTION…]
//! #   --with ssct|guess|screen|traced|history|off|bevy|bevy-steps|nothing   who reflects: guess takes no colour from the
//! #                                                        screen; off is the plugin without the component
//! #   --roughness 0.2                                      perceptual roughness of the floor; the figures are of mirrors
//! #   --size 640x360, --frames 12                          the picture, and frames before it is taken
//! #   --moved                                              the ball moves before the last frames
//! #   --images FOLDER                                      inputs and outputs of the last frame, as 32-bit floats
//! #   --truth FILE.png                                     the truth
//! #   --lit                                                a lamp shines on the surfaces
//! #   --mirrored                                           the hall mirrored at the floor: the truth for lit surfaces
//! #   --mirror FILE.png                                    a picture of the mirrored hall, as the truth for the figures
//! #   --sky even|colorful|none                             the environment map, and so the light from each direction
//! ```
//!
//! It prints a line of figures: the error of the mirror's pixels against the truth, the share of them that show the
//! right place, and how long the reflections took.

mod hall;

use bevy::asset::RenderAssetUsages;
use bevy::camera::{CameraProjection, Hdr, RenderTarget};
use bevy::core_pipeline::tonemapping::{DebandDither, Tonemapping};
use bevy::diagnostic::{DiagnosticPath, DiagnosticsStore};
use bevy::pbr::{DefaultOpaqueRendererMethod, ScreenSpaceReflections};
use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::render::diagnostic::RenderDiagnosticsPlugin;
use bevy::render::gpu_readback::{Readback, ReadbackComplete};
use bevy::render::render_resource::{TextureFormat, TextureUsages};
use bevy::render::renderer::{RenderAdapterInfo, RenderDevice};
use bevy::window::ExitCondition;
use embed_bevy::truth::{self, Seen};
use embed_bevy::{KeepImages, Result, SsctPlugin, SsctReflections};
use std::path::PathBuf;

/// The options of the command line, which the head of this file lists.
struct Options {
    output: PathBuf,
    with: String,
    size: [u32; 2],
    frames: usize,
    has_moved: bool,
    images: Option<PathBuf>,
    truth: Option<PathBuf>,
    /// `None` means that there is no environment map.
    sky: Option<hall::Sky>,
    hall: hall::Hall,
    mirror: Option<PathBuf>,
}

/// The bytes of the last picture that was read back, which are RGBA of 16-bit floats.
#[derive(Resource, Default)]
struct Shown(Vec<u8>);

fn main() -> Result<()> {
    let options = options()?;
    let mut app = app(&options)?;
    let camera = set_up(&mut app, &options)?;
    let [median_ms, least_ms] = run(&mut app, camera, &options)?;
    let [width, height] = options.size;
    let mut shown = colors(&app.world().resource::<Shown>().0);
    if options.hall.is_mirrored {
        shown = shown.chunks_exact(width as usize).rev().flatten().copied().collect();
    }
    write(&options.output, options.size, &shown)?;

    let world_from_view = hall::camera().to_matrix();
    let aspect = width as f32 / height as f32;
    let projection = PerspectiveProjection { aspect_ratio: aspect, ..default() };
    let clip_from_view = projection.get_clip_from_view();
    let sky = options.sky.unwrap_or(hall::Sky::Even);
    let size = [width as usize, height as usize];
    let triangles = hall::triangles(options.has_moved);
    let mut truth = truth::picture(&triangles, |direction| sky.color(direction), size, clip_from_view, world_from_view);
    if let Some(file) = &options.mirror {
        for ((color, _), mirrored) in truth.iter_mut().zip(read(file)?) {
            *color = mirrored;
        }
    }
    if let Some(file) = &options.truth {
        write(file, options.size, &truth.iter().map(|(color, _)| *color).collect::<Vec<_>>())?;
    }
    let figures = Figures::compare(&shown, &truth);
    let device = &app.world().resource::<RenderAdapterInfo>().name;
    println!(
        "{{\"device\": {device:?}, \"with\": {:?}, \"size\": [{width}, {height}], \"mirrors\": {}, \"rmse\": {:.5}, \
         \"right\": {:.5}, \"sky_rmse\": {:.5}, \"others_rmse\": {:.5}, \"median_ms\": {:.3}, \"least_ms\": {:.3}}}",
        options.with,
        figures.mirrors,
        figures.rmse,
        figures.right,
        figures.sky_rmse,
        figures.others_rmse,
        median_ms,
        least_ms
    );
    Ok(())
}

/// Reads the options from the arguments of the program.
fn options() -> Result<Options> {
    let mut options = Options {
        output: "bevy.png".into(),
        with: "ssct".into(),
        size: [640, 360],
        frames: 12,
        has_moved: false,
        images: None,
        truth: None,
        sky: Some(hall::Sky::Even),
        hall: hall::Hall { roughness: 0.0, is_lit: false, is_mirrored: false },
        mirror: None,
    };
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or_else(|| format!("{argument} needs a value"));
        match argument.as_str() {
            "--with" => options.with = value()?,
            "--size" => options.size = size(&value()?)?,
            "--frames" => options.frames = value()?.parse()?,
            "--images" => options.images = Some(value()?.into()),
            "--truth" => options.truth = Some(value()?.into()),
            "--roughness" => options.hall.roughness = value()?.parse()?,
            "--lit" => options.hall.is_lit = true,
            "--mirrored" => options.hall.is_mirrored = true,
            "--mirror" => options.mirror = Some(value()?.into()),
            "--moved" => options.has_moved = true,
            "--sky" => options.sky = sky(&value()?)?,
            name if name.starts_with("--") => return Err(format!("there is no option {name}").into()),
            file => options.output = file.into(),
        }
    }
    Ok(options)
}

/// Reads the value of `--sky`; `None` means that there is no environment map.
fn sky(name: &str) -> Result<Option<hall::Sky>> {
    match name {
        "even" => Ok(Some(hall::Sky::Even)),
        "colorful" => Ok(Some(hall::Sky::Colorful)),
        "none" => Ok(None),
        other => Err(format!("there is no sky {other}").into()),
    }
}

/// Reads a width and a height, such as 640x360.
fn size(text: &str) -> Result<[u32; 2]> {
    let (width, height) = text.split_once('x').ok_or("--size takes a width and a height, as 640x360")?;
    Ok([width.parse()?, height.parse()?])
}

/// Makes the app without a window, with the plugin if `--with` needs it.
fn app(options: &Options) -> Result<App> {
    let mut app = App::new();
    let render = RenderPlugin {
        render_creation: embed_bevy::render_creation()?,
        synchronous_pipeline_compilation: true,
        ..default()
    };
    let window = WindowPlugin { primary_window: None, exit_condition: ExitCondition::DontExit, ..default() };
    app.add_plugins((DefaultPlugins.set(window).set(render), RenderDiagnosticsPlugin));
    if matches!(options.with.as_str(), "ssct" | "guess" | "screen" | "traced" | "history" | "off") {
        app.add_plugins(SsctPlugin);
    }
    app.insert_resource(DefaultOpaqueRendererMethod::deferred());
    app.insert_resource(GlobalAmbientLight::NONE);
    app.insert_resource(options.hall);
    app.init_resource::<Shown>();
    app.add_systems(Startup, hall::spawn);
    Ok(app)
}

/// Spawns the camera and the image that it draws to, which is read back after every frame. Returns the camera.
fn set_up(app: &mut App, options: &Options) -> Result<Entity> {
    let world = app.world_mut();
    let [width, height] = options.size;
    let mut images = world.resource_mut::<Assets<Image>>();
    let mut target = Image::new_target_texture(width, height, TextureFormat::Rgba16Float, None);
    target.asset_usage = RenderAssetUsages::RENDER_WORLD;
    target.texture_descriptor.usage |= TextureUsages::COPY_SRC;
    let target = images.add(target);
    let sky = options.sky.map(|sky| sky.map(&mut images));
    let camera = (
        Camera3d::default(),
        Camera { clear_color: Color::from(hall::SKY).into(), ..default() },
        RenderTarget::Image(target.clone().into()),
        (Tonemapping::None, DebandDither::Disabled, Hdr, Msaa::Off),
        if options.hall.is_mirrored { hall::mirrored_camera() } else { hall::camera() },
    );
    let camera = world.spawn(camera).id();
    let bevy_reflections = ScreenSpaceReflections { min_perceptual_roughness: 0.0..0.0, ..default() };
    let ssct_reflections = SsctReflections::default();
    let mut entity = world.entity_mut(camera);
    if let Some(sky) = sky {
        entity.insert(sky);
    }
    match options.with.as_str() {
        "ssct" => entity.insert(ssct_reflections),
        "guess" => entity
            .insert(SsctReflections { parameters: vec![("hit-color".into(), "triangles".into())], ..ssct_reflections }),
        // Bevy's reflections do not fade out at the borders of the screen either.
        "screen" => entity.insert(SsctReflections {
            world: false,
            parameters: vec![("fade".into(), "off".into())],
            ..ssct_reflections
        }),
        "traced" => entity.insert(SsctReflections { method: "traced".into(), ..ssct_reflections }),
        "history" => entity.insert(SsctReflections { history: true, ..ssct_reflections }),
        // The app has the plugin, but the camera lacks the component.
        "off" => &mut entity,
        "bevy" => entity.insert(bevy_reflections),
        "bevy-steps" => {
            entity.insert(ScreenSpaceReflections { linear_steps: 100, bisection_steps: 8, ..bevy_reflections })
        }
        "nothing" => {
            entity.insert((bevy::core_pipeline::prepass::DepthPrepass, bevy::core_pipeline::prepass::DeferredPrepass))
        }
        other => return Err(format!("nobody called {other} reflects").into()),
    };
    world.spawn(Readback::texture(target)).observe(|read: On<ReadbackComplete>, mut shown: ResMut<Shown>| {
        shown.0.clone_from(&read.data);
    });
    Ok(camera)
}

/// Draws the frames, and returns the median and the least time of the reflections on the GPU, in milliseconds.
fn run(app: &mut App, camera: Entity, options: &Options) -> Result<[f64; 2]> {
    app.finish();
    app.cleanup();
    // The ball moves after half of the frames.
    let half = options.frames / 2;
    for frame in 0..options.frames + 2 {
        if frame == half && options.has_moved {
            let mut balls = app.world_mut().query_filtered::<&mut Transform, With<hall::Moving>>();
            for mut ball in balls.iter_mut(app.world_mut()) {
                ball.translation = hall::ball(true);
            }
        }
        if let Some(folder) = options.images.as_ref().filter(|_| frame == options.frames) {
            app.world_mut().entity_mut(camera).insert(KeepImages(folder.clone()));
        }
        app.update();
        app.world().resource::<RenderDevice>().wgpu_device().poll(wgpu::PollType::wait_indefinitely())?;
    }
    let name = if options.with.starts_with("bevy") { "ssr" } else { "ssct" };
    let path = DiagnosticPath::new(format!("render/{name}/elapsed_gpu"));
    let diagnostics = app.world().resource::<DiagnosticsStore>();
    // The first three times do not count.
    let mut times: Vec<f64> = diagnostics.get(&path).map_or_else(Vec::new, |d| d.values().skip(3).copied().collect());
    times.sort_by(f64::total_cmp);
    Ok([times.len() / 2, 0].map(|index| times.get(index).copied().unwrap_or_default()))
}

/// Returns the linear colours of RGBA texels of 16-bit floats.
fn colors(halves: &[u8]) -> Vec<Vec3> {
    let channel =
        |bytes: &[u8], index: usize| half::f16::from_ne_bytes([bytes[2 * index], bytes[2 * index + 1]]).to_f32();
    halves.chunks_exact(8).map(|texel| Vec3::new(channel(texel, 0), channel(texel, 1), channel(texel, 2))).collect()
}

/// Writes linear colours as an sRGB picture.
fn write(file: &PathBuf, [width, height]: [u32; 2], colors: &[Vec3]) -> Result<()> {
    let byte = |color: &Vec3| {
        let [r, g, b] = Srgba::from(LinearRgba::rgb(color.x, color.y, color.z)).to_u8_array_no_alpha();
        [r, g, b]
    };
    let bytes = colors.iter().flat_map(byte).collect();
    let picture = image::RgbImage::from_raw(width, height, bytes).ok_or("the picture did not come back")?;
    Ok(picture.save(file)?)
}

/// Reads the linear colours of an sRGB picture.
fn read(file: &PathBuf) -> Result<Vec<Vec3>> {
    let picture = image::open(file)?.to_rgb8();
    let linear = |pixel: &image::Rgb<u8>| {
        let [r, g, b] = pixel.0;
        let color = LinearRgba::from(Srgba::rgb_u8(r, g, b));
        Vec3::new(color.red, color.green, color.blue)
    };
    Ok(picture.pixels().map(linear).collect())
}

/// How a picture differs from the truth.
struct Figures {
    /// Number of pixels that see the mirror.
    mirrors: usize,
    /// Root mean squared error of the mirror's pixels, in linear colour.
    rmse: f64,
    /// Share of the mirror's pixels whose colour differs from the truth by less than 0.04 in each channel.
    right: f64,
    /// Root mean squared error of the mirror's pixels that show the sky.
    sky_rmse: f64,
    /// Root mean squared error of the pixels that do not see the mirror. It says how well the truth fits Bevy's
    /// picture.
    others_rmse: f64,
}

impl Figures {
    /// Compares the colours of a picture with the truth, pixel by pixel.
    fn compare(shown: &[Vec3], truth: &[(Vec3, Seen)]) -> Self {
        let errors = |condition: fn(Seen) -> bool| -> Vec<Vec3> {
            let pixels = shown.iter().zip(truth).filter(|(_, (_, seen))| condition(*seen));
            pixels.map(|(shown, (truth, _))| (*shown - *truth).abs()).collect()
        };
        let rmse = |errors: &[Vec3]| {
            let sum: f64 = errors.iter().map(|error| f64::from(error.length_squared())).sum();
            (sum / (3 * errors.len().max(1)) as f64).sqrt()
        };
        let mirrors = errors(|seen| seen != Seen::Directly);
        let right = mirrors.iter().filter(|error| error.max_element() < 0.04).count();
        Self {
            mirrors: mirrors.len(),
            rmse: rmse(&mirrors),
            right: right as f64 / mirrors.len().max(1) as f64,
            sky_rmse: rmse(&errors(|seen| seen == Seen::MirroredSky)),
            others_rmse: rmse(&errors(|seen| seen == Seen::Directly)),
        }
    }
}

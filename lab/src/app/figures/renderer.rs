//! Renders the pictures of figures from the arguments of `ssct render`, so that a page can print the command that makes
//! each picture. The scene stays on the device between pictures.

use crate::app::cli::RenderOptions;
use crate::app::{reference, render, resolve};
use crate::error::{Error, Result};
use crate::report::figures;
use crate::report::images::{Rgb, display};
use crate::stage::{Intermediates, RenderedImage, Shot, Stage, image};
use clap::Parser;
use ssct::gpu::Gpu;
use ssct::methods::{self, METHODS, Wants};
use ssct_scenes::{Camera, Scene, library};
use std::path::Path;

/// Renders pictures on a device, and keeps the scene that was used last.
pub struct FigureRenderer<'a> {
    gpu: &'a Gpu,
    loaded: Option<LoadedScene>,
}

/// A scene that is loaded, and that is on the device.
struct LoadedScene {
    /// The scene's name or file, as the options give it.
    source: String,
    scene: Scene,
    stage: Stage,
}

/// The command line of one `ssct render`.
#[derive(Parser)]
struct Render {
    #[command(flatten)]
    options: RenderOptions,
}

/// Parses the options of an `ssct render`, such as `--scene rooms --view corridor`. They name no file to write; the
/// command demands one, so a name is added that nothing uses.
pub fn parse(arguments: &str) -> Result<RenderOptions> {
    let words = ["render"].into_iter().chain(words(arguments)).chain(["-o", "figure.png"]);
    Render::try_parse_from(words).map(|render| render.options).map_err(|e| {
        let text = e.to_string();
        let line = text.lines().next().unwrap_or_default();
        Error::usage(line.trim_start_matches("error: ").to_owned())
    })
}

/// The words of a command; text between quotation marks is one word.
fn words(arguments: &str) -> impl Iterator<Item = &str> {
    // Parts with an odd index stood between quotation marks.
    let parts = arguments.split('"').enumerate();
    parts.flat_map(|(n, part)| if n % 2 == 1 { vec![part] } else { part.split_whitespace().collect() })
}

/// Returns the reason why this program cannot render with the given arguments, if it lacks an option, a method or a
/// scene that they name.
pub fn find_lack(arguments: &str) -> Option<String> {
    let options = match parse(arguments) {
        Ok(options) => options,
        Err(e) => return Some(e.to_string()),
    };
    let method = render::method_name(&options);
    if method != "reference" && METHODS.iter().all(|m| m.name != method) {
        return Some(format!("there is no method {method}"));
    }
    let scene = scene_name(&options);
    let is_there = library::every_name().any(|name| name == scene) || Path::new(&scene).is_file();
    (!is_there).then(|| format!("there is no built-in scene {scene}"))
}

/// The name or the first file of the scene that the options ask for; `rooms` by default.
fn scene_name(options: &RenderOptions) -> String {
    options.common.place.scene.first().map_or_else(|| "rooms".into(), |p| p.to_string_lossy().into_owned())
}

impl<'a> FigureRenderer<'a> {
    /// Makes a renderer without a loaded scene.
    pub fn new(gpu: &'a Gpu) -> Self {
        Self { gpu, loaded: None }
    }

    /// Puts a scene that was loaded from the file `source` on the device, so that renders of this file need not load
    /// it.
    pub fn hold(&mut self, source: &str, scene: Scene) -> Result<()> {
        self.loaded = Some(LoadedScene { source: source.to_owned(), stage: Stage::new(self.gpu, &scene)?, scene });
        Ok(())
    }

    /// Renders the picture that `ssct render` would make with the given arguments.
    pub fn render_picture(&mut self, arguments: &str) -> Result<Rgb> {
        let options = parse(arguments)?;
        if render::method_name(&options) == "reference" {
            let scene = &self.load(&options)?.scene;
            return Ok(display(&reference::sample_image(&options, scene)?));
        }
        let (rendered, camera) = self.render(&options, options.figure.is_some())?;
        Ok(match (options.figure, &rendered.intermediates) {
            (Some(figure), Some(images)) => figures::draw(figure, images, &camera.lens)?,
            _ if options.reflection_only => display(&rendered.reflection),
            _ => display(&rendered.composite),
        })
    }

    /// Renders as `ssct render` would with the given arguments; returns all intermediate images, and the camera.
    pub fn render_intermediates(&mut self, arguments: &str) -> Result<(Intermediates, Camera)> {
        let (rendered, camera) = self.render(&parse(arguments)?, true)?;
        Ok((rendered.intermediates.unwrap_or_default(), camera))
    }

    /// Returns the scene that the options name, and loads it unless it was used last.
    fn load(&mut self, options: &RenderOptions) -> Result<&mut LoadedScene> {
        let source = scene_name(options);
        let loaded = match self.loaded.take() {
            Some(loaded) if loaded.source == source => loaded,
            _ => {
                let scene = resolve::scene(&options.common.place, "rooms")?;
                LoadedScene { source, stage: Stage::new(self.gpu, &scene)?, scene }
            }
        };
        Ok(self.loaded.insert(loaded))
    }

    /// Renders as the options say. Returns the image and its camera; if `keeps_intermediates` is true, with all intermediate
    /// images.
    fn render(&mut self, options: &RenderOptions, keeps_intermediates: bool) -> Result<(RenderedImage, Camera)> {
        let common = &options.common;
        let method = methods::find(render::method_name(options))?;
        let globals = resolve::one_globals(&common.place, "a figure has one roughness")?;
        let LoadedScene { scene, stage, .. } = self.load(options)?;
        let view = resolve::view(scene, &common.place, None)?;
        let setup = render::setup(options);
        let wants = if keeps_intermediates { Wants::HITS } else { Wants::REFLECTION };
        let camera = view.camera(scene, options.size);
        let shot = Shot::new(stage, method, &setup, wants, camera, globals.materials(scene, &view))?;
        Ok((image::render(stage, &shot, keeps_intermediates)?, camera))
    }
}

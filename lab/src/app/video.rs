//! `ssct video`: films of methods beside the film of the world reference.

use super::cli::{CommonOptions, DeviceOptions, parse_point, parse_size};
use super::measure::StudyOptions;
use super::resolve;
use super::variants::VariantOptions;
use crate::error::{Error, Result};
use crate::study::video::{CameraWay, VideoStudy};
use clap::Args;
use glam::Vec3;
use ssct_scenes::Scene;
use std::path::PathBuf;

/// Options of `ssct video`.
#[derive(Debug, Args)]
pub struct VideoOptions {
    #[command(flatten)]
    pub common: CommonOptions,
    #[command(flatten)]
    pub variants: VariantOptions,
    /// Widths and heights in pixels; by default 320x180
    #[arg(long, value_name = "WxH", value_parser = parse_size, value_delimiter = ',')]
    pub size: Vec<[u32; 2]>,
    /// Way of the camera, such as turn
    ///
    /// - walk: from the view towards what it looks at
    /// - turn: at rest, turned quickly, and at rest again
    /// - stop: aside for a third of the film, and at rest
    /// - rest: the camera stays where the view is
    /// - views: through the views of the scene
    /// - the name of a path of the scene file, or a path file (.toml)
    #[arg(long, value_name = "NAME|FILE", default_value = "walk", verbatim_doc_comment)]
    pub way: PathBuf,
    /// Frames of the film
    #[arg(long, value_name = "N", default_value_t = 60, value_parser = clap::value_parser!(u32).range(2..=100_000))]
    pub frames: u32,
    /// Frames that are shown in a second.
    #[arg(long, value_name = "N", default_value_t = 30.0)]
    pub fps: f32,
    /// Motion of the scene that is played, by name
    ///
    /// It begins with the film, and what has come to its end rests there.
    #[arg(long, value_name = "NAME", conflicts_with_all = ["moving", "time"])]
    pub play: Option<String>,
    /// Meshes that move, by name; with --step
    #[arg(long, value_name = "MESH", value_delimiter = ',', requires = "step")]
    pub moving: Vec<String>,
    /// How far they move from frame to frame, in metres
    ///
    /// The three numbers are along the axes of the world.
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true, requires = "moving")]
    pub step: Option<Vec3>,
    /// Frames after which they rest; by default they never do
    #[arg(long, value_name = "N", requires = "moving")]
    pub step_frames: Option<u32>,
    /// Meshes that the camera carries along, by name, as a hand does that is held before it
    #[arg(long, value_name = "MESH", value_delimiter = ',')]
    pub held: Vec<String>,
    /// Shifts each frame by another part of a pixel
    ///
    /// Renderers do so that average frames into a smooth picture. The world's film is shifted alike.
    #[arg(long)]
    pub jitter: bool,
    /// Rays a pixel of the world reference
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(2..=1_048_576))]
    pub rays: u32,
}

impl StudyOptions for VideoOptions {
    type Study = VideoStudy;

    fn device(&self) -> &DeviceOptions {
        &self.common.device
    }

    /// Makes the study. Meshes that the camera carries along must not move by themselves, too.
    fn study(&self) -> Result<VideoStudy> {
        if !(self.fps.is_finite() && (1.0..=1000.0).contains(&self.fps)) {
            return Err(Error::usage(format!("--fps {}: must lie between 1 and 1000", self.fps)));
        }
        let place = &self.common.place;
        let mut scene = resolve::scene(place, "rooms")?;
        scene.lens = resolve::lens(place, scene.lens)?;
        let way = camera_way(self, &scene)?;
        let globals = resolve::globals(place)?;
        let sizes = resolve::distinct_values_or(&self.size, [320, 180]);
        let base = self.common.method_options.setup(sizes[0]);
        let lenses = match &way {
            CameraWay::Path(_) => vec![scene.lens],
            CameraWay::Walk(view) | CameraWay::Turn(view) | CameraWay::Stop(view) | CameraWay::Rest(view) => {
                resolve::lenses(&scene, [view])
            }
        };
        let variants = resolve::variants(&self.variants, &base, (&[&scene], &lenses), false)?;
        resolve::check_meshes(&scene, "--moving", &self.moving)?;
        resolve::check_meshes(&scene, "--held", &self.held)?;
        let played_motion = |name: &str| resolve::motion(&scene, Some(name), "--play").cloned();
        let play = self.play.as_deref().map(played_motion).transpose()?;
        let played_meshes: Vec<&str> =
            play.iter().flat_map(|motion| motion.placements_at(0.0)).map(|(mesh, _)| mesh).collect();
        let moves = |name: &String| self.moving.contains(name) || played_meshes.contains(&name.as_str());
        if let Some(name) = self.held.iter().find(|name| moves(name)) {
            return Err(Error::usage(format!("--held {name}: it moves by itself, by --moving or --play")));
        }
        Ok(VideoStudy {
            play,
            scene,
            way,
            sizes,
            globals,
            variants,
            frames: self.frames,
            frames_per_second: self.fps,
            rays: self.rays,
            moving: resolve::distinct_values(&self.moving),
            step_m: self.step.unwrap_or(Vec3::ZERO),
            step_frames: self.step_frames,
            held: resolve::distinct_values(&self.held),
            jitter: self.jitter,
        })
    }
}

/// Returns the camera's way that `--way` names. The ways `walk`, `turn`, `stop` and `rest` begin at the view that the
/// flags choose. Any other name is that of a path, beside which flags that choose a view are an error.
fn camera_way(options: &VideoOptions, scene: &Scene) -> Result<CameraWay> {
    let place = &options.common.place;
    let name = options.way.as_path();
    let way_from_view: fn(_) -> CameraWay = match name.to_string_lossy().as_ref() {
        "walk" => CameraWay::Walk,
        "turn" => CameraWay::Turn,
        "stop" => CameraWay::Stop,
        "rest" => CameraWay::Rest,
        _ => {
            let path = resolve::path(scene, name, "--way")?;
            if place.view.is_some() || place.eye.is_some() {
                let message = "--way: a path says where the camera is; leave out --view and --eye";
                return Err(Error::usage(message.into()));
            }
            return Ok(CameraWay::Path(path));
        }
    };
    resolve::view(scene, place, None).map(way_from_view)
}

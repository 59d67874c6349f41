//! The flags that several commands share, and those of most commands, each declared once. What they mean together is decided in `resolve`.

use super::parameters::{BesideGBufferOptions, MethodOptions, choice};
use crate::report::figures::Figure;
use crate::scene::texture::MAX_EXTENT;
use crate::study::shard::Shard;
use clap::{Args, Subcommand, ValueEnum};
use glam::Vec3;
use std::path::PathBuf;

/// Options of `ssct devices`.
#[derive(Debug, Args)]
pub struct DevicesOptions {
    /// Print the list as JSON.
    #[arg(long)]
    pub json: bool,
}

/// Options that mean the same everywhere.
#[derive(Debug, Args)]
pub struct CommonOptions {
    #[command(flatten)]
    pub place: SceneOptions,
    #[command(flatten)]
    pub method_options: MethodOptions,
    #[command(flatten)]
    pub device: DeviceOptions,
}

/// What is looked at, from where, and with which materials.
#[derive(Debug, Clone, Args)]
pub struct SceneOptions {
    /// A built-in scene (rooms, atrium, street, museum, cathedral, corridor), a .scene.toml file, a glTF file (.gltf, .glb), or an OBJ file; several OBJ files make one scene.
    #[arg(long, value_name = "NAME|FILE")]
    pub scene: Vec<PathBuf>,
    /// Scale factor on the scene's coordinates.
    #[arg(long, default_value_t = 1.0)]
    pub scale: f32,
    /// The greatest side of a material's image in texels; larger ones are made smaller as they are loaded.
    #[arg(long, value_name = "TEXELS", default_value_t = MAX_EXTENT, value_parser = clap::value_parser!(u32).range(1..))]
    pub texture_size: u32,
    /// A named view of the scene; without it, the scene's first.
    #[arg(long, conflicts_with_all = ["eye", "look_at"])]
    pub view: Option<String>,
    /// Camera position in metres.
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true, requires = "look_at")]
    pub eye: Option<Vec3>,
    /// Where the camera looks.
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true, requires = "eye")]
    pub look_at: Option<Vec3>,
    /// Vertical field of view in degrees.
    #[arg(long, value_name = "DEG")]
    pub fov: Option<f32>,
    /// Near plane in metres.
    #[arg(long, value_name = "M")]
    pub near: Option<f32>,
    /// Far plane in metres.
    #[arg(long, value_name = "M")]
    pub far: Option<f32>,
    /// Replace every material's roughness (0 is a mirror, 1 the roughest).
    #[arg(long, value_name = "R", value_delimiter = ',')]
    pub roughness: Vec<f32>,
    /// Scale every material's reflectivity.
    #[arg(long, value_name = "F", default_value_t = 1.0)]
    pub reflectivity: f32,
    /// Replace every material's normal deviation (0 is the geometric normal, 1 the normal map).
    #[arg(long, value_name = "D")]
    pub normal_deviation: Option<f32>,
}

/// Which device, and whether it is watched.
#[derive(Debug, Args)]
pub struct DeviceOptions {
    /// An index of `ssct devices`, or a part of a name; also the variable SSCT_DEVICE.
    #[arg(long, value_name = "INDEX|NAME")]
    pub device: Option<String>,
    /// Run under the validation layers; any message outside the allow-list fails the run.
    #[arg(long)]
    pub validation: bool,
}

/// What a command that measures does with its records.
#[derive(Debug, Clone, Copy, Args)]
pub struct RunOptions {
    /// Go on with what the folder has: nothing that was measured with the same settings is measured again.
    #[arg(long, requires = "output")]
    pub resume: bool,
    /// Print the records as JSON, and nothing else.
    #[arg(long)]
    pub json: bool,
}

/// Which part of a study is run.
#[derive(Debug, Clone, Copy, Args)]
pub struct ShardOptions {
    /// Measure only this share of the cells, such as 3/8, the third of eight; `ssct merge` puts shards together
    /// (docs/many-machines.md).
    #[arg(long, value_name = "I/N", requires = "output")]
    pub shard: Option<Shard>,
}

/// Options of `ssct render`.
#[derive(Debug, Args)]
pub struct RenderOptions {
    #[command(flatten)]
    pub common: CommonOptions,
    /// The method, or `reference`: the ground truth, traced on the CPU against the triangles. Without it,
    /// the method that --figure is of, or ssct.
    #[arg(long)]
    pub method: Option<String>,
    /// Width and height in pixels.
    #[arg(long, value_name = "WxH", value_parser = size, default_value = "960x540")]
    pub size: [u32; 2],
    /// The image: .png (display) or .exr (linear).
    #[arg(short, long, value_name = "FILE", required_unless_present = "dump")]
    pub output: Option<PathBuf>,
    /// Write every intermediate into a folder, as PNG and EXR.
    #[arg(long, value_name = "DIR")]
    pub dump: Option<PathBuf>,
    /// Write a figure of the thesis or the poster instead of the image.
    #[arg(long, value_parser = choice::<Figure>(), requires = "output")]
    pub figure: Option<Figure>,
    /// Write only the reflection, before fade and reflectivity.
    #[arg(long, conflicts_with = "figure")]
    pub reflection_only: bool,
    /// For --method reference: sample until the reflection's standard error is at most this.
    #[arg(long, value_name = "E", default_value_t = 0.003)]
    pub standard_error: f32,
    /// For --method reference: rays a pixel at most.
    #[arg(long, value_name = "N", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(2..=1_048_576))]
    pub max_rays: u32,
    /// For --method reference: where samples are kept, to go on from; without it, the user's cache folder.
    #[arg(long, value_name = "DIR")]
    pub cache: Option<PathBuf>,
    /// For --method reference: take only this share of the --max-rays rays, such as 3/8, the third of eight, keep them in
    /// --cache, and show what they alone give; `ssct merge` puts the shares together (docs/many-machines.md).
    #[arg(long, value_name = "I/N", requires_all = ["output", "cache"], conflicts_with = "standard_error")]
    pub shard: Option<Shard>,
    /// Print which passes were recorded, and which were not and why.
    #[arg(long, conflicts_with = "json")]
    pub explain: bool,
    /// Print what was drawn, recorded and skipped, as JSON.
    #[arg(long)]
    pub json: bool,
}

/// Options of `ssct time`.
#[derive(Debug, Args)]
pub struct TimeOptions {
    #[command(flatten)]
    pub common: CommonOptions,
    /// The methods; without it, all of them.
    #[arg(long, value_delimiter = ',')]
    pub method: Vec<String>,
    /// Widths and heights in pixels.
    #[arg(long, visible_alias = "sizes", value_name = "WxH", value_parser = size, value_delimiter = ',')]
    pub size: Vec<[u32; 2]>,
    /// Measure a table of the thesis (its sizes and roughness values, on the view `hall`), or the times in its
    /// captions, each on the view that stands for its figure.
    #[arg(long, value_enum)]
    pub table: Option<Table>,
    /// For --table captions: rays a pixel of the reference that stands for Mitsuba.
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..=65536))]
    pub reference_rays: u32,
    /// Move the camera along a path and give frames per second: `views` (through the scene's views), a path of
    /// the scene file, or a path file (.toml).
    #[arg(long, value_name = "NAME|FILE", conflicts_with_all = ["table", "samples", "view", "eye"])]
    pub path: Option<PathBuf>,
    /// For --path: frames from its beginning to its end.
    #[arg(long, value_name = "N", default_value_t = 120, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub frames: u32,
    /// Frames that count, for each method, size and roughness.
    #[arg(long, default_value_t = 10)]
    pub samples: usize,
    /// Frames before the first that counts.
    #[arg(long, default_value_t = 2)]
    pub warmup: usize,
    /// Time each method against itself, too: how far it strays is its noise floor, within which `ssct compare` calls
    /// nothing faster or slower.
    #[arg(long, conflicts_with = "path")]
    pub a_a: bool,
    /// Write each sample's passes, on the host and on the device, as a trace for Chrome or Perfetto.
    #[arg(long, value_name = "FILE", conflicts_with = "path")]
    pub trace: Option<PathBuf>,
    #[command(flatten)]
    pub shard: ShardOptions,
    /// Write time.json, time-samples.csv, time.svg and time.txt into a folder; of a path, path.json,
    /// path-frames.csv, path.svg and path.txt.
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub run: RunOptions,
}

/// Options of `ssct merge`.
#[derive(Debug, Args)]
pub struct MergeOptions {
    /// The folders of the shards, or of runs that were merged before.
    #[arg(value_name = "DIR", required = true)]
    pub folders: Vec<PathBuf>,
    /// The folder of the whole study, with the files of a run that was never divided.
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// Merge although cells are missing; the page names them.
    #[arg(long)]
    pub partial: bool,
    /// Print what was merged as JSON: how many cells there are, on which devices, and which are missing.
    #[arg(long)]
    pub json: bool,
}

/// Options of `ssct stress`.
#[derive(Debug, Args)]
pub struct StressOptions {
    /// The methods; without it, all of them.
    #[arg(long, value_delimiter = ',')]
    pub method: Vec<String>,
    /// Only small images and one scene: a minute.
    #[arg(long)]
    pub quick: bool,
    /// Only cases whose name contains this.
    #[arg(long, value_name = "WORDS")]
    pub case: Option<String>,
    #[command(flatten)]
    pub shard: ShardOptions,
    /// Write stress.json, stress.txt and index.html into a folder.
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub run: RunOptions,
    #[command(flatten)]
    pub device: DeviceOptions,
}

/// Options of `ssct motion`.
#[derive(Debug, Args)]
pub struct MotionOptions {
    #[command(flatten)]
    pub common: CommonOptions,
    /// The methods; without it, all of them.
    #[arg(long, value_delimiter = ',')]
    pub method: Vec<String>,
    /// Width and height in pixels.
    #[arg(long, value_name = "WxH", value_parser = size, default_value = "320x180")]
    pub size: [u32; 2],
    /// Frames of each motion of the camera.
    #[arg(long, value_name = "N", default_value_t = 6, value_parser = clap::value_parser!(u32).range(2..=10_000))]
    pub frames: u32,
    /// Rays a pixel of the screen and the world reference.
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(2..=65536))]
    pub rays: u32,
    /// Write motion.json and motion.txt into a folder.
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub run: RunOptions,
}

/// The subcommands of `ssct gbuffer`.
#[derive(Debug, Subcommand)]
pub enum GBufferCommand {
    /// Write the G-buffer of a view as multi-channel OpenEXR.
    Export(GBufferExportOptions),
    /// Run a method on a G-buffer file.
    Reflect(GBufferReflectOptions),
    /// Write the G-buffer that a map makes of another renderer's files as a file of our own, to look at it.
    Convert(GBufferConvertOptions),
}

/// Options of `ssct gbuffer export`.
#[derive(Debug, Args)]
pub struct GBufferExportOptions {
    /// The file (.exr).
    #[arg(value_name = "FILE.exr")]
    pub file: PathBuf,
    #[command(flatten)]
    pub place: SceneOptions,
    #[command(flatten)]
    pub device: DeviceOptions,
    /// Width and height in pixels.
    #[arg(long, value_name = "WxH", value_parser = size, default_value = "960x540")]
    pub size: [u32; 2],
}

/// Options of `ssct gbuffer reflect`.
#[derive(Debug, Args)]
pub struct GBufferReflectOptions {
    /// The G-buffer: R, G, B, depth or Z, N.X, N.Y, N.Z, roughness, reflectivity, and a projection; with --gbuffer-map what
    /// the map says.
    #[arg(value_name = "FILE.exr")]
    pub file: PathBuf,
    /// A map that says which channel of which file is what, and in which conventions (docs/gbuffer-maps.md).
    #[arg(long, value_name = "FILE.toml")]
    pub gbuffer_map: Option<PathBuf>,
    /// The method.
    #[arg(long, default_value = "ssct")]
    pub method: String,
    /// The image: .png (display) or .exr (linear).
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// Write only the reflection, before fade and reflectivity.
    #[arg(long)]
    pub reflection_only: bool,
    #[command(flatten)]
    pub beside: BesideGBufferOptions,
    #[command(flatten)]
    pub device: DeviceOptions,
}

/// Options of `ssct gbuffer convert`.
#[derive(Debug, Args)]
pub struct GBufferConvertOptions {
    /// The G-buffer of another renderer; further files that the map names lie beside it.
    #[arg(value_name = "FILE.exr")]
    pub file: PathBuf,
    /// The map that says which channel of which file is what, and in which conventions (docs/gbuffer-maps.md).
    #[arg(long, value_name = "FILE.toml")]
    pub gbuffer_map: PathBuf,
    /// The G-buffer in our own conventions (.exr), as `ssct gbuffer export` writes it.
    #[arg(short, long, value_name = "FILE.exr")]
    pub output: PathBuf,
}

/// A table of the thesis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Table {
    /// Resolutions and roughness values of SSCT, HZCT and SSLR.
    #[value(name = "5.8")]
    T5_8,
    /// The times under figures 5.2 to 5.9.
    Captions,
}

/// Options of `ssct study`.
#[derive(Debug, Args)]
pub struct StudyOptions {
    /// Two scenes, small and few: a minute.
    #[arg(long, conflicts_with = "full")]
    pub quick: bool,
    /// Show and time every view of every scene, instead of showing the first of each and timing it in the rooms and
    /// the atrium: half an hour on two CPU cores.
    #[arg(long)]
    pub full: bool,
    /// Methods from folders, which are shown, timed and judged beside those of the table.
    #[arg(long, value_name = "FOLDER", value_delimiter = ',')]
    pub method: Vec<String>,
    /// Frames that count, for each measurement.
    #[arg(long, default_value_t = 5, conflicts_with = "quick")]
    pub samples: usize,
    /// The folder; its page is index.html.
    #[arg(short, long, value_name = "DIR", default_value = "out")]
    pub output: PathBuf,
    /// Go on with what the folder has: nothing that was measured with the same settings is measured again.
    #[arg(long)]
    pub resume: bool,
    #[command(flatten)]
    pub device: DeviceOptions,
}

/// Options of `ssct figures`.
#[derive(Debug, Args)]
pub struct FiguresOptions {
    /// The folder; its page is index.html.
    #[arg(short, long, value_name = "DIR", default_value = "figures")]
    pub output: PathBuf,
    /// Only the figures of these numbers, such as 4.5,5.2 or schmidt-27.
    #[arg(long, value_name = "NUMBER", value_delimiter = ',')]
    pub only: Vec<String>,
    /// Width and height of each render, instead of those in print.
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub size: Option<[u32; 2]>,
    /// Make only this share of the figures, such as 3/8, the third of eight; `ssct merge` puts shards together
    /// (docs/many-machines.md).
    #[arg(long, value_name = "I/N")]
    pub shard: Option<Shard>,
    /// Go on with what the folder has: nothing that was made with the same settings is made again.
    #[arg(long)]
    pub resume: bool,
    #[command(flatten)]
    pub device: DeviceOptions,
}

/// `960x540`.
pub fn size(text: &str) -> Result<[u32; 2], String> {
    let wrong = || format!("{text:?} is no size; write it as 960x540");
    let (w, h) = text.split_once(['x', 'X', '×']).ok_or_else(wrong)?;
    let [w, h] = [w, h].map(|v| v.trim().parse::<u32>());
    match (w, h) {
        (Ok(0), Ok(_)) | (Ok(_), Ok(0)) => Err(format!("a size of {text} has no pixels")),
        (Ok(w), Ok(h)) => Ok([w, h]),
        _ => Err(wrong()),
    }
}

/// `1.5,0,-3`.
pub fn point(text: &str) -> Result<Vec3, String> {
    let parts: Vec<_> = text.split(',').map(|v| v.trim().parse::<f32>()).collect();
    match parts[..] {
        [Ok(x), Ok(y), Ok(z)] if Vec3::new(x, y, z).is_finite() => Ok(Vec3::new(x, y, z)),
        _ => Err(format!("{text:?} is no point; write it as 1.5,0,-3")),
    }
}

//! The flags that several commands share, and those of most commands, each declared once. `resolve` decides what flags mean together.

use super::parameters::{BesideGBufferOptions, MethodOptions, choice_parser};
use crate::report::figures::Figure;
use crate::study::shard::Shard;
use clap::builder::TypedValueParser;
use clap::{Args, Subcommand};
use glam::Vec3;
use ssct_geometry::texture::MAX_EXTENT;
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
    /// Scene and camera.
    #[command(flatten)]
    pub place: SceneOptions,
    /// Parameters of methods.
    #[command(flatten)]
    pub method_options: MethodOptions,
    /// Device.
    #[command(flatten)]
    pub device: DeviceOptions,
}

/// What is looked at, from where, and with which materials.
#[derive(Debug, Clone, Args)]
pub struct SceneOptions {
    /// Scene (rooms, atrium, street, …) or file (glTF, OBJ)
    ///
    /// The built-in scenes are rooms, atrium, street, museum, cathedral and corridor, and cornell-box, which is for a figure
    /// alone. A file is a .scene.toml, a glTF file
    /// (.gltf, .glb) or an OBJ file; several OBJ files make one scene.
    #[arg(long, value_name = "NAME|FILE")]
    pub scene: Vec<PathBuf>,
    /// Factor on the scene's coordinates
    #[arg(long, value_name = "F", default_value_t = 1.0)]
    pub scale: f32,
    /// Greatest side of a material's image
    ///
    /// Larger images are made smaller as they are loaded.
    #[arg(long, value_name = "TEXELS", default_value_t = MAX_EXTENT, value_parser = clap::value_parser!(u32).range(1..))]
    pub texture_size: u32,
    /// Seconds at which the scene is shown, with things where its motion has them
    #[arg(long, value_name = "S", allow_hyphen_values = true)]
    pub time: Option<f32>,
    /// Motion of the scene that --time is of; by default its first
    ///
    /// The animations of a glTF file are motions, and scene files name others.
    #[arg(long, value_name = "NAME", requires = "time")]
    pub motion: Option<String>,
    /// Named view of the scene; by default its first
    #[arg(long, value_name = "NAME", conflicts_with_all = ["eye", "look_at"])]
    pub view: Option<String>,
    /// Position of the camera in metres, with --look-at
    ///
    /// It is in the program's own space, which is left-handed, with +y up. A place of an OBJ or glTF file, or of a scene file in
    /// the same coordinates, has the other sign of z there.
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true, requires = "look_at")]
    pub eye: Option<Vec3>,
    /// Point in metres that the camera looks at, with --eye
    ///
    /// It is in the same space as --eye.
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true, requires = "eye")]
    pub look_at: Option<Vec3>,
    /// Vertical field of view in degrees
    ///
    /// It makes a perspective of an orthographic view.
    #[arg(long, value_name = "DEG")]
    pub fov: Option<f32>,
    /// Height of an orthographic view in metres
    ///
    /// The view is seen along parallel lines, from the same place.
    #[arg(long, value_name = "M", conflicts_with = "fov")]
    pub orthographic_height: Option<f32>,
    /// Near plane in metres
    #[arg(long, value_name = "M")]
    pub near: Option<f32>,
    /// Far plane in metres
    #[arg(long, value_name = "M")]
    pub far: Option<f32>,
    /// Roughness of every material, from 0, a mirror, to 1
    ///
    /// 0 is a mirror. The half angle of the lobe is half the roughness, so that 1 is a lobe of 28.6 degrees to each side, and not
    /// a diffuse surface. The number replaces the materials' own numbers and maps. What a material reflects stays as it is: a
    /// metal keeps its reflectivity, and has no tint with this option or without it. Without it, materials keep their own, unless
    /// the command says otherwise. Commands that measure take several values, with commas between them.
    #[arg(long, value_name = "R", value_delimiter = ',')]
    pub roughness: Vec<f32>,
    /// Factor on every material's reflectivity
    #[arg(long, value_name = "F", default_value_t = 1.0)]
    pub reflectivity: f32,
    /// Normals of every material: 0 geometric, 1 its map's
    ///
    /// The number replaces the materials' own normal deviation.
    #[arg(long, value_name = "D")]
    pub normal_deviation: Option<f32>,
}

/// Which device, and whether it is watched.
#[derive(Debug, Args)]
pub struct DeviceOptions {
    /// Part of a device's name, or index of `ssct devices`
    ///
    /// The environment variable SSCT_DEVICE does the same. Without both, the best device by its type is used.
    #[arg(long, value_name = "NAME|INDEX")]
    pub device: Option<String>,
    /// Run under the validation layers
    ///
    /// A message of the layers that the allow-list does not excuse fails the run.
    #[arg(long)]
    pub validation: bool,
}

/// Which part of a study is measured, and where its results go.
#[derive(Debug, Clone, Args)]
pub struct RunOptions {
    /// Measure only this share, such as 3/8
    ///
    /// 3/8 is the third of eight shares of the study's cells. `ssct merge` puts shards together (docs/many-machines.md).
    #[arg(long, value_name = "I/N", requires = "output")]
    pub shard: Option<Shard>,
    /// Folder for records, tables, charts and a page
    ///
    /// Files are named by the command: the records are in error.json, time.json and so on.
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Go on with what the folder has
    ///
    /// Nothing that was measured with the same settings is measured again.
    #[arg(long, requires = "output")]
    pub resume: bool,
    /// Print the records as JSON, and nothing else
    #[arg(long)]
    pub json: bool,
}

/// Options of `ssct render`.
#[derive(Debug, Args)]
pub struct RenderOptions {
    /// Scene, methods and device.
    #[command(flatten)]
    pub common: CommonOptions,
    /// Method, or `reference` for the ground truth
    ///
    /// The ground truth is traced on the CPU against the triangles. Without --method, the method of --figure is used, or
    /// ssct. A path to a folder adds the method that is in it (docs/custom-methods.md).
    #[arg(long, value_name = "NAME")]
    pub method: Option<String>,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", value_parser = parse_size, default_value = "960x540")]
    pub size: [u32; 2],
    /// Image to write: .png (display) or .exr (linear)
    #[arg(short, long, value_name = "FILE", required_unless_present_any = ["dump", "pixel"])]
    pub output: Option<PathBuf>,
    /// Say why a pixel is as it is: X,Y from the top left
    ///
    /// It says where the pixel's ray ends by the method, by the oracle and in the world, what hid that place from the screen, what the
    /// fade leaves, which colours were mixed, and at which cell of which level the walk looked last (docs/dump.md). With --json the
    /// record has it as `pixel`.
    #[arg(long, value_name = "X,Y", value_parser = super::pixel::parse, conflicts_with = "figure")]
    pub pixel: Option<[u32; 2]>,
    /// Folder for every image on the way, as PNG and EXR
    ///
    /// The images are those of the passes that --explain lists (docs/dump.md).
    #[arg(long, value_name = "DIR")]
    pub dump: Option<PathBuf>,
    /// Write a figure of the thesis or the poster instead
    #[arg(long, value_name = "NUMBER", value_parser = choice_parser::<Figure>(), requires = "output")]
    pub figure: Option<Figure>,
    /// Write only the reflection, before fade and reflectivity.
    #[arg(long, conflicts_with = "figure")]
    pub reflection_only: bool,
    /// For --method reference: the standard error of the reflection at which sampling ends [default: 0.003]
    #[arg(long, value_name = "E")]
    pub standard_error: Option<f32>,
    /// For --method reference: rays a pixel at most [default: 1024]
    ///
    /// Mirrors take at least 16, over the footprint of a pixel, however few are allowed.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=1_048_576))]
    pub max_rays: Option<u32>,
    /// For --method reference: where samples are kept, to go on from; without it, the user's cache folder.
    #[arg(long, value_name = "DIR")]
    pub cache: Option<PathBuf>,
    /// For --method reference: light of diffuse paths instead
    ///
    /// The scene's rectangular area lights shine, things cast shadows, and surfaces pass light on up to N times; 0 is direct
    /// light alone. Every surface is taken for a diffuse one, and each pixel has --max-rays paths. The samples are not kept in
    /// --cache.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(..=64), conflicts_with_all = ["standard_error", "cache", "shard", "reflection_only", "json", "bounces"])]
    pub diffuse_bounces: Option<u32>,
    /// For --method reference: take this share of the rays
    ///
    /// 3/8 is the third of eight shares of the --max-rays rays. They are kept in --cache, and the image shows what they
    /// alone give. `ssct merge` puts the shares together (docs/many-machines.md).
    #[arg(long, value_name = "I/N", requires_all = ["output", "cache"], conflicts_with = "standard_error")]
    pub shard: Option<Shard>,
    /// Print which passes ran, and why others did not
    ///
    /// With --json the record says it, as `recorded`, `skipped` and `prepared`.
    #[arg(long)]
    pub explain: bool,
    /// Print what was drawn, recorded and skipped, as JSON
    #[arg(long)]
    pub json: bool,
}

/// Options of `ssct merge`.
#[derive(Debug, Args)]
pub struct MergeOptions {
    /// Folders of shards, or of runs that were merged
    #[arg(value_name = "DIR", required = true)]
    pub folders: Vec<PathBuf>,
    /// Folder of the whole study
    ///
    /// It gets the files of a run that was never divided.
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// Merge although cells are missing; the page names them
    #[arg(long)]
    pub partial: bool,
    /// Print the number of cells, devices and gaps as JSON
    ///
    /// The JSON object says how many cells there are, on which devices they were measured, and which are missing.
    #[arg(long)]
    pub json: bool,
}

/// The subcommands of `ssct gbuffer`.
#[derive(Debug, Subcommand)]
pub enum GBufferCommand {
    /// Write the G-buffer of a view as multi-channel OpenEXR.
    Export(GBufferExportOptions),
    /// Run a method on a G-buffer file.
    ///
    /// The image is made once. So in unified and traced, pixels whose neighbours' rays say little of their reflection get 16 rays of
    /// their own, unless --own-rays says how many.
    Reflect(GBufferReflectOptions),
    /// Write another renderer's G-buffer as a file of our own.
    ///
    /// A map says how the files of the other renderer are read.
    Convert(GBufferConvertOptions),
}

/// Options of `ssct gbuffer export`.
#[derive(Debug, Args)]
pub struct GBufferExportOptions {
    /// File to write
    #[arg(value_name = "FILE.exr")]
    pub file: PathBuf,
    /// Scene and camera.
    #[command(flatten)]
    pub place: SceneOptions,
    /// Device.
    #[command(flatten)]
    pub device: DeviceOptions,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", value_parser = parse_size, default_value = "960x540")]
    pub size: [u32; 2],
}

/// Options of `ssct gbuffer reflect`.
#[derive(Debug, Args)]
pub struct GBufferReflectOptions {
    /// G-buffer, as `ssct gbuffer export` writes it
    ///
    /// Its channels are R, G, B, depth or Z, N.X, N.Y, N.Z, roughness and reflectivity, and it has a projection; with
    /// --gbuffer-map, it has what the map says.
    #[arg(value_name = "FILE.exr")]
    pub file: PathBuf,
    /// Map that says what the channels mean
    ///
    /// It says which channel of which file is what, and in which conventions (docs/gbuffer-maps.md).
    #[arg(long, value_name = "MAP")]
    pub gbuffer_map: Option<PathBuf>,
    /// Method
    #[arg(long, value_name = "NAME", default_value = "ssct")]
    pub method: String,
    /// Image to write: .png (display) or .exr (linear)
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// Write only the reflection, before fade and reflectivity.
    #[arg(long)]
    pub reflection_only: bool,
    /// Scene that the G-buffer shows
    ///
    /// The name of a built-in scene or a file, as --scene takes them; several OBJ files make one scene. Rays that the screen loses
    /// go on among the scene's triangles, and methods that need a scene have this one. The G-buffer must say where its camera
    /// stands in the scene.
    #[arg(long, value_name = "NAME|FILE", conflicts_with = "captures")]
    pub triangles: Vec<PathBuf>,
    /// Captures beside the G-buffer, and parameters of methods.
    #[command(flatten)]
    pub beside: BesideGBufferOptions,
    /// Device.
    #[command(flatten)]
    pub device: DeviceOptions,
}

/// Options of `ssct gbuffer convert`.
#[derive(Debug, Args)]
pub struct GBufferConvertOptions {
    /// G-buffer of another renderer
    ///
    /// Further files that the map names lie beside it.
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// Map that says what the channels mean
    ///
    /// It says which channel of which file is what, and in which conventions (docs/gbuffer-maps.md).
    #[arg(long, value_name = "MAP")]
    pub gbuffer_map: PathBuf,
    /// G-buffer to write, in our conventions
    #[arg(short, long, value_name = "FILE.exr")]
    pub output: PathBuf,
}

/// Options of `ssct study`.
#[derive(Debug, Args)]
pub struct StudyOptions {
    /// Two scenes, small images: a minute
    #[arg(long, conflicts_with = "full")]
    pub quick: bool,
    /// Show and time every view of every scene
    ///
    /// It takes half an hour on two CPU cores. Without it, the first view of each scene is shown, and timed in the rooms
    /// and in the atrium.
    #[arg(long)]
    pub full: bool,
    /// Folders of methods, to be judged beside the built-in
    #[arg(long, value_name = "FOLDER", value_delimiter = ',')]
    pub method: Vec<String>,
    /// Frames that are timed for each measurement
    #[arg(long, value_name = "N", default_value_t = 3, conflicts_with = "quick", value_parser = count_parser(0))]
    pub samples: usize,
    /// Folder to write, with index.html
    #[arg(short, long, value_name = "DIR", default_value = "out")]
    pub output: PathBuf,
    /// Go on with what the folder has
    ///
    /// Nothing that was measured with the same settings is measured again.
    #[arg(long)]
    pub resume: bool,
    /// Device.
    #[command(flatten)]
    pub device: DeviceOptions,
}

/// Options of `ssct figures`.
#[derive(Debug, Args)]
pub struct FiguresOptions {
    /// Folder to write, with index.html
    #[arg(short, long, value_name = "DIR", default_value = "figures")]
    pub output: PathBuf,
    /// Only these figures, such as 4.5,5.2 or schmidt-27
    #[arg(long, value_name = "NUMBER", value_delimiter = ',')]
    pub only: Vec<String>,
    /// Draw the figures that print this scene in it
    ///
    /// A file of the thesis's rooms or of Sponza, known by its views: window-floor, corridor, two-cylinders and window, or
    /// atrium, lion and hall. Without it, generated scenes stand in for both.
    #[arg(long, value_name = "FILE")]
    pub scene: Option<PathBuf>,
    /// Width and height of renders, instead of the printed
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<[u32; 2]>,
    /// Make only this share of the figures, such as 3/8
    ///
    /// 3/8 is the third of eight shares. `ssct merge` puts shards together (docs/many-machines.md).
    #[arg(long, value_name = "I/N")]
    pub shard: Option<Shard>,
    /// Go on with what the folder has
    ///
    /// Nothing that was made with the same settings is made again.
    #[arg(long)]
    pub resume: bool,
    /// Device.
    #[command(flatten)]
    pub device: DeviceOptions,
}

/// The greatest number of frames or of samples that a command takes.
const MAX_COUNT: i64 = 1_000_000;

/// Returns a parser of numbers of frames or samples, from `least` to `MAX_COUNT`.
pub fn count_parser(least: i64) -> impl TypedValueParser<Value = usize> {
    clap::value_parser!(u32).range(least..=MAX_COUNT).map(|count| count as usize)
}

/// The greatest number of pixels of an image. Devices take less.
const MAX_PIXELS: u64 = 1 << 30;

/// Parses the width and the height of an image in pixels, such as `960x540`. Both are at least 1.
pub fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let wrong = || format!("{text:?} is no size; write it as 960x540");
    let (width_text, height_text) = text.split_once(['x', 'X', '×']).ok_or_else(wrong)?;
    let [width, height] = [width_text, height_text].map(|side| side.trim().parse::<u32>());
    match (width, height) {
        (Ok(0), Ok(_)) | (Ok(_), Ok(0)) => Err(format!("a size of {text} has no pixels")),
        (Ok(width), Ok(height)) if u64::from(width) * u64::from(height) > MAX_PIXELS => {
            Err(format!("a size of {text} is too large: an image has at most {MAX_PIXELS} pixels"))
        }
        (Ok(width), Ok(height)) => Ok([width, height]),
        _ => Err(wrong()),
    }
}

/// Parses a point such as `1.5,0,-3`: x, y and z, all finite.
pub fn parse_point(text: &str) -> Result<Vec3, String> {
    let coordinates: Vec<_> = text.split(',').map(|number| number.trim().parse::<f32>()).collect();
    match coordinates[..] {
        [Ok(x), Ok(y), Ok(z)] if Vec3::new(x, y, z).is_finite() => Ok(Vec3::new(x, y, z)),
        _ => Err(format!("{text:?} is no point; write it as 1.5,0,-3")),
    }
}

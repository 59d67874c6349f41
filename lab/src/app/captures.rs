//! `ssct captures`: where a scene's captures stand, what they see, and their images.

use super::cli::DeviceOptions;
use super::printed;
use super::resolve;
use crate::error::Error;
use crate::report::captures::{self, CubePictures};
use crate::report::files;
use crate::stage::{Stage, gbuffer};
use clap::Args;
use ssct::methods::capture::common_near_m;
use ssct_geometry::placement::{WantedCaptures, with_captures};
use ssct_scenes::capture::{MAX_CAPTURES, MAX_RESOLUTION};
use ssct_scenes::inside::PathInFolder;
use ssct_scenes::obj::Handedness;
use ssct_scenes::{Capture, LoadOptions, Scene, capture_file, scene_file};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Options of `ssct captures`.
#[derive(Debug, Args)]
pub struct CapturesOptions {
    /// Scene (rooms, atrium, street, …) or file (glTF, OBJ)
    ///
    /// The built-in scenes are rooms, atrium, street, museum, cathedral and corridor, and cornell-box, which is for a figure
    /// alone. A file is a .scene.toml, a glTF file (.gltf, .glb) or an OBJ file; several OBJ files make one scene.
    #[arg(value_name = "NAME|FILE", required = true)]
    scene: Vec<PathBuf>,
    /// Factor on the scene's coordinates
    #[arg(long, value_name = "F", default_value_t = 1.0)]
    scale: f32,
    /// Number of captures, or `auto`
    ///
    /// `auto` takes the captures of the scene file or, if it has none, as many as pay. A number takes so many, first the
    /// captures of the file.
    #[arg(long, value_name = "N|auto", value_parser = parse_wanted_captures, default_value = "auto")]
    captures: WantedCaptures,
    /// File for [[capture]] tables of a scene file
    ///
    /// Their places are in the coordinates of the scene file that is given, or else right-handed, as in a scene file that does
    /// not say otherwise.
    #[arg(long, value_name = "FILE.toml")]
    write: Option<PathBuf>,
    /// File for a map of the captures, seen from above
    ///
    /// The map also shows the places where people can stand.
    #[arg(long, value_name = "FILE.svg")]
    map: Option<PathBuf>,
    /// Texels along a side of a face
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_RESOLUTION)))]
    capture_side: Option<u32>,
    /// Folder for the images of the captures
    ///
    /// The faces are written as .exr, which `ssct gbuffer reflect --captures DIR` reads, and for each capture there is a
    /// .png of colour and one of depth.
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Named view whose materials are drawn
    ///
    /// Without it, the materials are those of the first view.
    #[arg(long, value_name = "NAME", requires = "output")]
    view: Option<String>,
    /// Print the records as JSON, and nothing else
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    device: DeviceOptions,
}

/// Places a scene's captures, writes the files that the options ask for, and prints a record of each capture.
pub fn run(options: &CapturesOptions) -> anyhow::Result<()> {
    let mut scene = resolve::load(&options.scene, &LoadOptions { scale: options.scale, ..LoadOptions::default() })?;
    let mut placement = with_captures(&mut scene, options.captures);
    if let Some(side) = options.capture_side {
        placement.captures.iter_mut().for_each(|c| c.resolution = side);
    }
    if placement.captures.is_empty() {
        let why = "it has no floor that people could stand on, or nothing around one that a mirror could show";
        return Err(Error::usage(format!("no place for a capture was found in scene {}: {why}", scene.name)).into());
    }
    if let Some(file) = &options.write {
        let coordinates = coordinates(&options.scene)?;
        let tables: Vec<Capture> = placement.captures.iter().map(|c| coordinates.capture(*c)).collect();
        files::write(file, capture_file::encode_tables(&tables).as_bytes())?;
    }
    if let Some(file) = &options.map {
        files::write(file, captures::map(&placement).as_bytes())?;
    }
    if let Some(folder) = &options.output {
        draw(options, &scene, &placement.captures, folder)?;
    }
    let records = captures::records(&scene.name, &placement);
    let shown = if options.json { files::json(&records) } else { captures::text(&records) };
    printed::out().write_all(shown.as_bytes())?;
    Ok(())
}

/// Returns the handedness of the coordinates in which captures are written for a scene file: that of the given scene
/// file, or right-handed if the scene has no scene file.
fn coordinates(sources: &[PathBuf]) -> crate::error::Result<Handedness> {
    match sources {
        [file] if super::resolve::is_toml(file) => Ok(scene_file::coordinates(file)?),
        _ => Ok(Handedness::Right),
    }
}

/// Draws captures of a scene, and writes the images, the sky and the list of captures into a folder ([`capture_file`]).
/// The materials are those of the view that the options name, or else of the scene's first view.
fn draw(options: &CapturesOptions, scene: &Scene, captures: &[Capture], folder: &Path) -> anyhow::Result<()> {
    let view = match &options.view {
        Some(name) => Some(scene.view(name)?),
        None => scene.views.first(),
    };
    let materials = view.map_or_else(|| scene.materials.clone(), |v| scene.materials_in(v));
    let gpu = resolve::gpu(&options.device)?;
    let mut stage = Stage::new(&gpu, scene)?;
    let sky = gbuffer::read_sky(&mut stage)?;
    // All paths in the folder begin without a prefix.
    let (target, prefix) = (PathInFolder::folder(folder), Path::new(""));
    let texels_a_face = (sky.side * sky.side) as usize;
    for (face, texels) in sky.texels.chunks_exact(texels_a_face).enumerate() {
        let file = target.join(capture_file::sky_path(prefix, face));
        file.write(&capture_file::encode_sky(sky.side, texels, &file.path())?)?;
    }
    let mut pictures = CubePictures::default();
    gbuffer::draw_captures(&mut stage, &materials, captures, |capture, face, data| {
        let path = capture_file::face_path(prefix, capture, face);
        let file = target.join(&path);
        file.write(&capture_file::encode_face(&data, &file.path())?)?;
        pictures.add(face, &data);
        if face + 1 < capture_file::FACES.len() {
            return Ok(());
        }
        // After the last face of a capture, the pictures of its whole cube are written.
        let [color, depth] = std::mem::take(&mut pictures).crosses();
        color.write_png(target.join(path.with_file_name("color.png")))?;
        Ok(depth.write_png(target.join(path.with_file_name("depth.png")))?)
    })?;
    // All captures were drawn with this near plane.
    let near_m = common_near_m(captures);
    let drawn: Vec<Capture> = captures.iter().map(|c| Capture { near_m, ..*c }).collect();
    let list = capture_file::encode_list(&drawn, stage.scene().bounds());
    // The list is written last, so that a folder with a list has all of its faces.
    target.join(capture_file::LIST).write(list.as_bytes())?;
    drop(stage);
    gpu.check_validation()?;
    Ok(())
}

/// Parses `auto` or a number of captures, from 1 to [`MAX_CAPTURES`].
fn parse_wanted_captures(text: &str) -> Result<WantedCaptures, String> {
    match text.parse::<usize>() {
        _ if text == "auto" => Ok(WantedCaptures::Auto),
        Ok(count) if (1..=MAX_CAPTURES).contains(&count) => Ok(WantedCaptures::Count(count)),
        _ => Err(format!("write auto, or a number from 1 to {MAX_CAPTURES}")),
    }
}

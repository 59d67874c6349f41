//! `ssct captures`: where a scene's captures stand, and what they see.

use super::resolve;
use crate::error::Error;
use crate::report::{captures, files};
use crate::scene::capture::MAX_CAPTURES;
use crate::scene::placement::{Wanted, with_captures};
use clap::Args;
use std::io::Write;
use std::path::PathBuf;

/// Options of `ssct captures`.
#[derive(Debug, Args)]
pub struct CapturesOptions {
    /// A built-in scene (rooms, atrium, street, museum, cathedral, corridor), a .scene.toml file, or OBJ files.
    #[arg(value_name = "NAME|FILE", required = true)]
    scene: Vec<PathBuf>,
    /// Scale factor on the scene's coordinates.
    #[arg(long, default_value_t = 1.0)]
    scale: f32,
    /// How many: `auto` takes those of the scene file or, where it has none, as many as pay; a number takes so many,
    /// first those of the file.
    #[arg(long, value_name = "auto|N", value_parser = wanted, default_value = "auto")]
    captures: Wanted,
    /// Write them as [[capture]] tables, to be pasted into a scene file.
    #[arg(long, value_name = "FILE.toml")]
    write: Option<PathBuf>,
    /// Draw a map: the places where people stand, seen from above, and the captures among them.
    #[arg(long, value_name = "FILE.svg")]
    map: Option<PathBuf>,
    /// Print the records as JSON, and nothing else.
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(options: &CapturesOptions) -> anyhow::Result<()> {
    let mut scene = resolve::load(&options.scene, options.scale)?;
    let placement = with_captures(&mut scene, options.captures);
    if placement.captures.is_empty() {
        let why = "it has no floor that people could stand on, or nothing around one that a mirror could show";
        return Err(Error::Usage(format!("no place for a capture was found in scene {}: {why}", scene.name)).into());
    }
    if let Some(file) = &options.write {
        let tables: Vec<String> = placement.captures.iter().map(|c| c.to_toml()).collect();
        files::write(file, tables.join("\n").as_bytes())?;
    }
    if let Some(file) = &options.map {
        files::write(file, captures::map(&placement).as_bytes())?;
    }
    let records = captures::records(&scene.name, &placement);
    let shown = if options.json { files::json(&records) } else { captures::text(&records) };
    std::io::stdout().lock().write_all(shown.as_bytes())?;
    Ok(())
}

/// `auto` or a number of captures.
fn wanted(text: &str) -> Result<Wanted, String> {
    match text.parse::<usize>() {
        _ if text == "auto" => Ok(Wanted::Auto),
        Ok(count) if (1..=MAX_CAPTURES).contains(&count) => Ok(Wanted::Count(count)),
        _ => Err(format!("write auto, or a number from 1 to {MAX_CAPTURES}")),
    }
}

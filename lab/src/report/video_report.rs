//! Films as files and text: records, a row a frame, a table, a plot, animated pictures, and a page that plays them beside
//! each other.

use super::html::{self, Clip, ClipsPage};
use super::plot::{self, Line};
use super::tables::{aligned, roughness};
use super::{error_report, files};
use crate::error::{Error, Result};
use crate::metrics::video::Film;
use crate::study::video::{Films, VideoRecord};
use std::path::Path;
use webp_animation::{Encoder, EncoderOptions, EncodingConfig};

/// Quality of the animated pictures, of 100.
const QUALITY: f32 = 85.0;

/// Folder of the animated pictures.
pub const CLIPS: &str = "clips";

/// Writes video.json, video-frames.csv, video.txt, video.svg and index.html.
pub fn write(folder: &Path, records: &[VideoRecord], command: &str) -> Result<()> {
    files::write(&folder.join("video.json"), files::json(records).as_bytes())?;
    files::write(&folder.join("video-frames.csv"), frames_csv(records).as_bytes())?;
    files::write(&folder.join("video.txt"), text(records).as_bytes())?;
    let svg = plot(records).map_err(|e| Error::io("draw the plot of", folder, std::io::Error::other(e)))?;
    files::write(&folder.join("video.svg"), svg.as_bytes())?;
    files::write(&folder.join("index.html"), page(folder, records, &svg, command).as_bytes())
}

/// One row a frame.
fn frames_csv(records: &[VideoRecord]) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let header =
        ["scene", "view", "way", "variant", "width", "height", "roughness", "frame", "effect_ms", "rmse", "flip"];
    // Writing to memory can't fail; were it to, the file would be short, and its reader would see.
    let _ = writer.write_record(header);
    for r in records {
        let h = &r.head;
        for (n, f) in r.frames.iter().enumerate() {
            let place = [h.scene.clone(), h.view.clone(), r.way.clone(), h.variant()];
            let size = [h.width.to_string(), h.height.to_string(), roughness(h.roughness), n.to_string()];
            let figures = [f.effect_ms, f.rmse, f.flip].map(|v| format!("{v:.6}"));
            let _ = writer.write_record(place.iter().chain(&size).chain(&figures));
        }
    }
    String::from_utf8(writer.into_inner().unwrap_or_default()).unwrap_or_default()
}

/// The films of one place, way, size and roughness are beside each other.
fn group(r: &VideoRecord) -> String {
    let h = &r.head;
    format!("{} {}, {}, {}x{}, roughness {}", h.scene, h.view, r.way, h.width, h.height, roughness(h.roughness))
}

/// A row for each film.
pub fn text(records: &[VideoRecord]) -> String {
    aligned(&table(records))
}

fn table(records: &[VideoRecord]) -> Vec<Vec<String>> {
    let header = [
        "film",
        "variant",
        "ms",
        "JOD",
        "JOD of reflections",
        "FLIP",
        "RMSE",
        "flicker over the world's",
        "error of changes over it",
        "standard error",
    ];
    let mut rows = vec![header.map(str::to_owned).to_vec()];
    for r in records {
        let over =
            |v: f64| if r.reference_flicker > 0.0 { format!("{:.2}", v / r.reference_flicker) } else { "-".into() };
        rows.push(vec![
            group(r),
            r.head.variant(),
            format!("{:.1}", r.time_ms),
            format!("{:.2}", r.jod),
            format!("{:.2}", r.jod_reflection),
            format!("{:.4}", r.flip),
            format!("{:.4}", r.rmse),
            over(r.flicker),
            over(r.change_error),
            format!("{:.4}", r.standard_error),
        ]);
    }
    rows
}

/// FLIP from frame to frame.
fn plot(records: &[VideoRecord]) -> std::result::Result<String, String> {
    let is_one = records.iter().all(|r| group(r) == group(&records[0]));
    let name = |r: &VideoRecord| {
        let of = if is_one { String::new() } else { format!(", r {}", roughness(r.head.roughness)) };
        r.head.variant() + &of
    };
    let line = |r: &VideoRecord| {
        let points = r.frames.iter().enumerate().map(|(n, f)| (n as f64, f.flip));
        Line { name: name(r), points: points.collect() }
    };
    plot::lines(&records.iter().map(line).collect::<Vec<_>>(), ["frame", "FLIP of the reflection colour"])
}

/// What the animated pictures of a measurement begin with.
fn stem(r: &VideoRecord) -> String {
    let h = &r.head;
    error_report::stem(&h.scene, &format!("{}-{}", h.view, r.way), [h.width, h.height], h.roughness)
}

/// A variant's name in a file's.
fn file_word(variant: &str) -> String {
    let word = |c: char| if c.is_ascii_alphanumeric() || c == '.' { c } else { '-' };
    variant.chars().map(word).collect::<String>().replace("---", "-")
}

/// Name of the world among the films.
const WORLD: &str = "world";

fn clip_file(r: &VideoRecord, name: &str) -> String {
    format!("{CLIPS}/{}-{}.webp", stem(r), file_word(name))
}

/// Writes the finished images of one measurement as animated pictures, which play on and on.
///
/// # Errors
/// Errors of the disk, and of images too large for the format.
pub fn write_clips(folder: &Path, records: &[VideoRecord], films: &Films) -> Result<()> {
    let Some(first) = records.first() else { return Ok(()) };
    let fps = first.frames_per_second;
    let made = records.iter().zip(&films.variants).map(|(r, film)| (clip_file(r, &r.head.variant()), film));
    for (name, film) in made.chain([(clip_file(first, WORLD), &films.world)]) {
        let path = folder.join(name);
        let bytes = animated(film, fps).map_err(|e| Error::io("encode", &path, std::io::Error::other(e)))?;
        files::write(&path, &bytes)?;
    }
    Ok(())
}

fn animated(film: &Film, frames_per_second: f32) -> std::result::Result<Vec<u8>, String> {
    let said = |e: webp_animation::Error| format!("{e:?}");
    let config = EncodingConfig::new_lossy(QUALITY);
    let options = EncoderOptions { encoding_config: Some(config), ..EncoderOptions::default() };
    let mut encoder = Encoder::new_with_options((film.width, film.height), options).map_err(said)?;
    let at = |n: usize| (1000.0 * n as f32 / frames_per_second).round() as i32;
    for (n, frame) in film.frames.iter().enumerate() {
        let rgba: Vec<u8> = frame.chunks_exact(3).flat_map(|c| [c[0], c[1], c[2], 255]).collect();
        encoder.add_frame(&rgba, at(n)).map_err(said)?;
    }
    Ok(encoder.finalize(at(film.frames.len())).map_err(said)?.to_vec())
}

const RULE: &str = "Each film is held against that of the world, frame by frame: FLIP and RMSE of the reflection colour as \
    means over the frames; the mean absolute change of a pixel from where its surface was a frame before, over that of the \
    world, and how far the change is off the world's, in the same unit; and the quality of the whole film in \
    just-objectionable differences (JOD), by ColorVideoVDP: 10 is the world, and of two films that are 1 apart 75 % of \
    people prefer the better.";

fn page(folder: &Path, records: &[VideoRecord], svg: &str, command: &str) -> String {
    let mut groups: Vec<(String, Vec<Clip>)> = Vec::new();
    for r in records {
        let world = || Clip { file: clip_file(r, WORLD), name: "the world".to_owned(), caption: String::new() };
        if groups.last().is_none_or(|(title, _)| *title != group(r)) {
            groups.push((group(r), vec![world()]));
        }
        let caption = format!("{:.2} JOD, {:.1} ms", r.jod, r.time_ms);
        let clip = Clip { file: clip_file(r, &r.head.variant()), name: r.head.variant(), caption };
        groups.iter_mut().rev().take(1).for_each(|(_, clips)| clips.push(clip.clone()));
    }
    // An interrupted run may lack the pictures of what it measured.
    for (_, clips) in &mut groups {
        clips.retain(|clip| folder.join(&clip.file).is_file());
    }
    html::clips_page(&ClipsPage {
        title: "Films",
        device: records.first().map(|r| &r.head.program.device),
        command,
        groups: &groups,
        rule: RULE,
        cells: &table(records),
        plot: svg,
    })
}

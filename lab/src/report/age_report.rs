//! Error over age as files and text: records, a row a frame, a table and a plot.

use super::files;
use super::plot::{self, Line};
use super::tables::{aligned, roughness};
use crate::error::{Error, Result};
use crate::study::Stats;
use crate::study::age::{AgeFrame, AgeRecord};
use std::path::Path;

/// Writes age.json, age-frames.csv, age.txt and age.svg.
pub fn write(folder: &Path, records: &[AgeRecord]) -> Result<()> {
    files::write(&folder.join("age.json"), files::json(records).as_bytes())?;
    files::write(&folder.join("age-frames.csv"), frames_csv(records).as_bytes())?;
    files::write(&folder.join("age.txt"), text(records).as_bytes())?;
    let svg = plot(records).map_err(|e| Error::io("draw the plot of", folder, std::io::Error::other(e)))?;
    files::write(&folder.join("age.svg"), svg.as_bytes())
}

/// One row a frame.
fn frames_csv(records: &[AgeRecord]) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let header = [
        "scene",
        "view",
        "method",
        "width",
        "height",
        "roughness",
        "faces_per_frame",
        "frame",
        "moved_m",
        "age_frames",
        "rmse",
        "touched",
        "touched_rmse",
        "standard_error",
        "effect_ms",
        "capture_ms",
    ];
    // Writing to memory can't fail; were it to, the file would be short, and its reader would see.
    let _ = writer.write_record(header);
    for r in records {
        let h = &r.head;
        for (n, f) in r.frames.iter().enumerate() {
            let place = [h.scene.clone(), h.view.clone(), h.method.clone()];
            let size = [h.width.to_string(), h.height.to_string(), roughness(h.roughness)];
            let counts = [r.faces_per_frame.to_string(), n.to_string(), f.moved_m.to_string()];
            let touched_rmse = f.touched_rmse.unwrap_or(f64::NAN);
            let figures = [f.age_frames, f.rmse, f.touched, touched_rmse, f.standard_error, f.effect_ms, f.capture_ms];
            let figures = figures.map(|v| if v.is_nan() { String::new() } else { format!("{v:.6}") });
            let _ = writer.write_record(place.iter().chain(&size).chain(&counts).chain(&figures));
        }
    }
    String::from_utf8(writer.into_inner().unwrap_or_default()).unwrap_or_default()
}

/// A row for each number of faces a frame: the error at the beginning and at the end, that of the pixels that something
/// moved for in the middle and at the end, and times.
pub fn text(records: &[AgeRecord]) -> String {
    let header = [
        "scene view",
        "size",
        "roughness",
        "method",
        "faces a frame",
        "rmse first",
        "last",
        "of touched, middle",
        "last",
        "touched %",
        "moved m",
        "age, frames",
        "effect ms median",
        "captures ms median",
    ];
    let mut rows = vec![header.map(str::to_owned).to_vec()];
    for r in records {
        let h = &r.head;
        let Some((first, last)) = r.frames.first().zip(r.frames.last()) else { continue };
        let middle = &r.frames[r.frames.len() / 2];
        let median = |of: fn(&AgeFrame) -> f64| Stats::of(&r.frames.iter().map(of).collect::<Vec<_>>()).median_ms;
        let mut row = vec![
            format!("{} {}", h.scene, h.view),
            format!("{}x{}", h.width, h.height),
            roughness(h.roughness),
            h.method_and_fallback(),
            format!("{} of {}", r.faces_per_frame, r.faces),
        ];
        row.extend([first, last].map(|f| format!("{:.4}", f.rmse)));
        row.extend([middle, last].map(|f| f.touched_rmse.map_or_else(|| "-".into(), |rmse| format!("{rmse:.4}"))));
        row.push(format!("{:.1}", 100.0 * last.touched));
        row.push(format!("{:.2}", last.moved_m));
        row.push(format!("{:.1}", last.age_frames));
        row.extend([median(|f| f.effect_ms), median(|f| f.capture_ms)].map(|ms| format!("{ms:.3}")));
        rows.push(row);
    }
    aligned(&rows)
}

/// The error of the pixels that something moved for over the frames, a line for each record.
pub fn plot(records: &[AgeRecord]) -> std::result::Result<String, String> {
    let has_several = |of: fn(&AgeRecord) -> String| records.iter().any(|r| of(r) != of(&records[0]));
    let [of_methods, of_roughness, of_sizes] = [
        has_several(|r| r.head.method_and_fallback()),
        has_several(|r| roughness(r.head.roughness)),
        has_several(|r| format!("{}x{}", r.head.width, r.head.height)),
    ];
    let name = |r: &AgeRecord| {
        let mut words = vec![format!("{} of {} faces", r.faces_per_frame, r.faces)];
        words.extend(of_methods.then(|| r.head.method_and_fallback()));
        words.extend(of_roughness.then(|| format!("r {}", roughness(r.head.roughness))));
        words.extend(of_sizes.then(|| format!("{} × {}", r.head.width, r.head.height)));
        words.join(", ")
    };
    let line = |r: &AgeRecord| {
        let points = r.frames.iter().enumerate().filter_map(|(n, f)| Some((n as f64, f.touched_rmse?)));
        Line { name: name(r), points: points.collect() }
    };
    let lines: Vec<Line> = records.iter().map(line).collect();
    plot::lines(&lines, ["frame", "RMSE of the pixels that something moved for"])
}

//! Frames per second along a path as CSV, text and a plot.

use super::plot::{self, Line};
use super::tables::{aligned, roughness};
use crate::study::path::PathRecord;

/// One row a frame.
pub fn frames_csv(records: &[PathRecord]) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let header = ["scene", "path", "method", "width", "height", "frame", "frame_ms", "effect_ms", "fps"];
    // Writing to memory can't fail; were it to, the file would be short, and its reader would see.
    let _ = writer.write_record(header);
    for r in records {
        let h = &r.head;
        for (n, f) in r.frames.iter().enumerate() {
            let [width, height, frame] = [h.width as usize, h.height as usize, n].map(|v| v.to_string());
            let [frame_ms, effect_ms, fps] = [f.frame_ms, f.effect_ms, f.fps].map(|v| format!("{v:.6}"));
            let place = [h.scene.clone(), h.view.clone(), h.method.clone()];
            let _ = writer.write_record(place.iter().chain(&[width, height, frame, frame_ms, effect_ms, fps]));
        }
    }
    String::from_utf8(writer.into_inner().unwrap_or_default()).unwrap_or_default()
}

/// Frames per second and times of each method.
pub fn text(records: &[PathRecord]) -> String {
    let header = [
        "scene path",
        "size",
        "roughness",
        "method",
        "frames",
        "fps median",
        "p95",
        "1 % low",
        "frame ms median",
        "p95",
        "effect ms median",
        "p95",
    ];
    let mut rows = vec![header.map(str::to_owned).to_vec()];
    for r in records {
        let h = &r.head;
        let mut row = vec![
            format!("{} {}", h.scene, h.view),
            format!("{}x{}", h.width, h.height),
            roughness(h.roughness),
            h.method.clone(),
            r.frames.len().to_string(),
        ];
        row.extend([r.fps.median, r.fps.p95, r.fps.low_1_percent].map(|v| format!("{v:.2}")));
        let ms = [r.frame.median_ms, r.frame.p95_ms, r.effect.median_ms, r.effect.p95_ms];
        row.extend(ms.map(|v| format!("{v:.3}")));
        rows.push(row);
    }
    aligned(&rows)
}

/// Frames per second over the frames, a line for each method and size.
pub fn plot(records: &[PathRecord]) -> Result<String, String> {
    let line = |r: &PathRecord| {
        let points = r.frames.iter().enumerate().map(|(n, f)| (n as f64, f.fps));
        Line { name: name(r, records), points: points.collect() }
    };
    let lines: Vec<Line> = records.iter().map(line).collect();
    plot::lines(&lines, ["frame along the path", "frames per second, whole frame on the device"])
}

/// The method, and its size where there are several.
fn name(record: &PathRecord, all: &[PathRecord]) -> String {
    let size = |r: &PathRecord| [r.head.width, r.head.height];
    if all.iter().all(|r| size(r) == size(record)) {
        return record.head.method.clone();
    }
    format!("{} {} × {}", record.head.method, record.head.width, record.head.height)
}

//! Frames per second along a path as CSV, text and a plot.

use super::plot::{STAGE_COLORS, TEXT, WIDTH};
use super::tables::{aligned, roughness};
use crate::study::path::PathRecord;
use plotters::prelude::*;

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
    let names: Vec<String> = records.iter().map(|r| name(r, records)).collect();
    let columns = legend_columns(&names);
    let legend = 16 + 20 * names.len().div_ceil(columns) as u32;
    let last = records.iter().map(|r| r.frames.len()).max().unwrap_or(0).saturating_sub(1).max(1);
    let most = records.iter().flat_map(|r| &r.frames).map(|f| f.fps).fold(1e-6, f64::max);
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, (WIDTH, 360 + legend)).into_drawing_area();
        let failed = |e: DrawingAreaErrorKind<std::io::Error>| e.to_string();
        root.fill(&WHITE).map_err(failed)?;
        let mut chart = ChartBuilder::on(&root)
            .margin(10)
            .margin_top(legend)
            .margin_right(24)
            .x_label_area_size(44)
            .y_label_area_size(60)
            .build_cartesian_2d(0.0..last as f64, 0.0..most * 1.05)
            .map_err(failed)?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .x_label_formatter(&|x| format!("{x:.0}"))
            .x_desc("frame along the path")
            .y_desc("frames per second, whole frame on the device")
            .label_style(("sans-serif", TEXT))
            .draw()
            .map_err(failed)?;
        for (n, (record, name)) in records.iter().zip(&names).enumerate() {
            let color = STAGE_COLORS[n % STAGE_COLORS.len()];
            let points = record.frames.iter().enumerate().map(|(i, f)| (i as f64, f.fps));
            chart.draw_series(LineSeries::new(points, color.stroke_width(2))).map_err(failed)?;
            let (x, y) = (12 + (n % columns) as i32 * legend_width(&names), 10 + 20 * (n / columns) as i32);
            root.draw(&Rectangle::new([(x, y), (x + 14, y + 14)], color.filled())).map_err(failed)?;
            root.draw(&Text::new(name.as_str(), (x + 19, y), ("sans-serif", TEXT))).map_err(failed)?;
        }
        root.present().map_err(failed)?;
    }
    Ok(svg)
}

/// The method, and its size where there are several.
fn name(record: &PathRecord, all: &[PathRecord]) -> String {
    let size = |r: &PathRecord| [r.head.width, r.head.height];
    if all.iter().all(|r| size(r) == size(record)) {
        return record.head.method.clone();
    }
    format!("{} {} × {}", record.head.method, record.head.width, record.head.height)
}

fn legend_width(names: &[String]) -> i32 {
    36 + 8 * names.iter().map(|n| n.chars().count()).max().unwrap_or(0) as i32
}

fn legend_columns(names: &[String]) -> usize {
    (((WIDTH - 20) as i32 / legend_width(names)) as usize).max(1)
}

//! Shows the times of recent frames as stacked bars, the work that the device counted in a frame, and the error against
//! a cached world reference.

use super::shared::{PanelData, header_row, heading};
use crate::history::{History, StageTime};
use crate::reference_error::ComparisonOutcome;
use crate::state::State;
use egui::{Color32, Grid, Rect, RichText, Sense, Stroke, Ui, pos2, vec2};
use ssct::passes::tiles::TILE;
use ssct_lab::study::inspect::Inspection;

/// Height of the bars, in points.
const BAR_HEIGHT: f32 = 110.0;

/// Draws this part of the panel: the times, the counted work and the error of the shown methods.
pub fn show(ui: &mut Ui, state: &State, data: &PanelData) {
    for (n, (history, side)) in data.histories.iter().zip(state.rendered()).enumerate() {
        heading(ui, format!("Time of {}", side.method.name));
        // Each table needs an id of its own; otherwise the two would overwrite each other's column widths.
        ui.push_id(n, |ui| draw_times(ui, history));
    }
    draw_work(ui, state, data);
    draw_errors(ui, state, data);
}

/// Returns the colour of stage `index` of a frame: grey if the stage is not `counted` towards the method's time.
fn stage_color(index: usize, counted: bool) -> Color32 {
    const HUES: [Color32; 8] = [
        Color32::from_rgb(86, 156, 214),
        Color32::from_rgb(220, 130, 60),
        Color32::from_rgb(106, 176, 106),
        Color32::from_rgb(206, 86, 100),
        Color32::from_rgb(160, 120, 200),
        Color32::from_rgb(200, 180, 70),
        Color32::from_rgb(80, 190, 190),
        Color32::from_rgb(210, 140, 180),
    ];
    if counted { HUES[index % HUES.len()] } else { Color32::from_gray(90 + 30 * (index % 3) as u8) }
}

/// Draws the bars of a method, and the table of its stages.
fn draw_times(ui: &mut Ui, history: &History) {
    let total = history.total();
    draw_bars(ui, history);
    ui.label(format!("{:.2} ms median, {:.2} ms p95 of {} frames", total.median_ms, total.p95_ms, total.samples));
    Grid::new("stages").num_columns(4).striped(true).show(ui, |ui| {
        header_row(ui, &["", "pass", "median ms", "p95 ms"]);
        for (i, (name, counted, stats)) in history.stages().iter().enumerate() {
            let (rect, _) = ui.allocate_exact_size(vec2(10.0, 10.0), Sense::hover());
            ui.painter().rect_filled(rect, 2.0, stage_color(i, *counted));
            let text = if *counted { RichText::new(name) } else { RichText::new(name).weak() };
            ui.label(text);
            ui.label(format!("{:.3}", stats.median_ms));
            ui.label(format!("{:.3}", stats.p95_ms));
            ui.end_row();
        }
    });
}

/// Draws a bar for each frame, the newest at the right. A bar is the stack of the times of the frame's stages, and the
/// line is the median of the method's time.
fn draw_bars(ui: &mut Ui, history: &History) {
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width() - 8.0, BAR_HEIGHT), Sense::hover());
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 3.0, Color32::from_gray(18));
    let total_ms = |stages: &[StageTime]| stages.iter().map(|s| s.ms).sum::<f64>();
    let highest_ms = history.frames().map(total_ms).fold(1e-3, f64::max) * 1.05;
    let frames: Vec<&[StageTime]> = history.frames().collect();
    let width = (rect.width() / frames.len().max(1) as f32).clamp(1.0, 12.0);
    let y_of = |ms: f64| rect.bottom() - (ms / highest_ms) as f32 * rect.height();
    for (n, stages) in frames.iter().rev().enumerate() {
        let right = rect.right() - n as f32 * width;
        if right < rect.left() {
            break;
        }
        let mut below = 0.0;
        // The method's passes are at the bottom, so that their sum can be read off.
        let bottom_to_top =
            (0..stages.len()).filter(|i| stages[*i].counted).chain((0..stages.len()).filter(|i| !stages[*i].counted));
        for i in bottom_to_top {
            let above = below + stages[i].ms;
            let bar = Rect::from_min_max(pos2(right - (width - 1.0).max(1.0), y_of(above)), pos2(right, y_of(below)));
            painter.rect_filled(bar, 0.0, stage_color(i, stages[i].counted));
            below = above;
        }
    }
    let median = y_of(history.total().median_ms);
    painter.hline(rect.x_range(), median, Stroke::new(1.0, Color32::WHITE));
    let font = egui::FontId::proportional(10.0);
    painter.text(
        rect.left_top() + vec2(4.0, 2.0),
        egui::Align2::LEFT_TOP,
        format!("{highest_ms:.1} ms"),
        font,
        Color32::GRAY,
    );
}

/// Draws the passes of each method, and the work that was counted in the first method's frame at rest.
fn draw_work(ui: &mut Ui, state: &State, data: &PanelData) {
    for (n, (history, side)) in data.histories.iter().zip(state.rendered()).enumerate() {
        heading(ui, format!("Passes of {}", side.method.name));
        ui.push_id(("passes", n), |ui| draw_passes(ui, history));
    }
    heading(ui, format!("Work of {}", state.sides[0].method.name));
    let Some(analysis) = data.analysis else {
        ui.label(RichText::new("counted when nothing moves").weak());
        return;
    };
    if let Some(inspection) = &analysis.inspection {
        let reflecting = inspection.reflecting();
        ui.label(format!("{reflecting} reflecting pixels of {}", inspection.gbuffer.depth.len()));
        Grid::new("rays").num_columns(3).striped(true).show(ui, |ui| {
            for (code, count) in inspection.ends() {
                ui.label(format!("{code:?}"));
                ui.label(count.to_string());
                ui.label(format!("{:.1} %", 100.0 * count as f64 / reflecting.max(1) as f64));
                ui.end_row();
            }
        });
        if inspection.is_unified {
            draw_classes(ui, inspection);
        }
    }
    if let Some(steps) = &analysis.steps {
        let traced: Vec<u32> = steps.iter().copied().filter(|n| *n > 0).collect();
        let mean = traced.iter().map(|n| f64::from(*n)).sum::<f64>() / traced.len().max(1) as f64;
        let most = traced.iter().max().copied().unwrap_or(0);
        ui.label(format!("steps of {} mirror rays: mean {mean:.1}, most {most}", traced.len()));
    }
    ui.collapsing("Invocations of each pass", |ui| {
        Grid::new("invocations").num_columns(3).striped(true).show(ui, |ui| {
            header_row(ui, &["pass", "fragment", "compute"]);
            for (name, work) in &analysis.work {
                ui.label(name);
                ui.label(work.fragment_invocations.to_string());
                ui.label(work.compute_invocations.to_string());
                ui.end_row();
            }
        });
    });
}

/// Draws two tables about `unified`: the pixels and rays of each kind of lobe, and the numbers of tiles with each kind
/// of reflector.
fn draw_classes(ui: &mut Ui, inspection: &Inspection) {
    let (lobes, tiles) = (inspection.pixels(), inspection.tiles());
    ui.label(format!("{} rays:", lobes.rays()));
    Grid::new("classes").num_columns(3).striped(true).show(ui, |ui| {
        header_row(ui, &["lobe", "pixels", "rays"]);
        for (name, pixels, rays) in [
            ("mirrors", lobes.mirrors, lobes.mirrors),
            ("narrow", lobes.narrow, lobes.narrow),
            ("wide", lobes.wide, lobes.wide_cells),
        ] {
            ui.label(name);
            ui.label(pixels.to_string());
            ui.label(rays.to_string());
            ui.end_row();
        }
    });
    ui.label(format!("tiles of {TILE} × {TILE}:"));
    Grid::new("tiles").num_columns(4).striped(true).show(ui, |ui| {
        header_row(ui, &["mirrors", "glossy", "both", "neither"]);
        for count in [tiles.mirrors, tiles.glossy, tiles.both, tiles.empty] {
            ui.label(count.to_string());
        }
        ui.end_row();
    });
}

/// Lists the passes that the last frame recorded, and those that it skipped, with the reasons.
fn draw_passes(ui: &mut Ui, history: &History) {
    ui.collapsing(format!("{} recorded", history.recorded.len()), |ui| ui.label(history.recorded.join(", ")));
    ui.label(format!("{} skipped", history.skipped.len()));
    for skipped in &history.skipped {
        ui.label(RichText::new(format!("{}: {}", skipped.pass, skipped.why)).weak());
    }
}

/// Draws the errors of the shown methods against the world reference, or the command that makes this reference if it is
/// missing.
fn draw_errors(ui: &mut Ui, state: &State, data: &PanelData) {
    heading(ui, "Error against the world reference");
    match &data.reference_error.outcome {
        Some(ComparisonOutcome::Errors { samples, standard_error, methods }) => {
            ui.label(format!("{samples} rays a pixel, own standard error {standard_error:.4}"));
            Grid::new("errors").num_columns(4).striped(true).show(ui, |ui| {
                header_row(ui, &["", "RMSE", "relative MSE", "FLIP"]);
                for (side, errors) in state.rendered().iter().zip(methods) {
                    ui.label(side.method.name);
                    ui.label(format!("{:.4}", errors.rmse));
                    ui.label(errors.relative_mse.map_or("–".into(), |v| format!("{v:.4}")));
                    ui.label(format!("{:.4}", errors.flip));
                    ui.end_row();
                }
            });
        }
        Some(ComparisonOutcome::NoReference) => {
            ui.label("none is kept of this view, size and these materials; this makes one:");
            ui.label(RichText::new(data.reference_command).monospace().small());
        }
        None if data.reference_error.is_waiting() => drop(ui.label(RichText::new("looking for one …").weak())),
        None => drop(ui.label(RichText::new("looked for when nothing moves").weak())),
    }
}

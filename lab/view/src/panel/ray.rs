//! Shows the picked ray on its walk through the Hi-Z chain, cell by cell (the thesis's figure 4.6, live), and the
//! result of the oracle for the same ray.

use super::shared::{PanelData, header_row, heading};
use crate::cubes::Cross;
use crate::state::State;
use egui::{Color32, Grid, Painter, Pos2, Rect, RichText, Stroke, StrokeKind, Ui, pos2};
use glam::Vec2;
use ssct::passes::PathCode;
use ssct_lab::report::pixel::lines;
use ssct_lab::study::inspect::{PickedRay, RayInWorld, WalkEnd};
use ssct_lab::study::pixel::PixelReport;
use ssct_scenes::Capture;
use ssct_truth::reference::Outcome;

/// The colour of the method's hit.
const METHOD_COLOR: Color32 = Color32::from_rgb(255, 140, 0);
/// The colour of the walk that is computed on the CPU.
const WALK_COLOR: Color32 = Color32::from_rgb(255, 230, 60);
/// The colour of the part of the ray that the screen does not see.
const BEYOND_COLOR: Color32 = Color32::from_rgb(255, 90, 200);
/// The colour of the oracle's hit.
const ORACLE_COLOR: Color32 = Color32::from_rgb(60, 230, 255);

/// Returns the colour of a mip level: from green for fine levels to red for coarse ones.
fn level_color(level: u32) -> Color32 {
    let share = (level as f32 / 7.0).min(1.0);
    Color32::from_rgb((90.0 + 165.0 * share) as u8, (220.0 - 150.0 * share) as u8, 120)
}

/// Draws this part of the panel: the picked pixel, its explanation, and the ends and steps of its ray.
pub fn show(ui: &mut Ui, state: &mut State, data: &PanelData) {
    ui.label("Click into the picture to pick a pixel's mirror ray.");
    // Before the first frame, the image's size is unknown.
    if let (Some([x, y]), false) = (&mut state.picked, data.images.is_empty()) {
        ui.horizontal(|ui| {
            ui.label("pixel");
            ui.add(egui::DragValue::new(x).range(0..=data.extent[0].saturating_sub(1)));
            ui.add(egui::DragValue::new(y).range(0..=data.extent[1].saturating_sub(1)));
        });
    }
    let Some(ray) = data.ray else {
        if state.picked.is_some() {
            ui.label(RichText::new("traced when nothing moves").weak());
        }
        return;
    };
    if let Some(report) = data.pixel {
        draw_explanation(ui, report);
    }
    draw_ends(ui, state, ray);
    if let Some(walk) = &ray.walk {
        heading(ui, format!("{} steps through the Hi-Z", walk.cells.len()));
        Grid::new("steps").num_columns(5).striped(true).show(ui, |ui| {
            header_row(ui, &["", "level", "cell", "nearest", "ray"]);
            for (n, cell) in walk.cells.iter().enumerate() {
                ui.label((n + 1).to_string());
                let arrow = if cell.crossed { "⬆" } else { "⬇" };
                ui.colored_label(level_color(cell.level), format!("{} {arrow}", cell.level));
                ui.label(format!("{}, {}", cell.place.x, cell.place.y));
                ui.label(format!("{:.6}", cell.nearest));
                ui.label(format!("{:.6}", cell.ray));
                ui.end_row();
            }
        });
        ui.label(RichText::new("⬇ met what the cell holds, ⬆ left the cell").weak().small());
        ui.label(RichText::new(walk.depth).weak().small());
    }
}

/// Draws the explanation of the pixel and its data, as `ssct render --pixel` prints them.
fn draw_explanation(ui: &mut Ui, report: &PixelReport) {
    heading(ui, report.verdict.name());
    for sentence in &report.why {
        ui.label(sentence);
    }
    heading(ui, "What is known of it");
    for (name, text) in lines(report) {
        ui.horizontal_wrapped(|ui| {
            ui.label(RichText::new(name).weak());
            ui.label(text);
        });
    }
}

/// Lists where the ray ends according to the method, its twin and the oracle.
fn draw_ends(ui: &mut Ui, state: &State, ray: &PickedRay) {
    heading(ui, "Where it ends");
    let describe_place = |x: f64, y: f64| format!("at {x:.1}, {y:.1}");
    let oracle = ray.oracle.position();
    // A text about the distance of a hit from the oracle's, if there is one.
    let distance_to_oracle =
        |x: f64, y: f64| oracle.map_or(String::new(), |o| format!(", {:.1} px off", (o.x - x).hypot(o.y - y)));
    Grid::new("ends").num_columns(2).show(ui, |ui| {
        ui.colored_label(METHOD_COLOR, state.sides[0].method.name);
        match ray.method {
            Some((code, [x, y])) if code.is_hit() => {
                let (x, y) = (f64::from(x), f64::from(y));
                ui.label(format!("{code:?} {}{}", describe_place(x, y), distance_to_oracle(x, y)))
            }
            Some((code, _)) => match &ray.in_world {
                Some(lost_ray) => ui.label(describe_end_beyond_screen(lost_ray)),
                None => ui.label(format!("{code:?}: no hit")),
            },
            None => ui.label("does not tell its hits"),
        };
        ui.end_row();
        ui.colored_label(ORACLE_COLOR, "oracle");
        match ray.oracle.outcome {
            Outcome::Hit { position, .. } => {
                ui.label(format!("hit {}, after {} pixels", describe_place(position.x, position.y), ray.oracle.steps))
            }
            Outcome::Miss { reason, behind } => {
                let behind = if behind { ", behind a surface" } else { "" };
                ui.label(format!("no hit: {reason:?}{behind}, after {} pixels", ray.oracle.steps))
            }
        };
        ui.end_row();
        if let Some(walk) = &ray.walk {
            ui.colored_label(WALK_COLOR, "Hi-Z");
            let (steps, end) = (walk.cells.len(), walk.last().as_dvec2());
            ui.label(match walk.end {
                WalkEnd::Hit => format!("met level 0 {}, after {steps} steps", describe_place(end.x, end.y)),
                WalkEnd::Left => format!("left the screen after {steps} steps"),
                WalkEnd::Behind => format!("met a block from behind after {steps} steps"),
                WalkEnd::Exhausted => format!("out of iterations after {steps} steps"),
            });
            ui.end_row();
        }
    });
}

/// Returns a text about the end of a ray that the screen lost.
fn describe_end_beyond_screen(ray: &RayInWorld) -> String {
    let (code, end) = (ray.code, ray.end);
    let capture_number = ray.capture.map_or_else(String::new, |k| format!(" {}", k + 1));
    match code {
        PathCode::Capture | PathCode::Triangle => {
            let distance_m = ray.begin.distance(end);
            format!("{code:?}{capture_number}: hit at {:.2}, {:.2}, {:.2}, {distance_m:.2} m away", end.x, end.y, end.z)
        }
        PathCode::Sky => format!("{code:?}: nothing stands in its way"),
        _ => format!("{code:?}: no image sees where it goes"),
    }
}

/// Draws the ray over the images of a capture, which are shown in a picture of `extent` pixels in `area`. The part
/// after the place at which the screen lost the ray has another colour.
pub fn draw_in_capture(painter: &Painter, area: Rect, extent: [u32; 2], (ray, capture): (&PickedRay, &Capture)) {
    let Some(ray) = &ray.in_world else { return };
    let cross = Cross::new(extent);
    let scale = egui::vec2(area.width() / extent[0] as f32, area.height() / extent[1] as f32);
    let screen_point = |p: Vec2| area.min + egui::vec2(p.x, p.y) * scale;
    let points = ray.points();
    // The first half of the points is on the screen, and the second half beyond it.
    let (before, after) = points.split_at(points.len() / 2);
    for (points, stroke) in [(before, Stroke::new(1.0, WALK_COLOR)), (after, Stroke::new(2.0, BEYOND_COLOR))] {
        for line in cross.polylines(capture, points) {
            painter.line(line.into_iter().map(screen_point).collect(), stroke);
        }
    }
    painter.circle_stroke(
        screen_point(cross.face_and_point(ray.begin - capture.position).1),
        5.0,
        Stroke::new(2.0, Color32::WHITE),
    );
    // The mark shows the direction of the ray's end, even if this capture does not see the end.
    if ray.code != PathCode::Unknown {
        draw_mark(painter, screen_point(cross.face_and_point(ray.end - capture.position).1), METHOD_COLOR);
    }
}

/// Draws the ray over the picture of the screen, which has `extent` pixels and is shown in `area`.
pub fn draw(painter: &Painter, area: Rect, extent: [u32; 2], ray: &PickedRay) {
    let scale = egui::vec2(area.width() / extent[0] as f32, area.height() / extent[1] as f32);
    let screen_point = |x: f32, y: f32| area.min + egui::vec2(x, y) * scale;
    let start = screen_point(ray.pixel[0] as f32 + 0.5, ray.pixel[1] as f32 + 0.5);
    if let Some(segment) = &ray.segment {
        let end = segment.point_at(1.0);
        painter.line_segment(
            [start, screen_point(end.x as f32, end.y as f32)],
            Stroke::new(1.0, Color32::from_white_alpha(120)),
        );
    }
    if let Some(walk) = &ray.walk {
        for cell in &walk.cells {
            let [low, high] = cell.corners.map(|corner| screen_point(corner.x, corner.y));
            let stroke = Stroke::new(1.0, level_color(cell.level));
            painter.rect_stroke(Rect::from_min_max(low, high), 0.0, stroke, StrokeKind::Inside);
        }
        for step in walk.positions.windows(2) {
            let [from, to] = [step[0], step[1]].map(|p| screen_point(p.x, p.y));
            painter.line_segment([from, to], Stroke::new(2.0, WALK_COLOR));
            painter.circle_filled(to, 2.0, WALK_COLOR);
        }
    }
    if let Some(line) = &ray.beyond_on_screen {
        painter.line(line.iter().map(|p| screen_point(p.x, p.y)).collect(), Stroke::new(2.0, BEYOND_COLOR));
    }
    painter.circle_stroke(start, 5.0, Stroke::new(2.0, Color32::WHITE));
    if let Some((_, [x, y])) = ray.method.filter(|(code, _)| code.is_hit()) {
        draw_mark(painter, screen_point(x, y), METHOD_COLOR);
    }
    if let Some(hit) = ray.oracle.position() {
        let centre = screen_point(hit.x as f32, hit.y as f32);
        painter.circle_stroke(centre, 7.0, Stroke::new(2.0, ORACLE_COLOR));
    }
}

/// Draws a small cross at a point.
fn draw_mark(painter: &Painter, centre: Pos2, color: Color32) {
    for (dx, dy) in [(6.0, 6.0), (6.0, -6.0)] {
        painter.line_segment(
            [pos2(centre.x - dx, centre.y - dy), pos2(centre.x + dx, centre.y + dy)],
            Stroke::new(2.0, color),
        );
    }
}

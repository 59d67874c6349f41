//! The panel beside the picture, and the marks and names over the picture. The panel uses egui to change the state and
//! to display measurements. It renders no frames itself and does not depend on the window.

mod captures;
mod inside;
mod live;
pub mod options;
mod path;
mod ray;
mod shaders;
mod shared;
mod tune;

use super::captures::CaptureEditor;
use super::cubes::CubeImage;
use super::path::PathEditor;
use super::state::{State, Tab};
use egui::{Color32, Rect, RichText, Sense, Ui};
use glam::Vec2;
use shared::dot;
pub use shared::{PanelActions, PanelData};
use ssct::passes::look::Compare;

/// Width of the panel, in points.
pub const WIDTH: f32 = 340.0;
/// The least width of the picture beside the panel, in points; a narrower window shows no panel.
const NARROWEST_PICTURE: f32 = 80.0;

/// Lays out the panel, and the marks and names over the picture. Returns the user's actions that are more than a change
/// of the state.
pub fn show(
    ui: &mut Ui,
    state: &mut State,
    (path, editor): (&mut PathEditor, &mut CaptureEditor),
    data: &PanelData,
) -> PanelActions {
    let mut actions = PanelActions::default();
    let width = ui.available_width();
    if state.tab != Tab::None && width >= WIDTH + NARROWEST_PICTURE {
        egui::Panel::right("panel").exact_size(WIDTH).show(ui, |ui| {
            egui::Panel::bottom("status").show(ui, |ui| draw_status(ui, data));
            ui.horizontal_wrapped(|ui| {
                for (tab, title) in Tab::SHOWN {
                    ui.selectable_value(&mut state.tab, tab, title);
                }
            });
            ui.separator();
            egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| match state.tab {
                Tab::Tune => tune::show(ui, state, data),
                Tab::Live => live::show(ui, state, data),
                Tab::Inside => inside::show(ui, state, data, &mut actions),
                Tab::Ray => ray::show(ui, state, data),
                Tab::Path => path::show(ui, state, path),
                Tab::Captures => captures::show(ui, state, editor, data, &mut actions),
                Tab::Shaders => shaders::show(ui, data),
                Tab::None => {}
            });
        });
    }
    let area = ui.available_rect_before_wrap();
    // The place of the line between two methods, before the mouse moves the line.
    let split_x = split_x(area, state);
    handle_mouse(ui, area, state, data, &mut actions);
    draw_over_picture(ui, area, split_x, state, data);
    actions.area = Some(area);
    actions
}

/// Returns the place, in points, of the line between two methods in a picture whose rectangle in points is `area`.
fn split_x(area: Rect, state: &State) -> f32 {
    area.left() + state.split * area.width()
}

/// Handles the mouse on the picture, which turns the camera, moves the line between two methods, picks a ray or changes
/// the speed. `area` is the picture's rectangle in points.
fn handle_mouse(ui: &mut Ui, area: Rect, state: &mut State, data: &PanelData, actions: &mut PanelActions) {
    let split_x = split_x(area, state);
    let response = ui.allocate_rect(area, Sense::click_and_drag());
    if state.compare == Compare::Split {
        let handle = Rect::from_x_y_ranges(split_x - 6.0..=split_x + 6.0, area.y_range());
        let handle = ui.interact(handle, ui.id().with("split"), Sense::drag());
        if handle.hovered() || handle.dragged() {
            ui.ctx().set_cursor_icon(egui::CursorIcon::ResizeHorizontal);
        }
        if let (true, Some(pointer)) = (handle.dragged(), handle.interact_pointer_pos()) {
            state.split = ((pointer.x - area.left()) / area.width()).clamp(0.0, 1.0);
        }
    }
    if response.dragged() {
        actions.looking = true;
        // While the cursor is held in place, only the motion of the mouse itself is reported.
        let drag = response.drag_delta() * ui.pixels_per_point();
        let turned = ui.input(|i| i.pointer.motion()).unwrap_or(drag);
        if turned != egui::Vec2::ZERO {
            state.camera.turn(Vec2::new(turned.x, turned.y));
            state.moved = true;
        }
    }
    if let (true, Tab::Ray, Some(pointer)) = (response.clicked(), state.tab, response.interact_pointer_pos()) {
        state.picked = Some(pixel_at(area, data.extent, pointer));
    }
    if response.hovered() {
        let wheel_notches: f32 = ui.input(|i| i.events.iter().filter_map(notches).sum());
        if wheel_notches != 0.0 {
            state.camera.change_speed(wheel_notches);
        }
    }
}

/// Draws the picked ray and the names of the methods over the picture, whose rectangle in points is `area`.
fn draw_over_picture(ui: &Ui, area: Rect, split_x: f32, state: &State, data: &PanelData) {
    if let (Tab::Ray, Some(ray)) = (state.tab, data.ray) {
        let painter = ui.painter_at(area);
        let shown_capture = state.inside.as_ref().and_then(|i| CubeImage::find(&i.name));
        match shown_capture {
            None => ray::draw(&painter, area, data.extent, ray),
            Some(cube) => {
                if let Some(capture) = data.captures.get(cube.capture) {
                    ray::draw_in_capture(&painter, area, data.extent, (ray, capture));
                }
            }
        }
    }
    if state.compare != Compare::One && state.tab != Tab::None {
        draw_method_names(ui, area, split_x, state);
    }
}

/// Writes the names of the methods over their parts of the picture.
fn draw_method_names(ui: &Ui, area: Rect, split_x: f32, state: &State) {
    let painter = ui.painter_at(area);
    let draw_name = |anchor: egui::Pos2, align: egui::Align2, text: &str| {
        let galley = painter.layout_no_wrap(text.to_owned(), egui::FontId::proportional(14.0), Color32::WHITE);
        let rect = align.anchor_size(anchor, galley.size());
        painter.rect_filled(rect.expand(4.0), 3.0, Color32::from_black_alpha(180));
        painter.galley(rect.min, galley, Color32::WHITE);
    };
    let [first, second] = [0, 1].map(|i| state.sides[i].method.name);
    let y = area.top() + 10.0;
    if state.compare == Compare::Split {
        draw_name(egui::pos2(split_x - 10.0, y), egui::Align2::RIGHT_TOP, first);
        draw_name(egui::pos2(split_x + 10.0, y), egui::Align2::LEFT_TOP, second);
    } else {
        let difference = format!("|{first} − {second}| × {:.1}", state.gain);
        draw_name(egui::pos2(area.center().x, y), egui::Align2::CENTER_TOP, &difference);
    }
}

/// Returns the notches by which an event turns the mouse wheel; `None` for any other event. 50 points of a smooth wheel
/// are one notch.
fn notches(event: &egui::Event) -> Option<f32> {
    match event {
        egui::Event::MouseWheel { unit: egui::MouseWheelUnit::Line, delta, .. } => Some(delta.y),
        egui::Event::MouseWheel { delta, .. } => Some(delta.y / 50.0),
        _ => None,
    }
}

/// Returns the pixel, in a picture of `extent` pixels, at a point of the window; `area` is the picture's rectangle in
/// points.
fn pixel_at(area: Rect, extent: [u32; 2], point: egui::Pos2) -> [u32; 2] {
    let share = (point - area.min) / area.size();
    [0, 1].map(|i| ((share[i] * extent[i] as f32).max(0.0) as u32).min(extent[i].saturating_sub(1)))
}

/// Draws the last lines of the panel, which are always shown: whether frames are rendered, and how many were.
fn draw_status(ui: &mut Ui, data: &PanelData) {
    let [frames, drawings, submissions] = data.counts;
    let total = data.histories.first().map(|h| h.total());
    ui.horizontal(|ui| {
        let (text, color) = if data.idle {
            ("idle: nothing to render", Color32::from_rgb(110, 190, 120))
        } else {
            ("rendering", Color32::from_rgb(230, 170, 60))
        };
        dot(ui, color);
        ui.colored_label(color, text);
        if let Some(t) = total.filter(|t| t.samples > 0) {
            ui.label(format!("{:.2} ms", t.median_ms));
        }
    });
    ui.label(RichText::new(format!("{frames} frames, {drawings} drawings, {submissions} submissions")).weak().small());
}

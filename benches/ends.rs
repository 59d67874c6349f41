//! Measures where the rays of `unified` with captures end wrongly in the world, and what that adds to its error. Prints
//! a table in CSV to standard output.
//!
//! All views of a scene are drawn with mirrors at 480×270, and with four captures that the program places. A row is
//! about the pixels of one kind in one view. `share` is their number over that of all pixels that reflect, and
//! `of_error` their part of the summed squared error against the world reference (32 rays a pixel). Three columns say
//! which kind it is:
//!
//! - `method`: where the method ended the ray: on the `screen`, in a `capture`, in the `sky`, or where no image sees it
//!   (`unknown`); `none` is a pixel that is seen from below its normal;
//! - `end`: `right` by place agreement; else `near` (off by less than a tenth of the ray's length), `before` the true
//!   end or `behind` it; `other` if one of the two ends is no place;
//! - `truth`: what shows the ray's true end: `beside`, if the ray is no longer than two pixels are high where it
//!   begins, which the screen cannot tell apart; else `screen`, `capture`, `sky`, or nothing (`hidden`).
//!
//! Usage: `cargo bench --bench ends [-- SCENE…]`, with names of built-in scenes or files, relative ones from `lab/`.

#![allow(clippy::expect_used)]

use glam::DVec3;
use ssct::gpu::{DeviceQuery, Gpu};
use ssct::methods::setup::{CaptureCount, EffectParams};
use ssct::methods::{Setup, Wants, unified};
use ssct::passes::PathCode;
use ssct_geometry::placement::sees;
use ssct_geometry::triangles::Triangles;
use ssct_lab::stage::{Globals, Shot, Stage, gbuffer};
use ssct_scenes::{Scene, View, library};
use ssct_truth::metrics::place::{RayEnd, is_right};
use ssct_truth::reference::first_hits::{FirstHits, Receiver};
use ssct_truth::reference::surface::World;
use ssct_truth::reference::world::WorldReference;
use ssct_truth::reference::world_hits::{WorldHit, world_hits};
use std::collections::BTreeMap;

/// Width and height of the frames in pixels.
const SIZE: [u32; 2] = [480, 270];
/// Rays a pixel of the reference.
const RAYS: u32 = 32;

/// A kind of pixels, by the three columns `method`, `end` and `truth`.
type Kind = [&'static str; 3];

/// The data of a view that decide the kind of a pixel.
struct ViewData<'a> {
    triangles: &'a Triangles<'a>,
    /// The places of the captures.
    captures: Vec<DVec3>,
    /// The place of the camera.
    eye: DVec3,
    /// Height in metres that one pixel covers at a distance of 1 m.
    pixel_at_1_m: f64,
}

impl ViewData<'_> {
    /// Returns the kind of a pixel whose ray begins at `receiver`, by the ray's end in the world (`truth`), and by the
    /// method's path code and end. `None` if the pixel has no ray.
    fn kind(&self, receiver: &Receiver, truth: &WorldHit, code: PathCode, end: &RayEnd) -> Option<Kind> {
        let method = match (code, end) {
            (PathCode::HiZ, _) => "screen",
            (_, RayEnd::Place(_)) => "capture",
            (_, RayEnd::Sky) => "sky",
            (PathCode::None, _) => "none",
            _ => "unknown",
        };
        let is_right = is_right(truth, end)?;
        let WorldHit::Hit { position, length_m, visible, .. } = truth else {
            return Some([method, if is_right { "right" } else { "other" }, "sky"]);
        };
        let end = match end {
            _ if is_right => "right",
            RayEnd::Place(place) if place.distance(*position) < 0.1 * length_m => "near",
            RayEnd::Place(place) if place.distance(receiver.position) < *length_m => "before",
            RayEnd::Place(_) => "behind",
            _ => "other",
        };
        let truth = if *length_m <= 2.0 * self.pixel_at_1_m * self.eye.distance(receiver.position) {
            "beside"
        } else if *visible {
            "screen"
        } else if self.captures.iter().any(|place| sees(self.triangles, *place, *position)) {
            "capture"
        } else {
            "hidden"
        };
        Some([method, end, truth])
    }
}

/// Draws a view, and prints a row for each kind of pixels.
fn print_view(scene: &Scene, view: &View, stage: &mut Stage) {
    let materials = Globals { roughness: Some(0.0), ..Globals::default() }.materials(scene, view);
    let setup = Setup::new(SIZE).with(|p: &mut EffectParams| p.captures = CaptureCount::Number(4));
    let shot = Shot::new(stage, &unified::INFO, &setup, Wants::HITS, view.camera(scene, SIZE), materials.clone())
        .expect("a shot");
    let (_, _, output) = stage.output(&shot).expect("a frame");
    let color = gbuffer::reflection(&mut stage.context, &output).expect("the reflection");
    let hits = output.traced.hits.expect("hits of a trace that is a pass of its own");
    let hits = stage.context.read(hits.0.all()).expect("the hits");
    let data = gbuffer::read(&mut stage.context, &shot).expect("the G-buffer");
    let ends = gbuffer::ray_ends(&hits, &data);
    let codes = hits.texels().map(|texel| PathCode::from_channel(texel[3]).unwrap_or(PathCode::None));

    let (world, triangles) = (World::new(scene, &materials), Triangles::new(scene, &materials));
    let first_hits = FirstHits::shown(&world, &data);
    let reference = WorldReference::new(&world, &first_hits, &data.camera, 2);
    let mut state = reference.start();
    reference.add(&mut state, RAYS);
    let true_color = reference.image(&state).reflection;
    let captures = shot.captures().expect("captures").1.iter().map(|c| c.position.as_dvec3()).collect();
    // The vertical scale of the projection is 1 over the tangent of half the angle of view.
    let pixel_at_1_m = 2.0 / (f64::from(data.camera.view_to_clip().y_axis.y.abs()) * f64::from(SIZE[1]));
    let view_data = ViewData { triangles: &triangles, captures, eye: data.camera.eye().as_dvec3(), pixel_at_1_m };

    // The number of pixels of each kind, and the sum of their squared errors.
    let mut sums_of_kinds: BTreeMap<Kind, (u32, f64)> = BTreeMap::new();
    let (mut pixel_count, mut error_sum) = (0, 0.0);
    for (i, (hit, code)) in world_hits(&world, &data, &first_hits).iter().zip(codes).enumerate() {
        let Some(receiver) = &first_hits.receivers[i] else { continue };
        let Some(kind) = view_data.kind(receiver, hit, code, &ends[i]) else { continue };
        let squared_error =
            |channel: usize| f64::from(color.values[i * color.channels + channel] - true_color[i][channel]).powi(2);
        let error = (0..3).map(|channel| squared_error(channel) / 3.0).sum::<f64>();
        let (pixels, errors) = sums_of_kinds.entry(kind).or_default();
        (*pixels, *errors) = (*pixels + 1, *errors + error);
        (pixel_count, error_sum) = (pixel_count + 1, error_sum + error);
    }
    for ([method, end, truth], (pixels, error)) in sums_of_kinds {
        let (share, of_error) = (f64::from(pixels) / f64::from(pixel_count.max(1)), error / error_sum);
        println!("{},{},{method},{end},{truth},{share:.5},{of_error:.5}", scene.name, view.name);
    }
}

/// Prints the rows of the scenes that the command line names, or of all built-in scenes.
fn main() {
    let mut names: Vec<_> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    if names.is_empty() {
        names = library::names().iter().map(|n| n.to_string()).collect();
    }
    let gpu = Gpu::open(&DeviceQuery::default()).expect("a Vulkan device");
    println!("# {} ({}), ssct {}", gpu.info().name, gpu.info().driver, env!("CARGO_PKG_VERSION"));
    println!("scene,view,method,end,truth,share,of_error");
    for name in names {
        let scene = library::scene_or_file(&name).expect("a built-in scene or a file of one");
        let mut stage = Stage::new(&gpu, &scene).expect("device memory");
        scene.views.iter().for_each(|view| print_view(&scene, view, &mut stage));
    }
}

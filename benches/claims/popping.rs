//! Measures how much the picture jumps when a method switches to another cube map (thesis §3.1.3), on walks of half a
//! metre past every place that is equally far from two of the maps.
//!
//! Columns: claim, method, scene, variant, and then `value`, the greatest change from one frame to the next over the
//! median change. `past` names the walk with the greatest change, by the numbers of its two maps in the scene's order.
//!
//! - `one`: only the map that was captured nearest to the camera counts.
//! - `pixels`: the two nearest maps count, weighed by the distances of each pixel, as the methods do it.
//! - `camera`: the two nearest maps count, weighed for all pixels by the distances of the camera.
//! - `none`: the method `traced`, which has no maps, shows how much the scene itself changes.

use super::edited::{Edits, difference};
use super::{Bench, globals, method, scene};
use glam::Vec3;
use ssct::methods::{Setup, Wants};
use ssct_lab::report::images::{Rgb, display};
use ssct_lab::stage::{Shot, Stage, gbuffer};
use ssct_scenes::{Scene, View};

/// Width and height of the frames in pixels.
const SIZE: [u32; 2] = [320, 180];
/// Metres from one frame to the next: 1.4 m/s at 60 frames a second.
const STEP_M: f32 = 1.4 / 60.0;
/// Frames of a walk before its middle, and as many after it.
const HALF_WALK: i32 = 11;
/// Roughness of all surfaces.
const ROUGHNESS: f32 = 0.1;
/// The shader of both methods with cube maps, and the lines of it that variants change.
const SHADER: &str = "schmidt/pccm.frag";
const WEIGHT_LINE: &str = "float second = distances[0] * distances[0] / max(dot(distances, distances), 1e-12);";
const DISTANCE_LINE: &str = "distances[k] = distance(pixel.position, map.position.xyz);";
const BOX_LINE: &str = "if (inside[0] != inside[1]) {";
/// Ignores the boxes of the maps, so that distances alone decide which map counts.
const WITHOUT_BOXES: (&str, &str, &str) = (SHADER, BOX_LINE, "if (false) {");
const NEAREST_MAP: Edits = &[WITHOUT_BOXES, (SHADER, WEIGHT_LINE, "float second = 0.0;")];
const CAMERA_WEIGHTS: Edits = &[
    WITHOUT_BOXES,
    (SHADER, DISTANCE_LINE, "distances[k] = distance(camera.view_to_world[3].xyz, map.position.xyz);"),
];
const VARIANTS: [(&str, Edits); 3] = [("one", NEAREST_MAP), ("pixels", &[]), ("camera", CAMERA_WEIGHTS)];

/// Returns a walk past the middle between each two maps: the numbers of the maps in the scene's order, as `a-b`, and
/// the views of the walk, which look ahead and a little down.
fn walks(scene: &Scene) -> Vec<(String, Vec<View>)> {
    let places: Vec<Vec3> = scene.probes.iter().map(|probe| probe.position).collect();
    let ahead = (places[places.len() - 1] - places[0]).normalize();
    let view_from = |eye| View { eye, look_at: eye + ahead + Vec3::NEG_Y * 0.2, ..scene.views[0].clone() };
    let walk_past_middle = |a: usize, b: usize| {
        let middle = 0.5 * (places[a] + places[b]);
        // The frames stand beside the middle and never on it.
        let views = (-HALF_WALK..HALF_WALK).map(|step| view_from(middle + (step as f32 + 0.5) * STEP_M * ahead));
        (format!("{a}-{b}"), views.collect())
    };
    (0..places.len()).flat_map(|a| (a + 1..places.len()).map(move |b| walk_past_middle(a, b))).collect()
}

/// Draws the reflections of the method `name` along a walk, with edited shaders. Returns a display image for each view.
fn draw(bench: &Bench, stage: &mut Stage, name: &str, edits: Edits, (scene, walk): (&Scene, &[View])) -> Vec<Rgb> {
    let materials = globals(ROUGHNESS, 0.1).materials(scene, &walk[0]);
    let camera = |view: &View| view.camera(scene, SIZE);
    let mut shot = bench.shaders.run_with(&bench.gpu, edits, || {
        let setup = Setup::new(SIZE);
        Shot::new(stage, method(name), &setup, Wants::REFLECTION, camera(&walk[0]), materials).expect("a shot")
    });
    let draw_view = |view: &View| {
        shot.camera = camera(view);
        let (.., output) = stage.output(&shot).expect("a frame");
        display(&gbuffer::reflection(&mut stage.context, &output).expect("a reflection"))
    };
    walk.iter().map(draw_view).collect()
}

/// Measures walks through the scenes that have several maps in a row, and prints a row for each variant.
pub fn run(bench: &Bench) {
    println!("claim,method,scene,variant,value,past");
    for name in ["corridor", "street"] {
        let scene = scene(name);
        let walks = walks(&scene);
        let mut stage = Stage::new(&bench.gpu, &scene).expect("device memory");
        let mut print_row = |name: &str, variant: &str, edits: Edits| {
            // The root mean square change between each two consecutive frames, with the name of their walk.
            let mut changes = Vec::new();
            for (walk_name, walk) in &walks {
                let images = draw(bench, &mut stage, name, edits, (&scene, walk));
                changes.extend(images.windows(2).map(|pair| {
                    let (_, rmse) = difference(&pair[0], &pair[1]);
                    (rmse, walk_name)
                }));
            }
            changes.sort_by(|(a, _), (b, _)| a.total_cmp(b));
            let ((greatest, walk_name), (median, _)) = (changes[changes.len() - 1], changes[changes.len() / 2]);
            println!("popping,{name},{},{variant},{:.2},{walk_name}", scene.name, greatest / median);
        };
        for name in ["local-map", "pccm"] {
            VARIANTS.into_iter().for_each(|(variant, edits)| print_row(name, variant, edits));
        }
        print_row("traced", "none", &[]);
    }
}

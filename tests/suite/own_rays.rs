//! Tests rays of a pixel's own (`--own-rays`). They lower the error against the world reference, and on the screen
//! alone against the screen reference. They are followed only on request. Both kinds of shader that gather list the
//! same pixels.

use crate::common::{check_validation, gpu};
use crate::triangles::{EXTENT, beyond};
use serde_json::Value;
use ssct::gpu::Pixels;
use ssct::gpu::frame::Mode;
use ssct::methods::setup::{Fallback, OwnRays, StageChoice};
use ssct::methods::unified::{self, FirstTraced, UnifiedParams};
use ssct::methods::{EffectParams, Setup, Wants};
use ssct_lab::stage::{Globals, Shot, Stage, gbuffer};
use std::process::Command;

/// Roughness, and the greatest allowed quotient of the error with own rays and the error without. In the atrium at this
/// size, the quotient is 0.79 for narrow lobes, and 0.68 for wide ones.
const MOST: [(f64, f64); 2] = [(0.1, 0.85), (0.3, 0.75)];

/// Roughness, and the greatest allowed quotient on the screen alone. In the corridor, the quotient is 0.75 for narrow
/// lobes, and 0.61 for wide ones.
const MOST_ON_SCREEN: [(f64, f64); 2] = [(0.1, 0.85), (0.3, 0.75)];

/// Returns the mean squared error of a record against its reference, less the square of the reference's noise.
fn squared_error(record: &Value) -> f64 {
    let value = |key: &str| record[key].as_f64().unwrap();
    value("rmse").powi(2) - value("standard_error").powi(2)
}

/// Checks in a view of a scene that the error of a method with 8 own rays, over that without, is below the bound of
/// each roughness. `against` names the reference of the error: `world` or `screen`.
fn check_gain(method: &str, against: &str, [scene, view]: [&str; 2], bounds: [(f64, f64); 2]) {
    let variants = ["none", "8"].map(|own| format!("{method} --own-rays {own}"));
    let options = ["--size", "160x90", "--samples", "1", "--rays", "16", "--json"];
    let subject = ["error", "--scene", scene, "--view", view, "--roughness", "0.1,0.3"];
    let variants = variants.iter().flat_map(|variant| ["--variant", variant]).collect::<Vec<_>>();
    let output =
        Command::new(env!("CARGO_BIN_EXE_ssct")).args([&subject[..], &variants, &options].concat()).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let records: Vec<Value> = serde_json::from_slice(&output.stdout).unwrap();
    for (roughness, greatest) in bounds {
        let error = |own: &str| {
            let is_wanted = |r: &&Value| {
                r["against"] == against
                    && r["setup"]["own_rays"] == own
                    && (r["roughness"].as_f64().unwrap() - roughness).abs() < 1e-6
            };
            squared_error(records.iter().find(is_wanted).unwrap_or_else(|| panic!("{scene} at {roughness}: {own}")))
        };
        let gain = (error("8") / error("none")).sqrt();
        println!("{method}, {scene} {view} at {roughness}: {gain:.2}");
        assert!(gain < greatest, "{method}, {scene} {view} at {roughness}: {gain:.3}");
    }
}

/// Eight own rays lower the error of `traced` against the triangles, and that of `unified` on the screen against the
/// screen reference. Rays for the wrong pixels, or with wrong weights, would cost time and gain nothing.
#[test]
fn own_rays_lower_the_error() {
    check_gain("traced", "world", ["atrium", "hall"], MOST);
    check_gain("unified --beyond none", "screen", ["corridor", "corridor"], MOST_ON_SCREEN);
}

/// Draws a view of the atrium by `unified`, and returns the reflection and the names of the recorded passes.
fn draw(view: &str, roughness: f32, setup: &Setup) -> (Pixels, Vec<String>) {
    let gpu = gpu();
    let scene = crate::common::built_in("atrium");
    let view = scene.view(view).unwrap();
    let materials = Globals { roughness: Some(roughness), ..Globals::default() }.materials(&scene, view);
    let mut stage = Stage::new(&gpu, &scene).unwrap();
    let camera = view.camera(&scene, EXTENT);
    let shot = Shot::new(&mut stage, &unified::INFO, setup, Wants::HITS, camera, materials).unwrap();
    let (report, _, output) = stage.output_in(Mode::Plain, &shot).unwrap();
    let reflection = gbuffer::reflection(&mut stage.context, &output).unwrap();
    check_validation(&gpu).unwrap();
    (reflection, report.recorded)
}

/// Returns a setup with rays beyond the screen and a number of own rays.
fn own(first: FirstTraced, own: OwnRays) -> Setup {
    beyond(first).with(|p: &mut EffectParams| p.own_rays = own)
}

/// With four own rays, passes of own rays are recorded and change the image; without, and for mirrors, none is
/// recorded. All colours are finite and no fade is above 1.
#[test]
fn own_rays_are_followed_only_if_asked_for() {
    let has = |recorded: &[String], pass: &str| recorded.iter().any(|p| p == pass);
    for (roughness, pass) in [(0.1, "own/narrow"), (0.4, "own/wide")] {
        let (without_own, plain) = draw("hall", roughness, &own(FirstTraced::Screen, OwnRays::None));
        let (with_own, recorded) = draw("hall", roughness, &own(FirstTraced::Screen, OwnRays::Four));
        assert!(has(&recorded, pass) && !has(&plain, pass), "{recorded:?}, {plain:?}");
        assert!(without_own.values != with_own.values, "own rays change the image");
        assert!(with_own.values.iter().all(|v| v.is_finite() && *v >= 0.0));
        let on_screen =
            |own| draw("hall", roughness, &Setup::on_screen(EXTENT).with(|p: &mut EffectParams| p.own_rays = own));
        // By default, rays on the screen alone get no own rays.
        let (alone, plain) = on_screen(OwnRays::Auto);
        let (with_own, recorded) = on_screen(OwnRays::Four);
        assert!(has(&recorded, pass) && !has(&plain, pass), "{recorded:?}, {plain:?}");
        assert!(alone.values != with_own.values && with_own.values.iter().all(|v| v.is_finite() && *v >= 0.0));
        assert!(with_own.texels().all(|t| t[3] <= 1.0), "no fade is above 1");
    }
    let (_, mirrors) = draw("hall", 0.0, &own(FirstTraced::Screen, OwnRays::Four));
    assert!(!mirrors.iter().any(|p| p.starts_with("own/")), "{mirrors:?}");
}

/// Passes in fragment shaders and in compute shaders make one image with own rays, to the bit, in three setups at two
/// roughnesses. The two kinds of shader see their neighbours' rays in other ways.
#[test]
fn both_stages_list_the_same_pixels() {
    let on_screen = Setup::on_screen(EXTENT).with(|p: &mut EffectParams| p.own_rays = OwnRays::Four);
    let over_environment = on_screen.with(|p: &mut EffectParams| p.fallback = Fallback::Environment);
    for setup in [own(FirstTraced::Triangles, OwnRays::Sixteen), on_screen, over_environment] {
        for roughness in [0.1, 0.4] {
            let drawn = |stage| {
                let staged = setup.with(|p: &mut UnifiedParams| (p.trace_stage, p.resolve_stage) = (stage, stage));
                draw("hall", roughness, &staged).0
            };
            let [fragment, compute] = [StageChoice::Fragment, StageChoice::Compute].map(drawn);
            assert_eq!(fragment.values, compute.values, "roughness {roughness}, {setup:?}");
        }
    }
}

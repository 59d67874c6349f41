//! The validation layers (core, synchronization, best practices) have nothing to say of any method
//! in any mode, but for the allow-list; and each entry of the list is one that they do say. That
//! they listen at all is shown in `gpu::validation`, by a hazard that they must see.

#![allow(clippy::unwrap_used, clippy::expect_used)]

mod common;

use common::{clutter, clutter_camera, gpu};
use ssct::gpu::frame::Mode;
use ssct::gpu::validation::ALLOWED;
use ssct::methods::{METHODS, Preset, Setup};
use ssct::passes::color_chain::ChainFilter;
use ssct::scene::View;
use ssct::study::image::render;
use ssct::study::{Globals, Shot, Stage};

#[test]
fn every_method_in_every_mode_is_valid() {
    let gpu = gpu();
    let scene = clutter();
    let mut stage = Stage::new(&gpu, &scene).unwrap();
    let materials = Globals { roughness: Some(0.2), ..Globals::default() }.materials(&scene, &View::default());
    let mut frames = 0;
    for extent in [[1, 1], [127, 61], [641, 479]] {
        for method in METHODS {
            for preset in [Preset::Published, Preset::Author] {
                for split in [false, true] {
                    for chain_filter in [ChainFilter::Hardware, ChainFilter::Gaussian] {
                        let setup = Setup { preset, split, chain_filter, ..Setup::new(extent) };
                        let camera = clutter_camera(extent);
                        let shot = Shot::new(&mut stage, method, &setup, camera, materials.clone()).unwrap();
                        let what = format!("{}, {setup:?}", method.name);
                        // Twice each: the second frame's barriers start from the first's states.
                        for mode in [Mode::Plain, Mode::Plain, Mode::Timed, Mode::Timed, Mode::Counted] {
                            let (report, drawn) = stage.run(&shot, mode).unwrap();
                            gpu.check_validation().unwrap_or_else(|e| panic!("{what}, {mode:?}: {e}"));
                            assert!(drawn.meshes > 0, "{what}");
                            assert_eq!(
                                report.passes.len(),
                                if mode == Mode::Timed { report.recorded.len() } else { 0 }
                            );
                            frames += 1;
                        }
                        let image = render(&mut stage, &shot, true).unwrap();
                        gpu.check_validation().unwrap_or_else(|e| panic!("{what}, read back: {e}"));
                        assert_eq!([image.composite.width, image.composite.height], extent);
                    }
                }
            }
        }
    }
    // And each of its settings: variants that are off by default.
    for method in METHODS {
        for setup in (method.settings)(Setup::new([127, 61])) {
            let camera = clutter_camera(setup.extent);
            let shot = Shot::new(&mut stage, method, &setup, camera, materials.clone()).unwrap();
            for mode in [Mode::Plain, Mode::Plain, Mode::Timed] {
                stage.run(&shot, mode).unwrap();
                gpu.check_validation().unwrap_or_else(|e| panic!("{}, {setup:?}, {mode:?}: {e}", method.name));
                frames += 1;
            }
        }
    }
    println!("{frames} frames without a message");
    // With all resources gone.
    drop(stage);
    gpu.check_validation().unwrap();
    for (id, _) in ALLOWED {
        assert!(gpu.validation().iter().any(|m| m.id == *id), "nothing says {id} any more: take it off the allow-list");
    }
}

//! A G-buffer that goes to a file and comes back gives the same image, to the bit, as the direct run.

use crate::common::gpu;
use ssct::methods::{METHODS, Setup, Wants};
use ssct::scene::{gbuffer_file, library};
use ssct::study::{Globals, Shot, Stage, gbuffer, image};

#[test]
fn export_and_reflect_are_the_direct_run_to_the_bit() {
    let gpu = gpu();
    let scene = library::scene("rooms").unwrap();
    let view = scene.view("corridor").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let mut stage = Stage::new(&gpu, &scene).unwrap();
    for extent in [[161, 119], [64, 64]] {
        let camera = view.camera(&scene, extent);
        let globals = Globals { roughness: Some(0.1), ..Globals::default() };
        for method in METHODS.iter().filter(|m| m.is_screen_space()) {
            let setup = Setup::new(extent);
            let shot =
                Shot::new(&mut stage, method, &setup, Wants::REFLECTION, camera, globals.materials(&scene, view))
                    .unwrap();
            let direct = image::render(&mut stage, &shot, false).unwrap();
            let data = gbuffer::read(&mut stage.context, &shot).unwrap();
            let path = folder.path().join("g.exr");
            std::fs::write(&path, gbuffer_file::encode(&data, &path).unwrap()).unwrap();
            let loaded = gbuffer_file::load(&path).unwrap();
            assert!(loaded == data, "the file gives back every bit");
            let reflected = gbuffer::reflect(&gpu, &loaded, method, &setup).unwrap();
            let bits = |p: &ssct::gpu::Pixels| p.values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
            assert!(bits(&reflected.reflection) == bits(&direct.reflection), "{} {extent:?}: reflection", method.name);
            assert!(bits(&reflected.composite) == bits(&direct.composite), "{} {extent:?}: composite", method.name);
        }
    }
    gpu.check_validation().unwrap();
}

//! Tests the precision ladder: it begins at the truth, and its errors grow as formats get coarser. The rung of this
//! project's own formats has the content of the G-buffer's images.

use crate::common::gpu;
use glam::Vec3;
use ssct::gpu::FrameContext;
use ssct::methods::{self, Setup};
use ssct::passes::gbuffer::GBufferImages;
use ssct_lab::stage::{Globals, gbuffer};
use ssct_lab::study::precision::{
    ColorFormat, DepthFormat, ExactGBuffer, NormalFormat, ORACLE, PrecisionSpec, Storage, measure, rungs,
};
use ssct_truth::metrics::image::masked_rmse;
use ssct_truth::reference::surface::World;

/// Size of the image in pixels.
const SIZE: [u32; 2] = [161, 91];

/// For the formats of depth, normals and colours in the corridor, the finest has no error, coarser normals and 16-bit
/// depth have more wrong hits, and colours move no ray. The study rounds on the host, which must do as the device does.
#[test]
fn errors_begin_at_nothing_and_grow_with_coarser_formats() {
    let gpu = gpu();
    let scene = crate::common::built_in("rooms");
    let view = scene.view("corridor").unwrap();
    let globals = Globals { roughness: Some(0.0), reflectivity: 1.0, normal_deviation: None };

    let materials = globals.materials(&scene, view);
    let exact = ExactGBuffer::trace(&World::new(&scene, &materials), &view.camera(&scene, SIZE), SIZE);
    let rounded = Storage::SSCT.store(&exact);
    let mut context = FrameContext::new(&gpu).unwrap();
    let images = GBufferImages::upload(&mut context, &exact.data).unwrap();
    let uploaded = images.gbuffer();
    assert!(context.read(uploaded.depth.all()).unwrap().values == rounded.depth);
    for (image, values) in [(uploaded.normal.all(), &rounded.normal), (uploaded.color.level(0), &rounded.color)] {
        let read: Vec<Vec3> = context.read(image).unwrap().texels().map(Vec3::from_slice).collect();
        assert!(read == *values, "an image of the G-buffer rounds otherwise than its rung");
    }

    let methods = ["unified", "ssct"].map(|name| methods::find(name).unwrap());
    let setup = Setup::new(SIZE);
    let spec = PrecisionSpec { gpu: &gpu, scene: &scene, view, globals, methods: &methods, setup, rays: 2 };
    let records = measure(&spec, &mut || Ok(())).unwrap();
    let finest = Storage::FINEST;
    for method in [ORACLE, "unified"] {
        let method_rungs = rungs(&records, method);
        assert_eq!(method_rungs.len(), Storage::ladder().len());
        let rung = |storage: Storage| method_rungs.iter().find(|r| r.storage == storage).unwrap();
        let wrong = |storage: Storage| rung(storage).wrong_hits.unwrap();
        let rmse = |storage: Storage| rung(storage).rmse[0];
        let normal = |normal| Storage { normal, ..finest };
        let halves = normal(NormalFormat::Rgba16f);
        if method == ORACLE {
            assert!(wrong(finest) < 1e-3 && rmse(finest) < 1e-3, "{method}: {} {}", wrong(finest), rmse(finest));
        } else {
            // `unified` has normals of 16-bit floats at best, and loses as many hits by them as the oracle does.
            assert_eq!((wrong(finest), rmse(finest)), (wrong(halves), rmse(halves)), "{method}");
            let oracle_rungs = rungs(&records, ORACLE);
            let oracle_rung = |storage: Storage| oracle_rungs.iter().find(|r| r.storage == storage).unwrap();
            let lost = oracle_rung(halves).wrong_hits.unwrap();
            assert!((wrong(halves) - lost).abs() < 1e-3, "{method}: {} {lost}", wrong(halves));
            // The reference filters over the pixel and the method does not: the method's own image with the finest
            // format tells what coarser formats cost it.
            let drawn = |storage: Storage| {
                let stored = storage.store(&exact);
                let image = gbuffer::reflect(&gpu, &stored, None, methods[0], &Setup::new(SIZE)).unwrap();
                image.reflection.texels().map(|t| [t[0], t[1], t[2]]).collect::<Vec<_>>()
            };
            let (finest_image, mask) = (drawn(finest), exact.data.reflecting());
            assert!(drawn(halves) == finest_image, "{method}");
            // Coarser colours cost both alike. Coarser normals cost the method more, since the reference averages over
            // a pixel.
            let cost_of = |coarser: Storage| masked_rmse(&finest_image, &drawn(coarser), &mask);
            let oracle_rmse = |coarser: Storage| oracle_rung(coarser).rmse[0];
            let color = Storage { color: ColorFormat::Rgba8Srgb, ..finest };
            let costs = [cost_of(color), oracle_rmse(color)];
            assert!(costs[0] > 0.0 && (costs[0] - costs[1]).abs() < 1e-3, "{method}: {costs:?}");
            let normals = normal(NormalFormat::Rgb10a2);
            let costs = [cost_of(normals), oracle_rmse(normals)];
            assert!(costs[0] > costs[1] && costs[0] < 0.02, "{method}: {costs:?}");
        }
        assert!(wrong(halves) < wrong(normal(NormalFormat::Rgb10a2)), "{method}");
        assert!(wrong(normal(NormalFormat::Rgb10a2)) < wrong(normal(NormalFormat::Rgba8)), "{method}");
        let depth = Storage { depth: DepthFormat::D16, ..finest };
        assert!(wrong(depth) > wrong(finest) && rmse(depth) > rmse(finest), "{method}");
        // Colours move no ray. For `unified`, the difference by the reference's filter is larger than the cost of
        // coarse colours.
        let color = Storage { color: ColorFormat::Rgba8Srgb, ..finest };
        assert!(wrong(color) == wrong(finest) && (method != ORACLE || rmse(color) > rmse(finest)), "{method}");
    }
    let truth = &rungs(&records, ORACLE)[0];
    assert_eq!((truth.wrong_hits, truth.rmse[0]), (Some(0.0), 0.0), "the oracle agrees with itself");
    gpu.check_validation().unwrap();
}

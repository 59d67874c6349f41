//! Triangles through the door: what methods make of a G-buffer beside them is what they make of it beside the scene itself.

use crate::common::engine::{Engine, NATIVE, Theirs, bits, info, plain_rooms, rmse, triangles_of, view_of_rooms};
use crate::common::gpu;
use ssct::gpu::FrameContext;
use ssct::methods::effect::Effect;
use ssct::methods::setup::BeyondScreen;
use ssct::methods::unified::{First, UnifiedParams};
use ssct::methods::{self, EffectParams, Input, SceneInput, Setup, Wants};
use ssct::passes::gbuffer::GBufferImages;
use ssct::{FrameInput, Reflections, ReflectionsInfo};
use ssct_lab::study::{Stage, gbuffer};

const EXTENT: [u32; 2] = [97, 61];

#[test]
fn triangles_of_the_caller_show_what_those_of_the_scene_show() {
    let gpu = gpu();
    let mut engine = Engine::new(&gpu);
    let data = view_of_rooms(&gpu, EXTENT);
    let scene = plain_rooms();
    let stage = Stage::new(&gpu, &scene).unwrap();
    let theirs = Theirs::new(&mut engine, &data, NATIVE);
    let context = engine.context();
    let triangles = triangles_of(&engine, &scene);

    let mut frames = FrameContext::new(&gpu).unwrap();
    let images = GBufferImages::upload(&mut frames, &data).unwrap();
    let shown = SceneInput { data: stage.scene(), materials: &scene.materials };
    let alone = gbuffer::reflect(&gpu, &data, None, &methods::unified::INFO, &Setup::new(EXTENT)).unwrap();
    for (method, first) in [("unified", "screen"), ("unified", "triangles"), ("traced", "")] {
        let first_is = if first == "screen" { First::Screen } else { First::Triangles };
        let setup = Setup::new(EXTENT)
            .with(|p: &mut EffectParams| p.beyond = BeyondScreen::Triangles)
            .with(|p: &mut UnifiedParams| p.first = first_is);
        let method_info = methods::find(method).unwrap();
        let effect = Effect::new(&mut frames, method_info, &setup, Wants::REFLECTION, Some(&shown)).unwrap();
        let input = Input { scene: Some(shown), ..Input::of_screen(images.gbuffer(), &data.camera) };
        let output = gbuffer::at_rest(&mut frames, &effect, &input).unwrap();
        let direct = gbuffer::reflection(&mut frames, &output).unwrap();

        let parameters: &[(&str, &str)] = if first.is_empty() { &[] } else { &[("first", first)] };
        let with = ReflectionsInfo { triangles: Some(&triangles), parameters, ..info(&data, method) };
        let mut reflections = Reflections::new(&context, &with).unwrap();
        let frame = FrameInput { triangles: Some(&triangles), ..theirs.input() };
        let recorded = engine.frame(&mut reflections, &frame).unwrap();
        let reflection = engine.read(&recorded.reflection.unwrap());
        let differ = bits(&reflection).iter().zip(bits(&direct)).filter(|(a, b)| **a != *b).count();
        assert_eq!(differ, 0, "{method}, {first} first: rmse {}", rmse(&reflection, &direct));
        assert!(bits(&reflection) != bits(&alone.reflection), "{method}, {first} first: rays end on triangles");
    }
    // A device of the caller's has no ray queries on.
    let asking = [("tracer", "query")];
    let with = ReflectionsInfo { triangles: Some(&triangles), parameters: &asking, ..info(&data, "unified") };
    let said = Reflections::new(&context, &with).err().expect("refused").to_string();
    assert!(said.contains("the tracer must be tree"), "{said}");
    gpu.check_validation().unwrap();
}

//! Tests triangles through the door: beside the caller's triangles, a method makes the same image of a G-buffer as
//! beside the scene itself.

use crate::common::engine::{
    Engine, ForeignGBuffer, NATIVE, bits, info, meshes_of, plain_rooms, rmse, textures_of, triangles_of, upload,
    vertices_of, view_of_rooms,
};
use crate::common::gpu;
use ssct::gpu::{FrameContext, Pixels};
use ssct::methods::effect::Effect;
use ssct::methods::setup::BeyondScreen;
use ssct::methods::unified::{FirstTraced, HitColor, UnifiedParams};
use ssct::methods::{self, EffectParams, Input, SceneInput, Setup, Wants};
use ssct::passes::gbuffer::GBufferImages;
use ssct::{FrameInput, HitTexture, MeshTexture, Reflections, ReflectionsInfo, TriangleMesh, Triangles};
use ssct_lab::stage::{Stage, gbuffer};
use ssct_scenes::{GBufferData, Surface};

/// Size of the images in pixels.
const EXTENT: [u32; 2] = [97, 61];
/// Size in pixels of the lit images, which show textures.
const EXTENT_LIT: [u32; 2] = [320, 180];

/// Returns the reflection that a method makes of a G-buffer beside the scene itself. The tuple has the G-buffer's
/// images, its data, and the scene.
fn in_the_laboratory(
    frames: &mut FrameContext,
    method: &str,
    setup: &Setup,
    (images, data, shown): (&GBufferImages, &GBufferData, SceneInput),
) -> Pixels {
    let method = methods::find(method).unwrap();
    let effect = Effect::new(frames, method, setup, Wants::REFLECTION, Some(&shown)).unwrap();
    let input = Input { scene: Some(shown), ..Input::of_screen(images.gbuffer(), &data.camera) };
    let output = gbuffer::reflect_at_rest(frames, &effect, &input).unwrap();
    gbuffer::reflection(frames, &output).unwrap()
}

/// Returns the reflection that a method makes of a G-buffer through the door, beside triangles of the caller. The
/// tuples have the G-buffer's images with its data, and the method with its parameters.
fn through_the_door(
    engine: &mut Engine,
    (theirs, data): (&ForeignGBuffer, &GBufferData),
    triangles: &Triangles,
    (method, parameters): (&str, &[(&str, &str)]),
) -> Pixels {
    let reflections_info = ReflectionsInfo { triangles: Some(triangles), parameters, ..info(data, method) };
    let mut reflections = Reflections::new(&engine.context(), &reflections_info).unwrap();
    let frame = FrameInput { triangles: Some(triangles), ..theirs.input() };
    let recorded = engine.frame(&mut reflections, &frame).unwrap();
    engine.read(&recorded.reflection.unwrap())
}

/// In five combinations of method and source of hit colours, no bit of the reflection differs between the caller's
/// triangles and the scene's. The door builds its own tree, and orders and transforms the meshes itself.
#[test]
fn triangles_of_the_caller_show_what_those_of_the_scene_show() {
    let gpu = gpu();
    let mut engine = Engine::new(&gpu);
    let data = view_of_rooms(&gpu, EXTENT);
    let scene = plain_rooms();
    let stage = Stage::new(&gpu, &scene).unwrap();
    let theirs = ForeignGBuffer::new(&mut engine, &data, NATIVE);
    let context = engine.context();
    let triangles = triangles_of(&engine, &scene);

    let mut frames = FrameContext::new(&gpu).unwrap();
    let images = GBufferImages::upload(&mut frames, &data).unwrap();
    let shown = SceneInput { data: stage.scene(), materials: &scene.materials };
    let alone = gbuffer::reflect(&gpu, &data, None, &methods::unified::INFO, &Setup::new(EXTENT)).unwrap();
    // The door takes the screen's colours of hits unless a parameter says otherwise; the laboratory takes the
    // triangles' colours.
    let (triangle_colors, screen) = (("hit-color", "triangles"), HitColor::Screen);
    type Case<'a> = (&'a str, &'a [(&'a str, &'a str)], FirstTraced, HitColor);
    let cases: [Case; 5] = [
        ("unified", &[("first", "screen"), triangle_colors], FirstTraced::Screen, HitColor::Triangles),
        ("unified", &[("first", "triangles"), triangle_colors], FirstTraced::Triangles, HitColor::Triangles),
        ("unified", &[("first", "screen")], FirstTraced::Screen, screen),
        ("unified", &[("first", "triangles")], FirstTraced::Triangles, screen),
        ("traced", &[], FirstTraced::Triangles, HitColor::Triangles),
    ];
    for (method, parameters, first, hit_color) in cases {
        let setup = Setup::new(EXTENT)
            .with(|p: &mut EffectParams| p.beyond = BeyondScreen::Triangles)
            .with(|p: &mut UnifiedParams| (p.first, p.hit_color) = (first, hit_color));
        let direct = in_the_laboratory(&mut frames, method, &setup, (&images, &data, shown));
        let reflection = through_the_door(&mut engine, (&theirs, &data), &triangles, (method, parameters));
        let differ = bits(&reflection).iter().zip(bits(&direct)).filter(|(a, b)| **a != *b).count();
        assert_eq!(differ, 0, "{method}, {parameters:?}: rmse {}", rmse(&reflection, &direct));
        assert!(bits(&reflection) != bits(&alone.reflection), "{method}, {parameters:?}: rays end on triangles");
    }
    // The caller's device has not enabled ray queries.
    let query_parameters = [("tracer", "query")];
    let reflections_info =
        ReflectionsInfo { triangles: Some(&triangles), parameters: &query_parameters, ..info(&data, "unified") };
    let message = Reflections::new(&context, &reflections_info).err().expect("refused").to_string();
    assert!(message.contains("the tracer must be tree"), "{message}");
    gpu.check_validation().unwrap();
}

/// With textures, the reflection is nearer than 0.004 to that of the scene; without textures it is ten times as far
/// off. Wrong textures are refused with a sentence, before a shader reads past their texels.
#[test]
fn textures_of_the_caller_show_what_those_of_the_scene_show() {
    let gpu = gpu();
    let mut engine = Engine::new(&gpu);
    let data = view_of_rooms(&gpu, EXTENT);
    let mut scene = crate::common::built_in("rooms");
    scene.lights.clear();
    for material in &mut scene.materials {
        (material.normal_map, material.alpha_mask) = (None, None);
        (material.emission, material.single_sided, material.surface) = (1.0, false, Surface::Lit);
    }
    let stage = Stage::new(&gpu, &scene).unwrap();
    let theirs = ForeignGBuffer::new(&mut engine, &data, NATIVE);
    let context = engine.context();
    let (textures, vertices) = (textures_of(&scene), vertices_of(&scene));
    let mut frames = FrameContext::new(&gpu).unwrap();
    let images = GBufferImages::upload(&mut frames, &data).unwrap();
    let shown = SceneInput { data: stage.scene(), materials: &scene.materials };
    let direct = in_the_laboratory(&mut frames, "traced", &Setup::new(EXTENT), (&images, &data, shown));

    let [textured, plain] = [true, false].map(|are_textured| {
        let meshes = meshes_of(&scene, &vertices, are_textured);
        let mut triangles = Triangles::with_textures(&context, &meshes, &textures).unwrap();
        upload(&engine, &mut triangles);
        rmse(&through_the_door(&mut engine, (&theirs, &data), &triangles, ("traced", &[])), &direct)
    });
    // The device makes the levels of the scene's textures and may round their bytes otherwise than the door.
    assert!(textured < 0.004 && plain > 10.0 * textured, "textured {textured}, plain {plain}");

    let meshes = meshes_of(&scene, &vertices, true);
    let first_mesh = &meshes[..1];
    let refused = |meshes: &[TriangleMesh], textures: &[HitTexture], words: &str| {
        let message = Triangles::with_textures(&context, meshes, textures).err().expect("refused").to_string();
        assert!(message.contains(words), "{message}");
    };
    let texture = MeshTexture { number: 1, places: &vertices[0].places };
    let mesh_with = |texture| [TriangleMesh { texture: Some(texture), ..first_mesh[0] }];
    refused(&mesh_with(texture), &textures[..1], "triangle mesh 0 has texture 1, and there are 1");
    refused(
        &mesh_with(MeshTexture { places: &[], ..texture }),
        &textures[..2],
        "triangle mesh 0 has 0 places on its texture",
    );
    refused(
        first_mesh,
        &[HitTexture { extent: [0, 4], ..textures[0] }],
        "texture 0 is 0x4 texels; each side must have 1 to",
    );
    refused(first_mesh, &[HitTexture { texels: &[0; 5], ..textures[0] }], "texels of four bytes, and has 5 bytes");
    gpu.check_validation().unwrap();
}

/// The caller's triangles are black, so that every colour in the reflection comes from the screen. The colours differ
/// by less than 8 % in the median from those that lit triangles have.
#[test]
fn what_the_screen_shows_of_a_hit_has_the_color_of_the_screen() {
    let gpu = gpu();
    let mut engine = Engine::new(&gpu);
    let scene = crate::common::built_in("rooms");
    let stage = Stage::new(&gpu, &scene).unwrap();
    let context = engine.context();
    let vertices = vertices_of(&scene);
    let meshes = meshes_of(&scene, &vertices, false);
    let black: Vec<_> = meshes.into_iter().map(|mesh| TriangleMesh { color: [0.0; 3], ..mesh }).collect();
    let mut triangles = Triangles::new(&context, &black).unwrap();
    upload(&engine, &mut triangles);
    let mut frames = FrameContext::new(&gpu).unwrap();
    let shown = SceneInput { data: stage.scene(), materials: &scene.materials };
    for roughness in [0.0, 0.1, 0.4] {
        let mut data = view_of_rooms(&gpu, EXTENT_LIT);
        data.roughness.fill(roughness);
        let theirs = ForeignGBuffer::new(&mut engine, &data, NATIVE);
        let images = GBufferImages::upload(&mut frames, &data).unwrap();
        // The reference: reflections of the scene's own triangles, which are lit.
        let setup = Setup::new(EXTENT_LIT).with(|p: &mut UnifiedParams| p.first = FirstTraced::Triangles);
        let lit = in_the_laboratory(&mut frames, "unified", &setup, (&images, &data, shown));
        let mut show = |parameters: &[(&str, &str)]| {
            through_the_door(&mut engine, (&theirs, &data), &triangles, ("unified", parameters))
        };
        let all_black = show(&[("hit-color", "triangles")]);
        assert!(all_black.values.chunks(4).all(|rgba| rgba[..3] == [0.0; 3]), "nothing but black triangles is met");
        for first in ["screen", "triangles"] {
            let colored = show(&[("first", first)]);
            let pairs = || colored.values.chunks(4).zip(lit.values.chunks(4));
            let of_screen = || pairs().filter(|(a, _)| a[..3] != [0.0; 3]);
            let reflecting = pairs().filter(|(_, b)| b[3] > 0.0).count();
            let share = of_screen().count() as f64 / reflecting as f64;
            // Single pixels differ: textures are looked up on the screen and not on the surface, lobes are partly
            // black, and windows show a sky on the screen that is not handed over.
            let mut relative_errors: Vec<f32> =
                of_screen().map(|(a, b)| (a[1] - b[1]).abs() / b[1].max(0.01)).collect();
            relative_errors.sort_by(f32::total_cmp);
            let median = relative_errors[relative_errors.len() / 2];
            println!("roughness {roughness}, {first} first: share {share:.3}, median {median:.4} apart");
            assert!(share > 0.5 && median < 0.08, "{roughness}, {first}: {share} of the pixels, {median} apart");
        }
    }
    gpu.check_validation().unwrap();
}

//! Tests rays that ray queries of the device follow (`--tracer query`). They end at the triangles where a walk through
//! the tree ends them. A device without ray queries refuses with a sentence.

use crate::common::folder::Folder;
use crate::common::{check_validation, gpu};
use crate::triangles::{EXTENT, beyond, mirrors, traced};
use glam::Vec3;
use ssct::gpu::frame::Mode;
use ssct::gpu::{Gpu, Pixels};
use ssct::methods::setup::Tracer;
use ssct::methods::unified::{self, FirstTraced};
use ssct::methods::{EffectParams, MethodInfo, Setup, Wants};
use ssct_lab::stage::{Globals, Shot, Stage, gbuffer};
use ssct_scenes::{Encoding, Material, Scene, Texture};

/// The number of rays for each of which one may end on another triangle that is equally near within rounding.
const RAYS_TO_A_TIE: usize = 1000;

/// Returns a setup with another tracer.
fn using(setup: &Setup, tracer: Tracer) -> Setup {
    setup.with(|p: &mut EffectParams| p.tracer = tracer)
}

/// The ends of the rays of a shot, if it stores them, its reflection, and its passes.
struct Drawn {
    hits: Option<Pixels>,
    reflection: Pixels,
    recorded: Vec<String>,
}

/// Draws a shot on its stage.
fn draw(stage: &mut Stage, shot: &Shot) -> Drawn {
    let (report, _, output) = stage.output_in(Mode::Plain, shot).unwrap();
    let hits = output.traced.hits.map(|hits| stage.context.read(hits.0.all()).unwrap());
    let reflection = gbuffer::reflection(&mut stage.context, &output).unwrap();
    Drawn { hits, reflection, recorded: report.recorded }
}

/// Makes shots of one view with both tracers, first the tree and then the query.
fn tree_and_query(
    stage: &mut Stage,
    (scene, view): (&Scene, &str),
    materials: &[Material],
    (method, setup): (&MethodInfo, &Setup),
) -> [Shot; 2] {
    let camera = scene.view(view).unwrap().camera(scene, EXTENT);
    [Tracer::Tree, Tracer::Query]
        .map(|tracer| Shot::new(stage, method, &using(setup, tracer), Wants::HITS, camera, materials.to_vec()).unwrap())
}

/// Returns the number of texels with an end of a ray, and the number of texels in which the two images differ. The
/// images are hits or reflections, whose last channel is above 0 where a ray ends.
fn differing(tree: &Pixels, query: &Pixels) -> (usize, usize) {
    let differ = |a: &[f32], b: &[f32]| a.iter().zip(b).any(|(a, b)| (a - b).abs() > 1e-3 * (1.0 + a.abs()));
    let rays = tree.texels().filter(|texel| texel[3] > 0.0).count();
    (rays, tree.texels().zip(query.texels()).filter(|(a, b)| differ(a, b)).count())
}

/// In three scenes with two methods, fewer than one ray in 1000 ends elsewhere by queries than by the tree, and as few
/// colours differ. The device builds its own structure of the same triangles.
#[test]
fn queries_end_rays_where_the_tree_does() {
    let gpu = gpu();
    if !gpu.has_ray_queries() {
        return check_refusal(&gpu);
    }
    for (name, view) in [("rooms", "cylinder"), ("street", "car"), ("cathedral", "clerestory")] {
        let scene = crate::common::built_in(name);
        let mut stage = Stage::new(&gpu, &scene).unwrap();
        let materials = mirrors(&scene, view);
        for (method, setup) in [(traced(), Setup::new(EXTENT)), (&unified::INFO, beyond(FirstTraced::Screen))] {
            let shots = tree_and_query(&mut stage, (&scene, view), &materials, (method, &setup));
            let [tree, query] = shots.each_ref().map(|shot| draw(&mut stage, shot));
            assert_eq!(tree.recorded, query.recorded);
            let (rays, differing_ends) = differing(tree.hits.as_ref().unwrap(), query.hits.as_ref().unwrap());
            let (_, colors) = differing(&tree.reflection, &query.reflection);
            println!(
                "{name} {view}, {}: {differing_ends} of {rays} rays end elsewhere, {colors} colours differ",
                method.name
            );
            assert!(rays > 1000 && differing_ends * RAYS_TO_A_TIE <= rays, "{name} {view}: {differing_ends} of {rays}");
            assert!(colors * RAYS_TO_A_TIE <= rays, "{name} {view}: {colors} of {rays}");
        }
    }
    check_validation(&gpu).unwrap();
}

/// At two roughnesses with two methods, the reflections of both tracers differ in less than 1 % of the pixels.
#[test]
fn lobes_of_both_tracers_are_alike() {
    let gpu = gpu();
    if !gpu.has_ray_queries() {
        return check_refusal(&gpu);
    }
    let scene = crate::common::built_in("rooms");
    let mut stage = Stage::new(&gpu, &scene).unwrap();
    // A narrow lobe has a ray for each pixel, and a wide one a ray for each four pixels. Programs of their own trace
    // the two.
    for roughness in [0.1, 0.6] {
        let view = scene.view("cylinder").unwrap();
        let materials = Globals { roughness: Some(roughness), ..Globals::default() }.materials(&scene, view);
        for (method, setup) in [(traced(), Setup::new(EXTENT)), (&unified::INFO, beyond(FirstTraced::Screen))] {
            let shots = tree_and_query(&mut stage, (&scene, "cylinder"), &materials, (method, &setup));
            let [tree, query] = shots.each_ref().map(|shot| draw(&mut stage, shot));
            let (rays, others) = differing(&tree.reflection, &query.reflection);
            assert!(tree.reflection.texels().any(|t| t[0] > 0.1), "black at roughness {roughness}");
            assert!(rays > 1000 && others * 100 <= rays, "{} {roughness}: {others} of {rays}", method.name);
        }
    }
    check_validation(&gpu).unwrap();
}

/// Rays pass through holes of masks and through the backs of surfaces with one side, equally for both tracers. The
/// device's query takes every triangle for solid unless the shader says otherwise.
#[test]
fn holes_and_backs_let_queries_through() {
    let gpu = gpu();
    if !gpu.has_ray_queries() {
        return check_refusal(&gpu);
    }
    let plain = crate::common::built_in("rooms");
    let mut holed = plain.clone();
    // A chequerboard of holes in every second material; the others have one side.
    let texel = |i: usize| if (i + i / 8).is_multiple_of(2) { [255; 4] } else { [0; 4] };
    let rgba = (0..64).flat_map(texel).collect();
    let mask = Texture { name: "holes".into(), width: 8, height: 8, rgba, encoding: Encoding::Linear };
    holed.textures.push(mask);
    for (i, material) in holed.materials.iter_mut().enumerate() {
        (material.alpha_mask, material.single_sided) =
            if i % 2 == 0 { (Some(holed.textures.len() - 1), false) } else { (None, true) };
    }
    let view = "cylinder";
    let drawn = [&plain, &holed].map(|scene| {
        let mut stage = Stage::new(&gpu, scene).unwrap();
        let shots = tree_and_query(&mut stage, (scene, view), &mirrors(scene, view), (traced(), &Setup::new(EXTENT)));
        shots.each_ref().map(|shot| draw(&mut stage, shot).hits.unwrap())
    });
    let [[whole, _], [tree, query]] = &drawn;
    let (rays, others) = differing(tree, query);
    let (_, through) = differing(whole, tree);
    println!("{others} of {rays} rays end elsewhere; {through} pass");
    assert!(others * RAYS_TO_A_TIE <= rays && through > 1000, "{others} and {through} of {rays}");
    check_validation(&gpu).unwrap();
}

/// After a mesh has moved, queries find it in its new place, as the tree does. The device's structure must be rebuilt
/// before the frame.
#[test]
fn queries_see_a_mesh_where_it_stands_now() {
    let gpu = gpu();
    if !gpu.has_ray_queries() {
        return check_refusal(&gpu);
    }
    let scene = crate::common::built_in("street");
    let mut stage = Stage::new(&gpu, &scene).unwrap();
    let shots = tree_and_query(&mut stage, (&scene, "car"), &mirrors(&scene, "car"), (traced(), &Setup::new(EXTENT)));
    let [_, before] = shots.each_ref().map(|shot| draw(&mut stage, shot));
    stage.scene_mut().place_meshes("car-body", Vec3::new(0.0, 0.5, 0.0)).unwrap();
    // The tree is drawn last, so that it cannot have built anything for the query.
    let [_, query] = shots.each_ref().map(|shot| draw(&mut stage, shot));
    let tree = draw(&mut stage, &shots[0]);
    let (rays, others) = differing(tree.hits.as_ref().unwrap(), query.hits.as_ref().unwrap());
    let (_, moved) = differing(before.hits.as_ref().unwrap(), query.hits.as_ref().unwrap());
    assert!(others * RAYS_TO_A_TIE <= rays && moved > 100, "{others} and {moved} of {rays}");
    check_validation(&gpu).unwrap();
}

/// Checks that a device without ray queries refuses them, with a sentence that says what it lacks.
fn check_refusal(gpu: &Gpu) {
    let scene = crate::common::built_in("rooms");
    let mut stage = Stage::new(gpu, &scene).unwrap();
    let camera = scene.views[0].camera(&scene, EXTENT);
    let setup = using(&Setup::new(EXTENT), Tracer::Query);
    let shot = Shot::new(&mut stage, traced(), &setup, Wants::IMAGE, camera, mirrors(&scene, &scene.views[0].name));
    let message = shot.err().expect("refused").to_string();
    let name = &gpu.info().name;
    assert!(message.starts_with(&format!("{name} has no ray queries: it lacks ")), "{message}");
    check_validation(gpu).unwrap();
}

/// `render --tracer query` draws the image of the tree and explains its structure, or ends with status 2 and the
/// reason.
#[test]
fn the_command_draws_with_queries_or_says_why_not() {
    let folder = Folder::new();
    let has_queries = gpu().has_ray_queries();
    let output = |tracer| {
        let file = format!("{tracer}.png");
        let size = ["--size", "66x37", "--validation", "--explain", "-o", &file];
        folder.run(&[&["render", "--method", "traced", "--tracer", tracer], &size[..]].concat())
    };
    let query = output("query");
    let [errors, printed] = [&query.stderr, &query.stdout].map(|bytes| String::from_utf8_lossy(bytes).into_owned());
    if !has_queries {
        assert_eq!(query.status.code(), Some(2), "{errors}");
        assert!(errors.contains(" has no ray queries: it lacks ") && errors.lines().count() == 1, "{errors}");
        return;
    }
    assert_eq!(query.status.code(), Some(0), "{errors}");
    assert!(printed.contains("structure for ray queries: "), "{printed}");
    let tree = output("tree");
    let printed = String::from_utf8_lossy(&tree.stdout).into_owned();
    assert!(tree.status.success() && !printed.contains("ray queries"), "{printed}");
    assert_eq!(folder.image("query.png"), folder.image("tree.png"));
}

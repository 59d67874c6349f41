//! Rays that ray queries of the device follow (`--tracer query`): they end where a walk through the tree ends them, and a
//! device without ray queries says so.

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

/// The number of rays of which one may end elsewhere: on another of two triangles that are equally near within rounding.
const RAYS_TO_A_TIE: usize = 1000;

fn by(setup: &Setup, tracer: Tracer) -> Setup {
    setup.with(|p: &mut EffectParams| p.tracer = tracer)
}

/// What a device drew of a shot: where each ray ended, the reflection, and the passes.
struct Drawn {
    hits: Option<Pixels>,
    reflection: Pixels,
    recorded: Vec<String>,
}

fn draw(stage: &mut Stage, shot: &Shot) -> Drawn {
    let (report, _, output) = stage.output_in(Mode::Plain, shot).unwrap();
    let hits = output.traced.hits.map(|hits| stage.context.read(hits.0.all()).unwrap());
    let reflection = gbuffer::reflection(&mut stage.context, &output).unwrap();
    Drawn { hits, reflection, recorded: report.recorded }
}

/// Both tracers on one stage, the tree first.
fn both(
    stage: &mut Stage,
    (scene, view): (&Scene, &str),
    materials: &[Material],
    (method, setup): (&MethodInfo, &Setup),
) -> [Shot; 2] {
    let camera = scene.view(view).unwrap().camera(scene, EXTENT);
    [Tracer::Tree, Tracer::Query]
        .map(|tracer| Shot::new(stage, method, &by(setup, tracer), Wants::HITS, camera, materials.to_vec()).unwrap())
}

/// How many texels there are in which rays end, and in how many of them two images differ.
fn differing(tree: &Pixels, query: &Pixels) -> (usize, usize) {
    let far = |a: &[f32], b: &[f32]| a.iter().zip(b).any(|(a, b)| (a - b).abs() > 1e-3 * (1.0 + a.abs()));
    let there = |a: &[f32]| a[3] > 0.0;
    let rays = tree.texels().filter(|a| there(a)).count();
    (rays, tree.texels().zip(query.texels()).filter(|(a, b)| far(a, b)).count())
}

#[test]
fn queries_end_rays_where_the_tree_does() {
    let gpu = gpu();
    if !gpu.has_ray_queries() {
        return refuses(&gpu);
    }
    for (name, view) in [("rooms", "cylinder"), ("street", "car"), ("cathedral", "clerestory")] {
        let scene = crate::common::built_in(name);
        let mut stage = Stage::new(&gpu, &scene).unwrap();
        let materials = mirrors(&scene, view);
        for (method, setup) in [(traced(), Setup::new(EXTENT)), (&unified::INFO, beyond(FirstTraced::Screen))] {
            let shots = both(&mut stage, (&scene, view), &materials, (method, &setup));
            let [tree, query] = shots.each_ref().map(|shot| draw(&mut stage, shot));
            assert_eq!(tree.recorded, query.recorded);
            let (rays, others) = differing(tree.hits.as_ref().unwrap(), query.hits.as_ref().unwrap());
            let (_, colors) = differing(&tree.reflection, &query.reflection);
            println!("{name} {view}, {}: {others} of {rays} rays end elsewhere, {colors} colours differ", method.name);
            assert!(rays > 1000 && others * RAYS_TO_A_TIE <= rays, "{name} {view}: {others} of {rays}");
            assert!(colors * RAYS_TO_A_TIE <= rays, "{name} {view}: {colors} of {rays}");
        }
    }
    check_validation(&gpu).unwrap();
}

#[test]
fn lobes_of_both_tracers_are_alike() {
    let gpu = gpu();
    if !gpu.has_ray_queries() {
        return refuses(&gpu);
    }
    let scene = crate::common::built_in("rooms");
    let mut stage = Stage::new(&gpu, &scene).unwrap();
    // A narrow lobe has a ray a pixel, a wide one a ray for four of them, and each program walks or asks by itself.
    for roughness in [0.1, 0.6] {
        let view = scene.view("cylinder").unwrap();
        let materials = Globals { roughness: Some(roughness), ..Globals::default() }.materials(&scene, view);
        for (method, setup) in [(traced(), Setup::new(EXTENT)), (&unified::INFO, beyond(FirstTraced::Screen))] {
            let shots = both(&mut stage, (&scene, "cylinder"), &materials, (method, &setup));
            let [tree, query] = shots.each_ref().map(|shot| draw(&mut stage, shot));
            let (rays, others) = differing(&tree.reflection, &query.reflection);
            assert!(tree.reflection.texels().any(|t| t[0] > 0.1), "black at roughness {roughness}");
            assert!(rays > 1000 && others * 100 <= rays, "{} {roughness}: {others} of {rays}", method.name);
        }
    }
    check_validation(&gpu).unwrap();
}

#[test]
fn holes_and_backs_let_queries_through() {
    let gpu = gpu();
    if !gpu.has_ray_queries() {
        return refuses(&gpu);
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
        let shots = both(&mut stage, (scene, view), &mirrors(scene, view), (traced(), &Setup::new(EXTENT)));
        shots.each_ref().map(|shot| draw(&mut stage, shot).hits.unwrap())
    });
    let [[whole, _], [tree, query]] = &drawn;
    let (rays, others) = differing(tree, query);
    let (_, through) = differing(whole, tree);
    println!("{others} of {rays} rays end elsewhere; {through} pass");
    assert!(others * RAYS_TO_A_TIE <= rays && through > 1000, "{others} and {through} of {rays}");
    check_validation(&gpu).unwrap();
}

#[test]
fn queries_see_a_mesh_where_it_stands_now() {
    let gpu = gpu();
    if !gpu.has_ray_queries() {
        return refuses(&gpu);
    }
    let scene = crate::common::built_in("street");
    let mut stage = Stage::new(&gpu, &scene).unwrap();
    let shots = both(&mut stage, (&scene, "car"), &mirrors(&scene, "car"), (traced(), &Setup::new(EXTENT)));
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

/// What a device without ray queries says to whoever asks them.
fn refuses(gpu: &Gpu) {
    let scene = crate::common::built_in("rooms");
    let mut stage = Stage::new(gpu, &scene).unwrap();
    let camera = scene.views[0].camera(&scene, EXTENT);
    let setup = by(&Setup::new(EXTENT), Tracer::Query);
    let made = Shot::new(&mut stage, traced(), &setup, Wants::IMAGE, camera, mirrors(&scene, &scene.views[0].name));
    let said = made.err().expect("refused").to_string();
    let name = &gpu.info().name;
    assert!(said.starts_with(&format!("{name} has no ray queries: it lacks ")), "{said}");
    check_validation(gpu).unwrap();
}

#[test]
fn the_command_draws_with_queries_or_says_why_not() {
    let folder = Folder::new();
    let has = gpu().has_ray_queries();
    let output = |tracer| {
        let file = format!("{tracer}.png");
        let size = ["--size", "64x36", "--validation", "--explain", "-o", &file];
        folder.run(&[&["render", "--method", "traced", "--tracer", tracer], &size[..]].concat())
    };
    let query = output("query");
    let [said, printed] = [&query.stderr, &query.stdout].map(|bytes| String::from_utf8_lossy(bytes).into_owned());
    if !has {
        assert_eq!(query.status.code(), Some(2), "{said}");
        assert!(said.contains(" has no ray queries: it lacks ") && said.lines().count() == 1, "{said}");
        return;
    }
    assert_eq!(query.status.code(), Some(0), "{said}");
    assert!(printed.contains("structure for ray queries: "), "{printed}");
    let tree = output("tree");
    let printed = String::from_utf8_lossy(&tree.stdout).into_owned();
    assert!(tree.status.success() && !printed.contains("ray queries"), "{printed}");
    assert_eq!(folder.image("query.png"), folder.image("tree.png"));
}

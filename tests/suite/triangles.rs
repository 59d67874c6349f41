//! Tests rays that are followed among the triangles of a scene (docs/definitions.md, "Triangles"): the device against
//! the hierarchy in 64-bit floats, both ways of reading buffers, and no passes without need.

use crate::common::{Builder, camera, check_validation, gpu, show};
use glam::Vec3;
use ssct::gpu::frame::Mode;
use ssct::gpu::{Gpu, Pixels};
use ssct::methods::setup::BeyondScreen;
use ssct::methods::unified::{FirstTraced, UnifiedParams};
use ssct::methods::{self, EffectParams, MethodInfo, SceneInput, Setup, Wants};
use ssct::passes::PathCode;
use ssct_geometry::bvh::WorldRay;
use ssct_ground::scene::tree::Tree;
use ssct_lab::stage::{Globals, Shot, Stage, gbuffer};
use ssct_scenes::{GBufferData, Material, Scene};
use ssct_truth::reference::first_hits::FirstHits;
use ssct_truth::reference::ray::RaySetup;
use ssct_truth::reference::surface::World;

/// Size of the images in pixels.
pub(crate) const EXTENT: [u32; 2] = [160, 90];

/// Returns the materials of a view as mirrors with flat normals.
pub(crate) fn mirrors(scene: &Scene, view: &str) -> Vec<Material> {
    let view = scene.view(view).unwrap();
    Globals { roughness: Some(0.0), normal_deviation: Some(0.0), ..Globals::default() }.materials(scene, view)
}

/// The results of a method: the G-buffer, the hits, the reflection and the names of the recorded passes.
pub(crate) struct Drawn {
    pub(crate) data: GBufferData,
    hits: Pixels,
    pub(crate) reflection: Pixels,
    recorded: Vec<String>,
}

/// Draws a view of a scene by its name, with a method in a setup. The buffers of triangles are read as blocks of
/// storage if `by_blocks` is true, and else as texels.
pub(crate) fn draw(
    gpu: &Gpu,
    (scene, view): (&Scene, &str),
    materials: Vec<Material>,
    (method, setup): (&MethodInfo, &Setup),
    by_blocks: bool,
) -> Drawn {
    let mut stage = Stage::new(gpu, scene).unwrap();
    stage.scene_mut().read_triangles_as_blocks(by_blocks);
    let camera = scene.view(view).unwrap().camera(scene, EXTENT);
    let shot = Shot::new(&mut stage, method, setup, Wants::HITS, camera, materials).unwrap();
    let (report, _, output) = stage.output_in(Mode::Plain, &shot).unwrap();
    let hits = stage.context.read(output.traced.hits.unwrap().0.all()).unwrap();
    let reflection = gbuffer::reflection(&mut stage.context, &output).unwrap();
    Drawn { data: gbuffer::read(&mut stage.context, &shot).unwrap(), hits, reflection, recorded: report.recorded }
}

/// Returns the method `traced`.
pub(crate) fn traced() -> &'static MethodInfo {
    methods::find("traced").unwrap()
}

/// Returns a setup whose rays go on among triangles. `first` says whether a ray is traced on the screen or among
/// triangles first.
pub(crate) fn beyond(first: FirstTraced) -> Setup {
    Setup::new(EXTENT)
        .with(|p: &mut EffectParams| p.beyond = BeyondScreen::Triangles)
        .with(|p: &mut UnifiedParams| p.first = first)
}

/// Compares the mirror rays of a frame with the world reference. Returns the number of rays that end at a triangle or
/// in the sky, and the number of those that the world ends elsewhere. A hit may be off by 2 cm and 0.5 % of the ray's
/// length.
pub(crate) fn against_world(drawn: &Drawn, scene: &Scene, materials: &[Material]) -> (usize, usize) {
    let world = World::new(scene, materials);
    let ray_setup = RaySetup::new(&drawn.data);
    let data = &drawn.data;
    let view_to_world = data.camera.world_to_view.as_dmat4().inverse();
    let shown = FirstHits::shown(&world, data);
    let eye = data.camera.eye();
    let (mut rays, mut wrong) = (0, 0);
    for (i, found) in drawn.hits.texels().enumerate() {
        let (x, y) = (i as u32 % data.width, i as u32 / data.width);
        assert!(found.iter().all(|v| v.is_finite()), "({x}, {y}): {found:?}");
        let (Some(receiver), Some(direction)) = (&shown.receivers[i], ray_setup.mirror(x, y)) else { continue };
        let code = PathCode::from_channel(found[3]);
        if !matches!(code, Some(PathCode::Triangle | PathCode::Sky)) {
            continue;
        }
        rays += 1;
        let direction = view_to_world.transform_vector3(direction).normalize();
        let ray = WorldRay { origin: receiver.position, direction, t_min: 1e-3, t_max: f64::INFINITY };
        let is_right = match (world.closest(&ray), code) {
            (None, code) => code == Some(PathCode::Sky),
            (Some(hit), Some(PathCode::Triangle)) => {
                // Hits among triangles are stored relative to the eye.
                let hit_position = (eye + Vec3::from_slice(found)).as_dvec3();
                hit_position.distance(ray.point_at(hit.t)) <= 0.02 + 0.005 * hit.t
            }
            _ => false,
        };
        wrong += usize::from(!is_right);
    }
    (rays, wrong)
}

/// In four views, at most one mirror ray of `traced` in 200 ends elsewhere than the 64-bit hierarchy says. A device
/// that walks its tree wrongly misses whole triangles.
#[test]
fn traced_rays_end_where_the_world_says() {
    let gpu = gpu();
    for (name, view) in [("rooms", "cylinder"), ("rooms", "window"), ("street", "car"), ("atrium", "hall")] {
        let scene = crate::common::built_in(name);
        let materials = mirrors(&scene, view);
        let setup = Setup::new(EXTENT);
        let drawn = draw(&gpu, (&scene, view), materials.clone(), (traced(), &setup), false);
        let (rays, wrong) = against_world(&drawn, &scene, &materials);
        // Points of the G-buffer are rounded, so that a ray that grazes an edge may end beside it.
        assert!(rays > 1000 && wrong * 200 <= rays, "{name} {view}: {wrong} of {rays} end elsewhere");
        println!("{name} {view}: {wrong} of {rays}");
    }
    check_validation(&gpu).unwrap();
}

/// With the screen first, at most one ray in 50 ends elsewhere than the world says. With triangles first, the passes of
/// the screen are left out, and `unified` equals `traced`. A ray that is handed over at a wrong place would miss
/// triangles.
#[test]
fn the_screen_and_the_triangles_agree() {
    let gpu = gpu();
    let scene = crate::common::built_in("rooms");
    let materials = mirrors(&scene, "corridor");
    let drawn_with =
        |first| draw(&gpu, (&scene, "corridor"), materials.clone(), (&methods::unified::INFO, &beyond(first)), false);
    let (screen, triangles) = (drawn_with(FirstTraced::Screen), drawn_with(FirstTraced::Triangles));
    let (rays, wrong) = against_world(&screen, &scene, &materials);
    assert!(rays > 1000 && wrong * 50 <= rays, "{wrong} of {rays} end elsewhere");
    let has = |drawn: &Drawn, pass: &str| drawn.recorded.iter().any(|p| p.starts_with(pass));
    assert!(has(&screen, "pyramid") && has(&screen, "triangles/mirrors"), "{:?}", screen.recorded);
    assert!(!has(&triangles, "pyramid") && !has(&triangles, "color"), "{:?}", triangles.recorded);
    // Without a walk over the screen, `unified` makes the image of `traced`.
    let plain = draw(&gpu, (&scene, "corridor"), materials.clone(), (traced(), &Setup::new(EXTENT)), false);
    assert_eq!(plain.reflection.values, triangles.reflection.values);
    check_validation(&gpu).unwrap();
}

/// Buffers of triangles that are read as blocks or as texels give one image, to the bit, at three roughnesses. The two
/// ways are different programs, chosen by the limits of the device.
#[test]
fn blocks_and_texels_give_the_same_image() {
    let gpu = gpu();
    let scene = crate::common::built_in("street");
    for roughness in [0.0, 0.1, 0.4] {
        let view = scene.view("car").unwrap();
        let materials = Globals { roughness: Some(roughness), ..Globals::default() }.materials(&scene, view);
        let setup = beyond(FirstTraced::Screen);
        let draw_reading =
            |by_blocks| draw(&gpu, (&scene, "car"), materials.clone(), (&methods::unified::INFO, &setup), by_blocks);
        let (texels, blocks) = (draw_reading(false), draw_reading(true));
        assert_eq!(texels.reflection.values, blocks.reflection.values, "roughness {roughness}");
        assert!(texels.reflection.values.iter().all(|v| v.is_finite() && *v >= 0.0));
        assert!(texels.reflection.texels().any(|t| t[0] > 0.1), "black at roughness {roughness}");
    }
    check_validation(&gpu).unwrap();
}

/// At reflectivity 0, a frame of `traced` has only the passes that draw the scene. Tracing for no pixel would still
/// cost time.
#[test]
fn without_reflectors_no_triangle_is_asked() {
    let gpu = gpu();
    let scene = crate::common::built_in("rooms");
    let view = scene.view("corridor").unwrap();
    let materials = Globals { reflectivity: 0.0, ..Globals::default() }.materials(&scene, view);
    let mut stage = Stage::new(&gpu, &scene).unwrap();
    let camera = view.camera(&scene, EXTENT);
    let shot = Shot::new(&mut stage, traced(), &Setup::new(EXTENT), Wants::IMAGE, camera, materials).unwrap();
    let (report, _) = stage.run(&shot, Mode::Plain).unwrap();
    let scene_passes = ["g-buffer/depth", "g-buffer", "lighting"];
    assert!(report.recorded.iter().all(|p| scene_passes.contains(&p.as_str())), "{:?}", report.recorded);
}

/// Methods among triangles prepare as many bytes when they share one scene, in either order, as each does alone. The
/// second method would otherwise seem to need no triangles.
#[test]
fn the_triangles_of_a_scene_count_as_prepared_for_each_method_that_uses_them() {
    let gpu = gpu();
    let scene = crate::common::built_in("rooms");
    let camera = scene.view("corridor").unwrap().camera(&scene, EXTENT);
    let prepared_bytes = |methods: &[&MethodInfo]| -> Vec<u64> {
        let mut stage = Stage::new(&gpu, &scene).unwrap();
        let (setup, materials) = (beyond(FirstTraced::Auto), &scene.materials);
        let mut shot = |method: &MethodInfo| {
            Shot::new(&mut stage, method, &setup, Wants::IMAGE, camera, materials.clone()).unwrap()
        };
        let shots: Vec<Shot> = methods.iter().map(|method| shot(method)).collect();
        shots.iter().map(|shot| shot.prepared().device_bytes).collect()
    };
    let unified = &methods::unified::INFO;
    let [of_traced, of_unified] = [traced(), unified].map(|method| prepared_bytes(&[method])[0]);
    assert!(of_traced > 1 << 20 && of_unified > 1 << 20, "{of_traced} and {of_unified} bytes have room for a tree");
    // Where an allocation lands decides by how many bytes it is padded.
    let is_near = |found: u64, expected: u64| found.abs_diff(expected) < 1024;
    for (methods, expected) in
        [([traced(), unified], [of_traced, of_unified]), ([unified, traced()], [of_unified, of_traced])]
    {
        let found = prepared_bytes(&methods);
        assert!(is_near(found[0], expected[0]) && is_near(found[1], expected[1]), "{found:?} instead of {expected:?}");
    }
}

/// With a G-buffer but no scene, `traced` and `unified` among triangles are refused with a sentence. They would have no
/// triangles to read.
#[test]
fn a_g_buffer_alone_has_no_triangles() {
    let gpu = gpu();
    let mut context = ssct::gpu::FrameContext::new(&gpu).unwrap();
    let no_scene: Option<&SceneInput> = None;
    for (method, setup) in [(traced(), Setup::new(EXTENT)), (&methods::unified::INFO, beyond(FirstTraced::Auto))] {
        let effect = methods::Effect::new(&mut context, method, &setup, Wants::IMAGE, no_scene);
        let message = effect.err().expect("refused").to_string();
        assert!(message.contains(method.name) && message.contains("G-buffer alone"), "{message}");
    }
}

/// The tree of each built-in scene has more levels than a tree that divides the list of triangles by halves. So it was
/// built by their neighbourhood, and not by the fallback, whose boxes overlap and are slow.
#[test]
fn no_built_in_scene_has_a_tree_by_halves() {
    for name in ssct_scenes::library::every_name() {
        let scene = crate::common::built_in(name);
        let tree = Tree::build(&scene).unwrap();
        // A node has up to eight children, three halvings in one. A tree by halves is nearly full, and a tree that
        // joins neighbours has more levels.
        let full_levels = scene.triangle_count().next_power_of_two().ilog2().div_ceil(3);
        println!("{name}: {} levels, {full_levels} in a full tree", tree.levels);
        assert!(
            tree.levels > full_levels + 1 || tree.slots.len() < 100,
            "{name}: a tree of {} levels is one by halves",
            tree.levels
        );
    }
}

/// Two walls stand in one place, and the first is all hole: 99 % of the rays show the second, and none the first. A ray
/// that goes on from a hole beyond its distance would miss the second wall.
#[test]
fn behind_a_surface_that_lets_a_ray_pass_the_one_in_the_same_place_stops_it() {
    let gpu = gpu();
    let mut builder = Builder::new("two walls in one place");
    builder.light(Vec3::Z);
    let [passed, stops] = [Vec3::X, Vec3::Y].map(|albedo| builder.matt(albedo));
    // Both walls have masks, which are read at each hit: the first is a hole everywhere, and the second has none.
    for (material, mask) in [(passed, 0), (stops, 255)] {
        builder.picture(1, 1, |_, _| [mask; 3]);
        builder.0.materials[material].alpha_mask = Some(builder.0.textures.len() - 1);
        builder.quad(material, Vec3::new(-30.0, 0.0, 6.0), Vec3::X * 60.0, Vec3::Y * 30.0, -Vec3::Z);
    }
    let mirror = builder.mirror();
    builder.quad(mirror, Vec3::new(-8.0, 0.0, 0.0), Vec3::X * 16.0, Vec3::Z * 5.9, Vec3::Y);
    let seen_from = camera(Vec3::new(0.0, 1.2, 0.0), Vec3::new(0.0, 0.6, 4.0), EXTENT);
    let shown = show(&gpu, &builder.0, seen_from, "traced", &Setup::new(EXTENT), &Globals::default());
    let (reflection, material) = (shown.get("reflection"), shown.get("material"));
    let floor = reflection.texels().zip(material.texels()).filter(|(_, material)| material[0] > 0.5);
    let (shows_second, shows_first): (Vec<_>, Vec<_>) =
        floor.map(|(color, _)| (color[1] > 0.1, color[0] > 0.1)).unzip();
    let count_true = |flags: &[bool]| flags.iter().filter(|flag| **flag).count();
    assert!(
        shows_second.len() > 3000 && count_true(&shows_first) == 0,
        "{} rays see what they pass",
        count_true(&shows_first)
    );
    assert!(
        count_true(&shows_second) * 100 > 99 * shows_second.len(),
        "{} of {} rays are stopped",
        count_true(&shows_second),
        shows_second.len()
    );
}

/// A G-buffer that was read back does not know its triangles. Fewer than one pixel in 100 shows another step of stairs
/// over a mirror than the traced rays. A screen hit without a triangle could take any triangle nearby for its own.
#[test]
fn a_hit_on_a_pixel_of_unknown_triangle_is_not_confirmed_by_another_triangle() {
    let gpu = gpu();
    // The stairs are tried in two directions, so that either time another triangle is the first of the tree.
    for (along, side) in [(Vec3::Z, 1.0), (-Vec3::Z, -1.0)] {
        let mut builder = Builder::new("stairs over a mirror");
        builder.light(along);
        let mirror = builder.mirror();
        builder.quad(mirror, Vec3::new(-8.0, 0.0, 0.0), Vec3::X * 16.0, along * 7.0, Vec3::Y);
        for step in 0..6 {
            let albedo = Vec3::new((step % 2) as f32, (step / 2 % 2) as f32, 1.0);
            let (material, height) = (builder.matt(albedo), 0.5 + 0.5 * step as f32);
            let corner = Vec3::new(-8.0, 0.0, 0.0) + along * (3.5 + height);
            builder.quad(material, corner, Vec3::X * 16.0, Vec3::Y * height, -along);
        }
        let seen_from = camera(Vec3::Y * 1.2, Vec3::new(0.0, 0.8, 4.0 * side), EXTENT);
        let mut stage = Stage::new(&gpu, &builder.0).unwrap();
        let setup = Setup::new(EXTENT);
        let shot =
            Shot::new(&mut stage, traced(), &setup, Wants::IMAGE, seen_from, builder.0.materials.clone()).unwrap();
        stage.run(&shot, Mode::Plain).unwrap();
        // The G-buffer that is read back has no numbers of triangles.
        let data = gbuffer::read(&mut stage.context, &shot).unwrap();
        let reflect = |method, setup| gbuffer::reflect_in(&gpu, &builder.0, &data, method, setup).unwrap().reflection;
        let (screen, world) =
            (reflect(&methods::unified::INFO, &beyond(FirstTraced::Screen)), reflect(traced(), &setup));
        let differ = |(first, second): (&[f32], &[f32])| (0..3).any(|c| (first[c] - second[c]).abs() > 0.05);
        let pixels: Vec<_> = screen.texels().zip(world.texels()).filter(|(_, world)| world[2] > 0.1).collect();
        let wrong = pixels.iter().filter(|pair| differ(**pair)).count();
        println!("{wrong} of {} pixels show another step", pixels.len());
        assert!(pixels.len() > 2000 && wrong * 100 < pixels.len(), "{wrong} of {} show another step", pixels.len());
    }
    check_validation(&gpu).unwrap();
}

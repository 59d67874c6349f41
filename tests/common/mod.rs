//! Code that the tests share: devices under the validation layers, small scenes built in code, and images of them. Each
//! test program uses a part of it.

#![allow(dead_code)]

pub mod engine;
pub mod folder;
pub mod hang;
pub mod html;
pub mod images;
pub mod sources;

use glam::Vec3;
use ssct::gpu::{DeviceQuery, Gpu, Pixels};
use ssct::methods::setup::CaptureSide;
use ssct::methods::{self, EffectParams, MethodInfo, Setup, Wants};
use ssct_ground::parameter::Value;
use ssct_lab::stage::image::{RenderedImage, render};
use ssct_lab::stage::{Globals, Shot, Stage, gbuffer};
use ssct_scenes::{
    Aabb, AreaLight, AreaShape, Camera, Encoding, Impostor, Lens, Light, LoadOptions, Material, Mesh, Scene, Surface,
    Texture, Vertex, View, library, scene_file,
};
use ssct_truth::reference::first_hits::FirstHits;
use ssct_truth::reference::surface::World;
use ssct_truth::reference::world::WorldReference;
use std::num::NonZero;
use std::ops::Deref;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Mutex, OnceLock, PoisonError};

/// Returns a device under the validation layers for one test at a time. Validation is GPU-assisted too if the variable
/// SSCT_GPU_AV is 1.
///
/// All devices are made before the first is used, and none is destroyed. The layers keep devices in a table that they
/// read in every call without a lock. They crash where another thread makes or destroys a device meanwhile
/// (KhronosGroup/Vulkan-ValidationLayers issue 4391).
pub fn gpu() -> PooledGpu {
    let mut free = POOL.get_or_init(|| Mutex::new(new_pool())).lock().unwrap_or_else(PoisonError::into_inner);
    PooledGpu(Some(free.pop().unwrap_or_else(own_gpu)))
}

/// Opens a new device like those of [`gpu`], which is destroyed after use. Tests of a device's whole life use it.
pub fn own_gpu() -> Gpu {
    Gpu::open(&DeviceQuery { validation: true, gpu_assisted: is_gpu_assisted(), ..DeviceQuery::default() }).unwrap()
}

/// The devices that no test uses now.
static POOL: OnceLock<Mutex<Vec<Gpu>>> = OnceLock::new();

/// Opens as many devices as tests run at a time by default: one for each thread of the machine.
fn new_pool() -> Vec<Gpu> {
    let threads = std::thread::available_parallelism().map_or(1, NonZero::get);
    (0..threads).map(|_| own_gpu()).collect()
}

/// A device of [`gpu`], which goes back to the pool when its test ends. It is `None` only while it is dropped.
pub struct PooledGpu(Option<Gpu>);

impl Deref for PooledGpu {
    type Target = Gpu;

    fn deref(&self) -> &Gpu {
        self.0.as_ref().unwrap()
    }
}

impl Drop for PooledGpu {
    fn drop(&mut self) {
        let gpu = self.0.take().unwrap();
        if std::thread::panicking() {
            // A test that failed may leave anything on the device, so that no other test gets it. It is not destroyed
            // while other threads use theirs.
            std::mem::forget(gpu);
        } else {
            POOL.get().unwrap().lock().unwrap_or_else(PoisonError::into_inner).push(gpu);
        }
    }
}

/// A failure that is expected on a driver and is no fault of this program (`tests/expected_failures.toml`).
#[derive(serde::Deserialize)]
struct Expected {
    /// The way of testing that fails, such as "gpu-assisted".
    mode: String,
    /// A part of the driver's name, in small letters.
    driver: String,
    /// The message or the test that fails.
    id: String,
    reason: String,
}

/// Returns the ids of the failures that are expected in a mode of testing on the driver of a device.
pub fn expected_failures(mode: &str, gpu: &Gpu) -> Vec<String> {
    #[derive(serde::Deserialize)]
    struct File {
        expected: Vec<Expected>,
    }
    let text = include_str!("../expected_failures.toml");
    let failures = toml::from_str::<File>(text).unwrap().expected;
    assert!(failures.iter().all(|e| !e.reason.trim().is_empty()), "a reason for each");
    let driver = gpu.info().driver.to_lowercase();
    let is_expected = |e: &Expected| e.mode == mode && driver.contains(&e.driver);
    failures.into_iter().filter(is_expected).map(|e| e.id).collect()
}

/// Returns the share of pixels that may differ where images should be equal to the bit. It is 0 on the drivers that the
/// program is developed on. On others it is 0.5 %, since their compilers may fuse a product and a sum in one program
/// alone.
pub fn tolerated_share(gpu: &Gpu) -> f64 {
    let driver = gpu.info().driver.to_lowercase();
    let is_known = ["mesa 22", "mesa 25", "swiftshader"].iter().any(|known| driver.contains(known));
    if is_known { 0.0 } else { 0.005 }
}

/// Returns whether [`gpu`] opens devices under GPU-assisted validation.
pub fn is_gpu_assisted() -> bool {
    std::env::var_os("SSCT_GPU_AV").is_some_and(|v| v == "1")
}

/// Returns an error if the validation layers reported anything that is neither on the allow-list nor expected of the
/// driver.
pub fn check_validation(gpu: &Gpu) -> Result<(), String> {
    let expected = if is_gpu_assisted() { expected_failures("gpu-assisted", gpu) } else { Vec::new() };
    let unexpected: Vec<_> = gpu.violations().into_iter().filter(|m| !expected.contains(&m.id)).collect();
    ssct::gpu::validation::check(&unexpected).map_err(|e| e.to_string())
}

/// Returns the root of the repository, which is the parent of the package's folder.
pub fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap()
}

/// Returns the folder of the scenes that are too large for the repository. If it is absent, a line tells that the test
/// is skipped.
pub fn shared_scenes() -> Option<PathBuf> {
    let folder = repository().join("../shared/scenes");
    if !folder.is_dir() {
        println!("skipped: ../shared/scenes is absent");
        return None;
    }
    Some(folder)
}

/// Loads Crytek Sponza, or returns `None` if the large scenes are absent. Its scene file has left-handed places without
/// a mark that says so. `scripts/left_handed.sh` makes a copy with this mark, and the copy is loaded, as for
/// measurements.
pub fn sponza() -> Option<Scene> {
    let file = shared_scenes()?.join("sponza/sponza.scene.toml");
    let folder = tempfile::tempdir().expect("a folder");
    let copy = folder.path().join("sponza.scene.toml");
    let status = Command::new(repository().join("scripts/left_handed.sh")).arg(file).arg(&copy).status();
    assert!(status.expect("the script runs").success());
    Some(scene_file::load(&copy, &LoadOptions::default()).expect("sponza"))
}

/// Returns a built-in scene. Each is made once for all tests of the program, since drawing its textures takes time.
pub fn built_in(name: &str) -> Scene {
    static NAMED_SCENES: Mutex<Vec<(String, Scene)>> = Mutex::new(Vec::new());
    let mut named_scenes = NAMED_SCENES.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((_, scene)) = named_scenes.iter().find(|(known, _)| known == name) {
        return scene.clone();
    }
    let scene = library::scene(name).expect("a built-in scene");
    named_scenes.push((name.to_owned(), scene.clone()));
    scene
}

/// Builds a scene in code: materials, quads and lights are added to the scene that it holds.
pub struct Builder(pub Scene);

impl Builder {
    /// Returns an empty scene with the default lens.
    pub fn new(name: &str) -> Self {
        Self(Scene { name: name.into(), views: vec![View::default()], ..Scene::default() })
    }

    /// Adds a material; returns its index.
    pub fn material(&mut self, material: Material) -> usize {
        self.0.materials.push(material);
        self.0.materials.len() - 1
    }

    /// Adds a material of one albedo that reflects nothing; returns its index.
    pub fn matt(&mut self, albedo: Vec3) -> usize {
        self.material(Material { albedo, reflectivity: 0.0, ..Material::default() })
    }

    /// Adds a black mirror, whose lit colour is 0, so that the composite is the reflection alone; returns its index.
    pub fn mirror(&mut self) -> usize {
        self.material(Material { albedo: Vec3::ZERO, reflectivity: 1.0, ..Material::default() })
    }

    /// Adds a matt material with a picture in sRGB, whose texels `texel` gives; returns its index.
    pub fn picture(&mut self, width: u32, height: u32, texel: impl Fn(u32, u32) -> [u8; 3]) -> usize {
        let texels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let rgba = texels.flat_map(|(x, y)| [texel(x, y).as_slice(), &[255]].concat()).collect();
        self.0.textures.push(Texture { name: "picture".into(), width, height, rgba, encoding: Encoding::Srgb });
        let albedo_map = Some(self.0.textures.len() - 1);
        self.material(Material { albedo_map, reflectivity: 0.0, ..Material::default() })
    }

    /// Adds a rectangle of a material. `corner` is its lower left corner, `right` and `up` are its sides, along the
    /// axes of its texture, and its front faces along `normal`.
    pub fn quad(&mut self, material: usize, corner: Vec3, right: Vec3, up: Vec3, normal: Vec3) {
        let tangent = right.normalize();
        let handedness = normal.cross(tangent).dot(up).signum();
        let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        let vertices: Vec<_> = corners
            .into_iter()
            .map(|(u, v)| Vertex {
                position: (corner + right * u + up * v).to_array(),
                normal: normal.normalize().to_array(),
                uv: [u, 1.0 - v],
                tangent: tangent.extend(handedness).to_array(),
            })
            .collect();
        // The triangles' winding must agree with the normal, so that the front is drawn.
        let indices = if right.cross(up).dot(normal) > 0.0 { vec![0, 1, 2, 0, 2, 3] } else { vec![0, 2, 1, 0, 3, 2] };
        let bounds = Aabb::around(&vertices);
        self.0.meshes.push(Mesh { name: "quad".into(), vertices, indices, material, bounds });
    }

    /// Adds parallel light along `direction`. A surface that faces the light is as bright as its albedo.
    pub fn light(&mut self, direction: Vec3) {
        self.0.lights.push(Light::Directional { direction: direction.normalize(), energy: 1.0 });
    }
}

/// Returns a mirror floor before a wall with a texture: two meshes and one texture.
pub fn two_quads() -> Scene {
    let mut b = Builder::new("two quads");
    b.light(Vec3::new(0.3, -0.6, 1.0));
    let (mirror, wall) = (b.mirror(), b.picture(4, 4, |x, y| [50 * x as u8, 50 * y as u8, 200]));
    b.quad(mirror, Vec3::new(-4.0, 0.0, 0.0), Vec3::X * 8.0, Vec3::Z * 8.0, Vec3::Y);
    b.quad(wall, Vec3::new(-4.0, 0.0, 6.0), Vec3::X * 8.0, Vec3::Y * 4.0, Vec3::NEG_Z);
    b.0
}

/// Returns many quads at many depths and angles, mirrors among them, over a reflecting floor, with sky between. Every
/// call returns the same scene.
pub fn clutter() -> Scene {
    let mut b = Builder::new("clutter");
    b.light(Vec3::new(0.3, -0.6, 1.0));
    let mut state = 12345_u32;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32
    };
    let mirror = b.mirror();
    let floor = b.picture(64, 64, |x, y| if (x / 4 + y / 4) % 2 == 0 { [230, 200, 160] } else { [60, 70, 110] });
    b.0.materials[floor].reflectivity = 0.6;
    b.quad(floor, Vec3::new(-12.0, 0.0, 0.0), Vec3::X * 24.0, Vec3::Z * 40.0, Vec3::Y);
    for n in 0..40 {
        let material = if n % 3 == 0 { mirror } else { b.matt(Vec3::new(random(), random(), random())) };
        let z = 1.5 + 28.0 * random() * random();
        let centre = Vec3::new((random() - 0.5) * 1.6 * z, random() * 0.5 * z, z);
        let turn = (random() - 0.5) * 2.0;
        let right = Vec3::new(turn.cos(), 0.0, turn.sin()) * (0.2 + 1.5 * random());
        let up = Vec3::new(0.0, 1.0, 0.4 * (random() - 0.5)) * (0.2 + 1.5 * random());
        b.quad(material, centre, right, up, up.cross(right));
    }
    // A few methods reflect nothing but impostors or area lights.
    let impostor = |centre, half_u| Impostor { name: "sign".into(), centre, half_u, half_v: Vec3::NEG_Y, texture: 0 };
    b.0.impostors = vec![
        impostor(Vec3::new(1.0, 2.0, 12.0), Vec3::X * 3.0),
        impostor(Vec3::new(-4.0, 1.5, 9.0), Vec3::new(0.7, 0.0, 0.7)),
    ];
    let shapes = [
        AreaShape::Sphere { centre: Vec3::new(-2.0, 2.0, 8.0), radius: 0.6 },
        AreaShape::Capsule { a: Vec3::new(0.0, 1.0, 6.0), b: Vec3::new(1.5, 2.0, 9.0), radius: 0.1 },
        AreaShape::Rectangle { centre: Vec3::new(3.0, 2.0, 10.0), half_u: Vec3::X, half_v: -0.5 * Vec3::Y },
    ];
    b.0.area_lights = shapes.map(|shape| AreaLight { shape, radiance: Vec3::new(1.0, 0.9, 0.7) }).to_vec();
    b.0
}

/// Returns a setup whose captures, if it has any, have as few texels as one may ask for. Drawing them at their usual
/// size takes a second.
pub fn with_small_captures(setup: &Setup) -> Setup {
    setup.with(|p: &mut EffectParams| p.capture_side = CaptureSide::Side128)
}

/// Returns what a record of a setup has for a method and the effect: names of parameters with their values as text. The
/// preset and values that `is_wanted` refuses are left out.
pub fn values(method: &MethodInfo, setup: &Setup, is_wanted: fn(&Value) -> bool) -> Vec<(&'static str, String)> {
    let wanted = setup.recorded(Some(method)).into_iter().filter(|(name, value)| *name != "preset" && is_wanted(value));
    wanted.map(|(name, value)| (name, value.to_string())).collect()
}

/// Returns the camera that sees [`clutter`], for an image size in pixels.
pub fn clutter_camera(extent: [u32; 2]) -> Camera {
    camera(Vec3::new(0.0, 1.4, 0.0), Vec3::new(0.0, 1.0, 6.0), extent)
}

/// Returns a camera with the default lens at `eye`, which looks at the point `look_at`, for an image size in pixels.
pub fn camera(eye: Vec3, look_at: Vec3, extent: [u32; 2]) -> Camera {
    Camera::new(eye, look_at, Lens::default(), extent[0] as f32 / extent[1] as f32)
}

/// A rendered image with all images of its passes, and its camera.
pub struct Shown {
    pub image: RenderedImage,
    pub camera: Camera,
}

impl Shown {
    /// Returns level 0 of the intermediate image of a name, or the image itself if it has no levels.
    pub fn get(&self, name: &str) -> &Pixels {
        self.levels(name)[0]
    }

    /// Returns whether the method made an intermediate image of this name.
    pub fn has(&self, name: &str) -> bool {
        self.image.intermediates.as_ref().unwrap().iter().any(|(stem, ..)| stem == name)
    }

    /// Returns all levels of the intermediate image of a name, whose own names are NAME, or NAME-0, NAME-1 and so on.
    pub fn levels(&self, name: &str) -> Vec<&Pixels> {
        let intermediates = self.image.intermediates.as_ref().unwrap();
        let is_level = |stem: &str| {
            stem == name
                || stem.strip_prefix(name).and_then(|s| s.strip_prefix('-')).is_some_and(|n| n.parse::<u32>().is_ok())
        };
        let named = intermediates.iter().filter(|(stem, ..)| is_level(stem));
        let levels: Vec<_> = named.map(|(_, _, pixels)| pixels).collect();
        assert!(!levels.is_empty(), "no intermediate {name}");
        levels
    }
}

/// Renders a scene by a method, and reads back the image, every intermediate image and the hits. Panics on any message
/// of the validation layers.
pub fn show(gpu: &Gpu, scene: &Scene, camera: Camera, method: &str, setup: &Setup, globals: &Globals) -> Shown {
    show_with(gpu, scene, (camera, globals), method, setup, Wants::HITS)
}

/// Renders a scene as [`show`] does. The tuple has the camera and the overrides of materials, and `wants` says what is
/// read back beside the image.
pub fn show_with(
    gpu: &Gpu,
    scene: &Scene,
    (camera, globals): (Camera, &Globals),
    method: &str,
    setup: &Setup,
    wants: Wants,
) -> Shown {
    let mut stage = Stage::new(gpu, scene).unwrap();
    let materials = globals.materials(scene, &View::default());
    let shot = Shot::new(&mut stage, methods::find(method).unwrap(), setup, wants, camera, materials).unwrap();
    let image = render(&mut stage, &shot, true).unwrap();
    gpu.check_validation().unwrap();
    Shown { image, camera }
}

/// The reflection that a method makes of a scene, and the reflection that rays among the triangles find: one ray for
/// each pixel.
pub struct Truth {
    pub reflection: Pixels,
    /// Linear RGB for each pixel, as the triangles say.
    pub world: Vec<Vec3>,
    /// The surfaces that the pixels show, which are where the rays start.
    pub first_hits: FirstHits,
}

/// Renders a scene by a method, and traces one ray among the triangles from each first hit of the same G-buffer. Panics
/// on any message of the validation layers.
pub fn beside_truth(gpu: &Gpu, scene: &Scene, camera: Camera, method: &str, setup: &Setup, globals: &Globals) -> Truth {
    let mut stage = Stage::new(gpu, scene).unwrap();
    let materials = globals.materials(scene, &View::default());
    let method = methods::find(method).unwrap();
    let shot = Shot::new(&mut stage, method, setup, Wants::REFLECTION, camera, materials).unwrap();
    let reflection = render(&mut stage, &shot, false).unwrap().reflection;
    gpu.check_validation().unwrap();
    let first_hits = FirstHits::from_gbuffer(&gbuffer::read(&mut stage.context, &shot).unwrap());
    let world = World::new(scene, &scene.materials);
    let reference = WorldReference::of_centres(&world, &first_hits, 1);
    let mut state = reference.start();
    reference.add(&mut state, 1);
    let world = reference.image(&state).reflection;
    Truth { reflection, world, first_hits }
}

/// Returns a setup, for a size in pixels, in which reflections do not fade and rays end on the screen alone.
pub fn unfaded(extent: [u32; 2]) -> Setup {
    Setup::on_screen(extent).with(|p: &mut EffectParams| p.fade = false)
}

/// Returns a material that shows the sky.
pub fn window() -> Material {
    Material { surface: Surface::Sky, ..Material::default() }
}

/// Samples an image at texture coordinates, bilinearly and clamped to the edge. Returns three channels; an image of one
/// channel gives it three times.
pub fn bilinear(image: &Pixels, u: f32, v: f32) -> [f32; 3] {
    let (x, y) = (u * image.width as f32 - 0.5, v * image.height as f32 - 0.5);
    let (fx, fy) = (x - x.floor(), y - y.floor());
    let texel = |dx: i32, dy: i32| {
        let clamp = |v: f32, d: i32, side: u32| (v.floor() as i32).saturating_add(d).clamp(0, side as i32 - 1) as u32;
        image.texel(clamp(x, dx, image.width), clamp(y, dy, image.height))
    };
    [0, 1, 2].map(|c| c.min(image.channels - 1)).map(|c| {
        let row = |dy| texel(0, dy)[c] * (1.0 - fx) + texel(1, dy)[c] * fx;
        row(0) * (1.0 - fy) + row(1) * fy
    })
}

/// The seven weights of the thesis's blur (§4.3.2).
pub const BLUR_WEIGHTS: [f32; 7] = [0.002, 0.028, 0.233, 0.474, 0.233, 0.028, 0.002];

/// Blurs an image by [`BLUR_WEIGHTS`] in one direction, and returns the result at a width and height in texels. `step`
/// leads from one tap to the next, in texture coordinates.
pub fn blur(image: &Pixels, width: u32, height: u32, step: [f32; 2]) -> Pixels {
    let mut values = Vec::new();
    for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
        let (u, v) = ((x as f32 + 0.5) / width as f32, (y as f32 + 0.5) / height as f32);
        let mut sum = [0.0; 3];
        for (weight, tap) in BLUR_WEIGHTS.into_iter().zip(-3..=3) {
            let sample = bilinear(image, u + tap as f32 * step[0], v + tap as f32 * step[1]);
            sum = [0, 1, 2].map(|c| sum[c] + weight * sample[c]);
        }
        values.extend(sum);
    }
    Pixels { width, height, channels: 3, values }
}

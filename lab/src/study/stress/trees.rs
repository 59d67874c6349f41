//! Scenes whose triangles break trees and walks: a single triangle, slivers, triangles in one plane, far from the
//! origin, inside a closed box, behind holes, and planes a millimetre apart. Methods that follow rays among triangles
//! must show a sound number in every pixel, end every ray, and end it where it ends in the world.

use super::captures::ROUGHNESS;
use super::lineup::{FrameImages, SceneMethods};
use super::{ComparedRays, JudgedFrame, StressRecord};
use crate::error::Result;
use crate::stage::Globals;
use crate::stage::gbuffer::ray_ends;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use ssct::gpu::Gpu;
use ssct::methods::unified::{FirstTraced, UnifiedParams};
use ssct::methods::{MethodInfo, Setup};
use ssct_geometry::bvh::WorldRay;
use ssct_ground::math::constants::ROUNDING;
use ssct_ground::math::random::Stream;
use ssct_scenes::{Aabb, Encoding, GBufferData, Lens, Light, Material, Mesh, Scene, Texture, Vertex, View};
use ssct_truth::metrics::place::RayEnd;
use ssct_truth::reference::first_hits::FirstHits;
use ssct_truth::reference::ray::RaySetup;
use ssct_truth::reference::surface::World;

/// The least share of the mirror rays that must end where they end in the world, with ties counted as right, if
/// triangles are traced first.
const RIGHT_ENDS_TRIANGLES_FIRST: f64 = 0.999;
/// The least share, as in [`RIGHT_ENDS_TRIANGLES_FIRST`], if the screen is traced first. On the screen a hit is
/// confirmed by the triangle of its pixel alone, whatever else the ray may pass.
const RIGHT_ENDS_SCREEN_FIRST: f64 = 0.98;

/// Tolerance of the place where a ray ends, as a share of the ray's length. It is so small that a ray must meet the
/// right one of two planes a millimetre apart.
const PLACE_SHARE: f64 = 1e-4;

/// Tolerance like [`PLACE_SHARE`] for a ray that meets slivers. The weights of a sliver's corners are differences of
/// products that are 10^5 times as large as its area, and lose five of their digits.
const PLACE_SHARE_ON_SLIVERS: f64 = 1e-3;

/// The greatest rounding of a scene's coordinates, in metres, at which ends are compared.
const COMPARED_ROUNDING_M: f64 = 1e-3;

/// A case: a scene of triangles.
pub struct TreeCase {
    /// Name of the case in records.
    pub name: String,
    /// Makes the scene.
    make: Box<dyn Fn() -> Scene>,
    /// Tolerance of the place where a ray ends, as a share of the ray's length.
    place_share: f64,
}

/// Makes every case; `most_triangles` is the number of triangles of the largest.
pub fn cases(most_triangles: usize) -> Vec<TreeCase> {
    let case = |name: String, make: Box<dyn Fn() -> Scene>| TreeCase {
        name: format!("triangles {name}"),
        make,
        place_share: PLACE_SHARE,
    };
    let slivers = case(format!("{most_triangles} slivers"), Box::new(move || slivers(most_triangles)));
    let mut all = vec![
        case("one alone".into(), Box::new(single_triangle)),
        TreeCase { place_share: PLACE_SHARE_ON_SLIVERS, ..slivers },
        case("all in one plane".into(), Box::new(|| one_plane(5_000))),
        case("all the same".into(), Box::new(|| copies(500))),
        case("in a closed box, seen from inside".into(), Box::new(|| closed_box(0.0))),
        case("in a closed box, 1000 km from the origin".into(), Box::new(|| closed_box(1e6))),
        case("behind 40 planes of holes".into(), Box::new(|| behind_holes(40))),
    ];
    for distance in [1.0, 100.0, 10_000.0] {
        let name = format!("of planes a millimetre apart, {distance} m away");
        all.push(case(name, Box::new(move || near_planes(distance))));
    }
    all
}

impl TreeCase {
    /// Makes the line-up of methods on the case's scene, which trace the triangles or the screen first, as `first`
    /// says.
    ///
    /// # Errors
    /// Errors of the device.
    pub fn lineup(
        &self,
        gpu: &Gpu,
        extent: [u32; 2],
        first: FirstTraced,
        methods: &[&'static MethodInfo],
    ) -> Result<SceneMethods> {
        let setup = Setup::new(extent).with(|p: &mut UnifiedParams| p.first = first);
        SceneMethods::with_hits(gpu, (self.make)(), &setup, methods)
    }
}

/// Runs methods on a case, with the triangles and with the screen traced first, as mirrors and as glossy surfaces, and
/// makes a record of each run.
///
/// # Errors
/// Errors of the device.
pub fn run(gpu: &Gpu, case: &TreeCase, extent: [u32; 2], methods: &[&'static MethodInfo]) -> Result<Vec<StressRecord>> {
    let mut records = Vec::new();
    for (first, order_name, required_share) in [
        (FirstTraced::Triangles, "triangles first", RIGHT_ENDS_TRIANGLES_FIRST),
        (FirstTraced::Screen, "screen first", RIGHT_ENDS_SCREEN_FIRST),
    ] {
        let mut lineup = case.lineup(gpu, extent, first, methods)?;
        let view = lineup.scene.views[0].clone();
        let camera = view.camera(&lineup.scene, extent);
        for roughness in ROUGHNESS {
            let globals = Globals { roughness: Some(roughness), ..Globals::default() };
            let materials = globals.materials(&lineup.scene, &view);
            lineup.set_materials(&materials)?;
            let Some(data) = lineup.draw(camera)? else { continue };
            let frames = lineup.read_images()?;
            // On a device that does not number triangles, rays begin at points that follow from depth, too inexactly.
            let is_compared =
                roughness == 0.0 && gpu.numbers_triangles() && rounding_m(&lineup.scene) <= COMPARED_ROUNDING_M;
            let truth = is_compared.then(|| Truth::new(&lineup.scene, &materials, &data, case.place_share));
            let name = format!("{}, {order_name}, roughness {roughness}", case.name);
            let judged = JudgedFrame { case: &name, setup: &lineup.setup, globals: &globals, must_pass: true };
            records.extend(lineup.methods().zip(&frames).map(|(m, frame)| {
                let compared = truth.as_ref().and_then(|truth| truth.compare(frame, &data, required_share));
                frame.judge(gpu, &judged, m, &data, compared)
            }));
        }
    }
    Ok(records)
}

/// Returns the rounding of a scene's coordinates: half a unit in the last place of the greatest coordinate, in metres.
fn rounding_m(scene: &Scene) -> f64 {
    let bounds = scene.bounds();
    ROUNDING * f64::from(bounds.min.abs().max(bounds.max.abs()).max_element())
}

/// The mirror rays of a G-buffer, and the triangles among which they end.
struct Truth<'a> {
    world: World<'a>,
    /// Indices of the reflecting pixels whose mirror ray leads above the pixel's surface, each with the ray.
    rays: Vec<(usize, WorldRay)>,
    /// Rounding of the point where a ray begins, in metres.
    rounding_m: f64,
    /// Tolerance of the place where a ray ends, as a share of the ray's length.
    place_share: f64,
}

impl<'a> Truth<'a> {
    /// Finds the mirror rays of a G-buffer in the scene that it shows.
    fn new(scene: &'a Scene, materials: &'a [Material], data: &GBufferData, place_share: f64) -> Self {
        let world = World::new(scene, materials);
        let first_hits = FirstHits::shown(&world, data);
        let view_to_world = data.camera.world_to_view.as_dmat4().inverse();
        let ray_setup = RaySetup::new(data);
        let pixel_and_ray = |i: usize| {
            let receiver = first_hits.receivers[i].as_ref()?;
            let in_view = ray_setup.mirror(i as u32 % data.width, i as u32 / data.width)?;
            let direction = view_to_world.transform_vector3(in_view).normalize();
            let origin = receiver.position;
            // A ray begins a tenth of a millimetre off its surface, lest it meet this surface again.
            let ray = WorldRay { origin, direction, t_min: 1e-4, t_max: f64::INFINITY };
            receiver.is_above(direction).then_some((i, ray))
        };
        let rays = (0..data.depth.len()).filter_map(pixel_and_ray).collect();
        Self { world, rays, rounding_m: rounding_m(scene), place_share }
    }

    /// Whether the end that a method reports of a ray is the ray's end in the world, within the tolerances.
    fn is_right(&self, ray: &WorldRay, end: &RayEnd) -> bool {
        match (self.world.closest(ray), end) {
            (None, end) => *end == RayEnd::Sky,
            (Some(hit), RayEnd::Place(place)) => {
                place.distance(ray.point_at(hit.t)) <= self.place_share * hit.t + 64.0 * self.rounding_m
            }
            (Some(_), _) => false,
        }
    }

    /// Whether rounding alone explains the end that a method reports of a pixel's ray. Random rays are tried, 32 of
    /// them, whose direction and start differ from those of the ray by up to 16 roundings of an f32. The end is a tie
    /// if one of them ends there in the world.
    fn is_tie(&self, ray: &WorldRay, end: &RayEnd, pixel: usize) -> bool {
        let random = Stream::new(23, pixel as u64);
        // A random vector with coordinates from −1 to 1.
        let offset = |n: u64| DVec3::from_array([0, 1, 2].map(|axis| 2.0 * random.uniform(3 * n + axis) - 1.0));
        (0..32_u64).any(|n| {
            let direction = (ray.direction + 16.0 * ROUNDING * offset(2 * n)).normalize();
            let origin = ray.origin + 16.0 * self.rounding_m * offset(2 * n + 1);
            self.is_right(&WorldRay { origin, direction, ..*ray }, end)
        })
    }

    /// Compares the ends of the rays in a method's frame with their ends in the world; `required_share` of them must be
    /// right. `None` for a method without hits.
    fn compare(&self, frame: &FrameImages, data: &GBufferData, required_share: f64) -> Option<ComparedRays> {
        let ends = ray_ends(frame.hits.as_ref()?, data);
        let wrong: Vec<&(usize, WorldRay)> =
            self.rays.par_iter().filter(|(i, ray)| !self.is_right(ray, &ends[*i])).collect();
        let ties = wrong.par_iter().filter(|(i, ray)| self.is_tie(ray, &ends[*i], *i)).count();
        Some(ComparedRays { rays: self.rays.len(), wrong: wrong.len(), ties: Some(ties), required_share })
    }
}

/// The corners of a triangle, and the index of its material.
type MeshTriangle = ([Vec3; 3], usize);

/// Makes a scene of single triangles, each with its own flat normal, with one view from `eye` towards `look_at`;
/// `far_m` is the distance of the far plane.
fn scene(name: &str, triangles: impl IntoIterator<Item = MeshTriangle>, eye: Vec3, look_at: Vec3, far_m: f32) -> Scene {
    let materials = [mirror(), paint(), holes()];
    let mut meshes: Vec<Mesh> = (0..materials.len())
        .map(|material| Mesh { name: format!("{name}-{material}"), material, ..Mesh::default() })
        .collect();
    for (corners, material) in triangles {
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or(Vec3::Y);
        let first_edge = (corners[1] - corners[0]).normalize_or(Vec3::X);
        let mesh = &mut meshes[material];
        for (corner, uv) in corners.into_iter().zip([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]) {
            mesh.indices.push(mesh.vertices.len() as u32);
            let tangent = first_edge.extend(1.0).to_array();
            mesh.vertices.push(Vertex { position: corner.to_array(), normal: normal.to_array(), uv, tangent });
        }
    }
    meshes.retain(|mesh| !mesh.indices.is_empty());
    meshes.iter_mut().for_each(|mesh| mesh.bounds = Aabb::around(&mesh.vertices));
    let view = View { name: "stress".into(), eye, look_at, ..View::default() };
    Scene {
        name: format!("triangles {name}"),
        meshes,
        materials: materials.into(),
        textures: vec![mask()],
        lights: vec![Light::Directional { direction: Vec3::new(0.3, -0.8, 0.5).normalize(), energy: 0.8 }],
        lens: Lens { near_m: 0.1, far_m, ..Lens::default() },
        views: vec![view],
        ..Scene::default()
    }
}

/// Material 0: a mirror.
fn mirror() -> Material {
    Material { name: "mirror".into(), albedo: Vec3::splat(0.2), ..Material::default() }
}

/// Material 1: paint, which reflects nothing.
fn paint() -> Material {
    Material { name: "paint".into(), albedo: Vec3::new(0.8, 0.5, 0.3), reflectivity: 0.0, ..Material::default() }
}

/// Material 2: paint with holes.
fn holes() -> Material {
    Material { name: "holes".into(), alpha_mask: Some(0), ..paint() }
}

/// A texture of 4×4 texels in a chequerboard of paint and holes.
fn mask() -> Texture {
    let texel = |i: u32| [if (i % 4 + i / 4).is_multiple_of(2) { 255 } else { 0 }; 4];
    let rgba = (0..16).flat_map(texel).collect();
    Texture { name: "mask".into(), width: 4, height: 4, rgba, encoding: Encoding::Linear }
}

/// Makes a parallelogram of two triangles, with the corner `origin` and the edges `a` and `b`. It faces in the
/// direction of their cross product.
fn quad(origin: Vec3, a: Vec3, b: Vec3, material: usize) -> [MeshTriangle; 2] {
    [([origin, origin + a, origin + a + b], material), ([origin, origin + a + b, origin + b], material)]
}

/// Makes a scene of some triangles and a mirror floor, which is 20 m a side around the origin and comes first.
fn scene_on_floor(name: &str, triangles: impl IntoIterator<Item = MeshTriangle>) -> Scene {
    let floor = quad(Vec3::new(-10.0, 0.0, -10.0), 20.0 * Vec3::Z, 20.0 * Vec3::X, 0);
    let all = floor.into_iter().chain(triangles);
    scene(name, all, Vec3::new(0.0, 1.5, -8.0), Vec3::new(0.0, 0.5, 0.0), 100.0)
}

/// A scene of a single triangle, whose tree is a single leaf: a mirror, which shows the sky.
fn single_triangle() -> Scene {
    let corners = [Vec3::new(-9.0, 0.0, -9.0), Vec3::new(0.0, 0.0, 9.0), Vec3::new(9.0, 0.0, -9.0)];
    scene("one", [(corners, 0)], Vec3::new(0.0, 2.0, -6.0), Vec3::ZERO, 100.0)
}

/// A scene of `count` triangles: a mirror floor, and above it slivers in all directions, ten thousand times as long as
/// wide.
fn slivers(count: usize) -> Scene {
    let sliver = |n: usize| {
        let random = Stream::new(5, n as u64);
        let random_vector =
            |from: u64| Vec3::from_array([0, 1, 2].map(|axis| 2.0 * random.uniform(from + axis) as f32 - 1.0));
        let middle = Vec3::new(0.0, 3.0, 2.0) + Vec3::new(6.0, 2.0, 6.0) * random_vector(0);
        let along = random_vector(3).normalize_or(Vec3::X);
        let across = along.any_orthonormal_vector();
        ([middle - along, middle + along, middle + along + 2e-4 * across], 1)
    };
    scene_on_floor("slivers", (0..count.saturating_sub(2)).map(sliver))
}

/// A scene of a mirror floor, and `count` triangles that lie over each other in the plane of a wall.
fn one_plane(count: usize) -> Scene {
    let wall = |n: usize| {
        let random = Stream::new(6, n as u64);
        let corner = |i: u64| Vec3::new(16.0 * random.uniform(i) as f32 - 8.0, 6.0 * random.uniform(i + 1) as f32, 4.0);
        ([corner(0), corner(2), corner(4)], 1)
    };
    scene_on_floor("one-plane", (0..count).map(wall))
}

/// A scene of a mirror floor, and `count` copies of one triangle.
fn copies(count: usize) -> Scene {
    let corners = [Vec3::new(-4.0, 0.0, 4.0), Vec3::new(0.0, 5.0, 4.0), Vec3::new(4.0, 0.0, 4.0)];
    scene_on_floor("same", (0..count).map(|_| (corners, 1)))
}

/// A scene of a closed box of mirrors around the camera, with smaller boxes inside. `offset` moves all of it along each
/// axis, in metres.
fn closed_box(offset: f32) -> Scene {
    // Makes a cube from its least corner and its size in metres; its faces look inwards or outwards.
    let cube = |corner: Vec3, size: f32, inwards: bool, material: usize| {
        let axes = [[Vec3::X, Vec3::Y, Vec3::Z], [Vec3::Y, Vec3::Z, Vec3::X], [Vec3::Z, Vec3::X, Vec3::Y]];
        axes.into_iter().flat_map(move |[a, b, c]| {
            let (near, far) = (corner, corner + size * c);
            let (outer, inner) = if inwards { (near, far) } else { (far, near) };
            [quad(outer, size * a, size * b, material), quad(inner, size * b, size * a, material)].concat()
        })
    };
    let boxes = (0..200).flat_map(|n| {
        let random = Stream::new(8, n);
        let place = Vec3::from_array([0, 1, 2].map(|axis| 16.0 * random.uniform(axis) as f32 - 9.0));
        cube(place + Vec3::splat(offset), 0.5, false, 1)
    });
    let walls = cube(Vec3::splat(offset - 10.0), 20.0, true, 0);
    let moved = |v: Vec3| v + Vec3::splat(offset);
    scene("closed-box", walls.chain(boxes), moved(Vec3::new(0.0, 0.0, -9.5)), moved(Vec3::new(0.0, -2.0, 0.0)), 100.0)
}

/// A scene of a mirror floor, and a wall behind a number of planes with holes in half of their area. A ray passes many
/// triangles without being stopped.
fn behind_holes(planes: usize) -> Scene {
    let plane = |n: usize| {
        let z = 1.0 + 0.1 * n as f32;
        quad(Vec3::new(-8.0, 0.0, z), 16.0 * Vec3::X, 5.0 * Vec3::Y, 2)
    };
    let wall = quad(Vec3::new(-8.0, 0.0, 8.0), 16.0 * Vec3::X, 5.0 * Vec3::Y, 1);
    scene_on_floor("behind-holes", (0..planes).flat_map(plane).chain(wall))
}

/// A scene of a chequerboard of mirror squares in two planes a millimetre apart, before a wall; `distance` is about
/// their distance from the camera, in metres. No ray may meet the plane that it begins on, and no ray from the lower
/// plane may miss a square of the upper plane on its way.
fn near_planes(distance: f32) -> Scene {
    let side = distance / 8.0;
    let squares = (0..256).flat_map(|n| {
        let (x, z) = ((n % 16) as f32 - 8.0, (n / 16) as f32);
        let height = if (n % 16 + n / 16) % 2 == 0 { 1e-3 } else { 0.0 };
        quad(Vec3::new(x * side, height, z * side), side * Vec3::Z, side * Vec3::X, 0)
    });
    let (low, wide) = (Vec3::new(-2.0 * distance, -0.5 * distance, 2.0 * distance), 4.0 * distance);
    let wall = quad(low, wide * Vec3::X, wide * Vec3::Y, 1);
    // The eye is off the middle, so that no pixel's centre lies on the border of two squares, where either may be seen.
    let eye = Vec3::new(0.013 * distance, 0.3 * distance, -0.6 * distance);
    scene("near-planes", squares.chain(wall), eye, Vec3::new(0.0, 0.0, 0.8 * distance), 10.0 * distance)
}

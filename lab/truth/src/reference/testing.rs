//! G-buffers and random numbers for the tests of the references.

use super::first_hits::{FirstHits, PrimaryRays};
use super::ray::RaySetup;
use super::surface::World;
use glam::{DVec3, Vec3};
use ssct_ground::math::random::Stream;
use ssct_scenes::{Camera, GBufferData, Lens, Surface};
use std::cell::Cell;

/// Returns a camera at the origin that looks along +z with the default lens.
fn camera(aspect: f32) -> Camera {
    Camera::new(Vec3::ZERO, Vec3::Z, Lens::default(), aspect)
}

/// Returns the reversed depth, with the default lens, of a view depth in metres; 0 (sky) if it is infinite.
pub fn depth_of(view_z_m: f64) -> f32 {
    if view_z_m.is_infinite() {
        return 0.0;
    }
    camera(1.0).view_to_clip_reversed().as_dmat4().project_point3(DVec3::new(0.0, 0.0, view_z_m)).z as f32
}

/// Returns a black G-buffer with the default lens, made from functions that return the reversed depth and the
/// view-space normal of pixel (x, y). Every pixel is a mirror.
pub fn gbuffer_from(
    width: u32,
    height: u32,
    depth: impl Fn(u32, u32) -> f32,
    normal: impl Fn(u32, u32) -> Vec3,
) -> GBufferData {
    let pixels: Vec<_> = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).collect();
    GBufferData {
        width,
        height,
        camera: camera(width as f32 / height as f32),
        depth: pixels.iter().map(|(x, y)| depth(*x, *y)).collect(),
        normal: pixels.iter().map(|(x, y)| normal(*x, *y)).collect(),
        reflectivity: vec![1.0; pixels.len()],
        roughness: vec![0.0; pixels.len()],
        color: vec![Vec3::ZERO; pixels.len()],
        surface: vec![Surface::Lit; pixels.len()],
    }
}

/// Returns the G-buffer of a scene, traced through the pixels' centres. Only reflecting surfaces have normals.
pub fn traced(world: &World, camera: &Camera, extent: [u32; 2]) -> GBufferData {
    let first_hits = FirstHits::trace(world, camera, extent);
    let (to_clip, to_view) = (camera.view_to_clip_reversed().as_dmat4(), camera.world_to_view.as_dmat4());
    let depth = |z: &f64| to_clip.project_point3(DVec3::Z * *z).z.max(0.0) as f32;
    let rays = PrimaryRays::new(camera, extent);
    let surface = |i| {
        let (ray, _) = rays.ray(i);
        world.closest(&ray).map_or(Surface::Lit, |hit| world.point(&ray, &hit).surface)
    };
    let channel = |value: fn(&super::first_hits::Receiver) -> f64| {
        first_hits.receivers.iter().map(|receiver| receiver.as_ref().map_or(0.0, value) as f32).collect()
    };
    GBufferData {
        width: extent[0],
        height: extent[1],
        camera: *camera,
        depth: first_hits.view_z_m.iter().map(depth).collect(),
        normal: first_hits
            .receivers
            .iter()
            .map(|receiver| {
                receiver.map_or(Vec3::ZERO, |receiver| to_view.transform_vector3(receiver.normal).as_vec3())
            })
            .collect(),
        reflectivity: channel(|receiver| receiver.reflectivity),
        roughness: channel(|receiver| receiver.roughness),
        color: first_hits.lit.clone(),
        surface: (0..first_hits.lit.len()).map(surface).collect(),
    }
}

/// Returns the G-buffer of a wall `view_z_m` metres away that faces the camera.
pub fn flat_wall(width: u32, height: u32, view_z_m: f64) -> GBufferData {
    gbuffer_from(width, height, |_, _| depth_of(view_z_m), |_, _| Vec3::NEG_Z)
}

/// Returns the G-buffer of a floor 1 m below the eye that ends at a wall 5 m away. The wall has no upper end.
pub fn floor_and_wall(width: u32, height: u32) -> GBufferData {
    // By how many metres the camera ray of a row rises with each metre of z.
    let slope = |y: u32| {
        let ndc = 1.0 - 2.0 * (f64::from(y) + 0.5) / f64::from(height);
        ndc * f64::from(Lens::default().fov_y_radians().expect("a perspective") / 2.0).tan()
    };
    // The camera ray of a row meets the floor, y = −1, at z = −1 / slope.
    let is_floor = move |y| slope(y) < -1.0 / 5.0;
    gbuffer_from(
        width,
        height,
        |_, y| depth_of(if is_floor(y) { -1.0 / slope(y) } else { 5.0 }),
        |_, y| if is_floor(y) { Vec3::Y } else { Vec3::NEG_Z },
    )
}

/// Image sizes in which rays are traced: one pixel, rows, odd numbers, primes, powers of two.
pub const SIZES: [[u32; 2]; 20] = [
    [1, 1],
    [1, 2],
    [2, 1],
    [1, 37],
    [53, 1],
    [1, 256],
    [2, 2],
    [3, 3],
    [5, 3],
    [7, 13],
    [16, 16],
    [17, 15],
    [31, 32],
    [33, 31],
    [64, 64],
    [65, 127],
    [97, 101],
    [128, 66],
    [160, 90],
    [321, 239],
];

/// A sequence of random numbers.
pub struct Random {
    stream: Stream,
    /// The index in the stream of the number that was returned last.
    last_index: Cell<u64>,
}

impl Random {
    /// Begins the sequence of a seed and an index.
    pub fn new(seed: u64, index: u64) -> Self {
        Self { stream: Stream::new(seed, index), last_index: Cell::new(0) }
    }

    /// Returns the next random number in 0…1.
    pub fn unit(&self) -> f64 {
        self.last_index.set(self.last_index.get() + 1);
        self.stream.uniform(self.last_index.get())
    }

    /// Returns a random number between two numbers.
    pub fn range(&self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.unit()
    }

    /// Returns a random whole number from 0 to `bound` − 1.
    pub fn below(&self, bound: u32) -> u32 {
        (self.unit() * f64::from(bound)) as u32
    }

    /// Returns a random vector whose components lie in −1…1; its length is not 1.
    pub fn direction(&self) -> DVec3 {
        DVec3::new(self.range(-1.0, 1.0), self.range(-1.0, 1.0), self.range(-1.0, 1.0))
    }

    /// Returns a random view depth between the near and far planes in metres, uniform in its logarithm.
    pub fn depth(&self) -> f64 {
        self.range(0.1_f64.ln(), 1000.0_f64.ln()).exp()
    }
}

/// Returns random reversed depths of a kind (0 to [`DEPTH_KINDS`] − 1) for each pixel. Kind 4 is a plane in view space,
/// which stays a plane in reversed depth.
pub fn random_depths(kind: u32, random: &Random, [width, height]: [u32; 2]) -> Vec<f32> {
    let (a, b) = (random.depth(), random.depth());
    let (near, far) = (depth_of(a.min(b)), depth_of(a.max(b)));
    let (cell_side, edge_pixel) = (1 + random.below(5), random.below(width.max(height)));
    let tilt = [random.range(-1.0, 1.0), random.range(-1.0, 1.0)];
    let (relief, sky_share) = (random.range(0.0, 0.02) as f32, random.range(0.0, 1.0));
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let depth = |(x, y): (u32, u32)| match kind {
        // Kinds 0 to 3: random depths, one depth, a chequerboard of two depths, and two depths with one edge.
        0 => depth_of(random.depth()),
        1 => near,
        2 => [near, far][((x / cell_side + y / cell_side) % 2) as usize],
        3 => [near, far][usize::from(if cell_side % 2 == 0 { x < edge_pixel } else { y < edge_pixel })],
        4 => {
            let [u, v] = [f64::from(x) / f64::from(width) - 0.5, f64::from(y) / f64::from(height) - 0.5];
            (f64::from(near) * (1.0 + tilt[0] * u + tilt[1] * v)).clamp(1e-4, 1.0) as f32
        }
        // Kinds 5 to 7: a rough surface, random depths with sky between them, and few pixels before the sky.
        5 => near * (1.0 - relief * random.unit() as f32),
        6 if random.unit() < sky_share => 0.0,
        6 => depth_of(random.depth()),
        7 if random.unit() < 0.02 => near,
        7 => 0.0,
        // The extreme depths include the near plane and the least number above sky.
        _ => [1.0, near, f32::MIN_POSITIVE, 0.0][random.below(4) as usize],
    };
    pixels.map(depth).collect()
}
/// Number of kinds of depths.
pub const DEPTH_KINDS: u32 = 9;

/// Returns a random view-space direction of a kind (0 to [`DIRECTION_KINDS`] − 1), of any length, from `start`.
pub fn direction_of_kind(kind: u32, random: &Random, rays: &RaySetup, start: DVec3) -> DVec3 {
    let gbuffer = rays.gbuffer;
    let target = || {
        let (x, y) = (random.below(gbuffer.width), random.below(gbuffer.height));
        rays.position(x, y).unwrap_or(start * 0.5)
    };
    match kind {
        0 => random.direction(),
        // Directions along the axes of view space.
        1 => [DVec3::X, DVec3::Y, DVec3::Z][random.below(3) as usize] * [1.0, -1.0][random.below(2) as usize],
        // Directions to the camera and away from it, exactly and approximately.
        2 => start * [1.0, -1.0][random.below(2) as usize],
        3 => (start.normalize() + 1e-7 * random.direction()) * [1.0, -1.0][random.below(2) as usize],
        // Directions to the centre of another pixel, exactly at its depth.
        4 => target() - start,
        // Directions to another pixel at the starting pixel's own z.
        5 => (target() - start) * DVec3::new(1.0, 1.0, 0.0),
        // Directions almost along the screen's x axis.
        _ => DVec3::new(random.range(-1.0, 1.0), 1e-9 * random.range(-1.0, 1.0), 1e-3 * random.range(-1.0, 1.0)),
    }
}
/// Number of kinds of directions.
pub const DIRECTION_KINDS: u32 = 7;

/// Returns the kind of depths of case number `case`, and the case's G-buffer, whose normals have random directions. The
/// cases go through all sizes and kinds.
pub fn random_gbuffer(case: u64, random: &Random) -> (u32, GBufferData) {
    let size = SIZES[(case % SIZES.len() as u64) as usize];
    let kind = (case / SIZES.len() as u64 % u64::from(DEPTH_KINDS)) as u32;
    let depths = random_depths(kind, random, size);
    let normals: Vec<Vec3> = depths.iter().map(|_| random.direction().as_vec3()).collect();
    let index = |x: u32, y: u32| (y * size[0] + x) as usize;
    (kind, gbuffer_from(size[0], size[1], |x, y| depths[index(x, y)], |x, y| normals[index(x, y)]))
}

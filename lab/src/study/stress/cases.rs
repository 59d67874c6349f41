//! Adversarial G-buffers: sizes, depth ranges, depths, ray directions, normals, colours and roughness that break
//! renderers (docs/numerics.md, "Faults of the engines"). They are made from seeds alone, so that they are the same in
//! each run.

use glam::{DMat4, DVec2, DVec3, Vec3};
use half::f16;
use rayon::prelude::*;
use ssct_ground::math::random::Stream;
use ssct_scenes::{Camera, GBufferData, Lens, Surface};

/// A case: a G-buffer that is hard for methods.
pub struct Case {
    /// Name of the case in records.
    pub name: String,
    /// Whether hits can be compared with the oracle's, since the rays are defined: all reflectors are mirrors, whose
    /// normals have a finite length above 0.
    pub comparable: bool,
    extent: [u32; 2],
    lens: Lens,
    /// Makes the contents of a pixel.
    texel: Box<dyn Fn(&Pixel) -> Texel + Sync>,
}

/// Contents of a pixel.
#[derive(Debug, Clone, Copy)]
struct Texel {
    depth: f32,
    normal: Vec3,
    reflectivity: f32,
    roughness: f32,
    color: Vec3,
}

/// A pixel, with everything that its contents may depend on.
struct Pixel<'a> {
    x: u32,
    y: u32,
    extent: [u32; 2],
    screen: &'a Screen,
    /// Random numbers of this pixel.
    random: Stream,
}

/// Properties of a case's camera, which all pixels share.
struct Screen {
    view_to_clip: DMat4,
    clip_to_view: DMat4,
    lens: Lens,
}

impl Pixel<'_> {
    /// Returns the view-space direction through the pixel's centre, with z = 1.
    fn direction(&self) -> DVec3 {
        let centre = DVec2::new(f64::from(self.x), f64::from(self.y)) + 0.5;
        let ndc = centre / DVec2::new(f64::from(self.extent[0]), f64::from(self.extent[1])) * DVec2::new(2.0, -2.0)
            + DVec2::new(-1.0, 1.0);
        let on_near_plane = self.screen.clip_to_view.project_point3(ndc.extend(1.0));
        on_near_plane / on_near_plane.z
    }

    /// Returns the reversed depth of a view depth in metres, clamped to the lens's range.
    fn depth_of(&self, z: f64) -> f32 {
        let lens = self.screen.lens;
        let z = z.clamp(f64::from(lens.near_m), f64::from(lens.far_m));
        (self.screen.view_to_clip.project_point3(DVec3::new(0.0, 0.0, z)).z as f32).clamp(0.0, 1.0)
    }

    /// Returns this pixel's random number with the index `n`, at least 0 and below 1.
    fn uniform(&self, n: u64) -> f64 {
        self.random.uniform(n)
    }

    /// Returns a random colour, which differs from pixel to pixel.
    fn color(&self) -> Vec3 {
        Vec3::new(self.uniform(100) as f32, self.uniform(101) as f32, self.uniform(102) as f32)
    }

    /// Makes a mirror with a reversed depth and a normal in view space.
    fn mirror(&self, depth: f32, normal: DVec3) -> Texel {
        Texel { depth, normal: normal.as_vec3(), reflectivity: 1.0, roughness: 0.0, color: self.color() }
    }

    /// Finds the nearest surface in this pixel of a picture of random tilted rectangles before a wall, like plausible
    /// geometry: its view depth and its normal. `None` for sky, which about one in 16 blocks of 4 × 4 pixels shows.
    fn nearest_facet(&self, seed: u64) -> Option<(f64, DVec3)> {
        // The factor tells the blocks of different rows apart.
        if Stream::new(seed, 1 << 40).uniform(u64::from(self.x / 4 + self.y / 4 * 8191)) < 1.0 / 16.0 {
            return None;
        }
        let direction = self.direction();
        let lens = self.screen.lens;
        let (near, far) = (f64::from(lens.near_m), f64::from(lens.far_m));
        // Distances are interpolated in the logarithm between the lens's planes, so that they fit any lens.
        let distance = |share: f64| near * (far / near).powf(share);
        // View depth and normal of the nearest surface: at first the wall.
        let (mut nearest_z, mut nearest_normal) = (distance(0.6), DVec3::NEG_Z);
        for rectangle in 0..12 {
            let random = Stream::new(seed, rectangle);
            let u = |n| random.uniform(n);
            // Centre and half the size of the rectangle in the image, as shares of its sides.
            let (centre, half_size) = ([u(0), u(1)], [0.05 + 0.3 * u(2), 0.05 + 0.3 * u(3)]);
            let pixel = [f64::from(self.x) + 0.5, f64::from(self.y) + 0.5];
            let is_inside = (0..2).all(|a| (pixel[a] / f64::from(self.extent[a]) - centre[a]).abs() < half_size[a]);
            let normal = DVec3::new(2.0 * u(4) - 1.0, 2.0 * u(5) - 1.0, -0.3 - u(6)).normalize();
            let z_ahead = distance(0.05 + 0.5 * u(7));
            // The pixel's ray meets the plane that has this normal and the depth `z_ahead` straight ahead of the
            // camera.
            let facing = direction.dot(normal);
            let hit_z = z_ahead * normal.z / facing;
            if is_inside && facing < 0.0 && hit_z > near && hit_z < nearest_z {
                (nearest_z, nearest_normal) = (hit_z, normal);
            }
        }
        Some((nearest_z, nearest_normal))
    }

    /// Makes the contents of the pixel from [`Self::nearest_facet`], of which all but the sky are mirrors.
    fn facet_texel(&self, seed: u64) -> Texel {
        match self.nearest_facet(seed) {
            Some((z, normal)) => self.mirror(self.depth_of(z), normal),
            None => Texel { reflectivity: 0.0, ..self.mirror(0.0, DVec3::ZERO) },
        }
    }

    /// Makes the contents of the pixel from [`Self::nearest_facet`], with a normal that reflects the view ray into the
    /// direction `along`, in view space.
    fn aimed_facet_texel(&self, seed: u64, along: DVec3) -> Texel {
        // A mirror with the half vector as its normal reflects the view ray into `along`.
        let normal = (along.normalize() - self.direction().normalize()).try_normalize().unwrap_or(DVec3::Y);
        match self.nearest_facet(seed) {
            Some((z, _)) => self.mirror(self.depth_of(z), normal),
            None => self.facet_texel(seed),
        }
    }
}

impl Case {
    /// Makes a case whose hits can be compared; `texel` makes the contents of each pixel.
    fn new(
        name: impl Into<String>,
        extent: [u32; 2],
        lens: Lens,
        texel: impl Fn(&Pixel) -> Texel + Sync + 'static,
    ) -> Self {
        Self { name: name.into(), comparable: true, extent, lens, texel: Box::new(texel) }
    }

    /// Marks the case as one whose hits cannot be compared.
    fn without_truth(mut self) -> Self {
        self.comparable = false;
        self
    }

    /// Returns the width and height in pixels.
    pub fn extent(&self) -> [u32; 2] {
        self.extent
    }

    /// Makes the G-buffer, with its numbers rounded as the device stores them.
    pub fn gbuffer(&self) -> GBufferData {
        let [width, height] = self.extent;
        let camera = Camera::new(Vec3::ZERO, Vec3::Z, self.lens, width as f32 / height as f32);
        let view_to_clip = camera.view_to_clip_reversed().as_dmat4();
        let screen = Screen { view_to_clip, clip_to_view: view_to_clip.inverse(), lens: self.lens };
        let texels: Vec<Texel> = (0..u64::from(width) * u64::from(height))
            .into_par_iter()
            .map(|i| {
                let (x, y) = ((i % u64::from(width)) as u32, (i / u64::from(width)) as u32);
                (self.texel)(&Pixel { x, y, extent: self.extent, screen: &screen, random: Stream::new(7, i) })
            })
            .collect();
        let stored = |v: f32| f16::from_f32(v).to_f32();
        let stored_vector = |v: Vec3| Vec3::new(stored(v.x), stored(v.y), stored(v.z));
        GBufferData {
            width,
            height,
            camera,
            depth: texels.iter().map(|t| t.depth).collect(),
            normal: texels.iter().map(|t| stored_vector(t.normal)).collect(),
            reflectivity: texels.iter().map(|t| stored(t.reflectivity)).collect(),
            roughness: texels.iter().map(|t| stored(t.roughness)).collect(),
            color: texels.iter().map(|t| stored_vector(t.color)).collect(),
            surface: vec![Surface::Lit; texels.len()],
        }
    }
}

/// The size of images in cases that test something other than sizes. Both sides are prime numbers of pixels.
const PRIME_SIZE: [u32; 2] = [127, 61];

/// Number of pixels from which on an image is large: only a random quarter of it reflects, since marches of one pixel a
/// step in all pixels would take minutes on a CPU.
const LARGE_PIXELS: u32 = 4_000_000;

/// Pixels along a side of a tile of a large image, which reflects as a whole or not at all.
const SQUARE_PIXELS: u32 = 16;

/// Makes every case; `quick` leaves the large images out.
pub fn cases(quick: bool) -> Vec<Case> {
    let mut all = sizes(quick);
    all.extend(ranges());
    all.extend(depths());
    all.extend(directions());
    all.extend(normals());
    all.extend(colors());
    all.extend(materials());
    all
}

/// Makes cases of images with unusual sizes; `quick` leaves the large images out.
fn sizes(quick: bool) -> Vec<Case> {
    let small = [[1, 1], [1, 257], [257, 1], [2, 2], [3, 5], [64, 64], [65, 63], PRIME_SIZE, [641, 479]];
    let large: &[[u32; 2]] = if quick { &[] } else { &[[1919, 1079], [4096, 2304]] };
    let case = |extent: &[u32; 2]| {
        let name = format!("size {}x{}", extent[0], extent[1]);
        if extent[0] * extent[1] < LARGE_PIXELS {
            return Case::new(name, *extent, Lens::default(), |p: &Pixel| p.facet_texel(1));
        }
        let name = format!("{name}, a quarter of its {SQUARE_PIXELS}x{SQUARE_PIXELS} tiles reflecting");
        Case::new(name, *extent, Lens::default(), |p: &Pixel| {
            let tile = u64::from(p.x / SQUARE_PIXELS) + (u64::from(p.y / SQUARE_PIXELS) << 20);
            let texel = p.facet_texel(1);
            if Stream::new(8, tile).uniform(0) < 0.25 { texel } else { Texel { reflectivity: 0.0, ..texel } }
        })
    };
    small.iter().chain(large).map(case).collect()
}

/// Makes cases of unusual near and far planes, in metres, and fields of view, in degrees.
fn ranges() -> Vec<Case> {
    let case = |(near_m, far_m): (f32, f32), fov: f32| {
        let lens = Lens::perspective(fov.to_radians(), near_m, far_m);
        let name = format!("near {near_m} far {far_m} fov {fov}");
        Case::new(name, PRIME_SIZE, lens, |p: &Pixel| p.facet_texel(2))
    };
    vec![
        case((1.0, 2.0), 74.0),
        case((0.1, 1000.0), 74.0),
        case((0.01, 1e4), 74.0),
        case((1e-3, 1e4), 74.0),
        case((100.0, 1e9), 74.0),
        case((0.1, 1000.0), 1.0),
        case((0.1, 1000.0), 175.0),
    ]
}

/// Makes cases of reversed depths that are constant, random, in steps, of thin objects, or of steep slopes, with random
/// normals.
fn depths() -> Vec<Case> {
    let lens = Lens::default();
    let flat = |name: &str, depth: f32| {
        Case::new(name, PRIME_SIZE, lens, move |p: &Pixel| {
            p.mirror(depth, DVec3::new(p.uniform(0) - 0.5, p.uniform(1) - 0.5, -0.6).normalize())
        })
    };
    let case = |name: &str, depth: fn(&Pixel) -> f32| {
        Case::new(name, PRIME_SIZE, lens, move |p: &Pixel| {
            let normal = DVec3::new(p.uniform(0) - 0.5, p.uniform(1) - 0.5, -p.uniform(2)).normalize_or(DVec3::Y);
            p.mirror(depth(p), normal)
        })
    };
    vec![
        flat("depth all sky", 0.0),
        flat("depth all at the near plane", 1.0),
        flat("depth all equal", 0.02),
        flat("depth the least above sky", f32::MIN_POSITIVE),
        flat("depth denormal", 1e-40),
        case("depth white noise", |p| p.uniform(3) as f32),
        case("depth white noise with sky", |p| if p.uniform(4) < 0.3 { 0.0 } else { p.uniform(3) as f32 }),
        case("depth checkerboard", |p| if (p.x + p.y).is_multiple_of(2) { p.depth_of(2.0) } else { p.depth_of(20.0) }),
        case("depth checkerboard of sky", |p| if (p.x + p.y).is_multiple_of(2) { p.depth_of(2.0) } else { 0.0 }),
        case("depth steps", |p| p.depth_of(1.0 + f64::from(p.x / 8))),
        case("depth one-pixel poles", |p| if p.x % 8 == 3 { p.depth_of(2.0) } else { p.depth_of(30.0) }),
        case("depth one-pixel beams", |p| if p.y % 8 == 3 { p.depth_of(2.0) } else { p.depth_of(30.0) }),
        case("depth slope edge-on", |p| p.depth_of(0.2 * 1.08_f64.powi(p.x as i32))),
        case("depth slope along the view", |p| p.depth_of(1.0 / (1e-3 + f64::from(p.y)))),
    ]
}

/// Makes cases of normals that send all rays along one direction, back to the eye, or through corners of cells.
fn directions() -> Vec<Case> {
    let axes: [(&str, DVec3); 15] = [
        ("+x", DVec3::X),
        ("-x", DVec3::NEG_X),
        ("+y", DVec3::Y),
        ("-y", DVec3::NEG_Y),
        ("+z", DVec3::Z),
        ("-z", DVec3::NEG_Z),
        ("+x with 1e-30 of y", DVec3::new(1.0, 1e-30, 0.0)),
        ("+z with a denormal of x", DVec3::new(1e-40, 0.0, 1.0)),
        ("-z with 1e-6 of x", DVec3::new(1e-6, 0.0, -1.0)),
        ("+x +y", DVec3::new(1.0, 1.0, 0.0)),
        ("-x +y", DVec3::new(-1.0, 1.0, 0.0)),
        ("+x -y -z", DVec3::new(1.0, -1.0, -1.0)),
        ("+x +z", DVec3::new(1.0, 0.0, 1.0)),
        ("+y -z", DVec3::new(0.0, 1.0, -1.0)),
        ("-x +z", DVec3::new(-1.0, 0.0, 1.0)),
    ];
    let lens = Lens::default();
    let case = |(name, along): (&str, DVec3)| {
        Case::new(format!("rays along {name}"), PRIME_SIZE, lens, move |p: &Pixel| p.aimed_facet_texel(3, along))
    };
    let mut all: Vec<Case> = axes.into_iter().map(case).collect();
    // Each ray goes straight back to the eye, so that it stays in its pixel.
    all.push(Case::new("rays straight back", PRIME_SIZE, lens, |p: &Pixel| p.aimed_facet_texel(3, -p.direction())));
    // In a square image, rays that move equally far in x and y pass through corners of pixels.
    all.push(Case::new("rays through the corners of cells", [64, 64], lens, |p: &Pixel| {
        p.aimed_facet_texel(3, DVec3::new(if p.y.is_multiple_of(2) { 1.0 } else { -1.0 }, 1.0, 0.0))
    }));
    all
}

/// Makes cases of normals that are no unit vectors, or do not face the camera.
fn normals() -> Vec<Case> {
    let lens = Lens::default();
    let case = |name: &str, change: fn(&Pixel, Vec3) -> Vec3| {
        Case::new(format!("normals {name}"), PRIME_SIZE, lens, move |p: &Pixel| {
            let facet = p.facet_texel(4);
            Texel { normal: change(p, facet.normal), ..facet }
        })
    };
    vec![
        case("zero", |_, _| Vec3::ZERO).without_truth(),
        case("three times too long", |_, n| 3.0 * n),
        case("a thousandth too short", |_, n| 1e-3 * n),
        case("the longest there are", |_, n| 65504.0 * n / n.abs().max_element().max(1e-6)),
        case("turned away", |_, n| -n).without_truth(),
        case("along the view", |p, _| p.direction().normalize().as_vec3()).without_truth(),
        case("at a right angle to the view", |p, _| p.direction().cross(DVec3::Y).normalize().as_vec3())
            .without_truth(),
        case("NaN", |_, _| Vec3::NAN).without_truth(),
        case("infinite", |_, _| Vec3::INFINITY).without_truth(),
        case("NaN here and there", |p, n| if p.uniform(0) < 0.1 { Vec3::NAN } else { n }).without_truth(),
        case("zero here and there", |p, n| if p.uniform(0) < 0.1 { Vec3::ZERO } else { n }).without_truth(),
    ]
}

/// Makes cases of lit colours that are extreme or no numbers, at three roughness values.
fn colors() -> Vec<Case> {
    let lens = Lens::default();
    let case = |name: &str, color: fn(&Pixel) -> Vec3, roughness: f32| {
        Case::new(format!("colours {name}, roughness {roughness}"), PRIME_SIZE, lens, move |p: &Pixel| Texel {
            color: color(p),
            roughness,
            ..p.facet_texel(5)
        })
        .without_truth()
    };
    let mut all = Vec::new();
    for roughness in [0.0, 0.1, 0.6] {
        all.extend([
            case("0", |_| Vec3::ZERO, roughness),
            case("65504", |_| Vec3::splat(65504.0), roughness),
            case("infinite here and there", |p| odd_color(p, f32::INFINITY), roughness),
            case("NaN here and there", |p| odd_color(p, f32::NAN), roughness),
            case("negative here and there", |p| odd_color(p, -1.0), roughness),
            case("minus infinity here and there", |p| odd_color(p, f32::NEG_INFINITY), roughness),
        ]);
    }
    all
}

/// Returns the grey `odd` in one pixel of ten, and a random colour in the others.
fn odd_color(p: &Pixel, odd: f32) -> Vec3 {
    if p.uniform(0) < 0.1 { Vec3::splat(odd) } else { p.color() }
}

/// Makes cases of roughness and reflectivity that are extreme or no numbers.
fn materials() -> Vec<Case> {
    let lens = Lens::default();
    let rough = |name: &str, roughness: fn(&Pixel) -> f32| {
        Case::new(format!("roughness {name}"), PRIME_SIZE, lens, move |p: &Pixel| Texel {
            roughness: roughness(p),
            ..p.facet_texel(6)
        })
        .without_truth()
    };
    let reflecting = |name: &str, reflectivity: fn(&Pixel) -> f32| {
        Case::new(format!("reflectivity {name}"), PRIME_SIZE, lens, move |p: &Pixel| Texel {
            reflectivity: reflectivity(p),
            ..p.facet_texel(6)
        })
        .without_truth()
    };
    vec![
        rough("-1", |_| -1.0),
        rough("1e-8", |_| 1e-8),
        rough("6e-8, the least that is stored", |_| 6e-8),
        rough("0.05", |_| 0.05),
        rough("0.3", |_| 0.3),
        rough("1", |_| 1.0),
        rough("2", |_| 2.0),
        rough("3.2, beyond a right angle", |_| 3.2),
        rough("NaN", |_| f32::NAN),
        rough("infinite", |_| f32::INFINITY),
        rough("of every pixel its own", |p| p.uniform(9) as f32),
        rough("mirrors and gloss in a checkerboard", |p| if (p.x + p.y).is_multiple_of(2) { 0.0 } else { 0.5 }),
        reflecting("-1", |_| -1.0),
        reflecting("NaN", |_| f32::NAN),
        reflecting("2", |_| 2.0),
        reflecting("in a pixel of ten", |p| if p.uniform(8) < 0.1 { 1.0 } else { 0.0 }),
        reflecting("just above the threshold", |_| 1.01e-4),
    ]
}

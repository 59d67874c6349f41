//! A mirror under a known pattern: for every pixel the host computes in f64 where the mirror ray
//! meets the wall and where that point is on screen, and the methods must find it.

#![allow(clippy::unwrap_used, clippy::expect_used)]

mod common;

use common::{Builder, Shown, bilinear, camera, clutter, clutter_camera, gpu, show, window};
use glam::{DVec2, DVec3, Vec3};
use ssct::gpu::{Gpu, Pixels};
use ssct::math::display_byte;
use ssct::math::projection::{project, unproject};
use ssct::methods::{self, Preset, Setup, Tuning};
use ssct::metrics::rmse;
use ssct::passes::linear_trace::March;
use ssct::passes::{PathCode, PosterFilter};
use ssct::scene::{Camera, Scene};
use ssct::study::Globals;

const WALL_Z: f64 = 6.0;
/// Side of a cell of the wall's pattern in metres.
const CELL: f64 = 1.5;
/// Cells across and up; their lower left corner is at (−12, −3) metres.
const CELLS: [u32; 2] = [16, 8];

fn cell_color(i: u32, j: u32) -> [u8; 3] {
    // Neighbours differ by 60 or more in every channel.
    [40 + 60 * ((i + 2 * j) % 4) as u8, 40 + 60 * ((2 * i + j) % 4) as u8, 40 + 60 * ((i + j) % 4) as u8]
}

/// A plane mirror, rolled about the z axis by an angle, before a wall of coloured cells.
struct Case {
    roll: f64,
}

impl Case {
    fn normal(&self) -> DVec3 {
        DVec3::new(self.roll.sin(), self.roll.cos(), 0.0)
    }

    fn scene(&self) -> Scene {
        let mut b = Builder::new("mirror");
        b.light(Vec3::Z);
        let texels = 64;
        let wall = b.picture(CELLS[0] * texels, CELLS[1] * texels, |x, y| {
            // Row 0 of the picture is the top; row 0 of the cells is the bottom.
            cell_color(x / texels, CELLS[1] - 1 - y / texels)
        });
        let width = (CELL * f64::from(CELLS[0])) as f32;
        let height = (CELL * f64::from(CELLS[1])) as f32;
        b.quad(wall, Vec3::new(-width / 2.0, -3.0, WALL_Z as f32), Vec3::X * width, Vec3::Y * height, -Vec3::Z);
        let mirror = b.mirror();
        let normal = self.normal().as_vec3();
        let right = Vec3::new(normal.y, -normal.x, 0.0) * 12.0;
        b.quad(mirror, -right, right * 2.0, Vec3::Z * WALL_Z as f32, normal);
        b.0
    }

    fn camera(&self, extent: [u32; 2]) -> Camera {
        camera(EYE.as_vec3(), EYE.as_vec3() + Vec3::Z, extent)
    }
}

const EYE: DVec3 = DVec3::new(0.0, 1.2, 0.0);

/// Calls for every pixel of a shot that reflects: pixel, its centre's texture coordinates.
fn reflecting(shown: &Shown) -> impl Iterator<Item = (u32, u32, DVec2)> {
    let material = shown.get("material");
    let (w, h) = (material.width, material.height);
    let pixels = (0..h).flat_map(move |y| (0..w).map(move |x| (x, y)));
    pixels
        .filter(|&(x, y)| material.at(x, y)[0] > 1e-4)
        .map(move |(x, y)| (x, y, DVec2::new((f64::from(x) + 0.5) / f64::from(w), (f64::from(y) + 0.5) / f64::from(h))))
}

/// Where the mirror ray of a pixel starts and where it goes, in view space; the mirror is the
/// plane through `point`.
fn mirror_ray(shown: &Shown, uv: DVec2, point: DVec3, normal: DVec3) -> (DVec3, DVec3) {
    let inverse = shown.camera.view_to_clip().as_dmat4().inverse();
    let direction = unproject(uv.extend(0.5), &inverse).normalize();
    let position = direction * (point.dot(normal) / direction.dot(normal));
    (position, direction - normal * 2.0 * direction.dot(normal))
}

/// A view-space point's texture coordinates, if it is on screen.
fn on_screen(shown: &Shown, view: DVec3) -> Option<DVec2> {
    let uv = project(view, &shown.camera.view_to_clip().as_dmat4()).truncate();
    (view.z > 0.0 && uv.cmpge(DVec2::ZERO).all() && uv.cmple(DVec2::ONE).all()).then_some(uv)
}

fn path(hit: &[f32]) -> PathCode {
    PathCode::from_channel(hit[3]).expect("a path code")
}

/// sRGB bytes of a reflection's colour.
fn bytes(color: &[f32]) -> [u8; 3] {
    [0, 1, 2].map(|c| display_byte(color[c]))
}

fn is_near(a: [u8; 3], b: [u8; 3]) -> bool {
    a.iter().zip(b).all(|(a, b)| a.abs_diff(b) <= 1)
}

/// What a case's pixels were compared with.
struct Compared {
    /// Pixels whose mirror ray meets the wall on screen.
    expected: usize,
    /// Of them, those without a hit.
    missed: usize,
    /// Of them, pixels between the hit and where it should be, in the worse direction; sorted.
    errors: Vec<f64>,
    /// Of them, those far enough from the border of a cell to say which colour they must have.
    colored: usize,
}

impl Compared {
    fn at(&self, share: f64) -> f64 {
        self.errors[((self.errors.len() - 1) as f64 * share) as usize]
    }
}

/// Compares hits and colours with the closed form. A colour must agree where the right hit lies
/// more than `margin` pixels inside its cell.
fn compare(case: &Case, shown: &Shown, margin: f64) -> Compared {
    let (hits, reflection, composite) = (shown.get("hits"), shown.get("reflection"), shown.get("composite"));
    let size = DVec2::new(f64::from(hits.width), f64::from(hits.height));
    let pixels_a_metre = size.y / (2.0 * (37_f64.to_radians()).tan() * WALL_Z);
    let mut found = Compared { expected: 0, missed: 0, errors: Vec::new(), colored: 0 };
    for (x, y, uv) in reflecting(shown) {
        let (p, r) = mirror_ray(shown, uv, -EYE, case.normal());
        let wall = p + r * ((WALL_Z - p.z) / r.z);
        let Some(expected) = on_screen(shown, wall) else { continue };
        found.expected += 1;
        let hit = hits.at(x, y);
        if path(hit) != PathCode::HiZ {
            assert_eq!(path(hit), PathCode::Miss, "({x}, {y})");
            assert_eq!(reflection.at(x, y), [0.0; 4], "a miss is black");
            found.missed += 1;
            continue;
        }
        let error = (DVec2::new(f64::from(hit[0]), f64::from(hit[1])) - expected) * size;
        found.errors.push(error.abs().max_element());
        // In cells: bottom left is (0, 0).
        let cell = DVec2::new(wall.x / CELL + f64::from(CELLS[0]) / 2.0, (wall.y + EYE.y + 3.0) / CELL);
        let inside = cell.fract().min(DVec2::ONE - cell.fract()).min_element() * CELL * pixels_a_metre;
        // The mirror cuts the wall's lowest cells.
        let above = (wall + EYE).dot(case.normal()) * pixels_a_metre;
        if inside.min(above) > margin {
            let right = cell_color(cell.x as u32, cell.y as u32);
            assert!(is_near(bytes(reflection.at(x, y)), right), "({x}, {y}): {:?}, not {right:?}", reflection.at(x, y));
            assert!(is_near(bytes(composite.at(x, y)), right), "({x}, {y}): composite {:?}", composite.at(x, y));
            found.colored += 1;
        }
    }
    found.errors.sort_by(f64::total_cmp);
    found
}

#[test]
fn mirror_rays_meet_the_wall_where_they_should() {
    let gpu = gpu();
    for roll in [0.0, 0.3, -0.2] {
        let case = Case { roll };
        let scene = case.scene();
        for extent in [[512, 256], [321, 239]] {
            for (method, preset) in [
                ("ssct", Preset::Published),
                ("ssct", Preset::Author),
                ("hzct", Preset::Published),
                ("hzct", Preset::Author),
            ] {
                let what = format!("{method}, {preset:?}, roll {roll}, {extent:?}");
                let setup = Setup { preset, split: true, fade: false, ..Setup::new(extent) };
                let shown = show(&gpu, &scene, case.camera(extent), method, &setup, &Globals::default());
                // A ray is pushed half a pixel past each boundary that it crosses (erratum), so one
                // that meets the wall within its first cells stands behind it when it is first
                // compared: by the cell and half a pixel. The first step is over a cell of the start
                // level and may be followed by one of level 1, before the ray has seen the wall's
                // depth; cells of an odd size are a little larger.
                let start = if preset == Preset::Author { 4.0 } else { 2.0 };
                let farthest = start * 1.02 + 0.5;
                // Bilinear lookup of the colour, and of the pattern's own mip level: 1 and 2 pixels.
                let found = compare(&case, &shown, farthest + 3.0);
                println!(
                    "{what}: {} pixels, {} missed, {} with colour; error median {:.3}, 90 % {:.3}, 99 % {:.3}, worst {:.3} px",
                    found.expected,
                    found.missed,
                    found.colored,
                    found.at(0.5),
                    found.at(0.9),
                    found.at(0.99),
                    found.at(1.0)
                );
                assert!(found.expected > extent[0] as usize * extent[1] as usize / 4, "{what}");
                assert!(found.colored > found.expected / 4, "{what}");
                // All other rays are as good as Alg. 2's finite difference, whose slope is wrong by
                // 3e-2 at 20 m in the worst twentieth (NUMERICS), thus by 3e-3 at 6 m, as its
                // cancellation grows with the square of the distance; times 30 pixels that a ray
                // typically drifts across before the depth plane stops it.
                assert!(found.at(0.5) < 0.02 && found.at(0.9) < 0.1, "{what}");
                assert!(found.at(0.97) < 1.5, "{what}");
                assert!(found.at(1.0) < farthest, "{what}");
                // A first step that ends outside the screen.
                assert!(found.missed * 5_000 <= found.expected, "{what}");
            }
        }
    }
}

/// A mirror floor before a wall of four quarters: bottom left, bottom right, top left, top right.
fn quarters(colors: [[u8; 3]; 4]) -> Scene {
    let mut b = Builder::new("quarters");
    b.light(Vec3::Z);
    let wall = b.picture(64, 64, |x, y| colors[usize::from(x >= 32) + 2 * usize::from(y < 32)]);
    b.quad(wall, Vec3::new(-12.0, -1.0, 6.0), Vec3::X * 24.0, Vec3::Y * 8.0, -Vec3::Z);
    let mirror = b.mirror();
    b.quad(mirror, Vec3::new(-12.0, 0.0, 0.0), Vec3::X * 24.0, Vec3::Z * 6.0, Vec3::Y);
    b.0
}

/// Where a ray of a case ended, beside where it should: lengths along the ray in screen space, that is in
/// texture coordinates and standard depth together, in which the thesis's strides are measured.
struct Ended {
    /// From the pixel to the wall.
    wall: f64,
    /// From the pixel to the hit; `None` for a miss.
    hit: Option<f64>,
    /// Of a hit, pixels beside the ray.
    beside: f64,
    /// Of a hit, pixels from where it should be, in the worse direction.
    pixels: f64,
    /// Standard depth that the ray gains over a length of 1.
    depth_slope: f64,
    /// Length at which the ray leaves the screen.
    border: f64,
}

/// Every ray of a case that meets the wall on screen.
fn ended(case: &Case, shown: &Shown) -> Vec<Ended> {
    let hits = shown.get("hits");
    let size = DVec2::new(f64::from(hits.width), f64::from(hits.height));
    let matrix = shown.camera.view_to_clip().as_dmat4();
    let mut all = Vec::new();
    for (x, y, uv) in reflecting(shown) {
        let (p, r) = mirror_ray(shown, uv, -EYE, case.normal());
        let wall = p + r * ((WALL_Z - p.z) / r.z);
        if on_screen(shown, wall).is_none() {
            continue;
        }
        let (from, to) = (project(p, &matrix), project(wall, &matrix));
        let direction = (to - from).normalize();
        let hit = hits.at(x, y);
        let is_hit = path(hit).is_hit();
        let offset = DVec3::new(f64::from(hit[0]), f64::from(hit[1]), f64::from(hit[2])) - from;
        let along = offset.dot(direction);
        let in_pixels = |v: DVec3| (v.truncate() * size).abs().max_element();
        let border = [0, 1].map(|i| {
            let side = if direction[i] > 0.0 { 1.0 } else { 0.0 };
            if direction[i] == 0.0 { f64::MAX } else { (side - from[i]) / direction[i] }
        });
        all.push(Ended {
            wall: from.distance(to),
            hit: is_hit.then_some(along),
            beside: in_pixels(offset - direction * along),
            pixels: in_pixels(from + offset - to),
            depth_slope: direction.z,
            border: border[0].min(border[1]),
        });
    }
    all
}

/// The share of some rays that something holds for.
fn share(all: &[Ended], holds: impl Fn(&Ended) -> bool) -> f64 {
    all.iter().filter(|e| holds(e)).count() as f64 / all.len() as f64
}

/// As good as Alg. 2's finite difference: what `mirror_rays_meet_the_wall_where_they_should` allows 97 of a
/// hundred rays, in pixels.
const SLOPE_PIXELS: f64 = 1.5;

#[test]
fn uniform_marches_end_within_a_step_behind_the_wall() {
    let gpu = gpu();
    // Method, set-up, roughness, stride, steps, and where in the last step the hit lies: behind the wall
    // by 0 to 1 of it, or, from the step's middle, by -1/2 to 1/2.
    let usual = |extent| Setup { split: true, fade: false, ..Setup::new(extent) };
    let fixed = |extent, stride| {
        let tuning = Tuning { march_stride: Some(stride), ..Tuning::default() };
        Setup { march: March::Fixed, tuning, ..usual(extent) }
    };
    let author = |extent| Setup { preset: Preset::Author, ..usual(extent) };
    for extent in [[512, 256], [321, 239]] {
        for (method, setup, roughness, stride, steps, first) in [
            ("linear", fixed(extent, 0.01), 0.0, 0.01, 100.0, 0.0),
            ("linear", fixed(extent, 0.004), 0.0, 0.004, 100.0, 0.0),
            ("sslr", usual(extent), 0.0, 0.001, 200.0, 0.0),
            ("sslr", usual(extent), 0.1, 0.0109, 200.0, 0.0),
            ("sslr", author(extent), 0.1, 0.0109, 200.0, -0.5),
        ] {
            for roll in [0.0, 0.3] {
                let case = Case { roll };
                let globals = Globals { roughness: Some(roughness), ..Globals::default() };
                let shown = show(&gpu, &case.scene(), case.camera(extent), method, &setup, &globals);
                let what = format!("{method}, {:?}, stride {stride}, roll {roll}, {extent:?}", setup.preset);
                let all = ended(&case, &shown);
                // A pixel's side as a length, and Alg. 2's error as one.
                let pixel = 1.0 / f64::from(extent[1]);
                let slack = SLOPE_PIXELS * pixel;
                // The first sample behind the wall decides; what is too near to call is left out.
                let sample = |e: &Ended| (e.wall / stride).ceil();
                let reached = |e: &Ended| sample(e) <= steps - slack / stride && sample(e) * stride < e.border - slack;
                let unreached = |e: &Ended| e.wall > steps * stride + slack;
                let beyond = share(&all, |e| unreached(e) && e.hit.is_some());
                let right = |e: &Ended| {
                    let behind = e.hit.map(|h| h - e.wall);
                    behind.is_some_and(|b| b > first * stride - slack && b < (first + 1.0) * stride + slack)
                        && e.beside < SLOPE_PIXELS
                };
                let (reached_share, right_share) = (share(&all, reached), share(&all, |e| reached(e) && right(e)));
                let mut parts: Vec<f64> = all
                    .iter()
                    .filter(|e| reached(e) && right(e))
                    .filter_map(|e| Some((e.hit? - e.wall) / stride))
                    .collect();
                parts.sort_by(f64::total_cmp);
                let median = parts[parts.len() / 2];
                println!(
                    "{what}: {reached_share:.3} in reach, {right_share:.3} right, {beyond:.3} beyond; median {median:.3} of a step"
                );
                assert!(all.len() > 1000 && reached_share > 0.05, "{what}");
                assert!(right_share > 0.99 * reached_share, "{what}");
                assert!(beyond < 0.01, "{what}: nothing is hit beyond the last step");
                // Rays meet the wall anywhere in a step; a stride far below a pixel drowns in Alg. 2's error.
                if stride > 2.0 * pixel / 3.0 {
                    assert!((median - first - 0.5).abs() < 0.1, "{what}");
                }
            }
        }
    }
}

#[test]
fn binary_searches_end_within_epsilon_of_the_wall() {
    let gpu = gpu();
    for extent in [[512, 256], [321, 239]] {
        for (preset, epsilon) in [(Preset::Published, 0.01), (Preset::Author, 2e-4)] {
            for roll in [0.0, 0.3] {
                let case = Case { roll };
                let setup = Setup { preset, split: true, fade: false, ..Setup::new(extent) };
                let shown = show(&gpu, &case.scene(), case.camera(extent), "linear", &setup, &Globals::default());
                let what = format!("linear, {preset:?}, roll {roll}, {extent:?}");
                let all = ended(&case, &shown);
                // The wall has one depth, so that a depth within epsilon is a length within epsilon / slope.
                let within = |e: &Ended| e.hit.is_some_and(|h| (h - e.wall).abs() * e.depth_slope < 1.05 * epsilon);
                let found = share(&all, |e| e.hit.is_some());
                let right = share(&all, |e| within(e) && e.beside < SLOPE_PIXELS);
                println!("{what}: {found:.3} of {} found, {right:.3} within epsilon", all.len());
                assert!(all.len() > 1000 && found > 0.98, "{what}");
                assert!(right > 0.99 * found, "{what}");
            }
        }
    }
}

#[test]
fn cones_of_no_width_meet_the_wall_where_they_should() {
    let gpu = gpu();
    let extent = [321, 239];
    for poster_filter in [PosterFilter::Mip, PosterFilter::Volume] {
        for (preset, least) in [(Preset::Published, 0.97), (Preset::Author, 0.99)] {
            let case = Case { roll: 0.3 };
            let setup = Setup { preset, poster_filter, split: true, fade: false, ..Setup::new(extent) };
            let shown = show(&gpu, &case.scene(), case.camera(extent), "poster", &setup, &Globals::default());
            let what = format!("poster, {poster_filter:?}, {preset:?}");
            let mut all = ended(&case, &shown);
            let found = share(&all, |e| e.hit.is_some());
            all.retain(|e| e.hit.is_some());
            // The poster marches in view space, without Alg. 2's difference. Epsilon is 2e-4 of the depth,
            // 1.2 mm at 6 m; a ray as flat as any here crosses that within 0.2 pixels of 38 mm.
            let near = share(&all, |e| e.pixels < 0.25);
            println!("{what}: {found:.3} found, {near:.3} of them near");
            assert!(all.len() > 1000 && found > least && near > 0.98, "{what}");
        }
    }
}

#[test]
fn a_mirror_lookup_knows_no_roughness() {
    let gpu = gpu();
    let extent = [160, 120];
    let [mirror, rough] = [0.0, 0.6].map(|roughness| {
        let globals = Globals { roughness: Some(roughness), ..Globals::default() };
        show(&gpu, &clutter(), clutter_camera(extent), "linear", &Setup::new(extent), &globals)
    });
    assert_eq!(mirror.get("reflection"), rough.get("reflection"));
}

#[test]
fn right_is_right_and_down_is_up() {
    const RED: [u8; 3] = [255, 0, 0];
    const GREEN: [u8; 3] = [0, 255, 0];
    const BLUE: [u8; 3] = [0, 0, 255];
    const WHITE: [u8; 3] = [255, 255, 255];
    let gpu = gpu();
    let scene = quarters([BLUE, RED, GREEN, WHITE]);
    let extent = [320, 240];
    let view = camera(EYE.as_vec3(), EYE.as_vec3() + Vec3::Z, extent);
    // With no roughness SSLR reaches a fifth of the screen only. The poster as published loses rays whose
    // step leaves the screen.
    let usual = Setup { split: true, fade: false, ..Setup::new(extent) };
    let author = Setup { preset: Preset::Author, ..usual };
    let volume = Setup { poster_filter: PosterFilter::Volume, ..author };
    let fixed =
        Setup { march: March::Fixed, tuning: Tuning { march_stride: Some(0.01), ..Tuning::default() }, ..usual };
    for (method, setup, roughness) in [
        ("ssct", usual, 0.0),
        ("hzct", usual, 0.0),
        ("sslr", usual, 0.03),
        ("linear", author, 0.0),
        ("linear", fixed, 0.0),
        ("poster", author, 0.0),
        ("poster", volume, 0.0),
        ("ssr", usual, 0.0),
        ("ssr-fast", usual, 0.0),
        // The wall is a side of the proxy box, so that the map is exact there.
        ("pccm", usual, 0.0),
    ] {
        let globals = Globals { roughness: Some(roughness), ..Globals::default() };
        let shown = show(&gpu, &scene, view, method, &setup, &globals);
        let (lit, reflection) = (shown.get("color"), shown.get("reflection"));
        // Directly: rows from the top, so the top quarters are seen in the top rows.
        assert_eq!(bytes(lit.at(40, 10)), GREEN);
        assert_eq!(bytes(lit.at(280, 10)), WHITE);
        assert_eq!(bytes(lit.at(40, 130)), BLUE);
        assert_eq!(bytes(lit.at(280, 130)), RED);
        // Mirrored in the floor: sides stay, up and down change places. SSLR's blur may mix in a hundredth
        // of the next quarter, which sRGB shows as 25.
        let slack = if roughness > 0.0 { 25 } else { 0 };
        for (x, y, color) in [(40, 160, BLUE), (280, 160, RED), (40, 235, GREEN), (280, 235, WHITE)] {
            let found = bytes(reflection.at(x, y));
            let near = found.iter().zip(color).all(|(f, c)| f.abs_diff(c) <= slack);
            assert!(near, "{method}, {setup:?}, ({x}, {y}): {found:?}, not {color:?}");
        }
        assert_eq!(reflection.at(40, 10), [0.0; 4], "the wall does not reflect");
    }
}

/// A mirror ramp under a red ceiling: its rays go up, at its top away from the camera and at its
/// foot towards it. All else is black.
struct Ramp;

impl Ramp {
    const TILT: f64 = 0.635;
    const FOOT: DVec3 = DVec3::new(0.0, 0.0, 3.2);

    fn normal() -> DVec3 {
        DVec3::new(0.0, Self::TILT.cos(), -Self::TILT.sin())
    }

    fn show(gpu: &Gpu, method: &str, fade: bool) -> Shown {
        let mut b = Builder::new("ramp");
        let mirror = b.mirror();
        let up = Vec3::new(0.0, Self::TILT.sin() as f32, Self::TILT.cos() as f32);
        b.quad(mirror, Self::FOOT.as_vec3() - Vec3::X * 2.0, Vec3::X * 4.0, up * 1.5, Self::normal().as_vec3());
        let black = b.matt(Vec3::ZERO);
        b.quad(black, Vec3::new(-30.0, -10.0, 12.0), Vec3::X * 60.0, Vec3::Y * 40.0, -Vec3::Z);
        let red = b.matt(Vec3::X);
        b.light(Vec3::Y);
        b.quad(red, Vec3::new(-9.0, 3.0, 2.0), Vec3::X * 18.0, Vec3::Z * 10.0, -Vec3::Y);
        let extent = [320, 240];
        let setup = Setup { split: true, fade, ..Setup::new(extent) };
        let view = camera(EYE.as_vec3(), EYE.as_vec3() + Vec3::Z, extent);
        show(gpu, &b.0, view, method, &setup, &Globals::default())
    }

    /// Direction of a pixel's mirror ray, and whether it meets the ceiling on screen.
    fn ray(shown: &Shown, uv: DVec2) -> (DVec3, bool) {
        let (p, r) = mirror_ray(shown, uv, Self::FOOT - EYE, Self::normal());
        (r, on_screen(shown, p + r * ((3.0 - EYE.y - p.y) / r.y)).is_some())
    }
}

#[test]
fn rays_towards_the_camera_are_traced_by_ssct_alone() {
    let gpu = gpu();
    let [ssct, hzct] = ["ssct", "hzct"].map(|m| Ramp::show(&gpu, m, true));
    let (mut away, mut towards, mut on_ceiling, mut red) = (0, 0, 0, 0);
    for (x, y, uv) in reflecting(&ssct) {
        let (r, meets) = Ramp::ray(&ssct, uv);
        let paths = [&ssct, &hzct].map(|s| path(s.get("hits").at(x, y)));
        let colors = [&ssct, &hzct].map(|s| s.get("reflection").at(x, y));
        // The threshold is not at 0 but at a V_z of 1e-5, for a ray of one near-plane length.
        if r.z > 0.03 {
            away += 1;
            assert_eq!(paths.map(PathCode::by_hi_z), [Some(true); 2], "({x}, {y}), {r}");
        } else if r.z < 0.0 {
            towards += 1;
            assert_eq!(paths[0].by_hi_z(), Some(false), "({x}, {y}), {r}");
            assert_eq!(paths[1], PathCode::Untraced, "({x}, {y}), {r}");
            assert_eq!(colors[1], [0.0; 4], "hzct is black");
            assert_eq!(hzct.get("composite").at(x, y)[..3], [0.0; 3], "hzct is black");
            if meets {
                on_ceiling += 1;
                red += usize::from(paths[0] == PathCode::Linear && bytes(colors[0]) == [255, 0, 0]);
            }
        }
    }
    println!("{away} pixels away from the camera, {towards} towards it, {red} of {on_ceiling} find the ceiling");
    assert!(away > 1000 && towards > 1000 && on_ceiling > 1000);
    // The march finds the ceiling, unless its growing step carries it off the screen first.
    assert!(red * 100 > on_ceiling * 98, "{red} of {on_ceiling}");
}

#[test]
fn hits_fade_towards_the_border_and_hzct_towards_the_camera() {
    let gpu = gpu();
    for method in ["ssct", "hzct"] {
        let (mut none, mut part, mut whole, mut grazing) = (0, 0, 0, 0);
        let case = Case { roll: 0.3 };
        let extent = [320, 240];
        let setup = Setup { split: true, ..Setup::new(extent) };
        let wall = show(&gpu, &case.scene(), case.camera(extent), method, &setup, &Globals::default());
        let ramp = Ramp::show(&gpu, method, true);
        for (shown, is_ramp) in [(&wall, false), (&ramp, true)] {
            let (hits, reflection) = (shown.get("hits"), shown.get("reflection"));
            for (x, y, uv) in reflecting(shown) {
                let hit = hits.at(x, y);
                if !path(hit).is_hit() {
                    continue;
                }
                // Eq. 4.7 with I_start = 0.8 and I_end = 1.
                let distance = (DVec2::new(f64::from(hit[0]), f64::from(hit[1])) - 0.5).length() * 2.0;
                let mut fade = 1.0 - ((distance - 0.8) / 0.2).clamp(0.0, 1.0);
                let mut tolerance = 1.0 / 1024.0;
                if method == "hzct" && is_ramp {
                    let z = Ramp::ray(shown, uv).0.z;
                    fade *= (10.0 * z).clamp(0.0, 1.0);
                    grazing += usize::from(z < 0.09);
                    // The normal is stored in f16: 5e-4 at most, twice that in R, ten times in the fade.
                    tolerance = 0.012;
                }
                let found = f64::from(reflection.at(x, y)[3]);
                assert!((found - fade).abs() <= tolerance, "{method}, ({x}, {y}): {found} against {fade}");
                if !is_ramp {
                    none += usize::from(fade == 0.0);
                    part += usize::from(fade > 0.0 && fade < 1.0);
                    whole += usize::from(fade == 1.0);
                    let (color, composite) = (reflection.at(x, y), shown.get("composite").at(x, y));
                    for c in 0..3 {
                        assert!((composite[c] - color[c] * color[3]).abs() <= 1.0 / 1024.0, "({x}, {y})");
                    }
                }
            }
        }
        assert!(none > 50 && part > 1000 && whole > 1000, "{none} {part} {whole}");
        assert!(method == "ssct" || grazing > 500, "{grazing}");
    }
}

#[test]
fn without_fade_nothing_fades() {
    let gpu = gpu();
    for method in ["ssct", "hzct", "ssr", "ssr-fast"] {
        let shown = Ramp::show(&gpu, method, false);
        for (hit, color) in shown.get("hits").texels().zip(shown.get("reflection").texels()) {
            assert_eq!(color[3], if path(hit).is_hit() { 1.0 } else { 0.0 });
        }
    }
}

#[test]
fn far_rays_fall_back_as_published() {
    // V_z is that of one near-plane length (Alg. 2): n · n f / (f − n) / z² · R_z, with n = 0.1 and R_z
    // nearly 1. It falls below ε = 1e-5 at about 32 m (an erratum of Alg. 6 that is kept).
    let gpu = gpu();
    let mut b = Builder::new("far");
    let mirror = b.mirror();
    b.quad(mirror, Vec3::new(-200.0, 0.0, 0.0), Vec3::X * 400.0, Vec3::Z * 200.0, Vec3::Y);
    let gray = b.matt(Vec3::splat(0.5));
    b.quad(gray, Vec3::new(-200.0, -1.0, 200.0), Vec3::X * 400.0, Vec3::Y * 300.0, -Vec3::Z);
    let extent = [160, 240];
    let view = camera(EYE.as_vec3(), EYE.as_vec3() + Vec3::Z, extent);
    for (method, beyond) in [("ssct", Some(false)), ("hzct", None)] {
        let setup = Setup { split: true, ..Setup::new(extent) };
        let shown = show(&gpu, &b.0, view, method, &setup, &Globals::default());
        let (mut near, mut far) = (0, 0);
        for (x, y, uv) in reflecting(&shown) {
            let (p, _) = mirror_ray(&shown, uv, -EYE, DVec3::Y);
            let by = path(shown.get("hits").at(x, y)).by_hi_z();
            if p.z < 25.0 {
                near += 1;
                assert_eq!(by, Some(true), "{method}, {} m", p.z);
            } else if p.z > 40.0 {
                far += 1;
                assert_eq!(by, beyond, "{method}, {} m", p.z);
            }
        }
        assert!(near > 1000 && far > 300, "{near} {far}");
    }
}

#[test]
fn split_and_combined_give_the_same_reflection() {
    let gpu = gpu();
    let extent = [321, 239];
    for method in methods::METHODS.iter().filter(|m| m.is_screen_space()) {
        for (preset, roughness) in [(Preset::Published, 0.0), (Preset::Published, 0.3), (Preset::Author, 0.1)] {
            let [split, combined] = [true, false].map(|split| {
                let setup = Setup { preset, split, ..Setup::new(extent) };
                let globals = Globals { roughness: Some(roughness), ..Globals::default() };
                show(&gpu, &clutter(), clutter_camera(extent), method.name, &setup, &globals)
            });
            let bits = |p: &Pixels| p.values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
            for what in ["reflection", "composite"] {
                let same = bits(split.get(what)) == bits(combined.get(what));
                assert!(same, "{}, {preset:?}, roughness {roughness}: the {what} differs", method.name);
            }
        }
    }
}

#[test]
fn roughness_changes_the_reflection() {
    let gpu = gpu();
    let case = Case { roll: 0.0 };
    let extent = [320, 240];
    for method in ["ssct", "hzct"] {
        let [mirror, rough] = [0.0, 0.3].map(|roughness| {
            let globals = Globals { roughness: Some(roughness), ..Globals::default() };
            show(&gpu, &case.scene(), case.camera(extent), method, &Setup::new(extent), &globals)
        });
        assert_eq!(mirror.get("color"), rough.get("color"), "the lit colour does not change");
        let difference = rmse(&mirror.get("reflection").values, &rough.get("reflection").values);
        assert!(difference > 0.02, "{method}: {difference}");
        // Blurring keeps the mean colour, roughly, and takes contrast away.
        let spread = |shown: &Shown| {
            let rows: Vec<f32> = (120..200).map(|x| shown.get("reflection").at(x, 220)[0]).collect();
            let mean = rows.iter().sum::<f32>() / rows.len() as f32;
            (mean, (rows.iter().map(|v| (v - mean).powi(2)).sum::<f32>() / rows.len() as f32).sqrt())
        };
        let ((mean_mirror, sharp), (mean_rough, soft)) = (spread(&mirror), spread(&rough));
        assert!(soft < 0.8 * sharp, "{method}: {sharp} {soft}");
        assert!((mean_mirror - mean_rough).abs() < 0.15, "{method}: {mean_mirror} {mean_rough}");
    }
}

#[test]
fn without_reflectivity_the_composite_is_the_lit_colour() {
    let gpu = gpu();
    let extent = [321, 239];
    for method in methods::METHODS.iter().filter(|m| m.is_screen_space()) {
        let of = |reflectivity| {
            let globals = Globals { reflectivity, ..Globals::default() };
            let setup = Setup { split: true, ..Setup::new(extent) };
            show(&gpu, &clutter(), clutter_camera(extent), method.name, &setup, &globals)
        };
        let dull = of(0.0);
        for (composite, lit) in dull.get("composite").texels().zip(dull.get("color").texels()) {
            assert_eq!(
                [0, 1, 2].map(|c| composite[c].to_bits()),
                [0, 1, 2].map(|c| lit[c].to_bits()),
                "{}",
                method.name
            );
        }
        if dull.has("hits") {
            assert!(dull.get("hits").texels().all(|h| path(h) == PathCode::None));
        }
        assert!(rmse(&of(1.0).get("composite").values, &dull.get("composite").values) > 0.01, "{}", method.name);
    }
}

#[test]
fn sky_does_not_reflect_but_windows_are_hit() {
    let gpu = gpu();
    let mut b = Builder::new("window");
    let window = b.material(window());
    b.quad(window, Vec3::new(-2.0, 0.0, 6.0), Vec3::X * 4.0, Vec3::Y * 3.0, -Vec3::Z);
    let mirror = b.mirror();
    b.quad(mirror, Vec3::new(-3.0, 0.0, 1.0), Vec3::X * 6.0, Vec3::Z * 5.0, Vec3::Y);
    let extent = [320, 240];
    let view = camera(EYE.as_vec3(), EYE.as_vec3() + Vec3::Z, extent);
    for method in ["ssct", "hzct"] {
        let setup = Setup { split: true, fade: false, ..Setup::new(extent) };
        let shown = show(&gpu, &b.0, view, method, &setup, &Globals::default());
        let (depth, hits, lit) = (shown.get("depth"), shown.get("hits"), shown.get("color"));
        let (mut sky, mut glass, mut in_mirror) = (0, 0, 0);
        for (y, x) in (0..extent[1]).flat_map(|y| (0..extent[0]).map(move |x| (y, x))) {
            let reflection = shown.get("reflection").at(x, y);
            let is_mirror = shown.get("material").at(x, y)[0] > 0.5;
            if !is_mirror {
                assert_eq!(path(hits.at(x, y)), PathCode::None, "({x}, {y})");
                assert_eq!(reflection, [0.0; 4], "({x}, {y})");
                assert_eq!(shown.get("composite").at(x, y)[..3], lit.at(x, y)[..3], "({x}, {y})");
                assert!(lit.at(x, y)[2] > 0.05, "sky and windows show the environment");
                sky += usize::from(depth.at(x, y)[0] == 0.0);
                glass += usize::from(depth.at(x, y)[0] > 0.0);
                continue;
            }
            let uv = DVec2::new((f64::from(x) + 0.5) / 320.0, (f64::from(y) + 0.5) / 240.0);
            let (p, r) = mirror_ray(&shown, uv, -EYE, DVec3::Y);
            let at = p + r * ((6.0 - p.z) / r.z);
            if at.x.abs() < 1.8 && (0.2..2.8).contains(&(at.y + EYE.y)) {
                let expected = on_screen(&shown, at).expect("the window is on screen");
                let hit = hits.at(x, y);
                assert_eq!(path(hit), PathCode::HiZ, "{method}, ({x}, {y})");
                let error = (DVec2::new(f64::from(hit[0]), f64::from(hit[1])) - expected) * DVec2::new(320.0, 240.0);
                assert!(error.abs().max_element() < 2.54, "{method}, ({x}, {y}): {error} pixels off");
                let seen = bilinear(lit, hit[0], hit[1]);
                for c in 0..3 {
                    // 8 bits of a filter's weights, and f16.
                    assert!((reflection[c] - seen[c]).abs() < 0.003, "({x}, {y}): {reflection:?} {seen:?}");
                }
                in_mirror += 1;
            }
        }
        assert!(sky > 1000 && glass > 1000 && in_mirror > 1000, "{sky} {glass} {in_mirror}");
    }
}

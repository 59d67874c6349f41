//! Compares the glossy passes of `unified` with their twins on the CPU, each pass by itself. A twin takes the results
//! that the device made in the pass before, so that a difference stays in the pass where it arises.

use crate::common::{check_validation, gpu, is_gpu_assisted, tolerated_share};
use glam::{IVec2, Vec2, Vec3, Vec4};
use ssct::gpu::frame::Mode;
use ssct::gpu::{FrameContext, Gpu, Image, Pixels, ShaderStage};
use ssct::methods::{self, Setup, Wants, unified};
use ssct::passes::classify::ClassifyPass;
use ssct::passes::color_chain::ColorChainPass;
use ssct::passes::gbuffer::GBufferImages;
use ssct::passes::lost::{ListContent, LostRays, capture_block};
use ssct::passes::pyramid::{self, PyramidPass};
use ssct::passes::tiles::UnifiedSetup;
use ssct::passes::unified_gloss::{GlossImages, UnifiedGlossInput, UnifiedGlossPass};
use ssct::passes::{Canvas, GBuffer, LIT_COLOR, Reflectors};
use ssct_ground::math::OracleVersion;
use ssct_ground::math::random::Stream;
use ssct_lab::stage::{Globals, Shot, Stage, gbuffer};
use ssct_scenes::{Camera, GBufferData, Lens, Surface};
use ssct_truth::reference::Level;
use ssct_truth::reference::unified::{AimedRay, Gloss, NeighbourRay, ResolvedCell, Traversal};

/// The distances from the middle of the screen, in half screens, between which a reflection fades.
/// `unified::parameters` gives these numbers.
const FADE: [f32; 2] = [0.8, 1.0];

/// The choices by which a G-buffer is drawn.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DrawMode {
    /// The version of the oracle that the traversal follows.
    pub(crate) oracle: OracleVersion,
    /// Whether passes run over the tiles of a list. Otherwise they run over the whole image, and all its reflectors
    /// must be of one kind.
    pub(crate) tiles: bool,
    /// Whether another reflection lies behind this one, so that the fade is stored.
    pub(crate) over: bool,
}

/// The results of each pass on the device: colour chain, rays of narrow and of wide lobes, cells, and both images.
pub(crate) struct Drawn {
    chain: Vec<Level<Vec3>>,
    narrow: Level<NeighbourRay>,
    wide: Level<NeighbourRay>,
    cells: Level<ResolvedCell>,
    reflection: Pixels,
    composite: Pixels,
}

/// Runs the glossy passes on a G-buffer, and reads the result of each.
pub(crate) fn draw(gpu: &Gpu, data: &GBufferData, mode: DrawMode) -> Drawn {
    let extent = [data.width, data.height];
    let mut context = FrameContext::new(gpu).unwrap();
    let images = GBufferImages::upload(&mut context, data).unwrap();
    let setup = UnifiedSetup {
        extent,
        projection: data.camera.kind(),
        strip: pyramid::strip(extent),
        oracle: mode.oracle,
        over_fallback: mode.over,
        composite: true,
        reflection: true,
        walks_screen: true,
        follows_lost_rays: false,
        triangles: None,
        own_rays: 0,
        stores_ends: false,
        trace_stage: ShaderStage::Fragment,
        resolve_stage: ShaderStage::Fragment,
    };
    let pyramid = PyramidPass::for_projection(gpu, extent, setup.projection).unwrap();
    let color = ColorChainPass::in_few_passes(gpu).unwrap();
    let classify = ClassifyPass::new(gpu, extent).unwrap();
    let gloss = UnifiedGlossPass::new(gpu, &setup).unwrap();
    let [composite, reflection] =
        ["composite", "reflection"].map(|name| Image::target(gpu, name, LIT_COLOR, extent).unwrap());
    let canvas = Canvas { composite: Some(&composite), reflection: Some(&reflection) };
    let has_lobes = |wide: bool| (0..data.depth.len()).any(|i| data.reflects(i) && (data.roughness[i] > 0.2) == wide);
    let reflectors = Reflectors { mirrors: false, narrow: has_lobes(false), wide: has_lobes(true), everywhere: true };
    assert!(mode.tiles || reflectors.kinds() == 1);
    let gbuffer = GBuffer { reflectors, ..images.gbuffer() };
    let parameters = unified::parameters(&data.camera, extent, true);
    let mut frame = context.begin(Mode::Plain).unwrap();
    let blocks = pyramid.record(&mut frame, &gbuffer, &parameters).unwrap();
    let chain = color.record(&mut frame, &gbuffer).unwrap().0;
    let tiles = if mode.tiles {
        let tiles = classify.record(&mut frame, &gbuffer, &parameters).unwrap();
        canvas.begin(&mut frame, gbuffer.color).unwrap();
        tiles
    } else {
        classify.whole()
    };
    let lost = LostRays::new(gpu, extent, ListContent::Nothing).unwrap();
    let block = capture_block(&data.camera, None);
    let lost_rays = lost.bindings(&mut frame, &block, None, false).unwrap();
    let input = UnifiedGlossInput { gbuffer, pyramid: blocks, tiles, canvas, lost_rays, triangle_bindings: None };
    if reflectors.narrow {
        gloss.trace_narrow(&mut frame, &input, &parameters).unwrap();
        gloss.resolve_narrow(&mut frame, &input, &parameters).unwrap();
    }
    if reflectors.wide {
        gloss.trace_wide(&mut frame, &input, &parameters).unwrap();
        gloss.resolve_wide(&mut frame, &input, &parameters).unwrap();
    }
    frame.finish().unwrap();
    let mut read = |image: &Image| context.read(image.level(0)).unwrap();
    let vec4 = |texel: &[f32]| Vec4::from_slice(texel);
    let GlossImages { records, place, seen, cell_reflection, cell_surface, .. } = gloss.images();
    let [narrow, place, seen, cell_reflection, cell_surface] =
        [records, place, seen, cell_reflection, cell_surface].map(&mut read);
    let texel_pairs = |a: &Pixels, b: &Pixels| -> Vec<[Vec4; 2]> {
        a.texels().zip(b.texels()).map(|(a, b)| [vec4(a), vec4(b)]).collect()
    };
    let unpack =
        |texel: &[f32]| NeighbourRay::unpack_record([0, 1, 2, 3].map(|channel: usize| texel[channel].to_bits()));
    let wide = texel_pairs(&place, &seen).into_iter().map(|[key, color]| NeighbourRay { key, color }).collect();
    let cells = texel_pairs(&cell_reflection, &cell_surface);
    let cells = cells.into_iter().map(|[reflection, surface]| ResolvedCell { reflection, surface }).collect();
    let (reflection, composite) = (read(&reflection), read(&composite));
    Drawn {
        narrow: level(&narrow, narrow.texels().map(unpack).collect()),
        wide: level(&place, wide),
        cells: level(&place, cells),
        reflection,
        composite,
        chain: (0..chain.levels())
            .map(|number| {
                let pixels = context.read(chain.level(number)).unwrap();
                level(&pixels, pixels.texels().map(Vec3::from_slice).collect())
            })
            .collect(),
    }
}

/// Returns an image with its texels converted to another type.
fn level<T>(pixels: &Pixels, texels: Vec<T>) -> Level<T> {
    Level { width: pixels.width, height: pixels.height, texels }
}

/// Returns one step of 16-bit floats at a value. A device may round a stored value up or down.
fn half_step(value: f32) -> f32 {
    (value.abs() / 1024.0).max(6e-8)
}

/// The error that 32-bit arithmetic adds, in steps of 16-bit storage. A quarter of a step is 2⁻¹² of a value, which is
/// 4096 roundings. A weight takes a few tens of operations, among them an exponent whose error is up to 14 units in the
/// last place. A mean of colours that are not negative has at most twice the relative error of its weights.
const ARITHMETIC: f32 = 0.25;

/// Returns the greatest error of a ray's direction on the device. It has 16 roundings, and the effect of one step of 1
/// − u on the sine of the angle from the lobe's middle: sin² = −2 ln(1 − u) / (α + 1). Vulkan allows larger errors of
/// `cos` and `sin`; on a device with such errors, rays would end elsewhere and the test would fail.
fn aim_error(aim: &AimedRay) -> f32 {
    let square_error = f32::EPSILON / aim.lobe.power;
    let sine = aim.direction.distance(aim.lobe.mirror);
    16.0 * f32::EPSILON / 2.0 + square_error / sine.max(square_error.sqrt())
}

/// Counts of the rays, pixels or cells that were compared in a pass.
#[derive(Debug, Default, Clone, Copy)]
pub(crate) struct Count {
    /// Rays, or pixels and cells, that were compared.
    pub(crate) all: usize,
    /// Rays that hit, or pixels and cells that show a hit.
    pub(crate) hits: usize,
    /// Rays that end in another pixel, or nowhere, if their direction is off by [`aim_error`].
    pub(crate) ties: usize,
    /// Rays, or pixels and cells, that are off by more than is allowed.
    pub(crate) wrong: usize,
}

impl Count {
    /// Adds the counts of another comparison.
    fn add(&mut self, other: Self) {
        self.all += other.all;
        self.hits += other.hits;
        self.ties += other.ties;
        self.wrong += other.wrong;
    }
}

/// Returns a ray, and eight rays whose directions are off by [`aim_error`] to all sides.
fn aims_within_error(aim: AimedRay) -> impl Iterator<Item = AimedRay> {
    let (x, y) = aim.direction.any_orthonormal_pair();
    let aside = (0..8).map(move |i| {
        let (sin, cos) = (i as f32 * std::f32::consts::FRAC_PI_4).sin_cos();
        aim_error(&aim) * (cos * x + sin * y)
    });
    std::iter::once(Vec3::ZERO).chain(aside).map(move |offset| AimedRay { direction: aim.direction + offset, ..aim })
}

/// Compares the ray `found` on the device with its twin, and adds the result to `count`. Key and colour must lie
/// between those of the twin along directions that are off by [`aim_error`]. Beyond these bounds, the key may be off by
/// its rounding, which `key_error` gives, and the colour by a step of 16-bit floats.
fn check_ray(
    gloss: &Gloss,
    aim: AimedRay,
    found: &NeighbourRay,
    key_error: impl Fn(&AimedRay, &NeighbourRay) -> [f32; 4],
    twin: impl Fn(&AimedRay) -> NeighbourRay,
    count: &mut Count,
) {
    let twins: Vec<NeighbourRay> = aims_within_error(aim).map(|aim| twin(&aim)).collect();
    let bound = |extreme: fn(Vec4, Vec4) -> Vec4| {
        let pairs = twins.iter().map(|ray| [ray.key, ray.color]);
        pairs.reduce(|a, b| [extreme(a[0], b[0]), extreme(a[1], b[1])]).unwrap()
    };
    let ([key_low, color_low], [key_high, color_high]) = (bound(Vec4::min), bound(Vec4::max));
    let key_allowed = Vec4::from(key_error(&aim, found));
    let color_allowed = Vec4::from(color_high.to_array().map(half_step));
    let outside_by = |found: Vec4, low: Vec4, high: Vec4| (low - found).max(found - high);
    let is_right = outside_by(found.key, key_low, key_high).cmple(key_allowed).all()
        && outside_by(found.color, color_low, color_high).cmple(color_allowed).all();
    if !is_right && count.wrong == 0 {
        println!("  {found:?}, twins: {twins:?}, {aim:?}, {:?}", gloss.trace_glossy_ray(&aim));
    }
    let hit_pixel = |aim: AimedRay| gloss.trace_glossy_ray(&aim).map(|(hit, _)| hit.pixel);
    count.add(Count {
        all: 1,
        hits: usize::from(found.key.w > 0.0),
        ties: usize::from(aims_within_error(aim).any(|other| hit_pixel(other) != hit_pixel(aim))),
        wrong: usize::from(!is_right),
    });
}

/// Compares a pixel of two images of 16-bit floats, reflection and composite, with the twin's. If another reflection
/// lies behind, the fade is rounded before the first image is divided by it: a second step, and a longer one where the
/// fade is small.
fn check_shown(found: [Vec4; 2], twin: [Vec4; 2], over: bool, count: &mut Count) {
    let fade = twin[0].w;
    let fade_error = if fade > 0.0 { half_step(fade) / fade } else { 1.0 / 1024.0 };
    let allowed = |twin_value: f32, image: usize| match over {
        true if image == 0 => (1.0 + ARITHMETIC) * half_step(twin_value) + twin_value.abs() * fade_error,
        true => (2.0 + ARITHMETIC) * half_step(twin_value),
        false => (1.0 + ARITHMETIC) * half_step(twin_value),
    };
    let is_wrong = (0..2).any(|image| {
        let pairs = found[image].to_array().into_iter().zip(twin[image].to_array());
        pairs.into_iter().any(|(found_value, twin_value)| (found_value - twin_value).abs() > allowed(twin_value, image))
    });
    if is_wrong && count.wrong == 0 {
        println!("  {found:?}\n  twin: {twin:?}");
    }
    count.add(Count { all: 1, hits: usize::from(twin[0].w > 0.0), ties: 0, wrong: usize::from(is_wrong) });
}

/// Returns the coordinates of the pixels of an image, row after row.
fn pixels(width: u32, height: u32) -> impl Iterator<Item = IVec2> {
    (0..height as i32).flat_map(move |y| (0..width as i32).map(move |x| IVec2::new(x, y)))
}

/// A count for each pass: "trace/narrow", "trace/wide", "cells", "resolve/narrow" and "resolve/wide".
pub(crate) type Counts = [Count; 5];

/// Compares the results of every pass with the twin's, and counts.
pub(crate) fn check(data: &GBufferData, drawn: &Drawn, mode: DrawMode) -> Counts {
    let traversal = Traversal::new(data).of_version(mode.oracle);
    let gloss = Gloss::new(&traversal, &drawn.chain, Some(FADE), mode.over);
    let mut counts = Counts::default();
    let [narrow, wide, cells, resolve_narrow, resolve_wide] = &mut counts;
    // The middle of a narrow lobe is stored in steps of 1 / 32767 along two axes, and rounding may move it by one step.
    // The root of its power is exact but for the last bits.
    let narrow_error = |aim: &AimedRay, _: &NeighbourRay| {
        let step = 4.0 / 32767.0;
        [step, step, step, 8.0 * f32::EPSILON * aim.lobe.power.sqrt()]
    };
    // Places and densities of wide lobes are exact but for the last bits of the greatest coordinate. If a ray goes far,
    // the error grows with the depth of its end over that of its start. A near hit is stored a thousand times as far
    // away along its ray, which makes its error a thousand times as great.
    let wide_error = |aim: &AimedRay, found: &NeighbourRay| {
        let greatest = found.key.truncate().abs().max_element() * (found.key.z / aim.point.z).max(1.0);
        let is_near = |position: Vec2| (position - aim.pixel.as_vec2() - 0.5).abs().max_element() < 8.5;
        let near = gloss.trace_glossy_ray(aim).is_some_and(|(hit, _)| is_near(hit.position));
        let error = 8.0 * f32::EPSILON * if near { 1000.0 * aim.point.abs().max_element() } else { greatest };
        [error, error, error, 8.0 * f32::EPSILON * 64.0]
    };
    for pixel in pixels(data.width, data.height) {
        let (x, y) = (pixel.x as u32, pixel.y as u32);
        if let Some(aim) = gloss.aim_narrow(pixel) {
            let twin = |aim: &AimedRay| NeighbourRay::unpack_record(gloss.trace_narrow_pixel(aim).pack_record());
            check_ray(&gloss, aim, &drawn.narrow.at_clamped(x, y), narrow_error, twin, narrow);
        }
        let shown = [&drawn.reflection, &drawn.composite].map(|image| Vec4::from_slice(image.texel(x, y)));
        let (twin, count) = match gloss.resolve_narrow(&drawn.narrow, pixel) {
            Some(twin) => (Some(twin), &mut *resolve_narrow),
            None => (gloss.resolve_wide(&drawn.cells, pixel), &mut *resolve_wide),
        };
        match twin {
            Some((reflection, color)) => check_shown(shown, [reflection, color.extend(1.0)], mode.over, count),
            // Pixels without a glossy reflection are copied, and nothing is rounded.
            None => {
                let i = data.index(x, y);
                let is_lit = data.surface[i] == Surface::Lit && data.depth[i] > 0.0;
                let lit = f32::from(u8::from(is_lit));
                count.wrong += usize::from(shown != [Vec4::ZERO, data.color[i].extend(lit)]);
            }
        }
    }
    for cell in pixels(drawn.wide.width, drawn.wide.height) {
        let (x, y) = (cell.x as u32, cell.y as u32);
        let Some(aim) = gloss.aim_wide(cell) else { continue };
        let twin = |aim: &AimedRay| gloss.trace_wide_cell(aim);
        check_ray(&gloss, aim, &drawn.wide.at_clamped(x, y), wide_error, twin, wide);
        let (found, twin) = (drawn.cells.at_clamped(x, y), gloss.resolve_cell(&drawn.wide, cell));
        check_shown([found.reflection, found.surface], [twin.reflection, twin.surface], mode.over, cells);
    }
    counts
}

/// Draws the G-buffer of a view of the rooms with one roughness and one deviation of normals.
pub(crate) fn rooms(gpu: &Gpu, view: &str, extent: [u32; 2], roughness: f32, deviation: f32) -> GBufferData {
    let scene = crate::common::built_in("rooms");
    let view = scene.view(view).unwrap();
    let globals = Globals { roughness: Some(roughness), normal_deviation: Some(deviation), ..Globals::default() };
    let mut stage = Stage::new(gpu, &scene).unwrap();
    let (materials, camera) = (globals.materials(&scene, view), view.camera(&scene, extent));
    let shot =
        Shot::new(&mut stage, methods::find("hzct").unwrap(), &Setup::new(extent), Wants::IMAGE, camera, materials)
            .unwrap();
    stage.output(&shot).unwrap();
    gbuffer::read(&mut stage.context, &shot).unwrap()
}

/// Returns the G-buffer with a random roughness in each square of `block` pixels a side, so that mirrors, narrow lobes
/// and wide lobes are neighbours. One square in ten does not reflect.
pub(crate) fn mixed(data: &GBufferData, block: u32) -> GBufferData {
    let stream = Stream::new(u64::from(block), u64::from(data.width));
    let mut mixed = data.clone();
    for (x, y) in (0..data.height).flat_map(|y| (0..data.width).map(move |x| (x, y))) {
        let block_index = u64::from(y / block * 1000 + x / block);
        let i = data.index(x, y);
        mixed.roughness[i] =
            round_to_half([0.0, 0.02, 0.1, 0.2, 0.21, 0.4, 0.7, 1.0][(8.0 * stream.uniform(2 * block_index)) as usize]);
        mixed.reflectivity[i] *= f32::from(u8::from(stream.uniform(2 * block_index + 1) < 0.9));
    }
    mixed
}

/// Rounds a value to a 16-bit float.
fn round_to_half(value: f32) -> f32 {
    half::f16::from_f32(value).to_f32()
}

/// Returns a G-buffer of noise: depths from 0.2 to 400 m, normals in any direction, colours up to thousands.
pub(crate) fn noise(extent: [u32; 2]) -> GBufferData {
    let count = u64::from(extent[0]) * u64::from(extent[1]);
    let stream = Stream::new(count, 7);
    // Each pixel has eight random numbers: number 0 is for the view depth z, 1 to 3 for the normal, 4 to 6 for the
    // colour.
    let unit = |pixel: u64, number: u64| stream.uniform(8 * pixel + number);
    let vector = |pixel: u64, first: u64| {
        Vec3::from([0, 1, 2].map(|c| round_to_half(unit(pixel, first + c) as f32 * 2.0 - 1.0)))
    };
    let z = |i: u64| 0.2 * 2000.0_f64.powf(unit(i, 0));
    GBufferData {
        width: extent[0],
        height: extent[1],
        camera: Camera::new(Vec3::ZERO, Vec3::Z, Lens::default(), extent[0] as f32 / extent[1] as f32),
        depth: (0..count).map(|i| ((0.1 * 1000.0 / z(i) - 0.1) / (1000.0 - 0.1)) as f32).collect(),
        normal: (0..count).map(|i| vector(i, 1)).collect(),
        reflectivity: vec![1.0; count as usize],
        roughness: vec![round_to_half(0.3); count as usize],
        color: (0..count).map(|i| vector(i, 4).abs().map(|v| round_to_half(4000.0 * v * v * v))).collect(),
        surface: vec![Surface::Lit; count as usize],
    }
}

/// Returns the G-buffer with sky in six of ten pixels.
fn under_sky(data: &GBufferData) -> GBufferData {
    let stream = Stream::new(6, u64::from(data.width));
    let depth = |(i, depth): (usize, &f32)| if stream.uniform(i as u64) < 0.6 { 0.0 } else { *depth };
    GBufferData { depth: data.depth.iter().enumerate().map(depth).collect(), ..data.clone() }
}

/// Each glossy pass on views of the corridor, on mixed roughnesses and on noise equals its twin within the allowed
/// error. Few rays are ties. An error of one pass would show in an image only as a little more noise.
#[test]
fn every_glossy_pass_is_its_twin() {
    use OracleVersion::{V1, V2};
    let gpu = gpu();
    let corridor = |roughness, deviation| rooms(&gpu, "corridor", [127, 61], roughness, deviation);
    let with_bumps = corridor(0.5, 1.0);
    let mut cases: Vec<(String, GBufferData, bool)> = Vec::new();
    for (roughness, deviation) in [(0.05, 0.0), (0.1, 1.0), (0.3, 0.0), (0.6, 1.0)] {
        cases.push((format!("roughness {roughness}"), corridor(roughness, deviation), true));
    }
    for block in [1, 5, 24] {
        cases.push((format!("mixed in blocks of {block}"), mixed(&with_bumps, block), false));
    }
    for extent in [[1, 1], [53, 1], [5, 3], [66, 65]] {
        cases.push((format!("noise, {extent:?}"), noise(extent), true));
        cases.push((format!("mixed noise, {extent:?}"), mixed(&noise(extent), 3), false));
    }
    cases.push(("noise under a sky".to_owned(), under_sky(&noise([66, 65])), true));
    let case_count = if is_gpu_assisted() { 1 } else { usize::MAX };
    let mut totals = Counts::default();
    for (name, data, is_of_one_kind) in cases.iter().take(case_count) {
        for (oracle, tiles, over) in [(V1, !is_of_one_kind, false), (V2, true, true)] {
            let mode = DrawMode { oracle, tiles, over };
            let counts = check(data, &draw(&gpu, data, mode), mode);
            println!("{name}, {mode:?}: {:?}", counts.map(|count| [count.all, count.hits, count.ties, count.wrong]));
            let most_wrong = |count: &Count| tolerated_share(&gpu) * count.all as f64;
            assert!(counts.iter().all(|count| count.wrong as f64 <= most_wrong(count)), "{name}, {mode:?}");
            totals.iter_mut().zip(counts).for_each(|(total, count)| total.add(count));
        }
    }
    println!("rays or pixels, hits, ties: {:?}", totals.map(|count| [count.all, count.hits, count.ties]));
    // Each pass has over 5000 hits, and less than one ray in 1000 could end in several pixels.
    for Count { all, hits, ties, .. } in totals.into_iter().take(case_count) {
        assert!(hits > 5000 && hits < all && ties * 1000 < all, "{all}, {hits}, {ties}");
    }
    check_validation(&gpu).unwrap();
}

/// If every 16th ray that the device traced is replaced by an empty one, the comparison finds over 5 % of the rays and
/// over 10 % of the gathered pixels wrong. The test above thus notices a lost ray.
#[test]
fn a_ray_that_is_not_gathered_is_seen() {
    let gpu = gpu();
    let mode = DrawMode { oracle: OracleVersion::V1, tiles: true, over: false };
    // A roughness, with the indices in `Counts` of the passes that trace and that gather its rays.
    for (roughness, traced, gathered) in [(0.1, 0, 3), (0.5, 1, 2)] {
        let data = rooms(&gpu, "corridor", [127, 61], roughness, 0.0);
        let mut drawn = draw(&gpu, &data, mode);
        for rays in [&mut drawn.narrow, &mut drawn.wide] {
            rays.texels.iter_mut().step_by(16).for_each(|ray| *ray = NeighbourRay::unpack_record([0; 4]));
        }
        let counts = check(&data, &drawn, mode);
        assert!(counts[traced].wrong * 20 > counts[traced].all, "{counts:?}");
        // Each replaced ray lies in the neighbourhood of 9 pixels, or of 25 cells.
        assert!(counts[gathered].wrong * 10 > counts[gathered].all, "{counts:?}");
    }
}

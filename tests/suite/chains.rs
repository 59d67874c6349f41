//! Compares the chains of the device with their twins on the CPU at every kind of size: odd, prime, one texel wide or
//! high, one texel, powers of two, and sizes of the thesis's table.

use crate::common::{BLUR_WEIGHTS, Shown, bilinear, blur, clutter, clutter_camera, gpu, shared_scenes, show};
use glam::Vec3;
use ssct::gpu::frame::Mode;
use ssct::gpu::{FrameContext, Gpu, Pixels};
use ssct::methods::Setup;
use ssct::methods::ssct::ThesisDrawing;
use ssct::passes::color_chain::{ChainFilter, ChainMask, ColorChainPass};
use ssct::passes::gbuffer::GBufferImages;
use ssct_ground::math::random::Stream;
use ssct_lab::stage::Globals;
use ssct_scenes::{GBufferData, LoadOptions, Surface, scene_file};
use ssct_truth::reference::Level;
use ssct_truth::reference::hi_z::{self, MinMax};
use ssct_truth::reference::visibility::{self, Range};

/// Sizes in pixels.
const SIZES: [[u32; 2]; 14] = [
    [1, 1],
    [2, 2],
    [3, 3],
    [1, 2],
    [5, 1],
    [1, 37],
    [53, 1],
    [2, 61],
    [64, 64],
    [127, 61],
    [131, 96],
    [256, 128],
    [641, 479],
    [800, 600],
];

/// Renders the cluttered scene by `ssct` with a filter of the colour chain. The Hi-Z chain has the maximum beside the
/// minimum.
fn render(gpu: &Gpu, extent: [u32; 2], filter: ChainFilter) -> Shown {
    let setup = Setup::new(extent).with(|p: &mut ThesisDrawing| (p.chain_filter, p.hi_z_maximum) = (filter, true));
    show(gpu, &clutter(), clutter_camera(extent), "ssct", &setup, &Globals::default())
}

/// Converts an image of two channels to a level of minima and maxima.
fn min_max(pixels: &Pixels) -> Level<MinMax> {
    let texels = pixels.texels().map(MinMax::from_texel).collect();
    Level { width: pixels.width, height: pixels.height, texels }
}

/// Converts one channel of an image to a level.
fn channel(pixels: &Pixels, channel: usize) -> Level<f32> {
    let texels = pixels.texels().map(|t| t[channel]).collect();
    Level { width: pixels.width, height: pixels.height, texels }
}

/// Checks that each texel of a shot's Hi-Z chain equals the twin's, to the bit.
fn check_depth(shown: &Shown) {
    let levels = shown.levels("hi-z");
    let extent = [levels[0].width, levels[0].height];
    for (standard, reversed) in levels[0].texels().zip(&shown.get("depth").values) {
        let [min, max] = [standard[0].to_bits(), standard[1].to_bits()];
        assert_eq!([min, max], [(1.0 - reversed).to_bits(); 2], "{extent:?}: level 0");
    }
    let twin = hi_z::chain(&channel(levels[0], 0));
    assert_eq!(levels.len(), twin.len(), "{extent:?}");
    for (n, (gpu, cpu)) in levels.iter().zip(&twin).enumerate() {
        assert_eq!((gpu.width, gpu.height), (cpu.width, cpu.height), "{extent:?}, level {n}");
        for (i, (found, expected)) in gpu.texels().zip(&cpu.texels).enumerate() {
            let bits = [found[0].to_bits(), found[1].to_bits()];
            assert_eq!(bits, [expected.min.to_bits(), expected.max.to_bits()], "{extent:?}, level {n}, texel {i}");
        }
    }
}

/// At every size of `SIZES`, each texel of each level of the Hi-Z chain is the twin's, to the bit. Where a side is odd,
/// a texel must cover the last row or column too, or a ray passes through the surfaces there.
#[test]
fn depth_chains_equal_their_twin_to_the_bit() {
    let gpu = gpu();
    for extent in SIZES {
        let shown = render(&gpu, extent, ChainFilter::Hardware);
        check_depth(&shown);
        if extent[0] * extent[1] > 4000 {
            let reversed = &shown.get("depth").values;
            assert!(reversed.contains(&0.0), "sky is in view");
            let near = reversed.iter().copied().fold(0.0, f32::max);
            assert!(near > 0.05, "near and far are in view: {near}");
        }
    }
}

/// A Hi-Z chain without maxima has one channel, with the same minima, and leads to the same finished image. It is an
/// image of another format, which the same shaders write and read.
#[test]
fn without_maxima_the_minima_and_the_image_are_the_same() {
    let gpu = gpu();
    let extent = [127, 61];
    let shown = [true, false].map(|maximum| {
        let setup = Setup::new(extent).with(|p: &mut ThesisDrawing| p.hi_z_maximum = maximum);
        show(&gpu, &clutter(), clutter_camera(extent), "ssct", &setup, &Globals::default())
    });
    let [both, minimum] = shown.each_ref().map(|s| s.levels("hi-z"));
    assert_eq!(both.len(), minimum.len());
    for (both, minimum) in both.iter().zip(minimum) {
        assert_eq!((both.channels, minimum.channels), (2, 1));
        let minima: Vec<f32> = both.texels().map(|t| t[0]).collect();
        assert_eq!(minima, minimum.values);
    }
    assert_eq!(shown[0].get("composite").values, shown[1].get("composite").values);
}

/// On the large scene of the author's rooms, too, the Hi-Z chain equals the twin, if the scene's files are present. Its
/// depths vary more from pixel to pixel than those of scenes built in code.
#[test]
fn depth_chains_of_the_authors_rooms_equal_their_twin_to_the_bit() {
    let Some(folder) = shared_scenes() else { return };
    let gpu = gpu();
    let scene = scene_file::load(&folder.join("ssct-rooms/rooms.scene.toml"), &LoadOptions::default()).unwrap();
    for (view, extent) in scene.views.iter().zip([[321, 179], [240, 135], [127, 61]]) {
        let setup = Setup::new(extent).with(|p: &mut ThesisDrawing| p.hi_z_maximum = true);
        let camera = view.camera(&scene, extent);
        check_depth(&show(&gpu, &scene, camera, "ssct", &setup, &Globals::default()));
    }
}

/// At every size of `SIZES`, each level of the visibility chain is what the twin makes of the level below. One texel in
/// 1000 may differ by one step, if it lies near the middle between two steps.
#[test]
fn visibility_chains_equal_their_twin_but_for_rounding_ties() {
    // The twin makes each level from the device's level below, so that a difference stays in the level where it arises.
    // A device may fuse or reorder Eq. 4.2, whose denominator f + n − z (f − n) then differs by one unit in the last
    // place of f. At the far plane, this is 6.1e-5 of 0.2, a share of 3e-4, and it counts twice in the quotient. It
    // moves a share by at most 0.16 steps of 1/255, so that only texels which lie this close to the middle between two
    // steps may differ, by one step.
    const TIE: f32 = 0.16;
    let gpu = gpu();
    let (mut texels, mut differing) = (0_usize, 0_usize);
    for extent in SIZES {
        let shown = render(&gpu, extent, ChainFilter::Hardware);
        let range = Range { near_m: shown.camera.lens.near_m, far_m: shown.camera.lens.far_m };
        let (depth, levels) = (shown.levels("hi-z"), shown.levels("visibility"));
        assert_eq!(depth.len(), levels.len());
        assert!(levels[0].values.iter().all(|v| *v == 1.0), "{extent:?}: level 0 is all 1");
        for n in 1..levels.len() {
            let twin =
                visibility::integrate(&min_max(depth[n - 1]), &channel(levels[n - 1], 0), range).expect("a level");
            assert_eq!((levels[n].width, levels[n].height), (twin.width, twin.height));
            for (i, (gpu_share, cpu_share)) in levels[n].values.iter().zip(&twin.texels).enumerate() {
                texels += 1;
                let (gpu_step, cpu_step) =
                    ((gpu_share * 255.0).round(), (visibility::quantize(*cpu_share) * 255.0).round());
                if gpu_step != cpu_step {
                    differing += 1;
                    let from_tie = ((cpu_share * 255.0).fract() - 0.5).abs();
                    assert!(
                        (gpu_step - cpu_step).abs() <= 1.0 && from_tie <= TIE,
                        "{extent:?}, level {n}, texel {i}: {gpu_step} against {}",
                        cpu_share * 255.0
                    );
                }
            }
        }
        if extent[0] * extent[1] > 4000 {
            let coarse = &levels[3];
            assert!(coarse.values.iter().any(|v| *v < 0.9) && coarse.values.contains(&1.0), "the content varies");
        }
    }
    println!("visibility: {differing} of {texels} texels differ by one step");
    assert!(differing * 1000 <= texels, "{differing} of {texels} texels differ");
}

/// The twin makes the whole visibility chain out of level 0 alone. Each level may add one step of 1/255 by rounding, so
/// that level n must lie within n steps. A systematic error would add up over the levels.
#[test]
fn a_visibility_chain_from_end_to_end_stays_within_a_step_a_level() {
    let gpu = gpu();
    let shown = render(&gpu, [641, 479], ChainFilter::Hardware);
    let range = Range { near_m: shown.camera.lens.near_m, far_m: shown.camera.lens.far_m };
    let twin = visibility::chain(&hi_z::chain(&channel(shown.get("hi-z"), 0)), range);
    for (n, (gpu, cpu)) in shown.levels("visibility").iter().zip(&twin).enumerate() {
        for (gpu_share, cpu_share) in gpu.values.iter().zip(&cpu.texels) {
            assert!(
                (gpu_share - cpu_share).abs() * 255.0 <= n as f32 + 0.01,
                "level {n}: {gpu_share} against {cpu_share}"
            );
        }
    }
}

/// Returns the greatest step between 16-bit floats near a value: 1/1024 of it. Rounding to 16 bits moves a value by at
/// most half a step, and two roundings by at most one.
fn float_step(value: f32) -> f32 {
    (value.abs() / 1024.0).max(6e-8)
}

/// If sides are powers of two, each texel of the colour chain is the mean of the four texels below it, within the
/// rounding of 16-bit floats. A blit with another filter, or half a texel off, gives other means.
#[test]
fn blits_of_even_levels_are_box_averages() {
    let gpu = gpu();
    for extent in [[2, 2], [64, 64], [256, 128]] {
        let shown = render(&gpu, extent, ChainFilter::Hardware);
        let levels = shown.levels("color");
        for n in 1..levels.len() {
            let (below, here) = (levels[n - 1], levels[n]);
            for (y, x) in (0..here.height).flat_map(|y| (0..here.width).map(move |x| (y, x))) {
                for c in 0..3 {
                    // A level whose side is one texel has no second texel there, so that its only texel counts twice.
                    let texel = |dx: u32, dy: u32| {
                        let (x, y) = ((2 * x + dx).min(below.width - 1), (2 * y + dy).min(below.height - 1));
                        below.texel(x, y)[c]
                    };
                    let box_average = 0.25 * (texel(0, 0) + texel(1, 0) + texel(0, 1) + texel(1, 1));
                    let found = here.texel(x, y)[c];
                    assert!(
                        (found - box_average).abs() <= float_step(box_average),
                        "{extent:?}, level {n}, ({x}, {y}): {found} against {box_average}"
                    );
                }
            }
        }
        let range = levels[0].values.iter().fold((f32::MAX, f32::MIN), |(a, b), v| (a.min(*v), b.max(*v)));
        assert!(extent[0] < 64 || range.1 - range.0 > 0.3, "the content varies: {range:?}");
    }
}

/// Returns a G-buffer whose pixels all reflect and face the camera. `depth` and `color` give the depth and the colour
/// of each pixel by its index.
fn colored(extent: [u32; 2], depth: impl Fn(u64) -> f32, color: impl Fn(u64) -> Vec3) -> GBufferData {
    let pixels = extent[0] as usize * extent[1] as usize;
    GBufferData {
        width: extent[0],
        height: extent[1],
        camera: clutter_camera(extent),
        depth: (0..pixels as u64).map(depth).collect(),
        normal: vec![Vec3::Z; pixels],
        reflectivity: vec![1.0; pixels],
        roughness: vec![0.5; pixels],
        color: (0..pixels as u64).map(color).collect(),
        surface: vec![Surface::Lit; pixels],
    }
}

/// The pass that makes seven coarse levels at once gives in each texel the bilinear sample of the level below. One
/// workgroup makes all seven, so that without a barrier it would read old texels. Blits make the finer levels, and all
/// levels of small images.
#[test]
fn coarse_levels_in_one_dispatch_are_bilinear_samples_of_the_level_below() {
    let gpu = gpu();
    let mut context = FrameContext::new(&gpu).unwrap();
    let pass = ColorChainPass::in_few_passes(&gpu).unwrap();
    // Each size has the levels that the one dispatch makes. An image with a side of 128 pixels or more has at least
    // seven levels above the first. For smaller images, blits make all levels.
    for (extent, coarse) in [
        ([127, 61], 7..7),
        ([128, 1], 1..8),
        ([1, 200], 1..8),
        ([131, 96], 1..8),
        ([256, 255], 2..9),
        ([641, 479], 3..10),
        ([960, 540], 3..10),
    ] {
        let stream = Stream::new(u64::from(extent[0]), u64::from(extent[1]));
        let color = |i: u64| Vec3::from([0, 1, 2].map(|c| stream.uniform(3 * i + c) as f32));
        let data = colored(extent, |_| 0.5, color);
        let images = GBufferImages::upload(&mut context, &data).unwrap();
        let mut frame = context.begin(Mode::Plain).unwrap();
        let chain = pass.record(&mut frame, &images.gbuffer()).unwrap().0;
        let report = frame.finish().unwrap();
        let blits: Vec<_> = (1..coarse.start).map(|level| format!("color/{level}")).collect();
        assert!(report.recorded.starts_with(&blits), "{extent:?}: {:?}", report.recorded);
        assert_eq!(report.recorded.len(), blits.len() + usize::from(!coarse.is_empty()), "{extent:?}");
        assert_eq!(chain.levels(), coarse.end, "{extent:?}");
        for level in coarse {
            let [below, here] = [level - 1, level].map(|level| context.read(chain.level(level)).unwrap());
            for (y, x) in (0..here.height).flat_map(|y| (0..here.width).map(move |x| (y, x))) {
                let (u, v) = ((x as f32 + 0.5) / here.width as f32, (y as f32 + 0.5) / here.height as f32);
                for (found, twin) in here.texel(x, y).iter().zip(bilinear(&below, u, v)) {
                    assert!(
                        (found - twin).abs() <= float_step(twin),
                        "{extent:?}, level {level}, ({x}, {y}): {found} against {twin}"
                    );
                }
            }
        }
    }
    gpu.check_validation().unwrap();
}

/// In the chain that leaves sky out, alpha is 0 in pixels of sky, and level 1 is a bilinear sample of level 0 with sky
/// set to zero. Otherwise a bright sky would leak into the reflections of surfaces before it.
#[test]
fn a_chain_without_sky_is_made_of_what_is_lit() {
    let gpu = gpu();
    let mut context = FrameContext::new(&gpu).unwrap();
    let pass = ColorChainPass::in_few_passes(&gpu).unwrap();
    for extent in [[2, 1], [61, 37], [200, 131], [256, 64], [641, 479]] {
        let stream = Stream::new(u64::from(extent[0]), u64::from(extent[1]));
        let is_sky = |i: u64| stream.uniform(i) < 0.3;
        let depth = |i: u64| if is_sky(i) { 0.0 } else { 0.5 };
        let data = colored(extent, depth, |i| Vec3::splat(0.125 + (i % 7) as f32 / 8.0));
        let images = GBufferImages::upload(&mut context, &data).unwrap();
        let mut frame = context.begin(Mode::Plain).unwrap();
        let chain = pass.record_without_sky(&mut frame, &images.gbuffer()).unwrap().0;
        frame.finish().unwrap();
        let written: Vec<_> = (0..chain.levels()).map(|level| chain.level(level).is_written()).collect();
        assert!(!written.contains(&false), "{extent:?}: {written:?}");
        let mut finest = context.read(chain.level(0)).unwrap();
        for (i, texel) in finest.values.chunks_exact_mut(4).enumerate() {
            assert_eq!(texel[3] == 0.0, is_sky(i as u64), "{extent:?}, pixel {i}");
            if texel[3] == 0.0 {
                texel.fill(0.0);
            }
        }
        let coarser = context.read(chain.level(1)).unwrap();
        for (y, x) in (0..coarser.height).flat_map(|y| (0..coarser.width).map(move |x| (y, x))) {
            let (u, v) = ((x as f32 + 0.5) / coarser.width as f32, (y as f32 + 0.5) / coarser.height as f32);
            for (found, twin) in coarser.texel(x, y).iter().zip(bilinear(&finest, u, v)) {
                // Device and twin round the place of the sample to a part of a texel, between colours of up to 1.
                let bound = float_step(twin) + extent[0] as f32 * f32::EPSILON;
                assert!((found - twin).abs() <= bound, "{extent:?}, ({x}, {y}): {found} against {twin}");
            }
        }
    }
    gpu.check_validation().unwrap();
}

/// At every size of `SIZES`, each level of the Gaussian chain is the twin's blur of the level below.
#[test]
fn gaussian_chains_equal_their_twin() {
    // The device blurs horizontally and then vertically, and rounds to a 16-bit float each time: one step each. Where a
    // side is odd, a tap falls between texels at any fraction. A device's filter has at least 8 bits for a fraction
    // (half a step is 1/512), in two directions.
    let gpu = gpu();
    for extent in SIZES {
        let shown = render(&gpu, extent, ChainFilter::Gaussian);
        let levels = shown.levels("color");
        for n in 1..levels.len() {
            let (below, here) = (levels[n - 1], levels[n]);
            let (w, h) = (here.width, here.height);
            let across = blur(below, w, h, [1.0 / w as f32, 0.0]);
            let twin = blur(&across, w, h, [0.0, 1.0 / h as f32]);
            let brightest = below.values.iter().copied().fold(0.0, f32::max);
            for (i, (texel, twin_texel)) in here.texels().zip(twin.texels()).enumerate() {
                for (found, expected) in texel.iter().zip(twin_texel) {
                    let tolerance = 2.0 * float_step(*expected) + 2.0 * brightest / 512.0;
                    let difference = (found - expected).abs();
                    assert!(difference <= tolerance, "{extent:?}, level {n}, texel {i}: {found} against {expected}");
                }
            }
        }
    }
}

/// The Gaussian filter and the blit give one level 0 and different levels 1. If the option had no effect, the tests of
/// either filter would hold nothing.
#[test]
fn the_two_filters_differ() {
    let gpu = gpu();
    let [blitted, gaussian] = [ChainFilter::Hardware, ChainFilter::Gaussian].map(|f| render(&gpu, [64, 64], f));
    assert_eq!(blitted.get("color"), gaussian.get("color"), "level 0 is the lit colour either way");
    let difference = ssct_truth::metrics::rmse(&blitted.levels("color")[1].values, &gaussian.levels("color")[1].values);
    assert!(difference > 0.005, "{difference}");
}

/// Blurs an image by the masked Gaussian in the direction [dx, dy], and returns a level of the size of `depth`. Where
/// `counts(middle, tap)` says that a tap's depth does not count, the sample of the middle is taken instead.
fn masked(image: &Pixels, depth: &Pixels, counts: &dyn Fn(f32, f32) -> bool, [dx, dy]: [i32; 2]) -> Pixels {
    let [width, height] = [depth.width, depth.height].map(|v| v as i32);
    let mut values = Vec::new();
    for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
        let sample =
            |x: i32, y: i32| bilinear(image, (x as f32 + 0.5) / width as f32, (y as f32 + 0.5) / height as f32);
        let depth_of = |x: i32, y: i32| depth.texel(x.clamp(0, width - 1) as u32, y.clamp(0, height - 1) as u32)[0];
        let mut sum = [0.0; 3];
        for (weight, tap) in BLUR_WEIGHTS.into_iter().zip(-3..=3) {
            let (tap_x, tap_y) = (x + tap * dx, y + tap * dy);
            let is_read = counts(depth_of(x, y), depth_of(tap_x, tap_y));
            let color = if is_read { sample(tap_x, tap_y) } else { sample(x, y) };
            sum = [0, 1, 2].map(|c| sum[c] + weight * color[c]);
        }
        values.extend(sum);
    }
    Pixels { width: width as u32, height: height as u32, channels: 3, values }
}

/// At every size of `SIZES`, the chains with both masks equal the twin's masked blur of the level below, and the masks
/// change many texels.
#[test]
fn masked_gaussian_chains_equal_their_twin() {
    // Colours have the tolerance of `gaussian_chains_equal_their_twin`. With the mask by surfaces, two depths may
    // differ by just the tolerance of the mask, so that rounding decides: one texel in 500 may differ.
    const TOLERANCE: f32 = 0.1;
    let gpu = gpu();
    for (mask, extent) in
        [ChainMask::Covered, ChainMask::Surface].into_iter().flat_map(|m| SIZES.map(|extent| (m, extent)))
    {
        let setup =
            Setup::new(extent).with(|p: &mut ThesisDrawing| (p.chain_mask, p.chain_mask_tolerance) = (mask, TOLERANCE));
        let shown = show(&gpu, &clutter(), clutter_camera(extent), "ssct", &setup, &Globals::default());
        let plain = render(&gpu, extent, ChainFilter::Gaussian);
        let lens = shown.camera.lens;
        // The view depth in metres at a standard depth.
        let z = |depth: f32| lens.near_m * lens.far_m / (lens.far_m - depth * (lens.far_m - lens.near_m));
        let counts = |middle: f32, tap: f32| match mask {
            ChainMask::Covered => tap < 1.0,
            _ => (z(tap) - z(middle)).abs() <= TOLERANCE * z(tap).min(z(middle)),
        };
        let (levels, depths) = (shown.levels("color"), shown.levels("hi-z"));
        let (mut texels, mut differing, mut left_out) = (0_usize, 0_usize, 0_usize);
        for n in 1..levels.len() {
            let (below, here) = (levels[n - 1], levels[n]);
            let across = masked(below, depths[n], &counts, [1, 0]);
            let twin = masked(&across, depths[n], &counts, [0, 1]);
            let brightest = below.values.iter().copied().fold(0.0, f32::max);
            let unmasked_level = plain.levels("color")[n];
            for ((found, expected), unmasked) in here.texels().zip(twin.texels()).zip(unmasked_level.texels()) {
                let tolerance = |value: f32| 2.0 * float_step(value) + 2.0 * brightest / 512.0;
                texels += 1;
                differing += usize::from((0..3).any(|c| (found[c] - expected[c]).abs() > tolerance(expected[c])));
                left_out += usize::from((0..3).any(|c| (found[c] - unmasked[c]).abs() > 0.05));
            }
        }
        println!(
            "{mask:?} {extent:?}: {differing} of {texels} texels differ, {left_out} from the chain without a mask"
        );
        let may_differ = if mask == ChainMask::Covered { 0 } else { texels / 500 };
        assert!(differing <= may_differ, "{mask:?} {extent:?}: {differing} of {texels} texels differ");
        assert!(texels < 5000 || left_out > 100, "{mask:?} {extent:?}: the mask leaves nothing out");
    }
    gpu.check_validation().unwrap();
}

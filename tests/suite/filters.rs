//! Compares the filters of SSLR and of the poster with their twins on the CPU: the mask-weighted chain, the mip level
//! of the reflection, the Gaussian volumes, and the edge-aware chain.

use crate::common::{BLUR_WEIGHTS, Shown, bilinear, blur, clutter, clutter_camera, gpu, show};
use ssct::gpu::{Gpu, Pixels};
use ssct::methods::Setup;
use ssct::methods::poster::PosterParams;
use ssct::passes::PosterFilter;
use ssct_ground::math::linear_to_srgb;
use ssct_ground::parameter::Preset;
use ssct_lab::stage::Globals;

/// Renders the cluttered scene by `sslr`, with all intermediate images.
fn sslr(gpu: &Gpu, extent: [u32; 2], preset: Preset, roughness: f32) -> Shown {
    let globals = Globals { roughness: Some(roughness), ..Globals::default() };
    let setup = Setup::new(extent).of_preset(preset);
    show(gpu, &clutter(), clutter_camera(extent), "sslr", &setup, &globals)
}

/// Returns a linear value in sRGB, from 0 to 255.
fn encoded(v: f32) -> f32 {
    linear_to_srgb(v) * 255.0
}

/// Blurs a colour and its mask in one direction, as thesis 4.3.2 does, and returns both at a size in texels. Where the
/// mask reads 0 at a tap, the central pixel is taken. `step` is the distance of taps in texture coordinates.
fn masked_blur(color: &Pixels, mask: &Pixels, [width, height]: [u32; 2], step: [f32; 2]) -> (Pixels, Pixels) {
    let (mut colors, mut masks) = (Vec::new(), Vec::new());
    for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
        let (u, v) = ((x as f32 + 0.5) / width as f32, (y as f32 + 0.5) / height as f32);
        let central = bilinear(color, u, v);
        let (mut sum, mut share) = ([0.0; 3], 0.0);
        for (weight, tap) in BLUR_WEIGHTS.into_iter().zip(-3..=3) {
            let (u, v) = (u + tap as f32 * step[0], v + tap as f32 * step[1]);
            let hit = bilinear(mask, u, v)[0];
            let read = if hit > 0.0 { bilinear(color, u, v) } else { central };
            sum = [0, 1, 2].map(|c| sum[c] + weight * read[c]);
            share += weight * hit;
        }
        colors.extend(sum);
        masks.push(share);
    }
    (Pixels { width, height, channels: 3, values: colors }, Pixels { width, height, channels: 1, values: masks })
}

/// Rounds a colour and a mask to 8 bits and back, as the images between the passes store them.
fn rounded(mut color: Pixels, mut mask: Pixels) -> (Pixels, Pixels) {
    color.values.iter_mut().for_each(|v| *v = ssct_ground::math::srgb_to_linear(encoded(*v).round() / 255.0));
    mask.values.iter_mut().for_each(|v| *v = (*v * 255.0).round() / 255.0);
    (color, mask)
}

/// At five sizes, at most 1 % of the texels of `sslr`'s chain differ from the twin's blur of the level below. If misses
/// were blurred in, reflections would darken towards them.
#[test]
fn masked_chains_equal_their_twin() {
    let gpu = gpu();
    for extent in [[1, 1], [5, 1], [64, 64], [127, 61], [320, 180]] {
        let shown = sslr(&gpu, extent, Preset::Published, 0.1);
        let (colors, masks) = (shown.levels("ray-trace-color"), shown.levels("mask"));
        let misses = masks[0].values.iter().filter(|m| **m == 0.0).count();
        assert!(masks[0].values.iter().all(|m| *m == 0.0 || *m == 1.0), "level 0 says hit or miss");
        assert!(extent[0] < 64 || (misses > 100 && misses < masks[0].values.len() - 100), "{misses}");
        let (mut texels, mut differing) = (0_usize, 0_usize);
        for n in 1..colors.len() {
            let size = [colors[n].width, colors[n].height];
            let (across, down) = ([1.0 / size[0] as f32, 0.0], [0.0, 1.0 / size[1] as f32]);
            let (color, mask) = masked_blur(colors[n - 1], masks[n - 1], size, across);
            let (color, mask) = rounded(color, mask);
            let (color, mask) = masked_blur(&color, &mask, size, down);
            for i in 0..masks[n].values.len() {
                texels += 1;
                let gpu_color = &colors[n].values[4 * i..4 * i + 3];
                let difference = (0..3).map(|c| (encoded(gpu_color[c]) - encoded(color.values[3 * i + c])).abs());
                let difference = difference.fold((masks[n].values[i] - mask.values[i]).abs() * 255.0, f32::max);
                // The bound in steps of 8 bits: two roundings of half a step, and the filter's weights, which have 8
                // bits, too.
                differing += usize::from(difference > 2.5);
            }
        }
        println!("{extent:?}: {differing} of {texels} texels differ");
        assert!(differing * 100 <= texels, "{extent:?}: {differing} of {texels} texels differ");
    }
}

/// For each hit of `sslr`, the reflection is the trilinear sample at a level: the number of levels times roughness
/// times spread. With the author's preset, the spread is ten times as large.
#[test]
fn the_reflection_is_the_level_that_roughness_and_length_ask_for() {
    let gpu = gpu();
    let extent = [320, 180];
    for (preset, factor) in [(Preset::Published, 1.0), (Preset::Author, 10.0)] {
        let roughness = 0.3_f32;
        let shown = sslr(&gpu, extent, preset, roughness);
        // The device stores the roughness as a 16-bit float, so that its value is read back.
        let roughness =
            shown.get("material").values.chunks_exact(2).find(|m| m[0] > 0.0).unwrap()[1].min(roughness + 1e-3);
        let (levels, reflection) = (shown.levels("ray-trace-color"), shown.get("reflection"));
        let (mut hits, mut between) = (0, 0);
        for (y, x) in (0..extent[1]).flat_map(|y| (0..extent[0]).map(move |x| (y, x))) {
            let found = reflection.texel(x, y);
            if shown.get("mask").texel(x, y)[0] == 0.0 {
                assert_eq!(found, [0.0; 4], "a miss is black");
                continue;
            }
            let spreading = levels[0].texel(x, y)[3] * factor;
            let level = (levels.len() as f32 * roughness * spreading).clamp(0.0, levels.len() as f32 - 1.0);
            let (u, v) = ((x as f32 + 0.5) / extent[0] as f32, (y as f32 + 0.5) / extent[1] as f32);
            let low = bilinear(levels[level as usize], u, v);
            let high = bilinear(levels[(level as usize + 1).min(levels.len() - 1)], u, v);
            for c in 0..3 {
                let expected = low[c] + (high[c] - low[c]) * level.fract();
                // The bound has filter weights of 8 bits in three dimensions, and the rounding of 16-bit floats.
                assert!((found[c] - expected).abs() < 0.015, "({x}, {y}), level {level}: {found:?}, {expected}");
            }
            assert_eq!(found[3], 1.0, "a hit does not fade");
            hits += 1;
            between += usize::from(level > 0.25);
        }
        println!("{preset:?}: {hits} hits, {between} beyond level 0");
        assert!(hits > 1000 && between > 100, "{preset:?}: {hits} {between}");
    }
}

/// Each slice of the poster's volume is the twin's Gaussian of the slice before. From slice to slice the contrast
/// falls, and the mean stays; a kernel whose weights do not sum to 1 would change the mean.
#[test]
fn slices_of_the_volumes_are_gaussians_of_each_other() {
    let gpu = gpu();
    for extent in [[1, 1], [127, 61], [160, 90]] {
        let setup = Setup::new(extent).with(|p: &mut PosterParams| p.poster_filter = PosterFilter::Volume);
        let shown = show(&gpu, &clutter(), clutter_camera(extent), "poster", &setup, &Globals::default());
        let slices = shown.levels("filtered-color");
        assert_eq!(slices[0], shown.get("color"), "slice 0 is the lit colour");
        let [width, height] = extent;
        for n in 1..slices.len() {
            // The taps' variance is 0.726 squares of their distance; slice n adds 4^(n-1) / 4 square pixels.
            let distance = 2_f32.powi(n as i32 - 2) / 0.726_f32.sqrt();
            let across = blur(slices[n - 1], width, height, [distance / width as f32, 0.0]);
            let twin = blur(&across, width, height, [0.0, distance / height as f32]);
            for (i, (gpu_texel, cpu_texel)) in slices[n].texels().zip(twin.texels()).enumerate() {
                for (gpu_texel, cpu_texel) in gpu_texel.iter().zip(cpu_texel) {
                    // The bound has two roundings to 16-bit floats, and filter weights of 8 bits in three dimensions.
                    assert!(
                        (gpu_texel - cpu_texel).abs() < 0.012,
                        "{extent:?}, slice {n}, texel {i}: {gpu_texel} against {cpu_texel}"
                    );
                }
            }
        }
        // Returns the mean and the variance of the red channel.
        let moments = |p: &Pixels| {
            let n = f64::from(p.width * p.height);
            let mean = p.texels().map(|t| f64::from(t[0])).sum::<f64>() / n;
            (mean, p.texels().map(|t| (f64::from(t[0]) - mean).powi(2)).sum::<f64>() / n)
        };
        for pair in slices.windows(2) {
            let [(mean, variance), (next_mean, next_variance)] = [pair[0], pair[1]].map(moments);
            assert!(extent[0] == 1 || next_variance < variance, "{extent:?}: {variance}, then {next_variance}");
            assert!((next_mean - mean).abs() < 0.05, "{extent:?}: {mean}, then {next_mean}");
        }
    }
}

/// Computes a level of depth in the edge-aware chain from the level below. Each texel is the mean of the depths that
/// agree, within the tolerance, with the depth that most others agree with.
fn edge_aware(below: &Pixels, tolerance: f32) -> Vec<f32> {
    let half = |n: u32| (n / 2).max(1);
    let (w, h) = (half(below.width), half(below.height));
    // The two texels below a texel; the last of an odd side has three.
    let range =
        |index: u32, small: u32, large: u32| 2 * index..=if index + 1 == small { large - 1 } else { 2 * index + 1 };
    let agrees = |a: f32, b: f32| (a - b).abs() <= tolerance * a.min(b);
    let texel = |(x, y): (u32, u32)| {
        let places = range(y, h, below.height).flat_map(|j| range(x, w, below.width).map(move |i| (i, j)));
        let depths: Vec<f32> = places.map(|(i, j)| below.texel(i, j)[0]).collect();
        let agreeing = |d: f32| depths.iter().filter(|other| agrees(d, **other)).count();
        let mut sorted = depths.clone();
        sorted.sort_by(|a, b| agreeing(*b).cmp(&agreeing(*a)).then(a.total_cmp(b)));
        let members: Vec<f32> = depths.iter().copied().filter(|d| agrees(*d, sorted[0])).collect();
        members.iter().sum::<f32>() / members.len() as f32
    };
    (0..h).flat_map(|y| (0..w).map(move |x| (x, y))).map(texel).collect()
}

/// Each level of the edge-aware chain is the twin's, but for 1e-5 of a depth, and differs from plain means in more than
/// 20 texels. A mean over an edge is a depth at which nothing stands.
#[test]
fn the_edge_aware_chain_keeps_to_one_surface() {
    let gpu = gpu();
    for extent in [[1, 1], [127, 61], [160, 90]] {
        let chain = |filter| {
            let setup = Setup::new(extent).with(|p: &mut PosterParams| p.poster_filter = filter);
            show(&gpu, &clutter(), clutter_camera(extent), "poster", &setup, &Globals::default())
        };
        let (aware, plain) = (chain(PosterFilter::EdgeAware), chain(PosterFilter::Mip));
        let (levels, mip) = (aware.levels("filtered-depth"), plain.levels("filtered-depth"));
        assert_eq!(levels[0], mip[0], "level 0 is the depth of the frame");
        let mut differ = 0;
        for n in 1..levels.len() {
            for (i, (found, expected)) in levels[n].texels().zip(edge_aware(levels[n - 1], 0.1)).enumerate() {
                assert!(
                    (found[0] - expected).abs() <= 1e-5 * expected,
                    "{extent:?}, level {n}, {i}: {found:?}, not {expected}"
                );
            }
            differ += levels[n].texels().zip(mip[n].texels()).filter(|(a, b)| (a[0] - b[0]).abs() > 0.1 * b[0]).count();
        }
        assert!(extent[0] == 1 || differ > 20, "{extent:?}: only {differ} texels differ from plain means");
    }
}

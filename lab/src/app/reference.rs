//! `ssct render --method reference`: the world reference as an image. It needs no Vulkan device.

use super::cli::{CommonOptions, RenderOptions};
use super::printed;
use super::reference_part::{self, ReferencePart};
use super::run::go_on;
use super::{progress, resolve};
use crate::error::{Error, Result};
use crate::report::images;
use crate::study::record::DEFINITIONS;
use glam::Vec3;
use ssct::gpu::Pixels;
use ssct_ground::parameter::Preset;
use ssct_scenes::{Camera, GBufferData, Material, Scene};
use ssct_truth::reference::first_hits::FirstHits;
use ssct_truth::reference::kept_samples::{short_name, whole_file};
use ssct_truth::reference::paths::Paths;
use ssct_truth::reference::screen::MIRROR_SAMPLES_MIN;
use ssct_truth::reference::surface::World;
use ssct_truth::reference::world::state::WorldState;
use ssct_truth::reference::world::{SamplingTarget, WorldReference};
use std::path::{Path, PathBuf};

/// Rays a pixel that [`truth`] traces before it looks whether a signal asks to stop.
const RAYS_AT_ONCE: u32 = 4;

/// Rays a pixel at most, unless the options say otherwise.
const MAX_RAYS: u32 = 1024;

/// The standard error at which sampling ends, unless the options say otherwise.
const STANDARD_ERROR: f32 = 0.003;

/// Takes samples of the world reference until the standard error is met, and writes the image. Samples that were kept
/// for the same image are used again.
pub fn run(options: &RenderOptions) -> anyhow::Result<()> {
    let common = &options.common;
    let looks_inside = options.dump.is_some() || options.figure.is_some() || options.pixel.is_some();
    let Some(output) = options.output.as_ref().filter(|_| !looks_inside) else {
        let message = "the reference has no intermediates: give -o, without --dump, --figure or --pixel";
        return Err(Error::usage(message.into()).into());
    };
    check_read(options)?;
    if let Some(error) = options.standard_error.filter(|error| !(error.is_finite() && *error > 0.0)) {
        return Err(Error::usage(format!("--standard-error {error}: must be above 0")).into());
    }
    images::check_extension(output)?;
    let globals = resolve::one_globals(&common.place, "render makes one image")?;
    let scene = resolve::scene(&common.place, "rooms")?;
    let view = resolve::view(&scene, &common.place, None)?;
    let materials = globals.materials(&scene, &view);
    let camera = view.camera(&scene, options.size);

    let world = World::new(&scene, &materials);
    if let Some(bounces) = options.diffuse_bounces {
        return Ok(images::write_image(output, &diffuse_image(options, &world, &camera, bounces)?)?);
    }
    let first_hits = FirstHits::trace(&world, &camera, options.size);
    let effect = options.common.method_options.setup(options.size).effect();
    let reference = WorldReference::new(&world, &first_hits, &camera, 1).with_bounces(effect.bounces);
    let bar = progress::bar("reference", max_rays(options) as usize);
    let mut progress = |state: &WorldState| {
        bar.set_position(u64::from(state.sample_counts().max().unwrap_or(0)));
        bar.set_message(format!("reference, standard error {:.4}", state.overall_standard_error()));
        Ok(())
    };
    let state = match (options.shard, &options.cache) {
        (Some(shard), Some(folder)) => {
            let part = ReferencePart::new(&reference, (&scene, &view), shard, max_rays(options));
            reference_part::sample(&reference, &part, folder, &mut progress)?
        }
        _ => {
            sample(&reference, &sampling_target(options), options.cache.clone().or_else(default_cache), &mut progress)?
        }
    };
    bar.finish_and_clear();

    let image = reference.image(&state);
    let shown = if options.reflection_only { &image.reflection } else { &image.composite };
    images::write_image(output, &to_pixels(shown, options.size))?;
    if options.json {
        let summary = serde_json::json!({
            "kind": "render", "definitions": DEFINITIONS, "scene": scene.name, "view": view.name, "method": "reference",
            "width": options.size[0], "height": options.size[1],
            "rays": image.samples.iter().max(), "standard_error": state.overall_standard_error(),
        });
        printed::json(&serde_json::json!([summary]))?;
    }
    Ok(())
}

/// Refuses options that the reference does not read: of the parameters of methods it reads the bounces alone, and it
/// runs on no device.
fn check_read(options: &RenderOptions) -> Result<()> {
    let CommonOptions { method_options, device, .. } = &options.common;
    let unread = method_options.values.given_names().find(|name| *name != "bounces");
    let others = [
        ("preset", method_options.values.preset != Preset::default()),
        ("device", device.device.is_some()),
        ("validation", device.validation),
        ("explain", options.explain),
    ];
    let other = others.into_iter().find(|(_, is_given)| *is_given).map(|(name, _)| name);
    let Some(name) = unread.or(other) else { return Ok(()) };
    let option = name.replace('_', "-");
    Err(Error::usage(format!("--{option} is not read by --method reference, which traces rays on the CPU")))
}

/// Takes samples until a target is met, beginning with the samples of the same reference in the folder `cache`, and
/// keeps all samples there. Without a folder, none are kept. `progress` is called after each pass, and its error ends
/// the sampling.
fn sample(
    reference: &WorldReference,
    target: &SamplingTarget,
    cache: Option<PathBuf>,
    progress: &mut dyn FnMut(&WorldState) -> Result<()>,
) -> Result<WorldState> {
    let state_path = cache.map(|folder| state_file(&folder, reference));
    let (mut state, why_unusable) = match &state_path {
        Some(path) => reference.resume(path),
        None => (reference.start(), None),
    };
    if let Some(why) = why_unusable {
        eprintln!("ssct: warning: {why}; sampling begins anew");
    }
    let kept_rays = state.sample_counts().max().unwrap_or(0);
    let wanted_rays = target.samples_max.max(MIRROR_SAMPLES_MIN);
    if kept_rays > wanted_rays {
        eprintln!(
            "ssct: an earlier run kept {kept_rays} rays a pixel, more than {wanted_rays}; the image shows all of them"
        );
    }
    reference.run(&mut state, target, &mut |state| {
        progress(state)?;
        if let Some(path) = &state_path {
            state.save(path)?;
        }
        Ok::<_, Error>(())
    })?;
    Ok(state)
}

/// The composite of a G-buffer by the error study's world reference, with `rays` rays a pixel, whatever the standard
/// error. Samples that the folder `cache` has are not taken again.
pub fn truth(scene: &Scene, materials: &[Material], data: &GBufferData, rays: u32, cache: &Path) -> Result<Pixels> {
    let world = World::new(scene, materials);
    let first_hits = FirstHits::shown(&world, data);
    let reference = WorldReference::new(&world, &first_hits, &data.camera, 1);
    let target =
        SamplingTarget { standard_error: 0.0, samples_min: rays, samples_max: rays, samples_per_pass: RAYS_AT_ONCE };
    let state = sample(&reference, &target, Some(cache.to_owned()), &mut |_| go_on())?;
    Ok(to_pixels(&reference.image(&state).composite, [data.width, data.height]))
}

/// Samples the image that `ssct render --method reference` would write of a loaded scene: the composite, or what else
/// the options ask for. No samples are kept.
pub fn sample_image(options: &RenderOptions, scene: &Scene) -> Result<Pixels> {
    let globals = resolve::one_globals(&options.common.place, "render makes one image")?;
    let view = resolve::view(scene, &options.common.place, None)?;
    let materials = globals.materials(scene, &view);
    let world = World::new(scene, &materials);
    let camera = view.camera(scene, options.size);
    if let Some(bounces) = options.diffuse_bounces {
        return diffuse_image(options, &world, &camera, bounces);
    }
    let first_hits = FirstHits::trace(&world, &camera, options.size);
    let effect = options.common.method_options.setup(options.size).effect();
    let reference = WorldReference::new(&world, &first_hits, &camera, 1).with_bounces(effect.bounces);
    let mut state = reference.start();
    reference.run(&mut state, &sampling_target(options), &mut |_| Ok::<_, Error>(()))?;
    let image = reference.image(&state);
    let shown = if options.reflection_only { &image.reflection } else { &image.composite };
    Ok(to_pixels(shown, options.size))
}

/// The image of diffuse paths, along which surfaces pass on light `bounces` times.
fn diffuse_image(options: &RenderOptions, world: &World, camera: &Camera, bounces: u32) -> Result<Pixels> {
    let paths = Paths::new(world, bounces, 1).ok_or_else(|| {
        let scene = &world.scene.name;
        Error::usage(format!("--diffuse-bounces {bounces}: the scene {scene} has no rectangular area light"))
    })?;
    Ok(to_pixels(&paths.image(camera, options.size, max_rays(options)), options.size))
}

/// The number of rays a pixel that the options allow.
fn max_rays(options: &RenderOptions) -> u32 {
    options.max_rays.unwrap_or(MAX_RAYS)
}

/// The target that the options set for sampling.
fn sampling_target(options: &RenderOptions) -> SamplingTarget {
    let samples_max = max_rays(options);
    SamplingTarget {
        standard_error: f64::from(options.standard_error.unwrap_or(STANDARD_ERROR)),
        samples_max,
        samples_min: SamplingTarget::default().samples_min.min(samples_max),
        ..SamplingTarget::default()
    }
}

/// Makes an image of colours, row by row, with four channels, of which the fourth is 1.
fn to_pixels(color: &[Vec3], [width, height]: [u32; 2]) -> Pixels {
    Pixels { width, height, channels: 4, values: color.iter().flat_map(|c| c.extend(1.0).to_array()).collect() }
}

/// The path of the file in `folder` that keeps the samples of a reference. References that differ in anything on which
/// a sample depends have different files.
pub fn state_file(folder: &Path, reference: &WorldReference) -> PathBuf {
    whole_file(folder, &short_name(&reference.fingerprint()))
}

/// The folder that keeps states if `--cache` names no other: `ssct` in the user's folder of caches. `None` if the
/// environment names no such folder.
pub fn default_cache() -> Option<PathBuf> {
    let variable = |name: &str| std::env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
    let caches = variable("XDG_CACHE_HOME").or_else(|| Some(variable("HOME")?.join(".cache")))?;
    Some(caches.join("ssct"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Args;

    #[test]
    fn help_tells_the_defaults_that_the_reference_takes() {
        let command = RenderOptions::augment_args(clap::Command::new("render"));
        for (name, default) in [("standard_error", STANDARD_ERROR.to_string()), ("max_rays", MAX_RAYS.to_string())] {
            let option = command.get_arguments().find(|a| a.get_id() == name).expect("an option");
            let help = option.get_help().expect("help").to_string();
            assert!(help.ends_with(&format!("[default: {default}]")), "{help}");
        }
    }
}

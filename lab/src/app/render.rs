//! `ssct render`.

use super::cli::RenderOptions;
use super::pixel::{self, Judge};
use super::printed;
use super::resolve;
use crate::error::Error;
use crate::report::dump::Dump;
use crate::report::figures::Figure;
use crate::report::pixel::text;
use crate::report::{figures, images};
use crate::stage::{Shot, Stage, image};
use crate::study::record::{DEFINITIONS, recorded_setup};
use ssct::methods::{self, Prepared, Setup, Wants};
use ssct_scenes::inside::PathInFolder;
use std::io::Write;

/// Renders one frame, and writes and prints what the options ask for: the image or a figure, the intermediates, the
/// passes that ran, and the explanation of a pixel.
pub fn run(options: &RenderOptions) -> anyhow::Result<()> {
    let method = method_name(options);
    if method == "reference" {
        return super::reference::run(options);
    }
    let for_reference = [
        ("--shard", options.shard.is_some()),
        ("--diffuse-bounces", options.diffuse_bounces.is_some()),
        ("--cache", options.cache.is_some()),
        ("--max-rays", options.max_rays.is_some()),
        ("--standard-error", options.standard_error.is_some()),
    ];
    if let Some((option, _)) = for_reference.into_iter().find(|(_, is_given)| *is_given) {
        let message = format!("{option} is for --method reference, which traces rays on the CPU, and not for {method}");
        return Err(Error::usage(message).into());
    }
    if let Some(pixel) = options.pixel {
        pixel::check(pixel, options.size)?;
    }
    let common = &options.common;
    let method = methods::find(method)?;
    let globals = resolve::one_globals(&common.place, "render makes one image")?;
    if let Some(path) = &options.output {
        images::check_extension(path)?;
    }
    let scene = resolve::scene(&common.place, "rooms")?;
    let view = resolve::view(&scene, &common.place, None)?;
    for need in method.unmet_needs(&scene) {
        let (method, need, scene) = (method.name, need.words(), super::printable(&scene.name));
        eprintln!("ssct: warning: {method} reflects {need} alone, and scene {scene} has none: the reflection is black");
    }
    let gpu = resolve::gpu(&common.device)?;

    let needs_intermediates = options.dump.is_some() || options.figure.is_some();
    let setup = setup(options);
    methods::check_read(&[method], &setup)?;
    let wants = if needs_intermediates || options.pixel.is_some() { Wants::HITS } else { Wants::REFLECTION };
    let mut stage = Stage::new(&gpu, &scene)?;
    let camera = view.camera(&scene, options.size);
    let materials = globals.materials(&scene, &view);
    let shot = Shot::new(&mut stage, method, &setup, wants, camera, materials.clone())?;
    let rendered = image::render(&mut stage, &shot, needs_intermediates)?;
    let subject = pixel::FrameSubject { method, setup: &setup, scene: &scene, materials: &materials };
    let needs_judge = options.dump.is_some() || options.pixel.is_some();
    let judge = needs_judge.then(|| Judge::new(&mut stage, &shot, &rendered, subject)).transpose()?;
    let explained = match (&judge, options.pixel) {
        (Some(judge), Some(pixel)) => Some(judge.explain(pixel)?),
        _ => None,
    };

    let intermediates = rendered.intermediates.as_ref();
    if let (Some(folder), Some(images), Some(judge)) = (&options.dump, intermediates, &judge) {
        let (lens, reflection, verdicts) = (&camera.lens, &rendered.reflection, &judge.verdicts());
        Dump { intermediates: images, lens, reflection, verdicts }.write(&PathInFolder::folder(folder))?;
    }
    if let Some(path) = &options.output {
        match (options.figure, intermediates) {
            (Some(figure), Some(images)) => figures::draw(figure, images, &camera.lens)?.write_png(path)?,
            _ if options.reflection_only => images::write_image(path, &rendered.reflection)?,
            _ => images::write_image(path, &rendered.composite)?,
        }
    }
    if options.json {
        let summary = serde_json::json!({
            "kind": "render", "definitions": DEFINITIONS, "scene": scene.name, "view": view.name,
            "method": method.name, "width": options.size[0], "height": options.size[1], "device": gpu.info(),
            "setup": recorded_setup(&setup, Some(method), &camera.lens, &globals),
            "drawn": rendered.drawn, "recorded": rendered.report.recorded, "skipped": rendered.report.skipped,
            "prepared": shot.prepared(), "pixel": explained,
            "validation": common.device.validation.then(|| gpu.violations().len()),
        });
        printed::json(&serde_json::json!([summary]))?;
    } else {
        let passes = options.explain.then(|| explain(&rendered, shot.prepared()));
        let texts = passes.into_iter().chain(explained.as_ref().map(text)).collect::<Vec<_>>();
        printed::out().write_all(texts.join("\n").as_bytes())?;
    }
    drop((shot, stage));
    gpu.check_validation()?;
    Ok(())
}

/// The name of the method that the flags give, or that of their figure, or else `ssct`.
pub fn method_name(options: &RenderOptions) -> &str {
    options.method.as_deref().or(options.figure.map(Figure::method)).unwrap_or("ssct")
}

/// Returns the setup of the method that the flags give, changed as their figure needs it if they name one.
pub fn setup(options: &RenderOptions) -> Setup {
    let setup = options.common.method_options.setup(options.size);
    options.figure.map_or(setup.clone(), |f| f.setup(&setup))
}

/// Returns the text of `--explain`: how much was drawn, how long a structure for ray queries took if one was built, and
/// a line for each pass that the frame recorded or left out.
fn explain(rendered: &image::RenderedImage, prepared: &Prepared) -> String {
    let drawn = &rendered.drawn;
    let mut text = format!("meshes: {} drawn, {} culled; {} triangles\n", drawn.meshes, drawn.culled, drawn.triangles);
    text.extend(prepared.ray_structure_ms.map(|ms| format!("built     structure for ray queries: {ms:.1} ms\n")));
    text.extend(rendered.report.recorded.iter().map(|pass| format!("recorded  {pass}\n")));
    text.extend(rendered.report.skipped.iter().map(|s| format!("skipped   {}: {}\n", s.pass, s.why)));
    text
}

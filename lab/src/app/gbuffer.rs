//! `ssct gbuffer export`, `ssct gbuffer reflect` and `ssct gbuffer convert`.

use super::cli::{GBufferCommand, GBufferConvertOptions, GBufferExportOptions, GBufferReflectOptions};
use super::resolve;
use crate::error::{Error, Result};
use crate::report::{files, images};
use crate::stage::{Shot, Stage, gbuffer};
use ssct::methods::setup::OwnRays;
use ssct::methods::{self, EffectParams, Setup};
use ssct_geometry::texture::MAX_EXTENT;
use ssct_scenes::capture_file::CaptureFolder;
use ssct_scenes::gbuffer_map::{self, GBufferMap};
use ssct_scenes::{GBufferData, LoadOptions, gbuffer_file};
use std::path::Path;

/// Runs the subcommand.
pub fn run(command: &GBufferCommand) -> anyhow::Result<()> {
    match command {
        GBufferCommand::Export(options) => export(options),
        GBufferCommand::Reflect(options) => reflect(options),
        GBufferCommand::Convert(options) => convert(options),
    }
}

/// Draws a view of a scene, and writes the G-buffer of the view to a file.
fn export(options: &GBufferExportOptions) -> anyhow::Result<()> {
    check_is_exr(&options.file)?;
    let place = &options.place;
    let globals = resolve::one_globals(place, "a G-buffer has one roughness a pixel")?;
    let scene = resolve::scene(place, "rooms")?;
    let view = resolve::view(&scene, place, None)?;
    let gpu = resolve::gpu(&options.device)?;
    let mut stage = Stage::new(&gpu, &scene)?;
    let camera = view.camera(&scene, options.size);
    let shot = Shot::of_scene(&mut stage, options.size, camera, globals.materials(&scene, &view))?;
    stage.draw(&shot)?;
    let data = gbuffer::read(&mut stage.context, &shot)?;
    files::write(&options.file, &gbuffer_file::encode(&data, &options.file)?)?;
    drop((shot, stage));
    gpu.check_validation()?;
    Ok(())
}

/// Runs a method on the G-buffer of a file, and writes the image. Rays that the screen loses go on among the triangles
/// of `--triangles` or in the captures of `--captures`, if the method follows them.
fn reflect(options: &GBufferReflectOptions) -> anyhow::Result<()> {
    images::check_extension(&options.output)?;
    check_is_no_input(&options.output, [Some(&*options.file), options.gbuffer_map.as_deref()])?;
    let method = methods::find(&options.method)?;
    let mut data = load(&options.file, options.gbuffer_map.as_deref())?;
    let clamped = data.clamp_colours();
    if clamped > 0 {
        let (file, most) = (options.file.display(), half::f16::MAX);
        eprintln!("ssct: warning: {file}: {clamped} pixels are brighter than {most} and were clamped to it");
    }
    let captures = options.beside.captures.as_deref().map(CaptureFolder::open).transpose()?;
    let unscaled = LoadOptions { scale: 1.0, texture_side: MAX_EXTENT };
    let has_triangles = !options.triangles.is_empty();
    let scene = has_triangles.then(|| resolve::load(&options.triangles, &unscaled)).transpose()?;
    let gpu = resolve::gpu(&options.device)?;
    let setup = options.beside.method_options.setup([data.width, data.height]);
    methods::check_read(&[method], &setup)?;
    let setup = for_one_image(setup);
    let reflected = match &scene {
        Some(scene) => gbuffer::reflect_in(&gpu, scene, &data, method, &setup)?,
        None => gbuffer::reflect(&gpu, &data, captures.as_ref(), method, &setup)?,
    };
    let image = if options.reflection_only { &reflected.reflection } else { &reflected.composite };
    images::write_image(&options.output, image)?;
    gpu.check_validation()?;
    Ok(())
}

/// Returns the setup for an image that is made once, where time matters little: pixels in doubt get the most rays of
/// their own, unless the user gave a number.
fn for_one_image(setup: Setup) -> Setup {
    let is_given = setup.values.given_names().any(|name| name == "own_rays");
    if is_given { setup } else { setup.with(|effect: &mut EffectParams| effect.own_rays = OwnRays::Sixteen) }
}

/// Reads another renderer's G-buffer by a map, and writes it in our conventions.
fn convert(options: &GBufferConvertOptions) -> anyhow::Result<()> {
    check_is_exr(&options.output)?;
    check_is_no_input(&options.output, [Some(&*options.file), Some(&*options.gbuffer_map)])?;
    let data = load(&options.file, Some(&options.gbuffer_map))?;
    files::write(&options.output, &gbuffer_file::encode(&data, &options.output)?)?;
    Ok(())
}

/// Refuses a file whose name does not end in .exr: other programs would take its bytes for those of another format.
fn check_is_exr(path: &Path) -> Result<()> {
    if images::has_extension(path, "exr") {
        return Ok(());
    }
    Err(Error::usage(format!("{}: a G-buffer is written as .exr", path.display())))
}

/// Refuses an output that is one of the files that are read, since writing would replace what cannot be made again.
fn check_is_no_input(output: &Path, inputs: [Option<&Path>; 2]) -> Result<()> {
    match inputs.into_iter().flatten().find(|input| resolve::is_same_place(input, output)) {
        Some(_) => {
            Err(Error::usage(format!("-o {}: this file is read, and would be lost; name another", output.display())))
        }
        None => Ok(()),
    }
}

/// Reads a G-buffer in our own conventions or in those of a map, and warns if its data contradict each other.
fn load(file: &Path, map: Option<&Path>) -> anyhow::Result<GBufferData> {
    let (data, doubt) = match map {
        Some(map) => {
            let map = GBufferMap::load(map)?;
            let data = map.read(file)?;
            let doubt = map.check(file, &data)?;
            (data, doubt)
        }
        None => {
            let data = gbuffer_file::load(file)?;
            let doubt = gbuffer_map::disagreement(&data);
            (data, doubt)
        }
    };
    if let Some(doubt) = doubt {
        eprintln!("ssct: warning: {}: {doubt}", super::printable(&file.display().to_string()));
    }
    Ok(data)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_output_that_is_an_input_is_refused_however_it_is_written() {
        let package = Path::new(env!("CARGO_MANIFEST_DIR"));
        let [file, same, other] = ["Cargo.toml", "src/../Cargo.toml", "build.rs"].map(|name| package.join(name));
        let refusal = |output: &Path, inputs| check_is_no_input(output, inputs).err().map(|e| e.to_string());
        let said = refusal(&same, [Some(&*file), None]).unwrap_or_default();
        assert!(said.ends_with("Cargo.toml: this file is read, and would be lost; name another"), "{said}");
        assert!(refusal(&same, [Some(&*other), Some(&*file)]).is_some());
        assert_eq!(refusal(&same, [Some(&*other), None]), None);
        assert_eq!(refusal(&package.join("new.exr"), [Some(&*file), Some(&*other)]), None);
    }
}

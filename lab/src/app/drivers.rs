//! `ssct drivers`: the same methods on every device here.

use super::cli::CommonOptions;
use super::cli::size;
use super::{progress, resolve};
use crate::error::{Error, Result};
use crate::gpu::{DeviceInfo, DeviceQuery, Gpu, device};
use crate::methods::{self, MethodInfo};
use crate::report::{agreement_report, files};
use crate::scene::{Scene, View};
use crate::study::Globals;
use crate::study::agreement::{self, AgreementRecord, AgreementSpec, DrawnRecord};
use clap::Args;
use serde_json::Value;
use std::io::Write;
use std::path::PathBuf;

/// Roughness values where none are given.
const ROUGHNESS: [f32; 2] = [0.0, 0.1];

/// Options of `ssct drivers`.
#[derive(Debug, Args)]
pub struct DriversOptions {
    #[command(flatten)]
    pub common: CommonOptions,
    /// The methods; without it, all of them.
    #[arg(long, value_delimiter = ',')]
    pub method: Vec<String>,
    /// Width and height in pixels.
    #[arg(long, value_name = "WxH", value_parser = size, default_value = "641x359")]
    pub size: [u32; 2],
    /// Write drivers.json and drivers.txt into a folder.
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Print the records as JSON, and nothing else.
    #[arg(long)]
    pub json: bool,
}

/// Compares every device with the one that the flags name.
pub fn run(options: &DriversOptions) -> anyhow::Result<()> {
    let common = &options.common;
    let scene = resolve::scene(&common.place, "rooms")?;
    let view = resolve::view(&scene, &common.place, common.place.scene.is_empty().then_some("corridor"))?;
    let globals = match &common.place.roughness[..] {
        [] => {
            let one = resolve::one_globals(&common.place, "no roughness was given")?;
            ROUGHNESS.map(|r| Globals { roughness: Some(r), ..one }).to_vec()
        }
        _ => resolve::globals(&common.place)?,
    };
    let setup = common.method_options.setup(options.size);
    let methods = methods::choose(&options.method, &setup)?;
    let base = resolve::gpu(&common.device)?;
    let others = others(&base, common.device.validation)?;
    if others.is_empty() {
        let message = format!("there is no device beside {} to compare with", base.info().name);
        return Err(Error::NoDevice(message).into());
    }
    let bar = progress::bar("drivers", others.len() * (globals.len() + 1));
    let (mut records, mut drawn) = (Vec::new(), Vec::new());
    for other in &others {
        for globals in &globals {
            let spec = spec(&scene, &view, *globals, &methods, &setup);
            records.extend(compare(&base, other, &spec)?);
            progress::step(&bar)?;
        }
        let spec = spec(&scene, &view, globals[0], &methods, &setup);
        drawn.extend(compare_drawn([&base, other], common.device.validation, &spec)?);
        progress::step(&bar)?;
    }
    bar.finish_and_clear();
    let text = agreement_report::text(&records, &drawn);
    let all = records.iter().map(serde_json::to_value).chain(drawn.iter().map(serde_json::to_value));
    let json = files::json(&all.collect::<std::result::Result<Vec<Value>, _>>()?);
    if let Some(folder) = &options.output {
        files::write(&folder.join("drivers.json"), json.as_bytes())?;
        files::write(&folder.join("drivers.txt"), text.as_bytes())?;
    }
    std::io::stdout().lock().write_all(if options.json { &json } else { &text }.as_bytes())?;
    for gpu in others.iter().chain([&base]) {
        gpu.check_validation()?;
    }
    Ok(())
}

fn spec<'a>(
    scene: &'a Scene,
    view: &'a View,
    globals: Globals,
    methods: &[&'static MethodInfo],
    setup: &crate::methods::Setup,
) -> AgreementSpec<'a> {
    AgreementSpec { scene, view, globals, methods: methods.to_vec(), setup: setup.clone() }
}

/// Every other device that can be used.
///
/// # Errors
/// Those of opening a device.
pub fn others(base: &Gpu, validation: bool) -> Result<Vec<Gpu>> {
    let is_other = |info: &DeviceInfo| info != base.info();
    let listing = device::devices()?.into_iter().filter(|d| d.unsuitable.is_none() && is_other(&d.info));
    listing.map(|d| open(d.index, validation, false)).collect()
}

fn open(index: usize, validation: bool, isotropic: bool) -> Result<Gpu> {
    Gpu::open(&DeviceQuery { device: Some(index.to_string()), validation, isotropic, ..DeviceQuery::default() })
}

/// What `--device` takes for a device.
///
/// # Errors
/// [`Error::NoDevice`] if it is no longer there.
pub fn index(gpu: &Gpu) -> Result<usize> {
    let found = device::devices()?.into_iter().find(|d| d.info == *gpu.info());
    found.map(|d| d.index).ok_or_else(|| Error::NoDevice(format!("{} is gone", gpu.info().name)))
}

/// What a device makes of the G-buffer that `base` draws, against what `base` makes of it.
///
/// # Errors
/// Those of the devices.
pub fn compare(base: &Gpu, other: &Gpu, spec: &AgreementSpec) -> Result<Vec<AgreementRecord>> {
    let data = agreement::draw(base, spec)?;
    let [theirs, ours] = [base, other].map(|gpu| agreement::images(gpu, spec, &data));
    Ok(agreement::compare(other, base.info(), spec, &data, [&theirs?, &ours?]))
}

/// The G-buffers that two devices draw: as methods see them, without anisotropy, and without normal maps, too.
///
/// # Errors
/// Those of the devices.
pub fn compare_drawn(devices: [&Gpu; 2], validation: bool, spec: &AgreementSpec) -> Result<Vec<DrawnRecord>> {
    let again = |gpu| open(index(gpu)?, validation, true);
    let isotropic = [again(devices[0])?, again(devices[1])?];
    let plain = Globals { normal_deviation: Some(0.0), ..spec.globals };
    let mut records = Vec::new();
    for (gpus, globals, is_isotropic) in [
        (devices, spec.globals, false),
        (isotropic.each_ref(), spec.globals, true),
        (isotropic.each_ref(), plain, true),
    ] {
        let spec = AgreementSpec { globals, methods: Vec::new(), setup: spec.setup.clone(), ..*spec };
        let [base, drawn] = gpus.map(|gpu| agreement::draw(gpu, &spec));
        records.push(agreement::compare_drawn(gpus, &spec, [&base?, &drawn?], is_isotropic));
    }
    for gpu in &isotropic {
        gpu.check_validation()?;
    }
    Ok(records)
}

//! `ssct drivers`: the same methods on every device here.

use super::cli::{CommonOptions, parse_size};
use super::printed;
use super::{progress, resolve};
use crate::report::{files, tables};
use crate::stage::Globals;
use crate::study::agreement::{AgreementRecord, AgreementSpec, DrawnRecord};
use crate::study::other_devices;
use clap::Args;
use serde_json::Value;
use ssct_scenes::inside::PathInFolder;
use std::io::Write;
use std::path::PathBuf;

/// Roughness values where none are given.
const ROUGHNESS: [f32; 2] = [0.0, 0.1];

/// Options of `ssct drivers`.
#[derive(Debug, Args)]
pub struct DriversOptions {
    #[command(flatten)]
    pub common: CommonOptions,
    /// Methods, such as ssct,hzct; by default all of them
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub method: Vec<String>,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", value_parser = parse_size, default_value = "641x359")]
    pub size: [u32; 2],
    /// Folder for drivers.json and drivers.txt
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Print the records as JSON, and nothing else
    #[arg(long)]
    pub json: bool,
}

/// Compares every other device with the device that the flags name, and writes and prints the records. It compares
/// the images of methods on one G-buffer, at each roughness, and then the G-buffers that the devices draw themselves.
pub fn run(options: &DriversOptions) -> anyhow::Result<()> {
    let common = &options.common;
    let scene = resolve::scene(&common.place, "rooms")?;
    let view = resolve::view(&scene, &common.place, common.place.scene.is_empty().then_some("corridor"))?;
    let globals = resolve::globals_or(&common.place, &ROUGHNESS)?;
    let setup = common.method_options.setup(options.size);
    let methods = resolve::methods(&options.method, &setup, &[&scene], &resolve::lenses(&scene, [&view]))?;
    let base = resolve::gpu(&common.device)?;
    let others = other_devices::others(&base, common.device.validation)?;
    if others.is_empty() {
        let message = format!("there is no device beside {} to compare with", base.info().name);
        return Err(ssct::Error::NoDevice(message).into());
    }
    let spec = |globals: Globals| AgreementSpec {
        scene: &scene,
        view: &view,
        globals,
        methods: methods.clone(),
        setup: setup.clone(),
    };
    let bar = progress::bar("drivers", globals.len() + others.len());
    let (mut records, mut drawn) = (Vec::new(), Vec::new());
    for globals in &globals {
        records.extend(other_devices::compare(&base, &others, &spec(*globals))?);
        progress::step(&bar)?;
    }
    for other in &others {
        drawn.extend(other_devices::compare_drawn([&base, other], common.device.validation, &spec(globals[0]))?);
        progress::step(&bar)?;
    }
    bar.finish_and_clear();
    let text = tables::text(&[AgreementRecord::table(&records), DrawnRecord::table(&drawn)]);
    let all_records = records.iter().map(serde_json::to_value).chain(drawn.iter().map(serde_json::to_value));
    let json = files::json(&all_records.collect::<std::result::Result<Vec<Value>, _>>()?);
    if let Some(folder) = &options.output {
        let folder = PathInFolder::folder(folder);
        folder.join("drivers.json").write(json.as_bytes())?;
        folder.join("drivers.txt").write(text.as_bytes())?;
    }
    printed::out().write_all(if options.json { &json } else { &text }.as_bytes())?;
    for gpu in others.iter().chain([&base]) {
        gpu.check_validation()?;
    }
    Ok(())
}

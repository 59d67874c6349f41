//! `ssct shaders`: what the compiler of a device made of each program.

use super::cli::{CommonOptions, DeviceOptions, parse_size};
use super::measure::StudyOptions;
use super::parameters::{TypedVariant, parse_variant};
use super::resolve;
use crate::error::{Error, Result};
use crate::study::engine::LastMade;
use crate::study::error::Variant;
use crate::study::shaders::ShadersStudy;
use clap::Args;
use ssct::gpu::sources;
use ssct::gpu::{DeviceQuery, Gpu};
use std::ffi::OsString;

/// Roughness values whose frames are compiled unless flags say otherwise: a mirror, a narrow lobe and a wide lobe.
const ROUGHNESS: [f32; 3] = [0.0, 0.1, 0.3];

/// Options of `ssct shaders`.
#[derive(Debug, Args)]
pub struct ShadersOptions {
    #[command(flatten)]
    pub common: CommonOptions,
    /// Methods, such as ssct,unified; by default all of them
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub method: Vec<String>,
    /// A method with its own options; may be repeated
    ///
    /// An example is "unified --history on". Options within the quotes override the same options outside them. Give it once for each
    /// variant whose programs are compiled, instead of --method. A folder whose path has blanks stands in quotes of its own:
    /// "'my methods/m' --fade off".
    #[arg(long, value_name = "METHOD OPTIONS", value_parser = parse_variant, conflicts_with = "method")]
    pub variant: Vec<TypedVariant>,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", value_parser = parse_size, default_value = "320x180")]
    pub size: [u32; 2],
}

/// Mesa's variable that names a GPU whose hardware need not be there.
const FAMILY: &str = "RADV_FORCE_FAMILY";

/// Returns the GPU family that the variable [`FAMILY`] names, if any.
fn family() -> Option<OsString> {
    std::env::var_os(FAMILY).filter(|family| !family.is_empty())
}

/// Checks that the driver knows the family that [`FAMILY`] names, if any. It lists the devices in another process,
/// since Mesa ends a process for which an unknown family is named.
fn check_family() -> Result<()> {
    let Some(family) = family() else { return Ok(()) };
    let Ok(program) = std::env::current_exe() else { return Ok(()) };
    // Without this variable, the other process adds no notice about the folder of shaders to the driver's message.
    match std::process::Command::new(program).arg("devices").env_remove(sources::VARIABLE).output() {
        // A process that a signal ended has no exit status.
        Ok(tried) if tried.status.code().is_none() => {
            let message = String::from_utf8_lossy(&tried.stderr);
            let (message, family) = (message.trim(), family.to_string_lossy());
            Err(ssct::Error::NoDevice(format!(
                "the driver gave up on {FAMILY}={family}, and said: {message}; a younger Mesa may know the family \
                 (scripts/drivers.sh --radv, docs/devices.md)"
            ))
            .into())
        }
        _ => Ok(()),
    }
}

impl StudyOptions for ShadersOptions {
    type Study = ShadersStudy;

    fn device(&self) -> &DeviceOptions {
        &self.common.device
    }

    /// Opens the device only to compile, so that its hardware need not be there. Validation layers are refused, since
    /// nothing runs.
    fn open(&self) -> Result<Gpu> {
        let DeviceOptions { device, validation } = self.device();
        if *validation {
            let message =
                "--validation: shaders are compiled here and not run, so that the layers have nothing to watch";
            return Err(Error::usage(message.into()));
        }
        check_family()?;
        let opened = Gpu::open(&DeviceQuery { device: device.clone(), compiles_only: true, ..DeviceQuery::default() });
        opened.map_err(|error| match error {
            ssct::Error::NoDevice(why) if family().is_none() => {
                let why = format!("{why}; for Mesa's RADV, {FAMILY}=navi31 names a GPU that need not be there");
                ssct::Error::NoDevice(why).into()
            }
            error => error.into(),
        })
    }

    fn study(&self) -> Result<ShadersStudy> {
        let place = &self.common.place;
        let scene = resolve::scene(place, "rooms")?;
        let view = resolve::view(&scene, place, None)?;
        let base = self.common.method_options.setup(self.size);
        let variants = if self.variant.is_empty() {
            Variant::for_methods(
                &resolve::methods(&self.method, &base, &[&scene], &resolve::lenses(&scene, [&view]))?,
                &base,
            )
        } else {
            resolve::typed_variants(&self.variant, &base)?
        };
        let globals = resolve::globals_or(place, &ROUGHNESS)?;
        Ok(ShadersStudy { scene, view, variants, extent: self.size, globals, stage: LastMade::default() })
    }
}

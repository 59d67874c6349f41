//! `ssct devices`.

use super::cli::DevicesOptions;
use super::printed;
use crate::study::names::json_text;
use ssct::gpu::device;
use std::io::Write;

/// Prints the devices that Vulkan lists, as text or as JSON, each with its index and, if it cannot be used, the reason.
pub fn run(options: &DevicesOptions) -> anyhow::Result<()> {
    let listing = device::devices()?;
    let mut out = printed::out();
    if options.json {
        writeln!(out, "{}", json_text(&serde_json::to_string_pretty(&listing)?))?;
        return Ok(());
    }
    for device in &listing {
        let why = device.unsuitable.as_ref().map(|why| format!(" (unusable: {why})")).unwrap_or_default();
        let info = &device.info;
        writeln!(out, "{}  {}, {}, Vulkan {}, {}{why}", device.index, info.name, info.kind, info.api, info.driver)?;
    }
    if listing.is_empty() {
        writeln!(out, "no Vulkan device; scripts/setup.sh installs one that runs on the CPU")?;
    }
    Ok(())
}

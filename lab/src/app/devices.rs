//! `ssct devices`.

use super::cli::DevicesOptions;
use super::printed;
use crate::study::names::json_text;
use ssct::gpu::device;
use std::io::Write;

/// Lists the devices. The default device is chosen by its type, not by its place in the list.
pub fn run(options: &DevicesOptions) -> anyhow::Result<()> {
    let listing = device::devices()?;
    let mut out = printed::out();
    if options.json {
        writeln!(out, "{}", json_text(&serde_json::to_string_pretty(&listing)?))?;
        return Ok(());
    }
    for d in &listing {
        let why = d.unsuitable.as_ref().map(|w| format!(" (unusable: {w})")).unwrap_or_default();
        writeln!(out, "{}  {}, {}, Vulkan {}, {}{why}", d.index, d.info.name, d.info.kind, d.info.api, d.info.driver)?;
    }
    if listing.is_empty() {
        writeln!(out, "no Vulkan device; scripts/setup.sh installs one that runs on the CPU")?;
    }
    Ok(())
}

//! Numbers of a large scene's time and memory.

use super::figures::{Result, greatest, median, text};
use std::path::Path;

/// Seconds or greatest memory, in GB, of the runs of a large scene with its images whole (`all`) or at most of a side.
pub fn large_gltf(folder: &Path, figure: &str, side: &str) -> Result<String> {
    let all = text(folder, "memory.txt")?;
    let flag = format!("--texture-size {side}");
    let is_wanted = |line: &&str| if side == "all" { !line.contains("--texture-size") } else { line.contains(&flag) };
    // A line ends in "…: 22.29 s, 6690380 KiB at most".
    let value = |line: &str| {
        let (seconds, kib) = line.rsplit_once(": ")?.1.split_once(" s, ")?;
        let kib: f64 = kib.strip_suffix(" KiB at most")?.parse().ok()?;
        Some([seconds.parse().ok()?, kib * 1024.0 / 1e9])
    };
    let values = all.lines().filter(is_wanted).map(|line| value(line).ok_or_else(|| format!("what is {line:?}?")));
    let values = values.collect::<Result<Vec<[f64; 2]>>>()?;
    match figure {
        "seconds" => Ok(format!("{:.0}", median(&values.iter().map(|v| v[0]).collect::<Vec<_>>())?)),
        "memory" => Ok(format!("{:.1}", greatest(&values.iter().map(|v| v[1]).collect::<Vec<_>>()))),
        _ => Err(format!("{figure} is neither seconds nor memory")),
    }
}

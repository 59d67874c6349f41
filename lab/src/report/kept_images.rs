//! What methods made of one G-buffer on one device, kept as files, so that a device on another machine can be held against
//! it.

use super::files;
use super::images::{read_exr_channels, write_exr};
use crate::error::{Error, Result};
use crate::gpu::{DeviceInfo, Pixels};
use crate::methods::MethodInfo;
use crate::scene::{GBufferData, gbuffer_file};
use crate::study::agreement::DeviceImage;
use std::path::{Path, PathBuf};

const COLOR: [&str; 4] = ["R", "G", "B", "A"];
const HITS: [&str; 4] = ["X", "Y", "Z", "W"];

fn gbuffer_path(folder: &Path, stem: &str) -> PathBuf {
    folder.join(format!("gbuffer-{stem}.exr"))
}

fn image_path(folder: &Path, method: &str, stem: &str, what: &str) -> PathBuf {
    folder.join(format!("{method}-{stem}{what}.exr"))
}

/// Writes which device it was.
///
/// # Errors
/// Errors of writing a file.
pub fn write_device(folder: &Path, device: &DeviceInfo) -> Result<()> {
    files::write(&folder.join("device.json"), files::json(std::slice::from_ref(device)).as_bytes())
}

/// Reads which device it was.
///
/// # Errors
/// [`Error::Io`] for a file that cannot be read, [`Error::Malformed`] for one that says something else.
pub fn read_device(folder: &Path) -> Result<DeviceInfo> {
    let path = folder.join("device.json");
    let text = std::fs::read_to_string(&path).map_err(|e| Error::io("read", &path, e))?;
    let all: Vec<DeviceInfo> =
        serde_json::from_str(&text).map_err(|e| Error::malformed(&path, None, format!("names no device: {e}")))?;
    all.into_iter().next().ok_or_else(|| Error::malformed(&path, None, "names no device".to_owned()))
}

/// Writes a G-buffer and what methods made of it; `stem` tells several of a folder apart.
///
/// # Errors
/// Errors of writing a file.
pub fn write(folder: &Path, stem: &str, data: &GBufferData, made: &[DeviceImage]) -> Result<()> {
    let path = gbuffer_path(folder, stem);
    files::write(&path, &gbuffer_file::encode(data, &path)?)?;
    for DeviceImage { method, reflection, hits } in made {
        write_exr(&image_path(folder, method.name, stem, ""), reflection, &COLOR)?;
        if let Some(hits) = hits {
            write_exr(&image_path(folder, method.name, stem, "-hits"), hits, &HITS)?;
        }
    }
    Ok(())
}

/// Reads the G-buffer.
///
/// # Errors
/// Errors of [`gbuffer_file::load`].
pub fn read_gbuffer(folder: &Path, stem: &str) -> Result<GBufferData> {
    gbuffer_file::load(&gbuffer_path(folder, stem))
}

/// Reads what methods made of the G-buffer; those of which the folder has nothing are left out.
///
/// # Errors
/// [`Error::Malformed`] for a file that cannot be read as such an image, or is of another size than the G-buffer.
pub fn read(
    folder: &Path,
    stem: &str,
    data: &GBufferData,
    methods: &[&'static MethodInfo],
) -> Result<Vec<DeviceImage>> {
    let read = |method: &MethodInfo, what: &str, [x, y, z, w]: [&str; 4]| -> Result<Option<Pixels>> {
        let path = image_path(folder, method.name, stem, what);
        if !path.exists() {
            return Ok(None);
        }
        let pixels = read_exr_channels(&path, [x, y, z], Some(w))?;
        if [pixels.width, pixels.height] != [data.width, data.height] {
            let (width, height) = (data.width, data.height);
            return Err(Error::malformed(&path, None, format!("its G-buffer has another size, {width}x{height}")));
        }
        Ok(Some(pixels))
    };
    let mut all = Vec::new();
    for method in methods {
        if let Some(reflection) = read(method, "", COLOR)? {
            all.push(DeviceImage { method, reflection, hits: read(method, "-hits", HITS)? });
        }
    }
    Ok(all)
}

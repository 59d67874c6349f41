//! Keeps the images that methods made of one G-buffer on one device as files, so that the images of a device on another machine can be
//! compared with them.

use super::files;
use super::images::{decode_exr_channels, write_exr};
use crate::study::agreement::DeviceImage;
use ssct::gpu::{DeviceInfo, Pixels};
use ssct::methods::MethodInfo;
use ssct_ground::{Error, Result};
use ssct_scenes::inside::PathInFolder;
use ssct_scenes::{GBufferData, gbuffer_file};

/// The names of channels in the files of reflections.
const COLOR: [&str; 4] = ["R", "G", "B", "A"];
/// The names of channels in the files of hits.
const HITS: [&str; 4] = ["X", "Y", "Z", "W"];

/// The file of the G-buffer that `stem` tells from others in the folder.
fn gbuffer_path(folder: &PathInFolder, stem: &str) -> PathInFolder {
    folder.join(format!("gbuffer-{stem}.exr"))
}

/// The file of an image that a method made of the G-buffer `stem`; `suffix` is `-hits` for hits, and empty for
/// reflections.
fn image_path(folder: &PathInFolder, method: &str, stem: &str, suffix: &str) -> PathInFolder {
    folder.join(format!("{method}-{stem}{suffix}.exr"))
}

/// Writes the device that made the images.
pub fn write_device(folder: &PathInFolder, device: &DeviceInfo) -> Result<()> {
    files::write(folder.join("device.json"), files::json(std::slice::from_ref(device)).as_bytes())
}

/// Reads the device that made the images.
pub fn read_device(folder: &PathInFolder) -> Result<DeviceInfo> {
    let path = folder.join("device.json");
    let wrong = |why: String| Error::malformed(path.path(), None, format!("names no device{why}"));
    let devices: Vec<DeviceInfo> = serde_json::from_slice(&path.bytes()?).map_err(|e| wrong(format!(": {e}")))?;
    devices.into_iter().next().ok_or_else(|| wrong(String::new()))
}

/// Writes a G-buffer and the images that methods made of it; `stem` distinguishes several G-buffers in a folder.
pub fn write(folder: &PathInFolder, stem: &str, data: &GBufferData, images: &[DeviceImage]) -> Result<()> {
    let path = gbuffer_path(folder, stem);
    path.write(&gbuffer_file::encode(data, &path.path())?)?;
    for DeviceImage { method, reflection, hits } in images {
        write_exr(image_path(folder, method.name, stem, ""), reflection, &COLOR)?;
        if let Some(hits) = hits {
            write_exr(image_path(folder, method.name, stem, "-hits"), hits, &HITS)?;
        }
    }
    Ok(())
}

/// Reads the G-buffer that [`write()`] wrote with the same `stem`.
pub fn read_gbuffer(folder: &PathInFolder, stem: &str) -> Result<GBufferData> {
    let path = gbuffer_path(folder, stem);
    gbuffer_file::decode(&path.bytes()?, &path.path())
}

/// Reads the images that methods made of the G-buffer; methods without an image in the folder are left out.
pub fn read(
    folder: &PathInFolder,
    stem: &str,
    data: &GBufferData,
    methods: &[&'static MethodInfo],
) -> Result<Vec<DeviceImage>> {
    let read_file = |method: &MethodInfo, suffix: &str, [x, y, z, w]: [&str; 4]| -> Result<Option<Pixels>> {
        let path = image_path(folder, method.name, stem, suffix);
        let Some(bytes) = path.read()? else { return Ok(None) };
        let pixels = decode_exr_channels(&bytes, &path.path(), [x, y, z], Some(w))?;
        if [pixels.width, pixels.height] != [data.width, data.height] {
            let message = format!("its G-buffer has another size, {}x{}", data.width, data.height);
            return Err(Error::malformed(path.path(), None, message));
        }
        Ok(Some(pixels))
    };
    let mut images = Vec::new();
    for method in methods {
        if let Some(reflection) = read_file(method, "", COLOR)? {
            images.push(DeviceImage { method, reflection, hits: read_file(method, "-hits", HITS)? });
        }
    }
    Ok(images)
}

//! Keeps the images that methods made of one G-buffer on one device as files, so that the images of a device on another machine can be
//! compared with them.

use super::files;
use super::images::{exr_channels, write_exr};
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

/// The file of a G-buffer.
fn gbuffer_path(folder: &PathInFolder, stem: &str) -> PathInFolder {
    folder.join(format!("gbuffer-{stem}.exr"))
}

/// The file of an image that a method made of the G-buffer `stem`; `what` is `-hits` for hits, and empty for
/// reflections.
fn image_path(folder: &PathInFolder, method: &str, stem: &str, what: &str) -> PathInFolder {
    folder.join(format!("{method}-{stem}{what}.exr"))
}

/// Writes the device that made the images.
///
/// # Errors
/// Errors of writing a file.
pub fn write_device(folder: &PathInFolder, device: &DeviceInfo) -> Result<()> {
    files::write(folder.join("device.json"), files::json(std::slice::from_ref(device)).as_bytes())
}

/// Reads the device that made the images.
///
/// # Errors
/// [`Io`](ssct_ground::Error::Io) for a file that cannot be read, [`Malformed`](ssct_ground::Error::Malformed) for a file that names no
/// device.
pub fn read_device(folder: &PathInFolder) -> Result<DeviceInfo> {
    let path = folder.join("device.json");
    let wrong = |why: String| Error::malformed(path.path(), None, format!("names no device{why}"));
    let all: Vec<DeviceInfo> = serde_json::from_slice(&path.bytes()?).map_err(|e| wrong(format!(": {e}")))?;
    all.into_iter().next().ok_or_else(|| wrong(String::new()))
}

/// Writes a G-buffer and the images that methods made of it; `stem` distinguishes several G-buffers in a folder.
///
/// # Errors
/// Errors of writing a file.
pub fn write(folder: &PathInFolder, stem: &str, data: &GBufferData, made: &[DeviceImage]) -> Result<()> {
    let path = gbuffer_path(folder, stem);
    path.write(&gbuffer_file::encode(data, &path.path())?)?;
    for DeviceImage { method, reflection, hits } in made {
        write_exr(image_path(folder, method.name, stem, ""), reflection, &COLOR)?;
        if let Some(hits) = hits {
            write_exr(image_path(folder, method.name, stem, "-hits"), hits, &HITS)?;
        }
    }
    Ok(())
}

/// Reads the G-buffer that [`write`] wrote with the same `stem`.
///
/// # Errors
/// Errors of [`gbuffer_file::load`].
pub fn read_gbuffer(folder: &PathInFolder, stem: &str) -> Result<GBufferData> {
    let path = gbuffer_path(folder, stem);
    gbuffer_file::decode(&path.bytes()?, &path.path())
}

/// Reads the images that methods made of the G-buffer; methods without an image in the folder are left out.
///
/// # Errors
/// [`Malformed`](ssct_ground::Error::Malformed) for a file that cannot be read as such an image, or is of another size than the G-buffer.
pub fn read(
    folder: &PathInFolder,
    stem: &str,
    data: &GBufferData,
    methods: &[&'static MethodInfo],
) -> Result<Vec<DeviceImage>> {
    let read = |method: &MethodInfo, what: &str, [x, y, z, w]: [&str; 4]| -> Result<Option<Pixels>> {
        let path = image_path(folder, method.name, stem, what);
        let Some(bytes) = path.read()? else { return Ok(None) };
        let pixels = exr_channels(&bytes, &path.path(), [x, y, z], Some(w))?;
        if [pixels.width, pixels.height] != [data.width, data.height] {
            let (width, height) = (data.width, data.height);
            return Err(Error::malformed(
                path.path(),
                None,
                format!("its G-buffer has another size, {width}x{height}"),
            ));
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

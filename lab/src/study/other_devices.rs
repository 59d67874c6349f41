//! Opens the other devices of this machine, and compares the images that they make of a view with those of a base
//! device.

use super::agreement::{self, AgreementRecord, AgreementSpec, DrawnRecord};
use crate::error::Result;
use crate::stage::Globals;
use ssct::gpu::{DeviceQuery, Gpu, device};

/// Opens every usable device of the machine except `base`; `validation` turns the validation layers on.
///
/// # Errors
/// Errors of opening a device.
pub fn others(base: &Gpu, validation: bool) -> Result<Vec<Gpu>> {
    let listing = device::devices()?.into_iter();
    let usable = listing.filter(|d| d.unsuitable.is_none() && Some(d.index) != base.index());
    usable.map(|d| open(Some(d.index), validation, false)).collect()
}

/// Opens a device once more, under the validation layers.
///
/// # Errors
/// Errors of opening a device; [`Usage`](ssct::Error::Usage) where the layers are not installed.
pub fn validated(gpu: &Gpu) -> Result<Gpu> {
    open(gpu.index(), true, false)
}

/// Opens a device once more, for compiling only.
///
/// # Errors
/// Errors of opening a device; [`NoDevice`](ssct::Error::NoDevice) for a device that reports nothing of its compiler.
pub fn compiler(gpu: &Gpu) -> Result<Gpu> {
    let device = gpu.index().map(|index| index.to_string());
    Ok(Gpu::open(&DeviceQuery { device, compiles_only: true, ..DeviceQuery::default() })?)
}

/// Opens a device by its index among all devices; without an index, the default device. If `isotropic` is true,
/// material maps are sampled without anisotropy.
fn open(index: Option<usize>, validation: bool, isotropic: bool) -> Result<Gpu> {
    let device = index.map(|index| index.to_string());
    Ok(Gpu::open(&DeviceQuery { device, validation, isotropic, ..DeviceQuery::default() })?)
}

/// Compares the images that other devices make from a G-buffer with the images that `base` makes from it; `base` draws
/// the G-buffer.
///
/// # Errors
/// The error of the first device that fails.
pub fn compare<'g>(
    base: &Gpu,
    others: impl IntoIterator<Item = &'g Gpu>,
    spec: &AgreementSpec,
) -> Result<Vec<AgreementRecord>> {
    let data = agreement::draw(base, spec)?;
    let base_images = agreement::images(base, spec, &data)?;
    let mut records = Vec::new();
    for gpu in others {
        let images = agreement::images(gpu, spec, &data)?;
        records.extend(agreement::compare(gpu, base.info(), spec, &data, [&base_images, &images]));
    }
    Ok(records)
}

/// Compares the G-buffers that two devices draw, the first of which is the base. The three records are of G-buffers as
/// methods see them, without anisotropy, and without anisotropy and normal maps.
///
/// # Errors
/// Errors of the devices.
pub fn compare_drawn(devices: [&Gpu; 2], validation: bool, spec: &AgreementSpec) -> Result<Vec<DrawnRecord>> {
    let open_isotropic = |gpu: &Gpu| open(gpu.index(), validation, true);
    let isotropic = [open_isotropic(devices[0])?, open_isotropic(devices[1])?];
    let plain = Globals { normal_deviation: Some(0.0), ..spec.globals };
    let mut records = Vec::new();
    for (gpus, globals, is_isotropic) in [
        (devices, spec.globals, false),
        (isotropic.each_ref(), spec.globals, true),
        (isotropic.each_ref(), plain, true),
    ] {
        let spec = AgreementSpec { globals, ..spec.clone() };
        let [base, drawn] = gpus.map(|gpu| agreement::draw(gpu, &spec));
        records.push(agreement::compare_drawn(gpus, &spec, [&base?, &drawn?], is_isotropic));
    }
    for gpu in &isotropic {
        gpu.check_validation()?;
    }
    Ok(records)
}

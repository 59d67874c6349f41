//! Records of several devices: times of different devices are never compared, so that what shows times shows each
//! device's apart (docs/many-machines.md, "Merging").

use crate::gpu::DeviceInfo;

/// Records by device, in the order in which the devices appear.
pub fn by_device<T: Clone>(records: &[T], device: impl Fn(&T) -> &DeviceInfo) -> Vec<(DeviceInfo, Vec<T>)> {
    let mut apart: Vec<(DeviceInfo, Vec<T>)> = Vec::new();
    for record in records {
        match apart.iter_mut().find(|(of, _)| of == device(record)) {
            Some((_, records)) => records.push(record.clone()),
            None => apart.push((device(record).clone(), vec![record.clone()])),
        }
    }
    apart
}

/// What a device is called beside others.
pub fn device_name(device: &DeviceInfo) -> String {
    format!("{} ({}, {})", device.name, device.kind, device.driver)
}

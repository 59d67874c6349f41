//! Records of several devices. Times of different devices are never compared: every report shows the times of each
//! device apart (docs/many-machines.md, "Merging").

use crate::study::names::one_line;
use ssct::gpu::DeviceInfo;

/// Groups records by their devices, in the order in which the devices appear. `device` returns the device of a record.
pub fn by_device<T: Clone>(records: &[T], device: impl Fn(&T) -> &DeviceInfo) -> Vec<(DeviceInfo, Vec<T>)> {
    let mut groups: Vec<(DeviceInfo, Vec<T>)> = Vec::new();
    for record in records {
        match groups.iter_mut().find(|(known, _)| known == device(record)) {
            Some((_, records)) => records.push(record.clone()),
            None => groups.push((device(record).clone(), vec![record.clone()])),
        }
    }
    groups
}

/// The name of a device in a report on several devices, in one line.
pub fn device_name(device: &DeviceInfo) -> String {
    one_line(&format!("{} ({}, {})", device.name, device.kind, device.driver)).into_owned()
}

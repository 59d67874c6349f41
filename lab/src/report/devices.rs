//! Records of several devices. Times of different devices are never compared: every report shows the times of each
//! device apart (docs/many-machines.md, "Merging").

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

/// Returns the shortest name that tells a device from the others in a table: its own name, with the driver and its version
/// if another device has the same name, and with the version of Vulkan if that one has the same driver, too.
pub fn name_among(device: &DeviceInfo, others: &[&DeviceInfo]) -> String {
    let (name, driver) = (&device.name, &device.driver);
    let mut namesakes = others.iter().filter(|other| **other != device && other.name == *name).peekable();
    if namesakes.peek().is_none() {
        name.clone()
    } else if namesakes.all(|other| other.driver != *driver) {
        format!("{name} ({driver})")
    } else {
        format!("{name} ({driver}, Vulkan {}, {})", device.api, device.kind)
    }
}

/// The name of a device in a report of several.
pub fn device_name(device: &DeviceInfo) -> String {
    format!("{} ({}, {})", device.name, device.kind, device.driver)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_drivers_of_one_name_are_told_apart() {
        let device = |name: &str, driver: &str, api: &str| {
            let kind = "CPU".to_owned();
            DeviceInfo { name: name.to_owned(), driver: driver.to_owned(), api: api.to_owned(), kind }
        };
        let old = device("llvmpipe", "Mesa 22.3", "1.3.230");
        let new = device("llvmpipe", "Mesa 25.0", "1.4.305");
        let other = device("SwiftShader", "5.0", "1.3.0");
        let all = [&old, &new, &other, &old];
        let names = [&old, &new, &other].map(|d| name_among(d, &all));
        assert_eq!(names, ["llvmpipe (Mesa 22.3)", "llvmpipe (Mesa 25.0)", "SwiftShader"]);
        assert_eq!(name_among(&old, &[&old, &other]), "llvmpipe");
        let same_driver = device("llvmpipe", "Mesa 22.3", "1.2.0");
        assert_eq!(name_among(&old, &[&old, &same_driver]), "llvmpipe (Mesa 22.3, Vulkan 1.3.230, CPU)");
    }
}

//! Says why the Vulkan loader offers no device: a variable names wrong files, a driver finds no card, or none is there.

use super::vulkan;
use crate::error::Error;
use ash::vk;
use std::path::Path;

/// The variables that name the loader's drivers. The first one that is set counts.
const VARIABLES: [&str; 2] = ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"];

/// Advice that helps on every machine.
const HINT: &str = "Mesa's lavapipe is a driver that runs on the CPU";

/// Returns a function that makes the error of the failed call `what`: why there is no device, or else the call's name.
pub(super) fn failed(what: &'static str) -> impl Fn(vk::Result) -> Error {
    move |result| match result {
        vk::Result::ERROR_INCOMPATIBLE_DRIVER | vk::Result::ERROR_INITIALIZATION_FAILED => no_device(result),
        _ => vulkan(what)(result),
    }
}

/// Makes the error about a loader that offers no device.
pub(super) fn no_device(result: vk::Result) -> Error {
    let value = |name: &&str| std::env::var(name).ok().filter(|value| !value.is_empty());
    let named = VARIABLES.iter().find_map(|name| Some((*name, value(name)?)));
    Error::NoDevice(sentence(named.as_ref().map(|(name, value)| (*name, value.as_str())), result))
}

/// Says why the loader offers no device. `named` is the variable that names the drivers, if one is set, with its value.
fn sentence(named: Option<(&str, &str)>, result: vk::Result) -> String {
    let Some((name, value)) = named else {
        return match result {
            vk::Result::ERROR_INCOMPATIBLE_DRIVER => format!("the loader finds no driver; {HINT}"),
            _ => format!("a driver is there and finds no card; {HINT}"),
        };
    };
    let separator = if cfg!(windows) { ';' } else { ':' };
    let files = || value.split(separator).filter(|file| !file.is_empty());
    match files().find(|file| !Path::new(file).exists()) {
        Some(absent) => format!("{name}={value} names no file: {absent} is not there; {HINT}"),
        None => format!("a driver is there and finds no card ({name}={value}); {HINT}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_variable_and_its_value_are_named() {
        let here = std::env::current_exe().expect("a program");
        let here = here.to_str().expect("a text");
        let none = vk::Result::ERROR_INCOMPATIBLE_DRIVER;
        let failed = vk::Result::ERROR_INITIALIZATION_FAILED;
        assert_eq!(sentence(None, none), format!("the loader finds no driver; {HINT}"));
        assert_eq!(sentence(None, failed), format!("a driver is there and finds no card; {HINT}"));
        let there = sentence(Some(("VK_DRIVER_FILES", here)), failed);
        assert_eq!(there, format!("a driver is there and finds no card (VK_DRIVER_FILES={here}); {HINT}"));
        let absent = sentence(Some(("VK_ICD_FILENAMES", "/nowhere/a.json")), none);
        assert_eq!(
            absent,
            format!("VK_ICD_FILENAMES=/nowhere/a.json names no file: /nowhere/a.json is not there; {HINT}")
        );
    }
}

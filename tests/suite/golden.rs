//! Compares small images of the built-in scenes with kept ones by FLIP: `tests/golden/` has a sheet of them for each
//! view.
//!
//! The images are drawn without anisotropy, since each driver places the samples of an anisotropic filter as it likes.
//! On lavapipe, maps are filtered in floating point (docs/devices.md). To renew the sheets after an intended change,
//! run `SSCT_UPDATE_GOLDEN=1 cargo test --test suite golden::`, and look at them.

use crate::common::{gpu, repository, unfaded};
use ssct::gpu::{DeviceQuery, Gpu};
use ssct::methods::ssct::ThesisDrawing;
use ssct::methods::{METHODS, Setup, Wants};
use ssct::passes::color_chain::ChainFilter;
use ssct_ground::parameter::Preset;
use ssct_lab::report::images::{Rgb, display};
use ssct_lab::stage::image::render;
use ssct_lab::stage::{Globals, SharedImages, Shot, Stage};
use ssct_scenes::library;
use ssct_truth::metrics::flip::FlipMap;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Size in pixels of one image on a sheet.
const EXTENT: [u32; 2] = [192, 108];

/// The greatest mean FLIP between an image and the kept one. Devices may differ in pixels on edges, in the last of 8
/// bits of a filter's weights, and in rays that pass a cell within rounding. One pixel in a hundred that is wholly
/// wrong makes 0.01. Another preset, filter or fade makes 0.07 and more, as `a_changed_pass_is_seen` tests.
const BOUND: f64 = 0.01;

/// Scene, view and roughness of each sheet. The scenes of the first thesis have mirrors or gloss; the others have their
/// materials' own roughness.
const VIEWS: [(&str, &str, Option<f32>); 7] = [
    ("rooms", "cylinder", Some(0.0)),
    ("rooms", "corridor", Some(0.3)),
    ("atrium", "hall", Some(0.1)),
    ("street", "car", None),
    ("museum", "exit-sign", None),
    ("cathedral", "rose", None),
    ("corridor", "corridor", None),
];

/// The number of images in a row of a sheet; a sheet has one image for each method, in the order of the table.
const COLUMNS: u32 = 5;

/// The images of a view, one for each method.
struct Sheet {
    path: PathBuf,
    image: image::RgbImage,
}

impl Sheet {
    /// Opens the sheet of a view, or makes a new one if the sheets are to be renewed.
    fn open(stem: &str) -> Self {
        let path = repository().join("tests/golden").join(format!("{stem}.png"));
        let size = [COLUMNS * EXTENT[0], (METHODS.len() as u32).div_ceil(COLUMNS) * EXTENT[1]];
        if is_updating() {
            return Self { path, image: image::RgbImage::new(size[0], size[1]) };
        }
        let renew = "SSCT_UPDATE_GOLDEN=1 makes it";
        let image = image::open(&path).unwrap_or_else(|e| panic!("{}: {e}; {renew}", path.display())).into_rgb8();
        assert_eq!([image.width(), image.height()], size, "{}: is of other methods; {renew}", path.display());
        Self { path, image }
    }

    /// Returns the upper left corner of the image of a method on a sheet, in pixels. Methods are numbered in the order
    /// of the table.
    fn corner(number: usize) -> [u32; 2] {
        let number = number as u32;
        [number % COLUMNS * EXTENT[0], number / COLUMNS * EXTENT[1]]
    }

    /// Returns the kept image of a method.
    fn get(&self, number: usize) -> image::RgbImage {
        let [x, y] = Self::corner(number);
        image::imageops::crop_imm(&self.image, x, y, EXTENT[0], EXTENT[1]).to_image()
    }

    /// Puts the new image of a method on the sheet.
    fn put(&mut self, number: usize, new_image: &Rgb) {
        let [x, y] = Self::corner(number);
        let new_image = image::RgbImage::from_raw(new_image.width, new_image.height, new_image.bytes.clone()).unwrap();
        image::imageops::replace(&mut self.image, &new_image, x.into(), y.into());
    }
}

/// Returns the path to which an image of a failed comparison is written.
fn failed_path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join("golden").join(name)
}

/// Returns whether the sheets are to be renewed instead of compared.
fn is_updating() -> bool {
    std::env::var_os("SSCT_UPDATE_GOLDEN").is_some_and(|v| v == "1")
}

/// Compares an image with the kept one. Returns a sentence if the mean FLIP is not below [`BOUND`]. `stem` is the name
/// of the image in messages and files.
fn compare(stem: &str, kept: &image::RgbImage, image: &Rgb) -> Option<String> {
    assert_eq!([kept.width(), kept.height()], [image.width, image.height], "{stem}");
    let map = FlipMap::new(kept.as_raw(), &image.bytes, image.width, image.height);
    println!("{stem}: FLIP {:.5}", map.mean());
    if map.mean() < BOUND {
        return None;
    }
    let (rendered, difference) = (failed_path(&format!("{stem}.png")), failed_path(&format!("{stem}-flip.png")));
    image.write_png(&rendered).unwrap();
    Rgb { bytes: map.picture(), ..image.clone() }.write_png(&difference).unwrap();
    Some(format!(
        "{stem}: mean FLIP {:.4} is not below {BOUND}; rendered: {}, FLIP map: {}",
        map.mean(),
        rendered.display(),
        difference.display()
    ))
}

/// An environment variable of Mesa, and the word in it by which lavapipe filters maps of 8 bits in floating point.
/// Without it, lavapipe filters in fixed point, which Mesa 26 rounds otherwise than Mesa 22 and 25.
const FILTER: [&str; 2] = ["GALLIVM_PERF", "no_aos_sampling"];

/// Every method on every view of `VIEWS`, on each usable device, differs from the kept image by a mean FLIP below 0.01.
/// A change that no other test covers shows here.
#[test]
fn images_of_the_built_in_scenes_are_as_they_were() {
    let [variable, word] = FILTER;
    let words_set = std::env::var(variable).unwrap_or_default();
    if !words_set.contains(word) {
        // A driver reads the variable when it is loaded, so that a process of its own has it.
        let words = if words_set.is_empty() { word.to_owned() } else { format!("{words_set},{word}") };
        let arguments = ["golden::images_of_the_built_in_scenes_are_as_they_were", "--exact", "--nocapture"];
        let this_test = std::env::current_exe().unwrap();
        let output = Command::new(this_test).args(arguments).env(variable, words).output().unwrap();
        println!("{}", String::from_utf8_lossy(&output.stdout));
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        return;
    }
    let devices = ssct::gpu::device::devices().unwrap();
    let usable: Vec<_> = devices.into_iter().filter(|d| d.unsuitable.is_none()).collect();
    assert!(!usable.is_empty());
    if let [only_device] = &usable[..] {
        println!(
            "one device here, {} ({}): held against the images alone",
            only_device.info.name, only_device.info.driver
        );
    }
    for device in &usable {
        // All devices are compared with one image, so that two devices are also close to each other.
        println!("{} ({})", device.info.name, device.info.driver);
        let device = Some(device.index.to_string());
        // Vulkan's validation layers are off here, since the tests in `validation` run every method with them.
        let query = DeviceQuery { device, isotropic: true, ..DeviceQuery::default() };
        check_all_views(&Gpu::open(&query).unwrap());
        if is_updating() {
            break;
        }
    }
}

/// Compares the image of every method on every view with its kept image.
fn check_all_views(gpu: &Gpu) {
    let mut failures = Vec::new();
    let setup = crate::common::with_small_captures(&Setup::on_screen(EXTENT));
    for name in library::names() {
        let scene = crate::common::built_in(name);
        let mut stage = Stage::new(gpu, &scene).unwrap();
        for (_, view, roughness) in VIEWS.iter().filter(|(scene, ..)| scene == name) {
            let view = scene.view(view).unwrap();
            let globals = Globals { roughness: *roughness, ..Globals::default() };
            let mut sheet = Sheet::open(&format!("{name}-{}", view.name));
            let mut shared = SharedImages::default();
            for (number, method) in METHODS.iter().enumerate() {
                let camera = view.camera(&scene, EXTENT);
                let materials = globals.materials(&scene, view);
                let shot = shared.shot(&mut stage, method, &setup, Wants::IMAGE, camera, materials).unwrap();
                let (_, _, output) = shared.output_at_rest(&mut stage, &shot).unwrap();
                let image = display(&stage.context.read(output.composite.level(0)).unwrap());
                if is_updating() {
                    sheet.put(number, &image);
                } else {
                    let stem = format!("{name}-{}-{}", view.name, method.name);
                    failures.extend(compare(&stem, &sheet.get(number), &image));
                }
            }
            if is_updating() {
                sheet.image.save(&sheet.path).unwrap();
            }
        }
    }
    assert!(failures.is_empty(), "\n{}\n", failures.join("\n"));
}

/// Another preset, another filter of the colour chain, and no fade each differ from the usual image by over five times
/// the bound. A wider bound could hide such changes.
#[test]
fn a_changed_pass_is_seen() {
    if is_updating() {
        return;
    }
    let gpu = gpu();
    let scene = crate::common::built_in("rooms");
    let view = scene.view("corridor").unwrap();
    let mut stage = Stage::new(&gpu, &scene).unwrap();
    let materials = Globals { roughness: Some(0.3), ..Globals::default() }.materials(&scene, view);
    let mut draw = |setup: &Setup| {
        let shot = Shot::new(
            &mut stage,
            &METHODS[0],
            setup,
            Wants::REFLECTION,
            view.camera(&scene, EXTENT),
            materials.clone(),
        )
        .unwrap();
        display(&render(&mut stage, &shot, false).unwrap().composite)
    };
    let usual = Setup::on_screen(EXTENT);
    let usual_image = draw(&usual);
    for (change, setup) in [
        ("preset", usual.of_preset(Preset::Author)),
        ("filter", usual.with(|p: &mut ThesisDrawing| p.chain_filter = ChainFilter::Gaussian)),
        ("fade", unfaded(EXTENT)),
    ] {
        let mean = FlipMap::new(&usual_image.bytes, &draw(&setup).bytes, EXTENT[0], EXTENT[1]).mean();
        println!("{change}: FLIP {mean:.5}");
        assert!(mean > 5.0 * BOUND, "{change}: FLIP {mean}");
    }
}

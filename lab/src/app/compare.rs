//! `ssct compare`: two runs of the time study or two settings, two runs of the study of compiled programs, or two images.

use super::printed;
use crate::error::{Error, Result};
use crate::report::{compare as report, files, images, tables};
use crate::study::compare::{self, Run, Selection, THRESHOLD, TOTAL, TimeComparison};
use crate::study::shaders::{self, ShaderRecord};
use crate::study::timing::SAMPLES;
use clap::Args;
use ssct_scenes::inside::PathInFolder;
use ssct_truth::metrics::bootstrap::Verdict;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Options of `ssct compare`.
#[derive(Debug, Args)]
pub struct CompareOptions {
    /// Folder of times or of shaders, time-samples.csv, .png or .exr
    ///
    /// `ssct time` and `ssct study` write folders of times, `ssct shaders` one of compiled programs.
    #[arg(value_name = "A")]
    first: PathBuf,
    /// Second folder or image, to compare with the first
    ///
    /// Without it, --a and --b name two settings of the first.
    #[arg(value_name = "B")]
    second: Option<PathBuf>,
    /// Setting of the first run: "ssct --iterations 1024"
    ///
    /// A method and options tell a setting from the others of its run: "ssct", "ssct --iterations 1024" or "--view hall". A
    /// value that is not named may be anything as long as one setting fits; of several, the one with the values of its preset
    /// is meant. The settings are compared at every place where both were timed, and in one run turn by turn.
    #[arg(long, value_name = "METHOD OPTIONS", requires = "b", allow_hyphen_values = true)]
    a: Option<Selection>,
    /// Setting that is compared with that of --a
    ///
    /// It is one of the second run, or without one of the first.
    #[arg(long, value_name = "METHOD OPTIONS", requires = "a", allow_hyphen_values = true)]
    b: Option<Selection>,
    /// Change of a time that counts [default: 0.05]
    ///
    /// The number is a share of the time.
    #[arg(long, value_name = "T")]
    threshold: Option<f64>,
    /// Print each level of a chain and each part of a pass
    ///
    /// Without it, passes whose names begin alike, such as hi-z/1 to hi-z/8, are one row. The records have all of them.
    #[arg(long)]
    all: bool,
    /// Fail if a method's total is SLOWER
    #[arg(long)]
    fail_on_slower: bool,
    /// Folder for records, and error images
    ///
    /// Its files are compare.json and compare.txt, and for images also error.exr, error.png with error-scale.svg, and flip.png.
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Print the records as JSON, and nothing else
    #[arg(long)]
    json: bool,
}

impl CompareOptions {
    /// The second path, which two folders of shaders and two images need.
    fn second(&self) -> Result<&Path> {
        let missing = "compare takes two folders or images, A and B, or one folder of times with --a and --b";
        self.second.as_deref().ok_or_else(|| Error::usage(missing.into()))
    }

    /// Refuses options that only a comparison of times has; `what` names the compared things.
    fn refuse_options_of_times(&self, what: &str) -> Result<()> {
        let given = [
            ("--threshold", self.threshold.is_some()),
            ("--fail-on-slower", self.fail_on_slower),
            ("--all", self.all),
            ("--a and --b", self.a.is_some()),
        ];
        match given.into_iter().find(|(_, is_given)| *is_given) {
            Some((option, _)) => Err(Error::usage(format!("{option}: for times, not for {what}"))),
            None => Ok(()),
        }
    }
}

/// The file of records in a folder of `ssct shaders`.
const SHADERS: &str = "shaders.json";

/// The kind of records or image that a path holds.
#[derive(Clone, Copy, PartialEq)]
enum PathContent {
    Times,
    Shaders,
    Image,
}

/// Compares two runs or two images, and writes and prints the result.
pub fn run(options: &CompareOptions) -> anyhow::Result<()> {
    let content = path_content(&options.first)?;
    if let Some(second) = &options.second
        && path_content(second)? != content
    {
        let message = "compare takes two folders of times, two of shaders or two images, not one of each";
        return Err(Error::usage(message.into()).into());
    }
    match content {
        PathContent::Times => compare_times(options),
        PathContent::Shaders => compare_shaders(options),
        PathContent::Image => compare_images(options),
    }
}

/// Finds the kind of records or image that a path holds, by the files of a folder or by the ending of a file's name.
fn path_content(path: &Path) -> Result<PathContent> {
    let has_extension = |extension: &str| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension));
    if path.join(SHADERS).is_file() && !path.join(SAMPLES).is_file() {
        return Ok(PathContent::Shaders);
    }
    if path.is_dir() || has_extension("csv") {
        return Ok(PathContent::Times);
    }
    if has_extension("png") || has_extension("exr") {
        return Ok(PathContent::Image);
    }
    std::fs::metadata(path).map_err(|e| Error::io("read", path, e))?;
    Err(Error::usage(format!("{}: neither a folder of times, a .csv, a .png nor an .exr file", path.display())))
}

/// Compares the times of two runs or of two settings. With `--fail-on-slower`, a slower total is an error.
fn compare_times(options: &CompareOptions) -> anyhow::Result<()> {
    let threshold = options.threshold.unwrap_or(THRESHOLD);
    check_threshold(threshold)?;
    let records = match (&options.a, &options.b) {
        (Some(a), Some(b)) => compare_settings(options, [a, b], threshold)?,
        _ => compare_runs(options, threshold)?,
    };
    if let Some(folder) = &options.output {
        report::write_times(&PathInFolder::folder(folder), &records, options.all)?;
    }
    print_result(options, || files::json(&records), || report::times_text(&records, options.all))?;
    let slower = records.iter().filter(|r| r.pass == TOTAL && r.verdict == Some(Verdict::Slower)).count();
    if options.fail_on_slower && slower > 0 {
        anyhow::bail!("{slower} total(s) are slower");
    }
    Ok(())
}

/// Compares the passes that two runs have in common. If they have none, the error says how two settings could be
/// compared.
fn compare_runs(options: &CompareOptions, threshold: f64) -> anyhow::Result<Vec<TimeComparison>> {
    let (a, b) = (load(&options.first)?, load(options.second()?)?);
    let records = compare::times(&a, &b, threshold);
    if records.iter().all(|r| r.only_in.is_some()) {
        let differs = records.iter().find_map(|r| r.differs.as_ref()).map(|d| format!(": {d}")).unwrap_or_default();
        // `is_one_place`: both settings were timed on the same view, at the same size and roughness.
        let advice = |([setting_a, setting_b], is_one_place): ([String; 2], bool)| {
            let by_name = format!("ssct compare {} {} --a \"{setting_a}\" --b \"{setting_b}\"", a.name, b.name);
            let in_turns = if is_one_place {
                format!(
                    ", and better in turns of one run, ssct time --variant \"{setting_a}\" --variant \"{setting_b}\""
                )
            } else {
                String::new()
            };
            format!("; two settings are compared by their names, {by_name}{in_turns}")
        };
        let advice = compare::named_settings(&a, &b).map(advice).unwrap_or_default();
        anyhow::bail!("{} and {} have no pass in common{differs}{advice}", a.name, b.name);
    }
    Ok(records)
}

/// Compares two settings of one run or of two; a run that is named twice counts as one.
fn compare_settings(
    options: &CompareOptions,
    chosen: [&Selection; 2],
    threshold: f64,
) -> anyhow::Result<Vec<TimeComparison>> {
    let a = load(&options.first)?;
    let other = options.second.as_deref().filter(|second| **second != *options.first).map(load).transpose()?;
    compare::settings(&a, other.as_ref().unwrap_or(&a), chosen, threshold).map_err(anyhow::Error::msg)
}

/// Refuses a `--threshold` that is out of range.
pub fn check_threshold(threshold: f64) -> Result<()> {
    if !(0.0..1.0).contains(&threshold) {
        return Err(Error::usage(format!("--threshold {threshold}: must be at least 0 and below 1")));
    }
    Ok(())
}

/// Loads a run from its folder or its file of samples; the device is that of the `time.json` in the same folder.
fn load(path: &Path) -> Result<Run> {
    let name = path.display().to_string();
    if path.is_dir() {
        let folder = PathInFolder::folder(path);
        let device = files::read_device(&folder.join("time.json"))?;
        return Ok(Run { name, device, samples: files::read_samples(&folder.join(SAMPLES))? });
    }
    // A link that the user names is followed; its file is in a folder of its own.
    let file = path.canonicalize().map_err(|e| Error::io("read", path, e))?;
    let device = files::read_device(&PathInFolder::file(path.with_file_name("time.json")))?;
    Ok(Run { name, device, samples: files::read_samples(&PathInFolder::file(file))? })
}

/// Compares the compiled programs of two folders of `ssct shaders`, and writes and prints the result.
fn compare_shaders(options: &CompareOptions) -> anyhow::Result<()> {
    options.refuse_options_of_times("shaders")?;
    let paths = [&options.first, options.second()?];
    let read = |folder: &Path| -> Result<Vec<ShaderRecord>> {
        Ok(files::read_records(&PathInFolder::folder(folder).join(SHADERS))?)
    };
    let names = paths.map(|path| path.display().to_string());
    let (records_a, records_b) = (read(paths[0])?, read(paths[1])?);
    let (a, b) = ((&*names[0], &*records_a), (&*names[1], &*records_b));
    let text = || tables::text(&shaders::compare::tables(a, b));
    let json = || files::json(&shaders::compare::compare(a, b));
    if let Some(folder) = &options.output {
        report::write(&PathInFolder::folder(folder), &json(), &text())?;
    }
    print_result(options, json, text)
}

/// Compares two images, and writes and prints the result. Images of different sizes are an error.
fn compare_images(options: &CompareOptions) -> anyhow::Result<()> {
    options.refuse_options_of_times("images")?;
    let [(name_a, image_a), (name_b, image_b)] =
        [&options.first, options.second()?].map(|p| (p.display().to_string(), images::read_image(p)));
    let (image_a, image_b) = (&image_a?, &image_b?);
    let Some(comparison) = compare::images((&*name_a, image_a), (&*name_b, image_b)) else {
        let size = |image: &compare::LinearImage| format!("{}x{}", image.width, image.height);
        let (size_a, size_b) = (size(image_a), size(image_b));
        anyhow::bail!("images of one size are compared; {name_a} has {size_a} pixels, {name_b} has {size_b}");
    };
    if let Some(folder) = &options.output {
        report::write_images(&PathInFolder::folder(folder), &comparison)?;
    }
    print_result(options, || files::json(std::slice::from_ref(&comparison)), || report::images_text(&comparison))
}

/// Prints the result as JSON or as text, as `--json` says. Only the function of the form that is printed is called.
fn print_result(options: &CompareOptions, json: impl Fn() -> String, text: impl Fn() -> String) -> anyhow::Result<()> {
    let shown = if options.json { json() } else { text() };
    printed::out().write_all(shown.as_bytes())?;
    Ok(())
}

//! `ssct compare`: two runs of the time study, two of the study of compiled programs, or two images.

use super::printed;
use crate::error::{Error, Result};
use crate::inside::Inside;
use crate::metrics::bootstrap::Verdict;
use crate::report::{compare as report, files, images, tables};
use crate::study::compare::{self, Run, TOTAL};
use crate::study::shaders::{self, ShaderRecord};
use crate::study::timing::SAMPLES;
use clap::Args;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Change that counts, unless the flag says otherwise.
pub const THRESHOLD: f64 = 0.05;

/// Options of `ssct compare`.
#[derive(Debug, Args)]
pub struct CompareOptions {
    /// Folder of times or of shaders, time-samples.csv, .png or .exr
    ///
    /// `ssct time` and `ssct study` write folders of times, `ssct shaders` one of compiled programs.
    a: PathBuf,
    /// Second folder or image, to compare with the first
    b: PathBuf,
    /// Change of a time that counts [default: 0.05]
    ///
    /// The number is a share of the time.
    #[arg(long, value_name = "T")]
    threshold: Option<f64>,
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

/// The records of `ssct shaders` in its folder.
const SHADERS: &str = "shaders.json";

/// What a path holds.
#[derive(Clone, Copy, PartialEq)]
enum Sort {
    Times,
    Shaders,
    Image,
}

/// Compares, writes and prints.
pub fn run(options: &CompareOptions) -> anyhow::Result<()> {
    let (a, b) = (sort(&options.a)?, sort(&options.b)?);
    if a != b {
        let message = "compare takes two folders of times, two of shaders or two images, not one of each";
        return Err(Error::Usage(message.into()).into());
    }
    match a {
        Sort::Times => times(options),
        Sort::Shaders => compiled(options),
        Sort::Image => pictures(options),
    }
}

fn sort(path: &Path) -> Result<Sort> {
    let is = |extension: &str| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension));
    if path.join(SHADERS).is_file() && !path.join(SAMPLES).is_file() {
        return Ok(Sort::Shaders);
    }
    if path.is_dir() || is("csv") {
        return Ok(Sort::Times);
    }
    if is("png") || is("exr") {
        return Ok(Sort::Image);
    }
    std::fs::metadata(path).map_err(|e| Error::io("read", path, e))?;
    Err(Error::Usage(format!("{}: neither a folder of times, a .csv, a .png nor an .exr file", path.display())))
}

fn times(options: &CompareOptions) -> anyhow::Result<()> {
    let threshold = options.threshold.unwrap_or(THRESHOLD);
    check_threshold(threshold)?;
    let records = compare::times(&load(&options.a)?, &load(&options.b)?, threshold);
    if records.iter().all(|r| r.only_in.is_some()) {
        let differs = records.iter().find_map(|r| r.differs.as_ref()).map(|d| format!(": {d}")).unwrap_or_default();
        anyhow::bail!("{} and {} have no pass in common{differs}", options.a.display(), options.b.display());
    }
    if let Some(folder) = &options.output {
        report::write_times(&Inside::folder(folder), &records)?;
    }
    print(options, || files::json(&records), || report::times(&records))?;
    let slower = records.iter().filter(|r| r.pass == TOTAL && r.verdict == Some(Verdict::Slower)).count();
    if options.fail_on_slower && slower > 0 {
        anyhow::bail!("{slower} total(s) are slower");
    }
    Ok(())
}

/// Refuses a `--threshold` that is out of range.
pub fn check_threshold(threshold: f64) -> Result<()> {
    if !(0.0..1.0).contains(&threshold) {
        return Err(Error::Usage(format!("--threshold {threshold}: must be at least 0 and below 1")));
    }
    Ok(())
}

/// A run from its folder or its samples, with the device of the time.json beside them.
fn load(path: &Path) -> Result<Run> {
    let name = path.display().to_string();
    if path.is_dir() {
        let folder = Inside::folder(path);
        let device = files::read_device(&folder.join("time.json"))?;
        return Ok(Run { name, device, samples: files::read_samples(&folder.join(SAMPLES))? });
    }
    // A link that the user names is followed; its file is in a folder of its own.
    let file = path.canonicalize().map_err(|e| Error::io("read", path, e))?;
    let device = files::read_device(&Inside::file(path.with_file_name("time.json")))?;
    Ok(Run { name, device, samples: files::read_samples(&Inside::file(file))? })
}

fn compiled(options: &CompareOptions) -> anyhow::Result<()> {
    if options.threshold.is_some() || options.fail_on_slower {
        return Err(Error::Usage("--threshold and --fail-on-slower are for times, not for shaders".into()).into());
    }
    let read =
        |folder: &Path| -> Result<Vec<ShaderRecord>> { files::read_records(&Inside::folder(folder).join(SHADERS)) };
    let names = [&options.a, &options.b].map(|path| path.display().to_string());
    let (a, b) = (read(&options.a)?, read(&options.b)?);
    let (a, b) = ((&*names[0], &*a), (&*names[1], &*b));
    let text = || tables::text(&shaders::compare::tables(a, b));
    let json = || files::json(&shaders::compare::compare(a, b));
    if let Some(folder) = &options.output {
        report::write(&Inside::folder(folder), &json(), &text())?;
    }
    print(options, json, text)
}

fn pictures(options: &CompareOptions) -> anyhow::Result<()> {
    if options.threshold.is_some() || options.fail_on_slower {
        return Err(Error::Usage("--threshold and --fail-on-slower are for times, not for images".into()).into());
    }
    let [a, b] = [&options.a, &options.b].map(|p| (p.display().to_string(), images::read_image(p)));
    let (a, b) = ((&*a.0, &a.1?), (&*b.0, &b.1?));
    let Some(found) = compare::images(a, b) else {
        let size = |image: &compare::LinearImage| format!("{}x{}", image.width, image.height);
        let sizes = (size(a.1), size(b.1));
        anyhow::bail!("images of one size are compared; {} has {} pixels, {} has {}", a.0, sizes.0, b.0, sizes.1);
    };
    if let Some(folder) = &options.output {
        report::write_images(&Inside::folder(folder), &found)?;
    }
    print(options, || files::json(std::slice::from_ref(&found)), || report::images(&found))
}

fn print(options: &CompareOptions, json: impl Fn() -> String, text: impl Fn() -> String) -> anyhow::Result<()> {
    let said = if options.json { json() } else { text() };
    printed::out().write_all(said.as_bytes())?;
    Ok(())
}

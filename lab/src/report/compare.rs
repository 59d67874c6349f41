//! Comparisons as text and files.

use super::images::{Rgb, write_exr};
use super::legend::scale;
use super::{files, tables};
use crate::error::Result;
use crate::gpu::Pixels;
use crate::inside::Inside;
use crate::math::display_byte;
use crate::methods::{self, MethodInfo};
use crate::metrics::bootstrap::{MIN_SAMPLES, Verdict};
use crate::parameter::{Choices, Preset};
use crate::study::compare::{ImageComparison, Side, Subject, TOTAL, TimeComparison};
use crate::study::names::one_line;
use crate::study::record::differing;

/// Writes compare.json and compare.txt.
pub fn write(folder: &Inside, json: &str, text: &str) -> Result<()> {
    folder.join("compare.json").write(json.as_bytes())?;
    folder.join("compare.txt").write(text.as_bytes())
}

/// Writes a comparison of times as compare.json and compare.txt.
pub fn write_times(folder: &Inside, records: &[TimeComparison]) -> Result<()> {
    write(folder, &files::json(records), &times(records))
}

/// Writes compare.json, compare.txt, the RMSE of each pixel as error.exr and error.png (white is 1
/// or more, sRGB-encoded; magenta is no number) with its scale as error-scale.svg, and FLIP's map as flip.png.
pub fn write_images(folder: &Inside, found: &ImageComparison) -> Result<()> {
    write(folder, &files::json(std::slice::from_ref(found)), &images(found))?;
    let (width, height) = (found.width, found.height);
    let map = Pixels { width, height, channels: 1, values: found.rmse_map.clone() };
    write_exr(folder.join("error.exr"), &map, &["rmse"])?;
    let shade = |c: &[f32]| if c[0].is_nan() { [255, 0, 255] } else { [display_byte(c[0]); 3] };
    Rgb::from_pixels(&map, shade).write_png(folder.join("error.png"))?;
    let greatest = (found.greatest, &*number(f64::from(found.greatest)));
    let scale = scale("error.png", "root mean square error of a pixel, linear", greatest);
    folder.join("error-scale.svg").write(scale.as_bytes())?;
    Rgb { width, height, bytes: found.flip_picture.clone() }.write_png(folder.join("flip.png"))
}

/// What was compared and how, a row for each pass and total that both runs have, what one lacks, and
/// how many totals got which verdict.
pub fn times(records: &[TimeComparison]) -> String {
    let Some(first) = records.first() else { return String::new() };
    let device = |d: &Option<crate::gpu::DeviceInfo>| {
        let known = |d: &crate::gpu::DeviceInfo| format!("{}, {}, {}", d.name, d.kind, d.driver);
        one_line(&d.as_ref().map_or_else(|| "device not known".into(), known)).into_owned()
    };
    let mut text = format!("A  {} ({})\n", first.head.a, device(&first.device_a));
    text += &format!("B  {} ({})\n", first.head.b, device(&first.device_b));
    if let Some(warning) = &first.warning {
        text += &format!("warning: {warning}\n");
    }
    let how = &first.judgement;
    text += &format!(
        "Medians, B over A, with the {} % interval of {} bootstrap resamples, seed {}; SAME is within ±{} %.\n\
         The interval knows the spread within each run, not what changed on the machine between them.\n\n",
        how.confidence * 100.0,
        how.resamples,
        how.seed,
        percent(how.threshold)
    );
    text += &tables::aligned(&cells(records));
    let both = || records.iter().filter(|r| r.only_in.is_none());
    if both().any(|r| r.noise_floor.is_some()) {
        text += "\nNothing within its noise floor (how far a run strays from itself) is faster or slower.\n";
    }
    if both().any(|r| r.samples_a.min(r.samples_b) < MIN_SAMPLES) {
        text += &format!("\nFewer than {MIN_SAMPLES} samples decide nothing.\n");
    }
    for (side, name) in [(Side::A, "A"), (Side::B, "B")] {
        let only: Vec<_> = records.iter().filter(|r| r.only_in == Some(side)).collect();
        if !only.is_empty() {
            text += &format!("\nOnly in {name}:\n");
            for r in only {
                text += &format!("  {}\n", labels(r).join("  "));
                text.extend(
                    r.differs.iter().filter(|_| r.pass == TOTAL).map(|d| format!("    the other has it with {d}\n")),
                );
            }
        }
    }
    let totals = |v: Verdict| both().filter(|r| r.pass == TOTAL && r.verdict == Some(v)).count();
    let counts: Vec<_> = Verdict::ALL.iter().map(|v| format!("{} {}", totals(*v), v.name())).collect();
    text + &format!("\nTotals: {}\n", counts.join(", "))
}

/// A share as a percentage without the noise of binary fractions.
fn percent(share: f64) -> f64 {
    (share * 1e6).round() / 1e4
}

fn labels(r: &TimeComparison) -> [String; 7] {
    let [place, size, roughness, normals, method, preset] = subject_labels(&r.subject);
    [place, size, roughness, normals, method, preset, r.pass.clone()]
}

/// The names of the columns of [`subject_labels`].
pub const SUBJECT_COLUMNS: [&str; 6] = ["scene view", "size", "roughness", "normals", "method", "preset"];

/// What was timed, in a few words a column.
pub fn subject_labels(s: &Subject) -> [String; 6] {
    let own = |name: &str| match s.get(name) {
        "" => "own".to_owned(),
        value => value.to_owned(),
    };
    let place = format!("{} {}", s.get("scene"), s.get("view"));
    let size = format!("{}x{}", s.get("width"), s.get("height"));
    [place, size, own("roughness"), own("normal_deviation"), method(s), s.get("preset").to_owned()]
}

/// A method with the parameters that are not those of its preset.
fn method(s: &Subject) -> String {
    let name = s.get("method");
    let preset = Preset::of_name(s.get("preset")).unwrap_or_default();
    let rows = methods::find(name).map_or_else(|_| Vec::new(), MethodInfo::reads);
    let values: Vec<_> = rows.iter().filter_map(|row| differing(row, preset, s.get(row.name))).collect();
    if values.is_empty() { name.to_owned() } else { format!("{name} ({})", values.join(", ")) }
}

fn cells(records: &[TimeComparison]) -> Vec<Vec<String>> {
    let figures = ["pass", "A ms", "B ms", "B/A", "low", "high", "floor", "n", "verdict"];
    let mut rows = vec![[&SUBJECT_COLUMNS[..], &figures].concat().into_iter().map(str::to_owned).collect::<Vec<_>>()];
    let number = |v: Option<f64>| v.map_or_else(|| "-".into(), |v| format!("{v:.3}"));
    for r in records.iter().filter(|r| r.only_in.is_none()) {
        let mut row = labels(r).to_vec();
        row.extend([r.median_a_ms, r.median_b_ms, r.ratio, r.low, r.high].map(number));
        row.push(r.noise_floor.map_or_else(|| "-".into(), |floor| format!("{:.1} %", floor * 100.0)));
        row.push(format!("{}/{}", r.samples_a, r.samples_b));
        row.push(r.verdict.map_or("-", Verdict::name).to_owned());
        rows.push(row);
    }
    rows
}

/// A difference with six digits behind the point; one of 0 is named, and a lesser one is not shown as 0.
fn number(value: f64) -> String {
    match value {
        0.0 => "identical".to_owned(),
        v if v.abs() < 1e-6 => format!("{v:.1e}"),
        v => format!("{v:.6}"),
    }
}

/// The figures of two images.
pub fn images(found: &ImageComparison) -> String {
    let [x, y] = found.greatest_at;
    let mut rows = vec![
        ["RMSE, linear".to_owned(), number(found.rmse)],
        ["greatest RMSE of a pixel".to_owned(), number(f64::from(found.greatest))],
        ["relative MSE, linear".to_owned(), found.rel_mse.map_or_else(|| "- (A is black)".into(), number)],
        ["FLIP mean, display".to_owned(), number(found.flip)],
    ];
    if found.greatest > 0.0 {
        rows.insert(2, ["where that pixel is".to_owned(), format!("{x}, {y}")]);
    }
    let rows: Vec<_> = rows.into_iter().map(Vec::from).collect();
    let size = format!("{}x{}", found.width, found.height);
    format!("A  {} (the reference), {size}\nB  {}\n\n", found.head.a, found.head.b) + &tables::aligned(&rows)
}

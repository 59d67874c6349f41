//! Writes comparisons of runs and of images as text and files.

use super::images::{Rgb, write_exr};
use super::legend::scale;
use super::{files, tables};
use crate::study::compare::{self, ImageComparison, Side, TOTAL, TimeComparison};
use crate::study::names::one_line;
use ssct::gpu::{DeviceInfo, Pixels};
use ssct_ground::Result;
use ssct_ground::math::display_byte;
use ssct_scenes::inside::PathInFolder;
use ssct_truth::metrics::bootstrap::{MIN_SAMPLES, Verdict};

/// Writes the records of a comparison as compare.json, and its text as compare.txt.
pub fn write(folder: &PathInFolder, json: &str, text: &str) -> Result<()> {
    folder.join("compare.json").write(json.as_bytes())?;
    folder.join("compare.txt").write(text.as_bytes())
}

/// Writes a comparison of times as compare.json and compare.txt. With `all`, the text has rows for the parts of groups.
pub fn write_times(folder: &PathInFolder, records: &[TimeComparison], all: bool) -> Result<()> {
    write(folder, &files::json(records), &times_text(records, all))
}

/// Writes compare.json, compare.txt, the RMSE of each pixel as error.exr and error.png (white is 1
/// or more, sRGB-encoded; magenta is NaN) with its scale as error-scale.svg, and FLIP's map as flip.png.
pub fn write_images(folder: &PathInFolder, comparison: &ImageComparison) -> Result<()> {
    write(folder, &files::json(std::slice::from_ref(comparison)), &images_text(comparison))?;
    let (width, height) = (comparison.width, comparison.height);
    let map = Pixels { width, height, channels: 1, values: comparison.rmse_map.clone() };
    write_exr(folder.join("error.exr"), &map, &["rmse"])?;
    let shade = |c: &[f32]| if c[0].is_nan() { [255, 0, 255] } else { [display_byte(c[0]); 3] };
    Rgb::from_pixels(&map, shade).write_png(folder.join("error.png"))?;
    let greatest = (comparison.greatest, &*difference_text(f64::from(comparison.greatest)));
    let scale = scale("error.png", "root mean square error of a pixel, linear", greatest);
    folder.join("error-scale.svg").write(scale.as_bytes())?;
    Rgb { width, height, bytes: comparison.flip_picture.clone() }.write_png(folder.join("flip.png"))
}

/// The text of a comparison: both runs, the rules, a row for each pass and total that both runs have, the passes of one run alone, and how
/// many totals got each verdict. With `all`, the parts of groups have rows, too.
pub fn times_text(records: &[TimeComparison], all: bool) -> String {
    let Some(first) = records.first() else { return String::new() };
    let mut text = sides(first);
    if let Some(warning) = &first.warning {
        text += &format!("warning: {warning}\n");
    }
    text += &interval_method_text(first);
    text += &tables::aligned(&compare::cells(records, all));
    // The records of passes and totals that both runs have.
    let in_both = || records.iter().filter(|r| r.only_in.is_none());
    if in_both().any(|r| r.noise_floor.is_some()) {
        text += "\nNothing within its noise floor (how far a run strays from itself) is faster or slower.\n";
    }
    if in_both().any(|r| r.drift.is_some()) {
        text += "\nDrift: how much longer the scene passes took in B. They are the same work on both sides: the machine changed by as much.\n";
    }
    // The scene passes of both sides give a drift wherever they are known to do the same work.
    if in_both().any(|r| !r.counted && r.drift.is_none()) {
        text += "\nDrift: none where the scene passes are not known to be the same work on both sides.\n";
    }
    if in_both().any(|r| r.samples_a.min(r.samples_b) < MIN_SAMPLES) {
        text += &format!("\nFewer than {MIN_SAMPLES} samples decide nothing.\n");
    }
    text.extend(compare::note_on_own(records).map(|note| format!("\n{note}\n")));
    text += &only_in_one(records, all);
    let count = |verdict| in_both().filter(|r| r.pass == TOTAL && r.verdict == Some(verdict)).count();
    let counts: Vec<_> = Verdict::ALL.iter().map(|verdict| format!("{} {}", count(*verdict), verdict.name())).collect();
    text + &format!("\nTotals: {}\n", counts.join(", "))
}

/// Returns two lines of text: the name of each of the two runs, A and B, with its device. `first` is any record of
/// them.
fn sides(first: &TimeComparison) -> String {
    let device = |d: &Option<DeviceInfo>| {
        let known = |d: &DeviceInfo| format!("{}, {}, {}", d.name, d.kind, d.driver);
        one_line(&d.as_ref().map_or_else(|| "device not known".into(), known)).into_owned()
    };
    let a = format!("A  {} ({})\n", first.head.a, device(&first.device_a));
    a + &format!("B  {} ({})\n", first.head.b, device(&first.device_b))
}

/// Returns the text that says how the intervals were found, and what the verdicts mean.
fn interval_method_text(first: &TimeComparison) -> String {
    let rules = &first.judgement;
    let (share, resamples, seed) = (rules.confidence * 100.0, rules.resamples, rules.seed);
    let intervals = if first.paired {
        format!(
            "A and B were timed in turn: the medians over the turns of B over A, with the {share} % interval of {resamples} \
             bootstrap resamples of the turns, seed {seed}."
        )
    } else {
        format!(
            "Medians, B over A, with the {share} % interval of {resamples} bootstrap resamples, seed {seed}.\n\
             The interval knows the spread within each side, not what changed on the machine between them."
        )
    };
    let bound = percent(rules.threshold);
    format!(
        "{intervals}\nSAME: the interval lies within ±{bound} %. FASTER, SLOWER: it lies beyond ±{bound} %, and beyond the noise floor \
         where one was measured.\nUNDECIDED: neither; about as many samples as stand behind it may decide.\nn: samples of A and of B.\n\n"
    )
}

/// Returns the list of passes that only one run has. With `all`, the parts of groups are listed, too.
fn only_in_one(records: &[TimeComparison], all: bool) -> String {
    let mut text = String::new();
    for (side, name) in [(Side::A, "A"), (Side::B, "B")] {
        let is_shown = |r: &&TimeComparison| r.only_in == Some(side) && (all || r.part_of.is_none());
        let only: Vec<_> = records.iter().filter(is_shown).collect();
        if !only.is_empty() {
            text += &format!("\nOnly in {name}:\n");
            for r in only {
                text += &format!("  {}\n", r.labels().join("  "));
                let differs = r.differs.iter().filter(|_| r.pass == TOTAL);
                text.extend(differs.map(|d| format!("    the other has it with {d}\n")));
            }
        }
    }
    text
}

/// Returns a share as a percentage, rounded to four digits behind the point, since 0.07 · 100 is not exactly 7.
fn percent(share: f64) -> f64 {
    (share * 1e6).round() / 1e4
}

/// Returns the text of a difference, with six digits behind the point. A difference of 0 is called identical, and one
/// below 0.000001 is written with an exponent.
fn difference_text(value: f64) -> String {
    match value {
        0.0 => "identical".to_owned(),
        v if v.abs() < 1e-6 => format!("{v:.1e}"),
        v => format!("{v:.6}"),
    }
}

/// Returns the figures of a comparison of two images as text.
pub fn images_text(comparison: &ImageComparison) -> String {
    let [x, y] = comparison.greatest_at;
    let relative_mse = comparison.rel_mse.map_or_else(|| "- (A is black)".to_owned(), difference_text);
    let mut rows = vec![
        ["RMSE, linear".to_owned(), difference_text(comparison.rmse)],
        ["greatest RMSE of a pixel".to_owned(), difference_text(f64::from(comparison.greatest))],
        ["relative MSE, linear".to_owned(), relative_mse],
        ["FLIP mean, display".to_owned(), difference_text(comparison.flip)],
    ];
    if comparison.greatest > 0.0 {
        rows.insert(2, ["where that pixel is".to_owned(), format!("{x}, {y}")]);
    }
    let rows: Vec<_> = rows.into_iter().map(Vec::from).collect();
    let size = format!("{}x{}", comparison.width, comparison.height);
    format!("A  {} (the reference), {size}\nB  {}\n\n", comparison.head.a, comparison.head.b) + &tables::aligned(&rows)
}

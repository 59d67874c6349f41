//! The stress study as files and text: records, a table of method × failure, a page.

use super::{files, html, tables};
use crate::error::Result;
use crate::metrics::percentile;
use crate::study::stress::motion::{Motion, MotionRecord};
use crate::study::stress::{AGREEMENT, COMPARED_PIXELS, JUDGED, StressRecord};
use std::path::Path;

/// Writes stress.json, motion.json, stress.txt and index.html.
pub fn write(folder: &Path, records: &[StressRecord], motions: &[MotionRecord], command: &str) -> Result<()> {
    files::write(&folder.join("stress.json"), files::json(records).as_bytes())?;
    files::write(&folder.join("motion.json"), files::json(motions).as_bytes())?;
    files::write(&folder.join("stress.txt"), text(records, motions).as_bytes())?;
    files::write(&folder.join("index.html"), page(records, motions, command).as_bytes())
}

/// The tables for a terminal.
pub fn text(records: &[StressRecord], motions: &[MotionRecord]) -> String {
    let mut text = tables::aligned(&methods(records));
    let failures = failures(records);
    if failures.len() > 1 {
        text += &format!("\nCases that are not passed and must be:\n{}", tables::aligned(&failures));
    }
    if !motions.is_empty() {
        text += &format!("\n{}", motion_text(motions));
    }
    text
}

/// The tables of motions for a terminal.
pub fn motion_text(motions: &[MotionRecord]) -> String {
    let against_screen = motion(motions, |r| r.ratio.zip(r.deviation));
    let mut text = format!("Flicker over the screen reference's own:\n{}", tables::aligned(&against_screen));
    if motions.iter().any(|r| r.world.is_some()) {
        let against_world = motion(motions, |r| r.world.and_then(|w| w.ratio.zip(w.deviation)));
        text += &format!("\nFlicker over the world reference's own:\n{}", tables::aligned(&against_world));
    }
    text
}

/// Methods × motions and roughness: the median over the views of the flicker over the reference's own, and how far it is
/// off the reference's (0 for the truth, 1 for a method that shows nothing).
pub fn motion(records: &[MotionRecord], of: impl Fn(&MotionRecord) -> Option<(f64, f64)>) -> Vec<Vec<String>> {
    let mut columns: Vec<(Motion, f32)> = Vec::new();
    let mut methods: Vec<String> = Vec::new();
    for r in records {
        if !columns.contains(&(r.motion, r.roughness)) {
            columns.push((r.motion, r.roughness));
        }
        if !methods.contains(&r.variant()) {
            methods.push(r.variant());
        }
    }
    let title = |(motion, roughness): &(Motion, f32)| format!("{} {roughness}", motion.name());
    let mut rows = vec![std::iter::once("method".to_owned()).chain(columns.iter().map(title)).collect::<Vec<_>>()];
    for method in methods {
        let mut row = vec![method.clone()];
        row.extend(columns.iter().map(|(motion, roughness)| {
            let here =
                records.iter().filter(|r| r.variant() == method && r.motion == *motion && r.roughness == *roughness);
            let (ratios, deviations): (Vec<f64>, Vec<f64>) = here.filter_map(&of).unzip();
            let median = |mut values: Vec<f64>| {
                values.sort_by(f64::total_cmp);
                percentile(&values, 0.5)
            };
            let both = median(ratios).zip(median(deviations));
            both.map_or("-".into(), |(ratio, deviation)| format!("{ratio:.2} off {deviation:.2}"))
        }));
        rows.push(row);
    }
    rows
}

/// A table of method × failure: the number of cases with such pixels, and the pixels over all of them.
pub fn methods(records: &[StressRecord]) -> Vec<Vec<String>> {
    let header = ["method", "cases", "pass", "NaN", "infinite", "negative", "exhausted", "agreement %", "least %"];
    let mut rows = vec![header.map(str::to_owned).to_vec()];
    let mut names: Vec<&str> = Vec::new();
    for r in records {
        if !names.contains(&r.method.as_str()) {
            names.push(&r.method);
        }
    }
    for name in names {
        let here: Vec<&StressRecord> = records.iter().filter(|r| r.method == name).collect();
        let counted = |of: fn(&StressRecord) -> usize| {
            let cases = here.iter().filter(|r| of(r) > 0).count();
            if cases == 0 { "0".into() } else { format!("{} px in {cases}", here.iter().map(|r| of(r)).sum::<usize>()) }
        };
        let exhausted =
            if here.iter().any(|r| r.exhausted.is_some()) { counted(|r| r.exhausted.unwrap_or(0)) } else { "-".into() };
        let agreements: Vec<(usize, f64)> = here.iter().filter_map(|r| r.compared.zip(r.hit_agreement)).collect();
        let (pixels, agreeing) = agreements.iter().fold((0, 0.0), |(n, a), (k, h)| (n + k, a + *k as f64 * h));
        let percent = |v: f64| format!("{:.3}", 100.0 * v);
        let least = agreements.iter().map(|(_, h)| *h).reduce(f64::min);
        rows.push(vec![
            name.to_owned(),
            here.len().to_string(),
            here.iter().filter(|r| r.pass).count().to_string(),
            counted(|r| r.nan),
            counted(|r| r.inf),
            counted(|r| r.negative),
            exhausted,
            if pixels > 0 { percent(agreeing / pixels as f64) } else { "-".into() },
            least.map_or("-".into(), percent),
        ]);
    }
    rows
}

/// What must pass and does not, a row each.
pub fn failures(records: &[StressRecord]) -> Vec<Vec<String>> {
    let header = ["method", "case", "size", "NaN", "infinite", "negative", "exhausted", "agreement %", "ties", "ms"];
    let mut rows = vec![header.map(str::to_owned).to_vec()];
    for r in records.iter().filter(|r| r.judged && !r.pass) {
        let or_dash = |v: Option<usize>| v.map_or("-".into(), |v| v.to_string());
        rows.push(vec![
            r.method.clone(),
            r.case.clone(),
            format!("{}x{}", r.width, r.height),
            r.nan.to_string(),
            r.inf.to_string(),
            r.negative.to_string(),
            or_dash(r.exhausted),
            r.hit_agreement.map_or("-".into(), |h| format!("{:.3}", 100.0 * h)),
            or_dash(r.ties),
            format!("{:.1}", r.time_ms),
        ]);
    }
    rows
}

/// Cases × methods: what was wrong in each.
fn cases(records: &[StressRecord]) -> Vec<Vec<String>> {
    let mut names: Vec<&str> = Vec::new();
    let mut methods: Vec<&str> = Vec::new();
    for r in records {
        if !names.contains(&r.case.as_str()) {
            names.push(&r.case);
        }
        if !methods.contains(&r.method.as_str()) {
            methods.push(&r.method);
        }
    }
    let mut rows = vec![std::iter::once("case".to_owned()).chain(methods.iter().map(|m| (*m).to_owned())).collect()];
    for name in names {
        let mut row = vec![name.to_owned()];
        row.extend(
            methods.iter().map(|method| {
                records.iter().find(|r| r.case == name && r.method == *method).map_or("-".into(), summary)
            }),
        );
        rows.push(row);
    }
    rows
}

/// What was wrong with one record, in a few words.
fn summary(r: &StressRecord) -> String {
    let share = |n: usize| format!("{:.2} %", 100.0 * n as f64 / r.pixels.max(1) as f64);
    let mut words: Vec<String> =
        [("NaN", r.nan), ("inf", r.inf), ("neg", r.negative), ("exh", r.exhausted.unwrap_or(0))]
            .into_iter()
            .filter(|(_, n)| *n > 0)
            .map(|(what, n)| format!("{what} {}", share(n)))
            .collect();
    words.extend(r.hit_agreement.map(|h| format!("{:.2} %", 100.0 * h)));
    if words.is_empty() { "sound".into() } else { words.join(", ") }
}

const MOTION_RULE: &str = "Mean absolute change of the reflection from frame to frame, each pixel beside the same \
    surface a frame before, over the screen reference's own on the same frames: the median over the views. Columns name \
    the camera's motion and the roughness; 1 is as still as the truth. Behind it, how far the change itself is off the \
    reference's, in the same unit: 0 is the truth, 1 shows nothing.";

const CASES_RULE: &str = "What each method made of it: the share of the compared hits that are the oracle's, before it \
    the shares of the image's pixels that are NaN, infinite (inf), negative (neg) or of exhausted rays (exh). Where no hits \
    are compared and no such pixel is, it is sound.";

fn page(records: &[StressRecord], motions: &[MotionRecord], command: &str) -> String {
    let rule = format!(
        "Pixels are counted on the host's bits, in the reflection and, where the lit colour is sound, in the image. Hits \
         are compared with oracle 1 where rays are defined, in {COMPARED_PIXELS} reflecting pixels drawn at random where \
         there are more. {JUDGED} passes a case with no such pixel and {} % of the hits \
         (disagreements that vanish when the ray's direction, its first depth or where it crosses the sides of pixels \
         changes by up to 16 units in the last place of an f32 are ties; each corner that it then passes is a choice of \
         its own); so do the methods that follow rays in captures, where captures stand in hard places; the published methods need only survive, and their counts are findings.",
        100.0 * AGREEMENT
    );
    html::tables_page(
        "Numerical stress",
        records.first().map(|r| &r.program.device),
        command,
        &[
            ("Method × failure", &rule, &methods(records)),
            (
                "Violations",
                "Cases that are not passed and must be. A frame that takes seconds counts as runaway, and does not pass either.",
                &failures(records),
            ),
            ("Stability in motion", MOTION_RULE, &motion(motions, |r| r.ratio.zip(r.deviation))),
            ("Every case", CASES_RULE, &cases(records)),
        ],
    )
}

//! Numbers of `cargo bench --bench claims`: counts, images on both sides of a change, and times of variants.

use super::figures::{Result, Row, csv, greatest, json, least, mean, median, median_and_range, number, percent, ratio};
use super::{against_world, claims, own_rays, stress};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

/// The answer to a query about what `cargo bench --bench claims` measured, or about single cases of stress.
pub fn show(query: &str, folder: &Path) -> Result<String> {
    let words: Vec<&str> = query.split(' ').collect();
    match words[..] {
        ["count", claim, method, variant, height] => count(folder, [claim, method, variant, height]),
        ["share", claim, method, variant, height] => share(folder, [claim, method, variant, height]),
        ["share-in", claim, view] => share_in(folder, claim, view),
        ["growth", method, height, from] => growth(folder, [method, height, from]),
        ["judged-change", claim, roughness] => change(folder, claim, roughness),
        ["judged-error", claim, roughness] => error(folder, claim, roughness),
        ["judged-mean", claim, roughness, field] => judged_mean(folder, [claim, roughness, field]),
        ["judged-median", claim, roughness, field] => judged_median(folder, [claim, roughness, field]),
        ["timed", claim, method, variant] => timed(folder, [claim, method, variant, "ratio"]),
        ["timed-scene", claim, method, variant] => timed(folder, [claim, method, variant, "scene_ratio"]),
        ["ordered", claim, method, roughness, variant] => ordered(folder, [claim, method, roughness, variant]),
        ["ordered-in", claim, method, variant, view] => {
            ordered_in(folder, [claim, method, variant, view]).map(|share| format!("{share:.2}"))
        }
        ["wider", method, other, view] => wider(folder, [method, other, view]),
        ["popped", method, variant, scene] => popped(folder, [method, variant, scene]),
        ["total-over", method, other, file] => total_over(folder, file, [method, other]),
        ["queries-over-tree", file, roughness] => setup_over(folder, [file, roughness], ["tracer", "query", "tree"]),
        ["against-world", stage] => against_world::methods(folder, stage),
        ["time-over", method, roughness] => against_world::time_over(folder, method, roughness),
        ["beaten", method] => against_world::beaten(folder, method),
        ["scenes-of", method] => against_world::errors_of(folder, method),
        ["own-times"] => own_rays::times(folder),
        ["own-cost", roughness] => {
            let ratios = ["rooms", "corridor", "atrium", "street"]
                .map(|scene| setup_ratio(folder, [&format!("time-{scene}"), roughness], ["own_rays", "4", "none"]));
            let ratios: Vec<f64> = ratios.into_iter().collect::<Result<_>>()?;
            Ok(format!("{} to {}", ratio(least(&ratios)), ratio(greatest(&ratios))))
        }
        ["rays-a-second", walk] => {
            median(&column(&csv(folder, "embree.csv")?, walk)?).map(|rays| format!("{:.2} million", rays / 1e6))
        }
        ["walk-over", walk, other] => {
            let rounds = csv(folder, "embree.csv")?;
            median(&claims::ratios(&column(&rounds, walk)?, &column(&rounds, other)?)?).map(ratio)
        }
        ["history-price", program, camera, roughness] => history_price(folder, [program, camera, roughness]),
        ["effect-over", program, other, roughness] => {
            least_over(folder, ["times.csv", "least_ms"], [program, other], roughness)
        }
        ["rmse-over", program, other, roughness] => {
            least_over(folder, ["errors.csv", "rmse"], [program, other], roughness)
        }
        ["change-over", program, other, roughness] => {
            least_over(folder, ["motion.csv", "deviation"], [program, other], roughness)
        }
        ["own-errors"] => own_rays::errors(folder),
        ["own-on-screen", own, figure] => own_rays::on_screen(folder, own, figure),
        ["pass-share", method, passes, file] => pass_share(folder, file, [method, passes]),
        ["stress-passed", method] => stress::passed(folder, method),
        ["stress-most-wrong", method] => stress::most_wrong(folder, method),
        ["stress-case", method, case] => stress::case(folder, method, case),
        _ => Err(format!("nothing is called {query:?}")),
    }
}

/// Rows of a file in which some fields have some values.
fn rows(folder: &Path, file: &str, fields: &[(&str, &str)]) -> Result<Vec<Row>> {
    let is_own = |row: &Row| fields.iter().all(|(field, value)| row[*field] == **value);
    let own: Vec<_> = csv(folder, file)?.into_iter().filter(is_own).collect();
    if own.is_empty() { Err(format!("{file} has no row of {fields:?}")) } else { Ok(own) }
}

fn column(rows: &[Row], field: &str) -> Result<Vec<f64>> {
    rows.iter().map(|r| number(r, field)).collect()
}

fn counted(folder: &Path, [claim, method, variant, height]: [&str; 4]) -> Result<Vec<f64>> {
    let fields = [("claim", claim), ("method", method), ("variant", variant), ("size", height)];
    column(&rows(folder, "counts.csv", &fields)?, "value")
}

/// A count: mean over the views.
fn count(folder: &Path, key: [&str; 4]) -> Result<String> {
    mean(&counted(folder, key)?).map(|n| format!("{n:.1}"))
}

/// A share: mean over the views.
fn share(folder: &Path, key: [&str; 4]) -> Result<String> {
    mean(&counted(folder, key)?).map(|n| percent(n, 0))
}

/// A share on one view.
fn share_in(folder: &Path, claim: &str, view: &str) -> Result<String> {
    let rows = rows(folder, "counts.csv", &[("claim", claim), ("view", view)])?;
    mean(&column(&rows, "value")?).map(|n| percent(n, 0))
}

/// A count over the same one of another height: the least and the greatest of the views.
fn growth(folder: &Path, [method, height, from]: [&str; 3]) -> Result<String> {
    let counts = |height| counted(folder, ["ray-steps", method, "1", height]);
    let ratios: Vec<_> = counts(height)?.iter().zip(counts(from)?).map(|(a, b)| a / b).collect();
    Ok(format!("{} to {}", ratio(least(&ratios)), ratio(greatest(&ratios))))
}

fn judged(folder: &Path, claim: &str, roughness: &str) -> Result<Vec<Row>> {
    rows(folder, "judged.csv", &[("claim", claim), ("roughness", roughness)])
}

/// What a change does to the image: the share of pixels and the difference, median and greatest over the views.
fn change(folder: &Path, claim: &str, roughness: &str) -> Result<String> {
    let own = judged(folder, claim, roughness)?;
    let (shares, errors) = (column(&own, "share")?, column(&own, "rmse")?);
    let shares = [median(&shares)?, greatest(&shares)].map(|share| percent(share, 2));
    let errors = [median(&errors)?, greatest(&errors)].map(|error| format!("{error:.4}"));
    Ok(format!("{} of pixels; RMSE {}", shares.join(", "), errors.join(", ")))
}

/// The error with a change over that without, both against the reference: median over the views.
fn error(folder: &Path, claim: &str, roughness: &str) -> Result<String> {
    let own = judged(folder, claim, roughness)?;
    let ratios: Vec<_> =
        column(&own, "error_changed")?.iter().zip(column(&own, "error")?).map(|(a, b)| a / b).collect();
    median(&ratios).map(ratio)
}

/// A column of the judged images, mean over the views: a share, or an error.
fn judged_mean(folder: &Path, [claim, roughness, field]: [&str; 3]) -> Result<String> {
    let mean = mean(&column(&judged(folder, claim, roughness)?, field)?)?;
    Ok(if field.starts_with("error") { format!("{mean:.3}") } else { percent(mean, 1) })
}

/// An error of the judged images: median over the views.
fn judged_median(folder: &Path, [claim, roughness, field]: [&str; 3]) -> Result<String> {
    median(&column(&judged(folder, claim, roughness)?, field)?).map(|error| format!("{error:.3}"))
}

/// The time of a variant over that of the first one: the median of the views, and the least and the greatest of them.
fn timed(folder: &Path, [claim, method, variant, field]: [&str; 4]) -> Result<String> {
    let fields = [("claim", claim), ("method", method), ("variant", variant)];
    let ratios = column(&rows(folder, "times.csv", &fields)?, field)?;
    Ok(format!("{} ({} to {})", ratio(median(&ratios)?), ratio(least(&ratios)), ratio(greatest(&ratios))))
}

/// The time of the pass that traces, with its rays in another order, over that in the order of pixels: the median of the
/// views, and the least and the greatest of them.
fn ordered(folder: &Path, [claim, method, roughness, variant]: [&str; 4]) -> Result<String> {
    let fields = [("claim", claim), ("method", method), ("roughness", roughness), ("variant", variant)];
    let ratios = column(&rows(folder, "rays.csv", &fields)?, "ratio")?;
    Ok(format!("{} ({} to {})", ratio(median(&ratios)?), ratio(least(&ratios)), ratio(greatest(&ratios))))
}

/// A ratio of mirrors in one view.
fn ordered_in(folder: &Path, [claim, method, variant, view]: [&str; 4]) -> Result<f64> {
    let fields = [("claim", claim), ("method", method), ("variant", variant), ("view", view), ("roughness", "0")];
    mean(&column(&rows(folder, "rays.csv", &fields)?, "ratio")?)
}

/// What groups of 32 rays in place of 8 make of a method's time over another's, by the steps for which groups run.
fn wider(folder: &Path, [method, other, view]: [&str; 3]) -> Result<String> {
    let longer = |method: &str| {
        let share = |variant| ordered_in(folder, ["in-step", method, variant, view]);
        Ok::<_, String>(share("8")? / share("32")?)
    };
    Ok(ratio(longer(other)? / longer(method)?))
}

/// The greatest change from one frame of a walk to the next, over the median one.
fn popped(folder: &Path, [method, variant, scene]: [&str; 3]) -> Result<String> {
    let fields = [("method", method), ("variant", variant), ("scene", scene)];
    mean(&column(&rows(folder, "popping.csv", &fields)?, "value")?).map(|n| format!("{n:.1}"))
}

/// The record of a method's times.
fn times_of(folder: &Path, file: &str, method: &str) -> Result<Value> {
    let records = json(folder, &format!("{file}.json"))?;
    records.into_iter().find(|r| r["method"] == method).ok_or_else(|| format!("{file}.json has no {method}"))
}

fn milliseconds(timing: &Value) -> Result<f64> {
    timing["median_ms"].as_f64().ok_or_else(|| "no median".to_owned())
}

/// The time of a method over another's.
fn total_over(folder: &Path, file: &str, [method, other]: [&str; 2]) -> Result<String> {
    let total = |method| milliseconds(&times_of(folder, file, method)?["total"]);
    Ok(ratio(total(method)? / total(other)?))
}

/// The time of a method with one value of a parameter over that with another at a roughness, of a file that has both.
fn setup_ratio(folder: &Path, [file, roughness]: [&str; 2], [field, value, other]: [&str; 3]) -> Result<f64> {
    let wanted: f64 = roughness.parse().map_err(|_| format!("{roughness} is no number"))?;
    let records = json(folder, &format!("{file}.json"))?;
    let is_it = |r: &&Value, value| {
        r["setup"][field] == value && r["roughness"].as_f64().is_some_and(|r| (r - wanted).abs() < 1e-6)
    };
    let total = |value| {
        let record = records.iter().find(|r| is_it(r, value));
        milliseconds(&record.ok_or_else(|| format!("{file}.json has no {field} {value} at {roughness}"))?["total"])
    };
    Ok(total(value)? / total(other)?)
}

fn setup_over(folder: &Path, place: [&str; 2], values: [&str; 3]) -> Result<String> {
    setup_ratio(folder, place, values).map(ratio)
}

/// The share of a method's time that passes take whose names begin alike.
fn pass_share(folder: &Path, file: &str, [method, passes]: [&str; 2]) -> Result<String> {
    let record = times_of(folder, file, method)?;
    let all = record["passes"].as_array().ok_or("no passes")?;
    let own = all.iter().filter(|p| p["name"].as_str().is_some_and(|name| name.starts_with(passes)));
    let sum = own.map(milliseconds).sum::<Result<f64>>()?;
    Ok(percent(sum / milliseconds(&record["total"])?, 0))
}

/// The least number of a column by one program over that by another, on the views that both measured: median, least, greatest.
fn least_over(folder: &Path, [file, column]: [&str; 2], programs: [&str; 2], roughness: &str) -> Result<String> {
    let numbers = |program: &str| -> Result<BTreeMap<String, f64>> {
        let mut numbers = BTreeMap::new();
        for row in rows(folder, file, &[("program", program), ("roughness", roughness)])? {
            let measured = number(&row, column)?;
            let least = numbers.entry(format!("{} {}", row["scene"].to_lowercase(), row["view"])).or_insert(measured);
            *least = least.min(measured);
        }
        Ok(numbers)
    };
    let (own, other) = (numbers(programs[0])?, numbers(programs[1])?);
    let ratios: Vec<f64> = own.iter().filter_map(|(view, number)| Some(number / other.get(view)?)).collect();
    median_and_range(&ratios)
}

/// What a history makes of the effect's time, by the medians of each round: the median over scenes and rounds, and the range.
fn history_price(folder: &Path, [program, camera, roughness]: [&str; 3]) -> Result<String> {
    let fields = [("program", program), ("camera", camera), ("roughness", roughness)];
    let rounds = rows(folder, "price.csv", &fields)?;
    median_and_range(&claims::ratios(&column(&rounds, "on_ms")?, &column(&rounds, "off_ms")?)?)
}

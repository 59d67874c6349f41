//! Writes numbers as pages show them.

use crate::records::{Failure, Result};

/// Returns the median of some values: for an even number of them, the mean of the middle two.
pub(crate) fn median(values: &[f64]) -> Result<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    match sorted.len() {
        0 => Err(Failure::missing("nothing to take the median of")),
        n => Ok((sorted[(n - 1) / 2] + sorted[n / 2]) / 2.0),
    }
}

/// Returns the least of some values; infinity without values.
pub(crate) fn least(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::INFINITY, f64::min)
}

/// Returns the greatest of some values; minus infinity without values.
pub(crate) fn greatest(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::NEG_INFINITY, f64::max)
}

/// Returns a number with two decimals, or with three if it is less than 0.02.
pub(crate) fn ratio(value: f64) -> String {
    if value < 0.02 { format!("{value:.3}") } else { format!("{value:.2}") }
}

/// Returns a share in percent, with so many decimals.
pub(crate) fn percent(share: f64, decimals: usize) -> String {
    format!("{:.decimals$} %", 100.0 * share)
}

/// Returns a whole number with its digits in groups of three.
pub(crate) fn grouped(n: f64) -> String {
    let rounded = format!("{n:.0}");
    let (sign, digits) = rounded.strip_prefix('-').map_or(("", &*rounded), |digits| ("-", digits));
    let parts = digits.as_bytes().rchunks(3).rev().map(|part| String::from_utf8_lossy(part).into_owned());
    sign.to_owned() + &parts.collect::<Vec<_>>().join(",")
}

/// Returns a wait in seconds or, from a minute on, in minutes and seconds.
pub(crate) fn wait(seconds: f64) -> String {
    let whole = seconds.round() as u64;
    if whole < 60 { format!("{whole} s") } else { format!("{}:{:02} min", whole / 60, whole % 60) }
}

/// Writes numbers by the function of the given name; `None` if there is no such function. `middle` writes the median
/// and, in brackets, the greatest number. `spread` and `ratios` have the least and the greatest number in the brackets,
/// and `range` and `range_of_ratios` write only these two. All other functions write a single number.
pub(crate) fn write(function: &str, values: &[f64], decimals: usize) -> Result<Option<String>> {
    if values.iter().any(|value| !value.is_finite()) {
        return Err(format!("{function} is of what is no number").into());
    }
    let only = || match values {
        [value] => Ok(*value),
        _ => Err(Failure::missing(format!("{} values where {function} writes one", values.len()))),
    };
    // The median is asked for only where it is written, since it fails without numbers.
    let (middle, low, high) = (|| median(values), least(values), greatest(values));
    Ok(Some(match function {
        "fixed" => format!("{:.decimals$}", only()?),
        "signed" => format!("{:+.decimals$}", only()?),
        "ratio" => ratio(only()?),
        "percent" => percent(only()?, decimals),
        "grouped" => grouped(only()?),
        "wait" => wait(only()?),
        "middle" => format!("{} ({})", ratio(middle()?), ratio(high)),
        "spread" => format!("{:.2} ({low:.2} to {high:.2})", middle()?),
        "ratios" => format!("{} ({} to {})", ratio(middle()?), ratio(low), ratio(high)),
        "range" if !values.is_empty() => format!("{low:.decimals$} to {high:.decimals$}"),
        "range_of_ratios" if !values.is_empty() => format!("{} to {}", ratio(low), ratio(high)),
        "range" | "range_of_ratios" => return Err(Failure::missing("nothing to take the range of")),
        _ => return Ok(None),
    }))
}

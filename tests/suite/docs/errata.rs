//! What the departures from print change, from the records of `cargo bench --bench errata`: the numbers in the pages of errata.

use super::figures::{Result, csv, greatest, median, number, percent};
use std::path::Path;

/// The share of pixels that a departure changes, and the difference of the images: median and maximum over the views.
pub fn erratum(folder: &Path, variant: &str) -> Result<String> {
    let rows = csv(folder, "errata.csv")?;
    let own: Vec<_> = rows.iter().filter(|r| r["variant"] == variant).collect();
    let of = |field: &str| own.iter().map(|r| number(r, field)).collect::<Result<Vec<f64>>>();
    let (shares, errors) = (of("share")?, of("rmse")?);
    let shares = [median(&shares)?, greatest(&shares)].map(|share| percent(share, 2));
    let errors = [median(&errors)?, greatest(&errors)].map(|error| format!("{error:.4}"));
    Ok(format!("{} of pixels; RMSE {}", shares.join(", "), errors.join(", ")))
}

//! Tables as plain text for a terminal.

use crate::study::table::Compared;
use crate::study::{TimeRecord, captions};

/// Rows of cells, each column as wide as its widest cell; the first is aligned left, others right.
pub fn aligned(rows: &[Vec<String>]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |c: usize| rows.iter().filter_map(|r| r.get(c)).map(|s| s.chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let mut text = String::new();
    for row in rows {
        let cells: Vec<String> = row
            .iter()
            .enumerate()
            .map(|(c, s)| if c == 0 { format!("{s:<w$}", w = widths[c]) } else { format!("{s:>w$}", w = widths[c]) })
            .collect();
        text.push_str(cells.join("  ").trim_end());
        text.push('\n');
    }
    text
}

/// What a record's global roughness is called.
pub fn roughness(value: Option<f32>) -> String {
    value.map_or_else(|| "own".into(), |r| format!("{r}"))
}

/// Medians of each stage of each record, and the totals.
pub fn times(records: &[TimeRecord]) -> String {
    let mut stages: Vec<String> = Vec::new();
    for name in records.iter().flat_map(|r| r.stages()).map(|(name, _)| name) {
        if !stages.contains(&name) {
            stages.push(name);
        }
    }
    let mut header: Vec<String> = ["scene view", "size", "roughness", "method"].map(str::to_owned).to_vec();
    header.extend(stages.iter().cloned());
    header.extend(["total ms", "min", "p95", "n", "frame ms"].map(str::to_owned));
    let has_floor = records.iter().any(|r| r.noise_floor.is_some());
    header.extend(has_floor.then(|| "floor".to_owned()));
    let mut rows = vec![header];
    for r in records {
        let mut row = vec![
            format!("{} {}", r.head.scene, r.head.view),
            format!("{}x{}", r.head.width, r.head.height),
            roughness(r.head.roughness),
            r.head.method.clone(),
        ];
        let found = r.stages();
        row.extend(stages.iter().map(|s| match found.iter().find(|(n, _)| n == s) {
            Some((_, ms)) => format!("{ms:.3}"),
            None => "-".into(),
        }));
        row.extend([r.total.median_ms, r.total.min_ms, r.total.p95_ms].map(|ms| format!("{ms:.3}")));
        row.extend([r.total.samples.to_string(), format!("{:.3}", r.frame.median_ms)]);
        let floor = r.noise_floor.map_or_else(|| "-".into(), |floor| format!("{:.1} %", floor * 100.0));
        row.extend(has_floor.then_some(floor));
        rows.push(row);
    }
    aligned(&rows)
}

/// Header and rows of the thesis's table 5.8 beside our own: times, and ratios to SSCT.
pub fn table_5_8_cells(rows: &[Compared]) -> Vec<Vec<String>> {
    let Some(first) = rows.first() else { return Vec::new() };
    let mut header = vec!["resolution".to_owned(), "roughness".to_owned()];
    for c in &first.columns {
        let name = c.method.to_uppercase();
        header.extend([format!("{name} thesis ms"), format!("{name} here ms")]);
    }
    for c in first.columns.iter().filter(|c| c.published_ratio.is_some()) {
        let name = c.method.to_uppercase();
        header.extend([format!("{name}/SSCT thesis"), format!("{name}/SSCT here")]);
    }
    let mut cells = vec![header];
    let ratio = |r: Option<f64>| r.map_or_else(|| "-".into(), |r| format!("{r:.2}"));
    for row in rows {
        let mut line = vec![format!("{} x {}", row.width, row.height), format!("{:.1}", row.roughness)];
        for c in &row.columns {
            line.extend([format!("{:.2}", c.published_ms), format!("{:.2}", c.measured_ms)]);
        }
        for c in row.columns.iter().filter(|c| c.published_ratio.is_some()) {
            line.extend([ratio(c.published_ratio), ratio(c.measured_ratio)]);
        }
        cells.push(line);
    }
    cells
}

/// The thesis's table 5.8 as text.
pub fn table_5_8(rows: &[Compared]) -> String {
    aligned(&table_5_8_cells(rows))
}

/// The thesis's captions beside our own times: milliseconds, and ratios to SSCT.
pub fn captions(rows: &[captions::Compared]) -> String {
    let header = [
        "figure",
        "view",
        "size",
        "roughness",
        "against SSCT",
        "SSCT thesis ms",
        "other thesis ms",
        "SSCT here ms",
        "other here ms",
        "other/SSCT thesis",
        "other/SSCT here",
    ];
    let mut cells = vec![header.map(str::to_owned).to_vec()];
    for row in rows {
        let c = row.caption;
        let other = if c.other == captions::REFERENCE { "Mitsuba".into() } else { c.other.to_uppercase() };
        let of = |pair: Option<captions::Pair>, value: fn(&captions::Pair) -> f64| {
            pair.map_or_else(|| "-".into(), |p| format!("{:.2}", value(&p)))
        };
        cells.push(vec![
            c.figure.to_owned(),
            c.view.to_owned(),
            format!("{} x {}", c.size[0], c.size[1]),
            roughness(row.roughness),
            other,
            of(Some(row.published), |p| p.ssct_ms),
            of(Some(row.published), |p| p.other_ms),
            of(row.measured, |p| p.ssct_ms),
            of(row.measured, |p| p.other_ms),
            of(Some(row.published), |p| p.ratio),
            of(row.measured, |p| p.ratio),
        ]);
    }
    aligned(&cells)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_line_up() {
        let rows = [["a", "bb"], ["ccc", "d"]].map(|r| r.map(str::to_owned).to_vec());
        assert_eq!(aligned(&rows), "a    bb\nccc   d\n");
    }
}

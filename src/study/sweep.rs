//! What `ssct error` sweeps: methods × their settings, and what a sweep adds up to.

use super::error::{Against, ErrorRecord, Variant};
use super::record::Stats;
use crate::math::OracleVersion;
use crate::methods::{MethodInfo, Preset, Setup};
use crate::metrics::pareto;
use crate::passes::PosterFilter;
use crate::passes::billboard::{Occlusion, Order};
use crate::passes::color_chain::ChainFilter;
use crate::passes::linear_trace::March;
use crate::passes::planar::Variant as Planar;
use std::collections::BTreeMap;

/// The roughness values of the study.
pub const ROUGHNESS: [f32; 5] = [0.0, 0.05, 0.1, 0.3, 0.6];

/// Every variant of some methods: the settings that each names, around a base.
pub fn variants(methods: &[&'static MethodInfo], base: Setup) -> Vec<Variant> {
    let of = |method: &&'static MethodInfo| {
        let method = *method;
        (method.settings)(base).into_iter().map(move |setup| Variant { method, setup })
    };
    methods.iter().flat_map(of).collect()
}

/// A record's method with what is behind it.
fn method_name(record: &ErrorRecord) -> String {
    let method = &record.head.method;
    match record.params.fallback.method() {
        Some(behind) => format!("{method} + {}", behind.name),
        None => method.clone(),
    }
}

/// What a record's variant is called: method, preset, and the parameters that differ from it.
pub fn name(record: &ErrorRecord) -> String {
    let mut name = method_name(record);
    if record.head.preset == Preset::Author {
        name += " author";
    }
    if record.params.chain_filter == ChainFilter::Gaussian {
        name += " gaussian";
    }
    if record.params.march == March::Fixed {
        name += " fixed";
    }
    if record.params.poster_filter == PosterFilter::Volume {
        name += " volume";
    }
    if record.head.resolution_scale != 1.0 {
        name += &format!(" scale {}", record.head.resolution_scale);
    }
    if record.head.oracle == OracleVersion::V2 {
        name += " oracle 2";
    }
    match record.params.billboards.order {
        Order::Printed => {}
        Order::Unbroken => name += " unbroken",
        Order::Nearest => name += " nearest",
    }
    if record.params.billboards.occlusion == Occlusion::Depth {
        name += " occluded";
    }
    if record.params.mirrors.variant == Planar::Target {
        name += " target";
    }
    if record.params.mirrors.planes != 1 {
        name += &format!(" planes {}", record.params.mirrors.planes);
    }
    let t = record.params.tuning;
    for (label, value) in
        [("iterations", t.iterations), ("start", t.start_level), ("cone", t.cone_samples), ("step", t.pixel_step)]
    {
        if let Some(value) = value {
            name += &format!(" {label} {value}");
        }
    }
    if let Some(stride) = t.march_stride {
        name += &format!(" stride {stride}");
    }
    if t.distance_blur {
        name += " blur";
    }
    name
}

/// A variant over all cells.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// Its name.
    pub name: String,
    /// Median over the cells of its median time.
    pub time_ms: f64,
    /// Mean over the cells of its error: the share of wrong hits against the oracle, else the RMSE.
    pub error: f64,
    /// Whether no other variant beats it.
    pub on_front: bool,
}

/// The error of a record in the plot of its reference.
fn error(record: &ErrorRecord) -> Option<f64> {
    match record.against {
        Against::Oracle => record.hits.hit_agreement.map(|a| 1.0 - a),
        Against::Screen | Against::World => record.rmse,
    }
}

/// One point a variant against a reference, over some records, in order of time. A variant with an
/// error that is not finite is left out.
pub fn points(records: &[ErrorRecord], against: Against) -> Vec<Point> {
    let mut all: Vec<(String, Vec<f64>, Vec<f64>)> = Vec::new();
    for r in records.iter().filter(|r| r.against == against) {
        let (Some(time), Some(error)) = (r.time_ms, error(r)) else { continue };
        let name = name(r);
        match all.iter_mut().find(|(n, ..)| *n == name) {
            Some((_, times, errors)) => {
                times.push(time);
                errors.push(error);
            }
            None => all.push((name, vec![time], vec![error])),
        }
    }
    let mut points: Vec<Point> = all
        .into_iter()
        .map(|(name, times, errors)| Point {
            name,
            time_ms: Stats::of(&times).median_ms,
            error: errors.iter().sum::<f64>() / errors.len() as f64,
            on_front: false,
        })
        .filter(|p| p.error.is_finite() && p.error >= 0.0 && p.time_ms > 0.0)
        .collect();
    for index in pareto::front(&points.iter().map(|p| (p.time_ms, p.error)).collect::<Vec<_>>()) {
        points[index].on_front = true;
    }
    points.sort_by(|a, b| a.time_ms.total_cmp(&b.time_ms));
    points
}

/// Medians over the views of what the error consists of, at one roughness.
#[derive(Debug, Clone, PartialEq)]
pub struct Sources {
    /// Roughness.
    pub roughness: Option<f32>,
    /// RMSE by (method, reference): the base variant of each method, exact hits with the thesis's
    /// cone, and the screen reference against the world.
    pub rmse: Vec<(String, Against, f64)>,
}

/// Where the error comes from, for each roughness: of each method its base variant, the first in the records.
pub fn sources(records: &[ErrorRecord]) -> Vec<Sources> {
    let mut bases = BTreeMap::new();
    for r in records {
        bases.entry(method_name(r)).or_insert_with(|| name(r));
    }
    let base = |r: &&ErrorRecord| bases.get(&method_name(r)) == Some(&name(r));
    let mut found: Vec<Sources> = Vec::new();
    for r in records.iter().filter(base) {
        if !found.iter().any(|s| s.roughness == r.head.roughness) {
            found.push(Sources { roughness: r.head.roughness, rmse: Vec::new() });
        }
    }
    for source in &mut found {
        let here: Vec<_> = records.iter().filter(base).filter(|r| r.head.roughness == source.roughness).collect();
        for r in &here {
            let name = method_name(r);
            let known = source.rmse.iter().any(|(m, a, _)| *m == name && *a == r.against);
            if known || r.rmse.is_none() {
                continue;
            }
            let same = here.iter().filter(|o| method_name(o) == name && o.against == r.against);
            let values: Vec<f64> = same.filter_map(|o| o.rmse).collect();
            source.rmse.push((name, r.against, Stats::of(&values).median_ms));
        }
    }
    found
}

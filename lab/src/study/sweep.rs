//! What `ssct error` sweeps: methods × their settings, and what a sweep adds up to.

use super::error::{Against, ErrorRecord, Variant};
use super::record::Stats;
use crate::methods::setup::{BeyondScreen, CaptureCount, CaptureSide};
use crate::methods::{EffectParams, Fallback, MethodInfo, Setup};
use crate::metrics::pareto;
use std::collections::BTreeMap;

/// The roughness values of the study.
pub const ROUGHNESS: [f32; 5] = [0.0, 0.05, 0.1, 0.3, 0.6];

/// Every variant of some methods: what each of them sweeps, around a base.
pub fn variants(methods: &[&'static MethodInfo], base: &Setup) -> Vec<Variant> {
    let of = |method: &&'static MethodInfo| {
        let method = *method;
        method.sweep(base).into_iter().map(move |setup| Variant { method, setup })
    };
    methods.iter().flat_map(of).collect()
}

/// A method without captures, and with each of some numbers of them at each of some sizes of face, around a base.
pub fn captures(method: &'static MethodInfo, base: &Setup) -> Vec<Variant> {
    use CaptureCount::{None, Number};
    use CaptureSide::{Scene, Side128, Side256, Side512, Side1024};
    let sides = [Side128, Side256, Side512, Side1024];
    let all = [1, 2, 4, 8].into_iter().flat_map(|count| sides.map(|side| (Number(count), side)));
    let of = |(count, side)| Variant {
        method,
        setup: base.with(|p: &mut EffectParams| {
            p.beyond = if count == None { BeyondScreen::None } else { BeyondScreen::Captures };
            (p.captures, p.capture_side) = (count, side);
        }),
    };
    std::iter::once((None, Scene)).chain(all).map(of).collect()
}

/// A method with nothing, with the environment and with `pccm` behind it, if it sees the screen alone; and if it takes
/// captures or triangles, also with the captures of a base and with the triangles of the scene.
pub fn fallbacks(method: &'static MethodInfo, base: &Setup) -> Vec<Variant> {
    use Fallback::{Environment, None, Pccm};
    let behind: &[Fallback] = if method.is_screen_space() { &[None, Environment, Pccm] } else { &[None] };
    let with = |fallback, captures, beyond| Variant {
        method,
        setup: base.with(|p: &mut EffectParams| (p.fallback, p.captures, p.beyond) = (fallback, captures, beyond)),
    };
    let (captures, on_screen) = (base.effect().captures, method.is_screen_space());
    // A method that sees captures alone is never without them.
    let without = if on_screen { CaptureCount::None } else { captures };
    let is_captured = on_screen && method.takes_captures && captures != CaptureCount::None;
    let alone = if on_screen { BeyondScreen::None } else { base.effect().beyond };
    let all = behind.iter().map(|fallback| with(*fallback, without, alone));
    let is_among_triangles = on_screen && method.takes_triangles;
    all.chain(is_captured.then(|| with(None, captures, BeyondScreen::Captures)))
        .chain(is_among_triangles.then(|| with(None, without, BeyondScreen::Triangles)))
        .collect()
}

/// A screen-space method with each number of bounces up to that of a base; any other as it is.
pub fn bounces(method: &'static MethodInfo, base: &Setup) -> Vec<Variant> {
    let most = if method.is_screen_space() { base.effect().bounces } else { 1 };
    let with = |n| Variant { method, setup: base.with(|p: &mut EffectParams| p.bounces = n) };
    (1..=most).map(with).collect()
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
    /// Mean over the cells of its place agreement; `None` where no cell has one.
    pub place_agreement: Option<f64>,
    /// Medians over the cells of what it made of the scene before the first frame: bytes on the device, and
    /// milliseconds. `None` where no record says it.
    pub prepared: Option<(f64, f64)>,
    /// Whether no other variant beats it.
    pub on_front: bool,
}

/// The mean; `None` of nothing.
fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// Mean over the cells of the screen's floor; `None` where no cell has one.
pub fn floor(records: &[ErrorRecord]) -> Option<f64> {
    // Every method of a cell has the same.
    mean(&records.iter().filter_map(|r| r.floor).collect::<Vec<_>>())
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
    let mut all: Vec<(String, [Vec<f64>; 5])> = Vec::new();
    for r in records.iter().filter(|r| r.against == against) {
        let (Some(time), Some(error)) = (r.time_ms, error(r)) else { continue };
        let name = r.head.variant();
        let known = all.iter().position(|(n, _)| *n == name).unwrap_or(all.len());
        if known == all.len() {
            all.push((name, Default::default()));
        }
        let [times, errors, places, bytes, prepared_ms] = &mut all[known].1;
        times.push(time);
        errors.push(error);
        places.extend(r.place_agreement);
        bytes.extend(r.prepared.as_ref().map(|p| p.device_bytes as f64));
        prepared_ms.extend(r.prepared.as_ref().map(|p| p.time_ms));
    }
    let mut points: Vec<Point> = all
        .into_iter()
        .map(|(name, [times, errors, places, bytes, prepared_ms])| Point {
            name,
            time_ms: Stats::of(&times).median_ms,
            error: mean(&errors).unwrap_or(f64::NAN),
            place_agreement: mean(&places),
            prepared: (!bytes.is_empty()).then(|| (Stats::of(&bytes).median_ms, Stats::of(&prepared_ms).median_ms)),
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
    /// RMSE of the floor of the screen's picture, against the world.
    pub floor: Option<f64>,
}

/// Where the error comes from, for each roughness: of each method its base variant, the first in the records.
pub fn sources(records: &[ErrorRecord]) -> Vec<Sources> {
    let mut bases = BTreeMap::new();
    for r in records {
        bases.entry(r.head.method_and_fallback()).or_insert_with(|| r.head.variant());
    }
    let base = |r: &&ErrorRecord| bases.get(&r.head.method_and_fallback()) == Some(&r.head.variant());
    let mut found: Vec<Sources> = Vec::new();
    for r in records.iter().filter(base) {
        if !found.iter().any(|s| s.roughness == r.head.roughness) {
            found.push(Sources { roughness: r.head.roughness, rmse: Vec::new(), floor: None });
        }
    }
    for source in &mut found {
        let here: Vec<_> = records.iter().filter(base).filter(|r| r.head.roughness == source.roughness).collect();
        let floors: Vec<f64> = here.iter().filter_map(|r| r.floor).collect();
        source.floor = (!floors.is_empty()).then(|| Stats::of(&floors).median_ms);
        for r in &here {
            let name = r.head.method_and_fallback();
            let known = source.rmse.iter().any(|(m, a, _)| *m == name && *a == r.against);
            if known || r.rmse.is_none() {
                continue;
            }
            let same = here.iter().filter(|o| o.head.method_and_fallback() == name && o.against == r.against);
            let values: Vec<f64> = same.filter_map(|o| o.rmse).collect();
            source.rmse.push((name, r.against, Stats::of(&values).median_ms));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::{METHODS, unified};
    use std::collections::BTreeSet;

    #[test]
    fn a_sweep_of_captures_has_every_number_of_every_size_once() {
        let base = Setup::new([64, 36]);
        let all = captures(&unified::INFO, &base);
        let texels = |v: &Variant| (v.setup.effect().captures.wanted(), v.setup.effect().capture_side.texels());
        let distinct: BTreeSet<String> = all.iter().map(|v| format!("{:?}", texels(v))).collect();
        assert_eq!((all.len(), distinct.len()), (17, 17));
        assert_eq!(texels(&all[0]), (None, None));
    }

    #[test]
    fn a_sweep_of_fallbacks_has_each_and_captures_once() {
        let base = Setup::new([64, 36]).with(|p: &mut EffectParams| p.captures = CaptureCount::Number(4));
        let of = |name: &str| {
            let method = METHODS.iter().find(|m| m.name == name);
            let variants = method.map_or_else(Vec::new, |method| fallbacks(method, &base));
            let effects = variants.iter().map(|v| v.setup.effect());
            effects.map(|e| (e.fallback, e.captures, e.beyond)).collect::<Vec<_>>()
        };
        use BeyondScreen::{Auto, Captures, None, Triangles};
        let behind = [Fallback::None, Fallback::Environment, Fallback::Pccm].map(|f| (f, CaptureCount::None, None));
        assert_eq!(of("ssct"), behind);
        let [captured, among] = [(CaptureCount::Number(4), Captures), (CaptureCount::None, Triangles)];
        let more = [captured, among].map(|(captures, beyond)| (Fallback::None, captures, beyond));
        assert_eq!(of("unified"), [&behind[..], &more].concat());
        assert_eq!(of("captures"), [(Fallback::None, CaptureCount::Number(4), Auto)]);
    }
}

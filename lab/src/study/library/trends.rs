//! Trends: figures over the runs of a library. A time is given as its ratio to the time of a base method in the same
//! run on the same device, never in milliseconds and never across devices. A line joins only runs that measured the
//! same views in the same setting.

use super::{LibraryRun, Quantity, Setting};
use crate::study::exhibit::distinct;
use crate::study::record::Stats;
use ssct::gpu::DeviceInfo;
use std::collections::{BTreeMap, BTreeSet};

/// One quantity over the runs that measured it on one device, in one setting and on the same views.
#[derive(Debug, Clone, PartialEq)]
pub struct Trend {
    /// Device.
    pub device: DeviceInfo,
    /// Setting of the measurements, without the views.
    pub setting: Setting,
    /// The views. Each value of a line is the median over them.
    pub views: Vec<String>,
    /// Quantity that was measured.
    pub quantity: Quantity,
    /// Indices of the runs in the library, ascending; at least two.
    pub runs: Vec<usize>,
    /// One line for each method, sorted by name.
    pub lines: Vec<TrendLine>,
}

/// The values of a method over the runs of its trend.
#[derive(Debug, Clone, PartialEq)]
pub struct TrendLine {
    /// The method and its parameters.
    pub method: String,
    /// Value for each run of the trend, ≥ 0; `None` where the run did not measure it. At least two values are present.
    pub values: Vec<Option<f64>>,
}

/// The values of one quantity of a method in one run, by the name of the view.
type ViewValues = BTreeMap<String, f64>;

/// Key of a trend: the index of its device, the setting, the views and the quantity.
type TrendKey = (usize, Setting, Vec<String>, Quantity);

/// The values of a trend: for each method, by its name, the value in each run, by the index of the run.
type MethodValues = BTreeMap<String, BTreeMap<usize, f64>>;

/// Finds all trends of a library. Times are divided by those of the method with the name `base`.
pub fn trends(library: &[LibraryRun], base: &str) -> Vec<Trend> {
    let devices = devices(library);
    let mut groups: BTreeMap<TrendKey, MethodValues> = BTreeMap::new();
    for (index, run) in library.iter().enumerate() {
        for ((device, setting, quantity), methods) in grouped_measurements(run) {
            let Some(device) = devices.iter().position(|d| **d == run.devices[device]) else { continue };
            let base_views = methods.get(base).cloned();
            for (method, views) in methods {
                let Some(views) = relative_to_base(quantity, &views, base_views.as_ref()) else { continue };
                let median = Stats::from_samples(&views.values().copied().collect::<Vec<_>>()).median_ms;
                let key = (device, setting.clone(), views.into_keys().collect(), quantity);
                groups.entry(key).or_default().entry(method).or_default().insert(index, median);
            }
        }
    }
    let trend = |((device, setting, views, quantity), mut methods): (TrendKey, MethodValues)| {
        // A value in a single run makes no line. The base method's time divided by itself is always 1, and tells
        // nothing.
        methods.retain(|method, values| values.len() > 1 && !(Quantity::is_time(quantity) && method == base));
        let runs: BTreeSet<usize> = methods.values().flat_map(|values| values.keys().copied()).collect();
        let line = |(method, values): (String, BTreeMap<usize, f64>)| TrendLine {
            method,
            values: runs.iter().map(|run| values.get(run).copied()).collect(),
        };
        let lines: Vec<_> = methods.into_iter().map(line).collect();
        let device: &DeviceInfo = devices[device];
        (!lines.is_empty()).then(|| Trend {
            device: device.clone(),
            setting,
            views,
            quantity,
            runs: runs.into_iter().collect(),
            lines,
        })
    };
    groups.into_iter().filter_map(trend).collect()
}

/// Returns the devices of a library, each once, in the order in which they first appear.
pub fn devices(library: &[LibraryRun]) -> Vec<&DeviceInfo> {
    distinct(library.iter().flat_map(|run| &run.devices))
}

/// Sorts the measurements of a run by the index of the device, setting and quantity, and below these by method and by
/// view.
fn grouped_measurements(run: &LibraryRun) -> BTreeMap<(usize, Setting, Quantity), BTreeMap<String, ViewValues>> {
    let mut groups: BTreeMap<_, BTreeMap<String, ViewValues>> = BTreeMap::new();
    for m in &run.measurements {
        let methods = groups.entry((m.device, m.setting.clone(), m.quantity)).or_default();
        methods.entry(m.method.clone()).or_default().insert(m.view.clone(), m.value);
    }
    groups
}

/// Returns the values `views` of a method unchanged if they are errors. Times are divided by the values `base` of the
/// base method, in the views that both methods have; `None` if no view is left.
fn relative_to_base(quantity: Quantity, views: &ViewValues, base: Option<&ViewValues>) -> Option<ViewValues> {
    if !quantity.is_time() {
        return Some(views.clone());
    }
    let ratio = |(view, value): (&String, &f64)| {
        let base_value = base?.get(view).filter(|value| **value > 0.0)?;
        Some((view.clone(), value / base_value))
    };
    let ratios: ViewValues = views.iter().filter_map(ratio).collect();
    (!ratios.is_empty()).then_some(ratios)
}

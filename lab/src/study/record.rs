//! Records: the subject and the result of a measurement, as one JSON object (docs/definitions.md, "Records").

use super::columns::{Column, ColumnSet, Columns, columns, nested, part, time, times};
use super::names::{EXACT_HITS, SCREEN_REFERENCE, roughness_name};
use crate::stage::Globals;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value as Json, json};
use ssct::gpu::timing::PassWork;
use ssct::gpu::{DeviceInfo, Gpu, Skipped};
use ssct::methods::{self, EffectParams, MethodInfo, Setup};
use ssct::passes::gbuffer::DrawnCounts;
use ssct_ground::parameter::{Choices, Domain, Parameter, Parameters, Preset, Value};
use ssct_scenes::{FieldOfView, Lens, Scene, View};

/// The version of docs/definitions.md that the figures of this program follow.
pub const DEFINITIONS: u32 = 3;

columns! {
    /// Median, minimum, 95th percentile and number of some samples, in milliseconds.
    #[derive(Copy)]
    pub struct Stats {
        /// Median; for an even number of samples, the mean of the middle two.
        pub median_ms: f64 = time("median"),
        /// Least sample.
        pub min_ms: f64 = time("min"),
        /// The least sample that 95 % of the samples don't exceed.
        pub p95_ms: f64 = time("p95"),
        /// Number of samples.
        pub samples: usize = time("n"),
    }
}

impl Stats {
    /// Computes the statistics of samples; all are 0 without samples.
    pub fn from_samples(samples: &[f64]) -> Self {
        let mut sorted = samples.to_vec();
        sorted.sort_by(f64::total_cmp);
        let count = sorted.len();
        if count == 0 {
            return Self { median_ms: 0.0, min_ms: 0.0, p95_ms: 0.0, samples: 0 };
        }
        let p95_index = (0.95 * count as f64).ceil() as usize - 1;
        Self {
            median_ms: (sorted[(count - 1) / 2] + sorted[count / 2]) / 2.0,
            min_ms: sorted[0],
            p95_ms: sorted[p95_index],
            samples: count,
        }
    }
}

/// The times of a pass.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PassRecord {
    /// Label of the pass; the number of a level stands behind a slash.
    pub name: String,
    /// Whether the pass counts towards the total (scene passes don't).
    pub counted: bool,
    /// Times of the pass.
    #[serde(flatten)]
    pub stats: Stats,
    /// Noise floor of the pass's time, as a share, if the method was timed against itself
    /// ([`super::timing::TimeSpec::a_a`]).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise_floor: Option<f64>,
    /// Work of the pass, counted in a separate frame, if the device can count.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub work: Option<PassWork>,
}

/// The program, the version of the definitions and the device of a measurement.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// The version of docs/definitions.md that the figures follow.
    pub definitions: u32,
    /// Version of this program.
    pub version: String,
    /// Commit of the program's source; "unknown" outside a repository.
    pub commit: String,
    /// Device.
    pub device: DeviceInfo,
}

impl Provenance {
    /// This program's version.
    pub const VERSION: &'static str = env!("CARGO_PKG_VERSION");
    /// The commit that the program was built from.
    const COMMIT: &'static str = env!("SSCT_COMMIT");

    /// Returns the commit that the program was built from, with a remark if the program uses shaders of another folder.
    pub fn commit() -> String {
        let remark = if ssct::gpu::sources::named_folder().is_some() { " with other shaders" } else { "" };
        format!("{}{remark}", Self::COMMIT)
    }

    /// Returns the provenance of measurements by this program on a device.
    pub fn on(gpu: &Gpu) -> Self {
        Self {
            definitions: DEFINITIONS,
            version: Self::VERSION.to_owned(),
            commit: Self::commit(),
            device: gpu.info().clone(),
        }
    }
}

/// Everything that was set for a measurement, by name: size, lens, the global factors, the preset, and every parameter of the
/// effect and of the method. A value that is not set, such as a roughness that the materials keep, is null.
pub type RecordedSetup = Map<String, Json>;

/// Collects everything that is set for a measurement: the setup with the parameters of the effect and of `method`, the
/// lens and the global factors, by name.
pub fn recorded_setup(setup: &Setup, method: Option<&MethodInfo>, lens: &Lens, globals: &Globals) -> RecordedSetup {
    let named = |(name, value): (&str, Value)| (name.to_owned(), json!(value));
    let mut all: RecordedSetup = setup.recorded(method).into_iter().map(named).collect();
    // Only the records of orthographic cameras have this name.
    let height = match lens.opening {
        FieldOfView::Angle(_) => None,
        FieldOfView::Height(height) => Some(("orthographic_height_m", Some(height))),
    };
    let lens_and_factors = [
        ("fov_degrees", lens.fov_y_radians().map(f32::to_degrees)),
        ("near_m", Some(lens.near_m)),
        ("far_m", Some(lens.far_m)),
        ("roughness", globals.roughness),
        ("reflectivity", Some(globals.reflectivity)),
        ("normal_deviation", globals.normal_deviation),
    ];
    let numbers = lens_and_factors.into_iter().chain(height);
    all.extend(numbers.map(|(name, value)| (name.to_owned(), json!(value.map(Value::Number)))));
    all
}

/// Returns a value of a [`RecordedSetup`] as text; null is an empty text.
pub fn setting_text(value: &Json) -> String {
    match value {
        Json::Null => String::new(),
        Json::String(text) => text.clone(),
        Json::Number(n) => n.as_f64().map_or_else(|| n.to_string(), |n| n.to_string()),
        other => other.to_string(),
    }
}

/// The first fields of every record about a view of a scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Head {
    /// Kind of the record, such as "time" or "error".
    pub kind: String,
    /// Program and device that measured.
    #[serde(flatten)]
    pub program: Provenance,
    /// Scene name.
    pub scene: String,
    /// View name.
    pub view: String,
    /// Method name.
    pub method: String,
    /// Preset.
    pub preset: Preset,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Global roughness; null where the materials keep their own.
    pub roughness: Option<f32>,
    /// Everything that was set for the measurement, by name.
    pub setup: RecordedSetup,
}

impl Head {
    /// Makes the head of a record of a measurement by this program. `place` is the scene with its view.
    pub fn new(
        kind: &str,
        gpu: &Gpu,
        place: (&Scene, &View),
        subject: RecordSubject,
        setup: &Setup,
        globals: &Globals,
    ) -> Self {
        let (scene, view) = place;
        let (name, method) = match subject {
            RecordSubject::Method(method) => (method.name, Some(method)),
            RecordSubject::Other { name, method } => (name, method),
        };
        Self {
            kind: kind.to_owned(),
            program: Provenance::on(gpu),
            scene: scene.name.clone(),
            view: view.name.clone(),
            method: name.to_owned(),
            preset: setup.values.preset,
            width: setup.extent[0],
            height: setup.extent[1],
            roughness: globals.roughness,
            setup: recorded_setup(setup, method, &view.lens.unwrap_or(scene.lens), globals),
        }
    }

    /// Returns a value of the setup as text; empty if it is null or missing.
    pub fn setting(&self, name: &str) -> String {
        self.setup.get(name).map(setting_text).unwrap_or_default()
    }

    /// Returns the method's name, followed by " + " and the fallback if it has one.
    pub fn method_and_fallback(&self) -> String {
        match self.setting("fallback").as_str() {
            "" | "none" => self.method.clone(),
            fallback => format!("{} + {fallback}", self.method),
        }
    }

    /// Returns the name of the record's line in a chart: the text `first`, and those of the method, place, roughness
    /// and size in which the record differs from some record of `all`. A property with which `first` begins is not
    /// repeated.
    pub fn line_name(&self, all: &[&Self], first: &str) -> String {
        let method = |h: &Self| h.method_and_fallback();
        let place = |h: &Self| format!("{} {}", h.scene, h.view);
        let roughness = |h: &Self| format!("r {}", roughness_name(h.roughness));
        let size = |h: &Self| format!("{} × {}", h.width, h.height);
        let properties: [&dyn Fn(&Self) -> String; 4] = [&method, &place, &roughness, &size];
        let differing = properties
            .iter()
            .filter(|property| all.iter().any(|other| property(other) != property(self)))
            .map(|property| property(self));
        let not_in_first = differing.filter(|word| !first.starts_with(word.as_str()));
        std::iter::once(first.to_owned()).chain(not_in_first).collect::<Vec<_>>().join(", ")
    }

    /// Returns the name of the record's variant: the method, its fallback, the preset unless it is the default, and the
    /// parameters that differ from the preset's values.
    pub fn variant(&self) -> String {
        let parameters = naming_parameters(&self.method);
        let has_presets = parameters.iter().any(|p| p.author != p.published);
        let preset = Some(self.preset.name()).filter(|_| has_presets && self.preset != Preset::default());
        // The fallback stands behind the method already.
        let others = parameters.iter().filter(|p| p.name != "fallback");
        let changed = others.filter_map(|p| changed_value(p, self.preset, &self.setting(p.name)));
        let words = preset.map(str::to_owned).into_iter().chain(changed);
        words.fold(self.method_and_fallback(), |name, word| format!("{name} {word}"))
    }
}

/// Returns the parameters by which variants of a subject are named: those that the subject reads.
fn naming_parameters(subject: &str) -> Vec<Parameter> {
    if let Ok(method) = methods::find(subject) {
        return method.read_parameters();
    }
    // A method from a folder reads what surrounds any method that sees the screen alone. What is no method has nothing
    // around it; its setup is that of a method, and says more than applies.
    let is_method = ![EXACT_HITS, SCREEN_REFERENCE].contains(&subject);
    let read_on_screen = methods::ssct::INFO.read_parameters();
    let is_read = |p: &Parameter| matches!(p.name, "oracle" | "bounces") || is_method && read_on_screen.contains(p);
    EffectParams::table().into_iter().filter(is_read).collect()
}

impl Columns for Head {
    fn columns() -> ColumnSet<Self> {
        let tables = [
            Column::derived("scene view", 0, |h: &Self| format!("{} {}", h.scene, h.view)),
            Column::derived("size", 0, |h: &Self| format!("{}x{}", h.width, h.height)),
            Column::derived("roughness", 0, |h: &Self| roughness_name(h.roughness)),
            Column::derived("method", 0, Self::variant),
        ];
        let files = [
            Column::named("scene", |h: &Self| h.scene.clone()),
            Column::named("view", |h: &Self| h.view.clone()),
            Column::named("method", |h: &Self| h.method.clone()),
            Column::named("variant", Self::variant),
            Column::named("width", |h: &Self| h.width),
            Column::named("height", |h: &Self| h.height),
            Column::named("roughness", |h: &Self| h.roughness),
        ];
        ColumnSet { columns: tables.into_iter().chain(files).collect(), ..ColumnSet::default() }
    }
}

/// Describes a parameter's value in a few words, if it differs from the preset's; `text` is the value in a record.
/// `None` if it does not differ, or if the text is empty, since the record is older than the parameter.
pub fn changed_value(parameter: &Parameter, preset: Preset, text: &str) -> Option<String> {
    if text.is_empty() || text == setting_text(&json!(parameter.preset_value(preset))) {
        return None;
    }
    Some(match parameter.domain {
        Domain::Switch if text == "true" => parameter.typed_name(),
        Domain::Switch => format!("no {}", parameter.typed_name()),
        // A number, "on" or "off" does not explain itself without the parameter's name; other choices do.
        Domain::Choices(_) | Domain::ChoicesOrCount(..)
            if parameter.name != "fallback" && !text.starts_with(|c: char| c.is_ascii_digit()) && text != "on" =>
        {
            text.to_owned()
        }
        _ => format!("{} {text}", parameter.typed_name()),
    })
}

/// The subject of a record.
#[derive(Clone, Copy)]
pub enum RecordSubject<'a> {
    /// A method.
    Method(&'a MethodInfo),
    /// Another subject, with the method whose parameters it uses, if any.
    Other {
        /// Name in records.
        name: &'a str,
        /// The method.
        method: Option<&'a MethodInfo>,
    },
}

columns! {
    /// Times of one method on one view, size and roughness.
    pub struct TimeRecord {
        /// Subject of the record.
        #[serde(flatten)]
        pub head: Head = part(),
        /// Every pass of the frame, in order.
        pub passes: Vec<PassRecord> = times(),
        /// Sum of the counted passes, sample by sample.
        pub total: Stats = nested(""),
        /// How far the total strays from itself, as a share, where the method was timed against itself.
        #[serde(skip_serializing_if = "Option::is_none")]
        pub noise_floor: Option<f64> = time(""),
        /// Times of whole frames, from a frame's first timestamp to its last, scene passes included.
        pub frame: Stats = nested(""),
        /// Meshes and triangles drawn.
        pub drawn: DrawnCounts,
        /// Labels of the passes that the frame recorded.
        pub recorded: Vec<String>,
        /// Passes that the frame did not need.
        pub skipped: Vec<Skipped>,
        /// Raw samples: for each frame the milliseconds of each pass, in order. A CSV file beside the record keeps
        /// them.
        #[serde(skip)]
        pub samples: Vec<Vec<f64>>,
    }
}

impl TimeRecord {
    /// Returns the sum of the medians of all passes divided by the median of the frame: 1 if no time passes between
    /// passes.
    pub fn sum_over_frame(&self) -> f64 {
        self.passes.iter().map(|p| p.stats.median_ms).sum::<f64>() / self.frame.median_ms
    }

    /// Returns the sum of the counted passes in each frame, in milliseconds.
    pub fn totals(&self) -> Vec<f64> {
        let counted = |frame: &Vec<f64>| {
            let passes = self.passes.iter().zip(frame).filter(|(pass, _)| pass.counted);
            passes.map(|(_, ms)| ms).sum()
        };
        self.samples.iter().map(counted).collect()
    }

    /// Returns the names and the median milliseconds of the passes that count towards the time of the method, as
    /// [`Self::group_medians`] does.
    pub fn stages(&self) -> Vec<(String, f64)> {
        self.group_medians(true)
    }

    /// Returns the names and the median milliseconds of the passes that count, or of those that do not, in order. The
    /// passes of one [`group_of`] become one: their times are added up in each frame. Without samples, their medians
    /// are added up.
    pub fn group_medians(&self, counted: bool) -> Vec<(String, f64)> {
        let mut groups: Vec<(String, Vec<usize>)> = Vec::new();
        for (n, pass) in self.passes.iter().enumerate().filter(|(_, p)| p.counted == counted) {
            let name = group_of(&pass.name);
            match groups.iter_mut().find(|(known, _)| known == name) {
                Some((_, parts)) => parts.push(n),
                None => groups.push((name.to_owned(), vec![n])),
            }
        }
        groups.into_iter().map(|(name, parts)| (name, self.median_of_sum(&parts))).collect()
    }

    /// Returns the median over the frames of the sum of some passes, given by their indices, in milliseconds. Without
    /// samples, returns the sum of their medians.
    fn median_of_sum(&self, passes: &[usize]) -> f64 {
        if self.samples.is_empty() {
            return passes.iter().filter_map(|n| self.passes.get(*n)).map(|pass| pass.stats.median_ms).sum();
        }
        let sum = |frame: &Vec<f64>| passes.iter().filter_map(|n| frame.get(*n)).sum();
        Stats::from_samples(&self.samples.iter().map(sum).collect::<Vec<_>>()).median_ms
    }
}

/// Returns the name of the group of a pass: the part of its label before the slash, which all levels of a chain have in
/// common, or the whole label without a slash.
pub fn group_of(label: &str) -> &str {
    label.split('/').next().unwrap_or(label)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use ssct::methods::METHODS;
    use ssct::methods::setup::{BeyondScreen, CaptureCount, HistoryUse};
    use ssct_ground::math::OracleVersion;

    /// Returns a value that the parameter allows, other than the given value.
    pub(crate) fn another(parameter: &Parameter, value: Value) -> Value {
        use ssct_ground::parameter::Domain;
        let candidates = match parameter.domain {
            Domain::Count(least, most) => vec![Value::Count(least), Value::Count(most)],
            Domain::Number { least, most, .. } => vec![Value::Number(most), Value::Number(0.5 * (least + most))],
            _ => parameter.domain.all_if_few().unwrap_or_default(),
        };
        candidates.into_iter().find(|c| *c != value && parameter.domain.has(*c)).expect("more than one value")
    }

    #[test]
    fn a_changed_parameter_changes_its_value_in_the_recorded_setup_and_no_other() {
        for method in METHODS {
            for preset in [Preset::Published, Preset::Author] {
                let base = Setup::new([64, 48]).of_preset(preset);
                for parameter in method.read_parameters() {
                    let mut changed = base.clone();
                    changed.values.set(&parameter, another(&parameter, base.values.value(&parameter)));
                    let (before, after) = (base.recorded(Some(method)), changed.recorded(Some(method)));
                    let differ: Vec<_> = before.iter().filter(|(k, v)| after.get(*k) != Some(v)).collect();
                    assert_eq!(differ.len(), 1, "{} of {}: {differ:?}", parameter.name, method.name);
                    assert_eq!(*differ[0].0, parameter.name);
                }
            }
        }
    }

    #[test]
    fn a_name_has_no_settings_that_its_subject_does_not_read() {
        let text = String::new;
        let device = DeviceInfo { name: text(), driver: text(), api: text(), kind: text() };
        let setup = Setup::new([64, 48]).with(|p: &mut EffectParams| {
            (p.beyond, p.captures, p.history) = (BeyondScreen::Triangles, CaptureCount::Auto, HistoryUse::On);
            p.oracle = OracleVersion::V2;
        });
        let name = |subject: &str| {
            let head = Head {
                kind: "error".into(),
                program: Provenance {
                    definitions: DEFINITIONS,
                    version: text(),
                    commit: text(),
                    device: device.clone(),
                },
                scene: "rooms".into(),
                view: "a".into(),
                method: subject.into(),
                preset: Preset::default(),
                width: 64,
                height: 48,
                roughness: None,
                setup: recorded_setup(&setup, methods::find(subject).ok(), &Lens::default(), &Globals::default()),
            };
            head.variant()
        };
        assert_eq!(name(EXACT_HITS), "exact-hits+cone oracle 2");
        assert_eq!(name(SCREEN_REFERENCE), "screen-reference oracle 2");
        assert_eq!(name("my/method"), "my/method history on oracle 2");
        assert_eq!(name("ssct"), "ssct history on");
        assert_eq!(name("unified"), "unified history on oracle 2 triangles auto");
    }

    #[test]
    fn stats_are_those_of_a_hand_computation() {
        let s = Stats::from_samples(&[4.0, 1.0, 3.0, 2.0]);
        assert_eq!((s.median_ms, s.min_ms, s.p95_ms, s.samples), (2.5, 1.0, 4.0, 4));
        let twenty: Vec<f64> = (1..=20).map(f64::from).collect();
        assert_eq!(Stats::from_samples(&twenty).p95_ms, 19.0);
        assert_eq!(Stats::from_samples(&[]).samples, 0);
    }
}

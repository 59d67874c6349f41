//! Reads records of all versions of the program. Older records lack some fields of newer records, so that each field is
//! read from plain JSON if it is present.

use super::{Measurement, Quantity, Setting};
use crate::study::error::{EXACT_HITS, SCREEN_REFERENCE};
use crate::study::record::{Head, Provenance, RecordedSetup, setting_text};
use serde::Deserialize;
use serde_json::Value as Json;
use ssct::gpu::DeviceInfo;
use ssct::methods::{self, EffectParams};
use ssct_ground::parameter::{Choices, Parameters, Preset};

/// The kinds of records that the studies write.
pub const KINDS: [&str; 9] = ["time", "error", "stress", "motion", "precision", "video", "path", "age", "reference"];

/// Names of settings that older records have at their top level, and newer records in their setup.
const FORMERLY_AT_THE_TOP: [&str; 4] = ["normal_deviation", "resolution_scale", "split", "oracle"];

/// Names of settings that belong to the place of a measurement and not to its method.
const PLACE_SETTINGS: [&str; 5] = ["fov_degrees", "near_m", "far_m", "reflectivity", "normal_deviation"];

/// The parts of a record that the library uses.
#[derive(Debug, Clone, PartialEq)]
pub struct ReadRecord {
    /// One of [`KINDS`].
    pub kind: String,
    /// Program, as "VERSION, commit COMMIT".
    pub program: String,
    /// Version of the definitions.
    pub definitions: u32,
    /// Device.
    pub device: DeviceInfo,
    /// The record's figures that can be followed over runs. Their index of the device is 0, since a record has one
    /// device.
    pub measurements: Vec<Measurement>,
    /// Whether the case passed, in a record of the stress study.
    pub passed: Option<bool>,
}

/// Whether a file has records of the studies, judged by the kind of its first object.
pub fn are_records(objects: &[Json]) -> bool {
    objects.first().and_then(|first| first["kind"].as_str()).is_some_and(|kind| KINDS.contains(&kind))
}

/// Reads a record.
///
/// # Errors
/// Which field the record lacks, as the end of a sentence that begins with the record.
pub fn record(json: &Json) -> Result<ReadRecord, String> {
    let kind = json["kind"].as_str().filter(|kind| KINDS.contains(kind)).ok_or("has no kind that is known")?;
    let device = DeviceInfo::deserialize(&json["device"]).map_err(|_| "has no device")?;
    let text = |name: &str| json[name].as_str().unwrap_or_default().to_owned();
    let program = Provenance {
        definitions: json["definitions"].as_u64().and_then(|d| d.try_into().ok()).unwrap_or(1),
        version: text("version"),
        commit: text("commit"),
        device,
    };
    let mut read = ReadRecord {
        kind: kind.to_owned(),
        program: format!("{}, commit {}", program.version, program.commit),
        definitions: program.definitions,
        device: program.device.clone(),
        measurements: Vec::new(),
        passed: json["pass"].as_bool().filter(|_| kind == "stress"),
    };
    // Only the figures need the fields of a head, so that a record without figures may lack them.
    let figures = figures(kind, json);
    if !figures.is_empty() {
        let head = head(kind, program, json)?;
        let (setting, method) = (setting(&head), method(&head));
        let view = match json["motion"].as_str() {
            Some(motion) => format!("{} ({motion})", head.view),
            None => head.view,
        };
        read.measurements.extend(figures.into_iter().map(|(quantity, value)| Measurement {
            device: 0,
            setting: setting.clone(),
            view: view.clone(),
            method: method.clone(),
            quantity,
            value,
        }));
    }
    Ok(read)
}

/// Returns the figures of a record that can be followed over runs, with their quantities; values that are missing,
/// negative or not finite are left out.
fn figures(kind: &str, json: &Json) -> Vec<(Quantity, f64)> {
    let number = |pointer: &str| json.pointer(pointer).and_then(Json::as_f64);
    let figures = match (kind, json["against"].as_str()) {
        ("time", _) => vec![(Quantity::Time, number("/total/median_ms"))],
        // Every record of a variant in a cell repeats the variant's time; a trend has one value for each view.
        ("error", Some("oracle")) => {
            let wrong_hits = number("/hit_agreement").map(|agreement| (1.0 - agreement).max(0.0));
            vec![(Quantity::WrongHits, wrong_hits), (Quantity::ErrorStudyTime, number("/time_ms"))]
        }
        ("error", Some("screen")) => {
            vec![(Quantity::ScreenRmse, number("/rmse")), (Quantity::ErrorStudyTime, number("/time_ms"))]
        }
        ("error", Some("world")) => {
            vec![(Quantity::WorldRmse, number("/rmse")), (Quantity::ErrorStudyTime, number("/time_ms"))]
        }
        ("motion", _) => vec![(Quantity::MotionDeviation, number("/deviation"))],
        _ => Vec::new(),
    };
    let sound_figure =
        |(quantity, value): (Quantity, Option<f64>)| Some((quantity, value.filter(|v| v.is_finite() && *v >= 0.0)?));
    figures.into_iter().filter_map(sound_figure).collect()
}

/// Reads the first fields of a record. The error names the field that is missing, as the end of a sentence that begins
/// with the record.
fn head(kind: &str, program: Provenance, json: &Json) -> Result<Head, String> {
    let text = |name: &str| json[name].as_str().ok_or_else(|| format!("has no {name}"));
    let pixels = |name: &str| {
        let pixels = json[name].as_u64().and_then(|n| u32::try_from(n).ok());
        pixels.ok_or_else(|| format!("has no {name}"))
    };
    Ok(Head {
        kind: kind.to_owned(),
        program,
        scene: text("scene")?.to_owned(),
        view: text("view")?.to_owned(),
        method: text("method")?.to_owned(),
        preset: json["preset"].as_str().and_then(Preset::of_name).unwrap_or_default(),
        width: pixels("width")?,
        height: pixels("height")?,
        roughness: json["roughness"].as_f64().map(|r| r as f32),
        setup: setup(json),
    })
}

/// Collects everything that was set for a measurement from the parts of a record in which versions of the program have
/// put it.
fn setup(json: &Json) -> RecordedSetup {
    let top_level = FORMERLY_AT_THE_TOP.iter().filter_map(|name| Some(((*name).to_owned(), json.get(name)?.clone())));
    let mut settings: RecordedSetup = top_level.collect();
    for part in ["params", "setup"] {
        let values = json[part].as_object().into_iter().flatten();
        settings.extend(values.map(|(name, value)| (name.clone(), value.clone())));
    }
    settings
}

/// Makes the setting of a record: scene, size, roughness, and the other settings that belong to the place of the
/// measurement.
fn setting(head: &Head) -> Setting {
    let place_settings = PLACE_SETTINGS.iter().filter_map(|name| Some((name, head.setup.get(*name)?)));
    let values = place_settings
        .filter(|(_, value)| !value.is_null())
        .map(|(name, value)| format!("{name} {}", setting_text(value)));
    Setting {
        scene: head.scene.clone(),
        size: [head.width, head.height],
        roughness: head.roughness.map_or_else(|| "own".to_owned(), |r| r.to_string()),
        other_settings: [format!("definitions {}", head.program.definitions)].into_iter().chain(values).collect(),
    }
}

/// Names the method of a record, with its parameters that differ from the preset. The presets of a method from a folder
/// are not known here, so that all of its parameters are named.
fn method(head: &Head) -> String {
    if methods::find(&head.method).is_ok() || [EXACT_HITS, SCREEN_REFERENCE].contains(&&*head.method) {
        return head.variant();
    }
    let effect_names: Vec<_> = EffectParams::table().iter().map(|p| p.name).collect();
    let place_names = ["preset", "width", "height", "roughness"].iter().chain(&PLACE_SETTINGS);
    let other_names: Vec<&str> = place_names.copied().chain(effect_names).collect();
    let method_parameters =
        head.setup.iter().filter(|(name, value)| !other_names.contains(&name.as_str()) && !value.is_null());
    method_parameters
        .fold(head.variant(), |name, (parameter, value)| format!("{name} {parameter} {}", setting_text(value)))
}

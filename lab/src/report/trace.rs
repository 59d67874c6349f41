//! Timed frames as a trace for Chrome (chrome://tracing) and Perfetto: the Trace Event Format, with one process for the
//! host and one for the device, and in each a thread for every method.

use crate::stage::span_ms;
use crate::study::timing::TimedFrame;
use serde_json::{Value, json};

/// The number of the host's process in the trace.
const HOST: u32 = 1;
/// The number of the device's process in the trace.
const DEVICE: u32 = 2;

/// Returns the trace of frames as JSON, in the order in which they ran. Times are in microseconds from the first frame.
/// Host and device have different clocks, so a frame of the device is placed so that it ends when the host saw its end.
pub fn json(frames: &[TimedFrame]) -> String {
    let mut events: Vec<Value> = Vec::new();
    let mut methods: Vec<&String> = Vec::new();
    let begun_us = |f: &TimedFrame| f.report.host.map(|h| h.begun_us);
    let first_us = frames.iter().filter_map(begun_us).min().unwrap_or(0);
    for (process, name) in [(HOST, "host"), (DEVICE, "device")] {
        events.push(json!({"name": "process_name", "ph": "M", "pid": process, "args": {"name": name}}));
    }
    for frame in frames {
        let Some(host) = frame.report.host else { continue };
        let thread = methods.iter().position(|m| **m == frame.method).unwrap_or_else(|| {
            methods.push(&frame.method);
            for process in [HOST, DEVICE] {
                let name = json!({"name": frame.method});
                events.push(json!({
                    "name": "thread_name", "ph": "M", "pid": process, "tid": methods.len() - 1, "args": name,
                }));
            }
            methods.len() - 1
        });
        let mut event = |process: u32, name: &str, category: &str, start_us: f64, ms: f64| {
            events.push(json!({
                "name": name, "cat": category, "ph": "X", "pid": process, "tid": thread, "ts": start_us, "dur": 1e3 * ms,
                "args": {"frame": frame.label},
            }));
        };
        let start_us = (host.begun_us - first_us) as f64;
        let submitted_us = start_us + 1e3 * host.record_ms;
        event(HOST, "record", "host", start_us, host.record_ms);
        event(HOST, "wait", "host", submitted_us, host.wait_ms);
        // Passes begin below zero if they drew the scene before this frame, for several methods.
        let [first_ms, end_ms] = span_ms(&frame.report);
        let on_device_us = submitted_us + 1e3 * (host.wait_ms - end_ms).max(0.0);
        event(DEVICE, &frame.label, "frame", on_device_us + 1e3 * first_ms, end_ms - first_ms);
        for pass in &frame.report.passes {
            let category = if pass.counted { "effect" } else { "scene" };
            event(DEVICE, &pass.name, category, on_device_us + 1e3 * pass.start_ms, pass.ms);
        }
    }
    json!({"displayTimeUnit": "ms", "traceEvents": events}).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use ssct::gpu::frame::HostTime;
    use ssct::gpu::{FrameReport, PassTime};

    #[test]
    fn passes_lie_within_their_frame_and_frames_follow_each_other() {
        let pass = |name: &str, start_ms: f64| PassTime { name: name.into(), ms: 2.0, start_ms, counted: true };
        let frame = |begun_us: u64| TimedFrame {
            method: "ssct".to_owned(),
            label: "64x36, sample 0".into(),
            report: FrameReport {
                passes: vec![pass("a", 0.5), pass("b", 2.5)],
                frame_ms: 5.0,
                host: Some(HostTime { begun_us, record_ms: 1.0, wait_ms: 6.0 }),
                ..FrameReport::default()
            },
        };
        let text = json(&[frame(1_000_000), frame(1_010_000)]);
        let trace: Value = serde_json::from_str(&text).unwrap();
        let events = trace["traceEvents"].as_array().unwrap();
        let timed: Vec<_> = events.iter().filter(|e| e["ph"] == "X").collect();
        assert_eq!(timed.len(), 2 * (2 + 1 + 2));
        let starts = |name: &str| {
            timed.iter().filter(|e| e["name"] == name).map(|e| e["ts"].as_f64().unwrap()).collect::<Vec<_>>()
        };
        // Submitted after 1 ms, done after 7: the last pass ends there, 4.5 ms after the frame's first timestamp.
        assert_eq!(starts("a"), [3000.0, 13000.0]);
        assert_eq!(starts("record"), [0.0, 10000.0]);
    }

    #[test]
    fn a_scene_that_was_drawn_for_another_method_is_shown_when_it_was_drawn() {
        let pass =
            |name: &str, start_ms: f64| PassTime { name: name.into(), ms: 2.0, start_ms, counted: start_ms >= 0.0 };
        let report = FrameReport {
            passes: vec![pass("scene", -4.0), pass("a", 0.5)],
            host: Some(HostTime { begun_us: 1_000_000, record_ms: 1.0, wait_ms: 6.0 }),
            ..FrameReport::default()
        };
        let text = json(&[TimedFrame { method: "ssct".to_owned(), label: "sample 0".into(), report }]);
        let trace: Value = serde_json::from_str(&text).unwrap();
        let event = |name: &str| trace["traceEvents"].as_array().unwrap().iter().find(|e| e["name"] == name).unwrap();
        let times = |name: &str| ["ts", "dur"].map(|field| event(name)[field].as_f64().unwrap());
        // The device is done 7 ms after the frame was begun, and the method's pass ends then, 2.5 ms after the first timestamp.
        assert_eq!(times("a"), [5000.0, 2000.0]);
        assert_eq!(times("scene"), [500.0, 2000.0]);
        assert_eq!(times("sample 0"), [500.0, 6500.0]);
    }
}

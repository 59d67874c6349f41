//! The journal of a study has the results so far, so that nothing is lost or measured twice, whatever ends the study. A
//! study asks the journal before each measurement, and adds the result afterwards. The caller decides where the
//! journal's lines are written.

use super::record::Provenance;
use crate::error::Result;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use ssct::gpu::Gpu;
use ssct_scenes::Scene;
use std::collections::HashMap;

/// A function that writes a line, given without its line ending, to where the caller keeps the journal.
pub type Sink = Box<dyn FnMut(&str) -> Result<()>>;

/// Results of measurements, each under a key. A sink, if there is one, gets a line for each new result.
#[derive(Default)]
pub struct Journal {
    /// The known results, by key.
    results: HashMap<String, Value>,
    /// Where the lines of new results go.
    sink: Option<Sink>,
}

impl Journal {
    /// Makes a journal that has the entries of some lines, and writes new entries to a sink, if given. Lines that are
    /// no entries are ignored.
    pub fn resume<'l>(lines: impl Iterator<Item = &'l str>, sink: Option<Sink>) -> Self {
        Self { results: lines.filter_map(entry).collect(), sink }
    }

    /// Returns the result with a key; `None` if there is none, or if it cannot be read as type `T`.
    pub fn get<T: DeserializeOwned>(&self, key: &str) -> Option<T> {
        T::deserialize(self.results.get(key)?).ok()
    }

    /// Returns the keys of all known results, in no order.
    pub fn keys(&self) -> impl Iterator<Item = &str> {
        self.results.keys().map(String::as_str)
    }

    /// Returns the result with a key as JSON.
    pub fn value(&self, key: &str) -> Option<&Value> {
        self.results.get(key)
    }

    /// Adds an entry of another journal, and writes its line to the sink unchanged. A line that is no entry is ignored.
    ///
    /// # Errors
    /// Errors of the sink.
    pub fn add_line(&mut self, line: &str) -> Result<()> {
        let Some((key, value)) = entry(line) else { return Ok(()) };
        if let Some(sink) = &mut self.sink {
            sink(line)?;
        }
        self.results.insert(key, value);
        Ok(())
    }

    /// Adds a result under a key, and writes its line to the sink.
    ///
    /// # Errors
    /// Errors of the sink.
    pub fn put<T: Serialize>(&mut self, key: String, result: &T) -> Result<()> {
        let value = json!(result);
        if let Some(sink) = &mut self.sink {
            sink(&json!({ "key": key, "value": value }).to_string())?;
        }
        self.results.insert(key, value);
        Ok(())
    }
}

/// Reads the key and the value of a line, which is the JSON object `{"key": …, "value": …}`; `None` for any other line.
pub fn entry(line: &str) -> Option<(String, Value)> {
    let mut entry: Value = serde_json::from_str(line).ok()?;
    Some((entry["key"].as_str()?.to_owned(), entry.get_mut("value")?.take()))
}

/// Reads the key of a line; `None` for a line that is no entry.
pub fn key_of(line: &str) -> Option<String> {
    entry(line).map(|(key, _)| key)
}

/// Returns the digest of everything that a result depends on: program, device, and `settings`, which may include the
/// scene's digest. Results that differ in any of these have different digests.
pub fn digest(gpu: &Gpu, settings: &Value) -> String {
    let mut hash = Sha256::new();
    hash.update(json!(Provenance::on(gpu)).to_string());
    hash.update(settings.to_string());
    short_hex(hash)
}

/// Returns the digest of settings alone, which is equal on every machine and device.
pub fn setup_digest(settings: &Value) -> String {
    let mut hash = Sha256::new();
    hash.update(settings.to_string());
    short_hex(hash)
}

/// Returns the digest of a scene: of its name, lens, materials, lights, area lights, probes, impostors, motions,
/// captures, triangles and textures. Views, paths of a camera and the names of meshes are left out.
pub fn scene_digest(scene: &Scene) -> String {
    let mut hash = Sha256::new();
    hash.update(format!("{} {:?} {:?} {:?}", scene.name, scene.lens, scene.materials, scene.lights));
    hash.update(format!("{:?} {:?} {:?}", scene.probes, scene.impostors, scene.area_lights));
    scene.motions.iter().for_each(|motion| hash.update(format!("{motion:?}")));
    scene.captures.iter().for_each(|capture| hash.update(format!("{capture:?}")));
    for mesh in &scene.meshes {
        hash.update(bytemuck::cast_slice::<_, u8>(&mesh.vertices));
        hash.update(bytemuck::cast_slice::<_, u8>(&mesh.indices));
        hash.update(mesh.material.to_le_bytes());
    }
    for texture in &scene.textures {
        hash.update(format!("{}x{} {:?}", texture.width, texture.height, texture.encoding));
        hash.update(&texture.rgba);
    }
    short_hex(hash)
}

/// Returns the first 8 bytes of a hash, as 16 hexadecimal digits.
fn short_hex(hash: Sha256) -> String {
    hash.finalize().iter().take(8).map(|b| format!("{b:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use ssct_scenes::Capture;
    use std::cell::RefCell;
    use std::rc::Rc;

    #[test]
    fn a_journal_returns_its_results_and_another_resumes_from_its_lines() {
        let lines = Rc::new(RefCell::new(Vec::new()));
        let sink_lines = Rc::clone(&lines);
        let sink: Sink = Box::new(move |line| {
            sink_lines.borrow_mut().push(line.to_owned());
            Ok(())
        });
        let mut journal = Journal::resume([].into_iter(), Some(sink));
        // An inexact parser of decimals would round these numbers.
        let value = vec![0.1 + 0.2, 5e-324, 1.797_693_134_862_315_7e308, 122.416_294_033_786_58];
        journal.put("a".into(), &value).unwrap();
        assert_eq!(journal.get::<Vec<f64>>("a").as_ref(), Some(&value));
        assert_eq!(journal.get::<String>("a"), None);
        let lines = lines.borrow();
        let no_entries = ["", "{\"key\":\"b\"", "{\"finished\":true}"];
        let resumed = Journal::resume(lines.iter().map(String::as_str).chain(no_entries), None);
        assert_eq!(resumed.get::<Vec<f64>>("a").as_ref(), Some(&value));
        assert!(resumed.value("a").is_some() && resumed.value("b").is_none());
    }

    #[test]
    fn a_moved_capture_changes_the_digest_of_its_scene() {
        let captured = |x: f32| Scene { captures: vec![Capture::placed_at(Vec3::X * x)], ..Scene::default() };
        let [none, first, second] = [Scene::default(), captured(0.0), captured(1.0)].map(|scene| scene_digest(&scene));
        assert!(none != first && first != second);
    }
}

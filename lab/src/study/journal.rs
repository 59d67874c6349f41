//! What a study has measured so far, so that whatever ends it, nothing is lost or measured twice. A
//! study asks the journal before it measures and tells it after; where the lines go is the caller's.

use super::record::Provenance;
use crate::error::Result;
use crate::gpu::Gpu;
use crate::scene::Scene;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use std::collections::HashMap;

/// Takes a line, without its end, to where it is kept.
pub type Sink = Box<dyn FnMut(&str) -> Result<()>>;

/// Results under keys.
#[derive(Default)]
pub struct Journal {
    known: HashMap<String, Value>,
    sink: Option<Sink>,
}

impl Journal {
    /// A journal that goes on from some lines, and keeps its own in a sink. Lines that are no entry are
    /// left out.
    pub fn resume<'l>(lines: impl Iterator<Item = &'l str>, sink: Option<Sink>) -> Self {
        Self { known: lines.filter_map(entry).collect(), sink }
    }

    /// A result that is known, if it reads as what it should be.
    pub fn get<T: DeserializeOwned>(&self, key: &str) -> Option<T> {
        T::deserialize(self.known.get(key)?).ok()
    }

    /// The keys of everything that is known.
    pub fn keys(&self) -> impl Iterator<Item = &str> {
        self.known.keys().map(String::as_str)
    }

    /// A known result, as the journal keeps it.
    pub fn value(&self, key: &str) -> Option<&Value> {
        self.known.get(key)
    }

    /// Keeps an entry of another journal, whose line is copied as it stands there. A line that is no entry is left out.
    ///
    /// # Errors
    /// Errors of the sink.
    pub fn keep_line(&mut self, line: &str) -> Result<()> {
        let Some((key, value)) = entry(line) else { return Ok(()) };
        if let Some(sink) = &mut self.sink {
            sink(line)?;
        }
        self.known.insert(key, value);
        Ok(())
    }

    /// Keeps a result.
    ///
    /// # Errors
    /// Errors of the sink.
    pub fn put<T: Serialize>(&mut self, key: String, result: &T) -> Result<()> {
        let value = json!(result);
        if let Some(sink) = &mut self.sink {
            sink(&json!({ "key": key, "value": value }).to_string())?;
        }
        self.known.insert(key, value);
        Ok(())
    }
}

/// Key and value of a line; `None` of a line that is no entry.
pub fn entry(line: &str) -> Option<(String, Value)> {
    let mut entry: Value = serde_json::from_str(line).ok()?;
    Some((entry["key"].as_str()?.to_owned(), entry.get_mut("value")?.take()))
}

/// The key of a line; `None` of a line that is no entry.
pub fn key_of(line: &str) -> Option<String> {
    entry(line).map(|(key, _)| key)
}

/// A short name for everything that a result depends on: program, device, and settings, of which the
/// scene's may be one. Two that differ in any of it have different names.
pub fn digest(gpu: &Gpu, settings: &Value) -> String {
    let mut hash = Sha256::new();
    hash.update(json!(Provenance::on(gpu)).to_string());
    hash.update(settings.to_string());
    name(hash)
}

/// A short name for settings alone, the same on every machine and device.
pub fn setup_digest(settings: &Value) -> String {
    let mut hash = Sha256::new();
    hash.update(settings.to_string());
    name(hash)
}

/// A digest of a scene's whole content, without its views.
pub fn scene_digest(scene: &Scene) -> String {
    let mut hash = Sha256::new();
    hash.update(format!("{} {:?} {:?} {:?}", scene.name, scene.lens, scene.materials, scene.lights));
    hash.update(format!("{:?} {:?} {:?}", scene.probes, scene.impostors, scene.area_lights));
    scene.motions.iter().for_each(|motion| hash.update(format!("{motion:?}")));
    for mesh in &scene.meshes {
        hash.update(bytemuck::cast_slice::<_, u8>(&mesh.vertices));
        hash.update(bytemuck::cast_slice::<_, u8>(&mesh.indices));
        hash.update(mesh.material.to_le_bytes());
    }
    for texture in &scene.textures {
        hash.update(format!("{}x{} {:?}", texture.width, texture.height, texture.encoding));
        hash.update(&texture.rgba);
    }
    name(hash)
}

fn name(hash: Sha256) -> String {
    hash.finalize().iter().take(8).map(|b| format!("{b:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::RefCell;
    use std::rc::Rc;

    #[test]
    fn what_is_put_is_there_and_in_the_lines_that_another_goes_on_from() {
        let lines = Rc::new(RefCell::new(Vec::new()));
        let kept = Rc::clone(&lines);
        let sink: Sink = Box::new(move |line| {
            kept.borrow_mut().push(line.to_owned());
            Ok(())
        });
        let mut journal = Journal::resume([].into_iter(), Some(sink));
        // A number that a careless reader of decimals rounds.
        let value = vec![0.1 + 0.2, 5e-324, 1.797_693_134_862_315_7e308, 122.416_294_033_786_58];
        journal.put("a".into(), &value).unwrap();
        assert_eq!(journal.get::<Vec<f64>>("a").as_ref(), Some(&value));
        assert_eq!(journal.get::<String>("a"), None);
        let lines = lines.borrow();
        let torn = ["", "{\"key\":\"b\"", "{\"finished\":true}"];
        let again = Journal::resume(lines.iter().map(String::as_str).chain(torn), None);
        assert_eq!(again.get::<Vec<f64>>("a").as_ref(), Some(&value));
        assert!(again.value("a").is_some() && again.value("b").is_none());
    }
}

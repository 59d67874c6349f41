//! The pipelines that a device keeps, even those that nobody uses now, to return them if they are asked for again. A
//! driver takes long to compile a pipeline: under GPU-assisted validation, half a minute for some.

use super::device::Gpu;
use super::pipeline::{DepthState, SharedPipeline};
use crate::error::Result;
use ash::vk;
use std::collections::HashMap;
use std::hash::Hash;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The number of kept pipelines. Above it, each new one replaces the unused one that was least recently asked for.
const KEPT: usize = 512;

/// The compiled pipelines that a device keeps.
#[derive(Default)]
pub(crate) struct Pipelines(Mutex<KeyedCache<Key, SharedPipeline>>);

/// A cache of shared values (`things`), each under a key.
struct KeyedCache<K, T> {
    /// By key: the value of `asked` when the thing was last asked for, and the thing.
    things: HashMap<K, (u64, Arc<T>)>,
    /// Number of times that somebody asked for a thing.
    asked: u64,
}

/// The properties in which two pipelines may differ.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Default)]
pub(super) struct Key {
    /// Names of the vertex and the fragment shader, or of the compute shader alone.
    pub shaders: [Option<&'static str>; 2],
    /// Ids and bits of the specialization constants.
    pub constants: Vec<(u32, u32)>,
    pub targets: Vec<vk::Format>,
    pub depth: Option<DepthState>,
    pub vertices: VerticesKey,
}

/// The source of the vertices.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Default)]
pub(super) enum VerticesKey {
    /// Corners of triangles that the shader makes from the number of the vertex.
    #[default]
    Triangles,
    /// Points that the shader makes from the number of the vertex.
    Points,
    /// Corners of triangles from a buffer: bytes from one vertex to the next, and format and offset of each location.
    Meshes(u32, Vec<(vk::Format, u32)>),
}

impl Gpu {
    /// Returns the pipeline that is kept under a key, or keeps the one that `make` compiles.
    pub(super) fn kept_pipeline(
        &self,
        key: Key,
        make: impl FnOnce() -> Result<SharedPipeline>,
    ) -> Result<Arc<SharedPipeline>> {
        // A pipeline of replaced code is not kept, because a window may change the code again.
        #[cfg(feature = "reload")]
        if key.shaders.iter().flatten().any(|name| self.shared().replaced_shaders.get(name).is_some()) {
            return Ok(Arc::new(make()?));
        }
        let pipelines = &self.shared().pipelines;
        if let Some(kept) = pipelines.lock().get(&key) {
            return Ok(kept);
        }
        // The pipeline is compiled without the lock, since compiling takes long.
        let made = Arc::new(make()?);
        Ok(pipelines.lock().insert(key, made))
    }

    /// Destroys the pipelines that nothing uses now.
    pub fn trim(&self) {
        self.shared().pipelines.lock().trim();
    }
}

impl Pipelines {
    fn lock(&self) -> MutexGuard<'_, KeyedCache<Key, SharedPipeline>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Destroys all pipelines, before their device is destroyed.
    pub fn clear(&mut self) {
        self.0.get_mut().unwrap_or_else(PoisonError::into_inner).things.clear();
    }
}

impl<K, T> Default for KeyedCache<K, T> {
    fn default() -> Self {
        Self { things: HashMap::new(), asked: 0 }
    }
}

impl<K: Clone + Eq + Hash, T> KeyedCache<K, T> {
    /// Returns the thing under a key, if there is one, and notes that somebody asked for it.
    fn get(&mut self, key: &K) -> Option<Arc<T>> {
        self.asked += 1;
        let (asked, thing) = self.things.get_mut(key)?;
        *asked = self.asked;
        Some(Arc::clone(thing))
    }

    /// Keeps a thing that was made, or returns the kept one if another thread was faster.
    fn insert(&mut self, key: K, made: Arc<T>) -> Arc<T> {
        if let Some(kept) = self.get(&key) {
            return kept;
        }
        if self.things.len() >= KEPT {
            let unused = self.things.iter().filter(|(_, (_, thing))| Arc::strong_count(thing) == 1);
            let oldest = unused.min_by_key(|(_, (asked, _))| *asked).map(|(key, _)| key.clone());
            oldest.and_then(|key| self.things.remove(&key));
        }
        self.things.insert(key, (self.asked, Arc::clone(&made)));
        made
    }

    /// Drops the things that nobody uses now.
    fn trim(&mut self) {
        self.things.retain(|_, (_, thing)| Arc::strong_count(thing) > 1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_key_has_one_thing_however_many_ask() {
        let mut kept = KeyedCache::default();
        let first = kept.insert("a", Arc::new(1));
        assert!(Arc::ptr_eq(&first, &kept.insert("a", Arc::new(2))));
        assert!(Arc::ptr_eq(&first, &kept.get(&"a").unwrap()));
        assert!(kept.get(&"b").is_none());
    }

    #[test]
    fn the_one_that_was_unused_longest_goes_first() {
        let mut kept = KeyedCache::default();
        let used = kept.insert(0, Arc::new(0));
        (1..KEPT).for_each(|n| drop(kept.insert(n, Arc::new(n))));
        // Asked for again, so that 2 is the oldest that nobody uses.
        drop(kept.get(&1));
        drop(kept.insert(KEPT, Arc::new(KEPT)));
        assert_eq!(kept.things.len(), KEPT);
        assert!([0, 1, 3, KEPT].iter().all(|n| kept.things.contains_key(n)) && !kept.things.contains_key(&2));
        kept.trim();
        assert_eq!(kept.things.keys().collect::<Vec<_>>(), [&0]);
        drop(used);
        kept.trim();
        assert!(kept.things.is_empty());
    }

    #[test]
    fn more_are_kept_while_all_are_used() {
        let mut kept = KeyedCache::default();
        let used: Vec<_> = (0..KEPT + 3).map(|n| kept.insert(n, Arc::new(n))).collect();
        assert_eq!(kept.things.len(), used.len());
    }
}

//! The pipelines that a device keeps, even those that nobody uses now, to return them if they are asked for again. A
//! driver takes long to compile a pipeline: under GPU-assisted validation, half a minute for some.

use super::device::Gpu;
use super::pipeline::{DepthState, SharedPipeline};
use crate::error::Result;
use ash::vk;
use std::collections::HashMap;
use std::hash::Hash;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The most pipelines that are kept, unless more are in use. A new one then replaces the unused one that was asked for least recently.
const PIPELINE_LIMIT: usize = 512;

/// The compiled pipelines that a device keeps.
#[derive(Default)]
pub(crate) struct Pipelines(Mutex<KeyedCache<Key, SharedPipeline>>);

/// A cache of shared values, each under a key.
struct KeyedCache<K, T> {
    /// By key: the number of the last request for the value, and the value.
    values: HashMap<K, (u64, Arc<T>)>,
    /// The number of requests so far, for any value.
    requests: u64,
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
    pub(super) fn cached_pipeline(
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
        let compiled = Arc::new(make()?);
        Ok(pipelines.lock().insert(key, compiled))
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
        self.0.get_mut().unwrap_or_else(PoisonError::into_inner).values.clear();
    }
}

impl<K, T> Default for KeyedCache<K, T> {
    fn default() -> Self {
        Self { values: HashMap::new(), requests: 0 }
    }
}

impl<K: Clone + Eq + Hash, T> KeyedCache<K, T> {
    /// Returns the value under a key, if there is one, and counts the request.
    fn get(&mut self, key: &K) -> Option<Arc<T>> {
        self.requests += 1;
        let (last_request, value) = self.values.get_mut(key)?;
        *last_request = self.requests;
        Some(Arc::clone(value))
    }

    /// Keeps a new value, and returns it, or returns the kept value if another thread was faster.
    fn insert(&mut self, key: K, new: Arc<T>) -> Arc<T> {
        if let Some(kept) = self.get(&key) {
            return kept;
        }
        if self.values.len() >= PIPELINE_LIMIT {
            let unused = self.values.iter().filter(|(_, (_, value))| Arc::strong_count(value) == 1);
            let oldest = unused.min_by_key(|(_, (last_request, _))| *last_request).map(|(key, _)| key.clone());
            oldest.and_then(|key| self.values.remove(&key));
        }
        self.values.insert(key, (self.requests, Arc::clone(&new)));
        new
    }

    /// Drops the values that nobody uses now.
    fn trim(&mut self) {
        self.values.retain(|_, (_, value)| Arc::strong_count(value) > 1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_key_has_one_value_however_many_ask() {
        let mut kept = KeyedCache::default();
        let first = kept.insert("a", Arc::new(1));
        assert!(Arc::ptr_eq(&first, &kept.insert("a", Arc::new(2))));
        assert!(Arc::ptr_eq(&first, &kept.get(&"a").unwrap()));
        assert!(kept.get(&"b").is_none());
    }

    #[test]
    fn a_full_cache_drops_the_unused_value_that_was_asked_for_least_recently() {
        let mut kept = KeyedCache::default();
        let used = kept.insert(0, Arc::new(0));
        (1..PIPELINE_LIMIT).for_each(|n| drop(kept.insert(n, Arc::new(n))));
        // 1 is asked for again, so that 2 is the oldest that nobody uses.
        drop(kept.get(&1));
        drop(kept.insert(PIPELINE_LIMIT, Arc::new(PIPELINE_LIMIT)));
        assert_eq!(kept.values.len(), PIPELINE_LIMIT);
        assert!([0, 1, 3, PIPELINE_LIMIT].iter().all(|n| kept.values.contains_key(n)) && !kept.values.contains_key(&2));
        kept.trim();
        assert_eq!(kept.values.keys().collect::<Vec<_>>(), [&0]);
        drop(used);
        kept.trim();
        assert!(kept.values.is_empty());
    }

    #[test]
    fn values_in_use_are_kept_beyond_the_limit() {
        let mut kept = KeyedCache::default();
        let used: Vec<_> = (0..PIPELINE_LIMIT + 3).map(|n| kept.insert(n, Arc::new(n))).collect();
        assert_eq!(kept.values.len(), used.len());
    }
}

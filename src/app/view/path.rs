//! Camera key frames: recorded, saved, loaded and played. The files are those of `ssct time --path`.

use super::fly_camera::FlyCamera;
use crate::error::Result;
use crate::report::files;
use crate::scene::path::{CameraPath, KeyFrame};
use glam::Vec3;
use std::path::Path;

/// Key frames that are being recorded, and their playing.
pub struct PathEditor {
    /// In their order.
    pub keys: Vec<KeyFrame>,
    /// Where they are saved.
    pub file: String,
    /// What was last said of saving, loading or playing.
    pub message: String,
    /// Seconds that playing takes.
    pub seconds: f32,
    playing: Option<(CameraPath, f32)>,
}

impl Default for PathEditor {
    fn default() -> Self {
        Self { keys: Vec::new(), file: "path.toml".into(), message: String::new(), seconds: 8.0, playing: None }
    }
}

impl PathEditor {
    /// Adds where the camera is.
    pub fn record(&mut self, camera: &FlyCamera) {
        let (eye, look_at) = camera.place();
        self.keys.push(KeyFrame { eye, look_at, time_s: None });
        // Times of a loaded path would not fit what was added.
        self.keys.iter_mut().for_each(|k| k.time_s = None);
        self.message = format!("key frame {} recorded", self.keys.len());
    }

    /// The path through the key frames.
    pub fn path(&self) -> Result<CameraPath> {
        let stem = Path::new(&self.file).file_stem().map_or("path".into(), |s| s.to_string_lossy());
        // Only the stem of "path.toml" or "path.path.toml".
        CameraPath::new(stem.split('.').next().unwrap_or("path"), self.keys.clone())
    }

    /// Writes the file.
    pub fn save(&mut self) {
        let path = Path::new(&self.file);
        let saved = self.path().and_then(|p| files::write(path, p.to_toml().as_bytes()));
        self.message = match saved {
            Ok(()) => format!("saved as {}", self.file),
            Err(e) => e.to_string(),
        };
    }

    /// Reads a file; what was recorded is replaced.
    ///
    /// # Errors
    /// As [`CameraPath::load`].
    pub fn load(&mut self, file: &Path) -> Result<()> {
        let path = CameraPath::load(file)?;
        self.keys = path.keys().to_vec();
        self.file = file.display().to_string();
        self.message = format!("{} key frames of {}", self.keys.len(), path.name);
        Ok(())
    }

    /// Begins to play, or stops.
    pub fn play_or_stop(&mut self) {
        if self.playing.take().is_none() {
            match self.path() {
                Ok(path) => self.playing = Some((path, 0.0)),
                Err(e) => self.message = e.to_string(),
            }
        }
    }

    /// The share of the way played, while it is.
    pub fn playing(&self) -> Option<f32> {
        self.playing.as_ref().map(|(_, share)| *share)
    }

    /// Where the camera is after some more seconds, while it plays; at its end, playing ends.
    pub fn advance(&mut self, seconds: f32) -> Option<(Vec3, Vec3)> {
        let (path, share) = self.playing.as_mut()?;
        *share += seconds / self.seconds.max(0.1);
        let place = path.at(*share);
        if *share >= 1.0 {
            self.playing = None;
        }
        Some(place)
    }
}

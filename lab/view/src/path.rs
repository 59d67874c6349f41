//! Records, saves, loads and plays key frames of the camera. `ssct path` reads the same files.

use super::fly_camera::FlyCamera;
use glam::Vec3;
use ssct_lab::error::Result;
use ssct_lab::report::files;
use ssct_scenes::path::{self, CameraPath, KeyFrame};
use std::path::Path;

/// The recorded key frames and the state of their playback.
pub struct PathEditor {
    /// The key frames in order.
    pub keys: Vec<KeyFrame>,
    /// The file in which they are saved.
    pub file: String,
    /// A message about the last recording, saving, loading or playing.
    pub message: String,
    /// The duration of the playback in seconds.
    pub seconds: f32,
    /// The path that is played, and the share of it that was played; `None` if nothing is played.
    playing: Option<(CameraPath, f32)>,
}

impl Default for PathEditor {
    fn default() -> Self {
        Self { keys: Vec::new(), file: "path.toml".into(), message: String::new(), seconds: 8.0, playing: None }
    }
}

impl PathEditor {
    /// Adds a key frame at the camera's current position.
    pub fn record(&mut self, camera: &FlyCamera) {
        let (eye, look_at) = camera.place();
        self.keys.push(KeyFrame { eye, look_at, time_s: None });
        // The times of a loaded path would not fit the added key frame.
        self.keys.iter_mut().for_each(|k| k.time_s = None);
        self.message = format!("key frame {} recorded", self.keys.len());
    }

    /// Returns the path through the key frames, named after the file.
    pub fn path(&self) -> Result<CameraPath> {
        let stem = Path::new(&self.file).file_stem().map_or("path".into(), |s| s.to_string_lossy());
        // The name ends at the first dot, since a file may be called "hall.path.toml".
        Ok(CameraPath::new(stem.split('.').next().unwrap_or("path"), self.keys.clone())?)
    }

    /// Writes the key frames to the file. The message says whether this succeeded.
    pub fn save(&mut self) {
        let path = Path::new(&self.file);
        let saved = self.path().and_then(|p| Ok(files::write(path, path::to_toml(&p).as_bytes())?));
        self.message = match saved {
            Ok(()) => format!("saved as {}", self.file),
            Err(e) => e.to_string(),
        };
    }

    /// Reads a file, whose key frames replace the recorded ones.
    ///
    /// # Errors
    /// The errors of [`path::load`].
    pub fn load(&mut self, file: &Path) -> Result<()> {
        let path = path::load(file)?;
        self.keys = path.keys().to_vec();
        self.file = file.display().to_string();
        self.message = format!("{} key frames of {}", self.keys.len(), path.name);
        Ok(())
    }

    /// Starts the playback, or stops it if it is running.
    pub fn play_or_stop(&mut self) {
        if self.playing.take().is_none() {
            match self.path() {
                Ok(path) => self.playing = Some((path, 0.0)),
                Err(e) => self.message = e.to_string(),
            }
        }
    }

    /// Returns the share of the path that was played, 0 to 1; `None` if nothing is played.
    pub fn playing(&self) -> Option<f32> {
        self.playing.as_ref().map(|(_, share)| *share)
    }

    /// Plays on by `seconds`. Returns the camera's eye and the point that it looks at then; `None` if nothing is
    /// played. The playback stops at the end of the path.
    pub fn advance(&mut self, seconds: f32) -> Option<(Vec3, Vec3)> {
        let (path, share) = self.playing.as_mut()?;
        *share += seconds / self.seconds.max(0.1);
        let place = path.eye_and_look_at(*share);
        if *share >= 1.0 {
            self.playing = None;
        }
        Some(place)
    }
}

//! The data from which a viewer is built. The command prepares the data before there is a window.

use super::path::PathEditor;
use super::reload::ShaderWatch;
use super::state::State;
use super::viewer::{Shaders, Viewer, Wake};
use ash::vk;
use ssct::gpu::Gpu;
use ssct_lab::app::cli::SceneOptions;
use ssct_lab::error::Result;
use ssct_scenes::Scene;
use std::path::PathBuf;

/// The data from which the viewer is built once there is a window.
pub struct ViewerSetup {
    /// The scene.
    pub scene: Scene,
    /// The initial state.
    pub state: State,
    /// The options that selected the scene.
    pub place: SceneOptions,
    /// The camera key frames.
    pub path: PathEditor,
    /// The folder whose shaders are watched.
    pub shaders: Option<PathBuf>,
}

impl ViewerSetup {
    /// Builds the viewer for a screen image of the given format. Other threads call `wake` when they have something to
    /// show.
    pub fn build_viewer(self, gpu: &Gpu, screen: vk::Format, wake: Wake) -> Result<Viewer> {
        let mut viewer = Viewer::new(gpu, self.scene, self.state, self.place, screen, wake.clone())?;
        viewer.path = self.path;
        if let Some(folder) = self.shaders {
            let changes = ShaderWatch::new(&folder)?.start(move || wake());
            viewer.watch(Shaders { folder: folder.display().to_string(), changes, statuses: Vec::new() });
        }
        Ok(viewer)
    }
}

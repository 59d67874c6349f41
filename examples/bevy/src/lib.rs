//! Reflections of `ssct` in Bevy's deferred renderer, in place of Bevy's own.
//!
//! ```no_run
//! use bevy::prelude::*;
//! use bevy::render::RenderPlugin;
//! use embed_bevy::{SsctPlugin, SsctReflections, render_creation};
//!
//! fn main() -> embed_bevy::Result<()> {
//!     let render = RenderPlugin { render_creation: render_creation()?, ..default() };
//!     App::new().add_plugins((DefaultPlugins.set(render), SsctPlugin::default())).add_systems(Startup, set_up).run();
//!     Ok(())
//! }
//!
//! fn set_up(mut commands: Commands) {
//!     commands.spawn((Camera3d::default(), Msaa::Off, SsctReflections::default()));
//! }
//! ```

mod device;
mod images;
mod passes;
mod reflect;
pub mod truth;
mod world;

pub use device::{Result, render_creation};
pub use images::KeepImages;
pub use world::{LightOnMeshes, NotReflected, WorldMeshes};

use bevy::camera::Hdr;
use bevy::core_pipeline::core_3d::main_opaque_pass_3d;
use bevy::core_pipeline::prepass::{DeferredPrepass, DepthPrepass};
use bevy::core_pipeline::schedule::{Core3d, Core3dSystems};
use bevy::pbr::deferred::deferred_lighting;
use bevy::pbr::{DefaultOpaqueRendererMethod, prepare_ssr_pipelines};
use bevy::prelude::*;
use bevy::render::{ExtractSchedule, Render, RenderApp, RenderStartup, RenderSystems};
use std::ops::Range;

/// Reflections of a camera by `ssct`, in place of Bevy's `ScreenSpaceReflections`. The camera must cover its whole target.
#[derive(Component, Clone, Debug, PartialEq)]
#[require(Hdr)]
pub struct SsctReflections {
    /// A method of `ssct`: `unified`, or `traced`, whose rays all go among the world's meshes.
    pub method: String,
    /// Parameters of the method by name, as docs/options.md of `ssct` lists them.
    pub parameters: Vec<(String, String)>,
    /// Perceptual roughness at which reflections begin to fade out into the environment map, and at which the map alone
    /// is left.
    pub max_perceptual_roughness: Range<f32>,
    /// Averages reflections over frames.
    pub history: bool,
    /// Follows rays that leave the screen through the world's meshes.
    pub world: bool,
}

impl Default for SsctReflections {
    fn default() -> Self {
        Self {
            method: "unified".into(),
            parameters: Vec::new(),
            max_perceptual_roughness: 0.55..0.6,
            history: false,
            world: true,
        }
    }
}

impl SsctReflections {
    /// Returns the settings for a world. The colour of a mesh is exact if the mesh is unlit; of a lit mesh, only the
    /// screen shows the exact colour. So if no mesh is lit, hits take the colours of the meshes.
    fn for_world(&self, world: &WorldMeshes) -> Self {
        let mut settings = self.clone();
        let is_chosen = settings.parameters.iter().any(|(name, _)| name.replace('_', "-") == "hit-color");
        if settings.world && settings.method == "unified" && !world.is_lit && !is_chosen {
            settings.parameters.push(("hit-color".into(), "triangles".into()));
        }
        settings
    }
}

/// Draws the reflections of cameras with [`SsctReflections`]. Bevy's `RenderPlugin` must use [`render_creation`]. With
/// this plugin, all opaque materials are drawn deferred, and every 3D camera gets the prepasses that show them.
#[derive(Default)]
pub struct SsctPlugin;

/// Gives every 3D camera the prepasses of deferred shading. The plugin draws all opaque meshes deferred, and a camera
/// without the prepasses would not show them.
fn add_deferred_prepasses(mut commands: Commands, cameras: Query<Entity, (With<Camera3d>, Without<DeferredPrepass>)>) {
    for camera in &cameras {
        commands.entity(camera).insert((DepthPrepass, DeferredPrepass));
    }
}

impl Plugin for SsctPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<WorldMeshes>()
            .init_resource::<LightOnMeshes>()
            .insert_resource(DefaultOpaqueRendererMethod::deferred())
            .add_systems(PostUpdate, add_deferred_prepasses)
            .add_systems(Last, world::gather);
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else { return };
        render_app
            .init_resource::<WorldMeshes>()
            .add_systems(RenderStartup, reflect::start)
            .add_systems(ExtractSchedule, (world::extract, reflect::extract))
            .add_systems(
                Render,
                (
                    reflect::begin.in_set(RenderSystems::PrepareAssets),
                    reflect::leave_out_bevys.in_set(RenderSystems::Prepare).after(prepare_ssr_pipelines),
                    images::write.after(RenderSystems::Render).before(RenderSystems::Cleanup),
                ),
            )
            .add_systems(
                Core3d,
                reflect::reflect.after(deferred_lighting).before(main_opaque_pass_3d).in_set(Core3dSystems::MainPass),
            );
    }
}

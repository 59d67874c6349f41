//! The cells of the error study: scene, view, size and roughness. What `ssct error` and `ssct study`
//! share. A cell that a folder has, measured with the same settings, is kept.

use crate::error::Error;
use crate::gpu::Gpu;
use crate::methods::{METHODS, Setup};
use crate::report::error_report::{self, stem};
use crate::report::files;
use crate::scene::{Scene, View};
use crate::study::error::{ErrorRecord, ErrorSpec, Variant, measure};
use crate::study::record::{DEFINITIONS, Head};
use crate::study::{Globals, Stage};
use std::path::Path;

/// Pixels of a quick study.
pub const QUICK_SIZE: [u32; 2] = [320, 180];
/// Views of a quick study.
pub const QUICK_VIEWS: usize = 2;
/// Roughness values of a quick study.
pub const QUICK_ROUGHNESS: [f32; 2] = [0.0, 0.1];

/// What is measured: each view at each size with each of the global factors.
pub struct Plan {
    /// Scenes, each with its views.
    pub scenes: Vec<(Scene, Vec<View>)>,
    /// Pixels.
    pub sizes: Vec<[u32; 2]>,
    /// Global factors.
    pub globals: Vec<Globals>,
    /// What is compared in every cell.
    pub variants: Vec<Variant>,
    /// Frames that count, for each variant.
    pub samples: usize,
    /// Rays a pixel of the references.
    pub rays: u32,
}

impl Plan {
    /// The quick study of a scene: two views, a mirror and a glossy one, every method as published.
    pub fn quick(scene: Scene, samples: usize, rays: u32) -> Self {
        let of = |r| Globals { roughness: Some(r), reflectivity: 1.0, normal_deviation: None };
        let variant = |method| Variant { method, setup: Setup::new(QUICK_SIZE) };
        let views = scene.views.iter().take(QUICK_VIEWS).cloned().collect();
        Self {
            scenes: vec![(scene, views)],
            sizes: vec![QUICK_SIZE],
            globals: QUICK_ROUGHNESS.map(of).to_vec(),
            variants: METHODS.iter().map(variant).collect(),
            samples,
            rays,
        }
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.scenes.iter().map(|(_, views)| views.len()).sum::<usize>() * self.sizes.len() * self.globals.len()
    }

    /// The records of every cell; records and pictures are kept in the folder, where there is one.
    pub fn run(
        &self,
        gpu: &Gpu,
        folder: Option<&Path>,
        progress: &mut dyn FnMut(),
    ) -> anyhow::Result<Vec<ErrorRecord>> {
        if self.samples == 0 || self.rays < 2 {
            return Err(Error::Usage("--samples must be at least 1, and --rays at least 2".into()).into());
        }
        let mut records = Vec::new();
        for (scene, views) in &self.scenes {
            let mut stage = None;
            for view in views {
                for &extent in &self.sizes {
                    for &globals in &self.globals {
                        let (warmup, samples, rays) = (1, self.samples, self.rays);
                        let variants = &self.variants[..];
                        let spec = ErrorSpec { gpu, scene, view, extent, globals, variants, warmup, samples, rays };
                        records.extend(cell(&spec, &mut stage, folder)?);
                        progress();
                    }
                }
            }
        }
        Ok(records)
    }
}

/// A cell from its file if it was measured with the same settings, else measured and kept.
fn cell(spec: &ErrorSpec, stage: &mut Option<Stage>, folder: Option<&Path>) -> anyhow::Result<Vec<ErrorRecord>> {
    let stem = stem(&spec.scene.name, &spec.view.name, spec.extent, spec.globals.roughness);
    let key = key(spec);
    let path = folder.map(|f| f.join("cells").join(format!("{stem}.json")));
    if let Some(kept) = path.as_ref().and_then(|p| kept(p, &key)) {
        return Ok(kept);
    }
    if stage.is_none() {
        *stage = Some(Stage::new(spec.gpu, spec.scene)?);
    }
    let Some(stage) = stage else { return Ok(Vec::new()) };
    let measured = measure(spec, stage)?;
    if let (Some(folder), Some(path)) = (folder, &path) {
        error_report::write_strips(&folder.join("images"), &stem, &measured)?;
        let content = serde_json::json!({ "key": key, "records": measured.records });
        files::write(path, serde_json::to_string(&content)?.as_bytes())?;
    }
    Ok(measured.records)
}

/// Everything that a cell depends on.
fn key(spec: &ErrorSpec) -> serde_json::Value {
    let setup = |s: &Setup| serde_json::json!(s);
    let variants: Vec<_> = spec.variants.iter().map(|v| (v.method.name, setup(&v.setup))).collect();
    let g = spec.globals;
    let view = spec.view;
    serde_json::json!({
        "definitions": DEFINITIONS, "version": Head::VERSION, "commit": Head::COMMIT, "device": spec.gpu.info(),
        "scene": spec.scene.name, "triangles": spec.scene.triangle_count(),
        "view": format!("{view:?}"), "lens": format!("{:?}", spec.scene.lens),
        "globals": [g.roughness, Some(g.reflectivity), g.normal_deviation],
        "extent": spec.extent, "variants": variants, "samples": [spec.warmup, spec.samples], "rays": spec.rays,
    })
}

fn kept(path: &Path, key: &serde_json::Value) -> Option<Vec<ErrorRecord>> {
    let mut content: serde_json::Value = serde_json::from_slice(&std::fs::read(path).ok()?).ok()?;
    if content.get("key") != Some(key) {
        return None;
    }
    serde_json::from_value(content.get_mut("records")?.take()).ok()
}

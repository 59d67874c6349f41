//! The precision ladder. A G-buffer is traced in f64 through the pixels' centres, and stored in one set of formats
//! after another; each set is a rung of the ladder. The methods' results on each stored G-buffer are compared with the
//! oracle and the screen reference on the unrounded G-buffer.

mod ladder;
mod storage;

pub use ladder::{Rung, roughness_values, rungs};
pub use storage::{ColorFormat, DepthFormat, NormalFormat, Storage};

use super::columns::{columns, figure, part};
use super::compare::rgb;
use super::engine::{Bench, Planned, Study};
use super::journal::scene_digest;
use super::names::cell_name;
use super::record::{Head, RecordSubject};
use super::ties::are_mirrors;
use crate::error::Result;
use crate::stage::Globals;
use crate::stage::gbuffer::{hit_positions, reflect_at_rest, reflection};
use glam::Vec3;
use rayon::prelude::*;
use serde_json::json;
use ssct::gpu::{FrameContext, Gpu};
use ssct::methods::{Effect, Input, MethodInfo, Setup, Wants};
use ssct::passes::gbuffer::GBufferImages;
use ssct::passes::scene_data;
use ssct_ground::math::OracleVersion;
use ssct_scenes::{Camera, GBufferData, Scene, Surface, View};
use ssct_truth::metrics::hits::HitAgreement;
use ssct_truth::metrics::image::masked_rmse;
use ssct_truth::reference::first_hits::PrimaryRays;
use ssct_truth::reference::hierarchy::Hierarchy;
use ssct_truth::reference::screen::{Sampling, ScreenReference};
use ssct_truth::reference::surface::{World, sky_color};

/// The name that stands for a method in the records of the oracle on a stored G-buffer. These records have the error of
/// storage alone, without the methods' arithmetic.
pub const ORACLE: &str = "oracle";

columns! {
    /// The result of a method on a G-buffer that was stored in some formats. (`unified` loads normals as 16-bit floats,
    /// so that finer normals are rounded to these, and coarser ones are changed by up to an eighth of their step.)
    pub struct PrecisionRecord {
        /// Subject of the record.
        #[serde(flatten)]
        pub head: Head = part(),
        /// Formats of the G-buffer.
        pub storage: Storage = figure(""),
        /// Bytes of a pixel of the G-buffer.
        pub bytes_per_pixel: u32 = figure(""),
        /// Number of reflecting pixels that rounding turns into sky, whose depth is 0.
        pub lost: usize = figure(""),
        /// Hits against the oracle's on the unrounded G-buffer; null unless every reflector is a mirror.
        #[serde(flatten)]
        pub hits: HitAgreement = part(),
        /// Root mean square error of the linear reflection colour, against the screen reference on the unrounded G-buffer.
        pub rmse: f64 = figure(""),
        /// RMSE that the reference itself is expected to have, from the finite number of its rays.
        pub standard_error: f64 = figure(""),
    }
}

/// A G-buffer before any format rounds it.
#[derive(Debug, Clone)]
pub struct ExactGBuffer {
    /// The G-buffer in f32; reflectivity and roughness as 16-bit floats hold them.
    pub data: GBufferData,
    /// Reversed depth in f64.
    pub depth: Vec<f64>,
}

impl ExactGBuffer {
    /// Traces a ray through the centre of each pixel, and makes the G-buffer of the surfaces that the rays hit.
    pub fn trace(world: &World, camera: &Camera, [width, height]: [u32; 2]) -> Self {
        let rays = PrimaryRays::new(camera, [width, height]);
        let view_to_clip = camera.view_to_clip_reversed().as_dmat4();
        let world_to_view = camera.world_to_view.as_dmat4();
        let half = |v: f64| half::f16::from_f64(v).to_f32();
        let pixel = |index: usize| {
            // A step of one metre along the ray changes view-space z by `z_per_metre`.
            let (ray, z_per_metre) = rays.ray(index);
            let Some(hit) = world.closest(&ray) else {
                return ExactPixel { color: sky_color(ray.direction).as_vec3(), ..ExactPixel::default() };
            };
            let point = world.point(&ray, &hit);
            // Depth depends on view-space z alone.
            let on_axis = glam::DVec3::new(0.0, 0.0, hit.t * z_per_metre);
            ExactPixel {
                depth: view_to_clip.project_point3(on_axis).z.clamp(0.0, 1.0),
                normal: world_to_view.transform_vector3(point.normal).normalize_or_zero().as_vec3(),
                reflectivity: half(point.reflectivity),
                roughness: half(point.roughness),
                color: world.color(&ray, &point).as_vec3(),
                surface: point.surface,
            }
        };
        let pixels: Vec<_> = (0..width as usize * height as usize).into_par_iter().map(pixel).collect();
        Self {
            depth: pixels.iter().map(|p| p.depth).collect(),
            data: GBufferData {
                width,
                height,
                camera: *camera,
                depth: pixels.iter().map(|p| p.depth as f32).collect(),
                normal: pixels.iter().map(|p| p.normal).collect(),
                reflectivity: pixels.iter().map(|p| p.reflectivity).collect(),
                roughness: pixels.iter().map(|p| p.roughness).collect(),
                color: pixels.iter().map(|p| p.color).collect(),
                surface: pixels.iter().map(|p| p.surface).collect(),
            },
        }
    }
}

/// A pixel of an [`ExactGBuffer`], with its normal in view space. The default is a pixel of sky.
#[derive(Default)]
struct ExactPixel {
    depth: f64,
    normal: Vec3,
    reflectivity: f32,
    roughness: f32,
    color: Vec3,
    surface: Surface,
}

/// Inputs of one ladder.
pub struct PrecisionSpec<'a> {
    /// Device.
    pub gpu: &'a Gpu,
    /// Scene.
    pub scene: &'a Scene,
    /// View.
    pub view: &'a View,
    /// Global factors.
    pub globals: Globals,
    /// Screen-space methods.
    pub methods: &'a [&'static MethodInfo],
    /// Setup of the methods, with the size.
    pub setup: Setup,
    /// Rays a pixel of the screen reference.
    pub rays: u32,
}

/// The unrounded G-buffer with its references.
struct Truth {
    exact: ExactGBuffer,
    /// Whether each pixel reflects.
    mask: Vec<bool>,
    /// The oracle's hits, if every reflector is a mirror.
    hits: Option<Hits>,
    /// Linear reflection colour of the screen reference.
    color: Vec<[f32; 3]>,
    /// Standard error of the screen reference.
    standard_error: f64,
}

/// The hit of each pixel's mirror ray, in pixels; `None` for a miss, and for pixels that do not reflect.
type Hits = Vec<Option<[f64; 2]>>;

impl Truth {
    /// Traces the unrounded G-buffer of a view, and finds its references. The error of `go_on` ends this.
    fn new(spec: &PrecisionSpec, go_on: &mut dyn FnMut() -> Result<()>) -> Result<Self> {
        let materials = spec.globals.materials(spec.scene, spec.view);
        let world = World::new(spec.scene, &materials);
        let exact = ExactGBuffer::trace(&world, &spec.view.camera(spec.scene, spec.setup.extent), spec.setup.extent);
        let mask = exact.data.reflecting();
        let screen = screen_reference(&exact.data, &mask, spec, go_on)?;
        Ok(Self {
            hits: are_mirrors(&exact.data).then(|| oracle_hits(&exact.data, &mask)),
            color: screen.color.iter().map(Vec3::to_array).collect(),
            standard_error: screen.overall_standard_error,
            exact,
            mask,
        })
    }

    /// Makes the record of a subject on the G-buffer `stored`, whose formats are `storage`. The subject's reflection
    /// `color` and `hits` are compared with the references on the unrounded G-buffer.
    fn record(
        &self,
        spec: &PrecisionSpec,
        subject: RecordSubject,
        (storage, stored): (Storage, &GBufferData),
        color: &[[f32; 3]],
        hits: Option<&Hits>,
    ) -> PrecisionRecord {
        let hit_pair = self.hits.as_ref().zip(hits);
        let is_lost = |(reflects, depth): &(&bool, &f32)| **reflects && **depth <= 0.0;
        PrecisionRecord {
            head: Head::new("precision", spec.gpu, (spec.scene, spec.view), subject, &spec.setup, &spec.globals),
            storage,
            bytes_per_pixel: storage.bytes_per_pixel(),
            lost: self.mask.iter().zip(&stored.depth).filter(is_lost).count(),
            hits: hit_pair.map(|(truth, hits)| HitAgreement::new(&self.mask, hits, truth)).unwrap_or_default(),
            rmse: masked_rmse(&self.color, color, &self.mask),
            standard_error: self.standard_error,
        }
    }
}

/// Renders the screen reference of a G-buffer in the pixels of `mask`. The seed, 3, is equal for all G-buffers, so that
/// their references differ by the G-buffers alone. The error of `go_on` ends the rendering.
fn screen_reference(
    data: &GBufferData,
    mask: &[bool],
    spec: &PrecisionSpec,
    go_on: &mut dyn FnMut() -> Result<()>,
) -> Result<ScreenReference> {
    let bounces = spec.setup.effect().bounces;
    let sampling = Sampling { samples: spec.rays, seed: 3, oracle: OracleVersion::V1, bounces };
    ScreenReference::render_while(data, mask, sampling, go_on)
}

/// Traces the mirror ray of each pixel of `mask` by version 1 of the oracle.
fn oracle_hits(data: &GBufferData, mask: &[bool]) -> Hits {
    let hierarchy = Hierarchy::new(data);
    let hit = |i: u32| mask[i as usize].then(|| hierarchy.trace(i % data.width, i / data.width).position_px());
    (0..mask.len() as u32).into_par_iter().map(|i| hit(i).flatten()).collect()
}

/// The study of precision: a ladder for each view of a scene and each set of factors.
pub struct PrecisionStudy {
    /// Scene.
    pub scene: Scene,
    /// Views.
    pub views: Vec<View>,
    /// Global factors.
    pub globals: Vec<Globals>,
    /// Screen-space methods.
    pub methods: Vec<&'static MethodInfo>,
    /// Setup of the methods, with the size.
    pub setup: Setup,
    /// Rays a pixel of the screen reference.
    pub rays: u32,
}

/// A cell is a view, by its index in the study, with a set of factors.
impl Study for PrecisionStudy {
    type Cell = (usize, Globals);
    type Row = PrecisionRecord;

    fn scenes(&self) -> Vec<&Scene> {
        vec![&self.scene]
    }

    /// Lists a cell for each view and set of factors.
    fn cells(&self) -> Vec<Planned<Self::Cell>> {
        let methods: Vec<_> = self.methods.iter().map(|m| (m.name, self.setup.recorded(Some(m)))).collect();
        let digest = scene_digest(&self.scene);
        let planned = |(view_index, globals): (usize, Globals)| {
            let view = &self.views[view_index];
            Planned {
                name: cell_name(&self.scene.name, &view.name, self.setup.extent, globals.roughness),
                setup: json!([digest, format!("{view:?}"), globals, methods, self.rays]),
                cell: (view_index, globals),
            }
        };
        let cells = (0..self.views.len()).flat_map(|view| self.globals.iter().map(move |globals| (view, *globals)));
        cells.map(planned).collect()
    }

    /// Measures the ladder of a view with a set of factors.
    fn measure(&mut self, (view, globals): &Self::Cell, bench: &mut Bench) -> Result<Vec<PrecisionRecord>> {
        let spec = PrecisionSpec {
            gpu: bench.gpu,
            scene: &self.scene,
            view: &self.views[*view],
            globals: *globals,
            methods: &self.methods,
            setup: self.setup.clone(),
            rays: self.rays,
        };
        measure(&spec, &mut bench.go_on)
    }
}

/// Measures every rung of a ladder: each method on the stored G-buffer, and before them the oracle, if every reflector
/// is a mirror. `go_on` is called between two steps, and its error ends the ladder.
///
/// # Errors
/// Errors of the device and of `go_on`.
pub fn measure(spec: &PrecisionSpec, go_on: &mut dyn FnMut() -> Result<()>) -> Result<Vec<PrecisionRecord>> {
    let truth = Truth::new(spec, go_on)?;
    let mut context = FrameContext::new(spec.gpu)?;
    let setup = spec.setup.seen_by(truth.exact.data.camera.kind());
    let effect = |m: &&'static MethodInfo| Ok((*m, Effect::new(&mut context, m, &setup, Wants::HITS, None)?));
    let effects = spec.methods.iter().map(effect).collect::<Result<Vec<_>>>()?;
    let sky = scene_data::environment(&mut context)?;
    let mut records = Vec::new();
    for storage in Storage::ladder() {
        let stored = storage.store(&truth.exact);
        if truth.hits.is_some() {
            let screen = screen_reference(&stored, &truth.mask, spec, go_on)?;
            let color: Vec<_> = screen.color.iter().map(Vec3::to_array).collect();
            let hits = oracle_hits(&stored, &truth.mask);
            records.push(truth.record(
                spec,
                RecordSubject::Other { name: ORACLE, method: None },
                (storage, &stored),
                &color,
                Some(&hits),
            ));
        }
        // A method that follows the oracle loads normals and colours as 16-bit floats; other methods see 32-bit floats.
        let images_32_bit = GBufferImages::upload_wide(&mut context, &stored)?;
        let images_16_bit = GBufferImages::upload(&mut context, &stored)?;
        for (method, effect) in &effects {
            go_on()?;
            let images = if method.follows_oracle { &images_16_bit } else { &images_32_bit };
            let input = Input { sky: Some(&sky), ..Input::of_screen(images.gbuffer(), &stored.camera) };
            let output = reflect_at_rest(&mut context, effect, &input)?;
            let color = rgb(&reflection(&mut context, &output)?);
            let hit_image = output.traced.hits.map(|hits| context.read(hits.0.all())).transpose()?;
            let hits = hit_image.map(|image| hit_positions(&image));
            records.push(truth.record(spec, RecordSubject::Method(method), (storage, &stored), &color, hits.as_ref()));
        }
    }
    Ok(records)
}

//! Agreement of devices: compares the images that methods make from one G-buffer on two devices, and the G-buffers that
//! two devices draw of one view.

use super::columns::{Column, columns, figure, part};
use super::compare::{display, rgb};
use super::exhibit::Table;
use super::names::name_among;
use super::record::{Head, RecordSubject};
use super::ties::{are_mirrors, is_tie};
use crate::error::Result;
use crate::stage::gbuffer::{self, hit_positions, reflect_at_rest};
use crate::stage::{Globals, Shot, Stage};
use ssct::gpu::{DeviceInfo, Gpu, Pixels, Precision};
use ssct::methods::{Effect, Input, MethodInfo, SceneInput, Setup, Wants};
use ssct::passes::GBuffer;
use ssct::passes::gbuffer::GBufferImages;
use ssct_scenes::{GBufferData, Scene, View};
use ssct_truth::metrics::flip::FlipMap;
use ssct_truth::metrics::hits::{HitAgreement, HitVerdict};
use ssct_truth::metrics::image::masked_rmse;
use ssct_truth::reference::hierarchy::Hierarchy;
use std::rc::Rc;

/// The scene, view and methods that every device draws.
#[derive(Clone)]
pub struct AgreementSpec<'a> {
    /// Scene.
    pub scene: &'a Scene,
    /// View of the scene.
    pub view: &'a View,
    /// Global factors.
    pub globals: Globals,
    /// The methods.
    pub methods: Vec<&'static MethodInfo>,
    /// Setup of the methods, with the size.
    pub setup: Setup,
}

/// Images that a method made from a G-buffer.
pub struct DeviceImage {
    /// The method.
    pub method: &'static MethodInfo,
    /// Reflection colour before fade and reflectivity, and the fade in the fourth channel.
    pub reflection: Pixels,
    /// Where the method's rays ended, if it traces any.
    pub hits: Option<Pixels>,
}

columns! {
    /// How a method's image on a device compares with the one on another device.
    pub struct AgreementRecord {
        /// Subject of the record; its device is the one that is compared with `base`.
        #[serde(flatten)]
        pub head: Head = part(),
        /// The device that is compared with; it also drew the G-buffer.
        pub base: DeviceInfo,
        /// Number of reflecting pixels.
        pub pixels: usize,
        /// The device's hits against those of `base`; null for a method that writes no hits.
        #[serde(flatten)]
        pub hits: HitAgreement,
        /// Number of pixels whose hits are apart; null unless the method follows version 1 of the oracle and all
        /// reflectors are mirrors.
        pub apart: Option<usize> = figure("apart"),
        /// Number of those among `apart` where the rounding of 32-bit floats explains the hits of both devices.
        pub ties: Option<usize> = figure("ties"),
        /// Root mean square difference of the linear reflection colour over reflecting pixels.
        pub rmse: f64 = figure("RMSE").digits(5),
        /// Mean FLIP of the display images of the reflection colour.
        pub flip: f64 = figure("FLIP"),
    }
}

columns! {
    /// How the G-buffers that two devices draw of one view differ.
    pub struct DrawnRecord {
        /// Kind of the record, which is always `drawn`.
        pub kind: String,
        /// The device.
        pub device: DeviceInfo,
        /// The device that is compared with.
        pub base: DeviceInfo,
        /// How finely `base` and the device rasterise and filter.
        pub precision: [Precision; 2],
        /// Scene name.
        pub scene: String = figure("scene"),
        /// View name.
        pub view: String = figure("view"),
        /// Width in pixels.
        pub width: u32,
        /// Height in pixels.
        pub height: u32,
        /// Whether material maps were sampled without anisotropy.
        pub isotropic: bool = figure("no anisotropy"),
        /// Whether normal maps were left out.
        pub plain_normals: bool = figure("no maps"),
        /// Share of the pixels that show another surface: sky on one of the two, or depths that are more than 1 % of the
        /// camera's reach apart, which is the depth itself in a perspective.
        pub other_surface: f64 = figure("surface %").share().digits(3),
        /// Share of the pixels with one surface whose normals are more than 2 degrees apart.
        pub other_normal: f64 = figure("normal %").share().digits(3),
        /// Share of the pixels with one surface whose lit colour differs by more than 0.02 in a channel.
        pub other_color: f64 = figure("colour %").share().digits(3),
        /// Root mean square difference of the lit colour over the pixels that show the same surface.
        pub rmse: f64 = figure("RMSE").digits(5),
    }
}

const ABOUT_METHODS: &str = "Every method runs on one G-buffer, which the device under “beside” drew; the hits and the \
    reflection colour of each device are held against those of that device. The hits of a pixel are apart if only one of the two \
    rays hits, or if both hit more than a pixel from each other. They are a tie if the rounding of 32-bit floats alone decides \
    between them. A method that sees more than the screen also draws the scene, with the device that it runs on.";

const ABOUT_DRAWN: &str = "Each device draws the G-buffer of one view; the table gives the shares of pixels that differ. A \
    pixel shows another surface where the two devices put it on different sides of an edge. Normals differ by more than 2 degrees \
    and colours by more than 0.02 mostly because of the filter of material maps: the specification does not say where an \
    anisotropic filter takes its samples. The rows without anisotropy and without normal maps show how much each of them \
    contributes. The three numbers of bits are those of the position of a vertex within a pixel, of a position between two texels \
    and of one between two levels.";

/// Makes two columns that name a row's device and its base device, by the shortest names that tell all devices of a
/// table apart. `device_pair` returns these two devices of a row, in this order.
fn device_columns<R: 'static>(rows: &[R], device_pair: fn(&R) -> [&DeviceInfo; 2]) -> [Column<R>; 2] {
    let all_devices: Rc<Vec<DeviceInfo>> = Rc::new(rows.iter().flat_map(device_pair).cloned().collect());
    [("device", 0), ("beside", 1)].map(|(title, index)| {
        let all_devices = Rc::clone(&all_devices);
        let name = move |row: &R| name_among(device_pair(row)[index], &all_devices.iter().collect::<Vec<_>>());
        Column::derived(title, 0, name)
    })
}

impl AgreementRecord {
    /// The table that compares the images of methods on one G-buffer.
    pub fn table(rows: &[Self]) -> Table {
        let [device, beside] = device_columns(rows, |r: &Self| [&r.head.program.device, &r.base]);
        let agree = Column::derived("hits agree %", 4, |r: &Self| r.hits.hit_agreement.map(|share| 100.0 * share));
        let table = Table::with_columns("same", rows, [device, beside, agree]);
        Table { title: "The same on other devices".to_owned(), about: ABOUT_METHODS.to_owned(), ..table }
    }
}

impl DrawnRecord {
    /// The table of the G-buffers that devices draw.
    pub fn table(rows: &[Self]) -> Table {
        let [device, beside] = device_columns(rows, |r: &Self| [&r.device, &r.base]);
        let bits = |p: &Precision| format!("{}/{}/{}", p.sub_pixel_bits, p.sub_texel_bits, p.mipmap_bits);
        let device_bits = Column::derived("bits", 0, move |r: &Self| bits(&r.precision[1]));
        let base_bits = Column::derived("bits there", 0, move |r: &Self| bits(&r.precision[0]));
        let table = Table::with_columns("drawn", rows, [device, beside, device_bits, base_bits]);
        Table { title: "G-buffers, share of other pixels".to_owned(), about: ABOUT_DRAWN.to_owned(), ..table }
    }
}

/// Draws the G-buffer of the view on a device, and reads it back.
///
/// # Errors
/// Errors of the device.
pub fn draw(gpu: &Gpu, spec: &AgreementSpec) -> Result<GBufferData> {
    let mut stage = Stage::new(gpu, spec.scene)?;
    let camera = spec.view.camera(spec.scene, spec.setup.extent);
    let materials = spec.globals.materials(spec.scene, spec.view);
    let shot = Shot::of_scene(&mut stage, spec.setup.extent, camera, materials)?;
    stage.draw(&shot)?;
    Ok(gbuffer::read(&mut stage.context, &shot)?)
}

/// Draws each method's images from the G-buffer `data`, which another device may have drawn. Methods that see more than
/// the screen also get the scene.
///
/// # Errors
/// Errors of the device.
pub fn images(gpu: &Gpu, spec: &AgreementSpec, data: &GBufferData) -> Result<Vec<DeviceImage>> {
    let mut stage = Stage::new(gpu, spec.scene)?;
    let (context, scene) = stage.parts();
    let materials = spec.globals.materials(spec.scene, spec.view);
    let uploaded = GBufferImages::upload(context, data)?;
    let gbuffer: GBuffer = uploaded.gbuffer();
    let setup = spec.setup.with_extent([data.width, data.height]).seen_by(data.camera.kind());
    let mut device_images = Vec::new();
    for method in &spec.methods {
        let scene_input = SceneInput { data: scene, materials: &materials };
        let effect = Effect::new(context, method, &setup, Wants::HITS, Some(&scene_input))?;
        let sky = Some(scene.sky());
        let input = Input { scene: Some(scene_input), sky, ..Input::of_screen(gbuffer, &data.camera) };
        let output = reflect_at_rest(context, &effect, &input)?;
        device_images.push(DeviceImage {
            method,
            reflection: gbuffer::reflection(context, &output)?,
            hits: output.traced.hits.map(|hits| context.read(hits.0.all())).transpose()?,
        });
    }
    Ok(device_images)
}

/// Compares the images of the device `gpu` with those that the device `base` made from the same G-buffer `data`. The
/// lists of images are in the order of the methods: first the list of `base`, then that of `gpu`.
pub fn compare(
    gpu: &Gpu,
    base: &DeviceInfo,
    spec: &AgreementSpec,
    data: &GBufferData,
    [base_images, device_images]: [&[DeviceImage]; 2],
) -> Vec<AgreementRecord> {
    let mask = data.reflecting();
    let (place, setup) = ((spec.scene, spec.view), spec.setup.with_extent([data.width, data.height]));
    let record = |(base_image, image): (&DeviceImage, &DeviceImage)| {
        let colors = [base_image, image].map(|device_image| rgb(&device_image.reflection));
        let display_images = colors.each_ref().map(|c| display(c));
        let hit_images = base_image.hits.as_ref().zip(image.hits.as_ref());
        let positions = hit_images.map(|(base, other)| [hit_positions(base), hit_positions(other)]);
        let version = setup.effect().oracle;
        // Ties are found for mirrors alone, by version 1 of the oracle.
        let can_tie = image.method.follows_oracle && version.is_first() && are_mirrors(data);
        let apart_and_ties = positions.as_ref().filter(|_| can_tie).map(|hits| count_apart_and_ties(data, &mask, hits));
        AgreementRecord {
            head: Head::new("agreement", gpu, place, RecordSubject::Method(image.method), &setup, &spec.globals),
            base: base.clone(),
            pixels: mask.iter().filter(|reflects| **reflects).count(),
            hits: positions.map(|[base, other]| HitAgreement::new(&mask, &other, &base)).unwrap_or_default(),
            apart: apart_and_ties.map(|(apart, _)| apart),
            ties: apart_and_ties.map(|(_, ties)| ties),
            rmse: masked_rmse(&colors[0], &colors[1], &mask),
            flip: FlipMap::new(&display_images[0], &display_images[1], data.width, data.height).mean(),
        }
    };
    base_images.iter().zip(device_images).map(record).collect()
}

/// Counts the reflecting pixels whose hits differ between two devices, and how many of these pixels differ by rounding
/// alone; the result has the two numbers in this order. `mask` says which pixels reflect. `base` and `other` have each
/// pixel's hit by the two devices, in pixels, or `None` for a miss.
fn count_apart_and_ties(
    data: &GBufferData,
    mask: &[bool],
    [base, other]: &[Vec<Option<[f64; 2]>>; 2],
) -> (usize, usize) {
    let is_apart = |i: &usize| mask[*i] && HitVerdict::compare(other[*i], base[*i]) != HitVerdict::Agrees;
    let apart: Vec<usize> = (0..mask.len()).filter(is_apart).collect();
    let hierarchy = Hierarchy::new(data);
    let is_tied = |i: &&usize| {
        let pixel = [**i as u32 % data.width, **i as u32 / data.width];
        [base, other].iter().all(|hits| is_tie(&hierarchy, pixel, hits[**i]))
    };
    (apart.len(), apart.iter().filter(is_tied).count())
}

/// Compares the G-buffers that two devices drew of one view: `base` by the first of `devices`, `drawn` by the second.
/// `isotropic` says that both sampled material maps without anisotropy.
pub fn compare_drawn(
    devices: [&Gpu; 2],
    spec: &AgreementSpec,
    [base, drawn]: [&GBufferData; 2],
    isotropic: bool,
) -> DrawnRecord {
    let projection = base.camera.projection_numbers();
    let view_depth_m = |reversed: f32| projection.kind.z_at(projection.depth.map(f64::from), f64::from(reversed));
    let is_same_surface = |i: &usize| {
        let depths = [base.depth[*i], drawn.depth[*i]];
        let [base_m, drawn_m] = depths.map(view_depth_m);
        // Sky has the reversed depth 0.
        let [base_has_surface, drawn_has_surface] = depths.map(|depth| depth > 0.0);
        let is_same_depth = || (base_m - drawn_m).abs() <= 0.01 * base.camera.reach_m(base_m.max(drawn_m));
        base_has_surface == drawn_has_surface
            && base.surface[*i] == drawn.surface[*i]
            && (!base_has_surface || is_same_depth())
    };
    let pixels = base.depth.len();
    let same: Vec<usize> = (0..pixels).filter(is_same_surface).collect();
    let share = |count: usize, total: usize| count as f64 / total.max(1) as f64;
    let has_other_normal = |i: &&usize| base.normal[**i].angle_between(drawn.normal[**i]) > 2.0_f32.to_radians();
    let has_other_color = |i: &&usize| (base.color[**i] - drawn.color[**i]).abs().max_element() > 0.02;
    let squares: f64 = same.iter().map(|i| f64::from((base.color[*i] - drawn.color[*i]).length_squared()) / 3.0).sum();
    DrawnRecord {
        kind: "drawn".to_owned(),
        device: devices[1].info().clone(),
        base: devices[0].info().clone(),
        precision: devices.map(Gpu::precision),
        scene: spec.scene.name.clone(),
        view: spec.view.name.clone(),
        width: base.width,
        height: base.height,
        isotropic,
        plain_normals: spec.globals.normal_deviation == Some(0.0),
        other_surface: share(pixels - same.len(), pixels),
        other_normal: share(same.iter().filter(has_other_normal).count(), same.len()),
        other_color: share(same.iter().filter(has_other_color).count(), same.len()),
        rmse: (squares / same.len().max(1) as f64).sqrt(),
    }
}

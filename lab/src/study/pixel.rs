//! Explains one pixel: its colour by a method, and the end of its ray by the method, by the oracle and in the world.
//! The explanation also names what hides the end from the screen, and the colours that the pixel's colour was mixed
//! from (docs/dump.md, "One pixel").

mod reasons;

use super::inspect::{Inspection, PickedRay, Walk, WalkEnd};
use glam::{DVec3, Vec3};
use serde::Serialize;
use ssct::gpu::Pixels;
use ssct::passes::PathCode;
use ssct_ground::math::display_byte;
use ssct_scenes::{Camera, GBufferData, Surface};
use ssct_truth::metrics::verdict::{PixelVerdict, difference};
use ssct_truth::reference::Outcome;
use ssct_truth::reference::first_hits::FirstHits;
use ssct_truth::reference::pixel::{
    EstimatedColor, PixelInWorld, PixelSampling, UnseenReason, all_references, references,
};
use ssct_truth::reference::surface::World;
use ssct_truth::reference::world_hits::WorldHit;

/// Rays of each reference if a single pixel is explained.
pub const RAYS: u32 = 256;

/// Rays a pixel of each reference if all pixels of a picture are judged.
pub const PICTURE_RAYS: u32 = 16;

/// Images that a method made in a frame, read back; both have the size of the frame.
#[derive(Clone, Copy)]
pub struct MethodImages<'a> {
    /// Reflection colour before fade and reflectivity, and the fade in the fourth channel.
    pub reflection: &'a Pixels,
    /// The finished image, linear.
    pub composite: &'a Pixels,
}

/// The properties of a method that the report of a pixel needs.
#[derive(Clone, Copy)]
pub struct PixelMethod<'a> {
    /// Name of the method.
    pub name: &'a str,
    /// Number of times that light is reflected.
    pub bounces: u32,
}

/// The report of a pixel. Colours are linear; places on the screen are continuous pixel coordinates from the top left;
/// places in the world are in metres.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PixelReport {
    /// Column and row, from the top left.
    pub pixel: [u32; 2],
    /// Name of the method.
    pub method: String,
    /// Whether the reflection is right, and if it is wrong, whether the screen reference is right.
    pub verdict: PixelVerdict,
    /// Reasons for the pixel's colour, in sentences.
    pub why: Vec<String>,
    /// Surface that the pixel shows.
    pub surface: SurfaceReport,
    /// Colours that the pixel was mixed from.
    pub colors: ColorReport,
    /// Where the pixel's ray ends by the method; null where the method does not report it, or there is no ray.
    pub method_end: Option<MethodEnd>,
    /// Where the pixel's mirror ray ends by the oracle, on the screen alone; null if there is no ray.
    pub oracle_end: Option<OracleEnd>,
    /// Where the pixel's mirror ray ends among the triangles of the scene; null if there is no ray.
    pub world_end: Option<WorldEnd>,
    /// How the mirror ray walks over the cells of the Hi-Z; null where the method does not walk, or its walk has no twin.
    pub walk: Option<WalkReport>,
}

/// The surface that a pixel shows.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SurfaceReport {
    /// The name of the surface's mesh; null for sky.
    pub mesh: Option<String>,
    /// View-space z in metres; null for sky.
    pub view_z_m: Option<f64>,
    /// Normal in view space; zero for sky.
    pub normal: [f32; 3],
    /// Reflectivity.
    pub reflectivity: f32,
    /// Roughness; 0 is a mirror.
    pub roughness: f32,
    /// Whether the surface reflects.
    pub reflects: bool,
}

/// The colours of a pixel: image = lit + reflectivity · fade · reflection.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ColorReport {
    /// Lit colour.
    pub lit: [f32; 3],
    /// The method's reflection before fade and reflectivity.
    pub reflection: [f32; 3],
    /// Share of the reflection that the fade leaves, 0…1.
    pub fade: f32,
    /// Share of the reflection that the surface adds.
    pub reflectivity: f32,
    /// The finished image.
    pub image: [f32; 3],
    /// The finished image as a PNG has it.
    pub display: [u8; 3],
    /// Reflection of the screen reference; null if the pixel does not reflect.
    pub screen: Option<ReferenceColor>,
    /// Reflection of the world reference; null if the pixel does not reflect.
    pub world: Option<ReferenceColor>,
}

/// The reflection by a reference.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ReferenceColor {
    /// Mean over the reference's rays, before fade and reflectivity.
    pub color: [f32; 3],
    /// Standard error of the mean.
    pub standard_error: [f32; 3],
    /// Number of the reference's rays.
    pub rays: u32,
    /// How far the method's reflection, after the fade, differs from the reference's on a display: a share of the way from
    /// black to white.
    pub difference: f32,
}

/// Where a method says that a ray ends.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MethodEnd {
    /// The path code, as docs/dump.md lists them.
    pub path: u8,
    /// How the ray ended, in words.
    pub end: &'static str,
    /// Whether the method takes the end for a hit on the screen.
    pub hits_screen: bool,
    /// Where on the screen the ray ends, if it hits there.
    pub pixel: Option<[f32; 2]>,
    /// Where in the world the ray ends, if it ends at a surface.
    pub place_m: Option<[f32; 3]>,
    /// The capture in which the ray ends, counted from 0.
    pub capture: Option<usize>,
}

/// Where the oracle says that a ray ends.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OracleEnd {
    /// The version of the oracle.
    pub version: u32,
    /// How the ray ended, in words.
    pub end: &'static str,
    /// Where on the screen the ray hits.
    pub pixel: Option<[f64; 2]>,
    /// Number of pixels that the oracle looked at.
    pub pixels: u32,
}

/// Where a ray ends in the world.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct WorldEnd {
    /// The name of the mesh; null where the ray ends in the sky.
    pub mesh: Option<String>,
    /// Where the ray ends.
    pub place_m: Option<[f64; 3]>,
    /// Length of the ray in metres.
    pub length_m: Option<f64>,
    /// View-space z of the ray's end in metres.
    pub view_z_m: Option<f64>,
    /// Where the ray's end is projected, on the screen or beside it; null behind the eye.
    pub pixel: Option<[f64; 2]>,
    /// Whether the screen shows the ray's end.
    pub shown: bool,
    /// Why the screen does not show the ray's end, in words.
    pub hidden: Option<&'static str>,
    /// The name of the mesh that hides the ray's end.
    pub hidden_by: Option<String>,
    /// View-space z in metres of the surface that the screen shows instead.
    pub shown_view_z_m: Option<f64>,
}

/// The walk of a ray, and the last cell that it looked at.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct WalkReport {
    /// Number of cells that the walk looked at.
    pub steps: usize,
    /// How the walk ended, in words.
    pub end: &'static str,
    /// The convention of the depths.
    pub depth: &'static str,
    /// The last cell that the walk looked at; null if it looked at none.
    pub last: Option<LastCell>,
}

/// A cell of the Hi-Z.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LastCell {
    /// Level of the cell; level 0 is the pixels.
    pub level: u32,
    /// Column and row of the cell in its level.
    pub cell: [u32; 2],
    /// Top left and bottom right corner of the cell, in pixels.
    pub corners: [[f32; 2]; 2],
    /// The nearest depth in the cell.
    pub nearest: f32,
    /// The ray's depth after the cell.
    pub ray: f32,
    /// Whether the ray passed on to the next cell; otherwise it met the depths that this cell holds.
    pub crossed: bool,
}

/// Explains a pixel of a frame; `None` outside the picture. `images` are those of the method, and `world` the scene
/// that the frame shows.
pub fn explain(
    inspection: &Inspection,
    images: MethodImages,
    world: &World,
    method: PixelMethod,
    pixel: [u32; 2],
) -> Option<PixelReport> {
    let ray = inspection.pick(pixel)?;
    let gbuffer = &inspection.gbuffer;
    let index = gbuffer.index(pixel[0], pixel[1]);
    let first_hits = FirstHits::shown_at(world, gbuffer, index);
    let in_world = PixelInWorld::new(world, gbuffer, &first_hits, index);
    let reflects = gbuffer.reflects(index);
    let sampling = PixelSampling { rays: RAYS, bounces: method.bounces, oracle: inspection.oracle };
    let screen_and_world = reflects.then(|| references(world, gbuffer, &first_hits, index, sampling));
    let colors = ColorReport::new(gbuffer, images, pixel, screen_and_world);
    let faded_reflection = colors.fade * Vec3::from(colors.reflection);
    let verdict = match screen_and_world {
        Some((screen, world)) => PixelVerdict::judge(faded_reflection, &screen, &world),
        None => PixelVerdict::NotReflecting,
    };
    let mut report = PixelReport {
        pixel,
        method: method.name.to_owned(),
        verdict,
        why: Vec::new(),
        surface: SurfaceReport::new(gbuffer, index, in_world.mesh.clone()),
        colors,
        method_end: MethodEnd::new(&ray),
        oracle_end: reflects.then(|| OracleEnd::new(inspection, &ray)),
        world_end: WorldEnd::new(&in_world, &gbuffer.camera),
        walk: ray.walk.as_ref().map(WalkReport::new),
    };
    report.why = reasons::sentences(&report, gbuffer.surface[index] == Surface::Sky, inspection.traces_lobes);
    Some(report)
}

/// Judges the reflection of every pixel of a frame, rows from the top. `world` is the scene that the frame shows.
pub fn verdicts(inspection: &Inspection, images: MethodImages, world: &World, bounces: u32) -> Vec<PixelVerdict> {
    let gbuffer = &inspection.gbuffer;
    let sampling = PixelSampling { rays: PICTURE_RAYS, bounces, oracle: inspection.oracle };
    let (screens, worlds) = all_references(world, gbuffer, sampling);
    let judge = |(index, texel): (usize, &[f32])| match gbuffer.reflects(index) {
        true => PixelVerdict::judge(texel[3] * Vec3::from_slice(texel), &screens[index], &worlds[index]),
        false => PixelVerdict::NotReflecting,
    };
    images.reflection.texels().enumerate().map(judge).collect()
}

impl SurfaceReport {
    /// Describes the surface that a pixel of the G-buffer shows. `index` is the pixel's number, row by row; `mesh` is
    /// the name of the mesh that the pixel shows.
    fn new(gbuffer: &GBufferData, index: usize, mesh: Option<String>) -> Self {
        let is_sky = gbuffer.depth[index] <= 0.0;
        let [x, y] = [index as u32 % gbuffer.width, index as u32 / gbuffer.width].map(|v| f64::from(v) + 0.5);
        let depth = f64::from(gbuffer.depth[index]);
        let point = gbuffer.unproject(x, y, depth, &gbuffer.view_to_clip().inverse());
        Self {
            mesh: mesh.filter(|_| !is_sky),
            view_z_m: (!is_sky).then_some(point.z),
            normal: gbuffer.normal[index].to_array(),
            reflectivity: gbuffer.reflectivity[index],
            roughness: gbuffer.roughness[index],
            reflects: gbuffer.reflects(index),
        }
    }
}

impl ColorReport {
    /// Collects the colours of the pixel (x, y). `references` are the colours of the screen reference and of the world
    /// reference; `None` if the pixel does not reflect.
    fn new(
        gbuffer: &GBufferData,
        images: MethodImages,
        [x, y]: [u32; 2],
        references: Option<(EstimatedColor, EstimatedColor)>,
    ) -> Self {
        let index = gbuffer.index(x, y);
        let color = |pixels: &Pixels| [0, 1, 2].map(|c| pixels.texel(x, y)[c]);
        let image = color(images.composite);
        let fade = images.reflection.texel(x, y)[3];
        let faded_reflection = fade * Vec3::from(color(images.reflection));
        let reference = |estimate: EstimatedColor| ReferenceColor {
            difference: difference(faded_reflection, estimate.color),
            color: estimate.color.to_array(),
            standard_error: estimate.standard_error.to_array(),
            rays: RAYS,
        };
        Self {
            lit: gbuffer.color[index].to_array(),
            reflection: color(images.reflection),
            fade,
            reflectivity: gbuffer.reflectivity[index],
            image,
            display: image.map(display_byte),
            screen: references.map(|(screen, _)| reference(screen)),
            world: references.map(|(_, world)| reference(world)),
        }
    }
}

impl MethodEnd {
    /// Describes where the method says that a picked ray ends; `None` if it does not say so, or if the pixel has no
    /// ray.
    fn new(ray: &PickedRay) -> Option<Self> {
        let (code, place_on_screen) = ray.method.filter(|(code, _)| *code != PathCode::None)?;
        let at_surface = ray.in_world.filter(|path| !matches!(path.code, PathCode::Sky | PathCode::Unknown));
        Some(Self {
            path: code as u8,
            end: code.words(),
            hits_screen: code.is_hit(),
            pixel: code.is_hit().then_some(place_on_screen),
            place_m: at_surface.map(|path| path.end.to_array()),
            capture: ray.in_world.and_then(|path| path.capture),
        })
    }
}

impl OracleEnd {
    /// Describes where the oracle says that a picked ray ends, in words and as a place on the screen.
    fn new(inspection: &Inspection, ray: &PickedRay) -> Self {
        Self {
            version: inspection.oracle.into(),
            end: match ray.oracle.outcome {
                Outcome::Hit { .. } => "hits a pixel",
                Outcome::Miss { reason, behind } => reasons::miss_text(reason, behind),
            },
            pixel: ray.oracle.position_px(),
            pixels: ray.oracle.steps,
        }
    }
}

impl WorldEnd {
    /// Describes the end of a pixel's mirror ray in the world; `None` for a pixel that does not reflect. For a ray that
    /// ends in the sky, every field is null or false.
    fn new(found: &PixelInWorld, camera: &Camera) -> Option<Self> {
        let in_sky = Self {
            mesh: None,
            place_m: None,
            length_m: None,
            view_z_m: None,
            pixel: None,
            shown: false,
            hidden: None,
            hidden_by: None,
            shown_view_z_m: None,
        };
        let WorldHit::Hit { position, pixel, view_z_m, length_m, visible } = found.end else {
            return matches!(found.end, WorldHit::Escaped).then_some(in_sky);
        };
        let (hidden_by, shown_view_z_m) = match &found.unseen {
            Some(UnseenReason::Hidden { by, view_z_m }) => (by.clone(), Some(*view_z_m)),
            Some(UnseenReason::NotDrawn { view_z_m }) => (None, Some(*view_z_m).filter(|z| z.is_finite())),
            _ => (None, None),
        };
        let is_before_near = view_z_m < f64::from(camera.lens.near_m);
        Some(Self {
            mesh: found.end_mesh.clone(),
            place_m: Some(DVec3::to_array(&position)),
            length_m: Some(length_m),
            view_z_m: Some(view_z_m),
            pixel: pixel.map(|p| p.to_array()),
            shown: visible,
            hidden: found.unseen.as_ref().map(|unseen| reasons::unseen_text(unseen, is_before_near)),
            hidden_by,
            shown_view_z_m,
        })
    }
}

impl WalkReport {
    /// Describes a walk by its number of steps, its end in words, and its last cell.
    fn new(walk: &Walk) -> Self {
        let last = walk.cells.last().map(|cell| LastCell {
            level: cell.level,
            cell: cell.place.to_array().map(|v| v as u32),
            corners: cell.corners.map(|corner| corner.to_array()),
            nearest: cell.nearest,
            ray: cell.ray,
            crossed: cell.crossed,
        });
        Self {
            steps: walk.cells.len(),
            end: match walk.end {
                WalkEnd::Hit => "met a pixel",
                WalkEnd::Left => "left the picture",
                WalkEnd::Behind => "met a surface from behind",
                WalkEnd::Exhausted => "ran out of steps",
            },
            depth: walk.depth,
            last,
        }
    }
}

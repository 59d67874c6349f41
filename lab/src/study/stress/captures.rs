//! Stress by captures at unusual places: inside a wall, on a surface, with faces of one texel, moved in each frame.
//! Methods that follow rays in captures must show a sound number in every pixel, and end every ray.

use super::lineup::SceneMethods;
use super::{JudgedFrame, StressRecord};
use crate::error::Result;
use crate::stage::Globals;
use glam::Vec3;
use ssct::gpu::Gpu;
use ssct::methods::setup::CaptureCount;
use ssct::methods::{EffectParams, METHODS, MethodInfo, Setup};
use ssct_geometry::bvh::WorldRay;
use ssct_scenes::{Capture, Scene, View};
use ssct_truth::reference::surface::World;

/// Roughness values: a mirror, a narrow lobe and a wide one.
pub(super) const ROUGHNESS: [f32; 3] = [0.0, 0.05, 0.3];

/// Texels along a side of a face in cases that test something other than sizes. The number is odd, so that it does not
/// halve exactly in the pyramid.
const SIDE: u32 = 61;

/// A case of captures at unusual places.
pub struct CaptureCase {
    /// Name of the case in records.
    pub name: String,
    /// Offset of the whole scene along each axis, in metres.
    offset: f32,
    /// View of the scene before the offset moves both.
    view: View,
    /// Places of the captures in each frame, before the offset moves them, in metres. Each frame has equally many.
    places: Vec<Vec<Vec3>>,
    /// Texels along a side of a face.
    resolution: u32,
}

/// Returns the methods that follow rays in captures, which must pass.
pub fn methods() -> Vec<&'static MethodInfo> {
    METHODS.iter().filter(|m| m.takes_captures).collect()
}

/// Makes every case of a scene from its first view.
pub fn cases(scene: &Scene) -> Vec<CaptureCase> {
    let Some(view) = scene.views.first() else { return Vec::new() };
    let (eye, ahead) = (view.eye, (view.look_at - view.eye).normalize_or(Vec3::Z));
    let bounds = scene.bounds();
    let materials = scene.materials_in(view);
    let ray = WorldRay { origin: eye.as_dvec3(), direction: ahead.as_dvec3(), t_min: 1e-3, t_max: f64::INFINITY };
    // If no surface is ahead, the far corner of the bounds replaces the wall.
    let wall = World::new(scene, &materials).closest(&ray).map_or(bounds.max, |hit| ray.point_at(hit.t).as_vec3());
    let case = |name: &str, resolution: u32, offset: f32, places: Vec<Vec<Vec3>>| CaptureCase {
        name: format!("{}: captures {name}", scene.name),
        offset,
        view: view.clone(),
        places,
        resolution,
    };
    let one_still = |name: &str, resolution: u32, place: Vec3| case(name, resolution, 0.0, vec![vec![place]]);
    let floor = Vec3::new(eye.x, bounds.min.y, eye.z);
    // The place in each of eight frames, from the eye to half a metre behind the wall's surface.
    let through_wall = |frame: u16| eye.lerp(wall + 0.5 * ahead, f32::from(frame) / 7.0);
    vec![
        one_still("at the eye", SIDE, eye),
        one_still("on a surface", SIDE, wall),
        one_still("a hair before a surface", SIDE, wall - 1e-4 * ahead),
        one_still("inside a wall", SIDE, wall + 0.05 * ahead),
        one_still("on the floor", SIDE, floor),
        one_still("below the floor", SIDE, floor - 0.1 * Vec3::Y),
        one_still("in a corner of the bounds", SIDE, bounds.min),
        one_still("outside", SIDE, bounds.max + 10.0),
        case("moved each frame, through a wall", SIDE, 0.0, (0..8).map(|frame| vec![through_wall(frame)]).collect()),
        case("two in one place", SIDE, 0.0, vec![vec![eye - 0.2 * ahead; 2]]),
        case("before and inside a wall", SIDE, 0.0, vec![vec![wall - 0.5 * ahead, wall + 0.05 * ahead]]),
        one_still("with faces of 1x1, at the eye", 1, eye),
        one_still("with faces of 1x1, on a surface", 1, wall),
        one_still("with faces of 2x2", 2, eye),
        one_still("with faces of 3x3", 3, eye),
        case("a kilometre from the origin", SIDE, 1e3, vec![vec![eye - 0.2 * ahead]]),
        case("1000 km from the origin", SIDE, 1e6, vec![vec![eye - 0.2 * ahead]]),
    ]
}

impl CaptureCase {
    /// Returns the key of the case: resolution, number of captures, and offset. Cases with equal keys use the same
    /// line-up of methods ([`super::lineup`]), which is made once.
    pub fn key(&self) -> (u32, usize, u32) {
        (self.resolution, self.places[0].len(), self.offset.to_bits())
    }

    /// Returns the scene of each frame, with the captures at the frame's places, and moved as a whole by the offset.
    pub fn scenes(&self, scene: &Scene) -> Vec<Scene> {
        let capture = |place: &Vec3| Capture { resolution: self.resolution, ..Capture::placed_at(*place) };
        let frame_scene = |places: &Vec<Vec3>| {
            let mut scene = Scene { captures: places.iter().map(capture).collect(), ..scene.clone() };
            scene.translate(Vec3::splat(self.offset));
            scene
        };
        self.places.iter().map(frame_scene).collect()
    }

    /// Makes the line-up of methods on the scene of the case's first frame, for all cases with this case's
    /// [`Self::key`].
    ///
    /// # Errors
    /// Errors of the device.
    pub fn lineup(
        &self,
        gpu: &Gpu,
        scene: &Scene,
        extent: [u32; 2],
        methods: &[&'static MethodInfo],
    ) -> Result<SceneMethods> {
        let setup = Setup::new(extent).with(|p: &mut EffectParams| p.captures = CaptureCount::Auto);
        SceneMethods::with_hits(gpu, self.scenes(scene).remove(0), &setup, methods)
    }
}

/// Runs the methods of the case's line-up on every frame, as mirrors and as glossy surfaces, and makes a record of each
/// run. Hits are not compared, since the screen's oracle does not know the captures.
///
/// # Errors
/// Errors of the device.
pub fn run(gpu: &Gpu, case: &CaptureCase, lineup: &mut SceneMethods) -> Result<Vec<StressRecord>> {
    let mut view = case.view.clone();
    view.eye += case.offset;
    view.look_at += case.offset;
    let camera = view.camera(&lineup.scene, lineup.extent);
    let mut records = Vec::new();
    for roughness in ROUGHNESS {
        let globals = Globals { roughness: Some(roughness), ..Globals::default() };
        lineup.set_materials(&globals.materials(&lineup.scene, &view))?;
        for (n, places) in case.places.iter().enumerate() {
            let places: Vec<Vec3> = places.iter().map(|p| *p + case.offset).collect();
            lineup.move_captures(&places)?;
            let Some(data) = lineup.draw(camera)? else { continue };
            let frames = lineup.read_images()?;
            let suffix = if case.places.len() > 1 { format!(", frame {n}") } else { String::new() };
            let name = format!("{}, roughness {roughness}{suffix}", case.name);
            let judged = JudgedFrame { case: &name, setup: &lineup.setup, globals: &globals, must_pass: true };
            records.extend(lineup.methods().zip(&frames).map(|(m, frame)| frame.judge(gpu, &judged, m, &data, None)));
        }
    }
    Ok(records)
}

//! G-buffers and captures between device and host, and methods run on a G-buffer from the host.

use super::{Shot, Stage};
use glam::Vec3;
use ssct::error::Result;
use ssct::gpu::frame::Mode;
use ssct::gpu::{FrameContext, Gpu, Pixels};
use ssct::methods::capture::{CaptureFacePass, CaptureImages, common_near_m};
use ssct::methods::{Effect, Input, MethodInfo, Output, SceneInput, Setup, Wants};
use ssct::passes::PathCode;
use ssct::passes::gbuffer::{GBufferImages, GBufferPass};
use ssct::passes::scene_data;
use ssct_scenes::capture::face_camera;
use ssct_scenes::capture_file::{CaptureFolder, SkyCube};
use ssct_scenes::{Camera, Capture, GBufferData, Material, Scene, Surface};
use ssct_truth::metrics::place::RayEnd;

/// Reads the G-buffer of a shot that has run.
pub fn read(context: &mut FrameContext, shot: &Shot) -> Result<GBufferData> {
    read_drawn(context, &shot.gbuffer, shot.camera)
}

/// Reads the G-buffer that a pass drew last; `camera` is the camera of that pass, and the lighting pass wrote the colour.
fn read_drawn(context: &mut FrameContext, pass: &GBufferPass, camera: Camera) -> Result<GBufferData> {
    let gbuffer = pass.gbuffer();
    let vectors = |p: Pixels| p.texels().map(|t| Vec3::new(t[0], t[1], t[2])).collect();
    let depth = context.read(gbuffer.depth.all())?;
    let material = context.read(gbuffer.material.all())?;
    let albedo = context.read(pass.albedo().all())?;
    let surfaces = albedo.texels().zip(&depth.values).map(|(albedo, depth)| {
        // The lighting pass uses this condition, too. Depth is 0 where there is no surface.
        if albedo[3] < 0.5 && *depth > 0.0 { Surface::Sky } else { Surface::Lit }
    });
    Ok(GBufferData {
        surface: surfaces.collect(),
        width: depth.width,
        height: depth.height,
        camera,
        depth: depth.values,
        normal: vectors(context.read(gbuffer.normal.all())?),
        reflectivity: material.texels().map(|t| t[0]).collect(),
        roughness: material.texels().map(|t| t[1]).collect(),
        color: vectors(context.read(gbuffer.color.level(0))?),
    })
}

/// Draws captures of a scene, all with one near plane and with the resolution of the first. Calls `face` for each face
/// after it is drawn, with the number of the capture, counted from 0, the number of the face (0…5), and the face's
/// G-buffer, in which sky is black.
pub fn draw_captures(
    stage: &mut Stage,
    materials: &[Material],
    captures: &[Capture],
    mut face: impl FnMut(usize, usize, GBufferData) -> Result<()>,
) -> Result<()> {
    let near_m = common_near_m(captures);
    let side = captures.first().map_or(1, |c| c.resolution);
    let pass = CaptureFacePass::new(stage.context.gpu(), side)?;
    let (context, data) = stage.parts();
    let scene = SceneInput { data, materials };
    for (capture_number, capture) in captures.iter().enumerate() {
        for face_number in 0..6 {
            let camera = face_camera(capture.position, face_number, near_m);
            context.once(|frame| pass.record(frame, &scene, &camera))?;
            face(capture_number, face_number, read_drawn(context, pass.drawn(), camera)?)?;
        }
    }
    Ok(())
}

/// Reads the sky of a scene: linear colours, face by face of a cube, each row by row.
pub fn read_sky(stage: &mut Stage) -> Result<SkyCube> {
    let (context, data) = stage.parts();
    let texels = context.read(data.sky().level(0))?;
    Ok(SkyCube { side: texels.width, texels: texels.texels().map(|t| Vec3::new(t[0], t[1], t[2])).collect() })
}

/// The images that a method makes from a G-buffer.
pub struct ReflectedImages {
    /// Linear colour, RGBA.
    pub composite: Pixels,
    /// Reflection colour before fade and reflectivity, and the fade in the fourth channel.
    pub reflection: Pixels,
}

/// Runs a method on a G-buffer from the host, with captures if there are any; the size in `setup` is replaced by the G-buffer's.
pub fn reflect(
    gpu: &Gpu,
    data: &GBufferData,
    captures: Option<&CaptureFolder>,
    method: &MethodInfo,
    setup: &Setup,
) -> Result<ReflectedImages> {
    let mut context = FrameContext::new(gpu)?;
    let images = GBufferImages::upload(&mut context, data)?;
    let setup = setup.with_extent([data.width, data.height]).seen_by(data.camera.kind());
    let wants = Wants::REFLECTION;
    let sky = captures.map(CaptureFolder::sky).transpose()?.flatten();
    let sky = sky.map(|sky| scene_data::upload_sky(&mut context, &sky)).transpose()?;
    let effect = match captures {
        Some(folder) => {
            let images = CaptureImages::of_faces(&mut context, folder.captures(), |capture, face| {
                Ok(folder.face(capture, face)?)
            })?;
            let images = images.with_bounds(folder.bounds());
            Effect::with_captures(&mut context, method, &setup, wants, images)?
        }
        None => Effect::new(&mut context, method, &setup, wants, None)?,
    };
    // If no captures bring a sky, a G-buffer with sky surfaces shows the built-in environment.
    let sky = match sky {
        None if data.surface.contains(&Surface::Sky) => Some(scene_data::environment(&mut context)?),
        sky => sky,
    };
    let input = Input { sky: sky.as_ref(), ..Input::of_screen(images.gbuffer(), &data.camera) };
    reflect_and_read(&mut context, &effect, &input)
}

/// Runs a method on a G-buffer from the host that shows `scene`, for methods that see more than the screen. Rays that
/// the screen loses are followed among the scene's triangles, which have the scene's own materials. Which triangle a
/// pixel shows is not known.
pub fn reflect_in(
    gpu: &Gpu,
    scene: &Scene,
    data: &GBufferData,
    method: &MethodInfo,
    setup: &Setup,
) -> Result<ReflectedImages> {
    let mut stage = Stage::new(gpu, scene)?;
    let (context, scene_data) = stage.parts();
    let images = GBufferImages::upload(context, data)?;
    let scene_input = SceneInput { data: scene_data, materials: &scene.materials };
    let setup = setup.with_extent([data.width, data.height]).seen_by(data.camera.kind());
    let effect = Effect::new(context, method, &setup, Wants::REFLECTION, Some(&scene_input))?;
    let screen_input = Input::of_screen(images.gbuffer(), &data.camera);
    let input = Input { scene: Some(scene_input), sky: Some(scene_data.sky()), ..screen_input };
    reflect_and_read(context, &effect, &input)
}

/// Runs an effect on a G-buffer at rest, and reads the images that it made.
fn reflect_and_read(context: &mut FrameContext, effect: &Effect, input: &Input) -> Result<ReflectedImages> {
    let output = reflect_at_rest(context, effect, input)?;
    Ok(ReflectedImages {
        composite: context.read(output.composite.level(0))?,
        reflection: reflection(context, &output)?,
    })
}

/// Runs an effect on a G-buffer at rest and returns its output. A history begins anew, and the output is that of the
/// last frame that it averages.
pub fn reflect_at_rest<'a>(
    context: &mut FrameContext,
    effect: &'a Effect,
    input: &Input<'a, '_>,
) -> Result<Output<'a>> {
    effect.restart_history();
    for _ in 1..effect.frames_at_rest() {
        let mut frame = context.begin(Mode::Plain)?;
        effect.record(&mut frame, input)?;
        frame.finish()?;
    }
    let mut frame = context.begin(Mode::Plain)?;
    frame.begin_effect();
    let output = effect.record(&mut frame, input)?;
    frame.finish()?;
    Ok(output)
}

/// Reads the reflection colour and the fade that a method made; zeros if nothing reflects.
pub fn reflection(context: &mut FrameContext, output: &Output) -> Result<Pixels> {
    match output.traced.reflection {
        Some(reflection) => context.read(reflection.0.all()),
        None => Ok(Pixels::zeros(output.composite.extent(), 4)),
    }
}

/// Returns the end of each pixel's ray in the world: the place of a hit on the screen, in a capture or on a triangle; the
/// sky; or unknown where the ray misses. `hits` is the image of [`ssct::passes::Hits`], of the
/// G-buffer's size.
pub fn ray_ends(hits: &Pixels, gbuffer: &GBufferData) -> Vec<RayEnd> {
    let clip_to_view = gbuffer.view_to_clip().inverse();
    let view_to_world = gbuffer.camera.world_to_view.as_dmat4().inverse();
    let screen_end = |([x, y], depth): ([f64; 2], f64)| {
        RayEnd::Place(view_to_world.transform_point3(gbuffer.unproject(x, y, depth, &clip_to_view)))
    };
    // The image has standard depth, and positions are computed from reversed depth.
    let depths = hits.texels().map(|texel| 1.0 - f64::from(texel[2]));
    let ends = hit_positions(hits).into_iter().zip(depths).map(|(hit, depth)| hit.map(|p| screen_end((p, depth))));
    let eye = gbuffer.camera.eye().as_dvec3();
    // For a hit beyond the screen, the image has the place relative to the eye, in world axes.
    let end_beyond_screen = |texel: &[f32]| match PathCode::from_channel(texel[3]) {
        Some(PathCode::Capture | PathCode::Triangle) => RayEnd::Place(eye + Vec3::from_slice(texel).as_dvec3()),
        Some(PathCode::Sky) => RayEnd::Sky,
        _ => RayEnd::Unknown,
    };
    ends.zip(hits.texels()).map(|(end, texel)| end.unwrap_or_else(|| end_beyond_screen(texel))).collect()
}

/// Returns where the ray of each pixel hits on the screen, in continuous pixel coordinates; `None` for a ray that hits
/// nothing there. `hits` is the image of [`ssct::passes::Hits`].
pub fn hit_positions(hits: &Pixels) -> Vec<Option<[f64; 2]>> {
    let size = [f64::from(hits.width), f64::from(hits.height)];
    let position = |t: &[f32]| [f64::from(t[0]) * size[0], f64::from(t[1]) * size[1]];
    hits.texels().map(|t| PathCode::from_channel(t[3]).is_some_and(PathCode::is_hit).then(|| position(t))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use ssct_scenes::Lens;

    /// Tests where rays end in the world: at hits on the screen or beyond it, in the sky, or at an unknown place.
    #[test]
    fn a_hit_ends_at_the_place_that_it_shows_and_a_miss_nowhere() {
        let camera = Camera::new(Vec3::new(1.0, 2.0, 3.0), Vec3::new(4.0, 1.0, 9.0), Lens::default(), 1.5);
        let gbuffer = GBufferData {
            width: 3,
            height: 2,
            camera,
            depth: vec![],
            normal: vec![],
            reflectivity: vec![],
            roughness: vec![],
            color: vec![],
            surface: vec![],
        };
        let place = DVec3::new(3.0, 1.5, 8.0);
        let view = camera.world_to_view.as_dmat4().transform_point3(place);
        // The pixel and the reversed depth; an image of hits has texture coordinates and standard depth.
        let projected = gbuffer.project(view, &gbuffer.view_to_clip()).unwrap();
        let hit = [projected.x / 3.0, projected.y / 2.0, 1.0 - projected.z].map(|number| number as f32);
        let texel = |code: PathCode| [hit[0], hit[1], hit[2], code as u8 as f32];
        let values = [PathCode::HiZ, PathCode::Miss, PathCode::Linear, PathCode::MissSky].map(texel).concat();
        let ends = ray_ends(&Pixels { width: 3, height: 2, channels: 4, values }, &gbuffer);
        for (n, end) in ends.into_iter().enumerate() {
            match end {
                RayEnd::Place(found) => assert!(n % 2 == 0 && found.distance(place) < 1e-3, "{n}: {found}"),
                other => assert!(n % 2 == 1 && other == RayEnd::Unknown, "{n}: {other:?}"),
            }
        }
        // Beyond the screen the image holds the place relative to the eye.
        let from_eye = (place.as_vec3() - camera.eye()).to_array();
        let beyond = |code: f32| [from_eye[0], from_eye[1], from_eye[2], code];
        let last_capture = PathCode::Capture as u8 as f32 + 7.0;
        let codes = [last_capture, PathCode::Sky as u8 as f32, PathCode::Unknown as u8 as f32];
        let image = Pixels { width: 3, height: 1, channels: 4, values: codes.map(beyond).concat() };
        let [RayEnd::Place(found), RayEnd::Sky, RayEnd::Unknown] = ray_ends(&image, &gbuffer)[..] else { panic!() };
        assert!(found.distance(place) < 1e-5, "{found}");
    }
}

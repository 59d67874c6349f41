//! Images that several shots share. Shots share a G-buffer, so that the scene is drawn once for all of them. They also
//! share the images of their methods, so that together they take no more memory than the largest of them.

use super::{Shot, Stage};
use ssct::error::Result;
use ssct::gpu::frame::Mode;
use ssct::gpu::{FrameReport, ImagePool};
use ssct::methods::{Effect, MethodInfo, Output, SceneInput, Setup, Wants};
use ssct::passes::gbuffer::{DrawnCounts, GBufferPass};
use ssct::passes::lighting::LightingPass;
use ssct_scenes::{Camera, Material};
use std::rc::Rc;

/// Images of shots that show a scene from one camera with one set of materials. Shots that draw the scene alike share a
/// G-buffer. When another shot runs, the images of a shot's method are overwritten, except its history and images that
/// were prepared before the first frame.
#[derive(Default)]
pub struct SharedImages {
    /// The G-buffers so far.
    gbuffers: Vec<SharedGBuffer>,
    /// The images that methods lend each other.
    pool: ImagePool,
}

/// A G-buffer that shots share.
struct SharedGBuffer {
    /// The pass that draws it.
    pass: Rc<GBufferPass>,
    /// Whether the pass was made for shots that ask which triangle a pixel shows.
    is_numbered: bool,
    /// The report of the frame that drew the scene, and its counts; `None` before.
    drawn: Option<(FrameReport, DrawnCounts)>,
}

impl SharedImages {
    /// Makes a shot that draws into shared images where they fit, and into new images otherwise.
    pub fn shot(
        &mut self,
        stage: &mut Stage,
        method: &MethodInfo,
        setup: &Setup,
        wants: Wants,
        camera: Camera,
        materials: Vec<Material>,
    ) -> Result<Shot> {
        let Stage { context, data } = stage;
        let scene = SceneInput { data, materials: &materials };
        context.lend_images(Some(self.pool.clone()));
        let effect = Effect::new(context, method, &setup.seen_by(camera.kind()), wants, Some(&scene));
        context.lend_images(None);
        let effect = effect?;
        let (gpu, is_numbered) = (context.gpu(), effect.wants_triangles());
        let fits =
            |known: &&SharedGBuffer| known.pass.albedo().extent() == setup.extent && known.is_numbered == is_numbered;
        let known = self.gbuffers.iter().find(fits).map(|known| Rc::clone(&known.pass));
        let make_pass = if is_numbered { GBufferPass::numbered } else { GBufferPass::new };
        let gbuffer = known.map_or_else(|| make_pass(gpu, setup.extent).map(Rc::new), Ok)?;
        let shot = Shot { gbuffer, lighting: LightingPass::new(gpu)?, effect, camera, materials };
        self.entry_of(&shot);
        Ok(shot)
    }

    /// Makes shots of several methods, each with its setup.
    pub fn shots<'m>(
        &mut self,
        stage: &mut Stage,
        methods: impl IntoIterator<Item = (&'m MethodInfo, Setup)>,
        wants: Wants,
        camera: Camera,
        materials: &[Material],
    ) -> Result<Vec<Shot>> {
        let shot = |(method, setup)| self.shot(stage, method, &setup, wants, camera, materials.to_vec());
        methods.into_iter().map(shot).collect()
    }

    /// Makes the next frame of each G-buffer draw the scene anew: for another camera, other materials, or times of another round.
    pub fn draw_anew(&mut self) {
        self.gbuffers.iter_mut().for_each(|known| known.drawn = None);
    }

    /// Returns the entry of a shot's G-buffer, which is added if there is none yet.
    fn entry_of(&mut self, shot: &Shot) -> &mut SharedGBuffer {
        let has_gbuffer = |known: &SharedGBuffer| Rc::ptr_eq(&known.pass, &shot.gbuffer);
        let index = self.gbuffers.iter().position(has_gbuffer).unwrap_or_else(|| {
            let is_numbered = shot.effect.wants_triangles();
            self.gbuffers.push(SharedGBuffer { pass: Rc::clone(&shot.gbuffer), is_numbered, drawn: None });
            self.gbuffers.len() - 1
        });
        &mut self.gbuffers[index]
    }

    /// Draws the scene into the G-buffer of a shot, unless it is drawn there already. Returns the report of the frame
    /// that drew the scene, and the counts of drawn meshes.
    pub fn draw(&mut self, stage: &mut Stage, mode: Mode, shot: &Shot) -> Result<&(FrameReport, DrawnCounts)> {
        match &mut self.entry_of(shot).drawn {
            Some(drawn) => Ok(drawn),
            not_drawn => Ok(not_drawn.insert(stage.draw_in(mode, shot)?)),
        }
    }

    /// Runs one frame of a shot on its G-buffer, into which the scene is drawn first if it is not drawn there yet. The
    /// report also has the scene passes, with their times and work in the frame in which they ran.
    pub fn output<'s>(
        &mut self,
        stage: &mut Stage,
        mode: Mode,
        shot: &'s Shot,
    ) -> Result<(FrameReport, DrawnCounts, Output<'s>)> {
        let (scene, drawn) = self.draw(stage, mode, shot)?;
        let (report, output) = stage.output_on(mode, shot, (shot, drawn))?;
        Ok((whole_frame(scene, report), *drawn, output))
    }

    /// Begins the history of a shot anew, and runs all but the last of the frames that an image at rest takes, so that
    /// the next frame shows this image.
    pub fn settle(&mut self, stage: &mut Stage, shot: &Shot) -> Result<()> {
        shot.effect.restart_history();
        (1..shot.frames_at_rest()).try_for_each(|_| self.output(stage, Mode::Plain, shot).map(drop))
    }

    /// Draws the image of a camera at rest. A history begins anew, and the image is the last of the frames that it
    /// averages. Nothing moves, so the scene is drawn once for all these frames.
    pub fn output_at_rest<'s>(
        &mut self,
        stage: &mut Stage,
        shot: &'s Shot,
    ) -> Result<(FrameReport, DrawnCounts, Output<'s>)> {
        self.settle(stage, shot)?;
        self.output(stage, Mode::Plain, shot)
    }
}

/// Returns when the first pass of a frame begins and when the last one ends, in milliseconds from the first timestamp
/// of the method's frame. The beginning is negative if the scene passes ran in an earlier frame.
pub fn span_ms(report: &FrameReport) -> [f64; 2] {
    let begins = report.passes.iter().map(|pass| pass.start_ms);
    let ends = report.passes.iter().map(|pass| pass.start_ms + pass.ms);
    [begins.fold(0.0, f64::min), ends.fold(0.0, f64::max)]
}

/// Joins the reports of the frame that drew the scene and of the frame of the method into one report. The beginnings of
/// scene passes are negative, since they ran before the method's frame began.
fn whole_frame(scene: &FrameReport, method: FrameReport) -> FrameReport {
    // By how much the frame of the scene began earlier. Without the host's clock, its own length is taken.
    let earlier_ms = match (scene.host, method.host) {
        (Some(scene), Some(method)) => method.begun_us.saturating_sub(scene.begun_us) as f64 / 1e3,
        _ => scene.frame_ms,
    };
    let mut passes = scene.passes.clone();
    passes.iter_mut().for_each(|pass| pass.start_ms -= earlier_ms);
    passes.extend(method.passes);
    FrameReport {
        passes,
        frame_ms: scene.frame_ms + method.frame_ms,
        host: method.host,
        work: [scene.work.clone(), method.work].concat(),
        recorded: [scene.recorded.clone(), method.recorded].concat(),
        skipped: [scene.skipped.clone(), method.skipped].concat(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ssct::gpu::{DeviceQuery, Gpu};
    use ssct::methods::setup::HistoryUse;
    use ssct::methods::{self, EffectParams};
    use ssct_scenes::library;

    #[test]
    fn shots_that_share_images_show_what_they_show_alone_and_draw_the_scene_once() {
        let gpu = Gpu::open(&DeviceQuery::default()).expect("a device");
        let scene = library::scene("rooms").expect("built in");
        let (view, setup) = (&scene.views[0], Setup::new([64, 36]));
        let (camera, mut materials) = (view.camera(&scene, setup.extent), scene.materials_in(view));
        // Rough surfaces look different in every frame that a history averages.
        materials.iter_mut().for_each(|material| material.roughness = 0.5);
        let mut stage = Stage::new(&gpu, &scene).expect("a stage");
        let method = |name| (methods::find(name).expect("a method"), setup.clone());
        // A history outlives frames, so that its images are no one else's.
        let with_history = setup.with(|p: &mut EffectParams| p.history = HistoryUse::On);
        let with_history = (methods::find("unified").expect("a method"), with_history);
        let wanted = [method("ssct"), method("hzct"), method("traced"), with_history];
        let mut shared = SharedImages::default();
        let shots = shared.shots(&mut stage, wanted.clone(), Wants::IMAGE, camera, &materials).expect("shots");
        assert!(Rc::ptr_eq(&shots[0].gbuffer, &shots[1].gbuffer));
        assert!(!Rc::ptr_eq(&shots[0].gbuffer, &shots[2].gbuffer), "traced asks for triangles");

        let held = gpu.allocated_bytes();
        let (ssct, setup_of_ssct) = &wanted[0];
        let again =
            shared.shot(&mut stage, ssct, setup_of_ssct, Wants::IMAGE, camera, materials.clone()).expect("a shot");
        assert_eq!(gpu.allocated_bytes(), held, "another shot of one method takes the images of the first");
        drop(again);
        let briefly = wanted[3].1.with(|p: &mut EffectParams| p.history_frames = 2);
        let other =
            shared.shot(&mut stage, wanted[3].0, &briefly, Wants::IMAGE, camera, materials.clone()).expect("a shot");

        let mut scenes = Vec::new();
        for ((method, setup), shot) in wanted.iter().zip(&shots) {
            shared.settle(&mut stage, shot).expect("frames");
            // The other history writes both of its images, in turn.
            shared.output(&mut stage, Mode::Timed, &other).expect("another shot's frame in between");
            shared.output(&mut stage, Mode::Timed, &other).expect("another shot's frame in between");
            let (report, _, output) = shared.output(&mut stage, Mode::Timed, shot).expect("a frame");
            let among_others = stage.context.read(output.composite.level(0)).expect("an image");
            let alone = Shot::new(&mut stage, method, setup, Wants::IMAGE, camera, materials.clone()).expect("a shot");
            stage.settle(&alone).expect("frames");
            let (whole, _, output) = stage.output_in(Mode::Timed, &alone).expect("a frame");
            let own = stage.context.read(output.composite.level(0)).expect("an image");
            assert!(among_others.texels().eq(own.texels()), "{}", method.name);
            assert_eq!(report.recorded, whole.recorded, "{}", method.name);
            let counted = |report: &FrameReport| report.passes.iter().map(|p| p.counted).collect::<Vec<_>>();
            assert_eq!(counted(&report), counted(&whole), "{}", method.name);
            scenes.push(report.passes.into_iter().filter(|p| !p.counted).map(|p| (p.name, p.ms)).collect::<Vec<_>>());
        }
        assert_eq!(scenes[0], scenes[1], "the second shot is shown on what was drawn for the first");
        assert_ne!(scenes[0], scenes[2]);
        assert_eq!(scenes[2], scenes[3]);
        shared.draw_anew();
        let (report, ..) = shared.output(&mut stage, Mode::Timed, &shots[1]).expect("a frame");
        let again = report.passes.into_iter().filter(|p| !p.counted).map(|p| (p.name, p.ms)).collect::<Vec<_>>();
        assert_ne!(scenes[0], again, "times of another drawing");
    }
}

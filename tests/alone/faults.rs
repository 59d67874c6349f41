//! Makes a device run out of memory or be lost, at every allocation and every submission of a small run. Each fault
//! must become a typed error and leave nothing behind, and the next run must succeed as if there had been no fault.
//!
//! Each test has a process of its own because it makes and destroys devices under the validation layers: see
//! [`common::gpu`](crate::common::gpu).

use crate::common::engine::{Engine, ForeignGBuffer, NATIVE, info, view_of_rooms};
use crate::common::{Builder, two_quads};
use crate::is_alone;
use glam::Vec3;
use ssct::error::{Error, Result};
use ssct::gpu::frame::Mode;
use ssct::gpu::{DeviceQuery, Fault, Gpu, Watch};
use ssct::methods::{self, METHODS, MethodInfo, Setup, Wants};
use ssct::{Context, FrameInput, Reflections};
use ssct_lab::stage::image::render;
use ssct_lab::stage::{Globals, Shot, Stage};
use ssct_scenes::{Camera, Lens, Scene, View};
use std::sync::Arc;

/// Width and height in pixels; small, since every run is repeated for hundreds of faults.
const EXTENT: [u32; 2] = [16, 9];

/// Opens a device under the validation layers whose calls `watch` counts and lets fail.
fn open(watch: &Arc<Watch>) -> Result<Gpu> {
    Gpu::open(&DeviceQuery { validation: true, watch: Some(Arc::clone(watch)), ..DeviceQuery::default() })
}

/// Makes a shot of a scene by a method, with roughness 0.2 on all surfaces, which reads back the hits too.
fn shot(stage: &mut Stage, method: &MethodInfo, scene: &Scene) -> Result<Shot> {
    let camera = Camera::new(Vec3::new(0.0, 1.5, 0.0), Vec3::new(0.0, 1.0, 6.0), Lens::default(), 16.0 / 9.0);
    let materials = Globals { roughness: Some(0.2), ..Globals::default() }.materials(scene, &View::default());
    Shot::new(stage, method, &Setup::new(EXTENT), Wants::HITS, camera, materials)
}

/// Draws a shot in every way that a study does: timed, counted, and with its images read back. Returns the composite's
/// values.
fn frames(stage: &mut Stage, shot: &Shot) -> Result<Vec<f32>> {
    stage.run(shot, Mode::Timed)?;
    stage.run(shot, Mode::Counted)?;
    Ok(render(stage, shot, false)?.composite.values)
}

/// Returns whether an error has the type that a fault must become, and names the call or the object that failed.
fn is_error_of(error: &Error, fault: Fault) -> bool {
    use ash::vk::Result as R;
    match (fault, error) {
        (Fault::Allocation(_), Error::Memory { what, .. }) => !what.is_empty(),
        (Fault::Allocation(_), Error::Vulkan { what, result }) => {
            !what.is_empty() && *result == R::ERROR_OUT_OF_DEVICE_MEMORY
        }
        (Fault::Submission(_), Error::Vulkan { what, result }) => !what.is_empty() && *result == R::ERROR_DEVICE_LOST,
        _ => false,
    }
}

/// A device, with the watch that counts its calls.
struct Watched {
    gpu: Gpu,
    watch: Arc<Watch>,
    /// The context of a caller on the device, if the test has one.
    context: Option<Context>,
}

impl Watched {
    /// Returns the number of live objects of each kind, and the bytes that are allocated. Blocks of device memory are
    /// left out, since they may stay for the next user.
    fn live(&self) -> (Vec<(&'static str, i64)>, u64) {
        self.trim();
        let counts = self.watch.live().into_iter().filter(|(kind, _)| *kind != "device memory");
        (counts.collect(), self.gpu.allocated_bytes())
    }

    /// Frees all that is kept for later use only.
    fn trim(&self) {
        self.gpu.trim();
        self.context.iter().for_each(Context::trim);
    }

    /// Destroys the device. Panics if an object is left on it or if the validation layers reported anything.
    fn close(self) {
        let Self { gpu, watch, context } = self;
        drop(context);
        let log = gpu.validation_log().unwrap();
        drop(gpu);
        assert_eq!(watch.live().into_iter().collect::<Vec<_>>(), [], "with the device gone");
        let left: Vec<_> = log.violations().into_iter().map(|m| m.text).collect();
        assert_eq!(left, [""; 0], "the validation layers report objects that were left or misused");
    }

    /// Runs an action once without a fault, once with each fault that is tried, and once more without one.
    ///
    /// The tried faults are every `step`th allocation and every submission of the action. Each must make the action
    /// return an error of the right type and leave no object alive. `is_same` compares the results of the first and
    /// the last run; `what` names the action in messages. Returns the number of faults that became errors.
    fn try_faults<T>(
        &self,
        what: &str,
        step: usize,
        mut action: impl FnMut() -> Result<T>,
        is_same: fn(&T, &T) -> bool,
    ) -> usize {
        // A pipeline that is kept would not be made again, so that its allocations could not fail.
        let mut action = || {
            self.trim();
            action()
        };
        self.watch.arm(None);
        let expected = action().unwrap();
        let [allocations, submissions] = self.watch.calls();
        let before = self.live();
        let faults = (1..=allocations).map(Fault::Allocation).step_by(step);
        let mut tried = 0;
        for fault in faults.chain((1..=submissions).map(Fault::Submission)) {
            self.watch.arm(Some(fault));
            let Err(error) = action() else {
                // Blocks of memory that were left need not be allocated again.
                let [reached, _] = self.watch.calls();
                assert!(matches!(fault, Fault::Allocation(n) if reached < n), "{what}, {fault:?}: no error");
                continue;
            };
            assert!(is_error_of(&error, fault), "{what}, {fault:?}: {error}");
            assert_eq!(self.live(), before, "{what}, {fault:?}");
            tried += 1;
        }
        self.watch.arm(None);
        assert!(is_same(&action().unwrap(), &expected), "{what}: not the same after the faults");
        tried
    }
}

/// Makes every `step`th allocation and every submission fail, while a scene is uploaded and while shots of the methods
/// are made and drawn. Returns the number of faults that became errors.
fn every_fault(methods: &[&MethodInfo], step: usize) -> usize {
    let (watch, scene) = (Arc::<Watch>::default(), two_quads());
    let watched = Watched { gpu: open(&watch).unwrap(), watch, context: None };
    let mut tried = watched.try_faults("uploads", step, || Stage::new(&watched.gpu, &scene), |_, _| true);
    let mut stage = Stage::new(&watched.gpu, &scene).unwrap();
    for method in methods {
        let name = method.name;
        tried += if method.takes_triangles {
            // The first shot of a stage uploads its triangles, and the next ones have them.
            watched.try_faults(name, step, || shot(&mut Stage::new(&watched.gpu, &scene)?, method, &scene), |_, _| true)
        } else {
            watched.try_faults(name, step, || shot(&mut stage, method, &scene), |_, _| true)
        };
        let shot = shot(&mut stage, method, &scene).unwrap();
        tried += watched.try_faults(name, step, || frames(&mut stage, &shot), |a, b| a == b);
        watched.gpu.check_validation().unwrap();
    }
    drop(stage);
    watched.close();
    tried
}

/// Every third allocation and every submission of `unified` and `ssct` may fail: the fault becomes an error and leaves
/// nothing behind. Paths that clean up after an error run in no other test.
#[test]
fn allocations_and_submissions_may_fail() {
    if !is_alone() {
        return;
    }
    let methods = ["unified", "ssct"].map(|name| methods::find(name).unwrap());
    let tried = every_fault(&methods, 3);
    println!("{tried} faults");
    assert!(tried > 100, "{tried}");
}

/// Each single allocation and submission of each method may fail, as in the test of two methods that always runs.
#[test]
#[ignore = "minutes: every fault of every method"]
fn every_allocation_and_submission_of_every_method_may_fail() {
    if !is_alone() {
        return;
    }
    let tried = every_fault(&METHODS.iter().collect::<Vec<_>>(), 1);
    println!("{tried} faults");
}

/// If an allocation fails while a device is opened, opening returns an error and destroys whatever had been made until
/// then.
#[test]
fn a_device_that_cannot_be_opened_leaves_nothing() {
    if !is_alone() {
        return;
    }
    let watch = Arc::<Watch>::default();
    drop(open(&watch).unwrap());
    let [allocations, _] = watch.calls();
    assert!(allocations >= 3, "the samplers");
    for n in 1..=allocations {
        watch.arm(Some(Fault::Allocation(n)));
        let error = open(&watch).expect_err("a fault is an error");
        assert!(is_error_of(&error, Fault::Allocation(n)), "{error}");
        assert_eq!(watch.live().into_iter().collect::<Vec<_>>(), []);
    }
}

/// After a frame whose submission fails, the next frame is drawn without a message of the layers. The program tracks
/// the layouts of images on the host, and these must not be those that the lost frame would have left.
#[test]
fn a_frame_that_was_not_submitted_changed_nothing() {
    if !is_alone() {
        return;
    }
    let (watch, scene) = (Arc::<Watch>::default(), two_quads());
    let gpu = open(&watch).unwrap();
    let mut stage = Stage::new(&gpu, &scene).unwrap();
    let shot = shot(&mut stage, methods::find("unified").unwrap(), &scene).unwrap();
    // The first failure comes when images have no layout yet, the second one after a frame was drawn.
    for _ in 0..2 {
        watch.arm(Some(Fault::Submission(1)));
        assert!(is_error_of(&stage.run(&shot, Mode::Timed).unwrap_err(), Fault::Submission(1)));
        watch.arm(None);
        stage.run(&shot, Mode::Timed).unwrap();
        gpu.check_validation().unwrap();
    }
}

/// Faults on a device that a caller handed over through the door become errors too. If the device is lost in the
/// caller's own submission, the times are an error, and new reflections work once the device does.
#[test]
fn a_device_of_the_callers_may_fail() {
    if !is_alone() {
        return;
    }
    let watch = Arc::<Watch>::default();
    let mut watched = Watched { gpu: open(&watch).unwrap(), watch, context: None };
    let mut engine = Engine::new(&watched.gpu);
    let data = view_of_rooms(&watched.gpu, EXTENT);
    let theirs = ForeignGBuffer::new(&mut engine, &data, NATIVE);
    let (context, reflections_info) = (engine.context(), info(&data, "unified"));
    watched.context = Some(context.clone());
    let tried = watched.try_faults("reflections", 3, || Reflections::new(&context, &reflections_info), |_, _| true);
    let mut reflections = Reflections::new(&context, &reflections_info).unwrap();
    assert!(tried > 20, "{tried}");

    // The device is lost in the caller's submission, which returns the error. Asking for the times is an error, too.
    let input = FrameInput { timed: true, ..theirs.input() };
    let commands = engine.begin();
    // SAFETY: the command buffer is recording; what is recorded is submitted, and nothing is under way after it.
    unsafe { reflections.record(commands, &input) }.unwrap();
    watched.watch.arm(Some(Fault::Submission(1)));
    assert_eq!(engine.submit(commands), Err(ash::vk::Result::ERROR_DEVICE_LOST));
    let error = reflections.times(input.slot).unwrap_err();
    assert!(is_error_of(&error, Fault::Submission(1)), "{error}");
    // The reflections may be dropped after the loss and leave nothing. New ones work once the device does.
    drop(reflections);
    watched.watch.arm(None);
    let mut reflections = Reflections::new(&context, &reflections_info).unwrap();
    engine.frame(&mut reflections, &input).unwrap();
    assert_eq!(reflections.times(input.slot).unwrap().first().map(|t| t.name.clone()).as_deref(), Some("import"));
    drop((reflections, context, theirs, engine));
    watched.close();
}

/// A frame of 3000 materials needs more memory for uniform blocks than a device begins with. Where that memory cannot
/// be allocated, the frame is an error, the next frame allocates it, and no later frame allocates more.
#[test]
fn a_frame_that_cannot_grow_is_an_error_and_the_next_one_grows() {
    if !is_alone() {
        return;
    }
    let mut b = Builder::new("many materials");
    for n in 0..3000 {
        let material = b.matt(Vec3::splat((n % 7) as f32 / 7.0));
        let corner = Vec3::new((n % 60) as f32 * 0.1 - 3.0, (n / 60) as f32 * 0.06, 6.0);
        b.quad(material, corner, Vec3::X * 0.1, Vec3::Y * 0.06, Vec3::NEG_Z);
    }
    let watch = Arc::<Watch>::default();
    let watched = Watched { gpu: open(&watch).unwrap(), watch, context: None };
    let mut stage = Stage::new(&watched.gpu, &b.0).unwrap();
    let shot = shot(&mut stage, methods::find("ssct").unwrap(), &b.0).unwrap();
    // Memory for uniform blocks and descriptor pools that a frame grew by before it failed are kept for the next one.
    let kept_objects = |watched: &Watched| {
        let (mut objects, _) = watched.live();
        objects.retain(|(kind, _)| !["buffers", "descriptor pools"].contains(kind));
        objects
    };
    let before = kept_objects(&watched);
    let mut faults = 0;
    // The frame needs more memory for its uniform blocks than it has to begin with.
    let drawn = loop {
        watched.watch.arm(Some(Fault::Allocation(faults + 1)));
        match stage.run(&shot, Mode::Plain) {
            Ok((_, drawn)) => break drawn,
            Err(error) => assert!(is_error_of(&error, Fault::Allocation(faults + 1)), "{error}"),
        }
        assert_eq!(kept_objects(&watched), before, "fault {}", faults + 1);
        faults += 1;
    };
    assert!(faults >= 2, "a buffer and what binds its memory");
    assert_eq!(drawn.meshes, 3000);
    // Grown once, it grows no more.
    let grown = watched.live();
    for _ in 0..2 {
        stage.run(&shot, Mode::Plain).unwrap();
        assert_eq!(watched.live(), grown);
    }
    watched.gpu.check_validation().unwrap();
}

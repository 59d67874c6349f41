//! Records reflections after Bevy's deferred lighting and before its main opaque pass.

use crate::SsctReflections;
use crate::device::{self, SsctFeatures};
use crate::images::{KeepImages, Pending};
use crate::passes::{self, PAIR, Passes, Picture, View, draw, picture};
use crate::world::WorldMeshes;
use bevy::camera::Exposure;
use bevy::core_pipeline::prepass::ViewPrepassTextures;
use bevy::light::EnvironmentMapLight;
use bevy::pbr::{ScreenSpaceReflections, ScreenSpaceReflectionsPipelineId, ScreenSpaceReflectionsUniform};
use bevy::platform::collections::{HashMap, HashSet};
use bevy::prelude::*;
use bevy::render::Extract;
use bevy::render::diagnostic::RecordDiagnostics;
use bevy::render::render_asset::RenderAssets;
use bevy::render::renderer::raw_vulkan_init::AdditionalVulkanFeatures;
use bevy::render::renderer::{RenderAdapter, RenderContext, RenderDevice, RenderQueue, ViewQuery};
use bevy::render::sync_world::RenderEntity;
use bevy::render::texture::GpuImage;
use bevy::render::view::{ExtractedView, ViewTarget};
use embed_wgpu::{HALF, NO_VULKAN, Result, input, resource};
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use wgpu::hal::api::Vulkan;

/// Number of frames that may be recorded or running at the same time.
const FRAMES_IN_FLIGHT: usize = 3;

/// A camera with reflections, in the render world.
#[derive(Component, Clone)]
pub struct Reflected {
    settings: SsctReflections,
    environment: Option<Environment>,
    keep: Option<PathBuf>,
}

/// The environment map of a camera. `exposure` is the factor on its texels.
#[derive(Clone, Copy, PartialEq)]
struct Environment {
    map: AssetId<Image>,
    exposure: f32,
    rotation: Quat,
}

/// The components of a camera that [`extract`] reads.
type Lit = (
    RenderEntity,
    Option<&'static SsctReflections>,
    Option<&'static EnvironmentMapLight>,
    Option<&'static Exposure>,
    Option<&'static KeepImages>,
);

/// Hands cameras with reflections to the render world. Each also gets settings of Bevy's own reflections: with these,
/// Bevy's lighting leaves out the specular part of the environment map, which the pass "add" adds instead.
pub fn extract(mut commands: Commands, cameras: Extract<Query<Lit, With<Camera>>>, before: Query<(), With<Reflected>>) {
    for (entity, settings, light, exposure, keep) in &cameras {
        let was_reflected = before.contains(entity);
        let mut camera = commands.entity(entity);
        let Some(settings) = settings else {
            if was_reflected {
                camera.remove::<(Reflected, ScreenSpaceReflectionsUniform)>();
            }
            continue;
        };
        let exposure = exposure.copied().unwrap_or_default().exposure();
        let environment = light.map(|light| Environment {
            map: light.specular_map.id(),
            exposure: light.intensity * exposure,
            rotation: light.rotation,
        });
        let everywhere = ScreenSpaceReflections {
            min_perceptual_roughness: 0.0..0.0,
            max_perceptual_roughness: 1.0..1.0,
            ..default()
        };
        let reflected = Reflected { settings: settings.clone(), environment, keep: keep.map(|keep| keep.0.clone()) };
        camera.insert((reflected, ScreenSpaceReflectionsUniform::from(everywhere)));
    }
}

/// Keeps Bevy's own reflection pass from running on cameras with [`SsctReflections`].
pub fn leave_out_bevys(
    mut commands: Commands,
    cameras: Query<Entity, (With<Reflected>, With<ScreenSpaceReflectionsPipelineId>)>,
) {
    for camera in &cameras {
        commands.entity(camera).remove::<ScreenSpaceReflectionsPipelineId>();
    }
}

/// The state that the reflections of all cameras share.
#[derive(Resource)]
pub struct Reflecting {
    state: Mutex<State>,
    pending: Mutex<Vec<Pending>>,
    /// The device is done with all frames before this number.
    done: Arc<AtomicU64>,
    /// Errors that were reported, so that each one is logged once and not in every frame.
    reported: Mutex<HashSet<String>>,
}

/// The objects on the device, of `ssct` and of wgpu. Rust drops fields in order: first the objects of `ssct`, last the
/// device.
struct State {
    views: HashMap<Entity, Viewed>,
    triangles: Option<Built>,
    /// Objects that are no longer needed, each with the number of the last frame that may use it.
    retired: Vec<(u64, Box<dyn Send>)>,
    context: ssct::Context,
    passes: Passes,
    frame: u64,
    device: wgpu::Device,
}

impl Drop for State {
    fn drop(&mut self) {
        // If the device is lost, the call fails; a lost device runs no commands any more.
        let _ = self.device.poll(wgpu::PollType::wait_indefinitely());
    }
}

/// The tree over the world's triangles on the device. `changes` says from which state of [`WorldMeshes`] it was built.
struct Built {
    changes: u64,
    triangles: ssct::Triangles,
}

impl Built {
    /// Builds the tree over the triangles, and records its copy to the device into `raw`.
    fn new(world: &WorldMeshes, context: &ssct::Context, raw: &mut wgpu::CommandEncoder) -> Result<Self> {
        let mut triangles = world.triangles(context)?;
        // SAFETY: the command buffer is recording outside rendering, and is submitted before the frames that see them.
        unsafe { in_raw(raw, |commands| triangles.record_upload(commands)) }??;
        Ok(Self { changes: world.changes, triangles })
    }
}

/// The reflections of one camera, and the images that they read.
struct Viewed {
    settings: SsctReflections,
    reflections: ssct::Reflections,
    /// The images that `reflections` write, as textures of wgpu: one, or two in turn with a history.
    outputs: Vec<(ash::vk::Image, Picture)>,
    normal: Picture,
    material: Picture,
    depth: Option<Picture>,
    view: wgpu::Buffer,
    sky: Option<(Environment, Picture)>,
    /// The number of the last frame that used each slot.
    slots: [u64; FRAMES_IN_FLIGHT],
    /// The slot of the next frame.
    next: usize,
}

/// Inserts the resource [`Reflecting`]. Logs an error instead if the device lacks what `ssct` needs.
pub fn start(
    mut commands: Commands,
    (adapter, device): (Res<RenderAdapter>, Res<RenderDevice>),
    additional: Option<Res<AdditionalVulkanFeatures>>,
) {
    if !additional.is_some_and(|additional| additional.has::<SsctFeatures>()) {
        error!("SsctPlugin: set RenderPlugin::render_creation to embed_bevy::render_creation()");
        return;
    }
    let device = device.wgpu_device().clone();
    match device::context(&adapter, &device) {
        Ok(context) => {
            let (views, retired, passes) = (HashMap::default(), Vec::new(), Passes::new(&device));
            let state = State { views, triangles: None, retired, context, passes, frame: 0, device };
            let state = Mutex::new(state);
            commands.insert_resource(Reflecting {
                state,
                pending: Mutex::default(),
                done: Arc::default(),
                reported: Mutex::default(),
            });
        }
        Err(why) => error!("SsctPlugin: {why}"),
    }
}

/// Counts the frames, and asks the device to say when the earlier ones are done. Retires the reflections of cameras
/// that lost their component, and drops the retired objects that no frame uses any more.
pub fn begin(reflecting: Option<Res<Reflecting>>, queue: Res<RenderQueue>, cameras: Query<(), With<Reflected>>) {
    let Some(reflecting) = reflecting else { return };
    let mut state = lock(&reflecting.state);
    let State { views, retired, frame, .. } = &mut *state;
    let ended: Vec<_> = views.extract_if(|camera, _| !cameras.contains(*camera)).collect();
    retired.extend(ended.into_iter().map(|(_, view)| (*frame, Box::new(view) as _)));
    state.frame += 1;
    let (done, frame) = (reflecting.done.clone(), state.frame);
    queue.on_submitted_work_done(move || {
        done.fetch_max(frame, Ordering::Release);
    });
    let finished = reflecting.done.load(Ordering::Acquire);
    state.retired.retain(|(frame, _)| *frame >= finished);
}

/// The components of a camera that [`reflect`] reads.
type Drawn = (&'static Reflected, &'static ExtractedView, &'static ViewTarget, &'static ViewPrepassTextures);

/// Records the reflections of a camera, and adds the reflected light to the lit colour of its picture.
pub fn reflect(
    view: ViewQuery<Drawn>,
    reflecting: Option<Res<Reflecting>>,
    world: Res<WorldMeshes>,
    images: Res<RenderAssets<GpuImage>>,
    adapter: Res<RenderAdapter>,
    mut ctx: RenderContext,
) {
    let entity = view.entity();
    let (reflected, extracted, target, prepass) = view.into_inner();
    let Some(reflecting) = reflecting else { return };
    let frame = Frame { entity, reflected, extracted, target, prepass, images: &images, adapter: &adapter };
    if let Err(why) = frame.record(&reflecting, &world, &mut ctx) {
        let why = why.to_string();
        if lock(&reflecting.reported).insert(why.clone()) {
            error!("no reflections: {why}");
        }
    }
}

/// One frame of one camera: the components and resources that it is recorded from.
struct Frame<'a> {
    entity: Entity,
    reflected: &'a Reflected,
    extracted: &'a ExtractedView,
    target: &'a ViewTarget,
    prepass: &'a ViewPrepassTextures,
    images: &'a RenderAssets<GpuImage>,
    adapter: &'a wgpu::Adapter,
}

impl Frame<'_> {
    /// Records the frame: the images that the reflections read, the reflections, and their sum with the lit colour.
    fn record(&self, reflecting: &Reflecting, world: &WorldMeshes, ctx: &mut RenderContext) -> Result<()> {
        let mut state = lock(&reflecting.state);
        let State { views, triangles, retired, context, passes, frame, device } = &mut *state;
        let depth = self.prepass.depth.as_ref().zip(self.prepass.depth_only_view());
        let (depth, depth_view) = depth.ok_or("there is no depth prepass")?;
        let deferred = self.prepass.deferred_view().ok_or("there is no deferred prepass")?;
        let settings = &self.reflected.settings.for_world(world);
        let environment = self.environment();
        // wgpu refuses an encoder that has both its own commands and raw ones, so that the raw ones get this encoder.
        let mut raw = device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("ssct") });

        if settings.world && triangles.as_ref().is_none_or(|built| built.changes != world.changes) {
            let replaced = triangles.replace(Built::new(world, context, &mut raw)?);
            retired.extend(replaced.map(|built| (*frame, Box::new(built.triangles) as _)));
        }
        let triangles = triangles.as_ref().filter(|_| settings.world).map(|built| &built.triangles);

        let extent = [self.prepass.size.width, self.prepass.size.height];
        if views.get(&self.entity).is_none_or(|v| v.settings != *settings || v.reflections.extent() != extent) {
            // The device is idle after this, so that the old reflections of this camera can be dropped.
            device.poll(wgpu::PollType::wait_indefinitely())?;
            views.insert(self.entity, Viewed::new(context, device, settings, extent, triangles)?);
        }
        let viewed = views.get_mut(&self.entity).ok_or("made above")?;
        let slot = viewed.slot(*frame, &reflecting.done, device)?;

        let matrices = self.matrices();
        let block = self.block(&matrices, environment);
        let diagnostics = ctx.diagnostic_recorder();
        let diagnostics = diagnostics.as_deref();
        let encoder = ctx.command_encoder();
        let span = diagnostics.time_span(encoder, "ssct");
        write_block(device, encoder, &viewed.view, &block);
        let bound_view = (0, viewed.view.as_entire_binding());
        let gbuffer_bindings = [
            bound_view.clone(),
            (1, wgpu::BindingResource::TextureView(depth_view)),
            (2, wgpu::BindingResource::TextureView(deferred)),
        ];
        let targets = [&viewed.normal.view, &viewed.material.view];
        draw(device, encoder, &passes.inputs, &gbuffer_bindings, &targets, 0);
        let map = environment.map_or(&passes.nothing.view, |(_, image)| &*image.texture_view);
        let bound_map = (5, wgpu::BindingResource::TextureView(map));
        let bound_sampler = (6, wgpu::BindingResource::Sampler(&passes.sampler));
        let bindings = [bound_view.clone(), bound_map.clone(), bound_sampler.clone()];
        viewed.sky = match (viewed.sky.take(), environment) {
            (Some((source, sky)), Some((current, _))) if source == current => Some((source, sky)),
            (_, Some((new, image))) => Some((new, passes.sky(device, encoder, &bindings, image.texture.width()))),
            (_, None) => None,
        };

        // The pass "add" reads the lit colour from one texture of the target, and writes the sum to the other.
        let written = self.target.post_process_write();
        let (lit, lit_view) = (&**written.source_texture, &**written.source);
        let inputs = [&*depth.texture.texture, &viewed.normal.texture, &viewed.material.texture, lit];
        let inputs = inputs.into_iter().chain(viewed.sky.as_ref().map(|(_, sky)| &sky.texture));
        let state = wgpu::TextureUses::RESOURCE;
        let transitions = inputs.map(|texture| wgpu::TextureTransition { texture, selector: None, state });
        encoder.transition_resources(std::iter::empty(), transitions);

        let sampled = (&*depth.texture.texture, &**depth_view);
        let frame_input = self.input(viewed, sampled, (lit, lit_view), &matrices)?;
        let frame_input = ssct::FrameInput { slot, triangles, ..frame_input };
        let reflections = &mut viewed.reflections;
        // SAFETY: the command buffer is recording outside rendering. It is submitted after the commands that write its
        // inputs, in the order of frames, and the last frame with this slot is done.
        let recorded = unsafe { in_raw(&mut raw, |commands| reflections.record(commands, &frame_input)) }??;
        let output = recorded.reflection.ok_or("the reflection was asked for")?;
        let known = viewed.outputs.iter().position(|(image, _)| *image == output.image);
        if known.is_none() {
            viewed.outputs.push((output.image, passes::adopt(device, &output)?));
        }
        let (_, reflection) = &viewed.outputs[known.unwrap_or(viewed.outputs.len() - 1)];
        ctx.add_command_buffer(raw.finish());

        let encoder = ctx.command_encoder();
        let [view, depth_buffer, deferred_buffer] = gbuffer_bindings;
        let bindings = [
            view.clone(),
            depth_buffer.clone(),
            deferred_buffer,
            (3, wgpu::BindingResource::TextureView(lit_view)),
            (4, wgpu::BindingResource::TextureView(&reflection.view)),
            bound_map,
            bound_sampler,
        ];
        draw(device, encoder, &passes.add, &bindings, &[&**written.destination], 0);
        span.end(encoder);
        if let Some(folder) = &self.reflected.keep {
            let kept = viewed.depth.get_or_insert_with(|| picture(device, "depth", extent, passes::DEPTH));
            draw(device, encoder, &passes.depth, &[depth_buffer], &[&kept.view], 0);
            let (normal, material) = (&viewed.normal.texture, &viewed.material.texture);
            let images = [
                ("depth", &kept.texture),
                ("normal", normal),
                ("material", material),
                ("color", lit),
                ("reflection", &reflection.texture),
            ];
            lock(&reflecting.pending).push(Pending::record(device, encoder, folder, matrices, &images));
        }
        Ok(())
    }

    /// Describes the inputs of the reflections, all of which are textures in the state `RESOURCE`.
    fn input<'t>(
        &self,
        viewed: &Viewed,
        (depth, depth_view): (&wgpu::Texture, &wgpu::TextureView),
        (lit, lit_view): (&wgpu::Texture, &wgpu::TextureView),
        [view_to_clip, world_to_view]: &[[f32; 16]; 2],
    ) -> Result<ssct::FrameInput<'t>> {
        let picture_input = |picture: &Picture| input(self.adapter, &picture.texture, &picture.view);
        let (world_to_view, view_to_clip) = (*world_to_view, *view_to_clip);
        let material = picture_input(&viewed.material)?;
        Ok(ssct::FrameInput {
            slot: 0,
            camera: ssct::CameraInput { world_to_view, view_to_clip, clip_y: ssct::ClipY::Up },
            depth: input(self.adapter, depth, depth_view)?,
            normal: ssct::NormalInput {
                image: picture_input(&viewed.normal)?,
                space: ssct::NormalSpace::View,
                encoding: ssct::NormalEncoding::Float,
            },
            reflectivity: ssct::FactorInput::Channel(material, 0),
            roughness: ssct::FactorInput::Channel(material, 1),
            reflectors: ssct::Reflectors::UNKNOWN,
            color: input(self.adapter, lit, lit_view)?,
            sky: viewed.sky.as_ref().map(|(_, sky)| picture_input(sky)).transpose()?,
            captures: None,
            triangles: None,
            triangle_numbers: None,
            motion: None,
            timed: false,
            outputs: resource(HALF),
        })
    }

    /// The environment map with its image, or `None` without one or before Bevy has loaded it.
    fn environment(&self) -> Option<(Environment, &GpuImage)> {
        let environment = self.reflected.environment?;
        Some((environment, self.images.get(environment.map)?))
    }

    /// The camera's matrices by columns: view to clip space, and world to view space.
    fn matrices(&self) -> [[f32; 16]; 2] {
        let world_to_view = self.extracted.world_from_view.to_matrix().inverse();
        [self.extracted.clip_from_view.to_cols_array(), world_to_view.to_cols_array()]
    }

    /// The uniform block `View` of this camera's passes; passes.wgsl says what its fields mean.
    fn block(
        &self,
        [view_to_clip, world_to_view]: &[[f32; 16]; 2],
        environment: Option<(Environment, &GpuImage)>,
    ) -> View {
        let clip_from_world = Mat4::from_cols_array(view_to_clip) * Mat4::from_cols_array(world_to_view);
        let pose = self.extracted.world_from_view.to_matrix();
        let is_orthographic = view_to_clip[15] == 1.0;
        let eye = if is_orthographic { pose.z_axis.truncate().extend(1.0) } else { pose.w_axis.truncate().extend(0.0) };
        let (rotation, exposure) = environment.map_or((Quat::IDENTITY, 0.0), |(e, _)| (e.rotation, e.exposure));
        let range = &self.reflected.settings.max_perceptual_roughness;
        View {
            world_from_clip: clip_from_world.inverse().to_cols_array(),
            view_from_world: *world_to_view,
            eye: eye.to_array(),
            environment: rotation.to_array(),
            fade: [range.start, range.end],
            exposure,
            levels: environment.map_or(0.0, |(_, image)| (image.texture.mip_level_count() - 1) as f32),
        }
    }
}

impl Viewed {
    /// Makes the reflections of a camera with `settings`, for pictures of `extent` pixels.
    fn new(
        context: &ssct::Context,
        device: &wgpu::Device,
        settings: &SsctReflections,
        extent: [u32; 2],
        triangles: Option<&ssct::Triangles>,
    ) -> Result<Self> {
        let named = settings.parameters.iter().map(|(name, value)| (name.as_str(), value.as_str()));
        let parameters: Vec<_> = settings.history.then_some(("history", "on")).into_iter().chain(named).collect();
        let info = ssct::ReflectionsInfo {
            extent,
            method: &settings.method,
            parameters: &parameters,
            triangles,
            composite: false,
            frames_in_flight: FRAMES_IN_FLIGHT,
            ..Default::default()
        };
        Ok(Self {
            settings: settings.clone(),
            reflections: ssct::Reflections::new(context, &info)?,
            outputs: Vec::new(),
            normal: picture(device, "ssct normal", extent, HALF),
            material: picture(device, "ssct material", extent, PAIR),
            depth: None,
            view: device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("ssct view"),
                size: View::BYTES,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }),
            sky: None,
            slots: [0; FRAMES_IN_FLIGHT],
            next: 0,
        })
    }

    /// Returns the slot for a frame. Waits first until the device is done with the last frame that used this slot.
    fn slot(&mut self, frame: u64, done: &AtomicU64, device: &wgpu::Device) -> Result<usize> {
        let slot = self.next;
        self.next = (slot + 1) % FRAMES_IN_FLIGHT;
        if self.slots[slot] >= done.load(Ordering::Acquire) {
            device.poll(wgpu::PollType::wait_indefinitely())?;
        }
        self.slots[slot] = frame;
        Ok(slot)
    }
}

impl Reflecting {
    /// Takes the copies of images that are not written to files yet.
    pub fn take_pending(&self) -> Vec<Pending> {
        std::mem::take(&mut lock(&self.pending))
    }
}

/// Calls `record` with the Vulkan command buffer of `encoder`, into which wgpu itself has recorded nothing. wgpu does
/// not see which textures `record` reads, so the caller must bring these into the right state before.
///
/// # Safety
/// The caller must keep the contract of the function of `ssct` that `record` calls.
unsafe fn in_raw<T>(
    encoder: &mut wgpu::CommandEncoder,
    record: impl FnOnce(ash::vk::CommandBuffer) -> ssct::Result<T>,
) -> Result<ssct::Result<T>> {
    // SAFETY: the caller keeps the contract.
    unsafe { encoder.as_hal_mut::<Vulkan, _, _>(|encoder| Ok(record(encoder.ok_or(NO_VULKAN)?.raw_handle()))) }
}

/// Records a copy of the block into the uniform buffer `to`. Each frame copies from a new buffer, so that frames that
/// are still running keep theirs.
fn write_block(device: &wgpu::Device, encoder: &mut wgpu::CommandEncoder, to: &wgpu::Buffer, block: &View) {
    use wgpu::util::DeviceExt;
    let usage = wgpu::BufferUsages::COPY_SRC;
    let contents = &block.bytes();
    let from =
        device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: Some("ssct view"), contents, usage });
    encoder.copy_buffer_to_buffer(&from, 0, to, 0, View::BYTES);
}

/// Locks a mutex, even if a thread panicked that held it.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

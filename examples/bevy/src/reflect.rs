//! Records reflections between Bevy's deferred lighting and what it draws after it.

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

/// Frames that the device may have under way.
const FRAMES_IN_FLIGHT: usize = 3;

/// A camera with reflections, in the render world.
#[derive(Component, Clone)]
pub struct Reflected {
    settings: SsctReflections,
    environment: Option<Environment>,
    keep: Option<PathBuf>,
}

#[derive(Clone, Copy, PartialEq)]
struct Environment {
    map: AssetId<Image>,
    exposure: f32,
    rotation: Quat,
}

type Lit = (
    RenderEntity,
    Option<&'static SsctReflections>,
    Option<&'static EnvironmentMapLight>,
    Option<&'static Exposure>,
    Option<&'static KeepImages>,
);

/// Hands cameras with reflections to the render world, with settings of Bevy's own reflections: while they are on, its lighting
/// leaves out the mirrored part of the environment map, which is added here.
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

/// Keeps Bevy's own pass from running on cameras with reflections.
pub fn leave_out_bevys(
    mut commands: Commands,
    cameras: Query<Entity, (With<Reflected>, With<ScreenSpaceReflectionsPipelineId>)>,
) {
    for camera in &cameras {
        commands.entity(camera).remove::<ScreenSpaceReflectionsPipelineId>();
    }
}

/// What reflections need on the device.
#[derive(Resource)]
pub struct Reflecting {
    state: Mutex<State>,
    pending: Mutex<Vec<Pending>>,
    /// Frames before this one are done.
    done: Arc<AtomicU64>,
    /// Faults that were reported: each is said once, and not in every frame.
    reported: Mutex<HashSet<String>>,
}

/// Fields are dropped in their order: what `ssct` made, before the device.
struct State {
    views: HashMap<Entity, Viewed>,
    triangles: Option<Built>,
    /// What frames up to a number may still use.
    retired: Vec<(u64, Box<dyn Send>)>,
    context: ssct::Context,
    passes: Passes,
    frame: u64,
    device: wgpu::Device,
}

impl Drop for State {
    fn drop(&mut self) {
        // A device that is lost is done with everything.
        let _ = self.device.poll(wgpu::PollType::wait_indefinitely());
    }
}

/// The world's meshes on the device.
struct Built {
    changes: u64,
    triangles: ssct::Triangles,
}

impl Built {
    /// Builds the triangles, and records copying them to the device.
    fn new(world: &WorldMeshes, context: &ssct::Context, raw: &mut wgpu::CommandEncoder) -> Result<Self> {
        let mut triangles = world.triangles(context)?;
        // SAFETY: the command buffer is recording outside rendering, and is submitted before the frames that see them.
        unsafe { in_raw(raw, |commands| triangles.record_upload(commands)) }??;
        Ok(Self { changes: world.changes, triangles })
    }
}

/// What one camera needs.
struct Viewed {
    settings: SsctReflections,
    reflections: ssct::Reflections,
    /// The images that `reflections` make: the same one in every frame, or two in turn with a history.
    made: Vec<(ash::vk::Image, Picture)>,
    normal: Picture,
    material: Picture,
    depth: Option<Picture>,
    view: wgpu::Buffer,
    sky: Option<(Environment, Picture)>,
    /// The frame that was recorded last with each slot.
    slots: [u64; FRAMES_IN_FLIGHT],
    next: usize,
}

/// Makes what reflections need, if the device has on what they need.
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

/// Counts frames, lets the device say when those before are done, and lets go of what cameras needed that have no reflections any
/// more.
pub fn begin(reflecting: Option<Res<Reflecting>>, queue: Res<RenderQueue>, cameras: Query<(), With<Reflected>>) {
    let Some(reflecting) = reflecting else { return };
    let mut state = lock(&reflecting.state);
    let State { views, retired, frame, .. } = &mut *state;
    let gone: Vec<_> = views.extract_if(|camera, _| !cameras.contains(*camera)).collect();
    retired.extend(gone.into_iter().map(|(_, view)| (*frame, Box::new(view) as _)));
    state.frame += 1;
    let (done, frame) = (reflecting.done.clone(), state.frame);
    queue.on_submitted_work_done(move || {
        done.fetch_max(frame, Ordering::Release);
    });
    let finished = reflecting.done.load(Ordering::Acquire);
    state.retired.retain(|(frame, _)| *frame >= finished);
}

type Drawn = (&'static Reflected, &'static ExtractedView, &'static ViewTarget, &'static ViewPrepassTextures);

/// Adds what is reflected to the lit colour of a camera.
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

/// What a camera's frame is made of.
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
    fn record(&self, reflecting: &Reflecting, world: &WorldMeshes, ctx: &mut RenderContext) -> Result<()> {
        let mut state = lock(&reflecting.state);
        let State { views, triangles, retired, context, passes, frame, device } = &mut *state;
        let depth = self.prepass.depth.as_ref().zip(self.prepass.depth_only_view());
        let (depth, depth_view) = depth.ok_or("there is no depth prepass")?;
        let deferred = self.prepass.deferred_view().ok_or("there is no deferred prepass")?;
        let settings = &self.reflected.settings.seeing(world);
        let environment = self.environment();
        let mut raw = device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("ssct") });

        if settings.world && triangles.as_ref().is_none_or(|built| built.changes != world.changes) {
            let old = triangles.replace(Built::new(world, context, &mut raw)?);
            retired.extend(old.map(|old| (*frame, Box::new(old.triangles) as _)));
        }
        let triangles = triangles.as_ref().filter(|_| settings.world).map(|built| &built.triangles);

        let extent = [self.prepass.size.width, self.prepass.size.height];
        if views.get(&self.entity).is_none_or(|v| v.settings != *settings || v.reflections.extent() != extent) {
            // What the old ones recorded is done, and nothing shows them any more.
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
        let of_gbuffer = [
            bound_view.clone(),
            (1, wgpu::BindingResource::TextureView(depth_view)),
            (2, wgpu::BindingResource::TextureView(deferred)),
        ];
        let targets = [&viewed.normal.view, &viewed.material.view];
        draw(device, encoder, &passes.inputs, &of_gbuffer, &targets, 0);
        let map = environment.map_or(&passes.nothing.view, |(_, image)| &*image.texture_view);
        let bound_map = (5, wgpu::BindingResource::TextureView(map));
        let bound_sampler = (6, wgpu::BindingResource::Sampler(&passes.sampler));
        let bindings = [bound_view.clone(), bound_map.clone(), bound_sampler.clone()];
        viewed.sky = match (viewed.sky.take(), environment) {
            (Some((source, sky)), Some((is, _))) if source == is => Some((source, sky)),
            (_, Some((is, image))) => Some((is, passes.sky(device, encoder, &bindings, image.texture.width()))),
            (_, None) => None,
        };

        // From here on, the lit colour is the source of a pass that writes the other texture.
        let written = self.target.post_process_write();
        let (lit, lit_view) = (&**written.source_texture, &**written.source);
        let read = [&*depth.texture.texture, &viewed.normal.texture, &viewed.material.texture, lit];
        let read = read.into_iter().chain(viewed.sky.as_ref().map(|(_, sky)| &sky.texture));
        let state = wgpu::TextureUses::RESOURCE;
        let transitions = read.map(|texture| wgpu::TextureTransition { texture, selector: None, state });
        encoder.transition_resources(std::iter::empty(), transitions);

        let sampled = (&*depth.texture.texture, &**depth_view);
        let frame_input = self.input(viewed, sampled, (lit, lit_view), &matrices)?;
        let frame_input = ssct::FrameInput { slot, triangles, ..frame_input };
        let reflections = &mut viewed.reflections;
        // SAFETY: the command buffer is recording outside rendering, and is submitted after what it reads, in the order of
        // frames; the frame with the same slot is done.
        let recorded = unsafe { in_raw(&mut raw, |commands| reflections.record(commands, &frame_input)) }??;
        let made = recorded.reflection.ok_or("the reflection was asked for")?;
        let known = viewed.made.iter().position(|(image, _)| *image == made.image);
        if known.is_none() {
            viewed.made.push((made.image, passes::adopt(device, &made)?));
        }
        let (_, reflection) = &viewed.made[known.unwrap_or(viewed.made.len() - 1)];
        ctx.add_command_buffer(raw.finish());

        let encoder = ctx.command_encoder();
        let [view, depth_buffer, deferred_buffer] = of_gbuffer;
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
            let made = [("color", lit), ("reflection", &reflection.texture)];
            let images = [("depth", &kept.texture), ("normal", normal), ("material", material)].into_iter().chain(made);
            let images: Vec<_> = images.collect();
            lock(&reflecting.pending).push(Pending::record(device, encoder, folder, matrices, &images));
        }
        Ok(())
    }

    /// What the reflections read: textures that are in the state `RESOURCE`.
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

    /// The environment map, once it is loaded.
    fn environment(&self) -> Option<(Environment, &GpuImage)> {
        let environment = self.reflected.environment?;
        Some((environment, self.images.get(environment.map)?))
    }

    /// From view to clip space, and from the world to view space.
    fn matrices(&self) -> [[f32; 16]; 2] {
        let world_to_view = self.extracted.world_from_view.to_matrix().inverse();
        [self.extracted.clip_from_view.to_cols_array(), world_to_view.to_cols_array()]
    }

    fn block(
        &self,
        [view_to_clip, world_to_view]: &[[f32; 16]; 2],
        environment: Option<(Environment, &GpuImage)>,
    ) -> View {
        let clip_from_world = Mat4::from_cols_array(view_to_clip) * Mat4::from_cols_array(world_to_view);
        let eye = self.extracted.world_from_view.to_matrix();
        let is_orthographic = view_to_clip[15] == 1.0;
        let eye = if is_orthographic { eye.z_axis.truncate().extend(1.0) } else { eye.w_axis.truncate().extend(0.0) };
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
            made: Vec::new(),
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

    /// A slot for a frame, once the device is done with the frame that had it before.
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
    /// Images that frames keep, and that are not written yet.
    pub fn take_pending(&self) -> Vec<Pending> {
        std::mem::take(&mut lock(&self.pending))
    }
}

/// Records into the command buffer of an encoder that has no commands of wgpu's. wgpu knows no texture of theirs, so that what
/// they read is brought into a known state before.
///
/// # Safety
/// The contract is that of the library's function.
unsafe fn in_raw<T>(
    encoder: &mut wgpu::CommandEncoder,
    record: impl FnOnce(ash::vk::CommandBuffer) -> ssct::Result<T>,
) -> Result<ssct::Result<T>> {
    // SAFETY: by the contract.
    unsafe { encoder.as_hal_mut::<Vulkan, _, _>(|encoder| Ok(record(encoder.ok_or(NO_VULKAN)?.raw_handle()))) }
}

/// Records writing the block of a view, so that each frame has its own.
fn write_block(device: &wgpu::Device, encoder: &mut wgpu::CommandEncoder, to: &wgpu::Buffer, block: &View) {
    use wgpu::util::DeviceExt;
    let usage = wgpu::BufferUsages::COPY_SRC;
    let contents = &block.bytes();
    let from =
        device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: Some("ssct view"), contents, usage });
    encoder.copy_buffer_to_buffer(&from, 0, to, 0, View::BYTES);
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

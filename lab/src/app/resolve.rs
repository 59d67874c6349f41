//! Finds what the flags mean together: scene, view, device, global factors, variants.

use super::cli::{DeviceOptions, SceneOptions};
use super::parameters::TypedVariant;
use super::variants::VariantOptions;
use crate::error::{Error, Result};
use crate::stage::Globals;
use crate::study::error::Variant;
use crate::study::exhibit::distinct;
use crate::study::sweep;
use ssct::gpu::{DeviceQuery, Gpu, Watch};
use ssct::methods::needs::Need;
use ssct::methods::{self, MethodInfo, Setup};
use ssct_scenes::path::{self, VIEWS};
use ssct_scenes::{CameraPath, FieldOfView, Lens, LoadOptions, Motion, Scene, View, gltf, library, obj, scene_file};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Opens the device that the flags choose.
pub fn gpu(options: &DeviceOptions) -> Result<Gpu> {
    Ok(Gpu::open(&DeviceQuery {
        device: options.device.clone(),
        validation: options.validation,
        watch: watch()?,
        ..DeviceQuery::default()
    })?)
}

/// A watch that makes one call fail, so that a user can try what happens then. The variable SSCT_FAULT names the call,
/// as in `submission:7`; `None` without the variable.
fn watch() -> Result<Option<Arc<Watch>>> {
    let Some(fault) = std::env::var("SSCT_FAULT").ok().filter(|f| !f.is_empty()) else { return Ok(None) };
    let watch = Arc::<Watch>::default();
    watch.arm(Some(fault.parse()?));
    Ok(Some(watch))
}

/// Loads the scene that the flags name, or else the built-in scene `default`. With `--time`, things stand where a
/// motion of the scene has them at that time.
pub fn scene(options: &SceneOptions, default: &str) -> Result<Scene> {
    let fallback = [PathBuf::from(default)];
    let sources = if options.scene.is_empty() { &fallback } else { options.scene.as_slice() };
    let mut scene = load(sources, &LoadOptions { scale: options.scale, texture_side: options.texture_size })?;
    if let Some(time_s) = options.time {
        if !time_s.is_finite() {
            return Err(Error::usage(format!("--time {time_s}: must be a number of seconds")));
        }
        let motion = motion(&scene, options.motion.as_deref(), "--time")?.clone();
        scene.pose(&motion, time_s);
    }
    Ok(scene)
}

/// The motion that has the name; without a name, the scene's first. An error names `flag`, which asks for the motion.
pub fn motion<'s>(scene: &'s Scene, name: Option<&str>, flag: &str) -> Result<&'s Motion> {
    let found = match name {
        Some(name) => scene.motions.iter().find(|m| m.name == name),
        None => scene.motions.first(),
    };
    found.ok_or_else(|| {
        let names: Vec<&str> = scene.motions.iter().map(|m| m.name.as_str()).collect();
        let has = if names.is_empty() { "it has none".to_owned() } else { format!("it has: {}", names.join(", ")) };
        let wanted = name.map_or_else(|| "no motion".to_owned(), |name| format!("no motion {name:?}"));
        Error::usage(format!("{flag}: scene {} has {wanted}; {has}", scene.name))
    })
}

/// True if two paths lead to the same file or folder, which exists.
pub fn is_same_place(a: &Path, b: &Path) -> bool {
    a.canonicalize().ok().zip(b.canonicalize().ok()).is_some_and(|(a, b)| a == b)
}

/// Loads a scene, and prints its warnings and notes on standard error. `sources` is the name of a scene that is built
/// in, a scene file, a glTF file, or OBJ files.
pub fn load(sources: &[PathBuf], options: &LoadOptions) -> Result<Scene> {
    let scale = options.scale;
    if !(scale.is_finite() && scale > 0.0) {
        return Err(Error::usage(format!("--scale {scale}: must be a number above 0")));
    }
    let extension = |p: &Path| p.extension().and_then(|e| e.to_str()).map(str::to_lowercase);
    let scene = match sources {
        [file] if is_toml(file) => scene_file::load(file, options)?,
        [file] if gltf::is_named(file) => gltf::load(file, options)?,
        _ if sources.iter().all(|p| extension(p).as_deref() == Some("obj")) => {
            let files: Vec<_> = sources.iter().map(obj::ObjFile::from).collect();
            obj::load(&files, &obj::ObjOptions { load: *options, ..obj::ObjOptions::default() })?
        }
        [name] => {
            let name = name.to_string_lossy();
            let mut scene = library::scene(&name).ok_or_else(|| {
                Error::usage(format!(
                    "{name}: neither a built-in scene ({}) nor a .scene.toml, .gltf, .glb or .obj file",
                    library::every_name().collect::<Vec<_>>().join(", ")
                ))
            })?;
            if scale != 1.0 {
                scene.scale(scale);
            }
            scene
        }
        several => {
            let names: Vec<_> = several.iter().map(|p| p.to_string_lossy()).collect();
            return Err(Error::usage(format!("{}: only OBJ files make one scene together", names.join(", "))));
        }
    };
    for warning in &scene.warnings {
        eprintln!("ssct: warning: {}", super::printable(warning));
    }
    for note in &scene.notes {
        eprintln!("ssct: {}", super::printable(note));
    }
    Ok(scene)
}

/// The view that the flags name or place, else the view `default`, else the scene's first. The flags replace values of
/// its lens.
pub fn view(scene: &Scene, options: &SceneOptions, default: Option<&str>) -> Result<View> {
    let view = match (options.view.as_deref().or(default), options.eye, options.look_at) {
        (_, Some(eye), Some(look_at)) => {
            if eye.distance(look_at) < 1e-6 {
                return Err(Error::usage("--eye and --look-at are the same point".into()));
            }
            View { name: "custom".into(), eye, look_at, ..View::default() }
        }
        (Some(name), ..) => scene.view(name)?.clone(),
        _ => scene.views.first().cloned().ok_or_else(|| Error::usage(format!("scene {} has no view", scene.name)))?,
    };
    let view = with_lens(scene, view, options)?;
    if options.eye.is_some() {
        warn_of_view_faults(scene, &view);
    }
    Ok(view)
}

/// Warns of faults of a view that flags place; the views of a scene file get the same warnings.
fn warn_of_view_faults(scene: &Scene, view: &View) {
    let faults = scene_file::seen::faults(scene, std::slice::from_ref(view)).into_iter().flatten();
    faults.for_each(|fault| eprintln!("ssct: warning: --eye and --look-at: the view {fault}"));
}

/// A view with the lens that the flags ask for.
pub fn with_lens(scene: &Scene, mut view: View, options: &SceneOptions) -> Result<View> {
    view.lens = Some(lens(options, view.lens.unwrap_or(scene.lens))?);
    Ok(view)
}

/// Returns a lens in which the flags replace the opening and the planes; values that no lens can have are an error.
pub fn lens(options: &SceneOptions, mut lens: Lens) -> Result<Lens> {
    if let Some(fov) = options.fov {
        if !(fov > 0.0 && fov < 180.0) {
            return Err(Error::usage(format!("--fov {fov}: must lie between 0 and 180 degrees")));
        }
        lens.opening = FieldOfView::Angle(fov.to_radians());
    }
    if let Some(height) = options.orthographic_height {
        if !(height > 0.0 && height.is_finite()) {
            return Err(Error::usage(format!("--orthographic-height {height}: must be a number of metres above 0")));
        }
        lens.opening = FieldOfView::Height(height);
    }
    lens.near_m = options.near.unwrap_or(lens.near_m);
    lens.far_m = options.far.unwrap_or(lens.far_m);
    let is_near_possible = lens.near_m > 0.0 || (lens.near_m == 0.0 && lens.kind().is_orthographic());
    if !(is_near_possible && lens.far_m > lens.near_m && lens.far_m.is_finite()) {
        return Err(Error::usage(format!(
            "near {} and far {}: near must be above 0 and below far",
            lens.near_m, lens.far_m
        )));
    }
    Ok(lens)
}

/// The path that a flag names: `views`, a path of the scene, or a file.
pub fn path(scene: &Scene, name: &Path, flag: &str) -> Result<CameraPath> {
    if is_toml(name) {
        return Ok(path::load(name)?);
    }
    let name = name.to_string_lossy();
    if let Some(path) = scene.paths.iter().find(|p| p.name == name) {
        return Ok(path.clone());
    }
    if name == VIEWS {
        return Ok(CameraPath::through_views(scene)?);
    }
    let names: Vec<&str> = [VIEWS].into_iter().chain(scene.paths.iter().map(|p| p.name.as_str())).collect();
    let known = names.join(", ");
    Err(Error::usage(format!("{flag} {name}: neither a path of scene {} ({known}) nor a .toml file", scene.name)))
}

/// Refuses a name among `wanted` that no mesh has. The error names the flag that gave it, and lists all meshes.
pub fn check_meshes(scene: &Scene, flag: &str, wanted: &[String]) -> Result<()> {
    let mut names: Vec<&str> = scene.meshes.iter().map(|m| m.name.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    match wanted.iter().find(|name| !names.contains(&name.as_str())) {
        Some(name) => Err(Error::usage(format!(
            "{flag} {name}: scene {} has no mesh of this name; it has: {}",
            scene.name,
            names.join(", ")
        ))),
        None => Ok(()),
    }
}

/// The global factors: one set for each `--roughness`, or one set that keeps the materials' own roughness.
pub fn globals(options: &SceneOptions) -> Result<Vec<Globals>> {
    let in_unit = |flag: &str, v: f32| {
        if (0.0..=1.0).contains(&v) {
            Ok(v)
        } else {
            Err(Error::usage(format!("{flag} {v}: must lie between 0 and 1")))
        }
    };
    let reflectivity = in_unit("--reflectivity", options.reflectivity)?;
    let normal_deviation = options.normal_deviation.map(|d| in_unit("--normal-deviation", d)).transpose()?;
    let factors = |roughness| Globals { roughness, reflectivity, normal_deviation };
    if options.roughness.is_empty() {
        return Ok(vec![factors(None)]);
    }
    distinct_values(&options.roughness).into_iter().map(|r| Ok(factors(Some(in_unit("--roughness", r)?)))).collect()
}

/// The global factors that flags give; without `--roughness`, one set for each of the usual roughness values.
pub fn globals_or(options: &SceneOptions, usual: &[f32]) -> Result<Vec<Globals>> {
    let given = globals(options)?;
    if let [factors @ Globals { roughness: None, .. }] = given[..] {
        return Ok(usual.iter().map(|r| Globals { roughness: Some(*r), ..factors }).collect());
    }
    Ok(given)
}

/// The global factors of a command that takes one roughness alone; the error gives `why` as the reason.
pub fn one_globals(options: &SceneOptions, why: &str) -> Result<Globals> {
    match globals(options)?[..] {
        [factors] => Ok(factors),
        _ => Err(Error::usage(format!("{why}: give one --roughness"))),
    }
}

/// The values of a list, each once, in the order in which they were first named.
pub fn distinct_values<T: PartialEq + Clone>(values: &[T]) -> Vec<T> {
    distinct(values.iter().cloned())
}

/// The values of a list, each once; `usual` if the list is empty.
pub fn distinct_values_or<T: PartialEq + Clone>(values: &[T], usual: T) -> Vec<T> {
    if values.is_empty() { vec![usual] } else { distinct_values(values) }
}

/// The variants that were typed, each once, over a base setup. A parameter that the base gives and no variant reads is
/// refused.
pub fn typed_variants(typed: &[TypedVariant], base: &Setup) -> Result<Vec<Variant>> {
    let mut variants: Vec<Variant> = Vec::new();
    for variant in typed.iter().map(|typed| typed.with_base(base)) {
        let variant = variant?;
        // A value that is given and equals the default one makes no other variant.
        let values = |variant: &Variant| (variant.method.name, variant.setup.recorded(Some(variant.method)));
        if !variants.iter().any(|known| values(known) == values(&variant)) {
            variants.push(variant);
        }
    }
    methods::check_read(&variants.iter().map(|variant| variant.method).collect::<Vec<_>>(), base)?;
    Ok(variants)
}

/// The named methods that find what they need in at least one of the scenes. Without names, every method that the setup allows and that
/// takes the cameras.
pub fn methods(
    names: &[String],
    setup: &Setup,
    scenes: &[&Scene],
    lenses: &[Lens],
) -> Result<Vec<&'static MethodInfo>> {
    let chosen = methods::choose(names, setup)?;
    let methods = if names.is_empty() { methods_taking_lenses(chosen, lenses) } else { chosen };
    leave_out_lacking(methods, |method| method, scenes)
}

/// Leaves out items whose method shows nothing, since each of the scenes lacks what the method needs. Prints for each
/// scene which methods show nothing there. `method` returns the method of an item. It is an error if none is left.
pub fn leave_out_lacking<T>(
    items: Vec<T>,
    method: impl Fn(&T) -> &'static MethodInfo,
    scenes: &[&Scene],
) -> Result<Vec<T>> {
    for scene in scenes {
        let mut left_out: Vec<(Need, Vec<&str>)> = Vec::new();
        for method in items.iter().map(&method) {
            let Some(need) = method.unmet_needs(scene).first().copied() else { continue };
            match left_out.iter_mut().find(|(known, _)| *known == need) {
                Some((_, names)) if names.contains(&method.name) => {}
                Some((_, names)) => names.push(method.name),
                None => left_out.push((need, vec![method.name])),
            }
        }
        for (need, names) in left_out {
            let (scene, need, names) = (super::printable(&scene.name), need.words(), names.join(", "));
            eprintln!("ssct: scene {scene} has no {need}; left out, as they would show nothing: {names}");
        }
    }
    let shows = |item: &T| scenes.iter().any(|scene| method(item).unmet_needs(scene).is_empty());
    let kept: Vec<T> = items.into_iter().filter(shows).collect();
    if kept.is_empty() {
        let scenes: Vec<&str> = scenes.iter().map(|scene| scene.name.as_str()).collect();
        let message = format!("no method is left that would show anything in {}", scenes.join(", "));
        return Err(Error::usage(message));
    }
    Ok(kept)
}

/// Leaves out of a default list the methods that do not take every camera, and says so.
pub fn methods_taking_lenses(methods: Vec<&'static MethodInfo>, lenses: &[Lens]) -> Vec<&'static MethodInfo> {
    let is_orthographic = lenses.iter().any(|lens| lens.kind().is_orthographic());
    let (taken, others): (Vec<_>, Vec<_>) =
        methods.into_iter().partition(|method| method.takes_orthographic || !is_orthographic);
    if !others.is_empty() {
        let names: Vec<&str> = others.iter().map(|method| method.name).collect();
        eprintln!("ssct: a camera is orthographic; left out, as they need a perspective: {}", names.join(", "));
    }
    taken
}

/// The lenses of some views of a scene.
pub fn lenses<'a>(scene: &Scene, views: impl IntoIterator<Item = &'a View>) -> Vec<Lens> {
    views.into_iter().map(|view| view.lens.unwrap_or(scene.lens)).collect()
}

/// The variants that are compared in some scenes: those that flags name, those of a sweep, or each method with the base's setup. If no flag
/// decides, `swept` chooses the sweep over both presets and their parameters.
pub fn variants(
    options: &VariantOptions,
    base: &Setup,
    (scenes, lenses): (&[&Scene], &[Lens]),
    swept: bool,
) -> Result<Vec<Variant>> {
    if !options.variant.is_empty() {
        return leave_out_lacking(typed_variants(&options.variant, base)?, |variant: &Variant| variant.method, scenes);
    }
    let methods = methods(&options.method, base, scenes, lenses)?;
    let plain = |method: &&'static MethodInfo| Variant { method, setup: base.clone() };
    Ok(if options.captures_sweep {
        let method_variants = |method: &&'static MethodInfo| match method.takes_captures {
            true => sweep::captures(method, base),
            false => vec![plain(method)],
        };
        methods.iter().flat_map(method_variants).collect()
    } else if options.fallback_sweep {
        methods.iter().flat_map(|method| sweep::fallbacks(method, base)).collect()
    } else if options.bounces_sweep {
        methods.iter().flat_map(|method| sweep::bounces(method, base)).collect()
    } else if swept {
        sweep::variants(&methods, base)
    } else {
        methods.iter().map(plain).collect()
    })
}

/// True if a file's name ends in `.toml`: a scene file, or a camera path.
pub fn is_toml(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml"))
}

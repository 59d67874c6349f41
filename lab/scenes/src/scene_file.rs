//! Reads scene files (`NAME.scene.toml`), which list the OBJ and glTF files of a scene and add data that these formats
//! lack, such as reflectivities, lights, lenses and named views (docs/definitions.md, "Scene files").

pub(super) mod captures;
mod coordinates;
mod motions;
mod proxies;
pub mod seen;

pub use captures::with_captures;

use super::obj::{self, Handedness, ObjFile, ObjOptions};
use super::path::PathSection;
use super::{
    Camera, FieldOfView, Lens, Light, LoadOptions, MAX_COORDINATE_M, Material, MaterialChange, Probe, Scene, Surface,
    View, gltf,
};
use crate::far_away::far_origin;
use crate::source_text::{self, SourceText};
use glam::{DVec3, Vec3};
use serde::Deserialize;
use ssct_geometry::viewpoint;
use ssct_ground::{Error, Result};
use std::collections::BTreeMap;
use std::path::Path;
use toml::Spanned;

/// The name that stands for all materials without an entry, both in `[material.NAME]` and in a view's `materials`.
const DEFAULT_MATERIAL: &str = "default";

/// Loads a scene file and the files that it names, whose paths are relative to its folder.
///
/// Positions, directions and paths are in the coordinates that the key `coordinates` names. Without this key, they are
/// in the coordinates of the OBJ files (`handedness`), and without OBJ files right-handed, as in glTF. The loaded scene
/// has the program's own left-handed coordinates. A view that sees almost nothing adds a warning ([`Scene::warnings`]).
///
/// The scale of the options enlarges the whole scene: it multiplies the file's `scale` and everything that the file
/// states in metres (views and their clip planes, point lights, probes, impostors, area lights, captures). The energies
/// of point lights, which are squared lengths, are multiplied by the square of the scale.
///
/// Views keep the order of the file. Without a `[[light]]`, the scene gets the lights of its glTF files, or if they
/// have none the default light; without a `[view.NAME]` it gets their views, or the default view. Without a `[[probe]]`
/// it gets a probe at the centre of its bounds. A `[path.NAME]` with `[[path.NAME.key]]` tables is a camera path
/// ([`super::path`]), and a `[motion.NAME]` with `[[motion.NAME.key]]` tables moves meshes. A material's section
/// overrides the MTL file; `[material.default]` applies to all materials without a section of their own. A section for
/// a material that no mesh has adds a warning.
///
/// # Errors
/// The errors of [`obj::load`] and [`gltf::load`], and [`Error::Malformed`] with file and line for wrong syntax,
/// unknown keys and numbers out of range.
pub fn load(path: &Path, options: &LoadOptions) -> Result<Scene> {
    options.check()?;
    let extra_scale = options.scale;
    let text = source_text::read(path, "a scene file", source_text::MAX_FILE_BYTES)?;
    let source = SourceText { path, text: &text };
    let sections: Sections = source.deserialized()?;
    let coordinates = sections.coordinates();
    let scale = match &sections.scale {
        Some(scale) => source.positive("scale", scale)?,
        None => 1.0,
    };
    // The default lens is in metres, so that the scale of the options changes its planes, too.
    let default_lens = Lens::default().scaled(extra_scale);
    let camera = sections.camera.clone().unwrap_or_else(|| Spanned::new(0..0, LensSection::default()));
    let lens = source.lens(camera.get_ref(), default_lens, extra_scale, camera.span())?;
    let lights = sections.light.iter().map(|section| source.light(section, extra_scale));
    let lights = lights.collect::<Result<Vec<_>>>()?;
    let assumption_note = sections.assumption_note(path);
    let views = source.views(sections.view, lens, extra_scale)?;
    let stated_view_count = views.len();
    let paths = sections.path.iter().map(|(name, path)| source.camera_path(name, &path.key, extra_scale, coordinates));
    let paths = paths.collect::<Result<Vec<_>>>()?;
    let changes = source.changes(sections.material)?;
    let files = source.meshes(sections.mesh)?;
    let probes = sections.probe.iter().map(|section| source.probe(section, extra_scale));
    let mut probes = probes.collect::<Result<Vec<_>>>()?;
    let area_lights = sections.area_light.iter().map(|section| source.area_light(section, extra_scale));
    let mut area_lights = area_lights.collect::<Result<Vec<_>>>()?;
    let captures = source.captures(&sections.capture, extra_scale)?;
    let impostors = sections.impostor.iter().map(|section| source.impostor(section, extra_scale));
    let impostors = impostors.collect::<Result<Vec<_>>>()?;

    let scale = scale * extra_scale;
    let load_options = LoadOptions { scale, ..*options };
    let (gltf_files, obj_files): (Vec<_>, Vec<_>) = files.into_iter().partition(|file| gltf::is_named(&file.path));
    let mut scene = match obj_files[..] {
        [] => Scene::default(),
        _ => {
            let handedness = sections.handedness.unwrap_or_default();
            obj::load_plain(&obj_files, &ObjOptions { handedness, load: load_options }, Some(DVec3::ZERO))?
        }
    };
    for file in &gltf_files {
        append(&mut scene, gltf::load_plain(&file.path, &load_options, Some(DVec3::ZERO))?, file.surface);
    }
    let bounds = scene.bounds();
    if let Some(far) = far_origin([bounds.min, bounds.max].map(|corner| corner.as_dvec3())) {
        scene.warnings.push(format!("{}: {}", path.display(), far.warning()));
    }
    scene.lens = viewpoint::lens(scene.bounds());
    scene.name = sections.name.unwrap_or_else(|| source_text::stem(path));
    if *camera.get_ref() != LensSection::default() || !views.is_empty() {
        scene.lens = lens;
    }
    if !lights.is_empty() || scene.lights.is_empty() {
        let lights: Vec<Light> = lights.into_iter().map(|light| coordinates.light(light)).collect();
        scene.lights = if lights.is_empty() { vec![viewpoint::default_light()] } else { lights };
    }
    if !views.is_empty() || scene.views.is_empty() {
        let views: Vec<View> = views.into_iter().map(|view| coordinates.view(view)).collect();
        scene.views = if views.is_empty() { vec![viewpoint::default_view(&scene)] } else { views };
    }
    scene.paths = paths;
    for (name, section) in &sections.motion {
        let motion = source.motion(name, section, &scene, extra_scale, coordinates)?;
        scene.motions.push(motion);
    }
    if probes.is_empty() {
        scene.probes = vec![Probe::in_the_middle_of(scene.bounds())];
    }
    probes.iter_mut().for_each(|probe| probe.scale(extra_scale));
    area_lights.iter_mut().for_each(|light| light.shape.scale(extra_scale));
    scene.probes.extend(probes.into_iter().map(|probe| coordinates.probe(probe)));
    scene.area_lights = area_lights.into_iter().map(|light| coordinates.area_light(light)).collect();
    scene.captures = captures.into_iter().map(|capture| coordinates.capture(capture)).collect();
    for (mut impostor, texture) in impostors {
        impostor.scale(extra_scale);
        impostor.texture = scene.textures.len();
        scene.textures.push(texture);
        scene.impostors.push(coordinates.impostor(impostor));
    }
    apply_changes(path, &changes, &mut scene);
    let assumed = sections.coordinates.is_none().then_some(coordinates);
    let warnings = seen::warnings(&scene, stated_view_count, assumed);
    scene.warnings.extend(warnings.into_iter().map(|warning| format!("{}: {warning}", path.display())));
    scene.notes.extend(assumption_note);
    Ok(scene)
}

/// Reads the coordinates in which a scene file states positions, for code that writes positions into it.
///
/// # Errors
/// The errors of [`load`] about the text.
pub fn coordinates(path: &Path) -> Result<Handedness> {
    let text = source_text::read(path, "a scene file", source_text::MAX_FILE_BYTES)?;
    Ok(SourceText { path, text: &text }.deserialized::<Sections>()?.coordinates())
}

/// Adds the contents of a glTF file, `other`, to a scene. All materials of the file get the kind of surface `surface`:
/// lit, or showing the sky.
fn append(scene: &mut Scene, mut other: Scene, surface: Surface) {
    let (materials, textures) = (scene.materials.len(), scene.textures.len());
    // Indices of materials and textures are moved behind those that the scene has.
    other.meshes.iter_mut().for_each(|mesh| mesh.material += materials);
    for material in &mut other.materials {
        material.surface = surface;
        let Material { albedo_map, normal_map, alpha_mask, reflectivity_map, roughness_map, .. } = material;
        let maps = [albedo_map, normal_map, alpha_mask, reflectivity_map, roughness_map];
        maps.into_iter().flatten().for_each(|map| *map += textures);
    }
    scene.meshes.append(&mut other.meshes);
    scene.materials.append(&mut other.materials);
    scene.textures.append(&mut other.textures);
    scene.lights.append(&mut other.lights);
    scene.views.append(&mut other.views);
    scene.motions.append(&mut other.motions);
    scene.warnings.append(&mut other.warnings);
    scene.notes.append(&mut other.notes);
}

/// The contents of a scene file, whose values are not checked yet.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Sections {
    name: Option<String>,
    handedness: Option<Handedness>,
    coordinates: Option<Handedness>,
    scale: Option<Spanned<f32>>,
    #[serde(default)]
    mesh: Vec<MeshSection>,
    #[serde(default)]
    material: BTreeMap<String, ChangeSection>,
    #[serde(default)]
    light: Vec<Spanned<LightSection>>,
    camera: Option<Spanned<LensSection>>,
    #[serde(default)]
    view: BTreeMap<String, Spanned<ViewSection>>,
    #[serde(default)]
    path: BTreeMap<String, PathSection>,
    #[serde(default)]
    motion: BTreeMap<String, motions::MotionSection>,
    #[serde(default)]
    probe: Vec<proxies::ProbeSection>,
    #[serde(default)]
    impostor: Vec<proxies::ImpostorSection>,
    #[serde(default)]
    area_light: Vec<Spanned<proxies::AreaLightSection>>,
    #[serde(default)]
    capture: Vec<Spanned<captures::CaptureSection>>,
}

impl Sections {
    /// Returns the coordinates of the file's positions.
    fn coordinates(&self) -> Handedness {
        Handedness::of_places(self.coordinates, self.handedness, self.has_obj())
    }

    /// Returns true if any mesh comes from an OBJ file.
    fn has_obj(&self) -> bool {
        self.mesh.iter().any(|mesh| !gltf::is_named(Path::new(mesh.file.get_ref())))
    }

    /// Returns a note about a scene file whose positions are read as right-handed only because its OBJ files are;
    /// `None` for any other file. Before the key `coordinates` existed, such positions were read as left-handed.
    fn assumption_note(&self, path: &Path) -> Option<String> {
        let has_places = !(self.view.is_empty() && self.light.is_empty() && self.path.is_empty());
        let is_assumed = self.has_obj() && self.coordinates.is_none() && self.handedness == Some(Handedness::Right);
        (has_places && is_assumed).then(|| {
            let path = path.display();
            let (right, left) = (Handedness::Right.toml_line(), Handedness::Left.toml_line());
            format!(
                "{path}: its places are read as right-handed, as its OBJ files are; write {right} if that is right, or {left} if they are left-handed"
            )
        })
    }
}

/// A `[[mesh]]` section: a file, and what its surfaces show.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MeshSection {
    file: Spanned<String>,
    #[serde(default)]
    surface: SurfaceName,
}

/// The look of the surfaces of a file: their lit colour, or the sky.
#[derive(Deserialize, Default, Clone, Copy)]
#[serde(rename_all = "lowercase")]
enum SurfaceName {
    #[default]
    Lit,
    Sky,
}

/// The changes of a material, in `[material.NAME]` or in a view.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ChangeSection {
    reflectivity: Option<Spanned<f32>>,
    roughness: Option<Spanned<f32>>,
    normal_deviation: Option<Spanned<f32>>,
}

#[derive(Deserialize, Clone, Copy)]
#[serde(rename_all = "lowercase")]
enum LightKind {
    Point,
    Directional,
}

/// A `[[light]]` section; its kind decides whether it has a position or a direction.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LightSection {
    kind: LightKind,
    position: Option<Spanned<[f32; 3]>>,
    direction: Option<Spanned<[f32; 3]>>,
    energy: Spanned<f32>,
}

/// The keys of a lens; lengths are in metres.
#[derive(Deserialize, Default, Clone, PartialEq)]
#[serde(deny_unknown_fields)]
struct LensSection {
    fov_y_deg: Option<Spanned<f32>>,
    orthographic_height_m: Option<Spanned<f32>>,
    near: Option<Spanned<f32>>,
    far: Option<Spanned<f32>>,
}

/// A `[view.NAME]` section: the points of a view, the keys of its own lens, and its changes of materials.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ViewSection {
    eye: Spanned<[f32; 3]>,
    look_at: Spanned<[f32; 3]>,
    fov_y_deg: Option<Spanned<f32>>,
    orthographic_height_m: Option<Spanned<f32>>,
    near: Option<Spanned<f32>>,
    far: Option<Spanned<f32>>,
    #[serde(default)]
    materials: BTreeMap<String, ChangeSection>,
}

impl SourceText<'_> {
    /// Returns a number, which must be finite and above 0; `key` is its name in errors.
    fn positive(&self, key: &str, value: &Spanned<f32>) -> Result<f32> {
        let number = *value.get_ref();
        if number.is_finite() && number > 0.0 {
            return Ok(number);
        }
        Err(self.error(value.span(), format!("{key} must be a number > 0, not {number}")))
    }

    /// Returns an optional number, which must lie in 0 to 1; `key` is its name in errors.
    fn unit(&self, key: &str, value: &Option<Spanned<f32>>) -> Result<Option<f32>> {
        match value {
            Some(number) if !(0.0..=1.0).contains(number.get_ref()) => {
                Err(self.error(number.span(), format!("{key} must lie in 0 to 1, but is {}", number.get_ref())))
            }
            value => Ok(value.as_ref().map(|number| *number.get_ref())),
        }
    }

    /// Returns a vector, which must have three finite numbers; `key` is its name in errors.
    pub(super) fn vector(&self, key: &str, value: &Spanned<[f32; 3]>) -> Result<Vec3> {
        let vector = Vec3::from(*value.get_ref());
        if vector.is_finite() {
            return Ok(vector);
        }
        Err(self.error(value.span(), format!("{key} must have three finite numbers, not {vector}")))
    }

    /// Returns a position in metres, multiplied by `scale`, which must not exceed [`MAX_COORDINATE_M`]; `key` is
    /// its name in errors.
    pub(super) fn place(&self, key: &str, value: &Spanned<[f32; 3]>, scale: f32) -> Result<Vec3> {
        let place = self.vector(key, value)? * scale;
        if place.abs().max_element() <= MAX_COORDINATE_M {
            return Ok(place);
        }
        let message = format!("{key} lies more than {MAX_COORDINATE_M:e} m from the origin");
        Err(self.error(value.span(), message))
    }

    /// Returns the lens `base` with the changes of a section, whose planes and height are multiplied by `scale`. `span`
    /// is the byte range of the section in the file, for errors.
    fn lens(&self, section: &LensSection, base: Lens, scale: f32, span: std::ops::Range<usize>) -> Result<Lens> {
        let mut lens = base;
        if let Some(fov) = &section.fov_y_deg {
            let degrees = self.positive("fov_y_deg", fov)?;
            if degrees >= 180.0 {
                let message = format!("fov_y_deg must lie between 0 and 180, but is {degrees}");
                return Err(self.error(fov.span(), message));
            }
            lens.opening = FieldOfView::Angle(degrees.to_radians());
        }
        if let Some(height) = &section.orthographic_height_m {
            if section.fov_y_deg.is_some() {
                let message = "fov_y_deg and orthographic_height_m are two projections: one of them is too many";
                return Err(self.error(height.span(), message));
            }
            lens.opening = FieldOfView::Height(self.positive("orthographic_height_m", height)? * scale);
        }
        if let Some(near) = &section.near {
            lens.near_m = self.positive("near", near)? * scale;
        }
        if let Some(far) = &section.far {
            lens.far_m = self.positive("far", far)? * scale;
        }
        if lens.far_m <= lens.near_m {
            let span = section.far.as_ref().or(section.near.as_ref()).map_or(span, Spanned::span);
            let message = format!("far ({}) must be greater than near ({})", lens.far_m, lens.near_m);
            return Err(self.error(span, message));
        }
        if !Camera::new(Vec3::ZERO, Vec3::Z, lens, 1.0).is_sound() {
            let Lens { opening, near_m, far_m } = lens;
            let opening = match opening {
                FieldOfView::Angle(fov) => format!("fov_y_deg {}", fov.to_degrees()),
                FieldOfView::Height(height) => format!("orthographic_height_m {height}"),
            };
            let message = format!(
                "a lens with {opening}, near {near_m} and far {far_m} is beyond the precision of the projection"
            );
            return Err(self.error(span, message));
        }
        Ok(lens)
    }

    /// Reads and checks a `[[light]]` section. The position of a point light is multiplied by `extra_scale`, and its
    /// energy, a squared length, by the square.
    fn light(&self, section: &Spanned<LightSection>, extra_scale: f32) -> Result<Light> {
        let LightSection { kind, position, direction, energy } = section.get_ref();
        let energy = self.positive("energy", energy)?;
        match (kind, position, direction) {
            (LightKind::Point, Some(position), None) => {
                let position = self.place("position", position, extra_scale)?;
                Ok(Light::Point { position, energy: energy * extra_scale * extra_scale })
            }
            (LightKind::Directional, None, Some(direction)) => {
                let unit = self.vector("direction", direction)?.as_dvec3().normalize_or_zero().as_vec3();
                if unit == Vec3::ZERO {
                    return Err(self.error(direction.span(), "direction must not be zero"));
                }
                Ok(Light::Directional { direction: unit, energy })
            }
            (LightKind::Point, ..) => Err(self.error(section.span(), "a point light has a position and no direction")),
            (LightKind::Directional, ..) => {
                Err(self.error(section.span(), "a directional light has a direction and no position"))
            }
        }
    }

    /// Reads the views, in the order of the file; the parameters are those of [`Self::view`].
    fn views(
        &self,
        sections: BTreeMap<String, Spanned<ViewSection>>,
        base: Lens,
        extra_scale: f32,
    ) -> Result<Vec<View>> {
        let mut sections: Vec<_> = sections.into_iter().collect();
        sections.sort_by_key(|(_, section)| section.span().start);
        sections.into_iter().map(|(name, section)| self.view(name, section, base, extra_scale)).collect()
    }

    /// Reads and checks a `[view.NAME]` section, whose lengths are multiplied by `extra_scale`. If the view changes the
    /// lens, it gets a lens of its own: `base` with these changes.
    fn view(&self, name: String, section: Spanned<ViewSection>, base: Lens, extra_scale: f32) -> Result<View> {
        let span = section.span();
        let ViewSection { eye, look_at, fov_y_deg, orthographic_height_m, near, far, materials } = section.into_inner();
        let look_at_span = look_at.span();
        let eye = self.place("eye", &eye, extra_scale)?;
        let look_at = self.place("look_at", &look_at, extra_scale)?;
        if (look_at - eye).try_normalize().is_none() {
            let message = format!("view {name:?} looks at its own eye; look_at must be another point");
            return Err(self.error(look_at_span, message));
        }
        let lens_section = LensSection { fov_y_deg, orthographic_height_m, near, far };
        let lens = match lens_section == LensSection::default() {
            true => None,
            false => Some(self.lens(&lens_section, base, extra_scale, span)?),
        };
        let materials = self.changes(materials)?.into_iter().collect();
        Ok(View { name, eye, look_at, lens, materials })
    }

    /// Reads and checks changes of materials, by the names of the materials.
    fn changes(&self, sections: BTreeMap<String, ChangeSection>) -> Result<BTreeMap<String, MaterialChange>> {
        let change = |(name, section): (String, ChangeSection)| {
            let change = MaterialChange {
                reflectivity: self.unit("reflectivity", &section.reflectivity)?,
                roughness: self.unit("roughness", &section.roughness)?,
                normal_deviation: self.unit("normal_deviation", &section.normal_deviation)?,
            };
            Ok((name, change))
        };
        sections.into_iter().map(change).collect()
    }

    /// Finds the OBJ and glTF files that the `[[mesh]]` sections name.
    fn meshes(&self, sections: Vec<MeshSection>) -> Result<Vec<ObjFile>> {
        if sections.is_empty() {
            return Err(Error::malformed(self.path, None, "a scene file needs at least one [[mesh]]"));
        }
        let folder = self.path.parent().unwrap_or(Path::new(""));
        let file = |section: MeshSection| {
            let name = section.file.get_ref();
            let Some(path) = obj::resolve(folder, name) else {
                return Err(self.error(section.file.span(), format!("there is no file {name:?}")));
            };
            let surface = match section.surface {
                SurfaceName::Lit => Surface::Lit,
                SurfaceName::Sky => Surface::Sky,
            };
            Ok(ObjFile { path, surface })
        };
        sections.into_iter().map(file).collect()
    }
}

/// Applies the changes of the file's `[material.NAME]` sections to the scene's materials. In the views, `default` is
/// replaced by the materials without an entry of their own. Names that no material has add warnings.
fn apply_changes(path: &Path, changes: &BTreeMap<String, MaterialChange>, scene: &mut Scene) {
    for material in &mut scene.materials {
        if let Some(change) = changes.get(&material.name).or(changes.get(DEFAULT_MATERIAL)) {
            change.apply(material);
        }
    }
    let names: Vec<String> = scene.materials.iter().map(|material| material.name.clone()).collect();
    let is_unknown = |name: &String| name != DEFAULT_MATERIAL && !names.contains(name);
    let place = path.display();
    for name in changes.keys().filter(|name| is_unknown(name)) {
        scene.warnings.push(format!("{place}: [material.{name}] changes nothing: no mesh has this material"));
    }
    for view in &mut scene.views {
        for (name, _) in view.materials.iter().filter(|(name, _)| is_unknown(name)) {
            let message = format!("changes material {name}, which no mesh has");
            scene.warnings.push(format!("{place}: [view.{}] {message}", view.name));
        }
        if let Some(index) = view.materials.iter().position(|(name, _)| name == DEFAULT_MATERIAL) {
            let (_, change) = view.materials.remove(index);
            let mut others: Vec<String> = names.clone();
            others.retain(|other| view.materials.iter().all(|(name, _)| name != other));
            others.sort();
            others.dedup();
            view.materials.extend(others.into_iter().map(|name| (name, change)));
        }
    }
}

//! Walks the tree of nodes: places meshes, cameras and lights in the world.

use super::data::Data;
use super::geometry::{self, ToWorld};
use super::materials::Coordinates;
use super::{Notes, materials};
use crate::error::Result;
use crate::math::constants;
use crate::scene::assemble;
use crate::scene::texture::luminance;
use crate::scene::{Camera, Lens, Light, MAX_COORDINATE_M, Scene, View};
use glam::{DMat4, DQuat, DVec3, Vec3};
use gltf::camera::Projection;
use gltf::khr_lights_punctual::Kind;
use gltf::scene::Transform;
use gltf::{Camera as GltfCamera, Node};

/// A light with its brightness at the scene's centre, in lux.
struct PlacedLight {
    light: Light,
    illuminance: f64,
}

/// Places what the file's scene shows: meshes, views and lights go into `scene`. Returns the materials in use, by their
/// index in the file (none for the default material); a mesh's material is an index into these.
pub(super) fn place(data: &Data, scale: f32, scene: &mut Scene, notes: &mut Notes) -> Result<Vec<Option<usize>>> {
    let mut nodes = Nodes::new(data, scale);
    let mut parts = Vec::new();
    let mut used: Vec<Option<usize>> = Vec::new();
    let mut coordinates: Vec<Coordinates> = Vec::new();
    let mut triangles = 0;
    let mut cameras = Vec::new();
    let mut lamps = Vec::new();
    while let Some((node, to_world)) = nodes.next(data)? {
        if let Some(mesh) = node.mesh() {
            if node.skin().is_some() {
                notes.add("skins", "skins are not supported; skinned meshes stand in their bind pose".to_owned());
            }
            let name = node.name().or(mesh.name()).map_or_else(|| format!("mesh {}", mesh.index()), str::to_owned);
            let placement = ToWorld::new(to_world);
            for primitive in mesh.primitives() {
                let material = primitive.material();
                let at = used.iter().position(|u| *u == material.index()).unwrap_or_else(|| {
                    used.push(material.index());
                    coordinates.push(materials::coordinates(&material, notes));
                    used.len() - 1
                });
                let what = (&primitive, name.as_str(), at);
                parts.extend(geometry::part(data, what, &coordinates[at], &placement, &mut triangles, notes)?);
            }
        }
        if let Some(camera) = node.camera() {
            cameras.push((camera, node.name().map(str::to_owned), to_world));
        }
        if let Some(light) = node.light() {
            lamps.push((light, to_world));
        }
    }
    if parts.is_empty() {
        return Err(data.error("has no triangle with an area in its scene"));
    }
    scene.meshes = assemble::meshes(parts, |part| part.material);
    let bounds = scene.bounds();
    let centre = 0.5 * (bounds.min + bounds.max);
    let reach = (bounds.max - bounds.min).length();
    for (camera, name, to_world) in &cameras {
        let name = name.as_deref().or(camera.name()).unwrap_or("camera");
        if let Some(view) = view(camera, unique(name, &scene.views), to_world, centre, reach * 4.0, notes) {
            scene.views.push(view);
        }
    }
    let placed = lamps.iter().filter_map(|(light, to_world)| lamp(light, to_world, centre, notes)).collect();
    scene.lights = exposed(placed, notes);
    Ok(used)
}

/// The nodes of the file's scene that are still to be visited.
struct Nodes<'a> {
    left: Vec<(Node<'a>, DMat4)>,
    visited: Vec<bool>,
}

impl<'a> Nodes<'a> {
    fn new(data: &Data<'a>, scale: f32) -> Self {
        let document = data.document;
        // glTF is right-handed, the world left-handed.
        let scale = f64::from(scale);
        let root = DMat4::from_scale(DVec3::new(scale, scale, -scale));
        let scene = document.default_scene().or_else(|| document.scenes().next());
        let roots: Vec<Node> = match scene {
            Some(scene) => scene.nodes().collect(),
            None => {
                let children: Vec<usize> = document.nodes().flat_map(|n| n.children().map(|c| c.index())).collect();
                document.nodes().filter(|n| !children.contains(&n.index())).collect()
            }
        };
        let mut left: Vec<_> = roots.into_iter().map(|node| (node, root)).collect();
        // The last one is visited first.
        left.reverse();
        Self { left, visited: vec![false; document.nodes().len()] }
    }

    /// The next node, and where it stands.
    fn next(&mut self, data: &Data) -> Result<Option<(Node<'a>, DMat4)>> {
        let Some((node, parent)) = self.left.pop() else { return Ok(None) };
        if std::mem::replace(&mut self.visited[node.index()], true) {
            return Err(data.error(format!("node {} has more than one parent, or is its own", node.index())));
        }
        let to_world = parent * local(&node);
        let children: Vec<_> = node.children().collect();
        self.left.extend(children.into_iter().rev().map(|child| (child, to_world)));
        Ok(Some((node, to_world)))
    }
}

fn local(node: &Node) -> DMat4 {
    match node.transform() {
        Transform::Matrix { matrix } => DMat4::from_cols_array_2d(&matrix.map(|column| column.map(f64::from))),
        Transform::Decomposed { translation, rotation, scale } => {
            let rotation = DQuat::from_array(rotation.map(f64::from));
            let unit = if rotation.length_squared() > 0.0 { rotation.normalize() } else { DQuat::IDENTITY };
            let [scale, translation] = [scale, translation].map(|v| DVec3::from_array(v.map(f64::from)));
            DMat4::from_scale_rotation_translation(scale, unit, translation)
        }
    }
}

/// A name that no view has yet.
fn unique(name: &str, views: &[View]) -> String {
    let taken = |name: &str| views.iter().any(|v| v.name == name);
    if !taken(name) {
        return name.to_owned();
    }
    let numbered = (2..).map(|k| format!("{name} {k}")).find(|name| !taken(name));
    numbered.unwrap_or_else(|| name.to_owned())
}

/// The view of a camera, or nothing, with a sentence, if it cannot be one.
fn view(
    camera: &GltfCamera,
    name: String,
    to_world: &DMat4,
    centre: Vec3,
    far_m: f32,
    notes: &mut Notes,
) -> Option<View> {
    let Projection::Perspective(perspective) = camera.projection() else {
        notes.add("orthographic", "orthographic cameras are not supported and were left out".to_owned());
        return None;
    };
    let eye = to_world.w_axis.truncate();
    let forward = -to_world.z_axis.truncate().normalize_or_zero();
    let lens = Lens {
        fov_y_radians: perspective.yfov(),
        near_m: perspective.znear(),
        far_m: perspective.zfar().unwrap_or_else(|| far_m.max(Lens::default().far_m)),
    };
    let distance = (centre.as_dvec3() - eye).dot(forward).max(1.0);
    let [eye, look_at] = [eye, eye + distance * forward].map(|v| v.as_vec3());
    let near_enough = |v: Vec3| v.is_finite() && v.abs().max_element() <= MAX_COORDINATE_M;
    let sound = near_enough(eye) && near_enough(look_at) && (look_at - eye).try_normalize().is_some();
    if !sound || !Camera::new(eye, look_at, lens, 1.0).is_sound() {
        notes.add("camera", format!("camera {name} cannot be used as a view and was left out"));
        return None;
    }
    let right = to_world.x_axis.truncate().normalize_or_zero();
    if right.y.abs() > 1e-3 && forward.y.abs() < 0.999_999 {
        notes.add("roll", "cameras that are rolled about their axis are set upright".to_owned());
    }
    Some(View { name, eye, look_at, lens: Some(lens), ..View::default() })
}

/// A light in the world, or nothing if it gives no light.
fn lamp(
    light: &gltf::khr_lights_punctual::Light,
    to_world: &DMat4,
    centre: Vec3,
    notes: &mut Notes,
) -> Option<PlacedLight> {
    let colour = Vec3::from(light.color());
    let grey = luminance(colour);
    if (colour - grey).abs().max_element() > 1e-3 {
        notes.add("coloured", "coloured lights are not supported; they shine white with their luminance".to_owned());
    }
    let intensity = f64::from(light.intensity() * grey);
    let position = to_world.w_axis.truncate();
    let placed = match light.kind() {
        Kind::Directional => {
            let direction = -to_world.z_axis.truncate().normalize_or_zero().as_vec3();
            let light = Light::Directional { direction, energy: 1.0 };
            PlacedLight { light, illuminance: if direction == Vec3::ZERO { 0.0 } else { intensity } }
        }
        kind => {
            if matches!(kind, Kind::Spot { .. }) {
                notes.add("spots", "spot lights are not supported; they shine in all directions".to_owned());
            }
            // The file's unit of length is the metre; a light at the centre itself is judged from a metre away.
            let away = (position - centre.as_dvec3()).length().max(1.0);
            let light = Light::Point { position: position.as_vec3(), energy: intensity as f32 };
            PlacedLight { light, illuminance: intensity / (away * away) }
        }
    };
    let sound = placed.illuminance.is_finite()
        && placed.illuminance > 0.0
        && position.is_finite()
        && position.abs().max_element() <= f64::from(MAX_COORDINATE_M);
    sound.then_some(placed)
}

/// The lights at one exposure, at which the brightest gives 1 at the scene's centre. Far from a point light of energy e
/// its attenuation is e / d², which is glTF's.
fn exposed(mut placed: Vec<PlacedLight>, notes: &mut Notes) -> Vec<Light> {
    placed.sort_by(|a, b| b.illuminance.total_cmp(&a.illuminance));
    let most = constants::MAX_LIGHTS as usize;
    if placed.len() > most {
        notes.add(
            "lights",
            format!("{} lights are more than the {most} that are drawn; the brightest stay", placed.len()),
        );
        placed.truncate(most);
    }
    let Some(brightest) = placed.first().map(|p| p.illuminance) else { return Vec::new() };
    let exposed = |p: PlacedLight| match p.light {
        Light::Directional { direction, .. } => {
            Light::Directional { direction, energy: (p.illuminance / brightest) as f32 }
        }
        Light::Point { position, energy } => Light::Point { position, energy: (f64::from(energy) / brightest) as f32 },
    };
    let lit = |light: &Light| match *light {
        Light::Directional { energy, .. } | Light::Point { energy, .. } => energy.is_finite() && energy > 0.0,
    };
    placed.into_iter().map(exposed).filter(lit).collect()
}

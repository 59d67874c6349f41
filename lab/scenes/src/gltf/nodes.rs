//! Walks through the tree of nodes, and places meshes, cameras and lights in the world.

mod animations;
mod instances;
mod lights;

use super::data::Data;
use super::geometry::{self, Tally};
use super::materials::Coordinates;
use super::vertices::{MeshPlacement, PlacedMesh, ToWorld};
use super::{Notes, materials};
use crate::far_away::far_origin;
use crate::{Camera, Lens, MAX_COORDINATE_M, Scene, View};
use glam::{DMat4, DQuat, DVec3, Vec3};
use gltf::camera::Projection;
use gltf::scene::Transform;
use gltf::{Camera as GltfCamera, Node, Skin};
pub(super) use instances::{INSTANCING, VISIBILITY};
use serde_json::Value;
use ssct_geometry::assemble::{self, MeshPart};
use ssct_geometry::bounded;
use ssct_ground::Result;
use std::collections::HashMap;

/// Places the meshes, motions, views and lights of the file in `scene`. `scale` is the number of metres in the file's
/// unit of length. Returns the materials in use, by their index in the file (`None` for the default material); the
/// material of a mesh is an index into this list.
///
/// `fixed_origin`, in metres, is subtracted from every position. With `None`, a scene so far from the origin that
/// floats would lose its details is moved to its own centre, in 64 bits, before rounding; a note says by how much.
pub(super) fn place(
    data: &Data,
    animations: &Value,
    scale: f32,
    fixed_origin: Option<DVec3>,
    scene: &mut Scene,
    notes: &mut Notes,
) -> Result<Vec<Option<usize>>> {
    let nodes = Nodes::new(data, scale)?;
    let mut origin = fixed_origin.unwrap_or(DVec3::ZERO);
    let notes_before = notes.clone();
    let names = mesh_names(&nodes, animations);
    let (mut parts, used, bounds) = read_parts(data, &nodes, &names, origin, notes)?;
    if let Some(far) = far_origin(bounds).filter(|_| fixed_origin.is_none()) {
        // Notes about details lost by rounding no longer hold after the move.
        *notes = notes_before;
        notes.add("far", far.sentence());
        origin = far.centre;
        (parts, _, _) = read_parts(data, &nodes, &names, origin, notes)?;
    }
    if parts.is_empty() {
        return Err(data.error("has no triangle with an area in its scene"));
    }
    scene.meshes = assemble::meshes(parts, |part| part.material);
    scene.motions = animations::motions(data, animations, &nodes, origin, &names, &scene.meshes, notes);
    place_views_and_lights(&nodes, origin, scene, notes);
    Ok(used)
}

/// The parts of the meshes that the nodes place, the indices of the materials that they use (`None` for the default
/// material), and the bounds of their vertices in metres.
type Parts = (Vec<MeshPart>, Vec<Option<usize>>, [DVec3; 2]);

/// Returns the name of each node's mesh, by the index of the node. In a file with animations, each node gets a unique
/// name.
fn mesh_names(nodes: &Nodes, animations: &Value) -> HashMap<usize, String> {
    let is_animated = animations.as_array().is_some_and(|list| !list.is_empty());
    let mut unique_names = UniqueNames::default();
    let index_and_name = |(node, _): &(Node, DMat4)| {
        let mesh = node.mesh()?;
        let name = node.name().or(mesh.name()).map_or_else(|| format!("mesh {}", mesh.index()), str::to_owned);
        Some((node.index(), if is_animated { unique_names.unique(&name) } else { name }))
    };
    nodes.shown.iter().filter_map(index_and_name).collect()
}

/// Reads the parts of the meshes that the nodes place. `names` are the names of the nodes' meshes, and `origin` is
/// subtracted from every position in the world, in metres.
fn read_parts(
    data: &Data,
    nodes: &Nodes,
    names: &HashMap<usize, String>,
    origin: DVec3,
    notes: &mut Notes,
) -> Result<Parts> {
    let mut parts = Vec::new();
    let mut used: Vec<Option<usize>> = Vec::new();
    let mut coordinates: Vec<Coordinates> = Vec::new();
    // The index in `used` and `coordinates` for each material of the file.
    let mut index_in_used: HashMap<Option<usize>, usize> = HashMap::new();
    let mut tally = Tally::default();
    for (node, to_world) in &nodes.shown {
        let Some(mesh) = node.mesh() else { continue };
        let name = names.get(&node.index()).map_or("", String::as_str);
        let placements = match node.skin() {
            Some(skin) => vec![nodes.skin(data, &skin)?],
            None => instances::instances(data, node)?
                .into_iter()
                .map(|copy| MeshPlacement::Node(ToWorld::new(*to_world * copy)))
                .collect(),
        };
        let weights = node.weights().or(mesh.weights()).unwrap_or_default();
        for primitive in mesh.primitives() {
            let material = primitive.material();
            let index = *index_in_used.entry(material.index()).or_insert_with(|| {
                used.push(material.index());
                coordinates.push(materials::shared_coordinates(data, &material, notes));
                used.len() - 1
            });
            for placement in &placements {
                let placed = PlacedMesh { name, placement, weights, origin };
                let coordinates = &coordinates[index];
                parts.extend(geometry::mesh_part(data, &primitive, index, &placed, coordinates, &mut tally, notes)?);
            }
        }
    }
    Ok((parts, used, tally.bounds))
}

/// Adds the views and lights of the nodes to a scene that already has its meshes. `origin`, in metres, is subtracted
/// from every position.
fn place_views_and_lights(nodes: &Nodes, origin: DVec3, scene: &mut Scene, notes: &mut Notes) {
    let bounds = scene.bounds();
    let centre = 0.5 * (bounds.min + bounds.max);
    let diagonal = (bounds.max - bounds.min).length();
    let units = Units { scale: nodes.scale, centre, far_m: (4.0 * diagonal).max(Lens::default().far_m * nodes.scale) };
    let to_moved_world = |to_world: &DMat4| DMat4::from_translation(-origin) * *to_world;
    let mut names = UniqueNames::default();
    let mut placed_lights = Vec::new();
    for (node, to_world) in &nodes.shown {
        if let Some(camera) = node.camera() {
            let name = node.name().or(camera.name()).unwrap_or("camera");
            if let Some(view) = view_of_camera(&camera, name, &to_moved_world(to_world), &units, notes) {
                scene.views.push(View { name: names.unique(name), ..view });
            }
        }
        if let Some(light) = node.light() {
            placed_lights.extend(lights::place_light(&light, &to_moved_world(to_world), &units, notes));
        }
    }
    let (lights, exposure_sentence) = lights::expose(placed_lights, notes);
    scene.lights = lights;
    scene.notes.extend(exposure_sentence.map(|sentence| notes.about(&sentence)));
}

/// Units and defaults for the lengths of cameras and lights.
struct Units {
    /// Metres per unit of length of the file.
    scale: f32,
    /// The centre of the scene's bounds, in metres.
    centre: Vec3,
    /// Distance of the far plane of a camera that states none, in metres.
    far_m: f32,
}

/// The nodes of the file's scene, in the order of the tree, and the transforms of all nodes.
pub(super) struct Nodes<'a> {
    /// The visible nodes of the scene, each with its transform to the world.
    pub(super) shown: Vec<(Node<'a>, DMat4)>,
    /// Transform of each node of the file to the world, whether or not it is in the scene.
    to_world: Vec<DMat4>,
    /// Metres in the file's unit of length.
    scale: f32,
}

impl<'a> Nodes<'a> {
    /// Finds the nodes of the file's scene, and the transforms of all nodes.
    ///
    /// # Errors
    /// [`Error::Malformed`](ssct_ground::Error::Malformed) for a node with several parents, or a cycle of nodes.
    fn new(data: &Data<'a>, scale: f32) -> Result<Self> {
        let document = data.document;
        let all_nodes: Vec<Node> = document.nodes().collect();
        let mut is_child = vec![false; all_nodes.len()];
        for child in all_nodes.iter().flat_map(|node| node.children()) {
            is_child[child.index()] = true;
        }
        let scene = document.default_scene().or_else(|| document.scenes().next());
        let tops: Vec<Node> = match scene {
            Some(scene) => scene.nodes().collect(),
            None => all_nodes.iter().filter(|node| !is_child[node.index()]).cloned().collect(),
        };
        let root_to_world = file_to_world(scale);
        let mut nodes = Self { shown: Vec::new(), to_world: vec![root_to_world; all_nodes.len()], scale };
        let mut visited = vec![false; all_nodes.len()];
        nodes.shown = nodes
            .walk(tops, root_to_world, &mut visited)
            .map_err(|node| data.error(format!("node {node} has more than one parent, or is its own")))?;
        // Joints need not be in the scene that is shown, so that the transforms of all other nodes are computed, too.
        // An error in a tree outside the scene is ignored, since the tree is not drawn.
        for top in all_nodes.iter().filter(|node| !is_child[node.index()]) {
            if !visited[top.index()] {
                nodes.walk(vec![top.clone()], root_to_world, &mut visited).unwrap_or_default();
            }
        }
        Ok(nodes)
    }

    /// Returns the transform from the file's space to the world.
    pub(super) fn file_to_world(&self) -> DMat4 {
        file_to_world(self.scale)
    }

    /// Returns the parent of each node of the file, by index; `None` for a node without a parent.
    pub(super) fn parents(&self, data: &Data) -> Vec<Option<usize>> {
        let mut parents = vec![None; self.to_world.len()];
        for node in data.document.nodes() {
            node.children().for_each(|child| parents[child.index()] = Some(node.index()));
        }
        parents
    }

    /// Visits the trees below `tops`, and keeps the transform of each node to the world. Returns the visible nodes with
    /// these transforms, in the order of the tree. `root_to_world` is the transform from the space of `tops` to the
    /// world, and `visited` tells by index which nodes were visited.
    ///
    /// # Errors
    /// The index of a node that was visited before.
    fn walk(
        &mut self,
        tops: Vec<Node<'a>>,
        root_to_world: DMat4,
        visited: &mut [bool],
    ) -> std::result::Result<Vec<(Node<'a>, DMat4)>, usize> {
        let mut visible = Vec::new();
        // The last node on the stack is visited first.
        let mut stack: Vec<_> = tops.into_iter().rev().map(|node| (node, root_to_world, false)).collect();
        while let Some((node, parent_to_world, is_below_hidden)) = stack.pop() {
            if std::mem::replace(&mut visited[node.index()], true) {
                return Err(node.index());
            }
            let to_world = parent_to_world * node_to_parent(&node);
            self.to_world[node.index()] = to_world;
            let is_hidden = is_below_hidden || instances::is_hidden(&node);
            let children: Vec<_> = node.children().collect();
            stack.extend(children.into_iter().rev().map(|child| (child, to_world, is_hidden)));
            if !is_hidden {
                visible.push((node, to_world));
            }
        }
        Ok(visible)
    }

    /// Returns the placement of a mesh by the joints of a skin: for each joint its transform times its inverse bind
    /// matrix.
    fn skin(&self, data: &Data, skin: &Skin) -> Result<MeshPlacement> {
        let inverse_binds = skin.inverse_bind_matrices().map(|accessor| data.matrices(&accessor)).transpose()?;
        let joints: Vec<Node> = skin.joints().collect();
        if inverse_binds.as_ref().is_some_and(|matrices| matrices.len() < joints.len()) {
            let (index, count) = (skin.index(), joints.len());
            return Err(data.error(format!("skin {index} has fewer inverse bind matrices than its {count} joints")));
        }
        let joint_matrix = |(joint_number, joint): (usize, &Node)| {
            let inverse_bind = match &inverse_binds {
                Some(matrices) => DMat4::from_cols_array(&matrices.get(joint_number).map(f64::from)),
                None => DMat4::IDENTITY,
            };
            self.to_world[joint.index()] * inverse_bind
        };
        Ok(MeshPlacement::Skin(joints.iter().enumerate().map(joint_matrix).collect()))
    }
}

/// Returns the transform from a file's space to the world. It scales to metres, and negates z, since glTF is
/// right-handed and the world left-handed.
fn file_to_world(scale: f32) -> DMat4 {
    let scale = f64::from(scale);
    DMat4::from_scale(DVec3::new(scale, scale, -scale))
}

/// Returns the transform from the space of a node to that of its parent. A rotation of length 0 counts as none.
fn node_to_parent(node: &Node) -> DMat4 {
    match node.transform() {
        Transform::Matrix { matrix } => DMat4::from_cols_array_2d(&matrix.map(|column| column.map(f64::from))),
        Transform::Decomposed { translation, rotation, scale } => {
            let rotation = DQuat::from_array(rotation.map(f64::from));
            let unit_rotation = if rotation.length_squared() > 0.0 { rotation.normalize() } else { DQuat::IDENTITY };
            let [scale, translation] = [scale, translation].map(|v| DVec3::from_array(v.map(f64::from)));
            DMat4::from_scale_rotation_translation(scale, unit_rotation, translation)
        }
    }
}

/// Makes names unique by adding numbers to repeated names.
#[derive(Default)]
struct UniqueNames {
    /// Each name in use, with the last number that was tried after it.
    used: HashMap<String, usize>,
}

impl UniqueNames {
    /// Returns the name itself if it is not in use yet, else the name with a number after it. The result is then in
    /// use.
    fn unique(&mut self, name: &str) -> String {
        let mut number = *self.used.entry(name.to_owned()).and_modify(|number| *number += 1).or_insert(1);
        let mut unique = if number == 1 { name.to_owned() } else { format!("{name} {number}") };
        while number > 1 && self.used.contains_key(&unique) {
            number += 1;
            unique = format!("{name} {number}");
        }
        self.used.insert(name.to_owned(), number);
        self.used.entry(unique.clone()).or_insert(1);
        unique
    }
}

/// Makes the view of a camera; `None`, with a note, if the camera cannot be a view. The view looks at the point of its
/// axis that is nearest to the scene's centre, if this is at least one unit of the file away, else at the point one
/// unit away.
fn view_of_camera(camera: &GltfCamera, name: &str, to_world: &DMat4, units: &Units, notes: &mut Notes) -> Option<View> {
    let eye = to_world.w_axis.truncate();
    let forward = -to_world.z_axis.truncate().normalize_or_zero();
    let to_metres = |length: f32| length * units.scale;
    let lens = match camera.projection() {
        Projection::Perspective(lens) => {
            Lens::perspective(lens.yfov(), to_metres(lens.znear()), lens.zfar().map_or(units.far_m, to_metres))
        }
        // The stated width is ignored: pixels are square, as in a perspective.
        Projection::Orthographic(lens) => {
            Lens::orthographic(2.0 * to_metres(lens.ymag().abs()), to_metres(lens.znear()), to_metres(lens.zfar()))
        }
    };
    let distance = (units.centre.as_dvec3() - eye).dot(forward).max(f64::from(units.scale));
    let [eye, look_at] = [eye, eye + distance * forward].map(|point| point.as_vec3());
    let is_in_range = |point: Vec3| point.is_finite() && point.abs().max_element() <= MAX_COORDINATE_M;
    let are_points_sound = is_in_range(eye) && is_in_range(look_at) && (look_at - eye).try_normalize().is_some();
    let upright_camera = Camera::new(eye, look_at, lens, 1.0);
    if !are_points_sound || !upright_camera.is_sound() {
        notes.add(
            "camera",
            format!("camera {} cannot be used as a view and was left out", bounded::printable_name(name)),
        );
        return None;
    }
    // A level x axis is not enough: it is level, too, if the camera hangs upside down or looks straight down. Below a
    // stretched node, the x axis may lean along the view, which turns nothing in the picture.
    let right_axis = to_world.x_axis.truncate().reject_from_normalized(forward).normalize_or_zero();
    if right_axis.distance(upright_camera.world_to_view.row(0).truncate().as_dvec3()) > 1e-3 {
        notes.add("roll", "cameras that are rolled about their axis are set upright".to_owned());
    }
    Some(View { eye, look_at, lens: Some(lens), ..View::default() })
}

//! A hall whose floor reflects and whose other surfaces are unlit. If the floor is a mirror, the true colour of each of
//! its pixels is known: the colour of the point that it mirrors. The points of a surface differ in colour, so that
//! errors show.

use bevy::asset::RenderAssetUsages;
use bevy::camera::Exposure;
use bevy::image::{ImageAddressMode, ImageSampler, ImageSamplerDescriptor};
use bevy::light::EnvironmentMapLight;
use bevy::mesh::{Indices, VertexAttributeValues};
use bevy::prelude::*;
use bevy::render::render_resource::{
    Extent3d, TextureDimension, TextureFormat, TextureViewDescriptor, TextureViewDimension,
};
use embed_bevy::truth::{Look, Texture, Triangle};
use std::sync::Arc;

/// The linear colour of the even sky over the hall, which has no ceiling. The camera clears its picture to this colour.
pub const SKY: LinearRgba = LinearRgba::rgb(0.25, 0.4, 0.7);

/// Width and height of the textures, in texels.
const SIDE: u32 = 128;

/// An object of the hall. Its texture runs between two linear `colors`; the mirror has `None`.
struct HallObject {
    mesh: Mesh,
    transform: Transform,
    colors: Option<[LinearRgba; 2]>,
}

/// How the hall is made.
#[derive(Resource, Clone, Copy)]
pub struct Hall {
    /// Perceptual roughness of the floor; 0 is a mirror.
    pub roughness: f32,
    /// If true, a directional light shines on the surfaces other than the floor; else they are unlit.
    pub is_lit: bool,
    /// If true, the floor is left out and the camera is [`mirrored_camera`]. The picture, turned upside down, then
    /// shows what the mirror shows.
    pub is_mirrored: bool,
}

/// Marks the ball, which the option `--moved` moves.
#[derive(Component)]
pub struct Moving;

/// The pose of the camera over the floor.
pub fn camera() -> Transform {
    Transform::from_xyz(0.0, 1.8, 5.2).looking_at(Vec3::new(0.0, 0.75, -2.0), Vec3::Y)
}

/// The pose of [`camera`] mirrored at the floor. The picture from there is upside down.
pub fn mirrored_camera() -> Transform {
    let upside_down = Mat3::from_diagonal(Vec3::new(1.0, -1.0, 1.0));
    let Transform { translation, rotation, scale } = camera();
    let turned = upside_down * Mat3::from_quat(rotation) * upside_down;
    Transform { translation: upside_down * translation, rotation: Quat::from_mat3(&turned), scale }
}

/// The centre of the ball, before or after its move.
pub fn ball(has_moved: bool) -> Vec3 {
    if has_moved { Vec3::new(-0.9, 0.7, 0.4) } else { Vec3::new(1.9, 0.7, 0.2) }
}

/// Lists the objects of the hall: first the floor, last the ball.
fn objects(has_moved: bool) -> Vec<HallObject> {
    let wall = |x: f32, z: f32, turn: f32, width: f32| {
        let transform = Transform::from_xyz(x, 1.75, z).with_rotation(Quat::from_rotation_y(turn));
        (Rectangle::new(width, 3.5).into(), transform)
    };
    let cuboid = |size: Vec3, centre: Vec3, turn: f32| {
        let transform = Transform::from_translation(centre).with_rotation(Quat::from_rotation_y(turn));
        (Cuboid::from_size(size).into(), transform)
    };
    let sphere = |radius: f32, centre: Vec3| {
        let mesh = Sphere::new(radius).mesh().ico(3).unwrap_or_else(|_| Sphere::new(radius).into());
        (mesh, Transform::from_translation(centre))
    };
    let colors = |a: [f32; 3], b: [f32; 3]| Some([a, b].map(|[r, g, b]| LinearRgba::rgb(r, g, b)));
    let quarter = std::f32::consts::FRAC_PI_2;
    let floor = (Plane3d::new(Vec3::Y, Vec2::new(5.0, 6.0)).into(), Transform::default());
    let list: Vec<((Mesh, Transform), _)> = vec![
        (floor, None),
        (wall(0.0, -6.0, 0.0, 10.0), colors([0.8, 0.5, 0.2], [0.1, 0.5, 0.6])),
        (wall(-5.0, 0.0, quarter, 12.0), colors([0.7, 0.2, 0.15], [0.3, 0.3, 0.05])),
        (wall(5.0, 0.0, -quarter, 12.0), colors([0.2, 0.6, 0.25], [0.1, 0.15, 0.5])),
        (wall(0.0, 6.0, 2.0 * quarter, 10.0), colors([0.5, 0.5, 0.5], [0.2, 0.1, 0.3])),
        (cuboid(Vec3::new(1.2, 1.6, 1.2), Vec3::new(-1.9, 0.8, -1.6), 0.5), colors([0.9, 0.8, 0.3], [0.5, 0.1, 0.1])),
        (cuboid(Vec3::new(0.5, 2.4, 0.5), Vec3::new(0.6, 1.2, -3.2), 0.2), colors([0.2, 0.8, 0.9], [0.1, 0.2, 0.6])),
        // This cuboid hangs above the view, so that the mirror alone shows it. The next one shows its underside in the
        // mirror alone.
        (cuboid(Vec3::new(2.2, 0.3, 1.4), Vec3::new(0.2, 3.0, 0.6), 0.3), colors([1.0, 0.9, 0.6], [0.9, 0.4, 0.1])),
        (cuboid(Vec3::new(1.4, 0.2, 1.4), Vec3::new(2.4, 1.5, -2.6), 0.7), colors([0.9, 0.3, 0.7], [0.3, 0.6, 0.2])),
        (sphere(0.7, ball(has_moved)), colors([0.9, 0.3, 0.1], [0.95, 0.9, 0.85])),
    ];
    list.into_iter().map(|((mesh, transform), colors)| HallObject { mesh, transform, colors }).collect()
}

/// Makes the RGBA texels, in sRGB bytes, of a texture that runs from the first colour to the second along u. It gets
/// darker along v, and every second square of a checkerboard is lighter.
fn texels([a, b]: [LinearRgba; 2]) -> Vec<u8> {
    let texel = |index: u32| {
        let (x, y) = ((index % SIDE) as f32 / SIDE as f32, (index / SIDE) as f32 / SIDE as f32);
        let is_light = ((8.0 * x) as u32 + (8.0 * y) as u32).is_multiple_of(2);
        let color = a.mix(&b, x) * (1.0 - 0.6 * y) * if is_light { 1.0 } else { 0.7 };
        Srgba::from(color).to_u8_array_no_alpha()
    };
    (0..SIDE * SIDE)
        .flat_map(|index| {
            let [r, g, b] = texel(index);
            [r, g, b, 255]
        })
        .collect()
}

/// Makes the texture of [`texels`] as an image of Bevy that repeats.
fn image(colors: [LinearRgba; 2]) -> Image {
    let size = Extent3d { width: SIDE, height: SIDE, depth_or_array_layers: 1 };
    let (format, usage) = (TextureFormat::Rgba8UnormSrgb, RenderAssetUsages::default());
    let mut image = Image::new(size, TextureDimension::D2, texels(colors), format, usage);
    let repeat = ImageAddressMode::Repeat;
    let sampler =
        ImageSamplerDescriptor { address_mode_u: repeat, address_mode_v: repeat, ..ImageSamplerDescriptor::linear() };
    image.sampler = ImageSampler::Descriptor(sampler);
    image
}

/// Spawns the objects of the hall, and its lamp if it is lit.
pub fn spawn(
    mut commands: Commands,
    (mut meshes, mut images): (ResMut<Assets<Mesh>>, ResMut<Assets<Image>>),
    mut materials: ResMut<Assets<StandardMaterial>>,
    hall: Res<Hall>,
) {
    if hall.is_lit {
        let from = Transform::from_xyz(2.0, 4.0, 3.0).looking_at(Vec3::ZERO, Vec3::Y);
        commands.spawn((DirectionalLight { illuminance: 3000.0, ..default() }, from));
    }
    let list = objects(false);
    let last = list.len() - 1;
    for (number, HallObject { mesh, transform, colors }) in list.into_iter().enumerate() {
        let material = match colors {
            None if hall.is_mirrored => continue,
            None => StandardMaterial {
                base_color: Color::WHITE,
                metallic: 1.0,
                perceptual_roughness: hall.roughness,
                ..default()
            },
            Some(colors) => StandardMaterial {
                base_color: Color::WHITE,
                base_color_texture: Some(images.add(image(colors))),
                unlit: !hall.is_lit,
                // Without specular reflection, a lit surface has the same colour from every direction.
                reflectance: 0.0,
                double_sided: true,
                cull_mode: None,
                // Bevy's own reflections do not check whether a surface is unlit, but they leave out rough surfaces.
                perceptual_roughness: 1.0,
                ..default()
            },
        };
        let mut object = commands.spawn((Mesh3d(meshes.add(mesh)), MeshMaterial3d(materials.add(material)), transform));
        if number == last {
            object.insert(Moving);
        }
    }
}

/// The light that comes from above the hall.
#[derive(Clone, Copy, PartialEq)]
pub enum Sky {
    /// The colour [`SKY`] from every direction.
    Even,
    /// Another colour from each direction.
    Colorful,
}

impl Sky {
    /// The linear colour of the sky in a direction of the world.
    pub fn color(self, direction: Vec3) -> Vec3 {
        match self {
            Self::Even => Vec3::new(SKY.red, SKY.green, SKY.blue),
            Self::Colorful => 0.4 + 0.35 * direction.normalize(),
        }
    }

    /// The sky as an environment map. Its intensity undoes the camera's exposure, so that the picture shows
    /// [`Self::color`].
    pub fn map(self, images: &mut Assets<Image>) -> EnvironmentMapLight {
        let map = match self {
            Self::Even => EnvironmentMapLight::solid_color(images, SKY),
            Self::Colorful => {
                let map = images.add(self.cube());
                EnvironmentMapLight { diffuse_map: map.clone(), specular_map: map, ..default() }
            }
        };
        map.with_intensity(1.0 / Exposure::default().exposure())
    }

    /// Makes the sky's cube map of 16-bit floats. Its faces lie in the order of Vulkan; Bevy looks a cube map up with z
    /// negated.
    fn cube(self) -> Image {
        const SIDE: u16 = 64;
        // The coordinate, from -1 to 1, of the middle of a texel on its face, and the direction to a place on a face.
        let place = |index: u16| (2.0 * f32::from(index) + 1.0) / f32::from(SIDE) - 1.0;
        let direction = |face: u32, s: f32, t: f32| match face {
            0 => Vec3::new(1.0, -t, -s),
            1 => Vec3::new(-1.0, -t, s),
            2 => Vec3::new(s, 1.0, t),
            3 => Vec3::new(s, -1.0, -t),
            4 => Vec3::new(s, -t, 1.0),
            _ => Vec3::new(-s, -t, -1.0),
        };
        let texels = (0..6).flat_map(|face| (0..SIDE).flat_map(move |y| (0..SIDE).map(move |x| (face, x, y))));
        let data = texels.flat_map(|(face, x, y)| {
            let color = self.color(direction(face, place(x), place(y)) * Vec3::new(1.0, 1.0, -1.0));
            [color.x, color.y, color.z, 1.0].map(|channel| half::f16::from_f32(channel).to_le_bytes())
        });
        let size = Extent3d { width: SIDE.into(), height: SIDE.into(), depth_or_array_layers: 6 };
        let (data, format) = (data.flatten().collect(), TextureFormat::Rgba16Float);
        let mut image = Image::new(size, TextureDimension::D2, data, format, RenderAssetUsages::RENDER_WORLD);
        image.texture_view_descriptor =
            Some(TextureViewDescriptor { dimension: Some(TextureViewDimension::Cube), ..default() });
        image
    }
}

/// The triangles of the hall in the world, for the ray tracer of `truth.rs`.
pub fn triangles(has_moved: bool) -> Vec<Triangle> {
    objects(has_moved).into_iter().flat_map(triangles_of_object).collect()
}

/// Returns the triangles of an object in the world; none if its mesh lacks positions or texture coordinates.
fn triangles_of_object(HallObject { mesh, transform, colors }: HallObject) -> Vec<Triangle> {
    let look = colors.map_or(Look::Mirror, |colors| {
        let bytes = texels(colors);
        let linear = |texel: &[u8; 4]| {
            let color = LinearRgba::from(Srgba::rgb_u8(texel[0], texel[1], texel[2]));
            Vec3::new(color.red, color.green, color.blue)
        };
        let texels = bytes.as_chunks::<4>().0.iter().map(linear).collect();
        Look::Texture(Arc::new(Texture { width: SIDE as usize, height: SIDE as usize, texels }))
    });
    let (Some(VertexAttributeValues::Float32x3(positions)), Some(VertexAttributeValues::Float32x2(places))) =
        (mesh.attribute(Mesh::ATTRIBUTE_POSITION), mesh.attribute(Mesh::ATTRIBUTE_UV_0))
    else {
        return Vec::new();
    };
    let indices: Vec<usize> = mesh.indices().map_or_else(Vec::new, |indices: &Indices| indices.iter().collect());
    let triangle = |[a, b, c]: &[usize; 3]| Triangle {
        corners: [a, b, c].map(|i| transform.transform_point(positions[*i].into())),
        places: [a, b, c].map(|i| places[*i].into()),
        look: look.clone(),
    };
    indices.as_chunks::<3>().0.iter().map(triangle).collect()
}

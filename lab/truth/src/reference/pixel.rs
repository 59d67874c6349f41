//! Analysis of one pixel: the mesh that it shows, where its mirror ray ends in the world, and why the screen does not
//! show that place (docs/definitions.md, "World agreement"). Also computes the pixel's reflection by the references.

use super::first_hits::{FirstHits, PrimaryRays};
use super::screen::{Sampling, ScreenReference};
use super::surface::World;
use super::world::WorldReference;
use super::world_hits::{ShownPlaces, WorldHit};
use glam::Vec3;
use ssct_geometry::bvh::TriangleHit;
use ssct_ground::math::OracleVersion;
use ssct_scenes::GBufferData;

/// The seed of a pixel's screen reference: the seed in the study of run time against error.
const SCREEN_SEED: u64 = 1;
/// The seed of a pixel's world reference: the seed in the study of run time against error.
const WORLD_SEED: u64 = 2;

/// What a pixel of a G-buffer shows and reflects, in the world that the G-buffer shows.
#[derive(Debug, Clone, PartialEq)]
pub struct PixelInWorld {
    /// The name of the mesh that the pixel shows; `None` for sky.
    pub mesh: Option<String>,
    /// Where the pixel's mirror ray ends.
    pub end: WorldHit,
    /// The name of the mesh at which the ray ends.
    pub end_mesh: Option<String>,
    /// Why the screen does not show the end of the ray; `None` if it does, or if the ray meets nothing.
    pub unseen: Option<UnseenReason>,
}

/// Why a screen does not show a place.
#[derive(Debug, Clone, PartialEq)]
pub enum UnseenReason {
    /// The place lies behind the eye.
    BehindEye,
    /// The place lies beside the picture.
    OffScreen,
    /// Another surface stands before the place.
    Hidden {
        /// The name of the hiding mesh, if known.
        by: Option<String>,
        /// View-space z of the hiding surface, in metres.
        view_z_m: f64,
    },
    /// The picture shows a surface farther away than the place, because it does not draw the place. The place may lie
    /// before the near plane, or on the back of a one-sided surface.
    NotDrawn {
        /// View-space z of the surface shown, in metres; infinite for sky.
        view_z_m: f64,
    },
}

/// An estimate of a reflection's colour, before fade and reflectivity.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct EstimatedColor {
    /// Linear colour.
    pub color: Vec3,
    /// Standard error of each channel of the colour.
    pub standard_error: Vec3,
}

/// How the references of a pixel are sampled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelSampling {
    /// Rays of each reference.
    pub rays: u32,
    /// Number of times that light is reflected, ≥ 1.
    pub bounces: u32,
    /// The version of the oracle for the screen reference.
    pub oracle: OracleVersion,
}

impl PixelInWorld {
    /// Analyses pixel `index` of a G-buffer, which must have a receiver in `first_hits` if it reflects
    /// ([`FirstHits::shown_at`]).
    pub fn new(world: &World, gbuffer: &GBufferData, first_hits: &FirstHits, index: usize) -> Self {
        let names = Names { world, rays: PrimaryRays::new(&gbuffer.camera, [gbuffer.width, gbuffer.height]) };
        let screen = ShownPlaces::new(gbuffer, first_hits);
        let (end, end_triangle) = match first_hits.receivers.get(index).copied().flatten() {
            Some(receiver) => screen.end(world, &receiver),
            None => (WorldHit::NotReflecting, None),
        };
        let unseen = match end {
            WorldHit::Hit { pixel, view_z_m, visible: false, .. } => Some(match pixel {
                None => UnseenReason::BehindEye,
                Some(place) => match screen.index(place) {
                    None => UnseenReason::OffScreen,
                    Some(end_pixel) => names.reason_unseen(end_pixel, first_hits.view_z_m[end_pixel], view_z_m),
                },
            }),
            _ => None,
        };
        Self {
            mesh: names.shown_at(index),
            end,
            end_mesh: end_triangle.map(|triangle| names.mesh_name(&triangle)),
            unseen,
        }
    }
}

/// Finds the names of meshes.
struct Names<'a> {
    world: &'a World<'a>,
    rays: PrimaryRays,
}

impl Names<'_> {
    /// Returns the name of the mesh of a hit triangle.
    fn mesh_name(&self, hit: &TriangleHit) -> String {
        let mesh = self.world.triangle(hit).mesh as usize;
        self.world.scene.meshes.get(mesh).map_or_else(String::new, |mesh| mesh.name.clone())
    }

    /// Returns the name of the mesh that the centre of pixel `index` shows; `None` for sky.
    fn shown_at(&self, index: usize) -> Option<String> {
        self.world.closest(&self.rays.ray(index).0).map(|hit| self.mesh_name(&hit))
    }

    /// Returns why a pixel does not show a place that projects into it. `shown_z_m` is the view-space z of the surface
    /// that the pixel shows, and `place_z_m` that of the place, in metres.
    fn reason_unseen(&self, pixel: usize, shown_z_m: f64, place_z_m: f64) -> UnseenReason {
        if shown_z_m < place_z_m {
            UnseenReason::Hidden { by: self.shown_at(pixel), view_z_m: shown_z_m }
        } else {
            UnseenReason::NotDrawn { view_z_m: shown_z_m }
        }
    }
}

/// Returns the reflections of pixel `index` by the screen reference and by the world reference, in this order; black if
/// the pixel does not reflect.
pub fn references(
    world: &World,
    gbuffer: &GBufferData,
    first_hits: &FirstHits,
    index: usize,
    sampling: PixelSampling,
) -> (EstimatedColor, EstimatedColor) {
    let mut mask = vec![false; gbuffer.depth.len()];
    mask[index] = gbuffer.reflects(index);
    let (screen_colors, world_colors) = references_in(world, gbuffer, &mask, first_hits, sampling);
    (screen_colors[index], world_colors[index])
}

/// Returns the reflections of all pixels by the screen reference and by the world reference, in this order; black in
/// pixels that do not reflect.
pub fn all_references(
    world: &World,
    gbuffer: &GBufferData,
    sampling: PixelSampling,
) -> (Vec<EstimatedColor>, Vec<EstimatedColor>) {
    references_in(world, gbuffer, &gbuffer.reflecting(), &FirstHits::shown(world, gbuffer), sampling)
}

/// Returns the reflections of all pixels by the screen reference and by the world reference, in this order. The screen
/// reference is black outside the mask, and the world reference where `first_hits` has no receiver.
fn references_in(
    world: &World,
    gbuffer: &GBufferData,
    mask: &[bool],
    first_hits: &FirstHits,
    PixelSampling { rays, bounces, oracle }: PixelSampling,
) -> (Vec<EstimatedColor>, Vec<EstimatedColor>) {
    let estimates = |colors: &[Vec3], standard_errors: &[Vec3]| {
        let pairs = colors.iter().zip(standard_errors);
        pairs.map(|(color, standard_error)| EstimatedColor { color: *color, standard_error: *standard_error }).collect()
    };
    let sampling = Sampling { samples: rays, seed: SCREEN_SEED, oracle, bounces };
    let screen = ScreenReference::render(gbuffer, mask, sampling);
    let reference = WorldReference::new(world, first_hits, &gbuffer.camera, WORLD_SEED).with_bounces(bounces);
    let mut state = reference.start();
    reference.add(&mut state, rays);
    let image = reference.image(&state);
    (estimates(&screen.color, &screen.standard_error), estimates(&image.reflection, &image.standard_error))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::reference::surface::tests::rectangle;
    use crate::reference::testing;
    use glam::DVec2;
    use ssct_scenes::{Camera, FieldOfView, Lens, Material, Mesh, Scene};

    /// Returns a mesh with the given name.
    fn named(name: &str, mesh: Mesh) -> Mesh {
        Mesh { name: name.to_owned(), ..mesh }
    }

    /// Returns a scene and its camera: a mirror floor 1 m below the eye, a wall at z = 4 m that does not reflect, and
    /// `more_meshes` meshes.
    pub fn room(more_meshes: Vec<Mesh>) -> (Scene, Camera) {
        let floor = rectangle(Vec3::new(-9.0, -1.0, 0.0), 9.0 * Vec3::Z, 18.0 * Vec3::X, 0);
        let wall = rectangle(Vec3::new(-9.0, -1.0, 4.0), 9.0 * Vec3::Y, 18.0 * Vec3::X, 1);
        let scene = Scene {
            meshes: [vec![named("floor", floor), named("wall", wall)], more_meshes].concat(),
            materials: vec![Material::default(), Material { reflectivity: 0.0, ..Material::default() }],
            ..Scene::default()
        };
        (scene, Camera::new(Vec3::ZERO, Vec3::Z, lens(), 1.0))
    }

    /// Returns a lens that sees 90° from bottom to top.
    fn lens() -> Lens {
        Lens { opening: FieldOfView::Angle(90_f32.to_radians()), ..Lens::default() }
    }

    /// Returns the analysis of a pixel in an image of 40 × 40 pixels of the room with `more_meshes` meshes.
    fn analysed(more_meshes: Vec<Mesh>, pixel: [u32; 2]) -> PixelInWorld {
        let (scene, camera) = room(more_meshes);
        let world = World::new(&scene, &scene.materials);
        let data = testing::traced(&world, &camera, [40, 40]);
        let index = data.index(pixel[0], pixel[1]);
        PixelInWorld::new(&world, &data, &FirstHits::shown_at(&world, &data, index), index)
    }

    #[test]
    fn what_stands_where_the_ray_ends_and_what_hides_it_have_names() {
        let open = analysed(Vec::new(), [20, 38]);
        assert_eq!((open.mesh.as_deref(), open.end_mesh.as_deref()), (Some("floor"), Some("wall")));
        assert!(open.unseen.is_none() && open.end.visible_at().is_some(), "{open:?}");
        // A plate at z = 2 hangs above the ray, and hides the place where the ray ends.
        let WorldHit::Hit { position, .. } = open.end else { panic!("{open:?}") };
        let middle = (0.5 * position).as_vec3();
        let plate = rectangle(middle - Vec3::new(0.3, 0.05, 0.0), 0.1 * Vec3::Y, 0.6 * Vec3::X, 1);
        let hidden = analysed(vec![named("plate", plate)], [20, 38]);
        assert_eq!(hidden.end_mesh.as_deref(), Some("wall"), "{hidden:?}");
        let Some(UnseenReason::Hidden { by, view_z_m }) = hidden.unseen else { panic!("{hidden:?}") };
        assert!(by.as_deref() == Some("plate") && (view_z_m - 2.0).abs() < 1e-3, "{by:?} {view_z_m}");
    }

    #[test]
    fn places_beside_the_picture_and_pixels_without_a_ray_are_told_apart() {
        // The wall itself does not reflect.
        let wall = analysed(Vec::new(), [20, 5]);
        assert_eq!((wall.mesh.as_deref(), wall.end), (Some("wall"), WorldHit::NotReflecting));
        // The camera looks down, so that the horizon is at the picture's upper side. Rays meet the low ceiling before
        // the wall.
        let ceiling = rectangle(Vec3::new(-9.0, 0.9, 0.0), 18.0 * Vec3::X, 4.0 * Vec3::Z, 1);
        let (scene, _) = room(vec![named("ceiling", ceiling)]);
        let camera = Camera::new(Vec3::ZERO, Vec3::new(0.0, -1.0, 1.0), lens(), 1.0);
        let world = World::new(&scene, &scene.materials);
        let data = testing::traced(&world, &camera, [40, 40]);
        let analyses =
            (0..data.depth.len()).map(|i| PixelInWorld::new(&world, &data, &FirstHits::shown_at(&world, &data, i), i));
        let mut off_screen_count = 0;
        for analysis in analyses.filter(|analysis| analysis.end_mesh.as_deref() == Some("ceiling")) {
            let WorldHit::Hit { pixel, visible, .. } = analysis.end else { panic!("{analysis:?}") };
            let expected = match pixel {
                None => Some(UnseenReason::BehindEye),
                Some(DVec2 { y, .. }) if y < 0.0 => Some(UnseenReason::OffScreen),
                Some(_) if visible => None,
                Some(_) => continue,
            };
            assert_eq!(analysis.unseen, expected);
            off_screen_count += usize::from(expected == Some(UnseenReason::OffScreen));
        }
        assert!(off_screen_count > 0, "no ray ends above the picture");
    }

    #[test]
    fn the_references_of_a_pixel_are_those_of_the_picture() {
        let (scene, camera) = room(Vec::new());
        let world = World::new(&scene, &scene.materials);
        let data = testing::traced(&world, &camera, [40, 40]);
        let sampling = PixelSampling { rays: 16, bounces: 1, oracle: OracleVersion::V1 };
        let (screens, worlds) = all_references(&world, &data, sampling);
        for index in [data.index(20, 38), data.index(3, 30), data.index(20, 5)] {
            assert_eq!(
                references(&world, &data, &FirstHits::shown_at(&world, &data, index), index, sampling),
                (screens[index], worlds[index]),
                "{index}"
            );
        }
        assert!(worlds[data.index(20, 38)].color != Vec3::ZERO && worlds[data.index(20, 5)].color == Vec3::ZERO);
    }
}

//! The floor of the screen (docs/definitions.md, "Floor of the screen"): the reflection that has the screen's colour
//! for each ray whose end the screen shows, and the true colour for all other rays. A method that takes colours from
//! the screen cannot come nearer to the world reference than this floor by finding better hits.

use super::first_hits::FirstHits;
use super::partial_sums::PartialSums;
use super::world::WorldReference;
use super::world::state::WorldState;
use super::world_hits::ShownPlaces;
use glam::{DVec3, Vec3};
use ssct_scenes::GBufferData;

/// Sums of colours over the rays of a world reference, in which rays that end at places that the screen shows have the
/// screen's colour.
#[derive(Debug, Clone)]
pub struct ScreenFloor<'a> {
    screen: ShownPlaces<'a>,
    sums: PartialSums<DVec3>,
}

impl<'a> ScreenFloor<'a> {
    /// Makes the floor of a G-buffer and its first hits, without samples yet.
    pub fn new(gbuffer: &'a GBufferData, first_hits: &'a FirstHits) -> Self {
        let screen = ShownPlaces::new(gbuffer, first_hits);
        Self { screen, sums: PartialSums::new(0, gbuffer.depth.len()) }
    }

    /// Adds `samples` samples a pixel to `state`, the state of a world reference of the same size. Adds the same
    /// samples, with the screen's colours where the screen shows their ends, to the sums of the floor.
    pub fn add(&mut self, reference: &WorldReference, state: &mut WorldState, samples: u32) {
        let Self { screen, sums, .. } = self;
        let last_sample = state.samples().saturating_add(samples);
        while let Some(stop) = sums.next_stop(last_sample) {
            reference.add_and_visit(state, stop, sums.open(), |sum, sample| {
                let screen_color = sample.end.and_then(|end| screen.color(end, sample.direction));
                // The screen does not show the light of further bounces, which is taken from the reference.
                *sum += screen_color.map_or(sample.radiance, |color| color + sample.bounced);
            });
            sums.close(stop);
        }
    }

    /// Returns the linear reflection colour of each pixel, rows from the top: the sums divided by the numbers of
    /// samples. `state` must be the one to which [`Self::add`] added all samples.
    pub fn image(&self, state: &WorldState) -> Vec<Vec3> {
        let pixels = state.sample_counts().enumerate();
        pixels.map(|(pixel, samples)| (self.sums.total(pixel) / f64::from(samples.max(1))).as_vec3()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::first_hits::Receiver;
    use crate::reference::surface::World;
    use crate::reference::surface::tests::rectangle;
    use crate::reference::testing;
    use ssct_scenes::{Camera, FieldOfView, Lens, Material, Scene, Surface};

    const COLOR: Vec3 = Vec3::new(1.0, 0.5, 0.25);

    /// Returns a scene and its camera: a mirror floor 1 m below the eye, and on it a wall at z = 4 m, both of one
    /// colour. The camera looks down by 25° and sees 30° up and down from there. The upper edge of its image therefore
    /// rises by 5° and shows the wall up to 0.35 m above the eye.
    fn stage(wall_surface: Surface) -> (Scene, Camera) {
        let floor_mesh = rectangle(Vec3::new(-9.0, -1.0, 0.0), 9.0 * Vec3::Z, 18.0 * Vec3::X, 0);
        let wall_mesh = rectangle(Vec3::new(-9.0, -1.0, 4.0), 9.0 * Vec3::Y, 18.0 * Vec3::X, 1);
        let materials = vec![
            Material { albedo: COLOR, reflectivity: 1.0, ..Material::default() },
            Material { albedo: COLOR, reflectivity: 0.0, surface: wall_surface, ..Material::default() },
        ];
        let lens = Lens { opening: FieldOfView::Angle(60_f32.to_radians()), ..Lens::default() };
        let scene = Scene { meshes: vec![floor_mesh, wall_mesh], materials, ..Scene::default() };
        let down_rad = 25_f32.to_radians();
        (scene, Camera::new(Vec3::ZERO, Vec3::new(0.0, -down_rad.sin(), down_rad.cos()), lens, 1.0))
    }

    /// Difference of the floor from the truth at a pixel.
    struct Difference {
        /// Linear colour of the floor minus that of the truth.
        color: Vec3,
        /// Metres from the screen's upper edge up to the end of the mirror ray; `None` outside the middle columns.
        above_m: Option<f64>,
    }

    /// Returns the differences at the reflecting pixels. `screen_color`, if any, replaces the screen's
    /// colour on surfaces that do not reflect.
    fn differences(wall_surface: Surface, screen_color: Option<Vec3>) -> Vec<Difference> {
        let (scene, camera) = stage(wall_surface);
        let world = World::new(&scene, &scene.materials);
        let mut data = testing::traced(&world, &camera, [24, 24]);
        for i in 0..data.color.len() {
            data.color[i] = screen_color.filter(|_| !data.reflects(i)).unwrap_or(data.color[i]);
        }
        let first_hits = FirstHits::from_gbuffer(&data);
        let reference = WorldReference::new(&world, &first_hits, &camera, 3);
        let (mut state, mut floor) = (reference.start(), ScreenFloor::new(&data, &first_hits));
        [16, 16].iter().for_each(|samples| floor.add(&reference, &mut state, *samples));
        let mut state_without_floor = reference.start();
        reference.add(&mut state_without_floor, 32);
        assert_eq!(state, state_without_floor, "the truth is the same with the floor and without");
        let truth = reference.image(&state).reflection;
        let pixels = floor.image(&state).into_iter().zip(truth).zip(&first_hits.receivers).enumerate();
        let difference = |(i, ((floor, truth), receiver)): (usize, ((Vec3, Vec3), &Option<Receiver>))| {
            // A ray falls with some slope to the floor at z = 1 / slope. It rises as steeply, and reaches the wall at
            // the height 4 · slope − 2 above the eye.
            let above_m = receiver.as_ref()?.position.z.recip() * 4.0 - 2.0 - 4.0 * 5_f64.to_radians().tan();
            Some(Difference { color: floor - truth, above_m: (8..16).contains(&(i % 24)).then_some(above_m) })
        };
        pixels.filter_map(difference).collect()
    }

    /// Returns the colour differences of pixels in the middle columns whose mirror rays end in a range of metres above
    /// the upper edge.
    fn middle_colors(pixels: &[Difference], above_m_range: std::ops::Range<f64>) -> Vec<Vec3> {
        pixels
            .iter()
            .filter(|pixel| pixel.above_m.is_some_and(|above_m| above_m_range.contains(&above_m)))
            .map(|pixel| pixel.color)
            .collect()
    }

    #[test]
    fn the_floor_is_zero_where_the_screen_shows_all_as_it_is() {
        let pixels = differences(Surface::Lit, None);
        assert!(pixels.len() > 100 && pixels.iter().all(|pixel| pixel.color.length() < 1e-6));
    }

    #[test]
    fn the_floor_is_what_the_screen_shows_wrongly_and_nothing_else() {
        // The wall is unlit, so that its colour is a fifth of its albedo.
        let (wrong_color, true_color) = (Vec3::new(0.7, 0.1, 0.3), 0.2 * COLOR);
        let pixels = differences(Surface::Lit, Some(wrong_color));
        // A pixel's rays end up to half a metre apart, and colours are bilinear. Pixels whose rays end near the upper
        // edge of the screen are therefore left out.
        let (shown, hidden) = (middle_colors(&pixels, -1.0..-0.4), middle_colors(&pixels, 0.4..9.0));
        assert!(shown.len() > 10 && hidden.len() > 40, "{} {}", shown.len(), hidden.len());
        assert!(hidden.iter().all(|difference| difference.length() < 1e-6), "the screen does not show it: {hidden:?}");
        assert!(shown.iter().all(|difference| (*difference - (wrong_color - true_color)).length() < 1e-5), "{shown:?}");
    }

    #[test]
    fn on_a_surface_that_shows_the_environment_no_colour_of_the_screen_counts() {
        let pixels = differences(Surface::Sky, Some(Vec3::new(9.0, 0.0, 9.0)));
        let shown = middle_colors(&pixels, -1.0..-0.4);
        assert!(shown.len() > 10 && shown.iter().all(|difference| difference.length() < 1e-6), "{shown:?}");
    }
}

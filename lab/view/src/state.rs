//! The state that a user can change in the window, as plain data. A frame is rendered only if a part of the state on
//! which the picture depends has changed since the last rendered frame.

use super::fly_camera::FlyCamera;
use glam::Vec3;
use ssct::methods::{self, EffectParams, Fallback, MethodInfo, Setup};
use ssct::passes::Content;
use ssct::passes::look::{Compare, Tone};
use ssct_lab::app::parameters::MethodOptions;
use ssct_lab::stage::Globals;
use ssct_scenes::View;
use std::collections::BTreeMap;

/// A method with its options, as one of the two sides that are shown.
#[derive(Clone)]
pub struct Side {
    /// The method.
    pub method: &'static MethodInfo,
    /// The setup that the options give; each frame replaces its size.
    pub setup: Setup,
    /// The options that are set, by their flags, with values as the command line takes them.
    pub options: BTreeMap<String, String>,
    /// A sentence about what is wrong with the options, if anything is. The setup is then the last valid one, or leaves
    /// out the options that the method does not have.
    pub fault: Option<String>,
}

impl PartialEq for Side {
    fn eq(&self, other: &Self) -> bool {
        self.method.name == other.method.name && self.setup == other.setup
    }
}

impl Side {
    /// Makes a side of a method with options, which are by their flags.
    pub fn new(method: &'static MethodInfo, options: BTreeMap<String, String>) -> Self {
        let mut side = Self { method, setup: Setup::new([1, 1]), options, fault: None };
        side.apply();
        side
    }

    /// Sets an option, given by its flag, to a value; `None` sets it back to its default.
    pub fn set(&mut self, option: &str, value: Option<String>) {
        match value {
            Some(value) => drop(self.options.insert(option.to_owned(), value)),
            None => drop(self.options.remove(option)),
        }
        self.apply();
    }

    /// Makes the setup and the fault anew from method and options, which are parsed as on the command line.
    fn apply(&mut self) {
        let typed = self.options.iter().map(|(name, text)| (name.as_str(), text.as_str()));
        self.fault = match MethodOptions::from_typed(typed) {
            Ok(options) => {
                let setup = options.setup(self.setup.extent);
                // Options that only screen-space methods have are left out for other methods, which refuse them.
                let plain = setup.with(|p: &mut EffectParams| {
                    (p.resolution_scale, p.fallback) = (1.0, Fallback::None);
                });
                let fits = self.method.is_screen_space() || setup.effect() == plain.effect();
                self.setup = if fits { setup } else { plain };
                let name = self.method.name;
                (!fits).then(|| format!("{name} takes no resolution scale and no fallback: they are left out"))
            }
            Err(e) => Some(e.to_string()),
        };
    }
}

/// Returns the options of methods that were given on a command line, by their flags.
pub fn given_options(matches: &clap::ArgMatches) -> BTreeMap<String, String> {
    MethodOptions::typed(matches).into_iter().collect()
}

/// An intermediate image of the methods, which is shown instead of the finished image.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InnerImage {
    /// Its name.
    pub name: String,
    /// The mip level; a number beyond the last level stands for the last level.
    pub level: u32,
}

/// The image that shows each pixel's steps through the Hi-Z, which the CPU counts.
pub const STEPS: &str = "steps";

/// Parts of the panel, one of which is open.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
pub enum Tab {
    /// Scene, view, methods, materials and parameters.
    #[default]
    Tune,
    /// Times, work and errors.
    Live,
    /// Intermediates.
    Inside,
    /// A picked ray.
    Ray,
    /// Camera key frames.
    Path,
    /// Captures of the scene.
    Captures,
    /// Shaders that reload.
    Shaders,
    /// No panel.
    None,
}

impl Tab {
    /// The parts of the panel that show something, with their titles.
    pub const SHOWN: [(Self, &'static str); 7] = [
        (Self::Tune, "Tune"),
        (Self::Live, "Live"),
        (Self::Inside, "Inside"),
        (Self::Ray, "Ray"),
        (Self::Path, "Path"),
        (Self::Captures, "Captures"),
        (Self::Shaders, "Shaders"),
    ];

    /// Returns the next part of the panel, among those that show something. The first part follows the last.
    pub fn next(self) -> Self {
        let index = Self::SHOWN.iter().position(|(tab, _)| *tab == self);
        let (next, _) = Self::SHOWN[index.map_or(0, |n| (n + 1) % Self::SHOWN.len())];
        next
    }
}

/// Everything that a user changes.
#[derive(Clone)]
pub struct State {
    /// The part of the panel that is open.
    pub tab: Tab,
    /// Name of the scene, as `--scene` takes it.
    pub scene: String,
    /// The view that was chosen last; its lens and materials are used even after the camera has left it.
    pub view: View,
    /// The camera.
    pub camera: FlyCamera,
    /// True if the camera has left the view.
    pub moved: bool,
    /// Global factors.
    pub globals: Globals,
    /// The method, and the method that it is compared with.
    pub sides: [Side; 2],
    /// The way in which the two methods are shown.
    pub compare: Compare,
    /// The place of the line between the two pictures, as a share of the image's width.
    pub split: f32,
    /// Factor by which the shown difference of two methods is multiplied.
    pub gain: f32,
    /// An intermediate that is shown instead of the finished image.
    pub inside: Option<InnerImage>,
    /// How the intermediate's numbers are shown, except for `content`, which the intermediate itself determines.
    pub tone: Tone,
    /// The pixel whose ray is drawn, if one is picked.
    pub picked: Option<[u32; 2]>,
}

impl State {
    /// Returns how the picture's numbers are shown; `content` is their meaning.
    pub fn shown_tone(&self, content: Content) -> Tone {
        if self.inside.is_some() { Tone { content, ..self.tone } } else { Tone::DISPLAY }
    }

    /// Returns the sides that are rendered: one, or both if two methods are compared.
    pub fn rendered(&self) -> &[Side] {
        if self.compare == Compare::One { &self.sides[..1] } else { &self.sides }
    }

    /// Gives the first side the next method of the list of all methods. The first method follows the last.
    pub fn next_method(&mut self) {
        let side = &mut self.sides[0];
        let list = methods::all();
        let current = list.iter().position(|m| m.name == side.method.name).unwrap_or(0);
        side.method = list[(current + 1) % list.len()];
        side.apply();
    }

    /// Gives a side (0 or 1) another method.
    pub fn choose(&mut self, side: usize, method: &'static MethodInfo) {
        self.sides[side].method = method;
        self.sides[side].apply();
    }

    /// Switches from one method to both side by side, then to their difference, and then back to one.
    pub fn next_compare(&mut self) {
        self.compare = match self.compare {
            Compare::One => Compare::Split,
            Compare::Split => Compare::Difference,
            Compare::Difference => Compare::One,
        };
    }

    /// Changes the roughness of all materials by tenths; positive numbers make them rougher. If the materials kept
    /// their own roughness so far, all start from 0.
    pub fn change_roughness(&mut self, tenths: f32) {
        let current_tenths = (self.globals.roughness.unwrap_or(0.0) * 10.0).round();
        self.globals.roughness = Some(((current_tenths + tenths) / 10.0).clamp(0.0, 1.0));
    }

    /// Moves the camera to a view and uses the view's lens and materials.
    pub fn show_view(&mut self, view: &View) {
        self.view = view.clone();
        self.camera.jump(view);
        self.moved = false;
    }

    /// Moves the camera to an eye and a point that it looks at.
    pub fn put_camera(&mut self, place: (Vec3, Vec3)) {
        self.camera.put(place);
        self.moved = true;
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::state;
    use super::*;
    use clap::{Args, FromArgMatches};
    use ssct::methods::METHODS;

    #[test]
    fn options_of_the_command_line_are_those_of_a_side() {
        let command = MethodOptions::augment_args(clap::Command::new("ssct"));
        let matches = command.get_matches_from(["ssct", "--preset", "author", "--cone-samples=3", "--split"]);
        let given = given_options(&matches);
        assert_eq!(given.len(), 3, "defaults are not given: {given:?}");
        let mut side = Side::new(&METHODS[0], given);
        let expected = MethodOptions::from_arg_matches(&matches).expect("options").setup([1, 1]);
        assert_eq!((&side.setup, &side.fault), (&expected, &None));
        side.set("cone-samples", Some("many".into()));
        assert!(side.fault.as_ref().is_some_and(|f| f.contains("many")), "{:?}", side.fault);
        assert_eq!(side.setup, expected, "a wrong value changes nothing");
        side.set("cone-samples", None);
        side.set("split", None);
        assert!(side.fault.is_none() && side.setup.values.given_names().count() == 0);
    }

    #[test]
    fn roughness_steps_by_tenths_and_stays_in_range() {
        let mut state = state();
        state.change_roughness(1.0);
        assert_eq!(state.globals.roughness, Some(0.1));
        state.change_roughness(-5.0);
        assert_eq!(state.globals.roughness, Some(0.0));
        for _ in 0..METHODS.len() {
            state.next_method();
        }
        assert_eq!(state.sides[0].method.name, METHODS[0].name, "once round");
    }
}

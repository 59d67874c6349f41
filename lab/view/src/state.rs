//! The state that a user can change in the window, as plain data. A frame is rendered only if the part of the state that it depends on
//! differs from that of the last rendered frame.

use super::fly_camera::FlyCamera;
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
    /// The options as the command line takes them: those that are set.
    pub options: BTreeMap<String, String>,
    /// The fault of the options, if there is one. The setup is then the last right one, or leaves out the options that the method does not
    /// have.
    pub fault: Option<String>,
}

impl PartialEq for Side {
    fn eq(&self, other: &Self) -> bool {
        self.method.name == other.method.name && self.setup == other.setup
    }
}

impl Side {
    /// A method with the options of the command line.
    pub fn new(method: &'static MethodInfo, options: BTreeMap<String, String>) -> Self {
        let mut side = Self { method, setup: Setup::new([1, 1]), options, fault: None };
        side.apply();
        side
    }

    /// Sets an option, or with `None` goes back to its default.
    pub fn set(&mut self, option: &str, value: Option<String>) {
        match value {
            Some(value) => drop(self.options.insert(option.to_owned(), value)),
            None => drop(self.options.remove(option)),
        }
        self.apply();
    }

    /// Reads the options as the command line does.
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

/// Options that were given on a command line, by their flags.
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

    /// The next part of the panel, among those that show something.
    pub fn next(self) -> Self {
        let now = Self::SHOWN.iter().position(|(tab, _)| *tab == self);
        Self::SHOWN[now.map_or(0, |n| (n + 1) % Self::SHOWN.len())].0
    }
}

/// Everything that a user changes.
#[derive(Clone)]
pub struct State {
    /// The part of the panel that is open.
    pub tab: Tab,
    /// Name of the scene, as `--scene` takes it.
    pub scene: String,
    /// The view from which the camera came; its lens and materials hold until the next view is chosen.
    pub view: View,
    /// The camera.
    pub camera: FlyCamera,
    /// True if the camera has left its view.
    pub moved: bool,
    /// Global factors.
    pub globals: Globals,
    /// The method, and the method that it is compared with.
    pub sides: [Side; 2],
    /// The way in which the two methods are shown.
    pub compare: Compare,
    /// The place of the line between the two pictures, as a share of the image's width.
    pub split: f32,
    /// Factor by which the difference is multiplied.
    pub gain: f32,
    /// An intermediate, instead of the finished image.
    pub inside: Option<InnerImage>,
    /// How the intermediate's numbers are shown; the intermediate brings its own `content`.
    pub tone: Tone,
    /// A pixel whose ray is drawn.
    pub picked: Option<[u32; 2]>,
}

impl State {
    /// How the picture's numbers are shown.
    pub fn shown_tone(&self, content: Content) -> Tone {
        if self.inside.is_some() { Tone { content, ..self.tone } } else { Tone::DISPLAY }
    }

    /// The sides that are rendered.
    pub fn rendered(&self) -> &[Side] {
        if self.compare == Compare::One { &self.sides[..1] } else { &self.sides }
    }

    /// Gives the first side the next method of the list of all methods. The first method follows the last.
    pub fn next_method(&mut self) {
        let side = &mut self.sides[0];
        let all = methods::all();
        let now = all.iter().position(|m| m.name == side.method.name).unwrap_or(0);
        side.method = all[(now + 1) % all.len()];
        side.apply();
    }

    /// Chooses a method for a side.
    pub fn choose(&mut self, side: usize, method: &'static MethodInfo) {
        self.sides[side].method = method;
        self.sides[side].apply();
    }

    /// Goes on from one method to both side by side, to their difference, and back.
    pub fn next_compare(&mut self) {
        self.compare = match self.compare {
            Compare::One => Compare::Split,
            Compare::Split => Compare::Difference,
            Compare::Difference => Compare::One,
        };
    }

    /// Makes every material rougher (positive) or smoother by tenths. Materials that kept their own
    /// roughness so far all start from 0.
    pub fn change_roughness(&mut self, tenths: f32) {
        let now = (self.globals.roughness.unwrap_or(0.0) * 10.0).round();
        self.globals.roughness = Some(((now + tenths) / 10.0).clamp(0.0, 1.0));
    }

    /// Jumps to a view.
    pub fn show_view(&mut self, view: &View) {
        self.view = view.clone();
        self.camera.jump(view);
        self.moved = false;
    }

    /// Changes the camera by a function that returns whether the camera moved.
    pub fn steer(&mut self, change: impl FnOnce(&mut FlyCamera) -> bool) {
        self.moved |= change(&mut self.camera);
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
        assert!(side.fault.is_none() && side.setup.values.given().count() == 0);
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

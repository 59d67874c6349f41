//! The command that makes the reference of the picture that the window shows.

use crate::state::State;
use ssct_ground::scene::{FieldOfView, Lens};
use ssct_lab::app::cli::SceneOptions;
use ssct_lab::app::printed::quote_word;
use ssct_scenes::{LoadOptions, Scene};

/// Returns the command line that makes the reference of the current picture, which has the given size in pixels.
/// `place` is the options that loaded the scene. The command names the view or, if the camera has left it, the camera's
/// eye and the point that it looks at.
pub fn reference_command(state: &State, scene: &Scene, place: &SceneOptions, [width, height]: [u32; 2]) -> String {
    let mut words: Vec<String> = ["ssct", "render", "--method", "reference"].map(str::to_owned).into();
    let mut add = |flag: &str, value: String| words.extend([format!("--{flag}"), quote_word(&value)]);
    if place.scene.is_empty() {
        add("scene", state.scene.clone());
    }
    for file in &place.scene {
        add("scene", file.display().to_string());
    }
    if place.scale != 1.0 {
        add("scale", place.scale.to_string());
    }
    if place.texture_size != LoadOptions::default().texture_side {
        add("texture-size", place.texture_size.to_string());
    }
    let motion = place.motion.clone().map(|name| ("motion", name));
    for (flag, value) in place.time.map(|s| ("time", s.to_string())).into_iter().chain(motion) {
        add(flag, value);
    }
    // A view that options placed is in no list of views.
    let named_view = scene.views.iter().find(|view| !state.moved && view.name == state.view.name);
    if let Some(view) = named_view {
        add("view", view.name.clone());
    } else {
        let (eye, look_at) = state.camera.place();
        for (flag, point) in [("eye", eye), ("look-at", look_at)] {
            add(flag, format!("{},{},{}", point.x, point.y, point.z));
        }
    }
    let default_lens = named_view.and_then(|view| view.lens).unwrap_or(scene.lens);
    for (flag, number) in lens_flags(default_lens, state.view.lens.unwrap_or(scene.lens)) {
        add(flag, number.to_string());
    }
    add("size", format!("{width}x{height}"));
    let globals = &state.globals;
    for (flag, value) in [("roughness", globals.roughness), ("normal-deviation", globals.normal_deviation)] {
        if let Some(value) = value {
            add(flag, value.to_string());
        }
    }
    if globals.reflectivity != 1.0 {
        add("reflectivity", globals.reflectivity.to_string());
    }
    if let Some(bounces) = state.sides[0].options.get("bounces") {
        add("bounces", bounces.clone());
    }
    words.extend(["-o", "truth.png"].map(str::to_owned));
    words.join(" ")
}

/// Returns the flags and numbers that make the lens `wanted` of the lens `default`.
fn lens_flags(default: Lens, wanted: Lens) -> Vec<(&'static str, f32)> {
    let opening = match wanted.opening {
        FieldOfView::Angle(radians) => ("fov", degrees(radians)),
        FieldOfView::Height(height_m) => ("orthographic-height", height_m),
    };
    let flags = [
        (wanted.opening != default.opening).then_some(opening),
        (wanted.near_m != default.near_m).then_some(("near", wanted.near_m)),
        (wanted.far_m != default.far_m).then_some(("far", wanted.far_m)),
    ];
    flags.into_iter().flatten().collect()
}

/// Returns an angle in degrees which, converted to radians, is exactly `radians` if there is such a number.
fn degrees(radians: f32) -> f32 {
    let nearest = radians.to_degrees();
    let neighbours = [nearest, nearest.next_up(), nearest.next_down()];
    neighbours.into_iter().find(|degrees| degrees.to_radians() == radians).unwrap_or(nearest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::state;
    use crate::viewer::{Viewer, views_with_lens};
    use clap::{Args, FromArgMatches};
    use ssct_ground::scene::Camera;
    use ssct_lab::app::cli::CommonOptions;
    use ssct_lab::app::resolve;
    use std::ffi::OsString;
    use std::path::Path;

    /// Reads the options of a place from words of a command line, of which unknown ones are ignored.
    fn place(words: &[String]) -> SceneOptions {
        let command = CommonOptions::augment_args(clap::Command::new("ssct")).ignore_errors(true);
        let words = std::iter::once("ssct").chain(words.iter().map(String::as_str)).map(OsString::from);
        CommonOptions::from_arg_matches(&command.get_matches_from(words)).expect("options").place
    }

    /// Checks that a command leads to the scene, the camera and the lens with which a window was opened with some
    /// options. The camera is moved first if `moved` is true.
    fn check(options: &str, moved: bool) -> String {
        let first_words: Vec<String> = options.split_whitespace().map(str::to_owned).collect();
        let first_place = place(&first_words);
        let scene = resolve::scene(&first_place, "rooms").expect("a scene");
        let view = match first_place.eye {
            Some(_) => resolve::view(&scene, &first_place, None).expect("a view"),
            None => views_with_lens(&scene, &first_place).expect("views")[1].clone(),
        };
        let camera = Viewer::camera(&scene, &view);
        let mut state = State { scene: "rooms".into(), camera, view, ..state() };
        if moved {
            state.put_camera((glam::vec3(0.1, 1.7, -0.3), glam::vec3(1.0 / 3.0, 1.5, 2.0)));
        }
        let expected = state.frame_request(&scene, [53, 37]);
        let command = reference_command(&state, &scene, &first_place, [53, 37]);
        let words: Vec<String> = command.split_whitespace().skip(4).map(|word| word.replace('\'', "")).collect();
        let other_place = place(&words);
        let other_scene = resolve::scene(&other_place, "none").expect("the same scene");
        let other_view = resolve::view(&other_scene, &other_place, None).expect("the same view");
        let lens = other_view.lens.unwrap_or(other_scene.lens);
        let camera = Camera::new(other_view.eye, other_view.look_at, lens, 53.0 / 37.0);
        assert_eq!(camera, expected.camera, "{command}");
        assert_eq!(other_place.texture_size, first_place.texture_size);
        assert!(command.contains(" --size 53x37 ") && command.ends_with(" -o truth.png"), "{command}");
        command
    }

    #[test]
    fn the_command_leads_to_the_same_camera() {
        check("", false);
        check("", true);
        check("--scene atrium --scale 2.5 --texture-size 64", false);
        check("--fov 40.1 --near 0.3 --far 77", false);
        check("--fov 33.3", true);
        check("--orthographic-height 4.5", true);
        check("--eye 1,1.5,2 --look-at 0,1.25,0.5 --far 50", false);
    }

    #[test]
    fn files_and_times_are_named_and_quoted() {
        let mut place = place(&["--time".into(), "0.5".into(), "--motion".into(), "door opens".into()]);
        place.scene = ["a room.obj", "it's.obj"].map(Path::new).map(Path::to_owned).into();
        let scene = ssct_scenes::library::scene("rooms").expect("built in");
        let command = reference_command(&state(), &scene, &place, [8, 6]);
        assert!(command.contains(r#" --scene "a room.obj" --scene "it's.obj" "#), "{command}");
        assert!(command.contains(r#" --time 0.5 --motion "door opens" "#), "{command}");
    }
}

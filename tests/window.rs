//! `ssct view` as a user runs it: under an X server without a screen, without any display, and in a
//! build without the window.

#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::path::Path;
use std::process::{Command, Output};

const SIZE: &str = "320x200";

/// `ssct` on a built-in scene, without a display unless one is given.
fn ssct(folder: &Path, display: Option<&str>, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_ssct"));
    for variable in ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"] {
        command.env_remove(variable);
    }
    command.envs(display.map(|d| ("DISPLAY", d))).current_dir(folder).args(arguments);
    command.args(["--scene", "rooms", "--size", SIZE]);
    command.output().unwrap()
}

/// Fails with exit status 1 and one sentence; returns it.
fn refusal(output: &Output) -> String {
    let said = String::from_utf8(output.stderr.clone()).unwrap();
    assert_eq!((output.status.code(), said.lines().count()), (Some(1), 1), "{said}");
    assert!(output.stdout.is_empty());
    said
}

#[cfg(not(feature = "window"))]
#[test]
fn a_build_without_the_window_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let said = refusal(&ssct(folder.path(), None, &["view", "--frames", "1"]));
    assert!(said.contains("feature `window`"), "{said}");
}

#[cfg(feature = "window")]
mod with_window {
    use super::*;
    use std::io::{BufRead, BufReader};
    use std::process::{Child, Stdio};

    /// An X server of our own, which ends with the test.
    struct Xvfb {
        server: Child,
        display: String,
    }

    impl Xvfb {
        /// `None`, and a line that says so, where Xvfb is not installed.
        fn start(test: &str) -> Option<Self> {
            let started = Command::new("Xvfb")
                .args(["-displayfd", "1", "-screen", "0", "800x600x24", "-nolisten", "tcp"])
                .stdout(Stdio::piped())
                .stderr(Stdio::null())
                .spawn();
            let Ok(mut server) = started else {
                eprintln!("skipped: {test}: there is no Xvfb on the PATH; scripts/setup.sh installs it");
                return None;
            };
            let mut number = String::new();
            BufReader::new(server.stdout.take().unwrap()).read_line(&mut number).unwrap();
            assert!(!number.trim().is_empty(), "Xvfb did not start");
            Some(Self { server, display: format!(":{}", number.trim()) })
        }
    }

    impl Drop for Xvfb {
        fn drop(&mut self) {
            let _ = self.server.kill();
            let _ = self.server.wait();
        }
    }

    /// The bits of an image's values. The files themselves may differ: an EXR's chunks are written
    /// in the order in which threads finish them.
    fn values(path: &Path) -> Vec<u32> {
        if path.extension().is_some_and(|e| e == "png") {
            return image::open(path).unwrap().to_rgb8().iter().map(|v| u32::from(*v)).collect();
        }
        let image = exr::prelude::read_first_flat_layer_from_file(path).unwrap();
        let channels = image.layer_data.channel_data.list;
        channels.iter().flat_map(|c| c.sample_data.values_as_f32().map(f32::to_bits)).collect()
    }

    #[test]
    fn what_the_window_shows_is_what_render_renders() {
        let Some(x) = Xvfb::start("what_the_window_shows_is_what_render_renders") else { return };
        let folder = tempfile::tempdir().unwrap();
        let view = ["view", "--validation", "--frames", "3", "--screenshot"];
        for name in ["frame.png", "frame.exr"] {
            let shown = ssct(folder.path(), Some(&x.display), &[&view[..], &[&format!("view-{name}")]].concat());
            assert!(shown.status.success(), "{}", String::from_utf8_lossy(&shown.stderr));
            let rendered = ssct(folder.path(), None, &["render", "-o", &format!("render-{name}")]);
            assert!(rendered.status.success(), "{}", String::from_utf8_lossy(&rendered.stderr));
            let [a, b] = ["view", "render"].map(|by| values(&folder.path().join(format!("{by}-{name}"))));
            assert!(a.len() >= 320 * 200 * 3 && a == b, "{name}: the images differ");
        }
    }

    #[test]
    fn the_other_ways_to_present_work_or_are_refused_in_a_sentence() {
        let Some(x) = Xvfb::start("the_other_ways_to_present_work_or_are_refused_in_a_sentence") else { return };
        let folder = tempfile::tempdir().unwrap();
        for mode in ["mailbox", "immediate"] {
            let shown = ssct(folder.path(), Some(&x.display), &["view", "--frames", "2", "--present-mode", mode]);
            let said = String::from_utf8_lossy(&shown.stderr);
            assert!(shown.status.success() || said.contains("does not present by"), "{mode}: {said}");
        }
    }

    #[test]
    fn without_a_display_there_is_one_sentence() {
        let folder = tempfile::tempdir().unwrap();
        let said = refusal(&ssct(folder.path(), None, &["view"]));
        assert!(said.contains("no window") && said.contains("DISPLAY") && !said.contains(".rs"), "{said}");
        let said = refusal(&ssct(folder.path(), Some(":7654"), &["view"]));
        assert!(said.contains("no window") && !said.contains(".rs"), "{said}");
    }

    #[test]
    fn a_screenshot_needs_a_number_of_frames() {
        let folder = tempfile::tempdir().unwrap();
        let output = ssct(folder.path(), None, &["view", "--screenshot", "a.png"]);
        assert_eq!(output.status.code(), Some(2));
        let output = ssct(folder.path(), None, &["view", "--frames", "1", "--screenshot", "a.gif"]);
        assert_eq!(output.status.code(), Some(2), "an image format that is not written is refused before the work");
    }
}

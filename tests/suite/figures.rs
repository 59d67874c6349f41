//! Tests `ssct figures` in small pictures: the files that it makes, which figures are left out and why, and its page. A
//! headless Chromium shows the page if it is installed.

use crate::common::folder::Folder;
use crate::common::html::{attributes, probe};
use image::RgbImage;
use std::path::Path;

/// Returns the mean of the three channels (0 to 255) in a part of a picture, given by its left, top, right and bottom
/// in pixels.
fn mean(image: &RgbImage, [left, top, right, bottom]: [u32; 4]) -> f64 {
    let pixels = (top..bottom).flat_map(|y| (left..right).map(move |x| image.get_pixel(x, y).0));
    let values: Vec<f64> = pixels.flat_map(|p| p.map(f64::from)).collect();
    values.iter().sum::<f64>() / values.len() as f64
}

/// Each figure of both documents is on the page and has a file, or says that a method is missing. The page loads
/// nothing from other places, so that it can be sent as one file.
#[test]
fn every_figure_is_made_or_says_what_it_lacks() {
    let folder = Folder::new();
    let printed = folder.succeed(&["figures", "--size", "48x27", "--validation", "-o", "f"]);
    let page = folder.text("f/index.html");
    let ids = attributes(&page, "id");
    let early_chapters = ["2.3", "2.4", "3.1", "3.2", "3.7"].map(|n| format!("thesis-{n}"));
    let thesis = (1..=10).map(|n| format!("thesis-4.{n}")).chain((1..=9).map(|n| format!("thesis-5.{n}")));
    let thesis: Vec<String> = early_chapters.into_iter().chain(thesis).collect();
    let schmidt = [27, 28, 29, 32, 33, 39, 40, 41, 47, 48, 49, 50, 51].map(|n| format!("schmidt-{n}"));
    for stem in thesis.iter().chain(&schmidt) {
        assert!(ids.contains(&stem.as_str()), "{stem} stands on the page");
        let line =
            printed.lines().find(|l| l.starts_with(&format!("{stem}.")) || l.starts_with(&format!("{stem} "))).unwrap();
        match line.split_once(" left out: ") {
            // A figure may be left out only because its method does not exist.
            Some((_, why)) => assert!(why.starts_with("there is no method"), "{line}"),
            None => {
                let file = line.split(": ").next().unwrap();
                assert!(folder.path("f").join(file).is_file() && attributes(&page, "href").contains(&file), "{line}");
            }
        }
    }
    // The methods ssct and hzct always exist, so that these figures were made.
    for stem in
        ["thesis-4.1.svg", "thesis-4.4.png", "thesis-4.6.svg", "thesis-5.1.png", "thesis-5.9.png", "schmidt-27.png"]
    {
        assert!(printed.lines().any(|l| l.starts_with(stem)), "{stem}\n{printed}");
    }
    let left_out = printed.lines().filter(|l| l.contains(" left out: ")).count();
    assert_eq!(page.matches("Left out: ").count(), left_out);
    for word in ["http:", "https:", "url(", "@import", "<script"] {
        assert!(!page.contains(word), "the page needs nothing from elsewhere: {word}");
    }
    assert!(attributes(&page, "src").iter().all(|s| s.starts_with("data:image/")));
    assert!(page.contains("ssct render --scene rooms --view window-floor --method hzct --roughness 0.1"));
    check_in_browser(&folder);
}

/// Shows the page in a browser as wide as a phone, and checks that nothing is wider than the screen and that every
/// picture is there.
fn check_in_browser(folder: &Folder) {
    let script = r#"
  const d = (await show("f/index.html", 390, false)).contentDocument, r = d.documentElement;
  const bad = [...d.images].filter(i => i.naturalWidth == 0 || i.clientWidth == 0).length;
  lines.push(`overflow ${r.scrollWidth - r.clientWidth} bad ${bad} some ${d.images.length > 8}`);
"#;
    let Some(found) = probe(folder, script) else { return };
    assert_eq!(found, "overflow 0 bad 0 some true");
}

/// Five figures have the content that their captions name: lost minima in bold, brighter floors without fade, more
/// reflections by SSCT, and a grey picture of the reflectance. A figure with a wrong option would show something else.
#[test]
fn figures_show_what_their_captions_say() {
    let folder = Folder::new();
    folder.succeed(&["figures", "--only", "4.2,thesis-4.3,4.8,5.2,27", "--size", "192x108", "-o", "f"]);
    assert_eq!(
        folder.list("f"),
        [
            "cells.json",
            "index.html",
            "journal.jsonl",
            "schmidt-27.png",
            "thesis-4.2.svg",
            "thesis-4.3.svg",
            "thesis-4.8.png",
            "thesis-5.2.png"
        ]
    );
    // Cells that lost their minimum are in bold, and without Eq. 4.1 there are more of them.
    let lost = |name: &str| folder.text(name).matches("font-weight=\"bold\"").count();
    assert!(lost("f/thesis-4.2.svg") > lost("f/thesis-4.3.svg"));
    // Two renders with a gap of eight pixels.
    let fade = folder.image("f/thesis-4.8.png");
    assert_eq!(fade.dimensions(), (2 * 192 + 8, 108));
    // The floor in the lower half is brighter in the left picture, whose reflections do not fade.
    let floor = |left: u32| mean(&fade, [left, 60, left + 192, 108]);
    assert!(floor(0) > floor(200) + 2.0, "{} {}", floor(0), floor(200));
    // In figure 5.2 SSCT catches more than HZCT.
    let window = folder.image("f/thesis-5.2.png");
    let picture = |left: u32| mean(&window, [left, 0, left + 192, 108]);
    assert!(picture(0) > picture(200) + 1.0, "{} {}", picture(0), picture(200));
    // Figure 27: two pictures in each of three rows, then one.
    let gbuffer = folder.image("f/schmidt-27.png");
    assert_eq!(gbuffer.dimensions(), (2 * 192 + 8, 4 * 108 + 3 * 8));
    // The reflectance, to the right in the third row, is grey.
    assert!((244..392).all(|x| gbuffer.get_pixel(x, 2 * 116 + 50).0.windows(2).all(|c| c[0] == c[1])));
}

/// A figure that does not exist is refused with status 2 and the numbers that exist, and no folder is made.
#[test]
fn wrong_numbers_are_told() {
    let folder = Folder::new();
    let output = folder.run(&["figures", "--only", "9.9"]);
    assert_eq!(output.status.code(), Some(2));
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(message.contains("--only 9.9: there is no such figure") && message.contains("5.2"), "{message}");
    assert!(!Path::exists(&folder.path("figures")));
}

/// With a scene file that has the views of Sponza, the four figures of that scene are drawn in it, and the page says
/// so. Other figures and other scenes are refused.
#[test]
fn figures_are_drawn_in_a_file_of_the_scene_that_they_print() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("a scene")).unwrap();
    folder.write_boards("a scene", &["atrium", "lion", "hall"]);
    let file = "a scene/boards.scene.toml";
    let printed = folder.succeed(&["figures", "--scene", file, "--size", "48x27", "-o", "f"]);
    let figures: Vec<_> = printed.lines().filter_map(|l| l.split_once(".png: ")).map(|(stem, _)| stem).collect();
    assert_eq!(figures, ["thesis-3.7", "thesis-5.6", "thesis-5.7", "thesis-5.8"], "{printed}");
    let page = folder.text("f/index.html");
    assert!(page.contains("The scene of the print, from its file") && !page.contains("The generated stand-in"));
    assert!(page.contains("--scene &quot;a scene/boards.scene.toml&quot; --view hall"), "the command that draws it");

    let refused = folder.run(&["figures", "--scene", file, "--only", "5.1", "-o", "g"]);
    let message = String::from_utf8(refused.stderr).unwrap();
    assert_eq!(refused.status.code(), Some(2));
    assert!(message.contains("no such figure shows the scene of") && message.contains("5.8"), "{message}");

    std::fs::write(folder.path("plain.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    for (file, why) in [("plain.obj", "no figure is drawn in this scene"), ("none.toml", "there is no such file")] {
        let refused = folder.run(&["figures", "--scene", file, "-o", "g"]);
        let message = String::from_utf8(refused.stderr).unwrap();
        assert!(refused.status.code() == Some(2) && message.contains(why), "{message}");
    }
    assert!(!folder.path("g").exists());
}

/// In the Cornell box, the ceiling is black without diffuse bounces and bright with four, since only indirect light
/// reaches it. A scene without a rectangular light and another method are refused.
#[test]
fn indirect_light_comes_from_area_lights_alone() {
    let folder = Folder::new();
    let render = |scene: &str, bounces: &str, to: &str| {
        let settings = ["--method", "reference", "--max-rays", "8", "--size", "32x32", "--diffuse-bounces", bounces];
        folder.run(&[&["render", "--scene", scene, "-o", to][..], &settings].concat())
    };
    assert!(render("cornell-box", "0", "direct.png").status.success());
    assert!(render("cornell-box", "4", "both.png").status.success());
    let ceiling = |file: &str| mean(&folder.image(file), [8, 2, 24, 4]);
    assert!(ceiling("direct.png") < 4.0 && ceiling("both.png") > 20.0);
    let refused = render("atrium", "1", "none.png");
    let message = String::from_utf8(refused.stderr).unwrap();
    assert!(refused.status.code() == Some(2) && message.contains("has no rectangular area light"), "{message}");
    let refused = folder.run(&["render", "--method", "ssct", "--diffuse-bounces", "1", "-o", "x.png"]);
    assert!(String::from_utf8(refused.stderr).unwrap().contains("--diffuse-bounces is for --method reference"));
}

//! The pictures of `ssct study`.

use super::reference;
use crate::error::Result;
use crate::report::figures::{self, Figure};
use crate::report::html::{Gallery, Picture, Strip};
use crate::report::images;
use crate::stage::{Globals, SharedImages, Shot, Stage, gbuffer, image};
use crate::study::error::{EXACT_HITS, ErrorRecord, SCREEN_REFERENCE, WORLD_REFERENCE, flip_file, picture_file};
use crate::study::names::{cell_name, roughness_name, safe_word};
use crate::study::table;
use ssct::gpu::Pixels;
use ssct::methods::{self, METHODS, MethodInfo, Setup, Wants, unified};
use ssct_scenes::inside::PathInFolder;
use ssct_scenes::{Scene, View};

/// Name of the pictures without reflections.
const LIT: &str = "direct light";
/// Name of the pictures by the world reference.
const TRUTH: &str = "truth";
/// Rays a pixel of these pictures.
const TRUTH_RAYS: u32 = 16;
/// The folder that keeps the truth's samples for the next run.
pub const TRUTH_FOLDER: &str = "truth";
/// Name of the pictures of `unified` whose rays all end on the screen.
const ON_SCREEN: &str = "unified on the screen";
/// The folder of the error study.
pub const ERROR_FOLDER: &str = "error";
/// Roughness and normal deviation of the pictures: table 5.8's rougher rows.
pub const GLOSSY: Globals = table::factors(0.1, 1.0);

/// A view, and the methods that show it.
pub struct ShownView<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The view.
    pub view: &'a View,
    /// Width and height of the pictures.
    pub size: [u32; 2],
    /// The methods.
    pub methods: &'a [&'static MethodInfo],
}

/// Makes the pictures of a view, writes them below `folder`, and returns them as a gallery: direct light alone, the
/// truth, every method, and `unified` on the screen alone. `step` is called after the truth and after each picture of a
/// method.
pub fn view_gallery(
    stage: &mut Stage,
    subject: &ShownView,
    folder: &PathInFolder,
    step: &mut dyn FnMut() -> Result<()>,
) -> Result<Gallery> {
    let ShownView { scene, view, size, methods } = *subject;
    let plain = Setup::new(size);
    let on_screen = Setup::on_screen(size);
    let methods = methods.iter().map(|m| (*m, m.name, &plain, format!("{}, roughness 0.1", m.name)));
    let on_screen_caption = "unified on the screen alone, roughness 0.1".to_owned();
    let shown: Vec<_> = methods.chain([(&unified::INFO, ON_SCREEN, &on_screen, on_screen_caption)]).collect();
    let camera = view.camera(scene, size);
    let materials = GLOSSY.materials(scene, view);
    let mut shared = SharedImages::default();
    let mut pictures = Vec::new();
    let mut add_picture = |pixels: &Pixels, name: &str, caption: String| -> Result<()> {
        let [scene, view] = [&scene.name, &view.name].map(|name| safe_word(name));
        let file = format!("images/{scene}-{view}-{}.png", name.replace(' ', "-"));
        images::write_image(folder.join(&file), pixels)?;
        pictures.push(Picture { file, name: name.into(), caption });
        Ok(())
    };
    for (n, (method, name, setup, caption)) in shown.iter().enumerate() {
        let shot = shared.shot(stage, method, setup, Wants::IMAGE, camera, materials.clone())?;
        let (_, _, output) = shared.output_at_rest(stage, &shot)?;
        let rendered = stage.context.read(output.composite.level(0))?;
        // The lit colour and the truth are the same for all methods, so they are made of the first shot.
        if n == 0 {
            let lit = stage.context.read(shot.gbuffer.gbuffer().color.level(0))?;
            add_picture(&lit, LIT, "direct light only".into())?;
            let (data, cache) = (gbuffer::read(&mut stage.context, &shot)?, folder.path().join(TRUTH_FOLDER));
            let truth = reference::truth(scene, &materials, &data, TRUTH_RAYS, &cache)?;
            add_picture(&truth, TRUTH, format!("the truth, roughness 0.1: traced with {TRUTH_RAYS} rays a pixel"))?;
            step()?;
        }
        add_picture(&rendered, name, caption.clone())?;
        step()?;
    }
    Ok(Gallery {
        title: format!("{}, {}", scene.name, view.name),
        strips: vec![Strip::Plain(pictures)],
        compared: [METHODS[0].name.into(), TRUTH.into()],
    })
}

/// Draws figures 4.4, 4.5, 4.9 and 4.10 of a scene that has a view `corridor`, and writes them below `folder`.
pub fn thesis_figures(stage: &mut Stage, scene: &Scene, folder: &PathInFolder, size: [u32; 2]) -> Result<Vec<Picture>> {
    // For each figure: the stem of its file, its size in pixels, the view, and the caption.
    let wanted = [
        (
            Figure::VisibilityChain,
            "figure-4.4",
            [512, 512],
            "corridor",
            "Figure 4.4: the chain of the visibility buffer, level 0 omitted",
        ),
        (
            Figure::RaySplit,
            "figure-4.5",
            size,
            "corridor",
            "Figure 4.5: rays traced by Hi-Z (green) and by the linear march (red); darker where nothing was hit",
        ),
        (
            Figure::RayTraceColorChain,
            "figure-4.9",
            size,
            "corridor",
            "Figure 4.9: first five levels of the ray trace color buffer of SSLR",
        ),
        (
            Figure::MaskChain,
            "figure-4.10",
            size,
            "corridor",
            "Figure 4.10: first five levels of the mask buffer of SSLR",
        ),
    ];
    let mut pictures = Vec::new();
    for (figure, stem, extent, view, caption) in wanted {
        let view = scene.view(view)?;
        let camera = view.camera(scene, extent);
        let setup = figure.setup(&Setup::new(extent));
        let method = methods::find(figure.method())?;
        let shot = Shot::new(stage, method, &setup, Wants::HITS, camera, GLOSSY.materials(scene, view))?;
        if let Some(images) = image::render(stage, &shot, true)?.intermediates {
            let file = format!("images/{stem}.png");
            figures::draw(figure, &images, &camera.lens)?.write_png(folder.join(&file))?;
            pictures.push(Picture { file, name: stem.to_owned(), caption: caption.to_owned() });
        }
    }
    Ok(pictures)
}

/// Makes a gallery for each view and roughness: every method with its FLIP map, next to the reference that its error is
/// measured against. The pictures are the files that the error study wrote.
pub fn error_galleries(records: &[ErrorRecord], methods: &[&MethodInfo]) -> Vec<Gallery> {
    let mut galleries: Vec<Gallery> = Vec::new();
    for record in records {
        let head = &record.head;
        let title = format!("{}, {}, roughness {}", head.scene, head.view, roughness_name(head.roughness));
        if galleries.iter().any(|g| g.title == title) {
            continue;
        }
        let stem = cell_name(&head.scene, &head.view, [head.width, head.height], head.roughness);
        let picture = |file: String, name: &str, caption: String| Picture {
            file: format!("{ERROR_FOLDER}/images/{file}"),
            name: name.to_owned(),
            caption,
        };
        let reflection = |name: &str, caption: &str| picture(picture_file(&stem, name), name, caption.into());
        let reflection_and_flip = |name: &str| {
            let flip = flip_file(&stem, name);
            [reflection(name, name), picture(flip, &format!("FLIP map of {name}"), format!("FLIP map of {name}"))]
        };
        let was_judged = |m: &&MethodInfo| {
            let is_of_view = |r: &&ErrorRecord| (&r.head.scene, &r.head.view) == (&head.scene, &head.view);
            records.iter().filter(is_of_view).any(|r| r.head.method == m.name)
        };
        let (on_screen, beyond_screen): (Vec<&MethodInfo>, Vec<&MethodInfo>) =
            methods.iter().copied().filter(was_judged).partition(|m| m.is_screen_space());
        let beside = |title: &str, reference, names: Vec<&str>| Strip::Beside {
            title: title.to_owned(),
            reference,
            pairs: names.into_iter().map(reflection_and_flip).collect(),
        };
        galleries.push(Gallery {
            title,
            strips: vec![
                beside(
                    "Against the screen reference",
                    reflection(SCREEN_REFERENCE, "screen reference"),
                    on_screen.iter().map(|m| m.name).chain([EXACT_HITS]).collect(),
                ),
                beside(
                    "Methods that see more than the screen, against the world",
                    reflection(WORLD_REFERENCE, "world reference"),
                    beyond_screen.iter().map(|m| m.name).collect(),
                ),
            ],
            compared: [METHODS[0].name.into(), SCREEN_REFERENCE.into()],
        });
    }
    galleries
}

//! The record of a variant's film, with the table, the chart and the clips of such records.

use crate::study::columns::{Column, columns, figure, part, series, time};
use crate::study::engine::Row;
use crate::study::exhibit::{Chart, Clip, ClipGroup, Drawing, Line, Table};
use crate::study::names::{cell_name, roughness_name};
use crate::study::record::{Head, Provenance};
use serde_json::Value;

columns! {
    /// A frame of a film.
    #[derive(Copy)]
    pub struct VideoFrame {
        /// Time of the method in milliseconds.
        pub effect_ms: f64 = time(""),
        /// RMSE of the linear reflection colour against the world of this frame, over reflecting pixels.
        pub rmse: f64 = figure(""),
        /// Mean FLIP of the display image of the reflection colour.
        pub flip: f64 = figure(""),
    }
}

columns! {
    /// The film of a variant beside the world's.
    pub struct VideoRecord {
        /// Subject of the record; the view is where the camera begins.
        #[serde(flatten)]
        pub head: Head = part(),
        /// Name of the camera's way.
        pub way: String = figure("way"),
        /// Name of the scene's motion that is played, if any.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pub play: Option<String>,
        /// Names of the meshes that move in addition.
        pub moving: Vec<String>,
        /// Motion of these meshes from one frame to the next, in metres along the world's axes.
        pub step_m: [f32; 3],
        /// Number of frames after which these meshes rest; null if they never do.
        #[serde(default)]
        pub step_frames: Option<u32>,
        /// Names of the meshes that move with the camera.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        pub held: Vec<String>,
        /// Whether each frame is shifted by another part of a pixel.
        #[serde(default)]
        pub jitter: bool,
        /// Frames in a second.
        pub frames_per_second: f32,
        /// Rays a pixel of the world reference.
        pub rays: u32,
        /// Median over the frames of the method's time, in milliseconds.
        pub time_ms: f64 = time("ms").digits(1),
        /// Mean over the frames of the RMSE of the linear reflection colour against the world, over reflecting pixels.
        pub rmse: f64 = figure("RMSE"),
        /// Mean FLIP of the display images of the reflection colour, over all frames.
        pub flip: f64 = figure("FLIP"),
        /// Mean absolute change of the linear reflection colour from a pixel to the same surface a frame before; null if
        /// no frame shows a surface of the frame before.
        pub flicker: Option<f64> = figure(""),
        /// Flicker of the world reference, computed like `flicker`.
        pub reference_flicker: Option<f64> = figure(""),
        /// Mean absolute difference between the variant's changes and those of the world reference; null without changes.
        pub change_error: Option<f64> = figure(""),
        /// Quality of the finished images beside the world's, in just-objectionable differences (JOD): 10 is the world.
        pub jod: f64 = figure("JOD").digits(2).signed(),
        /// Quality of the reflection colour alone beside the world's, in just-objectionable differences (JOD).
        pub jod_reflection: f64 = figure("JOD of reflections").digits(2).signed(),
        /// Mean over the frames of the world reference's standard error.
        pub standard_error: f64 = figure("standard error"),
        /// Every frame in order.
        pub frames: Vec<VideoFrame> = series(),
    }
}

impl VideoRecord {
    /// Returns a mean change divided by the flicker of the world reference; `None` without a change, or if the reference
    /// does not change.
    fn per_reference_flicker(&self, change: Option<f64>) -> Option<f64> {
        let reference_flicker = self.reference_flicker.filter(|flicker| *flicker > 0.0)?;
        change.map(|change| change / reference_flicker)
    }

    /// Returns the title of the record's group of films: those of one scene, view, way, size and roughness, which pages
    /// show together.
    fn group(&self) -> String {
        let Head { scene, view, width, height, .. } = &self.head;
        format!("{scene} {view}, {}, {width}x{height}, roughness {}", self.way, roughness_name(self.head.roughness))
    }

    /// Returns the path of a film of the record's cell in the folder of the run; `name` is a variant's name, or
    /// [`WORLD`].
    pub(super) fn clip_file(&self, name: &str) -> String {
        let Head { scene, view, width, height, .. } = &self.head;
        let stem = cell_name(scene, &format!("{view}-{}", self.way), [*width, *height], self.head.roughness);
        let safe = |c: char| if c.is_ascii_alphanumeric() || c == '.' { c } else { '-' };
        // A " + " between two words becomes a single hyphen.
        let name = name.chars().map(safe).collect::<String>().replace("---", "-");
        format!("{CLIPS}/{stem}-{name}.webp")
    }
}

/// Folder of the animated pictures.
const CLIPS: &str = "clips";

/// The name that stands for a variant in the file of the world reference's film.
pub(super) const WORLD: &str = "world";

const ABOUT: &str = "Each film is held against that of the world, frame by frame: FLIP and RMSE of the reflection colour as \
    means over the frames; the mean absolute change of a pixel from where its surface was a frame before, over that of the \
    world, and how far the change is off the world's, in the same unit; and the quality of the whole film in \
    just-objectionable differences (JOD), by ColorVideoVDP: 10 is the world, and of two films that are 1 apart 75 % of \
    people prefer the better.";

impl Row for VideoRecord {
    const KIND: &'static str = "video";
    const TITLE: &'static str = "Films";
    const FOLDERS: &'static [&'static str] = &[CLIPS];

    fn program(&self) -> &Provenance {
        &self.head.program
    }

    /// Makes one table, with two further columns: the changes, divided by those of the world.
    fn tables(rows: &[Self], _: &Value) -> Vec<Table> {
        let more = [
            Column::derived("flicker over the world's", 2, |r: &Self| r.per_reference_flicker(r.flicker)),
            Column::derived("error of changes over it", 2, |r: &Self| r.per_reference_flicker(r.change_error)),
        ];
        vec![Table { about: ABOUT.to_owned(), ..Table::with_columns("table", rows, more) }]
    }

    /// Draws a line for each record: FLIP over the frames.
    fn charts(rows: &[Self]) -> Vec<Chart> {
        let heads: Vec<&Head> = rows.iter().map(|r| &r.head).collect();
        let line = |r: &Self| {
            let points = r.frames.iter().enumerate().map(|(n, f)| (n as f64, f.flip));
            Line { name: r.head.line_name(&heads, &r.head.variant()), points: points.collect() }
        };
        let axes = ["frame", "FLIP of the reflection colour"].map(str::to_owned);
        vec![Chart::new("video", "FLIP from frame to frame", Drawing::Lines(axes, rows.iter().map(line).collect()))]
    }

    /// Returns the films in groups, each of which begins with the film of the world.
    fn clips(rows: &[Self]) -> Vec<ClipGroup> {
        let mut groups: Vec<ClipGroup> = Vec::new();
        for r in rows {
            if groups.last().is_none_or(|group| group.title != r.group()) {
                let world = Clip { file: r.clip_file(WORLD), name: "the world".to_owned(), caption: String::new() };
                groups.push(ClipGroup { title: r.group(), clips: vec![world] });
            }
            let caption = format!("{:.2} JOD, {:.1} ms", r.jod, r.time_ms);
            let clip = Clip { file: r.clip_file(&r.head.variant()), name: r.head.variant(), caption };
            if let Some(group) = groups.last_mut() {
                group.clips.push(clip);
            }
        }
        groups
    }
}

//! A page of animated pictures beside each other, which begin together.

use super::{frame, heading, page_header, sections};
use crate::gpu::DeviceInfo;
use crate::study::record::DEFINITIONS;
use maud::{Markup, PreEscaped, html};

/// An animated picture.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Clip {
    /// File, relative to the page.
    pub file: String,
    /// What is filmed.
    pub name: String,
    /// What is known of it.
    pub caption: String,
}

/// What the page shows.
pub struct ClipsPage<'a> {
    /// Its title.
    pub title: &'a str,
    /// Device that everything ran on.
    pub device: Option<&'a DeviceInfo>,
    /// The command that made it.
    pub command: &'a str,
    /// Clips that are looked at together, under their titles.
    pub groups: &'a [(String, Vec<Clip>)],
    /// What the table says.
    pub rule: &'a str,
    /// The table, its header first.
    pub cells: &'a [Vec<String>],
    /// A plot, SVG.
    pub plot: &'a str,
}

/// Pictures that are loaded anew begin anew; those of a group together, once all of them are there.
const TOGETHER: &str = r#"
for (const button of document.querySelectorAll("button.together")) {
  button.addEventListener("click", async () => {
    const images = [...button.parentElement.querySelectorAll("img")];
    const blobs = await Promise.all(images.map(async (image) => {
      image.dataset.file ??= image.getAttribute("src");
      try { return await (await fetch(image.dataset.file)).blob(); } catch { return null; }
    }));
    images.forEach((image, n) => {
      image.src = blobs[n] ? URL.createObjectURL(blobs[n]) : image.dataset.file + "?" + Date.now();
    });
  });
}
"#;

/// The whole page.
pub fn clips_page(page: &ClipsPage) -> String {
    let parts = [("films", "Films"), ("table", "Every film"), ("frames", "From frame to frame")];
    let [films, table, frames] = parts.map(heading);
    let group = |(title, clips): &(String, Vec<Clip>)| -> Markup {
        html! {
            section {
                h3 { (title) }
                button.together type="button" { "Begin together" }
                div.strip {
                    @for clip in clips {
                        figure {
                            img src=(clip.file) alt={ "Film of " (clip.name) ": " (title) } loading="lazy";
                            figcaption { b { (clip.name) } @if !clip.caption.is_empty() { ": " (clip.caption) } }
                        }
                    }
                }
            }
        }
    };
    let body = html! {
        (films)
        @for of in page.groups { (group(of)) }
        (table)
        p { (page.rule) }
        (sections::grid(page.cells))
        (frames)
        (sections::inline_svg(page.plot, "FLIP from frame to frame; video-frames.csv has the same values"))
        script { (PreEscaped(TOGETHER)) }
    };
    let parts = parts.map(|(id, title)| (id.to_owned(), title));
    frame(page.title, &page_header(page.title, page.device, DEFINITIONS, page.command, &parts), &body)
}

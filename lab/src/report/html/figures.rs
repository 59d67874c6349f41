//! The page of the theses' figures: each figure as it is made here, a description of the printed one, the commands that make it, and the
//! differences.

use super::embed::{embed, svg_uri};
use super::{assemble, heading, page_header};
use crate::error::Result;
use crate::study::record::DEFINITIONS;
use maud::{Markup, html};
use serde::{Deserialize, Serialize};
use ssct::gpu::DeviceInfo;
use ssct_scenes::inside::PathInFolder;

/// Greatest width of an embedded picture in pixels.
const WIDEST: u32 = 1600;

/// The whole page.
pub struct FiguresPage<'a> {
    /// Device that rendered the figures.
    pub device: &'a DeviceInfo,
    /// The command that made the page.
    pub command: String,
    /// Figures by document.
    pub groups: Vec<Group>,
}

/// The figures of a document.
pub struct Group {
    /// The part's id.
    pub id: String,
    /// The part's heading.
    pub title: String,
    /// A description of the document.
    pub source: String,
    /// The document's figures, in order.
    pub entries: Vec<Entry>,
}

/// A figure.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Entry {
    /// The stem of the file's name, and the figure's id on the page.
    pub stem: String,
    /// Number and subject.
    pub title: String,
    /// The figure's file, relative to the page, or the reason why there is none.
    pub file: std::result::Result<String, String>,
    /// What the print shows.
    pub print: String,
    /// The differences between print and the figure made here.
    pub differs: String,
    /// The figure's parts, in reading order.
    pub panels: Vec<Panel>,
    /// The command that makes this figure alone.
    pub command: String,
}

/// A part of a figure.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Panel {
    /// The label of the part.
    pub label: String,
    /// The command that renders the part.
    pub command: String,
}

impl FiguresPage<'_> {
    /// Returns the page as HTML. Its pictures are read from `folder`, in which the page will lie.
    pub fn render(&self, folder: &PathInFolder) -> Result<String> {
        let parts: Vec<_> = self.groups.iter().map(|g| (g.id.clone(), g.title.as_str())).collect();
        let groups = self.groups.iter().map(|g| group(g, folder)).collect::<Result<Vec<_>>>()?;
        let header = page_header("Figures of the theses", Some(self.device), DEFINITIONS, &self.command, &parts);
        let body = html! {
            p {
                "The figures on this page are made anew by this program. Pictures are embedded small, as JPEG; each links to "
                "its file. Scenes are generated stand-ins for those in print, seen from similar places, except where a "
                "figure says that its scene is that of the print."
            }
            @for group in groups { (group) }
        };
        Ok(assemble("figures", &header, &body))
    }
}

/// Returns the part of the page with the figures of a document, below links to them.
fn group(group: &Group, folder: &PathInFolder) -> Result<Markup> {
    let entries = group.entries.iter().map(|e| entry(e, folder)).collect::<Result<Vec<_>>>()?;
    Ok(html! {
        (heading((&group.id, &group.title)))
        p { (group.source) }
        nav aria-label={ "Figures: " (group.title) } {
            ul { @for e in &group.entries { li { a href={ "#" (e.stem) } { (e.title.split(':').next().unwrap_or_default()) } } } }
        }
        @for entry in entries { (entry) }
    })
}

/// Returns a figure with the texts about it, or the reason why it was left out in place of the figure.
fn entry(entry: &Entry, folder: &PathInFolder) -> Result<Markup> {
    let shown = match &entry.file {
        Ok(file) => {
            let picture = picture(entry, file, folder)?;
            html! { figure { a href=(file) { (picture) } } }
        }
        Err(why) => html! { p { "Left out: " (why) } },
    };
    Ok(html! {
        section.plate id=(entry.stem) {
            h3 { (entry.title) }
            (shown)
            dl {
                dt { "In print" } dd { (entry.print) }
                dt { "Here" } dd { (entry.differs) }
                dt { "Made by" } dd { code { (entry.command) } }
                @if !entry.panels.is_empty() {
                    dt { "Parts" }
                    dd {
                        ul { @for p in &entry.panels { li { (p.label) ": " code { (p.command) } } } }
                    }
                }
            }
        }
    })
}

/// Returns the image element of a figure, with the figure's file embedded in it: a drawing unchanged, and a picture at
/// most [`WIDEST`] pixels wide.
fn picture(entry: &Entry, file: &str, folder: &PathInFolder) -> Result<Markup> {
    let place = folder.join(file);
    if file.ends_with(".svg") {
        let svg = svg_uri(&place.bytes()?);
        return Ok(html! { img src=(svg) alt=(entry.title) decoding="async"; });
    }
    let embedded = embed(&place, WIDEST)?;
    Ok(html! {
        img src=(embedded.uri) alt=(entry.title) width=(embedded.width) height=(embedded.height) decoding="async";
    })
}

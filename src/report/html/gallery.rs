//! Pictures on the page: a strip of them, and above it two of them with a divider to drag. The
//! divider is a script's work; without it, and on paper, the strip is all there is.

use super::embed::embed;
use crate::error::Result;
use maud::{Markup, html};
use std::path::Path;

/// A picture of the page.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    /// PNG file, relative to the page.
    pub file: String,
    /// What it is called among those of its gallery.
    pub name: String,
    /// What it shows.
    pub caption: String,
}

/// Pictures of the same pixels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Gallery {
    /// Scene and view.
    pub title: String,
    /// The pictures; one of the same name as an earlier one is the same picture.
    pub pictures: Vec<Picture>,
    /// Names of the two that the divider stands between at first.
    pub compared: [String; 2],
    /// Whether each three pictures make a row.
    pub rows_of_three: bool,
}

/// A gallery with its divider.
pub fn gallery(gallery: &Gallery, folder: &Path) -> Result<Markup> {
    let class = if gallery.rows_of_three { "strip three" } else { "strip" };
    Ok(html! {
        section data-compare=(gallery.compared.join(",")) {
            h3 { (gallery.title) }
            (strip(&gallery.title, &gallery.pictures, class, folder)?)
        }
    })
}

/// Pictures beside each other.
pub fn strip(title: &str, pictures: &[Picture], class: &str, folder: &Path) -> Result<Markup> {
    // Where pictures stand below each other, one of them is enough.
    let again = |n: usize| pictures[..n].iter().any(|p| p.name == pictures[n].name);
    let figures =
        pictures.iter().enumerate().map(|(n, p)| figure(title, p, again(n), folder)).collect::<Result<Vec<_>>>()?;
    Ok(html! { div class=(class) { @for figure in figures { (figure) } } })
}

fn figure(title: &str, picture: &Picture, again: bool, folder: &Path) -> Result<Markup> {
    let embedded = embed(&folder.join(&picture.file), u32::MAX)?;
    Ok(html! {
        figure.again[again] data-name=(picture.name) {
            a href=(picture.file) {
                img src=(embedded.uri) alt={ (title) ": " (picture.caption) }
                    width=(embedded.width) height=(embedded.height) decoding="async";
            }
            figcaption { (picture.caption) }
        }
    })
}

/// What the script copies for each gallery.
pub fn compare_template() -> Markup {
    html! {
        template id="compare-template" {
            div.compare {
                div.choice {
                    label { "Left " select {} }
                    label { "Right " select {} }
                }
                div.stage {
                    img.left alt="";
                    img.right alt="";
                    span.divider {}
                    input type="range" min="0" max="100" value="50"
                        aria-label="Divider between the left and the right picture";
                }
            }
        }
    }
}

//! Pictures on the page: a strip of pictures and, above the strip, two of them with a divider to drag. A script adds
//! the two pictures with the divider; without the script, and on paper, there is only the strip.

use super::embed::PictureFolder;
use crate::error::Result;
use maud::{Markup, html};

/// Greatest width of an embedded picture in pixels: about the width of the divider's stage, so that the page stays
/// small.
pub const WIDEST: u32 = 720;

/// A picture of the page.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    /// PNG file, relative to the page.
    pub file: String,
    /// The picture's name within its gallery.
    pub name: String,
    /// A description of the picture.
    pub caption: String,
}

/// Pictures beside each other.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Strip {
    /// Pictures in rows; each row holds as many as there is room for.
    Plain(Vec<Picture>),
    /// A reference, with pairs of a picture and its error map. The reference stands between the two images of a pair, and stays in sight as
    /// the page is scrolled.
    Beside {
        /// The subject of the strip.
        title: String,
        /// The picture in the middle.
        reference: Picture,
        /// Pictures and error maps.
        pairs: Vec<[Picture; 2]>,
    },
}

/// Pictures of one view that show the same pixels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Gallery {
    /// Scene and view.
    pub title: String,
    /// The pictures; no two of a gallery have the same name.
    pub strips: Vec<Strip>,
    /// Names of the two pictures between which the divider stands at first.
    pub compared: [String; 2],
}

/// Returns a gallery as HTML, to which the script adds the two pictures with the divider.
pub fn gallery(gallery: &Gallery, folder: &PictureFolder) -> Result<Markup> {
    let strips = gallery.strips.iter().map(|s| strip(&gallery.title, s, folder)).collect::<Result<Vec<_>>>()?;
    Ok(html! {
        section data-compare=(gallery.compared.join(",")) {
            h3 { (gallery.title) }
            @for strip in strips { (strip) }
        }
    })
}

/// Returns a strip as HTML; `title` is the title of its gallery.
fn strip(title: &str, strip: &Strip, folder: &PictureFolder) -> Result<Markup> {
    match strip {
        Strip::Plain(pictures) => {
            let figures = figures(title, pictures, folder)?;
            Ok(html! { div.strip { (figures) } })
        }
        Strip::Beside { title: strip_title, reference, pairs } => {
            let reference = figures(title, [reference], folder)?;
            let figures = figures(title, pairs.iter().flatten(), folder)?;
            Ok(html! {
                h4 { (strip_title) }
                div.strip.beside style={ "--rows: " (pairs.len()) } { (reference) (figures) }
            })
        }
    }
}

/// Returns pictures as HTML figures, in their order; `title` begins the texts for readers who cannot see them.
pub fn figures<'p>(
    title: &str,
    pictures: impl IntoIterator<Item = &'p Picture>,
    folder: &PictureFolder,
) -> Result<Markup> {
    let figures = pictures.into_iter().map(|p| figure(title, p, folder)).collect::<Result<Vec<_>>>()?;
    Ok(html! { @for figure in figures { (figure) } })
}

/// Returns a picture as an HTML figure: embedded at most [`WIDEST`] pixels wide, and linked to its file.
fn figure(title: &str, picture: &Picture, folder: &PictureFolder) -> Result<Markup> {
    let embedded = folder.embed(&picture.file, WIDEST)?;
    Ok(html! {
        figure data-name=(picture.name) {
            a href=(picture.file) {
                img src=(embedded.uri) alt={ (title) ": " (picture.caption) }
                    width=(embedded.width) height=(embedded.height) decoding="async";
            }
            figcaption { (picture.caption) }
        }
    })
}

/// The template that the script copies for each gallery.
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

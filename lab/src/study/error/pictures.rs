//! The pictures of a cell: reflection colours, and for each method the error maps, as numbers and as pictures in FLIP's
//! colours.

use super::{MeasuredCell, display};
use crate::study::exhibit::{Content, ExtraFile};
use crate::study::names::safe_word;

/// The folder of the cells' pictures.
pub const IMAGES: &str = "images";

/// Returns the file name of a picture of the cell named `cell`, in the folder of the pictures. The files of its error
/// maps have "-rmse" or "-flip" before the extension.
pub fn picture_file(cell: &str, name: &str) -> String {
    format!("{cell}-{}.png", safe_word(name))
}

/// Returns the file name of the FLIP map of a picture of the cell named `cell`, in the folder of the pictures.
pub fn flip_file(cell: &str, name: &str) -> String {
    format!("{cell}-{}-flip.png", safe_word(name))
}

/// Makes the image files of a cell, whose names begin with the cell's name `name`. Each reference and variant has a
/// picture. A variant also has maps of its RMSE and its FLIP, each as numbers (EXR) and in colours (PNG).
pub(super) fn files(name: &str, cell: &MeasuredCell) -> Vec<ExtraFile> {
    let image_file = |file: String, content| ExtraFile { path: format!("{IMAGES}/{file}"), content };
    let mut files = Vec::new();
    for picture in &cell.pictures {
        files.push(image_file(
            picture_file(name, &picture.name),
            Content::Picture(cell.extent, display(&picture.color)),
        ));
        let Some(error) = &picture.error else { continue };
        let stem = format!("{name}-{}", safe_word(&picture.name));
        for (measure, values) in [("rmse", &error.rmse), ("flip", &error.flip.errors)] {
            files.push(image_file(format!("{stem}-{measure}.exr"), Content::Map(cell.extent, values.clone(), measure)));
            files.push(image_file(format!("{stem}-{measure}.png"), Content::heat(cell.extent, values)));
        }
    }
    files
}

//! How devices agree, as tables.

use super::tables;
use crate::gpu::Precision;
use crate::study::agreement::{AgreementRecord, DrawnRecord};

/// What the table of [`cells`] says, in a paragraph.
pub const ABOUT_METHODS: &str = "Every method on the very same G-buffer, which the first device drew: each device's hits and \
    reflection colour against the first one's. A pixel is apart if only one of the two rays hits, or both hit more than a pixel \
    from each other; a tie is one in which a ray ends at either place within the rounding of 32-bit floats. Methods that see \
    more than the screen draw that with the device itself.";

/// What the table of [`drawn_cells`] says, in a paragraph.
pub const ABOUT_DRAWN: &str = "The G-buffers that the devices draw of one view. Another surface is shown by pixels at \
    silhouettes, which a rasteriser with other sub-pixel precision puts on the other side of an edge. All else is of material \
    maps: where a driver puts the samples of an anisotropic filter, how finely it interpolates between texels, and how it \
    rounds the levels of a map's chain are its own affair by the specification. The rows without anisotropy and without normal \
    maps say how much each is of it. The bits are those with which a device places vertices within pixels, and itself between \
    texels and between levels.";

/// Header and rows of what methods make of one G-buffer.
pub fn cells(records: &[AgreementRecord]) -> Vec<Vec<String>> {
    let header = ["method", "roughness", "device", "beside", "hits agree", "apart", "ties", "RMSE", "FLIP"];
    let mut rows = vec![header.map(str::to_owned).to_vec()];
    let count = |n: Option<usize>| n.map_or_else(|| "-".into(), |n| n.to_string());
    rows.extend(records.iter().map(|r| {
        vec![
            r.head.method.clone(),
            tables::roughness(r.head.roughness),
            r.head.program.device.name.clone(),
            r.base.name.clone(),
            r.hits.hit_agreement.map_or_else(|| "-".into(), |share| format!("{:.4} %", 100.0 * share)),
            count(r.apart),
            count(r.ties),
            format!("{:.5}", r.rmse),
            format!("{:.4}", r.flip),
        ]
    }));
    rows
}

/// Header and rows of the G-buffers that devices draw.
pub fn drawn_cells(records: &[DrawnRecord]) -> Vec<Vec<String>> {
    let header = [
        "scene view",
        "device",
        "beside",
        "bits",
        "bits there",
        "anisotropy",
        "maps",
        "surface",
        "normal",
        "colour",
        "RMSE",
    ];
    let mut rows = vec![header.map(str::to_owned).to_vec()];
    let yes = |v: bool| if v { "yes" } else { "no" }.to_owned();
    let percent = |share: f64| format!("{:.3} %", 100.0 * share);
    let bits = |p: &Precision| format!("{}/{}/{}", p.sub_pixel_bits, p.sub_texel_bits, p.mipmap_bits);
    rows.extend(records.iter().map(|r| {
        vec![
            format!("{} {}", r.scene, r.view),
            r.device.name.clone(),
            r.base.name.clone(),
            bits(&r.precision[1]),
            bits(&r.precision[0]),
            yes(!r.isotropic),
            yes(!r.plain_normals),
            percent(r.other_surface),
            percent(r.other_normal),
            percent(r.other_color),
            format!("{:.5}", r.rmse),
        ]
    }));
    rows
}

/// Both tables for a terminal.
pub fn text(records: &[AgreementRecord], drawn: &[DrawnRecord]) -> String {
    let methods = tables::aligned(&cells(records));
    format!("On one G-buffer:\n{methods}\nThe G-buffers that the devices draw, share of other pixels:\n{}", {
        tables::aligned(&drawn_cells(drawn))
    })
}

//! How devices agree, as tables.

use super::devices::name_among;
use super::tables;
use crate::gpu::{DeviceInfo, Precision};
use crate::study::agreement::{AgreementRecord, DrawnRecord};

/// What the table of [`cells`] says, in a paragraph.
pub const ABOUT_METHODS: &str = "Every method runs on one G-buffer, which the device under “beside” drew; the hits and the \
    reflection colour of each device are held against those of that device. The hits of a pixel are apart if only one of the two \
    rays hits, or if both hit more than a pixel from each other. They are a tie if the rounding of 32-bit floats alone decides \
    between them. A method that sees more than the screen also draws the scene, with the device that it runs on.";

/// What the table of [`drawn_cells`] says, in a paragraph.
pub const ABOUT_DRAWN: &str = "Each device draws the G-buffer of one view; the table gives the shares of pixels that differ. A \
    pixel shows another surface where the two devices put it on different sides of an edge. Normals differ by more than 2 degrees \
    and colours by more than 0.02 mostly because of the filter of material maps: the specification does not say where an \
    anisotropic filter takes its samples. The rows without anisotropy and without normal maps show how much each of them \
    contributes. The three numbers of bits are those of the position of a vertex within a pixel, of a position between two texels \
    and of one between two levels.";

/// Header and rows of what methods make of one G-buffer.
pub fn cells(records: &[AgreementRecord]) -> Vec<Vec<String>> {
    let header = ["method", "roughness", "device", "beside", "hits agree", "apart", "ties", "RMSE", "FLIP"];
    let mut rows = vec![header.map(str::to_owned).to_vec()];
    let devices: Vec<&DeviceInfo> = records.iter().flat_map(|r| [&r.head.program.device, &r.base]).collect();
    let count = |n: Option<usize>| n.map_or_else(|| "-".into(), |n| n.to_string());
    rows.extend(records.iter().map(|r| {
        vec![
            r.head.method.clone(),
            tables::roughness(r.head.roughness),
            name_among(&r.head.program.device, &devices),
            name_among(&r.base, &devices),
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
    let devices: Vec<&DeviceInfo> = records.iter().flat_map(|r| [&r.device, &r.base]).collect();
    let yes = |v: bool| if v { "yes" } else { "no" }.to_owned();
    let percent = |share: f64| format!("{:.3} %", 100.0 * share);
    let bits = |p: &Precision| format!("{}/{}/{}", p.sub_pixel_bits, p.sub_texel_bits, p.mipmap_bits);
    rows.extend(records.iter().map(|r| {
        vec![
            format!("{} {}", r.scene, r.view),
            name_among(&r.device, &devices),
            name_among(&r.base, &devices),
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

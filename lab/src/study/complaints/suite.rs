//! The study of complaints: each complaint is a cell, in which every variant of the methods is measured.

use super::cases::{COMPLAINTS, Complaint};
use super::frames::{CaseInput, show_frames};
use super::pictures;
use super::row::ComplaintRow;
use crate::error::{Error, Result};
use crate::stage::Globals;
use crate::study::engine::{Bench, Planned, Study};
use crate::study::error::Variant;
use crate::study::journal::scene_digest;
use crate::study::record::{Provenance, recorded_setup};
use serde_json::json;
use ssct::gpu::Gpu;
use ssct::methods::setup::BeyondScreen;
use ssct::methods::{EffectParams, MethodInfo, Setup};
use ssct_scenes::Scene;

/// Sizes of the frames in pixels: in a whole study, and in a quick one.
const SIZES: [[u32; 2]; 2] = [[240, 136], [120, 68]];

/// Some complaints, and the variants that are measured on them.
pub struct ComplaintStudy {
    /// Complaints, each with its scene and frames.
    cases: Vec<(&'static Complaint, CaseInput)>,
    /// Variants, each with its name.
    variants: Vec<(String, Variant)>,
}

impl ComplaintStudy {
    /// Makes the study of some methods. The frames are small if `is_quick`. If `words` are given, only complaints whose
    /// name contains them are measured. A method that follows rays among the triangles beyond the screen is also
    /// measured on the screen alone.
    ///
    /// # Errors
    /// [`Usage`](ssct::Error::Usage) if no complaint has `words` in its name.
    pub fn new(methods: &[&'static MethodInfo], is_quick: bool, words: Option<&str>) -> Result<Self> {
        let size = SIZES[usize::from(is_quick)];
        let chosen = COMPLAINTS.iter().filter(|c| words.is_none_or(|words| c.name.contains(words)));
        let cases: Vec<_> = chosen.map(|complaint| (complaint, (complaint.input)(size))).collect();
        if let (Some(words), true) = (words, cases.is_empty()) {
            let names: Vec<&str> = COMPLAINTS.iter().map(|c| c.name).collect();
            return Err(Error::usage(format!(
                "no complaint has {words:?} in its name; there are: {}",
                names.join("; ")
            )));
        }
        let variants = methods.iter().flat_map(|method| variants(method, &Setup::new(size))).collect();
        Ok(Self { cases, variants })
    }

    /// Makes the row of a complaint and of the variant with the index `variant`; `value` is the number that measures
    /// the complaint.
    fn row(
        &self,
        gpu: &Gpu,
        (complaint, input): &(&Complaint, CaseInput),
        variant: usize,
        value: Option<f64>,
    ) -> ComplaintRow {
        let (name, method_variant) = &self.variants[variant];
        let first_frame = &input.frames[0];
        let setup = (input.change_setup)(method_variant.setup.with_extent(first_frame.extent));
        let lens = first_frame.view.lens.unwrap_or(input.scene.lens);
        ComplaintRow {
            kind: "complaints".to_owned(),
            program: Provenance::on(gpu),
            case: complaint.name.to_owned(),
            complaint: complaint.complaint.to_owned(),
            method: name.clone(),
            measured: complaint.measured.to_owned(),
            value,
            at_most: complaint.at_most,
            is_good: value.is_some_and(|value| value <= complaint.at_most),
            width: first_frame.extent[0],
            height: first_frame.extent[1],
            frames: input.frames.len(),
            setup: recorded_setup(&setup, Some(method_variant.method), &lens, &Globals::default()),
        }
    }
}

/// Makes the variants of a method, each with its name: the method with the given setup, and, if it can follow rays from
/// the screen among the triangles, the method on the screen alone.
fn variants(method: &'static MethodInfo, setup: &Setup) -> Vec<(String, Variant)> {
    let plain = (method.name.to_owned(), Variant { method, setup: setup.clone() });
    let setup_on_screen = setup.with(|p: &mut EffectParams| p.beyond = BeyondScreen::None);
    let on_screen = (format!("{}, screen alone", method.name), Variant { method, setup: setup_on_screen });
    let has_both = method.takes_triangles && method.is_screen_space();
    std::iter::once(plain).chain(has_both.then_some(on_screen)).collect()
}

/// A cell is a complaint, given by its index among the study's cases.
impl Study for ComplaintStudy {
    type Cell = usize;
    type Row = ComplaintRow;

    fn scenes(&self) -> Vec<&Scene> {
        self.cases.iter().map(|(_, input)| &input.scene).collect()
    }

    /// Lists a cell for each complaint.
    fn cells(&self) -> Vec<Planned<usize>> {
        let planned = |(index, (complaint, input)): (usize, &(&Complaint, CaseInput))| {
            let variant_settings = |(name, variant): &(String, Variant)| {
                let setup = (input.change_setup)(variant.setup.clone());
                json!([name, setup.recorded(Some(variant.method))])
            };
            let variants: Vec<_> = self.variants.iter().map(variant_settings).collect();
            let inputs = json!([scene_digest(&input.scene), format!("{:?}", input.frames), input.bounces, input.rays]);
            Planned {
                name: complaint.name.to_owned(),
                setup: json!([complaint.measured, inputs, variants]),
                cell: index,
            }
        };
        self.cases.iter().enumerate().map(planned).collect()
    }

    /// Returns the number of frames, but at least 2: for a cell of one step, the engine itself advances the progress
    /// bar, too.
    fn steps(&self, cell: &usize) -> usize {
        let (_, input) = &self.cases[*cell];
        input.frames.len().max(2)
    }

    /// Draws the frames of a complaint by every variant, keeps the pictures, and returns a row for each variant. The
    /// progress bar advances by one step a frame, and at the end by the steps for which there is no frame.
    fn measure(&mut self, cell: &usize, bench: &mut Bench) -> Result<Vec<ComplaintRow>> {
        let case = &self.cases[*cell];
        let (complaint, input) = case;
        let (names, variants): (Vec<_>, Vec<_>) = self.variants.iter().cloned().unzip();
        let (gpu, unused_steps) = (bench.gpu, self.steps(cell) - input.frames.len());
        let frames = show_frames(gpu, input, &variants, &mut || bench.step())?;
        (bench.advance)(unused_steps);
        pictures::files(complaint, &names, &frames).iter().try_for_each(|file| (bench.keep)(file))?;
        let rows = (0..names.len()).map(|variant| {
            let value = (complaint.number)(&frames, variant);
            self.row(gpu, case, variant, value)
        });
        Ok(rows.collect())
    }
}

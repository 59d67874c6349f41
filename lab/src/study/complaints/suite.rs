//! The study of complaints: each complaint is a cell, in which every method is tried.

use super::cases::{COMPLAINTS, Complaint};
use super::frames::{CaseInput, show_frames};
use super::pictures;
use super::row::ComplaintRow;
use crate::error::{Error, Result};
use crate::stage::Globals;
use crate::study::engine::{Bench, Planned, Study};
use crate::study::error::Variant;
use crate::study::journal::scene_digest;
use crate::study::record::{Provenance, recorded};
use serde_json::json;
use ssct::gpu::Gpu;
use ssct::methods::setup::BeyondScreen;
use ssct::methods::{EffectParams, MethodInfo, Setup};
use ssct_scenes::Scene;

/// Sizes of the pictures in pixels: of a whole study, and of a quick one.
const SIZES: [[u32; 2]; 2] = [[240, 136], [120, 68]];

/// Some complaints, and the variants that are tried on them.
pub struct ComplaintStudy {
    cases: Vec<(&'static Complaint, CaseInput)>,
    variants: Vec<(String, Variant)>,
}

impl ComplaintStudy {
    /// The study of some methods: in small pictures if `is_quick`, and only for complaints whose name contains `words`, if
    /// given. A method that follows rays among the triangles beyond the screen is also tried on the screen alone.
    ///
    /// # Errors
    /// [`Usage`](ssct::Error::Usage) if no complaint has `words` in its name.
    pub fn new(methods: &[&'static MethodInfo], is_quick: bool, words: Option<&str>) -> Result<Self> {
        let size = SIZES[usize::from(is_quick)];
        let chosen = COMPLAINTS.iter().filter(|c| words.is_none_or(|words| c.name.contains(words)));
        let cases: Vec<_> = chosen.map(|complaint| (complaint, (complaint.take)(size))).collect();
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

    /// The row of a variant, with its number.
    fn row(
        &self,
        gpu: &Gpu,
        (complaint, take): &(&Complaint, CaseInput),
        variant: usize,
        value: Option<f64>,
    ) -> ComplaintRow {
        let (name, method_variant) = &self.variants[variant];
        let first = &take.frames[0];
        let setup = (take.set)(method_variant.setup.with_extent(first.extent));
        let lens = first.view.lens.unwrap_or(take.scene.lens);
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
            width: first.extent[0],
            height: first.extent[1],
            frames: take.frames.len(),
            setup: recorded(&setup, Some(method_variant.method), &lens, &Globals::default()),
        }
    }
}

/// The variants of a method, each with its name: the method with the given setup, and also on the screen alone if the
/// method can follow rays among the triangles.
fn variants(method: &'static MethodInfo, setup: &Setup) -> Vec<(String, Variant)> {
    let plain = (method.name.to_owned(), Variant { method, setup: setup.clone() });
    let on_screen = setup.with(|p: &mut EffectParams| p.beyond = BeyondScreen::None);
    let alone = (format!("{}, screen alone", method.name), Variant { method, setup: on_screen });
    let has_both = method.takes_triangles && method.is_screen_space();
    std::iter::once(plain).chain(has_both.then_some(alone)).collect()
}

/// A cell is a complaint, by its index.
impl Study for ComplaintStudy {
    type Cell = usize;
    type Row = ComplaintRow;

    fn scenes(&self) -> Vec<&Scene> {
        self.cases.iter().map(|(_, take)| &take.scene).collect()
    }

    /// Lists a cell for each complaint.
    fn cells(&self) -> Vec<Planned<usize>> {
        let planned = |(n, (complaint, take)): (usize, &(&Complaint, CaseInput))| {
            let set = |(name, variant): &(String, Variant)| {
                let setup = (take.set)(variant.setup.clone());
                json!([name, setup.recorded(Some(variant.method))])
            };
            let set: Vec<_> = self.variants.iter().map(set).collect();
            let shown = json!([scene_digest(&take.scene), format!("{:?}", take.frames), take.bounces, take.rays]);
            Planned { name: complaint.name.to_owned(), setup: json!([complaint.measured, shown, set]), cell: n }
        };
        self.cases.iter().enumerate().map(planned).collect()
    }

    fn steps(&self, cell: &usize) -> usize {
        // With one step, the engine would advance the progress bar, too.
        self.cases[*cell].1.frames.len().max(2)
    }

    /// Draws the frames of a complaint by every variant, keeps the pictures, and returns a row for each variant. The
    /// progress bar advances by one step a frame, and at the end by the steps for which there is no frame.
    fn measure(&mut self, cell: &usize, bench: &mut Bench) -> Result<Vec<ComplaintRow>> {
        let case = &self.cases[*cell];
        let (complaint, take) = case;
        let (names, variants): (Vec<_>, Vec<_>) = self.variants.iter().cloned().unzip();
        let (gpu, unused_steps) = (bench.gpu, self.steps(cell) - take.frames.len());
        let seen = show_frames(gpu, take, &variants, &mut || bench.step())?;
        (bench.advance)(unused_steps);
        pictures::all(complaint, &names, &seen).iter().try_for_each(|file| (bench.keep)(file))?;
        let rows = (0..names.len()).map(|n| self.row(gpu, case, n, (complaint.number)(&seen, n)));
        Ok(rows.collect())
    }
}

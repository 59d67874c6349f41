//! Makes the records of a variant: compares its image and its hits with the references of a cell.

use super::truth::{Reference, Truth};
use super::{ErrorRecord, ErrorReference, ErrorSpec, VariantTime, display};
use crate::study::columns::{figure, measured_columns};
use crate::study::record::{Head, RecordSubject};
use ssct::gpu::Gpu;
use ssct::methods::Setup;
use ssct_ground::math::OracleVersion;
use ssct_truth::metrics::flip::FlipMap;
use ssct_truth::metrics::hits::HitAgreement;
use ssct_truth::metrics::image::{masked_relative_mse, masked_rmse};
use ssct_truth::metrics::place::{self, RayEnd};
use ssct_truth::metrics::world;

/// An image, with the reference that it is compared with.
struct JudgedImage<'a> {
    /// The references of the cell, for the reflecting pixels and the size.
    truth: &'a Truth,
    /// The reference that the image is compared with.
    reference: &'a Reference,
    /// Linear reflection colour of the image.
    color: &'a [[f32; 3]],
}

measured_columns! {
    /// The errors of an image. A value without a meaning is null.
    #[derive(Copy, Default)]
    pub struct ImageError by from_image(image: &JudgedImage) {
        /// Root mean square error of the linear reflection colour over reflecting pixels.
        pub rmse: Option<f64> = figure("") => Some(masked_rmse(&image.reference.color, image.color, &image.truth.mask)),
        /// Mean square error divided by the mean square of the reference.
        pub rel_mse: Option<f64> = figure("") =>
            masked_relative_mse(&image.reference.color, image.color, &image.truth.mask),
        /// Mean FLIP of the display image of the reflection colour.
        pub flip: Option<f64> = figure("") => Some(image.flip()),
        /// Share of the reflecting pixels in which the reflection is black. The errors of a black image say nothing of
        /// a method.
        pub black: Option<f64> = figure("") => image.black(),
        /// RMSE that the reference itself is expected to have, from the finite number of its rays.
        pub standard_error: Option<f64> = figure("") => Some(image.reference.standard_error),
    }
}

impl JudgedImage<'_> {
    /// Returns the share of the reflecting pixels that are black; `None` if no pixel reflects.
    fn black(&self) -> Option<f64> {
        let reflecting = self.color.iter().zip(&self.truth.mask).filter(|(_, reflects)| **reflects);
        let (mut pixels, mut black_pixels) = (0.0, 0.0);
        for (color, _) in reflecting {
            pixels += 1.0;
            black_pixels += f64::from(u8::from(*color == [0.0; 3]));
        }
        (pixels > 0.0).then(|| black_pixels / pixels)
    }

    /// Returns the mean FLIP between the display images of the reference and of the image.
    fn flip(&self) -> f64 {
        let (width, height) = (self.truth.data.width, self.truth.data.height);
        FlipMap::new(&self.reference.display, &display(self.color), width, height).mean()
    }
}

/// Where a method's rays ended.
pub(super) struct MethodHits {
    /// Hit of each pixel's ray on the screen, in pixels; `None` for a miss. There is no list for a method whose rays
    /// end among the triangles of the scene.
    pub(super) positions: Option<Vec<Option<[f64; 2]>>>,
    /// End of each pixel's ray in the world.
    pub(super) ends: Vec<RayEnd>,
}

/// A template for the records of a variant, with the fields that they share.
pub(super) struct RecordTemplate {
    /// The record, without errors.
    pub(super) record: ErrorRecord,
    /// The version of the oracle that the variant is compared with.
    oracle: OracleVersion,
}

impl RecordTemplate {
    /// Makes the template of a subject's records; `time` is `None` for a subject that was not timed.
    pub(super) fn new(
        gpu: &Gpu,
        spec: &ErrorSpec,
        subject: RecordSubject,
        setup: &Setup,
        time: Option<&VariantTime>,
    ) -> Self {
        let setup = setup.with_extent(spec.extent);
        let head = Head::new("error", gpu, (spec.scene, spec.view), subject, &setup, &spec.globals);
        Self {
            oracle: setup.effect().oracle,
            record: ErrorRecord {
                head,
                time_ms: time.map(|time| time.median_ms),
                time_low_ms: time.and_then(|time| time.interval).map(|[low, _]| low),
                time_high_ms: time.and_then(|time| time.interval).map(|[_, high]| high),
                against: ErrorReference::Screen,
                hits: HitAgreement::default(),
                image: ImageError::default(),
                place_agreement: None,
                floor: None,
                prepared: None,
            },
        }
    }

    /// Makes the record of an image's errors against one reference. `color` is the linear reflection colour of each
    /// pixel, and `against` is the kind of `reference`.
    pub(super) fn image(
        &self,
        against: ErrorReference,
        truth: &Truth,
        reference: &Reference,
        color: &[[f32; 3]],
    ) -> ErrorRecord {
        ErrorRecord {
            against,
            image: ImageError::from_image(&JudgedImage { truth, reference, color }),
            floor: (against == ErrorReference::World).then_some(truth.floor),
            ..self.record.clone()
        }
    }

    /// Makes the records of a variant against all references. The image `color` is compared with the world reference,
    /// and with the screen reference if the variant sees the screen alone (`on_screen`). In a cell of mirrors, `hits`
    /// are compared with the oracle's and with the world's.
    pub(super) fn against_all(
        &self,
        truth: &Truth,
        on_screen: bool,
        color: &[[f32; 3]],
        hits: Option<&MethodHits>,
    ) -> Vec<ErrorRecord> {
        let hits = hits.filter(|_| truth.has_only_mirrors);
        let screen = truth.screen(self.oracle);
        let mut records = Vec::new();
        if let Some(positions) = hits.and_then(|hits| hits.positions.as_ref()) {
            let oracle_positions: Vec<_> = screen.hits.iter().map(|hit| hit.map(|p| [p.x, p.y])).collect();
            let hits = HitAgreement::new(&truth.mask, positions, &oracle_positions);
            records.push(ErrorRecord { against: ErrorReference::Oracle, hits, ..self.record.clone() });
        }
        if on_screen {
            records.push(self.image(ErrorReference::Screen, truth, &screen.image, color));
        }
        let mut world = self.image(ErrorReference::World, truth, &truth.world, color);
        if let Some(hits) = hits {
            world.place_agreement = place::agreement(&truth.world_hits, &hits.ends);
        }
        if let Some(positions) = hits.and_then(|hits| hits.positions.as_ref()) {
            let visible: Vec<_> = truth.world_hits.iter().map(|hit| hit.visible_at().map(|p| p.to_array())).collect();
            let agreement = world::agreement(&truth.mask, &visible, positions);
            let share = |count: u64| (agreement.pixels > 0).then(|| count as f64 / agreement.pixels as f64);
            world.hits = HitAgreement {
                hit_agreement: agreement.fraction(),
                false_hits: share(agreement.false_hits),
                missed: share(agreement.missed),
                displaced: share(agreement.displaced),
                ..HitAgreement::default()
            };
        }
        records.push(world);
        records
    }
}

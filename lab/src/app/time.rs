//! `ssct time`.

use super::cli::{CommonOptions, DeviceOptions, count_parser, parse_size};
use super::measure::StudyOptions;
use super::parameters::{TypedVariant, parse_variant};
use super::resolve;
use crate::error::{Error, Result};
use crate::report::{files, trace};
use crate::stage::Globals;
use crate::study::captions::{CAPTIONS, Caption, REFERENCE};
use crate::study::cell_list::CellList;
use crate::study::error::Variant;
use crate::study::journal::Journal;
use crate::study::table as table_5_8;
use crate::study::timing::{self, ThesisFigures, TimeJob, TimeSettings, TimeStudy};
use clap::{Args, ValueEnum};
use ssct::methods;
use ssct_scenes::Scene;
use std::path::PathBuf;
use std::rc::Rc;

/// Roughness and normal deviation of the captions' views unless flags say otherwise: table 5.8's rougher rows. The captions give no
/// roughness.
const CAPTION_ROUGHNESS: f32 = 0.1;

/// Options of `ssct time`.
#[derive(Debug, Args)]
pub struct TimeOptions {
    /// Scene, methods and device.
    #[command(flatten)]
    pub common: CommonOptions,
    /// Methods, such as ssct,hzct; by default all of them
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub method: Vec<String>,
    /// A method with its own options; may be repeated
    ///
    /// An example is "traced --tracer query". Options within the quotes override the same options outside them. Give it once for each
    /// variant that is timed, instead of --method. The tables of two or more end with verdicts on each beside the first
    /// (docs/definitions.md, "Verdicts"). A folder whose path has blanks stands in quotes of its own:
    /// "'my methods/m' --fade off".
    #[arg(
        long,
        value_name = "METHOD OPTIONS",
        value_parser = parse_variant,
        conflicts_with_all = ["method", "table"]
    )]
    pub variant: Vec<TypedVariant>,
    /// Widths and heights in pixels; by default 960x540
    #[arg(long, alias = "sizes", value_name = "WxH", value_parser = parse_size, value_delimiter = ',')]
    pub size: Vec<[u32; 2]>,
    /// Measure a table of the thesis, or its captions' times
    #[arg(long, value_name = "TABLE", value_enum, long_help = help_of_tables())]
    pub table: Option<Table>,
    /// For --table captions: rays a pixel of the reference that takes the place of Mitsuba.
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..=65536))]
    pub reference_rays: u32,
    /// Frames of a method that are timed
    ///
    /// They are as many for each method, size and roughness.
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = count_parser(0))]
    pub samples: usize,
    /// Frames that are drawn before the first that is timed.
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = count_parser(0))]
    pub warmup: usize,
    /// Time each method against itself, too: its noise floor
    ///
    /// The noise floor is how far a method strays from itself. Within it `ssct compare` calls nothing faster or slower.
    #[arg(long)]
    pub a_a: bool,
    /// Write each sample's passes, on the host and on the device, as a trace for Chrome or Perfetto.
    #[arg(long, value_name = "FILE")]
    pub trace: Option<PathBuf>,
}

/// The long help of `--table`.
fn help_of_tables() -> String {
    format!(
        "Measure a table of the thesis, or its captions' times\n\nA table is measured at its own sizes and roughness values, on the \
         view `hall`; the times in the captions each on the view that takes the place of its figure. Of table 5.8, {}. With --size \
         only some are measured, and beside them may stand sizes that have no row in print.",
        table_5_8::rows_and_seconds()
    )
}

/// A table of the thesis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Table {
    /// Resolutions and roughness values of SSCT, HZCT and SSLR.
    #[value(name = "5.8")]
    T5_8,
    /// The times under figures 5.2 to 5.9.
    Captions,
}

impl StudyOptions for TimeOptions {
    type Study = TimeStudy;

    fn device(&self) -> &DeviceOptions {
        &self.common.device
    }

    fn study(&self) -> Result<TimeStudy> {
        if self.samples == 0 {
            return Err(Error::usage("--samples 0: at least one is needed".into()));
        }
        let (beside, jobs) = match self.table {
            Some(Table::Captions) => (ThesisFigures::Captions, caption_jobs(self)?),
            Some(Table::T5_8) => (ThesisFigures::Table, vec![job(self, true)?]),
            None => (ThesisFigures::Nothing, vec![job(self, false)?]),
        };
        let judges = self.variant.len() > 1;
        let settings = TimeSettings { beside, samples: self.samples, a_a: self.a_a, judges };
        Ok(TimeStudy::new(jobs, settings, self.warmup, self.reference_rays))
    }

    fn write_more(&self, list: &CellList, journal: &Journal) -> Result<()> {
        let Some(path) = &self.trace else { return Ok(()) };
        Ok(files::write(path, trace::json(&timing::frames(list, journal)).as_bytes())?)
    }
}

/// Returns the measurement that the flags ask for: methods on a view or, if `is_table` is true, table 5.8 on its view.
fn job(options: &TimeOptions, is_table: bool) -> Result<TimeJob> {
    let common = &options.common;
    let scene = resolve::scene(&common.place, if is_table { "atrium" } else { "rooms" })?;
    let view = resolve::view(&scene, &common.place, is_table.then_some("hall"))?;
    let globals = if is_table { table_globals(options)? } else { resolve::globals(&common.place)? };
    let sizes = sizes(options, is_table)?;
    let base = common.method_options.setup(sizes[0]);
    let variants = match &options.variant[..] {
        [] if is_table && options.method.is_empty() => Variant::for_methods(&table_5_8::methods(), &base),
        [] => {
            let lenses = resolve::lenses(&scene, [&view]);
            Variant::for_methods(&resolve::methods(&options.method, &base, &[&scene], &lenses)?, &base)
        }
        typed => resolve::leave_out_lacking(
            resolve::typed_variants(typed, &base)?,
            |variant: &Variant| variant.method,
            &[&scene],
        )?,
    };
    Ok(TimeJob { scene: Rc::new(scene), view, variants, sizes, globals, has_reference: false })
}

/// Returns the sizes in pixels that the flags give or, without any, those of table 5.8 if `is_table` is true, or else
/// 960×540. If none of the given sizes is one of the table, that is an error.
fn sizes(options: &TimeOptions, is_table: bool) -> Result<Vec<[u32; 2]>> {
    let table_sizes = table_5_8::sizes();
    if !options.size.is_empty() {
        if is_table && !options.size.iter().any(|size| table_sizes.contains(size)) {
            let named: Vec<String> = options.size.iter().map(|[w, h]| format!("{w}x{h}")).collect();
            let (named, has) = (named.join(", "), table_5_8::rows_and_seconds());
            return Err(Error::usage(format!("--table 5.8 has no row for {named}; {has}")));
        }
        return Ok(resolve::distinct_values(&options.size));
    }
    Ok(if is_table { table_sizes } else { vec![[960, 540]] })
}

/// The roughness values of table 5.8 that the flags ask for, or all of them, each also set as the normal deviation.
/// Values that the table does not have are an error.
fn table_globals(options: &TimeOptions) -> Result<Vec<Globals>> {
    if options.common.place.normal_deviation.is_some() {
        return Err(Error::usage("--table 5.8 sets the normal deviation to the roughness".into()));
    }
    let in_table = table_5_8::ROUGHNESS;
    let wanted = if options.common.place.roughness.is_empty() {
        in_table.to_vec()
    } else {
        resolve::distinct_values(&options.common.place.roughness)
    };
    if let Some(unknown) = wanted.iter().find(|roughness| !in_table.contains(roughness)) {
        let has = table_5_8::rows_and_seconds();
        return Err(Error::usage(format!("--table 5.8 has no row for roughness {unknown}; {has}")));
    }
    let reflectivity = options.common.place.reflectivity;
    Ok(wanted.iter().map(|roughness| table_5_8::factors(*roughness, reflectivity)).collect())
}

/// Returns a measurement for each caption that the flags ask for: `ssct` and the caption's other method on the view
/// that stands for its figure. Where the other is Mitsuba, the reference on the CPU is measured instead.
fn caption_jobs(options: &TimeOptions) -> Result<Vec<TimeJob>> {
    let place = &options.common.place;
    if !options.method.is_empty() || !options.size.is_empty() {
        let message = "--table captions takes methods and sizes from the captions, without --method and --size";
        return Err(Error::usage(message.into()));
    }
    let (scenes, globals) = (caption_scenes(options)?, caption_globals(options)?);
    let job = |(caption, scene): (Caption, &Rc<Scene>)| {
        let has_reference = caption.other == REFERENCE;
        let names = ["ssct", caption.other];
        let methods = names.iter().filter(|name| **name != REFERENCE).map(|name| methods::find(name));
        let methods = methods.collect::<ssct::Result<Vec<_>>>()?;
        Ok(TimeJob {
            scene: Rc::clone(scene),
            view: resolve::with_lens(scene, scene.view(caption.view)?.clone(), place)?,
            variants: Variant::for_methods(&methods, &options.common.method_options.setup(caption.size)),
            sizes: vec![caption.size],
            globals: globals.clone(),
            has_reference,
        })
    };
    find_captions(options, &scenes)?.into_iter().map(job).collect()
}

/// The scene that the flags name, or else the built-in scenes that take the place of those in the printed figures.
fn caption_scenes(options: &TimeOptions) -> Result<Vec<Rc<Scene>>> {
    let place = &options.common.place;
    if place.scene.is_empty() {
        let mut names: Vec<&str> = CAPTIONS.iter().map(|c| c.scene).collect();
        names.sort_unstable();
        names.dedup();
        return names.into_iter().map(|name| Ok(Rc::new(resolve::scene(place, name)?))).collect();
    }
    Ok(vec![Rc::new(resolve::scene(place, "")?)])
}

/// Returns the captions whose view the flags name, or all captions, each with the first scene that has its view.
/// Captions whose view no scene has are left out.
fn find_captions<'a>(options: &TimeOptions, scenes: &'a [Rc<Scene>]) -> Result<Vec<(Caption, &'a Rc<Scene>)>> {
    if options.common.place.eye.is_some() {
        return Err(Error::usage("--eye: the captions of --table captions name their views".into()));
    }
    let wanted_view = options.common.place.view.as_deref();
    let caption_and_scene = |c: &Caption| {
        let scene = scenes.iter().find(|s| s.views.iter().any(|v| v.name == c.view))?;
        wanted_view.is_none_or(|view| view == c.view).then_some((*c, scene))
    };
    let wanted: Vec<_> = CAPTIONS.iter().filter_map(caption_and_scene).collect();
    if wanted.is_empty() {
        let views: Vec<&str> = CAPTIONS.iter().map(|c| c.view).collect();
        let views = views.join(", ");
        return Err(Error::usage(format!("no caption with times is of such a view; they are of: {views}")));
    }
    Ok(wanted)
}

/// The global factors that the flags give. By default the roughness is [`CAPTION_ROUGHNESS`], and the normal deviation
/// equals the roughness.
fn caption_globals(options: &TimeOptions) -> Result<Vec<Globals>> {
    let mut globals = resolve::globals(&options.common.place)?;
    for factors in &mut globals {
        factors.roughness = factors.roughness.or(Some(CAPTION_ROUGHNESS));
        factors.normal_deviation = factors.normal_deviation.or(factors.roughness);
    }
    Ok(globals)
}

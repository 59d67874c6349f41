//! The `ssct` command: arguments, headless runs and the exit status. Only this module and the modules inside it print.

mod age;
mod captures;
pub mod cli;
mod command;
mod compare;
mod custom_methods;
mod devices;
mod drivers;
mod error;
mod figures;
mod gbuffer;
mod gpu_study;
pub mod headings;
pub mod help;
mod index;
mod measure;
mod merge;
mod merger;
mod motion;
mod numbers;
pub mod parameters;
mod path;
mod pixel;
mod precision;
pub mod printed;
mod progress;
pub mod reference;
mod reference_part;
mod render;
pub mod resolve;
mod run;
mod shaders;
mod stress;
mod studies;
mod study;
mod study_pictures;
mod time;
mod truth;
mod variants;
mod video;
mod view;

use crate::error::Error;
use crate::study::names::one_line;
use clap::FromArgMatches;
use command::{Cli, Command};
use ssct::gpu::device::memory_limit;
use ssct::gpu::sources;
use std::ffi::OsString;
use std::io::Write;
use std::process::ExitCode;
use tracing_subscriber::Layer;
use tracing_subscriber::filter::{LevelFilter, ParseError, Targets};
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;

/// Runs the command line of `ssct`. The exit status is 0 if all is done, and 1 if the run failed or its results fail a
/// test of their study. It is 2 if the arguments are wrong, and 128 + n if signal n stopped the run.
pub fn run() -> ExitCode {
    run_program(help::command, |cli: &Cli| match &cli.command {
        Command::Render(options) => render::run(options),
        Command::Study(options) => study::run(options),
        Command::View(options) => view::run(options),
        Command::Measure(study) => study.run(),
        Command::GpuStudy(options) => gpu_study::run(options),
        Command::Compare(options) => compare::run(options),
        Command::Merge(options) => merge::run(options),
        Command::Index(options) => index::run(options),
        Command::Figures(options) => figures::run(options),
        Command::Captures(options) => captures::run(options),
        Command::Devices(options) => devices::run(options),
        Command::Drivers(options) => drivers::run(options),
        Command::GBuffer(command) => gbuffer::run(command),
        Command::Truth(options) => truth::run(options),
    })
}

/// Runs a program of the laboratory by its command line and prints how it ended; returns an exit status as [`run`]
/// does. `command` makes the parser of the command line, with the help that the arguments ask for, and `run` does what
/// the parsed arguments say.
pub fn run_program<P: FromArgMatches>(
    command: impl Fn(&[OsString]) -> clap::Command,
    run: impl FnOnce(&P) -> anyhow::Result<()>,
) -> ExitCode {
    warn_of_little_memory();
    // Methods from folders add flags of their own, so the folders are read before the command line is parsed. A folder
    // that another program takes should be one that `ssct` takes, so that the options of `ssct` count everywhere.
    let commands = || vec![help::command(&[]), command(&[])];
    let arguments = match custom_methods::add_folders(std::env::args_os(), commands) {
        Ok(arguments) => arguments,
        Err(error) => {
            eprintln!("ssct: {}", printable(&error.to_string()));
            return ExitCode::from(exit_status(&error));
        }
    };
    let mut command = numbers::with_number_parsers(command(&arguments));
    let matches = command.try_get_matches_from_mut(arguments);
    let options = match matches.and_then(|matches| P::from_arg_matches(&matches).map_err(|e| e.format(&mut command))) {
        Ok(options) => options,
        Err(e) => {
            let status = u8::try_from(e.exit_code()).unwrap_or(2);
            // Printing a help that was asked for may fail, as on a full disk; a closed pipe is no failure.
            return match e.print().and_then(|()| std::io::stdout().flush()) {
                Err(failed) if failed.kind() != std::io::ErrorKind::BrokenPipe && !e.use_stderr() => {
                    report_end(Err(failed.into()))
                }
                _ => ExitCode::from(status),
            };
        }
    };
    name_shader_folder();
    // Flushing the rest of the buffer may fail, as on a full disk.
    let flush = || Ok(std::io::stdout().flush()?);
    report_end(start_logging().map_err(Into::into).and_then(|()| run(&options)).and_then(|()| flush()))
}

/// Memory in MiB that sufficed for every command that was tried; the driver of a CPU takes most of it.
const ENOUGH_MIB: u64 = 1024;

/// Warns on standard error if the system lets this process take less than [`ENOUGH_MIB`] MiB of memory. In that case an
/// allocation may fail, which aborts the process without a message. A handler gives such an abort the exit status 1.
#[cfg(unix)]
fn warn_of_little_memory() {
    let Some(mib) = memory_limit().map(|limit| limit >> 20).filter(|mib| *mib < ENOUGH_MIB) else { return };
    eprintln!("ssct: memory is short, as this process may take {mib} MiB (ulimit -v)");
    // The handler ends the process only while this flag is true. Without the handler, the exit status would be the
    // signal's.
    let always = std::sync::Arc::new(true.into());
    drop(signal_hook::flag::register_conditional_shutdown(signal_hook::consts::SIGABRT, 1, always));
}

/// Does nothing, since such a limit is known on Unix alone.
#[cfg(not(unix))]
fn warn_of_little_memory() {}

/// Says on standard error that shaders come from another folder, if an environment variable names one.
fn name_shader_folder() {
    if let Some(folder) = sources::named_folder() {
        let folder = printable(&folder.display().to_string());
        eprintln!("ssct: shaders are compiled from {folder}, which {} names", sources::VARIABLE);
    }
}

/// Begins to print log messages on standard error: those that the variable SSCT_LOG asks for, as in `vulkan=warn`. Without
/// the variable, only errors are printed.
fn start_logging() -> Result<(), Error> {
    let usage = |text: &str, e: ParseError| Error::usage(format!("SSCT_LOG={text}: {e}; write it as vulkan=warn"));
    let targets = match std::env::var("SSCT_LOG") {
        Ok(text) if !text.is_empty() => text.parse().map_err(|e| usage(&text, e))?,
        _ => Targets::new().with_default(LevelFilter::ERROR),
    };
    let printed = tracing_subscriber::fmt::layer().with_writer(std::io::stderr).with_filter(targets);
    tracing_subscriber::registry().with(printed).init();
    Ok(())
}

/// Prints why a run failed, if it did, and returns the exit status.
fn report_end(outcome: anyhow::Result<()>) -> ExitCode {
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) if is_closed_pipe(&e) => ExitCode::SUCCESS,
        // The sentence of an error of our own names the cause; for any other error, `{e:#}` appends the causes.
        Err(e) => match laboratory_error(e) {
            Ok(error) => {
                eprintln!("ssct: {}{}", printable(&error.to_string()), advice(&error));
                ExitCode::from(exit_status(&error))
            }
            Err(e) => {
                if e.is::<std::io::Error>() {
                    eprintln!("ssct: cannot print: {e}");
                } else {
                    eprintln!("ssct: {}", printable(&format!("{e:#}")));
                }
                ExitCode::FAILURE
            }
        },
    }
}

/// Turns an error of any of our packages into an error of the laboratory. The error of another package comes back
/// unchanged, as `Err`.
fn laboratory_error(error: anyhow::Error) -> anyhow::Result<Error> {
    error
        .downcast()
        .or_else(|e| e.downcast::<ssct::Error>().map(Error::from))
        .or_else(|e| e.downcast::<ssct_ground::Error>().map(Error::from))
}

/// Returns a sentence on one line, without the control characters that a file's name may contain and a terminal would
/// obey.
fn printable(sentence: &str) -> String {
    one_line(sentence).into_owned()
}

/// The exit status: 2 for wrong arguments, 128 + n for signal n, else 1.
fn exit_status(error: &Error) -> u8 {
    match error {
        Error::Ssct(ssct::Error::Usage(_)) | Error::Unfinished { .. } => 2,
        Error::Stopped { signal, .. } => 128 + signal,
        _ => 1,
    }
}

/// Returns what the user can do next, as the end of an error's sentence; empty where there is no advice.
fn advice(error: &Error) -> String {
    match error {
        Error::Stopped { kept: Some(_), .. } => ", and --resume goes on with it".to_owned(),
        Error::Unfinished { journal, .. } => {
            format!(": --resume goes on with it; to begin anew, take another folder or remove {}", journal.display())
        }
        _ => String::new(),
    }
}

/// True if the reader of our output closed the pipe, which is no failure of ours.
fn is_closed_pipe(e: &anyhow::Error) -> bool {
    e.downcast_ref::<std::io::Error>().is_some_and(|e| e.kind() == std::io::ErrorKind::BrokenPipe)
}

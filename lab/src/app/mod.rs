//! The command: arguments, headless runs, exit status. The only place that prints.

mod age;
mod captures;
mod cli;
mod command;
mod compare;
mod custom_methods;
mod devices;
mod drivers;
mod error;
mod error_cells;
mod error_options;
mod figures;
mod gbuffer;
mod gpu_study;
mod headings;
mod help;
mod index;
mod merge;
mod motion;
mod parameters;
mod path;
mod plan;
mod precision;
mod progress;
mod reference;
mod reference_part;
mod render;
mod resolve;
mod run;
mod stress;
mod study;
mod time;
mod time_captions;
mod time_output;
mod truth;
mod video;
#[cfg(feature = "window")]
mod view;
#[cfg(not(feature = "window"))]
#[path = "no_view.rs"]
mod view;

use crate::error::Error;
use clap::FromArgMatches;
use command::{Cli, Command};
use std::io::Write;
use std::process::ExitCode;

/// Runs the command line; returns the exit status: 0 done, 1 the run failed or a bar was missed,
/// 2 the arguments are wrong.
pub fn run() -> ExitCode {
    // Methods from folders have flags of their own, so that they are known before the command line is read.
    let arguments = match custom_methods::added(std::env::args_os()) {
        Ok(arguments) => arguments,
        Err(error) => {
            eprintln!("ssct: {}", printable(&error.to_string()));
            return ExitCode::from(exit_status(&error));
        }
    };
    let mut command = help::command(&arguments);
    let matches = command.try_get_matches_from_mut(arguments);
    let cli = match matches.and_then(|matches| Cli::from_arg_matches(&matches).map_err(|e| e.format(&mut command))) {
        Ok(cli) => cli,
        Err(e) => {
            let status = u8::try_from(e.exit_code()).unwrap_or(2);
            // Printing to a closed pipe may fail, and there is nobody left to tell.
            let _ = e.print();
            return ExitCode::from(status);
        }
    };
    tracing_subscriber::fmt()
        .with_env_filter(tracing_subscriber::EnvFilter::from_env("SSCT_LOG"))
        .with_writer(std::io::stderr)
        .init();
    let done = match &cli.command {
        Command::Render(options) => render::run(options),
        Command::Study(options) => study::run(options),
        Command::View(options) => view::run(options),
        Command::Time(options) => time::run(options),
        Command::Error(options) => error::run(options),
        Command::Precision(options) => precision::run(options),
        Command::Age(options) => age::run(options),
        Command::Video(options) => video::run(options),
        Command::Motion(options) => motion::run(options),
        Command::Stress(options) => stress::run(options),
        Command::Path(options) => path::run(options),
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
    };
    // What is still to be printed may find no room, as what is printed.
    let done = done.and_then(|()| Ok(std::io::stdout().flush()?));
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) if is_closed_pipe(&e) => ExitCode::SUCCESS,
        Err(e) => {
            // Our own errors name their cause in their sentence; others have it behind them.
            match e.downcast_ref::<Error>() {
                Some(own) => eprintln!("ssct: {}{}", printable(&own.to_string()), advice(own)),
                None if e.is::<std::io::Error>() => eprintln!("ssct: cannot print: {e}"),
                None => eprintln!("ssct: {e:#}"),
            }
            ExitCode::from(e.downcast_ref::<Error>().map_or(1, exit_status))
        }
    }
}

/// A sentence without the control characters that a name of a file may bring, which a terminal would obey.
fn printable(sentence: &str) -> String {
    sentence.chars().map(|c| if c.is_control() && c != '\n' { '\u{fffd}' } else { c }).collect()
}

/// The exit status for an error of the library: 2 for wrong arguments, 128 + n for signal n, else 1.
fn exit_status(error: &Error) -> u8 {
    match error {
        Error::Usage(_) | Error::Unfinished { .. } => 2,
        Error::Stopped { signal, .. } => 128 + signal,
        _ => 1,
    }
}

/// Which flags help after an error, as the end of its sentence.
fn advice(error: &Error) -> String {
    match error {
        Error::Stopped { kept: Some(_), .. } => ", and --resume goes on with it".to_owned(),
        Error::Unfinished { journal, .. } => {
            format!(": --resume goes on with it; to begin anew, take another folder or remove {}", journal.display())
        }
        _ => String::new(),
    }
}

/// The reader of our output went away: not our failure.
fn is_closed_pipe(e: &anyhow::Error) -> bool {
    e.downcast_ref::<std::io::Error>().is_some_and(|e| e.kind() == std::io::ErrorKind::BrokenPipe)
}

//! `ssct view`: starts the window, which is another program, so that users who only render and measure need not build it.

use crate::error::Error;
use clap::Args;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The window's program, which is looked for beside this one and then on the PATH.
const PROGRAM: &str = "ssct-view";

/// Options of `ssct view`, which are handed on.
#[derive(Debug, Args)]
#[command(disable_help_flag = true, disable_version_flag = true)]
pub struct ViewArguments {
    #[arg(hide = true, trailing_var_arg = true, allow_hyphen_values = true)]
    arguments: Vec<OsString>,
}

/// Runs the window's program in place of this one. Returns only if that program cannot be run.
pub fn run(options: &ViewArguments) -> anyhow::Result<()> {
    let program = find_window_program(std::env::current_exe().ok().as_deref());
    let mut command = Command::new(program.unwrap_or_else(|| PROGRAM.into()));
    let error = replace(command.args(&options.arguments));
    let why = if error.kind() == std::io::ErrorKind::NotFound {
        format!("its program {PROGRAM} is neither beside ssct nor on the PATH; `make view` builds it")
    } else {
        format!("its program {PROGRAM} cannot be started: {error}")
    };
    Err(Error::NoWindow(why).into())
}

/// Returns the path of the window's program if it lies in the same folder as this program, whose path is
/// `this_program`.
fn find_window_program(this_program: Option<&Path>) -> Option<PathBuf> {
    let program = this_program?.with_file_name(PROGRAM).with_extension(std::env::consts::EXE_EXTENSION);
    program.is_file().then_some(program)
}

/// Replaces this process by another program, so that the program has the terminal and the signals, and its exit status
/// is that of this process. Returns the error if the program cannot be run.
#[cfg(unix)]
fn replace(command: &mut Command) -> std::io::Error {
    std::os::unix::process::CommandExt::exec(command)
}

/// Runs another program to its end, and exits with its status. Returns the error if the program cannot be run.
#[cfg(not(unix))]
fn replace(command: &mut Command) -> std::io::Error {
    match command.status() {
        Ok(status) => std::process::exit(status.code().unwrap_or(1)),
        Err(error) => error,
    }
}

//! The help of the command line: which commands belong together, what the short help of a command shows (`-h`), and
//! under which heading the long help (`--help`) shows each option.

use super::command::Cli;
use super::headings::{DEVICE, MEASUREMENT, METHOD, OUTPUT, SCENE, WINDOW};
use super::studies::StudyCommand;
use clap::builder::Resettable;
use clap::{Arg, ArgAction, Command, CommandFactory, Subcommand};
use std::ffi::OsString;

/// The title of the group in which the studies are.
const MEASURE: &str = "Measure";

/// The commands in groups, each with its title; the studies, which have a table of their own, are not named here.
const GROUPS: [(&str, &[&str]); 5] = [
    ("Start here", &["render", "study", "view"]),
    // The studies come before these commands, in the order of their table.
    (MEASURE, &["gpu-study"]),
    ("Compare", &["compare", "merge", "index"]),
    ("Look", &["figures", "captures", "devices", "drivers"]),
    ("Exchange", &["gbuffer", "truth"]),
];

/// The options of each heading, in the order in which the long help shows headings and options. The parameters of methods
/// bring their heading along.
const HEADINGS: [(&str, &[&str]); 6] = [
    (
        SCENE,
        &[
            "scene",
            "triangles",
            "view",
            "time",
            "motion",
            "size",
            "roughness",
            "reflectivity",
            "normal_deviation",
            "eye",
            "look_at",
            "fov",
            "orthographic_height",
            "near",
            "far",
            "scale",
            "texture_size",
        ],
    ),
    (METHOD, &["method", "include", "variant", "preset"]),
    (
        MEASUREMENT,
        &[
            "quick",
            "full",
            "samples",
            "warmup",
            "rays",
            "way",
            "path",
            "frames",
            "fps",
            "play",
            "moving",
            "step",
            "step_frames",
            "held",
            "jitter",
            "faces",
            "captures",
            "capture_side",
            "complaints",
            "case",
            "only",
            "table",
            "reference_rays",
            "a_a",
            "no_sweep",
            "captures_sweep",
            "fallback_sweep",
            "bounces_sweep",
            "beside",
            "base",
            "a",
            "b",
            "all",
            "threshold",
            "fail_on_slower",
            "partial",
            "standard_error",
            "max_rays",
            "diffuse_bounces",
            "cache",
            "seed",
            "shard",
        ],
    ),
    // The window names the headings of its own options.
    (WINDOW, &[]),
    (
        OUTPUT,
        &[
            "output",
            "json",
            "pixel",
            "explain",
            "figure",
            "dump",
            "reflection_only",
            "trace",
            "write",
            "map",
            "gbuffer_map",
            "resume",
        ],
    ),
    (DEVICE, &["device", "validation", "help", "version"]),
];

/// The options that the short help of a command with many options shows, in this order: first those that most people
/// look for, then those that only some commands have. Required options that are not listed here are shown behind them.
const SHORT: [&str; 26] = [
    "scene",
    "view",
    "method",
    "size",
    "roughness",
    "output",
    "quick",
    "eye",
    "preset",
    "fallback",
    "captures",
    "variant",
    "samples",
    "rays",
    "way",
    "path",
    "frames",
    "moving",
    "step",
    "faces",
    "table",
    "figure",
    "explain",
    "pixel",
    "dump",
    "a_a",
];

/// The options that every short help shows last.
const SHORT_LAST: [&str; 5] = ["json", "resume", "shard", "device", "help"];

/// The number of options up to which the short help of a command shows all of them.
const FEW: usize = 16;

/// The greatest width in characters of an option with its value in the short help. With more, clap would put the help into the next line of
/// a terminal with 80 columns.
const SHORT_WIDTH: usize = 16;

/// The command line, arranged for the help that the arguments ask for.
pub fn command(arguments: &[OsString]) -> Command {
    arranged_command(asks_for_summary(arguments))
}

/// The command line of a program that is a command by itself, arranged as a command of `ssct` is.
pub fn single_command<P: CommandFactory>(arguments: &[OsString]) -> Command {
    let command = P::command();
    let name = command.get_name().to_owned();
    arrange(command, &name, asks_for_summary(arguments))
}

/// True if the arguments ask for the short help, by `-h`.
fn asks_for_summary(arguments: &[OsString]) -> bool {
    arguments.iter().any(|argument| argument == "-h")
}

/// The command line: the overview is its help, and each command is arranged for the short or for the long help.
fn arranged_command(is_short: bool) -> Command {
    let command = Cli::command();
    // A command that hands its arguments on to another program leaves the help to that program, too.
    let has_help = |c: &&Command| !c.is_disable_help_flag_set();
    let names: Vec<String> = command.get_subcommands().filter(has_help).map(|c| c.get_name().to_owned()).collect();
    let overview = overview(&command);
    let [help, version] = help_options();
    let help = help.help("Print this");
    let mut command = with_help(command.help_template(overview), [help, version]);
    for name in &names {
        command = command.mut_subcommand(name, |c| arrange(c, &format!("ssct {name}"), is_short));
    }
    command
}

/// Returns the groups of commands: the title of each, and the names of its commands. The studies come first in the
/// group [`MEASURE`].
fn groups() -> Vec<(&'static str, Vec<String>)> {
    let studies = StudyCommand::augment_subcommands(Command::new(""));
    let studies: Vec<String> = studies.get_subcommands().map(|c| c.get_name().to_owned()).collect();
    let group = |(title, names): (&'static str, &[&str])| {
        let listed = names.iter().map(|name| (*name).to_owned());
        (title, studies.iter().filter(|_| title == MEASURE).cloned().chain(listed).collect())
    };
    GROUPS.into_iter().map(group).collect()
}

/// The help of the program: its commands in groups.
fn overview(command: &Command) -> String {
    let about = |name: &str| command.find_subcommand(name).and_then(Command::get_about).map(ToString::to_string);
    let mut text = "{about-with-newline}\n{usage-heading} {usage}\n".to_owned();
    for (title, names) in groups() {
        text += &format!("\n{title}:\n");
        text.extend(names.iter().map(|name| format!("  {name:<9}  {}\n", about(name).unwrap_or_default())));
    }
    text + "\nThe options of a command: ssct COMMAND -h, and all of them: ssct COMMAND --help.\n\nOptions:\n{options}"
}

/// Arranges a command and its subcommands for the short or for the long help. `path` is what a user types before the
/// options, such as `ssct gbuffer export`; the short help names it.
fn arrange(command: Command, path: &str, is_short: bool) -> Command {
    let nested: Vec<String> = command.get_subcommands().map(|c| c.get_name().to_owned()).collect();
    let command = nested.iter().fold(command, |command, name| {
        command.mut_subcommand(name, |c| arrange(c, &format!("{path} {name}"), is_short))
    });
    let [help, version] = help_options();
    let help = help.help("Print this summary; --help prints everything").long_help("Print this; -h prints a summary");
    let command = with_help(command, [help, version]);
    if is_short && nested.is_empty() { arrange_short(command, path) } else { arrange_long(command) }
}

/// The options `--help` and `--version`, which take the place of clap's own.
fn help_options() -> [Arg; 2] {
    let help = Arg::new("help").short('h').long("help").action(ArgAction::Help);
    let version = Arg::new("version").short('V').long("version").action(ArgAction::Version);
    [help, version.help("Print the version of the program")]
}

/// Replaces the two options that clap adds by `options`, which can stand under a heading.
fn with_help(command: Command, options: [Arg; 2]) -> Command {
    command.disable_help_flag(true).disable_version_flag(true).args(options)
}

/// The index of an option in a list; the length of the list if the option is not in it.
fn index_in(list: &[&str], argument: &Arg) -> usize {
    list.iter().position(|id| *id == argument.get_id().as_str()).unwrap_or(list.len())
}

/// Arranges a command for the short help: only the options of this help are shown, each in one line, and the last line says where the
/// others are.
fn arrange_short(command: Command, path: &str) -> Command {
    let options = || command.get_arguments().filter(|a| !a.is_positional());
    let count = options().count();
    let has_few = count <= FEW;
    // An option of `SHORT` has its index there as its place, and one of `SHORT_LAST` a place behind them. An option in
    // neither list has the place SHORT.len(), by which it is known below.
    let order = |a: &Arg| match index_in(&SHORT_LAST, a) {
        index if index < SHORT_LAST.len() => SHORT.len() + 1 + index,
        _ => index_in(&SHORT, a),
    };
    let is_shown = |a: &Arg| has_few || a.is_required_set() || order(a) != SHORT.len();
    let shown = options().filter(|a| is_shown(a)).count();
    let more = match count - shown {
        0 => format!("More about them: {path} --help"),
        hidden => format!("{hidden} more options, under headings: {path} --help"),
    };
    let command = command.mut_args(|a| {
        if a.is_positional() {
            return a;
        }
        let (is_hidden, order) = (!is_shown(&a), order(&a));
        let a = narrow(a).help_heading(Resettable::Reset).display_order(order).hide(is_hidden);
        // A column of this width has no room for the values that an option takes; the long help has them.
        if a.get_action().takes_values() { a.hide_possible_values(true) } else { a }
    });
    command.after_help(more)
}

/// Makes an option fit into the column of the short help: if the option is too wide, the name of its value is cut to
/// its first word.
fn narrow(argument: Arg) -> Arg {
    let name = argument.get_value_names().and_then(|names| names.first()).map(ToString::to_string);
    let width = |value: &str| "-- <>".len() + argument.get_long().map_or(0, str::len) + value.chars().count();
    match name {
        Some(name) if width(&name) > SHORT_WIDTH => {
            let first_word = name.split(['|', ' ']).next().unwrap_or_default().to_owned();
            argument.value_name(first_word)
        }
        _ => argument,
    }
}

/// Arranges a command for the long help: puts every option under its heading, and headings and options in the order of
/// [`HEADINGS`].
fn arrange_long(command: Command) -> Command {
    let find_heading = |argument: &Arg| {
        let lists_option = |(_, ids): &&(&str, &[&str])| index_in(ids, argument) < ids.len();
        let own_heading = argument.get_help_heading().map(str::to_owned);
        own_heading.or_else(|| HEADINGS.iter().find(lists_option).map(|(heading, _)| (*heading).to_owned()))
    };
    let mut sorted: Vec<Arg> = command.get_arguments().cloned().collect();
    for argument in sorted.iter_mut().filter(|a| !a.is_positional()) {
        if let Some(heading) = find_heading(argument) {
            *argument = argument.clone().help_heading(heading);
        }
    }
    // The index of an option's heading, and the index of the option under it.
    let rank = |argument: &Arg| {
        let heading = argument.get_help_heading()?;
        let heading_index = HEADINGS.iter().position(|(known, _)| *known == heading).unwrap_or(HEADINGS.len());
        let option_index = HEADINGS.get(heading_index).map_or(0, |(_, ids)| index_in(ids, argument));
        Some((heading_index, option_index))
    };
    // Positional arguments, which have no heading, come first. Parameters of methods, whose headings `HEADINGS` lacks,
    // come last. Both keep their order.
    sorted.sort_by_key(rank);
    let mut sorted = sorted.into_iter().enumerate().map(|(n, a)| a.display_order(n));
    // clap calls the closure once for each argument, so that `sorted` never runs out.
    command.mut_args(|argument| sorted.next().unwrap_or(argument))
}

#[cfg(test)]
mod tests;

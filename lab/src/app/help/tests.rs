use super::*;
use ssct::methods;
use ssct_ground::parameter::Parameters;
use ssct_scenes::library;

/// Columns of a terminal, which no line of any help may exceed.
const COLUMNS: usize = 80;
/// Lines of such a terminal.
const LINES: usize = 45;

/// Returns every command without subcommands, with its path. `view` is left out, since another program has its options
/// and help.
fn leaves(command: &Command) -> Vec<(String, Command)> {
    let mut found = Vec::new();
    for sub in command.get_subcommands().filter(|c| !["help", "view"].contains(&c.get_name())) {
        let nested: Vec<_> =
            leaves(sub).into_iter().map(|(path, c)| (format!("{} {path}", sub.get_name()), c)).collect();
        if nested.is_empty() { found.push((sub.get_name().to_owned(), sub.clone())) } else { found.extend(nested) }
    }
    found
}

/// Returns every command without subcommands, with its path, arranged for the short or for the long help.
fn arranged_leaves(is_short: bool) -> Vec<(String, Command)> {
    let mut command = arranged_command(is_short).term_width(COLUMNS);
    command.build();
    leaves(&command)
}

/// Fails if a text has more lines or columns than the terminal.
fn assert_fits(text: &str, what: &str) {
    assert!(text.lines().count() <= LINES, "{what} has {} lines:\n{text}", text.lines().count());
    for line in text.lines() {
        assert!(line.chars().count() <= COLUMNS, "{what}: {line:?} has {} columns", line.chars().count());
    }
}

/// Returns the names of the options that a help text has, in their order there.
fn options(text: &str) -> Vec<&str> {
    let lines = text.lines().filter(|line| line.starts_with("      --") || line.starts_with("  -"));
    lines.filter_map(|line| line.split_once("--")?.1.split([' ', '[']).next()).collect()
}

#[test]
fn every_command_is_in_one_group() {
    let command = Cli::command();
    let grouped = groups();
    let mut grouped: Vec<&str> = grouped.iter().flat_map(|(_, names)| names.iter().map(String::as_str)).collect();
    let mut names: Vec<&str> = command.get_subcommands().map(Command::get_name).collect();
    grouped.sort_unstable();
    names.sort_unstable();
    assert_eq!(grouped, names);
    let mut command = arranged_command(false).term_width(COLUMNS);
    let text = command.render_long_help().to_string();
    assert_fits(&text, "ssct --help");
    let titles: Vec<_> = GROUPS.iter().map(|(title, _)| text.find(&format!("\n{title}:\n")).expect(title)).collect();
    assert!(titles.is_sorted(), "{text}");
}

#[test]
fn the_short_help_fits_a_screen_with_the_common_options_first() {
    const COMMON: [&str; 6] = ["scene", "view", "method", "size", "roughness", "output"];
    for (path, mut command) in arranged_leaves(true) {
        let has = |id: &&str| command.get_arguments().any(|a| a.get_id() == *id && !a.is_positional());
        let common: Vec<_> = COMMON.into_iter().filter(|id| has(id)).collect();
        let text = command.render_help().to_string();
        assert_fits(&text, &path);
        assert_eq!(options(&text)[..common.len()], common, "{path}:\n{text}");
        let shown = command.get_arguments().filter(|a| !a.is_positional() && !a.is_hide_set()).count();
        let (_, options_text) = text.split_once("\nOptions:\n").expect("options");
        let lines = options_text.lines().take_while(|line| !line.is_empty()).count();
        assert_eq!(lines, shown, "{path}: an option is one line:\n{text}");
        assert!(text.trim_end().ends_with(&format!("ssct {path} --help")), "{path} says where the rest is:\n{text}");
    }
}

#[test]
fn the_long_help_has_every_option_under_its_heading() {
    // A parameter of the effect is under the heading of methods, and any other under one that names its methods.
    let effect_parameters = methods::EffectParams::table();
    for (path, mut command) in arranged_leaves(false) {
        let text = command.render_long_help().to_string();
        let runs_methods = command.get_arguments().any(|a| a.get_id() == "preset");
        let headings: Vec<&str> = HEADINGS.iter().map(|(heading, _)| *heading).collect();
        let mut found: Vec<&str> = Vec::new();
        for argument in command.get_arguments().filter(|a| !a.is_positional()) {
            let heading = argument.get_help_heading().unwrap_or_else(|| panic!("{path}: {argument} has no heading"));
            if found.last() != Some(&heading) && !found.contains(&heading) {
                found.push(heading);
            }
            let is_known = headings.contains(&heading) || heading.starts_with("Parameters of ");
            assert!(is_known, "{path}: {argument} is under {heading:?}");
            let Some((parameter, readers)) =
                methods::parameters().into_iter().find(|(p, _)| p.typed_name() == argument.get_id().as_str())
            else {
                continue;
            };
            if !runs_methods {
                continue;
            }
            if effect_parameters.iter().any(|p| p.name == parameter.name) {
                assert_eq!(heading, METHOD, "{path}: {argument}");
            } else {
                let names: Vec<_> = heading.trim_start_matches("Parameters of ").split(", ").collect();
                assert!(readers.iter().all(|m| names.contains(&m.name)), "{path}: {argument} is under {heading:?}");
            }
        }
        let rank = |heading: &&&str| headings.iter().position(|known| known == *heading).unwrap_or(headings.len());
        assert!(found.iter().map(|h| rank(&h)).is_sorted(), "{path}: {found:?}");
        let places: Vec<_> = found.iter().map(|h| text.find(&format!("\n{h}:\n")).expect(h)).collect();
        assert!(places.is_sorted(), "{path}: headings are printed in their order: {found:?}");
    }
}

#[test]
fn every_list_of_the_built_in_scenes_has_all_of_them() {
    let mut commands = Vec::new();
    for (path, command) in arranged_leaves(false) {
        let helps = command.get_arguments().filter_map(|a| Some(a.get_long_help()?.to_string()));
        for list in helps.filter(|help| help.contains("built-in scenes are")) {
            let missing: Vec<_> = library::every_name().filter(|name| !list.contains(name)).collect();
            assert!(missing.is_empty(), "{path} lacks {missing:?}: {list}");
            commands.push(path.clone());
        }
    }
    assert!(["captures", "render"].iter().all(|name| commands.iter().any(|path| path == name)), "{commands:?}");
}

#[test]
fn no_list_names_an_option_that_no_command_has() {
    let command = Cli::command();
    let has = |id: &str| {
        ["help", "version"].contains(&id)
            || leaves(&command).iter().any(|(_, c)| c.get_arguments().any(|a| a.get_id().as_str() == id))
    };
    let listed = HEADINGS.iter().flat_map(|(_, ids)| ids.iter()).chain(&SHORT).chain(&SHORT_LAST);
    let unknown: Vec<_> = listed.filter(|id| !has(id)).collect();
    assert!(unknown.is_empty(), "{unknown:?}");
}

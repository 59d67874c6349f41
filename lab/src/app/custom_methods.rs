//! Methods from folders on the command line: `--method path/to/folder` adds the method, and stands for its name.

use super::parameters::PRESET;
use crate::custom;
use crate::error::{Error, Result};
use clap::Command;
use std::cell::LazyCell;
use std::collections::{BTreeSet, HashMap};
use std::ffi::OsString;
use std::ops::Deref;
use std::path::PathBuf;

/// A flag whose value names methods, several with commas between them.
const METHOD: &str = "--method";
/// Another flag whose value names methods.
const AGAINST: &str = "--against";
/// The flag whose value is a method with flags of its own.
const VARIANT: &str = "--variant";
/// The flags whose value is one method, followed by flags of this method.
const VARIANTS: [&str; 3] = [VARIANT, "--a", "--b"];
/// The flag whose value is a folder that shaders of methods may include from.
const INCLUDE: &str = "--include";

/// Prints a sentence and ends the program at once: while the device never finishes its work, nothing can be freed.
fn give_up(sentence: &str) {
    eprintln!("ssct: {sentence}");
    signal_hook::low_level::exit(1);
}

/// Adds the methods of all folders that arguments name. Returns the arguments, in which the names of these methods
/// stand in place of the folders. `commands` makes command lines; no parameter of a folder may have the
/// name of one of their options.
pub fn add_folders(
    arguments: impl Iterator<Item = OsString>,
    commands: impl FnOnce() -> Vec<Command>,
) -> Result<Vec<OsString>> {
    custom::give_up_by(give_up);
    let arguments: Vec<OsString> = arguments.collect();
    custom::allow_includes(include_folders(&arguments));
    // Most command lines name no folder and need no reserved names. The names are those before any folder is added,
    // since parameters of two folders may share an option.
    let reserved = LazyCell::new(|| reserved_names(&commands()));
    let mut added = HashMap::new();
    let mut replaced = Vec::new();
    // The last argument, if it is a flag that names methods; then the next argument is the value of this flag.
    let mut open_flag: Option<&str> = None;
    for argument in arguments {
        let Some(text) = argument.to_str() else {
            replaced.push(argument);
            open_flag = None;
            continue;
        };
        if let Some(option) = open_flag.take() {
            replaced.push(replace_folders(option, text, &reserved, &mut added)?.into());
            continue;
        }
        match text.split_once('=') {
            Some((option, value)) if method_flags().any(|flag| flag == option) => {
                let value = replace_folders(option, value, &reserved, &mut added)?;
                replaced.push(format!("{option}={value}").into());
            }
            _ => {
                open_flag = method_flags().find(|flag| *flag == text);
                replaced.push(argument);
            }
        }
    }
    Ok(replaced)
}

/// Returns the names that parameters of folders cannot have: the names of all options of some commands, except the
/// parameters of built-in methods, with which a parameter may share an option.
fn reserved_names(commands: &[Command]) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    commands.iter().for_each(|command| add_option_names(command, &mut names));
    for (parameter, _) in ssct::methods::parameters() {
        names.remove(&parameter.typed_name());
    }
    names
}

/// Adds the names of the options of a command and of its subcommands.
fn add_option_names(command: &Command, names: &mut BTreeSet<String>) {
    // Every command that takes parameters of methods has the option of the preset.
    let takes_parameters = command.get_arguments().any(|a| a.get_id() == PRESET);
    for argument in command.get_arguments() {
        names.extend(argument.get_long().map(str::to_owned));
        names.extend(argument.get_all_aliases().into_iter().flatten().map(str::to_owned));
        // Beside parameters, an argument without an option, such as a file, must not have the id of a parameter either.
        if takes_parameters {
            names.insert(argument.get_id().to_string());
        }
    }
    command.get_subcommands().for_each(|subcommand| add_option_names(subcommand, names));
}

/// Every flag whose value names methods.
fn method_flags() -> impl Iterator<Item = &'static str> {
    [METHOD, AGAINST].into_iter().chain(VARIANTS)
}

/// The folders from which the arguments let shaders include files.
fn include_folders(arguments: &[OsString]) -> Vec<PathBuf> {
    let is_flag = |argument: &OsString| argument == INCLUDE;
    let after_blank = arguments.windows(2).filter(|pair| is_flag(&pair[0])).map(|pair| PathBuf::from(&pair[1]));
    let after_equals =
        |argument: &OsString| Some(PathBuf::from(argument.to_str()?.strip_prefix(INCLUDE)?.strip_prefix('=')?));
    after_blank.chain(arguments.iter().filter_map(after_equals)).collect()
}

/// Returns the value of a flag with the names of methods in place of their folders, whose methods are added. `added`
/// has the folders that were added before, each with the name of its method. `reserved` has the names that no
/// parameter may have; they are made when they are first needed.
fn replace_folders(
    flag: &str,
    value: &str,
    reserved: &impl Deref<Target = BTreeSet<String>>,
    added: &mut HashMap<PathBuf, &'static str>,
) -> Result<String> {
    // The name of the method that a word of the value names itself or by its folder.
    let mut method_name = |text: &str| -> Result<String> {
        let Some(folder) = custom::folder(text) else { return Ok(text.to_owned()) };
        // A folder is added once, even if two arguments write its path differently.
        let canonical = folder.canonicalize().unwrap_or_else(|_| folder.clone());
        if let Some(name) = added.get(&canonical) {
            return Ok((*name).to_owned());
        }
        let info = custom::add(&folder, reserved)?;
        added.insert(canonical, info.name);
        Ok(info.name.to_owned())
    };
    if VARIANTS.contains(&flag) {
        let (method, flags) = split_variant(value);
        let is_include = |word: &str| word.split('=').next() == Some(INCLUDE);
        if flag == VARIANT && flags.split_whitespace().any(is_include) {
            let message = format!("{VARIANT} {value:?}: {INCLUDE} stands outside the quotes, for all methods");
            return Err(Error::usage(message));
        }
        return Ok(format!("{} {flags}", method_name(method)?).trim_end().to_owned());
    }
    let names: Vec<String> = value.split(',').map(method_name).collect::<Result<_>>()?;
    Ok(names.join(","))
}

/// Splits a variant into its method and its flags. A method that begins with a quotation mark, ' or ", ends with the
/// next one, so that the path of a folder may have blanks.
fn split_variant(value: &str) -> (&str, &str) {
    let value = value.trim_start();
    let quoted = ['\'', '"'].into_iter().find_map(|mark| value.strip_prefix(mark)?.split_once(mark));
    let (method, flags) = quoted.or_else(|| value.split_once(char::is_whitespace)).unwrap_or((value, ""));
    (method, flags.trim_start())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_variant_is_a_method_perhaps_in_quotes_and_its_flags() {
        for (value, method, flags) in [
            ("ssct", "ssct", ""),
            ("  ssct  --fade off", "ssct", "--fade off"),
            ("'my methods/m' --fade off", "my methods/m", "--fade off"),
            ("\"it's mine/m\"", "it's mine/m", ""),
            ("it's/m --fade off", "it's/m", "--fade off"),
            ("'m --fade off", "'m", "--fade off"),
        ] {
            assert_eq!(split_variant(value), (method, flags), "{value}");
        }
    }

    #[test]
    fn a_variant_with_folders_for_its_shaders_is_refused() {
        let replace = |value: &str| replace_folders(VARIANT, value, &Box::new(BTreeSet::new()), &mut HashMap::new());
        for value in ["ssct --include parts", "ssct --fade off --include=parts"] {
            let message = replace(value).expect_err(value).to_string();
            assert!(message.contains("--include stands outside the quotes"), "{message}");
        }
        assert_eq!(replace("'ssct'  --fade off").expect("a variant"), "ssct --fade off");
    }
}

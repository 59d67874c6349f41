//! Parameters on the command line: the flags of methods, made from the methods' tables.

use super::headings::METHOD;
use crate::study::error::Variant;
use clap::builder::{PossibleValue, PossibleValuesParser, StringValueParser, TypedValueParser, ValueParser};
use clap::{Arg, ArgMatches, Args, Command, FromArgMatches};
use ssct::methods::exclusions::EXCLUSIONS;
use ssct::methods::{self, EffectParams, Setup};
use ssct_ground::parameter::{Choices, Domain, Parameter, Parameters, Preset, Values};
use std::path::PathBuf;

/// How methods run: the values of the flags that were given.
#[derive(Debug, Clone, Default)]
pub struct MethodOptions {
    /// The values, by the names of parameters.
    pub values: Values,
}

/// The flag of the preset.
pub(super) const PRESET: &str = "preset";

impl MethodOptions {
    /// The setup of methods at a size in pixels.
    pub fn setup(&self, extent: [u32; 2]) -> Setup {
        Setup { values: self.values.clone(), ..Setup::new(extent) }
    }

    /// Makes options from pairs: the name of a flag, and its value as it is typed.
    ///
    /// # Errors
    /// A sentence for a name that no method has, and for a value that its parameter does not take.
    pub fn from_typed<'t>(typed: impl Iterator<Item = (&'t str, &'t str)>) -> crate::error::Result<Self> {
        let usage = crate::error::Error::usage;
        let parameters = methods::parameters();
        let mut values = Values::default();
        for (name, text) in typed {
            if name == PRESET {
                let unknown = || usage(format!("there is no preset {text:?}"));
                values.preset = Preset::of_name(text).ok_or_else(unknown)?;
                continue;
            }
            let known = parameters.iter().map(|(parameter, _)| parameter).find(|p| p.typed_name() == name);
            let parameter = known.ok_or_else(|| usage(format!("no method has a parameter {name:?}")))?;
            values.set(parameter, parameter.parse(text)?);
        }
        Ok(Self { values })
    }

    /// Returns the parameters that a user typed on a command line: the name of each flag, and its value as it was
    /// typed. Values that are defaults are left out.
    pub fn typed(matches: &ArgMatches) -> Vec<(String, String)> {
        let given_value = |id: &String| {
            let is_given = matches.try_contains_id(id).unwrap_or(false)
                && matches.value_source(id) == Some(clap::parser::ValueSource::CommandLine);
            let value =
                || matches.get_raw(id).and_then(|mut v| v.next()).map(|text| text.to_string_lossy().into_owned());
            is_given.then(|| (id.clone(), value().unwrap_or_default()))
        };
        let mut names: Vec<_> = methods::parameters().into_iter().map(|(p, _)| p.typed_name()).collect();
        names.push(PRESET.to_owned());
        names.sort_unstable();
        names.dedup();
        names.iter().filter_map(given_value).collect()
    }
}

/// A method with flags of its own, which together are the value of one flag, such as `--variant`.
#[derive(Debug, Clone)]
pub struct TypedVariant {
    method: String,
    /// The preset, if the variant names one.
    preset: Option<Preset>,
    values: Values,
}

impl TypedVariant {
    /// The method with a base's setup, in which the variant's own flags replace values. It is an error if the method
    /// does not exist or does not read one of these flags.
    pub fn with_base(&self, base: &Setup) -> crate::error::Result<Variant> {
        let method = methods::find(&self.method)?;
        methods::check_read(&[method], &Setup { values: self.values.clone(), ..base.clone() })?;
        let mut setup = base.clone();
        setup.values.preset = self.preset.unwrap_or(base.values.preset);
        for name in self.values.given_names() {
            if let Some((row, _)) = methods::parameters().iter().find(|(p, _)| p.name == name) {
                setup.values.set(row, self.values.value(row));
            }
        }
        Ok(Variant { method, setup })
    }
}

/// Parses a variant such as `stochastic --history on`.
pub fn parse_variant(text: &str) -> Result<TypedVariant, String> {
    let command = Command::new("variant").no_binary_name(true).arg(Arg::new("METHOD").required(true));
    let command = MethodOptions::augment_args(command).disable_help_flag(true);
    // Only the first line of an error is kept, since the usage that clap adds shows a command that nobody can type.
    let first_line = |e: clap::Error| {
        let text = e.to_string();
        text.lines().next().map(|line| line.trim_start_matches("error: ").to_owned()).unwrap_or(text)
    };
    let matches = command.try_get_matches_from(text.split_whitespace()).map_err(first_line)?;
    let MethodOptions { values } = MethodOptions::from_arg_matches(&matches).map_err(first_line)?;
    let method = matches.get_one::<String>("METHOD").cloned().unwrap_or_default();
    let names_preset = matches.value_source(PRESET) == Some(clap::parser::ValueSource::CommandLine);
    Ok(TypedVariant { method, preset: names_preset.then_some(values.preset), values })
}

/// A parser of the names of choices.
pub fn choice_parser<T: Choices + Send + Sync>() -> impl TypedValueParser<Value = T> {
    let possible = T::CHOICES.iter().map(|c| PossibleValue::new(c.name).help(c.help.trim()));
    PossibleValuesParser::new(possible.collect::<Vec<_>>())
        .try_map(|name| T::of_name(&name).ok_or_else(|| format!("there is no {name:?}")))
}

/// Makes the flag for parameters that have one name, each given with the methods that read it. The help names the
/// values of both presets, published and author, which may differ between methods. All these parameters accept the same
/// values.
fn flag(declarations: &[(Parameter, Vec<&methods::MethodInfo>)]) -> Arg {
    let (parameter, _) = &declarations[0];
    // The values of the presets in brackets, with the names of the methods if these are few.
    let preset_text = |(p, methods): &(Parameter, Vec<&methods::MethodInfo>)| {
        let names: Vec<_> = methods.iter().map(|m| m.name).collect();
        let names = if names.len() < 4 { format!("{}; ", names.join(", ")) } else { String::new() };
        let author = if p.author == p.published { String::new() } else { format!("; author: {}", p.author) };
        format!("[{names}published: {}{author}]", p.published)
    };
    let presets = declarations.iter().map(preset_text).collect::<Vec<_>>().join(" ");
    let excluded = EXCLUSIONS.iter().filter(|exclusion| exclusion.parameter == parameter.name);
    let refused: String = excluded.map(|exclusion| format!(" It is refused {}.", exclusion.refused)).collect();
    let about = format!("{}{refused} {presets}", parameter.help);
    let (first_sentence, _) = parameter.help.split_once(". ").unwrap_or((parameter.help.trim_end_matches('.'), ""));
    let argument = Arg::new(parameter.typed_name())
        .long(parameter.typed_name())
        .help(first_sentence.to_owned())
        .long_help(about.clone())
        .help_heading(heading(declarations));
    let parsed_parameter = parameter.clone();
    let parser = StringValueParser::new().try_map(move |text| match parsed_parameter.parse(&text) {
        Ok(_) => Ok(text),
        Err(_) => Err(format!("it takes {}", parsed_parameter.domain)),
    });
    match &parameter.domain {
        domain if domain.is_switch() => argument
            .value_parser(possible_values(parameter))
            .num_args(0..=1)
            .default_missing_value("on")
            .value_name("on|off"),
        Domain::Count(..) => argument.value_parser(parser).value_name("N"),
        Domain::Number { .. } => argument.value_parser(parser).value_name("X"),
        Domain::ChoicesOrCount(named, least, most) => {
            let names: Vec<_> = named.iter().map(|c| c.name).collect();
            let choices: String = named.iter().map(|c| format!("\n- {}: {}", c.name, c.help)).collect();
            let name = format!("N|{}", names.join("|"));
            let help = format!("{about}{choices}\n- N: so many, from {least} to {most}");
            argument.value_parser(parser).value_name(name).long_help(help)
        }
        domain => argument.value_parser(possible_values(parameter)).value_name(match domain {
            Domain::Numbers(_) => "X",
            _ => "NAME",
        }),
    }
}

/// Returns the heading of the flag for parameters that have one name, each given with the methods that read it. The
/// heading is [`METHOD`] for a parameter of the effect, or else has the names of these methods.
fn heading(declarations: &[(Parameter, Vec<&methods::MethodInfo>)]) -> String {
    let (parameter, _) = &declarations[0];
    if EffectParams::table().iter().any(|known| known.name == parameter.name) {
        return METHOD.to_owned();
    }
    let mut names: Vec<_> = declarations.iter().flat_map(|(_, methods)| methods.iter().map(|m| m.name)).collect();
    // The names get the order of the table of methods, since declarations of one parameter may list its methods in
    // different orders.
    names.sort_by_key(|name| methods::all().iter().position(|m| m.name == *name));
    format!("Parameters of {}", names.join(", "))
}

/// Makes the parser of a parameter that takes few values, all of which the help lists.
fn possible_values(parameter: &Parameter) -> ValueParser {
    let values = match &parameter.domain {
        Domain::Choices(all) => all.iter().map(|c| PossibleValue::new(c.name).help(c.help.trim())).collect(),
        domain => domain
            .all_if_few()
            .unwrap_or_default()
            .iter()
            .map(|v| PossibleValue::new(v.to_string()))
            .collect::<Vec<_>>(),
    };
    PossibleValuesParser::new(values).into()
}

impl Args for MethodOptions {
    fn augment_args(command: Command) -> Command {
        let preset = Arg::new(PRESET)
            .long(PRESET)
            .value_name("NAME")
            .help("Whose constants a published method uses")
            .long_help("Whose constants a published method uses [default: published]")
            .value_parser(choice_parser::<Preset>().map(|p| p.name().to_owned()));
        // `custom_methods` reads the value of this flag, since methods from folders are read before the other flags are known.
        let include = Arg::new(INCLUDE)
            .long(INCLUDE)
            .value_name("DIR")
            .help("Folder whose shaders a method from a folder may use")
            .long_help(
                "Folder whose shaders a method from a folder may use; without it, a method has the files of its own folder \
                 alone",
            )
            .value_parser(clap::value_parser!(PathBuf))
            .action(clap::ArgAction::Append);
        // Parameters of one name, which several methods may declare, share one flag.
        let mut remaining = methods::parameters();
        let mut command = command.arg(preset).arg(include);
        while let Some((first, _)) = remaining.first().cloned() {
            let (same_name, others) = remaining.into_iter().partition::<Vec<_>, _>(|(p, _)| p.name == first.name);
            (command, remaining) = (command.arg(flag(&same_name)), others);
        }
        command
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for MethodOptions {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let typed = Self::typed(matches);
        Self::from_typed(typed.iter().map(|(name, text)| (name.as_str(), text.as_str())))
            .map_err(|e| clap::Error::raw(clap::error::ErrorKind::ValueValidation, format!("{e}\n")))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

/// The flags of methods for a G-buffer without its scene, whose captures come from a folder.
#[derive(Debug, Clone, Default)]
pub struct BesideGBufferOptions {
    /// All flags of methods except that of the captures.
    pub method_options: MethodOptions,
    /// The folder of the captures.
    pub captures: Option<PathBuf>,
}

/// The flag of folders that methods' shaders may use.
const INCLUDE: &str = "include";

/// The flag of the captures.
const CAPTURES: &str = "captures";

impl Args for BesideGBufferOptions {
    fn augment_args(command: Command) -> Command {
        MethodOptions::augment_args(command).mut_arg(CAPTURES, |flag| {
            let flag = flag.value_parser(clap::value_parser!(PathBuf)).value_name("DIR");
            flag.help("Folder with captures of the scene, or none").long_help(
                "Folder with captures of what the G-buffer does not show, in which unified follows the rays that the \
                 screen loses: `ssct captures -o` writes such a folder, and any renderer may write the same files; \
                 `none` for no captures",
            )
        })
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for BesideGBufferOptions {
    /// Reads the flags. `--captures` names a folder here, `none` means no captures, and a folder that is not there is
    /// an error.
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let wrong = |message: String| clap::Error::raw(clap::error::ErrorKind::ValueValidation, message + "\n");
        let typed = MethodOptions::typed(matches);
        let method_flags = typed.iter().filter(|(name, _)| name != CAPTURES);
        let method_options = MethodOptions::from_typed(method_flags.map(|(name, text)| (name.as_str(), text.as_str())))
            .map_err(|e| wrong(e.to_string()))?;
        let captures = matches.get_one::<PathBuf>(CAPTURES).filter(|folder| folder.as_os_str() != "none");
        if let Some(folder) = captures.filter(|folder| !folder.is_dir()) {
            return Err(wrong(format!(
                "--{CAPTURES} {}: there is no such folder; a G-buffer has no scene to be captured, so that captures beside \
                 it come from a folder that `ssct captures -o` wrote",
                folder.display()
            )));
        }
        if captures.is_some() && method_options.values.given_names().any(|name| name == "capture_side") {
            return Err(wrong("--capture-side: captures that come from a folder have the side that they have".into()));
        }
        Ok(Self { method_options, captures: captures.cloned() })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;
    use ssct::methods::METHODS;
    use ssct::methods::setup::{CaptureCount, HistoryUse};

    /// Parses the flags of methods alone, without a command around them.
    fn parse(flags: &[&str]) -> Result<MethodOptions, clap::Error> {
        let command = MethodOptions::augment_args(Command::new("method")).no_binary_name(true);
        MethodOptions::from_arg_matches(&command.try_get_matches_from(flags)?)
    }

    /// Every parameter of every method has a flag, and the value of the flag reaches the recorded setup.
    #[test]
    fn every_parameter_has_a_flag_that_reaches_the_record() {
        for method in METHODS {
            for row in method.read_parameters() {
                let values = row.domain.all_if_few().unwrap_or_else(|| vec![row.published, row.author]);
                for value in values {
                    let flag = format!("--{}={value}", row.typed_name());
                    let options = parse(&[&flag]).unwrap_or_else(|e| panic!("{flag}: {e}"));
                    assert_eq!(options.values.value(&row), value, "{flag}");
                    let recorded = options.setup([8, 8]).recorded(Some(method));
                    assert_eq!(recorded[row.name], value, "{flag}");
                }
            }
        }
    }

    #[test]
    fn the_flags_of_a_variant_count_before_those_outside() {
        let base = parse(&["--preset", "author", "--fade", "off", "--history", "on"]).expect("flags").setup([8, 8]);
        let typed = parse_variant("stochastic --history off  --history-frames 4").expect("a variant");
        let variant = typed.with_base(&base).expect("a method");
        let effect = variant.setup.effect();
        assert_eq!((variant.method.name, variant.setup.values.preset), ("stochastic", Preset::Author));
        let published =
            parse_variant("ssct --preset published").expect("a variant").with_base(&base).expect("a method");
        assert_eq!(published.setup.values.preset, Preset::Published);
        assert_eq!((effect.fade, effect.history, effect.history_frames), (false, HistoryUse::Off, 4));
        for (wrong, says) in [("", "required"), ("ssct --fade maybe", "maybe"), ("ssct --no-such 1", "--no-such")] {
            let message = parse_variant(wrong).expect_err(wrong);
            assert!(message.contains(says) && !message.contains('\n'), "{wrong}: {message}");
        }
        for wrong in ["none", "ssct --stochastic-rays 2"] {
            assert!(parse_variant(wrong).expect("flags that there are").with_base(&base).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_default_value_makes_no_other_variant() {
        let typed = ["ssct", "ssct --fade on", "ssct --fade off"].map(|text| parse_variant(text).expect("a variant"));
        let base = parse(&[]).expect("flags").setup([8, 8]);
        assert_eq!(crate::app::resolve::typed_variants(&typed, &base).expect("methods").len(), 2);
    }

    #[test]
    fn every_switch_takes_on_and_off_and_means_on_where_it_stands_alone() {
        let switches: Vec<_> = methods::parameters().into_iter().filter(|(p, _)| p.domain.is_switch()).collect();
        assert!(switches.len() > 5, "fade, history, split and the like");
        for (row, _) in switches {
            let name = format!("--{}", row.typed_name());
            let value = |flags: &[&str]| {
                let options = parse(flags).unwrap_or_else(|e| panic!("{flags:?}: {e}"));
                options.values.value(&row).to_string()
            };
            assert_eq!(value(&[&name, "--preset", "author"]), "on");
            for wanted in ["on", "off"] {
                assert_eq!(value(&[&name, wanted]), wanted);
                assert_eq!(value(&[&format!("{name}={wanted}")]), wanted);
            }
            assert!(parse(&[&name, "maybe"]).is_err(), "{name}");
        }
    }

    #[test]
    fn captures_are_a_number_or_a_name() {
        for (text, count) in [
            ("none", CaptureCount::None),
            ("auto", CaptureCount::Auto),
            ("camera", CaptureCount::Camera),
            ("1", CaptureCount::Number(1)),
            ("8", CaptureCount::Number(8)),
        ] {
            let setup = parse(&["--captures", text]).expect(text).setup([8, 8]);
            assert_eq!(setup.effect().captures, count);
            let recorded = serde_json::to_value(setup.recorded(None)["captures"]).expect("a value");
            assert_eq!(recorded, text.parse::<u32>().map_or_else(|_| json!(text), |n| json!(n)), "{text}");
        }
        for wrong in ["0", "9", "one", "-1"] {
            let message = parse(&[&format!("--captures={wrong}")]).expect_err(wrong).to_string();
            assert!(message.contains("none, auto, camera, or whole numbers from 1 to 8"), "{wrong}: {message}");
        }
    }

    #[test]
    fn several_flags_are_read_together_and_wrong_values_are_refused() {
        let options = parse(&["--preset", "author", "--cone-samples=3", "--split", "--fade", "off"]).expect("flags");
        assert_eq!(options.values.preset, Preset::Author);
        assert_eq!(options.values.given_names().collect::<Vec<_>>(), ["cone_samples", "fade", "split"]);
        for wrong in ["--cone-samples=0", "--cone-samples=many", "--fade=maybe", "--march-stride=0", "--preset=mine"] {
            assert!(parse(&[wrong]).is_err(), "{wrong}");
        }
    }
}

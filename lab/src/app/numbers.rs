//! Numbers on the command line: a negative or wrong number is read as an option's value, however it is spelt, so that the error is about
//! the value.

use clap::Command;
use clap::builder::ValueParser;
use std::any::TypeId;

/// Returns the command line, with its subcommands, so changed that options take `-0.1` after a blank as well as after
/// `=`. An error about an option of type `f32` then says that the text is no number.
pub fn with_number_parsers(command: Command) -> Command {
    let nested: Vec<String> = command.get_subcommands().map(|c| c.get_name().to_owned()).collect();
    let command = nested.iter().fold(command, |command, name| command.mut_subcommand(name, with_number_parsers));
    command.mut_args(|argument| {
        if argument.is_positional() || !argument.get_action().takes_values() {
            return argument;
        }
        let kind = argument.get_value_parser().type_id();
        let argument = argument.allow_negative_numbers(true);
        if kind == TypeId::of::<f32>() {
            argument.value_parser(ValueParser::new(parse_number))
        } else if kind == TypeId::of::<[u32; 2]>() {
            // `-1x5` is neither a number nor an option.
            argument.allow_hyphen_values(true)
        } else {
            argument
        }
    })
}

/// Reads a number; -0 is 0. The command that knows the number's meaning checks its range.
fn parse_number(text: &str) -> Result<f32, String> {
    let number: f32 = text.trim().parse().map_err(|_| format!("{text:?} is no number; write it as 0.5"))?;
    // The sum of -0 and 0 is 0, so that names and records have no second zero.
    Ok(number + 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::cli::parse_size;

    #[derive(clap::Parser)]
    struct Options {
        #[arg(long, value_delimiter = ',')]
        roughness: Vec<f32>,
        #[arg(long, value_parser = parse_size)]
        size: Option<[u32; 2]>,
    }

    /// Parses a command line of the two options above; an error is the message that a user sees.
    fn parse(words: &[&str]) -> Result<(Vec<f32>, Option<[u32; 2]>), String> {
        let command = with_number_parsers(<Options as clap::CommandFactory>::command().no_binary_name(true));
        let matches = command.try_get_matches_from(words).map_err(|e| e.to_string())?;
        let options = <Options as clap::FromArgMatches>::from_arg_matches(&matches).map_err(|e| e.to_string())?;
        Ok((options.roughness, options.size))
    }

    #[test]
    fn a_negative_number_may_follow_a_blank_or_an_equals_sign() {
        assert_eq!(parse(&["--roughness", "-0.1"]), parse(&["--roughness=-0.1"]));
        assert_eq!(parse(&["--roughness", "0.1,-0.5"]), Ok((vec![0.1, -0.5], None)));
    }

    #[test]
    fn minus_zero_is_read_as_zero() {
        let (zeros, _) = parse(&["--roughness", "0,-0,-0.0"]).expect("numbers");
        assert_eq!(zeros.iter().map(f32::to_string).collect::<Vec<_>>(), ["0"; 3]);
    }

    #[test]
    fn an_error_quotes_the_text_and_shows_how_to_write_the_value() {
        for words in [&["--roughness", "0.5f"][..], &["--roughness=0.5f"]] {
            let message = parse(words).unwrap_err();
            assert!(message.contains("\"0.5f\" is no number; write it as 0.5"), "{message}");
        }
        for words in [&["--size", "-1x5"][..], &["--size=-1x5"]] {
            let message = parse(words).unwrap_err();
            assert!(message.contains("\"-1x5\" is no size; write it as 960x540"), "{message}");
        }
    }
}

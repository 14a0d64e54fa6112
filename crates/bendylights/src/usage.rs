//! Parsing of the command line, and values that several commands take.

use std::fmt;
use std::ops::RangeInclusive;
use std::process;
use std::str::FromStr;

use clap::Parser;
use clap::builder::TypedValueParser;
use clap::error::ContextKind;
use cli::{CliError, print_answer, print_note, print_to_stderr};
use serde::Serialize;
use serde_json::json;

/// Default data folder of `bendylights serve` and of the commands that read it.
pub const DATA: &str = "./bendylights-data";

/// Exit code of an invalid command line.
const USAGE: u8 = 2;
/// Digits of the largest bound that a message shows.
const MAX_SHOWN_DIGITS: usize = 9;

/// Parses the command line. On an error, prints one sentence and exits.
///
/// clap suggests corrections, among them to pass a word after `--`. That is never what the user meant, so
/// suggestions are removed.
pub fn parse<T: Parser>() -> T {
    T::try_parse().unwrap_or_else(|mut error| {
        error.remove(ContextKind::Suggested);
        // The command line cannot be parsed, so the option is searched in it.
        let as_json = std::env::args_os().any(|word| word == "--json");
        if as_json && error.use_stderr() {
            print_failure(&sentence(&error.to_string()), USAGE, true);
            process::exit(USAGE.into());
        }
        error.exit()
    })
}

/// Prints the reason of a failure to standard error: a line for people, or for programs `{"error": {"message":
/// "...", "exitCode": 2}}`.
pub fn print_failure(why: &str, exit_code: u8, as_json: bool) {
    if as_json {
        print_to_stderr(&json!({"error": {"message": why, "exitCode": exit_code}}).to_string());
    } else {
        print_to_stderr(&format!("error: {why}"));
    }
}

/// Prints an answer as JSON over several lines.
pub fn print_json(answer: &impl Serialize) -> Result<(), CliError> {
    print_answer(&serde_json::to_string_pretty(answer).expect("plain data with string keys"))
}

/// Prints an array of objects, each on a line of its own.
pub fn print_objects(objects: &[String]) -> Result<(), CliError> {
    print_answer(&format!("[{}]", objects.join(",\n ")))
}

/// Returns the name of a value in JSON.
pub fn json_name(value: impl Serialize) -> String {
    let name = serde_json::to_value(value).ok();
    name.as_ref().and_then(serde_json::Value::as_str).unwrap_or_default().to_owned()
}

/// Prints notes on what a command does with its input.
pub fn print_notes(notes: impl IntoIterator<Item = impl fmt::Display>) {
    notes.into_iter().for_each(|note| print_note(&format!("note: {note}")));
}

/// Returns clap's message without the advice below it.
fn sentence(error: &str) -> String {
    let why = error.split("\n\n").next().unwrap_or_default();
    let words: Vec<_> = why.trim_start_matches("error: ").split_whitespace().collect();
    words.join(" ")
}

/// Returns a parser of whole numbers in `range`.
pub fn whole_number_parser<N>(range: RangeInclusive<N>) -> impl TypedValueParser<Value = N>
where
    N: FromStr + PartialOrd + fmt::Display + Clone + Send + Sync + 'static,
{
    clap::builder::StringValueParser::new().try_map(move |text| {
        let number = text.parse().ok().filter(|number| range.contains(number));
        number.ok_or_else(|| match range.end().to_string() {
            last if last.len() <= MAX_SHOWN_DIGITS => {
                format!("write a whole number from {} to {last}", range.start())
            }
            _ => format!("write a whole number from {} up", range.start()),
        })
    })
}

/// Address on which a server listens.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ListenAddress(pub String);

impl FromStr for ListenAddress {
    type Err = &'static str;

    /// Parses `HOST:PORT`, or a port with or without a colon before it. Without a host the address is
    /// 127.0.0.1, which other machines cannot reach.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let (host, port) = match text.rsplit_once(':') {
            None => ("127.0.0.1", text),
            Some(("", port)) => ("127.0.0.1", port),
            Some(parts) => parts,
        };
        let is_host =
            !host.contains(['/', ' ']) && (!host.contains(':') || host.starts_with('[') && host.ends_with(']'));
        match port.parse::<u16>() {
            Ok(port) if is_host => Ok(Self(format!("{host}:{port}"))),
            _ => Err("write HOST:PORT, such as 127.0.0.1:8080 or [::1]:8080, or a port from 0 to 65535 alone"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_port_alone_is_of_the_loopback_interface() {
        for (text, expected) in [
            ("80", "127.0.0.1:80"),
            (":80", "127.0.0.1:80"),
            ("0.0.0.0:8080", "0.0.0.0:8080"),
            ("localhost:0", "localhost:0"),
            ("[::1]:8080", "[::1]:8080"),
        ] {
            assert_eq!(text.parse(), Ok(ListenAddress(expected.into())), "{text}");
        }
        for text in ["", "localhost", "0.0.0.0", "::1", "127.0.0.1:", "127.0.0.1:65536", "http://localhost:80", "1e3"] {
            assert!(text.parse::<ListenAddress>().is_err(), "{text}");
        }
    }
}

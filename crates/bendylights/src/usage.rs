//! The command line: how it is read, and the values that several commands take.

use std::fmt;
use std::ops::RangeInclusive;
use std::process;
use std::str::FromStr;

use clap::Parser;
use clap::builder::TypedValueParser;
use clap::error::ContextKind;
use cli::print_to_stderr;
use serde_json::json;

/// The folder of `bendylights serve`, and of the commands that look into it.
pub const DATA: &str = "./bendylights-data";

/// The exit code of a command line that cannot be read.
const USAGE: u8 = 2;
/// Digits of the largest number that means something to people.
const MAX_SHOWN_DIGITS: usize = 9;

/// What is on the command line, or the end of the program with a sentence.
///
/// clap guesses what may have been meant. That a word could be passed behind `--` is never what was, and so is not said.
pub fn parse<T: Parser>() -> T {
    T::try_parse().unwrap_or_else(|mut error| {
        error.remove(ContextKind::Suggested);
        // What is on the command line cannot be read, so it is looked for.
        let as_json = std::env::args_os().any(|word| word == "--json");
        if as_json && error.use_stderr() {
            print_failure(&sentence(&error.to_string()), USAGE, true);
            process::exit(USAGE.into());
        }
        error.exit()
    })
}

/// Why a command fails, on standard error: a line for people, or for programs
/// `{"error": {"message": "...", "exitCode": 2}}`.
pub fn print_failure(why: &str, exit_code: u8, as_json: bool) {
    if as_json {
        print_to_stderr(&json!({"error": {"message": why, "exitCode": exit_code}}).to_string());
    } else {
        print_to_stderr(&format!("error: {why}"));
    }
}

/// What clap says of a command line, without the advice for people below it.
fn sentence(error: &str) -> String {
    let why = error.split("\n\n").next().unwrap_or_default();
    let words: Vec<_> = why.trim_start_matches("error: ").split_whitespace().collect();
    words.join(" ")
}

/// Takes a whole number of `range`.
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

/// Where a server listens.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ListenAddress(pub String);

impl FromStr for ListenAddress {
    type Err = &'static str;

    /// `HOST:PORT`, or a port alone, with a colon before it or without: then of 127.0.0.1, where nobody else comes in.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let (host, port) = match text.rsplit_once(':') {
            None => ("127.0.0.1", text),
            Some(("", port)) => ("127.0.0.1", port),
            Some(parts) => parts,
        };
        let is_host = !host.contains(['/', ' '])
            && (!host.contains(':') || host.starts_with('[') && host.ends_with(']'));
        match port.parse::<u16>() {
            Ok(port) if is_host => Ok(Self(format!("{host}:{port}"))),
            _ => {
                Err("write HOST:PORT, such as 127.0.0.1:8080 or [::1]:8080, or a port from 0 to 65535 alone")
            }
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
        for text in
            ["", "localhost", "0.0.0.0", "::1", "127.0.0.1:", "127.0.0.1:65536", "http://localhost:80", "1e3"]
        {
            assert!(text.parse::<ListenAddress>().is_err(), "{text}");
        }
    }
}

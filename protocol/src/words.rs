//! Error messages of serde, translated into the terms of JSON for the author of the JSON.

/// Translates a message of `serde_json` about a value of the wrong shape.
///
/// The result has no Rust terms. It names values by JSON's types, calls members fields, and lists the words
/// that an enumeration accepts. A message of no known form passes through unchanged.
pub(crate) fn json_wording(said: &str) -> String {
    let translated = |text: &str| -> Option<String> {
        if let Some(rest) = text.strip_prefix("invalid type: ").or_else(|| text.strip_prefix("invalid value: ")) {
            let (found, expected) = rest.rsplit_once(", expected ")?;
            return Some(format!("is {}, where {} should be", value(found), kind(expected)));
        }
        if let Some(rest) = text.strip_prefix("invalid length ") {
            let (found, expected) = rest.split_once(", expected ")?;
            return Some(format!("has {found} values, where {} should be", kind(expected)));
        }
        if let Some(rest) = text.strip_prefix("missing field ") {
            return Some(format!("the field {rest} is missing"));
        }
        if let Some(rest) = text.strip_prefix("duplicate field ") {
            return Some(format!("the field {rest} is there twice"));
        }
        if let Some(rest) = text.strip_prefix("unknown field ") {
            return Some(match rest.split_once(", expected ") {
                Some((field, known)) => {
                    format!("there is no field {field}, only {}", known.trim_start_matches("one of "))
                }
                None => {
                    format!("there is no field {}", rest.split_once(", there are").map_or(rest, |(field, _)| field))
                }
            });
        }
        if let Some(rest) = text.strip_prefix("unknown parameter ") {
            let (name, known) = rest.split_once(", expected ")?;
            return Some(format!("there is no parameter {name}, only {}", known.trim_start_matches("one of ")));
        }
        let (word, known) = text.strip_prefix("unknown variant ")?.split_once(", expected ")?;
        Some(format!("{word} is not {known}"))
    };
    translated(said).unwrap_or_else(|| said.to_owned())
}

/// Translates a message of `serde_json` about text that is not JSON.
pub(crate) fn syntax_error_wording(said: &str) -> String {
    let (problem, position) = said.split_once(" at line ").map_or((said, String::new()), |(problem, position)| {
        (problem, format!(" (line {})", position.replace(" column ", ", character ")))
    });
    let problem = match problem {
        "EOF while parsing a value" => "it ends where a value should begin",
        "EOF while parsing an object" | "EOF while parsing a list" | "EOF while parsing a string" => {
            "it ends before what began is closed"
        }
        "trailing characters" => "something follows where it should end",
        "trailing comma" => "a comma stands before the end",
        "expected value" => "there is no value where one should be",
        "expected ident" => "there is a word that is none of true, false and null",
        "key must be a string" => "the name of a field is not in double quotes",
        "number out of range" => "a number is out of range",
        "invalid number" => "a number is not written as JSON has it",
        "recursion limit exceeded" => "objects and arrays lie too deep in one another",
        "control character (\\u0000-\\u001F) found while parsing a string" => {
            "a text holds a line end or another control character; write \\n"
        }
        "lone leading surrogate in hex escape" | "unexpected end of hex escape" | "invalid unicode code point" => {
            "a \\u in a text is no character"
        }
        "invalid escape" => "a text has a backslash before what needs none",
        other => match other.strip_prefix("expected ") {
            Some(expected) => return format!("there is no {expected} where one should be{position}"),
            None => other,
        },
    };
    format!("{problem}{position}")
}

/// Describes a value that serde found: a string with its text, a number without its backticks, an object as "an
/// object".
fn value(found: &str) -> String {
    match found.split_once(' ') {
        Some(("string", text)) => format!("the text {text}"),
        Some(("integer" | "floating", number)) => {
            let number = number.strip_prefix("point ").unwrap_or(number);
            format!("the number {}", number.trim_matches('`'))
        }
        Some(("boolean", flag)) => flag.trim_matches('`').to_owned(),
        _ => match found {
            "map" => "an object",
            "sequence" => "an array",
            "null" | "unit value" | "Option value" => "null",
            other => other,
        }
        .to_owned(),
    }
}

/// Describes the type that serde expected, by the types of JSON.
fn kind(expected: &str) -> String {
    if let Some(count) = expected.strip_prefix("an array of length ") {
        return format!("an array of {count}");
    }
    match expected {
        "f64" | "a number" => "a number",
        "u8" | "u16" | "u32" | "u64" | "usize" | "a nonzero u32" => "a whole number from 0 up",
        "i8" | "i16" | "i32" | "i64" => "a whole number",
        "a boolean" => "true or false",
        "a string" | "str" | "string" => "a text",
        "a sequence" | "sequence" => "an array",
        "a map" | "map" | "option" => "an object",
        "unit" => "null",
        other if other.starts_with("struct ") || other.starts_with("an object: ") => "an object",
        other if other.contains("tagged enum") => "an object with `type`",
        other if other.starts_with("enum ") || other == "variant identifier" => "one of its words",
        other if other.starts_with("tuple ") || other.starts_with("a tuple") => "an array",
        other => other,
    }
    .to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn serdes_words_become_jsons() {
        for (said, expected) in [
            ("invalid type: string \"a\", expected f64", "is the text \"a\", where a number should be"),
            ("invalid type: map, expected a sequence", "is an object, where an array should be"),
            ("invalid type: null, expected struct Light", "is null, where an object should be"),
            ("invalid value: integer `-1`, expected u64", "is the number -1, where a whole number from 0 up should be"),
            (
                "invalid type: floating point `1.5`, expected usize",
                "is the number 1.5, where a whole number from 0 up should be",
            ),
            ("invalid length 2, expected an array of length 3", "has 2 values, where an array of 3 should be"),
            ("missing field `points`", "the field `points` is missing"),
            ("duplicate field `name`", "the field `name` is there twice"),
            ("unknown field `gobo`, expected one of `a`, `b`", "there is no field `gobo`, only `a`, `b`"),
            ("unknown field `gobo`, there are no fields", "there is no field `gobo`"),
            ("unknown variant `laser`, expected one of `spot`, `omni`", "`laser` is not one of `spot`, `omni`"),
            ("unknown variant `laser`, expected `spot` or `omni`", "`laser` is not `spot` or `omni`"),
            ("a sentence of ours", "a sentence of ours"),
        ] {
            assert_eq!(json_wording(said), expected);
        }
        let syntax = "EOF while parsing a value at line 1 column 17";
        assert_eq!(syntax_error_wording(syntax), "it ends where a value should begin (line 1, character 17)");
        assert_eq!(
            syntax_error_wording("expected `,` or `}` at line 2 column 3"),
            "there is no `,` or `}` where one should be (line 2, character 3)"
        );
    }
}

//! What a program answers: one JSON object, or nonsense that is shown.

use decor_api::AdapterError;
use decor_api::process::ANSWER_BYTES;

use crate::protocol::{Reply, VERSION};

/// How much of nonsense is shown.
const SHOWN: usize = 200;

/// The answer of `program`.
///
/// # Errors
/// [`AdapterError::BadOutput`] where it is no answer of this protocol.
pub fn read(program: &str, answer: &[u8]) -> Result<Reply, AdapterError> {
    if answer.len() > ANSWER_BYTES {
        let why = format!("it answered more than {ANSWER_BYTES} bytes");
        return Err(nonsense(program, &why));
    }
    let text = String::from_utf8_lossy(answer);
    let text = text.trim();
    if text.is_empty() {
        return Err(nonsense(program, "it answered nothing"));
    }
    // The version first: what another one says need not be understood.
    let stated = serde_json::from_str::<serde_json::Value>(text)
        .map_err(|error| nonsense(program, &format!("{error}: {}", beginning(text))))?;
    let version = stated.get("protocol").and_then(serde_json::Value::as_u64);
    if version != Some(u64::from(VERSION)) {
        let why = format!(
            "it does not say that it speaks version {VERSION} of the protocol: {}",
            beginning(text)
        );
        return Err(nonsense(program, &why));
    }
    serde_json::from_value(stated)
        .map_err(|error| nonsense(program, &format!("{error}: {}", beginning(text))))
}

/// The error for an answer that is none.
pub fn nonsense(program: &str, why: &str) -> AdapterError {
    AdapterError::BadOutput {
        program: program.to_owned(),
        file: "an answer that is none".into(),
        reason: why.to_owned(),
    }
}

fn beginning(text: &str) -> String {
    match text.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn says(answer: &str) -> Result<Reply, String> {
        read("ray.py", answer.as_bytes()).map_err(|error| error.to_string())
    }

    #[test]
    fn answers_are_understood() {
        let done = says("{\"protocol\":1,\"reply\":\"done\",\"layers\":3}\n");
        let layers = 3;
        let protocol = 1;
        assert_eq!(done, Ok(Reply::Done { protocol, layers }));
        let hello = says(
            r#"{"protocol":1,"reply":"hello","name":"a","version":"2","abilities":{"csg":true}}"#,
        );
        let Ok(Reply::Hello { abilities, .. }) = hello else {
            panic!("{hello:?}");
        };
        assert!(abilities.csg && !abilities.shadows && abilities.jobs == 1);
    }

    #[test]
    fn nonsense_is_shown_with_its_program() {
        let cases = [
            ("", "nothing"),
            ("Loading…", "Loading…"),
            ("{\"reply\":\"done\",\"layers\":3}", "version 1"),
            (
                "{\"protocol\":2,\"reply\":\"done\",\"layers\":3}",
                "version 1",
            ),
            ("{\"protocol\":1,\"reply\":\"dne\"}", "dne"),
            (
                "{\"protocol\":1,\"reply\":\"done\",\"layers\":1} {}",
                "trailing",
            ),
            ("{\"protocol\":1,\"reply\":\"done\",\"layers\":-1}", "-1"),
            (
                r#"{"protocol":1,"reply":"hello","name":"a","version":"2","abilities":{"cgs":true}}"#,
                "cgs",
            ),
        ];
        for (answer, shown) in cases {
            let error = says(answer).expect_err(answer);
            assert!(error.contains("ray.py") && error.contains(shown), "{error}");
        }
        let long = says(&format!("\u{e9}{}", "\u{e9}".repeat(500))).expect_err("long");
        assert!(long.chars().count() < 400, "{long}");
    }
}

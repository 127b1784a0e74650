//! The influence of what changed is conservative, and tight: against the
//! pictures of the reference and of POV-Ray.

mod povray;
mod reach;
mod reference;
mod scenes;
mod tight;

/// How many scenes to try: the environment's number, or `usual`.
fn count(variable: &str, usual: u64) -> u64 {
    match std::env::var(variable) {
        Ok(text) => text.parse().expect("a number of scenes"),
        Err(_) => usual,
    }
}

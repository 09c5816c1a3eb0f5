//! Errors with their causes, on one line.

use std::error::Error;

/// The message of an error followed by those of its causes, separated by `: `. A message that the text already ends
/// with is not repeated.
pub fn chain_of_causes(error: &dyn Error) -> String {
    let mut text = error.to_string();
    let mut source = error.source();
    while let Some(cause) = source {
        let message = cause.to_string();
        if !text.ends_with(&message) {
            text += ": ";
            text += &message;
        }
        source = cause.source();
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, thiserror::Error)]
    #[error("{text}")]
    struct Step {
        text: &'static str,
        source: Option<Box<Step>>,
    }

    #[test]
    fn causes_follow_and_are_not_repeated() {
        let step = |text, source: Option<Step>| Step {
            text,
            source: source.map(Box::new),
        };
        let disk = step("disk full", None);
        let write = step("cannot write a.rrd: disk full", Some(disk));
        let run = step("run failed", Some(write));
        assert_eq!(
            chain_of_causes(&run),
            "run failed: cannot write a.rrd: disk full"
        );
    }
}

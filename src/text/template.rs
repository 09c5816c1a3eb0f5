//! The templates under `assets/text`, and the filters they use.

use std::sync::LazyLock;

use minijinja::syntax::SyntaxConfig;
use minijinja::value::Value;
use minijinja::{Environment, Error, ErrorKind, UndefinedBehavior};

use crate::number::{percent, quantity};

/// The templates with their text.
macro_rules! templates {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../../assets/text/", $name, ".md")))),*]
    };
}

const TEMPLATES: &[(&str, &str)] = templates![
    "views",
    "paper/caption",
    "paper/page",
    "paper/score",
    "paper/scene",
    "sweep/about",
    "narration/vibration",
    "narration/separated",
];

/// Renders a template with named values; a missing value is an error.
pub fn fill(name: &str, values: Value) -> Result<String, Error> {
    static ENVIRONMENT: LazyLock<Result<Environment<'static>, Error>> = LazyLock::new(environment);
    match &*ENVIRONMENT {
        Ok(environment) => environment.get_template(name)?.render(values),
        Err(error) => Err(Error::new(error.kind(), error.to_string())),
    }
}

pub(super) fn environment() -> Result<Environment<'static>, Error> {
    let mut environment = Environment::new();
    // A line that contains only a tag produces no output.
    let mut syntax = SyntaxConfig::builder();
    environment.set_syntax(syntax.trim_blocks(true).lstrip_blocks(true).build()?);
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    for (name, text) in TEMPLATES {
        environment.add_template(name, text)?;
    }
    environment.add_filter("quantity", with_unit);
    environment.add_filter("percent", |x: Value| formatted(&x, percent));
    environment.add_filter("degrees", |x: Value| {
        formatted(&x, |x| format!("{:.1}°", x.to_degrees()))
    });
    environment.add_filter("decimals", |x: Value, digits: usize| {
        formatted(&x, |x| format!("{x:.digits$}"))
    });
    environment.add_filter("scientific", |x: Value, digits: usize| {
        formatted(&x, |x| format!("{x:.digits$e}"))
    });
    Ok(environment)
}

/// A value with an SI prefix and three significant digits, or `digits`.
fn with_unit(x: Value, unit: &str, digits: Option<usize>) -> Result<Value, Error> {
    formatted(&x, |x| quantity(x, digits.unwrap_or(3), unit))
}

/// A formatted number; none stays none.
fn formatted(x: &Value, format: impl Fn(f64) -> String) -> Result<Value, Error> {
    if x.is_undefined() {
        return Err(Error::from(ErrorKind::UndefinedError));
    }
    if x.is_none() {
        return Ok(x.clone());
    }
    Ok(Value::from(format(f64::try_from(x.clone())?)))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn every_template_is_embedded() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/text");
        let mut files = 0;
        for folder in [
            folder.clone(),
            folder.join("narration"),
            folder.join("paper"),
            folder.join("sweep"),
        ] {
            let entries = std::fs::read_dir(folder).unwrap().map(Result::unwrap);
            files += entries.filter(|entry| entry.path().is_file()).count();
        }
        assert_eq!(files, TEMPLATES.len());
    }

    #[test]
    fn a_missing_variable_is_an_error() {
        let error = fill("narration/separated", minijinja::context! { after => 1.0 });
        assert!(error.is_err(), "{error:?}");
    }
}

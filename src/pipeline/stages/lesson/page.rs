//! The form of a lesson.

/// What is there in place of a number that is not there yet.
const NOT_YET: &str = "not yet measured";

/// A lesson: what it is, what to look at, and what was computed and measured.
pub struct Page {
    /// The mechanism's name.
    pub title: &'static str,
    /// What it is, in a few sentences.
    pub explains: &'static str,
    /// What to look at now.
    pub look: &'static str,
    /// Names and values of what was computed before the run.
    pub computed: Vec<[String; 2]>,
    /// Names and values of what has been measured, as far as it has.
    pub measured: Vec<(String, Option<String>)>,
    /// What the numbers say, once they do.
    pub says: Option<String>,
}

impl Page {
    /// Adds a computed number.
    pub fn compute(&mut self, name: impl Into<String>, value: impl Into<String>) {
        self.computed.push([name.into(), value.into()]);
    }

    /// Adds a measured number, which may not be there yet.
    pub fn measure(&mut self, name: impl Into<String>, value: Option<String>) {
        self.measured.push((name.into(), value));
    }

    /// The whole in Markdown.
    pub fn markdown(&self) -> String {
        let mut text = format!(
            "## {}\n\n{}\n\n**Look at** {}\n",
            self.title, self.explains, self.look
        );
        if !self.computed.is_empty() {
            text += "\n| computed, before the run | |\n|---|---|\n";
            for [name, value] in &self.computed {
                text += &format!("| {name} | {value} |\n");
            }
        }
        text += "\n| measured, in this run so far | |\n|---|---|\n";
        for (name, value) in &self.measured {
            let value = value.as_ref().map(|value| format!("**{value}**"));
            text += &format!("| {name} | {} |\n", value.as_deref().unwrap_or(NOT_YET));
        }
        if let Some(says) = &self.says {
            text += &format!("\n{says}\n");
        }
        text
    }
}

//! What the commands say: text for the terminal, JSON for programs, from the same structures.
//!
//! The names and units of the JSON fields are stable: a field may be added in a later version,
//! none changes its meaning. Every number is in the unit at the end of its field's name. A number
//! that is not finite is written as `null`.

use std::fmt::Write as _;
use std::io::{self, Write as _};

use anstyle::{AnsiColor, Style};
use serde::Serialize;

use super::audit::AuditReport;
pub(super) use super::document::WrittenFile as FileReport;
use super::document::list;
use super::error::CliError;
use super::flow_report::{ButterflyReport, ExponentsReport};
use super::output::{OutputError, OutputFile};
use crate::VERSION;
use crate::escape;
use crate::pipeline::message::Summary;
use crate::scene::{Held, PRESETS, Scene, SceneError, SceneWarning};
use crate::study::growth::peak_memory;

const BAD: Style = AnsiColor::Red.on_default().bold();
const DOUBTFUL: Style = AnsiColor::Yellow.on_default().bold();
const NAME: Style = Style::new().bold();

/// A result that can be shown and written.
pub trait Report: Serialize {
    /// The text for the terminal, several lines.
    fn text(&self) -> String;
}

/// Result of `squeakscope scenes`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ScenesReport {
    /// Version of the program.
    pub version: &'static str,
    /// The scenes that come with it.
    pub scenes: Vec<SceneReport>,
}

/// One scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SceneReport {
    /// Name, as in `squeakscope run NAME`.
    pub name: String,
    /// One line that says what it shows.
    pub title: String,
    /// A few sentences (Markdown): what to look for.
    pub about: String,
    /// Simulated time, ms.
    pub duration_ms: f64,
    /// The scene file's text.
    pub toml: String,
}

impl SceneReport {
    /// What there is to say of a scene.
    pub fn new(scene: &Scene) -> Self {
        Self {
            name: scene.name.clone(),
            title: scene.title.clone(),
            about: scene.about.clone(),
            duration_ms: scene.duration * 1e3,
            toml: scene.text.clone(),
        }
    }
}

impl Report for SceneReport {
    /// The scene file's text, so that it can be saved and run.
    fn text(&self) -> String {
        self.toml.clone()
    }
}

impl ScenesReport {
    /// All scenes that come with the program.
    ///
    /// # Errors
    /// None, as long as the crate's tests pass: its own scenes are parsed like any other.
    pub fn of_presets() -> Result<Self, SceneError> {
        let scenes = PRESETS.iter().map(|preset| preset.scene());
        Ok(Self {
            version: VERSION,
            scenes: scenes
                .map(|scene| scene.map(|scene| SceneReport::new(&scene)))
                .collect::<Result<_, _>>()?,
        })
    }
}

impl Report for ScenesReport {
    fn text(&self) -> String {
        let names = self.scenes.iter().map(|scene| scene.name.len());
        let width = names.max().unwrap_or(0);
        let mut text = String::new();
        for scene in &self.scenes {
            let [name, title] = [&scene.name, &scene.title].map(|text| escape::line(text));
            let _ = writeln!(text, "{NAME}{name:width$}{NAME:#}  {title}");
        }
        text.push_str("\nsqueakscope scenes NAME prints one; squeakscope run NAME runs it\n");
        text
    }
}

/// Result of `squeakscope run`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunReport {
    /// Version of the program.
    pub version: &'static str,
    /// Name of the scene.
    pub scene: String,
    /// Whether Ctrl-C ended the run before its time.
    pub interrupted: bool,
    /// Simulated time, s.
    pub simulated_s: f64,
    /// Wall time of the whole run, s.
    pub wall_s: f64,
    /// Simulated seconds a second of the simulation thread.
    pub real_time_factor: f64,
    /// Strongest lines of the velocity's spectrum at the end, strongest first.
    pub lines: Vec<LineReport>,
    /// Half the peak-to-peak displacement (of a joint, of its central contact point) at the end, m.
    pub amplitude_m: f64,
    /// Largest speed of the same at the end, m/s.
    pub peak_velocity_m_per_s: f64,
    /// The most memory that the program has held, bytes; `null` where the system does not tell.
    pub peak_memory_bytes: Option<u64>,
    /// The integrator, as scenes name it.
    pub method: &'static str,
    /// Its tolerance; `null` where its step is fixed.
    pub tolerance: Option<f64>,
    /// Accepted steps of the integrator.
    pub steps: u64,
    /// Rejected steps of the integrator.
    pub rejections: u64,
    /// Calls of the right-hand side.
    pub calls: u64,
    /// Contact nodes that opened or closed; of a small system, events.
    pub transitions: u64,
    /// Relative residual of the energy audit at the end; `null` where there was none: only a joint has one,
    /// and only with samples of the energy.
    pub energy_residual: Option<f64>,
    /// The energy audit; `null` where nothing was audited.
    pub audit: Option<AuditReport>,
    /// Whether a joint was run, whose energy can be audited.
    #[serde(skip)]
    pub is_joint: bool,
    /// Steps that ran over their events, where steps stop at events.
    pub overrun_steps: u64,
    /// Lyapunov exponents, where the scene asks for them and the run has settled.
    pub exponents: Option<ExponentsReport>,
    /// How two copies have parted, where the scene asks for them and the second has started.
    pub butterfly: Option<ButterflyReport>,
    /// What is heard in the sound file, in a few words; `null` where there is none.
    pub heard: Option<String>,
    /// Files written.
    pub files: Vec<FileReport>,
}

/// A line of a spectrum.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LineReport {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Amplitude of the velocity, m/s.
    pub amplitude_m_per_s: f64,
    /// Name such as `f1`, `3 f1`, `f2 - 3 f1`; empty where nothing fits.
    pub label: String,
}

impl RunReport {
    /// What a run came to.
    pub fn new(scene: &Scene, summary: &Summary, files: Vec<FileReport>) -> Self {
        let lines = summary.peaks.iter().map(|peak| LineReport {
            frequency_hz: peak.frequency,
            amplitude_m_per_s: peak.amplitude,
            label: peak.label.clone(),
        });
        Self {
            version: VERSION,
            scene: scene.name.clone(),
            interrupted: summary.interrupted,
            simulated_s: summary.simulated,
            wall_s: summary.wall,
            real_time_factor: summary.real_time_factor,
            lines: lines.collect(),
            amplitude_m: summary.amplitude,
            peak_velocity_m_per_s: summary.peak_velocity,
            peak_memory_bytes: peak_memory(),
            method: scene.integrator.method.name(),
            tolerance: (!scene.integrator.method.has_fixed_step())
                .then_some(scene.integrator.tolerance),
            steps: summary.tally.steps,
            rejections: summary.tally.rejections,
            calls: summary.tally.calls,
            transitions: summary.transitions,
            energy_residual: summary.audit,
            audit: AuditReport::of(summary),
            is_joint: scene.joint().is_ok(),
            overrun_steps: summary.tally.overrun,
            exponents: summary.exponents.as_ref().map(ExponentsReport::new),
            butterfly: summary.parting.as_ref().map(ButterflyReport::new),
            heard: None,
            files,
        }
    }
}

impl Report for RunReport {
    fn text(&self) -> String {
        /// More lines than these are read in the recording.
        const LINES_SHOWN: usize = 6;

        let mut text = String::new();
        let _ = writeln!(
            text,
            "{NAME}{}{NAME:#}: {:.1} ms simulated in {:.2} s (simulation alone {:.2} x real time)",
            escape::line(&self.scene),
            self.simulated_s * 1e3,
            self.wall_s,
            self.real_time_factor
        );
        let place = match self.is_joint {
            true => " at the central contact point",
            false => "",
        };
        let _ = writeln!(
            text,
            "  amplitude {:.4} um, peak velocity {:.3} mm/s{place}",
            self.amplitude_m * 1e6,
            self.peak_velocity_m_per_s * 1e3
        );
        if self.lines.is_empty() {
            text.push_str("  no line in the spectrum\n");
        }
        for line in self.lines.iter().take(LINES_SHOWN) {
            let row = format!(
                "  {:>10.1} Hz {:>10.4} mm/s  {}",
                line.frequency_hz,
                line.amplitude_m_per_s * 1e3,
                line.label
            );
            let _ = writeln!(text, "{}", row.trim_end());
        }
        let events = match (self.is_joint, self.energy_residual) {
            (false, _) => format!("{} events", self.transitions),
            (true, Some(residual)) => format!(
                "{} contact transitions; energy residual {residual:.1e}",
                self.transitions
            ),
            (true, None) => format!(
                "{} contact transitions; energy not audited",
                self.transitions
            ),
        };
        let integrator = match self.tolerance {
            Some(tolerance) => format!("{} at {tolerance:e}", self.method),
            None => self.method.to_owned(),
        };
        let _ = writeln!(
            text,
            "  {integrator}: {} steps, {} rejected, {} calls; {events}",
            self.steps, self.rejections, self.calls
        );
        if let Some(exponents) = &self.exponents {
            text.push_str(&exponents.text());
        }
        if let Some(butterfly) = &self.butterfly {
            text.push_str(&butterfly.text());
        }
        if self.overrun_steps > 0 {
            let _ = writeln!(
                text,
                "  beware: contact nodes opened and closed too often to stop at each; {} steps ran over \
                 their events",
                self.overrun_steps
            );
        }
        if let Some(heard) = &self.heard {
            let _ = writeln!(text, "  heard: {heard}");
        }
        text += &list(&self.files);
        text
    }
}

/// Result of `squeakscope stability`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StabilityReport {
    /// Version of the program.
    pub version: &'static str,
    /// Name of the scene.
    pub scene: String,
    /// The tilts, in the order asked for.
    pub tilts: Vec<TiltReport>,
}

/// The modes at one tilt.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TiltReport {
    /// Tilt of the load, degrees.
    pub tilt_deg: f64,
    /// The modes, by frequency.
    pub modes: Vec<ModeReport>,
}

/// A complex eigenvalue at steady sliding.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ModeReport {
    /// Imaginary part over 2 pi: frequency, Hz.
    pub frequency_hz: f64,
    /// Real part: growth rate, 1/s.
    pub growth_per_s: f64,
    /// Which mode it is, such as `2nd bending x`.
    pub label: String,
    /// Whether it grows.
    pub unstable: bool,
    /// Why, where that was asked for; none of a mode that does not oscillate.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub causes: Vec<CauseReport>,
}

/// What one term of the linearised joint does to a mode.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CauseReport {
    /// The term, such as `negative slope`.
    pub cause: &'static str,
    /// Its share of the growth rate, 1/s; all of them add up to it.
    pub share_per_s: f64,
    /// The growth rate without the term, 1/s.
    pub without_per_s: f64,
}

impl Report for StabilityReport {
    fn text(&self) -> String {
        let labels = self.tilts.iter().flat_map(|tilt| &tilt.modes);
        let width = labels
            .map(|mode| mode.label.chars().count())
            .max()
            .unwrap_or(0);
        let mut text = String::new();
        for tilt in &self.tilts {
            let unstable = tilt.modes.iter().filter(|mode| mode.unstable).count();
            let _ = writeln!(
                text,
                "{NAME}{}{NAME:#} at {} deg: {unstable} of {} modes unstable",
                escape::line(&self.scene),
                tilt.tilt_deg,
                tilt.modes.len()
            );
            let causes = tilt.modes.iter().find(|mode| !mode.causes.is_empty());
            let causes = causes.map_or(&[][..], |mode| &mode.causes);
            let heads = causes
                .iter()
                .map(|cause| format!("  {:>CAUSE$}", cause.cause));
            let _ = writeln!(
                text,
                "  {:>12}  {:>12}{}  mode",
                "frequency Hz",
                "growth 1/s",
                heads.collect::<String>()
            );
            for mode in &tilt.modes {
                // Zero has no sign to a reader.
                let shares = mode.causes.iter().map(|cause| {
                    let both = format!(
                        "{:.1} ({:.1})",
                        cause.share_per_s + 0.0,
                        cause.without_per_s + 0.0
                    );
                    format!("  {both:>CAUSE$}")
                });
                let blank = if mode.causes.is_empty() {
                    " ".repeat((CAUSE + 2) * causes.len())
                } else {
                    String::new()
                };
                let row = format!(
                    "  {:>12.1}  {:>12.2}{}{blank}  {:width$}",
                    mode.frequency_hz,
                    mode.growth_per_s,
                    shares.collect::<String>(),
                    mode.label
                );
                let _ = if mode.unstable {
                    writeln!(text, "{row}  {BAD}unstable{BAD:#}")
                } else {
                    writeln!(text, "{}", row.trim_end())
                };
            }
            if !causes.is_empty() {
                text.push_str(
                    "  each cause with its share of the growth rate, and in brackets what the rate would be \
                     without it\n",
                );
            }
            text.push('\n');
        }
        text
    }
}

/// Width of a column of causes.
const CAUSE: usize = 18;

/// Result of `squeakscope model`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ModelReport {
    /// Version of the program.
    pub version: &'static str,
    /// Name of the scene.
    pub scene: String,
    /// Number of contact nodes.
    pub nodes: usize,
    /// Number of modes.
    pub modes: usize,
    /// The file with the arrays.
    pub file: FileReport,
}

impl Report for ModelReport {
    fn text(&self) -> String {
        format!(
            "{NAME}{}{NAME:#}: {} contact nodes, {} modes in {} ({} bytes)\n",
            escape::line(&self.scene),
            self.nodes,
            self.modes,
            escape::path(&self.file.path),
            self.file.bytes
        )
    }
}

/// Adds the files written, a line each with its size.
pub(super) fn list_files(text: &mut String, files: &[FileReport]) {
    text.push_str(&list(files));
}

/// From radians back to the decimal of degrees that was written.
pub(super) fn degrees(radians: f64) -> f64 {
    (radians.to_degrees() * 1e9).round() / 1e9
}

/// Shows a result, and writes it as JSON if asked for.
///
/// # Errors
/// When the JSON file cannot be written.
pub fn deliver(report: &impl Report, json: Option<&OutputFile>) -> Result<(), OutputError> {
    let written = write_json(report, json);
    print(&report.text())?;
    written
}

/// Writes a result as JSON, where a file is given.
///
/// # Errors
/// When it cannot be written.
pub fn write_json(report: &impl Report, json: Option<&OutputFile>) -> Result<(), OutputError> {
    let Some(file) = json else {
        return Ok(());
    };
    file.write(|out| {
        serde_json::to_writer_pretty(&mut *out, report)?;
        writeln!(out)
    })
}

/// Prints a result as JSON in place of its text.
///
/// # Errors
/// When it cannot be written.
pub fn print_json(report: &impl Report) -> Result<(), OutputError> {
    let json = serde_json::to_string_pretty(report)
        .map_err(|fault| OutputError::Terminal(fault.into()))?;
    print(&format!("{json}\n"))
}

/// Prints to the standard output, in colour where that is a terminal.
///
/// # Errors
/// When it cannot be written. A reader that has seen enough (`| head`) is no error.
pub fn print(text: &str) -> Result<(), OutputError> {
    let mut out = anstream::stdout().lock();
    match out
        .write_all(escape::terminal(text).as_bytes())
        .and_then(|()| out.flush())
    {
        Err(source) if source.kind() != io::ErrorKind::BrokenPipe => {
            Err(OutputError::Terminal(source))
        }
        _ => Ok(()),
    }
}

/// Prints warnings to the standard error.
pub fn print_warnings(warnings: &[SceneWarning]) {
    for warning in warnings {
        print_warning(&warning.to_string());
    }
}

/// Prints a warning to the standard error.
pub fn print_warning(warning: &str) {
    tell(&format!("{DOUBTFUL}warning:{DOUBTFUL:#}"), warning);
}

/// Says on the standard error what is held where, though it varies in the scene.
pub fn print_held(held: Held) {
    if let Some(words) = held.words() {
        print_warning(&format!(
            "the scene changes with time; here it is held at its first values: {words}"
        ));
    }
}

/// Prints an error and what caused it to the standard error, on one line.
pub fn print_error(error: &CliError) {
    let mut message = error.to_string();
    let mut cause = std::error::Error::source(error);
    while let Some(error) = cause {
        let _ = write!(message, ": {error}");
        cause = error.source();
    }
    tell(&format!("{BAD}error:{BAD:#}"), &message);
}

/// Prints a message to the standard error, on one line whatever is in it. That nobody reads it, as when it goes
/// into a file on a full disk, changes nothing.
fn tell(head: &str, message: &str) {
    let _ = writeln!(anstream::stderr(), "{head} {}", escape::line(message));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::message::SpectralLine;

    fn json(report: &impl Report) -> serde_json::Value {
        serde_json::to_value(report).expect("serialises")
    }

    #[test]
    fn stability_json_has_the_documented_fields() {
        let report = StabilityReport {
            version: VERSION,
            scene: "s".to_owned(),
            tilts: vec![TiltReport {
                tilt_deg: 3.5,
                modes: vec![
                    ModeReport {
                        frequency_hz: 1780.1,
                        growth_per_s: 766.6,
                        label: "1st bending x".to_owned(),
                        unstable: true,
                        causes: Vec::new(),
                    },
                    ModeReport {
                        frequency_hz: 4501.0,
                        growth_per_s: -0.25,
                        label: "1st torsion".to_owned(),
                        unstable: false,
                        causes: Vec::new(),
                    },
                ],
            }],
        };
        let value = json(&report);
        assert_eq!(value["tilts"][0]["tilt_deg"], 3.5);
        let mode = &value["tilts"][0]["modes"][0];
        assert_eq!(mode["frequency_hz"], 1780.1);
        assert_eq!(mode["growth_per_s"], 766.6);
        assert_eq!(mode["label"], "1st bending x");
        assert_eq!(mode["unstable"], true);
        let text = anstream::adapter::strip_str(&report.text()).to_string();
        assert!(
            text.starts_with("s at 3.5 deg: 1 of 2 modes unstable\n"),
            "{text}"
        );
        assert_eq!(text.matches("  unstable\n").count(), 1, "{text}");
    }

    #[test]
    fn run_report_carries_the_summary() {
        let scene = Scene::load("periodic-2deg").expect("preset");
        let summary = Summary {
            simulated: 0.1,
            amplitude: 0.69e-6,
            peak_velocity: f64::NAN,
            peaks: vec![SpectralLine {
                frequency: 4117.0,
                amplitude: 0.016,
                label: "f1".to_owned(),
            }],
            ..Summary::default()
        };
        let report = RunReport::new(&scene, &summary, Vec::new());
        let value = json(&report);
        assert_eq!(value["scene"], "periodic-2deg");
        assert_eq!(value["amplitude_m"], 0.69e-6);
        assert_eq!(value["lines"][0]["frequency_hz"], 4117.0);
        assert_eq!(value["peak_velocity_m_per_s"], serde_json::Value::Null);
        let text = report.text();
        assert!(text.contains("4117.0 Hz"), "{text}");
        assert!(text.contains("amplitude 0.6900 um"), "{text}");
    }
}

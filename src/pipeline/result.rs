//! The result of a run with its conclusions, and its report.

use schemars::JsonSchema;
use serde::Serialize;

use super::message::{RunExponents, SpectralLine, Summary, TrajectoryDivergence};
use crate::number::{quantity, significant};
use crate::report::{Block, Measured, Report, Table};
use crate::scene::{Integrator, Scene};

/// The result of a run.
#[derive(Debug, Serialize, JsonSchema)]
pub struct RunResult<'a> {
    /// Summary of the run.
    #[serde(flatten)]
    pub summary: &'a Summary,
    /// Lyapunov exponents; `null` if the scene does not compute them or the run has not settled.
    pub exponents: Option<RunExponents<'a>>,
    /// Peak memory: largest resident memory of the program, bytes; `null` if the system does not report it.
    pub peak_memory_bytes: Option<u64>,
    /// Integrator, as in the scene file.
    pub method: &'static str,
    /// Relative tolerance of a step; `null` for a fixed step.
    pub tolerance: Option<f64>,
    /// Energy audit; `null` if there was none.
    pub audit: Option<Audit>,
    /// Quantity, place and peak level of the sound file; `null` without a sound file.
    pub audio: Option<String>,
    /// Whether the scene has a joint.
    #[serde(skip)]
    is_joint: bool,
}

impl<'a> RunResult<'a> {
    /// The result of a run of a scene; `audio` describes its sound file.
    pub fn new(scene: &Scene, summary: &'a Summary, audio: Option<String>) -> Self {
        let Integrator {
            method, tolerance, ..
        } = scene.integrator;
        Self {
            summary,
            exponents: summary.exponents.as_ref().map(RunExponents::new),
            peak_memory_bytes: peak_memory(),
            method: method.name(),
            tolerance: (!method.has_fixed_step()).then_some(tolerance),
            audit: Audit::of(summary),
            audio,
            is_joint: scene.joint().is_ok(),
        }
    }
}

/// Peak memory of this process, bytes. `None` if the system does not report it (Linux does).
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let mut lines = status.lines();
    let line = lines.find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kilobytes: u64 = line.trim().strip_suffix(" kB")?.parse().ok()?;
    Some(1024 * kilobytes)
}

/// Limit of the relative residual above which a warning is printed.
const LIMIT: f64 = 0.05;

/// Result of the energy audit of a run: the balance of energy and work.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Audit {
    /// Residual of the energy balance over the largest energy or work.
    pub residual: f64,
    /// Limit of the residual above which a warning is printed.
    pub limit: f64,
    /// Whether the residual is at most the limit.
    pub holds: bool,
}

impl Audit {
    /// The audit of a run; `None` if there was none.
    pub fn of(summary: &Summary) -> Option<Self> {
        summary.energy_residual.map(|residual| Self {
            residual,
            limit: LIMIT,
            holds: residual <= LIMIT,
        })
    }
}

impl Report for RunResult<'_> {
    fn blocks(&self, scene: &str) -> Vec<Block> {
        let summary = self.summary;
        let rest = format!(
            ": {:.1} ms simulated in {:.2} s (simulation alone: {:.2} x real time)",
            summary.simulated_s * 1e3,
            summary.wall_s,
            summary.real_time_factor,
        );
        let place = if self.is_joint {
            " at the central contact point"
        } else {
            ""
        };
        let mut blocks = vec![
            Block::heading(scene, rest),
            Block::text(format!(
                "amplitude {}, peak velocity {}{place}",
                quantity(summary.amplitude_m, 4, "m"),
                quantity(summary.peak_velocity_m_per_s, 4, "m/s")
            )),
        ];
        if let Some(motion) = summary.describe_motion() {
            blocks.push(Block::text(format!("type of motion: {motion}")));
        }
        if !summary.at_rest {
            blocks.push(lines(&summary.lines));
        }
        blocks.extend(self.integration());
        blocks.extend(self.exponents.iter().map(|it| Block::text(it.line())));
        blocks.extend(summary.divergence.iter().map(divergence_line));
        let passed = summary.stats.steps_without_event_location;
        if passed > 0 {
            blocks.push(Block::Warning(format!(
                "{passed} steps passed contact events without locating them, because the events were too frequent"
            )));
        }
        if let Some(audio) = &self.audio {
            blocks.push(Block::text(format!("sound: {audio}")));
        }
        if !summary.facts.is_empty() {
            blocks.push(Block::heading("lesson", ""));
        }
        let facts = summary.facts.iter().map(|fact| Block::Text(fact.line()));
        blocks.extend(facts);
        blocks
    }

    fn is_interrupted(&self) -> bool {
        self.summary.interrupted
    }
}

/// The strongest lines of the spectrum. The recording has all of them.
fn lines(lines: &[SpectralLine]) -> Block {
    const MAX_LINES: usize = 6;
    if lines.is_empty() {
        return Block::text("no lines in the spectrum");
    }
    Table::of(lines.iter().take(MAX_LINES))
        .right("", |line| format!("{:.1} Hz", line.frequency))
        .right("", |line| format!("{:.4} mm/s", line.amplitude * 1e3))
        .left("", |line| line.label.clone())
        .into()
}

/// The divergence of the perturbed trajectory.
fn divergence_line(divergence: &TrajectoryDivergence) -> Block {
    let rate = divergence.line.map(|line| {
        let rate =
            |sign: f64| Measured::new(sign * line.rate_per_s, line.half_width_per_s).unit("1/s");
        if line.grows() {
            format!(", growing at {}", rate(1.0))
        } else if line.shrinks() {
            format!(", shrinking at {}", rate(-1.0))
        } else {
            format!(", no significant growth ({})", rate(1.0))
        }
    });
    let saturation = match divergence.saturated_s {
        Some(time) => format!("saturated at {:.0} ms", 1e3 * time),
        None => "not saturated".to_owned(),
    };
    Block::text(format!(
        "perturbed trajectory, started at {:.0} ms: relative distance {:.1e}{}, {saturation}",
        1e3 * divergence.start_s,
        divergence.distance,
        rate.unwrap_or_default()
    ))
}

impl RunResult<'_> {
    /// The integrator, its statistics and the energy residual.
    fn integration(&self) -> Vec<Block> {
        let Summary {
            stats, transitions, ..
        } = self.summary;
        let events = match (self.is_joint, self.summary.energy_residual) {
            (false, _) => format!("{transitions} events"),
            (true, Some(residual)) => format!(
                "{transitions} contact transitions; relative energy residual {residual:.1e}"
            ),
            (true, None) => format!("{transitions} contact transitions; no energy audit"),
        };
        let tolerance = self.tolerance;
        let tolerance = tolerance.map_or(String::new(), |tolerance| {
            format!(", tolerance {tolerance:e}")
        });
        let mut blocks = vec![Block::text(format!(
            "{}{tolerance}: {} steps, {} rejected, {} right-hand-side evaluations; {events}",
            self.method, stats.steps, stats.rejections, stats.rhs_evals,
        ))];
        if let Some(rate) = self.summary.analysis_rate.filter(|rate| *rate < 1.0) {
            let percent = significant(100.0 * rate, 2);
            blocks.push(Block::text(format!(
                "analyses at {percent} % of their rate, to keep up with real time"
            )));
        }
        blocks
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::message::DivergenceFit;

    #[test]
    fn the_result_contains_the_summary() {
        let scene = Scene::load("chaos-5deg").expect("preset");
        let summary = Summary {
            simulated_s: 0.1,
            amplitude_m: 0.69e-6,
            peak_velocity_m_per_s: f64::NAN,
            lines: vec![SpectralLine {
                frequency: 4117.0,
                amplitude: 0.016,
                label: "f1".to_owned(),
            }],
            ..Summary::default()
        };
        let result = RunResult::new(&scene, &summary, None);
        crate::report::agreement::check(&result, &[]);
        let value = serde_json::to_value(&result).expect("JSON");
        assert_eq!(value["amplitude_m"], 0.69e-6);
        assert_eq!(value["lines"][0]["frequency_hz"], 4117.0);
        assert_eq!(value["lines"][0]["amplitude"], 0.016);
        assert_eq!(value["steps"], 0);
        assert_eq!(value["peak_velocity_m_per_s"], serde_json::Value::Null);
        let text = crate::report::markdown(&result.blocks(&scene.name));
        assert!(text.contains("4117.0 Hz"), "{text}");
        assert!(text.contains("amplitude 690.0 nm"), "{text}");
    }

    #[test]
    fn divergence_is_printed_in_a_line() {
        let line = |divergence: &TrajectoryDivergence| {
            crate::report::markdown(&[divergence_line(divergence)])
        };
        let mut divergence = TrajectoryDivergence {
            time_s: 0.2,
            start_s: 0.05,
            distance: 2e-3,
            line: None,
            saturated_s: None,
        };
        assert_eq!(
            line(&divergence),
            "perturbed trajectory, started at 50 ms: relative distance 2.0e-3, not saturated\n"
        );
        divergence.line = Some(DivergenceFit {
            rate_per_s: 70.0,
            half_width_per_s: 5.0,
            since_s: 0.06,
            intercept: 0.0,
        });
        divergence.saturated_s = Some(0.18);
        let text = line(&divergence);
        assert!(text.ends_with("growing at 70.0 ± 5.0 1/s, saturated at 180 ms\n"));
        divergence.line = divergence.line.map(|line| DivergenceFit {
            rate_per_s: 3.0,
            ..line
        });
        let text = line(&divergence);
        assert!(
            text.contains("no significant growth (3.0 ± 5.0 1/s)"),
            "{text}"
        );
    }
}

//! State of the solver: accuracy of its steps, cost, queues.

use super::stream::RecordingStream;
use super::style::short;
use super::text;
use crate::pipeline::message::Health;
use crate::plot::Color;

/// Names of the series of steps and of queues.
const STEPS: [&str; 3] = [
    "steps per ms",
    "rejected steps per ms",
    "contact transitions per ms",
];
const QUEUES: [&str; 3] = ["frames in queue", "records in queue", "pictures replaced"];

/// Logs the current state of the solver.
pub fn log(rec: &RecordingStream, health: &Health) {
    let error = health.error.map(|error| error.ratio);
    let [frames, records] = [health.frames_waiting, health.records_waiting];
    let queues = [frames, records, health.drops as usize].map(|count| count as f64);
    let steps = [
        health.steps_per_ms,
        health.rejections_per_ms,
        health.events_per_ms,
    ];
    let log = |id: &str, names: &[&str], values: &[f64]| {
        let path = &format!("solver/{id}");
        rec.name(path, names.iter().copied().zip((0..).map(Color::Series)));
        if !values.is_empty() {
            rec.row(path, health.time, values.iter().copied());
        }
    };
    let [calls, speed] = [health.rhs_evals_per_ms, health.real_time_factor];
    let ratio = ["local error over tolerance"];
    log("local_error", &ratio, error.as_slice());
    log("rhs_evals", &["RHS evals per ms"], &[calls]);
    log("real_time_factor", &["simulated s per s"], &[speed]);
    log("steps", &STEPS, &steps);
    log("queues", &QUEUES, &queues);
    let residual = ["relative energy residual"];
    log("energy_residual", &residual, health.audit.as_slice());
    let document = text::document(markdown(health));
    rec.log("solver/text", health.time, &document);
}

/// Accuracy and cost of the current steps as a line of text.
fn markdown(health: &Health) -> String {
    let error = match health.error {
        Some(error) => format!(
            "Largest local error of a step: **{:.1e}** ({} of the tolerance {:.0e})",
            error.relative(),
            short(error.ratio),
            error.tolerance
        ),
        None => "The steps have no error estimate".to_owned(),
    };
    let calls = short(1e3 * health.rhs_evals_per_ms);
    let speed = match health.real_time_factor {
        factor if factor > 0.0 => {
            let [seconds, factor] = [factor.recip(), factor].map(short);
            format!(
                " and **{seconds} s** of wall time per simulated second ({factor} times real time)"
            )
        }
        _ => " per simulated second".to_owned(),
    };
    format!("{error}. **{calls}** right-hand-side evaluations{speed}.")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::ErrorEstimate;

    #[test]
    fn accuracy_and_cost_are_a_line_of_text() {
        let health = Health {
            real_time_factor: 1.4,
            rhs_evals_per_ms: 1100.0,
            error: Some(ErrorEstimate {
                ratio: 0.9,
                tolerance: 1e-5,
            }),
            ..Health::default()
        };
        assert_eq!(
            markdown(&health),
            "Largest local error of a step: **9.0e-6** (0.9 of the tolerance 1e-5). \
             **1.1e6** right-hand-side evaluations and **0.714 s** of wall time per simulated \
             second (1.4 times real time)."
        );
        let fixed = Health {
            rhs_evals_per_ms: 0.5,
            ..Health::default()
        };
        assert_eq!(
            markdown(&fixed),
            "The steps have no error estimate. **500** right-hand-side evaluations per \
             simulated second."
        );
    }
}

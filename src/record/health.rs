//! State of the solver: accuracy of its steps, cost, queues.

use super::{
    error::RecordError,
    paths,
    samples::Rows,
    stream::{self, RecordingStream},
    style::{self, short},
    text,
};
use crate::pipeline::message::Health;

/// Names the series.
pub fn name(rec: &RecordingStream, rows: &mut Rows) -> Result<(), RecordError> {
    let entities: [(&str, &[&str]); 6] = [
        (paths::SOLVER_ERROR, &["local error over tolerance"]),
        (paths::SOLVER_RHS_EVALS, &["RHS evals per ms"]),
        (paths::SOLVER_SPEED, &["simulated s per s"]),
        (
            paths::SOLVER_STEPS,
            &[
                "steps per ms",
                "rejected steps per ms",
                "contact transitions per ms",
            ],
        ),
        (
            paths::SOLVER_QUEUES,
            &["frames in queue", "records in queue", "pictures replaced"],
        ),
        (paths::SOLVER_ENERGY_RESIDUAL, &["relative energy residual"]),
    ];
    for (path, names) in entities {
        let colors = style::MODES.into_iter().step_by(2);
        rows.name(rec, path, names.iter().copied().zip(colors))?;
    }
    Ok(())
}

/// Logs the current state of the solver.
pub fn log(rec: &RecordingStream, rows: &mut Rows, health: &Health) -> Result<(), RecordError> {
    let steps = [
        health.steps_per_ms,
        health.rejections_per_ms,
        health.events_per_ms,
    ];
    let queues = [health.frames_waiting, health.records_waiting].map(|count| count as f64);
    let queues = queues.into_iter().chain([health.drops as f64]);
    let mut push = |path, values: Vec<f64>| rows.push(path, health.time, values);
    if let Some(error) = health.error {
        push(paths::SOLVER_ERROR, vec![error.ratio]);
    }
    push(paths::SOLVER_RHS_EVALS, vec![health.rhs_evals_per_ms]);
    push(paths::SOLVER_SPEED, vec![health.real_time_factor]);
    push(paths::SOLVER_STEPS, steps.to_vec());
    push(paths::SOLVER_QUEUES, queues.collect());
    if let Some(audit) = health.audit {
        push(paths::SOLVER_ENERGY_RESIDUAL, vec![audit]);
    }
    let words = text::document(words(health));
    stream::log_at(rec, paths::SOLVER_TEXT, health.time, &words)
}

/// Accuracy and cost of the current steps as a line of text.
fn words(health: &Health) -> String {
    let error = match health.error {
        Some(error) => format!(
            "Largest local error of a step: **{:.1e}** ({} of the tolerance {:.0e})",
            error.relative(),
            short(error.ratio),
            error.tolerance
        ),
        None => "The steps have no error estimate".to_owned(),
    };
    let calls = many(1e3 * health.rhs_evals_per_ms);
    let speed = match health.real_time_factor {
        factor if factor > 0.0 => format!(
            " and **{} s** of wall time per simulated second ({} times real time)",
            short(factor.recip()),
            short(factor)
        ),
        _ => " per simulated second".to_owned(),
    };
    format!("{error}. **{calls}** right-hand-side evaluations{speed}.")
}

/// A count, in millions if it is large.
fn many(count: f64) -> String {
    if count >= 1e6 {
        format!("{} million", short(1e-6 * count))
    } else {
        short(count)
    }
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
            words(&health),
            "Largest local error of a step: **9.0e-6** (0.9 of the tolerance 1e-5). \
             **1.1 million** right-hand-side evaluations and **0.714 s** of wall time per simulated \
             second (1.4 times real time)."
        );
        let fixed = Health {
            rhs_evals_per_ms: 0.5,
            ..Health::default()
        };
        assert_eq!(
            words(&fixed),
            "The steps have no error estimate. **500** right-hand-side evaluations per \
             simulated second."
        );
    }
}

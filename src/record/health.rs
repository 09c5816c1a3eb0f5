//! How the run is doing: how accurate its steps are, what they cost, what waits.

use rerun::Scalars;

use super::{
    error::RecordError,
    paths,
    samples::name_series,
    stream::{self, RecordingStream},
    style::{self, short},
    text,
};
use crate::pipeline::message::Health;

/// Names the series.
pub fn name(rec: &RecordingStream) -> Result<(), RecordError> {
    let entities: [(&str, &[&str]); 6] = [
        (paths::HEALTH_ERROR, &["local error over the tolerance"]),
        (paths::HEALTH_CALLS, &["right-hand sides per ms"]),
        (paths::HEALTH_SPEED, &["simulated s per s"]),
        (
            paths::HEALTH_WORK,
            &[
                "steps per ms",
                "rejections per ms",
                "contact transitions per ms",
            ],
        ),
        (
            paths::HEALTH_QUEUES,
            &["frames waiting", "records waiting", "pictures replaced"],
        ),
        (paths::HEALTH_AUDIT, &["relative energy residual"]),
    ];
    for (path, names) in entities {
        let names = names.iter().map(|name| (*name).to_owned());
        let colors = style::MODES.into_iter().step_by(2).take(names.len());
        name_series(rec, path, names, colors)?;
    }
    Ok(())
}

/// Logs how the run is doing now; rare enough to go row by row.
pub fn log(rec: &RecordingStream, health: &Health) -> Result<(), RecordError> {
    let log = |path, values: &[f64]| {
        let values = Scalars::new(values.iter().copied());
        stream::log_at(rec, path, health.time, &values)
    };
    if let Some(error) = health.error {
        log(paths::HEALTH_ERROR, &[error.ratio])?;
    }
    log(paths::HEALTH_CALLS, &[health.calls_per_ms])?;
    log(paths::HEALTH_SPEED, &[health.real_time_factor])?;
    log(
        paths::HEALTH_WORK,
        &[
            health.steps_per_ms,
            health.rejections_per_ms,
            health.events_per_ms,
        ],
    )?;
    log(
        paths::HEALTH_QUEUES,
        &[
            health.frames_waiting as f64,
            health.records_waiting as f64,
            health.drops as f64,
        ],
    )?;
    if let Some(audit) = health.audit {
        log(paths::HEALTH_AUDIT, &[audit])?;
    }
    let words = text::document(words(health));
    stream::log_at(rec, paths::HEALTH_WORDS, health.time, &words)
}

/// How accurate the steps are and what they cost now, in a line.
fn words(health: &Health) -> String {
    let error = match health.error {
        Some(error) => format!(
            "Local error of a step at most **{:.1e}** ({} of the tolerance {:.0e})",
            error.relative(),
            short(error.ratio),
            error.tolerance
        ),
        None => "Steps without an estimate of their error".to_owned(),
    };
    let calls = many(1e3 * health.calls_per_ms);
    let speed = match health.real_time_factor {
        factor if factor > 0.0 => format!(
            " and **{} s** of computing a simulated second ({} times real time)",
            short(factor.recip()),
            short(factor)
        ),
        _ => " a simulated second".to_owned(),
    };
    format!("{error}. **{calls}** calls of the right-hand side{speed}.")
}

/// A large number as people say it.
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
    fn accuracy_and_cost_are_a_line_of_words() {
        let health = Health {
            real_time_factor: 1.4,
            calls_per_ms: 1100.0,
            error: Some(ErrorEstimate {
                ratio: 0.9,
                tolerance: 1e-5,
            }),
            ..Health::default()
        };
        assert_eq!(
            words(&health),
            "Local error of a step at most **9.0e-6** (0.9 of the tolerance 1e-5). \
             **1.1 million** calls of the right-hand side and **0.714 s** of computing a simulated \
             second (1.4 times real time)."
        );
        let fixed = Health {
            calls_per_ms: 0.5,
            ..Health::default()
        };
        assert_eq!(
            words(&fixed),
            "Steps without an estimate of their error. **500** calls of the right-hand side a \
             simulated second."
        );
    }
}

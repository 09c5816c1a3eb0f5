//! Short searches.

use super::*;

struct Notes {
    trials: Vec<Trial>,
    stop_after: usize,
}

impl CalibrationObserver for Notes {
    type Error = ThreadSpawnError;

    fn on_trial(&mut self, trial: &Trial) -> Result<(), Self::Error> {
        self.trials.push(trial.clone());
        Ok(())
    }

    fn on_screening(&mut self, done: usize) -> bool {
        assert!(done <= 40);
        true
    }

    fn on_progress(&mut self, done: usize, best: Option<&Trial>) -> bool {
        assert_eq!(best.is_some(), done > 0);
        self.trials.len() < self.stop_after
    }
}

fn notes(stop_after: usize) -> Notes {
    Notes {
        trials: Vec::new(),
        stop_after,
    }
}

fn plan() -> CalibrationPlan {
    let tolerance = (Parameter::named("time.tolerance").unwrap(), 1e-3);
    CalibrationPlan {
        base: Scene::load("periodic-2deg")
            .unwrap()
            .with_values(&[tolerance])
            .unwrap(),
        seed: 5,
        screened: 40,
        starts: 2,
        generations: 1,
        population: 4,
        response: ResponsePlan {
            min_transient: 0.01,
            max_transient: 0.02,
            measurement_time: 0.02,
            ..RESPONSE
        },
    }
}

#[test]
fn a_search_depends_only_on_its_plan() {
    let plan = plan();
    let mut all = notes(usize::MAX);
    let result = calibrate(&plan, &[], 2, &mut all).unwrap();
    let trials = &result.trials;
    assert!(result.complete && trials.len() == 6 && all.trials.len() == 6);
    assert_eq!(result.screening.agreeing.iter().sum::<usize>(), 40);
    for (k, trial) in trials.iter().enumerate() {
        assert_eq!(trial.number, k);
        assert!(
            (0.0..=1.0).contains(&trial.score) && trial.score <= trial.fitness,
            "{trial:?}"
        );
    }
    assert!(trials.iter().any(|trial| trial.score > 0.0));
    // Interrupted and resumed.
    let mut some = notes(2);
    let part = calibrate(&plan, &[], 2, &mut some).unwrap();
    assert!(!part.complete && part.trials.len() < 6);
    let mut rest = notes(usize::MAX);
    let again = calibrate(&plan, &some.trials, 1, &mut rest).unwrap();
    assert_eq!(again, result);
    assert_eq!(rest.trials.len() + some.trials.len(), 6);
}

/// A trial without simulation.
fn trial(number: usize, candidate: Candidate, fitness: f64) -> Trial {
    Trial {
        number,
        candidate,
        start: StartingWay {
            kick_mm_per_s: 1.0,
            continued: false,
        },
        score: 0.0,
        fitness,
        claims_held: Vec::new(),
        claims_missed: Vec::new(),
        error: None,
    }
}

/// A search whose fitness is the closeness to a point: it improves the fittest start, then the next one.
#[test]
fn the_fittest_starts_are_improved_one_after_another() {
    let plan = CalibrationPlan {
        starts: 10,
        generations: 2 * GENERATIONS_PER_RUN,
        population: 12,
        ..plan()
    };
    let starts: Vec<_> = (0..10).map(|k| Candidate::random(1, k)).collect();
    let distance = |candidate: &Candidate| {
        let squares = candidate.positions.iter().map(|x| (x - 0.6).powi(2));
        squares.sum::<f64>().sqrt()
    };
    let mut trials: Vec<Trial> = Vec::new();
    for generation in 0..=plan.generations {
        let candidates = plan.generation(generation, &starts, &trials);
        assert_eq!(candidates, plan.generation(generation, &starts, &trials));
        for candidate in candidates {
            let fitness = 1.0 / (1.0 + distance(&candidate));
            trials.push(trial(trials.len(), candidate, fitness));
        }
    }
    assert_eq!(trials.len(), plan.len());
    let best = |trials: &[Trial]| distance(&ranked(trials)[0].candidate);
    let run = GENERATIONS_PER_RUN * plan.population;
    let simulated = ranked(&trials[..10]);
    for (k, trials) in trials[10..].chunks(run).enumerate() {
        let before = distance(&simulated[k].candidate);
        assert!(best(trials) < 0.7 * before, "{} {before}", best(trials));
        assert_eq!(trials[0].candidate.choices, simulated[k].candidate.choices);
    }
}

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
    let values = [
        (Parameter::named("nodes").unwrap(), 20.0),
        (Parameter::named("time.tolerance").unwrap(), 1e-3),
    ];
    CalibrationPlan {
        base: Scene::load("periodic-2deg")
            .unwrap()
            .with_values(&values)
            .unwrap(),
        seed: 5,
        generations: 2,
        population: 3,
    }
}

#[test]
fn a_search_depends_only_on_its_plan() {
    let plan = plan();
    let mut all = notes(usize::MAX);
    let (trials, complete) = calibrate(&plan, &[], 2, &mut all).unwrap();
    assert!(complete && trials.len() == 6 && all.trials.len() == 6);
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
    let (part, complete) = calibrate(&plan, &[], 2, &mut some).unwrap();
    assert!(!complete && part.len() < 6);
    let mut rest = notes(usize::MAX);
    let (again, complete) = calibrate(&plan, &some.trials, 1, &mut rest).unwrap();
    assert!(complete && again == trials);
    assert_eq!(rest.trials.len() + some.trials.len(), 6);
    // The trials of another search are not reused.
    let other = CalibrationPlan { seed: 6, ..plan };
    assert_eq!(other.generation(0, &[]).len(), 3);
    assert_ne!(other.generation(0, &[])[0], trials[0].candidate);
}

#[test]
fn the_fittest_candidates_are_the_parents() {
    let plan = CalibrationPlan {
        population: 20,
        ..plan()
    };
    let trials: Vec<Trial> = (0..20)
        .map(|number| Trial {
            number,
            candidate: Candidate::random(1, number as u64),
            score: 0.0,
            fitness: (number as f64 * 0.7).sin(),
            claims_held: Vec::new(),
            error: None,
        })
        .collect();
    let most = trials.iter().map(|trial| trial.fitness).fold(0.0, f64::max);
    assert_eq!(ranked(&trials)[0].fitness, most);
    let next = plan.generation(1, &trials);
    assert_eq!(next.len(), 20);
    // Later generations have a smaller mutation width.
    let later = plan.generation(9, &trials);
    assert_ne!(next, later);
    assert_eq!(
        next[..4],
        (20..24)
            .map(|k| Candidate::random(5, k))
            .collect::<Vec<_>>()
    );
}

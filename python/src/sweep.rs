//! Sweeps and basins: settled responses over parameters and kicks.

use std::num::NonZero;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use squeakscope::plot::{basins_figure, sweep_figures};
use squeakscope::study::basins::Basins;
use squeakscope::study::response::ResponsePlan;
use squeakscope::study::sweep::{
    Axis, Shard, Start, SweepPlan, SweepPoint, SweepResult, sweep as compute,
};
use squeakscope::study::{StudyError, Subject, threads};

use crate::array::{check_names, choice, optional, options, positive, vector, whole};
use crate::call::{Watch, long_call, watched_call};
use crate::error::{input, raise};
use crate::own::{OwnSystems, SEED, Studied};
use crate::result::Fields;

options! {
    /// How each response settles and is measured.
    Options {
        min_transient: Option<f64> = None,
        max_transient: Option<f64> = None,
        measure: Option<f64> = None,
        exponents: i64 = 3,
        threads: Option<i64> = None,
    }
}

impl Options {
    /// A plan of responses without what only pictures need. Times of own systems are in periods.
    fn response(&self, is_own: bool) -> PyResult<ResponsePlan> {
        let [least, most, measure] = if is_own {
            [80.0, 1600.0, 1000.0]
        } else {
            [0.05, 1.0, 0.6]
        };
        Ok(ResponsePlan {
            min_transient_s: positive("min_transient", self.min_transient.unwrap_or(least))?,
            max_transient_s: positive("max_transient", self.max_transient.unwrap_or(most))?,
            measurement_s: positive("measure", self.measure.unwrap_or(measure))?,
            exponents: whole("exponents", self.exponents, 0)?,
            orbits: true,
            portrait: false,
            max_rhs_evals: None,
        })
    }
}

/// A sweep of a scene, or of a caller's systems.
enum Swept {
    Scene(Box<SweepPlan>),
    Systems(SweepPlan<OwnSystems>),
}

impl Swept {
    fn new(
        py: Python<'_>,
        studied: Studied,
        given: Vec<(String, Vec<f64>)>,
        starts: Vec<Start>,
        options: &Options,
    ) -> PyResult<Self> {
        let given = given.into_iter();
        match studied {
            Studied::Scene(scene) => {
                let scene = scene.load(None)?;
                let axes = given.map(|(key, values)| {
                    let parameter = scene.parameter(&key).map_err(|error| raise(&error))?;
                    Ok(Axis::new(parameter, values))
                });
                Ok(Self::Scene(Box::new(SweepPlan {
                    axes: axes.collect::<PyResult<_>>()?,
                    subject: scene,
                    starts,
                    response: options.response(false)?,
                })))
            }
            Studied::Systems(function) => Ok(Self::Systems(SweepPlan {
                subject: OwnSystems::new(py, function)?,
                axes: given
                    .map(|(name, values)| Axis::new(name, values))
                    .collect(),
                starts,
                response: options.response(true)?,
            })),
        }
    }

    /// The points of a shard in ascending order of index.
    fn points(
        &self,
        py: Python<'_>,
        shard: Shard,
        options: &Options,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Vec<SweepPoint>> {
        let number = optional("threads", options.threads, 1)?.and_then(NonZero::new);
        match self {
            Self::Scene(plan) => long_call(py, progress, |watch| {
                computed(plan, shard, threads(number), watch)
            }),
            Self::Systems(plan) => plan.subject.call(py, progress, |watch| {
                computed(plan, shard, number.map_or(1, NonZero::get), watch)
            }),
        }
    }
}

/// The points of a shard, computed on a number of threads.
fn computed<S: Subject>(
    plan: &SweepPlan<S>,
    shard: Shard,
    threads: usize,
    watch: &Watch,
) -> Result<Vec<SweepPoint>, StudyError> {
    let mut report = |share, _: &str| watch.report(share);
    compute(plan, shard, Vec::new(), threads, &mut report, |_| Ok(()))
}

/// Compute the settled response over one or two parameters.
///
/// The results do not depend on the number of threads or of shards.
///
/// Parameters
/// ----------
/// scene : Scene, str, os.PathLike or callable
///     The scene, or its name or path; or a function of the parameters that returns a :class:`System`.
/// values : dict
///     One or two keys of the scene, or names of arguments, each with its values, in the unit of the scene file.
/// starts : sequence of {"fresh", "upward", "downward"}
///     Initial states: the kick of the scene, or the state at the next lower or higher value of the first key.
/// min_transient, max_transient : float, optional
///     Shortest and longest time for the motion to settle, by default 0.05 and 1 s; of own systems in periods, by default
///     80 and 1600.
/// measure : float, optional
///     Time of the measurement, by default 0.6 s; of own systems in periods, by default 1000. A quarter of it for a motion
///     of a scene that follows a stable periodic orbit.
/// exponents : int
///     Number of largest Lyapunov exponents; 0 for none.
/// shard : tuple of int, optional
///     Part to compute, and number of parts, such as (3, 8). By default (1, 1), the whole.
/// threads : int, optional
///     Number of threads. By default the number of cores, and one for own systems.
/// progress : callable, optional
///     Called with the share of the work that is done, 0 to 1.
///
/// Returns
/// -------
/// Result
///     ``points``, a row each, which has the values of the parameters by their keys, as ``row["load.tilt_deg"]``;
///     ``regime_intervals``, ``transitions``, ``hysteresis``, ``hysteresis_ends``. Displacements of own systems are the
///     first component of the state.
#[pyfunction]
#[pyo3(signature = (scene, values, *, starts=None, shard=None, progress=None, **options), text_signature = "(scene, values, \
    *, starts=None, min_transient=None, max_transient=None, measure=None, exponents=3, shard=None, threads=None, \
    progress=None)")]
pub fn sweep<'py>(
    py: Python<'py>,
    scene: Studied,
    values: &Bound<'py, PyDict>,
    starts: Option<Vec<String>>,
    shard: Option<(usize, usize)>,
    progress: Option<Bound<'py, PyAny>>,
    options: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyAny>> {
    let given = values.iter().map(|(key, values)| {
        let key = key.extract::<String>()?;
        let name = format!("values of {key}");
        Ok((key, vector(&name, &values)?.as_slice()?.to_vec()))
    });
    let given = given.collect::<PyResult<Vec<_>>>()?;
    if !(1..=2).contains(&given.len()) {
        return Err(input("values: give one or two keys"));
    }
    let known = Start::ALL.map(|start| (start.to_string(), start));
    let known: Vec<_> = known
        .iter()
        .map(|(name, start)| (name.as_str(), *start))
        .collect();
    let mut chosen: Vec<Start> = Vec::new();
    for word in starts.unwrap_or_else(|| vec!["upward".to_owned(), "downward".to_owned()]) {
        let start = choice("starts", &word, &known)?;
        if !chosen.contains(&start) {
            chosen.push(start);
        }
    }
    if chosen.is_empty() || given.iter().any(|(_, values)| values.is_empty()) {
        return Err(input("values, starts: there is no point to compute"));
    }
    let (number, of) = shard.unwrap_or((1, 1));
    if !(1..=of).contains(&number) {
        return Err(input(
            "shard: give the number of the part from 1, and the number of parts",
        ));
    }
    let shard = Shard { number, of };
    check_names(options, &[Options::NAMES])?;
    let options = Options::of(options)?;
    let swept = Swept::new(py, scene, given, chosen, &options)?;
    let points = swept.points(py, shard, &options, progress.as_ref())?;
    // Those of own systems have no units, and no figures.
    let fields = match swept {
        Swept::Systems(plan) => {
            let all = SweepResult::new(&plan, points, shard);
            Fields::of(py, &all)?.unitless(&plan.names())
        }
        Swept::Scene(plan) => {
            let watch = Watch::default();
            watch.show(1.0);
            let all = watched_call(py, progress.as_ref(), &watch, |watch| {
                let all = SweepResult::new(&plan, points, shard);
                Ok::<_, StudyError>(all.concluded(&plan, &mut |share, _| watch.report(share)))
            })?;
            Fields::of(py, &all)?.drawn(move || sweep_figures(&plan, &all.points))
        }
    };
    fields?.finish::<SweepResult>()
}

/// Find coexisting attractors, and the share of random kicks that reach each.
///
/// Parameters
/// ----------
/// scene : Scene, str, os.PathLike or callable
///     The scene, or its name or path; or a function of ``seed`` that returns a :class:`System` with an initial state of
///     its own, as in ``lambda seed: System(rhs, numpy.random.default_rng(seed).uniform(-2, 2, 2), period)``.
/// kicks : int
///     Number of random kicks.
/// seed : int
///     Seed of the first kick; each further kick takes the next seed.
/// min_transient, max_transient, measure, exponents, threads, progress : optional
///     As for :func:`sweep`.
///
/// Returns
/// -------
/// Result
///     ``attractors`` in descending order of their share.
#[pyfunction]
#[pyo3(signature = (scene, kicks=20, *, seed=1, progress=None, **options), text_signature = "(scene, kicks=20, *, seed=1, \
    min_transient=None, max_transient=None, measure=None, exponents=3, threads=None, progress=None)")]
pub fn basins<'py>(
    py: Python<'py>,
    scene: Studied,
    kicks: i64,
    seed: i64,
    progress: Option<Bound<'py, PyAny>>,
    options: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyAny>> {
    let (kicks, first) = (whole("kicks", kicks, 1)?, whole("seed", seed, 0)?);
    let seeds = (first..first + kicks).map(|seed| seed as f64).collect();
    let key = match scene {
        Studied::Scene(_) => "start.seed",
        Studied::Systems(_) => SEED,
    };
    check_names(options, &[Options::NAMES])?;
    let options = Options::of(options)?;
    let given = vec![(key.to_owned(), seeds)];
    let swept = Swept::new(py, scene, given, vec![Start::Fresh], &options)?;
    let points = swept.points(py, Shard::WHOLE, &options, progress.as_ref())?;
    let fields = match swept {
        Swept::Systems(plan) => {
            Fields::of(py, &Basins::new(None, kicks, &points))?.unitless(&plan.names())
        }
        Swept::Scene(plan) => {
            let found = Basins::new(plan.subject.start_tilt(), kicks, &points);
            Fields::of(py, &found)?.drawn(move || {
                let attractors = &found.attractors;
                vec![basins_figure(&plan.subject.name, &points, attractors)]
            })
        }
    };
    fields?.finish::<Basins>()
}

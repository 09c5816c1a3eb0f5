//! Sweeps and basins: settled responses over parameters and kicks.

use std::num::NonZero;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use squeakscope::plot::{Figure, basins_figure, sweep_figures};
use squeakscope::scene::Scene;
use squeakscope::study::basins::Basins;
use squeakscope::study::response::ResponsePlan;
use squeakscope::study::sweep::{
    Axis, Grid, Shard, Start, SweepPlan, SweepPoint, SweepResult, sweep as sweep_scene,
    sweep_subject,
};
use squeakscope::study::{StudyError, threads};

use crate::array::{check_names, choice, optional, options, positive, vector, whole};
use crate::call::long_call;
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
            min_transient: positive("min_transient", self.min_transient.unwrap_or(least))?,
            max_transient: positive("max_transient", self.max_transient.unwrap_or(most))?,
            measurement_time: positive("measure", self.measure.unwrap_or(measure))?,
            exponents: whole("exponents", self.exponents, 0)?,
            orbits: true,
            portrait: false,
            max_rhs_evals: None,
        })
    }
}

/// The points of a sweep in ascending order of index.
fn collected(
    sweep: impl FnOnce(&mut dyn FnMut(SweepPoint) -> Result<(), StudyError>) -> Result<(), StudyError>,
) -> Result<Vec<SweepPoint>, StudyError> {
    let mut points = Vec::new();
    sweep(&mut |point| {
        points.push(point);
        Ok(())
    })?;
    points.sort_by_key(|point: &SweepPoint| point.place.index);
    Ok(points)
}

/// What is swept over one or two parameters.
struct Swept {
    names: Vec<String>,
    labels: Vec<String>,
    /// Values of each parameter, ascending.
    values: Vec<Vec<f64>>,
    of: Of,
}

enum Of {
    Scene(Box<Scene>, Vec<Axis>),
    Systems(OwnSystems),
}

impl Swept {
    fn new(py: Python<'_>, studied: Studied, given: Vec<(String, Vec<f64>)>) -> PyResult<Self> {
        match studied {
            Studied::Scene(scene) => {
                let scene = scene.load(None)?;
                let axes = given.into_iter().map(|(key, values)| {
                    let parameter = scene.parameter(&key).map_err(|error| raise(&error))?;
                    Ok(Axis::new(parameter, values))
                });
                let axes = axes.collect::<PyResult<Vec<_>>>()?;
                Ok(Self {
                    names: axes
                        .iter()
                        .map(|axis| axis.parameter().path().to_owned())
                        .collect(),
                    labels: axes.iter().map(Axis::label).collect(),
                    values: axes.iter().map(|axis| axis.values().to_vec()).collect(),
                    of: Of::Scene(Box::new(scene), axes),
                })
            }
            Studied::Systems(function) => {
                let (names, mut values): (Vec<_>, Vec<_>) = given.into_iter().unzip();
                for values in &mut values {
                    values.sort_by(f64::total_cmp);
                    values.dedup();
                }
                Ok(Self {
                    labels: names.clone(),
                    of: Of::Systems(OwnSystems::new(py, function, names.clone())?),
                    names,
                    values,
                })
            }
        }
    }

    fn is_own(&self) -> bool {
        matches!(self.of, Of::Systems(_))
    }

    fn grid<'a>(&'a self, starts: &'a [Start]) -> Grid<'a> {
        Grid {
            names: self.names.as_slice().into(),
            axes: self.values.iter().map(Vec::as_slice).collect(),
            starts,
        }
    }

    /// The points of a shard in ascending order of index.
    fn points(
        &self,
        py: Python<'_>,
        (starts, shard): (&[Start], Shard),
        options: &Options,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Vec<SweepPoint>> {
        let number = optional("threads", options.threads, 1)?.and_then(NonZero::new);
        let response = options.response(self.is_own())?;
        match &self.of {
            Of::Scene(scene, axes) => {
                let plan = SweepPlan {
                    scene: (**scene).clone(),
                    axes: axes.clone(),
                    starts: starts.to_vec(),
                    response,
                };
                long_call(py, progress, |watch| {
                    let threads = threads(number);
                    let mut report = |share, _: &str| watch.report(share);
                    collected(|add| sweep_scene(&plan, shard, &[], threads, &mut report, add))
                })
            }
            Of::Systems(systems) => {
                let (grid, number) = (self.grid(starts), number.map_or(1, NonZero::get));
                systems.call(py, progress, |watch| {
                    let work = (shard, &[][..], number);
                    let mut report = |share, _: &str| watch.report(share);
                    collected(|add| {
                        sweep_subject(systems, &grid, &response, work, &mut report, add)
                    })
                })
            }
        }
    }

    /// A result, with its figures. Those of own systems have no units, and no figures.
    fn answer<'py>(
        self,
        fields: Fields<'py>,
        figures: impl Fn(&Scene, &[Axis]) -> Vec<Figure> + Send + Sync + 'static,
    ) -> PyResult<Fields<'py>> {
        match self.of {
            Of::Systems(_) => fields.unitless(&self.names),
            Of::Scene(scene, axes) => fields.drawn(move || figures(&scene, &axes)),
        }
    }
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
///     ``regime_intervals``, ``transitions``, ``hysteresis``. Displacements of own systems are the first component of the
///     state.
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
    let swept = Swept::new(py, scene, given.collect::<PyResult<_>>()?)?;
    if !(1..=2).contains(&swept.names.len()) {
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
    let grid = swept.grid(&chosen);
    if grid.is_empty() {
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
    let found = swept.points(py, (&chosen, shard), &options, progress.as_ref())?;
    let all = SweepResult::of(swept.labels.clone(), &grid, found, shard);
    let fields = Fields::of(py, &all)?;
    let figures = move |scene: &Scene, axes: &[Axis]| {
        let plan = SweepPlan {
            scene: scene.clone(),
            axes: axes.to_vec(),
            starts: chosen.clone(),
            response: ResponsePlan::default(),
        };
        sweep_figures(&plan, &all.points)
    };
    swept.answer(fields, figures)?.finish::<SweepResult>()
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
    let swept = Swept::new(py, scene, vec![(key.to_owned(), seeds)])?;
    check_names(options, &[Options::NAMES])?;
    let options = Options::of(options)?;
    let starts = (&[Start::Fresh][..], Shard::WHOLE);
    let points = swept.points(py, starts, &options, progress.as_ref())?;
    let mut found = Basins::of(kicks, &points);
    if let Of::Scene(scene, _) = &swept.of {
        found.tilt = scene.joint().ok().map(|joint| joint.tilt.at(0.0));
    }
    let fields = Fields::of(py, &found)?;
    let figures = move |scene: &Scene, _: &[Axis]| {
        vec![basins_figure(&scene.name, &points, &found.attractors)]
    };
    swept.answer(fields, figures)?.finish::<Basins>()
}

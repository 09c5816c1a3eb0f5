//! Words for what accuracy costs: a chapter of a page, and what stands beside the pictures of a recording.

use minijinja::context;
use minijinja::value::Value;

use super::or_fault;
use super::template::fill;
use crate::escape;
use crate::number::{error, setting, short, tolerance};
use crate::study::cost::{CostPoint, CostSet, CostStudy, Knob};
use crate::table::Table;

/// The sets as a chapter of a page: tables of settings, a column a family.
pub fn chapter(study: &CostStudy) -> String {
    or_fault(fill("cost/chapter", values(study, &Knob::ALL))) + "\n"
}

/// All about a knob.
pub fn knob(study: &CostStudy, knob: Knob) -> String {
    or_fault(fill("cost/knob", values(study, &[knob])))
}

/// The study in all, by some of its knobs.
pub fn about(study: &CostStudy, knobs: &[Knob]) -> String {
    or_fault(fill("cost/about", values(study, knobs)))
}

/// The names of the texts on some knobs.
fn values(study: &CostStudy, knobs: &[Knob]) -> Value {
    let sets = || study.sets.iter().filter(|set| knobs.contains(&set.knob));
    let errors = || sets().flat_map(|set| &set.points).map(|point| &point.error);
    let turned = knobs.iter().filter_map(|knob| of_knob(study, *knob));
    let advice = match knobs.contains(&Knob::Integrator) && !study.advice.is_empty() {
        true => advice(study).markdown(),
        false => String::new(),
    };
    let write = format!("squeakscope cost {} --write FILE.toml", study.scene);
    context! {
        scene => &*study.scene,
        code => escape::code(&study.scene),
        write => escape::code(&write),
        horizon => format!("{} ms", short(1e3 * study.horizon)),
        held => study.held.words(),
        exponent => study.exponent.map(|exponent| exponent.value),
        floor => sets().any(|set| set.floor.is_some_and(|floor| floor > 0.0)),
        failed => errors().any(Result::is_err),
        exact => errors().any(|error| *error == Ok(0.0)),
        advice,
        knobs => turned.collect::<Vec<_>>(),
    }
}

/// What the texts say of a knob; nothing of one that was not turned.
fn of_knob(study: &CostStudy, knob: Knob) -> Option<Value> {
    let sets = study.sets.iter().filter(|set| set.knob == knob);
    let sets: Vec<CostSet> = sets.cloned().collect();
    let of_set = |set: &CostSet| {
        let table = settings(set, escape::markdown);
        context! { family => &*set.family, floor => set.floor, table => table.markdown() }
    };
    let floors = || sets.iter().filter_map(|set| set.floor);
    let ends = [floors().reduce(f64::min), floors().reduce(f64::max)];
    let mut ends: Vec<String> = ends.into_iter().flatten().map(error).collect();
    ends.dedup();
    // Families whose settings are the same share a table.
    let tables = sets
        .chunk_by(is_turned_like)
        .map(|sets| families(sets).markdown());
    (!sets.is_empty()).then(|| {
        context! {
            name => knob.name(),
            error => knob.error(),
            floors => ends,
            sets => sets.iter().map(of_set).collect::<Vec<_>>(),
            tables => tables.collect::<Vec<_>>(),
        }
    })
}

/// The cheapest setting of the integrator for each error.
pub(crate) fn advice(study: &CostStudy) -> Table {
    let mut table = Table::default()
        .right("for an error of")
        .left("the cheapest setting");
    table = table.right("CPU ms").right("calls").right("its error");
    for advice in &study.advice {
        let mut sets = study.sets.iter();
        let set = sets.find(|set| set.knob == Knob::Integrator && set.family == advice.method);
        let turned = set.map_or("", |set| set.turned);
        table.row([
            format!("{:.0e}", advice.target),
            format!("{}, {}", advice.method, setting(turned, advice.value)),
            short(1e3 * advice.seconds),
            advice.calls.to_string(),
            error(advice.error),
        ]);
    }
    table
}

/// The settings of a family, a row each; a reason of failure may need to be escaped.
pub(crate) fn settings(set: &CostSet, escaped: impl Fn(&str) -> String) -> Table {
    let has_details = set.points.iter().any(|point| !point.detail.is_empty());
    let table = Table::default()
        .right(set.turned)
        .right("CPU ms")
        .right("calls");
    let mut table = table.left(set.knob.error());
    if has_details {
        table = table.left("which");
    }
    for point in &set.points {
        let [milliseconds, calls] = work(point);
        let error = match &point.error {
            Ok(found) => error(*found),
            Err(reason) => format!("failed: {}", escaped(reason)),
        };
        let row = [tolerance(point.value), milliseconds, calls, error];
        table.row(
            row.into_iter()
                .chain(has_details.then(|| point.detail.clone())),
        );
    }
    table
}

/// Milliseconds and calls; a dash where there are none.
fn work(point: &CostPoint) -> [String; 2] {
    let calls = match point.calls {
        0 => "–".to_owned(),
        calls => calls.to_string(),
    };
    [short(1e3 * point.seconds), calls]
}

fn is_turned_like(a: &CostSet, b: &CostSet) -> bool {
    let values = |set: &CostSet| set.points.iter().map(|p| p.value).collect::<Vec<_>>();
    a.turned == b.turned && values(a) == values(b)
}

/// A row a setting, a column a family. Work and details that all families share have columns of their own.
fn families(sets: &[CostSet]) -> Table {
    let shared = |same: fn(&CostPoint, &CostPoint) -> bool| {
        let all = |set: &CostSet| {
            set.points
                .iter()
                .zip(&sets[0].points)
                .all(|(a, b)| same(a, b))
        };
        sets.len() > 1 && sets.iter().all(all)
    };
    let one_work = shared(|a, b| (a.seconds, a.calls) == (b.seconds, b.calls));
    let one_detail = shared(|a, b| a.detail == b.detail && !a.detail.is_empty());
    let mut table = Table::default().right(sets[0].turned);
    if one_detail {
        table = table.left("which");
    }
    if one_work {
        table = table.right("CPU ms").right("calls");
    }
    table = sets
        .iter()
        .fold(table, |table, set| table.left(&set.family));
    for (k, first) in sets[0].points.iter().enumerate() {
        let mut row = vec![tolerance(first.value)];
        row.extend(one_detail.then(|| first.detail.clone()));
        row.extend(one_work.then(|| work(first)).into_iter().flatten());
        row.extend(sets.iter().map(|set| {
            let point = &set.points[k];
            let error = point
                .error
                .as_ref()
                .map_or_else(|_| "failed".to_owned(), |e| error(*e));
            let [milliseconds, calls] = work(point);
            let work = [format!("{milliseconds} ms"), calls];
            let work = work.into_iter().take(if point.calls > 0 { 2 } else { 1 });
            let detail = Some(&point.detail).filter(|detail| !one_detail && !detail.is_empty());
            let cell = std::iter::once(error).chain(work.filter(|_| !one_work));
            cell.chain(detail.cloned()).collect::<Vec<_>>().join(" · ")
        }));
        table.row(row);
    }
    table
}

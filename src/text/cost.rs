//! Text of the cost study: a chapter of a page, and the text next to the plots of a recording.

use minijinja::context;
use minijinja::value::Value;

use super::or_error_text;
use super::template::fill;
use crate::escape;
use crate::number::{self, error, short, significant, tolerance};
use crate::study::cost::{
    BudgetChoice, CostSetting, CostStudy, ErrorBudget, Quantity, QuantityValue, UnreachedTarget,
    WorkPrecisionPoint, WorkPrecisionSet,
};
use crate::table::Table;

/// The study as a chapter of a page: tables of values, one column per family.
pub fn chapter(study: &CostStudy) -> String {
    or_error_text(fill("cost/chapter", values(study, &CostSetting::ALL))) + "\n"
}

/// The description of one setting: what is varied, the recommendations, all values.
pub fn setting(study: &CostStudy, setting: CostSetting) -> String {
    or_error_text(fill("cost/setting", values(study, &[setting])))
}

/// The overview of the study for some settings.
pub fn about(study: &CostStudy, settings: &[CostSetting]) -> String {
    or_error_text(fill("cost/about", values(study, settings)))
}

/// Template variables for some settings.
fn values(study: &CostStudy, settings: &[CostSetting]) -> Value {
    let sets = || {
        study
            .sets
            .iter()
            .filter(|set| settings.contains(&set.setting))
    };
    let errors = || sets().flat_map(|set| &set.points).map(|point| &point.error);
    let used = settings
        .iter()
        .filter_map(|setting| setting_values(study, *setting));
    let advice = match settings.contains(&CostSetting::Integrator) && !study.advice.is_empty() {
        true => advice(study).markdown(),
        false => String::new(),
    };
    let write = format!("squeakscope cost {} --write FILE.toml", study.scene);
    context! {
        scene => &*study.scene,
        code => escape::code(&study.scene),
        write => escape::code(&write),
        horizon => format!("{} ms", short(1e3 * study.horizon)),
        held => study.fixed_at.description(),
        exponent => study.exponent.map(|exponent| exponent.value),
        floor => sets().any(|set| set.floor.is_some_and(|floor| floor > 0.0)),
        failed => errors().any(Result::is_err),
        exact => errors().any(|error| *error == Ok(0.0)),
        advice,
        settings => used.collect::<Vec<_>>(),
    }
}

/// Template variables of one setting; `None` if it was not varied.
fn setting_values(study: &CostStudy, setting: CostSetting) -> Option<Value> {
    let sets = study.sets.iter().filter(|set| set.setting == setting);
    let sets: Vec<WorkPrecisionSet> = sets.cloned().collect();
    let of_set = |set: &WorkPrecisionSet| {
        let table = settings(set, escape::markdown);
        context! { family => &*set.family, floor => set.floor, table => table.markdown() }
    };
    let floors = || sets.iter().filter_map(|set| set.floor);
    let ends = [floors().reduce(f64::min), floors().reduce(f64::max)];
    let mut ends: Vec<String> = ends.into_iter().flatten().map(error).collect();
    ends.dedup();
    // Families with the same values share a table.
    let tables = sets
        .chunk_by(has_same_values)
        .map(|sets| families(sets).markdown());
    (!sets.is_empty()).then(|| {
        context! {
            name => setting.name(),
            error => setting.error(),
            floors => ends,
            sets => sets.iter().map(of_set).collect::<Vec<_>>(),
            tables => tables.collect::<Vec<_>>(),
        }
    })
}

/// The cheapest integrator setting for each target error.
pub(crate) fn advice(study: &CostStudy) -> Table {
    let mut table = Table::default()
        .right("target error")
        .left("cheapest setting");
    table = table.right("CPU ms").right("RHS evals").right("error");
    for advice in &study.advice {
        let mut sets = study.sets.iter();
        let set =
            sets.find(|set| set.setting == CostSetting::Integrator && set.family == advice.method);
        let parameter = set.map_or("", |set| &set.parameter);
        table.row([
            format!("{:.0e}", advice.target),
            format!(
                "{}, {}",
                advice.method,
                number::setting(parameter, advice.value)
            ),
            short(1e3 * advice.seconds),
            advice.rhs_evals.to_string(),
            error(advice.error),
        ]);
    }
    table
}

/// The error budget: values of the quantities, and for each target the settings, their shares and the verified
/// errors.
pub(crate) fn budget(budget: &ErrorBudget) -> String {
    let mut text = String::new();
    for QuantityValue {
        quantity,
        value,
        undefined,
    } in &budget.quantities
    {
        let value = match (value, undefined) {
            (Some(value), _) => format!("{} {}", significant(*value, 6), quantity.unit()),
            (None, reason) => format!("not defined: {}", reason.as_deref().unwrap_or_default()),
        };
        text += &format!("  {} {value}\n", quantity.name());
    }
    for choice in &budget.choices {
        text += &budget_choice(budget, choice);
    }
    for UnreachedTarget { target, reason } in &budget.unreached {
        text += &format!("  total error {target:e}: not reached; {reason}\n");
    }
    text
}

/// The choice for one target.
fn budget_choice(budget: &ErrorBudget, choice: &BudgetChoice) -> String {
    let names: Vec<&str> = budget.defined().map(Quantity::name).collect();
    let mut table = Table::default().left("source").left("setting");
    table = names
        .iter()
        .fold(table, |table, name| table.right(*name))
        .right("CPU ms");
    for share in &choice.shares {
        let mut row = vec![share.source.name().to_owned(), share.setting.clone()];
        row.extend(share.errors.iter().map(|e| error(*e)));
        row.push(short(1e3 * share.seconds));
        table.row(row);
    }
    let mut sum = vec!["sum".to_owned(), String::new()];
    sum.extend(choice.predicted.iter().map(|e| error(*e)));
    sum.push(short(1e3 * choice.seconds));
    table.row(sum);
    let mut verified = vec!["verified".to_owned(), String::new()];
    verified.extend(names.iter().map(|name| {
        choice
            .budget
            .errors
            .get(*name)
            .map_or_else(String::new, |e| error(*e))
    }));
    verified.push(String::new());
    table.row(verified);
    let state = match choice.verified {
        true => "",
        false => ", NOT VERIFIED: the difference from the finer run exceeds it",
    };
    let next = choice
        .next
        .map(|next| format!("  to improve next: {}\n", next.name()));
    format!(
        "  total error {:e}{state}\n{}{}",
        choice.budget.target,
        table.text(),
        next.unwrap_or_default()
    )
}

/// The values of a family, one per row. `escaped` escapes the reason of a failure.
pub(crate) fn settings(set: &WorkPrecisionSet, escaped: impl Fn(&str) -> String) -> Table {
    let has_details = set.points.iter().any(|point| !point.detail.is_empty());
    let table = Table::default()
        .right(&*set.parameter)
        .right("CPU ms")
        .right("RHS evals");
    let mut table = table.left(set.setting.error());
    if has_details {
        table = table.left("detail");
    }
    for point in &set.points {
        let [milliseconds, rhs_evals] = work(point);
        let error = match &point.error {
            Ok(found) => error(*found),
            Err(reason) => format!("failed: {}", escaped(reason)),
        };
        let row = [tolerance(point.value), milliseconds, rhs_evals, error];
        table.row(
            row.into_iter()
                .chain(has_details.then(|| point.detail.clone())),
        );
    }
    table
}

/// CPU time in ms and right-hand-side evaluations; a dash if they were not counted.
fn work(point: &WorkPrecisionPoint) -> [String; 2] {
    let rhs_evals = match point.rhs_evals {
        0 => "–".to_owned(),
        rhs_evals => rhs_evals.to_string(),
    };
    [short(1e3 * point.seconds), rhs_evals]
}

fn has_same_values(a: &WorkPrecisionSet, b: &WorkPrecisionSet) -> bool {
    let values = |set: &WorkPrecisionSet| set.points.iter().map(|p| p.value).collect::<Vec<_>>();
    a.parameter == b.parameter && values(a) == values(b)
}

/// One row per value, one column per family. Cost and details shared by all families have separate columns.
fn families(sets: &[WorkPrecisionSet]) -> Table {
    let shared = |same: fn(&WorkPrecisionPoint, &WorkPrecisionPoint) -> bool| {
        let all = |set: &WorkPrecisionSet| {
            set.points
                .iter()
                .zip(&sets[0].points)
                .all(|(a, b)| same(a, b))
        };
        sets.len() > 1 && sets.iter().all(all)
    };
    let one_work = shared(|a, b| (a.seconds, a.rhs_evals) == (b.seconds, b.rhs_evals));
    let one_detail = shared(|a, b| a.detail == b.detail && !a.detail.is_empty());
    let mut table = Table::default().right(&*sets[0].parameter);
    if one_detail {
        table = table.left("detail");
    }
    if one_work {
        table = table.right("CPU ms").right("RHS evals");
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
            let [milliseconds, rhs_evals] = work(point);
            let work = [format!("{milliseconds} ms"), rhs_evals];
            let work = work
                .into_iter()
                .take(if point.rhs_evals > 0 { 2 } else { 1 });
            let detail = Some(&point.detail).filter(|detail| !one_detail && !detail.is_empty());
            let cell = std::iter::once(error).chain(work.filter(|_| !one_work));
            cell.chain(detail.cloned()).collect::<Vec<_>>().join(" · ")
        }));
        table.row(row);
    }
    table
}

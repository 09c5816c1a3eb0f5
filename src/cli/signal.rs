//! Signals from files and from recordings.

use std::path::Path;

use super::console::{print_notice, print_warning};
use super::error::CliError;
use super::harness::Watch;
use crate::import::{Format, ImportError, Selection, Signal, Table, read_signal_with};
use crate::record::{paths, read_series};

/// Reads a signal from a file or a recording.
pub(super) fn read(
    path: &Path,
    selection: &Selection,
    watch: &Watch<'_>,
) -> Result<Signal, CliError> {
    let failed = |problem| ImportError {
        path: path.to_owned(),
        problem,
    };
    if Format::of(path).map_err(failed)? != Format::Rrd {
        watch.show(0.0, "reading");
        let mut warn = |damage: &str| {
            print_warning(&format!(
                "{}: {damage}; the samples before the damage are used",
                path.display()
            ));
        };
        return Ok(read_signal_with(path, selection, &mut warn)?);
    }
    let series = read_series(path, selection.column.as_deref())?;
    if let Some(damage) = &series.damage {
        let length = match (series.times.first(), series.times.last()) {
            (Some(first), Some(last)) => last - first,
            _ => 0.0,
        };
        print_warning(&format!(
            "{} is damaged at {damage}; the {} samples of `{}` before the damage are used, {length:.6} s",
            path.display(),
            series.values.len(),
            series.name
        ));
    }
    if selection.column.is_none() && series.name == paths::DISPLACEMENT {
        print_notice(&format!(
            "analysing the column `{}` of {}; choose another with --column",
            series.name,
            path.display()
        ));
    }
    let table = Table::of_series(series.name, &series.unit, series.times, series.values);
    // `read_series` has selected the column.
    let rest = Selection {
        column: None,
        ..selection.clone()
    };
    Ok(table.signal(&rest).map_err(failed)?)
}

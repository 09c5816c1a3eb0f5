//! Knots of a curve from a CSV file.

use std::io::{self, Read};
use std::path::Path;

use super::friction::{CURVE, CURVE_FILE};
use super::knots::{Curve, MAX_POINTS};
use super::load::schedules;
use crate::foreign::{csv_rows, open_file};
use crate::scene::document::{Document, Table};
use crate::scene::edit::knot_list;
use crate::scene::error::SceneError;
use crate::scene::schema::kind::Mismatch;
use crate::scene::schema::{Key, join};

/// Size limit, bytes.
const MAX_BYTES: u64 = 4 << 20;

/// The text of a scene with the knots of CSV files in the place of their names, so that it is self-contained and can be
/// recorded and edited without the files. A curve that is given more than once stays, to be rejected.
///
/// # Errors
/// If the text is not a scene's, and as [`knots`].
pub fn expanded(file: &str, text: &str) -> Result<String, SceneError> {
    let document = Document::parse(file, text)?;
    let mut edits = Vec::new();
    let mut notes = String::new();
    let curves = schedules().map(|keys| (&keys.knots, keys.csv, keys.paths()));
    let friction = vec!["friction.points", "friction.points_csv"];
    let friction = (&CURVE, &CURVE_FILE, friction);
    for (curve, csv, forms) in curves.into_iter().chain([friction]) {
        let is_given_once = forms.iter().filter(|form| document.has(form)).count() == 1;
        let span = document.span(&join(curve.table, csv.name));
        let Some(span) = span.filter(|_| is_given_once) else {
            continue;
        };
        let table = document.table(curve.table);
        let list = knot_list(curve, &knots(table, curve, csv)?);
        let file = table.get(csv)?;
        notes += &format!("# {} was read from {file:?}\n", curve.path());
        edits.push((span, format!("{} = {list}", curve.list.name)));
    }
    let mut text = text.to_owned();
    edits.sort_by_key(|(span, _)| std::cmp::Reverse(span.start));
    for (span, list) in edits {
        text.replace_range(span, &list);
    }
    if !notes.is_empty() && !text.ends_with('\n') {
        text.push('\n');
    }
    Ok(text + &notes)
}

/// Reads the knots of the CSV file that a scene names, in the units of the file: variable (such as time in ms), and
/// value.
///
/// The first line contains the names of the two columns, each further line a knot. Empty lines and
/// comments after `#` are ignored.
///
/// # Errors
/// If the file cannot be read or a line is not a valid knot. The error names file and line.
fn knots(table: Table<'_>, curve: &Curve, csv: &Key<String>) -> Result<Vec<[f64; 2]>, SceneError> {
    let path = table.document.path().with_file_name(table.get(csv)?);
    let file = path.display().to_string();
    let text = read(&path).map_err(|problem| {
        let remedy =
            "give the path of a readable CSV file, relative to the folder of the scene file";
        let problem = format!("the file `{file}` {problem}");
        table.inconsistent(csv.name, &[], problem, remedy)
    })?;
    let place = |line: usize| format!("{file}:{line}");
    let refused = |line, problem: String, remedy: &str| {
        let key = table.path_of(csv.name);
        Err(SceneError::inconsistent(place(line), key, problem, remedy))
    };
    let columns = curve.point.map(|key| key.name);
    let names = columns.join(",");
    let mut rows = csv_rows(&text);
    let (line, heading) = rows.next().unwrap_or((1, Vec::new()));
    if heading != columns {
        let problem = "the first line does not contain the names of the columns".to_owned();
        let remedy = format!(
            "begin with the line `{names}`, separate columns by commas, and write numbers with a decimal point"
        );
        return refused(line, problem, &remedy);
    }
    let mut knots: Vec<[f64; 2]> = Vec::new();
    for (line, fields) in rows {
        if fields.len() != 2 {
            let problem = format!("the line has {} fields instead of 2", fields.len());
            let remedy = format!("write `{names}` on each line, separated by a comma");
            return refused(line, problem, &remedy);
        }
        let mut knot = [0.0; 2];
        for ((number, field), key) in knot.iter_mut().zip(fields).zip(curve.point) {
            let stated = field.parse().map_err(|_| Mismatch::Type);
            let limits = &key.kind.limits;
            let accepted = stated.and_then(|x: f64| limits.range.check(x));
            *number = accepted.map_err(|mismatch| {
                let (key, found) = (join(&curve.path(), key.name), format!("`{field}`"));
                mismatch.at(place(line), &key, &limits.expected(), &found)
            })?;
        }
        if knots.len() == MAX_POINTS {
            let problem = format!("the file contains more than {MAX_POINTS} knots");
            return refused(line, problem, "remove knots from nearly straight sections");
        }
        curve.append(&mut knots, knot, || place(line))?;
    }
    if knots.is_empty() {
        let (last, problem) = (text.lines().count().max(1), "the file contains no knot");
        let remedy = "write one knot on each line below the names of the columns";
        return refused(last, problem.to_owned(), remedy);
    }
    Ok(knots)
}

fn read(path: &Path) -> Result<String, String> {
    let unreadable = |fault: io::Error| format!("cannot be read ({fault})");
    let (file, length) = open_file(path).map_err(unreadable)?;
    if length > MAX_BYTES {
        return Err(format!("is larger than {MAX_BYTES} bytes"));
    }
    io::read_to_string(file.take(MAX_BYTES)).map_err(unreadable)
}

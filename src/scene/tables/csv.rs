//! Knots of a curve from a CSV file.

use std::io::{self, Read};
use std::path::Path;

use super::friction::CURVE;
use super::knots::{KnotKeys, MAX_POINTS, out_of_order};
use super::load::schedules;
use crate::foreign::open_file;
use crate::scene::document::Document;
use crate::scene::edit::knot_list;
use crate::scene::error::{Location, SceneError};
use crate::scene::schema::join;
use crate::scene::schema::kind::Kind;

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
    let curves = schedules().map(|keys| (&keys.curve, keys.paths()));
    let friction = vec!["friction.points", "friction.points_csv"];
    for (keys, forms) in curves.into_iter().chain([(&CURVE, friction)]) {
        let is_given_once = forms.iter().filter(|form| document.has(form)).count() == 1;
        let span = document.span(&join(keys.table, keys.csv.name));
        let Some(span) = span.filter(|_| is_given_once) else {
            continue;
        };
        let list = knot_list(keys, &knots(&document, keys)?);
        let (table, name) = (keys.table, keys.knots.name);
        let file = document.table(table).get(keys.csv)?;
        notes += &format!("# {table}.{name} was read from {file:?}\n");
        edits.push((span, format!("{name} = {list}")));
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
/// The first line contains the names of the two columns, each further line a knot. Empty lines and comments after `#` are
/// ignored.
///
/// # Errors
/// If the file cannot be read or a line is not a valid knot. The error names file and line.
fn knots(document: &Document<'_>, keys: &KnotKeys) -> Result<Vec<[f64; 2]>, SceneError> {
    let table = document.table(keys.table);
    let path = document.folder().join(table.get(keys.csv)?);
    let file = path.display().to_string();
    let text = read(&path).map_err(|problem| {
        let remedy =
            "give the path of a readable CSV file, relative to the folder of the scene file";
        let problem = format!("the file `{file}` {problem}");
        table.inconsistent(keys.csv.name, &[], problem, remedy)
    })?;
    let uncommented = |line: &str| line.split('#').next().unwrap_or_default().trim().to_owned();
    let text: Vec<String> = text.lines().map(uncommented).collect();
    // A position is in front of the empty lines above its row.
    let place = |position: Option<&csv::Position>| {
        let line = position.map_or(1, |position| position.line() as usize);
        let above = text.iter().skip(line - 1);
        Location {
            file: file.clone(),
            line: Some(line + above.take_while(|line| line.is_empty()).count()),
        }
    };
    let refused = |at: Location, problem: String| {
        let remedy = format!(
            "write the line `{}`, and below it one knot on each line: two numbers with a decimal point, separated by a comma",
            keys.knot.map(|key| key.name).join(",")
        );
        SceneError::inconsistent(at, join(keys.table, keys.csv.name), problem, remedy)
    };
    let unreadable = |error: csv::Error| refused(place(error.position()), error.to_string());
    let path_of = |name| format!("{}.{}.{name}", keys.table, keys.knots.name);
    let content = text.join("\n");
    let mut rows = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .from_reader(content.as_bytes());
    let names = rows.headers().map_err(unreadable)?;
    if *names != keys.knot.map(|key| key.name)[..] {
        let problem = "the first line does not contain the names of the columns";
        return Err(refused(place(names.position()), problem.to_owned()));
    }
    let mut knots: Vec<[f64; 2]> = Vec::new();
    let mut row = csv::StringRecord::new();
    while rows.read_record(&mut row).map_err(unreadable)? {
        let knot: [f64; 2] = row.deserialize(None).map_err(unreadable)?;
        for (x, key) in knot.iter().zip(keys.knot) {
            key.kind.accept(*x).map_err(|mismatch| {
                let (path, expected) = (path_of(key.name), key.kind.expected());
                mismatch.at(place(row.position()), &path, &expected, &format!("`{x}`"))
            })?;
        }
        if knots.last().is_some_and(|before| knot[0] <= before[0]) {
            let variable = path_of(keys.knot[0].name);
            return Err(out_of_order(&variable, keys.order, place(row.position())));
        }
        if knots.len() == MAX_POINTS {
            let problem = format!("the file contains more than {MAX_POINTS} knots");
            return Err(refused(place(row.position()), problem));
        }
        knots.push(knot);
    }
    if knots.is_empty() {
        return Err(refused(place(None), "the file contains no knot".to_owned()));
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

//! The knots of a function of time from a CSV file beside the scene file.

use std::fs::File;
use std::io::Read;

use super::schedule::out_of_order;
use crate::scene::error::{Fault, Place, SceneError};
use crate::scene::file::{Document, mismatched};
use crate::scene::keys::{Key, MOST_POINTS, ScheduleKeys};
use crate::scene::kind::Number;

/// Longer files are refused before they are read whole: endless devices are files, too.
const LONGEST: u64 = 4 << 20;

/// The knots in the file that a scene names, as stated there: time in ms, and value.
///
/// The file has a line with the names of its two columns, then a knot a line. Empty lines and what
/// follows `#` count for nothing.
///
/// # Errors
/// When the file cannot be read, or a line of it is no valid knot: the error names file and line.
pub(super) fn knots(
    document: &Document<'_>,
    keys: &ScheduleKeys,
) -> Result<Vec<[f64; 2]>, SceneError> {
    let name = document.get(keys.csv)?;
    let path = document.folder().join(&name);
    let text = read(&path).map_err(|problem| {
        document.inconsistent(
            keys.csv.path,
            &[],
            format!("the file `{}` {problem}", path.display()),
            "give a readable CSV file, named from the scene file's folder",
        )
    })?;
    let file = path.display().to_string();
    knots_in(&text, &file, keys)
}

fn read(path: &std::path::Path) -> Result<String, String> {
    let mut bytes = Vec::new();
    // A pipe would wait for ever for somebody to write into it.
    let there = std::fs::metadata(path).map_err(|fault| format!("cannot be read ({fault})"))?;
    if !there.is_file() {
        return Err("is no regular file".to_owned());
    }
    File::open(path)
        .and_then(|file| file.take(LONGEST + 1).read_to_end(&mut bytes))
        .map_err(|fault| format!("cannot be read ({fault})"))?;
    if bytes.len() as u64 > LONGEST {
        return Err(format!("is larger than {LONGEST} bytes"));
    }
    String::from_utf8(bytes).map_err(|_| "is not UTF-8 text".to_owned())
}

fn knots_in(text: &str, file: &str, keys: &ScheduleKeys) -> Result<Vec<[f64; 2]>, SceneError> {
    let place = |line: usize| Place {
        file: file.to_owned(),
        line: Some(line),
    };
    let wrong = |line: usize, problem: String, remedy: String| {
        let key = keys.csv.path;
        Fault::Inconsistent {
            key,
            problem,
            remedy,
        }
        .at(place(line))
    };
    let columns = keys.knots.1;
    let [time, value] = columns;
    let heading = format!("{},{}", time.name(), value.name());
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let lines = (1..).zip(
        text.lines()
            .map(|line| line.split('#').next().unwrap_or("")),
    );
    let mut rows = lines.filter(|(_, line)| !line.trim().is_empty());
    let fields =
        |line: &str| -> Vec<String> { line.split(',').map(|f| f.trim().to_owned()).collect() };

    let first = rows.next();
    let is_heading = |line: &str| fields(line) == columns.map(Key::name);
    if let Some((line, heading)) = first.filter(|(_, line)| !is_heading(line)) {
        let parted_by = |sign: char| {
            heading
                .split(sign)
                .map(str::trim)
                .eq(columns.map(Key::name))
        };
        let other = [(';', "semicolons"), ('\t', "tabs")]
            .into_iter()
            .find(|(sign, _)| parted_by(*sign));
        if let Some((_, signs)) = other {
            return Err(wrong(
                line,
                format!("its columns are parted by {signs}"),
                "part them by commas, and write numbers with a decimal point".to_owned(),
            ));
        }
    }
    if !first.is_some_and(|(_, line)| is_heading(line)) {
        return Err(wrong(
            first.map_or(1, |(line, _)| line),
            "the columns are not named as they should be".to_owned(),
            format!("begin with the line `{heading}`"),
        ));
    }
    let mut knots: Vec<[f64; 2]> = Vec::new();
    for (line, row) in rows {
        let fields = fields(row);
        let [at, there] = &fields[..] else {
            return Err(wrong(
                line,
                format!("the line has {} fields", fields.len()),
                format!("make them two, `{heading}`, parted by a comma"),
            ));
        };
        let knot = [
            number(at, time, &place(line))?,
            number(there, value, &place(line))?,
        ];
        if knots.last().is_some_and(|before| knot[0] <= before[0]) {
            return Err(out_of_order(time, place(line)));
        }
        if knots.len() == MOST_POINTS {
            return Err(wrong(
                line,
                format!("there are more than {MOST_POINTS} knots"),
                "leave out those between which the line is nearly straight".to_owned(),
            ));
        }
        knots.push(knot);
    }
    if knots.is_empty() {
        let below = "write a knot a line below the names of the columns";
        let last = text.lines().count().max(1);
        return Err(wrong(last, "there is no knot".to_owned(), below.to_owned()));
    }
    Ok(knots)
}

/// A number as stated, if the key takes it.
fn number(field: &str, key: &Key<Number>, place: &Place) -> Result<f64, SceneError> {
    use crate::scene::kind::Mismatch::Type;

    let refused = |mismatch| mismatched(key, mismatch, place.clone(), format!("`{field}`"));
    let stated: f64 = field.parse().map_err(|_| refused(Type))?;
    key.kind.accept(stated).map_err(refused)?;
    Ok(stated)
}

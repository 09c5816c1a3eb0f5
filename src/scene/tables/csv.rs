//! Knots of a curve from a CSV file.

use std::io::{self, Read};
use std::path::Path;

use super::knots::{KnotKeys, MAX_POINTS, out_of_order};
use crate::foreign::open_file;
use crate::scene::document::Document;
use crate::scene::error::{Fault, Location, SceneError};
use crate::scene::schema::kind::{Kind, Mismatch, Number};
use crate::scene::schema::{Key, join};

/// Size limit, bytes.
const MAX_BYTES: u64 = 4 << 20;

/// Reads the knots of the CSV file that a scene names, in the units of the file: variable (such as time in ms), and
/// value.
///
/// The first line contains the names of the two columns, each further line a knot. Empty lines and
/// comments after `#` are ignored.
///
/// # Errors
/// If the file cannot be read or a line is not a valid knot. The error names file and line.
pub fn knots(document: &Document<'_>, keys: &KnotKeys) -> Result<Vec<[f64; 2]>, SceneError> {
    let table = document.table(keys.table);
    let path = document.folder().join(table.get(keys.csv)?);
    let file = path.display().to_string();
    let text = read(&path).map_err(|problem| {
        let remedy =
            "give the path of a readable CSV file, relative to the folder of the scene file";
        table.inconsistent(
            keys.csv.name,
            &[],
            format!("the file `{file}` {problem}"),
            remedy,
        )
    })?;
    KnotFile { file, keys }.knots(text.strip_prefix('\u{feff}').unwrap_or(&text))
}

fn read(path: &Path) -> Result<String, String> {
    let unreadable = |fault: io::Error| format!("cannot be read ({fault})");
    let (file, length) = open_file(path).map_err(unreadable)?;
    if length > MAX_BYTES {
        return Err(format!("is larger than {MAX_BYTES} bytes"));
    }
    io::read_to_string(file.take(MAX_BYTES)).map_err(unreadable)
}

/// The content of a CSV file with its name.
struct KnotFile<'k> {
    file: String,
    keys: &'k KnotKeys,
}

impl KnotFile<'_> {
    fn knots(&self, text: &str) -> Result<Vec<[f64; 2]>, SceneError> {
        let uncommented = |line: &'_ str| line.split('#').next().unwrap_or("").trim().to_owned();
        let lines = (1..).zip(text.lines().map(uncommented));
        let mut rows = lines.filter(|(_, line)| !line.is_empty());
        self.check_heading(rows.next())?;
        let mut knots: Vec<[f64; 2]> = Vec::new();
        for (line, row) in rows {
            let knot = self.knot(line, &row)?;
            if knots.last().is_some_and(|before| knot[0] <= before[0]) {
                let variable = self.path_of(self.keys.knot[0]);
                return Err(out_of_order(&variable, self.keys.order, self.place(line)));
            }
            if knots.len() == MAX_POINTS {
                let problem = format!("the file contains more than {MAX_POINTS} knots");
                let remedy = "remove knots from nearly straight sections";
                return Err(self.error(line, &problem, remedy));
            }
            knots.push(knot);
        }
        if knots.is_empty() {
            let remedy = "write one knot on each line below the names of the columns";
            let last = text.lines().count().max(1);
            return Err(self.error(last, "the file contains no knot", remedy));
        }
        Ok(knots)
    }

    /// Checks the names of the columns in the first line.
    fn check_heading(&self, first: Option<(usize, String)>) -> Result<(), SceneError> {
        let (line, heading) = first.unwrap_or((1, String::new()));
        let names = self.keys.knot.map(|key| key.name);
        if heading.split(',').map(str::trim).eq(names) {
            return Ok(());
        }
        let problem = "the first line does not contain the names of the columns";
        let names = names.join(",");
        let remedy = format!(
            "begin with the line `{names}`, separate columns by commas, and write numbers with a decimal point"
        );
        Err(self.error(line, problem, &remedy))
    }

    fn knot(&self, line: usize, row: &str) -> Result<[f64; 2], SceneError> {
        let fields: Vec<&str> = row.split(',').map(str::trim).collect();
        let [variable, value] = self.keys.knot;
        let [at, there] = fields[..] else {
            let problem = format!("the line has {} fields instead of 2", fields.len());
            let heading = format!("{},{}", variable.name, value.name);
            let remedy = format!("write `{heading}` on each line, separated by a comma");
            return Err(self.error(line, &problem, &remedy));
        };
        Ok([
            self.number(line, at, variable)?,
            self.number(line, there, value)?,
        ])
    }

    /// Parses a number and checks its range; the result is in the unit of the file.
    fn number(&self, line: usize, field: &str, key: &Key<Number>) -> Result<f64, SceneError> {
        let stated: Result<f64, Mismatch> = field.parse().map_err(|_| Mismatch::Type);
        let accepted = stated.and_then(|stated| key.kind.accept(stated).map(|_| stated));
        accepted.map_err(|mismatch| {
            let (path, found) = (self.path_of(key), format!("`{field}`"));
            let fault = mismatch.fault(&path, &key.kind.expected(), &found);
            fault.at(self.place(line))
        })
    }

    /// Path of a key of a knot, for messages.
    fn path_of(&self, key: &Key<Number>) -> String {
        format!("{}.{}.{}", self.keys.table, self.keys.knots.name, key.name)
    }

    fn error(&self, line: usize, problem: &str, remedy: &str) -> SceneError {
        let key = join(self.keys.table, self.keys.csv.name);
        Fault::inconsistent(key, problem, remedy).at(self.place(line))
    }

    fn place(&self, line: usize) -> Location {
        Location {
            file: self.file.clone(),
            line: Some(line),
        }
    }
}

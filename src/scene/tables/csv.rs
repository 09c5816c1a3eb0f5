//! Knots of a curve from a CSV file.

use std::fs::File;
use std::io::Read;

use super::knots::{KnotKeys, MAX_POINTS, out_of_order};
use crate::scene::document::Document;
use crate::scene::error::{Fault, Location, SceneError};
use crate::scene::schema::kind::{Kind, Mismatch, Number};
use crate::scene::schema::{Key, join};

/// Size limit, bytes; a larger file, such as an endless device, is rejected before it is read completely.
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
    let path = document.folder().join(table.get(&keys.csv)?);
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

fn read(path: &std::path::Path) -> Result<String, String> {
    let mut bytes = Vec::new();
    // Reading a pipe could block forever.
    let there = std::fs::metadata(path).map_err(|fault| format!("cannot be read ({fault})"))?;
    if !there.is_file() {
        return Err("is not a regular file".to_owned());
    }
    File::open(path)
        .and_then(|file| file.take(MAX_BYTES + 1).read_to_end(&mut bytes))
        .map_err(|fault| format!("cannot be read ({fault})"))?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(format!("is larger than {MAX_BYTES} bytes"));
    }
    String::from_utf8(bytes).map_err(|_| "is not UTF-8 text".to_owned())
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
                let variable = self.path_of(&self.keys.knot[0]);
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
        let names = self.keys.knot.each_ref().map(|key| key.name);
        let is_separated_by = |sign: char| heading.split(sign).map(str::trim).eq(names);
        if is_separated_by(',') {
            return Ok(());
        }
        let signs = [(';', "semicolons"), ('\t', "tabs")];
        Err(
            match signs.into_iter().find(|(sign, _)| is_separated_by(*sign)) {
                Some((_, signs)) => self.error(
                    line,
                    &format!("its columns are separated by {signs}"),
                    "separate them by commas, and write numbers with a decimal point",
                ),
                None => self.error(
                    line,
                    "the first line does not contain the names of the columns",
                    &format!("begin with the line `{}`", names.join(",")),
                ),
            },
        )
    }

    fn knot(&self, line: usize, row: &str) -> Result<[f64; 2], SceneError> {
        let fields: Vec<&str> = row.split(',').map(str::trim).collect();
        let [variable, value] = &self.keys.knot;
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
            let fault =
                mismatch.fault(self.path_of(key), key.kind.expected(), format!("`{field}`"));
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

//! The knots of a function of time from a CSV file beside the scene file.

use std::fs::File;
use std::io::Read;

use super::load::{MOST_POINTS, ScheduleKeys, out_of_order};
use crate::scene::document::Document;
use crate::scene::error::{Fault, Place, SceneError};
use crate::scene::schema::kind::{Kind, Mismatch, Number};
use crate::scene::schema::{Key, join};

/// Longer files are refused before they are read whole: endless devices are files, too.
const LONGEST: u64 = 4 << 20;

/// The knots in the file that a scene names, as stated there: time in ms, and value.
///
/// The file has a line with the names of its two columns, then a knot a line. Empty lines and what
/// follows `#` count for nothing.
///
/// # Errors
/// When the file cannot be read, or a line of it is no valid knot: the error names file and line.
pub fn knots(document: &Document<'_>, keys: &ScheduleKeys) -> Result<Vec<[f64; 2]>, SceneError> {
    let table = document.table(keys.table);
    let path = document.folder().join(table.get(&keys.csv)?);
    let file = path.display().to_string();
    let text = read(&path).map_err(|problem| {
        let remedy = "give a readable CSV file, named from the scene file's folder";
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

/// A file of knots.
struct KnotFile<'k> {
    file: String,
    keys: &'k ScheduleKeys,
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
                return Err(out_of_order(&self.path_of(self.time()), self.place(line)));
            }
            if knots.len() == MOST_POINTS {
                let problem = format!("there are more than {MOST_POINTS} knots");
                let remedy = "leave out those between which the line is nearly straight";
                return Err(self.wrong(line, &problem, remedy));
            }
            knots.push(knot);
        }
        if knots.is_empty() {
            let remedy = "write a knot a line below the names of the columns";
            let last = text.lines().count().max(1);
            return Err(self.wrong(last, "there is no knot", remedy));
        }
        Ok(knots)
    }

    /// The first line must name the columns.
    fn check_heading(&self, first: Option<(usize, String)>) -> Result<(), SceneError> {
        let (line, heading) = first.unwrap_or((1, String::new()));
        let names = self.keys.knot.each_ref().map(|key| key.name);
        let is_parted_by = |sign: char| heading.split(sign).map(str::trim).eq(names);
        if is_parted_by(',') {
            return Ok(());
        }
        let signs = [(';', "semicolons"), ('\t', "tabs")];
        Err(
            match signs.into_iter().find(|(sign, _)| is_parted_by(*sign)) {
                Some((_, signs)) => self.wrong(
                    line,
                    &format!("its columns are parted by {signs}"),
                    "part them by commas, and write numbers with a decimal point",
                ),
                None => self.wrong(
                    line,
                    "the columns are not named as they should be",
                    &format!("begin with the line `{}`", names.join(",")),
                ),
            },
        )
    }

    fn knot(&self, line: usize, row: &str) -> Result<[f64; 2], SceneError> {
        let fields: Vec<&str> = row.split(',').map(str::trim).collect();
        let [time, value] = &self.keys.knot;
        let [at, there] = fields[..] else {
            let problem = format!("the line has {} fields", fields.len());
            let heading = format!("{},{}", time.name, value.name);
            let remedy = format!("make them two, `{heading}`, parted by a comma");
            return Err(self.wrong(line, &problem, &remedy));
        };
        Ok([
            self.number(line, at, time)?,
            self.number(line, there, value)?,
        ])
    }

    /// A number as stated, if the key takes it.
    fn number(&self, line: usize, field: &str, key: &Key<Number>) -> Result<f64, SceneError> {
        let stated: Result<f64, Mismatch> = field.parse().map_err(|_| Mismatch::Type);
        let accepted = stated.and_then(|stated| key.kind.accept(stated).map(|_| stated));
        accepted.map_err(|mismatch| {
            let fault =
                mismatch.fault(self.path_of(key), key.kind.expected(), format!("`{field}`"));
            fault.at(self.place(line))
        })
    }

    fn time(&self) -> &Key<Number> {
        &self.keys.knot[0]
    }

    /// The path of a number of a knot.
    fn path_of(&self, key: &Key<Number>) -> String {
        format!("{}.{}.{}", self.keys.table, self.keys.knots.name, key.name)
    }

    fn wrong(&self, line: usize, problem: &str, remedy: &str) -> SceneError {
        let key = join(self.keys.table, self.keys.csv.name);
        Fault::inconsistent(key, problem, remedy).at(self.place(line))
    }

    fn place(&self, line: usize) -> Place {
        Place {
            file: self.file.clone(),
            line: Some(line),
        }
    }
}

//! The views and tabs of `layout.txt`.

use re_sdk_types::blueprint::components::{ContainerKind, Corner2D};

use super::tree::{Part, View};
use crate::record::panel_view::NAMES_HEIGHT;
use crate::record::paths::Root;
use crate::record::plot::{CAPTION_HEIGHT, bounds};

/// The views and tabs.
const LAYOUT: &str = include_str!("layout.txt");

/// A view of the table.
pub struct Row {
    /// Kind and its arguments.
    pub kind: Vec<&'static str>,
    /// Paths of the entities.
    pub paths: Vec<&'static str>,
    /// The analysis, or what else is needed for the view to have data; may be empty.
    pub needs: &'static str,
    /// Title with placeholders.
    pub title: &'static str,
    /// What the colours of the viewer mean: the end of the title there, with placeholders; may be empty.
    pub key: &'static str,
}

impl Row {
    /// The view of a name.
    pub fn of(name: &str) -> Option<Self> {
        let (_, lines) = section("views")?;
        let mut rows = lines.lines().map(|line| line.split('|').map(str::trim));
        let mut row = rows.find_map(|mut row| (row.next()? == name).then_some(row))?;
        let mut words = || row.next().unwrap_or_default().split_whitespace().collect();
        let (kind, paths) = (words(), words());
        let [needs, title, key] = std::array::from_fn(|_| row.next().unwrap_or_default());
        Some(Self {
            kind,
            paths,
            needs,
            title,
            key,
        })
    }

    /// The title with the key, and placeholders replaced.
    pub fn title_with(&self, values: &[(&str, &str)]) -> String {
        let title = format!("{}{}", self.title, self.key);
        let replaced = |title: String, (name, value): &(&str, &str)| title.replace(name, value);
        values.iter().fold(title, replaced)
    }

    /// Size of the plot area of a picture, and the space above it for a caption or names, pixels.
    pub fn field(&self) -> Option<([f32; 2], f32)> {
        let [_, size, above @ ..] = &self.kind[..] else {
            return None;
        };
        let (width, height) = size.split_once('x')?;
        let above = match above {
            ["caption"] => CAPTION_HEIGHT,
            ["names"] => NAMES_HEIGHT,
            _ => 0.0,
        };
        Some(([width.parse().ok()?, height.parse().ok()?], above))
    }

    /// The view with a title. `argument` is the distance of the eye from a cube.
    pub fn view(&self, title: String, argument: &str) -> Option<View> {
        let (path, paths) = (self.paths[0], &self.paths);
        Some(match self.kind[0] {
            "text" => View::of("TextDocument", title, path),
            "log" => View::of("TextLog", title, path),
            "cube" => View::cube(title, path, argument.parse().ok()?),
            "states" => View::of("StateTimeline", title, path),
            "legend-left" => View::series(title, paths, Some(Corner2D::LeftTop)),
            "legend-right" => View::series(title, paths, Some(Corner2D::RightBottom)),
            "picture" => return self.picture(title, &Root::of_run()),
            _ => View::series(title, paths, None),
        })
    }

    /// Range of a series, if the table has one.
    pub fn range(&self) -> Option<[f64; 2]> {
        match self.kind[..] {
            [_, low, high] => Some([low.parse().ok()?, high.parse().ok()?]),
            _ => None,
        }
    }

    /// The view of a picture without a legend, below a root.
    pub fn picture(&self, title: impl Into<String>, root: &Root) -> Option<View> {
        let (field, above) = self.field()?;
        let path = root.at(self.paths[0]);
        Some(View::picture(title, &path, bounds(field, above)))
    }
}

/// Gives a view by its name; `None` if it has no data.
pub type ViewOf<'a> = dyn FnMut(&str) -> Option<View> + 'a;

/// A tab by its key, if one of its views exists; `view` gives a view by its name.
pub fn tab(key: &str, view: &mut ViewOf<'_>) -> Option<Part> {
    let (title, screen) = screen_of(key, view)?;
    Some(Part::tab(title, vec![screen]))
}

/// The title and the screen of a tab, as [`tab`].
pub fn screen_of(key: &str, view: &mut ViewOf<'_>) -> Option<(&'static str, Part)> {
    let (title, lines) = section(key)?;
    Some((title, screen(lines, view)?))
}

/// Title and lines of a section.
fn section(key: &str) -> Option<(&'static str, &'static str)> {
    let (_, section) = LAYOUT.split_once(&format!("\n[{key}]"))?;
    let (title, lines) = section.split_once('\n')?;
    Some((title.trim(), lines.split("\n[").next()?))
}

/// The part that lines describe.
fn screen(lines: &'static str, view: &mut ViewOf<'_>) -> Option<Part> {
    let lines = lines.lines().filter(|line| !line.trim().is_empty());
    let lines = lines.map(|line| {
        let text = line.trim_start();
        let words = text.split_once(' ');
        let shared = words.and_then(|(share, name)| Some((share.parse().ok()?, name)));
        // The first line has no share.
        let (share, name) = shared.unwrap_or((1.0, text));
        (line.len() - text.len(), share, name)
    });
    part(&lines.collect::<Vec<_>>(), view)
}

/// The part of the first line; the other lines are inside.
fn part(lines: &[(usize, f32, &'static str)], view: &mut ViewOf<'_>) -> Option<Part> {
    let (&(depth, _, name), inside) = lines.split_first()?;
    if !["row", "column"].contains(&name) {
        return view(name).map(Part::View);
    }
    let starts = (0..inside.len()).filter(|&k| inside[k].0 == depth + 1);
    let starts: Vec<usize> = starts.chain([inside.len()]).collect();
    let (mut parts, mut shares) = (Vec::new(), Vec::new());
    for ends in starts.windows(2) {
        let lines = &inside[ends[0]..ends[1]];
        if let Some(part) = part(lines, view) {
            parts.push(part);
            shares.push(lines[0].1);
        }
    }
    let kind = match name {
        "row" => ContainerKind::Horizontal,
        _ => ContainerKind::Vertical,
    };
    (!parts.is_empty()).then_some(Part::Group {
        kind,
        name: None,
        parts,
        shares,
    })
}

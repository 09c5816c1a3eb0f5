//! The tabs of `layout.txt` with their views.

use super::tree::{Container, Part, View};

/// The tabs.
const LAYOUT: &str = include_str!("layout.txt");

/// A tab by its key, if one of its views exists; `view` gives a view by its name.
pub fn tab(key: &str, view: &mut dyn FnMut(&str) -> Option<View>) -> Option<Part> {
    let (title, screen) = section(key)?;
    Some(named(title, self::screen(screen, view)?))
}

/// The screen of a tab without its title, as [`tab`].
pub fn screen_of(key: &str, view: &mut dyn FnMut(&str) -> Option<View>) -> Option<Part> {
    let (_, screen) = section(key)?;
    self::screen(screen, view)
}

/// A screen as a tab with a title.
pub fn named(title: &str, screen: Part) -> Part {
    let screen = Container::column(vec![screen], Vec::new());
    screen.with_name(title).into()
}

/// Title and lines of a section.
fn section(key: &str) -> Option<(&'static str, &'static str)> {
    let (_, section) = LAYOUT.split_once(&format!("\n[{key}]"))?;
    let (title, lines) = section.split_once('\n')?;
    Some((title.trim(), lines.split("\n[").next()?))
}

/// The part that lines describe.
fn screen(lines: &'static str, view: &mut dyn FnMut(&str) -> Option<View>) -> Option<Part> {
    let lines = lines.lines().filter(|line| !line.trim().is_empty());
    let lines: Vec<_> = lines
        .map(|line| {
            let text = line.trim_start();
            let depth = line.len() - text.len();
            // The first line has no share.
            match text
                .split_once(' ')
                .and_then(|(share, name)| Some((share.parse().ok()?, name)))
            {
                Some((share, name)) => (depth, share, name),
                None => (depth, 1.0, text),
            }
        })
        .collect();
    part(&lines, view)
}

/// The part of the first line; the other lines are inside.
fn part(
    lines: &[(usize, f32, &'static str)],
    view: &mut dyn FnMut(&str) -> Option<View>,
) -> Option<Part> {
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
    if parts.is_empty() {
        return None;
    }
    Some(match name {
        "row" => Container::row(parts, shares).into(),
        _ => Container::column(parts, shares).into(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_views_and_empty_rows_take_no_space() {
        let some = |names: &[&str]| {
            tab("contact", &mut |name| {
                names.contains(&name).then(|| View::in_3d(name))
            })
        };
        let text = format!("{:?}", some(&["patch", "contact-force"]).expect("a tab"));
        assert!(
            text.contains("\"patch\"") && text.contains("shares: [0.45, 0.55]"),
            "{text}"
        );
        let text = format!("{:?}", some(&["patch"]).expect("a tab"));
        assert!(
            text.contains("shares: [0.45]") && !text.contains("0.55"),
            "{text}"
        );
        assert!(some(&[]).is_none());
    }
}

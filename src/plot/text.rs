//! Text metrics: width of a text, and line breaking.

use std::sync::OnceLock;

use ttf_parser::Face;

/// Font family.
pub const FAMILY: &str = "Inter";
/// Font families for browsers without the font.
pub const FALLBACK: &str = "Inter, 'Helvetica Neue', Helvetica, Arial, 'DejaVu Sans', sans-serif";
/// The regular and the semibold face of the font (SIL Open Font License, assets/fonts/OFL.txt).
pub const FACES: [&[u8]; 2] = [
    include_bytes!("../../assets/fonts/Inter-Regular.ttf"),
    include_bytes!("../../assets/fonts/Inter-SemiBold.ttf"),
];

/// Width of a character without a glyph, ems.
const MISSING: f64 = 0.6;

/// Width of a text at a font size, both in points.
pub fn width(text: &str, size: f64, bold: bool) -> f64 {
    static PARSED: OnceLock<[Option<Face<'static>>; 2]> = OnceLock::new();
    let faces = PARSED.get_or_init(|| FACES.map(|face| Face::parse(face, 0).ok()));
    let face = faces[usize::from(bold)].as_ref();
    let ems = |c: char| {
        let advance = face.and_then(|face| {
            let advance = face.glyph_hor_advance(face.glyph_index(c)?)?;
            Some(f64::from(advance) / f64::from(face.units_per_em()))
        });
        advance.unwrap_or(MISSING)
    };
    size * text.chars().map(ems).sum::<f64>()
}

/// Breaks a text at spaces into lines of at most `max_width` points.
pub fn wrap(text: &str, max_width: f64, size: f64, bold: bool) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split(' ') {
        let longer = lines.last().map(|line| format!("{line} {word}"));
        match longer.filter(|line| width(line, size, bold) <= max_width) {
            Some(longer) => *lines.last_mut().expect("a line exists") = longer,
            None => lines.push(word.to_owned()),
        }
    }
    lines.retain(|line| !line.is_empty());
    lines
}

/// Escapes a text as the content of an XML element or attribute. Control characters are not allowed in XML.
pub fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in crate::escape::lines(text).chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            c => escaped.push(c),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_texts_break_at_spaces() {
        let text = "a title that is much too long for its panel";
        let lines = wrap(text, 100.0, 10.0, true);
        assert!(lines.len() > 1);
        assert!(lines.iter().all(|line| width(line, 10.0, true) <= 100.0));
        assert_eq!(lines.join(" "), text);
        assert_eq!(wrap("unbreakable", 5.0, 10.0, false), ["unbreakable"]);
        assert!(wrap("", 5.0, 10.0, false).is_empty());
    }

    #[test]
    fn letters_have_their_own_widths() {
        assert!(width("W", 10.0, false) > 2.0 * width("i", 10.0, false));
        assert!(width("figure", 10.0, true) > width("figure", 10.0, false));
    }
}

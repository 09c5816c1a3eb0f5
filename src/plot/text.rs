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

/// Breaks a text at spaces, and words that are too long anywhere, into lines of at most `max_width` points.
pub fn wrap(text: &str, max_width: f64, size: f64, bold: bool) -> Vec<String> {
    let text = shown(text);
    let is_long = |line: &str| width(line, size, bold) > max_width;
    let mut lines: Vec<String> = Vec::new();
    for word in text.split(' ').filter(|word| !word.is_empty()) {
        match lines.last_mut() {
            Some(line) if !is_long(&format!("{line} {word}")) => *line += &format!(" {word}"),
            _ => lines.push(word.to_owned()),
        }
        while let Some(line) = lines.last_mut().filter(|line| is_long(line)) {
            let ends = line.char_indices().skip(1).map(|(end, _)| end);
            let Some(end) = ends.take_while(|end| !is_long(&line[..*end])).last() else {
                break;
            };
            let rest = line.split_off(end);
            lines.push(rest);
        }
    }
    lines
}

/// A text as it is shown: control characters escaped, and a minus sign for a hyphen before a number.
pub fn shown(text: &str) -> String {
    let text = crate::escape::lines(text);
    let sign = |(at, c): (usize, char)| {
        let is_sign = c == '-'
            && !text[..at].ends_with(char::is_alphanumeric)
            && text[at + 1..].starts_with(|next: char| next.is_ascii_digit());
        if is_sign { '−' } else { c }
    };
    text.char_indices().map(sign).collect()
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
        let pieces = wrap("a_file_name_without_spaces.wav", 60.0, 10.0, false);
        assert!(pieces.iter().all(|line| width(line, 10.0, false) <= 60.0));
        assert_eq!(pieces.concat(), "a_file_name_without_spaces.wav");
        assert!(wrap("", 5.0, 10.0, false).is_empty());
    }

    #[test]
    fn numbers_have_a_minus_sign() {
        assert_eq!(shown("torus-3deg: -2.1 (-3)"), "torus-3deg: −2.1 (−3)");
    }

    #[test]
    fn letters_have_their_own_widths() {
        assert!(width("W", 10.0, false) > 2.0 * width("i", 10.0, false));
        assert!(width("figure", 10.0, true) > width("figure", 10.0, false));
    }
}

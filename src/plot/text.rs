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

/// A text as it is shown: control characters escaped, a minus sign for a hyphen before a number or a frequency, and `2.5e-4` as
/// `2.5 × 10⁻⁴`.
pub fn shown(text: &str) -> String {
    let text = crate::escape::lines(text);
    let mut shown = String::with_capacity(text.len());
    let mut left = &*text;
    while let Some(c) = left.chars().next() {
        left = &left[c.len_utf8()..];
        let is_in_word = shown.ends_with(char::is_alphanumeric);
        if c == 'e'
            && let Some(power) = exponent(left)
            && let Some(before) = number_before(&shown)
        {
            match &shown[before..] {
                "1" => shown.truncate(before),
                _ => shown += " × ",
            }
            shown += &power_of_ten(power);
            left = &left[power.len()..];
        } else if c == '-'
            && (starts_with_digit(left) && !is_in_word || is_difference(&shown, left))
        {
            shown.push('−');
        } else {
            shown.push(c);
        }
    }
    shown
}

/// Whether a number follows, as after a sign.
fn starts_with_digit(after: &str) -> bool {
    after.starts_with(|next: char| next.is_ascii_digit())
}

/// Whether a text ends and the next one begins as at the minus of `2 f1 - f2`.
fn is_difference(before: &str, after: &str) -> bool {
    let next = after.strip_prefix(' ').unwrap_or_default();
    before.ends_with(' ')
        && (starts_with_digit(next)
            || starts_with_digit(next.strip_prefix('f').unwrap_or_default()))
}

/// The exponent with which a text starts, unless it belongs to a word.
fn exponent(text: &str) -> Option<&str> {
    let digits = text.strip_prefix('-').unwrap_or(text);
    let after = digits.trim_start_matches(|c: char| c.is_ascii_digit());
    let is_number = after.len() < digits.len() && !after.starts_with(char::is_alphanumeric);
    is_number.then(|| &text[..text.len() - after.len()])
}

/// Start of the number with which a text ends.
fn number_before(text: &str) -> Option<usize> {
    let before = text.trim_end_matches(|c: char| c.is_ascii_digit() || c == '.');
    let is_number = text.ends_with(|c: char| c.is_ascii_digit());
    (is_number && !before.ends_with(char::is_alphanumeric)).then_some(before.len())
}

/// A power of ten with its exponent raised: `10⁻³`.
pub fn power_of_ten(exponent: &str) -> String {
    let raised = exponent.chars().map(|c| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => char::from_u32('⁰' as u32 + digit as u32 - '0' as u32).unwrap_or(digit),
    });
    format!("10{}", raised.collect::<String>())
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
        assert_eq!(shown("(-2.5e-4, 1e12)"), "(−2.5 × 10⁻⁴, 10¹²)");
        assert_eq!(shown("2 f1 - f2 - 3 f1"), "2 f1 − f2 − 3 f1");
        assert_eq!(shown("f1e3, 2e3d, a - f"), "f1e3, 2e3d, a - f");
    }

    #[test]
    fn letters_have_their_own_widths() {
        assert!(width("W", 10.0, false) > 2.0 * width("i", 10.0, false));
        assert!(width("figure", 10.0, true) > width("figure", 10.0, false));
    }
}

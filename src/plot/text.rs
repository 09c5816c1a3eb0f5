//! Text metrics: width of a text, and line breaking.

use std::sync::LazyLock;

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
    static PARSED: LazyLock<[Face<'static>; 2]> =
        LazyLock::new(|| FACES.map(|face| Face::parse(face, 0).expect("an embedded font")));
    let face = &PARSED[usize::from(bold)];
    let ems = |c: char| {
        let glyph = face.glyph_index(c);
        let advance = glyph.and_then(|glyph| face.glyph_hor_advance(glyph));
        advance.map_or(MISSING, |advance| {
            f64::from(advance) / f64::from(face.units_per_em())
        })
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

/// A text as it is shown: control characters escaped, a minus sign for a hyphen before a number or a frequency, `2.5e-4` as
/// `2.5 × 10⁻⁴`, and `omega_1` as `ω1`.
pub fn shown(text: &str) -> String {
    let text = crate::escape::lines(text).replace("omega_1", "ω1");
    let mut shown = String::with_capacity(text.len());
    let mut left = &text[..];
    while let Some(c) = left.chars().next() {
        left = &left[c.len_utf8()..];
        let is_in_word = shown.ends_with(char::is_alphanumeric);
        // A difference of frequencies, such as `2 f1 - f2`, has spaces at its sign.
        let after = left.strip_prefix(" f").or_else(|| left.strip_prefix(' '));
        let after = after.unwrap_or(left);
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
        } else if c == '-' && !is_in_word && after.starts_with(|c: char| c.is_ascii_digit()) {
            shown.push('−');
        } else {
            shown.push(c);
        }
    }
    shown
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
fn power_of_ten(exponent: &str) -> String {
    let digits = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let raised = |c: char| c.to_digit(10).map_or('⁻', |digit| digits[digit as usize]);
    format!("10{}", exponent.chars().map(raised).collect::<String>())
}

/// Escapes a text as the content of an XML element or attribute. Control characters are not allowed in XML.
pub fn escape(text: &str) -> String {
    crate::escape::lines(text)
        .replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
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
        assert_eq!(shown("| / omega_1 |"), "| / ω1 |");
    }

    #[test]
    fn letters_have_their_own_widths() {
        assert!(width("W", 10.0, false) > 2.0 * width("i", 10.0, false));
        assert!(width("figure", 10.0, true) > width("figure", 10.0, false));
    }
}

//! Units in the names of columns: `u (um)`, `v [mm/s]`, `v_mm_per_s`, `time_ms`.

/// Suffixes of names and their units; longer ones first, as `_m_per_s` ends in `_s`.
const ENDINGS: [(&str, &str); 25] = [
    ("_m_per_s2", "m/s^2"),
    ("_mm_per_s2", "mm/s^2"),
    ("_um_per_s", "um/s"),
    ("_mm_per_s", "mm/s"),
    ("_m_per_s", "m/s"),
    ("_rad_per_s", "rad/s"),
    ("_min", "min"),
    ("_deg", "deg"),
    ("_rad", "rad"),
    ("_kHz", "kHz"),
    ("_Hz", "Hz"),
    ("_hz", "Hz"),
    ("_Pa", "Pa"),
    ("_pa", "Pa"),
    ("_mV", "mV"),
    ("_V", "V"),
    ("_N", "N"),
    ("_ms", "ms"),
    ("_us", "us"),
    ("_ns", "ns"),
    ("_mm", "mm"),
    ("_um", "um"),
    ("_nm", "nm"),
    ("_m", "m"),
    ("_s", "s"),
];

/// Names of a time column.
const TIMES: [&str; 8] = [
    "t",
    "time",
    "zeit",
    "temps",
    "tiempo",
    "tempo",
    "seconds",
    "timestamp",
];

/// A name without its unit, and the unit; empty if the name contains none.
pub(super) fn split(header: &str) -> (&str, &str) {
    let header = header.trim();
    for (open, close) in [('(', ')'), ('[', ']')] {
        if let Some((name, unit)) = header.strip_suffix(close).and_then(|h| h.rsplit_once(open))
            && !name.trim().is_empty()
        {
            return (name.trim_end(), unit.trim());
        }
    }
    let fits = |(ending, unit): &(&str, &'static str)| {
        let name = header.strip_suffix(ending)?;
        (!name.is_empty()).then_some((name, *unit))
    };
    ENDINGS.iter().find_map(fits).unwrap_or((header, ""))
}

/// Whether a name (without its unit) is that of a time column.
pub(super) fn is_time(name: &str) -> bool {
    TIMES.contains(&name.to_lowercase().as_str())
}

/// A unit without brackets around it.
pub(super) fn without_brackets(unit: &str) -> &str {
    let pairs = [('(', ')'), ('[', ']')];
    let inside = |(open, close)| unit.strip_prefix(open)?.strip_suffix(close);
    pairs.into_iter().find_map(inside).unwrap_or(unit).trim()
}

/// Units that a row of units may have besides those of [`ENDINGS`].
const FURTHER: [&str; 14] = [
    "",
    "-",
    "1",
    "%",
    "g",
    "A",
    "mA",
    "dB",
    "Nm",
    "bar",
    "kN",
    "m/s2",
    "m/s\u{b2}",
    "\u{b0}C",
];

/// Whether a row below one of names is one of units: all in brackets, all known, or a unit of time below the
/// name of a time.
pub(super) fn is_row(names: &[&str], row: &[&str]) -> bool {
    let mut pairs = names.iter().zip(row);
    let is_known = |unit: &&str| {
        let unit = without_brackets(unit);
        FURTHER.contains(&unit) || ENDINGS.iter().any(|(_, known)| *known == unit)
    };
    row.iter().all(|unit| without_brackets(unit) != *unit)
        || row.iter().all(is_known)
        || pairs.any(|(name, unit)| {
            let unit = without_brackets(unit);
            is_time(name) && !unit.is_empty() && seconds(unit).is_some()
        })
}

/// A unit of time in seconds; `None` for other units.
pub(super) fn seconds(unit: &str) -> Option<f64> {
    Some(match unit.to_lowercase().as_str() {
        "" | "s" | "sec" | "seconds" => 1.0,
        "ms" => 1e-3,
        "us" | "\u{b5}s" | "\u{3bc}s" => 1e-6,
        "ns" => 1e-9,
        "min" => 60.0,
        "h" => 3600.0,
        _ => return None,
    })
}

//! Units in the names of columns: `u (um)`, `v [mm/s]`, `v_mm_per_s`, `time_ms`.

/// Units at the end of a name.
const UNITS: [&str; 23] = [
    "m/s^2", "mm/s^2", "um/s", "mm/s", "m/s", "rad/s", "min", "deg", "rad", "kHz", "Hz", "Pa",
    "mV", "V", "N", "ms", "us", "ns", "mm", "um", "nm", "m", "s",
];

/// Units that only a row of units has.
const FURTHER: [&str; 14] = [
    "", "-", "1", "%", "g", "A", "mA", "dB", "Nm", "bar", "kN", "m/s2", "m/s²", "°C",
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
    // The longest unit: `v_mm_per_s` also ends with one of time.
    let ends = header.match_indices('_').filter(|(at, _)| *at > 0);
    let mut units = ends.filter_map(|(at, _)| {
        let unit = header[at + 1..].replace("_per_", "/").replace("s2", "s^2");
        let unit = match &unit[..] {
            "hz" => "Hz",
            "pa" => "Pa",
            unit => unit,
        };
        let known = UNITS.iter().find(|known| **known == unit)?;
        Some((&header[..at], *known))
    });
    units.next().unwrap_or((header, ""))
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

/// Whether a row below one of names is one of units: all in brackets, all known, or a unit of time below the
/// name of a time.
pub(super) fn is_row(names: &[&str], row: &[&str]) -> bool {
    let mut pairs = names.iter().zip(row);
    let is_known = |unit: &&str| {
        let unit = without_brackets(unit);
        UNITS.contains(&unit) || FURTHER.contains(&unit)
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
        "" | "s" | "sec" | "second" | "seconds" => 1.0,
        "ms" => 1e-3,
        "us" | "\u{b5}s" | "\u{3bc}s" => 1e-6,
        "ns" => 1e-9,
        "min" => 60.0,
        "h" => 3600.0,
        _ => return None,
    })
}

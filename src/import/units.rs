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

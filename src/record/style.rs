//! Colours and full scales. Colours are the same in every view, legible on the viewer's dark background and
//! distinguishable by colour-blind readers (after the palette of Okabe and Ito).

use crate::analysis::regime::Regime;
pub(crate) use crate::number::{format_range, short};
use crate::pipeline::message::{Header, NodeState, SignalInfo};
use crate::plot::{Color, Rgb, Unit, gradient};
use crate::record::sdk;
pub(crate) use crate::text::capitalize;

/// Background of three-dimensional views.
pub const BACKGROUND: sdk::Color = rgb([0x10, 0x12, 0x16]);
/// The load, and the second signal of a pair.
pub const LOAD: Color = Color::Regime(Regime::Transient);
/// The rotation.
pub const ROTATION: Color = Color::Regime(Regime::QuasiPeriodic);
/// Friction.
pub const FRICTION: Color = Color::Series(4);

/// The colour of a contact node by its state.
pub const fn node(state: NodeState) -> Color {
    match state {
        NodeState::Stick => Color::Compared,
        NodeState::Slip => Color::Run,
        NodeState::Separated => Color::Ink,
    }
}

/// The colour of figures on the viewer's dark background.
impl From<Color> for sdk::Color {
    fn from(color: Color) -> Self {
        rgb(color.on_dark())
    }
}

/// An opaque colour.
pub const fn rgb([r, g, b]: Rgb) -> sdk::Color {
    sdk::Color(sdk::Rgba32(u32::from_be_bytes([r, g, b, 0xff])))
}

/// A colour blended with the background; `share` (0 to 1) is the fraction of the colour.
pub fn faded(color: Color, share: f32) -> Color {
    let mixed = |color: Rgb, ground: f32| {
        color.map(|c| (f32::from(c) * share + ground * (1.0 - share)) as u8)
    };
    Color::Shade([mixed(color.on_light(), 255.0), mixed(color.on_dark(), 18.0)])
}

/// Steel grey through teal to yellow, so that a body at rest has the colour of steel.
pub fn steel() -> [Rgb; 256] {
    gradient(&[
        [0x5a, 0x66, 0x78],
        [0x46, 0x86, 0x98],
        [0x49, 0xa8, 0x96],
        [0x8d, 0xca, 0x76],
        [0xfd, 0xe7, 0x25],
    ])
}

/// The colour of a map at `share`, 0 (darkest) to 1 (brightest), clamped; NaN is darkest.
pub fn shade(map: &[Rgb; 256], share: f32) -> Rgb {
    // A cast to u8 saturates and converts NaN to 0.
    map[usize::from((share * 255.0) as u8)]
}

/// A time of the run with its unit, to about a thousandth of the duration.
pub fn format_time(header: &Header, time: f64) -> String {
    let unit = Unit::of("s", header.duration);
    let length = unit.factor * header.duration;
    let decimals = (2.0 - length.log10().floor()).clamp(0.0, 3.0) as usize;
    format!("{:.decimals$} {}", unit.factor * time, unit.symbol)
}

/// The colour of piece `k` (1 is the oldest) of `count`.
pub fn fade(color: Color, k: usize, count: usize) -> Color {
    let age = k as f32 / count as f32;
    faded(color, 0.18 + 0.82 * age.powi(2))
}

/// Name and unit of a signal from a file.
pub fn signal_title(signal: &SignalInfo) -> String {
    let title = format!("{}, {}", signal.column, signal.unit);
    title.trim_end_matches(", ").to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::INFERNO;

    #[test]
    fn colour_maps_are_monotonic_in_brightness() {
        for map in [gradient(&INFERNO), steel()] {
            let at = |share| shade(&map, share);
            let light = |share| at(share).map(f32::from).iter().sum::<f32>();
            assert!((0..10).all(|i| light(i as f32 / 10.0) < light((i + 1) as f32 / 10.0)));
            assert_eq!(at(-1.0), at(0.0));
            assert_eq!(at(7.0), at(1.0));
            assert_eq!(at(f32::NAN), at(0.0));
        }
        assert_eq!(shade(&gradient(&INFERNO), 1.0), [0xfc, 0xff, 0xa4]);
    }

    /// The word for a colour.
    fn name(color: Color) -> &'static str {
        let [r, g, b] = color.on_dark().map(i32::from);
        let [low, high] = [r.min(g).min(b), r.max(g).max(b)];
        if high - low < 30 {
            return if high > 200 { "white" } else { "grey" };
        }
        let hue = |a: i32, b: i32| f64::from(a - b) / f64::from(high - low);
        let hue = match high {
            _ if high == r => 60.0 * hue(g, b).rem_euclid(6.0),
            _ if high == g => 120.0 + 60.0 * hue(b, r),
            _ => 240.0 + 60.0 * hue(r, g),
        };
        match hue {
            ..15.0 | 345.0.. => "red",
            ..42.0 => "orange",
            ..70.0 => "yellow",
            ..170.0 => "green",
            ..250.0 => "blue",
            ..290.0 => "violet",
            _ => "pink",
        }
    }

    /// Lessons, titles and scenes name the colours of what they speak of.
    #[test]
    fn the_colours_have_the_names_that_the_texts_use() {
        for (color, expected) in [
            (Color::Run, "blue"),
            (Color::Compared, "orange"),
            (LOAD, "yellow"),
            (FRICTION, "pink"),
            (Color::Faint, "grey"),
            (Color::Accent, "pink"),
            (node(NodeState::Slip), "blue"),
            (node(NodeState::Stick), "orange"),
            (node(NodeState::Separated), "white"),
        ] {
            assert_eq!(name(color), expected);
        }
    }
}

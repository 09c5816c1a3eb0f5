//! Colours, the same in every view, legible on the viewer's dark background and to the
//! colour-blind (after the palette of Okabe and Ito), and the scales that keep pictures still.

use rerun::Color;

use crate::pipeline::message::NodeState;

/// Behind three-dimensional pictures.
pub const BACKGROUND: Color = rgb(0x10, 0x12, 0x16);
/// Axes, ticks and words.
pub const AXIS: Color = rgb(0x9a, 0xa4, 0xb2);
/// Grid lines.
pub const GRID: Color = rgb(0x2e, 0x34, 0x3d);
/// Circles of equal tilt.
pub const RULER: Color = rgb(0x55, 0x5f, 0x6d);
/// Where the beam's axis meets the ball.
pub const POLE: Color = rgb(0xf4, 0xf6, 0xf8);
/// The signal: probe, portrait, spectrum.
pub const SIGNAL: Color = rgb(0x56, 0xb4, 0xe9);
/// The second signal of a pair.
pub const SECOND: Color = rgb(0xf5, 0xc7, 0x4a);
/// What calls for attention: peaks, the present point.
pub const ACCENT: Color = rgb(0xff, 0x8c, 0x42);
/// The load.
pub const LOAD: Color = rgb(0xf5, 0xc7, 0x4a);
/// The rotation.
pub const ROTATION: Color = rgb(0x4c, 0xd0, 0x9e);
/// Friction.
pub const FRICTION: Color = rgb(0xd9, 0x8c, 0xc3);

/// One colour a mode, repeated past the end.
pub const MODES: [Color; 11] = [
    rgb(0x56, 0xb4, 0xe9),
    rgb(0x2a, 0x78, 0xb8),
    rgb(0xff, 0xb0, 0x4a),
    rgb(0xc9, 0x6a, 0x12),
    rgb(0x4c, 0xd0, 0x9e),
    rgb(0x0d, 0x8f, 0x68),
    rgb(0xf2, 0x9c, 0xd0),
    rgb(0xb0, 0x5a, 0x92),
    rgb(0xf0, 0xe4, 0x42),
    rgb(0xa8, 0x9d, 0x1c),
    rgb(0xd0, 0xd4, 0xda),
];

/// The colour of a contact node.
pub const fn node(state: NodeState) -> Color {
    match state {
        NodeState::Stick => rgb(0xff, 0x9f, 0x1c),
        NodeState::Slip => SIGNAL,
        NodeState::Separated => rgb(0xe6, 0xe6, 0xe6),
    }
}

/// An opaque colour.
pub const fn rgb(r: u8, g: u8, b: u8) -> Color {
    rgba(r, g, b, 0xff)
}

/// A colour with opacity `a` (0 transparent, 255 opaque).
pub const fn rgba(r: u8, g: u8, b: u8, a: u8) -> Color {
    Color(rerun::datatypes::Rgba32(u32::from_be_bytes([r, g, b, a])))
}

/// The same colour, `share` (0 to 1) of it over the dark background.
pub fn faded(color: Color, share: f32) -> Color {
    let [r, g, b, _] = color.to_array();
    let mix = |c: u8| (f32::from(c) * share + 18.0 * (1.0 - share)) as u8;
    rgb(mix(r), mix(g), mix(b))
}

/// A perceptually uniform colour map: 256 colours, dark to bright.
#[derive(Clone, Debug)]
pub struct ColorMap([[u8; 3]; 256]);

impl ColorMap {
    /// Black over purple and orange to pale yellow (the nodes of matplotlib's "inferno").
    pub fn inferno() -> Self {
        Self::through(&[
            [0x00, 0x00, 0x04],
            [0x1b, 0x0c, 0x41],
            [0x4a, 0x0c, 0x6b],
            [0x78, 0x1c, 0x6d],
            [0xa5, 0x2c, 0x60],
            [0xcf, 0x44, 0x46],
            [0xed, 0x69, 0x25],
            [0xfb, 0x9b, 0x06],
            [0xf7, 0xd1, 0x3d],
            [0xfc, 0xff, 0xa4],
        ])
    }

    /// The grey of steel over teal to yellow: a body at rest looks like what it is.
    pub fn steel() -> Self {
        Self::through(&[
            [0x5a, 0x66, 0x78],
            [0x46, 0x86, 0x98],
            [0x49, 0xa8, 0x96],
            [0x8d, 0xca, 0x76],
            [0xfd, 0xe7, 0x25],
        ])
    }

    /// Linear between equally spaced nodes.
    fn through(nodes: &[[u8; 3]]) -> Self {
        let last = nodes.len() - 1;
        Self(std::array::from_fn(|i| {
            let at = i as f32 / 255.0 * last as f32;
            let k = (at as usize).min(last - 1);
            let part = at - k as f32;
            std::array::from_fn(|c| {
                let [low, high] = [nodes[k][c], nodes[k + 1][c]].map(f32::from);
                (low + (high - low) * part).round() as u8
            })
        }))
    }

    /// The colour of `share`, 0 (darkest) to 1 (brightest); clamped, not-a-number is darkest.
    pub fn at(&self, share: f32) -> [u8; 3] {
        // A cast to u8 saturates and takes not-a-number to 0.
        self.0[usize::from((share * 255.0) as u8)]
    }
}

/// The full scale of a picture: a round number, changed only when the data outgrow it or shrink
/// far below it, so that a picture does not breathe with the signal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FullScale(f64);

impl FullScale {
    /// Starts at the smallest scale ever shown.
    pub fn new(smallest: f64) -> Self {
        Self(round_up(smallest))
    }

    /// The present full scale.
    pub fn get(self) -> f64 {
        self.0
    }

    /// Takes the largest magnitude now on show; true if the scale changed.
    pub fn update(&mut self, peak: f64, smallest: f64) -> bool {
        let before = self.0;
        if peak.is_finite() && (peak > self.0 || peak < 0.3 * self.0) {
            self.0 = round_up(peak.max(smallest));
        }
        self.0 != before
    }
}

/// The smallest round number (1, 1.5, 2, 3, 4, 5, 6 or 8 times a power of ten) that is not below
/// `x` (positive).
pub fn round_up(x: f64) -> f64 {
    let decade = 10f64.powf(x.log10().floor());
    let digit = [1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0]
        .into_iter()
        .find(|d| d * decade >= x * (1.0 - 1e-9));
    digit.unwrap_or(10.0) * decade
}

/// A unit that values are drawn in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// Its symbol.
    pub symbol: &'static str,
    /// How many of it make the SI unit.
    pub per_si: f64,
}

impl Unit {
    /// The unit of lengths in which `full` (m) is a number that reads well: µm down to pm.
    pub fn length(full: f64) -> Self {
        Self::fitting(full, [("µm", 1e6), ("nm", 1e9), ("pm", 1e12)])
    }

    /// The unit of speeds in which `full` (m/s) is a number that reads well: mm/s down to nm/s.
    pub fn speed(full: f64) -> Self {
        Self::fitting(full, [("mm/s", 1e3), ("µm/s", 1e6), ("nm/s", 1e9)])
    }

    /// The largest in which `full` is not below a tenth, else the smallest.
    fn fitting(full: f64, units: [(&'static str, f64); 3]) -> Self {
        let fits = |(_, per_si): &(&str, f64)| full * per_si >= 0.1 * (1.0 - 1e-9);
        let (symbol, per_si) = units.into_iter().find(fits).unwrap_or(units[2]);
        Self { symbol, per_si }
    }
}

/// A number for a label: at most three significant digits, no trailing zeros.
pub fn short(x: f64) -> String {
    if x == 0.0 {
        return "0".to_owned();
    }
    let decimals = (2 - x.abs().log10().floor() as i32).clamp(0, 6) as usize;
    let text = format!("{x:.decimals$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colour_maps_start_dark_and_end_bright() {
        for map in [ColorMap::inferno(), ColorMap::steel()] {
            let light = |share| map.at(share).map(f32::from).iter().sum::<f32>();
            assert!((0..10).all(|i| light(i as f32 / 10.0) < light((i + 1) as f32 / 10.0)));
            assert_eq!(map.at(-1.0), map.at(0.0));
            assert_eq!(map.at(7.0), map.at(1.0));
            assert_eq!(map.at(f32::NAN), map.at(0.0));
        }
        assert_eq!(ColorMap::inferno().at(1.0), [0xfc, 0xff, 0xa4]);
    }

    #[test]
    fn full_scale_holds_still_within_its_band() {
        let mut scale = FullScale::new(1e-3);
        assert!(scale.update(0.9, 1e-3));
        assert!((scale.get() - 1.0).abs() < 1e-12);
        assert!(!scale.update(0.31, 1e-3), "within the band");
        assert!(scale.update(0.1, 1e-3));
        assert!((scale.get() - 0.1).abs() < 1e-12);
        assert!(scale.update(0.0, 1e-3), "silence goes to the smallest");
        assert!((scale.get() - 1e-3).abs() < 1e-12);
        assert!(!scale.update(f64::NAN, 1e-3));
    }

    #[test]
    fn units_fit_the_scale() {
        let symbols = [1e-6, 1e-7, 5e-8, 2e-11, 0.0].map(|full| Unit::length(full).symbol);
        assert_eq!(symbols, ["µm", "µm", "nm", "pm", "pm"]);
        let unit = Unit::speed(3e-6);
        assert_eq!((unit.symbol, 3e-6 * unit.per_si), ("µm/s", 3.0));
    }

    #[test]
    fn labels_are_short() {
        let cases = [
            (0.0, "0"),
            (0.25, "0.25"),
            (4.117, "4.12"),
            (12.0, "12"),
            (-0.5, "-0.5"),
            (1234.0, "1234"),
        ];
        for (x, text) in cases {
            assert_eq!(short(x), text);
        }
    }
}

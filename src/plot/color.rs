//! Colours by meaning: a colour has the same meaning in all figures and recordings.
//!
//! Types of motion have strong hues that are distinguishable with any kind of colour vision (after Okabe and
//! Ito 2008). Families of settings, measures, modes and exponents have muted hues (after Tol 2021).

use serde::{Serialize, Serializer};

use crate::analysis::regime::Regime;

/// An RGB colour: red, green, blue.
pub type Rgb = [u8; 3];

/// The meaning of a colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Color {
    /// Text, zero lines, and lines without a specific colour.
    Ink,
    /// Axis names and secondary elements.
    Faint,
    /// Background elements.
    Pale,
    /// Grid lines.
    Grid,
    /// A selected or detected value: spectral lines, the chosen delay.
    Accent,
    /// The run itself: measured values, a rising parameter. Blue.
    Run,
    /// What the run is compared with: computed values, a falling parameter, a perturbed copy. Orange.
    Compared,
    /// A type of motion.
    Regime(Regime),
    /// One of several series by index, from 0.
    Series(usize),
    /// A colour of a colour map, on a light and on a dark background.
    Shade([Rgb; 2]),
}

/// Colours of series on a light and on a dark background, repeated cyclically.
const SERIES: [[Rgb; 2]; 7] = [
    [[51, 34, 136], [143, 162, 230]],
    [[204, 102, 119], [232, 138, 155]],
    [[17, 119, 51], [125, 200, 140]],
    [[68, 170, 153], [94, 206, 196]],
    [[136, 34, 85], [205, 120, 165]],
    [[153, 153, 51], [205, 205, 110]],
    [[136, 204, 238], [178, 224, 246]],
];

impl Color {
    /// The colours on a white background and on a dark one, such as that of the Rerun viewer.
    const fn pair(self) -> [Rgb; 2] {
        match self {
            Self::Ink => [[38, 42, 48], [244, 246, 248]],
            Self::Faint => [[110, 116, 124], [154, 164, 178]],
            Self::Pale => [[214, 218, 223], [85, 95, 109]],
            Self::Grid => [[232, 234, 237], [46, 52, 61]],
            Self::Accent => [[190, 20, 80], [255, 105, 145]],
            Self::Run => [[0, 85, 138], [107, 201, 255]],
            Self::Compared => [[184, 67, 0], [255, 154, 77]],
            Self::Regime(regime) => match regime {
                Regime::Silent => [[205, 209, 214], [90, 102, 120]],
                Regime::Periodic => [[0, 114, 178], [86, 180, 233]],
                Regime::QuasiPeriodic => [[0, 158, 115], [76, 208, 158]],
                Regime::Chaotic => [[213, 94, 0], [255, 140, 66]],
                Regime::Transient => [[240, 190, 30], [245, 199, 74]],
                Regime::Noise => [[120, 85, 60], [190, 150, 120]],
                Regime::Undetermined => [[150, 155, 162], [154, 164, 178]],
            },
            Self::Series(k) => SERIES[k % SERIES.len()],
            Self::Shade(pair) => pair,
        }
    }

    /// The colour on a white background.
    pub const fn on_light(self) -> Rgb {
        self.pair()[0]
    }

    /// The colour on a dark background.
    pub const fn on_dark(self) -> Rgb {
        self.pair()[1]
    }
}

/// The colours on a light and on a dark background.
impl Serialize for Color {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.pair().serialize(serializer)
    }
}

/// Nodes of the colour map of spectrograms: black through purple and orange to pale yellow ("inferno" of matplotlib).
pub const INFERNO: [Rgb; 10] = [
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
];

/// The same map from pale to dark.
pub fn colormap() -> [Rgb; 256] {
    let mut colors = gradient(&INFERNO);
    colors.reverse();
    colors
}

/// Colours by linear interpolation between equally spaced nodes, at least two.
pub fn gradient(nodes: &[Rgb]) -> [Rgb; 256] {
    std::array::from_fn(|k| {
        let position = k as f64 / 255.0 * (nodes.len() - 1) as f64;
        let node = (position as usize).min(nodes.len() - 2);
        let part = position - node as f64;
        std::array::from_fn(|c| {
            let [low, high] = [nodes[node][c], nodes[node + 1][c]].map(f64::from);
            (low + part * (high - low)).round() as u8
        })
    })
}

/// Index into [`colormap`] of a value from 0 to 1.
pub fn colormap_index(share: f64) -> u8 {
    // A cast saturates and converts NaN to 0.
    (255.0 * share).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;
    use strum::VariantArray as _;

    #[test]
    fn colours_are_distinguishable() {
        let regimes = Regime::VARIANTS.iter().copied().map(Color::Regime);
        let series = (0..SERIES.len()).map(Color::Series);
        let all: Vec<Color> = regimes.chain(series).collect();
        let all: Vec<Color> = all.into_iter().chain([Color::Accent]).collect();
        for on in [Color::on_light, Color::on_dark] {
            for (k, one) in all.iter().enumerate() {
                for other in &all[..k] {
                    let pairs = on(*one).into_iter().zip(on(*other));
                    let apart: u32 = pairs.map(|(a, b)| u32::from(a.abs_diff(b))).sum();
                    assert!(apart > 30, "{one:?} and {other:?} differ by {apart}");
                }
            }
        }
    }

    #[test]
    fn the_colormap_darkens() {
        let light = |c: &Rgb| c.iter().map(|c| u32::from(*c)).sum::<u32>();
        let colors = colormap();
        assert!(
            colors
                .windows(9)
                .step_by(8)
                .all(|w| light(&w[0]) > light(&w[8]))
        );
        assert_eq!(
            [
                colormap_index(-1.0),
                colormap_index(f64::NAN),
                colormap_index(2.0)
            ],
            [0, 0, 255]
        );
    }
}

//! Colours by meaning: a type of motion, a mode and a role have the same colour in all figures and recordings.
//!
//! Types of motion have strong hues (after Okabe and Ito 2008). Families of settings, measures, modes and exponents have
//! muted hues (after Tol 2021). Both are distinguishable with protanopia and deuteranopia, and in print.

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
const SERIES: [[Rgb; 2]; 11] = [
    [[51, 34, 136], [130, 150, 240]],
    [[203, 99, 112], [212, 115, 112]],
    [[17, 119, 51], [119, 195, 131]],
    [[61, 174, 166], [94, 206, 196]],
    [[136, 34, 85], [209, 118, 170]],
    [[154, 153, 49], [209, 209, 103]],
    [[80, 150, 210], [178, 224, 246]],
    [[80, 35, 33], [233, 151, 10]],
    [[83, 91, 190], [113, 105, 255]],
    [[79, 72, 0], [111, 137, 40]],
    [[20, 20, 30], [255, 255, 205]],
];

impl Color {
    /// The colours on a white background and on a dark one, such as that of the Rerun viewer.
    const fn pair(self) -> [Rgb; 2] {
        match self {
            Self::Ink => [[38, 42, 48], [244, 246, 248]],
            Self::Faint => [[110, 116, 124], [154, 164, 178]],
            Self::Pale => [[214, 218, 223], [85, 95, 109]],
            Self::Grid => [[232, 234, 237], [46, 52, 61]],
            Self::Accent => [[174, 45, 148], [254, 118, 216]],
            Self::Run => [[12, 60, 131], [130, 213, 255]],
            Self::Compared => [[176, 69, 0], [253, 158, 53]],
            Self::Regime(regime) => match regime {
                Regime::Silent => [[161, 163, 169], [116, 126, 142]],
                Regime::Periodic => [[0, 118, 190], [78, 178, 239]],
                Regime::QuasiPeriodic => [[48, 164, 106], [77, 208, 158]],
                Regime::Chaotic => [[227, 79, 45], [254, 109, 70]],
                Regime::Transient => [[202, 154, 21], [248, 202, 78]],
                Regime::Noise => [[111, 84, 75], [182, 150, 123]],
                Regime::Undetermined => [[122, 124, 127], [149, 155, 174]],
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

    type Matrix = [[f64; 3]; 3];

    /// Colours as seen with normal vision, protanopia and deuteranopia, in linear RGB (Machado, Oliveira and Fernandes
    /// 2009).
    const VISIONS: [Matrix; 3] = [
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        [
            [0.152286, 1.052583, -0.204868],
            [0.114503, 0.786281, 0.099216],
            [-0.003882, -0.048116, 1.051998],
        ],
        [
            [0.367322, 0.860646, -0.227968],
            [0.280085, 0.672501, 0.047413],
            [-0.011820, 0.042940, 0.968881],
        ],
    ];
    /// From linear RGB to the responses of the cones, and from their cube roots to Oklab (Ottosson 2020).
    const CONES: Matrix = [
        [0.4122214708, 0.5363325363, 0.0514459929],
        [0.2119034982, 0.6806995451, 0.1073969566],
        [0.0883024619, 0.2817188376, 0.6299787005],
    ];
    const OKLAB: Matrix = [
        [0.2104542553, 0.7936177850, -0.0040720468],
        [1.9779984951, -2.4285922050, 0.4505937099],
        [0.0259040371, 0.7827717662, -0.8086757660],
    ];

    fn times(matrix: &Matrix, vector: [f64; 3]) -> [f64; 3] {
        matrix.map(|row| row.iter().zip(vector).map(|(a, b)| a * b).sum())
    }

    fn linear(color: Rgb) -> [f64; 3] {
        color.map(|c| match f64::from(c) / 255.0 {
            c if c <= 0.04045 => c / 12.92,
            c => ((c + 0.055) / 1.055).powf(2.4),
        })
    }

    /// Smallest distance of two colours in Oklab with any vision.
    fn distance(a: Rgb, b: Rgb) -> f64 {
        let distances = VISIONS.map(|vision| {
            let [a, b] = [a, b].map(|color| {
                let seen = times(&vision, linear(color)).map(|c| c.clamp(0.0, 1.0));
                times(&OKLAB, times(&CONES, seen).map(f64::cbrt))
            });
            let squares = a.iter().zip(b).map(|(a, b)| (a - b).powi(2));
            squares.sum::<f64>().sqrt()
        });
        distances.into_iter().fold(f64::INFINITY, f64::min)
    }

    /// Contrast of the Web Content Accessibility Guidelines, 1 to 21.
    fn contrast(a: Rgb, b: Rgb) -> f64 {
        let luminance = |color| {
            let [r, g, b] = linear(color);
            0.2126 * r + 0.7152 * g + 0.0722 * b + 0.05
        };
        let ratio = luminance(a) / luminance(b);
        ratio.max(ratio.recip())
    }

    /// Types of motion with the roles beside them, and the series, are told apart with any vision, and visible in print and
    /// in the viewer; the dark words of the page are legible on them. Oklab distances of 0.02 are just noticeable.
    #[test]
    fn colours_are_distinguishable() {
        let roles = [Color::Ink, Color::Accent, Color::Run, Color::Compared];
        let regimes = Regime::VARIANTS.iter().copied().map(Color::Regime);
        let series = (0..SERIES.len()).map(Color::Series).collect();
        for family in [regimes.chain(roles).collect::<Vec<_>>(), series] {
            for (k, one) in family.iter().enumerate() {
                let [light, dark] = one.pair();
                assert!(contrast(light, [255; 3]) > 2.5, "{one:?} on paper");
                assert!(contrast(dark, [0x10, 0x12, 0x16]) > 4.5, "{one:?} on dark");
                for other in &family[..k] {
                    let grounds = one.pair().into_iter().zip(other.pair());
                    let apart = grounds.map(|(a, b)| distance(a, b)).fold(1.0, f64::min);
                    assert!(apart > 0.07, "{one:?} and {other:?}: {apart}");
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

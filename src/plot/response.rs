//! Panels of one steady-state motion: time series, phase portrait, delay reconstruction, spectrum, Poincaré
//! section, recurrence plot. The figures of the paper and of the attractors and the recordings of sweeps use
//! them.

use super::axis::extent;
use super::color::{colormap, colormap_index};
use super::{
    Axis, Color, Image, Layer, Panel, Scale, SectionAxes, Unit, full_scale, round_up, units,
};
use crate::analysis::{recurrence::RecurrenceImage, stats::range, tones::SpectralLine};
use crate::pipeline::message::{Header, Subject};
use crate::scene::Evidence;
use crate::study::response::{PhasePortrait, SettledResponse};

/// Delay of reconstructions, s: a quarter of the period of 4.1 kHz.
pub const LAG: f64 = 60e-6;
/// Length of time series and recurrence plots, s: about twenty periods of a 4 kHz squeak.
pub const WINDOW: f64 = 5e-3;

/// Points drawn per sample interval, so that curves have no visible corners.
const FINER: usize = 5;
/// Maximum number of labelled spectral lines.
pub const NAMED_LINES: usize = 6;
/// Maximum number of points of a spectrum; it exceeds the number of pixels.
const SPECTRUM_POINTS: usize = 2000;
/// Maximum number of points of a time series.
pub const SERIES_POINTS: usize = 4000;
/// Smallest amplitude (m) and speed (m/s) shown.
pub const SMALLEST: [f64; 2] = [1e-12, 1e-8];

/// Displacement (m) and velocity (m/s) at the samples.
pub fn samples(portrait: &PhasePortrait) -> Vec<[f64; 2]> {
    let samples = portrait.u_m.iter().zip(&portrait.v_m_per_s);
    samples.map(|(&u, &v)| [u, v].map(f64::from)).collect()
}

/// Displacement (m) and velocity (m/s), interpolated between samples `h` (s) apart by the cubic Hermite polynomial of
/// displacements and velocities, and its derivative.
pub fn interpolated(samples: &[[f64; 2]], h: f64) -> Vec<[f64; 2]> {
    let pieces = samples.windows(2).flat_map(|pair| {
        let [[u0, v0], [u1, v1]] = [pair[0], pair[1]];
        (0..FINER).map(move |k| {
            let s = k as f64 / FINER as f64;
            let rise = u1 - u0;
            let (a, b) = (h * v0 - rise, rise - h * v1);
            let r = 1.0 - s;
            let u = r * u0 + s * u1 + s * r * (r * a + s * b);
            let slope = rise + (1.0 - 2.0 * s) * (r * a + s * b) + s * r * (b - a);
            [u, slope / h]
        })
    });
    pieces.chain(samples.last().copied()).collect()
}

/// The largest displacement (m) and speed (m/s) of a response.
pub fn largest(response: &SettledResponse) -> [f64; 2] {
    let Some(motion) = &response.portrait else {
        return [response.amplitude_m, 0.0];
    };
    [&motion.u_m, &motion.v_m_per_s].map(|values| {
        let sizes = values.iter().map(|value| f64::from(value.abs()));
        sizes.fold(0.0, f64::max)
    })
}

/// Displacement over the last 5 ms of an interpolated motion with samples `dt` (s) apart.
pub fn time_series(fine: &[[f64; 2]], dt: f64, color: Color) -> Panel {
    let dt = dt / FINER as f64;
    let count = (WINDOW / dt).round() as usize + 1;
    let first = fine.len().saturating_sub(count);
    let points = fine[first..].iter().enumerate();
    let points: Vec<[f64; 2]> = points.map(|(k, [u, _])| [dt * k as f64, *u]).collect();
    let x = Axis::linear("time", [0.0, WINDOW]).of("s");
    let y = Axis::with_margin("u", points.iter().map(|p| p[1])).of("m");
    let layers = vec![Layer::line(points, color)];
    Panel::new("displacement at the patch centre", x, y, layers)
}

/// A curve of a time series: label, colour, width of the line (points on paper), and values over the time in s.
pub type Curve = (String, Color, f64, Vec<[f64; 2]>);

/// Time series over a range of the time (s), by default their own, on an axis with a name, a unit that takes a prefix, and
/// a scale. A curve with gaps, or with a single value, has points instead of a line; a logarithmic axis is for positive
/// values.
pub fn over_time(
    title: &str,
    (name, unit, scale): (&str, &str, Scale),
    times: Option<[f64; 2]>,
    all: &[Curve],
) -> Panel {
    let is_finite = |point: &[f64; 2]| point[1].is_finite();
    let layers = all.iter().map(|(label, color, width, points)| {
        let parts = points.split(|point| !is_finite(point));
        let parts = parts.filter(|part| !part.is_empty()).count();
        let values = points.iter().copied().filter(is_finite);
        let values: Vec<[f64; 2]> = values.collect();
        let layer = if parts > 1 || values.len() < 2 {
            Layer::points(values, 1.4, *color)
        } else {
            Layer::line(envelope(values, SERIES_POINTS), *color).with_size(*width)
        };
        layer.with_label(label)
    });
    let layers: Vec<Layer> = layers.collect();
    let values = layers.iter().flat_map(Layer::points_of).map(|p| p[1]);
    let y = match scale {
        Scale::Logarithmic => Axis::rounded_logarithmic(name, values),
        _ => Axis::with_margin(name, values.chain([0.0])),
    };
    let y = if unit.is_empty() { y } else { y.of(unit) };
    let points = all.iter().flat_map(|(.., points)| points);
    let times = times.unwrap_or_else(|| range(points.map(|point| point[0])));
    Panel::new(title, Axis::linear("time", times).of("s"), y, layers)
}

/// Phase portrait: velocity (m/s) over displacement (m), on axes of ± `reach` if it is given.
pub fn phase_portrait(points: &[[f64; 2]], reach: Option<[f64; 2]>, color: Color) -> Panel {
    let axis = |c: usize, name| match reach {
        Some(reach) => Axis::linear(name, [-reach[c], reach[c]]),
        None => Axis::with_margin(name, points.iter().map(|p| p[c])),
    };
    let x = axis(0, "displacement").of("m");
    let y = axis(1, "velocity").of("m/s");
    let trail = Layer::line(points.to_vec(), color).with_size(0.9);
    Panel::new("phase portrait", x, y, vec![trail.with_id("trail")])
}

/// Common range of displacement (m) and speed (m/s) of phase portraits that are compared; `least` is the
/// smallest range.
pub fn common_range(found: &[&SettledResponse], least: [f64; 2]) -> [f64; 2] {
    let sizes = found.iter().map(|response| largest(response));
    let largest = sizes.fold(least, |[a, b], [c, d]| [a.max(c), b.max(d)]);
    largest.map(|size| round_up(1.02 * size))
}

/// A curve of many points: the lowest and the highest of each interval, so that about `most` remain.
pub fn envelope(points: Vec<[f64; 2]>, most: usize) -> Vec<[f64; 2]> {
    if points.len() <= most {
        return points;
    }
    let intervals = points.chunks(points.len().div_ceil(most / 2));
    let ends = intervals.flat_map(|part| {
        let [x, _] = part[part.len() / 2];
        extent(part.iter().map(|point| point[1])).map(|y| [x, y])
    });
    ends.collect()
}

/// Delay reconstruction of an interpolated motion with samples `dt` (s) apart in two dimensions.
pub fn reconstruction(fine: &[[f64; 2]], dt: f64, color: Color) -> Panel {
    let lag = (FINER as f64 * LAG / dt).round().max(1.0) as usize;
    let pairs = fine.iter().zip(fine.iter().skip(lag));
    let points: Vec<[f64; 2]> = pairs.map(|([a, _], [b, _])| [*a, *b]).collect();
    let axis = |c: usize, name| Axis::with_margin(name, points.iter().map(|p| p[c])).of("m");
    let (x, y) = (axis(0, "u(t)"), axis(1, "u(t + τ)"));
    let title = format!("delay reconstruction, τ = {:.0} µs", 1e6 * LAG);
    let curve = Layer::line(points, color).with_size(0.9);
    Panel::new(title, x, y, vec![curve])
}

/// The axes of spectra, without data: amplitudes of the displacement over `decades` decades below `largest` (m),
/// frequencies up to `highest` (Hz).
pub fn spectrum_axes(largest: f64, decades: i32, highest: f64) -> Panel {
    let top = largest.max(SMALLEST[0]).log10().ceil() as i32;
    let x = Axis::linear("frequency", [0.0, highest]).of("Hz");
    let y = Axis::decades("amplitude", [top - decades, top]);
    let y = y.written_in(Unit::of("m", largest));
    Panel::new("spectrum", x, y, Vec::new())
}

/// The axes of the spectra of a run: velocity amplitudes of 0.0001 to 100 mm/s; of a signal from a file, seven decades
/// below its full scale. Frequencies that the lesson computes are marked.
pub fn run_spectrum_axes(header: &Header) -> Panel {
    let (name, [low, high], largest) = match &header.subject {
        Subject::Joint(_) | Subject::Small(_) => ("velocity amplitude", [-7, -1], 1e-3),
        Subject::Signal(signal) => {
            let full = full_scale(signal);
            let top = full.log10().ceil() as i32;
            ("amplitude", [top - 7, top], full)
        }
    };
    let highest = header.highest_frequency();
    let x = Axis::linear("frequency", [0.0, highest]).of("Hz");
    let y = Axis::decades(name, [low, high]);
    let y = y.written_in(Unit::of(units(&header.subject)[1], largest));
    let computed = header.computed.iter();
    let computed = computed.filter(|computed| computed.mechanism.evidence() == Evidence::Modes);
    let unstable = computed.flat_map(|computed| computed.unstable());
    let marks = unstable.filter(|mode| mode.frequency_hz <= highest);
    let marks = marks.map(|mode| y.range.map(|end| [mode.frequency_hz, end]).to_vec());
    let marks = Layer::lines(marks.collect(), Color::Faint).with_id("computed");
    let marks = Vec::from_iter(Some(marks).filter(Layer::has_points));
    Panel::new("spectrum", x, y, marks)
}

/// A spectrum on some axes, with values `bin` (Hz) apart, and its labelled lines, strongest first.
pub fn spectrum(
    axes: &Panel,
    bin: f64,
    values: impl IntoIterator<Item = f64>,
    lines: &[SpectralLine],
    color: Color,
) -> Panel {
    let mut panel = axes.clone();
    let Axis { range, unit, .. } = &axes.x;
    let points = values.into_iter().enumerate();
    let points = points.map(|(k, amplitude)| [bin * k as f64, amplitude]);
    let points = points.take_while(|point| point[0] <= range[1]);
    let points = envelope(points.collect(), SPECTRUM_POINTS);
    let shown = lines.iter().filter(|line| line.frequency <= range[1]);
    let peaks = shown.take(NAMED_LINES).map(|line| {
        let frequency = unit.factor * line.frequency;
        let name = match &*line.label {
            "" => format!("{frequency:.2}"),
            name => format!("{name}: {frequency:.2}"),
        };
        ([line.frequency, line.amplitude], name)
    });
    let peaks = Layer::peaks(peaks.collect());
    panel.layers.extend([Layer::line(points, color), peaks]);
    panel
}

/// The spectrum of a motion with its labelled lines.
pub fn motion_spectrum(axes: &Panel, motion: &PhasePortrait, lines: &[SpectralLine]) -> Panel {
    let amplitude = motion.spectrum_m.iter().map(|a| f64::from(*a));
    spectrum(axes, motion.spectrum_bin_hz, amplitude, lines, Color::Faint)
}

/// The axes of the sections of some responses. `letter` is the symbol of the displacement, `fallback` the half-width
/// without intersections.
pub fn section_axes(found: &[&SettledResponse], letter: &str, fallback: f64) -> SectionAxes {
    let points = || found.iter().flat_map(|response| &response.section_m);
    let smallest = points().next().map_or(fallback, |_| SMALLEST[0]);
    let mut axes = SectionAxes::delayed(letter, "m", [0.0, smallest]);
    axes.fit(points());
    axes
}

/// The section of one response; an empty panel without one.
pub fn section(axes: &SectionAxes, response: Option<&SettledResponse>) -> Panel {
    let points = response.map_or(&[][..], |response| &response.section_m);
    let color = response.map_or(Color::Ink, |response| Color::Regime(response.regime));
    axes.section(points, color)
}

/// Distance classes of a recurrence plot, 0 the nearest; recurrences are the next class. The number is small,
/// because noise in the last bits would only enlarge a recording.
pub const SHADES: u8 = 16;

/// Recurrence plot of the last 5 ms: recurrences are dark on paper and bright in the viewer. `shaded` shows
/// the distances of the other pairs, too.
pub fn recurrence(found: Option<&RecurrenceImage>, shaded: bool) -> Panel {
    let window = found.map_or(WINDOW, |found| found.window);
    let ends = [-window, 0.0];
    let axis = || Axis::linear("time before end", ends).of("s");
    let classes = found.map_or_else(Vec::new, |found| classes(found, shaded));
    let image = Layer::image(Image {
        x: ends,
        y: ends,
        size: [found.map_or(0, |found| found.size); 2],
        pixels: classes,
        palette: recurrence_palette(),
    });
    Panel::new("recurrence plot", axis(), axis(), vec![image]).square()
}

/// Recurrence rate, threshold (a distance in `unit`), dimension and delay of a recurrence plot.
pub fn recurrence_caption(plot: &RecurrenceImage, unit: &str) -> String {
    let epsilon = match plot.threshold {
        Some(threshold) => format!("ε = {}", Unit::write(threshold, unit)),
        None => "ε chosen for each state".to_owned(),
    };
    let (rate, dimension) = (1e2 * plot.rate, plot.dimension);
    let lag = Unit::write(plot.lag, "s");
    format!("RR = {rate:.0} %, {epsilon}, m = {dimension}, τ = {lag}")
}

/// The class of each pixel, the latest row first.
pub fn classes(found: &RecurrenceImage, shaded: bool) -> Vec<u8> {
    let pairs = found.distance.iter().zip(&found.recurrent);
    let class = |(distance, recurrent): (&u8, &u8)| match (*recurrent > 0, shaded) {
        (true, _) => SHADES,
        (false, true) => distance / (255 / SHADES + 1),
        (false, false) => SHADES - 1,
    };
    let classes: Vec<u8> = pairs.map(class).collect();
    let rows = classes.chunks(found.size.max(1)).rev();
    rows.flatten().copied().collect()
}

/// The palette: shades of distance, the nearest first, and the colour of recurrences.
fn recurrence_palette() -> Vec<(Color, String)> {
    let map = colormap();
    let shades = (0..SHADES).map(|shade| {
        let far = f64::from(shade) / f64::from(SHADES - 1);
        // Pale grey to white on paper; half brightness to black in the viewer.
        let light = [(190.0 + 65.0 * far) as u8; 3];
        let dark = map[usize::from(colormap_index(0.5 + 0.5 * far))];
        let percent = 100 * (u32::from(shade) + 1) / u32::from(SHADES);
        let name = format!("distance up to {percent} % of the largest");
        (Color::Shade([light, dark]), name)
    });
    let recurrent = Color::Shade([Color::Ink.on_light(), map[0]]);
    let recurrent = (recurrent, "recurrent".to_owned());
    shades.chain([recurrent]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_latest_row_of_a_recurrence_plot_is_on_top() {
        let found = RecurrenceImage {
            window: 1e-3,
            size: 2,
            distance: vec![0, 255, 255, 0],
            recurrent: vec![0, 0, 0, 255],
            threshold: Some(1e-7),
            rate: 0.25,
            lag: 1e-5,
            dimension: 3,
        };
        let far = SHADES - 1;
        assert_eq!(classes(&found, true), [far, SHADES, 0, far]);
        assert_eq!(classes(&found, false), [far, SHADES, far, far]);
    }

    #[test]
    fn an_envelope_keeps_lines_and_noise_floor() {
        let points = (0..16_000).map(|k| {
            let value = match k {
                800 => 1.0,
                1001 => 1e-6,
                _ => 1e-3,
            };
            [f64::from(k), value]
        });
        let points: Vec<[f64; 2]> = points.collect();
        let thin = envelope(points.clone(), SPECTRUM_POINTS);
        assert_eq!(thin.len(), SPECTRUM_POINTS);
        assert_eq!((thin[101], thin[124]), ([808.0, 1.0], [1000.0, 1e-6]));
        let few = &points[..SPECTRUM_POINTS];
        assert_eq!(envelope(few.to_vec(), SPECTRUM_POINTS), few);
    }

    #[test]
    fn a_sine_is_smooth_between_its_samples() {
        let dt = 5e-6;
        let omega = std::f64::consts::TAU * 12.4e3;
        let wave = |k: usize| omega * dt * k as f64;
        let portrait = PhasePortrait {
            dt_s: dt,
            u_m: (0..50).map(|k| wave(k).sin() as f32).collect(),
            v_m_per_s: (0..50).map(|k| (omega * wave(k).cos()) as f32).collect(),
            spectrum_bin_hz: 1.0,
            spectrum_m: Vec::new(),
        };
        let fine = interpolated(&samples(&portrait), dt);
        assert_eq!(fine.len(), 49 * FINER + 1);
        for (k, [u, v]) in fine.into_iter().enumerate() {
            let phase = omega * dt * k as f64 / FINER as f64;
            assert!((u - phase.sin()).abs() < 2e-4, "{k}: {u}");
            assert!((v / omega - phase.cos()).abs() < 3e-3, "{k}: {v}");
        }
    }
}

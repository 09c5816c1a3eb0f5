//! Figures of the report on a signal.

use std::collections::BTreeMap;

use super::axis::extent;
use super::color::{colormap, colormap_index};
use super::figure::{plain_palette, regime_legend};
use super::response::{Curve, over_time};
use super::{Axis, Color, Figure, Image, Layer, Panel, Scale, SectionAxes, Unit};
use super::{chaos, figures, range_shown, response};
use crate::analysis::chaos::Divergence;
use crate::analysis::levels::LevelReference;
use crate::analysis::recurrence::{Measures, RecurrencePeriods};
use crate::analysis::regime::{Evidence, Verdict};
use crate::analysis::tones::{Bases, Column};
use crate::number::significant;
use crate::study::signal::{Outcome, SignalAnalysis, SkipReason};

/// Maximum number of points of a curve; more cannot be resolved.
const MOST_POINTS: usize = 4000;
/// Periods shown in the detail panel; without a period, hundredths of the signal.
const CLOSE_PERIODS: f64 = 12.0;
/// Maximum number of labelled spectral lines.
const NAMED_LINES: usize = 8;
/// Range of the spectrum and of the spectrogram below the strongest line, dB.
const DEPTH_DB: f64 = 100.0;
const SPECTROGRAM_DB: f64 = 80.0;
/// Highest frequency shown over that of all lines and events.
const HEADROOM: f64 = 1.25;
/// Maximum number of rows of a spectrogram.
const ROWS: usize = 600;
/// Colour of ridges: visible on the dark colours of strong tones.
const RIDGE: Color = Color::Series(6);

/// Panels, or why the analysis was skipped.
type Picture = Result<Vec<Panel>, SkipReason>;

/// What draws a picture of a report.
type Draw = fn(&SignalAnalysis) -> Picture;

/// The pictures of a report, each with the names of its panels in the list of figures.
const PICTURES: [(&str, Draw); 13] = [
    ("events", events),
    ("waveform waveform-near", waveform),
    ("spectrum", spectrum),
    ("spectrogram", spectrogram),
    ("mutual-information false-neighbours", delay),
    ("portrait", portrait),
    ("recurrence", recurrence),
    ("recurrence-shares recurrence-times entropy", measures),
    ("section return-map", section),
    ("return-times", return_times),
    ("divergence kantz", divergence),
    ("zero-one-frequencies zero-one-path", zero_one),
    ("evidence", regime),
];

/// The figures of a report.
pub fn signal_figures(report: &SignalAnalysis) -> Vec<Figure> {
    let panels = PICTURES.iter().flat_map(|(names, picture)| {
        let skipped = |reason| vec![empty_panel("skipped", reason)];
        let panels = picture(report).unwrap_or_else(skipped);
        names.split(' ').zip(panels)
    });
    let panels: BTreeMap<_, _> = panels.collect();
    figures(&report.signal.name, |name| panels.get(name).cloned())
}

/// The unit in which samples are written.
fn unit(report: &SignalAnalysis) -> Unit {
    let samples = &report.signal.samples;
    let largest = samples.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    Unit::of(&report.signal.unit, largest)
}

/// A panel without data that says why.
fn empty_panel(title: &str, reason: impl ToString) -> Panel {
    let axis = Axis::linear("", [0.0, 1.0]);
    Panel::new(title, axis.clone(), axis, Vec::new()).with_note(reason.to_string())
}

/// A curve at the resolution of the figure.
fn curve(points: impl Iterator<Item = [f64; 2]>) -> Layer {
    let points = response::envelope(points.collect(), MOST_POINTS);
    Layer::line(points, Color::Ink).with_size(0.8)
}

/// The spectrogram with the ridges of the events, numbered at their starts.
fn events(report: &SignalAnalysis) -> Picture {
    let mut panel = spectrogram_panel(report);
    let events = report.events();
    let reference = report.level_reference();
    let shown = format!("events with number and level ({reference}) at their starts");
    let title = match (&report.sound, events.len()) {
        (None, _) => "no tonal events: the sample rate is not that of sound",
        (Some(_), 0) => "no tonal events",
        _ => &shown,
    };
    if !events.is_empty() {
        let ridges = events.iter().map(|event| {
            let ridge = event.ridge.iter();
            ridge.map(|p| [p.time_s, p.frequency_hz]).collect()
        });
        let ridges = Layer::lines(ridges.collect(), RIDGE).with_size(1.3);
        let starts = events.iter().zip(1..).map(|(event, number)| {
            let start = [event.start_s, event.frequency_at(event.start_s)];
            (start, format!("{number}: {:.1}", event.level_db))
        });
        let starts = Layer {
            color: RIDGE,
            ..Layer::peaks(starts.collect())
        };
        panel.layers.extend([ridges.with_id("ridges"), starts]);
    }
    Ok(vec![panel.with_title(title)])
}

fn waveform(report: &SignalAnalysis) -> Picture {
    let signal = &report.signal;
    let all = &signal.samples;
    let count = all.len();
    let line = report.tones.lines.first();
    let periods = line.map(|line| CLOSE_PERIODS * signal.rate / line.line.frequency);
    let close = periods.unwrap_or(0.01 * count as f64).ceil() as usize;
    let close = close.clamp(2.min(count), count);
    let y = Axis::with_margin("signal", all.iter().copied()).written_in(unit(report));
    let panel = |title: &str, from: usize| {
        let curve = curve((from..count).map(|k| [signal.time(k as f64), all[k]]));
        let times = [from as f64, count as f64 - 1.0].map(|sample| signal.time(sample));
        let x = Axis::linear("time", times).of("s");
        Panel::new(title, x, y.clone(), vec![curve])
    };
    let whole = panel("whole signal", 0);
    let end = panel("end of the signal", count - close);
    Ok(vec![whole, end])
}

fn spectrum(report: &SignalAnalysis) -> Picture {
    let spectrum = &report.spectrum;
    let strongest = spectrum.amplitude.iter().copied().fold(0.0, f64::max);
    // Relative to the strongest line, or to a sine of 20 uPa RMS.
    let sound = LevelReference::SoundPressure;
    let (zero, reference) = if report.signal.unit == LevelReference::PASCAL {
        (sound.amplitude(strongest), sound.to_string())
    } else {
        let Unit { symbol, factor } = unit(report);
        let shown = significant(strongest * factor, 3);
        (strongest.max(1e-300), format!("dB re {shown} {symbol}"))
    };
    let level = |a: f64| 20.0 * (a.max(1e-12 * strongest).max(1e-300) / zero).log10();
    let highest = report.highest_frequency(HEADROOM);
    let shown = (highest / spectrum.bin).ceil() as usize + 1;
    let levels = spectrum.amplitude.iter().take(shown).map(|&a| level(a));
    let lowest = extent(levels.clone())[0].max(level(strongest) - DEPTH_DB - 20.0);
    let lines = report.tones.lines.iter().take(NAMED_LINES);
    let lines = lines.map(|named| &named.line);
    let named = lines.filter(|line| !line.label.is_empty());
    let peaks = named.map(|line| ([line.frequency, level(line.amplitude)], line.label.clone()));
    let peaks = Layer::peaks(peaks.collect());
    let bases = bases(&report.tones.naming.bases);
    let floor = 100.0 * report.tones.broadband_share;
    let name = format!("amplitude, {}", reference.trim_end());
    let x = Axis::linear("frequency", [0.0, highest]).of("Hz");
    let y = Axis::linear(name, [lowest, level(strongest) + 20.0]);
    let levels = levels.enumerate();
    let curve = curve(levels.map(|(k, level)| [k as f64 * spectrum.bin, level]));
    let layers = vec![curve, peaks];
    let title = format!("{bases}; broadband floor {floor:.2} %");
    Ok(vec![Panel::new(title, x, y, layers)])
}

fn spectrogram(report: &SignalAnalysis) -> Picture {
    Ok(vec![spectrogram_panel(report)])
}

/// The spectrogram of the whole signal.
fn spectrogram_panel(report: &SignalAnalysis) -> Panel {
    let columns = &report.spectrogram;
    let title = format!("dark is strong; range {SPECTROGRAM_DB:.0} dB");
    let (Some(first), Some(last)) = (columns.first(), columns.last()) else {
        return empty_panel(&title, "the signal is too short for a spectrogram");
    };
    let shown = (report.highest_frequency(HEADROOM) / first.bin).ceil() as usize;
    let shown = shown.clamp(1, first.amplitude.len());
    let times = [first.centre, last.centre].map(|sample| report.signal.time(sample));
    let image = image(columns, shown, times, [0.0, shown as f64 * first.bin]);
    let x = Axis::linear("time", image.x).of("s");
    let y = Axis::linear("frequency", image.y).of("Hz");
    Panel::new(title, x, y, vec![Layer::image(image)])
}

/// The lowest bins of the columns as an image; each pixel shows the largest amplitude of its bins.
fn image(columns: &[Column], bins: usize, x: [f64; 2], y: [f64; 2]) -> Image {
    let most = |amplitude: &[f64]| amplitude.iter().copied().fold(0.0, f64::max);
    let strongest = columns.iter().map(|c| most(&c.amplitude[..bins]));
    let strongest = strongest.fold(0.0, f64::max);
    let height = bins.min(ROWS);
    let pixels = (0..height).rev().flat_map(|row| {
        let first = row * bins / height;
        let bins = first..((row + 1) * bins / height).max(first + 1);
        columns.iter().map(move |column| {
            let share = most(&column.amplitude[bins.clone()]) / strongest;
            colormap_index(1.0 + 20.0 * share.log10() / SPECTROGRAM_DB)
        })
    });
    Image {
        x,
        y,
        size: [columns.len(), height],
        pixels: pixels.collect(),
        palette: plain_palette(colormap()),
    }
}

/// The base frequencies as text.
fn bases(bases: &Bases) -> String {
    let hertz = |f: f64| match f {
        f if f >= 1000.0 => format!("{:.4} kHz", 1e-3 * f),
        f => format!("{f:.3} Hz"),
    };
    match bases {
        Bases::None => "no simple pattern of spectral lines".to_owned(),
        Bases::One { f1 } => format!("f1 = {}", hertz(*f1)),
        Bases::Modulated { f1, fm } => {
            format!("f1 = {}, modulated at fm = {}", hertz(*f1), hertz(*fm))
        }
        Bases::Two { f1, f2 } => format!("f1 = {}, f2 = {}", hertz(*f1), hertz(*f2)),
    }
}

fn delay(report: &SignalAnalysis) -> Picture {
    let dt = 1.0 / report.analysed().rate;
    Ok(chaos::embedding(dt, &report.embedding.get()?.choice).to_vec())
}

fn portrait(report: &SignalAnalysis) -> Picture {
    let lag = report.embedding.get()?.choice.lag;
    let samples = &report.analysed().samples;
    let count = samples.len().saturating_sub(lag);
    let newest = count.saturating_sub(2 * MOST_POINTS)..count;
    let title = format!("delay {lag} samples, the last {}", newest.len());
    let points = newest.map(|k| [samples[k], samples[k + lag]]).collect();
    let axis = |name| Axis::with_margin(name, samples.iter().copied()).written_in(unit(report));
    let (x, y) = (axis("y(t)"), axis("y(t + τ)"));
    let curve = Layer::line(points, Color::Ink).with_size(0.6);
    let panel = Panel::new(title, x, y, vec![curve]);
    Ok(vec![panel.square()])
}

fn recurrence(report: &SignalAnalysis) -> Picture {
    let recurrence = report.recurrence.get()?;
    let picture = &recurrence.picture;
    let mut panel = response::recurrence(Some(picture), true);
    let marks = period_marks(&recurrence.recurrence_periods, picture.window);
    panel.layers.extend(marks);
    let share = 100.0 * picture.rate;
    let panel = panel.with_title(format!("recurrence rate {share:.2} % in this plot"));
    Ok(vec![panel])
}

/// The diagonals at the recurrence periods that fit in a plot of a window (s), above the line of identity.
fn period_marks(periods: &RecurrencePeriods, window: f64) -> impl Iterator<Item = Layer> {
    let inside = periods.0.iter().filter(move |found| found.period < window);
    inside.enumerate().map(move |(k, found)| {
        let line = vec![[-window, found.period - window], [-found.period, 0.0]];
        let label = format!("{}: {}", found.kind, Unit::write(found.period, "s"));
        let line = Layer::line(line, Color::Series(k)).dashed();
        line.with_label(label)
    })
}

fn measures(report: &SignalAnalysis) -> Picture {
    let windows = &report.recurrence.get()?.windows;
    let curve = |label: &str, color, value: &dyn Fn(&Measures) -> Option<f64>| {
        let points = windows.iter();
        let points = points.map(|at| [at.time_s, value(&at.measures).unwrap_or(f64::NAN)]);
        (
            label.to_owned(),
            Color::Series(color),
            1.0,
            points.collect(),
        )
    };
    let shares = [
        curve("RR", 0, &|m| Some(m.recurrence_rate)),
        curve("DET", 2, &|m| m.determinism),
        curve("LAM", 3, &|m| m.laminarity),
    ];
    let lengths = [
        curve("L", 2, &|m| m.mean_diagonal),
        curve("TT", 3, &|m| m.trapping_time),
        curve("T²", 4, &|m| m.recurrence_time_2),
    ];
    let entropy = [curve("", 0, &|m| m.entropy)];
    let panel = |title, name, unit, curves: &[Curve]| {
        over_time(title, (name, unit, Scale::Linear), None, curves)
    };
    let title = "mean line lengths L and TT, recurrence time T²";
    let lengths = panel(title, "duration", "s", &lengths);
    let entropy = panel("entropy of the diagonal line lengths", "nats", "", &entropy);
    let shares = panel("RR, DET and LAM", "", "", &shares);
    Ok(vec![shares, lengths, entropy])
}

fn section(report: &SignalAnalysis) -> Picture {
    let crossings = report.section.get()?.crossings.iter();
    let points: Vec<[f64; 2]> = crossings.map(|crossing| crossing.at).collect();
    let mut axes = section_axes(report);
    axes.fit(points.iter());
    let map = axes.return_map(&points, Color::Ink);
    let section = axes.section(&points, Color::Ink);
    let section = section.with_title(format!("{} intersections", points.len()));
    Ok(vec![section, map])
}

/// The axes of a section about the middle of the samples.
fn section_axes(report: &SignalAnalysis) -> SectionAxes {
    let span = extent(report.analysed().samples.iter().copied());
    SectionAxes::delayed("y", &report.signal.unit, range_shown(span))
}

fn return_times(report: &SignalAnalysis) -> Picture {
    let crossings = report.section.get()?.crossings.iter();
    let times: Vec<f64> = crossings.map(|crossing| crossing.time_s).collect();
    Ok(vec![section_axes(report).return_times(&times, Color::Ink)])
}

fn divergence(report: &SignalAnalysis) -> Picture {
    let panel = |title: &str, divergence: &Outcome<Divergence>| match divergence.get() {
        Ok(divergence) => chaos::divergence(divergence, &unit(report)).with_title(title),
        Err(reason) => empty_panel(&format!("{title}: skipped"), reason),
    };
    let rosenstein = panel("Rosenstein", &report.rosenstein);
    let kantz = panel("Kantz", &report.kantz);
    Ok(vec![rosenstein, kantz])
}

fn zero_one(report: &SignalAnalysis) -> Picture {
    let test = report.zero_one.get()?;
    let x = Axis::with_margin("frequency c, rad", test.by_frequency.iter().map(|p| p[0]));
    let y = Axis::linear("K", [-1.05, 1.05]);
    let layers = vec![Layer::points(test.by_frequency.clone(), 1.7, Color::Ink)];
    let title = format!("K = {:.3}: 0 regular, 1 chaos or noise", test.k);
    let k = Panel::new(title, x, y, layers);
    // The other panel has K as its title.
    let path = chaos::zero_one_path(test, &report.signal.unit, test.path.len()).with_caption("");
    Ok(vec![k, path])
}

fn regime(report: &SignalAnalysis) -> Picture {
    Ok(vec![evidence_panel(report.verdict.get()?)])
}

/// The evidence for a type of motion.
pub fn evidence_panel(verdict: &Verdict) -> Panel {
    // What matters, as many as a slide has room for.
    let evidence = verdict.evidence.iter().filter(|piece| piece.matters());
    let evidence: Vec<&Evidence> = evidence.take(8).collect();
    let rows = evidence.iter().map(|piece| {
        let bar = ([0.0, piece.contribution], Color::Regime(piece.supports));
        (piece.criterion.clone(), vec![bar])
    });
    let largest = evidence.iter().map(|piece| piece.contribution);
    let axis = Axis::linear("change of ln(odds)", [0.0, largest.fold(1.0, f64::max)]);
    let mut panel = Panel::bars(&verdict.summary(), axis, rows.collect());
    let is_supported = |regime| evidence.iter().any(|e| e.supports == regime);
    panel.layers.extend(regime_legend(is_supported));
    panel
}

#[cfg(test)]
mod features_tests;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn silence_is_light() {
        let image = |amplitude: Vec<f64>| {
            let column = Column {
                centre: 0.0,
                bin: 1.0,
                amplitude,
            };
            image(&[column], 2, [0.0, 1.0], [0.0, 1.0]).pixels
        };
        assert_eq!(image(vec![0.0, 0.0]), [0, 0]);
        assert_eq!(image(vec![0.0, 1e-20]), [255, 0]);
    }
}

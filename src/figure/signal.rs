//! The figures of the report on a signal.

use super::panel::{Axis, Bar, Mark, Panel, extent};
use super::style::{self, BLUE, FAINT, GREEN, INK, PURPLE, Rgb, VERMILION};
use super::{Figure, FigureError};
use crate::analysis::{Divergence, Measures, return_map};
use crate::study::signal::{MeasuresAt, SignalReport};

/// Most points of a curve: more cannot be told apart.
const MOST_POINTS: usize = 4000;
/// Periods (or, without one, hundredths of the signal) that a close view shows.
const CLOSE_PERIODS: f64 = 12.0;
/// Lines of the spectrum that get a name.
const NAMED_LINES: usize = 8;
/// Decibels below the strongest that spectrum and spectrogram reach down to.
const DEPTH_DB: f64 = 100.0;

/// One figure a subject: waveform, spectrum, spectrogram, delay, portrait, recurrence, measures,
/// section, divergence, zero_one, regime.
///
/// # Errors
/// [`FigureError`].
pub fn signal_figures(report: &SignalReport) -> Result<Vec<Figure>, FigureError> {
    let view = View::new(report);
    Ok(vec![
        view.waveform()?,
        view.spectrum()?,
        view.spectrogram()?,
        view.delay()?,
        view.portrait()?,
        view.recurrence()?,
        view.measures()?,
        view.section()?,
        view.divergence()?,
        view.zero_one()?,
        view.regime()?,
    ])
}

/// A unit to print numbers in.
struct Unit {
    name: String,
    per_own: f64,
}

impl Unit {
    /// For values up to `largest` in `unit`: with a prefix where the unit takes one, else with a
    /// power of ten.
    fn of(unit: &str, largest: f64) -> Self {
        const PLAIN: [&str; 9] = ["m", "m/s", "m/s²", "m/s^2", "Pa", "V", "A", "N", "s"];
        const PREFIXES: [&str; 6] = ["n", "µ", "m", "", "k", "M"];
        let large = largest.is_finite() && largest > 0.0;
        let step = if large {
            (largest.log10() / 3.0).floor() as i32
        } else {
            0
        };
        if PLAIN.contains(&unit) {
            let step = step.clamp(-3, 2);
            return Self {
                name: format!("{}{unit}", PREFIXES[(step + 3) as usize]),
                per_own: 10_f64.powi(-3 * step),
            };
        }
        if (-1..=1).contains(&step) {
            return Self {
                name: unit.to_owned(),
                per_own: 1.0,
            };
        }
        let power = format!("1e{}", 3 * step).replace('-', "−");
        Self {
            name: format!("{power} {unit}").trim_end().to_owned(),
            per_own: 10_f64.powi(-3 * step),
        }
    }

    /// A name with the unit behind it, if there is one.
    fn after(&self, name: &str) -> String {
        if self.name.is_empty() {
            name.to_owned()
        } else {
            format!("{name}, {}", self.name)
        }
    }
}

/// The report with what all figures need of it.
struct View<'a> {
    report: &'a SignalReport,
    /// Unit of the signal.
    unit: Unit,
    /// Unit of times along the signal.
    along: Unit,
    /// Frequencies are in kHz rather than in Hz.
    kilo: bool,
}

impl<'a> View<'a> {
    fn new(report: &'a SignalReport) -> Self {
        let samples = &report.signal.samples;
        let largest = samples.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let seconds = samples.len() as f64 / report.signal.rate;
        Self {
            report,
            unit: Unit::of(&report.signal.unit, largest),
            along: Unit::of("s", 0.5 * seconds.max(1e-6)),
            kilo: report.signal.rate >= 4000.0,
        }
    }

    fn title(&self, words: &str) -> String {
        format!("{words} — {}", self.report.signal.name)
    }

    fn time(&self, sample: f64) -> f64 {
        let signal = &self.report.signal;
        (signal.start + sample / signal.rate) * self.along.per_own
    }

    fn samples(&self) -> impl Iterator<Item = f64> + '_ {
        self.report
            .signal
            .samples
            .iter()
            .map(|x| x * self.unit.per_own)
    }

    fn frequency(&self, hz: f64) -> f64 {
        if self.kilo { 1e-3 * hz } else { hz }
    }

    fn frequency_name(&self) -> &'static str {
        if self.kilo {
            "frequency, kHz"
        } else {
            "frequency, Hz"
        }
    }

    /// The highest frequency worth showing, Hz: all lines, or all there is.
    fn top(&self) -> f64 {
        let nyquist = 0.5 * self.report.signal.rate;
        let lines = self.report.lines.iter().map(|l| l.line.frequency);
        let highest = lines.fold(0.0, f64::max);
        if highest > 0.0 {
            (1.25 * highest).min(nyquist)
        } else {
            nyquist
        }
    }

    fn waveform(&self) -> Result<Figure, FigureError> {
        let all: Vec<f64> = self.samples().collect();
        let count = all.len();
        let period = match self.report.lines.first() {
            Some(line) => self.report.signal.rate / line.line.frequency,
            None => count as f64 / (100.0 * CLOSE_PERIODS),
        };
        let close = ((CLOSE_PERIODS * period).ceil() as usize).clamp(2.min(count), count);
        let panel = |title: &str, from: usize| Panel {
            title: title.to_owned(),
            x: Axis::linear(
                self.along.after("time"),
                [self.time(from as f64), self.time(count as f64 - 1.0)],
            ),
            y: Axis::around(self.unit.after("signal"), all.iter().copied()),
            marks: vec![line(
                envelope(&all[from..], |k| self.time((from + k) as f64)),
                BLUE,
                "",
            )],
        };
        Figure::new(
            "waveform",
            &self.title("Waveform"),
            [900, 560],
            &[
                vec![panel("the whole signal", 0)],
                vec![panel("its end, closely", count - close)],
            ],
        )
    }

    fn spectrum(&self) -> Result<Figure, FigureError> {
        let spectrum = &self.report.spectrum;
        let strongest = spectrum.amplitude.iter().copied().fold(0.0, f64::max);
        let level = |a: f64| 20.0 * (a.max(1e-12 * strongest) / strongest.max(1e-300)).log10();
        let shown = ((self.top() / spectrum.bin).ceil() as usize + 1).min(spectrum.amplitude.len());
        let levels: Vec<f64> = spectrum.amplitude[..shown]
            .iter()
            .map(|&a| level(a))
            .collect();
        let at = |k: usize| self.frequency(k as f64 * spectrum.bin);
        let lowest = extent(levels.iter().copied())[0].max(-DEPTH_DB - 20.0);
        let mut marks = vec![line(envelope(&levels, at), BLUE, "")];
        for named in self.report.lines.iter().take(NAMED_LINES) {
            let words = match named.name {
                Some(name) => name.to_string(),
                None => continue,
            };
            let point = [
                self.frequency(named.line.frequency),
                level(named.line.amplitude),
            ];
            marks.push(dots(vec![point], 3.0, VERMILION, ""));
            marks.push(Mark::Words {
                at: [point[0], point[1] + 7.0],
                words,
            });
        }
        let unit = &self.unit;
        let name = format!(
            "amplitude, dB re {:.3} {}",
            strongest * unit.per_own,
            unit.name
        );
        let panel = Panel {
            title: format!(
                "{}; {:.2} % of the power in the floor",
                bases(&self.report.naming.bases),
                100.0 * self.report.floor_share
            ),
            x: Axis::linear(self.frequency_name(), [0.0, self.frequency(self.top())]),
            y: Axis::linear(name.trim_end(), [lowest, 16.0]),
            marks,
        };
        Figure::new(
            "spectrum",
            &self.title("Spectrum"),
            [900, 440],
            &[vec![panel]],
        )
    }

    fn spectrogram(&self) -> Result<Figure, FigureError> {
        let columns = &self.report.spectrogram;
        let marks = match (columns.first(), columns.last()) {
            (Some(first), Some(last)) => {
                let shown =
                    ((self.top() / first.bin).ceil() as usize).clamp(1, first.amplitude.len());
                let all = columns.iter().flat_map(|c| &c.amplitude[..shown]);
                let strongest = all.fold(1e-300_f64, |most, &a| most.max(a));
                let width = columns.len().min(1600);
                let height = shown.min(600);
                let mut pixels = Vec::with_capacity(width * height);
                for row in (0..height).rev() {
                    let bins = row * shown / height
                        ..((row + 1) * shown / height).max(row * shown / height + 1);
                    for x in 0..width {
                        let column = &columns[x * columns.len() / width];
                        let most = column.amplitude[bins.clone()]
                            .iter()
                            .copied()
                            .fold(0.0, f64::max);
                        let level = 20.0 * (most.max(1e-300) / strongest).log10();
                        pixels.push(style::shade(1.0 + level / (0.8 * DEPTH_DB)));
                    }
                }
                vec![Mark::Picture {
                    x: [self.time(first.centre), self.time(last.centre)],
                    y: [0.0, self.frequency(shown as f64 * first.bin)],
                    size: [width, height],
                    pixels,
                }]
            }
            _ => vec![words(
                [0.1, 0.5],
                "the signal is too short for a spectrogram",
            )],
        };
        let span = match marks.first() {
            Some(Mark::Picture { x, y, .. }) => (*x, *y),
            _ => ([0.0, 1.0], [0.0, 1.0]),
        };
        let panel = Panel {
            title: format!(
                "dark is strong, down to {:.0} dB below the strongest",
                0.8 * DEPTH_DB
            ),
            x: Axis::linear(self.along.after("time"), span.0),
            y: Axis::linear(self.frequency_name(), span.1),
            marks,
        };
        Figure::new(
            "spectrogram",
            &self.title("Spectrogram"),
            [900, 440],
            &[vec![panel]],
        )
    }

    fn delay(&self) -> Result<Figure, FigureError> {
        let delay = &self.report.delay;
        let bits = &delay.mutual.bits;
        let curve: Vec<[f64; 2]> = bits
            .iter()
            .enumerate()
            .map(|(k, &b)| [k as f64, b])
            .collect();
        let mutual = Panel {
            title: "average mutual information".to_owned(),
            x: Axis::linear("lag, samples", [0.0, bits.len().saturating_sub(1) as f64]),
            y: Axis::linear("bits", [0.0, 1.08 * extent(bits.iter().copied())[1]]),
            marks: vec![
                line(curve, BLUE, ""),
                Mark::Upright {
                    x: delay.lag as f64,
                    words: format!("τ = {}", delay.lag),
                    color: VERMILION,
                },
            ],
        };
        let share = &delay.neighbours.share;
        let curve: Vec<[f64; 2]> = share
            .iter()
            .enumerate()
            .map(|(k, &s)| [k as f64 + 1.0, 100.0 * s])
            .collect();
        let neighbours = Panel {
            title: "false nearest neighbours".to_owned(),
            x: Axis::linear("dimension", [0.5, share.len() as f64 + 0.5]),
            y: Axis::linear("share, %", [-3.0, 105.0]),
            marks: vec![
                line(curve.clone(), BLUE, ""),
                dots(curve, 3.5, BLUE, ""),
                Mark::Upright {
                    x: delay.dimension as f64,
                    words: format!("m = {}", delay.dimension),
                    color: VERMILION,
                },
            ],
        };
        Figure::new(
            "delay",
            &self.title("Lag and dimension"),
            [900, 380],
            &[vec![mutual, neighbours]],
        )
    }

    fn portrait(&self) -> Result<Figure, FigureError> {
        let samples: Vec<f64> = self.samples().collect();
        let lag = self.report.delay.lag;
        let count = samples.len().saturating_sub(lag);
        let newest = count.saturating_sub(2 * MOST_POINTS);
        let points: Vec<[f64; 2]> = (newest..count)
            .map(|k| [samples[k], samples[k + lag]])
            .collect();
        let panel = Panel {
            title: format!("lag {lag} samples, the newest {}", points.len()),
            x: Axis::around(self.unit.after("y(t)"), samples.iter().copied()),
            y: Axis::around(self.unit.after("y(t + τ)"), samples.iter().copied()),
            marks: vec![line(points, BLUE, "")],
        };
        Figure::new(
            "portrait",
            &self.title("Delay portrait"),
            [560, 560],
            &[vec![panel]],
        )
    }

    fn recurrence(&self) -> Result<Figure, FigureError> {
        let picture = &self.report.recurrence.picture;
        let span = picture.span.map(|t| t * self.along.per_own);
        let rows = |bytes: &[u8], paint: &dyn Fn(u8) -> Rgb| -> Vec<Rgb> {
            let rows = bytes.chunks_exact(picture.size.max(1)).rev();
            rows.flatten().map(|&byte| paint(byte)).collect()
        };
        let recurrent = |byte: u8| if byte > 0 { INK } else { [255; 3] };
        let distance = |byte: u8| style::shade(1.0 - f64::from(byte) / 255.0);
        let panel = |title: String, pixels: Vec<Rgb>| Panel {
            title,
            x: Axis::linear(self.along.after("time"), span),
            y: Axis::linear(self.along.after("time"), span),
            marks: if picture.size == 0 {
                vec![]
            } else {
                vec![Mark::Picture {
                    x: span,
                    y: span,
                    size: [picture.size; 2],
                    pixels,
                }]
            },
        };
        let measures = &self.report.recurrence.measures;
        let title = format!(
            "recurrent: {:.2} % of the pairs",
            100.0 * measures.recurrence_rate
        );
        Figure::new(
            "recurrence",
            &self.title("Recurrence plot"),
            [1000, 520],
            &[vec![
                panel(title, rows(&picture.recurrent, &recurrent)),
                panel(
                    "distance: dark is near".to_owned(),
                    rows(&picture.distance, &distance),
                ),
            ]],
        )
    }

    fn measures(&self) -> Result<Figure, FigureError> {
        let along = &self.report.recurrence.along;
        let step = self.report.recurrence.stride as f64 / self.report.signal.rate;
        let curve = |value: &dyn Fn(&Measures) -> Option<f64>| -> Vec<[f64; 2]> {
            let point =
                |at: &MeasuresAt| value(&at.measures).map(|v| [at.time * self.along.per_own, v]);
            along.iter().filter_map(point).collect()
        };
        let times = extent(along.iter().map(|at| at.time * self.along.per_own));
        let x = || Axis::linear(self.along.after("time"), times);
        let shares = Panel {
            title: "shares".to_owned(),
            x: x(),
            y: Axis::linear("", [0.0, 1.05]),
            marks: vec![
                line(curve(&|m| Some(m.recurrence_rate)), BLUE, "RR"),
                line(curve(&|m| m.determinism), VERMILION, "DET"),
                line(curve(&|m| m.laminarity), GREEN, "LAM"),
            ],
        };
        let lengths = [
            (
                curve(&|m| m.mean_diagonal.map(|l| l * step)),
                VERMILION,
                "L",
            ),
            (curve(&|m| m.trapping_time.map(|l| l * step)), GREEN, "TT"),
            (
                curve(&|m| m.recurrence_time_2.map(|l| l * step)),
                PURPLE,
                "T²",
            ),
        ];
        let longest = extent(lengths.iter().flat_map(|(c, ..)| c).map(|p| p[1]))[1];
        let unit = Unit::of("s", longest);
        let lengths: Vec<Mark> = lengths
            .into_iter()
            .map(|(points, color, label)| {
                let points = points
                    .into_iter()
                    .map(|[t, s]| [t, s * unit.per_own])
                    .collect();
                line(points, color, label)
            })
            .collect();
        let lengths = Panel {
            title: "mean lengths of lines and gaps".to_owned(),
            x: x(),
            y: Axis::linear(unit.after("duration"), [0.0, 1.08 * longest * unit.per_own]),
            marks: lengths,
        };
        let entropy = curve(&|m| m.entropy);
        let most = extent(entropy.iter().map(|p| p[1]))[1];
        let entropy = Panel {
            title: "entropy of the diagonal lines".to_owned(),
            x: x(),
            y: Axis::linear("nats", [0.0, 1.1 * most]),
            marks: vec![line(entropy, BLUE, "")],
        };
        Figure::new(
            "measures",
            &self.title("Recurrence quantification along time"),
            [900, 760],
            &[vec![shares], vec![lengths], vec![entropy]],
        )
    }

    fn section(&self) -> Result<Figure, FigureError> {
        let scaled = |c: usize| {
            let points = self.report.section.iter();
            points.map(move |p| p.point.get(c).copied().unwrap_or(f64::NAN) * self.unit.per_own)
        };
        let (first, third): (Vec<f64>, Vec<f64>) = (scaled(0).collect(), scaled(2).collect());
        let points: Vec<[f64; 2]> = first.iter().zip(&third).map(|(&a, &b)| [a, b]).collect();
        let map = return_map(&first);
        let count = points.len();
        let radius = if count > 1000 { 1.0 } else { 2.0 };
        let map_mark = dots(map, radius, BLUE, "");
        let panel =
            |title: String, [x, y]: [&str; 2], x_values: &[f64], y_values: &[f64], mark| Panel {
                title,
                x: Axis::around(self.unit.after(x), x_values.iter().copied()),
                y: Axis::around(self.unit.after(y), y_values.iter().copied()),
                marks: vec![mark],
            };
        let section = panel(
            format!("{count} passages"),
            ["y(t)", "y(t + 2τ)"],
            &first,
            &third,
            dots(points, radius, BLUE, ""),
        );
        let map = panel(
            "return map".to_owned(),
            ["y(t) at a passage", "y(t) at the next"],
            &first,
            &first,
            map_mark,
        );
        Figure::new(
            "section",
            &self.title("Poincaré section y(t + τ) = mean"),
            [1000, 500],
            &[vec![section, map]],
        )
    }

    fn divergence(&self) -> Result<Figure, FigureError> {
        let panel = |title: &str, divergence: &Divergence| {
            let ms = 1e3 / self.report.signal.rate;
            let curve: Vec<[f64; 2]> = divergence
                .curve
                .iter()
                .enumerate()
                .map(|(k, &v)| [k as f64 * ms, v])
                .collect();
            let mut marks = vec![line(curve.clone(), BLUE, "")];
            let verdict = match &divergence.region {
                Some(region) => {
                    let rate = self.report.signal.rate;
                    let at = |k: usize| [k as f64 * ms, region.intercept + region.slope * k as f64];
                    let (slope, error) = (region.slope * rate, region.error * rate);
                    let ends = vec![at(region.from), at(region.to)];
                    marks.push(line(ends, VERMILION, "the straight part"));
                    // Two digits of the error, and as many places of the value.
                    let places = (1.0 - error.abs().max(1e-300).log10().floor()).clamp(0.0, 9.0);
                    let places = places as usize;
                    format!("{title}: {slope:.places$} ± {error:.places$} 1/s")
                }
                None => format!("{title}: no straight part"),
            };
            Panel {
                title: verdict,
                x: Axis::linear("time, ms", extent(curve.iter().map(|p| p[0]))),
                y: Axis::around("mean ln(distance)", curve.iter().map(|p| p[1])),
                marks,
            }
        };
        Figure::new(
            "divergence",
            &self.title("How neighbours part"),
            [1000, 440],
            &[vec![
                panel("Rosenstein", &self.report.rosenstein),
                panel("Kantz", &self.report.kantz),
            ]],
        )
    }

    fn zero_one(&self) -> Result<Figure, FigureError> {
        let test = &self.report.zero_one;
        let k = Panel {
            title: format!("K = {:.3}: 0 regular, 1 chaotic", test.k),
            x: Axis::linear(
                "frequency c, rad",
                extent(test.by_frequency.iter().map(|p| p[0])),
            ),
            y: Axis::linear("K", [-1.05, 1.05]),
            marks: vec![dots(test.by_frequency.clone(), 2.5, BLUE, "")],
        };
        let path = Panel {
            title: "path at the median: bounded or a random walk?".to_owned(),
            x: Axis::around("p", test.path.iter().map(|p| p[0])),
            y: Axis::around("q", test.path.iter().map(|p| p[1])),
            marks: vec![line(test.path.clone(), BLUE, "")],
        };
        Figure::new(
            "zero_one",
            &self.title("0–1 test for chaos"),
            [1000, 460],
            &[vec![k, path]],
        )
    }

    fn regime(&self) -> Result<Figure, FigureError> {
        let verdict = &self.report.verdict;
        let bars: Vec<Bar> = verdict
            .evidence
            .iter()
            .map(|piece| Bar {
                value: piece.weight,
                words: format!("{} → {}: {}", piece.what, piece.kinds(), piece.words),
                color: if piece.says.contains(&verdict.regime) {
                    BLUE
                } else {
                    FAINT
                },
            })
            .collect();
        let rows = bars.len().max(1);
        let panel = Panel {
            title: format!(
                "{}, confidence {:.0} %",
                verdict.regime,
                100.0 * verdict.confidence
            ),
            x: Axis::linear("weight of the evidence", [0.0, 1.0]),
            y: Axis::linear("", [0.0, rows as f64]),
            marks: vec![Mark::Bars { bars }],
        };
        let height = 130 + 44 * rows as u32;
        Figure::new(
            "regime",
            &self.title("Kind of motion"),
            [1000, height],
            &[vec![panel]],
        )
    }
}

fn line(points: Vec<[f64; 2]>, color: Rgb, label: &str) -> Mark {
    Mark::Line {
        points,
        color,
        label: label.to_owned(),
    }
}

fn dots(points: Vec<[f64; 2]>, radius: f64, color: Rgb, label: &str) -> Mark {
    Mark::Dots {
        points,
        radius,
        color,
        label: label.to_owned(),
    }
}

fn words(at: [f64; 2], words: &str) -> Mark {
    Mark::Words {
        at,
        words: words.to_owned(),
    }
}

/// A curve as it looks: with more samples than can be told apart, the smallest and the largest of
/// each stretch.
fn envelope(values: &[f64], at: impl Fn(usize) -> f64) -> Vec<[f64; 2]> {
    if values.len() <= MOST_POINTS {
        return values
            .iter()
            .enumerate()
            .map(|(k, &v)| [at(k), v])
            .collect();
    }
    let stretch = values.len().div_ceil(MOST_POINTS / 2);
    let pair = |(n, part): (usize, &[f64])| {
        let [low, high] = extent(part.iter().copied());
        let x = at(n * stretch + part.len() / 2);
        [[x, low], [x, high]]
    };
    values.chunks(stretch).enumerate().flat_map(pair).collect()
}

/// The base frequencies in words.
fn bases(bases: &crate::analysis::Bases) -> String {
    use crate::analysis::Bases;
    let hertz = |f: f64| {
        if f >= 1000.0 {
            format!("{:.4} kHz", 1e-3 * f)
        } else {
            format!("{f:.3} Hz")
        }
    };
    match bases {
        Bases::None => "no simple pattern of lines".to_owned(),
        Bases::One { f1 } => format!("f1 = {}", hertz(*f1)),
        Bases::Two { f1, f2 } => format!("f1 = {}, f2 = {}", hertz(*f1), hertz(*f2)),
    }
}

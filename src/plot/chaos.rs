//! Choice of a delay embedding, as in Fig. 8 of the paper, and evidence of chaos in a signal: divergence of nearby
//! states, 0-1 test, exponents over time.

use super::{Axis, Color, Layer, Panel, Unit, axis::extent, round_up};
use crate::analysis::chaos::{Divergence, ScalingRegion, ZeroOne};
use crate::analysis::delay::{DelayChoice, LagReason};
use crate::number::{short, with_error};

/// Mean logarithmic distance of nearby states over time, with its linear part. Times are in s, distances in `unit`.
pub fn divergence(divergence: &Divergence, unit: &Unit) -> Panel {
    let shift = unit.factor.ln();
    let last = divergence.step * divergence.curve.len().saturating_sub(1).max(1) as f64;
    let values = divergence.curve.iter().map(|value| value + shift);
    let [low, high] = extent(values.clone());
    let points = values.enumerate();
    let points = points.map(|(k, value)| [divergence.step * k as f64, value]);
    let region = divergence.region.as_ref();
    // Without a region the line is empty, so that a recording clears the last one.
    let line = region.map_or_else(Vec::new, |region| {
        let at = |t: f64| [t, region.intercept + region.slope * t + shift];
        vec![at(region.from), at(region.to)]
    });
    let line = Layer::line(line, Color::Accent).with_size(2.2);
    let curve = Layer::line(points.collect(), Color::Ink);
    let layers = vec![curve, line.with_id("fit")];
    let distance = match &*unit.symbol {
        "" => "mean ln(distance)".to_owned(),
        symbol => format!("mean ln(distance / {symbol})"),
    };
    let verdict = match region {
        Some(ScalingRegion { slope, error, .. }) => {
            let exponent = with_error(*slope, *error);
            format!("largest exponent λ = {exponent} per s (± std. error)")
        }
        None => "no scaling region: no chaos, or too weak for this length".to_owned(),
    };
    let x = Axis::linear("time", [0.0, last]).of("s");
    let y = Axis::linear(distance, [low.floor(), high.ceil()]);
    let panel = Panel::new("divergence of nearby states", x, y, layers);
    if divergence.curve.is_empty() {
        return panel.with_note("too few distinct neighbours");
    }
    panel.with_caption(verdict)
}

/// The first `most` points of the path of the 0-1 test about its centre, in `unit`: bounded for a regular motion, a random
/// walk for chaos.
pub fn zero_one_path(test: &ZeroOne, unit: &str, most: usize) -> Panel {
    let path = &test.path[..test.path.len().min(most)];
    let spans = [0, 1].map(|c| extent(path.iter().map(|point| point[c])));
    let middle = spans.map(|[low, high]| 0.5 * (low + high));
    let half = spans.iter().map(|[low, high]| 0.5 * (high - low));
    let half = half.fold(1e-12, f64::max);
    let full = round_up(half);
    let axis = |name| Axis::linear(name, [-full, full]).of(unit);
    let points = path.iter().map(|[p, q]| [p - middle[0], q - middle[1]]);
    let path = Layer::line(points.collect(), Color::Ink).with_size(0.7);
    let meaning = match test.k {
        ..0.4 => "regular or weak chaos",
        0.6.. => "chaos or noise",
        _ => "undecided",
    };
    // Without the sign of a zero.
    let hundredths = (100.0 * test.k).round() / 100.0 + 0.0;
    let (x, y) = (axis("p − centre"), axis("q − centre"));
    Panel::new("path of the 0-1 test", x, y, vec![path.with_id("path")])
        .with_caption(format!("K = {}: {meaning}", short(hundredths)))
}

/// The largest exponents of windows (end in s, and the value between the ends of its interval in 1/s) over a span (s).
pub fn largest_exponents(exponents: &[[f64; 4]], span: [f64; 2]) -> Panel {
    let intervals = exponents.iter().map(|[t, low, _, high]| [*t, *low, *high]);
    let values = exponents.iter().map(|[t, _, value, _]| [*t, *value]);
    let layers = vec![
        Layer::intervals(intervals, Color::Faint),
        Layer::points(values.collect(), 2.5, Color::Ink).with_id("values"),
    ];
    let ends = exponents.iter().flat_map(|[_, low, _, high]| [*low, *high]);
    let x = Axis::linear("time", span).of("s");
    let y = Axis::with_margin("λ, 1/s", ends.chain([0.0]));
    let missing = "no exponent so far: no window has a scaling region";
    let note = exponents.is_empty().then_some(missing);
    Panel::new("largest exponent of each window", x, y, layers).with_note(note.unwrap_or_default())
}

/// The choice of a delay embedding of samples `dt` (s) apart, with its reasons: average mutual information over the delay,
/// and share of false nearest neighbours over the dimension, each with the chosen value.
pub fn embedding(dt: f64, choice: &DelayChoice) -> [Panel; 2] {
    let bits = &choice.mutual.bits;
    let curve = bits.iter().enumerate();
    let curve = curve.map(|(k, bits)| [dt * k as f64, *bits]).collect();
    let largest = dt * bits.len().saturating_sub(1).max(1) as f64;
    let [_, most] = extent(bits.iter().copied());
    let x = Axis::linear("delay", [0.0, largest]).of("s");
    let range = [0.0, round_up(most.max(1e-3))];
    let y = Axis::linear("average mutual information, bits", range);
    let (samples, delay) = (choice.lag, dt * choice.lag as f64);
    let why = match choice.reason {
        LagReason::FirstMinimum => "first minimum",
        LagReason::FirstDecay => "first value below 1/e of the initial one; no minimum",
        LagReason::Largest => "largest delay tried; no minimum, no decay below 1/e",
    };
    let (shown, unit) = (short(x.unit.factor * delay), &x.unit.symbol);
    let caption = format!("τ = {shown} {unit} ({samples} samples): {why}");
    let chosen = Layer::vertical_lines([delay], Color::Accent);
    let layers = vec![Layer::line(curve, Color::Ink), chosen];
    let mutual = Panel::new("average mutual information", x, y, layers).with_caption(caption);
    let shares = choice.neighbours.share.iter().zip(1..);
    let shares = shares.map(|(share, m)| [f64::from(m), 100.0 * share]);
    let shares: Vec<[f64; 2]> = shares.collect();
    let (m, unfolded) = (choice.dimension, choice.unfolded);
    let share = shares.get(m.wrapping_sub(1));
    let share = short(share.map_or(0.0, |[_, share]| *share));
    let lowest = if unfolded { "" } else { ", the lowest share" };
    let theiler = Unit::write(dt * choice.theiler as f64, "s");
    let caption = format!("m = {m}: {share} % false{lowest}; Theiler window {theiler}");
    let x = Axis::integers("embedding dimension m", shares.len());
    let y = Axis::linear("false nearest neighbours, %", [-3.0, 105.0]);
    let layers = vec![
        Layer::line(shares.clone(), Color::Ink),
        Layer::points(shares, 2.4, Color::Ink),
        Layer::vertical_lines([m as f64], Color::Accent),
    ];
    let neighbours = Panel::new("false nearest neighbours", x, y, layers).with_caption(caption);
    [mutual, neighbours]
}

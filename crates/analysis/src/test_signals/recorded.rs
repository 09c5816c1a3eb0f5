//! Synthetic recordings: squeaks, tones, speech, music and noises at all sampling rates, with a background.

use std::f64::consts::{PI, TAU};

use rand::RngExt;

use super::systems;
use super::textbook::{CHAOS, Draw, ROESSLER, Textbook, autoregressive, coloured, family, judged};
use super::{noise, roessler};
use squeakscope_analysis::filter::band_pass;
use squeakscope_analysis::regime::Regime::{
    Chaotic, Noise, Periodic, QuasiPeriodic, Transient, Undetermined,
};
use squeakscope_analysis::stats::deviation;

/// Families of recordings.
pub const RECORDED: &[Textbook] = &[
    family("squeak, locked harmonics", &[Periodic], |draw| {
        squeak(draw, true, [0.0, 0.0], 15.0)
    }),
    family("squeak, drifting", &[Periodic], |draw| {
        squeak(draw, true, [0.15, 1e-3], 15.0)
    }),
    family("tone in noise", &[Periodic], |draw| {
        squeak(draw, false, [0.1, 5e-4], 10.0)
    }),
    family("squeak in its band", &[Periodic], |draw| {
        let (n, rate) = (draw.count(), audio_rate(draw).max(8.0));
        let (levels, bend) = (wander(draw, n, 0.3 * n as f64), draw.between(0.0, 5e-4));
        let (wave, size) = (harmonics(draw, rate, false), draw.between(0.0, 0.15));
        let at = |i: usize| {
            let phase = TAU / rate * i as f64 * (1.0 + bend * levels[i]);
            (1.0 + size * levels[i]) * wave(phase)
        };
        let clean = (0..n).map(at).collect();
        let highest = (draw.pick(&[1.5, 3.5, 5.5]) / rate).min(0.45);
        let squeak = recorded(draw, clean, [5.0, 40.0]);
        band_pass(&squeak, 1.0, [0.4 / rate, highest]).samples
    }),
    judged("squeak over road noise", &[Periodic], |draw| {
        let clean = squeak(draw, true, [0.1, 5e-4], 30.0);
        over_road(draw, clean)
    }),
    judged("tone of random level", &[Periodic, Undetermined], |draw| {
        let (n, rate) = (draw.count(), audio_rate(draw));
        let (wave, scale) = (harmonics(draw, rate, false), draw.between(5.0, 60.0) * rate);
        let (level, depth) = (wander(draw, n, scale), draw.between(0.1, 0.3));
        let at = |i: usize| (1.0 + depth * level[i]) * wave(TAU * i as f64 / rate);
        let clean = (0..n).map(at).collect();
        recorded(draw, clean, [15.0, 50.0])
    }),
    family("modulated squeak", &[Periodic, QuasiPeriodic], |draw| {
        let depth = draw.between(0.03, 0.6);
        let bend = draw.pick(&[0.0, 2e-3]) * draw.between(0.0, 1.0);
        slowly_modulated(draw, depth, bend)
    }),
    family("vibrato", &[Periodic, QuasiPeriodic], |draw| {
        let bend = draw.between(1e-3, 1e-2);
        slowly_modulated(draw, 0.0, bend)
    }),
    family("two tones in noise", &[QuasiPeriodic], |draw| {
        let (n, rate) = (draw.count(), draw.between(4.5, 80.0));
        let ratio = draw.irrational().min(0.44 * rate);
        let (size, shift) = (draw.between(0.15, 1.0), draw.phase());
        // A nonlinear function makes combinations, which must stay below half of the rate.
        let bend = draw.pick(&[0.0, 0.3]) * f64::from(u8::from(rate > 20.0));
        let at = |i: usize| {
            let phase = TAU * i as f64 / rate;
            let x = phase.sin() + size * (ratio * phase + shift).sin();
            x + bend * x * x
        };
        let clean = (0..n).map(at).collect();
        recorded(draw, clean, [20.0, 60.0])
    }),
    family("two equal tones", &[QuasiPeriodic], |draw| {
        let (n, rate) = (draw.count(), draw.between(5.0, 80.0));
        let ratio = 1.0 + draw.between(8.0, 80.0) * rate / n as f64;
        let (size, shift) = (draw.between(0.95, 1.05), draw.phase());
        let at = |i: usize| {
            let phase = TAU * i as f64 / rate;
            phase.sin() + size * (ratio * phase + shift).sin()
        };
        let clean = (0..n).map(at).collect();
        recorded(draw, clean, [20.0, 60.0])
    }),
    judged("subharmonic", &[Periodic], |draw| {
        let (n, rate) = (draw.count(), draw.between(5.0, 40.0));
        let wave = harmonics(draw, rate, true);
        let (size, order, shift) = (
            draw.between(0.03, 0.4),
            draw.pick(&[0.5, 1.5]),
            draw.phase(),
        );
        let at = |i: usize| {
            let phase = TAU * i as f64 / rate;
            wave(phase) + size * (order * phase + shift).sin()
        };
        let clean = (0..n).map(at).collect();
        recorded(draw, clean, [20.0, 50.0])
    }),
    family("clipped squeak", &[Periodic], |draw| {
        let squeak = squeak(draw, true, [0.0, 0.0], 25.0);
        let top = squeak.iter().fold(0.0_f64, |top, x| top.max(x.abs())) * draw.between(0.5, 0.9);
        squeak.iter().map(|x| x.clamp(-top, top)).collect()
    }),
    family("run-up", &[Transient, Undetermined], |draw| {
        let (n, rate) = (draw.count(), audio_rate(draw).max(8.0));
        let wave = harmonics(draw, 0.7 * rate, true);
        let (rise, growth) = (draw.between(0.05, 0.4), draw.between(-0.3, 0.3));
        let mut phase = 0.0;
        let at = |i: usize| {
            let part = i as f64 / n as f64;
            phase += TAU / rate * (1.0 + rise * part);
            (1.0 + growth * part) * wave(phase)
        };
        let clean = (0..n).map(at).collect();
        recorded(draw, clean, [15.0, 60.0])
    }),
    family("speech", &[Undetermined, Transient, Noise], speech),
    family("music", &[Undetermined, Transient, QuasiPeriodic], music),
    family("chatter", &[Undetermined, Noise, Transient], |draw| {
        bursts(draw, |draw, gap| gap * draw.between(0.92, 1.08))
    }),
    judged("creak", &[Undetermined, Noise, Transient], |draw| {
        bursts(draw, |draw, gap| {
            1.0 - gap * draw.between(0.0, 1.0).max(1e-9).ln()
        })
    }),
    judged("road noise", &[Noise], |draw| {
        let n = draw.count();
        let clean = road(draw, n);
        recorded(draw, clean, [30.0, 60.0])
    }),
    judged("resonance in noise", &[Noise], |draw| {
        let (radius, angle) = (draw.between(0.98, 0.9985), TAU / audio_rate(draw).max(6.0));
        let clean = coloured(draw, 2.0 * radius * angle.cos(), -radius * radius);
        recorded(draw, clean, [0.0, 20.0])
    }),
    family("weak chaos", &[Chaotic], |draw| {
        let c = draw.between(5.0, 7.0);
        modulated_by_roessler(draw, c)
    }),
    family("chaos on a torus", &[Chaotic], |draw| {
        let c = draw.between(4.6, 7.0);
        torus_with_roessler(draw, c)
    }),
    family("modulated torus", &[QuasiPeriodic], |draw| {
        let c = draw.between(2.2, 3.6);
        torus_with_roessler(draw, c)
    }),
    judged("slow torus", &[QuasiPeriodic], |draw| {
        let c = draw.between(2.2, 2.7);
        modulated_by_roessler(draw, c)
    }),
    family(
        "chaos in a background",
        &[Chaotic, Undetermined, Noise],
        |draw| {
            let flow = |draw: &mut Draw| systems::driven_roessler(draw.between(4.4, 9.0), 0.0, 1.0);
            let clean = draw.attractor(flow, [1.0, 1.0, 0.0, 0.0], ROESSLER, CHAOS);
            recorded(draw, clean, [10.0, 40.0])
        },
    ),
];

/// Samples per period of a fundamental: from harmonics above half of the rate to 400 Hz at 48 kHz.
fn audio_rate(draw: &mut Draw) -> f64 {
    draw.between(3.5_f64.ln(), 120.0_f64.ln()).exp()
}

/// A periodic function of a phase: one to three harmonics, or three to eight; none above 0.45 of the rate.
fn harmonics(draw: &mut Draw, rate: f64, many: bool) -> impl Fn(f64) -> f64 + use<> {
    let power = draw.pick(&[0.7, 1.0, 1.5, 2.0]);
    let count = if many {
        draw.pick(&[3, 4, 5, 6, 7, 8])
    } else {
        draw.pick(&[1, 1, 2, 3])
    };
    let list: Vec<[f64; 3]> = (1..=count)
        .map(f64::from)
        .filter(|k| k / rate < 0.45)
        .map(|k| [k, draw.between(0.5, 1.5) * k.powf(-power), draw.phase()])
        .collect();
    move |phase| {
        let terms = list.iter();
        terms
            .map(|[k, a, shift]| a * (k * phase + shift).sin())
            .sum()
    }
}

/// A smooth random function between -1 and 1 with the given time scale, samples.
fn wander(draw: &mut Draw, n: usize, scale: f64) -> Vec<f64> {
    let count = (n as f64 / scale) as usize + 3;
    let knots: Vec<f64> = (0..count).map(|_| draw.between(-1.0, 1.0)).collect();
    let at = |i: usize| {
        let (knot, part) = ((i as f64 / scale) as usize, (i as f64 / scale).fract());
        let step = part * part * (3.0 - 2.0 * part);
        knots[knot] * (1.0 - step) + knots[knot + 1] * step
    };
    (0..n).map(at).collect()
}

/// Adds noise of a colour at a signal-to-noise ratio in a range (dB). Its power is known in every second recording,
/// within 40 %.
fn recorded(draw: &mut Draw, clean: Vec<f64>, [low, high]: [f64; 2]) -> Vec<f64> {
    let ratio = 10.0_f64.powf(-draw.between(low, high) / 20.0);
    let white = noise(draw.rng.random(), clean.len() + 2000, 1.0);
    let memory = draw.pick(&[0.0, 0.0, 0.6, 0.9, 0.97]);
    let hiss = autoregressive(&white, memory, 0.0);
    let size = ratio * deviation(&clean);
    draw.background = draw.pick(&[0.0, 1.0]) * draw.between(0.7, 1.4) * size * size;
    let scale = size / deviation(&hiss);
    clean.iter().zip(hiss).map(|(x, e)| x + scale * e).collect()
}

/// Noise that falls from two corner frequencies on, and at low frequencies.
fn road(draw: &mut Draw, n: usize) -> Vec<f64> {
    let corners = [draw.between(5.0, 50.0), draw.between(30.0, 300.0)];
    let [a, b] = corners.map(|scale| (-TAU / scale).exp());
    let white = noise(draw.rng.random(), n + 4000, 1.0);
    let rumble = autoregressive(&white, a + b, -a * b);
    let memory = (-1.0 / draw.between(100.0, 1000.0)).exp();
    let slow = autoregressive(&rumble, memory, 0.0);
    let both = rumble.iter().skip(2000).zip(slow);
    both.map(|(x, slow)| x - (1.0 - memory) * slow).collect()
}

/// Adds road noise 10 to 40 dB below a signal. Its power is known in every second recording.
fn over_road(draw: &mut Draw, clean: Vec<f64>) -> Vec<f64> {
    let noise = road(draw, clean.len());
    let size = 10.0_f64.powf(-draw.between(10.0, 40.0) / 20.0) * deviation(&clean);
    draw.background = draw.pick(&[0.0, 1.0]) * draw.between(0.7, 1.4) * size * size;
    let scale = size / deviation(&noise);
    clean
        .iter()
        .zip(noise)
        .map(|(x, e)| x + scale * e)
        .collect()
}

/// A tone with harmonics whose level and frequency wander by at most the given shares, in a background at least
/// `quietest` (dB) below it.
fn squeak(draw: &mut Draw, many: bool, [level, bend]: [f64; 2], quietest: f64) -> Vec<f64> {
    let (n, rate) = (draw.count(), audio_rate(draw));
    let wave = harmonics(draw, rate, many);
    let [levels, bends] = [level, bend].map(|most| {
        let (scale, size) = (draw.between(0.1, 1.0) * n as f64, draw.between(0.0, most));
        wander(draw, n, scale).into_iter().map(move |x| size * x)
    });
    let mut phase = 0.0;
    let at = |(level, bend): (f64, f64)| {
        phase += TAU / rate * (1.0 + bend);
        (1.0 + level) * wave(phase)
    };
    let clean = levels.zip(bends).map(at).collect();
    let loudest = if many { 60.0 } else { 40.0 };
    recorded(draw, clean, [quietest, loudest])
}

/// A tone with sinusoidal modulation of level and frequency, slower than a fiftieth of its frequency.
fn slowly_modulated(draw: &mut Draw, depth: f64, bend: f64) -> Vec<f64> {
    let n = draw.count();
    let rate = audio_rate(draw).min(n as f64 / 300.0);
    let (wave, slow, shift) = (
        harmonics(draw, rate, true),
        draw.between(3.0 / n as f64, 0.02 / rate),
        draw.phase(),
    );
    let mut phase = 0.0;
    let at = |i: usize| {
        let s = (TAU * slow * i as f64 + shift).sin();
        phase += TAU / rate * (1.0 + bend * s);
        (1.0 + depth * s) * wave(phase)
    };
    let clean = (0..n).map(at).collect();
    recorded(draw, clean, [15.0, 60.0])
}

/// A tone and its octave with levels that follow a Roessler system, 6 to 20 periods of the tone per cycle.
fn modulated_by_roessler(draw: &mut Draw, c: f64) -> Vec<f64> {
    let (n, rate) = (
        (draw.between(1.5, 4.0) * draw.count() as f64) as usize,
        draw.rate(),
    );
    let (cycle, depth) = (draw.between(6.0, 20.0), draw.between(0.04, 0.1));
    let start = [1.0 + draw.between(-0.3, 0.3), 1.0, 0.0];
    let slow = roessler(n, ROESSLER / (cycle * rate), [0.2, 0.2, c], start);
    let at = |(i, [x, y, _]): (usize, &[f64; 3])| {
        let phase = TAU * i as f64 / rate;
        (1.0 + depth * x) * phase.sin() + (0.3 + 0.5 * depth * y) * (2.0 * phase).sin()
    };
    let signal = slow.iter().enumerate().map(at).collect();
    draw.with_floor(signal)
}

/// Two tones near to each other, the second with level and phase that follow a Roessler system, 10 to 40 periods per
/// cycle.
fn torus_with_roessler(draw: &mut Draw, c: f64) -> Vec<f64> {
    let (n, rate) = (
        (draw.between(0.8, 2.5) * draw.count() as f64) as usize,
        draw.rate(),
    );
    let (ratio, size) = (
        1.0 + draw.between(0.03, 0.2) * draw.pick(&[-1.0, 1.0]),
        draw.between(0.1, 0.5),
    );
    let (cycle, depth, bend) = (
        draw.between(10.0, 40.0),
        draw.between(0.03, 0.12),
        draw.between(0.0, 0.1),
    );
    let (overtone, start) = (
        draw.between(0.0, 0.3),
        [1.0 + draw.between(-0.3, 0.3), 1.0, 0.0],
    );
    let slow = roessler(n, ROESSLER / (cycle * rate), [0.2, 0.2, c], start);
    let at = |(i, [x, y, _]): (usize, &[f64; 3])| {
        let phase = TAU * i as f64 / rate;
        let second = size * (1.0 + depth * x) * (ratio * phase + bend * y).sin();
        (1.0 + 0.2 * depth * y) * phase.sin() + second + overtone * (3.0 * phase).sin()
    };
    let signal = slow.iter().enumerate().map(at).collect();
    draw.with_floor(signal)
}

/// Pulses of a wandering pitch through two wandering resonances, with syllables.
fn speech(draw: &mut Draw) -> Vec<f64> {
    let (n, rate) = (draw.count(), draw.pick(&[8000.0, 16_000.0, 22_050.0]));
    let pitch = draw.between(90.0, 260.0);
    let curves = [0.08, 0.06, 0.1, 0.1].map(|scale| wander(draw, n, scale * rate));
    let breath = noise(draw.rng.random(), n, 0.05);
    let (mut phase, mut states) = (0.0, [[0.0; 2]; 2]);
    let radius = (-PI * 90.0 / rate).exp();
    let at = |i: usize| {
        phase += pitch / rate * (1.0 + 0.12 * curves[0][i]);
        let pulse = if phase >= 1.0 { 3.0 } else { 0.0 };
        phase = phase.fract();
        let formants = [550.0 + 250.0 * curves[2][i], 1600.0 + 600.0 * curves[3][i]];
        let mut sum = 0.0;
        for ((past, formant), gain) in states.iter_mut().zip(formants).zip([1.0, 0.6]) {
            let turn = 2.0 * radius * (TAU * formant / rate).cos();
            let next = turn * past[0] - radius * radius * past[1] + pulse + breath[i];
            *past = [next, past[0]];
            sum += gain * next;
        }
        0.5 * (1.0 + curves[1][i]) * sum
    };
    let clean = (0..n).map(at).collect();
    recorded(draw, clean, [25.0, 50.0])
}

/// One to three voices of struck notes.
fn music(draw: &mut Draw) -> Vec<f64> {
    let (n, rate) = (draw.count(), draw.pick(&[8000.0, 16_000.0]));
    let length = draw.between(0.1, 0.4) * rate;
    let mut clean = vec![0.0; n];
    for _ in 0..draw.pick(&[1, 2, 3]) {
        let mut first = 0;
        while first < n {
            let pitch = 220.0 * 2.0_f64.powf(draw.between(0.0, 24.0).floor() / 12.0);
            let wave = harmonics(draw, rate / pitch, true);
            let decay = draw.between(0.05, 0.4) * rate;
            let end = (first + (length * draw.between(0.7, 1.3)) as usize).min(n);
            for (i, x) in clean[first..end].iter_mut().enumerate() {
                let i = i as f64;
                *x += (-i / decay).exp() * wave(TAU * pitch / rate * i);
            }
            first = end;
        }
    }
    recorded(draw, clean, [25.0, 50.0])
}

/// Decaying bursts of two tones, `next` samples apart.
fn bursts(draw: &mut Draw, next: fn(&mut Draw, f64) -> f64) -> Vec<f64> {
    let (n, gap) = (draw.count(), draw.between(100.0, 900.0));
    let (first, second, decay) = (
        TAU * draw.between(0.02, 0.3),
        TAU * draw.between(0.02, 0.4),
        draw.between(10.0, 200.0),
    );
    let (mut clean, mut start) = (vec![0.0; n], 0.0);
    while (start as usize) < n {
        let size = draw.between(0.4, 1.6);
        for (i, x) in clean[start as usize..].iter_mut().enumerate() {
            let t = i as f64;
            *x += size * (-t / decay).exp() * ((first * t).sin() + 0.5 * (second * t).sin());
        }
        start += next(draw, gap);
    }
    recorded(draw, clean, [15.0, 40.0])
}

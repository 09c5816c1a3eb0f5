//! The words of each lesson, and which numbers it tells.

use std::f64::consts::LN_2;

use super::measured::Measured;
use super::page::Page;
use super::tilts::{Change, Tilts};
use crate::dynamics::Attractor;
use crate::pipeline::message::{Computed, ComputedMode, FrictionReading, PartingLine, Way};
use crate::pipeline::stages::words::{percent, quantity, rounded, with_error};
use crate::scene::Mechanism;

/// Share by which a heard frequency may miss a computed mode and still be called by its name: a large
/// vibration is a little out of tune.
const NEAR: f64 = 0.05;

/// Level over the sliding speed below which nothing is heard.
const SILENT: f64 = 1e-3;

/// How many changes of tone are told, a way.
const CHANGES: usize = 3;

/// How many sums and differences of two tones are told.
const COMBINATIONS: usize = 3;

/// The lesson as far as the run has come.
pub fn page(computed: &Computed, measured: &Measured) -> Page {
    let mut page = of_mechanism(computed, measured);
    if !page.computed.is_empty()
        && let (Some(then), Some(now)) = (computed.tilt, measured.tilt)
        && degrees(then) != degrees(now)
    {
        let moved = format!(
            "The load is tilted to **{}** now; what was computed holds for {}.",
            degrees(now),
            degrees(then)
        );
        page.says = Some(match page.says {
            Some(says) => format!("{moved} {says}"),
            None => moved,
        });
    }
    page
}

fn of_mechanism(computed: &Computed, measured: &Measured) -> Page {
    match computed.mechanism {
        Mechanism::NegativeSlope => negative_slope(computed, measured),
        Mechanism::ModeCoupling => mode_coupling(computed, measured),
        Mechanism::StickSlip => stick_slip(computed, measured),
        Mechanism::LiftOff => lift_off(computed, measured),
        Mechanism::ExchangedFriction => exchanged_friction(computed, measured),
        Mechanism::WhichModeWins => which_mode_wins(computed, measured),
        Mechanism::Hysteresis => hysteresis(measured),
        Mechanism::Torus => torus(measured),
        Mechanism::Chaos => chaos(measured),
        Mechanism::Prediction => prediction(computed, measured),
    }
}

fn new(title: &'static str, explains: &'static str, look: &'static str) -> Page {
    Page {
        title,
        explains,
        look,
        computed: Vec::new(),
        measured: Vec::new(),
        says: None,
    }
}

fn negative_slope(computed: &Computed, measured: &Measured) -> Page {
    let mut page = new(
        "Negative slope: friction that feeds a vibration",
        "The faster the belt slides past the mass, the weaker it drags. While the mass swings along with \
         the belt, it is dragged more than it loses while swinging against it: each swing gains a little. \
         Friction that falls with speed acts like a damper turned round. It grows until the mass is as \
         fast as the belt, and sticks.",
        "*How loud it is*: a straight line on its logarithmic scale is exponential growth, and its slope \
         the growth rate. In the phase portrait the spiral winds outwards.",
    );
    for mode in &computed.modes {
        page.compute("growth rate", per_second(mode.growth));
        page.compute("frequency", quantity(mode.frequency_hz, "Hz"));
    }
    growth(&mut page, measured);
    tone(&mut page, computed, measured);
    page.measure(
        "time that it sticks, of the last 25 ms",
        measured.statuses.as_ref().map(|s| percent(s.held())),
    );
    page.says = agreement(computed, measured);
    page
}

fn mode_coupling(computed: &Computed, measured: &Measured) -> Page {
    let mut page = new(
        "Mode coupling: two modes flutter together",
        "Friction is constant here: no falling curve feeds anything. But friction follows the normal \
         force: what one mode presses into the belt, friction turns into a push along it, which moves the \
         other mode. Above a critical coefficient the two frequencies become one, the two modes move with \
         a lag, and each round trip gains energy.",
        "the computed curves: two frequencies meet, and from there on the growth rate rises. *How loud it \
         is* must then rise as a straight line, until the contact lifts off.",
    );
    if let Some(coupling) = &computed.coupling {
        page.compute(
            "coefficient of friction µ of this run",
            rounded_plain(coupling.mu),
        );
        let critical = match coupling.critical {
            Some(critical) => rounded_plain(critical),
            None => "none: no friction couples them".to_owned(),
        };
        page.compute("critical coefficient µ_c, from its matrices", critical);
    }
    if let Some(fastest) = computed.fastest() {
        page.compute("growth rate", per_second(fastest));
    }
    let frequencies: Vec<String> = computed
        .modes
        .iter()
        .map(|mode| quantity(mode.frequency_hz, "Hz"))
        .collect();
    page.compute("frequencies of the two modes", frequencies.join(", "));
    growth(&mut page, measured);
    tone(&mut page, computed, measured);
    page.measure(
        "time that it is lifted off, of the last 25 ms",
        measured.statuses.as_ref().map(|s| percent(1.0 - s.held())),
    );
    page.says = agreement(computed, measured);
    page
}

fn stick_slip(computed: &Computed, measured: &Measured) -> Page {
    let mut page = new(
        "Stick-slip: held, torn off, held again",
        "Slow sliding lets friction hold. What sticks is carried along and winds up its spring, until this \
         pulls harder than friction holds; then it slips back, faster than it was carried, and sticks \
         again. Bowed strings, chalk and door hinges do this.",
        "the flat edge of the phase portrait: there the velocity is that of what drags it. What sticks is \
         drawn in orange.",
    );
    let natural = quantity(computed.natural_hz, "Hz");
    page.compute("lowest natural frequency", &natural);
    tone(&mut page, computed, measured);
    if let Some(nodes) = &measured.nodes {
        let [mean, most] = nodes.stuck();
        page.measure(
            "nodes that stick, on average over the last 25 ms",
            Some(percent(mean)),
        );
        page.measure("nodes that stick, at most", Some(percent(most)));
        page.measure(
            "time in which half of them or more stick",
            Some(percent(nodes.half_stuck())),
        );
    } else if let Some(statuses) = &measured.statuses {
        page.measure(
            "time that it sticks, of the last 25 ms",
            Some(percent(statuses.held())),
        );
        let times = 0.5 * measured.rate(statuses.changes, statuses.samples);
        page.measure("it is torn off so often", Some(per_second(times)));
    } else {
        page.measure("time that it sticks", None);
    }
    let sticking = match (&measured.nodes, &measured.statuses) {
        (Some(nodes), _) => Some(("Half of the nodes or more stick", nodes.half_stuck())),
        (None, Some(statuses)) => Some(("It sticks", statuses.held())),
        (None, None) => None,
    };
    page.says = sticking.map(|(who, share)| {
        if share == 0.0 {
            return "Nothing sticks at present: it only slides.".to_owned();
        }
        let low = measured.tone().filter(|tone| *tone < 0.95 * computed.natural_hz);
        let low = low.map_or_else(String::new, |tone| {
            format!(
                " The time of sticking is added to each swing: the pitch, {}, lies below the natural \
                 frequency, {natural}.",
                quantity(tone, "Hz")
            )
        });
        format!("{who} for **{}** of the time.{low}", percent(share))
    });
    page
}

fn lift_off(computed: &Computed, measured: &Measured) -> Page {
    let mut page = new(
        "Lift-off: the contact opens and hammers",
        "A contact can push, but not pull. Where the vibration is larger than the elastic indentation, \
         nodes leave the socket, fly and strike again. While a node is open neither pressure nor friction \
         acts on it, so that the force on the ball is cut off: a vibration that would grow for ever finds \
         a limit, and its spectrum gets harmonics.",
        "the contact patch: white nodes have lifted off. In *Forces* the normal force has flat zeros where \
         the whole contact is open, and peaks where it strikes.",
    );
    tone(&mut page, computed, measured);
    let nodes = measured.nodes.as_ref();
    let open = nodes.map(|nodes| nodes.open());
    page.measure(
        "nodes that are open, on average over the last 25 ms",
        open.map(|[mean, _]| percent(mean)),
    );
    page.measure(
        "nodes that are open, at most",
        open.map(|[_, most]| percent(most)),
    );
    page.measure(
        "time in which the whole contact is open",
        nodes.map(|n| percent(n.all_open())),
    );
    page.measure(
        "each node lifts off so often",
        nodes.map(|n| per_second(n.lift_offs())),
    );
    page.says = nodes.map(|nodes| match (nodes.open()[1], nodes.all_open()) {
        (0.0, _) => "No node is open at present: the vibration is too small yet.".to_owned(),
        (most, 0.0) => format!(
            "Part of the patch hammers, up to **{}** of its nodes; the rest stays closed.",
            percent(most)
        ),
        (_, all) => format!(
            "The ball leaves the socket altogether, for **{}** of the time, and strikes again: hammering.",
            percent(all)
        ),
    });
    page
}

fn exchanged_friction(computed: &Computed, measured: &Measured) -> Page {
    let mut page = new(
        "One friction curve, read in two ways",
        "The paper prints the two slope factors of its friction curve as d = 10 and f = 1000 s/m. So read, \
         friction still rises at the sliding speed, which damps. Exchanged, it has risen long before and \
         falls at that speed, which feeds. The same joint, load and kick: one is silent, one squeals.",
        "the computed friction curves: at the dots one rises, one falls. *How loud it is* shows what that \
         comes to.",
    );
    for (name, reading) in ["this run", "the other way"]
        .into_iter()
        .zip(computed.readings.iter().flatten())
    {
        reading_rows(&mut page, name, reading);
    }
    growth(&mut page, measured);
    level(&mut page, computed, measured);
    tone(&mut page, computed, measured);
    let grew = measured.envelope.growth().map(|fit| fit.slope);
    page.says = grew.map(|grew| {
        let other = computed
            .readings
            .as_ref()
            .map(|[_, other]| other.unstable().len());
        let other = match other {
            Some(0) => "With the two exchanged no mode would grow, by computation: silence.",
            Some(_) => "With the two exchanged modes would grow, by computation: a squeal.",
            None => "",
        };
        let own = match (measured.envelope.ended.is_some(), grew > 0.0) {
            (true, _) => "The kick has grown into a **squeal**.",
            (false, true) => "The kick **grows**.",
            (false, false) => "The kick does **not grow**: the joint stays silent.",
        };
        format!("{own} {other}")
    });
    page
}

fn reading_rows(page: &mut Page, name: &str, reading: &FrictionReading) {
    let FrictionReading {
        creep,
        stribeck,
        mu,
        slope,
        ..
    } = reading;
    page.compute(format!("{name}: d, f"), format!("{creep}, {stribeck} s/m"));
    page.compute(
        format!("{name}: µ as it slides, its slope"),
        format!("{mu:.3}, {slope:+.2} s/m"),
    );
    let fastest = reading
        .unstable()
        .first()
        .map(|mode| per_second(mode.growth));
    let grow = match fastest {
        Some(rate) => format!("{}, up to {rate}", reading.unstable().len()),
        None => "none".to_owned(),
    };
    page.compute(format!("{name}: modes that grow"), grow);
}

fn which_mode_wins(computed: &Computed, measured: &Measured) -> Page {
    let mut page = new(
        "Which mode wins: the kick decides",
        "Several modes are unstable at once, and each could sing. While the vibration is small they grow \
         side by side; when it is large they fight for the same sliding, and one or two starve the \
         others. Which, depends on how strongly each was kicked: several tones are possible, and the run \
         keeps the one that it has come to.",
        "*Energy of each mode*: all rise, then most fall back. In the spectrum, grey lines are the computed \
         frequencies of the modes that grow.",
    );
    for mode in computed.unstable() {
        page.compute(&mode.label, mode_words(mode));
    }
    let start = &computed.start;
    page.compute(
        "kick of this run",
        format!("{} √kg, seed {}", quantity(start.kick, "m/s"), start.seed),
    );
    leaders(&mut page, measured);
    tone(&mut page, computed, measured);
    page.says = measured.tone().map(|tone| {
        let winner = match near(computed, tone) {
            Some(mode) => format!("**{}** has won", mode.label),
            None => format!("The winner, at **{}**, is no mode by itself", quantity(tone, "Hz")),
        };
        format!(
            "{winner} in this run. Another `seed` in `[start]` can give another one; `squeakscope basins` \
             counts which seeds lead where."
        )
    });
    page
}

fn prediction(computed: &Computed, measured: &Measured) -> Page {
    let mut page = new(
        "Linear prediction, and what is heard",
        "Complex eigenvalues tell which modes a tiny disturbance makes grow, and how fast. They are right \
         as long as it is tiny. What is heard is what is left when it is large: the mode that grew fastest \
         need not be the one that lasts. This is the paper's point: a stability analysis alone does not \
         tell the squeak.",
        "the spectrum: grey lines are the computed frequencies of the modes that grow, the blue curve is \
         what is heard. *Energy of each mode* shows who leads when.",
    );
    for mode in computed.unstable() {
        page.compute(&mode.label, mode_words(mode));
    }
    growth(&mut page, measured);
    leaders(&mut page, measured);
    tone(&mut page, computed, measured);
    page.says = computed.unstable().first().zip(measured.tone()).map(|(bet, tone)| {
        let heard = quantity(tone, "Hz");
        let foretold = quantity(bet.frequency_hz, "Hz");
        match near(computed, tone) {
            Some(mode) if mode.label == bet.label => format!(
                "Heard is **{heard}**, the mode that was computed to grow fastest ({foretold}): they agree here."
            ),
            Some(mode) => format!(
                "Computed to grow fastest is the {} at {foretold}; heard is the **{}** at **{heard}**: they \
                 disagree.",
                bet.label, mode.label
            ),
            None => format!(
                "Computed to grow fastest is the {} at {foretold}; heard is **{heard}**, which is none of the \
                 modes: they disagree.",
                bet.label
            ),
        }
    });
    page
}

fn hysteresis(measured: &Measured) -> Page {
    let mut page = new(
        "Hysteresis: the way back is another one",
        "Two motions can be stable at the same tilt. The joint keeps the one it is in until that one ceases \
         to be possible, and only then jumps. Tilted up it jumps at one angle, tilted back at a smaller one, \
         or not at all: at the same tilt it sounds otherwise, depending on where it comes from.",
        "the loop: pitch over tilt, blue on the way up, orange on the way down. Where the two lie apart, \
         the joint remembers.",
    );
    let Some(tilts) = &measured.tilts else {
        return page;
    };
    let now = tilts.heard.last();
    page.measure("tilt now", now.map(|heard| degrees(heard.tilt)));
    page.measure(
        "heard now",
        measured.tone().map(|tone| quantity(tone, "Hz")),
    );
    for (way, name, there) in [
        (
            Way::Up,
            "change on the way up, and at the top",
            !tilts.heard.is_empty(),
        ),
        (Way::Down, "change on the way down", tilts.has_come_down()),
    ] {
        page.measure(name, there.then(|| changes(tilts, way)));
    }
    let span = tilts.differs();
    page.measure(
        "tilts that sound otherwise up and down",
        tilts.has_come_down().then(|| match span {
            Some([low, high]) => format!("{} to {}", degrees(low), degrees(high)),
            None => "none so far".to_owned(),
        }),
    );
    page.says = tilts.has_come_down().then(|| {
        let [up, down] = tilts.last_loop();
        match (up, down, span) {
            (Some(up), Some(down), _) => format!(
                "Up it changed at **{}**, down it changed back only at **{}**, {:.1}° below.",
                degrees(up.to.tilt),
                degrees(down.to.tilt),
                // As the reader would subtract them.
                tenths(up.to.tilt) - tenths(down.to.tilt)
            ),
            (Some(up), None, Some(_)) => format!(
                "Up it changed at **{}**; down it has not changed back so far.",
                degrees(up.to.tilt)
            ),
            (_, _, None) => {
                "Up and down sound the same so far: no hysteresis is seen within the resolution."
                    .to_owned()
            }
            (None, _, Some(_)) => "It sounds otherwise on the way down.".to_owned(),
        }
    });
    page
}

/// The last few changes on a way.
fn changes(tilts: &Tilts, way: Way) -> String {
    let one = |change: &Change| {
        format!(
            "at {} from {} to {}",
            degrees(change.to.tilt),
            quantity(change.from, "Hz"),
            quantity(change.to.frequency, "Hz")
        )
    };
    let all: Vec<String> = tilts.on(way).map(one).collect();
    match all.len() {
        0 => "none so far".to_owned(),
        count => all[count.saturating_sub(CHANGES)..].join("; "),
    }
}

fn torus(measured: &Measured) -> Page {
    let mut page = new(
        "Torus: two tones without a common period",
        "Two tones sound at once, and their frequencies share no period, so that the motion never repeats, \
         though it is perfectly regular: it winds round a torus as a thread round a ring. Friction and \
         contact mix the two: sums and differences appear, and the slow difference is heard as a beat.",
        "the spectrum: each line is a sum of multiples of f1 and f2. The phase portrait is a woven band, the \
         section a closed curve instead of a point.",
    );
    let line = |name: &str| measured.peaks.iter().find(|peak| peak.label == name);
    let tones = line("f1").zip(line("f2"));
    page.measure(
        "first tone f1",
        line("f1").map(|peak| quantity(peak.frequency, "Hz")),
    );
    page.measure(
        "second tone f2",
        line("f2").map(|peak| quantity(peak.frequency, "Hz")),
    );
    let difference = tones.map(|(a, b)| (a.frequency - b.frequency).abs());
    page.measure("their difference", difference.map(|hz| quantity(hz, "Hz")));
    let mixed = |label: &str| label.contains("f1") && label.contains("f2");
    let mixed: Vec<_> = measured
        .peaks
        .iter()
        .filter(|peak| mixed(&peak.label))
        .collect();
    if mixed.is_empty() {
        page.measure("sums and differences", None);
    }
    for peak in mixed.into_iter().take(COMBINATIONS) {
        page.measure(&peak.label, Some(quantity(peak.frequency, "Hz")));
    }
    exponents(&mut page, measured, 2);
    let alone = line("f1").filter(|_| difference.is_none()).map(|_| {
        "One tone and its multiples is all that is heard so far: a closed curve, and no torus."
            .to_owned()
    });
    let two = difference.filter(|hz| *hz > 0.0).map(|hz| {
        let seen = match measured.exponents.as_ref().map(|exponents| exponents.attractor()) {
            Some(Attractor::Torus(_)) => {
                " Its exponents agree: two are zero, as on a torus; neighbours neither part nor meet."
            }
            Some(Attractor::Undecided) => " Its exponents have not yet decided.",
            Some(_) | None => "",
        };
        format!(
            "The two drift through each other **{}** times a second, once every {}.{seen}",
            plain(hz),
            quantity(1.0 / hz, "s")
        )
    });
    page.says = two.or(alone);
    page
}

fn chaos(measured: &Measured) -> Page {
    let mut page = new(
        "Chaos: two copies that started alike",
        "A second copy of the joint starts almost in the same state and obeys the same law, without any \
         chance. Their distance doubles time and again, until the two have nothing in common but the \
         shape of their motion. So the law is known, yet the future is not: what is not known of the start \
         grows.",
        "the distance on its logarithmic scale: by and large a straight rise, which is doubling; it halts \
         where the motion is calm for a while. The two phase portraits look alike, but the copies are \
         elsewhere on them.",
    );
    let [first, last] = match measured.parting {
        Some([first, last]) => [Some(first), Some(last)],
        None => [None; 2],
    };
    page.measure(
        "distance at first, over the motion",
        first.map(|p| format!("{:.1e}", p.distance)),
    );
    page.measure("distance now", last.map(|p| format!("{:.1e}", p.distance)));
    let line = last.and_then(|parting| parting.line);
    page.measure(
        "growth rate of the distance",
        line.map(|line| format!("{} ± {}", plain(line.rate), per_second(line.half_width))),
    );
    let grows = line.filter(PartingLine::grows);
    page.measure(
        "it doubles every",
        grows.map(|line| rounded(LN_2 / line.rate, 2, "s")),
    );
    let parted = last.and_then(|parting| Some(parting.saturated? - parting.start));
    page.measure(
        "a tenth of the motion apart after",
        parted.map(|time| rounded(time, 2, "s")),
    );
    exponents(&mut page, measured, 1);
    page.says = match (grows, parted) {
        (Some(line), Some(time)) => Some(format!(
            "A start known to {:.0e} of the motion foretells it to a tenth for **{}**, no more. Known ten \
             times better, it would foretell only {} longer.",
            first.map_or(0.0, |first| first.distance),
            rounded(time, 2, "s"),
            rounded(10f64.ln() / line.rate, 2, "s")
        )),
        (Some(_), None) => Some("The two part, but are still together.".to_owned()),
        (None, _) => line.map(|line| match line.shrinks() {
            true => "The two come together: no chaos so far.".to_owned(),
            false => "Whether the two part is not told yet.".to_owned(),
        }),
    };
    page
}

/// Rows on the growth of the envelope.
fn growth(page: &mut Page, measured: &Measured) {
    let envelope = &measured.envelope;
    let fit = match (envelope.growth(), envelope.ended) {
        (Some(fit), _) => Some(format!(
            "{} ± {}",
            plain(fit.slope),
            per_second(fit.half_width)
        )),
        (None, Some(_)) => Some("too brief to be measured".to_owned()),
        (None, None) => None,
    };
    page.measure("growth rate of the loudness, while small", fit);
}

/// Rows on how loud it was and is.
fn level(page: &mut Page, computed: &Computed, measured: &Measured) {
    let first = measured.envelope.first;
    page.measure(
        "loudness at first",
        first.map(|[_, level]| quantity(level, "m/s")),
    );
    let now = measured.envelope.level();
    let silent = is_silent(computed, measured);
    let words = quantity(now, "m/s") + if silent { ", silent" } else { "" };
    page.measure("loudness now", first.map(|_| words));
}

/// Whether there is nothing to hear.
fn is_silent(computed: &Computed, measured: &Measured) -> bool {
    measured.envelope.level() < SILENT * computed.sliding_speed
}

/// A row on what is heard.
fn tone(page: &mut Page, computed: &Computed, measured: &Measured) {
    let heard = measured
        .tone()
        .map(|tone| match is_silent(computed, measured) {
            true => "nothing".to_owned(),
            false => quantity(tone, "Hz"),
        });
    page.measure("heard, the strongest line", heard);
}

/// Rows on the modes with the most energy.
fn leaders(page: &mut Page, measured: &Measured) {
    let leaders = &measured.leaders;
    page.measure(
        "most energy as the growth ended",
        leaders.at_end().map(str::to_owned),
    );
    page.measure(
        "most energy over the last 25 ms",
        leaders.now().map(str::to_owned),
    );
}

/// Rows on the largest exponents.
fn exponents(page: &mut Page, measured: &Measured, count: usize) {
    let told = measured.exponents.as_ref().map(|exponents| {
        let told = exponents.spectrum.exponents.iter().take(count);
        told.map(with_error).collect::<Vec<_>>().join(", ") + " per s"
    });
    let name = match count {
        1 => "largest Lyapunov exponent",
        _ => "largest Lyapunov exponents",
    };
    page.measure(name, told);
}

/// How the measured growth compares with the computed one.
fn agreement(computed: &Computed, measured: &Measured) -> Option<String> {
    let (rate, fit) = (computed.fastest()?, measured.envelope.growth()?);
    let unstable = !computed.unstable().is_empty();
    Some(match (unstable, fit.slope > 2.0 * fit.half_width) {
        (true, true) => format!(
            "It grows, as computed: the measured rate is **{}** of the computed one.",
            percent(fit.slope / rate)
        ),
        (false, false) => "It does not grow, as computed.".to_owned(),
        (true, false) => "Computed to grow, but no growth is measured so far.".to_owned(),
        (false, true) => {
            "Computed not to grow, yet growth is measured: linear theory misses something."
                .to_owned()
        }
    })
}

/// The computed mode that a frequency (Hz) is near, of those that grow.
fn near(computed: &Computed, frequency: f64) -> Option<&ComputedMode> {
    let off = |mode: &ComputedMode| (mode.frequency_hz / frequency - 1.0).abs();
    let modes = computed.modes.iter().filter(|mode| mode.unstable);
    let nearest = modes.min_by(|a, b| off(a).total_cmp(&off(b)))?;
    (off(nearest) < NEAR).then_some(nearest)
}

fn mode_words(mode: &ComputedMode) -> String {
    let frequency = quantity(mode.frequency_hz, "Hz");
    format!("{frequency}, grows at {}", per_second(mode.growth))
}

/// A tilt (rad) in degrees, to a tenth.
fn tenths(tilt: f64) -> f64 {
    (10.0 * tilt.to_degrees()).round() / 10.0
}

fn degrees(tilt: f64) -> String {
    format!("{:.1}°", tilt.to_degrees())
}

/// A number without a unit, to three digits where it is small, whole where it is large.
fn plain(x: f64) -> String {
    match x.abs() {
        100.0.. => format!("{x:.0}"),
        10.0.. => format!("{x:.1}"),
        0.1.. => format!("{x:.2}"),
        _ => format!("{x:.4}"),
    }
}

fn per_second(x: f64) -> String {
    format!("{} per s", plain(x))
}

fn rounded_plain(x: f64) -> String {
    format!("{x:.3}")
}

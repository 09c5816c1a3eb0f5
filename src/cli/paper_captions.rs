//! What the counterparts of the paper's figures show, and how they differ from the paper.

use std::fmt::Write as _;

use crate::study::paper::{Finding, Holds};
use crate::study::response::Response;

pub(super) const CONFIGURATION: &str = "**Fig. 1.** Ball and beam with the tilted load and the \
rotation, and the pre-stress on the contact patch. The patch is the spherical cap of Hertz' radius about \
the load's direction; each contact node carries the mean pressure of its cell, so that the load is kept \
exactly. The paper projects the patch onto the nodes of its own mesh and does not say how many there are.";

pub(super) const MODE_SHAPES: &str = "**Fig. 2.** Mode shapes of the finite-element model, free at both \
ends, one of each bending pair, upon the body at rest; the frequencies are those that the scene uses. The \
paper's seven frequencies are met by no simple boundary condition of the stated geometry: scenes impose \
them upon our shapes unless they ask for the model's own.";

pub(super) const FRICTION: &str = "**Fig. 3.** The friction curve, Eq. (5). With the slope factors as \
printed in the caption the coefficient still rises at the speed of steady sliding, and no mode is unstable \
at any tilt; exchanged, it falls there, and the four bending pairs squeak. Both are drawn.";

pub(super) const EMBEDDING: &str = "**Fig. 8.** Average mutual information and false nearest neighbours \
of the settled motion, from 20 ms of it. The paper's delay of 20 samples is of a spacing that it does not \
state. The other figures take 60 µs at every tilt, a quarter of the period of 4.1 kHz, and five dimensions, \
so that they can be compared with each other and with the paper's.";

pub(super) const RECURRENCE: &str = "**Fig. 9.** Recurrence plots of 5 ms, delay vectors of dimension 5, \
a tenth of all pairs recurrent. The paper does not state its threshold; a fixed share of pairs lets plots \
of strong and of faint motions be compared.";

pub(super) const SECTIONS: &str = "**Fig. 10.** Poincaré maps: y(t) and y(t + 2 τ) whenever y(t + τ) \
rises through zero, all on the same axes. Points: periodic; a closed curve: quasi-periodic; a cloud: \
chaotic.";

pub(super) const EXPONENTS: &str = "**Fig. 11.** (a) The largest three Lyapunov exponents with their 95 % \
intervals, which the paper does not give; (b) bifurcation diagram: local maxima of the displacement; (c) \
lines of the spectrum, which the paper does not give either. \
Attractors coexist, so that another start may give another diagram: `squeakscope sweep --start all` shows \
them side by side.";

/// What the paper says of a figure and is not so here, with the reason; empty where all is so.
pub(super) fn differences(number: u8, findings: &[Finding]) -> String {
    let of_figure = |finding: &&Finding| {
        let place = &finding.claim.place;
        let places = place.split([',', ';']).filter_map(|part| {
            let digits = part.trim().trim_start_matches("Fig. ");
            let end = digits
                .find(|c: char| !c.is_ascii_digit())
                .unwrap_or(digits.len());
            digits[..end].parse::<u8>().ok()
        });
        let figures: Vec<u8> = places.collect();
        place.starts_with("Fig.") && figures.contains(&number)
    };
    let missed = findings.iter().filter(of_figure).filter(|finding| {
        let known = !matches!(finding.holds, Holds::Yes | Holds::Unknown);
        known && finding.ours != finding.published
    });
    let missed: Vec<String> = missed
        .map(|finding| {
            format!(
                "{}: published {}, here {}",
                finding.claim.says, finding.published, finding.ours
            )
        })
        .collect();
    if missed.is_empty() {
        return String::new();
    }
    let why = match number {
        2 => "no simple reading of the stated geometry meets its frequencies",
        _ => {
            "the paper leaves the direction of the tilt, the contact stiffness and the kick open, and of \
             all sets that `squeakscope calibrate` has tried none meets every claim"
        }
    };
    format!(" *Differs from the paper* ({why}): {}.", missed.join("; "))
}

/// The caption of one of Fig. 4 to 7.
pub(super) fn motion(number: u8, tilt_deg: f64, response: &Response) -> String {
    let mut caption = format!(
        "**Fig. {number}**, {tilt_deg}°. (a) Growth of the linear modes of steady sliding, and as bars the \
         shares in it of the friction law's slope, of mode coupling, and of damping, which add up to \
         it; the paper gives the growth alone. Overdamped modes, and bars that reach below the panel, are left \
         out. (b to f) Time series, phase plot, spectrum, delay reconstruction and \
         recurrence plot of the settled motion, which is {}",
        response.regime
    );
    let lines = response.lines.iter().take(3);
    let lines: Vec<String> = lines
        .map(|line| format!("{:.2}", 1e-3 * line.frequency))
        .collect();
    if !lines.is_empty() {
        let _ = write!(
            caption,
            "; its strongest lines are at {} kHz",
            lines.join(", ")
        );
    }
    let exponent = response
        .exponents
        .as_ref()
        .and_then(|spectrum| spectrum.exponents.first());
    if let Some(exponent) = exponent {
        let places = if exponent.half_width < 2.0 { 2 } else { 0 };
        let _ = write!(
            caption,
            "; its largest exponent is {:.places$} ± {:.places$} 1/s",
            exponent.value, exponent.half_width
        );
    }
    caption.push('.');
    if !response.settled {
        caption.push_str(" It still changed when it was measured.");
    }
    caption
}

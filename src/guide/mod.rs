//! Longer pages: what the code means and how far to trust it. Their examples are tests.
//!
//! * [`equations`]: each equation of the paper and where it is; axes, signs, energy.
//! * [`stability`]: what can go wrong with the numbers, what is caught, and how.
//! * [`hard_cases`]: the hardest of them, one by one, with what was measured.
//! * [`exponents`]: Lyapunov exponents, their intervals, and how to read a zero.
//! * [`mechanisms`]: why things squeal, a scene each, with numbers measured in its run.
//! * [`sweeps`]: what happens as a number of a scene changes; many machines; the paper.
//! * [`cost`]: what accuracy costs, knob by knob, for four scenes; how cost grows.
//! * [`json`]: the fields of results, as `--json` writes them.
//! * [`live`]: a run that is steered while it goes on, its page, its sound.
//! * [`off`]: what an effect costs that is left out.
//! * [`peers`]: the laboratory beside other tools, measured.
//! * [`scene`](crate::scene): all keys of a scene file.

#[doc = include_str!("equations.md")]
pub mod equations {}

#[doc = include_str!("stability.md")]
pub mod stability {}

#[doc = include_str!("hard_cases.md")]
pub mod hard_cases {}

#[doc = include_str!("exponents.md")]
pub mod exponents {}

#[doc = include_str!("mechanisms.md")]
pub mod mechanisms {}

#[doc = include_str!("sweeps.md")]
pub mod sweeps {}

#[doc = include_str!("cost.md")]
#[doc = include_str!("cost.html")]
pub mod cost {}

#[doc = include_str!("json.md")]
pub mod json {}

#[doc = include_str!("live.md")]
pub mod live {}

#[doc = include_str!("off.md")]
pub mod off {}

#[doc = include_str!("peers.md")]
pub mod peers {}

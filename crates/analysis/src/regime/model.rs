//! The model of the classification: its inputs, classes and coefficients.
//!
//! The classes are the regimes and *not enough evidence*, which has training signals of its own (short records, speech,
//! music, creak). The ignored test `the_model_is_fitted` repeats the fit.

use std::sync::LazyLock;

use super::Regime;
use crate::logistic::Model;

/// The inputs, and the criterion to which each belongs.
pub(super) const INPUTS: [(&str, &str); 18] = [
    ("beside_one", "one tone"),
    ("beside_two", "two tones"),
    ("floor", "broadband floor"),
    ("floor_excess", "broadband floor"),
    ("coloured_excess", "broadband floor"),
    ("floor_over_error", "broadband floor"),
    ("loop", "Poincare section"),
    ("points", "Poincare section"),
    ("repetition", "repetition"),
    ("long_error", "predictability"),
    ("error_over_linear", "predictability"),
    ("divergence", "divergence"),
    ("drift", "divergence"),
    ("zero_one", "0-1 test"),
    ("level", "steadiness"),
    ("change", "steadiness"),
    ("period_drift", "steadiness"),
    ("periods", "record length"),
];

/// The classes. The last one stands for too little evidence.
pub(super) const CLASSES: [Regime; 6] = [
    Regime::Transient,
    Regime::Periodic,
    Regime::QuasiPeriodic,
    Regime::Chaotic,
    Regime::Noise,
    Regime::Undetermined,
];

/// Values of all inputs.
pub(super) type Inputs = [f64; INPUTS.len()];

/// The model of `model.json`.
pub(super) static MODEL: LazyLock<Model> =
    LazyLock::new(|| Model::of_program(include_str!("model.json")));

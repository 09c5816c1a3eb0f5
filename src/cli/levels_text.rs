//! Sound levels of a calibrated signal, for the terminal.

use std::fmt::Write as _;

use super::report::HEADING;
use crate::analysis::SoundLevels;
use crate::number::significant;
use crate::study::signal::CalibratedLevels;
use crate::table::Table;

/// The paragraph of the report.
pub(super) fn levels_text(found: &CalibratedLevels) -> String {
    let SoundLevels {
        equivalent_level_db,
        a_weighted_level_db,
        fast_maximum_db,
        peak_level_db,
        third_octaves,
    } = &found.levels;
    let mut text = format!(
        "{HEADING}sound levels{HEADING:#}, dB re 20 uPa\n  A-weighted: equivalent {a_weighted_level_db:.1}, maximum \
             (fast) {fast_maximum_db:.1}; unweighted: equivalent {equivalent_level_db:.1}, peak {peak_level_db:.1}\n"
    );
    let sensitivity = significant(found.calibration.sensitivity_pa, 4);
    let _ = match found.calibration.calibrator {
        None => writeln!(text, "  calibration: 1 unit is {sensitivity} Pa, as given"),
        Some(tone) => writeln!(
            text,
            "  calibration: 1 unit is {sensitivity} Pa, by a tone of {:.1} Hz at {} dB that varies by {:.2} dB; the \
                 uncertainty of the calibrator (class 1: up to 0.4 dB) and of the microphone adds to it",
            tone.tone_hz, tone.stated_level_db, tone.level_deviation_db
        ),
    };
    let mut table = Table::default()
        .right("third octave, Hz")
        .right("dB")
        .right("+-");
    for band in third_octaves {
        table.row([
            band.centre_hz.to_string(),
            format!("{:.1}", band.band_level_db),
            format!("{:.1}", band.standard_deviation_db),
        ]);
    }
    text += &table.text();
    text + "  +-: standard deviation for random noise; less for tones\n"
}

//! From a parsed file to a validated [`Scene`]: values by key first, then what must fit together.

use crate::fem::{Families, Geometry, LengthReading, Material};
use crate::joint::{BodySpec, Contact, Frequencies, Friction, JointSpec, Socket};

use super::error::{Place, SceneError};
use super::file::{Document, line_of};
use super::keys::{self, Law};
use super::kind::Numbers;
use super::schedule::Schedule;
use super::spec::{
    AnalysisSpec, Integrator, Method, RecordSpec, RecurrenceSpec, RecurrenceThreshold, Scene,
    SpectrogramSpec, SpectrumSpec, Start,
};

impl Scene {
    /// Parses and validates a scene file's content. `file` is the name it goes by in messages;
    /// its stem names the scene if the text does not.
    ///
    /// # Errors
    /// The first fault found, in the order: not text, not TOML, an unknown key, a value that is
    /// missing, mistyped or out of range, values that do not fit together.
    pub fn parse(file: &str, content: impl AsRef<[u8]>) -> Result<Self, SceneError> {
        let content = content.as_ref();
        let text = std::str::from_utf8(content).map_err(|error| {
            let valid = String::from_utf8_lossy(&content[..error.valid_up_to()]);
            SceneError::NotText {
                at: Place {
                    file: file.to_owned(),
                    line: Some(line_of(&valid, valid.len())),
                },
            }
        })?;
        // Some editors put a byte-order mark first; it is no part of the text.
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        build(&Document::parse(file, text)?, file, text)
    }
}

fn build(document: &Document<'_>, file: &str, text: &str) -> Result<Scene, SceneError> {
    let stem = std::path::Path::new(file).file_stem();
    let name = match document.find(&keys::NAME)? {
        Some(name) => name,
        None => stem.unwrap_or_default().to_string_lossy().into_owned(),
    };
    let title = document.find(&keys::TITLE)?;
    let about = document.find(&keys::ABOUT)?;
    let sample_rate = document.get(&keys::SAMPLE_RATE)?;
    let scene = Scene {
        title: title.unwrap_or_else(|| name.clone()),
        about: about.unwrap_or_default(),
        name,
        text: text.to_owned(),
        joint: joint(document)?,
        tilt: tilt(document)?,
        start: Start {
            kick: document.get(&keys::KICK)?,
            seed: document.get(&keys::SEED)?,
        },
        duration: document.get(&keys::DURATION)?,
        sample_rate,
        frame_samples: document.get(&keys::FRAME_SAMPLES)?,
        integrator: integrator(document)?,
        analysis: AnalysisSpec {
            spectrum: spectrum(document, sample_rate)?,
            spectrogram: spectrogram(document, sample_rate)?,
            recurrence: recurrence(document, sample_rate)?,
        },
        record: record(document, sample_rate)?,
    };
    let motion = [
        keys::ROTATION.path,
        keys::AZIMUTH.path,
        keys::TILT.path,
        keys::TILT_KNOTS.path,
    ];
    sliding(&scene.joint, &scene.tilt, || document.place_of(&motion))?;
    Ok(scene)
}

fn joint(document: &Document<'_>) -> Result<JointSpec, SceneError> {
    let body = body(document)?;
    Ok(JointSpec {
        socket: socket(document, &body.geometry)?,
        load: document.get(&keys::LOAD)?,
        azimuth: document.get(&keys::AZIMUTH)?,
        rotation: rotation(document)?,
        contact: Contact {
            nodes: document.get(&keys::NODES)?,
            quadrature: document.get(&keys::QUADRATURE)?,
            stiffness_factor: document.get(&keys::STIFFNESS_FACTOR)?,
            stiffness: document.get(&keys::STIFFNESS)?,
            radius_factor: document.get(&keys::RADIUS_FACTOR)?,
            unilateral: document.get(&keys::UNILATERAL)?,
        },
        friction: friction(document)?,
        damping: damping(document, body.families.count())?,
        body,
    })
}

fn body(document: &Document<'_>) -> Result<BodySpec, SceneError> {
    let geometry = Geometry {
        ball_diameter: document.get(&keys::BALL_DIAMETER)?,
        beam_diameter: document.get(&keys::BEAM_DIAMETER)?,
        beam_length: document.get(&keys::BEAM_LENGTH)?,
        reading: document.get(&keys::BEAM_REACHES)?,
    };
    let element_size = document.get(&keys::ELEMENT_SIZE)?;
    dimensions(document, &geometry, element_size)?;
    let families = Families {
        bending_pairs: document.get(&keys::BENDING_PAIRS)?,
        torsion: document.get(&keys::TORSION)?,
        axial: document.get(&keys::AXIAL)?,
    };
    let frequencies = document.get(&keys::FREQUENCIES)?;
    modes(document, &families, &frequencies)?;
    Ok(BodySpec {
        geometry,
        material: Material {
            young: document.get(&keys::BODY_YOUNG)?,
            poisson: document.get(&keys::BODY_POISSON)?,
            density: document.get(&keys::DENSITY)?,
        },
        element_size,
        families,
        frequencies,
    })
}

/// The beam must be thinner than the ball, reach out of it, and be meshable.
fn dimensions(
    document: &Document<'_>,
    geometry: &Geometry,
    element_size: f64,
) -> Result<(), SceneError> {
    /// Far beyond any use (the default mesh has a few hundred), but still solved in minutes.
    const MOST_ELEMENTS: f64 = 1e5;

    if geometry.beam_diameter >= geometry.ball_diameter {
        return Err(SceneError::Inconsistent {
            at: document.place_of(&[keys::BALL_DIAMETER.path, keys::BEAM_DIAMETER.path]),
            key: keys::BEAM_DIAMETER.path,
            problem: format!(
                "the beam ({} mm) is not thinner than the ball ({} mm)",
                geometry.beam_diameter * 1e3,
                geometry.ball_diameter * 1e3
            ),
            remedy: "make it smaller than body.ball_diameter_mm".to_owned(),
        });
    }
    if geometry.reading == LengthReading::ToCentre
        && geometry.beam_length <= geometry.ball_diameter / 2.0
    {
        return Err(SceneError::Inconsistent {
            at: document.place_of(&[keys::BEAM_LENGTH.path, keys::BALL_DIAMETER.path]),
            key: keys::BEAM_LENGTH.path,
            problem: "a beam measured to the ball's centre ends inside the ball".to_owned(),
            remedy: "make it longer than half of body.ball_diameter_mm".to_owned(),
        });
    }
    // Right triangles with legs of the element size fill the meridian section.
    let section = geometry.beam_length * geometry.beam_diameter / 2.0
        + std::f64::consts::PI / 8.0 * geometry.ball_diameter.powi(2);
    let elements = 2.0 * section / element_size.powi(2);
    if elements > MOST_ELEMENTS {
        return Err(SceneError::Inconsistent {
            at: document.place_of(&[keys::ELEMENT_SIZE.path, keys::BEAM_LENGTH.path]),
            key: keys::ELEMENT_SIZE.path,
            problem: format!("a body of this size would take about {elements:.0} elements"),
            remedy: format!("choose a size that gives at most {MOST_ELEMENTS}"),
        });
    }
    Ok(())
}

/// There must be a mode, and published frequencies exist for the paper's modes only.
fn modes(
    document: &Document<'_>,
    families: &Families,
    frequencies: &Frequencies,
) -> Result<(), SceneError> {
    /// The modes of Fig. 2.
    const PUBLISHED: Families = Families {
        bending_pairs: 4,
        torsion: 2,
        axial: 1,
    };
    let at = || {
        document.place_of(&[
            keys::BENDING_PAIRS.path,
            keys::TORSION.path,
            keys::AXIAL.path,
            keys::FREQUENCIES.path,
        ])
    };
    if families.count() == 0 {
        return Err(SceneError::Inconsistent {
            at: at(),
            key: keys::BENDING_PAIRS.path,
            problem: "no mode takes part".to_owned(),
            remedy: "make one of body.bending_pairs, body.torsion, body.axial at least 1"
                .to_owned(),
        });
    }
    let beyond = families.bending_pairs > PUBLISHED.bending_pairs
        || families.torsion > PUBLISHED.torsion
        || families.axial > PUBLISHED.axial;
    if *frequencies == Frequencies::Published && beyond {
        return Err(SceneError::Inconsistent {
            at: at(),
            key: keys::FREQUENCIES.path,
            problem: format!(
                "the paper publishes frequencies of {} bending pairs, {} torsion modes and {} \
                 axial mode, and more take part",
                PUBLISHED.bending_pairs, PUBLISHED.torsion, PUBLISHED.axial
            ),
            remedy: "take fewer modes, or body.frequencies = \"fe\"".to_owned(),
        });
    }
    Ok(())
}

fn socket(document: &Document<'_>, geometry: &Geometry) -> Result<Socket, SceneError> {
    let diameter = document.get(&keys::SOCKET_DIAMETER)?;
    if diameter <= geometry.ball_diameter {
        return Err(SceneError::Inconsistent {
            at: document.place_of(&[keys::SOCKET_DIAMETER.path, keys::BALL_DIAMETER.path]),
            key: keys::SOCKET_DIAMETER.path,
            problem: format!(
                "the socket ({} mm) is not larger than the ball ({} mm)",
                diameter * 1e3,
                geometry.ball_diameter * 1e3
            ),
            remedy: "make it larger than body.ball_diameter_mm".to_owned(),
        });
    }
    Ok(Socket {
        diameter,
        young: document.get(&keys::SOCKET_YOUNG)?,
        poisson: document.get(&keys::SOCKET_POISSON)?,
    })
}

fn rotation(document: &Document<'_>) -> Result<[f64; 3], SceneError> {
    let rotation = document.get(&keys::ROTATION)?;
    if rotation.iter().all(|&component| component == 0.0) {
        return Err(SceneError::Inconsistent {
            at: document.place_of(&[keys::ROTATION.path]),
            key: keys::ROTATION.path,
            problem: "the ball does not rotate, so nothing slides".to_owned(),
            remedy: "make one component other than 0".to_owned(),
        });
    }
    Ok(rotation)
}

fn friction(document: &Document<'_>) -> Result<Friction, SceneError> {
    if !document.has("friction") {
        return Ok(Friction::None);
    }
    match document.get(&keys::LAW)? {
        Law::Stribeck => Ok(Friction::Stribeck {
            mu_s: document.get(&keys::MU_S)?,
            mu_d: document.get(&keys::MU_D)?,
            creep: document.get(&keys::CREEP_SLOPE)?,
            stribeck: document.get(&keys::STRIBECK_SLOPE)?,
            radial: document.get(&keys::RADIAL)?,
        }),
    }
}

fn damping(document: &Document<'_>, modes: usize) -> Result<Vec<f64>, SceneError> {
    if !document.has("damping") {
        return Ok(Vec::new());
    }
    match document.get(&keys::DAMPING)? {
        Numbers::One(ratio) => Ok(vec![ratio; modes]),
        Numbers::Many(ratios) if ratios.len() == modes => Ok(ratios),
        Numbers::Many(ratios) => Err(SceneError::Inconsistent {
            at: document.place_of(&[keys::DAMPING.path]),
            key: keys::DAMPING.path,
            problem: format!("{} ratios for {modes} modes", ratios.len()),
            remedy: "give one for each mode (a bending pair is two), or a single number".to_owned(),
        }),
    }
}

fn tilt(document: &Document<'_>) -> Result<Schedule, SceneError> {
    let elements = match (
        document.find(&keys::TILT)?,
        document.list(&keys::TILT_KNOTS)?,
    ) {
        (Some(tilt), None) => return Ok(Schedule::constant(tilt)),
        (None, Some(elements)) => elements,
        (None, None) => return Err(document.missing(&keys::TILT)),
        (Some(_), Some(_)) => {
            return Err(SceneError::Inconsistent {
                at: document.place_of(&[keys::TILT.path, keys::TILT_KNOTS.path]),
                key: keys::TILT_KNOTS.path,
                problem: "the tilt is given twice, as a constant and as a function of time"
                    .to_owned(),
                remedy: "keep one of load.tilt_deg and load.tilt".to_owned(),
            });
        }
    };
    let mut knots: Vec<(f64, f64)> = Vec::with_capacity(elements.len());
    for element in &elements {
        let time = document.get_in(element, &keys::KNOT_TIME)?;
        let tilt = document.get_in(element, &keys::KNOT_TILT)?;
        if let Some(&(before, _)) = knots.last()
            && time <= before
        {
            return Err(out_of_order(document.place_of_element(element)));
        }
        knots.push((time, tilt));
    }
    let at = document.place_of(&[keys::TILT_KNOTS.path]);
    Schedule::through(knots).ok_or_else(|| out_of_order(at))
}

fn out_of_order(at: Place) -> SceneError {
    SceneError::Inconsistent {
        at,
        key: keys::KNOT_TIME.path,
        problem: "this knot is not later than the one before".to_owned(),
        remedy: "put the knots in order, each time once".to_owned(),
    }
}

/// The central contact point must slide at every tilt that is reached: otherwise Eq. (24) has no
/// direction. It does not where the load's axis meets the axis of rotation.
pub(super) fn sliding(
    joint: &JointSpec,
    tilt: &Schedule,
    at: impl FnOnce() -> Place,
) -> Result<(), SceneError> {
    /// Angle between the two axes below which sliding has no certain direction, rad.
    const TOO_CLOSE: f64 = 1e-4;

    let [x, y, z] = joint.rotation;
    let (sin, cos) = joint.azimuth.sin_cos();
    // Across the plane in which the load tilts, and within it.
    let across = y * cos - x * sin;
    let within = x * cos + y * sin;
    let axis = within.atan2(z);
    let off_plane = across.abs().atan2(within.hypot(z));
    if off_plane > TOO_CLOSE {
        return Ok(());
    }
    let knots = tilt.knots().iter().map(|knot| knot.1);
    let lowest = knots.clone().fold(f64::INFINITY, f64::min) - TOO_CLOSE;
    let highest = knots.fold(f64::NEG_INFINITY, f64::max) + TOO_CLOSE;
    // An axis has two ends, half a turn apart.
    let half_turn = std::f64::consts::PI;
    let meets = [axis - half_turn, axis, axis + half_turn]
        .into_iter()
        .find(|end| (lowest..=highest).contains(end));
    match meets {
        None => Ok(()),
        Some(end) => Err(SceneError::Inconsistent {
            at: at(),
            key: keys::ROTATION.path,
            problem: format!(
                "at a tilt of {:.3} deg the load lies along the axis of rotation, so the central \
                 contact point does not slide",
                end.to_degrees()
            ),
            remedy: "change the rotation, load.azimuth_deg or the tilt".to_owned(),
        }),
    }
}

fn integrator(document: &Document<'_>) -> Result<Integrator, SceneError> {
    let method = document.get(&keys::METHOD)?;
    if method == Method::Rk4 && !document.has(keys::MAX_STEP.path) {
        return Err(SceneError::Inconsistent {
            at: document.place_of(&[keys::METHOD.path]),
            key: keys::MAX_STEP.path,
            problem: "rk4 takes fixed steps, and none is given".to_owned(),
            remedy: "add time.max_step_us; 0.4 to 1.6 fits the paper's joint".to_owned(),
        });
    }
    Ok(Integrator {
        method,
        tolerance: document.get(&keys::TOLERANCE)?,
        max_step: document.get(&keys::MAX_STEP)?,
    })
}

fn spectrum(document: &Document<'_>, rate: f64) -> Result<Option<SpectrumSpec>, SceneError> {
    if !document.has("analysis.spectrum") {
        return Ok(None);
    }
    let spec = SpectrumSpec {
        window: document.get(&keys::SPECTRUM_WINDOW)?,
        every: document.get(&keys::SPECTRUM_EVERY)?,
    };
    long_enough(document, keys::SPECTRUM_WINDOW.path, spec.window, rate)?;
    Ok(Some(spec))
}

fn spectrogram(document: &Document<'_>, rate: f64) -> Result<Option<SpectrogramSpec>, SceneError> {
    if !document.has("analysis.spectrogram") {
        return Ok(None);
    }
    let spec = SpectrogramSpec {
        window: document.get(&keys::SPECTROGRAM_WINDOW)?,
        every: document.get(&keys::SPECTROGRAM_EVERY)?,
        max_frequency: document.get(&keys::MAX_FREQUENCY)?,
    };
    long_enough(document, keys::SPECTROGRAM_WINDOW.path, spec.window, rate)?;
    if spec.max_frequency > rate / 2.0 {
        return Err(SceneError::Inconsistent {
            at: document.place_of(&[keys::MAX_FREQUENCY.path, keys::SAMPLE_RATE.path]),
            key: keys::MAX_FREQUENCY.path,
            problem: format!(
                "{} kHz is above half the sample rate ({} kHz), beyond which samples say nothing",
                spec.max_frequency / 1e3,
                rate / 2e3
            ),
            remedy: "lower it, or raise time.sample_rate_khz".to_owned(),
        });
    }
    Ok(Some(spec))
}

fn recurrence(document: &Document<'_>, rate: f64) -> Result<Option<RecurrenceSpec>, SceneError> {
    if !document.has("analysis.recurrence") {
        return Ok(None);
    }
    let thresholds = [keys::THRESHOLD_RATE.path, keys::THRESHOLD_DISTANCE.path];
    let share = document.find(&keys::THRESHOLD_RATE)?;
    let distance = document.find(&keys::THRESHOLD_DISTANCE)?;
    let threshold = match (share, distance) {
        (Some(share), None) => RecurrenceThreshold::Rate(share),
        (None, Some(distance)) => RecurrenceThreshold::Distance(distance),
        (None, None) => return Err(document.missing(&keys::THRESHOLD_RATE)),
        (Some(_), Some(_)) => {
            return Err(SceneError::Inconsistent {
                at: document.place_of(&thresholds),
                key: keys::THRESHOLD_DISTANCE.path,
                problem: "the threshold is given twice, as a rate and as a distance".to_owned(),
                remedy: "keep one of threshold_rate and threshold_um".to_owned(),
            });
        }
    };
    let spec = RecurrenceSpec {
        window: document.get(&keys::RECURRENCE_WINDOW)?,
        size: document.get(&keys::RECURRENCE_SIZE)?,
        every: document.get(&keys::RECURRENCE_EVERY)?,
        lag: document.get(&keys::LAG)?,
        dimension: document.get(&keys::DIMENSION)?,
        threshold,
    };
    long_enough(document, keys::RECURRENCE_WINDOW.path, spec.window, rate)?;
    if spec.size as f64 > (spec.window * rate).round() {
        return Err(SceneError::Inconsistent {
            at: document.place_of(&[keys::RECURRENCE_SIZE.path, keys::RECURRENCE_WINDOW.path]),
            key: keys::RECURRENCE_SIZE.path,
            problem: format!(
                "{} points from a window of {:.0} samples",
                spec.size,
                spec.window * rate
            ),
            remedy: "take fewer points or a longer window".to_owned(),
        });
    }
    if spec.lag * rate < 0.999 {
        return Err(SceneError::Inconsistent {
            at: document.place_of(&[keys::LAG.path, keys::SAMPLE_RATE.path]),
            key: keys::LAG.path,
            problem: format!("the delay is shorter than one sample ({} us)", 1e6 / rate),
            remedy: "make it at least that long".to_owned(),
        });
    }
    Ok(Some(spec))
}

/// A window must hold enough samples to be analysed.
fn long_enough(
    document: &Document<'_>,
    key: &'static str,
    window: f64,
    rate: f64,
) -> Result<(), SceneError> {
    const FEWEST_SAMPLES: f64 = 16.0;
    if (window * rate).round() >= FEWEST_SAMPLES {
        return Ok(());
    }
    Err(SceneError::Inconsistent {
        at: document.place_of(&[key, keys::SAMPLE_RATE.path]),
        key,
        problem: format!("the window holds fewer than {FEWEST_SAMPLES} samples"),
        remedy: format!("make it at least {} ms", FEWEST_SAMPLES / rate * 1e3),
    })
}

fn record(document: &Document<'_>, sample_rate: f64) -> Result<RecordSpec, SceneError> {
    let rate = |key| {
        let rate = document.get(key)?;
        if rate <= sample_rate {
            return Ok(rate);
        }
        Err(SceneError::Inconsistent {
            at: document.place_of(&[key.path, keys::SAMPLE_RATE.path]),
            key: key.path,
            problem: format!(
                "more often than samples are taken ({} kHz)",
                sample_rate / 1e3
            ),
            remedy: "make it at most time.sample_rate_khz".to_owned(),
        })
    };
    Ok(RecordSpec {
        patch_rate: rate(&keys::PATCH_RATE)?,
        body_rate: rate(&keys::BODY_RATE)?,
        energy_rate: rate(&keys::ENERGY_RATE)?,
        exaggeration: document.get(&keys::EXAGGERATION)?,
    })
}

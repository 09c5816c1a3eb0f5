//! What of a motion is heard, and where.

use serde::{Deserialize, Serialize};

use crate::pipeline::message::{Frame, Header, SurfaceMesh, vertex_normals};

/// What of a motion is heard.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Quantity {
    /// The velocity.
    ///
    /// It is what a laser vibrometer aimed there would play.
    #[default]
    Velocity,
    /// The acceleration, as the pressure far away follows it.
    ///
    /// The pressure far from a source much smaller than the wave length follows the
    /// acceleration of its surface: a proxy of the radiated sound, without the room and without the directions
    /// in which a body radiates.
    Pressure,
}

/// Where a motion is picked up.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Place {
    /// The scene's probe: of a joint the centre of the contact, in the direction of sliding.
    #[default]
    Probe,
    /// The point of the body's drawn surface that is nearest to this one (from the ball's centre, m), outwards.
    Surface([f64; 3]),
}

/// What is heard.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Source {
    /// The quantity.
    pub quantity: Quantity,
    /// The point.
    pub place: Place,
}

/// A surface is to be heard that is not there.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the scene `{scene}` has no surface to listen to: its body is drawn only where `body_rate_khz` in \
     its `[record]` is above 0 and its mode shapes are known there; without a point the probe is heard"
)]
pub struct NoSurface {
    /// Name of the scene.
    pub scene: String,
}

/// Turns a run's samples into what is heard.
#[derive(Clone, Debug)]
pub struct Pickup {
    quantity: Quantity,
    aim: Aim,
    last: Option<f64>,
}

/// The point that is heard.
#[derive(Clone, Debug, PartialEq)]
enum Aim {
    Probe {
        /// What it is.
        name: &'static str,
    },
    Surface {
        /// Where it is, m.
        at: [f64; 3],
        /// How much of each modal velocity there is in that of the surface, 1/sqrt(kg).
        row: Vec<f64>,
    },
}

impl Pickup {
    /// Aims at the place of a run that is to be heard.
    ///
    /// # Errors
    /// [`NoSurface`].
    pub fn new(source: Source, header: &Header) -> Result<Self, NoSurface> {
        let outline = header.joint().map(|joint| &joint.outline);
        let aim = match source.place {
            Place::Probe => probe(header),
            Place::Surface(point) => outline
                .and_then(|outline| nearest(outline, point))
                .ok_or_else(|| NoSurface {
                    scene: header.scene.clone(),
                })?,
        };
        Ok(Self::aimed(source.quantity, aim))
    }

    fn aimed(quantity: Quantity, aim: Aim) -> Self {
        Self {
            quantity,
            aim,
            last: None,
        }
    }

    /// Aims at the place that is to be heard, or at the probe of a run without a surface.
    pub fn wherever(source: Source, header: &Header) -> Self {
        Self::new(source, header).unwrap_or_else(|_| Self::aimed(source.quantity, probe(header)))
    }

    /// What is heard, in a few words.
    pub fn words(&self) -> String {
        let place = match &self.aim {
            Aim::Probe { name } => (*name).to_owned(),
            Aim::Surface { at, .. } => {
                // Rounded, minus nothing is nothing.
                let mm = at.map(|x| (1e4 * x).round() / 10.0 + 0.0);
                format!(
                    "the surface at ({}, {}, {}) mm, outwards",
                    mm[0], mm[1], mm[2]
                )
            }
        };
        match self.quantity {
            Quantity::Velocity => format!("velocity of {place}"),
            Quantity::Pressure => {
                format!("acceleration of {place}, as the pressure far away follows it")
            }
        }
    }

    /// So much of what is heard, with its unit.
    pub fn amount(&self, heard: f32) -> String {
        let (amount, unit) = match self.quantity {
            Quantity::Velocity => (1e3 * heard, "mm/s"),
            Quantity::Pressure => (heard, "m/s^2"),
        };
        match amount {
            0.1..1e4 => format!("{amount:.1} {unit}"),
            _ => format!("{amount:.1e} {unit}"),
        }
    }

    /// What is heard of a frame: a number a sample, m/s or m/s^2.
    pub fn hear<'a>(&'a mut self, frame: &'a Frame) -> impl Iterator<Item = f64> + 'a {
        let Self {
            quantity,
            aim,
            last,
        } = self;
        (0..frame.len()).map(move |k| {
            let velocity = match aim {
                Aim::Probe { .. } => frame.velocity[k],
                Aim::Surface { row, .. } => {
                    let modes = frame.qdot[k * frame.modes..].iter();
                    row.iter().zip(modes).map(|(r, v)| r * v).sum()
                }
            };
            match quantity {
                Quantity::Velocity => velocity,
                Quantity::Pressure => {
                    let before = last.replace(velocity).unwrap_or(velocity);
                    (velocity - before) / frame.dt
                }
            }
        })
    }
}

fn probe(header: &Header) -> Aim {
    let name = match header.joint() {
        Some(_) => "the contact's centre",
        None => "the mass",
    };
    Aim::Probe { name }
}

/// The vertex of a surface that is nearest to a point, moving outwards; `None` where there is no surface.
fn nearest(outline: &SurfaceMesh, point: [f64; 3]) -> Option<Aim> {
    let away = |at: &[f64; 3]| (0..3).map(|i| (at[i] - point[i]).powi(2)).sum::<f64>();
    let vertices = outline.vertices.iter().enumerate();
    let (k, &at) = vertices.min_by(|(_, a), (_, b)| away(a).total_cmp(&away(b)))?;
    let normal = vertex_normals(&outline.vertices, &outline.triangles)[k];
    let modes = outline.shapes.len() / outline.vertices.len();
    let shapes = &outline.shapes[k * modes..][..modes];
    let row = shapes.iter().map(|shape| dot(normal, *shape)).collect();
    Some(Aim::Surface { at, row })
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

//! Quantity and point of the audio signal.

use schemars::JsonSchema;
use serde::Serialize;

use crate::number::quantity;
use crate::pipeline::message::{Frame, Header, SurfaceMesh, vertex_normals};

/// Quantity of the audio signal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Quantity {
    /// Velocity.
    ///
    /// A laser vibrometer at_point at the point measures it.
    #[default]
    Velocity,
    /// Acceleration, which is proportional to the far-field sound pressure.
    ///
    /// The pressure far from a source much smaller than the wavelength is proportional to the acceleration of
    /// its surface: a proxy of the radiated sound, without room acoustics and directivity.
    Pressure,
}

/// Selection of the audio signal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Source {
    /// Quantity.
    pub quantity: Quantity,
    /// Point near the outline of the body, m from the ball's centre: the nearest vertex, along its outward normal. `None`:
    /// the probe of the scene, for a joint the contact centre in the sliding direction.
    pub point: Option<[f64; 3]>,
    /// Value at full scale of a sound file, m/s or m/s^2; without it the peak is near full scale.
    pub full_scale: Option<f64>,
}

/// The scene has no surface for a surface point.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the scene `{scene}` has no surface: its body is drawn only if `body_rate_khz` in its `[record]` table is \
     above 0 and its mode shapes are known on the surface; omit the point to listen to the probe"
)]
pub struct NoSurface {
    /// Name of the scene.
    pub scene: String,
}

/// Computes the audio signal from the samples of a run.
#[derive(Clone, Debug)]
pub struct SurfaceProbe {
    quantity: Quantity,
    /// Description of the point.
    point: String,
    /// Share of each modal velocity in the surface velocity, 1/sqrt(kg); `None` at the probe of the scene.
    shares: Option<Vec<f64>>,
    last: Option<f64>,
}

impl SurfaceProbe {
    /// Sets up the signal for a run.
    ///
    /// # Errors
    /// [`NoSurface`].
    pub fn new(source: Source, header: &Header) -> Result<Self, NoSurface> {
        let probe = Self::with_fallback(source, header);
        if source.point.is_some() && probe.shares.is_none() {
            let scene = header.scene.clone();
            return Err(NoSurface { scene });
        }
        Ok(probe)
    }

    /// As [`SurfaceProbe::new`], but with the probe of the scene if the run has no surface.
    pub fn with_fallback(source: Source, header: &Header) -> Self {
        let joint = header.joint();
        let surface = source
            .point
            .and_then(|point| nearest(&joint?.outline, point));
        let (point, shares) = match (surface, joint) {
            (Some((point, shares)), _) => (point, Some(shares)),
            (None, Some(_)) => ("the contact centre".to_owned(), None),
            (None, None) => ("the mass".to_owned(), None),
        };
        Self {
            quantity: source.quantity,
            point,
            shares,
            last: None,
        }
    }

    /// Description of the signal.
    pub fn description(&self) -> String {
        let point = &self.point;
        match self.quantity {
            Quantity::Velocity => format!("velocity of {point}"),
            Quantity::Pressure => {
                format!("acceleration of {point}, proportional to the far-field sound pressure")
            }
        }
    }

    /// Formats a value of the signal with its unit.
    pub fn format_value(&self, value: f32) -> String {
        let unit = match self.quantity {
            Quantity::Velocity => "m/s",
            Quantity::Pressure => "m/s^2",
        };
        quantity(value.into(), 3, unit)
    }

    /// The signal of a frame, one value per sample, m/s or m/s^2.
    pub fn samples<'a>(&'a mut self, frame: &'a Frame) -> impl Iterator<Item = f64> + 'a {
        (0..frame.len()).map(move |k| {
            let velocity = match &self.shares {
                None => frame.velocity[k],
                Some(shares) => {
                    let modes = frame.qdot[k * frame.modes..].iter();
                    shares.iter().zip(modes).map(|(r, v)| r * v).sum()
                }
            };
            match self.quantity {
                Quantity::Velocity => velocity,
                Quantity::Pressure => {
                    let before = self.last.replace(velocity).unwrap_or(velocity);
                    (velocity - before) / frame.dt
                }
            }
        })
    }
}

/// The vertex of a surface closest to a point, along its outward normal: its description, and the share of each modal
/// velocity; `None` without a surface.
fn nearest(outline: &SurfaceMesh, point: [f64; 3]) -> Option<(String, Vec<f64>)> {
    let away = |at: &[f64; 3]| (0..3).map(|i| (at[i] - point[i]).powi(2)).sum::<f64>();
    let vertices = outline.vertices.iter().enumerate();
    let (k, &at) = vertices.min_by(|(_, a), (_, b)| away(a).total_cmp(&away(b)))?;
    let normal = vertex_normals(&outline.vertices, &outline.triangles)[k];
    let modes = outline.shapes.len() / outline.vertices.len();
    let shapes = &outline.shapes[k * modes..][..modes];
    let row = shapes.iter().map(|shape| dot(normal, *shape)).collect();
    // Adding 0 removes the sign of a rounded negative zero.
    let [x, y, z] = at.map(|x| (1e4 * x).round() / 10.0 + 0.0);
    let place = format!("the surface at ({x}, {y}, {z}) mm along the outward normal");
    Some((place, row))
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

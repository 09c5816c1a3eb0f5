//! The modes of the ball on its beam.

use super::bodies::BallOnBeam;
use super::surface::SurfacePoint;
use super::{Elements, Families, FemError, Geometry, Harmonic, Material, MeridianMode, ModeKind};

/// The elastic modes of a free ball on a beam, normalised to unit modal mass (`Phi^T M Phi = I`), in
/// ascending order of frequency. The x mode of a bending pair precedes its y mode.
///
/// Signs: at the north pole of the ball a bending mode moves towards +x (or +y), an axial mode towards
/// +z; a torsion mode rotates the ball about +z.
#[derive(Clone, Debug)]
pub struct BodyModes {
    modes: Vec<BodyMode>,
    pub(super) fields: Vec<MeridianMode>,
    pub(super) mesh: BallOnBeam,
}

/// Label and frequency of one mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyMode {
    /// Family and orientation.
    pub kind: ModeKind,
    /// Number within its family, from 1.
    pub order: usize,
    /// Natural frequency, Hz.
    pub frequency_hz: f64,
    /// Index of the meridian field; the modes of a pair share one.
    pub(super) field: usize,
}

impl BodyMode {
    /// Label for display: "2nd bending x", "1st torsion", "1st axial".
    pub fn label(&self) -> String {
        let plane = match self.kind {
            ModeKind::BendingX => " x",
            ModeKind::BendingY => " y",
            ModeKind::Torsion | ModeKind::Axial => "",
        };
        self.family_label() + plane
    }

    /// The label without the plane, the same for both modes of a bending pair: "2nd bending".
    pub fn family_label(&self) -> String {
        let family = match self.kind {
            ModeKind::BendingX | ModeKind::BendingY => "bending",
            ModeKind::Torsion => "torsion",
            ModeKind::Axial => "axial",
        };
        let ending = match (self.order % 10, self.order % 100) {
            (_, 11..=13) => "th",
            (1, _) => "st",
            (2, _) => "nd",
            (3, _) => "rd",
            _ => "th",
        };
        format!("{}{ending} {family}", self.order)
    }
}

impl BodyModes {
    /// Meshes the body and computes the lowest modes of each family.
    ///
    /// [`Elements::default`] is suitable for a body of the paper's size.
    ///
    /// # Errors
    /// [`FemError`] for invalid dimensions or material constants, an unavailable order, a mesh that is
    /// too fine, or a failed eigenvalue computation.
    pub fn solve(
        geometry: &Geometry,
        material: &Material,
        elements: &Elements,
        families: &Families,
    ) -> Result<Self, FemError> {
        let mesh = BallOnBeam::mesh(geometry, elements)?;
        let mut found = Vec::new();
        for (harmonic, kinds, count) in [
            (Harmonic::Bending, PAIR, families.bending_pairs),
            (Harmonic::Torsion, &[ModeKind::Torsion], families.torsion),
            (Harmonic::Axial, &[ModeKind::Axial], families.axial),
        ] {
            let fields = mesh.section.modes(material, harmonic, count)?;
            let oriented = fields
                .into_iter()
                .map(|field| oriented(field, harmonic, &mesh));
            found.extend(
                (1..)
                    .zip(oriented)
                    .map(|(order, field)| (kinds, order, field)),
            );
        }
        found.sort_by(|(.., a), (.., b)| a.frequency_hz.total_cmp(&b.frequency_hz));
        let modes = found.iter().enumerate();
        let modes = modes.flat_map(|(index, (kinds, order, field))| {
            kinds.iter().map(move |&kind| BodyMode {
                kind,
                order: *order,
                frequency_hz: field.frequency_hz,
                field: index,
            })
        });
        Ok(Self {
            modes: modes.collect(),
            fields: found.into_iter().map(|(.., field)| field).collect(),
            mesh,
        })
    }

    /// The modes, in ascending order of frequency.
    pub fn modes(&self) -> &[BodyMode] {
        &self.modes
    }

    /// One mode of each family, in ascending order of frequency, of a bending pair the first: its index, and the name of
    /// the family (`2nd bending pair`, `1st torsion`).
    pub fn families(&self) -> Vec<(usize, String)> {
        let modes = self.modes.iter().enumerate();
        let name = |mode: &BodyMode| match mode.kind {
            ModeKind::BendingX => mode.family_label() + " pair",
            _ => mode.family_label(),
        };
        modes
            .filter(|(_, mode)| mode.kind != ModeKind::BendingY)
            .map(|(index, mode)| (index, name(mode)))
            .collect()
    }

    /// Mode shapes at a point of the ball's surface: the displacement `[x, y, z]` of each mode, in
    /// 1/sqrt(kg).
    ///
    /// `direction` points from the centre of the ball to the point; its length is irrelevant. The shape
    /// functions of the elements interpolate. `out` has one entry per mode.
    ///
    /// # Errors
    /// [`FemError::OutsideBall`] if the direction points into the beam or is zero.
    ///
    /// # Panics
    /// If the length of `out` differs from the number of [`BodyModes::modes`].
    pub fn shapes_at_ball(
        &self,
        direction: [f64; 3],
        out: &mut [[f64; 3]],
    ) -> Result<(), FemError> {
        let [x, y, z] = direction;
        let distance = x.hypot(y);
        let polar = distance.atan2(z);
        let outside = || FemError::OutsideBall {
            direction,
            polar_deg: polar.to_degrees(),
            limit_deg: self.mesh.ball.limit().to_degrees(),
        };
        if direction == [0.0; 3] {
            return Err(outside());
        }
        let BallOnBeam { section, ball, .. } = &self.mesh;
        let point = ball.locate(section, polar).ok_or_else(outside)?;
        // On the axis the displacement does not depend on the azimuth.
        let [cos, sin] = if distance > 0.0 {
            [x / distance, y / distance]
        } else {
            [1.0, 0.0]
        };
        self.shapes(&point, [cos, sin], out);
        Ok(())
    }

    /// All mode shapes at one point of a meridian, at the azimuth with the given cosine and sine.
    fn shapes(&self, point: &SurfacePoint<'_>, [cos, sin]: [f64; 2], out: &mut [[f64; 3]]) {
        assert_eq!(out.len(), self.modes.len(), "one shape vector per mode");
        let mut previous = None;
        for (mode, shape) in self.modes.iter().zip(out) {
            // The modes of a pair are adjacent.
            let amplitudes = match previous {
                Some((field, amplitudes)) if field == mode.field => amplitudes,
                _ => point.interpolate(&self.fields[mode.field].amplitudes),
            };
            previous = Some((mode.field, amplitudes));
            *shape = mode.kind.displacement(amplitudes, cos, sin);
        }
    }

    /// A triangle mesh of the whole surface for display, with the mode shapes at its vertices. It is the
    /// surface of the elements: at order 1 the ball is faceted.
    ///
    /// `along` is the number of segments from the free end to the north pole, two fifths of them on the
    /// ball; `round` is the number around the axis. The minimum is 4 and 3. The mesh has `along * round
    /// + 2` vertices; 40 and 18 give a smooth picture.
    pub fn outline(&self, along: usize, round: usize) -> SurfaceMesh {
        let [along, round] = [along.max(4), round.max(3)];
        let on_ball = (2 * along).div_ceil(5);
        let on_beam = along - on_ball;
        let count = self.modes.len();
        let mut builder = SurfaceMesh {
            vertices: Vec::with_capacity(along * round + 2),
            triangles: Vec::with_capacity(2 * along * round),
            shapes: Vec::with_capacity((along * round + 2) * count),
            modes: count,
        };
        let mut shapes = vec![[0.0; 3]; count];

        let BallOnBeam {
            section,
            end,
            side,
            ball,
        } = &self.mesh;
        for (mode, shape) in self.modes.iter().zip(&mut shapes) {
            let amplitudes = self.fields[mode.field].amplitudes[*end];
            *shape = mode.kind.displacement(amplitudes, 1.0, 0.0);
        }
        builder.push([0.0, 0.0, section.nodes[*end][1]], &shapes);

        let beam = (0..on_beam).map(|k| (side, k as f64 / on_beam as f64));
        let rings = beam.chain((0..on_ball).map(|k| (ball, 1.0 - k as f64 / on_ball as f64)));
        for (surface, fraction) in rings {
            let point = surface.at_fraction(section, fraction);
            let [r, z] = point.interpolate(&section.nodes);
            for j in 0..round {
                let (sin, cos) = (std::f64::consts::TAU * j as f64 / round as f64).sin_cos();
                self.shapes(&point, [cos, sin], &mut shapes);
                builder.push([r * cos, r * sin, z], &shapes);
            }
        }

        let pole = ball.at_fraction(section, 0.0);
        self.shapes(&pole, [1.0, 0.0], &mut shapes);
        builder.push([0.0, 0.0, pole.interpolate(&section.nodes)[1]], &shapes);
        builder.connect(along, round);
        builder
    }
}

/// A closed triangle mesh of the undeformed surface of the body, with mode shapes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceMesh {
    /// Positions, m: the centre of the free end, rings from there to the ball, the north pole.
    pub vertices: Vec<[f64; 3]>,
    /// Corners of the triangles, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Mode shapes, 1/sqrt(kg): vertex by vertex, all modes of one vertex together.
    pub shapes: Vec<[f64; 3]>,
    /// Number of modes.
    pub modes: usize,
}

impl SurfaceMesh {
    /// The shapes of all modes at one vertex.
    pub fn shapes_at(&self, vertex: usize) -> &[[f64; 3]] {
        &self.shapes[vertex * self.modes..][..self.modes]
    }

    /// The shapes mode by mode, all vertices of one mode together, in single precision.
    pub fn shapes_by_mode(&self) -> impl Iterator<Item = f32> + Clone {
        (0..self.modes)
            .flat_map(|mode| self.shapes.iter().skip(mode).step_by(self.modes))
            .flatten()
            .map(|&x| x as f32)
    }

    fn push(&mut self, position: [f64; 3], shapes: &[[f64; 3]]) {
        self.vertices.push(position);
        self.shapes.extend_from_slice(shapes);
    }

    /// Creates the triangles between the rings and at both ends.
    fn connect(&mut self, rings: usize, round: usize) {
        let vertex = |ring: usize, j: usize| (1 + ring * round + j % round) as u32;
        let pole = (1 + rings * round) as u32;
        for j in 0..round {
            self.triangles.push([0, vertex(0, j + 1), vertex(0, j)]);
            for ring in 0..rings - 1 {
                let [a, b] = [vertex(ring, j), vertex(ring, j + 1)];
                let [c, d] = [vertex(ring + 1, j + 1), vertex(ring + 1, j)];
                self.triangles.extend([[a, b, c], [a, c, d]]);
            }
            self.triangles
                .push([vertex(rings - 1, j), vertex(rings - 1, j + 1), pole]);
        }
    }
}

/// The modes of a bending pair.
const PAIR: &[ModeKind] = &[ModeKind::BendingX, ModeKind::BendingY];

/// Applies the sign convention of [`BodyModes`].
fn oriented(mut field: MeridianMode, harmonic: Harmonic, mesh: &BallOnBeam) -> MeridianMode {
    let ball = &mesh.ball.nodes;
    let indicator: f64 = match harmonic {
        Harmonic::Bending => field.amplitudes[ball[0]][0],
        Harmonic::Axial => field.amplitudes[ball[0]][2],
        // Torsion does not move the axis: use the mean rotation of the ball's surface.
        Harmonic::Torsion => ball.iter().map(|&node| field.amplitudes[node][1]).sum(),
    };
    if indicator < 0.0 {
        for amplitude in field.amplitudes.as_flattened_mut() {
            *amplitude = -*amplitude;
        }
    }
    field
}

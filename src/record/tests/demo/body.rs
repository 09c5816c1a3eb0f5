//! The synthetic body and its contact patch.

use std::f64::consts::TAU;

use super::{BALL, BEAM, PATCH, RINGS};
use crate::pipeline::message::{PatchGeometry, SurfaceMesh};

/// A surface of revolution, a sphere on a cylinder, with sinusoidal modes.
pub fn outline() -> SurfaceMesh {
    const AROUND: u32 = 32;
    let meeting = -(BALL * BALL - BEAM * BEAM).sqrt();
    let end = meeting - 0.2;
    let widest = (meeting / BALL).acos();
    let sphere = (1..=14).map(|k| f64::from(k) / 14.0 * widest);
    let mut profile: Vec<[f64; 2]> = sphere
        .map(|polar| [BALL * polar.sin(), BALL * polar.cos()])
        .collect();
    profile.extend((1..=30).map(|k| [BEAM, meeting - 0.2 * f64::from(k) / 30.0]));

    let mut outline = SurfaceMesh {
        vertices: vec![[0.0, 0.0, BALL]],
        ..SurfaceMesh::default()
    };
    for &[radius, z] in &profile {
        outline.vertices.extend((0..AROUND).map(|k| {
            let angle = TAU * f64::from(k) / f64::from(AROUND);
            [radius * angle.cos(), radius * angle.sin(), z]
        }));
    }
    outline.vertices.push([0.0, 0.0, end]);
    let last = outline.vertices.len() as u32 - 1;
    let rings = profile.len() as u32;
    for k in 0..AROUND {
        let next = (k + 1) % AROUND;
        outline.triangles.push([0, 1 + k, 1 + next]);
        for ring in 0..rings - 1 {
            let [a, b] = [k, next].map(|k| 1 + ring * AROUND + k);
            outline.triangles.push([a, a + AROUND, b]);
            outline.triangles.push([b, a + AROUND, b + AROUND]);
        }
        let low = 1 + (rings - 1) * AROUND;
        outline.triangles.push([low + k, last, low + next]);
    }
    outline.shapes = outline
        .vertices
        .iter()
        .flat_map(|&[x, y, z]| {
            let s = (z - end) / (BALL - end);
            let wave = |k: f64| 2.2 * (k * TAU / 2.0 * s).cos();
            let bend = |k: f64| wave(k) + 0.8 * (1.0 - 2.0 * s);
            let twist = |k: f64| [-y / BEAM * wave(k), x / BEAM * wave(k), 0.0];
            [
                [bend(2.0), 0.0, 0.0],
                [0.0, bend(2.0), 0.0],
                [bend(3.0), 0.0, 0.0],
                [0.0, bend(3.0), 0.0],
                twist(1.0),
                [bend(4.0), 0.0, 0.0],
                [0.0, bend(4.0), 0.0],
                [0.0, 0.0, wave(1.0)],
                twist(2.0),
                [bend(5.0), 0.0, 0.0],
                [0.0, bend(5.0), 0.0],
            ]
        })
        .collect();
    outline
}

/// Nodes in rings around the load direction, with Hertz pressure.
pub fn geometry(tilt: f64) -> PatchGeometry {
    let (sin, cos) = tilt.sin_cos();
    let turned = |[x, y, z]: [f64; 3]| [cos * x + sin * z, y, cos * z - sin * x];
    let mut geometry = PatchGeometry {
        direction: turned([0.0, 0.0, 1.0]),
        radius: PATCH,
        ..PatchGeometry::default()
    };
    let width = PATCH / (RINGS as f64 + 0.5);
    for ring in 0..=RINGS {
        let count = (6 * ring).max(1);
        for k in 0..count {
            let angle = TAU * k as f64 / count as f64;
            let r = ring as f64 * width;
            let polar = r / BALL;
            let normal = turned([
                polar.sin() * angle.cos(),
                polar.sin() * angle.sin(),
                polar.cos(),
            ]);
            geometry.positions.push(normal.map(|c| BALL * c));
            geometry
                .areas
                .push(std::f64::consts::PI * PATCH * PATCH / 91.0);
            geometry
                .pre_stress
                .push(24.87e6 * (1.0 - (r / PATCH).powi(2)).max(0.0).sqrt());
        }
    }
    geometry
}

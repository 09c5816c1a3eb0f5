//! Mode shapes on the surface.

use std::f64::consts::{FRAC_PI_2, PI};

use super::tests::*;
use super::*;

#[test]
fn surface_shapes_equal_the_nodal_values_at_the_nodes() {
    for body in bodies().chain([paper_body()]) {
        for &node in &body.mesh.ball.nodes {
            let [r, z] = body.mesh.section.nodes[node];
            let azimuth: f64 = 0.7;
            let (sin, cos) = azimuth.sin_cos();
            let found = shapes(body, [r * cos, r * sin, z]);
            let nodal: Vec<[f64; 3]> = body
                .modes()
                .iter()
                .map(|mode| {
                    let amplitudes = body.fields[mode.field].amplitudes[node];
                    mode.kind.displacement(amplitudes, cos, sin)
                })
                .collect();
            assert!(distance(&found, &nodal) < 1e-11);
        }
    }
}

#[test]
fn located_points_lie_in_the_requested_direction() {
    for body in bodies().chain([paper_body()]) {
        let (section, ball) = (&body.mesh.section, &body.mesh.ball);
        for k in 0..=500 {
            let polar = ball.limit() * f64::from(k) / 500.0;
            let point = ball.locate(section, polar).unwrap();
            let [r, z] = point.interpolate(&section.nodes);
            assert!((r.atan2(z) - polar).abs() < 1e-14, "{polar}");
        }
    }
}

#[test]
fn surface_shapes_are_continuous_along_the_meridian_and_at_the_pole() {
    let body = paper_body();
    let step = 1e-9;
    let ball = &body.mesh.ball.nodes;
    for &node in &ball[1..ball.len() - 1] {
        let [r, z] = body.mesh.section.nodes[node];
        let polar = r.atan2(z);
        let [before, after] = [polar - step, polar + step].map(|p| shapes(body, direction(p, 0.3)));
        // Mode shapes are of order 1 and vary over the ball: slopes are of order 10 per radian, larger
        // near the corner.
        assert!(distance(&before, &after) < 1e-6);
    }
    let pole = shapes(body, [0.0, 0.0, 1.0]);
    for azimuth in [0.0, 1.0, 4.0] {
        assert!(distance(&pole, &shapes(body, direction(1e-9, azimuth))) < 1e-7);
    }
}

#[test]
fn a_rotation_by_90_degrees_maps_x_modes_to_y_modes() {
    let body = paper_body();
    for (polar, azimuth) in [(0.1, 0.0), (0.9, 1.1), (2.2, -2.5)] {
        let here = shapes(body, direction(polar, azimuth));
        let there = shapes(body, direction(polar, azimuth + FRAC_PI_2));
        for (i, mode) in body.modes().iter().enumerate() {
            let image = match mode.kind {
                ModeKind::BendingX => there[i + 1],
                ModeKind::BendingY => continue,
                ModeKind::Torsion | ModeKind::Axial => there[i],
            };
            let [x, y, z] = here[i];
            assert!(distance(&[image], &[[-y, x, z]]) < 1e-13);
        }
    }
}

#[test]
fn surface_shapes_converge_and_keep_their_sign() {
    let fine = body(LengthReading::ToSphere, &refined(4.0));
    for (elements, tolerance) in [
        (elements(1e-3, 1), 1e-2),
        (elements(4e-3, 2), 1e-3),
        (elements(8e-3, 3), 1e-4),
        (refined(1.0), 1e-4),
        (elements(40e-3, 8), 1e-4),
    ] {
        let coarse = body(LengthReading::ToSphere, &elements);
        for polar in [0.0, 0.11, 0.6, 1.4, 2.0] {
            let [a, b] = [&coarse, &fine].map(|body| shapes(body, direction(polar, 0.4)));
            let size = distance(&b, &vec![[0.0; 3]; b.len()]);
            let error = distance(&a, &b) / size;
            assert!(error < tolerance, "{elements:?} at {polar} rad: {error:e}");
        }
    }
}

#[test]
fn signs_follow_the_convention() {
    let body = paper_body();
    let pole = shapes(body, [0.0, 0.0, 1.0]);
    let side = shapes(body, [1.0, 0.0, 0.0]);
    for (i, mode) in body.modes().iter().enumerate() {
        let indicator = match mode.kind {
            ModeKind::BendingX => pole[i][0],
            ModeKind::BendingY => pole[i][1],
            ModeKind::Axial => pole[i][2],
            ModeKind::Torsion => side[i][1],
        };
        assert!(indicator > 0.0, "{}", mode.label());
    }
}

#[test]
fn the_length_of_a_direction_does_not_matter() {
    let body = paper_body();
    let [x, y, z] = direction(0.8, 2.0);
    let scaled = [1e-3 * x, 1e-3 * y, 1e-3 * z];
    assert!(distance(&shapes(body, [x, y, z]), &shapes(body, scaled)) < 1e-13);
}

#[test]
fn directions_into_the_beam_and_invalid_ones_are_rejected() {
    let body = paper_body();
    let mut out = vec![[0.0; 3]; body.modes().len()];
    let corner = PI - (10.0_f64 / 15.875).asin();
    assert!(
        body.shapes_at_ball(direction(corner, 0.2), &mut out)
            .is_ok()
    );
    for bad in [
        direction(corner + 1e-6, 0.2),
        [0.0, 0.0, -1.0],
        [0.0; 3],
        [f64::NAN, 0.0, 1.0],
    ] {
        let error = body.shapes_at_ball(bad, &mut out).unwrap_err();
        let limit = format!("to {:.3} deg", corner.to_degrees());
        assert!(error.to_string().contains(&limit), "{error}");
    }
}

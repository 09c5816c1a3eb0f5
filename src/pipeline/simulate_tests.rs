//! Runs of a joint.

use super::*;

/// With friction that has states, also across steps and ramps of the loading, the energy audit closes, and the motion
/// does not depend on the method.
#[test]
fn runs_with_states_of_friction_close_the_energy_audit() {
    for law in [
        "law = \"lugre\"\nmu_s = 0.55\nmu_d = 0.25\nbristle_stiffness_per_m = 1e6\n\
         bristle_damping_s_per_m = 1\n",
        "law = \"rate-and-state\"\nmu_0 = 0.5\ndirect_effect = 0.01\nevolution_effect = 0.06\n\
         reference_speed_m_per_s = 0.016\nslip_distance_um = 0.5\n",
    ] {
        let run = |method: &str| {
            let text = format!(
                "[load]\nload_n = 150\n\
                 tilt_steps = [{{ time_ms = 0, tilt_deg = 2 }}, {{ time_ms = 2, tilt_deg = 5 }}]\n\
                 [contact]\nnodes = 16\n[start]\nkick_mm_per_s = 2\n[record]\nenergy_rate_khz = 100\n\
                 [time]\nduration_ms = 4\ntolerance = 1e-7\nmethod = \"{method}\"\n[friction]\n{law}"
            );
            let scene = Scene::parse("mine.toml", text).unwrap();
            let mut simulation = Simulation::new(&scene).unwrap();
            let mut frames = Vec::new();
            while let Some(frame) = simulation.next_frame().unwrap() {
                frames.push(frame);
            }
            frames
        };
        let frames = run("lawson54");
        let energies = || frames.iter().flat_map(|frame| &frame.energy);
        let largest = energies().map(|e| e.total).fold(0.0, f64::max);
        let residual = energies().map(|e| e.residual.abs()).fold(0.0, f64::max);
        assert!(
            largest > 0.0 && residual < 1e-5 * largest,
            "{residual:e} of {largest:e}"
        );
        let displacement = |frames: &[Frame]| -> Vec<f64> {
            frames
                .iter()
                .flat_map(|frame| frame.displacement.clone())
                .collect()
        };
        let [one, other] = [&frames, &run("tsit5")].map(|frames| displacement(frames));
        let size = one.iter().fold(0.0_f64, |m, u| m.max(u.abs()));
        let pairs = one.iter().zip(&other);
        let error = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(error < 1e-4 * size, "{error:e} of {size:e}");
    }
}

//! Non-finite values: detected in one place and reported in full; the recording stays readable.

use std::sync::Arc;

use squeakscope::dynamics::{Accuracy, DynamicsError, Integrator, Method, MethodName, System};
use squeakscope::joint::{BallJoint, Friction, FrictionLaw, Joint, Ratio, Stribeck};

use super::{joint, scene};

/// Eq. (5), but NaN above a sliding speed.
#[derive(Debug)]
struct NanAbove {
    law: Stribeck,
    limit: f64,
}

impl FrictionLaw for NanAbove {
    fn ratio(&self, speed: f64) -> Ratio {
        let ratio = self.law.ratio(speed);
        Ratio {
            value: if speed > self.limit {
                f64::NAN
            } else {
                ratio.value
            },
            ..ratio
        }
    }

    fn stick_speed(&self) -> f64 {
        self.law.stick_speed()
    }
}

/// A joint whose friction becomes NaN when a node slides 2 mm/s faster than in steady sliding, with its
/// initial state. The squeak grows until then.
fn joint_that_fails() -> (Joint, Vec<f64>) {
    let scene = scene(&[]);
    let ball = BallJoint::new(&scene.joint().unwrap().spec).unwrap();
    let model = ball.model(0.05).unwrap();
    let speed = |v: &[f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let fastest = model.sliding_velocity.iter().map(speed).fold(0.0, f64::max);
    let Friction::Stribeck { law, radial } = model.friction else {
        panic!("{:?}", model.friction)
    };
    let limit = fastest + 2e-3;
    let joint = Joint::with_friction(&model, Arc::new(NanAbove { law, limit }), radial);
    let start = squeakscope::pipeline::initial_state(&scene, joint.modes());
    (joint, start)
}

fn methods() -> Vec<Method> {
    let accuracy = Accuracy::relative(1e-6);
    let max_step = 20e-6;
    vec![
        MethodName::Lawson54.with(accuracy, max_step),
        MethodName::Lawson853.with(accuracy, max_step),
        MethodName::Tsit5.with(accuracy, max_step),
        MethodName::Dop853.with(accuracy, max_step),
        MethodName::Rodas5P.with(accuracy, max_step),
        MethodName::Auto.with(accuracy, max_step),
        MethodName::Rk4.with(Accuracy::relative(1e-6), 1e-6),
    ]
}

#[test]
fn a_nan_is_reported_with_time_node_mode_and_last_finite_state() {
    let (joint, start) = joint_that_fails();
    let m = joint.modes();
    for method in methods() {
        let mut integrator = Integrator::new(method, &joint).unwrap();
        integrator.start(0.0, &start).unwrap();
        let error = integrator.integrate_to(50e-3).unwrap_err();
        let message = error.to_string();
        let DynamicsError::NonFinite {
            time,
            last_good_time,
            component,
            modes,
            part,
            last_good_state,
        } = error
        else {
            panic!("{method:?}: {error:?}")
        };
        assert!(time > last_good_time && last_good_time > 0.0, "{method:?}");
        assert!(component < 2 * m && modes == m);
        assert_eq!(last_good_state, integrator.state());
        assert_eq!(last_good_time, integrator.time());
        assert!(last_good_state.iter().all(|x| x.is_finite()));
        // The reported node is the one with the highest sliding speed.
        let (q, v) = last_good_state.split_at(m);
        let speed = |k: &usize| joint.node_action(*k, q, v, &[]).speed;
        let nodes = 0..joint.contact_nodes();
        let fastest = nodes.max_by(|a, b| speed(a).total_cmp(&speed(b))).unwrap();
        let part = part.unwrap_or_else(|| panic!("{method:?}: no node reported: {message}"));
        if method.name != MethodName::Rk4 {
            assert_eq!(
                part,
                format!("contact node {fastest}"),
                "{method:?}: {message}"
            );
        }
        for word in [&part, "q", "t = ", "last finite state at t = "] {
            assert!(message.contains(word), "{message}");
        }
    }
}

/// A non-finite initial state, and one that overflows.
#[test]
fn non_finite_initial_states() {
    let joint = joint(&scene(&[]));
    let m = joint.modes();
    for (value, index) in [
        (f64::NAN, 3),
        (f64::INFINITY, m + 2),
        (-f64::INFINITY, 0),
        (1e308, 5),
    ] {
        for method in methods() {
            let mut start = vec![0.0; 2 * m];
            start[index] = value;
            let mut integrator = Integrator::new(method, &joint).unwrap();
            let error = integrator.start(0.0, &start).unwrap_err();
            let DynamicsError::NonFinite { component, .. } = error else {
                panic!("{method:?}: {error:?}")
            };
            if value.abs() != 1e308 {
                assert_eq!(component, index, "{method:?}: {error}");
            }
        }
    }
}

/// A run that fails leaves a readable recording with all frames before the failure.
#[cfg(feature = "record")]
#[test]
fn the_recording_of_a_failed_run_is_readable() {
    use squeakscope::pipeline::message::{Frame, Header};
    use squeakscope::pipeline::{Monitor, PipelineError, Simulation, Source, drive};
    use squeakscope::record::{Output, RerunSink, read_series};

    /// Frames of a simulation, then an error of the integrator.
    struct Failing {
        simulation: Simulation,
        remaining: usize,
    }

    impl Source for Failing {
        fn header(&self, command: &str) -> Header {
            self.simulation.header(command)
        }
        fn next_frame(&mut self) -> Result<Option<Frame>, PipelineError> {
            if self.remaining > 0 {
                self.remaining -= 1;
                return self.simulation.next_frame();
            }
            let (joint, start) = joint_that_fails();
            let mut integrator = Integrator::new(methods()[0], &joint)?;
            integrator.start(0.0, &start)?;
            integrator.integrate_to(50e-3)?;
            Ok(None)
        }
        fn is_finished(&self) -> bool {
            false
        }
    }

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.rrd");
    let scene = scene(&[("start.kick_mm_per_s", "1")]);
    let output = Output {
        save: Some(path.clone()),
        ..Output::default()
    };
    let mut sink = RerunSink::new(&output, scene.record).unwrap();
    let source = Failing {
        simulation: Simulation::new(&scene).unwrap(),
        remaining: 5,
    };
    let fault = drive(source, "test", &mut sink, Monitor::default()).unwrap_err();
    let PipelineError::Dynamics(DynamicsError::NonFinite { .. }) = &fault else {
        panic!("{fault:?}")
    };
    drop(sink);
    // An incomplete recording never gets the final name.
    assert!(!path.exists());
    let part = folder.path().join("run.rrd.part");
    let series = read_series(&part, Some("probe/velocity")).unwrap();
    assert_eq!(series.values.len(), 5 * scene.frame_samples);
    assert!(series.values.iter().all(|v| v.is_finite()));
}

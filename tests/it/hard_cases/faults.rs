//! Numbers that are not finite: caught in one place, told in full, and a recording that still opens.

use std::sync::Arc;

use squeakscope::dynamics::{Accuracy, DynamicsError, Integrator, Method, System};
use squeakscope::joint::{BallJoint, Friction, FrictionLaw, Joint, Ratio, Stribeck};

use super::{joint, scene};

/// Eq. (5), but no number beyond a slip speed.
#[derive(Debug)]
struct BreaksAbove {
    law: Stribeck,
    limit: f64,
}

impl FrictionLaw for BreaksAbove {
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

/// A joint whose friction breaks once a node slips 2 mm/s faster than in steady sliding, and where it
/// starts: the squeak grows until then.
fn fragile() -> (Joint, Vec<f64>) {
    let scene = scene(&[]);
    let ball = BallJoint::new(&scene.joint().unwrap().spec).unwrap();
    let model = ball.model(0.05).unwrap();
    let speed = |v: &[f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let fastest = model.sliding_velocity.iter().map(speed).fold(0.0, f64::max);
    let Friction::Stribeck { law, radial } = model.friction else {
        panic!("{:?}", model.friction)
    };
    let limit = fastest + 2e-3;
    let joint = Joint::with_friction(&model, Arc::new(BreaksAbove { law, limit }), radial);
    let start = squeakscope::pipeline::initial_state(&scene, joint.modes());
    (joint, start)
}

fn methods() -> Vec<Method> {
    let accuracy = Accuracy::relative(1e-6);
    let max_step = 20e-6;
    vec![
        Method::Lawson54 { accuracy, max_step },
        Method::Lawson853 { accuracy, max_step },
        Method::Tsit54 { accuracy, max_step },
        Method::Dop853 { accuracy, max_step },
        Method::Rodas5p { accuracy, max_step },
        Method::Auto { accuracy, max_step },
        Method::Rk4 { step: 1e-6 },
    ]
}

#[test]
fn a_nan_is_told_with_time_node_mode_and_last_good_state() {
    let (joint, start) = fragile();
    let m = joint.modes();
    for method in methods() {
        let mut integrator = Integrator::new(method, &joint).unwrap();
        integrator.start(&joint, 0.0, &start).unwrap();
        let error = integrator.land(&joint, 50e-3).unwrap_err();
        let said = error.to_string();
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
        // The node named is the one that slips fastest.
        let (q, v) = last_good_state.split_at(m);
        let speed = |k: &usize| joint.node_action(*k, q, v).speed;
        let nodes = 0..joint.contact_nodes();
        let fastest = nodes.max_by(|a, b| speed(a).total_cmp(&speed(b))).unwrap();
        let part = part.unwrap_or_else(|| panic!("{method:?} names no node: {said}"));
        if !matches!(method, Method::Rk4 { .. }) {
            assert_eq!(
                part,
                format!("contact node {fastest}"),
                "{method:?}: {said}"
            );
        }
        for word in [&part, "q", "t = ", "was good up to t = "] {
            assert!(said.contains(word), "{said}");
        }
    }
}

/// A start that is no number, and one that overflows.
#[test]
fn starts_that_are_not_finite() {
    let joint = joint(&scene(&[]));
    let m = joint.modes();
    for (spice, place) in [
        (f64::NAN, 3),
        (f64::INFINITY, m + 2),
        (-f64::INFINITY, 0),
        (1e308, 5),
    ] {
        for method in methods() {
            let mut start = vec![0.0; 2 * m];
            start[place] = spice;
            let mut integrator = Integrator::new(method, &joint).unwrap();
            let error = integrator.start(&joint, 0.0, &start).unwrap_err();
            let DynamicsError::NonFinite { component, .. } = error else {
                panic!("{method:?}: {error:?}")
            };
            if spice.abs() != 1e308 {
                assert_eq!(component, place, "{method:?}: {error}");
            }
        }
    }
}

/// A run that ends in a fault leaves a recording with all that came before, and it opens.
#[cfg(feature = "record")]
#[test]
fn the_recording_of_a_run_that_fails_still_opens() {
    use squeakscope::pipeline::message::{Frame, Header};
    use squeakscope::pipeline::{Monitor, PipelineError, Simulation, Source, drive};
    use squeakscope::record::{Output, RerunSink, read_series};
    use squeakscope::scene::AnalysisSpec;

    /// Frames of a simulation, then a fault of the integrator.
    struct Failing {
        simulation: Simulation,
        left: usize,
    }

    impl Source for Failing {
        fn header(&self, command: &str) -> Header {
            self.simulation.header(command)
        }
        fn analysis(&self) -> &AnalysisSpec {
            self.simulation.analysis()
        }
        fn next_frame(&mut self) -> Result<Option<Frame>, PipelineError> {
            if self.left > 0 {
                self.left -= 1;
                return self.simulation.next_frame();
            }
            let (joint, start) = fragile();
            let mut integrator = Integrator::new(methods()[0], &joint)?;
            integrator.start(&joint, 0.0, &start)?;
            integrator.land(&joint, 50e-3)?;
            Ok(None)
        }
        fn is_over(&self) -> bool {
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
        left: 5,
    };
    let fault = drive(source, "test", &mut sink, Monitor::default()).unwrap_err();
    let PipelineError::Dynamics(DynamicsError::NonFinite { .. }) = &fault else {
        panic!("{fault:?}")
    };
    drop(sink);
    // It never takes the name of a whole one.
    assert!(!path.exists());
    let part = folder.path().join("run.rrd.part");
    let series = read_series(&part, Some("probe/velocity")).unwrap();
    assert_eq!(series.values.len(), 5 * scene.frame_samples);
    assert!(series.values.iter().all(|v| v.is_finite()));
}

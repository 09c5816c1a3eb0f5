//! The branch diagram of the present scene, and an event for each bifurcation that the tilt passes.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;

use super::lock;
use super::panel::StatusStore;
use crate::pipeline::message::Record;
use crate::scene::Scene;
use crate::study::Stopped;
use crate::study::branch::{
    DiagramBifurcation, DiagramBifurcationKind, TiltDiagram, shipped_diagram, tilt_diagram,
};

/// The store of the diagram of the present scene.
#[derive(Default)]
pub(super) struct DiagramStore(Mutex<Present>);

#[derive(Default)]
struct Present {
    scene: Option<Scene>,
    /// Number of diagrams so far.
    count: u64,
    /// The diagram, or the part of it that is computed so far.
    shown: Option<Arc<TiltDiagram>>,
    /// What is computed at present, or why the scene has no diagram; `None` for a complete one.
    note: Option<String>,
    /// The computation of a diagram on its own thread, and the flag that stops it.
    computation: Option<(Arc<AtomicBool>, JoinHandle<()>)>,
}

impl DiagramStore {
    /// Shows the diagram of a scene: the stored one at once, or else one over the given interval of the tilt (degrees),
    /// which is computed in the background and grows. Without an interval, or if a rotation moves the patch, there is no
    /// diagram. The computation of another scene is cancelled; a restart of the same scene keeps its diagram.
    pub fn show(
        self: &Arc<Self>,
        scene: &Scene,
        interval: Option<[f64; 2]>,
        store: &Arc<StatusStore>,
    ) {
        let present = &mut *lock(&self.0);
        if present.scene.as_ref() == Some(scene) {
            return;
        }
        if let Some((stop, _)) = &present.computation {
            stop.store(true, Ordering::Relaxed);
        }
        present.scene = Some(scene.clone());
        let shipped = shipped_diagram(scene);
        present.set(shipped.and_then(|text| serde_json::from_str(text).ok()));
        // A rotation that moves the patch changes the tilt itself.
        let turns = scene.joint().is_ok_and(|joint| joint.patch_moves());
        present.note = match interval.filter(|[low, high]| low < high) {
            _ if present.shown.is_some() => None,
            None => Some("no branch diagram: this scene has no tilt to change".to_owned()),
            Some(_) if turns => Some(
                "no branch diagram: the rotation of this scene changes the tilt itself".to_owned(),
            ),
            Some(interval) => {
                let (before, stop) = (present.computation.take(), Arc::<AtomicBool>::default());
                let (diagrams, scene, store) = (Arc::clone(self), scene.clone(), Arc::clone(store));
                let stopped = Arc::clone(&stop);
                let thread = std::thread::Builder::new()
                    .name("diagram".to_owned())
                    .spawn(move || {
                        // A panic there was printed; it does not concern this scene.
                        let _ = before.map(|(_, thread)| thread.join());
                        diagrams.compute(&scene, interval, &stopped, &store);
                    });
                // Without a thread the run continues without a diagram.
                present.computation = thread.ok().map(|thread| (stop, thread));
                Some(computing("steady sliding"))
            }
        };
    }

    /// Computes a diagram on this thread: the run needs the other cores.
    fn compute(&self, scene: &Scene, interval: [f64; 2], stop: &AtomicBool, store: &StatusStore) {
        let mut progress = |share: f64, task: &str| {
            if stop.load(Ordering::Relaxed) {
                return Err(Stopped);
            }
            let note = computing(&format!("{task}, {:.0} %", 100.0 * share));
            self.change(scene, |present| present.note = Some(note));
            Ok(())
        };
        let found = tilt_diagram(scene, interval, &mut progress, |diagram| {
            self.change(scene, |present| present.set(Some(diagram.clone())));
        });
        if stop.load(Ordering::Relaxed) {
            return;
        }
        let time = store.read().time_s;
        self.change(scene, |present| match found {
            Ok(diagram) => {
                present.set(Some(diagram));
                present.note = None;
                store.log(time, "the branch diagram is complete");
            }
            Err(fault) => {
                let note = format!("no branch diagram: {fault}");
                store.log(time, &note);
                present.note = Some(note);
            }
        });
    }

    /// Changes the diagram of a scene, unless another scene has taken its place.
    fn change(&self, scene: &Scene, change: impl FnOnce(&mut Present)) {
        let mut present = lock(&self.0);
        if present.scene.as_ref() == Some(scene) {
            change(&mut present);
        }
    }

    /// Cancels a computation and waits for its end.
    pub fn cancel(&self) {
        let computation = lock(&self.0).computation.take();
        if let Some((stop, thread)) = computation {
            stop.store(true, Ordering::Relaxed);
            // A panic there was printed; the session has its own result.
            let _ = thread.join();
        }
    }

    /// What is computed at present, or why the scene has no diagram; `None` for a complete one.
    pub fn note(&self) -> Option<String> {
        lock(&self.0).note.clone()
    }

    /// The number of the diagram, from 1; a part that is new has another number.
    pub fn number(&self) -> Option<u64> {
        let present = lock(&self.0);
        present.shown.is_some().then_some(present.count)
    }

    /// The diagram, as far as it is computed.
    pub fn diagram(&self) -> Option<Arc<TiltDiagram>> {
        lock(&self.0).shown.clone()
    }
}

/// A note on a computation.
fn computing(what: &str) -> String {
    format!("the branch diagram is being computed: {what}")
}

impl Present {
    fn set(&mut self, diagram: Option<TiltDiagram>) {
        self.count += u64::from(diagram.is_some());
        self.shown = diagram.map(Arc::new);
    }
}

/// An event for each bifurcation of the diagram that the tilt passes.
#[derive(Default)]
pub(super) struct BifurcationEvents {
    diagrams: Arc<DiagramStore>,
    /// Tilt of the last frame, degrees.
    tilt_deg: Option<f64>,
    /// Base frequencies of the motion, Hz: the branch that the run is on has one of them.
    base_hz: Vec<f64>,
}

impl BifurcationEvents {
    /// No events yet.
    pub fn new(diagrams: Arc<DiagramStore>) -> Self {
        Self {
            diagrams,
            ..Self::default()
        }
    }

    /// Whether a bifurcation concerns the motion of the run: its frequency is a base frequency to 2 %. Bifurcations of steady
    /// sliding concern a joint without spectral lines.
    fn concerns(&self, found: &DiagramBifurcation) -> bool {
        match found.kind {
            DiagramBifurcationKind::Steady(_) => self.base_hz.is_empty(),
            DiagramBifurcationKind::Orbit(_) => {
                let mut bases = self.base_hz.iter();
                bases.any(|hz| (hz / found.frequency_hz - 1.0).abs() < 0.02)
            }
        }
    }

    /// The events after a record.
    pub fn after(&mut self, record: &Record) -> Vec<Record> {
        match record {
            Record::Samples(frame) => return self.events(frame.tilt.to_degrees(), frame.t0),
            Record::Spectrum { peaks, .. } => {
                let bases = peaks
                    .iter()
                    .filter(|line| ["f1", "f2"].contains(&&*line.label));
                self.base_hz = bases.map(|line| line.frequency).collect();
            }
            _ => {}
        }
        Vec::new()
    }

    /// The events of a change of the tilt to a value (degrees) at a time (s).
    fn events(&mut self, tilt_deg: f64, time: f64) -> Vec<Record> {
        let Some(before) = self.tilt_deg.replace(tilt_deg).filter(|t| *t != tilt_deg) else {
            return Vec::new();
        };
        let diagram = self.diagrams.diagram();
        let passed = diagram.iter().flat_map(|it| it.passed(before, tilt_deg));
        let passed = passed.filter(|found| self.concerns(found));
        let way = if tilt_deg > before { "rises" } else { "falls" };
        let events = passed.map(|found| Record::Event {
            time,
            text: format!(
                "the tilt {way} through {:.3} degrees. {}",
                found.tilt_deg, found.text
            ),
        });
        events.collect()
    }
}

#[cfg(test)]
mod tests {
    use std::time::{Duration, Instant};

    use super::*;
    use crate::pipeline::message::{Frame, SpectralLine};
    use crate::scene::Parameter;

    fn shown(scene: &Scene, interval: [f64; 2]) -> Arc<DiagramStore> {
        let diagrams = Arc::<DiagramStore>::default();
        diagrams.show(scene, Some(interval), &Arc::default());
        diagrams
    }

    fn own(name: &str) -> Scene {
        let nodes = Parameter::named("contact.nodes").unwrap();
        let scene = Scene::load(name).unwrap();
        scene.with_values(&[(nodes, 28.0)]).unwrap()
    }

    #[test]
    fn the_tilt_of_a_run_passes_the_birth_of_the_torus_in_both_directions() {
        let scene = Scene::load("torus-birth").unwrap();
        let mut passed = BifurcationEvents::new(shown(&scene, [0.0, 10.0]));
        let tilts = [0.1, 0.2, 0.34, 0.35, 0.35, 0.5, 0.3, 0.4, 2.5];
        let tone = |frequency| Record::Spectrum {
            time: 0.0,
            bin: 1.0,
            amplitude: Vec::new(),
            peaks: vec![SpectralLine {
                frequency,
                amplitude: 1e-3,
                label: "f1".to_owned(),
            }],
        };
        let mut events = passed.after(&tone(4104.0));
        for (k, tilt) in tilts.into_iter().enumerate() {
            if tilt == 0.4 {
                // The run is on another branch, on which nothing happens here.
                events.extend(passed.after(&tone(12_430.0)));
            }
            let frame = Frame {
                t0: k as f64,
                tilt: f64::to_radians(tilt),
                ..Frame::default()
            };
            events.extend(passed.after(&Record::Samples(Arc::new(frame))));
        }
        let events = events.iter().filter_map(|record| match record {
            Record::Event { time, text } => Some((*time, text.as_str())),
            _ => None,
        });
        let events: Vec<_> = events.collect();
        let [(up, rises), (down, falls)] = events[..] else {
            panic!("{events:?}");
        };
        assert_eq!((up, down), (3.0, 6.0));
        assert!(rises.starts_with("the tilt rises through 0.347 degrees. "));
        assert!(rises.contains("second tone"), "{rises}");
        assert!(falls.starts_with("the tilt falls through 0.347 degrees. "));
    }

    #[test]
    fn a_scene_that_ships_has_its_stored_diagram_at_any_tilt_and_another_joint_has_none() {
        let scene = Scene::load("doubled-torus-3deg").unwrap();
        for tilt in [0.0, 3.0, 7.5] {
            let diagrams = shown(&scene.clone().with_tilt(tilt).unwrap(), [0.0, 10.0]);
            let diagram = diagrams.diagram().unwrap();
            assert!(!diagram.branches.is_empty());
        }
        let own = own("doubled-torus-3deg");
        assert_eq!(shipped_diagram(&own), None);
        let small = Scene::load("mass-on-belt").unwrap();
        assert_eq!(shipped_diagram(&small), None);
    }

    #[test]
    fn a_scene_without_a_diagram_says_why() {
        let note = |name: &str, interval| {
            let diagrams = Arc::<DiagramStore>::default();
            diagrams.show(&Scene::load(name).unwrap(), interval, &Arc::default());
            diagrams.note()
        };
        assert_eq!(note("periodic-2deg", Some([0.0, 10.0])), None);
        let turning = note("articulation", Some([0.0, 10.0])).unwrap();
        assert!(turning.contains("changes the tilt itself"), "{turning}");
        let small = note("mass-on-belt", None).unwrap();
        assert!(small.contains("has no tilt"), "{small}");
    }

    #[test]
    fn the_diagram_of_an_own_scene_grows_and_another_scene_cancels_it() {
        let squeaking = own("doubled-torus-3deg");
        let silent = own("printed-friction");
        let diagrams = shown(&squeaking, [0.0, 8.0]);
        assert_eq!((diagrams.diagram(), diagrams.number()), (None, None));
        let began = Instant::now();
        diagrams.show(&silent, Some([0.0, 1.0]), &Arc::default());
        let note = diagrams.note().unwrap();
        assert!(
            note.starts_with("the branch diagram is being computed"),
            "{note}"
        );
        while diagrams.note().is_some() {
            assert!(began.elapsed() < Duration::from_secs(60), "no diagram");
            std::thread::sleep(Duration::from_millis(5));
        }
        // Steady sliding, settled responses, and the whole.
        assert_eq!(diagrams.number(), Some(3));
        let diagram = diagrams.diagram().unwrap();
        let modes = &diagram.unstable_modes[..];
        assert_eq!((modes.len(), modes[0].count), (1, 0), "{modes:?}");
        assert_eq!(diagram.responses.len(), 3);
        diagrams.show(&squeaking, Some([0.0, 8.0]), &Arc::default());
        diagrams.cancel();
        assert_eq!(diagrams.diagram(), None);
    }
}

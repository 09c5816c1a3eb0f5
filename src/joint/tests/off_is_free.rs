//! Disabled effects have no cost: comparison of each kernel in each setting with a loop written by hand for this
//! setting only. Both use the same blocks of eight nodes, the same vectors and the same order, so that their results
//! are bit-identical; the difference in cost is that of the disabled effects.
//!
//! Callgrind counts the instructions reproducibly. It does not support AVX-512, so that the counts are for four
//! nodes per vector. `benches/off_is_free.sh` writes the table into the guide.

mod derivative;
mod force;

use std::hint::black_box;
use std::process::Command;
use std::time::Instant;

use pulp::Arch;
use pulp::bytemuck::cast_slice_mut;

use self::derivative::*;
use self::force::*;
use super::*;
use crate::joint::contact_force::PAPER_MODES;
use crate::joint::differentiable::Parts;
use crate::joint::simd::{LANES, machines};
use crate::joint::system::ActiveLaw;

/// Number of nodes, with padding in the last block and a remaining vector after the pairs.
const NODES: usize = 100;

const LEVEL: Constant = Constant {
    mu: 0.4,
    creep: 1000.0,
};
const FALLING: Stribeck = Stribeck {
    mu_s: 0.55,
    mu_d: 0.25,
    creep: 1000.0,
    stribeck: 10.0,
};

/// A joint in one setting with the arguments of its kernels.
struct Setup {
    setting: &'static str,
    joint: Joint,
    z: Vec<f64>,
    /// Two adjacent tangent vectors.
    vectors: Vec<f64>,
    /// The record of the state.
    record: Vec<f64>,
}

impl Setup {
    fn new(setting: &'static str, friction: Friction, unilateral: bool, machine: Arch) -> Self {
        let mut joint = Joint::new(&Model {
            unilateral,
            ..scattered(NODES, PAPER_MODES, friction)
        });
        joint.arch = machine;
        let z = state(&joint, 17);
        let mut record = vec![0.0; joint.record_len()];
        joint.force_recorded(None, 0.0, &z, &mut [0.0; PAPER_MODES], &mut record);
        Self {
            setting,
            joint,
            z,
            vectors: (0..6 * PAPER_MODES)
                .map(|i| (1.3 * i as f64).cos())
                .collect(),
            record,
        }
    }

    fn state(&self) -> State<'_> {
        let (q, v) = self.z.split_at(PAPER_MODES);
        State { q, v }
    }

    /// The hand-written force kernel.
    fn pass<const M: usize, const F: usize>(&self, setting: impl Setting<M, F>, out: &mut [f64]) {
        self.joint.arch.dispatch(Pass {
            nodes: &self.joint.nodes,
            steady: &self.joint.equilibrium().force,
            setting,
            out: &mut out[..PAPER_MODES],
        });
    }

    fn kept<'a>(&self, record: &'a mut [f64]) -> &'a mut [[f64; LANES]] {
        self.joint.parts_of(record).kept
    }

    /// Arguments of a hand-written assembly.
    fn matrix<'a>(&'a self, record: &'a mut [f64]) -> Matrix<'a> {
        let Parts { kept, sums, matrix } = self.joint.parts_of(record);
        Matrix {
            nodes: &self.joint.nodes,
            kept,
            sums,
            matrix,
        }
    }

    /// Arguments of a hand-written matrix-free product.
    fn sweep<'a>(&'a self, out: &'a mut [f64], record: &'a mut [f64]) -> Sweep<'a> {
        Sweep {
            nodes: &self.joint.nodes,
            kept: self.kept(record),
            vectors: &self.vectors,
            // The number of vectors is known at run time only, also by hand.
            width: black_box(3),
            out,
        }
    }
}

/// Writes the force (or two adjacent ones) and the record.
type Kernel = fn(&Setup, &mut [f64], &mut [f64]);

/// One kernel in one setting.
struct Case<'a> {
    kernel: &'static str,
    setup: &'a Setup,
    /// The kernel of the joint, and the hand-written one.
    sides: [Kernel; 2],
}

const FORCE: &str = "force";

/// The kernel that writes the record for the others.
const RECORDED: &str = "force and record";

/// The kernel for the change of the force with three tangent vectors.
const TANGENTS: &str = "three tangents";

impl Case<'_> {
    /// Initial buffers of both implementations: force and record.
    fn start(&self) -> [Vec<f64>; 2] {
        let mut record = self.setup.record.clone();
        if self.kernel == RECORDED {
            record.fill(0.0);
        }
        [vec![f64::INFINITY; 3 * PAPER_MODES], record]
    }

    fn run(&self, side: usize, [out, record]: &mut [Vec<f64>; 2]) {
        self.sides[side](self.setup, out, record);
    }
}

/// The settings.
struct Settings {
    bonded_spring: Setup,
    spring: Setup,
    tangential_constant: Setup,
    constant: Setup,
    tangential: Setup,
    bonded: Setup,
    whole: Setup,
}

impl Settings {
    fn new(on: Arch) -> Self {
        let level = |radial| Friction::Constant { law: LEVEL, radial };
        let law = FALLING;
        let falling = |radial| Friction::Stribeck { law, radial };
        Self {
            bonded_spring: Setup::new("no friction, bonded", Friction::None, false, on),
            spring: Setup::new("no friction", Friction::None, true, on),
            tangential_constant: Setup::new("constant, no radial part", level(false), true, on),
            constant: Setup::new("constant", level(true), true, on),
            tangential: Setup::new("Eq. (5), no radial part", falling(false), true, on),
            bonded: Setup::new("Eq. (5), bonded", falling(true), false, on),
            whole: Setup::new("Eq. (5)", falling(true), true, on),
        }
    }

    fn cases(&self) -> Vec<Case<'_>> {
        let mut cases = self.forces();
        cases.extend(self.records());
        cases.extend(self.derivatives());
        cases
    }

    fn forces(&self) -> Vec<Case<'_>> {
        let product: Kernel = |s, out, _| s.joint.force(0.0, &s.z, out);
        let case = |setup, by_hand: Kernel| Case {
            kernel: FORCE,
            setup,
            sides: [product, by_hand],
        };
        vec![
            case(&self.bonded_spring, |s, out, _| {
                s.pass(BondedSpring(s.state()), out)
            }),
            case(&self.spring, |s, out, _| s.pass(Spring(s.state()), out)),
            case(&self.tangential_constant, |s, out, _| {
                s.pass(TangentialConstant(s.state(), LEVEL), out);
            }),
            case(&self.constant, |s, out, _| {
                s.pass(WholeConstant(s.state(), LEVEL), out)
            }),
            case(&self.tangential, |s, out, _| {
                s.pass(TangentialStribeck(s.state(), FALLING), out);
            }),
            case(&self.bonded, |s, out, _| {
                s.pass(BondedStribeck(s.state(), FALLING), out)
            }),
            case(&self.whole, |s, out, _| {
                s.pass(WholeStribeck(s.state(), FALLING), out)
            }),
        ]
    }

    fn records(&self) -> Vec<Case<'_>> {
        let product: Kernel = |s, out, record| {
            s.joint.force_recorded(None, 0.0, &s.z, out, record);
        };
        let case = |setup, by_hand: Kernel| Case {
            kernel: RECORDED,
            setup,
            sides: [product, by_hand],
        };
        vec![
            case(&self.spring, |s, out, record| {
                s.pass(RecordedSpring(s.state(), s.kept(record)), out);
            }),
            case(&self.tangential_constant, |s, out, record| {
                s.pass(RecordedConstant(s.state(), LEVEL, s.kept(record)), out);
            }),
            case(&self.tangential, |s, out, record| {
                s.pass(RecordedTangential(s.state(), FALLING, s.kept(record)), out);
            }),
            case(&self.bonded, |s, out, record| {
                s.pass(RecordedBonded(s.state(), FALLING, s.kept(record)), out);
            }),
            case(&self.whole, |s, out, record| {
                s.pass(RecordedWhole(s.state(), FALLING, s.kept(record)), out);
            }),
        ]
    }

    fn derivatives(&self) -> Vec<Case<'_>> {
        let case = |kernel, setup, product: Kernel, by_hand: Kernel| Case {
            kernel,
            setup,
            sides: [product, by_hand],
        };
        let jacobian = |setup, by_hand: Kernel| {
            let product: Kernel = |s, _, record| {
                s.joint.assembled(record);
            };
            case("Jacobian", setup, product, by_hand)
        };
        let tangents = |setup, by_hand: Kernel| {
            let product: Kernel = |s, out, record| {
                s.joint.product_matrix_free(record, &s.vectors, 3, out);
            };
            case(TANGENTS, setup, product, by_hand)
        };
        let status: Kernel = |s, out, _| {
            s.joint
                .separated_nodes(&s.z[..PAPER_MODES], status_bits(out))
        };
        vec![
            jacobian(&self.spring, |s, _, record| {
                s.joint.arch.dispatch(AssembledSpring(s.matrix(record)));
            }),
            jacobian(&self.tangential, |s, _, record| {
                s.joint.arch.dispatch(AssembledTangential(s.matrix(record)));
            }),
            jacobian(&self.whole, |s, _, record| {
                s.joint.arch.dispatch(AssembledWhole(s.matrix(record)));
            }),
            tangents(&self.spring, |s, out, record| {
                s.joint.arch.dispatch(SweptSpring(s.sweep(out, record)));
            }),
            tangents(&self.tangential, |s, out, record| {
                s.joint.arch.dispatch(SweptTangential(s.sweep(out, record)));
            }),
            tangents(&self.whole, |s, out, record| {
                s.joint.arch.dispatch(SweptWhole(s.sweep(out, record)));
            }),
            case("contact status", &self.whole, status, |s, out, _| {
                s.joint.arch.dispatch(Status {
                    nodes: &s.joint.nodes,
                    q: &s.z[..PAPER_MODES],
                    status: status_bits(out),
                });
            }),
        ]
    }
}

/// Buffer for the status bits, within that for the force.
fn status_bits(out: &mut [f64]) -> &mut [u8] {
    &mut cast_slice_mut(out)[..NODES.div_ceil(8)]
}

/// Both implementations are bit-identical with every supported instruction set, and both write their output.
#[test]
fn hand_written_loops_agree() {
    for machine in machines() {
        let settings = Settings::new(machine);
        for case in settings.cases() {
            let name = format!("{}, {}, {machine:?}", case.kernel, case.setup.setting);
            let bits = |[out, mut record]: [Vec<f64>; 2]| {
                if case.kernel == TANGENTS {
                    // The product uses a part of the record as scratch.
                    record.clear();
                }
                [out, record].concat().into_iter().map(f64::to_bits)
            };
            let [product, by_hand] = [0, 1].map(|side| {
                let mut numbers = case.start();
                case.run(side, &mut numbers);
                bits(numbers).collect::<Vec<_>>()
            });
            assert_eq!(product, by_hand, "{name}");
            assert!(bits(case.start()).ne(product), "{name}: no output");
        }
    }
}

/// Number of calls in one count.
const CALLS: u32 = 10;

/// The section that is counted and timed.
#[inline(never)]
fn burst(case: &Case<'_>, side: usize, numbers: &mut [Vec<f64>; 2]) {
    for _ in 0..CALLS {
        case.run(side, black_box(numbers));
    }
}

#[test]
#[ignore = "run within callgrind by `off_is_free`"]
fn each_side_once() {
    for case in Settings::new(Arch::new()).cases() {
        for side in [0, 1] {
            let mut numbers = case.start();
            burst(&case, side, &mut numbers);
        }
    }
}

/// Instructions per call of both implementations of each case.
fn instructions() -> Vec<[f64; 2]> {
    let out = tempfile::tempdir().unwrap();
    let run = Command::new("valgrind")
        .arg("--tool=callgrind")
        .arg(format!(
            "--callgrind-out-file={}/counts",
            out.path().display()
        ))
        .arg("--toggle-collect=*off_is_free*burst*")
        // The pattern differs, since callgrind ignores a second option with the same pattern.
        .arg("--dump-after=*burst*")
        .arg(std::env::current_exe().unwrap())
        .args(["--ignored", "--exact", "--test-threads=1"])
        .arg("joint::tests::off_is_free::each_side_once")
        .output()
        .expect("valgrind is installed");
    assert!(
        run.status.success(),
        "{}",
        String::from_utf8_lossy(&run.stderr)
    );
    let counts: Vec<f64> = (1..)
        .map_while(|dump| std::fs::read_to_string(out.path().join(format!("counts.{dump}"))).ok())
        .filter_map(|dump| {
            let total = dump
                .lines()
                .find_map(|line| line.strip_prefix("totals: "))?;
            Some(total.trim().parse::<f64>().unwrap() / f64::from(CALLS))
        })
        .filter(|count| *count > 0.0)
        .collect();
    counts.as_chunks().0.to_vec()
}

/// Minimum time per call, us, of both implementations.
fn times(case: &Case<'_>) -> [f64; 2] {
    let mut numbers = case.start();
    let mut least = [f64::INFINITY; 2];
    for _ in 0..2000 {
        for side in [0, 1] {
            let start = Instant::now();
            burst(case, side, &mut numbers);
            let time = start.elapsed().as_secs_f64() * 1e6 / f64::from(CALLS);
            least[side] = least[side].min(time);
        }
    }
    least
}

/// Maximum ratio of instructions to those of the hand-written loop: 1.03, with known exceptions. The dispatch takes
/// about 70 instructions per call, which is significant for short kernels; and the three separation rules leave
/// fewer registers.
fn most(case: &Case<'_>) -> f64 {
    match (case.kernel, &case.setup.joint.law) {
        (FORCE, ActiveLaw::Known(Friction::None)) => 1.11,
        (RECORDED | TANGENTS, ActiveLaw::Known(Friction::None)) => 1.055,
        (FORCE, _) | (RECORDED, ActiveLaw::Known(Friction::Constant { .. })) => 1.04,
        _ => 1.03,
    }
}

/// Prints the table of the guide and checks the ratios.
#[test]
#[ignore = "needs valgrind: apt-get install valgrind; cargo test --release --lib off_is_free -- --ignored"]
fn off_is_free() {
    let settings = Settings::new(Arch::new());
    let (cases, instructions) = (settings.cases(), instructions());
    assert_eq!(cases.len(), instructions.len());
    println!("| kernel | setting | instructions | by hand | ratio | us | by hand | ratio |");
    println!("|---|---|---|---|---|---|---|---|");
    let mut beyond = Vec::new();
    for (case, [own, by_hand]) in cases.iter().zip(instructions) {
        let (kernel, setting) = (case.kernel, case.setup.setting);
        let [time, time_by_hand] = times(case);
        println!(
            "| {kernel} | {setting} | {own:.0} | {by_hand:.0} | {:.3} | {time:.3} | {time_by_hand:.3} | {:.2} |",
            own / by_hand,
            time / time_by_hand,
        );
        if own > most(case) * by_hand {
            beyond.push(format!(
                "{kernel}, {setting}: {own} instructions, {by_hand} by hand"
            ));
        }
    }
    assert!(beyond.is_empty(), "{beyond:#?}");
}

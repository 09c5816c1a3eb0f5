//! A step allocates nothing: workspaces are made once, by the constructor.
#![allow(
    unsafe_code,
    reason = "a counting allocator must implement the unsafe GlobalAlloc trait"
)]

use std::alloc::{GlobalAlloc, Layout, System as SystemAllocator};
use std::cell::Cell;

use squeakscope::dynamics::{Accuracy, Integrator, Method, System};

/// The system's allocator, which counts the requests of each thread.
struct Counting;

thread_local! {
    static REQUESTS: Cell<u64> = const { Cell::new(0) };
}

// SAFETY: every request is passed on unchanged to the system's allocator; counting touches only a
// constant-initialised thread-local without destructor, which itself never allocates.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        REQUESTS.set(REQUESTS.get() + 1);
        // SAFETY: the caller's promises are those of the allocator called.
        unsafe { SystemAllocator.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as above; `pointer` came from the same allocator.
        unsafe { SystemAllocator.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        REQUESTS.set(REQUESTS.get() + 1);
        // SAFETY: as above; `pointer` came from the same allocator.
        unsafe { SystemAllocator.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// How many requests for memory `work` makes on this thread.
fn requests(work: impl FnOnce()) -> u64 {
    let before = REQUESTS.get();
    work();
    REQUESTS.get() - before
}

/// Eleven oscillators on unilateral springs, with the springs' work.
struct Springs {
    omega: Vec<f64>,
}

impl Springs {
    fn new() -> Self {
        Self {
            omega: (1..=11).map(f64::from).collect(),
        }
    }
}

impl System for Springs {
    fn omega(&self) -> &[f64] {
        &self.omega
    }
    fn first_order(&self) -> usize {
        1
    }
    fn force(&self, _t: f64, z: &[f64], out: &mut [f64]) {
        let (q, v) = z.split_at(11);
        for i in 0..11 {
            out[i] = 0.2 - (0.2 + q[i] + q[(i + 1) % 11]).max(0.0);
        }
        out[11] = (0..11).map(|i| out[i] * v[i]).sum();
    }
}

#[test]
fn the_counter_counts() {
    assert_eq!(requests(|| drop(std::hint::black_box(vec![1.0_f64; 8]))), 1);
}

#[test]
fn integrating_allocates_nothing() {
    let springs = Springs::new();
    let mut start = vec![0.0; 23];
    start[11..22].fill(0.5);
    let mut z = vec![0.0; 23];
    let accuracy = Accuracy::relative(1e-6);
    let methods = [
        Method::Lawson54 {
            accuracy,
            max_step: 1.0,
        },
        Method::Tsit54 {
            accuracy,
            max_step: 1.0,
        },
        Method::Rk4 { step: 0.01 },
    ];
    for method in methods {
        let mut integrator = Integrator::new(method, &springs).expect("valid parameters");
        let count = requests(|| {
            integrator
                .start(&springs, 0.0, &start)
                .expect("finite start");
            for frame in 1..=10 {
                let border = f64::from(frame);
                for k in 0..20 {
                    let t = border - 1.0 + 0.05 * f64::from(k);
                    integrator.sample(&springs, t, &mut z).expect("a sample");
                }
                integrator.land(&springs, border).expect("a landing");
                integrator.restart(&springs).expect("the same system again");
            }
        });
        let tally = integrator.tally();
        assert_eq!(count, 0, "{method:?} allocated in {tally:?}");
        let adaptive = !matches!(method, Method::Rk4 { .. });
        assert!(
            tally.steps > 50 && (tally.rejections > 0) == adaptive,
            "{method:?}: {tally:?}"
        );
    }
}

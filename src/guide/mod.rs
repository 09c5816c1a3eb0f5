//! The guide: a book in four parts. Its code examples are run as tests.
//!
//! | part | read it to |
//! |---|---|
//! | [Tutorial](tutorial) | learn the program step by step |
//! | [How-to](how_to) | complete one task; each page stands alone |
//! | [Explanation](explanation) | understand the physics, the numerics, the analyses and the cost |
//! | [Reference](mod@reference) | look up a scene key, an output, a fault, a term |
//!
//! # Tutorial
//!
//! 1. [First recording](tutorial::first_recording): simulate the default scene and read the recording.
//! 2. [First live run](tutorial::first_live_run): change the tilt during the simulation.
//! 3. [First signal](tutorial::first_signal): analyse a signal from a file.
//! 4. [First scene](tutorial::first_scene): write a scene file and run it.
//!
//! # How-to
//!
//! Find the cause of a squeak:
//!
//! * [Find what sets off a squeak](how_to::find_what_squeaks): linear stability, then a sweep over the tilt.
//! * [Compare attractors](how_to::compare_attractors): basins of attraction from random kicks.
//! * [Compute Lyapunov exponents with errors](how_to::exponents).
//! * [Analyse a measured recording](how_to::measured_recording): WAV, CSV, NumPy arrays, `.rrd`.
//!
//! Run and control simulations:
//!
//! * [Choose the accuracy](how_to::choose_accuracy): tolerance and contact nodes for a given error.
//! * [Use modes from another finite-element program](how_to::own_modes): Nastran, Abaqus, Ansys, CalculiX, UFF.
//! * [Run a sweep on many machines](how_to::many_machines), as a Slurm job array or with Dask.
//! * [Control a live run in a classroom](how_to::classroom).
//!
//! Use the results:
//!
//! * [Listen to a squeak](how_to::listen): WAV files and audio on the page.
//! * [Make figures for slides and for a paper](how_to::figures).
//! * [Read results in Python, R and other programs](how_to::read_results): JSON, Arrow, CSV, NumPy.
//! * [Use it from Python](how_to::python): arrays in and out, results as objects and tables.
//! * [Use the library](how_to::library).
//!
//! Compare with Kang (2022):
//!
//! * [Reproduce the paper](how_to::reproduce_paper): each figure and each claim.
//!
//! # Explanation
//!
//! Physics:
//!
//! * [Equations](explanation::equations): each equation of the paper and its code; axes, signs, energy.
//! * [Mechanisms](explanation::mechanisms): mechanisms of friction-induced vibration, each with a scene that shows it.
//!
//! Numerics:
//!
//! * [Numerical stability](explanation::stability): stiffness, kinks, wrong solutions, and what detects them.
//! * [Contact nodes](explanation::nodes): how many a scene needs, and which are shown.
//! * [Hard cases](explanation::hard_cases): the most difficult test cases with measured errors.
//!
//! Bifurcations:
//!
//! * [Branches](explanation::branches): equilibria and periodic motions over a parameter, where and why they change.
//!
//! Chaos:
//!
//! * [Lyapunov exponents](explanation::exponents): definition, computation, confidence intervals, zeros.
//! * [Settled responses](explanation::responses): end of the transient, starts, coexisting attractors.
//! * [Tonal events](explanation::events): tones in a recording, and how reliably they are found.
//! * [Types of motion](explanation::regimes): the classifier and its evidence.
//! * [Recurrence](explanation::recurrence): delay vectors, recurrence plots, recurrence quantification.
//!
//! Cost:
//!
//! * [Cost of accuracy](explanation::cost): error against CPU time.
//! * [Comparison with other programs](explanation::peers): analyses, right-hand side and integrators.
//!
//! # Reference
//!
//! * [Scene files](crate::scene): format, functions of time, rules.
//! * [Outputs and exit codes](mod@reference::outputs): files, warnings, the energy audit.
//! * [Live runs](mod@reference::live): commands, server, limits, latency.
//! * [Faults](mod@reference::faults): full disks, closed viewers, signals, damaged files.
//! * [Glossary](mod@reference::glossary): terms that a newcomer needs.

/// The pages of a part, each a module with the text of its file, and of a file with drawings.
macro_rules! pages {
    ($part:literal: $($page:ident $(with $drawings:literal)?,)*) => {$(
        #[doc = include_str!(concat!($part, "/", stringify!($page), ".md"))]
        $(#[doc = include_str!(concat!($part, "/", $drawings))])?
        pub mod $page {}
    )*};
}

/// First recording, first live run, first signal, first scene.
pub mod tutorial {
    pages! { "tutorial":
        first_recording,
        first_live_run,
        first_signal,
        first_scene,
    }
}

/// One page for each task.
pub mod how_to {
    pages! { "how_to":
        find_what_squeaks,
        compare_attractors,
        exponents,
        measured_recording,
        choose_accuracy,
        own_modes with "own_modes.html",
        many_machines,
        classroom,
        listen,
        figures,
        read_results,
        python,
        library,
        reproduce_paper with "reproduce_paper.html",
    }
}

/// Physics, numerics, chaos and cost.
pub mod explanation {
    pages! { "explanation":
        equations,
        mechanisms,
        stability,
        nodes,
        hard_cases,
        branches,
        exponents,
        responses,
        events with "events.html",
        regimes with "regimes.html",
        recurrence,
        cost,
        peers,
    }
}

/// Scene keys ([`scene`](crate::scene)), outputs, live runs, faults, glossary.
pub mod reference {
    pages! { "reference":
        outputs,
        live,
        faults,
        glossary,
    }
}

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

/// First recording, first live run, first signal, first scene.
pub mod tutorial {
    #[doc = include_str!("tutorial/first_recording.md")]
    pub mod first_recording {}

    #[doc = include_str!("tutorial/first_live_run.md")]
    pub mod first_live_run {}

    #[doc = include_str!("tutorial/first_signal.md")]
    pub mod first_signal {}

    #[doc = include_str!("tutorial/first_scene.md")]
    pub mod first_scene {}
}

/// One page for each task.
pub mod how_to {
    #[doc = include_str!("how_to/find_what_squeaks.md")]
    pub mod find_what_squeaks {}

    #[doc = include_str!("how_to/compare_attractors.md")]
    pub mod compare_attractors {}

    #[doc = include_str!("how_to/exponents.md")]
    pub mod exponents {}

    #[doc = include_str!("how_to/measured_recording.md")]
    pub mod measured_recording {}

    #[doc = include_str!("how_to/choose_accuracy.md")]
    pub mod choose_accuracy {}

    #[doc = include_str!("how_to/own_modes.md")]
    #[doc = include_str!("how_to/own_modes.html")]
    pub mod own_modes {}

    #[doc = include_str!("how_to/many_machines.md")]
    pub mod many_machines {}

    #[doc = include_str!("how_to/classroom.md")]
    pub mod classroom {}

    #[doc = include_str!("how_to/listen.md")]
    pub mod listen {}

    #[doc = include_str!("how_to/figures.md")]
    pub mod figures {}

    #[doc = include_str!("how_to/read_results.md")]
    pub mod read_results {}

    #[doc = include_str!("how_to/python.md")]
    pub mod python {}

    #[doc = include_str!("how_to/library.md")]
    pub mod library {}

    #[doc = include_str!("how_to/reproduce_paper.md")]
    #[doc = include_str!("how_to/reproduce_paper.html")]
    pub mod reproduce_paper {}
}

/// Physics, numerics, chaos and cost.
pub mod explanation {
    #[doc = include_str!("explanation/equations.md")]
    pub mod equations {}

    #[doc = include_str!("explanation/mechanisms.md")]
    pub mod mechanisms {}

    #[doc = include_str!("explanation/stability.md")]
    pub mod stability {}

    #[doc = include_str!("explanation/nodes.md")]
    pub mod nodes {}

    #[doc = include_str!("explanation/hard_cases.md")]
    pub mod hard_cases {}

    #[doc = include_str!("explanation/branches.md")]
    pub mod branches {}

    #[doc = include_str!("explanation/exponents.md")]
    pub mod exponents {}

    #[doc = include_str!("explanation/responses.md")]
    pub mod responses {}

    #[doc = include_str!("explanation/events.md")]
    #[doc = include_str!("explanation/events.html")]
    pub mod events {}

    #[doc = include_str!("explanation/regimes.md")]
    #[doc = include_str!("explanation/regimes.html")]
    pub mod regimes {}

    #[doc = include_str!("explanation/recurrence.md")]
    pub mod recurrence {}

    #[doc = include_str!("explanation/cost.md")]
    pub mod cost {}

    #[doc = include_str!("explanation/peers.md")]
    pub mod peers {}
}

/// Scene keys ([`scene`](crate::scene)), outputs, live runs, faults, glossary.
pub mod reference {
    #[doc = include_str!("reference/outputs.md")]
    pub mod outputs {}

    #[doc = include_str!("reference/live.md")]
    pub mod live {}

    #[doc = include_str!("reference/faults.md")]
    pub mod faults {}

    #[doc = include_str!("reference/glossary.md")]
    pub mod glossary {}
}

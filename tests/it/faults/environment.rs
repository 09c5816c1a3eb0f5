//! Environment variables do not change the recorded data.

use super::{Running, desk, run, samples, size, squeakscope};

/// Rerun's environment variable switches its own streams off, which then record nothing.
#[test]
fn a_recording_does_not_depend_on_the_rerun_variable() {
    for value in ["off", "0", "false", "on", "garbage"] {
        let (folder, recording) = desk();
        let mut program = run(folder.path(), "5", &["--save", "run.rrd"]);
        program.env("RERUN", value);
        Running::start(program).end().said(0, &[]);
        assert!(!samples(&recording).values.is_empty(), "{value}");
    }
}

#[test]
fn a_study_is_recorded_with_rerun_switched_off() {
    let (folder, recording) = desk();
    let words = "sweep doubled-torus-3deg --tilt 1:2:1 --min-transient 5 --max-transient 5 --measure 5 --out run.arrow --save run.rrd";
    let mut program = squeakscope();
    program.current_dir(folder.path()).args(words.split(' '));
    program.env("RERUN", "off");
    Running::start(program).end().said(0, &[]);
    assert!(size(&recording) > 10_000, "{}", size(&recording));
}

//! What the environment says does not change what is recorded.

use super::{Running, desk, run, samples, size, squeakscope};

/// Rerun's own streams are turned off by it, and record nothing then.
#[test]
fn a_recording_does_not_depend_on_what_rerun_is_told() {
    for value in ["off", "0", "false", "on", "garbage"] {
        let (folder, recording) = desk();
        let mut program = run(folder.path(), "5", &["--save", "run.rrd"]);
        program.env("RERUN", value);
        Running::start(program).end().said(0, &[]);
        assert!(!samples(&recording).values.is_empty(), "{value}");
    }
}

#[test]
fn a_study_is_recorded_where_rerun_is_off() {
    let (folder, recording) = desk();
    let words = "sweep torus-3deg --tilt 1:2:1 --least 5 --most 5 --measure 5 --out run.arrow --save run.rrd";
    let mut program = squeakscope();
    program.current_dir(folder.path()).args(words.split(' '));
    program.env("RERUN", "off");
    Running::start(program).end().said(0, &[]);
    assert!(size(&recording) > 10_000, "{}", size(&recording));
}

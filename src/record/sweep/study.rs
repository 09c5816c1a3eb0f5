//! What is recorded of a sweep.

use crate::joint::BallJoint;
use crate::study::sweep::{Start, SweepPlan, SweepPoint};

/// Application name: not that of runs, whose screen in the viewer is another.
pub const APPLICATION: &str = "squeakscope-sweep";

/// A sweep over one parameter, as far as it has come.
#[derive(Clone, Copy)]
pub struct SweepStudy<'a> {
    /// What is varied.
    pub plan: &'a SweepPlan,
    /// The points that are known.
    pub points: &'a [SweepPoint],
    /// How the program was started.
    pub command: &'a str,
    /// Ball and beam, if their natural modes are to be shown.
    pub ball: Option<&'a BallJoint>,
}

impl<'a> SweepStudy<'a> {
    /// The ways of starting that have points.
    pub fn starts(&self) -> impl Iterator<Item = Start> + 'a {
        let points = self.points;
        let starts = self.plan.starts.iter().copied();
        starts.filter(move |start| points.iter().any(|point| point.place.start == *start))
    }

    /// The values of the parameter, in its unit.
    pub fn values(&self) -> &'a [f64] {
        self.plan.axes.first().map_or(&[], |axis| axis.values())
    }

    /// The point at a value.
    pub fn at(&self, start: Start, value: f64) -> Option<&'a SweepPoint> {
        let is_there =
            |point: &&SweepPoint| point.place.start == start && point.place.values[0] == value;
        self.points.iter().find(is_there)
    }

    /// The letter of the displacement on axes.
    pub fn letter(&self) -> &'static str {
        match self.plan.scene.joint() {
            Ok(_) => "u",
            Err(_) => "x",
        }
    }
}

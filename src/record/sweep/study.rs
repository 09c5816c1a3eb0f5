//! The data of a recorded sweep.

use crate::joint::BallJoint;
use crate::study::sweep::{Start, SweepPlan, SweepPoint};

/// Application id, different from that of runs because the layout differs.
pub const APPLICATION: &str = "squeakscope-sweep";

/// A complete or partial sweep over one parameter.
#[derive(Clone, Copy)]
pub struct SweepStudy<'a> {
    /// Parameter, values and starts.
    pub plan: &'a SweepPlan,
    /// The computed points.
    pub points: &'a [SweepPoint],
    /// The command line.
    pub command: &'a str,
    /// Ball and beam, if their natural modes are shown.
    pub ball: Option<&'a BallJoint>,
}

impl<'a> SweepStudy<'a> {
    /// The starts that have points.
    pub fn starts(&self) -> impl Iterator<Item = Start> + 'a {
        let points = self.points;
        let starts = self.plan.starts.iter().copied();
        starts.filter(move |start| points.iter().any(|point| point.place.start == *start))
    }

    /// The values of the parameter, in its unit.
    pub fn values(&self) -> &'a [f64] {
        self.plan.axes.first().map_or(&[], |axis| axis.values())
    }

    /// The point of a start at a parameter value.
    pub fn at(&self, start: Start, value: f64) -> Option<&'a SweepPoint> {
        let is_there =
            |point: &&SweepPoint| point.place.start == start && point.place.values[0] == value;
        self.points.iter().find(is_there)
    }

    /// Symbol of the displacement.
    pub fn letter(&self) -> &'static str {
        match self.plan.scene.joint() {
            Ok(_) => "u",
            Err(_) => "x",
        }
    }
}

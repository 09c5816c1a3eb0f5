//! Curves in the plane of two parameters: each step sets the parameter that changes more and solves for the other one, so
//! that turning points are passed. Lengths and angles are those in the unit square of the intervals.

use super::map::MapPlan;

/// Angles (rad) between successive steps below which the next step is doubled, and above which it is halved.
const TURNS: [f64; 2] = [0.05, 0.15];
/// Smallest cosine of the angle between successive steps; a longer turn is tried again with half the step.
const MIN_COSINE: f64 = 0.9;
/// Distance of a point from the chords of a curve that passes it.
pub(super) const ON_CURVE: f64 = 2e-3;
/// Largest number of points of a curve in one direction.
const MAX_POINTS: usize = 1000;

/// A point of a curve.
pub(super) trait CurvePoint: Clone {
    /// Values of the parameters, in the units of the scene file.
    fn values(&self) -> [f64; 2];

    /// Whether a point with almost the same values would be on the same curve.
    fn is_alike(&self, other: &Self) -> bool;
}

/// A curve that was followed in both directions.
pub(super) struct Curve<P> {
    /// The points, in their order along the curve.
    pub points: Vec<P>,
    /// Whether the last point is the first one.
    pub closed: bool,
    /// Why the curve ends inside the intervals, one sentence each.
    pub ended: Vec<String>,
}

/// Finds the point of a curve next to another one: with the expected value of one parameter (the index) and near the
/// expected value of the other one.
pub(super) type Solve<'a, P, E> = &'a mut dyn FnMut(&P, usize, [f64; 2]) -> Result<Option<P>, E>;

impl MapPlan {
    /// The values of the parameters relative to their intervals, 0 to 1.
    fn relative(&self, values: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| {
            let [from, to] = self.intervals[axis];
            (values[axis] - from) / (to - from)
        })
    }

    fn between<P: CurvePoint>(&self, from: &P, to: &P) -> [f64; 2] {
        let [a, b] = [from, to].map(|point| self.relative(point.values()));
        [b[0] - a[0], b[1] - a[1]]
    }

    /// Whether a curve passes a point at less than a distance.
    pub(super) fn passes<P: CurvePoint>(&self, curve: &[P], point: &P, within: f64) -> bool {
        curve.windows(2).any(|pair| {
            let [[x, y], [dx, dy]] = [&pair[1], point].map(|to| self.between(&pair[0], to));
            let along = ((x * dx + y * dy) / (x * x + y * y)).clamp(0.0, 1.0);
            let aside = (dx - along * x).hypot(dy - along * y);
            aside < within && pair[0].is_alike(point)
        })
    }

    /// Follows a curve from a point in both directions. `direction` is a first guess, `steps` are the first, the smallest and
    /// the largest step.
    pub(super) fn follow<P: CurvePoint, E>(
        &self,
        start: &P,
        direction: [f64; 2],
        steps: [f64; 3],
        solve: Solve<'_, P, E>,
    ) -> Result<Curve<P>, E> {
        let mut curve = Curve {
            points: vec![start.clone()],
            closed: false,
            ended: Vec::new(),
        };
        for way in [-1.0, 1.0] {
            if !curve.closed {
                // The first direction is the beginning of the curve, in reverse.
                curve.points.reverse();
                self.trace(direction.map(|d| way * d), steps, &mut curve, solve)?;
            }
        }
        Ok(curve)
    }

    /// Continues a curve from its last point.
    fn trace<P: CurvePoint, E>(
        &self,
        mut direction: [f64; 2],
        [mut step, least, most]: [f64; 3],
        curve: &mut Curve<P>,
        solve: Solve<'_, P, E>,
    ) -> Result<(), E> {
        let start = curve.points.len();
        let mut now = curve.points[start - 1].clone();
        let first = now.clone();
        loop {
            let here = self.relative(now.values());
            let Some((axis, length)) = step_within(here, direction, step) else {
                return Ok(());
            };
            let expected = [0, 1].map(|k| {
                let [from, to] = self.intervals[k];
                let share = (here[k] + length * direction[k]).clamp(0.0, 1.0);
                from * (1.0 - share) + to * share
            });
            let cosine = if curve.points.len() > start {
                MIN_COSINE
            } else {
                0.0
            };
            let next = solve(&now, axis, expected)?;
            let next = next.filter(|next| {
                let [x, y] = self.between(&now, next);
                x * direction[0] + y * direction[1] > cosine * x.hypot(y)
            });
            let Some(next) = next else {
                // Not the next step, which a border may have shortened.
                step = 0.5 * length;
                if step >= least {
                    continue;
                }
                let at = now.values();
                let names = self.parameters.map(|parameter| parameter.name());
                curve.ended.push(format!(
                    "the curve ends at {} = {:.6}, {} = {:.6}: no further point was found",
                    names[0], at[0], names[1], at[1],
                ));
                return Ok(());
            };
            let [x, y] = self.between(&now, &next);
            let [dx, dy] = direction;
            let turn = (y * dx - x * dy).atan2(x * dx + y * dy);
            let moved = x.hypot(y);
            direction = [x / moved, y / moved];
            let pair = [now, next];
            if curve.points.len() > start + 2 && self.passes(&pair, &first, ON_CURVE) {
                curve.points.push(first);
                curve.closed = true;
                return Ok(());
            }
            [_, now] = pair;
            curve.points.push(now.clone());
            if curve.points.len() - start >= MAX_POINTS {
                let reason = "the maximum number of points was reached".to_owned();
                curve.ended.push(reason);
                return Ok(());
            }
            step *= match turn.abs() {
                turn if turn < TURNS[0] => 2.0,
                turn if turn > TURNS[1] => 0.5,
                _ => 1.0,
            };
            step = step.clamp(least, most);
        }
    }
}

/// The length of a step in the unit square, shortened to end on its border, and the parameter that is set: the one whose
/// border is reached, else the one that changes more. `None` for a step out of the square.
fn step_within(here: [f64; 2], direction: [f64; 2], step: f64) -> Option<(usize, f64)> {
    let inside = usize::from(direction[1].abs() > direction[0].abs());
    let to_border = [0, 1].map(|axis| {
        let room = if direction[axis] > 0.0 {
            1.0 - here[axis]
        } else {
            here[axis]
        };
        room / direction[axis].abs()
    });
    let nearest = usize::from(to_border[1] < to_border[0]);
    match to_border[nearest] {
        room if room <= 1e-9 => None,
        room if room <= step => Some((nearest, room)),
        _ => Some((inside, step)),
    }
}

//! Bracketing of a zero.

/// An interval at whose ends a function has opposite signs; it shrinks around the zero.
///
/// The method is that of I. F. D. Oliveira and R. H. C. Takahashi, An enhancement of the bisection
/// method average performance preserving minmax optimality, ACM Trans. Math. Softw. 47 (2021) 5: a
/// secant step shifted slightly towards the middle, at most one evaluation slower than bisection.
#[derive(Clone, Copy, Debug)]
pub struct RootBracket {
    /// The ends, ascending. The caller replaces the end at which the function has the sign that it has at the
    /// [guess](RootBracket::guess).
    pub ends: [f64; 2],
    /// Width at which the search ends.
    resolution: f64,
    first_width: f64,
    /// Permitted width: that of bisection.
    allowed: f64,
}

impl RootBracket {
    /// A bracket that shrinks to a width of `resolution`.
    pub fn new([low, high]: [f64; 2], resolution: f64) -> Self {
        Self {
            ends: [low, high],
            resolution,
            first_width: high - low,
            allowed: resolution.max(high - low),
        }
    }

    /// Where to evaluate the function next; `None` once the bracket is narrow. `secant` is the zero of the secant, as a
    /// fraction of the bracket from 0 to 1.
    pub fn guess(&mut self, secant: f64) -> Option<f64> {
        let ([low, high], resolution) = (self.ends, self.resolution);
        let width = high - low;
        if width <= resolution {
            return None;
        }
        let secant = low + width * secant;
        let middle = low + 0.5 * width;
        let towards = (middle - secant).signum();
        let shift = (0.01 * width * (width / self.first_width)).max(0.5 * resolution);
        let moved = if shift <= (middle - secant).abs() {
            secant + towards * shift
        } else {
            middle
        };
        let reach = self.allowed - 0.5 * width;
        let guess = if (moved - middle).abs() <= reach {
            moved
        } else {
            middle - towards * reach
        };
        self.allowed *= 0.5;
        (low < guess && guess < high).then_some(guess)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A smooth function takes few evaluations; a vertical tangent and a step take at most one more than bisection.
    #[test]
    fn zeros_are_bracketed_to_the_resolution() {
        let root = |x: f64| (x - 1.25).signum() * (x - 1.25).abs().sqrt();
        let step = |x: f64| if x < 0.3 { -1.0 } else { 1e6 };
        let functions: [&dyn Fn(f64) -> f64; 3] = [&|x| x.exp() - 3.0, &root, &step];
        let zeros = [(3.0_f64.ln(), 12), (1.25, 46), (0.3, 46)];
        for (function, (zero, most)) in functions.into_iter().zip(zeros) {
            let mut bracket = RootBracket::new([0.0, 3.0], 1e-13);
            let mut values = bracket.ends.map(function);
            let mut count = 0;
            while let Some(x) = bracket.guess(values[0] / (values[0] - values[1])) {
                let end = usize::from(function(x) >= 0.0);
                (bracket.ends[end], values[end]) = (x, function(x));
                count += 1;
            }
            assert!(count <= most, "{count} evaluations for {zero}");
            assert!(bracket.ends.iter().all(|end| (end - zero).abs() <= 1e-13));
        }
    }
}

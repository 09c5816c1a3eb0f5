//! Vector norms.

use schemars::JsonSchema;
use serde::Serialize;

/// Norm used for the distance of two vectors.
#[derive(
    Clone,
    Copy,
    Debug,
    Default,
    PartialEq,
    Eq,
    Hash,
    strum::VariantArray,
    strum::EnumString,
    strum::IntoStaticStr,
    Serialize,
    JsonSchema,
)]
#[strum(serialize_all = "kebab-case")]
#[serde(rename_all = "kebab-case")]
pub enum Norm {
    /// `sqrt(sum_c d_c^2)`.
    #[default]
    Euclidean,
    /// `max_c |d_c|`.
    Maximum,
    /// `sum_c |d_c|`.
    Manhattan,
}

/// Distances are compared in *unrooted* form, without the square root: the sum of squares for the
/// Euclidean norm, the distance itself for the others. Every operation is rounded separately and sums
/// start with the first coordinate, which makes all comparisons agree to the last bit.
impl Norm {
    /// Unrooted norm of a vector of differences.
    pub(crate) fn unrooted(self, differences: impl Iterator<Item = f64>) -> f64 {
        match self {
            Self::Euclidean => differences.fold(0.0, |sum, t| sum + t * t),
            Self::Maximum => differences.fold(0.0, |most, t| t.abs().max(most)),
            Self::Manhattan => differences.fold(0.0, |sum, t| sum + t.abs()),
        }
    }

    /// Adds a coordinate of each of several vectors of differences to their unrooted norms.
    #[inline(always)]
    pub(crate) fn add(self, unrooted: &mut [f64], differences: impl Iterator<Item = f64>) {
        let both = unrooted.iter_mut().zip(differences);
        match self {
            Self::Euclidean => both.for_each(|(sum, t)| *sum += t * t),
            Self::Maximum => {
                both.for_each(|(most, t)| *most = if t.abs() > *most { t.abs() } else { *most })
            }
            Self::Manhattan => both.for_each(|(sum, t)| *sum += t.abs()),
        }
    }

    /// Largest unrooted distance within a distance (not negative).
    pub(crate) fn unrooted_limit(self, distance: f64) -> f64 {
        match self {
            Self::Euclidean => distance * distance,
            Self::Maximum | Self::Manhattan => distance,
        }
    }

    /// Distance of an unrooted one, rounded.
    #[inline(always)]
    pub(crate) fn rooted(self, unrooted: f64) -> f64 {
        match self {
            Self::Euclidean => unrooted.sqrt(),
            Self::Maximum | Self::Manhattan => unrooted,
        }
    }

    /// Largest unrooted distance whose rounded root is at most `radius`.
    pub(crate) fn rooted_limit(self, radius: f64) -> f64 {
        if radius < 0.0 || self != Self::Euclidean {
            return radius;
        }
        // The square is rounded, so the limit is found among the adjacent numbers.
        let mut sum = radius * radius;
        while sum.sqrt() > radius {
            sum = sum.next_down();
        }
        while sum < f64::INFINITY && sum.next_up().sqrt() <= radius {
            sum = sum.next_up();
        }
        sum
    }

    /// Smallest distance that contains an unrooted distance: the smallest root whose rounded square reaches it. Where
    /// squares underflow, one of very many such roots.
    pub(crate) fn distance_of_unrooted(self, unrooted: f64) -> f64 {
        let root = self.rooted(unrooted);
        if self.unrooted_limit(root) < unrooted {
            root.next_up()
        } else {
            root
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn unrooted_distances_match_the_norms() {
        let t = [3.0, -4.0, 0.0];
        assert_eq!(Norm::Euclidean.unrooted(t.into_iter()), 25.0);
        assert_eq!(Norm::Maximum.unrooted(t.into_iter()), 4.0);
        assert_eq!(Norm::Manhattan.unrooted(t.into_iter()), 7.0);
        assert_eq!(Norm::Euclidean.distance_of_unrooted(25.0), 5.0);
        assert_eq!(Norm::Euclidean.unrooted_limit(5.0), 25.0);
    }

    fn check_distance_of(unrooted: f64) {
        for norm in [Norm::Euclidean, Norm::Maximum, Norm::Manhattan] {
            let distance = norm.distance_of_unrooted(unrooted);
            assert!(
                norm.unrooted_limit(distance) >= unrooted,
                "{norm:?} {unrooted}"
            );
            if (f64::MIN_POSITIVE..f64::INFINITY).contains(&unrooted) {
                let less = norm.unrooted_limit(distance.next_down());
                assert!(less < unrooted, "{norm:?} {unrooted}");
            }
        }
    }

    #[test]
    fn squares_that_underflow_or_overflow_have_a_distance() {
        // About 10^15 roots or more have the same square.
        for unrooted in [0.0, 5e-324, 1e-320, 1e-310, f64::MIN_POSITIVE, f64::MAX] {
            check_distance_of(unrooted);
        }
        check_distance_of(f64::INFINITY);
    }

    proptest! {
        #[test]
        fn the_distance_is_the_smallest_that_contains_its_unrooted_form(bits in 0..f64::INFINITY.to_bits()) {
            check_distance_of(f64::from_bits(bits));
        }
    }
}

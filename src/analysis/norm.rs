//! Distances between vectors.

use serde::{Deserialize, Serialize};

/// How the distance of two vectors is measured.
#[derive(
    Clone,
    Copy,
    Debug,
    Default,
    PartialEq,
    Eq,
    Hash,
    strum::VariantArray,
    strum::IntoStaticStr,
    Serialize,
    Deserialize,
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

/// Distances are compared without roots, as what is here called their *extent*: the sum of
/// squares of the Euclidean norm, the distance itself of the others. Each operation is rounded by
/// itself and sums run from the first coordinate on, so that all comparisons agree to the last
/// bit.
impl Norm {
    /// The extent of a vector of differences.
    pub(crate) fn extent(self, differences: impl Iterator<Item = f64>) -> f64 {
        match self {
            Self::Euclidean => differences.fold(0.0, |sum, t| sum + t * t),
            Self::Maximum => differences.fold(0.0, |most, t| t.abs().max(most)),
            Self::Manhattan => differences.fold(0.0, |sum, t| sum + t.abs()),
        }
    }

    /// The largest extent within a distance (not negative).
    pub(crate) fn extent_within(self, distance: f64) -> f64 {
        match self {
            Self::Euclidean => distance * distance,
            Self::Maximum | Self::Manhattan => distance,
        }
    }

    /// The smallest distance that an extent is within: the smallest root whose square, rounded as
    /// it will be, reaches the extent.
    ///
    /// Bisection, because squares that underflow or overflow have very many such roots.
    pub(crate) fn distance_of_extent(self, extent: f64) -> f64 {
        match self {
            Self::Euclidean => {
                // Numbers that are not negative are ordered like their bits.
                let (mut low, mut high) = (0, extent.sqrt().next_up().to_bits());
                while low < high {
                    let middle = low + (high - low) / 2;
                    let root = f64::from_bits(middle);
                    if root * root >= extent {
                        high = middle;
                    } else {
                        low = middle + 1;
                    }
                }
                f64::from_bits(low)
            }
            Self::Maximum | Self::Manhattan => extent,
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn extents_are_those_of_the_norms() {
        let t = [3.0, -4.0, 0.0];
        assert_eq!(Norm::Euclidean.extent(t.into_iter()), 25.0);
        assert_eq!(Norm::Maximum.extent(t.into_iter()), 4.0);
        assert_eq!(Norm::Manhattan.extent(t.into_iter()), 7.0);
        assert_eq!(Norm::Euclidean.distance_of_extent(25.0), 5.0);
        assert_eq!(Norm::Euclidean.extent_within(5.0), 25.0);
    }

    fn check_distance_of(extent: f64) {
        for norm in [Norm::Euclidean, Norm::Maximum, Norm::Manhattan] {
            let distance = norm.distance_of_extent(extent);
            assert!(norm.extent_within(distance) >= extent, "{norm:?} {extent}");
            if distance > 0.0 {
                let less = norm.extent_within(distance.next_down());
                assert!(less < extent, "{norm:?} {extent}");
            }
        }
    }

    #[test]
    fn squares_that_underflow_or_overflow_have_a_distance() {
        // Some 10^15 roots or more have the same square.
        for extent in [0.0, 5e-324, 1e-320, 1e-310, f64::MIN_POSITIVE, f64::MAX] {
            check_distance_of(extent);
        }
        check_distance_of(f64::INFINITY);
    }

    proptest! {
        #[test]
        fn a_distance_is_the_smallest_that_holds_its_extent(bits in 0..f64::INFINITY.to_bits()) {
            check_distance_of(f64::from_bits(bits));
        }
    }
}

//! Distances between vectors.

/// How the distance of two vectors is measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
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

    /// The smallest distance that an extent is within: a root is nudged until its square, rounded
    /// as it will be, reaches the extent.
    pub(crate) fn distance_of_extent(self, extent: f64) -> f64 {
        match self {
            Self::Euclidean => {
                let mut root = extent.sqrt();
                while root * root < extent {
                    root = root.next_up();
                }
                while root > 0.0 && root.next_down() * root.next_down() >= extent {
                    root = root.next_down();
                }
                root
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

    proptest! {
        #[test]
        fn a_distance_is_the_smallest_that_holds_its_extent(bits in 0..f64::INFINITY.to_bits()) {
            let extent = f64::from_bits(bits);
            for norm in [Norm::Euclidean, Norm::Maximum, Norm::Manhattan] {
                let distance = norm.distance_of_extent(extent);
                prop_assert!(norm.extent_within(distance) >= extent);
                if distance > 0.0 {
                    prop_assert!(norm.extent_within(distance.next_down()) < extent);
                }
            }
        }
    }
}

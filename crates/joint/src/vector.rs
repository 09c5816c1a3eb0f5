//! Operations on three-dimensional vectors.

/// Scalar product.
pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Vector product.
pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// Euclidean length.
pub(crate) fn norm(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

/// `s a`.
pub(crate) fn scale(a: [f64; 3], s: f64) -> [f64; 3] {
    a.map(|x| s * x)
}

/// `a + s b`.
pub(crate) fn add_scaled(a: [f64; 3], s: f64, b: [f64; 3]) -> [f64; 3] {
    [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]]
}

/// The unit vector along `a`; `None` for a zero vector.
pub(crate) fn unit(a: [f64; 3]) -> Option<[f64; 3]> {
    let length = norm(a);
    (length > 0.0).then(|| scale(a, 1.0 / length))
}

/// A unit vector normal to the unit vector `n`.
pub(crate) fn any_normal(n: [f64; 3]) -> [f64; 3] {
    // The axis least aligned with n gives a well-conditioned cross product.
    let axis = if n[0].abs() <= n[1].abs() && n[0].abs() <= n[2].abs() {
        [1.0, 0.0, 0.0]
    } else if n[1].abs() <= n[2].abs() {
        [0.0, 1.0, 0.0]
    } else {
        [0.0, 0.0, 1.0]
    };
    let side = cross(n, axis);
    scale(side, 1.0 / norm(side))
}

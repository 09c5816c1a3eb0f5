//! A valid file, and every fault of a file.

use super::*;

/// Radius of the ball, m; load, N; half-angle of the patch, rad.
const BALL: f64 = 16e-3;
const LOAD: f64 = 100.0;
const HALF_ANGLE: f64 = 0.1;

struct Array {
    shape: Vec<usize>,
    values: Vec<f64>,
}

impl Array {
    fn number(value: f64) -> Self {
        Self {
            shape: vec![],
            values: vec![value],
        }
    }

    fn vector(values: Vec<f64>) -> Self {
        Self {
            shape: vec![values.len()],
            values,
        }
    }

    fn matrix(rows: usize, values: Vec<f64>) -> Self {
        Self {
            shape: vec![rows, values.len() / rows],
            values,
        }
    }
}

/// The arrays of a valid file: four contact nodes around the pole, two modes.
struct Arrays(Vec<(&'static str, Array)>);

impl Arrays {
    fn valid() -> Self {
        let (sin, cos) = HALF_ANGLE.sin_cos();
        let normals = [[sin, 0.0], [0.0, sin], [-sin, 0.0], [0.0, -sin]].map(|[x, y]| [x, y, cos]);
        let normals = normals.as_flattened().to_vec();
        let positions = normals.iter().map(|x| BALL * x).collect();
        let shapes = (0..24).map(f64::from).collect();
        Self(vec![
            ("positions", Array::matrix(4, positions)),
            ("normals", Array::matrix(4, normals)),
            ("areas", Array::vector(vec![1e-6; 4])),
            ("pre_stress", Array::vector(vec![0.25e6 * LOAD; 4])),
            ("stiffness", Array::vector(vec![1e13; 4])),
            ("shapes", cube([4, 3, 2], shapes)),
            ("omega", Array::vector(vec![1e4, 2e4])),
        ])
    }

    /// Replaces or adds an array.
    fn with(mut self, name: &'static str, array: Array) -> Self {
        self.0.retain(|(other, _)| *other != name);
        self.0.push((name, array));
        self
    }

    fn without(mut self, name: &str) -> Self {
        self.0.retain(|(other, _)| *other != name);
        self
    }

    /// Replaces a value of an array.
    fn set(mut self, name: &str, at: usize, value: f64) -> Self {
        let array = self.0.iter_mut().find(|(other, _)| *other == name);
        array.expect("an array of that name").1.values[at] = value;
        self
    }

    fn read(mut self) -> Result<ImportedModes, ImportedModesError> {
        ImportedModes::read(&mut self, "hip.npz")
    }

    /// Error message for an invalid file.
    fn rejection(self) -> String {
        self.read().expect_err("invalid").to_string()
    }
}

impl NamedArrays for Arrays {
    fn shape(&mut self, name: &str) -> Result<Option<Vec<usize>>, ArrayError> {
        let array = self.0.iter().find(|(other, _)| *other == name);
        Ok(array.map(|(_, array)| array.shape.clone()))
    }

    fn values(&mut self, name: &str) -> Result<Vec<f64>, ArrayError> {
        let array = self.0.iter().find(|(other, _)| *other == name);
        Ok(array.expect("its shape is known").1.values.clone())
    }
}

fn cube(shape: [usize; 3], values: Vec<f64>) -> Array {
    Array {
        shape: shape.to_vec(),
        values,
    }
}

#[test]
fn a_valid_file_is_read() {
    let modes = Arrays::valid().read().unwrap();
    assert_eq!((modes.nodes(), modes.modes()), (4, 2));
    assert_eq!(modes.omega(), [1e4, 2e4]);
    assert!((modes.ball_radius() - BALL).abs() < 1e-15);
    assert!((modes.patch_radius().powi(2) * std::f64::consts::PI - 4e-6).abs() < 1e-18);
    // In the file x, y, z of a mode are one row apart.
    assert_eq!(modes.shapes[0], [0.0, 2.0, 4.0]);
    assert_eq!(modes.shapes[7], [19.0, 21.0, 23.0]);
    assert!(modes.surface().is_none());
    let in_hertz = Arrays::valid()
        .without("omega")
        .with("frequencies_hz", Array::vector(vec![1000.0, 1000.0]))
        .with("version", Array::number(1.0));
    let omega = in_hertz.read().unwrap().omega;
    assert_eq!(omega, [1000.0 * std::f64::consts::TAU; 2]);
}

/// Vertices of a triangle on the surface of the ball.
fn corners() -> Vec<f64> {
    vec![BALL, 0.0, 0.0, 0.0, BALL, 0.0, 0.0, 0.0, BALL]
}

/// Values that are finite and positive, but inconsistent with a joint.
#[test]
fn implausible_magnitudes_are_reported_with_their_array() {
    let fast = |name, hz: [f64; 2]| {
        let plain = Arrays::valid().without("omega");
        plain.with(name, Array::vector(hz.to_vec())).rejection()
    };
    let message = fast("frequencies_hz", [1e4, 1.1e7]);
    assert!(
        message.starts_with("`frequencies_hz`[1] is 1.100e7 Hz"),
        "{message}"
    );
    let message = fast("omega", [1e9, 2e9]);
    assert!(message.starts_with("`omega`[0] is 1.592e8 Hz"), "{message}");
    for invalid in [
        Arrays::valid().set("shapes", 9, 1e6),
        Arrays::valid().set("shapes", 9, 1e300),
        Arrays::valid().set("stiffness", 2, 1e25),
    ] {
        let message = invalid.rejection();
        assert!(
            message.contains("`stiffness` times `areas` times the square of `shapes`"),
            "{message}"
        );
    }
    let message = Arrays::valid()
        .with("shapes", cube([4, 3, 2], vec![0.0; 24]))
        .rejection();
    assert!(
        message.starts_with("`shapes` contains zeros only"),
        "{message}"
    );
    let message = Arrays::valid()
        .with("probe", Array::vector(vec![0.0; 2]))
        .rejection();
    assert!(
        message.starts_with("`probe` contains zeros only: the probe signal would be zero"),
        "{message}"
    );
    for factor in [1e3, 1e-3, 1e30] {
        let vertices = corners().iter().map(|x| factor * x).collect();
        let surface = Arrays::valid()
            .with("surface_vertices", Array::matrix(3, vertices))
            .with("surface_triangles", Array::matrix(1, vec![0.0, 1.0, 2.0]))
            .with("surface_shapes", cube([3, 3, 2], vec![1.0; 18]));
        let message = surface.rejection();
        assert!(
            message.starts_with("`surface_vertices` have distances"),
            "{message}"
        );
    }
    let both = Arrays::valid()
        .with("mass", Array::matrix(1, vec![1.0]))
        .with("mass_data", Array::vector(vec![1.0]));
    let message = both.rejection();
    assert!(
        message.starts_with("the file contains both `mass` and `mass_data`"),
        "{message}"
    );
}

#[test]
fn a_surface_does_not_affect_the_motion() {
    let with_surface = || {
        Arrays::valid()
            .with("surface_vertices", Array::matrix(3, corners()))
            .with("surface_triangles", Array::matrix(1, vec![0.0, 1.0, 2.0]))
            .with(
                "surface_shapes",
                cube([3, 3, 2], (0..18).map(f64::from).collect()),
            )
    };
    let modes = with_surface().read().unwrap();
    let surface = modes.surface().unwrap();
    assert_eq!(surface.triangles, [[0, 1, 2]]);
    assert_eq!(surface.shapes_at(2)[1], [13.0, 15.0, 17.0]);
    let without = Arrays::valid().read().unwrap();
    assert_eq!(modes.fingerprint(), without.fingerprint());
    let other = Arrays::valid().set("shapes", 23, 23.5).read().unwrap();
    assert_ne!(other.fingerprint(), without.fingerprint());
    let message = with_surface().set("surface_triangles", 1, 3.0).rejection();
    assert!(
        message.contains("`surface_triangles`[0, 1] is 3"),
        "{message}"
    );
    let message = with_surface().without("surface_shapes").rejection();
    assert!(message.contains("`surface_shapes` is missing"), "{message}");
}

#[test]
fn missing_arrays_and_wrong_shapes_are_reported() {
    for name in [
        "positions",
        "normals",
        "areas",
        "pre_stress",
        "stiffness",
        "shapes",
        "omega",
    ] {
        let message = Arrays::valid().without(name).rejection();
        assert!(
            message.starts_with(&format!("the array `{name}` is missing; add")),
            "{message}"
        );
    }
    let shape = |name: &'static str, array: Array, words: &str| {
        let message = Arrays::valid().with(name, array).rejection();
        assert!(
            message.starts_with(&format!("`{name}`")) && message.contains(words),
            "{message}"
        );
    };
    // Some programs order modes before directions.
    shape(
        "shapes",
        cube([4, 2, 3], vec![1.0; 24]),
        "[4, 2, 3] instead of [4, 3, 2]; it must contain",
    );
    shape(
        "positions",
        Array::matrix(3, vec![1.0; 12]),
        "[3, 4] instead of [4, 3]",
    );
    shape(
        "pre_stress",
        Array::vector(vec![1.0; 3]),
        "[3] instead of [4]",
    );
    shape(
        "omega",
        Array::vector(vec![]),
        "one axis with a length of 1 to 128",
    );
    shape(
        "omega",
        Array::vector(vec![1e4; 129]),
        "one axis with a length of 1 to 128",
    );
    shape(
        "areas",
        Array::vector(vec![1e-9; 10_001]),
        "one axis with a length of 1 to 10000",
    );
    shape("areas", Array::matrix(2, vec![1e-6; 4]), "one axis");
    shape("probe", Array::vector(vec![1.0; 3]), "[3] instead of [2]");
    shape(
        "version",
        Array::number(2.0),
        "this program supports only 1",
    );
    let both = Arrays::valid().with("frequencies_hz", Array::vector(vec![1e3, 2e3]));
    assert!(both.rejection().contains("remove one of them"));
}

#[test]
fn invalid_values_are_reported_with_their_index() {
    let cases: [(&str, usize, f64, &str); 14] = [
        ("shapes", 13, f64::NAN, "`shapes`[2, 0, 1] is NaN"),
        ("omega", 1, f64::INFINITY, "`omega`[1] is inf"),
        ("areas", 2, 0.0, "`areas`[2] is 0; it must be above 0"),
        (
            "pre_stress",
            0,
            -1.0,
            "`pre_stress`[0] is -1; it must be above 0",
        ),
        ("stiffness", 3, 0.0, "`stiffness`[3] is 0"),
        ("omega", 0, 0.0, "`omega`[0] is 0"),
        ("omega", 0, -5.0, "`omega`[0] is -5"),
        ("omega", 0, 1.0, "a rigid-body mode; remove"),
        (
            "omega",
            1,
            9e3,
            "`omega`[1] is 1.432e3 Hz, below the previous value",
        ),
        ("normals", 2, 0.5, "`normals`[0] has the length 0.509"),
        (
            "positions",
            5,
            20e-3,
            "place the origin at the centre of the ball",
        ),
        ("areas", 0, 1.0, "exceeds the surface of the ball"),
        ("normals", 2, -HALF_ANGLE.cos(), "deviates by 168.5 deg"),
        (
            "positions",
            5,
            f64::NEG_INFINITY,
            "`positions`[1, 2] is -inf",
        ),
    ];
    for (name, at, value, words) in cases {
        let message = Arrays::valid().set(name, at, value).rejection();
        assert!(message.contains(words), "{message}");
    }
    // Positions in mm.
    let sound = Arrays::valid();
    let positions = sound.0[0].1.values.iter().map(|x| 1e3 * x).collect();
    let message = sound
        .with("positions", Array::matrix(4, positions))
        .rejection();
    assert!(message.contains("give them in m"), "{message}");
}

#[test]
fn the_pre_stress_balances_the_load() {
    let modes = Arrays::valid().read().unwrap();
    let pole = [0.0, 0.0, 1.0];
    // The sum of the pressures is the load; their vector sum is 0.5 % less.
    modes.check_load(LOAD, pole).unwrap();
    modes.check_load(0.995 * LOAD, pole).unwrap();
    for load in [0.98 * LOAD, 1.02 * LOAD] {
        let message = modes.check_load(load, pole).unwrap_err().to_string();
        assert!(message.contains("is 100.000000 N"), "{message}");
    }
    let tilted = |deg: f64| [0.0, deg.to_radians().sin(), deg.to_radians().cos()];
    modes.check_load(LOAD, tilted(0.09)).unwrap();
    let message = modes.check_load(LOAD, tilted(0.5)).unwrap_err().to_string();
    assert!(
        message.contains("differs by 0.500 deg from the load") && !message.contains("-0.000"),
        "{message}"
    );
}

/// Two mode shapes with three degrees of freedom that are orthonormal with respect to the mass matrix
/// `[[2, 1, 0], [1, 2, 0], [0, 0, 4]]`.
fn with_mass() -> Arrays {
    let [a, b] = [6.0_f64.sqrt().recip(), 0.5];
    Arrays::valid()
        .with("mass_data", Array::vector(vec![2.0, 1.0, 1.0, 2.0, 4.0]))
        .with("mass_indices", Array::vector(vec![0.0, 1.0, 0.0, 1.0, 2.0]))
        .with("mass_indptr", Array::vector(vec![0.0, 2.0, 4.0, 5.0]))
        .with("dof_shapes", Array::matrix(3, vec![a, 0.0, a, 0.0, 0.0, b]))
}

#[test]
fn shapes_are_orthonormal_with_the_mass_matrix() {
    with_mass().read().unwrap();
    let dense = || {
        let rows = vec![2.0, 1.0, 0.0, 1.0, 2.0, 0.0, 0.0, 0.0, 4.0];
        with_mass()
            .without("mass_data")
            .without("mass_indices")
            .without("mass_indptr")
            .with("mass", Array::matrix(3, rows))
    };
    dense().read().unwrap();
    for arrays in [with_mass, dense] {
        // Many programs normalise the largest component to 1.
        let message = arrays().set("dof_shapes", 5, 1.0).rejection();
        assert!(
            message.contains("shape 2, `mass`, shape 2 (from 1) gives 4.000000 instead of 1"),
            "{message}"
        );
        // Not orthogonal: 0.06 / sqrt(6), compared with 2 * 0.02^2 on the diagonal.
        let message = arrays().set("dof_shapes", 3, 0.02).rejection();
        assert!(
            message.contains("shape 1, `mass`, shape 2 (from 1) gives 0.024495 instead of 0"),
            "{message}"
        );
        assert!(
            arrays()
                .without("dof_shapes")
                .rejection()
                .contains("`dof_shapes` is missing")
        );
    }
}

#[test]
fn invalid_mass_matrices_are_rejected() {
    let refused = |arrays: Arrays, words: &str| {
        let message = arrays.rejection();
        assert!(message.contains(words), "{message}");
    };
    refused(
        with_mass().set("mass_indptr", 3, 4.0),
        "`mass_indptr` does not increase",
    );
    refused(
        with_mass().set("mass_indptr", 1, 5.0),
        "`mass_indptr` does not increase",
    );
    refused(with_mass().set("mass_indices", 0, 3.0), "and below 3");
    refused(
        with_mass().set("mass_indices", 0, -1.0),
        "`mass_indices`[0] is -1; it must be a whole number",
    );
    refused(
        with_mass().without("mass_indices"),
        "`mass_indices` is missing",
    );
    refused(
        with_mass().without("mass_indptr"),
        "`mass_indptr` is missing",
    );
    let wide = Array::matrix(2, vec![1.0; 6]);
    refused(
        Arrays::valid().with("mass", wide),
        "[2, 3] instead of [2, 2]",
    );
    let three = Array::matrix(3, vec![0.0; 9]);
    refused(
        with_mass().with("dof_shapes", three),
        "[3, 3] instead of [3, 2]",
    );
}

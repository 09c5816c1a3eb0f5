//! A file that is sound, and every way in which it can be unsound.

use std::fs::File;

use super::*;
use crate::numpy::{Array, encode_npz};

/// Radius of the ball, m; load, N; half-angle of the patch, rad.
const BALL: f64 = 16e-3;
const LOAD: f64 = 100.0;
const HALF_ANGLE: f64 = 0.1;

/// The arrays of a sound file: four contact nodes round the pole, two modes.
struct Arrays(Vec<(&'static str, Array)>);

impl Arrays {
    fn sound() -> Self {
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

    /// With another array of a name, or one more.
    fn with(mut self, name: &'static str, array: Array) -> Self {
        self.0.retain(|(other, _)| *other != name);
        self.0.push((name, array));
        self
    }

    fn without(mut self, name: &str) -> Self {
        self.0.retain(|(other, _)| *other != name);
        self
    }

    /// With another value at a place of an array.
    fn set(mut self, name: &str, at: usize, value: f64) -> Self {
        let array = self.0.iter_mut().find(|(other, _)| *other == name);
        array.expect("an array of that name").1.values[at] = value;
        self
    }

    fn read(self) -> Result<OwnModes, OwnModesError> {
        let file = tempfile::NamedTempFile::new().expect("a file");
        encode_npz(File::create(file.path()).expect("a file"), &self.0).expect("written");
        OwnModes::read(file.path(), "hip.npz")
    }

    /// What is said of an unsound file.
    fn refusal(self) -> String {
        self.read().expect_err("unsound").to_string()
    }
}

fn cube(shape: [usize; 3], values: Vec<f64>) -> Array {
    Array {
        shape: shape.to_vec(),
        values,
    }
}

#[test]
fn a_sound_file_is_what_it_says() {
    let modes = Arrays::sound().read().unwrap();
    assert_eq!((modes.nodes(), modes.modes()), (4, 2));
    assert_eq!(modes.omega(), [1e4, 2e4]);
    assert!((modes.ball_radius() - BALL).abs() < 1e-15);
    assert!((modes.patch_radius().powi(2) * std::f64::consts::PI - 4e-6).abs() < 1e-18);
    // Node by node all modes: x, y, z of a mode are a row apart in the file.
    assert_eq!(modes.shapes[0], [0.0, 2.0, 4.0]);
    assert_eq!(modes.shapes[7], [19.0, 21.0, 23.0]);
    assert!(modes.surface().is_none());
    let in_hertz = Arrays::sound()
        .without("omega")
        .with("frequencies_hz", Array::vector(vec![1000.0, 1000.0]))
        .with("version", Array::number(1.0));
    let omega = in_hertz.read().unwrap().omega;
    assert_eq!(omega, [1000.0 * std::f64::consts::TAU; 2]);
}

/// A triangle whose corners are as far from the origin as the ball's surface is.
fn corners() -> Vec<f64> {
    vec![BALL, 0.0, 0.0, 0.0, BALL, 0.0, 0.0, 0.0, BALL]
}

/// Each number is finite and of the right sign; it is together that they are those of no joint.
#[test]
fn magnitudes_that_no_joint_has_are_told_with_their_array() {
    let fast = |name, hz: [f64; 2]| {
        let plain = Arrays::sound().without("omega");
        plain.with(name, Array::vector(hz.to_vec())).refusal()
    };
    let said = fast("frequencies_hz", [1e4, 1.1e7]);
    assert!(
        said.starts_with("`frequencies_hz`[1] is 1.100e7 Hz"),
        "{said}"
    );
    let said = fast("omega", [1e9, 2e9]);
    assert!(said.starts_with("`omega`[0] is 1.592e8 Hz"), "{said}");
    for unsound in [
        Arrays::sound().set("shapes", 9, 1e6),
        Arrays::sound().set("shapes", 9, 1e300),
        Arrays::sound().set("stiffness", 2, 1e25),
    ] {
        let said = unsound.refusal();
        assert!(
            said.contains("`stiffness` times `areas` times the square of `shapes`"),
            "{said}"
        );
    }
    let said = Arrays::sound()
        .with("shapes", cube([4, 3, 2], vec![0.0; 24]))
        .refusal();
    assert!(said.starts_with("`shapes` is 0 throughout"), "{said}");
    let said = Arrays::sound()
        .with("probe", Array::vector(vec![0.0; 2]))
        .refusal();
    assert!(
        said.starts_with("`probe` is 0 throughout: nothing would be heard"),
        "{said}"
    );
    for factor in [1e3, 1e-3, 1e30] {
        let vertices = corners().iter().map(|x| factor * x).collect();
        let surface = Arrays::sound()
            .with("surface_vertices", Array::matrix(3, vertices))
            .with("surface_triangles", Array::matrix(1, vec![0.0, 1.0, 2.0]))
            .with("surface_shapes", cube([3, 3, 2], vec![1.0; 18]));
        let said = surface.refusal();
        assert!(said.starts_with("`surface_vertices` lie"), "{said}");
    }
    let both = Arrays::sound()
        .with("mass", Array::matrix(1, vec![1.0]))
        .with("mass_data", Array::vector(vec![1.0]));
    let said = both.refusal();
    assert!(
        said.starts_with("`mass` and `mass_data` are both there"),
        "{said}"
    );
}

#[test]
fn a_surface_is_for_pictures() {
    let with_surface = || {
        Arrays::sound()
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
    // The motion does not depend on it.
    let without = Arrays::sound().read().unwrap();
    assert_eq!(modes.fingerprint(), without.fingerprint());
    let other = Arrays::sound().set("shapes", 23, 23.5).read().unwrap();
    assert_ne!(other.fingerprint(), without.fingerprint());
    let said = with_surface().set("surface_triangles", 1, 3.0).refusal();
    assert!(said.contains("`surface_triangles`[0]"), "{said}");
    let said = with_surface().without("surface_shapes").refusal();
    assert!(said.contains("`surface_shapes` is missing"), "{said}");
}

#[test]
fn what_is_missing_or_of_another_shape_is_named() {
    for name in [
        "positions",
        "normals",
        "areas",
        "pre_stress",
        "stiffness",
        "shapes",
        "omega",
    ] {
        let said = Arrays::sound().without(name).refusal();
        assert!(
            said.starts_with(&format!("the array `{name}` is missing; add")),
            "{said}"
        );
    }
    let shape = |name: &'static str, array: Array, words: &str| {
        let said = Arrays::sound().with(name, array).refusal();
        assert!(
            said.starts_with(&format!("`{name}`")) && said.contains(words),
            "{said}"
        );
    };
    // Modes before directions, as some programs have them.
    shape(
        "shapes",
        cube([4, 2, 3], vec![1.0; 24]),
        "[4, 2, 3], not [4, 3, 2]; it is to hold",
    );
    shape(
        "positions",
        Array::matrix(3, vec![1.0; 12]),
        "[3, 4], not [4, 3]",
    );
    shape("pre_stress", Array::vector(vec![1.0; 3]), "[3], not [4]");
    shape("omega", Array::vector(vec![]), "one axis, of 1 to 128");
    shape(
        "omega",
        Array::vector(vec![1e4; 129]),
        "one axis, of 1 to 128",
    );
    shape(
        "areas",
        Array::vector(vec![1e-9; 10_001]),
        "one axis, of 1 to 10000",
    );
    shape("areas", Array::matrix(2, vec![1e-6; 4]), "one axis");
    shape("probe", Array::vector(vec![1.0; 3]), "[3], not [2]");
    shape("version", Array::number(2.0), "this program reads 1");
    let both = Arrays::sound().with("frequencies_hz", Array::vector(vec![1e3, 2e3]));
    assert!(both.refusal().contains("keep one of them"));
}

#[test]
fn values_that_cannot_be_are_told_with_their_place() {
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
        ("omega", 0, 1.0, "a rigid-body motion; leave these out"),
        ("omega", 1, 9e3, "`omega`[1] is below the one before; sort"),
        ("normals", 2, 0.5, "`normals`[0] has the length 0.509"),
        (
            "positions",
            5,
            20e-3,
            "put the origin into the ball's centre",
        ),
        ("areas", 0, 1.0, "more than the ball's surface"),
        ("normals", 2, -HALF_ANGLE.cos(), "is turned by 168.5 deg"),
        (
            "positions",
            5,
            f64::NEG_INFINITY,
            "`positions`[1, 2] is -inf",
        ),
    ];
    for (name, at, value, words) in cases {
        let said = Arrays::sound().set(name, at, value).refusal();
        assert!(said.contains(words), "{said}");
    }
    // Millimetres.
    let sound = Arrays::sound();
    let positions = sound.0[0].1.values.iter().map(|x| 1e3 * x).collect();
    let said = sound
        .with("positions", Array::matrix(4, positions))
        .refusal();
    assert!(said.contains("give them in m"), "{said}");
}

#[test]
fn the_pre_stress_must_be_that_of_the_load() {
    let modes = Arrays::sound().read().unwrap();
    let pole = [0.0, 0.0, 1.0];
    // As numbers the pressures add up to the load, as vectors to half a per cent less.
    modes.check_load(LOAD, pole).unwrap();
    modes.check_load(0.995 * LOAD, pole).unwrap();
    for load in [0.98 * LOAD, 1.02 * LOAD] {
        let said = modes.check_load(load, pole).unwrap_err().to_string();
        assert!(said.contains("adds up to 100.000000 N"), "{said}");
    }
    let tilted = |deg: f64| [0.0, deg.to_radians().sin(), deg.to_radians().cos()];
    modes.check_load(LOAD, tilted(0.09)).unwrap();
    let said = modes.check_load(LOAD, tilted(0.5)).unwrap_err().to_string();
    assert!(
        said.contains("0.500 deg from the load asked for") && !said.contains("-0.000"),
        "{said}"
    );
}

/// Two shapes of three degrees of freedom that are orthonormal with the mass matrix
/// `[[2, 1, 0], [1, 2, 0], [0, 0, 4]]`.
fn with_mass() -> Arrays {
    let [a, b] = [6.0_f64.sqrt().recip(), 0.5];
    Arrays::sound()
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
        // Largest component 1, as many programs scale shapes.
        let said = arrays().set("dof_shapes", 5, 1.0).refusal();
        assert!(
            said.contains("shape 2, `mass`, shape 2 (from 1) gives 4.000000, where 1 is due"),
            "{said}"
        );
        // Not orthogonal: 0.06 / sqrt(6) beside 2 * 0.02^2 on the diagonal.
        let said = arrays().set("dof_shapes", 3, 0.02).refusal();
        assert!(
            said.contains("shape 1, `mass`, shape 2 (from 1) gives 0.024495, where 0 is due"),
            "{said}"
        );
        assert!(
            arrays()
                .without("dof_shapes")
                .refusal()
                .contains("`dof_shapes` is missing")
        );
    }
}

#[test]
fn a_mass_matrix_is_one() {
    let refused = |arrays: Arrays, words: &str| {
        let said = arrays.refusal();
        assert!(said.contains(words), "{said}");
    };
    refused(
        with_mass().set("mass_indptr", 3, 4.0),
        "`mass_indptr` does not rise",
    );
    refused(
        with_mass().set("mass_indptr", 1, 5.0),
        "`mass_indptr` does not rise",
    );
    refused(with_mass().set("mass_indices", 0, 3.0), "beyond the rows");
    refused(
        with_mass().set("mass_indices", 0, -1.0),
        "something else than indices",
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
    refused(Arrays::sound().with("mass", wide), "[2, 3], not [2, 2]");
    let three = Array::matrix(3, vec![0.0; 9]);
    refused(with_mass().with("dof_shapes", three), "[3, 3], not [3, 2]");
}

//! Sweep tables: written and read in each format.

use super::table::*;
use crate::analysis::regime::Regime;
use crate::scene::{Parameter, Scene};
use crate::study::response::ResponsePlan;
use crate::study::sweep::tests::run;
use crate::study::sweep::{Axis, Place, Shard, Start, SweepPlan, SweepPoint};

/// A plan with one impossible point, and its points.
fn swept() -> (SweepPlan, Vec<SweepPoint>) {
    let scene = Scene::load("doubled-torus-3deg").unwrap();
    let plan = SweepPlan {
        subject: scene
            .with_values(&[(Parameter::named("nodes").unwrap(), 28.0)])
            .unwrap(),
        axes: vec![Axis::new(
            Parameter::named("socket.diameter_mm").unwrap(),
            [31.0, 31.9, 32.0],
        )],
        starts: vec![Start::Upward],
        response: ResponsePlan {
            min_transient_s: 0.02,
            max_transient_s: 0.02,
            measurement_s: 0.01,
            exponents: 2,
            orbits: false,
            portrait: true,
            max_rhs_evals: None,
        },
    };
    let points = run(&plan, Shard::WHOLE, Vec::new(), 1);
    assert!(points[0].outcome.is_err() && points[2].outcome.is_ok());
    (plan, points)
}

#[test]
fn a_growing_table_is_read_back_even_if_truncated() {
    let (plan, points) = swept();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sweep.arrows");
    let mut table = TableWriter::new(&path, &plan, &points[..1]).unwrap();
    table.add(&points[2]).unwrap();
    table.add(&points[1]).unwrap();
    // As after kill -9: the end of the stream is missing.
    let read = read_table(&path).unwrap();
    assert_eq!(read.points, [0, 2, 1].map(|k| points[k].clone()));
    assert!(!read.truncated && read.check(&plan, &path).is_ok());
    let whole = std::fs::read(&path).unwrap();
    std::fs::write(&path, &whole[..whole.len() - 100]).unwrap();
    let torn = read_table(&path).unwrap();
    assert_eq!((torn.points.len(), torn.truncated), (2, true));
    // Resume from the truncated table.
    let mut table = TableWriter::new(&path, &plan, &torn.points).unwrap();
    table.add(&points[1]).unwrap();
    assert_eq!(std::fs::read(&path).unwrap(), whole);
}

/// A finished table is sorted, so its bytes depend on the points alone.
#[test]
fn finished_tables_are_read_back_and_depend_on_the_points_alone() {
    let (plan, points) = swept();
    let folder = tempfile::tempdir().unwrap();
    for name in ["sweep.arrow", "sweep.parquet"] {
        let path = folder.path().join(name);
        let shuffled = [2, 0, 1].map(|k| points[k].clone());
        write_table(&path, &plan, &shuffled).unwrap();
        let sorted = std::fs::read(&path).unwrap();
        write_table(&path, &plan, &points).unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), sorted, "{name}");
        let read = read_table(&path).unwrap();
        assert_eq!(read.points, points, "{name}");
        assert!(read.check(&plan, &path).is_ok() && !read.truncated);
    }
}

/// A finished table of several batches, whose words differ.
#[test]
fn a_long_table_is_read_back() {
    let (plan, points) = swept();
    let folder = tempfile::tempdir().unwrap();
    let mut many: Vec<SweepPoint> = (0..2500).map(|k| points[k / 1200].clone()).collect();
    let name = &plan.axes[0].name;
    let plan = SweepPlan {
        axes: vec![Axis::new(
            name,
            (0..2500).map(|k| 31.0 + 1e-3 * f64::from(k)),
        )],
        ..plan
    };
    for (index, point) in many.iter_mut().enumerate() {
        point.place = plan.place(index);
        if let Ok(found) = &mut point.outcome {
            found.regime = [Regime::Silent, Regime::Chaotic, Regime::Noise][index / 1000];
        }
    }
    for name in ["sweep.arrow", "sweep.parquet"] {
        let path = folder.path().join(name);
        write_table(&path, &plan, &many).unwrap();
        assert_eq!(read_table(&path).unwrap().points, many, "{name}");
    }
}

#[test]
fn a_table_of_another_sweep_is_rejected_with_the_difference() {
    let (plan, points) = swept();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sweep.arrow");
    write_table(&path, &plan, &points).unwrap();
    let other = SweepPlan {
        starts: vec![Start::Downward],
        ..plan
    };
    let refused = read_table(&path).unwrap().check(&other, &path).unwrap_err();
    let words = refused.to_string();
    assert!(
        words.contains("`starts: upward` in the file and `starts: downward` in this sweep"),
        "{words}"
    );
    std::fs::write(&path, "no table").unwrap();
    assert!(matches!(read_table(&path), Err(TableError::Invalid(..))));
    let missing = read_table(&folder.path().join("missing"));
    assert!(matches!(missing, Err(TableError::Read(..))));
}

#[test]
fn a_row_that_does_not_match_the_plan_is_refused() {
    let (plan, points) = swept();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sweep.arrow");
    let changes: [fn(&mut Place); 4] = [
        // Outside the plan.
        |place| place.index = 7,
        // That of another row.
        |place| place.index = 1,
        |place| place.start = Start::Fresh,
        |place| place.named = [("socket.diameter_mm".to_owned(), 31.5)].into(),
    ];
    for change in changes {
        let mut points = points.clone();
        change(&mut points[2].place);
        write_table(&path, &plan, &points).unwrap();
        let refused = read_table(&path).unwrap_err();
        let TableError::Invalid(_, reason) = &refused else {
            panic!("{refused}");
        };
        assert!(reason.contains("does not match the plan"), "{reason}");
    }
}

#[test]
fn columns_of_one_value_come_first_and_state_their_units() {
    let (plan, _) = swept();
    let schema = super::table::schema(&plan).unwrap();
    let fields = schema.fields();
    let first_list = fields.iter().position(|f| f.data_type().is_nested());
    let (single, lists) = fields.split_at(first_list.unwrap());
    assert!(single.len() > 10 && !single.iter().any(|f| f.data_type().is_nested()));
    assert!(lists.iter().all(|f| f.data_type().is_nested()));
    let unit = |name: &str| {
        let field = schema.field_with_name(name).unwrap();
        field.metadata().get("unit").map(String::as_str)
    };
    assert_eq!(fields[2].name(), "socket.diameter_mm");
    for (name, expected) in [
        ("socket.diameter_mm", Some("mm")),
        ("amplitude_m", Some("m")),
        ("peak_velocity_m_per_s", Some("m/s")),
        ("frequency_hz", Some("Hz")),
        ("largest_exponent_per_s", Some("1/s")),
        ("largest_exponent_half_width_per_s", Some("1/s")),
        ("maxima_m", Some("m")),
        ("transient_s", Some("s")),
        ("confidence", None),
    ] {
        assert_eq!(unit(name), expected, "{name}");
    }
    assert!(!fields.iter().any(|f| f.name().ends_with("_rad")));
}

#[test]
fn a_csv_table_has_the_columns_of_one_value() {
    let (plan, points) = swept();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sweep.csv");
    write_table(&path, &plan, &points).unwrap();
    let mut csv = csv::Reader::from_path(&path).unwrap();
    let head = csv.headers().unwrap().clone();
    let schema = super::table::schema(&plan).unwrap();
    let single = schema
        .fields()
        .iter()
        .filter(|field| !field.data_type().is_nested());
    assert!(head.iter().eq(single.map(|field| field.name().as_str())));
    let rows: Vec<csv::StringRecord> = csv.records().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 3);
    let cell = |row: usize, name: &str| {
        let place = head.iter().position(|h| h == name).unwrap();
        rows[row][place].to_owned()
    };
    assert!(cell(0, "error").contains("socket.diameter_mm"));
    assert_eq!(cell(0, "amplitude_m"), "");
    let found = points[1].outcome.as_ref().unwrap();
    assert_eq!(cell(1, "socket.diameter_mm"), "31.9");
    assert_eq!(
        cell(1, "regime"),
        serde_json::to_value(found.regime).unwrap()
    );
    let exponent = found.exponents.as_ref().unwrap().exponents[0];
    for (name, value) in [
        ("amplitude_m", Some(found.amplitude_m)),
        (
            "frequency_hz",
            found.lines.first().map(|line| line.frequency),
        ),
        ("largest_exponent_per_s", Some(exponent.value)),
        (
            "largest_exponent_half_width_per_s",
            Some(exponent.half_width),
        ),
    ] {
        // A value that is not finite is empty.
        let finite = value.filter(|value| value.is_finite());
        assert_eq!(cell(1, name).parse().ok(), finite, "{name}");
    }
}

//! Sweep tables: written, read, merged.

use super::table::*;
use crate::scene::{Parameter, Scene};
use crate::study::response::ResponsePlan;
use crate::study::sweep::tests::run;
use crate::study::sweep::{Axis, Shard, Start, SweepPlan, SweepPoint};

/// A plan with one impossible point, and its points.
fn swept() -> (SweepPlan, Vec<SweepPoint>) {
    let scene = Scene::load("torus-3deg").unwrap();
    let plan = SweepPlan {
        scene: scene
            .with_values(&[(Parameter::named("nodes").unwrap(), 28.0)])
            .unwrap(),
        axes: vec![Axis::new(
            Parameter::named("socket.diameter_mm").unwrap(),
            [31.0, 31.9, 32.0],
        )],
        starts: vec![Start::Upward],
        response: ResponsePlan {
            min_transient: 0.02,
            max_transient: 0.02,
            measurement_time: 0.01,
            exponents: 2,
            portrait: true,
            max_rhs_evals: None,
        },
    };
    let points = run(&plan, Shard::WHOLE, &[], 1);
    assert!(points[0].outcome.is_err() && points[2].outcome.is_ok());
    (plan, points)
}

#[test]
fn a_table_is_read_back_even_if_truncated() {
    let (plan, points) = swept();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sweep.arrow");
    let mut table = TableWriter::new(&path, &plan.identity(), &points[..1]).unwrap();
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
    let mut table = TableWriter::new(&path, &torn.identity, &torn.points).unwrap();
    table.add(&points[1]).unwrap();
    assert_eq!(std::fs::read(&path).unwrap(), whole);
    // A finished table is sorted, so its bytes depend on the points alone.
    let mut shuffled = [2, 0, 1].map(|k| points[k].clone());
    write_table(&path, &plan.identity(), &mut shuffled).unwrap();
    let sorted = std::fs::read(&path).unwrap();
    write_table(&path, &plan.identity(), &mut points.clone()).unwrap();
    assert_eq!(std::fs::read(&path).unwrap(), sorted);
    assert_eq!(read_table(&path).unwrap().points, points);
}

#[test]
fn a_table_of_another_sweep_is_rejected_with_the_difference() {
    let (plan, points) = swept();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sweep.arrow");
    write_table(&path, &plan.identity(), &mut points.clone()).unwrap();
    let other = SweepPlan {
        starts: vec![Start::Downward],
        ..plan
    };
    let refused = read_table(&path).unwrap().check(&other, &path).unwrap_err();
    let words = refused.to_string();
    assert!(
        words.contains("`starts` is [\"upward\"] in the file and [\"downward\"] in this sweep"),
        "{words}"
    );
    std::fs::write(&path, "no table").unwrap();
    assert!(matches!(read_table(&path), Err(TableError::Invalid { .. })));
    let missing = read_table(&folder.path().join("missing"));
    assert!(matches!(missing, Err(TableError::Read { .. })));
}

#[test]
fn the_csv_table_has_a_cell_for_each_column() {
    let (plan, points) = swept();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sweep.csv");
    write_csv(&path, &plan, &points).unwrap();
    let mut csv = csv::Reader::from_path(&path).unwrap();
    let head = csv.headers().unwrap().clone();
    assert_eq!(&head[2], "socket.diameter_mm");
    let rows: Vec<csv::StringRecord> = csv.records().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 3);
    let cell = |row: usize, name: &str| {
        let place = head.iter().position(|h| h == name).unwrap();
        rows[row][place].to_owned()
    };
    assert!(cell(0, "error").contains("socket.diameter_mm"));
    let found = points[1].outcome.as_ref().unwrap();
    assert_eq!(cell(1, "regime"), found.regime.to_string());
    assert_eq!(cell(1, "unstable_modes"), "4");
    assert_eq!(cell(1, "amplitude_um"), (1e6 * found.amplitude).to_string());
    assert_eq!(
        cell(1, "exponent_2_per_s"),
        found.exponents.as_ref().unwrap().exponents[1]
            .value
            .to_string()
    );
}

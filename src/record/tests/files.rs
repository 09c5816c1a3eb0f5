//! A recording as a file: complete or absent, and errors of its path.

use super::*;

/// A sink with the records of a short run, for a path with an existing recording.
fn sink_for_existing_path(path: &Path) -> RerunSink {
    std::fs::write(path, "the old recording").unwrap();
    let mut sink = RerunSink::new(&to_file(path), demo::spec()).unwrap();
    for record in demo::records(0.005) {
        sink.accept(record).unwrap();
    }
    sink
}

#[test]
fn the_file_appears_only_when_complete() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.rrd");
    let mut sink = sink_for_existing_path(&path);
    assert_eq!(std::fs::read(&path).unwrap(), b"the old recording");
    sink.finish().unwrap();
    assert!(read(&path, paths::TIMELINE).0.contains_key(paths::VELOCITY));
    assert!(!folder.path().join("run.rrd.part").exists());
}

#[test]
fn a_failed_run_leaves_the_old_file_unchanged() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.rrd");
    let sink = sink_for_existing_path(&path);
    // The run fails: the pipeline drops the sink without finishing it.
    drop(sink);
    assert_eq!(std::fs::read(&path).unwrap(), b"the old recording");
    let part = folder.path().join("run.rrd.part");
    assert_eq!(
        read(&part, paths::TIMELINE).0[paths::VELOCITY].rows,
        demo::samples(0.005)
    );
}

#[test]
fn unwritable_paths_are_rejected_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let missing = folder.path().join("no such folder").join("run.rrd");
    for path in [missing, folder.path().to_owned(), PathBuf::from("/")] {
        let error = RerunSink::new(&to_file(&path), demo::spec()).unwrap_err();
        assert!(matches!(error, RecordError::Create { .. }), "{error:?}");
        assert!(error.to_string().contains(&path.display().to_string()));
    }
    let error = RerunSink::new(&Output::default(), demo::spec()).unwrap_err();
    assert!(matches!(error, RecordError::NoOutput));
}

#[test]
fn a_missing_viewer_is_an_error_before_a_file_is_created() {
    // A port that is not in use.
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    drop(listener);
    let folder = tempfile::tempdir().unwrap();
    let url = |address: String| Output {
        connect: Some(address),
        ..to_file(folder.path().join("run.rrd"))
    };
    let unused = url(format!("rerun+http://127.0.0.1:{port}/proxy"));
    let error = RerunSink::new(&unused, demo::spec()).unwrap_err();
    assert!(matches!(error, RecordError::Viewer { .. }), "{error:?}");
    let error = RerunSink::new(&url("not an address".to_owned()), demo::spec()).unwrap_err();
    assert!(matches!(error, RecordError::Address { .. }), "{error:?}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn a_lost_viewer_does_not_affect_the_file() {
    // A server that accepts the connection and closes it; it is not a viewer.
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    let hang_up = std::thread::spawn(move || drop(listener.accept()));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.rrd");
    let output = Output {
        connect: Some(format!("rerun+http://{address}/proxy")),
        ..to_file(&path)
    };
    let (notice, notices) = std::sync::mpsc::channel();
    let sink = RerunSink::new(&output, demo::spec()).unwrap();
    let mut sink = sink.with_notice(move |text| notice.send(text.to_owned()).unwrap());
    hang_up.join().unwrap();
    for record in demo::records(0.005) {
        sink.accept(record).unwrap();
    }
    sink.finish().unwrap();
    assert!(notices.try_recv().unwrap().contains("the viewer at"));
    assert_eq!(
        read(&path, paths::TIMELINE).0[paths::VELOCITY].rows,
        demo::samples(0.005)
    );
}

#[test]
fn records_need_a_header_first() {
    let folder = tempfile::tempdir().unwrap();
    let mut sink = RerunSink::new(&to_file(folder.path().join("run.rrd")), demo::spec()).unwrap();
    let error = sink.accept(Record::Health(Health::default())).unwrap_err();
    assert!(error.to_string().contains("header"), "{error}");
}

#[test]
fn a_file_requires_complete_delivery() {
    let folder = tempfile::tempdir().unwrap();
    let sink = RerunSink::new(&to_file(folder.path().join("run.rrd")), demo::spec()).unwrap();
    assert!(!sink.may_skip_pictures());
}

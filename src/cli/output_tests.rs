//! Checks of outputs before work starts.

use std::io::Write;

use super::*;
use crate::cli::error::CliError;
use crate::export::replace_file;

const KEEP: Overwrite = Overwrite { force: false };

fn names_in(folder: &Path) -> usize {
    fs::read_dir(folder).expect("a folder").count()
}

/// The message of a refusal.
fn refused<T>(found: Result<T, OutputError>) -> String {
    found.map(drop).expect_err("refused").to_string()
}

#[test]
fn checks_change_nothing_and_writing_replaces_complete_files() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("out.json");
    let file = check_file(&path, "--json").expect("writable");
    assert_eq!(names_in(folder.path()), 0);
    replace_file(&file, |out| out.write_all(b"first")).expect("written");
    let failed = replace_file(&file, |out| {
        out.write_all(b"half")?;
        Err(io::Error::other("disk full"))
    });
    assert_eq!(CliError::from(failed.expect_err("failed")).exit_code(), 1);
    assert_eq!(fs::read(&path).expect("there"), b"first");
    replace_file(&file, |out| out.write_all(b"second")).expect("written");
    assert_eq!(fs::read(&path).expect("there"), b"second");
    assert_eq!(names_in(folder.path()), 1);
}

#[test]
fn paths_that_cannot_be_files_are_refused() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let check = |path: &Path| check_file(path, "--save");
    assert!(refused(check(folder.path())).contains("is not a regular file"));
    for path in ["absent/", ".."] {
        let path = folder.path().join(path);
        assert!(refused(check(&path)).contains("is not a regular file"));
    }
    assert!(refused(check(Path::new(""))).contains("is not a regular file"));
    let lost = check(&folder.path().join("absent/out.rrd")).expect_err("no such folder");
    assert!(matches!(lost, OutputError::NotWritable { .. }));
    assert!(lost.is_bad_input());
    assert!(lost.to_string().contains("(--save)"));
    #[cfg(unix)]
    assert!(refused(check(Path::new("/dev/null"))).contains("is not a regular file"));
}

#[test]
fn directories_may_exist_but_files_of_that_name_are_refused() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let file = folder.path().join("file");
    fs::write(&file, "x").expect("written");
    let check = |path: &Path| KEEP.check_directory(path, "--png", &["figure.png"]);
    check(folder.path()).expect("there");
    check(&folder.path().join("new/figures")).expect("can be made");
    let back = folder.path().join("new/../figures");
    for path in [&file, &file.join("figures"), &back, Path::new("")] {
        let error = check(path).expect_err("no directory");
        assert!(error.to_string().contains("is not a directory"));
    }
    assert_eq!(names_in(folder.path()), 1);
}

#[test]
fn a_new_directory_and_a_file_cannot_share_a_path() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let [new, below] = ["new", "new/figures"].map(|name| folder.path().join(name));
    let file = check_file(&new, "--csv").expect("writable");
    for directory in [&new, &below] {
        let clash = check_apart(directory, "--png", &[("--csv", file.clone())]);
        assert!(refused(clash).contains("is used for two outputs"));
    }
    let other = folder.path().join("other");
    check_apart(&other, "--png", &[("--csv", file)]).expect("apart");
}

#[test]
fn protected_files_and_long_names_are_refused_in_directories_too() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("kept.png");
    fs::write(&path, "old").expect("written");
    let mut permissions = path.metadata().expect("there").permissions();
    permissions.set_readonly(true);
    fs::set_permissions(&path, permissions).expect("protected");
    for refused in [
        check_file(&path, "--png").map(drop),
        Overwrite::ALLOWED.check_directory(folder.path(), "--png", &["new.png", "kept.png"]),
    ] {
        let refused = refused.expect_err("protected");
        assert!(
            refused.to_string().contains("is write-protected"),
            "{refused}"
        );
        assert!(refused.is_bad_input());
    }
    KEEP.check_directory(folder.path(), "--png", &["new.png"])
        .expect("free");
    let long = folder.path().join("x".repeat(255));
    let longer = folder.path().join("x".repeat(256));
    for refused in [
        check_file(&long, "--png").map(drop),
        KEEP.check_directory(&longer, "--png", &["new.png"]),
        KEEP.check_directory(&longer.join("new"), "--png", &["new.png"]),
    ] {
        let refused = refused.expect_err("too long");
        assert!(
            refused
                .to_string()
                .contains("is too long for the file system"),
            "{refused}"
        );
    }
    check_file(&folder.path().join("x".repeat(247)), "--png").expect("fits");
}

#[cfg(unix)]
#[test]
fn a_link_stays_and_its_target_is_replaced() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let (file, link) = (folder.path().join("file"), folder.path().join("link"));
    fs::write(&file, "old").expect("written");
    std::os::unix::fs::symlink(&file, &link).expect("linked");
    let output = check_file(&link, "--json").expect("writable");
    replace_file(&output, |out| out.write_all(b"new")).expect("written");
    assert_eq!(fs::read(&file).expect("there"), b"new");
    assert!(fs::symlink_metadata(&link).expect("there").is_symlink());
}

#[test]
fn two_outputs_cannot_share_a_path() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("out.csv");
    let outputs = ["--csv", "--out"].map(|option| (option, Kind::CSV, path.clone()));
    let twice = KEEP.check_all(None, &outputs);
    let missing = folder.path().join("new.toml");
    let detour = folder.path().join(".").join("new.toml");
    let two_names = [
        ("--write", Kind::SCENE, missing.clone()),
        ("--best", Kind::SCENE, detour.clone()),
    ];
    let error = KEEP
        .check_all(None, &two_names)
        .expect_err("the same file, not there yet");
    assert!(error.to_string().contains("is used for two outputs"));
    fs::write(&missing, "a scene").expect("written");
    let onto_scene = [("--write", Kind::SCENE, detour)];
    let error = Overwrite::ALLOWED.check_all(Some(missing.as_os_str()), &onto_scene);
    assert!(refused(error).contains("is the input"));
    let message = twice.expect_err("refused").to_string();
    assert!(message.contains("two outputs (--out, --csv)"), "{message}");
}

#[test]
fn existing_files_are_replaced_by_force_only() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("there.rrd");
    fs::write(&path, "kept").expect("written");
    let check = |overwrite: Overwrite, kind| {
        overwrite
            .check_all(None, &[("--save", kind, path.clone())])
            .map(drop)
    };
    let refused = check(KEEP, Kind::RECORDING).expect_err("exists");
    assert!(refused.is_bad_input());
    let message = refused.to_string();
    assert!(
        message.contains("there.rrd") && message.contains("--force"),
        "{message}"
    );
    check(Overwrite::ALLOWED, Kind::RECORDING).expect("forced");
    check(KEEP.or(true), Kind::RECORDING).expect("resumed");
    check(KEEP, Kind::RECORDING.replaced()).expect("a default");
    for overwrite in [KEEP, Overwrite::ALLOWED] {
        let names = ["new.rrd", "there.rrd"];
        let checked = overwrite.check_directory(folder.path(), "--figures", &names);
        assert_eq!(checked.is_ok(), overwrite.force);
    }
    assert_eq!(fs::read(&path).expect("there"), b"kept");
}

#[test]
fn endings_fit_the_kind_of_file() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let check = |name: &str, kind| {
        let path = folder.path().join(name);
        KEEP.check_all(None, &[("--out", kind, path)]).map(drop)
    };
    check("a.rrd", Kind::RECORDING).expect("fits");
    check("a.RRD", Kind::RECORDING).expect("fits");
    check("a.svg", Kind::FIGURE).expect("fits");
    for name in ["a", "a.json", "rrd", "a.rrd.txt"] {
        let refused = check(name, Kind::RECORDING).expect_err("does not fit");
        assert!(refused.is_bad_input());
        assert!(refused.to_string().contains("ends in .rrd"), "{refused}");
    }
    let several = check("a.txt", Kind::FIGURE).expect_err("does not fit");
    assert!(
        several.to_string().contains(".png or .svg or .pdf"),
        "{several}"
    );
    let picture = folder.path().join("a.png");
    let directory = KEEP.check_directory(&picture, "--figures", &["b.png"]);
    assert!(refused(directory).contains("is to be a directory"));
}

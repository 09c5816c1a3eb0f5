//! Checks of outputs before work starts.

use std::io::Write;

use super::*;
use crate::cli::figures::{FigureArgs, PIXELS};
use crate::cli::harness::{OutputArgs, Outputs};
use crate::export::replace_file;

fn names_in(folder: &Path) -> usize {
    fs::read_dir(folder).expect("a folder").count()
}

/// The message of a refusal.
fn message<T>(found: Result<T, CliError>) -> String {
    let refused = found.map(drop).expect_err("refused");
    assert_eq!(refused.exit_code(), 2);
    refused.to_string()
}

/// Checks files of the same command, beside an input.
fn check_all<const N: usize>(
    force: bool,
    input: Option<&Path>,
    files: [(&'static str, Kind, &Path); N],
) -> Result<(), CliError> {
    let mut args = OutputArgs::default();
    args.overwrite.force = force;
    let outputs = Outputs::new(input.map(Path::as_os_str), &args);
    let mut files = files.into_iter();
    let all = files.try_fold(outputs, |all, (option, kind, path)| {
        all.file(option, kind, Some(path))
    });
    all.map(drop)
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
        Err::<(), _>(io::Error::other("disk full"))
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
    assert!(message(check(folder.path())).contains("is not a regular file"));
    for path in ["absent/", ".."] {
        let path = folder.path().join(path);
        assert!(message(check(&path)).contains("is not a regular file"));
    }
    assert!(message(check(Path::new(""))).contains("is not a regular file"));
    let lost = message(check(&folder.path().join("absent/out.rrd")));
    assert!(lost.contains("(--save): no file can be created"), "{lost}");
    #[cfg(unix)]
    assert!(message(check(Path::new("/dev/null"))).contains("is not a regular file"));
}

#[test]
fn directories_may_exist_but_files_of_that_name_are_refused() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let file = folder.path().join("file");
    fs::write(&file, "x").expect("written");
    let check = |path: &Path| check_directory(path, "--png", &["figure.png"], false);
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
    let [new, below, other] =
        ["new.csv", "new.csv/figures", "other"].map(|name| folder.path().join(name));
    let check = |directory: &Path| {
        let (args, mut figures) = (OutputArgs::default(), FigureArgs::default());
        figures.path = Some(directory.to_owned());
        let outputs = Outputs::new(None, &args).file("--csv", Kind::CSV, Some(&new))?;
        outputs.figures(&figures, PIXELS, ["a"]).map(drop)
    };
    for directory in [&new, &below] {
        assert!(message(check(directory)).contains("is used for two outputs (--figures, --csv)"));
    }
    check(&other).expect("apart");
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
        check_directory(folder.path(), "--png", &["new.png", "kept.png"], true),
    ] {
        let refused = message(refused);
        assert!(refused.contains("is write-protected"), "{refused}");
    }
    check_directory(folder.path(), "--png", &["new.png"], false).expect("free");
    let long = folder.path().join("x".repeat(255));
    let longer = folder.path().join("x".repeat(256));
    for refused in [
        check_file(&long, "--png").map(drop),
        check_directory(&longer, "--png", &["new.png"], false),
        check_directory(&longer.join("new"), "--png", &["new.png"], false),
    ] {
        let refused = message(refused);
        let reason = "is too long for the file system";
        assert!(refused.contains(reason), "{refused}");
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
    let twice = ["--csv", "--out"].map(|option| (option, Kind::CSV, &*path));
    let twice = message(check_all(false, None, twice));
    assert!(twice.contains("two outputs (--out, --csv)"), "{twice}");
    let missing = folder.path().join("new.toml");
    let detour = folder.path().join(".").join("new.toml");
    // The same file, not there yet.
    let two_names = [
        ("--write", Kind::SCENE, &*missing),
        ("--best", Kind::SCENE, &*detour),
    ];
    let error = message(check_all(false, None, two_names));
    assert!(error.contains("is used for two outputs"), "{error}");
    fs::write(&missing, "a scene").expect("written");
    let onto_scene = [("--write", Kind::SCENE, &*detour)];
    let error = message(check_all(true, Some(&missing), onto_scene));
    assert!(error.contains("is the input"), "{error}");
}

#[test]
fn existing_files_are_replaced_by_force_only() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("there.rrd");
    fs::write(&path, "kept").expect("written");
    let check = |force, kind| check_all(force, None, [("--save", kind, &*path)]);
    let refused = message(check(false, Kind::RECORDING));
    assert!(
        refused.contains("there.rrd") && refused.contains("--force"),
        "{refused}"
    );
    check(true, Kind::RECORDING).expect("forced");
    check(false, Kind::DEFAULT_RECORDING).expect("a default");
    for force in [false, true] {
        let names = ["new.rrd", "there.rrd"];
        let checked = check_directory(folder.path(), "--figures", &names, force);
        assert_eq!(checked.is_ok(), force);
    }
    assert_eq!(fs::read(&path).expect("there"), b"kept");
}

#[test]
fn endings_fit_the_kind_of_file() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let check = |name: &str, kind| {
        let path = folder.path().join(name);
        check_all(false, None, [("--out", kind, &*path)])
    };
    check("a.rrd", Kind::RECORDING).expect("fits");
    check("a.RRD", Kind::RECORDING).expect("fits");
    check("a.svg", Kind::FIGURE).expect("fits");
    for name in ["a", "a.json", "rrd", "a.rrd.txt"] {
        let refused = message(check(name, Kind::RECORDING));
        assert!(refused.contains("ends in .rrd"), "{refused}");
    }
    let several = message(check("a.txt", Kind::FIGURE));
    assert!(several.contains(".png or .svg or .pdf"), "{several}");
    let picture = folder.path().join("a.png");
    let directory = check_directory(&picture, "--figures", &["b.png"], false);
    assert!(message(directory).contains("is to be a directory"));
}

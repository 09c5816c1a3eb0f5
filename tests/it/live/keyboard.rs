//! The page by keyboard, by touch and for screen readers.

use std::path::PathBuf;
use std::process::Command;

use serde_json::{Value, json};

use super::Live;
use super::browser::{Browser, Tab};
use super::page::{PANEL, opened};

/// The name of the element with the focus.
const FOCUSED: &str =
    "(({ id, tagName, textContent }) => id || `${tagName} ${textContent}`)(document.activeElement)";

#[test]
fn tab_visits_every_control() {
    let live = Live::start("doubled-torus-3deg", &["--no-lyapunov"]);
    let Some((mut browser, tab)) = opened(&live) else {
        return;
    };
    browser.until(&tab, "document.getElementById('scene').options.length > 1");
    // Each element that takes the focus is visible and has an outline.
    let mut visited = Vec::new();
    for _ in 0..80 {
        browser.press(&tab, "Tab");
        let focused = browser.run(&tab, FOCUSED).as_str().unwrap().to_owned();
        if focused.starts_with("BODY") {
            break;
        }
        let outline = "getComputedStyle(document.activeElement).outlineStyle !== 'none' && \
             document.activeElement.getBoundingClientRect().width > 0";
        assert_eq!(browser.run(&tab, outline), true, "{focused}");
        visited.push(focused);
    }
    for id in [
        "scene",
        "load.tilt_deg",
        "pause",
        "kick",
        "speed",
        "listen",
        "record",
    ] {
        assert!(
            visited.iter().any(|name| name == id),
            "{id} is not in {visited:?}"
        );
    }
    assert_eq!(browser.errors, [""; 0]);
}

#[test]
fn shortcuts_act_while_no_control_has_the_focus() {
    let live = Live::start("doubled-torus-3deg", &["--no-lyapunov"]);
    let Some((mut browser, tab)) = opened(&live) else {
        return;
    };
    browser.until(&tab, "document.getElementById('scene').options.length > 1");
    // Space presses the button with the focus, and does not pause.
    browser.run(&tab, "document.getElementById('kick').focus()");
    browser.press(&tab, " ");
    browser.until(
        &tab,
        &format!("{PANEL}.events.some((e) => e.text.startsWith('kick'))"),
    );
    assert_eq!(browser.run(&tab, &format!("{PANEL}.paused")), false);
    // Arrows move the slider with the focus; without one they are shortcuts.
    browser.run(&tab, "document.getElementById('speed').focus()");
    browser.press(&tab, "ArrowLeft");
    assert_eq!(
        browser.run(
            &tab,
            &format!("{PANEL}.events.some((e) => e.text.startsWith('tilt'))")
        ),
        false
    );
    browser.press(&tab, "Escape");
    assert_eq!(
        browser.run(&tab, "document.activeElement === document.body"),
        true
    );
    browser.press(&tab, " ");
    browser.until(&tab, &format!("{PANEL}.paused"));
    // While paused, the label follows the slider.
    browser.press(&tab, "ArrowRight");
    browser.until(
        &tab,
        "document.getElementById('load.tilt_deg-now').textContent === '3.10°'",
    );
    // The list of the shortcuts, and shortcuts switched off.
    browser.press(&tab, "?");
    browser.until(&tab, "document.getElementById('help').open");
    browser.press(&tab, "Escape");
    browser.until(&tab, "!document.getElementById('help').open");
    browser.run(
        &tab,
        "document.getElementById('shortcuts-on').click(); document.activeElement.blur()",
    );
    browser.press(&tab, "h");
    assert_eq!(
        browser.run(&tab, "document.body.classList.contains('alone')"),
        false
    );
    browser.run(
        &tab,
        "document.getElementById('shortcuts-on').click(); document.activeElement.blur()",
    );
    // A hidden panel leaves its button visible.
    browser.press(&tab, "h");
    assert_eq!(
        browser.run(&tab, "document.body.classList.contains('alone')"),
        true
    );
    browser.click(&tab, "panel-toggle");
    assert_eq!(
        browser.run(&tab, "document.body.classList.contains('alone')"),
        false
    );
    assert_eq!(browser.errors, [""; 0]);
}

#[test]
fn a_phone_controls_the_run_by_touch() {
    let live = Live::start("doubled-torus-3deg", &["--no-lyapunov"]);
    let Some((mut browser, tab)) = opened(&live) else {
        return;
    };
    browser.resize(&tab, [390, 844]);
    browser.until(&tab, "document.documentElement.scrollWidth <= innerWidth");
    browser.touch(&tab, "pause");
    browser.until(&tab, &format!("{PANEL}.paused"));
    // A finger on the middle of the slider.
    browser.touch(&tab, "load.tilt_deg");
    browser.until(
        &tab,
        "Math.abs(Number(document.getElementById('load.tilt_deg').value) - 5) < 0.3",
    );
    browser.touch(&tab, "pause");
    browser.until(
        &tab,
        &format!("!{PANEL}.paused && Math.abs({PANEL}.tilt_deg - 5) < 0.3"),
    );
    assert_eq!(browser.errors, [""; 0]);
}

/// The source of axe-core, fetched by npm for this test; `None` without npm or its registry.
fn axe() -> Option<String> {
    if let Some(named) = std::env::var_os("SQUEAKSCOPE_AXE") {
        return Some(std::fs::read_to_string(PathBuf::from(named)).expect("axe.min.js"));
    }
    let folder = tempfile::tempdir().ok()?;
    let fetched = Command::new("npm")
        .args([
            "install",
            "--no-save",
            "--no-audit",
            "--no-fund",
            "axe-core@4",
        ])
        .current_dir(folder.path())
        .output()
        .ok()?;
    if !fetched.status.success() {
        return None;
    }
    std::fs::read_to_string(folder.path().join("node_modules/axe-core/axe.min.js")).ok()
}

/// The violations that axe finds on the page, of all its rules or of some.
fn violations(browser: &mut Browser, tab: &Tab, rules: &str) -> Value {
    let script = format!(
        "axe.run(document, {{ resultTypes: ['violations'], {rules} }}).then(({{ violations }}) => violations.map(\
         ({{ id, help, nodes }}) => [id, help, nodes.map(({{ target, failureSummary }}) => [target, failureSummary])]))"
    );
    browser.run(tab, &script)
}

/// Contrast of text, names and roles of controls and much more; the contrast in both themes.
#[test]
fn axe_finds_no_violation() {
    let live = Live::start("doubled-torus-3deg", &["--speed", "100", "--no-lyapunov"]);
    let Some((mut browser, tab)) = opened(&live) else {
        return;
    };
    let Some(axe) = axe() else {
        eprintln!(
            "skipped: no axe-core (npm and its registry, or set SQUEAKSCOPE_AXE to axe.min.js)"
        );
        return;
    };
    browser.run(&tab, &axe);
    browser.until(&tab, &format!("{PANEL}.lesson && {PANEL}.lines.length"));
    let click = |id: &str| format!("document.getElementById('{id}').click()");
    for (theme, rules) in [("dark", ""), ("light", "runOnly: ['color-contrast']")] {
        assert_eq!(
            browser.run(&tab, "document.documentElement.dataset.theme"),
            theme
        );
        for (what, open, close) in [
            ("page", String::new(), String::new()),
            (
                "share",
                click("share-open"),
                "document.getElementById('share').close()".to_owned(),
            ),
            (
                "help",
                click("help-open"),
                "document.getElementById('help').close()".to_owned(),
            ),
            ("sound", click("listen"), click("listen")),
            ("comparison", click("compare"), click("compare")),
            ("tour", click("tour-start"), click("tour-end")),
        ] {
            browser.run(&tab, &open);
            browser.until(&tab, "new Promise((ok) => setTimeout(() => ok(true), 300))");
            let found = violations(&mut browser, &tab, rules);
            assert_eq!(found, json!([]), "{what}, {theme}");
            browser.run(&tab, &close);
        }
        browser.run(&tab, &click("theme"));
    }
}

//! The real page in a real browser.

use serde_json::json;

use super::browser::{Browser, Tab, chromium};
use super::{Live, tilt};

/// A browser with the page of a run after its panel has received data; `None` without a browser.
pub fn opened(live: &Live) -> Option<(Browser, Tab)> {
    let Some(program) = chromium() else {
        eprintln!("skipped: no Chromium (apt-get install chromium, or set SQUEAKSCOPE_CHROMIUM)");
        return None;
    };
    let mut browser = Browser::start(&program);
    let tab = browser.open(&format!("http://{}/{}", live.host, live.query));
    browser.until(&tab, "Boolean(window.squeakscope?.state.panel?.run)");
    Some((browser, tab))
}

/// JavaScript expression for the state of the panel.
pub const PANEL: &str = "squeakscope.state.panel";

#[test]
fn user_input_on_the_page_controls_the_run() {
    let live = Live::start("doubled-torus-3deg", &[]);
    let Some((mut browser, tab)) = opened(&live) else {
        return;
    };
    let mut control = live.socket("/control");
    // The slider.
    browser.run(
        &tab,
        "{ const s = document.getElementById('load.tilt_deg'); s.value = 4.5; \
           s.dispatchEvent(new Event('input')); s.dispatchEvent(new Event('change')); }",
    );
    control.panel(|panel| panel["tilt_deg"] == 4.5);
    browser.until(&tab, &format!("{PANEL}.tilt_deg === 4.5"));
    // Keys: tilt, pause, playback speed.
    browser.press(&tab, "ArrowRight");
    control.panel(|panel| {
        panel["tilt_deg"]
            .as_f64()
            .is_some_and(|deg| (deg - 4.6).abs() < 1e-6)
    });
    browser.press(&tab, " ");
    control.panel(|panel| panel["paused"] == true);
    browser.until(
        &tab,
        "document.getElementById('pause').textContent === 'Resume'",
    );
    let stopped = browser.run(&tab, &format!("{PANEL}.time_s"));
    std::thread::sleep(std::time::Duration::from_millis(400));
    let still = browser.run(&tab, &format!("{PANEL}.time_s"));
    let elapsed = still.as_f64().unwrap() - stopped.as_f64().unwrap();
    assert!(
        elapsed < 2e-3,
        "{elapsed} s of simulated time elapsed while paused"
    );
    browser.press(&tab, " ");
    control.panel(|panel| panel["paused"] == false);
    browser.press(&tab, "1");
    control.panel(|panel| panel["speed"] == 1e-3);
    // A rejection is displayed.
    browser.run(
        &tab,
        "squeakscope.ask({ do: 'set', key: 'tilt_deg', value: 99 })",
    );
    browser.until(&tab, "!document.getElementById('refused').hidden");
    // Another scene, from the list.
    browser.run(
        &tab,
        "{ const s = document.getElementById('scene'); s.value = 'mass-on-belt'; \
           s.dispatchEvent(new Event('change')); }",
    );
    browser.until(
        &tab,
        &format!("{PANEL}.run === 2 && {PANEL}.scene === 'mass-on-belt'"),
    );
    browser.until(&tab, "document.getElementById('load.tilt_deg') === null");
    // The light theme persists when the page is reloaded.
    let theme = "document.documentElement?.dataset.theme";
    assert_eq!(browser.run(&tab, theme), "dark");
    browser.press(&tab, "l");
    assert_eq!(browser.run(&tab, theme), "light");
    browser.reload(&tab);
    browser.until(
        &tab,
        &format!("{theme} === 'light' && window.squeakscope?.state.panel?.run === 2"),
    );
    assert_eq!(browser.errors, [""; 0]);
}

#[test]
fn the_page_tells_about_the_run_and_audio_arrives() {
    let live = Live::start("doubled-torus-3deg", &[]);
    let Some((mut browser, tab)) = opened(&live) else {
        return;
    };
    // The rows of the diagram below the slider, the text on the present motion, and the speed that is reached.
    browser.until(&tab, "document.querySelectorAll('#bands .band').length > 1");
    browser.until(
        &tab,
        "document.getElementById('words').textContent.length > 20",
    );
    browser.until(
        &tab,
        "/^0\\.0\\d+ × real time/.test(document.getElementById('measured_speed').textContent)",
    );
    browser.until(
        &tab,
        "document.getElementById('watching').textContent === '1 page shows this run'",
    );
    browser.press(&tab, "m");
    browser.until(&tab, "squeakscope.sound.samples > 4800");
    // At true pitch, or as it runs.
    let heard =
        |words: &str| format!("document.getElementById('audio').textContent.includes('{words}')");
    browser.until(&tab, &heard("at true pitch: the last"));
    browser.until(&tab, "document.getElementById('level').value > 0.1");
    browser.run(
        &tab,
        "{ const p = document.getElementById('pitch'); p.value = 'run'; p.dispatchEvent(new Event('change')); }",
    );
    browser.until(&tab, &heard("slowed down"));
    // No other server was contacted.
    let own = [
        format!("http://{}/", live.host),
        format!("ws://{}/", live.host),
    ];
    for url in &browser.requested {
        let local = ["data:", "blob:"]
            .iter()
            .any(|scheme| url.starts_with(scheme));
        assert!(local || own.iter().any(|own| url.starts_with(own)), "{url}");
    }
    assert!(browser.requested.len() > 5);
}

#[test]
fn a_second_page_shares_the_run() {
    let live = Live::start("mass-on-belt", &[]);
    let Some((mut browser, first)) = opened(&live) else {
        return;
    };
    let second = browser.open(&format!("http://{}/", live.host));
    browser.until(&second, "Boolean(window.squeakscope?.state.panel?.run)");
    browser.press(&second, "k");
    let kicked = format!("{PANEL}.events.some((e) => e.text.startsWith('kick'))");
    browser.until(&first, &kicked);
    browser.until(&second, &kicked);
    let mut control = live.socket("/control");
    assert!(control.ask(&tilt(1.0)).is_some());
    assert_eq!(control.ask(&json!({ "do": "reset" })), None);
    browser.until(&first, &format!("{PANEL}.run === 2"));
    browser.until(&second, &format!("{PANEL}.run === 2"));
}

/// Takes the picture of the page for the README.
#[test]
#[ignore = "makes a picture: assets/screenshots/make"]
fn screenshot() {
    let folder = std::env::var_os("SQUEAKSCOPE_SCREENSHOTS")
        .expect("SQUEAKSCOPE_SCREENSHOTS names a folder");
    let live = Live::start("torus-1.75deg", &["--speed", "20"]);
    let (mut browser, tab) = opened(&live).expect("Chromium");
    // Until the torus has closed and is classified.
    browser.until(&tab, "squeakscope.run.data.time > 0.2");
    let picture = browser.screenshot(&tab);
    std::fs::write(std::path::Path::new(&folder).join("live-page.png"), picture).expect("written");
}

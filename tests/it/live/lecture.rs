//! A lecture: the guided tour, two runs side by side, and an audience that only watches.

use serde_json::json;

use super::browser::Browser;
use super::page::{PANEL, opened};
use super::{DEADLINE, Live, tilt};

#[test]
fn the_tour_runs_from_end_to_end() {
    let live = Live::start("doubled-torus-3deg", &["--tour"]);
    let Some((mut browser, tab)) = opened(&live) else {
        return;
    };
    // `--tour` starts it.
    browser.until(&tab, "!document.getElementById('tour-bar').hidden");
    let steps = browser.run(
        &tab,
        "fetch('/tour.json').then((r) => r.json()).then(({ tour }) => tour.steps)",
    );
    let steps = steps.as_array().unwrap();
    for (k, step) in steps.iter().enumerate() {
        browser.until(&tab, &format!("squeakscope.tour.step === {k}"));
        let say = browser.run(&tab, "document.getElementById('tour-say').textContent");
        assert_eq!(say, step["say"]);
        // The run of the step, with its tilt and speed; its numbers are those that the run measures.
        let mut holds = format!("{PANEL}.scene === {} && {PANEL}.time_s > 0", step["scene"]);
        if let Some(deg) = step["set"]["tilt_deg"].as_f64() {
            holds += &format!(" && Math.abs({PANEL}.tilt_deg - {deg}) < 1e-6");
        }
        if let Some(speed) = step["speed_ms_per_s"].as_f64() {
            holds += &format!(" && Math.abs(1e3 * {PANEL}.speed - {speed}) < 1e-6");
        }
        browser.until(&tab, &holds);
        browser.until(
            &tab,
            "[...document.querySelectorAll('#tour-numbers dd')].some((d) => d.textContent !== '–')",
        );
        let shown = browser.run(&tab, "squeakscope.stage.shown.length");
        assert_eq!(shown, step["views"].as_array().unwrap().len());
        browser.press(&tab, "Enter");
    }
    // The last step remains; back and end.
    browser.press(&tab, "PageUp");
    let last = steps.len() - 2;
    let scene = &steps[last]["scene"];
    browser.until(
        &tab,
        &format!(
            "squeakscope.tour.step === {last} && {PANEL}.scene === {scene} && {PANEL}.time_s > 0"
        ),
    );
    // A reload changes nothing.
    let runs = browser.run(&tab, &format!("{PANEL}.run"));
    browser.reload(&tab);
    browser.until(
        &tab,
        &format!("window.squeakscope?.tour.step === {last} && {PANEL}.run === {runs}"),
    );
    // The black screen of a remote.
    for dark in ["", "!"] {
        browser.press(&tab, "b");
        browser.until(
            &tab,
            &format!("{dark}document.body.classList.contains('blank')"),
        );
    }
    browser.click(&tab, "tour-end");
    browser.until(&tab, "document.getElementById('tour-bar').hidden");
    assert_eq!(browser.errors, [""; 0]);
}

/// Steps and bookmarks that follow one another faster than their runs start.
#[test]
fn quick_steps_and_bookmarks_end_where_the_last_one_says() {
    let live = Live::start("doubled-torus-3deg", &["--no-lyapunov"]);
    let Some((mut browser, tab)) = opened(&live) else {
        return;
    };
    browser.until(&tab, "!document.getElementById('tour-start').hidden");
    for step in 0..5 {
        browser.run(
            &tab,
            &format!("squeakscope.ask({{ do: 'tour', step: {step} }})"),
        );
    }
    browser.until(
        &tab,
        &format!("{PANEL}.scene === 'doubled-torus-3deg' && Math.abs({PANEL}.tilt_deg - 3) < 1e-9 && {PANEL}.time_s > 0"),
    );
    browser.run(&tab, "squeakscope.ask({ do: 'tour', step: null })");
    // A bookmark of the strip, and one of the user's own, which survives a reload of the page.
    browser.run(
        &tab,
        "document.querySelectorAll('#bookmark-list button')[2].click()",
    );
    let chaos = format!("{PANEL}.scene === 'chaos-5deg' && Math.abs({PANEL}.tilt_deg - 5) < 1e-9");
    browser.until(&tab, &chaos);
    browser.click(&tab, "bookmark-add");
    browser.run(
        &tab,
        "document.getElementById('bookmark-name').value = 'My own'",
    );
    browser.press(&tab, "Enter");
    let own = "[...document.querySelectorAll('#bookmark-list button')].find((b) => b.textContent === 'My own')";
    browser.until(&tab, &format!("Boolean({own})"));
    browser.reload(&tab);
    browser.until(
        &tab,
        &format!("window.squeakscope?.state.panel?.time_s > 0 && Boolean({own})"),
    );
    browser.run(
        &tab,
        "squeakscope.ask({ do: 'set', key: 'tilt_deg', value: 2 })",
    );
    browser.until(&tab, &format!("{PANEL}.tilt_deg === 2"));
    browser.run(&tab, &format!("{own}.click()"));
    browser.until(&tab, &chaos);
    assert_eq!(browser.errors, [""; 0]);
}

#[test]
fn a_presenter_window_steers_the_tour() {
    let live = Live::start("doubled-torus-3deg", &["--no-lyapunov"]);
    let Some((mut browser, tab)) = opened(&live) else {
        return;
    };
    let notes = browser.open(&format!("http://{}/?presenter=1", live.host));
    browser.until(
        &notes,
        "document.getElementById('tour-notes')?.textContent.length > 20",
    );
    for step in 0..2 {
        browser.run(&notes, "document.getElementById('tour-next').click()");
        browser.until(&notes, &format!("squeakscope.tour.step === {step}"));
    }
    browser.until(
        &tab,
        "squeakscope.tour.step === 1 && squeakscope.state.panel.scene === 'negative-slope'",
    );
}

#[test]
fn two_runs_are_shown_and_controlled_together() {
    let live = Live::start("doubled-torus-3deg", &["--no-lyapunov"]);
    let Some((mut browser, tab)) = opened(&live) else {
        return;
    };
    browser.click(&tab, "compare");
    let second = "squeakscope.comparison.second";
    browser.until(
        &tab,
        &format!("{second}?.panel?.scene === 'doubled-torus-3deg' && {second}.data.received > 5"),
    );
    // Both, then B alone.
    browser.run(
        &tab,
        "squeakscope.comparison.ask({ do: 'set', key: 'tilt_deg', value: 2 })",
    );
    browser.until(
        &tab,
        &format!("{PANEL}.tilt_deg === 2 && {second}.panel.tilt_deg === 2"),
    );
    browser.run(
        &tab,
        "document.getElementById('compare-target').value = 'b'",
    );
    browser.run(
        &tab,
        "squeakscope.comparison.ask({ do: 'set', key: 'tilt_deg', value: 5 })",
    );
    browser.until(&tab, &format!("{second}.panel.tilt_deg === 5"));
    // The slider then shows the tilt of B.
    browser.until(
        &tab,
        "document.getElementById('load.tilt_deg-now').textContent === '5.00°'",
    );
    assert_eq!(browser.run(&tab, &format!("{PANEL}.tilt_deg")), 2);
    // The perturbed copy starts both again, at the tilt of A.
    let runs = browser.run(&tab, &format!("{PANEL}.run"));
    browser.run(&tab, "document.getElementById('compare-same').click()");
    browser.until(
        &tab,
        &format!("{PANEL}.run > {runs} && {PANEL}.tilt_deg === 2 && {second}.panel.tilt_deg === 2"),
    );
    browser.until(
        &tab,
        &format!("{second}.panel.events.some((e) => e.text.startsWith('kick'))"),
    );
    // Both in one picture, at different tilts: some pixels are yellow.
    browser.run(
        &tab,
        "squeakscope.comparison.ask({ do: 'set', key: 'tilt_deg', value: 5 })",
    );
    let yellow = "(() => { const c = document.querySelector('#views .view-scope canvas'); \
         const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data; let n = 0; \
         for (let k = 0; k < d.length; k += 4) n += d[k] > 200 && d[k + 1] > 170 && d[k + 2] < 120; return n; })()";
    assert!(browser.run(&tab, yellow).as_u64() < Some(20));
    browser.run(&tab, "document.getElementById('compare-over').click()");
    browser.until(&tab, &format!("{yellow} > 40"));
    browser.until(&tab, "document.getElementById('stage-b').hidden");
    browser.click(&tab, "compare");
    browser.until(&tab, "document.getElementById('compare-bar').hidden");
    assert_eq!(browser.errors, [""; 0]);
}

/// On a page for other machines only the presenter's address controls the run, and an address without a key shows
/// nothing of it.
#[test]
fn an_audience_only_watches() {
    let live = Live::start(
        "doubled-torus-3deg",
        &["--no-lyapunov", "--host", "0.0.0.0"],
    );
    let presenter = live.query.strip_prefix("?key=").expect("a key");
    let mut control = live.socket(&format!("/control?key={presenter}"));
    let welcome = control.value_of("welcome");
    assert_eq!(welcome["controls"], true);
    let address = welcome["audience_url"].as_str().expect("an address");
    let (_, key) = address.split_once("?key=").expect("a key");
    assert_ne!(key, presenter);
    let mut audience = live.socket(&format!("/control?key={key}"));
    assert_eq!(audience.value_of("welcome")["controls"], false);
    assert!(
        audience
            .ask(&tilt(2.0))
            .expect("refused")
            .contains("only watches")
    );
    audience.panel(|panel| {
        panel["tilt_deg"]
            .as_f64()
            .is_some_and(|deg| (deg - 3.0).abs() < 1e-9)
    });
    assert_eq!(control.ask(&tilt(4.0)), None);
    audience.panel(|panel| {
        panel["tilt_deg"]
            .as_f64()
            .is_some_and(|deg| (deg - 4.0).abs() < 1e-9)
    });
    for path in ["/control", "/views", "/sound", "/b/control"] {
        for wrong in ["", "?key=", "?key=00000000000000000000"] {
            let refused = tungstenite::connect(format!("ws://{}{path}{wrong}", live.host));
            assert!(refused.is_err(), "{path}{wrong}");
        }
    }
    let Some(program) = super::browser::chromium() else {
        return;
    };
    let mut browser = Browser::start(&program);
    let tab = browser.open(address);
    browser.until(&tab, "window.squeakscope?.stage.drawn > 3");
    browser.until(&tab, "document.body.classList.contains('audience')");
    assert_eq!(
        browser.run(&tab, "document.getElementById('load.tilt_deg').disabled"),
        true
    );
    browser.press(&tab, "ArrowRight");
    browser.until(&tab, "!document.getElementById('refused').hidden");
    // It follows the tour, without its buttons.
    assert_eq!(control.ask(&json!({ "do": "tour", "step": 3 })), None);
    browser.until(&tab, "squeakscope.tour.step === 3");
    let buttons = "document.querySelector('#tour-bar .buttons').offsetHeight";
    assert_eq!(browser.run(&tab, buttons), 0);
    assert_eq!(browser.errors, [""; 0]);
}

/// A picture and a clip of a view, as the files that the page saves; a clip of 2 s instead of 10 s.
#[test]
fn pictures_and_clips_are_saved() {
    let live = Live::start("doubled-torus-3deg", &["--no-lyapunov"]);
    let Some((mut browser, tab)) = opened(&live) else {
        return;
    };
    browser.until(&tab, "squeakscope.stage.drawn > 3");
    browser.run(
        &tab,
        "window.saved = {}; const url = URL.createObjectURL; \
         URL.createObjectURL = (blob) => { saved[blob.type] = blob.size; return url(blob); }; \
         const later = setTimeout; window.setTimeout = (done, ms) => later(done, ms / 5); \
         for (const k of [0, 1]) document.querySelectorAll('.view-portrait .quiet-tools button')[k].click()",
    );
    for kind in ["image/png", "video/webm"] {
        browser.until(&tab, &format!("saved['{kind}'] > 5000"));
    }
    assert_eq!(browser.errors, [""; 0]);
}

#[test]
fn the_last_second_is_repeated_and_lines_are_played() {
    let live = Live::start("doubled-torus-3deg", &["--speed", "100", "--no-lyapunov"]);
    let Some((mut browser, tab)) = opened(&live) else {
        return;
    };
    browser.until(&tab, &format!("{PANEL}.lines.length > 1"));
    browser.click(&tab, "listen");
    browser.until(&tab, "squeakscope.sound.samples > 20000");
    browser.until(&tab, "document.getElementById('level').value > 0.1");
    // Four times slower, lowered and at its pitch.
    browser.run(&tab, "document.getElementById('slow').value = 4");
    browser.run(&tab, "document.getElementById('loop').click()");
    let pressed = |id: &str| {
        format!("document.getElementById('{id}').getAttribute('aria-pressed') === 'true'")
    };
    assert_eq!(browser.run(&tab, &pressed("loop")), true);
    browser.until(&tab, "document.getElementById('level').value > 0.1");
    browser.run(&tab, "document.getElementById('keep-pitch').click()");
    browser.until(&tab, "document.getElementById('level').value > 0.1");
    browser.run(&tab, "document.getElementById('loop').click()");
    // All tones at full volume reach the limiter.
    browser.until(
        &tab,
        "document.querySelectorAll('#tones button').length > 1",
    );
    browser.run(
        &tab,
        "{ const v = document.getElementById('volume'); v.value = 1; v.dispatchEvent(new Event('input')); }",
    );
    browser.run(
        &tab,
        "for (const b of document.querySelectorAll('#tones button')) b.click()",
    );
    browser.until(
        &tab,
        "document.getElementById('limiter').textContent.length > 0",
    );
    assert_eq!(browser.errors, [""; 0]);
}

/// A recording is downloaded from the page, and no other file is.
#[test]
fn a_complete_recording_is_downloaded() {
    let live = Live::start("mass-on-belt", &[]);
    let Some((mut browser, tab)) = opened(&live) else {
        return;
    };
    browser.click(&tab, "record");
    browser.until(&tab, &format!("{PANEL}.recording && {PANEL}.time_s > 0.01"));
    browser.click(&tab, "record");
    browser.until(&tab, &format!("{PANEL}.recordings[0] === 'live-1.rrd'"));
    browser.run(&tab, "document.getElementById('share-open').click()");
    let size = "fetch(document.querySelector('#share-recordings a').href).then((r) => r.arrayBuffer()).then((b) => b.byteLength)";
    let size = browser.run(&tab, size).as_u64().unwrap();
    assert_eq!(
        size,
        live.folder().join("live-1.rrd").metadata().unwrap().len()
    );
    let status = |name: &str| format!("fetch('/recordings/{name}').then((r) => r.status)");
    assert_eq!(browser.run(&tab, &status("live-2.rrd")), 404);
    assert_eq!(browser.run(&tab, &status("..%2Flive-1.rrd")), 404);
}

#[test]
fn a_tour_file_with_a_fault_is_refused_before_any_work() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("own.toml");
    for (step, part) in [
        ("scene = \"absent\"", "step 1: unknown scene `absent`"),
        (
            "scene = \"periodic-2deg\"\nset = { tilt_deg = 60 }",
            "step 1: the tilt must be between 0 and 10 deg",
        ),
        (
            "scene = \"mass-on-belt\"\nset = { tilt_deg = 1 }",
            "step 1: a run of the scene `mass-on-belt` cannot change",
        ),
    ] {
        std::fs::write(
            &path,
            format!("title = \"x\"\n[[step]]\nsay = \"y\"\n{step}\n"),
        )
        .unwrap();
        let ended = std::process::Command::new(env!("CARGO_BIN_EXE_squeakscope"))
            .args(["live", "periodic-2deg", "--tour", path.to_str().unwrap()])
            .output()
            .unwrap();
        let message = String::from_utf8_lossy(&ended.stderr);
        assert_eq!(ended.status.code(), Some(2), "{message}");
        assert!(message.contains(part), "{message}");
    }
}

/// Ten minutes of a lesson: all controls again and again, without an error on the console.
#[test]
#[ignore = "takes ten minutes: cargo test --release --test it live::lecture::ten_minutes -- --ignored"]
fn ten_minutes() {
    let live = Live::start("doubled-torus-3deg", &["--tour"]);
    let (mut browser, tab) = opened(&live).expect("Chromium");
    let began = std::time::Instant::now();
    let keys = [
        "Enter",
        "ArrowRight",
        "k",
        "1",
        "2",
        "3",
        "m",
        "h",
        "l",
        " ",
        " ",
        "r",
        "n",
        "?",
        "Escape",
        "b",
        "t",
        "t",
    ];
    for key in keys.iter().cycle() {
        if began.elapsed() > std::time::Duration::from_secs(600).max(DEADLINE) {
            break;
        }
        browser.press(&tab, key);
        std::thread::sleep(std::time::Duration::from_millis(1500));
        assert_eq!(browser.errors, [""; 0], "after {key}");
    }
    let drawn = browser.run(&tab, "squeakscope.stage.drawn");
    browser.until(&tab, &format!("squeakscope.stage.drawn > {drawn}"));
    let panel = browser.run(&tab, &format!("{PANEL}.time_s"));
    assert_ne!(panel, json!(0));
}

//! The page's views in a real browser, and their data.

use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tungstenite::Message;

use super::page::opened;
use super::{Live, Socket};

/// The header of the next message of `/views`.
pub fn header(socket: &mut Socket) -> (Value, usize) {
    loop {
        let Message::Binary(bytes) = socket.next() else {
            continue;
        };
        let length = u32::from_le_bytes(bytes[..4].try_into().unwrap()) as usize;
        let header = serde_json::from_slice(&bytes[4..4 + length]).unwrap();
        return (header, bytes.len());
    }
}

/// A client that draws slowly gets fewer messages, but each with the present picture.
#[test]
fn a_slow_client_gets_the_present_and_no_queue() {
    let live = Live::start("doubled-torus-3deg", &["--speed", "20"]);
    let (mut control, mut views) = (live.socket("/control"), live.socket("/views"));
    let (first, _) = header(&mut views);
    assert_eq!(first["start"]["scene"], "doubled-torus-3deg");
    assert_eq!(first["start"]["sample_rate_hz"], 2e5);
    let (mut received, mut last) = (1, 0.0);
    for _ in 0..4 {
        // Two messages wait at most.
        std::thread::sleep(Duration::from_millis(300));
        let now = control.panel(|_| true)["time_s"].as_f64().unwrap();
        while last < now {
            let (message, _) = header(&mut views);
            received += 1;
            last = message["time_s"].as_f64().unwrap();
            views.send(&json!({ "drawn": received }));
        }
    }
    assert!(
        received < 60,
        "{received} messages for a client that drew seldom"
    );
}

/// At most 2 MB per second, even in real time and for a client that draws at once.
#[test]
fn the_rate_of_a_client_is_limited() {
    let live = Live::start("doubled-torus-3deg", &["--speed", "1000", "--no-lyapunov"]);
    let mut views = live.socket("/views");
    let began = Instant::now();
    let (mut bytes, mut drawn) = (0, 0);
    while began.elapsed() < Duration::from_secs(2) {
        bytes += header(&mut views).1;
        drawn += 1;
        views.send(&json!({ "drawn": drawn }));
    }
    let seconds = began.elapsed().as_secs_f64();
    println!(
        "{:.2} MB/s, {:.0} messages/s",
        1e-6 * bytes as f64 / seconds,
        f64::from(drawn) / seconds
    );
    // The burst, and the rate.
    assert!(
        (bytes as f64) < 1e6 + 2e6 * seconds,
        "{bytes} bytes in {seconds} s"
    );
    assert!(drawn > 3);
}

/// Number of colours of the canvas of a view, and a sum of its pixels.
fn pixels(view: &str) -> String {
    format!(
        "(() => {{ const c = document.querySelector('#views .view-{view} canvas'); \
         const d = new Uint32Array(c.getContext('2d').getImageData(0, 0, c.width, c.height).data.buffer); \
         let sum = 0; for (const x of d) sum = (sum * 31 + x) | 0; \
         return {{ colours: new Set(d).size, sum }}; }})()"
    )
}

#[test]
fn every_view_draws_the_run() {
    let live = Live::start("doubled-torus-3deg", &["--speed", "50", "--no-lyapunov"]);
    let Some((mut browser, tab)) = opened(&live) else {
        return;
    };
    let first = browser.until(&tab, "squeakscope.stage.drawn > 0 && performance.now()");
    println!(
        "first picture after {:.0} ms of the page's time",
        first.as_f64().unwrap()
    );
    let views = [
        "patch",
        "portrait",
        "scope",
        "spectrum",
        "spectrogram",
        "section",
        "recurrence",
        "body",
        "lesson",
    ];
    browser.run(&tab, &format!("squeakscope.stage.show({})", json!(views)));
    // Until each has data.
    browser.until(
        &tab,
        "(({ versions: v, pose, body }) => v.patch && v.spectrum && v.columns > 9 && v.recurrence && v.points && \
         pose && body)(squeakscope.run.data)",
    );
    let now = "squeakscope.stage.drawn";
    let drawn = browser.run(&tab, now).as_i64().unwrap();
    browser.until(&tab, &format!("{now} > {}", drawn + 2));
    for view in views {
        let before = browser.run(&tab, &pixels(view));
        assert!(before["colours"].as_u64() > Some(8), "{view}: {before}");
        let changed = format!("({}).sum !== {}", pixels(view), before["sum"]);
        browser.until(&tab, &changed);
    }
    // One view alone, by its button; Escape shows all again.
    browser.run(
        &tab,
        "document.querySelector('.view-portrait .quiet-tools button:last-child').click()",
    );
    assert_eq!(
        browser.run(&tab, "document.querySelectorAll('#views figure').length"),
        1
    );
    browser.run(&tab, "document.activeElement.blur()");
    browser.press(&tab, "Escape");
    assert_eq!(
        browser.run(&tab, "document.querySelectorAll('#views figure').length"),
        views.len()
    );
    // A phone draws each view, too, and nothing is wider than its screen.
    for size in [[1280, 720], [1920, 1080], [820, 1180], [390, 844]] {
        browser.resize(&tab, size);
        browser.until(&tab, "document.documentElement.scrollWidth <= innerWidth");
        browser.until(&tab, &format!("({}).colours > 8", pixels("portrait")));
    }
    assert_eq!(browser.errors, [""; 0]);
}

/// Time from the slider to a picture of the run at the new tilt, in the browser.
#[test]
fn the_slider_changes_the_picture() {
    const MOVES: usize = 10;
    let live = Live::start("doubled-torus-3deg", &["--no-lyapunov"]);
    let Some((mut browser, tab)) = opened(&live) else {
        return;
    };
    browser.until(&tab, "squeakscope.stage.drawn > 10");
    for k in 0..MOVES {
        let deg = 2.0 + 0.1 * k as f64;
        browser.run(
            &tab,
            &format!(
                "{{ const s = document.getElementById('load.tilt_deg'); s.value = {deg}; \
                 s.dispatchEvent(new Event('input')); }}"
            ),
        );
        browser.until(&tab, &format!("squeakscope.latencies.length === {}", k + 1));
    }
    let mut took: Vec<f64> =
        serde_json::from_value(browser.run(&tab, "squeakscope.latencies")).unwrap();
    took.sort_by(f64::total_cmp);
    println!(
        "slider to picture: median {:.0} ms, maximum {:.0} ms",
        took[MOVES / 2],
        took[MOVES - 1]
    );
    assert_eq!(took.len(), MOVES);
    let drawn = browser
        .run(&tab, "squeakscope.run.data.tilt")
        .as_f64()
        .unwrap();
    assert!((drawn - 2.9).abs() < 1e-9, "{drawn}");
}

/// Pictures per second, and the time of one, at the size of a projector and of a telephone with a processor slowed
/// four times. The page's budget is 60 and 20 per second. Nearly every refresh of the screen shows a new picture.
#[test]
#[ignore = "a measurement: cargo test --release --test it live::views::frame_rate -- --ignored --nocapture"]
fn frame_rate() {
    let live = Live::start("doubled-torus-3deg", &["--no-lyapunov"]);
    let (mut browser, tab) = opened(&live).expect("Chromium");
    // Size, pixels of the device per pixel of the page, and how many times the processor is slowed.
    let devices = [
        ("projector", [1920, 1080], 1, 1),
        ("telephone", [412, 915], 2, 4),
    ];
    for (device, [width, height], scale, slowed) in devices {
        let size = json!({ "width": width, "height": height, "deviceScaleFactor": scale, "mobile": width < 1000 });
        browser.call(Some(&tab), "Emulation.setDeviceMetricsOverride", &size);
        let rate = json!({ "rate": slowed });
        browser.call(Some(&tab), "Emulation.setCPUThrottlingRate", &rate);
        let drawn = browser.run(&tab, "squeakscope.stage.drawn");
        browser.until(&tab, &format!("squeakscope.stage.drawn > {drawn} + 60"));
        // Pictures, messages and refreshes of the screen in five seconds of the page's clock.
        let rates = browser.run(
            &tab,
            "new Promise((done) => { const { stage, run } = squeakscope; const [drawn, received, began] = [stage.drawn, \
             run.data.received, performance.now()]; let refreshes = 0, drawing = 0; \
             requestAnimationFrame(function count(now) { refreshes++; drawing += stage.drawnTime; \
             if (now < began + 5000) return requestAnimationFrame(count); const s = 1e-3 * (performance.now() - began); \
             done([(stage.drawn - drawn) / s, (run.data.received - received) / s, refreshes / s, drawing / refreshes]); }); })",
        );
        let rates: [f64; 4] = serde_json::from_value(rates).unwrap();
        let [pictures, messages, refreshes, one] = rates;
        println!(
            "{device}, per second: {pictures:.1} pictures, {messages:.1} messages, {refreshes:.1} refreshes of the \
             screen; {one:.1} ms per picture"
        );
        assert!(
            pictures > 0.8 * refreshes,
            "{device}: {pictures} of {refreshes}"
        );
    }
}

/// With reduced motion, the pictures change at most twice a second.
#[test]
fn reduced_motion_is_respected() {
    let live = Live::start("doubled-torus-3deg", &["--no-lyapunov"]);
    let Some((mut browser, tab)) = opened(&live) else {
        return;
    };
    browser.emulate(&tab, "reduce");
    browser.reload(&tab);
    browser.until(&tab, "window.squeakscope?.stage.drawn > 3");
    let [drawn, time] =
        ["squeakscope.stage.drawn", "performance.now()"].map(|what| browser.run(&tab, what));
    browser.until(&tab, &format!("squeakscope.stage.drawn >= {} + 4", drawn));
    let took = browser.run(&tab, "performance.now()").as_f64().unwrap() - time.as_f64().unwrap();
    assert!(took > 1200.0, "four pictures in {took} ms");
}

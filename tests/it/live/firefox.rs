//! The page in Firefox, controlled through WebDriver BiDi.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tungstenite::Message;

use super::{DEADLINE, Live, Socket};

/// A headless Firefox with one page, stopped at the end of its test.
struct Firefox {
    child: Child,
    socket: Socket,
    calls: u64,
    /// The page.
    context: Value,
    /// Errors that the page reported on its console.
    errors: Vec<String>,
    _profile: tempfile::TempDir,
}

impl Firefox {
    /// Starts `SQUEAKSCOPE_FIREFOX`, else `firefox-esr` or `firefox` from the `PATH`; `None` without one.
    fn start() -> Option<Self> {
        let named = std::env::var("SQUEAKSCOPE_FIREFOX").ok();
        let names = named.map_or_else(
            || vec!["firefox-esr".to_owned(), "firefox".to_owned()],
            |name| vec![name],
        );
        let profile = tempfile::tempdir().expect("temporary folder");
        let mut child = names.iter().find_map(|program| {
            Command::new(program)
                .args(["--headless", "--no-remote", "--remote-debugging-port", "0"])
                .arg("--profile")
                .arg(profile.path())
                .stdin(Stdio::null())
                .stdout(Stdio::null())
                .stderr(Stdio::piped())
                .spawn()
                .ok()
        })?;
        let mut lines = BufReader::new(child.stderr.take().expect("piped")).lines();
        let address = lines
            .by_ref()
            .map_while(Result::ok)
            .find_map(|line| {
                let (_, address) = line.split_once("BiDi listening on ws://")?;
                Some(address.to_owned())
            })
            .expect("the browser prints its address");
        // Drains later output, which must not fill the pipe.
        std::thread::spawn(move || lines.map_while(Result::ok).for_each(drop));
        let mut browser = Self {
            child,
            socket: Socket::open(&address, "/session"),
            calls: 0,
            context: Value::Null,
            errors: Vec::new(),
            _profile: profile,
        };
        browser.call("session.new", &json!({ "capabilities": {} }));
        browser.call(
            "session.subscribe",
            &json!({ "events": ["log.entryAdded"] }),
        );
        browser.context =
            browser.call("browsingContext.getTree", &json!({}))["contexts"][0]["context"].take();
        Some(browser)
    }

    fn call(&mut self, method: &str, params: &Value) -> Value {
        self.calls += 1;
        let call = json!({ "id": self.calls, "method": method, "params": params });
        self.socket.send(&call);
        let began = Instant::now();
        loop {
            assert!(began.elapsed() < DEADLINE, "no response to {method}");
            let Message::Text(text) = self.socket.next() else {
                continue;
            };
            let mut said: Value = serde_json::from_str(&text).expect("JSON");
            if said["method"] == "log.entryAdded" && said["params"]["level"] == "error" {
                self.errors.push(said["params"].to_string());
            }
            if said["id"] == self.calls {
                assert_eq!(said["type"], "success", "{method}: {said:#}");
                return said["result"].take();
            }
        }
    }

    /// Value of a JavaScript expression: a number, a text or a truth value.
    fn run(&mut self, script: &str) -> Value {
        let params = json!({
            "expression": script,
            "target": { "context": self.context },
            "awaitPromise": true,
        });
        let mut done = self.call("script.evaluate", &params);
        assert_eq!(done["type"], "success", "{script}: {done:#}");
        done["result"]["value"].take()
    }

    /// Waits until a JavaScript expression is true.
    fn until(&mut self, script: &str) {
        let began = Instant::now();
        while self.run(&format!("Boolean({script})")) != json!(true) {
            assert!(began.elapsed() < DEADLINE, "timeout: {script}");
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// Presses a key, by its character in WebDriver.
    fn press(&mut self, key: char) {
        let actions = ["keyDown", "keyUp"].map(|kind| json!({ "type": kind, "value": key }));
        let keyboard = json!({ "type": "key", "id": "keyboard", "actions": actions });
        let params = json!({ "context": self.context, "actions": [keyboard] });
        self.call("input.performActions", &params);
    }
}

impl Drop for Firefox {
    fn drop(&mut self) {
        // It may have stopped already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn the_page_draws_and_is_controlled_by_keyboard() {
    const ARROW_RIGHT: char = '\u{e014}';
    const SPACE: char = ' ';
    let Some(mut browser) = Firefox::start() else {
        eprintln!("skipped: no Firefox (apt-get install firefox-esr, or set SQUEAKSCOPE_FIREFOX)");
        return;
    };
    let live = Live::start("doubled-torus-3deg", &["--speed", "50", "--no-lyapunov"]);
    let url = format!("http://{}/", live.host);
    let params = json!({ "context": browser.context, "url": url, "wait": "complete" });
    browser.call("browsingContext.navigate", &params);
    let views = json!([
        "patch",
        "portrait",
        "scope",
        "spectrum",
        "spectrogram",
        "section",
        "recurrence",
        "body"
    ]);
    browser.until("window.squeakscope?.stage.drawn > 3");
    browser.run(&format!("squeakscope.stage.show({views})"));
    for view in views.as_array().expect("a list") {
        let canvas = format!(
            "document.querySelector('#views .view-{} canvas')",
            view.as_str().expect("a name")
        );
        // More colours than those of axes and text.
        browser.until(&format!(
            "((c) => new Set(new Uint32Array(c.getContext('2d').getImageData(0, 0, c.width, c.height).data.buffer))             .size > 100)({canvas})"
        ));
    }
    // The slider by keyboard, and a shortcut.
    browser.run("document.getElementById('load.tilt_deg').focus()");
    browser.press(ARROW_RIGHT);
    browser.until("Math.abs(squeakscope.state.panel.tilt_deg - 3.1) < 1e-6");
    browser.run("document.activeElement.blur()");
    browser.press(SPACE);
    browser.until("squeakscope.state.panel.paused");
    assert_eq!(browser.errors, [""; 0]);
}

//! A whole lecture in a hall: twenty minutes of tour, bookmarks, sliders, two runs, kicks and sound on the lecturer's page,
//! watched on a projector, a laptop and a telephone.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use serde_json::json;

use super::Live;
use super::browser::{Browser, Tab};
use super::contradictions::contradictions;
use super::page::{PANEL, opened};

/// Pages with their sizes, pixels. The first one is the lecturer's.
const PAGES: [(&str, [u32; 2]); 3] = [
    ("projector", [1920, 1080]),
    ("laptop", [1280, 720]),
    ("telephone", [412, 915]),
];

/// Length of the lecture.
const LECTURE: Duration = Duration::from_secs(20 * 60);

/// The panel of a page, and texts that do not fit.
const PAGE: &str = r"(() => {
    const clipped = [...document.querySelectorAll('header, #tour-say, #words, .control')]
        .filter((box) => box.scrollWidth > box.clientWidth + 1 && getComputedStyle(box).overflowX === 'visible')
        .map((box) => `clipped: ${box.id || box.className}`);
    if (document.documentElement.scrollWidth > innerWidth + 1) clipped.push('the page is wider than the screen');
    return { panel: squeakscope.state.panel, clipped };
})()";

/// The pages of the hall.
struct Hall {
    browser: Browser,
    tabs: Vec<Tab>,
    folder: Option<PathBuf>,
    shown: usize,
    /// Number of the run before the last command that starts another one.
    run: u64,
    /// Simulated time of the last change of the present run, s.
    since: f64,
    /// Contradictions so far.
    found: Vec<String>,
}

impl Hall {
    /// Waits until the run, a new one after a command that starts one, reaches its promised motion, or for some seconds.
    /// Checks every page and keeps its picture.
    fn inspect(&mut self, name: &str, seconds: f64) {
        self.show(0);
        let lecturer = &self.tabs[0];
        let settled = format!(
            "(window.waited ??= performance.now()) && ({PANEL}.run > {} && {PANEL}.time_s > {} + 0.35 && {PANEL}.confidence !== null || \
             performance.now() - window.waited > {})",
            self.run,
            self.since,
            1e3 * seconds
        );
        self.browser.run(lecturer, "delete window.waited");
        self.browser.until(lecturer, &settled);
        self.shown += 1;
        for (k, (page, _)) in PAGES.iter().enumerate() {
            self.show(k);
            let state = self.browser.run(&self.tabs[k], PAGE);
            let mut found = contradictions(&state["panel"]);
            let clipped = state["clipped"].as_array().into_iter().flatten();
            found.extend(clipped.map(ToString::to_string));
            println!(
                "{:3} {name}, {page}: {} {found:?}",
                self.shown, state["panel"]["now"]
            );
            if let Some(folder) = &self.folder {
                let picture = self.browser.screenshot(&self.tabs[k]);
                let file = folder.join(format!("{:03}-{name}-{page}.png", self.shown));
                std::fs::write(file, picture).expect("written");
            }
            self.found.extend(
                found
                    .into_iter()
                    .map(|found| format!("{:3} {name}, {page}: {found}", self.shown)),
            );
        }
        assert_eq!(self.browser.errors, [""; 0], "{name}");
    }

    /// Brings a page to the front, since a browser draws no other, and waits for its next picture.
    fn show(&mut self, k: usize) {
        let tab = &self.tabs[k];
        self.browser
            .call(Some(tab), "Page.bringToFront", &json!({}));
        self.browser
            .until(tab, "Boolean(window.squeakscope?.state.panel)");
        self.browser
            .run(tab, "window.shownAt = squeakscope.stage.drawn");
        self.browser
            .until(tab, "squeakscope.stage.drawn > window.shownAt");
    }

    fn lecturer(&mut self, script: &str) {
        self.browser.run(&self.tabs[0], script);
    }

    /// A script that starts another run.
    fn start(&mut self, script: &str) {
        self.run = self.number(&format!("{PANEL}.run"));
        self.since = 0.0;
        self.lecturer(script);
    }

    /// A script that changes the present run.
    fn change(&mut self, script: &str) {
        let time = self.browser.run(&self.tabs[0], &format!("{PANEL}.time_s"));
        self.since = time.as_f64().expect("a time");
        self.lecturer(script);
    }

    fn number(&mut self, what: &str) -> u64 {
        let number = self.browser.run(&self.tabs[0], what);
        number.as_u64().expect("a number")
    }
}

#[test]
#[ignore = "takes 20 minutes: SQUEAKSCOPE_SCREENSHOTS=DIR cargo test --release --test it whole_lecture -- --ignored --nocapture"]
fn a_whole_lecture_has_no_contradiction() {
    let live = Live::start("tilt-ramp", &["--tour", "--no-lyapunov"]);
    let (mut browser, lecturer) = opened(&live).expect("Chromium");
    let mut tabs = vec![lecturer];
    for _ in &PAGES[1..] {
        tabs.push(browser.open(&format!("http://{}/{}", live.host, live.query)));
    }
    for (tab, (_, size)) in tabs.iter().zip(PAGES) {
        browser.resize(tab, size);
    }
    let folder = std::env::var_os("SQUEAKSCOPE_SCREENSHOTS").map(PathBuf::from);
    let mut hall = Hall {
        browser,
        tabs,
        folder,
        shown: 0,
        run: 0,
        since: 0.0,
        found: Vec::new(),
    };
    let began = Instant::now();
    while began.elapsed() < LECTURE {
        let steps = hall.number("document.querySelectorAll('#tour-steps li').length");
        for step in 0..steps {
            hall.start(&format!("squeakscope.ask({{ do: 'tour', step: {step} }})"));
            hall.inspect(&format!("step-{}", step + 1), 40.0);
        }
        hall.lecturer("squeakscope.ask({ do: 'tour', step: null })");
        let bookmarks = hall.number("document.querySelectorAll('#bookmark-list button').length");
        for k in 0..bookmarks {
            hall.start(&format!(
                "document.querySelectorAll('#bookmark-list button')[{k}].click()"
            ));
            hall.inspect(&format!("bookmark-{}", k + 1), 40.0);
        }
        // Every named slider of a joint and of small systems, slowly to its upper end and back.
        for scene in ["chaos-5deg", "negative-slope", "impact-oscillator"] {
            hall.start(&format!(
                "squeakscope.ask({{ do: 'scene', name: '{scene}' }})"
            ));
            hall.inspect(scene, 30.0);
            let sliders = hall.number("document.querySelectorAll('#slider-first input, #slider-others > .control input').length",
            );
            for k in 0..sliders {
                for to in ["max", "min"] {
                    hall.change(&format!(
                        "{{ const s = document.querySelectorAll('#slider-first input, #slider-others > .control input')[{k}]; \
                         s.value = s.{to}; s.dispatchEvent(new Event('input')); }}"
                    ));
                    hall.inspect(&format!("{scene}-slider-{}-{to}", k + 1), 6.0);
                }
            }
        }
        // Two runs, sound, a hard kick.
        hall.start("squeakscope.ask({ do: 'scene', name: 'which-mode-wins' })");
        hall.inspect("which-mode-wins", 20.0);
        hall.lecturer("document.getElementById('compare').click()");
        hall.inspect("a-and-b", 20.0);
        hall.start("document.getElementById('compare-same').click()");
        hall.inspect("perturbed-copy", 20.0);
        hall.lecturer("document.getElementById('compare').click()");
        hall.lecturer("squeakscope.sound.toggle(); squeakscope.ask({ do: 'kick', mm_per_s: 30 })");
        hall.inspect("sound-and-kick", 20.0);
        hall.lecturer("squeakscope.sound.toggle()");
    }
    assert_eq!(hall.found, [""; 0]);
}

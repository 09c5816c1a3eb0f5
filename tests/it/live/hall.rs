//! A whole lecture in a hall: twenty minutes of tour, bookmarks, sliders, two runs, kicks and sound on the lecturer's page,
//! watched on a projector, a laptop and a telephone.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use serde_json::json;

use super::Live;
use super::browser::{Browser, Tab};
use super::page::{PANEL, opened};

/// Pages with their sizes, pixels. The first one is the lecturer's.
const PAGES: [(&str, [u32; 2]); 3] = [
    ("projector", [1920, 1080]),
    ("laptop", [1280, 720]),
    ("telephone", [412, 915]),
];

/// Length of the lecture.
const LECTURE: Duration = Duration::from_secs(20 * 60);

/// Statements of a page that contradict each other, in words.
const CONTRADICTIONS: &str = r"(() => {
    const { panel } = squeakscope.state;
    const text = (id) => document.getElementById(id)?.textContent ?? '';
    const heading = /^## (.*)/.exec(panel.narration)?.[1] ?? '';
    const found = [];
    const clash = { periodic: /broadband|two base/i, 'quasi-periodic': /broadband|pure tone|one tone/i, chaotic: /pure tone|one tone/i }[panel.regime];
    if (panel.confidence !== null && clash?.test(heading)) found.push(`panel: ${panel.regime}; commentary: ${heading}`);
    const other = /now classified as ([a-z-]+)/.exec(panel.lesson)?.[1];
    if (other && panel.confidence !== null && panel.regime !== other) found.push(`panel: ${panel.regime}; lesson: ${other}`);
    if (panel.departure) found.push(panel.departure);
    if (panel.regime === 'at rest' && panel.lines.length) found.push('lines of a joint at rest');
    for (const box of document.querySelectorAll('header, #tour-say, #words, .control'))
        if (box.scrollWidth > box.clientWidth + 1 && getComputedStyle(box).overflowX === 'visible') found.push(`clipped: ${box.id || box.className}`);
    if (document.documentElement.scrollWidth > innerWidth + 1) found.push('the page is wider than the screen');
    return found;
})()";

/// The pages of the hall.
struct Hall {
    browser: Browser,
    tabs: Vec<Tab>,
    folder: Option<PathBuf>,
    shown: usize,
}

impl Hall {
    /// Waits until the run reaches its promised motion, or for some seconds, checks every page and keeps its picture.
    fn inspect(&mut self, name: &str, seconds: f64) {
        self.show(0);
        let lecturer = &self.tabs[0];
        let settled = format!(
            "(window.waited ??= performance.now()) && ({PANEL}.time_s > 0.35 && {PANEL}.confidence !== null || \
             performance.now() - window.waited > {})",
            1e3 * seconds
        );
        self.browser.run(lecturer, "delete window.waited");
        self.browser.until(lecturer, &settled);
        self.shown += 1;
        for (k, (page, _)) in PAGES.iter().enumerate() {
            self.show(k);
            let found = self.browser.run(&self.tabs[k], CONTRADICTIONS);
            println!("{:3} {name}, {page}: {found}", self.shown);
            assert_eq!(
                found.as_array().map(Vec::len),
                Some(0),
                "{name}, {page}: {found}"
            );
            if let Some(folder) = &self.folder {
                let picture = self.browser.screenshot(&self.tabs[k]);
                let file = folder.join(format!("{:03}-{name}-{page}.png", self.shown));
                std::fs::write(file, picture).expect("written");
            }
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
    };
    let began = Instant::now();
    let number = |hall: &mut Hall, what: &str| {
        hall.browser
            .run(&hall.tabs[0], what)
            .as_u64()
            .expect("a number")
    };
    while began.elapsed() < LECTURE {
        let steps = number(
            &mut hall,
            "document.querySelectorAll('#tour-steps li').length",
        );
        for step in 0..steps {
            hall.lecturer(&format!("squeakscope.ask({{ do: 'tour', step: {step} }})"));
            hall.inspect(&format!("step-{}", step + 1), 40.0);
        }
        hall.lecturer("squeakscope.ask({ do: 'tour', step: null })");
        let bookmarks = number(
            &mut hall,
            "document.querySelectorAll('#bookmark-list button').length",
        );
        for k in 0..bookmarks {
            hall.lecturer(&format!(
                "document.querySelectorAll('#bookmark-list button')[{k}].click()"
            ));
            hall.inspect(&format!("bookmark-{}", k + 1), 40.0);
        }
        // Every named slider of a joint and of small systems, slowly to its upper end and back.
        for scene in ["chaos-5deg", "negative-slope", "impact-oscillator"] {
            hall.lecturer(&format!(
                "squeakscope.ask({{ do: 'scene', name: '{scene}' }})"
            ));
            hall.inspect(scene, 30.0);
            let sliders = number(
                &mut hall,
                "document.querySelectorAll('#slider-first input, #slider-others > .control input').length",
            );
            for k in 0..sliders {
                for to in ["max", "min"] {
                    hall.lecturer(&format!(
                        "{{ const s = document.querySelectorAll('#slider-first input, #slider-others > .control input')[{k}]; \
                         s.value = s.{to}; s.dispatchEvent(new Event('input')); }}"
                    ));
                    hall.inspect(&format!("{scene}-slider-{}-{to}", k + 1), 6.0);
                }
            }
        }
        // Two runs, sound, a hard kick.
        hall.lecturer("squeakscope.ask({ do: 'scene', name: 'which-mode-wins' })");
        hall.lecturer("document.getElementById('compare').click()");
        hall.inspect("a-and-b", 20.0);
        hall.lecturer("document.getElementById('compare-same').click()");
        hall.inspect("perturbed-copy", 20.0);
        hall.lecturer("document.getElementById('compare').click()");
        hall.lecturer("squeakscope.sound.toggle(); squeakscope.ask({ do: 'kick', mm_per_s: 30 })");
        hall.inspect("sound-and-kick", 20.0);
        hall.lecturer("squeakscope.sound.toggle()");
    }
}

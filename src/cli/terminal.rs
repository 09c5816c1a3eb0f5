//! The terminal interface of a live run: keyboard control and the main results.

use std::io::{self, IsTerminal, stdout};
use std::time::{Duration, Instant};

use ratatui::crossterm::event::{self, Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers};
use ratatui::crossterm::execute;
use ratatui::crossterm::terminal::{self, EnterAlternateScreen};
use ratatui::layout::{Constraint, Layout, Rect, Size};
use ratatui::style::{Color, Style, Stylize};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Paragraph, Wrap};
use ratatui::{DefaultTerminal, Frame, TerminalOptions, Viewport};

use super::markdown;
use crate::escape;
use crate::live::{Command, HARD_KICK, Panel, SPEED_RANGE, Session};

/// Tilt step of a key, degrees; with Shift, five times as much.
const TILT_STEP: f64 = 0.1;
/// Time for which key steps start from the requested tilt, because the panel follows with a delay.
const TARGET_VALID: Duration = Duration::from_millis(500);
/// Factor of the playback speed per key.
const SPEED_FACTOR: f64 = 1.25;
/// Lines per scroll key.
const PAGE: u16 = 5;
/// Largest number of columns and rows that are drawn. Each cell takes memory, and a terminal may report 65535
/// columns and rows.
const MAX_SIZE: [u16; 2] = [400, 200];
/// Colours and names of the contact states, as in the recording.
const NODES: [(Color, &str); 3] = [
    (Color::Rgb(255, 165, 58), "sticking"),
    (Color::Rgb(88, 169, 255), "slipping"),
    (Color::White, "separated"),
];

/// Effect of the keyboard on the program, apart from commands to the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum KeyAction {
    /// Continue the run.
    Continue,
    /// End the run.
    Quit,
    /// End the run as Ctrl-C does.
    Interrupt,
}

/// The terminal in full-screen mode; dropping it restores the terminal.
pub(super) struct Terminal {
    terminal: DefaultTerminal,
    /// Error of the last command.
    refused: Option<String>,
    /// Last requested tilt, degrees, and the time of the request.
    target: Option<(f64, Instant)>,
    /// URL of the live page, if there is one.
    page: Option<String>,
    /// Number of scrolled lines of the explanation, and its scene.
    scrolled: (u16, String),
}

impl Terminal {
    /// Switches the terminal to full-screen mode.
    ///
    /// # Errors
    /// If the standard output is not a terminal, or cannot be written.
    pub fn open(page: Option<String>) -> io::Result<Self> {
        let (columns, rows) = terminal::size()?;
        let viewport = Viewport::Fixed(drawn_area(Size::new(columns, rows)));
        let opened = ratatui::try_init_with_options(TerminalOptions { viewport })
            .and_then(|terminal| execute!(stdout(), EnterAlternateScreen).map(|()| terminal));
        Ok(Self {
            terminal: opened.inspect_err(|_| ratatui::restore())?,
            refused: None,
            target: None,
            page,
            scrolled: Default::default(),
        })
    }

    /// Draws the panel and handles a pressed key. A closed terminal ends the run as Ctrl-C does.
    ///
    /// # Errors
    /// If the terminal cannot be written or read.
    pub fn update(&mut self, session: &Session) -> io::Result<KeyAction> {
        if !io::stdin().is_terminal() {
            return Ok(KeyAction::Interrupt);
        }
        let panel = session.panel();
        if self.scrolled.1 != panel.scene {
            self.scrolled = (0, panel.scene.clone());
        }
        let (refused, page) = (self.refused.as_deref(), self.page.as_deref());
        let scrolled = &mut self.scrolled.0;
        let area = drawn_area(self.terminal.size()?);
        if self.terminal.get_frame().area() != area {
            self.terminal.resize(area)?;
        }
        self.terminal
            .draw(|frame| draw(frame, &panel, page, refused, scrolled))?;
        // Do not wait here: crossterm does not return if the terminal is closed while it waits.
        if !event::poll(Duration::ZERO)? {
            return Ok(KeyAction::Continue);
        }
        let Event::Key(key) = event::read()? else {
            return Ok(KeyAction::Continue);
        };
        let mut known = panel;
        if let Some((deg, when)) = self.target
            && when.elapsed() < TARGET_VALID
        {
            known.tilt_deg = known.tilt_deg.map(|_| deg);
        }
        match binding(key, &known, &session.scenes()) {
            Binding::None => {}
            Binding::Action(action) => return Ok(action),
            Binding::Scroll(lines) => {
                self.scrolled.0 = self.scrolled.0.saturating_add_signed(lines);
            }
            Binding::Command(command) => {
                if let Command::Tilt { deg } = command {
                    self.target = Some((deg, Instant::now()));
                }
                self.refused = session.apply(&command).err().map(|error| error.to_string());
            }
        }
        Ok(KeyAction::Continue)
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        ratatui::restore();
    }
}

/// The part of the terminal that is drawn.
fn drawn_area(size: Size) -> Rect {
    let [columns, rows] = MAX_SIZE;
    Rect::new(0, 0, size.width.min(columns), size.height.min(rows))
}

/// Meaning of a key.
#[derive(Clone, Debug, PartialEq)]
enum Binding {
    None,
    Action(KeyAction),
    /// Scroll the explanation down by this number of lines.
    Scroll(i16),
    Command(Command),
}

fn binding(key: KeyEvent, panel: &Panel, scenes: &[[String; 2]]) -> Binding {
    if key.kind == KeyEventKind::Release {
        return Binding::None;
    }
    if key.modifiers.contains(KeyModifiers::CONTROL) {
        return match key.code {
            KeyCode::Char('c') => Binding::Action(KeyAction::Interrupt),
            _ => Binding::None,
        };
    }
    let shift = key.modifiers.contains(KeyModifiers::SHIFT);
    let tilt = |sign: f64| match (panel.tilt_deg, panel.tilt_range_deg) {
        (Some(deg), Some([low, high])) => {
            let by = sign * TILT_STEP * if shift { 5.0 } else { 1.0 };
            // Rounding to 0.01 degrees keeps repeated steps exact.
            let deg = (1e2 * (deg + by)).round() / 1e2;
            Binding::Command(Command::Tilt {
                deg: deg.clamp(low, high),
            })
        }
        _ => Binding::None,
    };
    let speed = |ms_per_s: f64| {
        Binding::Command(Command::Speed {
            ms_per_s: ms_per_s.clamp(SPEED_RANGE[0], SPEED_RANGE[1]),
        })
    };
    let scene = |by: usize| {
        let now = scenes.iter().position(|[name, _]| *name == panel.scene);
        let next = (now.unwrap_or(0) + by) % scenes.len().max(1);
        scenes.get(next).map_or(Binding::None, |[name, _]| {
            Binding::Command(Command::Scene { name: name.clone() })
        })
    };
    match key.code {
        KeyCode::Left => tilt(-1.0),
        KeyCode::Right => tilt(1.0),
        KeyCode::Up => speed(1e3 * panel.speed * SPEED_FACTOR),
        KeyCode::Down => speed(1e3 * panel.speed / SPEED_FACTOR),
        KeyCode::PageUp => Binding::Scroll(-(PAGE as i16)),
        KeyCode::PageDown => Binding::Scroll(PAGE as i16),
        KeyCode::Char(letter) => match letter.to_ascii_lowercase() {
            'q' => Binding::Action(KeyAction::Quit),
            ' ' if panel.paused => Binding::Command(Command::Resume {}),
            ' ' => Binding::Command(Command::Pause {}),
            '.' => Binding::Command(Command::Step {}),
            'k' => Binding::Command(Command::Kick {
                mm_per_s: shift.then_some(HARD_KICK),
            }),
            'r' => Binding::Command(Command::Reset {}),
            'e' => Binding::Command(Command::Lyapunov {
                enabled: panel.lyapunov != Some(true),
            }),
            'f' if panel.recording.is_some() => Binding::Command(Command::StopRecording {}),
            'f' => Binding::Command(Command::Record {}),
            'n' => scene(1),
            'p' => scene(scenes.len().saturating_sub(1)),
            '1' => speed(1.0),
            '2' => speed(20.0),
            '3' => speed(250.0),
            '4' => speed(1000.0),
            _ => Binding::None,
        },
        _ => Binding::None,
    }
}

/// Draws the panel; `scrolled` is limited to the length of the explanation.
fn draw(
    frame: &mut Frame<'_>,
    panel: &Panel,
    page: Option<&str>,
    refused: Option<&str>,
    scrolled: &mut u16,
) {
    let rows = Layout::vertical([
        Constraint::Length(3),
        Constraint::Length(8),
        Constraint::Min(4),
        Constraint::Length(3),
    ]);
    let [head, numbers, explanation, keys] = rows.areas(frame.area());
    let title = Line::from(vec![
        Span::from(format!(" {} ", panel.scene)).bold(),
        Span::from(format!("Now: {}. ", panel.now)).bold(),
        Span::from(format!("The scene as written: {}", panel.title)).dark_gray(),
    ]);
    let head_title = match page {
        Some(page) => format!(" squeakscope live: {page} "),
        None => " squeakscope live ".to_owned(),
    };
    let head_block = Block::bordered().title(head_title);
    frame.render_widget(Paragraph::new(title).block(head_block), head);
    draw_numbers(frame, numbers, panel);
    let halves = Layout::horizontal([Constraint::Percentage(60), Constraint::Percentage(40)]);
    let [explanation, events] = halves.areas(explanation);
    draw_explanation(frame, explanation, panel, scrolled);
    draw_events(frame, events, panel, refused);
    let help = "←→ tilt (Shift: larger steps)  ↑↓ playback speed  1-4 slow motion to real time  \
                space pause  . step  k kick (Shift: strong)  r reset  n/p next/previous scene  \
                e Lyapunov exponents  f record  PgUp/PgDn scroll  q quit";
    let help = Paragraph::new(help).wrap(Wrap { trim: true }).dark_gray();
    frame.render_widget(help, keys);
    // Ratatui removes control characters, but not those that reverse the text direction.
    for cell in &mut frame.buffer_mut().content {
        if cell.symbol().contains(escape::is_hidden) {
            let seen = cell.symbol().replace(escape::is_hidden, "");
            cell.set_symbol(&seen);
        }
    }
}

fn draw_numbers(frame: &mut Frame<'_>, area: Rect, panel: &Panel) {
    let [left, right] =
        Layout::horizontal([Constraint::Percentage(50), Constraint::Percentage(50)]).areas(area);
    let name = |name: &'static str| Span::styled(format!("{name:<9}"), Style::new().dark_gray());
    let tilt = match (panel.tilt_deg, panel.tilt_range_deg) {
        (Some(deg), Some([low, high])) => format!("{deg:.2}°  ({low} to {high})"),
        _ => "fixed".to_owned(),
    };
    let measured_speed = match panel.measured_speed {
        _ if panel.paused => "  paused".to_owned(),
        Some(measured_speed) if measured_speed < 0.9 * panel.speed => {
            format!("  (actual {:.3} ms/s)", 1e3 * measured_speed)
        }
        _ => String::new(),
    };
    let speed = match 1e3 * panel.speed {
        999.5.. => "real time".to_owned(),
        ms => format!("{ms:.3} ms/s"),
    };
    let mut run = vec![
        Line::from(vec![name("tilt"), Span::from(tilt).bold()]),
        Line::from(vec![
            name("speed"),
            Span::from(speed).bold(),
            Span::from(measured_speed).yellow(),
        ]),
        Line::from(vec![
            name("time"),
            format!("{:.2} ms", 1e3 * panel.time_s).into(),
        ]),
    ];
    if let Some(counts) = panel.nodes {
        let mut spans = vec![name("nodes")];
        for (count, (color, what)) in counts.iter().zip(NODES) {
            spans.push(Span::styled(
                format!("{count:.0} {what}  "),
                Style::new().fg(color),
            ));
        }
        run.push(Line::from(spans));
    }
    if let Some(file) = &panel.recording {
        run.push(Line::from(vec![
            name("file"),
            Span::from(file.clone()).red(),
        ]));
    }
    let block = Block::bordered().title(" run ");
    frame.render_widget(Paragraph::new(run).block(block), left);

    let regime = match (&panel.regime, panel.confidence) {
        (Some(regime), Some(confidence)) => {
            format!("{regime} (confidence {:.0} %)", 1e2 * confidence)
        }
        _ => "not yet classified".to_owned(),
    };
    let mut sound = vec![
        Line::from(vec![name("motion"), Span::from(regime).bold()]),
        Line::from(vec![
            name("velocity"),
            format!("{:.3} mm/s", panel.peak_velocity_mm_per_s).into(),
        ]),
    ];
    for (k, line) in panel.lines.iter().take(4).enumerate() {
        let text = format!(
            "{:8.1} Hz  {:8.3} mm/s  {}",
            line.frequency,
            1e3 * line.amplitude,
            line.label
        );
        sound.push(Line::from(vec![
            name(if k == 0 { "lines" } else { "" }),
            text.into(),
        ]));
    }
    let block = Block::bordered().title(" vibration ");
    frame.render_widget(Paragraph::new(sound).block(block), right);
}

fn draw_explanation(frame: &mut Frame<'_>, area: Rect, panel: &Panel, scrolled: &mut u16) {
    let text = match (panel.lesson.is_empty(), panel.narration.is_empty()) {
        (false, _) => format!("{}\n\n{}", panel.lesson, panel.narration),
        (true, false) => panel.narration.clone(),
        (true, true) => panel.about.clone(),
    };
    let lines = markdown::lines(&text);
    *scrolled = (*scrolled).min(lines.len().saturating_sub(1) as u16);
    let explanation = Paragraph::new(lines)
        .wrap(Wrap { trim: true })
        .scroll((*scrolled, 0))
        .block(Block::bordered().title(" explanation "));
    frame.render_widget(explanation, area);
}

fn draw_events(frame: &mut Frame<'_>, area: Rect, panel: &Panel, refused: Option<&str>) {
    let mut lines: Vec<Line<'_>> = Vec::new();
    if let Some(error) = refused {
        lines.push(Line::from(error.to_owned()).red());
    }
    lines.extend(panel.events.iter().rev().map(|event| {
        let time = Span::styled(
            format!("{:.1} ms  ", 1e3 * event.time_s),
            Style::new().dark_gray(),
        );
        Line::from(vec![time, event.text.clone().into()])
    }));
    let events = Paragraph::new(lines)
        .wrap(Wrap { trim: true })
        .block(Block::bordered().title(" events "));
    frame.render_widget(events, area);
}

#[cfg(test)]
mod tests {
    use ratatui::backend::TestBackend;

    use super::*;

    fn panel() -> Panel {
        Panel {
            scene: "torus-3deg".to_owned(),
            title: "A torus".to_owned(),
            now: "chaotic".to_owned(),
            speed: 0.02,
            tilt_deg: Some(3.0),
            tilt_range_deg: Some([0.0, 10.0]),
            nodes: Some([1.0, 97.0, 2.0]),
            narration: "## Looks like **two** tones\n\nand so on".to_owned(),
            lines: vec![crate::analysis::SpectralLine {
                frequency: 4112.8,
                amplitude: 15.9e-3,
                label: "f1".to_owned(),
            }],
            ..Panel::default()
        }
    }

    fn press(code: KeyCode, modifiers: KeyModifiers) -> Binding {
        let scenes =
            ["tilt-ramp", "torus-3deg", "paper"].map(|name| [name.to_owned(), String::new()]);
        binding(KeyEvent::new(code, modifiers), &panel(), &scenes)
    }

    #[test]
    fn keys_are_bound_to_commands() {
        let none = KeyModifiers::NONE;
        let tilt = |deg| Binding::Command(Command::Tilt { deg });
        assert_eq!(press(KeyCode::Right, none), tilt(3.1));
        assert_eq!(press(KeyCode::Left, KeyModifiers::SHIFT), tilt(2.5));
        let speed = |ms_per_s| Binding::Command(Command::Speed { ms_per_s });
        assert_eq!(press(KeyCode::Up, none), speed(25.0));
        assert_eq!(press(KeyCode::Char('4'), none), speed(1000.0));
        assert_eq!(
            press(KeyCode::Char(' '), none),
            Binding::Command(Command::Pause {})
        );
        let scene = |name: &str| {
            Binding::Command(Command::Scene {
                name: name.to_owned(),
            })
        };
        assert_eq!(press(KeyCode::Char('n'), none), scene("paper"));
        assert_eq!(press(KeyCode::Char('p'), none), scene("tilt-ramp"));
        let enable = Command::Lyapunov { enabled: true };
        assert_eq!(press(KeyCode::Char('e'), none), Binding::Command(enable));
        assert_eq!(
            press(KeyCode::Char('q'), none),
            Binding::Action(KeyAction::Quit)
        );
        let interrupt = press(KeyCode::Char('c'), KeyModifiers::CONTROL);
        assert_eq!(interrupt, Binding::Action(KeyAction::Interrupt));
        assert_eq!(press(KeyCode::Char('x'), none), Binding::None);
        assert_eq!(press(KeyCode::PageDown, none), Binding::Scroll(5));
    }

    /// Control characters in a scene file do not reach the terminal.
    #[test]
    fn control_characters_are_removed() {
        let evil = || "a\u{1b}[2J\u{9b}1m\u{202e}b\u{2066}c\nd".to_owned();
        let panel = Panel {
            scene: evil(),
            title: evil(),
            narration: evil(),
            recording: Some(evil()),
            regime: Some(evil()),
            ..panel()
        };
        let mut terminal = ratatui::Terminal::new(TestBackend::new(100, 30)).unwrap();
        let text = evil();
        terminal
            .draw(|frame| draw(frame, &panel, Some(&text), Some(&text), &mut 0))
            .unwrap();
        let cells = &terminal.backend().buffer().content;
        let hidden = |c: char| c.is_control() || "\u{202e}\u{2066}".contains(c);
        let found = cells.iter().find(|cell| cell.symbol().contains(hidden));
        assert!(found.is_none(), "{found:?}");
    }

    #[test]
    fn the_main_results_are_drawn() {
        for (size, scrolled) in [((100, 30), 0), ((60, 20), 2), ((20, 5), 99)] {
            let mut scrolled = scrolled;
            let mut terminal = ratatui::Terminal::new(TestBackend::new(size.0, size.1)).unwrap();
            terminal
                .draw(|frame| {
                    draw(
                        frame,
                        &panel(),
                        Some("http://127.0.0.1:9180/"),
                        Some("the tilt must be less"),
                        &mut scrolled,
                    )
                })
                .unwrap();
            let text = terminal.backend().to_string();
            assert!(scrolled <= 2, "the text has three lines");
            if size.0 < 100 {
                continue;
            }
            for part in [
                "3.00°",
                "20.000 ms/s",
                "97 slipping",
                "4112.8 Hz",
                "Now: chaotic. The scene as written: A torus",
                "Looks like two tones",
                "the tilt must be less",
                "http://127.0.0.1:9180/",
            ] {
                assert!(text.contains(part), "{part}:\n{text}");
            }
        }
    }

    #[test]
    fn any_terminal_size_can_be_drawn() {
        use ratatui::backend::CrosstermBackend;

        let size = |(columns, rows)| drawn_area(Size::new(columns, rows));
        let viewport = Viewport::Fixed(size((80, 25)));
        let backend = CrosstermBackend::new(Vec::new());
        let options = TerminalOptions { viewport };
        let mut terminal = ratatui::Terminal::with_options(backend, options).unwrap();
        let max = u16::MAX;
        for claimed in [
            (0, 0),
            (1, 1),
            (max, 0),
            (max, 1),
            (1, max),
            (max, max),
            (80, 25),
        ] {
            terminal.resize(size(claimed)).unwrap();
            let drawn = terminal.draw(|frame| draw(frame, &panel(), None, None, &mut 0));
            let cells = drawn.unwrap().buffer.content.len();
            assert!(cells <= 80_000, "{claimed:?}: {cells}");
        }
    }
}

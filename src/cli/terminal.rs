//! The controls of a live run in the terminal: keys, and the main numbers.

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

use super::plain;
use crate::escape;
use crate::live::{Command, HARD, PACES, Panel, Session};

/// How much a key tilts, degrees; with Shift, five times as much.
const NUDGE: f64 = 0.1;
/// How long a tilt that was asked for counts as the one that is there.
const AIMED: Duration = Duration::from_millis(500);
/// By how much a key changes the pace.
const FASTER: f64 = 1.25;
/// Lines that a key scrolls.
const PAGE: u16 = 5;
/// Columns and rows that are drawn on, at most; the rest of a larger terminal stays empty. Each takes memory,
/// and a terminal may claim 65535 of both.
const LARGEST: [u16; 2] = [400, 200];
/// Contact nodes that stick, slip, are open: as in the recording.
const NODES: [(Color, &str); 3] = [
    (Color::Rgb(255, 165, 58), "stick"),
    (Color::Rgb(88, 169, 255), "slide"),
    (Color::White, "open"),
];

/// What a key says that is no command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Told {
    /// Nothing.
    Nothing,
    /// To end.
    Quit,
    /// To end as Ctrl-C does.
    Interrupt,
}

/// The terminal while it is taken; it is given back when this is dropped.
pub(super) struct Terminal {
    terminal: DefaultTerminal,
    refused: Option<String>,
    /// The tilt that was asked for last, degrees, and when: the panel shows it a moment later.
    aim: Option<(f64, Instant)>,
    /// Where the page is, if there is one.
    page: Option<String>,
    /// Lines of the words above those that are seen, and the scene that they are of.
    scrolled: (u16, String),
}

impl Terminal {
    /// Takes the terminal.
    ///
    /// # Errors
    /// When it is none, or cannot be drawn on.
    pub fn open(page: Option<String>) -> io::Result<Self> {
        let (columns, rows) = terminal::size()?;
        let viewport = Viewport::Fixed(drawn_area(Size::new(columns, rows)));
        let opened = ratatui::try_init_with_options(TerminalOptions { viewport })
            .and_then(|terminal| execute!(stdout(), EnterAlternateScreen).map(|()| terminal));
        Ok(Self {
            terminal: opened.inspect_err(|_| ratatui::restore())?,
            refused: None,
            aim: None,
            page,
            scrolled: Default::default(),
        })
    }

    /// Draws, and takes a key if one has been pressed. A terminal that was closed ends the run as Ctrl-C does.
    ///
    /// # Errors
    /// When the terminal cannot be drawn on or read.
    pub fn turn(&mut self, session: &Session) -> io::Result<Told> {
        if !io::stdin().is_terminal() {
            return Ok(Told::Interrupt);
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
        // Never waited for here: the library would not come back from a terminal that is closed meanwhile.
        if !event::poll(Duration::ZERO)? {
            return Ok(Told::Nothing);
        }
        let Event::Key(key) = event::read()? else {
            return Ok(Told::Nothing);
        };
        let mut known = panel;
        if let Some((deg, when)) = self.aim
            && when.elapsed() < AIMED
        {
            known.tilt_deg = known.tilt_deg.map(|_| deg);
        }
        match asked(key, &known, &session.scenes()) {
            Asked::Nothing => {}
            Asked::Told(told) => return Ok(told),
            Asked::Scroll(lines) => {
                self.scrolled.0 = self.scrolled.0.saturating_add_signed(lines);
            }
            Asked::Command(command) => {
                if let Command::Tilt { deg } = command {
                    self.aim = Some((deg, Instant::now()));
                }
                self.refused = session.obey(&command).err().map(|why| why.to_string());
            }
        }
        Ok(Told::Nothing)
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        ratatui::restore();
    }
}

/// What is drawn on of a terminal.
fn drawn_area(size: Size) -> Rect {
    let [columns, rows] = LARGEST;
    Rect::new(0, 0, size.width.min(columns), size.height.min(rows))
}

/// What a key asks for.
#[derive(Clone, Debug, PartialEq)]
enum Asked {
    Nothing,
    Told(Told),
    /// To see words that are so many lines further down.
    Scroll(i16),
    Command(Command),
}

fn asked(key: KeyEvent, panel: &Panel, scenes: &[[String; 2]]) -> Asked {
    if key.kind == KeyEventKind::Release {
        return Asked::Nothing;
    }
    if key.modifiers.contains(KeyModifiers::CONTROL) {
        return match key.code {
            KeyCode::Char('c') => Asked::Told(Told::Interrupt),
            _ => Asked::Nothing,
        };
    }
    let shift = key.modifiers.contains(KeyModifiers::SHIFT);
    let tilt = |sign: f64| match (panel.tilt_deg, panel.reach_deg) {
        (Some(deg), Some([low, high])) => {
            let by = sign * NUDGE * if shift { 5.0 } else { 1.0 };
            // To whole hundredths: steps of a tenth add up to what they say.
            let deg = (1e2 * (deg + by)).round() / 1e2;
            Asked::Command(Command::Tilt {
                deg: deg.clamp(low, high),
            })
        }
        _ => Asked::Nothing,
    };
    let pace = |ms_per_s: f64| {
        Asked::Command(Command::Pace {
            ms_per_s: ms_per_s.clamp(PACES[0], PACES[1]),
        })
    };
    let scene = |by: usize| {
        let now = scenes.iter().position(|[name, _]| *name == panel.scene);
        let next = (now.unwrap_or(0) + by) % scenes.len().max(1);
        scenes.get(next).map_or(Asked::Nothing, |[name, _]| {
            Asked::Command(Command::Scene { name: name.clone() })
        })
    };
    match key.code {
        KeyCode::Left => tilt(-1.0),
        KeyCode::Right => tilt(1.0),
        KeyCode::Up => pace(1e3 * panel.pace * FASTER),
        KeyCode::Down => pace(1e3 * panel.pace / FASTER),
        KeyCode::PageUp => Asked::Scroll(-(PAGE as i16)),
        KeyCode::PageDown => Asked::Scroll(PAGE as i16),
        KeyCode::Char(letter) => match letter.to_ascii_lowercase() {
            'q' => Asked::Told(Told::Quit),
            ' ' if panel.paused => Asked::Command(Command::Resume {}),
            ' ' => Asked::Command(Command::Pause {}),
            '.' => Asked::Command(Command::Step {}),
            'k' => Asked::Command(Command::Kick {
                mm_per_s: shift.then_some(HARD),
            }),
            'r' => Asked::Command(Command::Reset {}),
            'e' => Asked::Command(Command::Neighbours {
                follow: panel.neighbours != Some(true),
            }),
            'f' if panel.recording.is_some() => Asked::Command(Command::StopRecording {}),
            'f' => Asked::Command(Command::Record {}),
            'n' => scene(1),
            'p' => scene(scenes.len().saturating_sub(1)),
            '1' => pace(1.0),
            '2' => pace(20.0),
            '3' => pace(250.0),
            '4' => pace(1000.0),
            _ => Asked::Nothing,
        },
        _ => Asked::Nothing,
    }
}

/// Draws the panel, its words scrolled as far as there are any.
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
    let [head, numbers, words, keys] = rows.areas(frame.area());
    let title = Line::from(vec![
        Span::from(format!(" {} ", panel.scene)).bold(),
        Span::from(panel.title.clone()),
    ]);
    let head_title = match page {
        Some(page) => format!(" squeakscope live: {page} "),
        None => " squeakscope live ".to_owned(),
    };
    let head_block = Block::bordered().title(head_title);
    frame.render_widget(Paragraph::new(title).block(head_block), head);
    draw_numbers(frame, numbers, panel);
    let [words, events] =
        Layout::horizontal([Constraint::Percentage(60), Constraint::Percentage(40)]).areas(words);
    draw_words(frame, words, panel, scrolled);
    draw_events(frame, events, panel, refused);
    let help = "←→ tilt (Shift: faster)  ↑↓ pace  1-4 slow motion..real time  space pause  . step  \
                k kick (Shift: hard)  r reset  n/p scene  e neighbours  f record  \
                PgUp PgDn words  q quit";
    let help = Paragraph::new(help).wrap(Wrap { trim: true }).dark_gray();
    frame.render_widget(help, keys);
    // The library leaves out control characters, but not those that turn a line round.
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
    let tilt = match (panel.tilt_deg, panel.reach_deg) {
        (Some(deg), Some([low, high])) => format!("{deg:.2}°  ({low} to {high})"),
        _ => "nothing to tilt".to_owned(),
    };
    let reached = match panel.reached {
        _ if panel.paused => "  paused".to_owned(),
        Some(reached) if reached < 0.9 * panel.pace => {
            format!("  (reaches {:.3} ms/s)", 1e3 * reached)
        }
        _ => String::new(),
    };
    let pace = match 1e3 * panel.pace {
        999.5.. => "real time".to_owned(),
        ms => format!("{ms:.3} ms/s"),
    };
    let mut run = vec![
        Line::from(vec![name("tilt"), Span::from(tilt).bold()]),
        Line::from(vec![
            name("pace"),
            Span::from(pace).bold(),
            Span::from(reached).yellow(),
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
                format!("{count} {what}  "),
                Style::new().fg(color),
            ));
        }
        run.push(Line::from(spans));
    }
    if let Some(file) = &panel.recording {
        run.push(Line::from(vec![
            name("into"),
            Span::from(file.clone()).red(),
        ]));
    }
    let block = Block::bordered().title(" run ");
    frame.render_widget(Paragraph::new(run).block(block), left);

    let regime = match (&panel.regime, panel.confidence) {
        (Some(regime), Some(sure)) => format!("{regime} ({:.0} % sure)", 1e2 * sure),
        _ => "not yet told".to_owned(),
    };
    let mut sound = vec![
        Line::from(vec![name("motion"), Span::from(regime).bold()]),
        Line::from(vec![
            name("speed"),
            format!("{:.3} mm/s", panel.speed_mm_s).into(),
        ]),
    ];
    for (k, line) in panel.lines.iter().take(4).enumerate() {
        let words = format!(
            "{:8.1} Hz  {:8.3} mm/s  {}",
            line.frequency,
            1e3 * line.amplitude,
            line.label
        );
        sound.push(Line::from(vec![
            name(if k == 0 { "tones" } else { "" }),
            words.into(),
        ]));
    }
    let block = Block::bordered().title(" sound ");
    frame.render_widget(Paragraph::new(sound).block(block), right);
}

fn draw_words(frame: &mut Frame<'_>, area: Rect, panel: &Panel, scrolled: &mut u16) {
    let words = match (panel.lesson.is_empty(), panel.words.is_empty()) {
        (false, _) => format!("{}\n\n{}", panel.lesson, panel.words),
        (true, false) => panel.words.clone(),
        (true, true) => panel.about.clone(),
    };
    let lines = plain::lines(&words);
    *scrolled = (*scrolled).min(lines.len().saturating_sub(1) as u16);
    let seen = Paragraph::new(lines)
        .wrap(Wrap { trim: true })
        .scroll((*scrolled, 0))
        .block(Block::bordered().title(" what you see "));
    frame.render_widget(seen, area);
}

fn draw_events(frame: &mut Frame<'_>, area: Rect, panel: &Panel, refused: Option<&str>) {
    let mut lines: Vec<Line<'_>> = Vec::new();
    if let Some(why) = refused {
        lines.push(Line::from(why.to_owned()).red());
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
            pace: 0.02,
            tilt_deg: Some(3.0),
            reach_deg: Some([0.0, 10.0]),
            nodes: Some([1, 97, 2]),
            words: "## Looks like **two** tones\n\nand so on".to_owned(),
            lines: vec![crate::analysis::SpectralLine {
                frequency: 4112.8,
                amplitude: 15.9e-3,
                label: "f1".to_owned(),
            }],
            ..Panel::default()
        }
    }

    fn press(code: KeyCode, modifiers: KeyModifiers) -> Asked {
        let scenes =
            ["tilt-ramp", "torus-3deg", "paper"].map(|name| [name.to_owned(), String::new()]);
        asked(KeyEvent::new(code, modifiers), &panel(), &scenes)
    }

    #[test]
    fn keys_are_commands() {
        let none = KeyModifiers::NONE;
        let tilt = |deg| Asked::Command(Command::Tilt { deg });
        assert_eq!(press(KeyCode::Right, none), tilt(3.1));
        assert_eq!(press(KeyCode::Left, KeyModifiers::SHIFT), tilt(2.5));
        let pace = |ms_per_s| Asked::Command(Command::Pace { ms_per_s });
        assert_eq!(press(KeyCode::Up, none), pace(25.0));
        assert_eq!(press(KeyCode::Char('4'), none), pace(1000.0));
        assert_eq!(
            press(KeyCode::Char(' '), none),
            Asked::Command(Command::Pause {})
        );
        let scene = |name: &str| {
            Asked::Command(Command::Scene {
                name: name.to_owned(),
            })
        };
        assert_eq!(press(KeyCode::Char('n'), none), scene("paper"));
        assert_eq!(press(KeyCode::Char('p'), none), scene("tilt-ramp"));
        let follow = Command::Neighbours { follow: true };
        assert_eq!(press(KeyCode::Char('e'), none), Asked::Command(follow));
        assert_eq!(press(KeyCode::Char('q'), none), Asked::Told(Told::Quit));
        let interrupt = press(KeyCode::Char('c'), KeyModifiers::CONTROL);
        assert_eq!(interrupt, Asked::Told(Told::Interrupt));
        assert_eq!(press(KeyCode::Char('x'), none), Asked::Nothing);
        assert_eq!(press(KeyCode::PageDown, none), Asked::Scroll(5));
    }

    /// Whatever a scene's file says, nothing but what is seen goes to the terminal.
    #[test]
    fn foreign_text_is_not_obeyed() {
        let evil = || "a\u{1b}[2J\u{9b}1m\u{202e}b\u{2066}c\nd".to_owned();
        let panel = Panel {
            scene: evil(),
            title: evil(),
            words: evil(),
            recording: Some(evil()),
            regime: Some(evil()),
            ..panel()
        };
        let mut terminal = ratatui::Terminal::new(TestBackend::new(100, 30)).unwrap();
        let told = evil();
        terminal
            .draw(|frame| draw(frame, &panel, Some(&told), Some(&told), &mut 0))
            .unwrap();
        let cells = &terminal.backend().buffer().content;
        let hidden = |c: char| c.is_control() || "\u{202e}\u{2066}".contains(c);
        let found = cells.iter().find(|cell| cell.symbol().contains(hidden));
        assert!(found.is_none(), "{found:?}");
    }

    #[test]
    fn the_main_numbers_are_drawn() {
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
            assert!(scrolled <= 2, "three lines");
            if size.0 < 100 {
                continue;
            }
            for part in [
                "3.00°",
                "20.000 ms/s",
                "97 slide",
                "4112.8 Hz",
                "Looks like two tones",
                "the tilt must be less",
                "http://127.0.0.1:9180/",
            ] {
                assert!(text.contains(part), "{part}:\n{text}");
            }
        }
    }

    #[test]
    fn a_terminal_may_be_of_any_size() {
        use ratatui::backend::CrosstermBackend;

        let size = |(columns, rows)| drawn_area(Size::new(columns, rows));
        let viewport = Viewport::Fixed(size((80, 25)));
        let backend = CrosstermBackend::new(Vec::new());
        let options = TerminalOptions { viewport };
        let mut terminal = ratatui::Terminal::with_options(backend, options).unwrap();
        let most = u16::MAX;
        for claimed in [
            (0, 0),
            (1, 1),
            (most, 0),
            (most, 1),
            (1, most),
            (most, most),
            (80, 25),
        ] {
            terminal.resize(size(claimed)).unwrap();
            let drawn = terminal.draw(|frame| draw(frame, &panel(), None, None, &mut 0));
            let cells = drawn.unwrap().buffer.content.len();
            assert!(cells <= 80_000, "{claimed:?}: {cells}");
        }
    }
}

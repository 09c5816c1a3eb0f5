//! The help: commands grouped by task, with examples at the end of each command's help.

use std::fmt::Write as _;

use clap::CommandFactory;

use super::args::Args;

/// Commands for one kind of task.
struct Task {
    title: &'static str,
    commands: &'static [Entry],
}

/// A command with two or three examples: what each does, and its command line.
struct Entry {
    name: &'static str,
    examples: &'static [[&'static str; 2]],
}

/// Every command of [`super::args::Command`] occurs once; a test checks it.
static TASKS: [Task; 6] = [
    Task {
        title: "Simulate",
        commands: &[Entry {
            name: "run",
            examples: &[
                [
                    "Simulate a torus and save the recording for the Rerun viewer",
                    "squeakscope run torus-3deg --save torus.rrd",
                ],
                [
                    "Hold the tilt at 2.5 degrees for 100 ms and watch in a viewer",
                    "squeakscope run tilt-ramp --tilt 2.5 --duration 100 --spawn",
                ],
                [
                    "Write the sound ten times slower, and the samples for NumPy",
                    "squeakscope run chaos-5deg --wav chaos.wav --time-stretch 10 --npz chaos.npz",
                ],
            ],
        }],
    },
    Task {
        title: "Watch live",
        commands: &[Entry {
            name: "live",
            examples: &[
                [
                    "Serve a page with viewer, controls and sound",
                    "squeakscope live torus-3deg --serve",
                ],
                [
                    "Run in real time, without the expensive analyses, in a viewer on this machine",
                    "squeakscope live tilt-ramp --spawn --speed 1000 --no-lyapunov",
                ],
            ],
        }],
    },
    Task {
        title: "Study",
        commands: &[
            Entry {
                name: "stability",
                examples: &[
                    [
                        "Find the unstable modes at tilts from 0 to 7 degrees",
                        "squeakscope stability periodic-2deg --tilt 0:7:0.5",
                    ],
                    [
                        "Show which terms destabilise each mode at 2 degrees",
                        "squeakscope stability periodic-2deg --tilt 2 --causes",
                    ],
                ],
            },
            Entry {
                name: "lyapunov",
                examples: &[
                    [
                        "Compute the largest exponent to +-2 1/s",
                        "squeakscope lyapunov chaos-5deg --exponents 1 --target-half-width 2",
                    ],
                    [
                        "Average four exponents over 4 s, and draw their convergence",
                        "squeakscope lyapunov tilt-ramp --exponents 4 --average-time 4 --figures lyapunov.png",
                    ],
                ],
            },
            Entry {
                name: "sweep",
                examples: &[
                    [
                        "Sweep the tilt upward and downward, and draw the bifurcation diagram",
                        "squeakscope sweep torus-3deg --tilt 1:8:0.5 --start both --figures figures",
                    ],
                    [
                        "Sweep the contact stiffness, with a fresh start at each point",
                        "squeakscope sweep torus-3deg --param contact.stiffness_factor=1:20:0.5 --start fresh",
                    ],
                    [
                        "Compute part 3 of 8 of a map on this machine",
                        "squeakscope sweep --tilt 0:8:0.1 --param load_n=100:200:10 --shard 3/8 --out part-3.arrow",
                    ],
                ],
            },
            Entry {
                name: "basins",
                examples: &[
                    [
                        "Find the attractors that 50 random kicks reach at 3 degrees",
                        "squeakscope basins torus-3deg --tilt 3 --kicks 50",
                    ],
                    [
                        "Resume an interrupted study",
                        "squeakscope basins torus-3deg --tilt 3 --kicks 50 --resume",
                    ],
                ],
            },
            Entry {
                name: "merge",
                examples: &[
                    [
                        "Merge two shards into sweep.arrow",
                        "squeakscope merge part-1.arrow part-2.arrow",
                    ],
                    [
                        "Draw the figures of one table",
                        "squeakscope merge sweep.arrow --out copy.arrow --figures figures",
                    ],
                ],
            },
            Entry {
                name: "paper",
                examples: &[
                    [
                        "Draw all figures and check all claims",
                        "squeakscope paper --out paper",
                    ],
                    [
                        "Draw the bifurcation diagram only",
                        "squeakscope paper --figure 11",
                    ],
                ],
            },
            Entry {
                name: "calibrate",
                examples: &[
                    [
                        "Search for 12 generations, and write the best set as a scene",
                        "squeakscope calibrate --best best.toml",
                    ],
                    [
                        "Resume an interrupted search",
                        "squeakscope calibrate --best best.toml --resume",
                    ],
                ],
            },
            Entry {
                name: "cost",
                examples: &[
                    [
                        "Study all settings of a scene",
                        "squeakscope cost torus-3deg --out cost",
                    ],
                    [
                        "Find the cheapest integrator, and write it into a scene file",
                        "squeakscope cost torus-3deg --setting integrator --write torus.toml",
                    ],
                ],
            },
            Entry {
                name: "growth",
                examples: &[
                    ["Measure a scene", "squeakscope growth torus-3deg"],
                    [
                        "Use at most four threads, and write a chapter in Markdown",
                        "squeakscope growth torus-3deg --threads 4 --markdown growth.md",
                    ],
                ],
            },
        ],
    },
    Task {
        title: "Analyse a signal",
        commands: &[Entry {
            name: "analyse",
            examples: &[
                [
                    "List what sounds when in a sound file, classify the motion, and draw all figures",
                    "squeakscope analyse squeak.wav --figures figures",
                ],
                [
                    "Analyse the motion within the second tonal event",
                    "squeakscope analyse squeak.wav --event 2",
                ],
                [
                    "Analyse one column of a table from 0.2 s on, sampled at 50 kHz",
                    "squeakscope analyse data.csv --column velocity --rate 50000 --from 0.2",
                ],
            ],
        }],
    },
    Task {
        title: "Inspect",
        commands: &[
            Entry {
                name: "scenes",
                examples: &[
                    ["List the scenes", "squeakscope scenes"],
                    [
                        "Write a copy of a scene as a starting point for your own",
                        "squeakscope scenes torus-3deg > mine.toml",
                    ],
                    [
                        "Measure the CPU time of each effect of a scene",
                        "squeakscope scenes torus-3deg --effects",
                    ],
                ],
            },
            Entry {
                name: "model",
                examples: &[
                    [
                        "Export the default scene",
                        "squeakscope model --out model.npz",
                    ],
                    [
                        "Export your own scene, and the numbers of nodes and modes",
                        "squeakscope model mine.toml --out model.npz --json model.json",
                    ],
                ],
            },
        ],
    },
    Task {
        title: "Set up",
        commands: &[
            Entry {
                name: "completions",
                examples: &[
                    [
                        "Bash",
                        "squeakscope completions bash > ~/.local/share/bash-completion/completions/squeakscope",
                    ],
                    [
                        "Fish",
                        "squeakscope completions fish > ~/.config/fish/completions/squeakscope.fish",
                    ],
                ],
            },
            Entry {
                name: "man",
                examples: &[
                    [
                        "Install the man pages for this user",
                        "squeakscope man ~/.local/share/man/man1",
                    ],
                    [
                        "Write the man pages to a directory for packaging",
                        "squeakscope man target/man",
                    ],
                ],
            },
        ],
    },
];

/// Examples at the end of the main help.
const FIRST_STEPS: [[&str; 2]; 3] = [
    [
        "Simulate the default scene; `rerun squeak.rrd` opens the recording",
        "squeakscope",
    ],
    ["Change the tilt while it squeaks", "squeakscope live"],
    [
        "Analyse your own recording",
        "squeakscope analyse squeak.wav",
    ],
];

/// The parser of the command line, with the grouped help and the examples.
pub(super) fn command() -> clap::Command {
    let mut command = Args::command();
    let header = *command.get_styles().get_header();
    let literal = *command.get_styles().get_literal();
    let examples = |examples: &[[&str; 2]]| {
        let mut text = format!("{header}Examples:{header:#}");
        for [purpose, line] in examples {
            let _ = write!(text, "\n  {purpose}:\n    {literal}{line}{literal:#}");
        }
        text
    };
    let mut groups = String::new();
    for Task { title, commands } in &TASKS {
        let _ = writeln!(groups, "{header}{title}:{header:#}");
        for Entry {
            name,
            examples: own,
        } in *commands
        {
            let about = command
                .find_subcommand(name)
                .and_then(clap::Command::get_about);
            let about = about.map(ToString::to_string).unwrap_or_default();
            let _ = writeln!(groups, "  {literal}{name:<11}{literal:#}  {about}");
            command = command.mut_subcommand(name, |command| command.after_help(examples(own)));
        }
        groups.push('\n');
    }
    let template = format!(
        "{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n{groups}{header}Options:{header:#}\n\
         {{options}}{{after-help}}"
    );
    let more = format!(
        "`{literal}squeakscope COMMAND --help{literal:#}` prints the options of a command.\n\n{}",
        examples(&FIRST_STEPS)
    );
    command.help_template(template).after_help(more)
}

#[cfg(test)]
#[path = "help_tests.rs"]
mod tests;

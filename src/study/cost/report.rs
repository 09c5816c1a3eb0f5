//! The report of a cost study.

use super::{Cost, Effect, Motion, Origin, Setting, WorkPrecision};
use crate::number::{error, quantity, short, tolerance};
use crate::report::{Block, Measured, Report, Table};

impl Report for Cost {
    fn blocks(&self, scene: &str) -> Vec<Block> {
        let rest = format!(
            ": {}; settles for {}, measured for {}",
            motion(&self.reference),
            quantity(self.settling, 3, "s"),
            quantity(self.measurement, 3, "s"),
        );
        let mut blocks = vec![Block::heading(scene, rest)];
        if let Some(held) = self.fixed_at.description() {
            blocks.push(Block::text(format!("held at its initial values: {held}")));
        }
        if let Some(scatter) = self.scatter {
            blocks.push(Block::text(format!(
                "two measurements of this motion differ by {}: smaller errors cannot be seen",
                error(scatter)
            )));
        }
        for setting in Setting::ALL {
            let sets = self.settings.iter().filter(|set| set.setting == setting);
            let sets: Vec<&WorkPrecision> = sets.collect();
            if !sets.is_empty() {
                let rest = format!(": error, and {}", setting.time());
                blocks.push(Block::heading(setting.name(), rest));
                blocks.push(Block::Table(levels(&sets)));
            }
        }
        if !self.choices.is_empty() {
            let rest = ", verified by a run at the next finer level of everything";
            blocks.push(Block::heading("settings for a total error", rest));
            blocks.push(Block::Table(choices(self)));
        }
        if let Some(run) = self.run_time {
            let run = short(run);
            let rest = format!(": a complete run takes {run} s of CPU time per simulated s");
            blocks.push(Block::heading("effects", rest));
            blocks.push(Block::Table(effects(&self.effects)));
        }
        blocks
    }

    fn is_interrupted(&self) -> bool {
        self.stopped
    }
}

/// The type of a motion, its frequency, amplitude, velocity and largest exponent.
fn motion(motion: &Motion) -> String {
    let mut text = motion.regime.to_string();
    if let (Some(frequency), Some(amplitude)) = (motion.frequency_hz, motion.amplitude_m) {
        let amplitude = quantity(amplitude, 4, "m");
        text += &format!(", {frequency:.1} Hz with {amplitude}");
    }
    let rms = quantity(motion.rms_velocity_m_per_s, 4, "m/s");
    text += &format!(", rms velocity {rms}");
    if let Some(exponent) = motion.exponent_per_s {
        let exponent = Measured::from(&exponent).unit("1/s");
        text += &format!(", largest exponent {exponent}");
    }
    text
}

/// The levels of one setting: a column for each method.
fn levels(sets: &[&WorkPrecision]) -> Table {
    let mut table = Table::default().right("");
    for set in sets {
        table = table.right(&set.method).right("");
    }
    for (row, level) in sets[0].points.iter().enumerate() {
        let cells = sets.iter().filter_map(|set| set.points.get(row));
        let cells = cells.flat_map(|point| match point.error {
            Some(found) => [error(found), short(point.cpu_s)],
            None => ["failed".to_owned(), String::new()],
        });
        table.row([tolerance(level.value)].into_iter().chain(cells));
    }
    table
}

fn choices(study: &Cost) -> Table {
    let mut table = Table::default().right("error").left("").left("method");
    for title in ["tolerance", "nodes", "elements, mm", "s per s", "verified"] {
        table = table.right(title);
    }
    table = table.left("");
    for choice in &study.choices {
        let settings = &choice.settings;
        let remark = match (choice.is_met, choice.exponents_agree) {
            (false, _) => "not met",
            (true, Some(false)) => "exponents differ",
            (true, _) => "",
        };
        table.row([
            error(choice.target),
            match choice.origin {
                Origin::Cheapest => "cheapest".to_owned(),
                Origin::Accuracy => "--accuracy".to_owned(),
            },
            settings.method.clone(),
            tolerance(settings.tolerance),
            settings.nodes.map(|n| n.to_string()).unwrap_or_default(),
            settings.element_size_mm.map(short).unwrap_or_default(),
            short(choice.cpu_s_per_s),
            error(choice.error),
            remark.to_owned(),
        ]);
    }
    table
}

fn effects(effects: &[Effect]) -> Table {
    let mut table = Table::default().left("effect").left("key");
    table = table.right("s per s").right("ratio").left("without it");
    for effect in effects {
        let price = match effect.price_s_per_s {
            Some(price) if price.abs() < effect.noise_s_per_s => {
                format!("< {}", short(effect.noise_s_per_s))
            }
            Some(price) => short(price),
            None => String::new(),
        };
        let without = match (&effect.unavailable, &effect.without, effect.change) {
            (Some(reason), ..) => format!("cannot be switched off alone: {}", reason),
            (None, Some(other), Some(change)) => {
                format!("{} ({} different)", motion(other), error(change))
            }
            _ => String::new(),
        };
        table.row([
            effect.name.clone(),
            effect.key.clone(),
            price,
            effect.ratio.map(short).unwrap_or_default(),
            without,
        ]);
    }
    table
}

#[cfg(test)]
mod tests {
    use crate::report::agreement;
    use crate::scene::Scene;
    use crate::study::cost::cost;

    #[test]
    fn the_report_has_the_numbers_of_the_result() {
        let scene = Scene::load("mass-on-belt").unwrap();
        let study = cost(&scene, None, &mut |_| Ok(())).unwrap();
        agreement::check(&study, &[]);
        let json = serde_json::to_value(&study).unwrap();
        assert_eq!(json["choices"][0]["error"], study.choices[0].error);
    }
}

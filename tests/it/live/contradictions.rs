//! Statements of the panel of a live run that contradict each other.

use serde_json::Value;

/// Motions, each with phrases of a commentary that deny it.
const DENIALS: [(&str, &[&str]); 4] = [
    (
        "periodic",
        &[
            "broadband floor",
            "wo base frequencies",
            "on a torus",
            "Silent",
        ],
    ),
    (
        "quasi-periodic",
        &[
            "broadband floor",
            "One fundamental",
            "one tone",
            "pure tone",
            "Silent",
        ],
    ),
    (
        "chaotic",
        &[
            "One fundamental",
            "one tone",
            "pure tone",
            "never exactly repeats",
            "Silent",
        ],
    ),
    (
        "the tilt moves",
        &[
            "One fundamental",
            "never exactly repeats",
            "broadband floor",
        ],
    ),
];

/// The contradictions of a panel as a page gets it.
pub fn contradictions(panel: &Value) -> Vec<String> {
    let text = |key: &str| panel[key].as_str().unwrap_or_default();
    let [motion, commentary] = ["motion", "narration"].map(text);
    let kind = motion.split(':').next().unwrap_or_default();
    let denials = DENIALS.iter().filter(|(denied, _)| *denied == kind);
    let mut found: Vec<String> = denials
        .flat_map(|(_, phrases)| *phrases)
        .filter(|phrase| commentary.contains(**phrase))
        .map(|phrase| format!("{motion}, but the commentary says `{phrase}`: {commentary}"))
        .collect();
    if !text("now").starts_with(motion) {
        found.push(format!("{motion}, but the header says {}", text("now")));
    }
    let regime = text("regime").split([' ', ':']).next().unwrap_or_default();
    let types = text("lesson").lines().filter_map(|line| {
        let is_type = line.contains("by the last classification: ")
            || !panel["confidence"].is_null() && line.contains("now classified as ");
        // What is measured is bold.
        line.rsplit("**").nth(1).filter(|_| is_type)
    });
    found.extend(
        types
            .filter(|motion| !motion.contains(regime))
            .map(|motion| format!("{regime}, but the lesson says {motion}")),
    );
    if regime == "at" && panel["lines"] != serde_json::json!([]) {
        found.push("lines of a system at rest".to_owned());
    }
    found.extend(panel["departure"].as_str().map(str::to_owned));
    found
}

//! The table of the guide lists every hard-case test, and only existing ones.

const GUIDE: &str = include_str!("../../../src/guide/explanation/hard_cases.md");

const SOURCES: [&str; 7] = [
    include_str!("../campaign/mod.rs"),
    include_str!("contact.rs"),
    include_str!("faults.rs"),
    include_str!("friction.rs"),
    include_str!("kinks.rs"),
    include_str!("long.rs"),
    include_str!("rest.rs"),
];

/// Names of all tests in a source file.
fn tests(source: &str) -> impl Iterator<Item = &str> {
    let parts = source.split("#[test]\n").skip(1);
    parts.filter_map(|part| part.split("fn ").nth(1)?.split('(').next())
}

#[test]
fn the_table_lists_exactly_the_tests() {
    let all: Vec<&str> = SOURCES.iter().flat_map(|source| tests(source)).collect();
    assert!(all.len() > 20 && all.contains(&"a_kick_of_zero"), "{all:?}");
    for test in &all {
        assert!(
            GUIDE.contains(&format!("`{test}`")),
            "the guide has no row for {test}"
        );
    }
    // Rows have the name of a test in backquotes in the last column.
    let rows = GUIDE
        .lines()
        .filter(|line| line.starts_with("| ") && line.contains("` |"));
    for row in rows {
        let name = row
            .trim_end_matches("` |")
            .rsplit('`')
            .next()
            .unwrap_or_default();
        assert!(
            all.contains(&name),
            "the guide names `{name}`, which is not a test"
        );
    }
}

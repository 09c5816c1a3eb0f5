//! The table of the guide names each hard case, and each case stands in it.

const GUIDE: &str = include_str!("../../../src/guide/hard_cases.md");

const SOURCES: [&str; 7] = [
    include_str!("../campaign/mod.rs"),
    include_str!("contact.rs"),
    include_str!("faults.rs"),
    include_str!("friction.rs"),
    include_str!("kinks.rs"),
    include_str!("long.rs"),
    include_str!("rest.rs"),
];

/// The names of all tests of a source.
fn tests(source: &str) -> impl Iterator<Item = &str> {
    let parts = source.split("#[test]\n").skip(1);
    parts.filter_map(|part| part.split("fn ").nth(1)?.split('(').next())
}

#[test]
fn the_table_and_the_tests_are_the_same() {
    let all: Vec<&str> = SOURCES.iter().flat_map(|source| tests(source)).collect();
    assert!(all.len() > 20 && all.contains(&"a_kick_of_zero"), "{all:?}");
    for test in &all {
        assert!(
            GUIDE.contains(&format!("`{test}`")),
            "{test} has no row in the guide"
        );
    }
    // Rows name tests in backquotes in the last column.
    let rows = GUIDE
        .lines()
        .filter(|line| line.starts_with("| ") && line.contains("` |"));
    for row in rows {
        let name = row
            .trim_end_matches("` |")
            .rsplit('`')
            .next()
            .unwrap_or_default();
        assert!(all.contains(&name), "the guide's `{name}` is no test");
    }
}

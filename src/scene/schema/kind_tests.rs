//! Reading and description of each type of value.

use toml_edit::Value;

use super::kind::*;
use super::unit::DEGREE;
use crate::scene::tables::analysis::StateCoordinate;

fn read<T>(kind: &Kind<T>, text: &str) -> Result<T, Mismatch> {
    kind.read(&text.parse::<Value>().expect("valid TOML"))
}

const TILT: Kind<f64> = number(DEGREE, Range::Closed(-90.0, 90.0));

#[derive(Clone, Debug, PartialEq, strum::VariantArray, strum::IntoStaticStr, strum::EnumString)]
#[strum(serialize_all = "kebab-case")]
enum Layout {
    Rings,
    Gauss,
}

#[test]
fn numbers_accept_integers_and_reject_infinities() {
    assert_eq!(read(&TILT, "90"), Ok(std::f64::consts::FRAC_PI_2));
    assert_eq!(read(&TILT, "-9_0.0"), Ok(-std::f64::consts::FRAC_PI_2));
    for out in ["90.000001", "nan", "-nan", "inf", "-inf"] {
        assert_eq!(read(&TILT, out), Err(Mismatch::Range), "{out}");
    }
    for other in ["\"3\"", "true", "[3]", "{ a = 3 }", "2024-01-01"] {
        assert_eq!(read(&TILT, other), Err(Mismatch::Type), "{other}");
    }
}

#[test]
fn open_ends_are_excluded() {
    let range = Range::Open(-1.0, 0.5);
    assert!(range.contains(0.499) && !range.contains(0.5) && !range.contains(-1.0));
    assert_eq!(range.to_string(), "above -1 and below 0.5");
    let range = Range::Positive(2.0);
    assert!(range.contains(2.0) && range.contains(5e-324) && !range.contains(0.0));
    assert_eq!(range.to_string(), "above 0, at most 2");
    let range = Range::HalfOpen(0.0, 1.0);
    assert!(range.contains(0.0) && !range.contains(1.0));
    assert_eq!(range.to_string(), "from 0 to below 1");
    let range = Range::Closed(1e-13, 0.01);
    assert!(range.contains(1e-13) && range.contains(0.01) && !range.contains(0.011));
    assert_eq!(range.to_string(), "from 1e-13 to 0.01");
}

#[test]
fn counts_are_integral_and_bounded() {
    let nodes = count(1, 10_000);
    assert_eq!(read(&nodes, "0x64"), Ok(100));
    for out in ["0", "-1", "10001", "4294967297"] {
        assert_eq!(read(&nodes, out), Err(Mismatch::Range), "{out}");
    }
    assert_eq!(read(&nodes, "100.0"), Err(Mismatch::Type));
    assert_eq!(read(&seed(), "9223372036854775807"), Ok(i64::MAX as u64));
    assert_eq!(read(&seed(), "-1"), Err(Mismatch::Range));
}

#[test]
fn choices_suggest_the_most_similar_word() {
    let choice = choice::<Layout>();
    assert_eq!(read(&choice, "\"gauss\""), Ok(Layout::Gauss));
    assert_eq!(
        read(&choice, "\"guass\""),
        Err(Mismatch::Choice(Some("gauss")))
    );
    assert_eq!(read(&choice, "\"zzz\""), Err(Mismatch::Choice(None)));
    assert_eq!(choice.limits.expected(), "\"rings\" or \"gauss\"");
}

#[test]
fn lists_have_the_required_length() {
    let vector = vector(TILT);
    assert_eq!(read(&vector, "[0, 0.0, 0]"), Ok([0.0; 3]));
    assert_eq!(read(&vector, "[0, 0]"), Err(Mismatch::Type));
    assert_eq!(read(&vector, "[0, 0, nan]"), Err(Mismatch::Range));
    let many = one_or_many(TILT);
    assert_eq!(read(&many, "0"), Ok(vec![0.0]));
    assert_eq!(read(&many, "[0, 0]"), Ok(vec![0.0, 0.0]));
    let list = list(TILT);
    assert_eq!(read(&list, "[0, 0.0]"), Ok(vec![0.0, 0.0]));
    assert_eq!(read(&list, "[]"), Err(Mismatch::Range));
    assert_eq!(read(&list, "0"), Err(Mismatch::Type));
    let tables = tables(2);
    assert_eq!(read(&tables, "[{}, {}]"), Ok(2));
    assert_eq!(read(&tables, "[{}, {}, {}]"), Err(Mismatch::Range));
    assert_eq!(read(&tables, "[]"), Err(Mismatch::Range));
    assert_eq!(read(&tables, "[{}, 1]"), Err(Mismatch::Type));
    assert_eq!(read(&tables, "{}"), Err(Mismatch::Type));
}

#[test]
fn auto_is_accepted_for_numbers() {
    let lag = auto_or(TILT);
    assert_eq!(read(&lag, "\"auto\""), Ok(None));
    assert_eq!(read(&lag, "0"), Ok(Some(0.0)));
    assert_eq!(read(&lag, "\"automatic\""), Err(Mismatch::Choice(None)));
    assert_eq!(read(&lag, "91"), Err(Mismatch::Range));
    assert_eq!(
        lag.limits.expected(),
        "\"auto\", or a number from -90 to 90 deg"
    );
}

#[test]
fn all_is_accepted_for_counts() {
    let count = all_or(count(1, 9));
    assert_eq!(read(&count, "\"all\""), Ok(usize::MAX));
    assert_eq!(read(&count, "3"), Ok(3));
    assert_eq!(read(&count, "\"every\""), Err(Mismatch::Choice(None)));
    assert_eq!(read(&count, "0"), Err(Mismatch::Range));
    assert_eq!(read(&count, "2.0"), Err(Mismatch::Type));
    assert_eq!(
        count.limits.expected(),
        "\"all\", or an integer from 1 to 9"
    );
}

#[test]
fn coordinates_count_modes_from_one() {
    use StateCoordinate::{Q, Qdot};
    let pair = |pair: &str| read(&coordinates(), pair);
    assert_eq!(pair("[\"q1\", \"qdot12\"]"), Ok([Q(0), Qdot(11)]));
    assert_eq!(pair("[\"q1\"]"), Err(Mismatch::Type));
    assert_eq!(pair("[\"q1\", 2]"), Err(Mismatch::Type));
    assert_eq!(pair("[\"q0\", \"q1\"]"), Err(Mismatch::Range));
    for wrong in ["q", "p1", "qdot", "q-1", "q1x", ""] {
        let text = format!("[\"q1\", \"{wrong}\"]");
        assert_eq!(pair(&text), Err(Mismatch::Choice(None)), "{wrong}");
    }
}

#[test]
fn texts_are_not_blank() {
    assert_eq!(read(&text(), "\" a \""), Ok("a".to_owned()));
    assert_eq!(read(&text(), "\" \""), Err(Mismatch::Range));
    assert_eq!(read(&text(), "1"), Err(Mismatch::Type));
}

//! The ranges that the key tables (and with them docs/scene-format.md) promise are those that the program accepts.

use mie_cloud::scene::folder::Folder;
use mie_cloud::scene::given::Given;
use mie_cloud::scene::keys::{Key, SETTINGS};
use mie_cloud::scene::marks::{LIGHT, MARKS};
use serde_json::json;

/// A range of numbers as the tables write it: `0 to 1`, `above 0, at most 1e12`, `auto, or 1 to 4096`, `0 (exact) to 1`.
#[derive(Debug, PartialEq)]
struct Range {
    low: f64,
    low_is_in: bool,
    high: f64,
}

fn range(text: &str) -> Option<Range> {
    let last = text.rsplit(" or ").next().unwrap_or(text).replace("(exact) ", "");
    let number = |text: &str| text.trim().parse::<f64>().ok();
    if let Some((low, high)) = last.split_once(" to ") {
        return Some(Range { low: number(low)?, low_is_in: true, high: number(high)? });
    }
    let above = last.trim().strip_prefix("above ")?;
    let (low, high) = above.split_once(", at most ").or_else(|| above.split_once(" and at most "))?;
    Some(Range { low: number(low)?, low_is_in: false, high: number(high)? })
}

fn accepts<T: Default>(key: &Key<T>, value: f64) -> bool {
    (key.set)(&mut T::default(), &Given { value: &json!(value), folder: &Folder::of_user() }).is_ok()
}

/// Checks every numeric key of a table; returns how many there are.
fn check<T: Default>(keys: &[Key<T>]) -> usize {
    let numeric = keys.iter().filter_map(|key| range(key.range).map(|range| (key, range)));
    numeric
        .map(|(key, range)| {
            let (name, below) = (key.name, range.low - 1e-3 * range.low.abs().max(1e-3));
            assert_eq!(accepts(key, range.low), range.low_is_in, "{name} = {}", range.low);
            assert!(accepts(key, range.high), "{name} = {}", range.high);
            assert!(accepts(key, (0.5 * (range.low + range.high)).ceil().min(range.high)), "{name}, inside");
            assert!(!accepts(key, below), "{name} = {below}");
            assert!(!accepts(key, range.high * 1.001 + 1.0), "{name} above {}", range.high);
        })
        .count()
}

#[test]
fn ranges_are_read_as_they_are_written() {
    assert_eq!(range("above 0, at most 1e12"), Some(Range { low: 0.0, low_is_in: false, high: 1e12 }));
    assert_eq!(range("auto, or 1 to 4096"), Some(Range { low: 1.0, low_is_in: true, high: 4096.0 }));
    assert_eq!(range("0 (exact) to 1"), Some(Range { low: 0.0, low_is_in: true, high: 1.0 }));
    assert_eq!(range("draft, fine, or above 0 and at most 1"), Some(Range { low: 0.0, low_is_in: false, high: 1.0 }));
    assert_eq!(range("auto, on or off"), None);
}

#[test]
fn numbers_are_accepted_up_to_the_ends_of_their_ranges_and_not_beyond() {
    let counts = [check(SETTINGS), check(MARKS), check(LIGHT)];
    assert!(counts[0] >= 13 && counts[1] >= 6 && counts[2] == 1, "{counts:?}");
}

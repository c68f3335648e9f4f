//! "Did you mean": the known name that is nearest to a mistyped one.

/// The nearest of `known` if it is near enough to be a slip; `None` otherwise.
pub fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    // Words far longer than any key are no slips; the bound also keeps the comparison cheap.
    if word.len() > 100 {
        return None;
    }
    let near_enough = (word.chars().count() / 3).max(2);
    known
        .into_iter()
        .map(|name| (distance(word, name).min(distance_of_last_parts(word, name)), name))
        .filter(|(distance, _)| *distance <= near_enough)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, name)| name)
}

/// Keys are dotted: `step_m` should find `atmosphere.step_m`, one step behind an exact neighbour.
fn distance_of_last_parts(word: &str, name: &str) -> usize {
    let last = |text: &str| text.rsplit('.').next().unwrap_or_default().to_owned();
    if last(name).len() < 4 { usize::MAX } else { distance(&last(word), &last(name)).saturating_add(1) }
}

/// Levenshtein (1966): insertions, deletions and substitutions that turn `a` into `b`.
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, cb) in b.iter().enumerate() {
            let substitution = diagonal + usize::from(ca != *cb);
            diagonal = row[j + 1];
            row[j + 1] = substitution.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_those_of_levenshtein() {
        assert_eq!(distance("kitten", "sitting"), 3);
        assert_eq!(distance("", "abc"), 3);
        assert_eq!(distance("abc", "abc"), 0);
    }

    #[test]
    fn slips_are_found_and_nonsense_is_not() {
        let known = ["atmosphere.step_m", "atmosphere.depth_m", "sun.irradiance"];
        assert_eq!(nearest("atmosphere.setp_m", known), Some("atmosphere.step_m"));
        assert_eq!(nearest("step_m", known), Some("atmosphere.step_m"));
        assert_eq!(nearest("sun.iradiance", known), Some("sun.irradiance"));
        assert_eq!(nearest("quux", known), None);
    }
}

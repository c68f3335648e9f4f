//! "Did you mean": the accepted word nearest to one that is not accepted.

/// The candidate nearest to `word`, when it is near enough to be a slip of the pen.
///
/// Near means at most a third of the letters differ (at least one slip is always allowed), and not all.
///
/// ```
/// use mie_cloud::suggest::closest;
/// assert_eq!(closest("waetr", ["water", "ice"]), Some("water"));
/// assert_eq!(closest("stone", ["water", "ice"]), None);
/// ```
pub fn closest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let word = word.to_lowercase();
    let letters = word.chars().count();
    let allowed = (letters / 3).max(1).min(letters.saturating_sub(1));
    let ranked = candidates.into_iter().map(|candidate| (edit_distance(&word, candidate), candidate));
    ranked.filter(|(distance, _)| *distance <= allowed).min_by_key(|(distance, _)| *distance).map(|(_, word)| word)
}

/// The half sentence that proposes the nearest candidate, or nothing.
pub fn did_you_mean<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> String {
    closest(word, candidates).map_or_else(String::new, |candidate| format!(" (did you mean `{candidate}`?)"))
}

/// What is said of a word that names none of the things of a kind: the nearest, where it is near, and all there are.
///
/// ```
/// use mie_cloud::suggest::no_such;
/// let said = no_such("knob", "bandz", ["spp", "bands"]);
/// assert_eq!(said, "there is no knob `bandz` (did you mean `bands`?); the knobs are spp, bands");
/// ```
pub fn no_such<'a>(kind: &str, word: &str, names: impl IntoIterator<Item = &'a str>) -> String {
    let names: Vec<&str> = names.into_iter().collect();
    let hint = did_you_mean(word, names.iter().copied());
    format!("there is no {kind} `{word}`{hint}; the {kind}s are {}", names.join(", "))
}

/// Optimal string alignment: insertions, deletions, substitutions and swaps of neighbours each count one.
fn edit_distance(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().collect(), b.chars().collect());
    let mut rows = vec![(0..=b.len()).collect::<Vec<usize>>()];
    for i in 1..=a.len() {
        let mut row = vec![i];
        for j in 1..=b.len() {
            let substitute = rows[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
            let mut best = substitute.min(rows[i - 1][j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                best = best.min(rows[i - 2][j - 2] + 1);
            }
            row.push(best);
        }
        rows.push(row);
    }
    rows[a.len()][b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_are_counted_once() {
        assert_eq!(edit_distance("reff", "refff"), 1);
        assert_eq!(edit_distance("veff", "evff"), 1);
        assert_eq!(edit_distance("", "abc"), 3);
        assert_eq!(closest("ref", ["reff", "veff"]), Some("reff"));
        assert_eq!(did_you_mean("sphere", ["rmin"]), "");
        assert_eq!(closest("c", ["a", "b"]), None);
        assert_eq!(closest("", ["a"]), None);
    }
}

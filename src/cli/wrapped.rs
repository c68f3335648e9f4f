//! Text in lines that fit a terminal of 80 columns.

/// Columns of a terminal that nobody has widened.
pub const COLUMNS: usize = 80;

/// `text` beside `label`: broken between words, with later lines beneath the first. Words longer than a line, such as paths, stand
/// out.
pub fn beside(label: &str, text: &str) -> String {
    let indent = label.chars().count();
    let (mut out, mut column) = (label.to_owned(), indent);
    for word in words(text) {
        let length = word.chars().count();
        if column > indent && column + 1 + length > COLUMNS {
            out.push('\n');
            out.push_str(&" ".repeat(indent));
            column = indent;
        } else if column > indent {
            out.push(' ');
            column += 1;
        }
        out.push_str(word);
        column += length;
    }
    out.truncate(out.trim_end().len());
    out.push('\n');
    out
}

/// What is between spaces, and a percent sign with its number.
fn words(text: &str) -> impl Iterator<Item = &str> {
    let mut rest = Some(text);
    std::iter::from_fn(move || {
        let now = rest?;
        let space = now.match_indices(' ').map(|(at, _)| at).find(|at| !now[at + 1..].starts_with('%'));
        rest = space.map(|at| &now[at + 1..]);
        Some(space.map_or(now, |at| &now[..at]))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_broken_between_words_and_aligned() {
        let said = beside("memory      ", &"twelve chars ".repeat(20));
        assert!(said.lines().count() > 3 && said.lines().all(|line| line.len() <= COLUMNS), "{said}");
        assert!(said.lines().skip(1).all(|line| line.starts_with(&" ".repeat(12)) && !line.ends_with(' ')), "{said}");
        assert_eq!(said.split_whitespace().count(), 41);
    }

    #[test]
    fn words_are_not_broken() {
        let long = "x".repeat(100);
        assert_eq!(beside("a ", &format!("{long} b")), format!("a {long}\n  b\n"));
        assert_eq!(beside("a  ", ""), "a\n");
        assert_eq!(words("to 5 %, or 1 %").collect::<Vec<_>>(), ["to", "5 %,", "or", "1 %"]);
    }
}

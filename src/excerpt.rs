//! Text from files in messages: short, and without characters that would change a terminal.

/// Shortens text from a file to what fits into a sentence; control characters are escaped.
///
/// ```
/// use mie_cloud::excerpt::excerpt;
/// assert_eq!(excerpt("a\u{1b}[2Jb"), "a\\u{1b}[2Jb");
/// assert_eq!(excerpt(&"x".repeat(100)), "x".repeat(80) + "...");
/// ```
pub fn excerpt(text: &str) -> String {
    shortened(text, 80)
}

/// The same for whole messages, parts of which may come from a file: 2000 characters are kept, and lines.
///
/// ```
/// use mie_cloud::excerpt::printable;
/// assert_eq!(printable("one\ntwo\r"), "one\ntwo\\r");
/// ```
pub fn printable(message: &str) -> String {
    let lines: Vec<String> = shortened_lines(message, 2000);
    lines.join("\n")
}

fn shortened_lines(message: &str, most: usize) -> Vec<String> {
    let mut left = most;
    let mut lines = Vec::new();
    for line in message.split('\n') {
        if left == 0 {
            break;
        }
        lines.push(shortened(line, left));
        left = left.saturating_sub(line.chars().count() + 1);
    }
    lines
}

fn shortened(text: &str, most: usize) -> String {
    let mut short = String::new();
    for c in text.chars().take(most) {
        if c.is_control() { short.extend(c.escape_debug()) } else { short.push(c) }
    }
    if text.chars().nth(most).is_some() {
        short.push_str("...");
    }
    short
}

//! Places for labels beside points, so that none covers another or a point.

/// A box: left, top, right, bottom, points.
type Box = [f64; 4];

/// Height of a line, and width of a character of the labels' size, points; an ample one.
const HEIGHT: f64 = 10.5;
const CHARACTER: f64 = 5.4;

/// Half the width of a point, and how far a label keeps from its middle, points.
const DOT: f64 = 4.5;
const GAP: f64 = 5.0;

/// What has been taken so far.
#[derive(Clone, Debug, Default)]
pub struct Labels(Vec<Box>);

impl Labels {
    /// Keeps labels off a point.
    pub fn keep_off(&mut self, [x, y]: [f64; 2]) {
        self.0.push([x - DOT, y - DOT, x + DOT, y + DOT]);
    }

    /// Where the left top corner of a label goes, relative to its point: to the right and above it if there is room, else to another
    /// side; `None` where there is none.
    pub fn place(&mut self, [x, y]: [f64; 2], text: &str) -> Option<[f64; 2]> {
        let width = CHARACTER * text.chars().count() as f64;
        let (right, left) = (GAP, -GAP - width);
        let (above, beside, below) = (-HEIGHT - 2.0, -0.5 * HEIGHT, 3.0);
        let offsets =
            [[right, above], [right, below], [left, above], [left, below], [right + 2.0, beside], [left - 2.0, beside]];
        let at = |[dx, dy]: [f64; 2]| [x + dx, y + dy, x + dx + width, y + dy + HEIGHT];
        let offset = offsets.into_iter().find(|offset| self.0.iter().all(|taken| !overlap(taken, &at(*offset))))?;
        self.0.push(at(offset));
        Some(offset)
    }
}

fn overlap(a: &Box, b: &Box) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_take_other_sides_and_give_up_where_all_is_full() {
        let mut labels = Labels::default();
        labels.keep_off([0.0, 0.0]);
        let places: Vec<_> = (0..8).map(|_| labels.place([0.0, 0.0], "0.5")).collect();
        assert!(places[0].is_some_and(|[x, y]| x > 0.0 && y < 0.0), "{places:?}");
        assert!(places[2].is_some_and(|[x, _]| x < 0.0), "{places:?}");
        assert_eq!(places[7], None);
        // Far away there is room again.
        assert_eq!(labels.place([100.0, 0.0], "0.5"), places[0]);
    }
}

//! How many optical tables are wanted and made: counted by the threads that make them, read by whoever tells of it.

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A count of tables in work. No result depends on it.
#[derive(Debug, Default)]
pub struct TableCount {
    wanted: AtomicUsize,
    made: AtomicUsize,
}

impl TableCount {
    /// Tables that are made, and those that are wanted as far as is known.
    pub fn made_of(&self) -> (usize, usize) {
        let made = self.made.load(Ordering::Relaxed);
        (made, self.wanted.load(Ordering::Relaxed).max(made))
    }
}

/// Where tables come from, and who hears of them.
#[derive(Clone, Copy, Debug, Default)]
pub struct TableStore<'a> {
    /// A folder in which tables are kept between runs.
    pub cache: Option<&'a Path>,
    /// Counts the tables.
    pub count: Option<&'a TableCount>,
}

impl TableStore<'_> {
    /// So many more tables are wanted.
    pub(super) fn want(&self, n: usize) {
        if let Some(count) = self.count {
            count.wanted.fetch_add(n, Ordering::Relaxed);
        }
    }

    /// One more table is made.
    pub(super) fn made_one(&self) {
        if let Some(count) = self.count {
            count.made.fetch_add(1, Ordering::Relaxed);
        }
    }
}

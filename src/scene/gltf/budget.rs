//! Memory that a scene may ask for: bounded by the size of its files, because counts and linked duplicates cost nothing.

use std::cell::Cell;

use crate::scene::error::{SceneError, SceneFault, SceneResult};

/// What any scene may use for its particles: half a million of them. With a tree over them they stay below 64 MiB.
const FREE_BYTES: u64 = 24 << 20;
/// What each byte of the scene's files may bring with it. A particle of 48 bytes takes at least 4 in a file, so that
/// 12 serve every cloud that is written out; with the text and the buffers it stays below 20 in all.
const PER_FILE_BYTE: u64 = 12;

/// Counts down the bytes that a scene's particles and boxes may take.
#[derive(Debug)]
pub struct Budget {
    limit: Limit,
    used_bytes: Cell<u64>,
    visits: Cell<u64>,
}

/// Vertices that may be measured in any scene, and once more for each byte of its files: an honest file spends 12 bytes
/// on a vertex, which is read twice; many accessors over the same bytes could otherwise keep the reader busy for hours.
const FREE_VISITS: u64 = 4 << 20;

#[derive(Debug)]
enum Limit {
    /// In proportion to the files.
    Files,
    /// What the user allowed.
    Fixed(u64),
}

impl Budget {
    /// A budget in proportion to the files, or the one that the user gave.
    pub fn new(limit_bytes: Option<u64>) -> Self {
        Self { limit: limit_bytes.map_or(Limit::Files, Limit::Fixed), used_bytes: Cell::new(0), visits: Cell::new(0) }
    }

    /// Takes room for `count` elements of `size` bytes before they are allocated; `file_bytes` have been read so far.
    ///
    /// # Errors
    /// When the scene's files are too small to justify them.
    pub fn take(&self, count: u64, size: usize, file_bytes: u64, element: &str) -> SceneResult<()> {
        let limit = match self.limit {
            Limit::Files => FREE_BYTES.saturating_add(file_bytes.saturating_mul(PER_FILE_BYTE)),
            Limit::Fixed(limit) => limit,
        };
        let left = limit.saturating_sub(self.used_bytes.get());
        let bytes = count.saturating_mul(size as u64);
        if bytes > left {
            let remedy = "allow more with --memory-limit if this is meant";
            let what = format!("{count} elements");
            return Err(SceneError::at(element, SceneFault::TooLarge { what, bytes, limit: left, remedy }));
        }
        self.used_bytes.set(self.used_bytes.get() + bytes);
        Ok(())
    }

    /// Counts `count` vertices that are about to be measured.
    ///
    /// # Errors
    /// When the scene's files are too small to justify them.
    pub fn visit(&self, count: u64, file_bytes: u64, element: &str) -> SceneResult<()> {
        let left = FREE_VISITS.saturating_add(file_bytes).saturating_sub(self.visits.get());
        if count > left {
            let (what, remedy) = (format!("{count} vertices to measure"), "do not share bytes among so many accessors");
            let fault = SceneFault::TooLarge { what, bytes: count.saturating_mul(12), limit: left, remedy };
            return Err(SceneError::at(element, fault));
        }
        self.visits.set(self.visits.get() + count);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_that_no_file_justifies_are_refused() {
        let budget = Budget::new(None);
        assert!(budget.take(1_000_000_000_000, 48, 4000, "x").is_err());
        assert!(budget.take(u64::MAX, 48, u64::MAX, "x").is_ok(), "saturates");
        let budget = Budget::new(Some(100));
        assert!(budget.take(2, 48, 0, "x").is_ok());
        assert!(budget.take(1, 48, 0, "x").is_err());
    }
}

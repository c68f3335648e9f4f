//! Memory that a scene may ask for: bounded by the size of its files, because counts and linked duplicates cost nothing, and by
//! what there is.

use std::cell::Cell;

use crate::scene::error::{SceneError, SceneFault, SceneResult};

/// What any scene may use for its particles: half a million of them. With a tree over them they stay below 64 MiB.
const FREE_BYTES: u64 = 24 << 20;
/// What each byte of the scene's files may bring with it. A particle of 40 bytes takes at least 4 in a file, so that
/// 12 serve every cloud that is written out; with the text and the buffers it stays below 20 in all.
const PER_FILE_BYTE: u64 = 12;

/// Counts down the bytes that a scene's particles and boxes may take.
#[derive(Debug)]
pub struct Budget {
    /// Whether the files' size bounds it.
    by_files: bool,
    /// What files, particles and boxes may take together.
    most_bytes: u64,
    used_bytes: Cell<u64>,
    visits: Cell<u64>,
}

/// Vertices that may be measured in any scene, and once more for each byte of its files: an honest file spends 12 bytes
/// on a vertex, which is read twice; many accessors over the same bytes could otherwise keep the reader busy for hours.
const FREE_VISITS: u64 = 4 << 20;

impl Budget {
    /// A budget in proportion to the files where `by_files`, and of at most `most_bytes` with the files themselves.
    pub fn new(by_files: bool, most_bytes: u64) -> Self {
        Self { by_files, most_bytes, used_bytes: Cell::new(0), visits: Cell::new(0) }
    }

    /// Takes room for `count` elements of `size` bytes before they are allocated; `file_bytes` have been read so far.
    ///
    /// # Errors
    /// When the scene's files are too small to justify them, or they do not fit.
    pub fn take(&self, count: u64, size: usize, file_bytes: u64, element: &str) -> SceneResult<()> {
        let left = |limit: u64| limit.saturating_sub(self.used_bytes.get());
        let bytes = count.saturating_mul(size as u64);
        let what = format!("{count} elements");
        let justified = left(FREE_BYTES.saturating_add(file_bytes.saturating_mul(PER_FILE_BYTE)));
        if self.by_files && bytes > justified {
            let (limit, remedy) = (justified, "allow more with --memory-limit if this is meant");
            return Err(SceneError::at(element, SceneFault::TooLarge { what, bytes, limit, remedy }));
        }
        let limit = left(self.most_bytes.saturating_sub(file_bytes));
        if bytes > limit {
            return Err(SceneError::at(element, SceneFault::Memory { what, bytes, limit }));
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
        let budget = Budget::new(true, u64::MAX);
        assert!(budget.take(1_000_000_000_000, 48, 4000, "x").is_err());
        assert!(budget.take(1_000_000, 48, 1 << 40, "x").is_ok());
        assert!(budget.take(u64::MAX, 48, u64::MAX, "x").is_err(), "saturates");
        let budget = Budget::new(false, 100);
        assert!(budget.take(2, 48, 0, "x").is_ok());
        assert!(budget.take(1, 48, 0, "x").is_err());
        assert!(Budget::new(false, 100).take(1, 48, 60, "x").is_err(), "the file takes its part");
        assert!(Budget::new(true, 100).take(3, 48, 0, "x").is_err());
    }
}

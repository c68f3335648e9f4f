//! Tables kept on disk between runs, found by the content that they were made from.
//!
//! An entry is one file: magic, length of the key, key, cross sections, table, checksum; all numbers little-endian. The
//! whole key is compared, so that two contents of one hash cannot be mistaken for each other; whatever is damaged,
//! truncated or of another version is no entry, and is made again.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

use super::distribution::{Shape, SizeDistribution};
use super::ensemble::CrossSections;
use super::phase_table::PhaseTable;
use super::size_average::AverageAccuracy;

/// Begins every entry; the digit is the version, which changes with the format and with every change of what the
/// numbers in an entry would be.
const MAGIC: &[u8; 8] = b"mietab01";

/// Entries larger than this are not read: the largest table has 32 768 nodes, a few cells each, of 24 bytes.
const MAX_ENTRY_BYTES: u64 = 16 << 20;

/// What an entry was made from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CacheKey(Vec<u8>);

impl CacheKey {
    /// The key of a kind of entry.
    pub fn new(kind: &str) -> Self {
        Self(Vec::new()).bytes(kind.as_bytes())
    }

    fn bytes(mut self, bytes: &[u8]) -> Self {
        self.0.extend((bytes.len() as u64).to_le_bytes());
        self.0.extend(bytes);
        self
    }

    /// Adds numbers.
    pub fn numbers(mut self, values: &[f64]) -> Self {
        self.0.extend((values.len() as u64).to_le_bytes());
        values.iter().for_each(|value| self.0.extend(value.to_le_bytes()));
        self
    }

    /// Adds how well the entry was made.
    pub fn accuracy(self, accuracy: &AverageAccuracy) -> Self {
        let AverageAccuracy { size_tolerance, angle_tolerance, max_radii, max_terms } = *accuracy;
        self.numbers(&[size_tolerance, angle_tolerance, max_radii as f64, max_terms])
    }

    /// Adds a size distribution: its numbers, not its name.
    pub fn distribution(self, distribution: &SizeDistribution) -> Self {
        let key = self.numbers(&[distribution.r_min_m, distribution.r_max_m]);
        match &distribution.shape {
            Shape::Mono { r_m } => key.bytes(b"mono").numbers(&[*r_m]),
            Shape::Gamma { reff_m, veff } => key.bytes(b"gamma").numbers(&[*reff_m, *veff]),
            Shape::ModifiedGamma { alpha, gamma, rc_m } => key.bytes(b"modgamma").numbers(&[*alpha, *gamma, *rc_m]),
            Shape::LogNormal { rg_m, sigma } => key.bytes(b"lognormal").numbers(&[*rg_m, *sigma]),
            Shape::Table { r_m, dn_dr, .. } => key.bytes(b"table").numbers(r_m).numbers(dn_dr),
        }
    }
}

/// A folder of entries.
#[derive(Clone, Debug)]
pub struct TableCache {
    folder: PathBuf,
}

impl TableCache {
    /// The cache in a folder, which is made with the first entry.
    pub fn new(folder: &Path) -> Self {
        Self { folder: folder.to_path_buf() }
    }

    fn path(&self, key: &CacheKey) -> PathBuf {
        self.folder.join(format!("{:016x}.table", fnv1a(&key.0)))
    }

    /// The entry of a key; `None` where there is none that is whole.
    pub fn load(&self, key: &CacheKey) -> Option<(CrossSections, Option<PhaseTable>)> {
        let file = fs::File::open(self.path(key)).ok()?;
        let mut entry = Vec::new();
        file.take(MAX_ENTRY_BYTES).read_to_end(&mut entry).ok()?;
        let (content, checksum) = entry.split_last_chunk::<8>()?;
        if u64::from_le_bytes(*checksum) != fnv1a(content) {
            return None;
        }
        let content = content.strip_prefix(&head(key)[..])?;
        let (numbers, table) = content.split_at_checked(5 * 8)?;
        let number = |i: usize| numbers.get(8 * i..8 * i + 8)?.try_into().ok().map(f64::from_le_bytes);
        let cross_sections = CrossSections {
            c_ext_m2: number(0)?,
            c_sca_m2: number(1)?,
            c_abs_m2: number(2)?,
            g: number(3)?,
            area_m2: number(4)?,
        };
        let table = if table.is_empty() { None } else { Some(PhaseTable::from_bytes(table)?) };
        Some((cross_sections, table))
    }

    /// Keeps an entry. A cache that cannot be written is no failure: the tables are made again.
    pub fn store(&self, key: &CacheKey, cross_sections: &CrossSections, table: Option<&PhaseTable>) {
        let CrossSections { c_ext_m2, c_sca_m2, c_abs_m2, g, area_m2 } = *cross_sections;
        let mut entry = head(key);
        for number in [c_ext_m2, c_sca_m2, c_abs_m2, g, area_m2] {
            entry.extend(number.to_le_bytes());
        }
        if let Some(table) = table {
            table.write_bytes(&mut entry);
        }
        entry.extend(fnv1a(&entry).to_le_bytes());
        if entry.len() as u64 <= MAX_ENTRY_BYTES {
            // Without the entry the next run takes longer, nothing else.
            self.write_whole(&self.path(key), &entry).unwrap_or(());
        }
    }

    /// Writes beside the entry and renames, so that other processes see it whole or not at all.
    fn write_whole(&self, path: &Path, entry: &[u8]) -> std::io::Result<()> {
        fs::create_dir_all(&self.folder)?;
        let partial = path.with_extension(format!("{}.tmp", std::process::id()));
        let written = fs::write(&partial, entry).and_then(|()| fs::rename(&partial, path));
        if written.is_err() {
            // What is left of a failed write is removed if it can be.
            fs::remove_file(&partial).unwrap_or(());
        }
        written
    }
}

fn head(key: &CacheKey) -> Vec<u8> {
    let mut head = MAGIC.to_vec();
    head.extend((key.0.len() as u64).to_le_bytes());
    head.extend(&key.0);
    head
}

/// FNV-1a, 64 bits (Fowler, Noll & Vo 1991): finds damage and spreads names; nobody is kept from forging an entry.
fn fnv1a(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x100_0000_01b3))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry() -> (CacheKey, CrossSections, PhaseTable) {
        let key = CacheKey::new("test").numbers(&[1.33, 0.0]).distribution(&SizeDistribution::default());
        let cross_sections = CrossSections { c_ext_m2: 2.0, c_sca_m2: 1.0, c_abs_m2: 1.0, g: 0.5, area_m2: 1.0 };
        let theta: Vec<f64> = (0..=18).map(|i| std::f64::consts::PI * f64::from(i) / 18.0).collect();
        let values: Vec<f64> = theta.iter().map(|theta| (3.0 * theta.cos()).exp()).collect();
        (key, cross_sections, PhaseTable::from_samples(&theta, &values).expect("a table"))
    }

    #[test]
    fn entries_come_back_as_they_were() {
        let folder = tempfile::tempdir().expect("a folder");
        let cache = TableCache::new(&folder.path().join("new"));
        let (key, cross_sections, table) = entry();
        assert_eq!(cache.load(&key), None);
        cache.store(&key, &cross_sections, Some(&table));
        assert_eq!(cache.load(&key), Some((cross_sections, Some(table))));
        assert_eq!(cache.load(&CacheKey::new("other")), None);
        cache.store(&key, &cross_sections, None);
        assert_eq!(cache.load(&key), Some((cross_sections, None)));
    }

    #[test]
    fn damaged_entries_are_no_entries() {
        let folder = tempfile::tempdir().expect("a folder");
        let cache = TableCache::new(folder.path());
        let (key, cross_sections, table) = entry();
        cache.store(&key, &cross_sections, Some(&table));
        let path = cache.path(&key);
        let whole = fs::read(&path).expect("the entry");
        for place in (0..whole.len()).step_by(7) {
            let mut damaged = whole.clone();
            damaged[place] ^= 0x10;
            fs::write(&path, &damaged).expect("written");
            assert_eq!(cache.load(&key), None, "byte {place}");
            fs::write(&path, &whole[..place]).expect("written");
            assert_eq!(cache.load(&key), None, "cut at {place}");
        }
        fs::write(&path, &whole).expect("written");
        assert!(cache.load(&key).is_some());
    }

    #[test]
    fn a_folder_that_cannot_be_written_is_no_failure() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("file");
        fs::write(&file, b"").expect("written");
        let (key, cross_sections, table) = entry();
        let cache = TableCache::new(&file);
        cache.store(&key, &cross_sections, Some(&table));
        assert_eq!(cache.load(&key), None);
    }
}

//! Sealed records: content with its length and checksum, at the end of a file, so that damage is found before use.
//!
//! Layout: whatever comes first (nothing, or a picture), the content, then 24 bytes: XXH3 (64 bits) of the content, its
//! length, and a magic; numbers little-endian.

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use thiserror::Error;
use xxhash_rust::xxh3::Xxh3;

/// Ends every record; the digit is the version of the layout.
const MAGIC: &[u8; 8] = b"miekept1";

/// Bytes of checksum, length and magic.
const SEAL_BYTES: u64 = 24;

/// A record could not be read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SealedError {
    /// The file cannot be opened or read.
    #[error("cannot read {path}: {source}; check the path and its permissions")]
    Io { path: PathBuf, source: io::Error },
    /// There is no record in the file.
    #[error(
        "{0} holds no sums of samples: it was not written by `--checkpoint` or `--samples`, or cut off, or saved again by another program; `--resume` goes on from what `--checkpoint` writes, `merge` takes what `--samples A..B` writes"
    )]
    None(PathBuf),
    /// The record is damaged.
    #[error("{path} is damaged: {what}; use an earlier copy, or render it again")]
    Damaged { path: PathBuf, what: String },
}

/// Writes content and seals it.
pub struct Sealer<'a> {
    out: &'a mut dyn Write,
    hash: Xxh3,
    length: u64,
}

impl<'a> Sealer<'a> {
    /// Begins a record.
    pub fn new(out: &'a mut dyn Write) -> Self {
        Self { out, hash: Xxh3::new(), length: 0 }
    }

    /// Adds content.
    ///
    /// # Errors
    /// When the bytes cannot be written.
    pub fn put(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.hash.update(bytes);
        self.length += bytes.len() as u64;
        self.out.write_all(bytes)
    }

    /// Ends the record; nothing may follow in the file.
    ///
    /// # Errors
    /// When the bytes cannot be written.
    pub fn seal(self) -> io::Result<()> {
        self.out.write_all(&self.hash.digest().to_le_bytes())?;
        self.out.write_all(&self.length.to_le_bytes())?;
        self.out.write_all(MAGIC)
    }
}

/// Reads the content of a record whose checksum is right.
#[derive(Debug)]
pub struct Sealed {
    path: PathBuf,
    content: io::Take<BufReader<File>>,
}

impl Sealed {
    /// Opens the record at the end of a file, and compares its checksum.
    ///
    /// # Errors
    /// When the file cannot be read, has no record, or a damaged one.
    pub fn open(path: &Path) -> Result<Self, SealedError> {
        let io = |source| SealedError::Io { path: path.into(), source };
        let mut file = File::open(path).map_err(io)?;
        let file_bytes = file.metadata().map_err(io)?.len();
        let most = file_bytes.checked_sub(SEAL_BYTES).ok_or_else(|| SealedError::None(path.into()))?;
        file.seek(SeekFrom::Start(most)).map_err(io)?;
        let [checksum, length, magic] = read_seal(&mut file).map_err(io)?;
        if magic != *MAGIC {
            return Err(SealedError::None(path.into()));
        }
        let damaged = |what: &str| SealedError::Damaged { path: path.into(), what: what.into() };
        let length = u64::from_le_bytes(length);
        let start = most.checked_sub(length).ok_or_else(|| damaged("it is shorter than it says"))?;
        let mut content = BufReader::new(file).take(length);
        content.get_mut().seek(SeekFrom::Start(start)).map_err(io)?;
        if checksum_of(&mut content).map_err(io)? != u64::from_le_bytes(checksum) {
            return Err(damaged("its checksum is wrong"));
        }
        content.get_mut().seek(SeekFrom::Start(start)).map_err(io)?;
        content.set_limit(length);
        Ok(Self { path: path.into(), content })
    }

    /// Bytes that have not been read.
    pub fn left(&self) -> u64 {
        self.content.limit()
    }

    /// The next bytes. Memory is taken only for what is there.
    ///
    /// # Errors
    /// When there are fewer, or the file cannot be read.
    pub fn take(&mut self, n: u64) -> Result<Vec<u8>, SealedError> {
        let short = || self.damaged("it ends early");
        let n = usize::try_from(n).ok().filter(|_| n <= self.left()).ok_or_else(short)?;
        let mut bytes = vec![0; n];
        self.fill(&mut bytes)?;
        Ok(bytes)
    }

    /// Fills `bytes` with the next ones.
    ///
    /// # Errors
    /// When there are fewer, or the file cannot be read.
    pub fn fill(&mut self, bytes: &mut [u8]) -> Result<(), SealedError> {
        self.content.read_exact(bytes).map_err(|source| SealedError::Io { path: self.path.clone(), source })
    }

    /// An error that names the file.
    pub fn damaged(&self, what: impl Into<String>) -> SealedError {
        SealedError::Damaged { path: self.path.clone(), what: what.into() }
    }
}

fn read_seal(file: &mut File) -> io::Result<[[u8; 8]; 3]> {
    let mut seal = [[0; 8]; 3];
    seal.iter_mut().try_for_each(|part| file.read_exact(part))?;
    Ok(seal)
}

fn checksum_of(content: &mut impl Read) -> io::Result<u64> {
    let mut hash = Xxh3::new();
    let mut buffer = vec![0; 1 << 16];
    loop {
        match content.read(&mut buffer)? {
            0 => return Ok(hash.digest()),
            n => hash.update(&buffer[..n]),
        }
    }
}

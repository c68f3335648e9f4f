//! The GLB container (glTF 2.0, section 4): a header, a JSON chunk and perhaps a binary one.

use crate::scene::error::SceneFault;

/// The two chunks of a GLB file.
#[derive(Debug, PartialEq, Eq)]
pub struct Glb<'a> {
    /// The JSON text.
    pub json: &'a [u8],
    /// The binary chunk, if there is one.
    pub bin: Option<&'a [u8]>,
}

const MAGIC: &[u8] = b"glTF";
const JSON_CHUNK: u32 = 0x4E4F_534A;
const BIN_CHUNK: u32 = 0x004E_4942;
const HEADER_BYTES: usize = 12;

/// Whether a file is a GLB container.
pub fn is_glb(file: &[u8]) -> bool {
    file.starts_with(MAGIC)
}

/// Takes a GLB file apart; nothing is copied.
///
/// # Errors
/// When the header or a chunk does not fit the file.
pub fn split(file: &[u8]) -> Result<Glb<'_>, SceneFault> {
    let version = word(file, 4)?;
    if version != 2 {
        return Err(SceneFault::Version(version.to_string()));
    }
    let declared = word(file, 8)?;
    if u64::from(declared) != file.len() as u64 {
        return Err(broken(format!("its header says {declared} bytes, the file has {}", file.len())));
    }
    let (kind, json, rest) = chunk(&file[HEADER_BYTES..])?;
    if kind != JSON_CHUNK {
        return Err(broken("its first chunk is not JSON".into()));
    }
    // Chunks of unknown kind are to be skipped, and the binary chunk comes second if at all.
    let bin = if rest.is_empty() { None } else { Some(chunk(rest)?) };
    Ok(Glb { json, bin: bin.filter(|(kind, ..)| *kind == BIN_CHUNK).map(|(_, data, _)| data) })
}

fn broken(problem: String) -> SceneFault {
    SceneFault::Container(problem)
}

fn word(bytes: &[u8], at: usize) -> Result<u32, SceneFault> {
    let four = bytes.get(at..).and_then(|rest| rest.first_chunk::<4>());
    four.map(|four| u32::from_le_bytes(*four)).ok_or_else(|| broken("it ends inside a header".into()))
}

/// Kind, data and what follows.
fn chunk(bytes: &[u8]) -> Result<(u32, &[u8], &[u8]), SceneFault> {
    let (length, kind) = (word(bytes, 0)?, word(bytes, 4)?);
    let body = &bytes[8..];
    let fits = usize::try_from(length).ok().filter(|length| *length <= body.len());
    let Some(length) = fits else {
        return Err(broken(format!("a chunk says {length} bytes, {} are left", body.len())));
    };
    Ok((kind, &body[..length], &body[length..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn glb(json: &[u8], bin: &[u8]) -> Vec<u8> {
        let mut out = b"glTF\x02\0\0\0".to_vec();
        out.extend(((28 + json.len() + bin.len()) as u32).to_le_bytes());
        for (kind, data) in [(JSON_CHUNK, json), (BIN_CHUNK, bin)] {
            out.extend((data.len() as u32).to_le_bytes());
            out.extend(kind.to_le_bytes());
            out.extend(data);
        }
        out
    }

    #[test]
    fn both_chunks_are_found() -> Result<(), SceneFault> {
        assert_eq!(split(&glb(b"{}  ", b"abcd"))?, Glb { json: b"{}  ", bin: Some(b"abcd") });
        Ok(())
    }

    #[test]
    fn every_truncation_is_an_error() {
        let whole = glb(b"{}  ", b"abcd");
        for length in 0..whole.len() {
            assert!(split(&whole[..length]).is_err(), "{length}");
        }
    }
}

//! Files that the program writes for itself: parts and checkpoints, and the table cache. Their checksums are put right first.

use std::ffi::OsString;
use std::path::Path;

use mie_cloud::cli::outcome;
use mie_cloud::image::exr::{Limits, read};
use mie_cloud::image::sealed::Sealer;
use mie_cloud::optics::cache::{CacheKey, TableCache};
use mie_cloud::optics::ensemble::CrossSections;
use mie_cloud::transport::keep::Kept;

use super::check_message;

/// A part or checkpoint, as `merge` reads it: as it is, and sealed anew.
pub fn part(bytes: &[u8], folder: &Path) {
    let file = folder.join("part.exr");
    std::fs::write(&file, bytes).expect("written");
    check_kept(&file, bytes.len());
    std::fs::write(&file, seal(bytes)).expect("written");
    if check_kept(&file, bytes.len() + 24).is_some() {
        check_merge(&file, folder);
    }
}

/// The same content with a seal that is right; a length in the old seal is kept where there are so many bytes.
fn seal(bytes: &[u8]) -> Vec<u8> {
    let old = bytes.split_last_chunk::<24>().filter(|(_, seal)| seal.ends_with(b"miekept1"));
    let (content, length) = match old {
        Some((content, seal)) => {
            let length = seal[8..].first_chunk::<8>().map_or(0, |length| u64::from_le_bytes(*length));
            (content, usize::try_from(length).unwrap_or(usize::MAX).min(content.len()))
        }
        None => (bytes, bytes.len()),
    };
    let (before, content) = content.split_at(content.len() - length);
    let mut out = before.to_vec();
    let mut sealer = Sealer::new(&mut out);
    sealer.put(content).expect("memory");
    sealer.seal().expect("memory");
    out
}

/// Opens and reads a state; `Some` where it could be.
fn check_kept(file: &Path, n_bytes: usize) -> Option<()> {
    let kept = Kept::open(file).map_err(|error| check_message(&error.to_string(), "part.exr")).ok()?;
    let state = kept.read().map_err(|error| check_message(&error.to_string(), "part.exr")).ok()?;
    let sums: usize = state.into_films().iter().map(|film| size_of_val(film.sums())).sum();
    assert!(sums <= n_bytes, "{sums} bytes of sums from {n_bytes}");
    Some(())
}

/// What can be merged is a picture whose values are finite.
fn check_merge(part: &Path, folder: &Path) {
    let out = folder.join("merged.exr");
    let flags = ["mie-cloud", "merge", "-q", "--allow-gaps", "-o"].map(OsString::from);
    match outcome(flags.into_iter().chain([out.clone().into(), part.into()])) {
        Ok(_) => {
            let picture = read(&out, Limits::default()).expect("what was written");
            let mut values = picture.channels.iter().flat_map(|channel| &channel.values);
            assert!(values.all(|value| value.is_finite()));
        }
        // Sums that are too large for the picture's numbers are found when it is written.
        Err(message) => check_message(&message, if message.contains("merged.exr") { "merged.exr" } else { "part.exr" }),
    }
}

/// A checkpoint, sealed anew, as `render --resume` reads it: the scene and the flags are those of the seeds.
pub fn resume(bytes: &[u8], folder: &Path) {
    let file = folder.join("part.exr");
    std::fs::write(&file, seal(bytes)).expect("written");
    let path = |name: &str| folder.join(name).display().to_string();
    let (scene, out, file) = (path("c.glb"), path("resumed.exr"), path("part.exr"));
    if !Path::new(&scene).exists() {
        let made = [&["mie-cloud", "generate", "-o", &scene][..], &CLOUD].concat();
        outcome(made.iter().map(OsString::from)).expect("a cloud");
    }
    let flags = ["mie-cloud", "render", &scene, "-o", &out, "--spp", "4", "--no-cache", "--threads", "1", "-q"];
    if let Err(message) = outcome([&flags, &["--resume", &file][..]].concat().iter().map(OsString::from)) {
        // As for parts: sums that are too large for the picture's numbers are found when it is written.
        check_message(&message, if message.contains("resumed.exr") { "resumed.exr" } else { "part.exr" });
    }
}

/// Flags of `generate` for the cloud whose parts and checkpoints are seeds.
pub const CLOUD: [&str; 16] = [
    "--count",
    "4",
    "--size",
    "2m",
    "--optical-depth",
    "1",
    "--distribution",
    "mono:r=5um",
    "--set",
    "spectral.mode=mono:550nm",
    "--set",
    "droplets.phase=isotropic",
    "--set",
    "image.resolution=4x3",
    "--seed=1",
    "-q",
];

/// The content of an entry of the table cache behind its key.
pub fn table(bytes: &[u8], folder: &Path) {
    let (cache, key) = (TableCache::new(&folder.join("tables")), CacheKey::new("fuzz"));
    let cross_sections = CrossSections { c_ext_m2: 2.0, c_sca_m2: 1.0, c_abs_m2: 1.0, g: 0.5, area_m2: 1.0 };
    cache.store(&key, &cross_sections, None);
    let entries = std::fs::read_dir(folder.join("tables")).expect("the cache").filter_map(Result::ok);
    let file = entries.map(|entry| entry.path()).find(|path| path.extension().is_some_and(|e| e == "table"));
    let file = file.expect("the entry");
    let mut entry = std::fs::read(&file).expect("the entry");
    assert_eq!(cache.load(&key), Some((cross_sections, None)));
    // Five cross sections and the checksum end the entry.
    entry.truncate(entry.len() - 48);
    entry.extend(bytes);
    entry.extend(fnv1a(&entry).to_le_bytes());
    std::fs::write(&file, &entry).expect("written");
    let Some((_, Some(table))) = cache.load(&key) else { return };
    assert!(table.heap_bytes() <= 8 * bytes.len() + 1024);
    assert!(table.mean_cosine().abs() <= 1.0 + 1e-9 && table.max_value() >= 0.0, "{}", table.mean_cosine());
    for i in 0..=16 {
        let u = f64::from(i) / 16.0;
        let h = table.sample(u);
        assert!((0.0..=2.0).contains(&h), "sample {u} is {h}");
        assert!(table.eval(2.0 * u) >= 0.0 && (0.0..=1.0 + 1e-9).contains(&table.cdf(2.0 * u)), "at {u}");
    }
}

/// FNV-1a, the checksum of an entry.
fn fnv1a(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x100_0000_01b3))
}

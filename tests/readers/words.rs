//! Words on the command line and in settings: quantities, descriptions, arguments, recipes of clouds.

use std::ffi::OsString;
use std::path::Path;

use mie_cloud::cli::{outcome, understand};
use mie_cloud::optics::distribution::SizeDistribution;
use mie_cloud::optics::material::Material;
use mie_cloud::optics::phase_model::PhaseModel;
use mie_cloud::scene::glob::matches;
use mie_cloud::scene::{LoadOptions, load};
use mie_cloud::spectrum::SpectralMode;
use mie_cloud::spectrum::sun::SunSpectrum;
use mie_cloud::units::parse_length_m;

use super::tables;

/// Files that are read by descriptions are not there.
fn none(_: &str) -> Result<String, String> {
    Err("there is no such file".into())
}

/// What is said of a value repeats it at most twice.
fn check_answer(message: &str, text: &str) {
    assert!(!message.is_empty() && message.len() < 1000 + 2 * text.len(), "{message}");
}

/// A value on each line, as every parser of values reads it.
pub fn values(bytes: &[u8], _folder: &Path) {
    String::from_utf8_lossy(bytes).lines().take(32).for_each(value);
}

fn value(text: &str) {
    match parse_length_m(text) {
        Ok(length_m) => assert!(length_m.is_finite() && length_m >= 0.0, "{text} is {length_m} m"),
        Err(error) => check_answer(&error.to_string(), text),
    }
    match SizeDistribution::parse(text, &none) {
        Ok(sizes) => {
            tables::check_sizes(&sizes);
            let again = SizeDistribution::parse(&sizes.to_string(), &none);
            assert_eq!(again.as_ref(), Ok(&sizes), "{sizes} is not read back");
        }
        Err(error) => check_answer(&error.to_string(), text),
    }
    match Material::parse(text, &none) {
        Ok(material) => assert_eq!(Material::parse(&material.name(), &none), Ok(material)),
        Err(error) => check_answer(&error.to_string(), text),
    }
    match PhaseModel::parse(text, &none) {
        Ok(model) => assert_eq!(PhaseModel::parse(&model.to_string(), &none), Ok(model)),
        Err(error) => check_answer(&error.to_string(), text),
    }
    match text.parse::<SpectralMode>() {
        Ok(mode) => assert_eq!(mode.to_string().parse(), Ok(mode)),
        Err(error) => check_answer(&error.to_string(), text),
    }
    if let Err(error) = text.parse::<SunSpectrum>() {
        check_answer(&error.to_string(), text);
    }
    let (pattern, name) = text.split_once(' ').unwrap_or((text, "droplet.001"));
    let _ = matches(pattern, name);
}

/// Arguments, one on each line, as they are understood before anything is done.
pub fn arguments(bytes: &[u8], _folder: &Path) {
    let text = String::from_utf8_lossy(bytes);
    let _ = understand(std::iter::once("mie-cloud").chain(text.lines()).map(OsString::from));
}

/// Flags of `generate` that decide about the cloud; the rest is fixed.
const FLAGS: [&str; 17] = [
    "--shape=",
    "--size=",
    "--kind=",
    "--distribution=",
    "--liquid-water=",
    "--optical-depth=",
    "--seed=",
    "--as=",
    "--overlap=",
    "--patchiness=",
    "--camera-position=",
    "--look-at=",
    "--yfov=",
    "--sun-elevation=",
    "--sun-azimuth=",
    "--set=",
    "--count=",
];

/// Flags of `generate`, one on each line; a cloud that is made can be read.
pub fn recipe(bytes: &[u8], folder: &Path) {
    const MOST_PARTICLES: f64 = 200.0;
    let text = String::from_utf8_lossy(bytes);
    let too_many = |line: &str| {
        let count = line.strip_prefix("--count=").map(|count| count.trim().parse::<f64>());
        matches!(count, Some(Ok(count)) if count > MOST_PARTICLES)
    };
    let lines: Vec<&str> = text.lines().filter(|line| FLAGS.iter().any(|flag| line.starts_with(flag))).collect();
    if lines.iter().any(|line| too_many(line)) {
        return;
    }
    let few = (!lines.iter().any(|line| line.starts_with("--count="))).then_some("--count=50");
    let out = folder.join("cloud.glb");
    let first = ["mie-cloud", "generate", "-q", "-o"].map(OsString::from).into_iter().chain([out.clone().into()]);
    match outcome(first.chain(few.into_iter().chain(lines).map(OsString::from))) {
        Ok(_) => {
            if let Err(error) = load(&out, &LoadOptions::default()) {
                panic!("what was made cannot be read: {error}");
            }
        }
        Err(message) => assert!(!message.is_empty() && message.len() < 20_000),
    }
}

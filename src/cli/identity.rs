//! What must agree for the samples of two runs to belong to one picture, and the words for where they do not.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use anyhow::Context;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};
use xxhash_rust::xxh3::Xxh3;

use super::output::Recipe;
use crate::film::Layer;
use crate::image::exr::Limits;
use crate::plan::EffectPlan;
use crate::scene::model::Scene;
use crate::spectrum::SpectralSampling;
use crate::transport::{RenderRequest, Spectral, Until};

/// The entry that parts of one picture differ in.
const SAMPLES: &str = "samples";
/// The entry that differs where any setting does.
const SCENE: &str = "scene";

/// What is recorded with the sums of a render.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct About {
    /// Everything that decides about the samples, by name.
    pub identity: Map<String, Value>,
    /// How the picture is made of the sums.
    pub recipe: Recipe,
    /// First sample, and the one after the last, of a finished part; none in checkpoints.
    pub part: Option<[u32; 2]>,
}

/// Everything that decides about the samples.
pub fn identity(
    scene: &Scene,
    sampling: &SpectralSampling,
    plan: &EffectPlan,
    request: &RenderRequest,
    (accuracy, order): (f64, Option<u32>),
) -> anyhow::Result<Map<String, Value>> {
    let mut identity = Map::new();
    let mut put = |key: &str, value: Value| {
        identity.insert(key.to_owned(), value);
    };
    put("version", env!("CARGO_PKG_VERSION").into());
    put(SCENE, scene.hash.clone().into());
    if let Value::Object(settings) = scene.settings.to_json() {
        settings.into_iter().for_each(|(key, value)| put(&key, value));
    }
    let on = plan.decisions.iter().filter(|decision| decision.on);
    put("--effects", on.map(|decision| decision.effect.name()).collect());
    put("--crop", json!(request.crop));
    put("--seed", request.seed.into());
    put("--order", order.into());
    put("--accuracy", accuracy.into());
    put("--aov", request.layers.iter().map(|layer| Layer::ALL[*layer as usize].1).collect());
    put("--spectral", (request.spectral == Spectral::Keep).into());
    put("spectral.mode", sampling.mode().to_string().into());
    put(SAMPLES, until(request.until).into());
    if let Some(image) = &scene.settings.background.image {
        put("background.image", hash_of(image)?.into());
    }
    Ok(identity)
}

fn until(until: Until) -> String {
    match until {
        Until::Samples(n) => format!("--spp {n}"),
        Until::Noise { target: 0.0, .. } => "--time-limit".into(),
        Until::Noise { target, .. } => format!("--noise {target}"),
        Until::Range { first, end } => format!("--samples {first}..{end}"),
    }
}

/// A scene's hash knows only the name of its background; here its content counts.
fn hash_of(path: &Path) -> anyhow::Result<String> {
    let read = || -> std::io::Result<Xxh3> {
        // More is not read of a picture either: a longer file is refused where it is used.
        let file = File::open(path)?.take(Limits::default().file_bytes);
        let (mut file, mut hash, mut buffer) = (file, Xxh3::new(), vec![0; 1 << 16]);
        loop {
            match file.read(&mut buffer)? {
                0 => return Ok(hash),
                n => hash.update(&buffer[..n]),
            }
        }
    };
    Ok(format!("{:032x}", read().with_context(|| format!("cannot read {}", path.display()))?.digest128()))
}

/// How another run differs from this one, in words; none where the samples belong together.
pub fn difference(other: &Map<String, Value>, this: &Map<String, Value>) -> Option<String> {
    let keys: std::collections::BTreeSet<&String> = other.keys().chain(this.keys()).collect();
    let differs: Vec<&String> = keys.into_iter().filter(|key| other.get(*key) != this.get(*key)).collect();
    let said = |key: &String| {
        let value = |map: &Map<String, Value>| map.get(key).map_or("nothing".into(), shown);
        match key.as_str() {
            SCENE => format!("the scene has hash {}, not {}", value(other), value(this)),
            SAMPLES => format!("it is for {}, not {}", value(other), value(this)),
            _ => format!("{key} is {}, not {}", value(other), value(this)),
        }
    };
    // With a setting the hash of the scene differs as well; that says nothing new.
    let other_than_scene: Vec<String> = differs.iter().filter(|key| **key != SCENE).map(|key| said(key)).collect();
    match (other_than_scene.is_empty(), differs.first()) {
        (true, first) => first.map(|key| said(key)),
        (false, _) => Some(other_than_scene.join("; ")),
    }
}

/// Whether nothing differs but the number of samples.
pub fn differs_in_samples_only(other: &Map<String, Value>, this: &Map<String, Value>) -> bool {
    other.get(SAMPLES) != this.get(SAMPLES) && difference(&without_samples(other), &without_samples(this)).is_none()
}

fn without_samples(identity: &Map<String, Value>) -> Map<String, Value> {
    let mut identity = identity.clone();
    identity.remove(SAMPLES);
    identity
}

/// The same, for parts of one picture, whose samples must differ.
pub fn difference_of_parts(other: &About, this: &About) -> Option<String> {
    let of_output =
        || (!other.recipe.makes_the_same_as(&this.recipe)).then(|| "it was made with other output flags".to_owned());
    difference(&without_samples(&other.identity), &without_samples(&this.identity)).or_else(of_output)
}

fn shown(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Null => "unset".into(),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_name_the_key_and_both_values() {
        let map = |value: Value| value.as_object().cloned().unwrap_or_default();
        let this = map(json!({"scene": "ab", "--seed": 1, "atmosphere.step_m": null}));
        assert_eq!(difference(&this, &this), None);
        let other = map(json!({"scene": "cd", "--seed": 2, "atmosphere.step_m": 0.5}));
        let said = difference(&other, &this).unwrap_or_default();
        assert_eq!(said, "--seed is 2, not 1; atmosphere.step_m is 0.5, not unset");
        let moved = map(json!({"scene": "cd", "--seed": 1, "atmosphere.step_m": null}));
        assert_eq!(difference(&moved, &this).unwrap_or_default(), "the scene has hash cd, not ab");
    }
}

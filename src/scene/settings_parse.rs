//! From JSON and `--set` to settings: flattens nested and dotted keys, finds each in its table, proposes the nearest.

use std::borrow::Cow;

use serde::Deserialize;
use serde::de::{IgnoredAny, MapAccess, Visitor};
use serde_json::Value;
use serde_json::value::RawValue;

use super::error::{SceneError, SceneFault, SceneResult};
use super::folder::Folder;
use super::given::{Given, Misfit};
use super::hints::place_of;
use super::keys::{Key, SETTINGS};
use super::marks::{LIGHT, MARKS};
use crate::excerpt::excerpt;
use crate::suggest::closest;

/// Settings longer than this are refused: as a tree, JSON takes up to ninety times the space of its text.
const TEXT_LIMIT_BYTES: usize = 128 << 10;

/// Dotted keys with their values, in order.
pub type Entries = Vec<(String, Value)>;

/// The entries of an element's `extras`: everything under `mie_cloud`, nested, dotted or as a JSON string.
///
/// # Errors
/// When `mie_cloud` is neither an object nor a string that holds one, or is unreasonably long.
pub fn entries_of_extras(extras: Option<&RawValue>, element: &str) -> SceneResult<Entries> {
    let Some(extras) = extras else { return Ok(Entries::new()) };
    let json = |e: serde_json::Error| SceneError::at(format!("{element}.extras"), SceneFault::Json(e.to_string()));
    // Extras may be anything; only objects can hold settings.
    if !extras.get().starts_with('{') {
        return Ok(Entries::new());
    }
    let OwnExtras { own, misspelt } = serde_json::from_str(extras.get()).map_err(json)?;
    if let Some(key) = misspelt {
        let suggestion = "ours is `mie_cloud`, or begins with `mie_cloud.`, as in `mie_cloud.kind`".into();
        let fault = SceneFault::UnknownKey { key: excerpt(&key), suggestion };
        return Err(SceneError::at(format!("{element}.extras"), fault));
    }
    let mut entries = Entries::new();
    for (key, raw) in own {
        if raw.get().len() > TEXT_LIMIT_BYTES || key.len() > TEXT_LIMIT_BYTES {
            return Err(too_long(element, raw.get().len()));
        }
        let mut value: Value = serde_json::from_str(raw.get()).map_err(json)?;
        if let (Value::String(text), true) = (&value, key == "mie_cloud") {
            let broken = |e: serde_json::Error| SceneFault::SettingsJson(e.to_string());
            value = serde_json::from_str(text)
                .map_err(|e| SceneError::at(format!("{element}.extras.mie_cloud"), broken(e)))?;
        }
        match key.strip_prefix("mie_cloud.") {
            Some(key) => flatten(key, value, &mut entries),
            None if value.is_object() => flatten("", value, &mut entries),
            None => {
                let problem = "is no object and no JSON text of one; expected an object of settings".into();
                let value = excerpt(&value.to_string());
                return Err(SceneError::at(element, SceneFault::Setting { key: key.into(), value, problem }));
            }
        }
    }
    Ok(entries)
}

fn too_long(element: &str, bytes: usize) -> SceneError {
    let (what, bytes, limit) = ("settings of this length".into(), bytes as u64, TEXT_LIMIT_BYTES as u64);
    let remedy = "keep tables in CSV files beside the scene";
    SceneError::at(format!("{element}.extras.mie_cloud"), SceneFault::TooLarge { what, bytes, limit, remedy })
}

/// The members of `extras` that are ours, unparsed, so that foreign extras cost nothing.
struct OwnExtras<'a> {
    own: Vec<(Cow<'a, str>, &'a RawValue)>,
    /// A foreign key that was meant to be ours.
    misspelt: Option<Cow<'a, str>>,
}

/// Whether a key that is not ours was meant to be: `miecloud`, `Mie_Cloud.kind`, `mie-cloud`, `mie_cloud_kind`.
fn is_misspelt(key: &str) -> bool {
    const OURS: &str = "miecloud";
    const NEXT: [&str; 18] = [
        "kind",
        "material",
        "phase",
        "distribution",
        "albedo",
        "number",
        "liquid",
        "extinction",
        "droplet",
        "sun",
        "atmosphere",
        "background",
        "spectral",
        "effects",
        "accuracy",
        "image",
        "spectrum",
        "angular",
    ];
    let letters = key.chars().filter(char::is_ascii_alphabetic).take(OURS.len() + 16);
    let letters: String = letters.map(|letter| letter.to_ascii_lowercase()).collect();
    let rest = letters.strip_prefix(OURS);
    rest.is_some_and(|rest| rest.is_empty() || NEXT.iter().any(|next| rest.starts_with(next)))
}

impl<'de> Deserialize<'de> for OwnExtras<'de> {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Members;
        impl<'de> Visitor<'de> for Members {
            type Value = OwnExtras<'de>;

            fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
                f.write_str("an object")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<OwnExtras<'de>, A::Error> {
                let (mut own, mut misspelt) = (Vec::new(), None);
                while let Some(key) = map.next_key::<Cow<'de, str>>()? {
                    if key == "mie_cloud" || key.starts_with("mie_cloud.") {
                        own.push((key, map.next_value()?));
                    } else {
                        map.next_value::<IgnoredAny>()?;
                        misspelt = misspelt.or_else(|| is_misspelt(&key).then_some(key));
                    }
                }
                Ok(OwnExtras { own, misspelt })
            }
        }
        deserializer.deserialize_map(Members)
    }
}

/// The entries of one `--set KEY=VALUE`: JSON where the value is an object or array, text otherwise.
///
/// # Errors
/// When the value begins like JSON but is none.
pub fn entries_of_flag(key: &str, text: &str) -> SceneResult<Entries> {
    let key = key.trim();
    let key = key.strip_prefix("mie_cloud.").unwrap_or(key);
    let value = if text.trim_start().starts_with(['{', '[', '"']) {
        serde_json::from_str(text)
            .map_err(|e| SceneError::at(format!("--set {key}"), SceneFault::SettingsJson(e.to_string())))?
    } else {
        Value::String(text.into())
    };
    let mut entries = Entries::new();
    flatten(key, value, &mut entries);
    Ok(entries)
}

/// Turns `{"atmosphere": {"step_m": 1}}` into `atmosphere.step_m = 1`; null sets nothing. An empty group stays, for its name to be looked at.
fn flatten(prefix: &str, value: Value, entries: &mut Entries) {
    match value {
        Value::Object(members) if prefix.is_empty() || !members.is_empty() => {
            for (name, value) in members {
                let key = if prefix.is_empty() { name } else { format!("{prefix}.{name}") };
                flatten(&key, value, entries);
            }
        }
        Value::Null => {}
        value => entries.push((prefix.to_owned(), value)),
    }
}

/// Sets every entry by its key; `element` is named in messages.
///
/// # Errors
/// For unknown keys, with the nearest known one, and for values that do not fit.
pub fn apply<T>(
    target: &mut T,
    keys: &[&[Key<T>]],
    entries: &Entries,
    folder: &Folder,
    element: &str,
) -> SceneResult<()> {
    for (name, value) in entries {
        let name = canonical(name);
        if is_empty_group(value) && keys.iter().copied().flatten().any(|key| is_in_group(key.name, &name)) {
            continue;
        }
        let Some(key) = keys.iter().copied().flatten().find(|key| key.name == name) else {
            return Err(SceneError::at(element, unknown(&name, keys)));
        };
        (key.set)(target, &Given { value, folder }).map_err(|misfit| {
            let value = value.as_str().map_or_else(|| value.to_string(), |text| format!("\"{text}\""));
            let fault = SceneFault::Setting {
                key: key.name.into(),
                value: excerpt(&value),
                problem: match misfit {
                    Misfit::Problem(problem) => format!("{problem}; expected {}", expectation(key.range, key.unit)),
                    Misfit::Sentence(sentence) => sentence,
                },
            };
            SceneError::at(element, fault)
        })?;
    }
    Ok(())
}

fn is_empty_group(value: &Value) -> bool {
    value.as_object().is_some_and(serde_json::Map::is_empty)
}

fn is_in_group(key: &str, group: &str) -> bool {
    key.strip_prefix(group).is_some_and(|rest| rest.starts_with('.'))
}

/// Effects are named with dashes; underscores come naturally where everything else has them.
fn canonical(name: &str) -> Cow<'_, str> {
    match name.strip_prefix("effects.") {
        Some(effect) if effect.contains('_') => Cow::Owned(format!("effects.{}", effect.replace('_', "-"))),
        _ => Cow::Borrowed(name),
    }
}

fn expectation(range: &str, unit: &str) -> String {
    if unit.is_empty() { range.into() } else { format!("{range} ({unit})") }
}

fn unknown<T>(name: &str, keys: &[&[Key<T>]]) -> SceneFault {
    let names: Vec<&str> = keys.iter().copied().flatten().map(|key| key.name).collect();
    // Words far longer than any key are no slips; the bound also keeps comparisons cheap.
    let word: String = name.chars().take(60).collect();
    let nearest = nearest(&word, &names);
    // What is looked for at the wrong place is no slip of the pen; marks have keys of their own for most of it.
    let place = if is_of_scene(&names) { place_of(&word) } else { None };
    let hint = match (place, nearest) {
        (Some(place), _) => format!("{place}; "),
        (None, Some(key)) => format!("did you mean `{key}`? "),
        (None, None) => elsewhere(name, &names).map_or_else(String::new, |place| format!("it belongs to {place}; ")),
    };
    let nearest = nearest.filter(|_| place.is_none());
    let known = known(nearest.unwrap_or(&word), &names);
    let suggestion = format!("{hint}{known}; docs/scene-format.md lists them with units, defaults and ranges");
    SceneFault::UnknownKey { key: excerpt(name), suggestion }
}

fn is_of_scene(names: &[&str]) -> bool {
    SETTINGS.iter().all(|key| names.contains(&key.name))
}

/// Where a key belongs that is not one of these.
fn elsewhere(name: &str, names: &[&str]) -> Option<&'static str> {
    let is_among = |keys: &[&str]| keys.contains(&name) && !keys.iter().all(|key| names.contains(key));
    if is_among(&SETTINGS.iter().map(|key| key.name).collect::<Vec<_>>()) {
        return Some("the scene");
    }
    if is_among(&MARKS.iter().map(|key| key.name).collect::<Vec<_>>()) {
        return Some("a node, mesh or material with droplets or fog");
    }
    is_among(&LIGHT.iter().map(|key| key.name).collect::<Vec<_>>()).then_some("a sun")
}

/// The part of a key before its first dot.
fn group(key: &str) -> &str {
    key.split('.').next().unwrap_or_default()
}

/// The part of a key after its last dot.
fn last_part(key: &str) -> &str {
    key.rsplit('.').next().unwrap_or(key)
}

/// The known keys of the same group, or all where there are few, or the groups.
fn known(name: &str, names: &[&str]) -> String {
    const FEW: usize = 12;
    let meant = closest(group(name), names.iter().copied().map(group)).unwrap_or_default();
    let of_group: Vec<&str> = names.iter().copied().filter(|known| group(known) == meant).collect();
    if names.len() <= FEW {
        return format!("known are {}", names.join(", "));
    }
    if !of_group.is_empty() {
        return format!("known are {}", of_group.join(", "));
    }
    let mut groups: Vec<String> = names.iter().map(|known| format!("{}.*", group(known))).collect();
    groups.dedup();
    format!("the keys are {}", groups.join(", "))
}

/// The known key that is nearest to a mistyped one; also if only its last part was written, or its unit was left away.
fn nearest<'a>(name: &str, known: &[&'a str]) -> Option<&'a str> {
    let begun = |key: &&&str| last_part(key).strip_prefix(last_part(name)).is_some_and(|rest| rest.starts_with('_'));
    closest(name, known.iter().copied()).or_else(|| known.iter().find(begun).copied()).or_else(|| {
        let near = closest(last_part(name), known.iter().copied().map(last_part))?;
        known.iter().copied().find(|key| last_part(key) == near)
    })
}

//! `--effects auto,+glow,-multiple`: which effects the user switches.

use std::collections::BTreeMap;

use anyhow::anyhow;

use super::failure::Failure;
use crate::scene::settings::{Effect, Switch};
use crate::suggest::{closest, did_you_mean, no_such};

/// What the flag switches; nothing where it is not given.
pub fn chosen(list: Option<&str>) -> Result<BTreeMap<Effect, Switch>, Failure> {
    list.map_or(Ok(BTreeMap::new()), parse).map_err(Failure::usage)
}

/// Reads the list; later entries win.
fn parse(list: &str) -> anyhow::Result<BTreeMap<Effect, Switch>> {
    let mut switches = BTreeMap::new();
    for entry in list.split(',').map(str::trim).filter(|entry| !entry.is_empty()) {
        if entry == "auto" {
            switches = Effect::ALL.iter().map(|(effect, _)| (*effect, Switch::Auto)).collect();
            continue;
        }
        let (switch, name) = match (entry.strip_prefix('+'), entry.strip_prefix('-')) {
            (Some(name), _) => (Switch::On, name),
            (_, Some(name)) => (Switch::Off, name),
            _ => return Err(no_sign(entry)),
        };
        switches.insert(effect(name)?, switch);
    }
    Ok(switches)
}

fn effect(name: &str) -> anyhow::Result<Effect> {
    // Layers and keys have underscores.
    let found = Effect::ALL.iter().find(|(_, known)| *known == name.replace('_', "-")).map(|(effect, _)| *effect);
    found.ok_or_else(|| anyhow!("--effects: {}", no_such("effect", name, names())))
}

fn names() -> impl Iterator<Item = &'static str> {
    Effect::ALL.iter().map(|(_, name)| *name)
}

/// What is said of an entry without a sign: a name, or a slip for `auto` or for a name.
fn no_sign(entry: &str) -> anyhow::Error {
    let auto = did_you_mean(entry, ["auto"]);
    let name = closest(entry, names()).unwrap_or("glow");
    let all = names().collect::<Vec<_>>().join(", ");
    anyhow!(
        "--effects {entry}{auto}: write `auto`, or a name after a sign, `+{name}` or `-{name}`; the effects are {all}"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_switch_and_later_ones_win() {
        let switches = parse("auto,+airlight,-shadows,+shadows").unwrap();
        assert_eq!(switches[&Effect::Airlight], Switch::On);
        assert_eq!(switches[&Effect::Shadows], Switch::On);
        assert_eq!(switches[&Effect::Direct], Switch::Auto);
    }

    #[test]
    fn slips_are_pointed_out() {
        let error = parse("+shadow").unwrap_err().to_string();
        assert!(error.contains("did you mean `shadows`"), "{error}");
        for slip in ["shadows", "shadow"] {
            assert!(parse(slip).unwrap_err().to_string().contains("`+shadows` or `-shadows`; the effects are direct"));
        }
        assert!(parse("aut").unwrap_err().to_string().contains("did you mean `auto`"));
    }
}

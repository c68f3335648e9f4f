//! `--effects auto,+glow,-multiple`: which effects the user switches.

use std::collections::BTreeMap;

use anyhow::anyhow;

use crate::scene::settings::{Effect, Switch};
use crate::suggest::closest;

/// Reads the list; later entries win.
pub fn parse(list: &str) -> anyhow::Result<BTreeMap<Effect, Switch>> {
    let mut switches = BTreeMap::new();
    for entry in list.split(',').map(str::trim).filter(|entry| !entry.is_empty()) {
        if entry == "auto" {
            switches = Effect::ALL.iter().map(|(effect, _)| (*effect, Switch::Auto)).collect();
            continue;
        }
        let (switch, name) = match (entry.strip_prefix('+'), entry.strip_prefix('-')) {
            (Some(name), _) => (Switch::On, name),
            (_, Some(name)) => (Switch::Off, name),
            _ => {
                let name = closest(entry, Effect::ALL.iter().map(|(_, name)| *name)).unwrap_or("glow");
                return Err(anyhow!("--effects {entry}: write `auto`, or a name after a sign, `+{name}` or `-{name}`"));
            }
        };
        switches.insert(effect(name)?, switch);
    }
    Ok(switches)
}

fn effect(name: &str) -> anyhow::Result<Effect> {
    let names = || Effect::ALL.iter().map(|(_, name)| *name);
    Effect::ALL.iter().find(|(_, known)| *known == name).map(|(effect, _)| *effect).ok_or_else(|| {
        let hint = match closest(name, names()) {
            Some(known) => format!("did you mean `{known}`?"),
            None => format!("the effects are {}", names().collect::<Vec<_>>().join(", ")),
        };
        anyhow!("--effects: there is no effect `{name}`; {hint}")
    })
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
            assert!(parse(slip).unwrap_err().to_string().ends_with("`+shadows` or `-shadows`"));
        }
    }
}

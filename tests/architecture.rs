//! The layering of ARCHITECTURE.md: which module may use which, and who may name which crate.

use std::path::{Path, PathBuf};

/// Module, and the modules of this crate that it may name.
const MAY_USE: [(&str, &[&str]); 15] = [
    ("excerpt", &[]),
    ("units", &[]),
    ("suggest", &[]),
    ("warning", &[]),
    ("spectrum", &["units", "suggest"]),
    ("mie", &[]),
    ("optics", &["excerpt", "mie", "spectrum", "units", "suggest", "warning"]),
    ("scene", &["excerpt", "units", "optics", "spectrum", "suggest", "warning"]),
    ("plan", &["scene", "optics", "spectrum", "units", "warning"]),
    ("accel", &[]),
    ("film", &[]),
    ("image", &["excerpt"]),
    ("transport", &["accel", "excerpt", "optics", "plan", "scene", "spectrum", "film", "image", "warning"]),
    (
        "study",
        &[
            "accel",
            "film",
            "image",
            "mie",
            "optics",
            "plan",
            "scene",
            "spectrum",
            "suggest",
            "transport",
            "units",
            "warning",
        ],
    ),
    ("paper", &["film", "image", "mie", "optics", "plan", "scene", "spectrum", "transport"]),
];

/// Crate, and the places that may name it.
const ONLY_IN: [(&str, &[&str]); 11] = [
    ("gltf::", &["scene/gltf"]),
    ("obvhs", &["accel"]),
    ("exr::prelude", &["image/exr"]),
    ("png::Encoder", &["image/png"]),
    ("clap", &["cli"]),
    ("indicatif", &["cli"]),
    ("signal_hook", &["cli"]),
    ("anyhow", &["cli"]),
    ("plotters", &["study/plot"]),
    ("embedded_graphics", &["paper/sheet"]),
    ("std::time", &["study", "cli"]),
];

/// Rows of the code map: the modules in the first column, the modules that the last one allows them.
fn rows_of_the_map() -> Vec<(Vec<String>, Vec<String>)> {
    let quoted = |cell: &str| -> Vec<String> {
        cell.split('`').skip(1).step_by(2).map(|name| name.trim_end_matches('/').to_owned()).collect()
    };
    let rows = include_str!("../ARCHITECTURE.md").lines().filter(|line| line.starts_with("| `"));
    rows.map(|row| {
        let cells: Vec<&str> = row.trim_matches('|').split('|').collect();
        let last = cells.last().copied().unwrap_or_default();
        let allowed = match last.trim().strip_prefix("all but ") {
            Some(but) => {
                let but = quoted(but);
                let all = MAY_USE.iter().map(|(name, _)| (*name).to_owned());
                all.filter(|name| !but.contains(name)).collect()
            }
            None => quoted(last),
        };
        (quoted(cells[0]), allowed)
    })
    .collect()
}

#[test]
fn the_map_says_what_is_checked() {
    let common = ["excerpt", "units", "suggest", "warning"];
    let mut seen = 0;
    for (modules, mapped) in rows_of_the_map() {
        for module in modules {
            let Some((_, checked)) = MAY_USE.iter().find(|(name, _)| *name == module) else { continue };
            let sorted = |names: Vec<&str>| -> Vec<String> {
                let own = names.iter().filter(|name| !common.contains(name) && **name != module);
                let mut names: Vec<String> = own.map(|name| (*name).to_owned()).collect();
                names.sort();
                names
            };
            let mapped = sorted(mapped.iter().map(String::as_str).collect());
            assert_eq!(mapped, sorted(checked.to_vec()), "{module}: the map, and what is checked");
            seen += 1;
        }
    }
    assert_eq!(seen, MAY_USE.len(), "every module has its row");
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

/// Every source file below `src/` with its path relative to it and its lines of code before the unit tests.
fn code() -> Vec<(String, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut found = Vec::new();
    sources(&root, &mut found);
    let relative = |path: &Path| path.strip_prefix(&root).unwrap().to_string_lossy().replace('\\', "/");
    let read = |path: &PathBuf| {
        let text = std::fs::read_to_string(path).unwrap();
        let code = text.split("#[cfg(test)]").next().unwrap_or_default();
        let lines = code.lines().filter(|line| !line.trim_start().starts_with("//"));
        (relative(path), lines.collect::<Vec<_>>().join("\n"))
    };
    found.iter().map(read).collect()
}

#[test]
fn no_module_reaches_back() {
    let mut wrong = Vec::new();
    for (path, text) in code() {
        let module = path.split(['/', '.']).next().unwrap_or_default();
        let Some((_, allowed)) = MAY_USE.iter().find(|(name, _)| *name == module) else { continue };
        for named in text.match_indices("crate::").map(|(at, prefix)| &text[at + prefix.len()..]) {
            let target: String = named.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
            if target != module && !target.is_empty() && !allowed.contains(&target.as_str()) {
                wrong.push(format!("{path} names crate::{target}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn each_foreign_crate_is_named_in_one_place() {
    let mut wrong = Vec::new();
    for (path, text) in code() {
        for (name, places) in ONLY_IN {
            let named = text.match_indices(name).any(|(at, _)| {
                let before = text[..at].chars().next_back();
                !before.is_some_and(|c| c.is_alphanumeric() || c == '_' || c == ':')
            });
            if named && !places.iter().any(|place| path.starts_with(place)) {
                wrong.push(format!("{path} names {name}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn the_library_neither_prints_nor_exits_nor_is_unsafe() {
    let mut wrong = Vec::new();
    for (path, text) in code() {
        let forbidden: &[&str] = if path.starts_with("cli") || path == "main.rs" {
            &["eprint", "unsafe ", "process::exit"]
        } else {
            &["println!", "eprintln!", "dbg!(", "process::exit", "unsafe ", "static mut"]
        };
        wrong.extend(forbidden.iter().filter(|word| text.contains(**word)).map(|word| format!("{path}: {word}")));
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

//! The package that others get: what is in it, under which licences, and whether documents name files that are there.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn cargo(arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO")).args(arguments).current_dir(root()).output().expect("cargo starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("UTF-8")
}

/// Names in quotation marks of the list `allow` in `deny.toml`.
fn allowed_licences() -> Vec<String> {
    let text = std::fs::read_to_string(root().join("deny.toml")).expect("deny.toml");
    let list = text.split("allow = [").nth(1).and_then(|rest| rest.split(']').next()).expect("a list of licences");
    list.split('"').skip(1).step_by(2).map(ToOwned::to_owned).collect()
}

/// Whether a licence expression can be met: `A OR B AND C`, with `/` for OR as old crates have it.
fn is_met(expression: &str, allowed: &[String]) -> bool {
    let alternatives = expression.replace(['(', ')'], "").replace('/', " OR ");
    // `(A OR B) AND C` is read as `A OR (B AND C)` with its brackets gone: C is then asked for by itself.
    let always: Vec<&str> = expression.split(") AND ").skip(1).collect();
    let known = |licence: &str| allowed.iter().any(|known| known == licence.trim());
    alternatives.split(" OR ").any(|each| each.split(" AND ").all(known)) && always.iter().all(|each| known(each))
}

#[test]
fn every_dependency_has_a_licence_that_is_allowed() {
    let allowed = allowed_licences();
    assert!(allowed.len() > 5 && is_met("MIT", &allowed) && is_met("(MIT OR Apache-2.0) AND Unicode-3.0", &allowed));
    for refused in ["GPL-3.0", "MIT AND GPL-3.0", "(MIT OR Apache-2.0) AND GPL-3.0"] {
        assert!(!is_met(refused, &allowed), "{refused}");
    }
    let metadata = cargo(&["metadata", "--format-version", "1", "--locked"]);
    let metadata: Value = serde_json::from_str(&metadata).expect("JSON");
    let packages = metadata["packages"].as_array().expect("packages");
    assert!(packages.len() > 50);
    for package in packages {
        let licence = package["license"].as_str().unwrap_or("none");
        assert!(is_met(licence, &allowed), "{} {}: {licence}", package["name"], package["version"]);
        let source = package["source"].as_str();
        assert!(source.is_none_or(|s| s.starts_with("registry+")), "{} comes from {source:?}", package["name"]);
    }
}

#[test]
fn the_package_holds_what_it_needs_and_little_else() {
    let listed = cargo(&["package", "--list", "--allow-dirty", "--locked"]);
    let files: Vec<&str> = listed.lines().collect();
    for needed in
        ["LICENSE-MIT", "LICENSE-APACHE", "README.md", "Cargo.lock", "src/main.rs", "docs/theory.md", "scenes/fog.gltf"]
    {
        assert!(files.contains(&needed), "{needed}");
    }
    assert_eq!(files.iter().find(|file| file.starts_with("target/")), None);
    let bytes: u64 = files.iter().filter_map(|file| root().join(file).metadata().ok()).map(|file| file.len()).sum();
    // crates.io takes 10 MB, compressed.
    assert!(bytes < 16 << 20, "{bytes} bytes");
}

/// Every relative link and picture of a document, with the document's own folder.
fn links(document: &Path) -> Vec<(PathBuf, String)> {
    let text = std::fs::read_to_string(document).expect("a document");
    let folder = document.parent().expect("a folder").to_path_buf();
    let targets = text.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    targets
        .filter(|target| !target.contains("://") && !target.starts_with('#'))
        .map(|target| (folder.join(target.split('#').next().unwrap_or(target)), target.to_owned()))
        .collect()
}

#[test]
fn documents_link_to_files_that_are_there() {
    let markdown = |folder: PathBuf| -> Vec<PathBuf> {
        let entries = std::fs::read_dir(folder).expect("listed").map(|entry| entry.expect("an entry").path());
        entries.filter(|path| path.extension().is_some_and(|extension| extension == "md")).collect()
    };
    let documents = [markdown(root()), markdown(root().join("docs"))].concat();
    let mut seen = 0;
    for document in &documents {
        for (path, target) in links(document) {
            assert!(path.exists(), "{}: {target}", document.display());
            seen += 1;
        }
    }
    assert!(seen > 25, "{seen}");
    // The README leads to every document.
    let readme: Vec<PathBuf> = links(&root().join("README.md")).into_iter().map(|(path, _)| path).collect();
    for document in documents.iter().filter(|document| !document.ends_with("README.md")) {
        assert!(readme.contains(document), "README.md does not lead to {}", document.display());
    }
}

/// Files that documents name in code, such as `scripts/rings.py` or `src/plan/mod.rs`.
#[test]
fn documents_name_files_that_are_there() {
    let mut seen = 0;
    for name in
        ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "docs/validation.md", "docs/exr.md", "docs/theory.md"]
    {
        let text = std::fs::read_to_string(root().join(name)).expect(name);
        let words = text.split(|c: char| !(c.is_alphanumeric() || "/._-".contains(c)));
        for word in words.map(|word| word.trim_end_matches(['.', '/'])) {
            let ours = ["src/", "tests/", "scripts/", "examples/", "docs/", "scenes/", "benches/", ".ci/"];
            if ours.iter().any(|folder| word.starts_with(folder)) {
                assert!(root().join(word).exists(), "{name} names {word}");
                seen += 1;
            }
        }
    }
    assert!(seen > 60, "{seen}");
}

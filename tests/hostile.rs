//! Broken and malicious files: each gives the documented outcome, and no damage whatever makes the reader panic.

mod support;

use mie_cloud::scene::{LoadOptions, load};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use serde_json::Value;
use support::{data, everything, load_bytes};

/// What a file should give.
enum Outcome {
    /// Reads, with this many particles.
    Reads(usize),
    /// An error whose text has this in it.
    Fails(&'static str),
}
use Outcome::{Fails, Reads};

/// The table of `docs/scene-format.md`, which a test compares with this one.
const OUTCOMES: [(&str, Outcome); 39] = [
    ("acc_idx_oob.gltf", Fails("accessors[99]")),
    ("acc_off_overflow.gltf", Fails("accessors[0]")),
    ("buf_idx_oob.gltf", Fails("buffers[99]")),
    ("buf_len_lie.gltf", Fails("buffers[0]")),
    ("bv_idx_oob.gltf", Fails("bufferViews[99]")),
    ("bv_oob_len.gltf", Fails("bufferViews[0]")),
    ("bv_oob_off.gltf", Fails("bufferViews[0]")),
    ("bv_overflow.gltf", Fails("bufferViews[0]")),
    ("camera_none.gltf", Fails("cameras[0]")),
    ("chunklen.glb", Fails("2147483647")),
    ("count_over.gltf", Fails("accessors[0]")),
    ("count_zero.gltf", Fails("count is 0")),
    ("ctype_bad.gltf", Fails("componentType")),
    ("ctype_mismatch.gltf", Fails("componentType is 5121")),
    ("deep_json.gltf", Fails("nested")),
    ("huge_count.gltf", Fails("4611686018427387904")),
    ("huge_count_nobv.gltf", Fails("1000000000000")),
    ("huge_count_sparse.gltf", Fails("1000000000000")),
    ("light_oob.gltf", Fails("lights[5]")),
    ("nan.gltf", Fails("JSON")),
    ("node_cycle.gltf", Fails("ancestor")),
    ("node_cycle2.gltf", Fails("ancestor")),
    ("nodes_missing.gltf", Fails("nodes[55]")),
    ("req_unknown.gltf", Reads(64)),
    ("scene_oob.gltf", Fails("scenes[7]")),
    ("sparse_ctype.gltf", Fails("sparse")),
    ("sparse_few_values.gltf", Fails("sparse")),
    ("stride_huge.gltf", Fails("9223372036854775808")),
    ("stride_small.gltf", Fails("byteStride is 4")),
    ("stride_zero.gltf", Fails("byteStride is 0")),
    ("total_len_small.glb", Fails("header")),
    ("trunc.glb", Fails("header")),
    ("type_bad.gltf", Fails("type is unknown")),
    ("type_mismatch.gltf", Fails("VEC2")),
    ("uri_abs.gltf", Fails("absolute")),
    ("uri_dev.gltf", Fails("scheme `file:`")),
    ("uri_http.gltf", Fails("scheme `http:`")),
    ("uri_pct.gltf", Fails("UTF-8")),
    ("uri_trav.gltf", Fails("leaves the scene's folder")),
];

#[test]
fn every_hostile_file_has_its_documented_outcome() {
    for (name, outcome) in &OUTCOMES {
        let path = data("hostile").join(name);
        match (load(&path, &LoadOptions::default()), outcome) {
            (Ok(scene), Reads(count)) => assert_eq!(scene.particles.len(), *count, "{name}"),
            (Err(error), Fails(part)) => {
                let text = error.to_string();
                println!("{name}: {text}");
                assert!(text.contains(part), "{name}: {text}");
                assert!(text.starts_with(path.to_str().unwrap_or_default()), "{name} names no file: {text}");
            }
            (Ok(_), Fails(part)) => panic!("{name} reads, but should fail with `{part}`"),
            (Err(error), Reads(_)) => panic!("{name} should read, but: {error}"),
        }
    }
}

#[test]
fn the_table_of_outcomes_is_the_documented_one() {
    let document = include_str!("../docs/scene-format.md");
    let folder = std::fs::read_dir(data("hostile")).map(Iterator::count).unwrap_or(0);
    assert_eq!(folder, OUTCOMES.len());
    for (name, outcome) in &OUTCOMES {
        let row = document.lines().find(|line| line.starts_with(&format!("| `{name}` |")));
        let Some(row) = row else { panic!("{name} is not documented") };
        assert_eq!(row.contains("| reads |"), matches!(outcome, Reads(_)), "{row}");
    }
}

/// Numbers and words that break readers which trust a file.
const NASTY: [&str; 14] = [
    "0",
    "-1",
    "1",
    "0.5",
    "1e999",
    "-1e308",
    "4294967295",
    "4294967296",
    "18446744073709551615",
    "9223372036854775807",
    "null",
    "[]",
    "{}",
    "\"x\"",
];

/// One kind of damage, at random.
fn damage(bytes: &mut Vec<u8>, rng: &mut Pcg64) {
    let at = rng.random_range(0..bytes.len());
    match rng.random_range(0..6) {
        0 => bytes[at] = rng.random_range(0..=255),
        1 => bytes[at] ^= 1 << rng.random_range(0..8),
        2 => bytes.truncate(at),
        3 => drop(bytes.drain(at..(at + rng.random_range(1..40)).min(bytes.len()))),
        4 => {
            let copy = bytes[at..(at + rng.random_range(1..40)).min(bytes.len())].to_vec();
            let to = rng.random_range(0..bytes.len());
            bytes.splice(to..to, copy);
        }
        _ => replace_number(bytes, at, NASTY[rng.random_range(0..NASTY.len())]),
    }
}

/// Replaces the first number after `at` that stands where JSON has values.
fn replace_number(bytes: &mut Vec<u8>, at: usize, by: &str) {
    let is_number = |b: u8| b.is_ascii_digit() || b"+-.eE".contains(&b);
    let starts = |w: &[u8]| matches!(w[0], b':' | b',' | b'[' | b' ') && w[1].is_ascii_digit();
    if let Some(start) = bytes[at..].windows(2).position(starts).map(|k| at + k + 1) {
        let end = bytes[start..].iter().position(|&b| !is_number(b)).map_or(bytes.len(), |k| start + k);
        bytes.splice(start..end, by.bytes());
    }
}

#[test]
fn damaged_files_never_make_the_reader_panic() {
    let mut rng = Pcg64::seed_from_u64(20_240_607);
    let (mut read, mut refused) = (0, 0);
    for name in ["fog_points.gltf", "fog_points.glb", "fog_instanced_required.gltf"] {
        let whole = std::fs::read(data(name)).unwrap_or_else(|e| panic!("{name}: {e}"));
        for _ in 0..1500 {
            let mut bytes = whole.clone();
            for _ in 0..rng.random_range(1..4) {
                if !bytes.is_empty() {
                    damage(&mut bytes, &mut rng);
                }
            }
            match load_bytes(&bytes, &LoadOptions::default()) {
                Ok(_) => read += 1,
                Err(error) => {
                    assert!(error.to_string().len() < 3000, "{error}");
                    refused += 1;
                }
            }
        }
    }
    // Much damage falls into names and numbers that stay valid; the rest must be found.
    assert!(read > 100 && refused > 1000, "{read} read, {refused} refused");
}

/// Replaces, removes or doubles one value somewhere in a JSON tree.
fn damage_value(value: &mut Value, rng: &mut Pcg64) {
    let count = value.as_array().map_or(0, Vec::len) + value.as_object().map_or(0, serde_json::Map::len);
    if count == 0 || rng.random_range(0..4) == 0 {
        *value = serde_json::from_str(NASTY[rng.random_range(0..NASTY.len())]).unwrap_or(Value::Null);
        return;
    }
    let k = rng.random_range(0..count);
    match (value, rng.random_range(0..8)) {
        (Value::Array(items), 0) => drop(items.remove(k)),
        (Value::Array(items), 1) => items.push(items[k].clone()),
        (Value::Array(items), _) => damage_value(&mut items[k], rng),
        (Value::Object(members), choice) => {
            let Some(key) = members.keys().nth(k).cloned() else { return };
            match choice {
                0 => drop(members.remove(&key)),
                _ => damage_value(&mut members[&key], rng),
            }
        }
        _ => {}
    }
}

#[test]
fn wrong_values_anywhere_never_make_the_reader_panic() {
    let mut rng = Pcg64::seed_from_u64(7);
    let whole = everything();
    let scene = whole.load(&LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    // Three points, two of three with a radius, two spheres, and two balls of fog.
    assert_eq!((scene.particles.len(), scene.fog_balls.len()), (3 + 2 + 2 + 2, 1));
    let json: Value = serde_json::from_str(&whole.to_text()).unwrap_or_else(|e| panic!("{e}"));
    let (mut read, mut refused) = (0, 0);
    for _ in 0..4000 {
        let mut json = json.clone();
        damage_value(&mut json, &mut rng);
        match load_bytes(json.to_string().as_bytes(), &LoadOptions::default()) {
            Ok(_) => read += 1,
            Err(_) => refused += 1,
        }
    }
    assert!(read > 100 && refused > 1000, "{read} read, {refused} refused");
}

/// Peak memory of whole processes, measured where the kernel tells it.
#[cfg(target_os = "linux")]
mod memory {
    use std::path::Path;
    use std::process::Command;

    use super::*;
    use support::{Gltf, glb_of};

    /// Peak resident memory that any scene may take: 64 MiB and 20 times its size.
    fn allowance_bytes(path: &Path) -> u64 {
        (64 << 20) + 20 * std::fs::metadata(path).map_or(0, |info| info.len())
    }

    /// Loads one file in a process of its own; returns its peak resident memory and what became of the file.
    fn peak_bytes(path: &Path) -> (u64, String) {
        let program = std::env::current_exe().unwrap_or_else(|e| panic!("{e}"));
        let mut command = Command::new(program);
        command.args(["--exact", "memory::load_the_file_that_is_named", "--ignored", "--nocapture"]);
        let output = command.env("MIE_CLOUD_TEST_SCENE", path).output().unwrap_or_else(|e| panic!("{e}"));
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        let field = |name: &str| text.lines().find_map(|line| line.strip_prefix(name)).map(str::to_owned);
        let peak = field("peak_kb=").and_then(|kb| kb.parse::<u64>().ok());
        let (Some(peak_kb), Some(outcome)) = (peak, field("outcome=")) else { panic!("{}: {text}", path.display()) };
        (peak_kb * 1024, outcome)
    }

    #[test]
    #[ignore = "the child process of the memory tests"]
    fn load_the_file_that_is_named() {
        let Some(path) = std::env::var_os("MIE_CLOUD_TEST_SCENE") else { return };
        let outcome = match load(path.as_ref(), &LoadOptions::default()) {
            Ok(scene) => format!("reads, {} particles, {} boxes", scene.particles.len(), scene.fog_boxes.len()),
            Err(error) => error.to_string().replace('\n', " ").chars().take(200).collect(),
        };
        let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
        let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap_or_default();
        println!("\noutcome={outcome}\npeak_kb={}", peak.trim().trim_end_matches(" kB"));
    }

    fn check(path: &Path) {
        let (peak, outcome) = peak_bytes(path);
        println!(
            "{:>7.1} of {:>7.1} MiB  {outcome}",
            peak as f64 / 1048576.0,
            allowance_bytes(path) as f64 / 1048576.0
        );
        assert!(peak <= allowance_bytes(path), "{}: {peak} bytes; {outcome}", path.display());
    }

    #[test]
    fn hostile_files_stay_within_their_memory() {
        for (name, _) in &OUTCOMES {
            check(&data("hostile").join(name));
        }
    }

    /// A glTF text whose array `name` holds `item` as often as fits into `bytes`.
    fn repeated(name: &str, item: &str, bytes: usize) -> Vec<u8> {
        let count = bytes / (item.len() + 1);
        let items = vec![item; count].join(",");
        format!(r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],"{name}":[{items}]}}"#).into_bytes()
    }

    fn nested_in(before: &str, item: &str, after: &str, bytes: usize) -> Vec<u8> {
        let items = vec![item; bytes / (item.len() + 1)].join(",");
        format!(
            r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],{before}{items}{after}}}"#
        )
        .into_bytes()
    }

    fn chain(bytes: usize) -> Vec<u8> {
        let nodes: Vec<String> = (1..bytes / 24).map(|child| format!(r#"{{"children":[{child}]}}"#)).collect();
        let nodes = nodes.join(",");
        format!(r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],"nodes":[{nodes},{{}}]}}"#).into_bytes()
    }

    fn star(bytes: usize) -> Vec<u8> {
        let count = bytes / 12;
        let children: Vec<String> = (1..=count).map(|child| child.to_string()).collect();
        let (children, leaves) = (children.join(","), vec!["{}"; count].join(","));
        format!(
            r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],"nodes":[{{"children":[{children}]}},{leaves}]}}"#
        )
        .into_bytes()
    }

    /// A million points, as a GLB file.
    fn honest_cloud(count: usize) -> Vec<u8> {
        let mut gltf = Gltf::new();
        let position = gltf.floats("VEC3", &(0..3 * count).map(|i| i as f32).collect::<Vec<_>>());
        let radius = gltf.floats("SCALAR", &vec![0.5; count]);
        let attributes = serde_json::json!({ "POSITION": position, "_RADIUS": radius });
        gltf.json["meshes"] = serde_json::json!([{ "primitives": [{ "mode": 0, "attributes": attributes }] }]);
        gltf.json["nodes"] = serde_json::json!([{ "mesh": 0 }]);
        glb_of(&gltf)
    }

    /// A few points that very many nodes link to.
    fn linked(bytes: usize) -> Vec<u8> {
        let mut gltf = Gltf::new();
        let position = gltf.floats("VEC3", &(0..3000).map(|i| i as f32).collect::<Vec<_>>());
        let radius = gltf.floats("SCALAR", &[0.5; 1000]);
        let attributes = serde_json::json!({ "POSITION": position, "_RADIUS": radius });
        gltf.json["meshes"] = serde_json::json!([{ "primitives": [{ "mode": 0, "attributes": attributes }] }]);
        let count = bytes / 20;
        gltf.json["nodes"] = vec![serde_json::json!({ "mesh": 0 }); count].into();
        gltf.json["scenes"][0]["nodes"] = (0..count).collect::<Vec<_>>().into();
        gltf.to_text().into_bytes()
    }

    #[test]
    fn files_that_are_made_to_swell_stay_within_their_memory() {
        const BYTES: usize = 6 << 20;
        let files = [
            ("empty nodes", repeated("nodes", "{}", BYTES)),
            ("numbers for nodes", repeated("nodes", "0", BYTES)),
            ("empty accessors", repeated("accessors", "{}", BYTES)),
            ("empty buffers", repeated("buffers", "{}", BYTES)),
            ("empty meshes", repeated("meshes", "{}", BYTES)),
            ("extensions without names", repeated("extensionsUsed", "\"\"", BYTES)),
            ("the same root again and again", nested_in(r#""scenes2":[{"nodes":["#, "0", "]}]", BYTES)),
            ("arrays in foreign extras", nested_in(r#""extras":["#, "[0]", "]", BYTES)),
            ("objects in mie_cloud", {
                let before = r#""meshes":[{"primitives":[],"extras":{"mie_cloud":{"kind":["#;
                nested_in(before, r#"{"":0}"#, "]}}}]", BYTES)
            }),
            ("primitives of points", {
                nested_in(r#""meshes":[{"primitives":["#, r#"{"mode":0,"attributes":{}}"#, "]}]", BYTES)
            }),
            ("a long chain", chain(BYTES)),
            ("a wide star", star(BYTES)),
            ("a million points", honest_cloud(BYTES / 16)),
            ("linked duplicates", linked(BYTES)),
        ];
        let folder = tempfile::tempdir().unwrap_or_else(|e| panic!("{e}"));
        for (name, bytes) in files {
            let path = folder.path().join(name);
            std::fs::write(&path, bytes).unwrap_or_else(|e| panic!("{name}: {e}"));
            check(&path);
        }
    }
}

//! Broken and malicious files: each gives the documented outcome, and no damage whatever makes the reader panic.

use std::path::{Path, PathBuf};
use std::time::Instant;

use mie_cloud::scene::{LoadOptions, load};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

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

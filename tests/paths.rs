//! Files that a scene names stay in its folder, however they are named and whatever they are for; what the user types does not.

#![cfg(unix)]

mod program;
mod support;

use std::os::unix::fs::symlink;

use mie_cloud::image::{Existing, Picture, exr};
use program::{Bench, assert_says};
use serde_json::{Value, json};
use support::Gltf;

/// Ways out of a scene's folder that name `FILE` beside it, and what is said of them. The second holds in URIs only, which are
/// percent-encoded.
const OUT: [(&str, &str); 8] = [
    ("../FILE", "`..`"),
    ("sub/../../FILE", "`..`"),
    ("ABSOLUTE/FILE", "absolute"),
    ("link.EXT", "link that leaves"),
    ("linked/FILE", "link that leaves"),
    ("sub/link.EXT", "link that leaves"),
    ("zero.EXT", "link that leaves"),
    ("folder.EXT", "regular file"),
];
const OUT_ENCODED: [(&str, &str); 6] = [
    ("%2e%2e/FILE", "`..`"),
    ("%2E%2E%2FFILE", "`..`"),
    ("sub/%2e%2e/.%2e/FILE", "`..`"),
    ("%2Fetc/hostname", "absolute"),
    ("file:///etc/hostname", "scheme"),
    ("a%00b", "not a file name"),
];

/// A folder with `scene/`, whose links lead out, to a device and in; and files of every kind outside and inside.
fn home() -> Bench {
    let bench = Bench::new();
    std::fs::create_dir_all(bench.path("scene/sub")).expect("made");
    let mut picture = Picture::new(2, 1);
    for name in ["R", "G", "B"] {
        picture.push(name, vec![1.0, 2.0]);
    }
    for folder in ["", "scene/"] {
        bench.write(&format!("{folder}index.csv"), "wavelength_um,n,k\n0.3,1.5,0\n0.9,1.5,0\n");
        bench.write(&format!("{folder}sizes.csv"), "radius_um,dn_dr\n4,0\n5,1\n6,0\n");
        bench.write(&format!("{folder}phase.csv"), "angle_deg,value\n0,1\n180,1\n");
        std::fs::write(bench.path(&format!("{folder}points.bin")), points().bytes).expect("written");
        exr::write(&bench.path(&format!("{folder}sky.exr")), &picture, Existing::Replace).expect("written");
    }
    symlink("..", bench.path("scene/linked")).expect("linked");
    bench
}

/// One parcel, at the origin.
fn points() -> Gltf {
    let mut gltf = Gltf::new();
    gltf.bytes = [0.0f32, 0.0, 0.0, 1.0].iter().flat_map(|x| x.to_le_bytes()).collect();
    gltf.json["bufferViews"] =
        json!([{ "buffer": 0, "byteLength": 12 }, { "buffer": 0, "byteOffset": 12, "byteLength": 4 }]);
    gltf.json["accessors"] = json!([
        { "bufferView": 0, "componentType": 5126, "count": 1, "type": "VEC3", "min": [0, 0, 0], "max": [0, 0, 0] },
        { "bufferView": 1, "componentType": 5126, "count": 1, "type": "SCALAR" }]);
    gltf.json["meshes"] = json!([{
        "primitives": [{ "mode": 0, "attributes": { "POSITION": 0, "_RADIUS": 1 } }],
        "extras": { "mie_cloud": { "droplet_count": 1e6 } } }]);
    gltf.json["nodes"] = json!([{ "mesh": 0 }]);
    gltf
}

/// A scene that names one file for one purpose.
fn scene(purpose: &str, name: &str) -> Value {
    let mut json = points().json;
    let buffer = if purpose == "buffer" { name } else { "points.bin" };
    json["buffers"] = json!([{ "byteLength": 16, "uri": buffer }]);
    let (key, value) = match purpose {
        "buffer" => return json,
        "material" => ("droplets.material", name.to_owned()),
        "distribution" => ("droplets.distribution", format!("csv:{name}")),
        "phase" => ("droplets.phase", format!("table:{name}")),
        _ => ("background.image", name.to_owned()),
    };
    json["scenes"][0]["extras"] = json!({ format!("mie_cloud.{key}"): value });
    json
}

#[test]
fn files_of_a_scene_stay_in_its_folder() {
    let bench = home();
    let purposes = [
        ("buffer", "points.bin"),
        ("material", "index.csv"),
        ("distribution", "sizes.csv"),
        ("phase", "phase.csv"),
        ("background", "sky.exr"),
    ];
    for (purpose, file) in purposes {
        let extension = file.split('.').next_back().expect("an extension");
        std::fs::create_dir_all(bench.path(&format!("scene/folder.{extension}"))).expect("made");
        for (link, target) in [
            ("link", format!("../{file}")),
            ("sub/link", format!("../../{file}")),
            ("inside", file.into()),
            ("zero", "/dev/zero".into()),
        ] {
            let link = bench.path(&format!("scene/{link}.{extension}"));
            let _ = std::fs::remove_file(&link);
            symlink(target, link).expect("linked");
        }
        let try_with = |name: &str| {
            let name = name
                .replace("FILE", file)
                .replace("EXT", extension)
                .replace("ABSOLUTE", &bench.path("").display().to_string());
            bench.write("scene/a.gltf", &scene(purpose, &name).to_string());
        };
        for name in [file, "inside.EXT", "./inside.EXT", "linked/scene/FILE"] {
            try_with(name);
            bench.ok("render scene/a.gltf -o a.exr --spp 1 --resolution 2x2 -q --set spectral.mode=mono:550nm");
        }
        let encoded = OUT_ENCODED.iter().filter(|_| purpose == "buffer");
        for (name, part) in OUT.iter().chain(encoded) {
            try_with(name);
            let said = bench.fails(3, "inspect scene/a.gltf");
            assert_says(&said, &["scene/a.gltf", part]);
        }
    }
    // What the user types is unrestricted.
    bench.write("scene/a.gltf", &scene("buffer", "points.bin").to_string());
    for flag in ["droplets.material=index.csv", "droplets.distribution=csv:sizes.csv", "background.image=sky.exr"] {
        bench.ok(&format!("inspect scene/a.gltf --set {flag}"));
    }
    // A scene that is itself reached by a link lies in the folder in which it is named.
    std::fs::create_dir(bench.path("elsewhere")).expect("made");
    symlink("../scene/a.gltf", bench.path("elsewhere/b.gltf")).expect("linked");
    assert_says(&bench.fails(3, "inspect elsewhere/b.gltf"), &["points.bin", "cannot be read"]);
}

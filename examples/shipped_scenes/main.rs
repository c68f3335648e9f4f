//! Makes the scenes that come with the program again: `cargo run --release --example shipped_scenes [FOLDER]`.

mod clouds;
mod document;
mod drop;
mod paper;
mod rings;

use std::error::Error;
use std::path::Path;

use mie_cloud::image::{Existing, exr};
use mie_cloud::paper::FIGURES;
use serde_json::Value;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| "scenes".into());
    let mut scenes: Vec<(String, Value)> = Vec::new();
    for (name, scene) in [
        ("fog", clouds::fog()?),
        ("droplet", clouds::droplet()?),
        ("cumulus", clouds::cumulus()?),
        ("steam", clouds::steam()?),
        ("drop", drop::drop()),
        ("fogbow", rings::fogbow()),
        ("glory", rings::glory()),
        ("corona", rings::corona()),
        ("rainbow", rings::rainbow()),
    ] {
        scenes.push((name.into(), scene));
    }
    for figure in &FIGURES {
        scenes.push((format!("paper/fig{:02}", figure.number), paper::figure(figure)?));
    }
    std::fs::create_dir_all(Path::new(&folder).join("paper"))?;
    for (name, scene) in scenes {
        let path = Path::new(&folder).join(name).with_extension("gltf");
        let text = serde_json::to_string_pretty(&scene)? + "\n";
        println!("{}: {} kB", path.display(), text.len() / 1000);
        std::fs::write(&path, text)?;
    }
    exr::write(&Path::new(&folder).join(drop::MEADOW), &drop::meadow(), Existing::Replace)?;
    Ok(())
}

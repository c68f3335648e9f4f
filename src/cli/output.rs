//! From sums to files: which channels are written, in which units, and what is recorded with them.

use std::path::Path;

use anyhow::anyhow;

use super::failure::Failure;
use crate::film::{Layer, Wanted, develop};
use crate::image::file::Existing;
use crate::image::{Attribute, Frame, Picture, exr, png, spectral};
use crate::scene::model::Scene;
use crate::spectrum::{SpectralMode, SpectralSampling};
use crate::suggest::closest;
use crate::transport::{RenderOutcome, RenderRequest, Spectral};

/// What the user wants beside R, G, B, A.
#[derive(Clone, Debug)]
pub struct Wishes {
    /// Extra channels.
    pub wanted: Vec<Wanted>,
    /// Radiance by wavelength.
    pub spectral: Spectral,
    absolute: bool,
}

impl Wishes {
    /// Reads `--aov`.
    pub fn new(aov: Option<&str>, spectral: bool, absolute: bool) -> anyhow::Result<Self> {
        let spectral = if spectral { Spectral::Keep } else { Spectral::Discard };
        let mut wanted = aov.map_or(Ok(Vec::new()), parse_aov)?;
        wanted.sort_unstable();
        wanted.dedup();
        Ok(Self { wanted, spectral, absolute })
    }

    /// The layers that the film must keep apart.
    pub fn film_layers(&self) -> Vec<Layer> {
        let layer = |wanted: &Wanted| if let Wanted::Layer(layer) = wanted { Some(*layer) } else { None };
        self.wanted.iter().filter_map(layer).collect()
    }
}

fn parse_aov(list: &str) -> anyhow::Result<Vec<Wanted>> {
    let all = Wanted::all();
    let one = |name: &str| -> anyhow::Result<Vec<Wanted>> {
        if name == "all" {
            return Ok(all.iter().map(|(wanted, _)| *wanted).collect());
        }
        let found = all.iter().find(|(_, known)| *known == name).map(|(wanted, _)| vec![*wanted]);
        found.ok_or_else(|| {
            let names = || all.iter().map(|(_, known)| *known);
            let hint = closest(name, names()).map_or_else(
                || format!("the layers are {}, all", names().collect::<Vec<_>>().join(", ")),
                |known| format!("did you mean `{known}`?"),
            );
            anyhow!("--aov: there is no layer `{name}`; {hint}")
        })
    };
    let parts: Vec<Vec<Wanted>> =
        list.split(',').map(str::trim).filter(|name| !name.is_empty()).map(one).collect::<Result<_, _>>()?;
    Ok(parts.concat())
}

/// What is recorded with a picture of a scene.
pub struct Description {
    attributes: Vec<(String, Attribute)>,
    frame: Frame,
    total_lux: f64,
}

impl Description {
    /// Version, scene, settings and seed.
    pub fn new(scene: &Scene, sampling: &SpectralSampling, request: &RenderRequest) -> Self {
        let text = |value: String| Attribute::Text(value);
        let [x, y, _, _] = request.crop;
        let [full_width, full_height] = scene.settings.image.resolution;
        let attributes = vec![
            ("software".into(), text(format!("mie-cloud {}", env!("CARGO_PKG_VERSION")))),
            ("mieCloud:version".into(), text(env!("CARGO_PKG_VERSION").into())),
            ("mieCloud:scene".into(), text(scene.name.clone())),
            ("mieCloud:sceneHash".into(), text(scene.hash.clone())),
            ("mieCloud:settings".into(), text(scene.settings.to_json().to_string())),
            ("mieCloud:spectralMode".into(), text(sampling.mode().to_string())),
            ("mieCloud:seed".into(), text(request.seed.to_string())),
        ];
        let total_lux = scene.suns.iter().map(|sun| sun.lux).sum();
        Self { attributes, frame: Frame { x: x as i32, y: y as i32, full_width, full_height }, total_lux }
    }
}

/// File names that promise another format than the one that is written.
const OTHER_FORMATS: [&str; 12] =
    ["png", "jpg", "jpeg", "tif", "tiff", "hdr", "pfm", "ppm", "bmp", "webp", "json", "gltf"];

/// Refuses names of other formats than OpenEXR.
pub fn check_kind(path: &Path) -> anyhow::Result<()> {
    let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or("").to_lowercase();
    if OTHER_FORMATS.contains(&extension.as_str()) {
        let exr = path.with_extension("exr");
        return Err(anyhow!(
            "--output {}: the picture is OpenEXR; write `-o {}` (and `--preview FILE.png` for a PNG)",
            path.display(),
            exr.display()
        ));
    }
    Ok(())
}

/// The finished picture.
pub fn picture(
    outcome: &RenderOutcome,
    description: &Description,
    wishes: &Wishes,
    sampling: &SpectralSampling,
) -> Picture {
    let film = &outcome.film;
    let mut picture = Picture::new(film.width() as u32, film.height() as u32);
    let white = sampling.white_luminance_cd_m2(description.total_lux);
    let scale = if wishes.absolute { white.unwrap_or(1.0) } else { 1.0 };
    picture.frame = description.frame;
    // After scaling, the pixel value 1.0 is one cd/m^2.
    picture.white_luminance_cd_m2 = white.map(|white| if wishes.absolute { 1.0 } else { white as f32 });
    if !matches!(sampling.mode(), SpectralMode::Bands { .. }) {
        picture.chromaticities = None;
    }
    for channel in develop(film, &wishes.wanted, scale) {
        picture.push(channel.name, channel.values);
    }
    if wishes.spectral == Spectral::Keep {
        let planes = sampling.wavelengths_m.iter().enumerate().map(|(w, m)| (m * 1e9, film.spectral_plane(w)));
        spectral::add_spectrum(&mut picture, planes, "sr^-1");
    }
    for (name, value) in &description.attributes {
        picture.record(name.clone(), value.clone());
    }
    picture.record("mieCloud:samples", Attribute::Int(outcome.samples as i32));
    picture
}

/// Writes the picture and, if wished, its preview.
pub fn write(exr_path: &Path, preview: Option<&Path>, picture: &Picture, existing: Existing) -> Result<(), Failure> {
    exr::write(exr_path, picture, existing).map_err(Failure::other)?;
    if let Some(path) = preview {
        png::write_preview(path, picture, existing).map_err(Failure::other)?;
    }
    Ok(())
}

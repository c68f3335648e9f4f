//! From sums to files: which channels are written, in which units, and what is recorded with them.

use std::io::Write;
use std::path::Path;

use anyhow::{Context, anyhow};
use serde::{Deserialize, Serialize};

use super::failure::Failure;
use super::values::promises_other;
use crate::film::{Film, Layer, Wanted, develop};
use crate::image::file::{Existing, write_atomically};
use crate::image::{Attribute, Frame, Picture, exr, png, spectral};
use crate::plan::EffectPlan;
use crate::scene::model::Scene;
use crate::spectrum::{SpectralMode, SpectralSampling};
use crate::suggest::no_such;
use crate::transport::{RenderRequest, RenderState, Spectral, keep};

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
        // Effects have dashes.
        let found = all.iter().find(|(_, known)| *known == name.replace('-', "_")).map(|(wanted, _)| vec![*wanted]);
        let names = all.iter().map(|(_, known)| *known).chain(["all"]);
        found.ok_or_else(|| anyhow!("--aov: {}", no_such("layer", name, names)))
    };
    let parts: Vec<Vec<Wanted>> =
        list.split(',').map(str::trim).filter(|name| !name.is_empty()).map(one).collect::<Result<_, _>>()?;
    Ok(parts.concat())
}

/// How a picture is made of sums: what is recorded with it, which channels it has, in which units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Recipe {
    attributes: Vec<(String, String)>,
    /// Left, top, full width, full height.
    frame: (i32, i32, u32, u32),
    white_luminance_cd_m2: Option<f32>,
    /// Whether R, G, B are colours, not radiances at three wavelengths.
    is_colour: bool,
    scale: f64,
    wanted: Vec<String>,
    /// Wavelengths at which radiance is written, nm.
    wavelengths_nm: Vec<f64>,
    /// Irradiance of the brightest sun in the sums' unit: radiance by wavelength is written over it.
    #[serde(default = "unit")]
    irradiance: f64,
}

/// Of records that were written before it was one of theirs.
fn unit() -> f64 {
    1.0
}

impl Recipe {
    /// Whether the same picture comes out of the same sums. What is recorded beside it, such as the name by which each
    /// machine calls the scene, does not count.
    pub fn makes_the_same_as(&self, other: &Self) -> bool {
        let attributes = self.attributes.clone();
        *self == Self { attributes, ..other.clone() }
    }

    /// Channels at most: R, G, B, A, three for each that is wished, and one for each wavelength.
    pub fn n_channels(&self) -> usize {
        4 + 3 * self.wanted.len() + self.wavelengths_nm.len()
    }

    /// R, G, B and the number of samples.
    pub fn for_preview(&self) -> Self {
        Self { wanted: vec!["samples".into()], wavelengths_nm: Vec::new(), ..self.clone() }
    }

    /// Version, scene, settings, effects, orders of scattering and seed, and what is wished.
    pub fn new(
        scene: &Scene,
        (plan, order): (&EffectPlan, Option<u32>),
        sampling: &SpectralSampling,
        request: &RenderRequest,
        wishes: &Wishes,
    ) -> Self {
        let [x, y, _, _] = request.crop;
        let [full_width, full_height] = scene.settings.image.resolution;
        let attributes = [
            ("software", format!("mie-cloud {}", env!("CARGO_PKG_VERSION"))),
            ("mieCloud:version", env!("CARGO_PKG_VERSION").into()),
            ("mieCloud:scene", file_name(&scene.name)),
            ("mieCloud:sceneHash", scene.hash.clone()),
            ("mieCloud:settings", scene.settings.to_json().to_string()),
            ("mieCloud:spectralMode", sampling.mode().to_string()),
            ("mieCloud:effects", effects_on(plan)),
            ("mieCloud:order", order.map_or_else(|| "unlimited".into(), |order| order.to_string())),
            ("mieCloud:seed", request.seed.to_string()),
        ];
        let white = sampling.white_luminance_cd_m2(scene.suns.iter().map(|sun| sun.lux).sum());
        let kept = if wishes.spectral == Spectral::Keep { &sampling.wavelengths_m[..] } else { &[] };
        let all = Wanted::all();
        let name = |wanted: &Wanted| all.iter().find(|(known, _)| known == wanted).map(|(_, name)| (*name).to_owned());
        Self {
            attributes: attributes.map(|(name, value)| (name.to_owned(), value)).to_vec(),
            frame: (x as i32, y as i32, full_width, full_height),
            // After scaling, the pixel value 1.0 is one cd/m^2.
            white_luminance_cd_m2: white.map(|white| if wishes.absolute { 1.0 } else { white as f32 }),
            is_colour: matches!(sampling.mode(), SpectralMode::Bands { .. }),
            scale: white.filter(|_| wishes.absolute).unwrap_or(1.0),
            wanted: wishes.wanted.iter().filter_map(name).collect(),
            wavelengths_nm: kept.iter().map(|m| m * 1e9).collect(),
            irradiance: sampling.reference_irradiance(scene.settings.sun.irradiance),
        }
    }
}

/// Names of the effects that were simulated, whether asked for or planned.
fn effects_on(plan: &EffectPlan) -> String {
    let on = plan.decisions.iter().filter(|decision| decision.on).map(|decision| decision.effect.name());
    on.collect::<Vec<_>>().join(",")
}

/// The name of the scene's file without its folder: each machine keeps it elsewhere, and the picture must not tell.
fn file_name(scene: &str) -> String {
    Path::new(scene).file_name().map_or_else(|| scene.to_owned(), |name| name.to_string_lossy().into_owned())
}

/// Refuses names of other formats than OpenEXR.
pub fn check_kind(path: &Path) -> anyhow::Result<()> {
    if promises_other(path, "exr") {
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
pub fn picture(film: &Film, recipe: &Recipe) -> Picture {
    let mut picture = Picture::new(film.width() as u32, film.height() as u32);
    let (x, y, full_width, full_height) = recipe.frame;
    picture.frame = Frame { x, y, full_width, full_height };
    picture.white_luminance_cd_m2 = recipe.white_luminance_cd_m2;
    if !recipe.is_colour {
        picture.chromaticities = None;
    }
    let wanted: Vec<Wanted> =
        Wanted::all().into_iter().filter(|(_, name)| recipe.wanted.iter().any(|w| w == name)).map(|(w, _)| w).collect();
    for channel in develop(film, &wanted, recipe.scale) {
        picture.push(channel.name, channel.values);
    }
    if film.n_spectral() > 0 {
        let kept = recipe.wavelengths_nm.iter().take(film.n_spectral()).enumerate();
        let planes = kept.map(|(w, nm)| (*nm, film.spectral_plane(w, recipe.irradiance.recip())));
        spectral::add_spectrum(&mut picture, planes, "sr^-1");
    }
    for (name, value) in &recipe.attributes {
        picture.record(name.clone(), Attribute::Text(value.clone()));
    }
    picture.record("mieCloud:samples", Attribute::Int(film.mean_samples() as i32));
    picture
}

/// A part of a picture: its state, and what it is of.
pub type PartOf<'a> = (&'a serde_json::Value, &'a RenderState);

/// Writes the picture, the sums that it is made of if it is a part, and, if wished, its preview, which is written even where the picture
/// cannot be.
pub fn write(
    exr_path: &Path,
    preview: Option<&Path>,
    picture: &Picture,
    part: Option<PartOf>,
    existing: Existing,
) -> Result<(), Failure> {
    let written = match part {
        None => exr::write(exr_path, picture, existing).map_err(Failure::other),
        Some(part) => write_part(exr_path, picture, part, existing),
    };
    let shown = preview.map_or(Ok(()), |path| png::write_preview(path, picture, existing));
    written.and(shown.map_err(Failure::other))
}

fn write_part(path: &Path, picture: &Picture, (about, state): PartOf, existing: Existing) -> Result<(), Failure> {
    let encoded = exr::encode(picture).with_context(|| format!("cannot write {}", path.display()));
    let encoded = encoded.map_err(Failure::other)?;
    let write = |out: &mut dyn Write| out.write_all(&encoded).and_then(|()| keep::write(out, about, state));
    write_atomically(path, existing, write).map_err(Failure::other)
}

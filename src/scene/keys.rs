//! Every key of a scene's settings: its name, unit, default, range and what it sets. The documentation is tested against it.

use super::given::{Fit, Given, Misfit, Truth};
use super::settings::{AirPhase, Effect, Settings, Switch};
use crate::optics::distribution::SizeDistribution;
use crate::optics::material::Material;
use crate::optics::phase_model::PhaseModel;

/// A key that can be set on a `T`.
pub struct Key<T> {
    /// Its dotted name.
    pub name: &'static str,
    /// Its unit; empty for text and pure numbers.
    pub unit: &'static str,
    /// Its default, as it would be written.
    pub default: &'static str,
    /// What is accepted.
    pub range: &'static str,
    /// Sets it.
    pub set: fn(&mut T, &Given) -> Fit<()>,
}

/// Scattering and absorption coefficients, radiances and irradiances end here: 1e12 per metre is a mean free path of a
/// picometre, and larger numbers could overflow products in single precision.
const LARGEST: f64 = 1e12;
/// More pixels than this are no picture but a mistake, and would not fit into memory.
const MAX_PIXELS: u64 = 1 << 28;
/// What `_MATERIAL` can index: particles keep 16 bits for their class.
const MAX_MATERIALS: usize = 1024;

/// Keys of `extras.mie_cloud` of the scene, and of `--set`.
#[rustfmt::skip]
pub const SETTINGS: &[Key<Settings>] = &[
    Key { name: "droplets.material", unit: "", default: "water", range: "water, ice, n=N,k=K or a CSV file", set: |s, g| { s.droplets.class.material = g.parse(Material::parse)?; Ok(()) } },
    Key { name: "droplets.materials", unit: "", default: "[]", range: "a list of materials, for _MATERIAL to index", set: materials },
    Key { name: "droplets.phase", unit: "", default: "mie", range: "mie, hg, hg:G, hg-draine, rayleigh, isotropic or table:FILE.csv", set: |s, g| { s.droplets.class.phase = g.parse(PhaseModel::parse)?; Ok(()) } },
    Key { name: "droplets.distribution", unit: "", default: "gamma:reff=6um,veff=0.1", range: "mono:, gamma:, modgamma:, lognormal: or csv: with parameters", set: |s, g| { s.droplets.class.distribution = g.parse(SizeDistribution::parse)?; Ok(()) } },
    Key { name: "droplets.albedo", unit: "", default: "from Mie theory", range: "0 to 1", set: |s, g| { s.droplets.class.albedo = Some(g.within(0.0, 1.0)?); Ok(()) } },
    Key { name: "droplets.size_bins", unit: "", default: "auto", range: "auto, or 1 to 4096", set: size_bins },
    Key { name: "sun.spectrum", unit: "", default: "e490", range: "e490, g173, g173-direct, d65 or equal", set: |s, g| { s.sun.spectrum = from_str(g)?; Ok(()) } },
    Key { name: "sun.irradiance", unit: "W m^-2 nm^-1", default: "1", range: "1e-12 to 1e12", set: |s, g| { s.sun.irradiance = g.within(LARGEST.recip(), LARGEST)?; Ok(()) } },
    Key { name: "sun.angular_diameter_deg", unit: "degrees", default: "0.533", range: "0 to 90", set: |s, g| { s.sun.angular_diameter_deg = g.within(0.0, 90.0)?; Ok(()) } },
    Key { name: "atmosphere.scattering_per_m", unit: "1/m", default: "0", range: "0 to 1e12", set: |s, g| { s.atmosphere.scattering_per_m = g.within(0.0, LARGEST)?; Ok(()) } },
    Key { name: "atmosphere.absorption_per_m", unit: "1/m", default: "0", range: "0 to 1e12", set: |s, g| { s.atmosphere.absorption_per_m = g.within(0.0, LARGEST)?; Ok(()) } },
    Key { name: "atmosphere.phase", unit: "", default: "hg:0.7", range: "isotropic, rayleigh, hg:G with -1 < G < 1, or mie:DISTRIBUTION", set: air_phase },
    Key { name: "atmosphere.depth_m", unit: "m", default: "10", range: "above 0, at most 1e12", set: |s, g| { s.atmosphere.depth_m = g.positive(LARGEST)?; Ok(()) } },
    Key { name: "atmosphere.step_m", unit: "m", default: "0.05", range: "above 0, at most 1e12", set: |s, g| { s.atmosphere.step_m = g.positive(LARGEST)?; Ok(()) } },
    Key { name: "atmosphere.sunlight", unit: "", default: "true", range: "true or false", set: |s, g| { s.atmosphere.sunlight = g.truth()? == Truth::Yes; Ok(()) } },
    Key { name: "background.radiance", unit: "output units", default: "[0, 0, 0]", range: "three numbers (or one for all) from 0 to 1e12", set: radiance },
    Key { name: "background.image", unit: "", default: "none", range: "a lat-long EXR file", set: background_image },
    Key { name: "spectral.mode", unit: "", default: "from the accuracy", range: "mono:550nm, rgb, rgb:650nm,550nm,450nm, or bands:N, N from 1 to 400", set: |s, g| { s.spectral_mode = Some(from_str(g)?); Ok(()) } },
    Key { name: "effects.direct", unit: "", default: "auto", range: SWITCH, set: effect::<0> },
    Key { name: "effects.multiple", unit: "", default: "auto", range: SWITCH, set: effect::<1> },
    Key { name: "effects.absorption", unit: "", default: "auto", range: SWITCH, set: effect::<2> },
    Key { name: "effects.shadows", unit: "", default: "auto", range: SWITCH, set: effect::<3> },
    Key { name: "effects.airlight", unit: "", default: "auto", range: SWITCH, set: effect::<4> },
    Key { name: "effects.glow", unit: "", default: "auto", range: SWITCH, set: effect::<5> },
    Key { name: "effects.air-multiple", unit: "", default: "auto", range: SWITCH, set: effect::<6> },
    Key { name: "effects.refraction", unit: "", default: "auto", range: SWITCH, set: effect::<7> },
    Key { name: "effects.dispersion", unit: "", default: "auto", range: SWITCH, set: effect::<8> },
    Key { name: "effects.background", unit: "", default: "auto", range: SWITCH, set: effect::<9> },
    Key { name: "effects.sun-disc", unit: "", default: "auto", range: SWITCH, set: effect::<10> },
    Key { name: "accuracy.target", unit: "", default: "none", range: "draft, standard, fine, reference, or above 0 and at most 1", set: target },
    Key { name: "accuracy.size_parameter_cap", unit: "", default: "20000", range: "1 to 1e6", set: |s, g| { s.accuracy.size_parameter_cap = g.within(1.0, 1e6)?; Ok(()) } },
    Key { name: "accuracy.glow_tolerance", unit: "", default: "from the target", range: "0 (exact) to 1", set: |s, g| { s.accuracy.glow_tolerance = Some(g.within(0.0, 1.0)?); Ok(()) } },
    Key { name: "accuracy.angle_tolerance", unit: "", default: "from the target", range: "above 0, at most 1", set: |s, g| { s.accuracy.angle_tolerance = Some(g.positive(1.0)?); Ok(()) } },
    Key { name: "accuracy.peak_truncation_deg", unit: "degrees", default: "0", range: "0 to 45", set: |s, g| { s.accuracy.peak_truncation_deg = g.within(0.0, 45.0)?; Ok(()) } },
    Key { name: "image.resolution", unit: "pixels", default: "[640, 360]", range: "WxH or [W, H], each 1 to 65536, at most 2^28 in all", set: resolution },
];

const SWITCH: &str = "auto, on or off";

/// Names of accuracy targets: relative errors of the picture.
pub const ACCURACY_NAMES: [(&str, f64); 4] = [("draft", 0.1), ("standard", 0.05), ("fine", 0.02), ("reference", 0.005)];

/// Reads text by `FromStr`.
pub fn from_str<T: std::str::FromStr<Err: std::fmt::Display>>(given: &Given) -> Fit<T> {
    given.text()?.parse().map_err(|e: T::Err| Misfit::Sentence(e.to_string()))
}

fn materials(settings: &mut Settings, given: &Given) -> Fit<()> {
    // On the command line, commas belong to materials (`n=1.33,k=0`), so semicolons divide them.
    let items = match given.value.as_str() {
        Some(text) => text.split(';').map(|item| item.trim().into()).collect(),
        None => given.list()?,
    };
    if items.len() > MAX_MATERIALS {
        return Err(Misfit::Sentence(format!("has {} materials; at most {MAX_MATERIALS} are kept", items.len())));
    }
    settings.droplets.materials =
        items.iter().map(|item| given.with(item).parse(Material::parse)).collect::<Fit<Vec<Material>>>()?;
    Ok(())
}

fn size_bins(settings: &mut Settings, given: &Given) -> Fit<()> {
    settings.droplets.size_bins = match given.value.as_str() {
        Some("auto") => None,
        _ if given.number().is_err() => return Err(given.no_word("is neither `auto` nor a number", ["auto"])),
        _ => Some(given.whole(1, 4096)? as usize),
    };
    Ok(())
}

fn air_phase(settings: &mut Settings, given: &Given) -> Fit<()> {
    let text = given.text()?;
    settings.atmosphere.phase = match text.trim().split_once(':') {
        None if text.trim() == "isotropic" => AirPhase::Isotropic,
        None if text.trim() == "rayleigh" => AirPhase::Rayleigh,
        Some(("hg", g)) => {
            let g: f64 = g.trim().parse().map_err(|_| Misfit::from("its G is not a number"))?;
            if g.abs() >= 1.0 || g.is_nan() {
                return Err("its G is out of range".into());
            }
            AirPhase::HenyeyGreenstein { g }
        }
        Some(("mie", distribution)) => AirPhase::Haze(given.with(&distribution.into()).parse(SizeDistribution::parse)?),
        _ => {
            let names = ["isotropic", "rayleigh", "hg", "mie"];
            let stem = text.split(':').next().unwrap_or_default().into();
            return Err(given.with(&stem).no_word("is not a phase function of air", names));
        }
    };
    Ok(())
}

fn radiance(settings: &mut Settings, given: &Given) -> Fit<()> {
    if let Ok(gray) = given.number() {
        let gray = given.within(0.0, LARGEST).map(|_| gray)?;
        settings.background.radiance = [gray; 3];
        return Ok(());
    }
    let items = given.list()?;
    let [r, g, b] = items.as_slice() else { return Err("does not hold three numbers".into()) };
    let part = |item| given.with(item).within(0.0, LARGEST);
    settings.background.radiance = [part(r)?, part(g)?, part(b)?];
    Ok(())
}

fn background_image(settings: &mut Settings, given: &Given) -> Fit<()> {
    let name = given.text()?;
    let path = given.folder.resolve(&name).map_err(|r| Misfit::Sentence(format!("{}; {}", r.problem, r.remedy)))?;
    settings.background.image = Some(path);
    Ok(())
}

fn effect<const N: usize>(settings: &mut Settings, given: &Given) -> Fit<()> {
    let switch = match given.value.as_str() {
        Some("auto") => Switch::Auto,
        _ => match given.truth().map_err(|_| given.no_word("is not a switch", ["auto", "on", "off"]))? {
            Truth::Yes => Switch::On,
            Truth::No => Switch::Off,
        },
    };
    settings.effects.insert(Effect::ALL[N].0, switch);
    Ok(())
}

fn target(settings: &mut Settings, given: &Given) -> Fit<()> {
    let named = given.value.as_str().and_then(|text| ACCURACY_NAMES.iter().find(|(name, _)| *name == text.trim()));
    settings.accuracy.target = Some(match named {
        Some((_, target)) => *target,
        None if given.number().is_err() => {
            return Err(given.no_word("is neither a level nor a number", ACCURACY_NAMES.map(|(name, _)| name)));
        }
        None => given.positive(1.0)?,
    });
    Ok(())
}

fn resolution(settings: &mut Settings, given: &Given) -> Fit<()> {
    let items = match given.value.as_str().and_then(|text| text.split_once(['x', 'X'])) {
        Some((width, height)) => vec![width.into(), height.into()],
        None => given.list()?,
    };
    let [width, height] = items.as_slice() else { return Err("does not hold a width and a height".into()) };
    let (width, height) = (given.with(width).whole(1, 65536)?, given.with(height).whole(1, 65536)?);
    if u64::from(width) * u64::from(height) > MAX_PIXELS {
        return Err("holds too many pixels".into());
    }
    settings.image.resolution = [width, height];
    Ok(())
}

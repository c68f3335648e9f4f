//! Everything that can be set in a scene's `extras.mie_cloud` or with `--set`, with its default.

use std::collections::BTreeMap;
use std::path::PathBuf;

use crate::optics::DropletClass;
use crate::optics::distribution::SizeDistribution;
use crate::optics::material::Material;
use crate::optics::phase_model::PhaseModel;
use crate::spectrum::SpectralMode;
use crate::spectrum::sun::SunSpectrum;

/// The scene's settings, complete.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Droplets that say nothing of their own.
    pub droplets: DropletSettings,
    /// The sun.
    pub sun: SunSettings,
    /// The air between the droplets.
    pub atmosphere: Atmosphere,
    /// What lies behind everything.
    pub background: Background,
    /// How the spectrum is sampled; `None` lets the accuracy decide.
    pub spectral_mode: Option<SpectralMode>,
    /// Effects that the scene switches; others are `auto`. What `--effects` switches is not in it.
    pub effects: BTreeMap<Effect, Switch>,
    /// Accuracy target and knobs.
    pub accuracy: Accuracy,
    /// The picture.
    pub image: ImageSettings,
}

/// `droplets.*`.
#[derive(Clone, Debug, PartialEq)]
pub struct DropletSettings {
    /// The class of droplets that name nothing of their own.
    pub class: DropletClass,
    /// `droplets.materials`: what `_MATERIAL` indexes.
    pub materials: Vec<Material>,
    /// `droplets.size_bins`: `auto` (`None`) or a count per class.
    pub size_bins: Option<usize>,
}

/// `sun.*`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SunSettings {
    /// Spectrum in `bands` mode.
    pub spectrum: SunSpectrum,
    /// Irradiance of the brightest sun in `mono` and `rgb`.
    pub irradiance: f64,
    /// Angular diameter, degrees.
    pub angular_diameter_deg: f64,
}

/// `atmosphere.*`.
#[derive(Clone, Debug, PartialEq)]
pub struct Atmosphere {
    /// Scattering coefficient, 1/m.
    pub scattering_per_m: f64,
    /// Absorption coefficient, 1/m.
    pub absorption_per_m: f64,
    /// Phase function of the air.
    pub phase: AirPhase,
    /// Radius of the ball of air about the camera, m.
    pub depth_m: f64,
    /// Longest march step, m.
    pub step_m: f64,
    /// Whether direct sunlight is scattered by the air.
    pub sunlight: bool,
}

/// The air's phase function.
#[derive(Clone, Debug, PartialEq)]
pub enum AirPhase {
    /// The same in every direction.
    Isotropic,
    /// Molecules.
    Rayleigh,
    /// Henyey-Greenstein with the given asymmetry.
    HenyeyGreenstein { g: f64 },
    /// A Mie haze: water droplets of the given distribution (`mie:DISTRIBUTION`).
    Haze(SizeDistribution),
}

/// `background.*`.
#[derive(Clone, Debug, PartialEq)]
pub struct Background {
    /// Radiance in output units.
    pub radiance: [f64; 3],
    /// A lat-long EXR, already resolved to a file that may be read.
    pub image: Option<PathBuf>,
}

/// `accuracy.*`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accuracy {
    /// Target relative error of the picture; `None` where the scene sets none.
    pub target: Option<f64>,
    /// Above this size parameter phase tables are those at the cap.
    pub size_parameter_cap: f64,
    /// Relative error of the glow sum.
    pub glow_tolerance: Option<f64>,
    /// Relative error of phase tables.
    pub angle_tolerance: Option<f64>,
    /// Scattering by less than this angle counts as none, degrees; 0 leaves phase functions whole.
    pub peak_truncation_deg: f64,
}

/// `image.*`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImageSettings {
    /// Width and height in pixels.
    pub resolution: [u32; 2],
}

/// An effect that can be switched.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Effect {
    Direct,
    Multiple,
    Absorption,
    Shadows,
    Airlight,
    Glow,
    AirMultiple,
    Refraction,
    Dispersion,
    Background,
    SunDisc,
}

impl Effect {
    /// All effects with their names, in the order they are reported.
    pub const ALL: [(Effect, &str); 11] = [
        (Effect::Direct, "direct"),
        (Effect::Multiple, "multiple"),
        (Effect::Absorption, "absorption"),
        (Effect::Shadows, "shadows"),
        (Effect::Airlight, "airlight"),
        (Effect::Glow, "glow"),
        (Effect::AirMultiple, "air-multiple"),
        (Effect::Refraction, "refraction"),
        (Effect::Dispersion, "dispersion"),
        (Effect::Background, "background"),
        (Effect::SunDisc, "sun-disc"),
    ];

    /// The name as it is written in settings and flags.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(effect, _)| *effect == self).map_or("", |(_, name)| name)
    }
}

/// What was asked of an effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Switch {
    /// On where it can change the picture.
    #[default]
    Auto,
    /// On.
    On,
    /// Off.
    Off,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            droplets: DropletSettings {
                class: DropletClass {
                    material: Material::Water,
                    phase: PhaseModel::Mie,
                    distribution: SizeDistribution::default(),
                    albedo: None,
                },
                materials: Vec::new(),
                size_bins: None,
            },
            sun: SunSettings { spectrum: SunSpectrum::E490, irradiance: 1.0, angular_diameter_deg: 0.533 },
            atmosphere: Atmosphere {
                scattering_per_m: 0.0,
                absorption_per_m: 0.0,
                phase: AirPhase::HenyeyGreenstein { g: 0.7 },
                depth_m: 10.0,
                step_m: 0.05,
                sunlight: true,
            },
            background: Background { radiance: [0.0; 3], image: None },
            spectral_mode: None,
            effects: BTreeMap::new(),
            accuracy: Accuracy {
                target: None,
                size_parameter_cap: 2e4,
                glow_tolerance: None,
                angle_tolerance: None,
                peak_truncation_deg: 0.0,
            },
            image: ImageSettings { resolution: [640, 360] },
        }
    }
}

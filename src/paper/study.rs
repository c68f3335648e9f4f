//! One figure three ways: pictures, numbers, and what they say of its caption.

use thiserror::Error;

use super::captions::{Verdict, judge};
use super::exact::ExactSphere;
use super::figures::{Figure, INDEX, WAVELENGTHS_NM};
use super::formulas::{Caution, Efficiencies, G, Variant, efficiencies, phase, size_parameter};
use super::picture::{Colours, Setting};
use super::{exact_column, picture};
use crate::image::{Attribute, Picture};
use crate::mie::MieError;
use crate::scene::SceneError;
use crate::transport::PrepareError;

/// A figure could not be made.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PaperError {
    /// Its scene is broken.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// Its scene has no droplet.
    #[error("{0}: there is no droplet in it; take the scene that comes with the program")]
    NoDroplet(String),
    /// The exact numbers could not be computed.
    #[error(transparent)]
    Mie(#[from] MieError),
    /// Its scene cannot be prepared.
    #[error(transparent)]
    Prepare(#[from] PrepareError),
}

/// A way to make a figure: a column of the contact sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// The paper's code.
    Listing,
    /// The paper's equations.
    Equations,
    /// Exact coefficients and phase function, through the ordinary program.
    Exact,
}

impl Method {
    /// All of them, from left to right.
    pub const ALL: [Self; 3] = [Self::Listing, Self::Equations, Self::Exact];

    /// The name in files and tables.
    pub fn name(self) -> &'static str {
        ["listing", "equations", "exact"][self as usize]
    }
}

/// What a method says of the droplet in one colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Numbers {
    /// Size parameter.
    pub x: f64,
    /// Scattering efficiency.
    pub q_sca: f64,
    /// Absorption efficiency.
    pub q_abs: f64,
    /// Mean cosine of the scattering angle.
    pub g: f64,
    /// p(0) / p(180 degrees).
    pub forward_over_backward: f64,
    /// Light into the forward hemisphere over light into the backward one.
    pub hemispheres: f64,
}

/// A figure by one method.
#[derive(Clone, Debug)]
pub struct Column {
    /// The method.
    pub method: Method,
    /// Red, green, blue.
    pub numbers: [Numbers; 3],
    /// The picture.
    pub picture: Picture,
    /// The effects that it shows: `as published`, or names of the program's.
    pub effects: String,
}

/// A figure, three ways.
#[derive(Clone, Debug)]
pub struct Study {
    /// The figure.
    pub figure: Figure,
    /// One per method, in the order of [`Method::ALL`].
    pub columns: [Column; 3],
    /// Whether its caption is true.
    pub verdict: Verdict,
}

/// Makes a figure three ways; `resolution`, in pixels, wins over its scene's.
///
/// # Errors
/// When the scene that comes with the program is broken.
pub fn make(figure: &Figure, resolution: Option<[u32; 2]>) -> Result<Study, PaperError> {
    let d = figure.diameter_nm;
    let scene = figure.scene(resolution)?;
    let setting = Setting::of(&scene).ok_or_else(|| PaperError::NoDroplet(figure.scene_path()))?;
    let [red, green, blue] = WAVELENGTHS_NM.map(|wavelength| ExactSphere::new(d, wavelength, INDEX));
    let exact = [red?, green?, blue?];
    let verdict = judge(figure.claim, &exact)?;
    let [red, green, blue] = exact.each_ref().map(exact_numbers);
    let (picture, effects) = exact_column::draw(scene)?;
    let exact = column(figure, Method::Exact, [red?, green?, blue?], picture, effects.join(" "));
    let columns = [published(figure, Method::Listing, &setting), published(figure, Method::Equations, &setting), exact];
    Ok(Study { figure: *figure, columns, verdict })
}

/// A figure by one of the paper's own ways.
fn published(figure: &Figure, method: Method, setting: &Setting) -> Column {
    let variant = if method == Method::Listing { Variant::Listing } else { Variant::Equations };
    let of = |wavelength: f64| {
        efficiencies(variant, Caution::BeforeNan, size_parameter(figure.diameter_nm, wavelength), INDEX)
    };
    let efficiencies = WAVELENGTHS_NM.map(of);
    let numbers = [0, 1, 2].map(|c| published_numbers(figure.diameter_nm, WAVELENGTHS_NM[c], &efficiencies[c]));
    let picture = picture::draw(setting, &Colours { efficiencies, index: [INDEX.re; 3] });
    column(figure, method, numbers, picture, "as published".into())
}

/// The fixed phase function's numbers stand beside the efficiencies.
fn published_numbers(diameter_nm: f64, wavelength_nm: f64, q: &Efficiencies) -> Numbers {
    // The integral of P over mu, (1-g^2)/g / sqrt(1 + g^2 - 2 g mu), between the bounds.
    let integral = |mu: f64| (1.0 - G * G) / G / (1.0 + G * G - 2.0 * G * mu).sqrt();
    Numbers {
        x: size_parameter(diameter_nm, wavelength_nm),
        q_sca: q.q_sca,
        q_abs: q.q_abs,
        g: G,
        forward_over_backward: phase(1.0) / phase(-1.0),
        hemispheres: (integral(1.0) - integral(0.0)) / (integral(0.0) - integral(-1.0)),
    }
}

fn exact_numbers(sphere: &ExactSphere) -> Result<Numbers, MieError> {
    Ok(Numbers {
        x: sphere.x(),
        q_sca: sphere.q_sca(),
        q_abs: sphere.q_abs(),
        g: sphere.g(),
        forward_over_backward: sphere.forward_over_backward()?,
        hemispheres: sphere.hemispheres()?,
    })
}

/// Records with the picture what it shows.
fn column(figure: &Figure, method: Method, numbers: [Numbers; 3], mut picture: Picture, effects: String) -> Column {
    let text = |value: String| Attribute::Text(value);
    picture.record("software", text(format!("mie-cloud {}", env!("CARGO_PKG_VERSION"))));
    picture.record("mieCloud:scene", text(figure.scene_path()));
    picture.record("mieCloud:column", text(method.name().into()));
    picture.record("mieCloud:effects", text(effects.clone()));
    picture.record("mieCloud:diameterNm", Attribute::Double(figure.diameter_nm));
    Column { method, numbers, picture, effects }
}

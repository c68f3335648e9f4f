//! The ten figures: which droplets they show, in which light, and what their captions say.

use num_complex::Complex64;

use super::captions::Claim;
use crate::scene::{LoadOptions, SceneError, load_embedded, model::Scene};

/// Red, green, blue: the light's wavelengths, nm.
pub const WAVELENGTHS_NM: [f64; 3] = [650.0, 550.0, 450.0];

/// One of the three colours; as a number the place in every array of three.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    Red,
    Green,
    Blue,
}

impl Channel {
    /// All of them, in order.
    pub const ALL: [Self; 3] = [Self::Red, Self::Green, Self::Blue];

    /// Its name.
    pub fn name(self) -> &'static str {
        ["red", "green", "blue"][self as usize]
    }
}

/// Refractive index of water in every colour.
pub const INDEX: Complex64 = Complex64::new(1.33, 0.0);

/// One figure of the paper.
#[derive(Clone, Copy, Debug)]
pub struct Figure {
    /// Its number here, 1 to 10.
    pub number: usize,
    /// The droplet's diameter, nm.
    pub diameter_nm: f64,
    /// What its caption says, in short; `None` where no claim is on record.
    pub claim: Option<Claim>,
    /// The scene, glTF.
    gltf: &'static str,
}

impl Figure {
    /// The scene of the figure, from `scenes/paper`: the droplet drawn large, light, air and camera. `resolution`, in
    /// pixels, each at least 1, wins over the scene's own.
    ///
    /// # Errors
    /// When the scene that was built in is broken.
    pub fn scene(&self, resolution: Option<[u32; 2]>) -> Result<Scene, SceneError> {
        let options = LoadOptions { resolution, ..LoadOptions::default() };
        load_embedded(&self.scene_path(), self.gltf.as_bytes(), &options)
    }

    /// Where the scene lies in the project's folder.
    pub fn scene_path(&self) -> String {
        format!("scenes/paper/fig{:02}.gltf", self.number)
    }
}

/// The figures in the paper's order.
#[rustfmt::skip]
pub const FIGURES: [Figure; 10] = [
    Figure { number: 1, diameter_nm: 201.5015, claim: Some(Claim::NarrowForwardBeam), gltf: include_str!("../../scenes/paper/fig01.gltf") },
    Figure { number: 2, diameter_nm: 312.012, claim: None, gltf: include_str!("../../scenes/paper/fig02.gltf") },
    Figure { number: 3, diameter_nm: 312.6126, claim: Some(Claim::Strong(Channel::Blue)), gltf: include_str!("../../scenes/paper/fig03.gltf") },
    Figure { number: 4, diameter_nm: 313.2132, claim: Some(Claim::Evenly(Channel::Blue)), gltf: include_str!("../../scenes/paper/fig04.gltf") },
    Figure { number: 5, diameter_nm: 334.5345, claim: None, gltf: include_str!("../../scenes/paper/fig05.gltf") },
    Figure { number: 6, diameter_nm: 345.6456, claim: None, gltf: include_str!("../../scenes/paper/fig06.gltf") },
    Figure { number: 7, diameter_nm: 346.5465, claim: Some(Claim::Evenly(Channel::Green)), gltf: include_str!("../../scenes/paper/fig07.gltf") },
    Figure { number: 8, diameter_nm: 370.027, claim: Some(Claim::Over { more: Channel::Blue, less: Channel::Red }), gltf: include_str!("../../scenes/paper/fig08.gltf") },
    Figure { number: 9, diameter_nm: 3472.6727, claim: Some(Claim::Under { less: Channel::Green, more: Channel::Red }), gltf: include_str!("../../scenes/paper/fig09.gltf") },
    Figure { number: 10, diameter_nm: 437.5375, claim: Some(Claim::Evenly(Channel::Red)), gltf: include_str!("../../scenes/paper/fig10.gltf") },
];

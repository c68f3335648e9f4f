//! One table: the phase function of a cloud of many sizes, as CSV that a scene reads (`droplets.phase = table:FILE.csv`).
//!
//! `cargo run --release --example phase_table > fog.csv`

use std::error::Error;

use mie_cloud::optics::distribution::SizeDistribution;
use mie_cloud::optics::material::Material;
use mie_cloud::study::Scatterer;

pub fn main() -> Result<(), Box<dyn Error>> {
    let no_files = |name: &str| Err(format!("{name} is not needed here"));
    let fog = SizeDistribution::parse("gamma:reff=6um,veff=0.1", &no_files)?;
    let wavelength_m = 550e-9;
    let cloud = Scatterer::cloud(fog, wavelength_m, Material::Water.index(wavelength_m)?)?;

    // Fine steps where the forward peak is.
    let near = (0..200).map(|i| 0.05 * f64::from(i));
    let far = (0..=340).map(|i| 10.0 + 0.5 * f64::from(i));
    let angles_deg: Vec<f64> = near.chain(far).collect();
    let theta_rad: Vec<f64> = angles_deg.iter().map(|angle| angle.to_radians()).collect();
    let scale = cloud.phase_scale().ok_or("nothing is scattered")?;
    println!("angle_deg,phase_per_sr");
    for (angle, matrix) in angles_deg.iter().zip(cloud.matrices(&theta_rad)?) {
        println!("{angle},{:e}", scale * matrix.s11);
    }
    Ok(())
}

//! One sphere: what a water droplet of 10 um does to green light, and where its fogbow stands.
//!
//! `cargo run --release --example one_sphere`

use std::error::Error;
use std::f64::consts::PI;

use mie_cloud::mie::Series;
use mie_cloud::optics::material::Material;

pub fn main() -> Result<(), Box<dyn Error>> {
    let (radius_m, wavelength_m) = (10e-6, 550e-9);
    let index = Material::Water.index(wavelength_m)?;
    let sphere = Series::new(2.0 * PI * radius_m / wavelength_m, index)?;
    let q = sphere.efficiencies();
    println!("size parameter {:.2}, index {:.4} + {:.1e} i", sphere.x, index.re, index.im);
    println!("Q_ext {:.5}, Q_sca {:.5}, g {:.5}", q.q_ext, q.q_sca, q.g);

    let angles_deg: Vec<f64> = (0..=1800).map(|tenth| f64::from(tenth) / 10.0).collect();
    let theta_rad: Vec<f64> = angles_deg.iter().map(|angle| angle.to_radians()).collect();
    let mut intensity = vec![0.0; theta_rad.len()];
    sphere.intensities(&theta_rad, &mut intensity)?;
    // So that it integrates to 1 over the sphere, sr^-1 (theory (19)).
    let scale = 1.0 / (PI * sphere.x * sphere.x * q.q_sca);
    for at in [0, 900, 1800] {
        println!("phase function at {:3} deg: {:.4e} /sr", angles_deg[at], scale * intensity[at]);
    }
    let bow = (1300..1600).max_by(|a, b| intensity[*a].total_cmp(&intensity[*b])).unwrap_or(1300);
    println!("fogbow {:.1} deg from the point opposite the sun", 180.0 - angles_deg[bow]);
    Ok(())
}

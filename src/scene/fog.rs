//! Turns fog that is given by mass or extinction into numbers of droplets, once the optics of its droplets are known.

use std::collections::HashMap;

use super::model::{FogDensity, Scene};
use crate::optics::DropletClass;

/// What fog may be measured by, other than the number of its droplets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Measure {
    /// Grams of condensed matter.
    MassG,
    /// Extinction cross section at 550 nm, m^2.
    ExtinctionM2,
}

/// Droplets of one kind, by class index and bits of their own radius (0 for the class's distribution), and what is asked of them.
type Asked = (u16, u32, Measure);

impl Scene {
    /// Fills balls and boxes of fog: afterwards every parcel has its count and every box a number per volume.
    ///
    /// `of_one` says how much one droplet has on average, and is asked once for each class, own radius (m, `None` for the class's
    /// distribution) and measure that occurs.
    ///
    /// # Errors
    /// Those of `of_one`; the scene is then filled in part.
    pub fn fill_fog<E>(
        &mut self,
        mut of_one: impl FnMut(&DropletClass, Option<f64>, Measure) -> Result<f64, E>,
    ) -> Result<(), E> {
        let mut known: HashMap<Asked, f64> = HashMap::new();
        let classes = &self.classes;
        let mut number_per_m3 = |density: FogDensity, class: u16, radius_m: f32| {
            let (amount, measure) = match density {
                FogDensity::NumberPerM3(number) => return Ok(number),
                FogDensity::LiquidWaterGPerM3(mass_g) => (mass_g, Measure::MassG),
                FogDensity::ExtinctionPerM(extinction_m2) => (extinction_m2, Measure::ExtinctionM2),
            };
            let asked = (class, radius_m.to_bits(), measure);
            if let Some(of_one) = known.get(&asked) {
                return Ok(amount / of_one);
            }
            let own_m = (radius_m > 0.0).then_some(f64::from(radius_m));
            let of_one = of_one(&classes[usize::from(class)], own_m, measure)?;
            known.insert(asked, of_one);
            Ok(amount / of_one)
        };
        for balls in std::mem::take(&mut self.fog_balls) {
            for particle in &mut self.particles[balls.particles] {
                let number = number_per_m3(balls.density, particle.class, particle.droplet_radius_m)?;
                particle.count = (number * ball_volume_m3(f64::from(particle.radius_m))) as f32;
            }
        }
        for fog_box in &mut self.fog_boxes {
            let radius_m = fog_box.droplet_radius_m.unwrap_or(0.0) as f32;
            let number = number_per_m3(fog_box.density, fog_box.class, radius_m)?;
            fog_box.density = FogDensity::NumberPerM3(number);
        }
        Ok(())
    }
}

/// 4/3 pi R^3.
pub fn ball_volume_m3(radius_m: f64) -> f64 {
    4.0 / 3.0 * std::f64::consts::PI * radius_m.powi(3)
}

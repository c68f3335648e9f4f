//! Turns fog that is given by mass or extinction into numbers of droplets, once the optics of its droplets are known.

use std::collections::HashMap;

use super::model::{FogDensity, Scene};
use crate::optics::DropletClass;

/// What one droplet of a class contributes, averaged over its distribution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PerDroplet {
    /// Mass, g.
    pub mass_g: f64,
    /// Extinction cross section at 550 nm, m^2.
    pub extinction_m2: f64,
}

impl FogDensity {
    /// Droplets per cubic metre, given what one of them contributes.
    pub fn number_per_m3(self, droplet: PerDroplet) -> f64 {
        match self {
            FogDensity::NumberPerM3(number) => number,
            FogDensity::LiquidWaterGPerM3(mass) => mass / droplet.mass_g,
            FogDensity::ExtinctionPerM(extinction) => extinction / droplet.extinction_m2,
        }
    }
}

/// Droplets of one kind: class index and bits of their own radius, 0 for the class's distribution.
type KindOfDroplet = (u16, u32);

impl Scene {
    /// Fills balls and boxes of fog: afterwards every parcel has its count and every box a number per volume.
    ///
    /// `per_droplet` is asked once for each class and own radius (m, `None` for the class's distribution) that occurs.
    ///
    /// # Errors
    /// Those of `per_droplet`; the scene is then filled in part.
    pub fn fill_fog<E>(
        &mut self,
        mut per_droplet: impl FnMut(&DropletClass, Option<f64>) -> Result<PerDroplet, E>,
    ) -> Result<(), E> {
        let mut known: HashMap<KindOfDroplet, PerDroplet> = HashMap::new();
        let classes = &self.classes;
        let mut look_up = |class: u16, radius_m: f32| match known.get(&(class, radius_m.to_bits())) {
            Some(droplet) => Ok(*droplet),
            None => {
                let own = (radius_m > 0.0).then_some(f64::from(radius_m));
                let droplet = per_droplet(&classes[usize::from(class)], own)?;
                known.insert((class, radius_m.to_bits()), droplet);
                Ok(droplet)
            }
        };
        for balls in std::mem::take(&mut self.fog_balls) {
            for particle in &mut self.particles[balls.particles] {
                let number = balls.density.number_per_m3(look_up(particle.class, particle.droplet_radius_m)?);
                particle.count = (number * ball_volume_m3(f64::from(particle.radius_m))) as f32;
            }
        }
        for fog_box in &mut self.fog_boxes {
            let radius_m = fog_box.droplet_radius_m.unwrap_or(0.0) as f32;
            let number = fog_box.density.number_per_m3(look_up(fog_box.class, radius_m)?);
            fog_box.density = FogDensity::NumberPerM3(number);
        }
        Ok(())
    }
}

/// 4/3 pi R^3.
pub fn ball_volume_m3(radius_m: f64) -> f64 {
    4.0 / 3.0 * std::f64::consts::PI * radius_m.powi(3)
}

//! The sizes of a scene's droplets, class by class, and how many bins they fall into: what `inspect` tells of them.

use std::f64::consts::TAU;

use super::inspect_histogram::{Histogram, Tally};
use crate::optics::bins::{BinPlan, DropletSize};
use crate::scene::model::{Particle, Scene};
use crate::units::short::length;

/// The sizes of the droplets of one class.
pub struct ClassSizes {
    /// Droplets and parcels of the class.
    pub n_particles: usize,
    /// Fog boxes of the class.
    pub n_fog_boxes: usize,
    /// Size bins that a render sorts them into.
    pub n_bins: usize,
    /// Radii of their own, each particle and box counted once; none where all have the class's distribution.
    pub own: Option<Histogram>,
    /// The class's distribution, if some have it.
    pub law: Option<Histogram>,
}

impl ClassSizes {
    /// Of every class of a scene, in their order.
    pub fn of(scene: &Scene) -> Vec<Self> {
        let mut tallies: Vec<Tally> = scene.classes.iter().map(|_| Tally::default()).collect();
        // A histogram has to know its ends before it can be filled.
        bodies(scene).for_each(|(class, radius_m)| tallies[class].extend(radius_m));
        bodies(scene).for_each(|(class, radius_m)| tallies[class].count(radius_m));
        let mut sizes: Vec<Self> = scene
            .classes
            .iter()
            .zip(tallies)
            .map(|(class, tally)| Self {
                n_particles: 0,
                n_fog_boxes: 0,
                n_bins: 0,
                law: tally.follows_law.then(|| Histogram::of_law(&class.distribution)),
                own: tally.finish(),
            })
            .collect();
        scene.particles.iter().for_each(|particle| sizes[usize::from(particle.class)].n_particles += 1);
        scene.fog_boxes.iter().for_each(|fog| sizes[usize::from(fog.class)].n_fog_boxes += 1);
        bin_plan(scene).bins.iter().for_each(|bin| sizes[usize::from(bin.class)].n_bins += 1);
        sizes
    }

    /// Whether any droplets are of the class.
    pub fn is_used(&self) -> bool {
        self.n_particles + self.n_fog_boxes > 0
    }

    /// Their sizes in words; none where there are no droplets.
    pub fn words(&self, distribution: &str) -> Option<String> {
        let own = self.own.as_ref().map(|own| match [own.least_m, own.greatest_m].map(length) {
            [least, most] if least == most => format!("radius {least}"),
            [least, most] => format!("radii {least} to {most}"),
        });
        match (own, &self.law) {
            (Some(own), Some(_)) => Some(format!("{own} and {distribution}")),
            (Some(own), None) => Some(own),
            (None, Some(_)) => Some(distribution.into()),
            (None, None) => None,
        }
    }

    /// Own radii first, then the distribution.
    pub fn histograms(&self) -> impl Iterator<Item = &Histogram> {
        self.own.iter().chain(&self.law)
    }
}

/// Least and largest size parameter 2 pi r / wavelength of all droplets at these wavelengths (m).
pub fn size_parameters(sizes: &[ClassSizes], wavelengths_m: &[f64]) -> Option<[f64; 2]> {
    let (shortest_m, longest_m) =
        wavelengths_m.iter().fold((f64::INFINITY, 0.0_f64), |(least, most), l_m| (least.min(*l_m), most.max(*l_m)));
    let x = |histogram: &Histogram| [TAU * histogram.least_m / longest_m, TAU * histogram.greatest_m / shortest_m];
    sizes.iter().flat_map(ClassSizes::histograms).map(x).reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
}

/// Class and own radius (m) of every particle and fog box.
fn bodies(scene: &Scene) -> impl Iterator<Item = (usize, Option<f64>)> {
    let particles = scene.particles.iter().map(|particle| (usize::from(particle.class), particle.own_radius_m()));
    particles.chain(scene.fog_boxes.iter().map(|fog| (usize::from(fog.class), fog.droplet_radius_m)))
}

/// The bins of a render: their number does not depend on how many droplets a parcel holds, which is not known of all yet.
fn bin_plan(scene: &Scene) -> BinPlan {
    let size = |(class, radius_m): (usize, Option<f64>)| DropletSize {
        class: class as u16,
        radius_m: radius_m.unwrap_or(0.0) as f32,
        count: 1.0,
    };
    BinPlan::new(&scene.classes, bodies(scene).map(size), scene.settings.droplets.size_bins)
}

/// Smallest and largest drawn radius, m.
pub fn drawn_radii_m(scene: &Scene) -> Option<(f32, f32)> {
    let drawn = |particle: &Particle| (particle.radius_m, particle.radius_m);
    scene.particles.iter().map(drawn).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
}

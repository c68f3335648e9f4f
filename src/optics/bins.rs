//! Which size bins a scene needs, and which one a droplet belongs to.
//!
//! A class with few distinct radii has a bin for each, exact. Otherwise its radii are divided evenly in ln r, and a bin
//! averages over the radii of the scene that fall into it, known by a histogram.

use std::sync::Arc;

use super::DropletClass;
use super::distribution::{Shape, SizeDistribution};

/// Up to this many distinct radii each have their own bin.
pub const EXACT_RADII: usize = 64;

/// Bins of a class whose radii are many, unless a count is given: at most this many, and no narrower than `BIN_RATIO`.
pub const MAX_AUTO_BINS: usize = 48;

/// Ratio of the radii at the ends of an automatic bin. Across 10 % the position of bows and rings moves by a tenth of
/// their distance from the axis at most, the width that the distributions of real fogs (v_eff 0.1, 30 %) blur them by
/// three times over.
const BIN_RATIO: f64 = 1.1;

/// Histogram parts per octave of the radius, a power of two: 1.6 % at most, a sixth of a bin.
const PARTS_PER_OCTAVE_BITS: u32 = 6;

/// Bits of an f32 below those that number the histogram's parts.
const SHIFT: u32 = 23 - PARTS_PER_OCTAVE_BITS;

/// One droplet, or parcel, as the bins see it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DropletSize {
    /// Index of its class.
    pub class: u16,
    /// The droplets' own radius, m; 0 takes the class's distribution.
    pub radius_m: f32,
    /// Number of droplets.
    pub count: f64,
}

/// A size bin: a class and the sizes that it stands for.
#[derive(Clone, Debug, PartialEq)]
pub struct SizeBin {
    /// Index of the class.
    pub class: u16,
    /// Its sizes: one radius, the class's distribution, or the scene's own radii in a range.
    pub distribution: SizeDistribution,
}

impl SizeBin {
    /// Whether the bin is one slice of the sizes of a scene.
    pub(super) fn is_slice(&self) -> bool {
        matches!(&self.distribution.shape, Shape::Table { name, .. } if name == SLICE_NAME)
    }
}

/// Name of the distributions that are slices of a scene's own sizes.
const SLICE_NAME: &str = "sizes of the scene";

/// The bins of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BinPlan {
    /// The bins.
    pub bins: Vec<SizeBin>,
    classes: Vec<ClassBins>,
}

/// How the radii of one class find their bin.
#[derive(Clone, Debug, Default, PartialEq)]
struct ClassBins {
    distribution: u32,
    radii: Lookup,
}

#[derive(Clone, Debug, Default, PartialEq)]
enum Lookup {
    #[default]
    None,
    /// Bits of the radii, increasing, whose bins follow each other from `first`.
    Exact { bits: Vec<u32>, first: u32 },
    /// The bin of each part of the histogram from `first_part` on.
    Parts { first_part: u32, bins: Vec<u32> },
}

impl BinPlan {
    /// Plans the bins for the droplets of a scene; `count` is the number of bins per class, `None` chooses.
    ///
    /// One pass over the droplets and 128 KiB per class, however many there are. Droplets of unknown classes are
    /// ignored; radii must be finite and not negative.
    pub fn new(
        classes: &[DropletClass],
        droplets: impl IntoIterator<Item = DropletSize>,
        count: Option<usize>,
    ) -> Self {
        let mut tallies: Vec<Tally> = classes.iter().map(|_| Tally::default()).collect();
        for droplet in droplets {
            if let Some(tally) = tallies.get_mut(usize::from(droplet.class)) {
                tally.add(droplet);
            }
        }
        let mut plan = Self::default();
        for (class, (tally, droplet_class)) in tallies.iter().zip(classes).enumerate() {
            plan.add_class(class as u16, droplet_class, tally, count);
        }
        plan
    }

    /// One bin for the distribution of one class, index 0: for a haze.
    pub fn of_distribution(class: &DropletClass) -> Self {
        let droplet = DropletSize { class: 0, radius_m: 0.0, count: 1.0 };
        Self::new(std::slice::from_ref(class), [droplet], None)
    }

    fn add_class(&mut self, class: u16, droplet_class: &DropletClass, tally: &Tally, count: Option<usize>) {
        let mut found = ClassBins::default();
        if tally.uses_distribution {
            found.distribution = self.push(class, droplet_class.distribution.clone());
        }
        if let Some(radii) = tally.exact_radii().filter(|radii| radii.len() <= count.unwrap_or(EXACT_RADII)) {
            let first = self.bins.len() as u32;
            for bits in &radii {
                self.push(class, one_radius(f32::from_bits(*bits)));
            }
            found.radii = if radii.is_empty() { Lookup::None } else { Lookup::Exact { bits: radii, first } };
        } else {
            found.radii = self.add_histogram(class, tally, count);
        }
        self.classes.push(found);
    }

    /// Divides the histogram of a class evenly in ln r; bins without droplets are left out.
    fn add_histogram(&mut self, class: u16, tally: &Tally, count: Option<usize>) -> Lookup {
        let used: Vec<usize> = (0..tally.parts.len()).filter(|i| tally.parts[*i] > 0.0).collect();
        let (Some(first), Some(last)) = (used.first().copied(), used.last().copied()) else { return Lookup::None };
        let (low, high) = (part_start_m(first).ln(), part_start_m(last + 1).ln());
        let auto = (((high - low) / BIN_RATIO.ln()).ceil() as usize).clamp(1, MAX_AUTO_BINS);
        let count = count.unwrap_or(auto).max(1);
        let bin_of_part = |part: usize| {
            let middle = 0.5 * (part_start_m(part) + part_start_m(part + 1));
            (((middle.ln() - low) / (high - low) * count as f64) as usize).min(count - 1)
        };
        let mut bins = vec![0; last + 1 - first];
        let mut start = 0;
        while start < used.len() {
            let bin = bin_of_part(used[start]);
            let end = start + used[start..].iter().take_while(|part| bin_of_part(**part) == bin).count();
            let index = self.push(class, tally.distribution(&used[start..end]));
            used[start..end].iter().for_each(|part| bins[part - first] = index);
            start = end;
        }
        Lookup::Parts { first_part: first as u32, bins }
    }

    fn push(&mut self, class: u16, distribution: SizeDistribution) -> u32 {
        self.bins.push(SizeBin { class, distribution });
        self.bins.len() as u32 - 1
    }

    /// The bin of a droplet of a class; a radius of 0 m means the class's distribution.
    ///
    /// For droplets that the plan was made from; others get a bin that exists but not one that fits.
    pub fn bin_of(&self, class: u16, radius_m: f32) -> u32 {
        let Some(found) = self.classes.get(usize::from(class)) else { return 0 };
        if radius_m == 0.0 {
            return found.distribution;
        }
        match &found.radii {
            Lookup::None => found.distribution,
            Lookup::Exact { bits, first } => {
                let place = bits.partition_point(|known| *known < radius_m.to_bits());
                first + place.min(bits.len() - 1) as u32
            }
            Lookup::Parts { first_part, bins } => {
                let part = (radius_m.to_bits() >> SHIFT).saturating_sub(*first_part) as usize;
                bins[part.min(bins.len() - 1)]
            }
        }
    }
}

/// What one pass learns about the droplets of a class.
#[derive(Clone, Debug, Default)]
struct Tally {
    uses_distribution: bool,
    /// Bits of the distinct radii, increasing, as long as they are few; one more than `EXACT_RADII` means many.
    distinct: Vec<u32>,
    /// Droplets per part of the histogram; allocated with the first radius.
    parts: Vec<f64>,
}

impl Tally {
    fn add(&mut self, droplet: DropletSize) {
        if droplet.radius_m == 0.0 {
            self.uses_distribution = true;
            return;
        }
        let bits = droplet.radius_m.to_bits();
        if self.distinct.len() <= EXACT_RADII
            && let Err(place) = self.distinct.binary_search(&bits)
        {
            self.distinct.insert(place, bits);
        }
        if self.parts.is_empty() {
            self.parts = vec![0.0; 1 << (31 - SHIFT)];
        }
        if let Some(part) = self.parts.get_mut((bits >> SHIFT) as usize) {
            *part += droplet.count;
        }
    }

    fn exact_radii(&self) -> Option<Vec<u32>> {
        (self.distinct.len() <= EXACT_RADII).then(|| self.distinct.clone())
    }

    /// The density of the scene's radii over some parts of the histogram, linear between their middles.
    fn distribution(&self, parts: &[usize]) -> SizeDistribution {
        let edge = |part: usize| part_start_m(part);
        let density = |part: &usize| self.parts[*part] / (edge(part + 1) - edge(*part));
        let (first, last) = (parts[0], parts[parts.len() - 1]);
        let (mut r_m, mut dn_dr) = (vec![edge(first)], vec![density(&first)]);
        for part in first..=last {
            r_m.push(0.5 * (edge(part) + edge(part + 1)));
            dn_dr.push(density(&part));
        }
        r_m.push(edge(last + 1));
        dn_dr.push(density(&last));
        let (r_min_m, r_max_m) = (r_m[0], r_m[r_m.len() - 1]);
        let shape = Shape::Table { name: SLICE_NAME.into(), r_m: Arc::from(r_m), dn_dr: Arc::from(dn_dr) };
        SizeDistribution { shape, r_min_m, r_max_m }
    }
}

/// The radius at which a part of the histogram begins, m.
fn part_start_m(part: usize) -> f64 {
    f64::from(f32::from_bits((part as u32) << SHIFT))
}

fn one_radius(radius_m: f32) -> SizeDistribution {
    let r_m = shortest_f64(radius_m);
    SizeDistribution { shape: Shape::Mono { r_m }, r_min_m: r_m, r_max_m: r_m }
}

/// The f64 that prints like the f32: 5e-6 rather than 4.999999873689376e-6, which is what was written in the scene.
fn shortest_f64(value: f32) -> f64 {
    value.to_string().parse().unwrap_or(f64::from(value))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::material::Material;
    use crate::optics::phase_model::PhaseModel;

    fn class() -> DropletClass {
        DropletClass {
            material: Material::Water,
            phase: PhaseModel::Mie,
            distribution: SizeDistribution::default(),
            albedo: None,
        }
    }

    fn droplets(radii_um: impl IntoIterator<Item = f64>) -> Vec<DropletSize> {
        let droplet = |um: f64| DropletSize { class: 0, radius_m: (um * 1e-6) as f32, count: 1.0 };
        radii_um.into_iter().map(droplet).collect()
    }

    #[test]
    fn few_radii_are_exact() {
        let all = droplets([5.0, 3.0, 5.0, 20.0]);
        let plan = BinPlan::new(&[class()], all.clone(), None);
        let radii: Vec<f64> = plan.bins.iter().map(|bin| bin.distribution.r_min_m).collect();
        assert_eq!(radii, [3e-6, 5e-6, 20e-6]);
        let bins: Vec<u32> = all.iter().map(|droplet| plan.bin_of(0, droplet.radius_m)).collect();
        assert_eq!(bins, [1, 0, 1, 2]);
    }

    #[test]
    fn many_radii_share_narrow_bins() {
        let radii = (0..10_000).map(|i| 2.0 * 10f64.powf(f64::from(i) / 10_000.0));
        let all = droplets(radii);
        let plan = BinPlan::new(&[class()], all.clone(), None);
        assert!((20..=30).contains(&plan.bins.len()), "{}", plan.bins.len());
        for droplet in all {
            let bin = &plan.bins[plan.bin_of(0, droplet.radius_m) as usize].distribution;
            let r_m = f64::from(droplet.radius_m);
            assert!(bin.r_min_m <= r_m && r_m <= bin.r_max_m, "{r_m}");
            assert!(bin.r_max_m / bin.r_min_m < 1.13);
        }
    }

    #[test]
    fn a_count_is_obeyed_and_bins_follow_the_scenes_radii() {
        // All droplets but a few are near 4 um.
        let radii = (0..1000).map(|i| 4.0 + 1e-4 * f64::from(i)).chain((0..100).map(|i| 4.0 + 0.04 * f64::from(i)));
        let plan = BinPlan::new(&[class()], droplets(radii), Some(1));
        assert_eq!(plan.bins.len(), 1);
        let mean_m = plan.bins[0].distribution.law().moment(1);
        assert!((mean_m - 4.22e-6).abs() < 0.03e-6, "{mean_m}");
    }

    #[test]
    fn distributions_and_classes_have_their_own_bins() {
        let mut all = droplets([5.0, 0.0]);
        all.push(DropletSize { class: 1, ..all[0] });
        let plan = BinPlan::new(&[class(), class()], all, None);
        assert_eq!(plan.bins.len(), 3);
        assert_eq!(plan.bins[plan.bin_of(0, 0.0) as usize].distribution, SizeDistribution::default());
        assert_eq!(plan.bins[plan.bin_of(1, 5e-6) as usize].class, 1);
        assert_eq!(BinPlan::of_distribution(&class()).bins.len(), 1);
        assert_eq!(BinPlan::new(&[class()], [], None).bins.len(), 0);
    }

    #[test]
    fn extreme_radii_find_a_bin() {
        let radii = (0..200).map(|i| 10f64.powf(-3.0 + 0.05 * f64::from(i)));
        let all = droplets(radii);
        let plan = BinPlan::new(&[class()], all.clone(), None);
        assert!(plan.bins.len() <= MAX_AUTO_BINS);
        for droplet in all {
            let bin = &plan.bins[plan.bin_of(0, droplet.radius_m) as usize].distribution;
            assert!(bin.r_min_m <= f64::from(droplet.radius_m) && f64::from(droplet.radius_m) <= bin.r_max_m);
            assert!(bin.law().moment(2) > 0.0);
        }
    }
}

//! Paths divide where they come to brighter places, and are thinned out where they come to darker ones.
//!
//! What a path still brings home is about its weight times the light where it is. Where that has grown beyond a window about
//! what it was at the first collision, the path goes on as several of less weight; where it has fallen below, one stands for
//! several (weight windows: Booth & Hendricks 1984; with an estimate of the light: Vorba & Krivanek 2016); theory (124).

use super::path::survival_of_length;
use super::random::PathRandom;
use super::scratch::Scratch;
use crate::accel::LocalRay;

/// Below this share of what it was at first, a path plays Russian roulette.
const THIN_BELOW: f64 = 0.25;

/// A path goes on as two where it has come to more than this.
const SPLIT_ABOVE: f64 = 2.0;

/// At most so many at once.
const MOST_COPIES: f64 = 16.0;

/// A path divides no further after so many branches.
const MOST_BRANCHES: u32 = 1 << 10;

/// A branch that waits; its numbers by wavelength lie in `Branches::numbers`.
#[derive(Clone, Debug)]
pub(super) struct Offshoot {
    pub ray: LocalRay,
    pub order: u32,
    pub random: PathRandom,
    rarity: f64,
    n_turns: u32,
    surfaces: u32,
    is_refracted: bool,
}

/// The branches of a path that wait.
#[derive(Clone, Debug, Default)]
pub(super) struct Branches {
    waiting: Vec<Offshoot>,
    numbers: Vec<f64>,
    /// How many there have been of this path.
    n_begun: u32,
    /// How many more paths go on from the present collision.
    n_more: u32,
    /// One over the weight times light at the first collision.
    per_first: f64,
}

impl Branches {
    pub fn clear(&mut self) {
        self.waiting.clear();
        self.numbers.clear();
        self.n_begun = 0;
    }
}

/// Whether a path goes on after its `order`th collision, where the guide says how bright it is there; notes into how many it divides.
pub(super) fn goes_on(light: f64, u: f64, order: u32, long: u32, scratch: &mut Scratch) -> bool {
    let Scratch { weight, event, branches, .. } = scratch;
    let largest = weight.iter().zip(&event.sigma).map(|(weight, sigma)| weight * sigma).fold(0.0, f64::max);
    branches.n_more = 0;
    if largest <= 0.0 {
        return false;
    }
    if order == 1 {
        branches.per_first = (largest * light).recip();
    }
    let against_first = largest * light * branches.per_first;
    let survival = (against_first / THIN_BELOW).min(1.0) * survival_of_length(order, long);
    if u >= survival {
        return false;
    }
    if against_first > SPLIT_ABOVE && branches.n_begun < MOST_BRANCHES {
        branches.n_more = against_first.round().min(MOST_COPIES) as u32 - 1;
    }
    weight.iter_mut().for_each(|weight| *weight /= survival);
    true
}

impl Scratch {
    /// Puts aside the copies of a path that is about to fly on from its `order`th collision.
    pub fn divide(&mut self, ray: &LocalRay, order: u32, random: &PathRandom) {
        let Self { branches, weight, density, small_turns, rarity, n_turns, surfaces, is_refracted, .. } = self;
        let n_more = std::mem::take(&mut branches.n_more);
        if n_more == 0 {
            return;
        }
        weight.iter_mut().for_each(|weight| *weight /= f64::from(n_more + 1));
        for copy in 1..=n_more {
            branches.n_begun += 1;
            for numbers in [&*weight, density, small_turns] {
                branches.numbers.extend_from_slice(numbers);
            }
            branches.waiting.push(Offshoot {
                ray: *ray,
                order,
                random: random.branch(order, copy),
                rarity: *rarity,
                n_turns: *n_turns,
                surfaces: *surfaces,
                is_refracted: *is_refracted,
            });
        }
    }

    /// Takes up the branch that was put aside last.
    pub fn take_up(&mut self) -> Option<Offshoot> {
        let Self { branches, weight, density, small_turns, rarity, n_turns, surfaces, is_refracted, .. } = self;
        let branch = branches.waiting.pop()?;
        for numbers in [small_turns, density, weight] {
            let rest = branches.numbers.len() - numbers.len();
            numbers.copy_from_slice(&branches.numbers[rest..]);
            branches.numbers.truncate(rest);
        }
        (*rarity, *n_turns, *surfaces, *is_refracted) =
            (branch.rarity, branch.n_turns, branch.surfaces, branch.is_refracted);
        Some(branch)
    }
}

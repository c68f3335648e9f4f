//! Sums over a run of samples of one pixel, added up in a fixed order.
//!
//! Samples are added to their block, and blocks in pairs, pairs of pairs and so on, wherever two neighbours of one length
//! start at a multiple of twice that length. The sums of 0..64 and of 64..128 then add up to exactly those of 0..128,
//! although floating-point addition depends on the order.

use super::block::block_of;
use super::{Layer, Sample, slot};

/// Sums of one pixel in the making; reused from pixel to pixel.
#[derive(Clone, Debug)]
pub struct Tally {
    layers: Vec<Layer>,
    stride: usize,
    /// Sums of one piece after the other; while a block is open, the last one is its.
    sums: Vec<f64>,
    /// First sample and number of samples of each closed piece.
    pieces: Vec<(u32, u32)>,
    /// The sample that comes next.
    next: u32,
    /// Where the open block began and ends.
    open: Option<(u32, u32)>,
}

impl Tally {
    pub(super) fn new(layers: &[Layer], stride: usize) -> Self {
        Self { layers: layers.to_vec(), stride, sums: Vec::new(), pieces: Vec::new(), next: 0, open: None }
    }

    /// Forgets everything; `first` is the number of the sample that will be added first.
    pub fn start(&mut self, first: u32) {
        self.sums.clear();
        self.pieces.clear();
        (self.next, self.open) = (first, None);
    }

    /// Adds the next sample, and its radiance by wavelength where the film keeps it.
    pub fn add(&mut self, sample: &Sample, spectrum: &[f64]) {
        let end = match self.open {
            Some((_, end)) => end,
            None => {
                let end = block_of(self.next).end;
                self.open = Some((self.next, end));
                self.sums.resize(self.sums.len() + self.stride, 0.0);
                end
            }
        };
        let place = self.sums.len() - self.stride;
        add_sample(&mut self.sums[place..], &self.layers, sample, spectrum);
        self.next = self.next.saturating_add(1);
        if self.next == end {
            self.close();
        }
    }

    /// Adds what was tallied to the sums of a pixel.
    pub(super) fn pour(&mut self, pixel: &mut [f64]) {
        self.close();
        for piece in self.sums.chunks_exact(self.stride) {
            add(pixel, piece);
        }
        self.start(self.next);
    }

    /// Ends the open block, and joins neighbours.
    fn close(&mut self) {
        let Some((first, _)) = self.open.take() else { return };
        let place = self.sums.len() - self.stride;
        end_block(&mut self.sums[place..]);
        self.pieces.push((first, self.next - first));
        while let [.., (first, count), (_, last_count)] = self.pieces[..] {
            if count != last_count || !count.is_power_of_two() || u64::from(first) % (2 * u64::from(count)) != 0 {
                break;
            }
            let last = self.sums.len() - self.stride;
            let (left, right) = self.sums.split_at_mut(last);
            add(&mut left[last - self.stride..], right);
            self.sums.truncate(last);
            self.pieces.truncate(self.pieces.len() - 2);
            self.pieces.push((first, 2 * count));
        }
    }
}

fn add(sums: &mut [f64], others: &[f64]) {
    sums.iter_mut().zip(others).for_each(|(sum, other)| *sum += other);
}

fn add_sample(sums: &mut [f64], layers: &[Layer], sample: &Sample, spectrum: &[f64]) {
    sums[slot::COUNT] += 1.0;
    for c in 0..3 {
        sums[slot::BEAUTY + c] += sample.layers.iter().map(|layer| layer[c]).sum::<f64>();
        sums[slot::TRANSMITTANCE + c] += sample.transmittance[c];
    }
    sums[slot::OPACITY] += sample.opacity;
    sums[slot::DEPTH] += sample.depth_sum_m;
    sums[slot::DEPTH_WEIGHT] += sample.depth_weight;
    let (kept, spectral) = sums[slot::LAYERS..].split_at_mut(3 * layers.len());
    for (sums, layer) in kept.chunks_exact_mut(3).zip(layers) {
        add(sums, &sample.layers[*layer as usize]);
    }
    add(spectral, spectrum);
}

/// Fills in what the scatter between blocks needs (theory (93)).
fn end_block(sums: &mut [f64]) {
    let n = sums[slot::COUNT];
    sums[slot::COUNT_SQUARES] = n * n;
    for c in 0..3 {
        let beauty = sums[slot::BEAUTY + c];
        sums[slot::SQUARES + c] = beauty * beauty;
        sums[slot::PRODUCTS + c] = n * beauty;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(i: u32) -> Sample {
        let mut sample = Sample { opacity: 1.0 / f64::from(i + 1), ..Sample::default() };
        sample.layers[0] = [f64::from(i).sin(), 1.0 / f64::from(i + 3), 1e17 * f64::from(i % 3)];
        sample
    }

    fn sums(from: u32, to: u32) -> Vec<f64> {
        let mut tally = Tally::new(&[Layer::Direct], slot::LAYERS + 3);
        let mut pixel = vec![0.0; slot::LAYERS + 3];
        tally.start(from);
        (from..to).for_each(|i| tally.add(&sample(i), &[]));
        tally.pour(&mut pixel);
        pixel
    }

    /// Expected: aligned runs combine to the very bits of one run over all, in whatever pieces they were made.
    #[test]
    fn aligned_runs_combine_exactly() {
        for cuts in [&[0, 64, 128][..], &[0, 1, 2, 4, 8, 16, 32, 64, 128], &[0, 512, 1024], &[0, 256, 512, 1024]] {
            let mut combined = vec![0.0; slot::LAYERS + 3];
            for run in cuts.windows(2) {
                add(&mut combined, &sums(run[0], run[1]));
            }
            assert_eq!(combined, sums(0, cuts[cuts.len() - 1]), "{cuts:?}");
        }
        let plain: f64 = (0..1024).map(|i| f64::from(i).sin()).sum();
        assert_ne!(sums(0, 1024)[slot::BEAUTY], plain, "the order of addition shows in the last bits");
        assert!((sums(0, 1024)[slot::BEAUTY] - plain).abs() < 1e-12);
    }
}

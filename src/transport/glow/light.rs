//! From the nodes of a cut to light by wavelength.

use super::Glow;
use super::blur::Spot;
use super::eye::Eye;
use super::sources::LEAF;
use super::weigh::{Item, turn};
use crate::accel::Accel;
use crate::transport::lighting::Lighting;

impl Glow {
    /// Adds what an item brings, in the tree's units (times `scale` it is J).
    #[inline(always)]
    pub(super) fn add_light(&self, accel: &Accel, lighting: &Lighting, eye: &Eye, item: &Item, out: &mut [f64]) {
        if item.is_leaf {
            self.add_source(accel, lighting, eye, item, out);
        } else {
            self.add_node(eye, item, out);
        }
    }

    #[inline(always)]
    fn add_node(&self, eye: &Eye, item: &Item, out: &mut [f64]) {
        let n = self.n_wavelengths;
        let (octet, k) = (&self.tree.octets[item.node as usize / LEAF], item.node as usize % LEAF);
        let (row, n_mixes) = (octet.rows as usize + k, self.mixture.rank() - 1);
        let n_colours = self.suns.len() * n;
        let mut is_known = false;
        for (bin, colours) in self.tree.bins(row, n_colours) {
            is_known = true;
            self.add_bin(eye, item, bin, colours, out);
        }
        if is_known {
            return;
        }
        let colours = &self.tree.colours[row * n_colours..(row + 1) * n_colours];
        let mixes = &self.tree.mixes[row * n_mixes..(row + 1) * n_mixes];
        for (s, colours) in colours.chunks_exact(n).enumerate() {
            let spot = self.spot_of(eye, item, s);
            let (low, high) = self.phases.rows(spot);
            for (w, out) in out.iter_mut().enumerate() {
                let mut phase = low[w] + spot.part * (high[w] - low[w]);
                for (r, mix) in mixes.iter().enumerate() {
                    let i = (r + 1) * n + w;
                    phase += mix * (low[i] + spot.part * (high[i] - low[i]));
                }
                *out += f64::from(item.factor * self.air_of(item, w) * colours[w] * phase.max(0.0));
            }
        }
    }

    /// Adds what the droplets of one bin bring to a node.
    fn add_bin(&self, eye: &Eye, item: &Item, bin: usize, colours: &[f32], out: &mut [f64]) {
        for (s, colours) in colours.chunks_exact(self.n_wavelengths).enumerate() {
            let spot = self.spot_of(eye, item, s);
            for (w, out) in out.iter_mut().enumerate() {
                *out += f64::from(item.factor * self.air_of(item, w) * colours[w] * self.bin_phase(bin, spot, w));
            }
        }
    }

    fn add_source(&self, accel: &Accel, lighting: &Lighting, eye: &Eye, item: &Item, out: &mut [f64]) {
        let n = self.n_wavelengths;
        let slot = self.slot_of(item);
        let body = accel.body(self.slots[slot].body);
        let (row, lit) = (self.rows.of(body), self.sun_share.of(slot));
        let per_scale = f64::from(self.slots[slot].amount) / (self.scale * self.unit_m * self.unit_m);
        for (s, sun) in lighting.suns.iter().enumerate() {
            let spot = self.spot_of(eye, item, s);
            for (w, out) in out.iter_mut().enumerate() {
                let phase = f64::from(item.factor * self.air_of(item, w) * self.bin_phase(body.bin(), spot, w));
                *out += phase * per_scale * row[w] * sun.irradiance[w] * f64::from(lit[s * n + w]);
            }
        }
    }

    /// A bin's own phase function at a spot.
    #[inline]
    fn bin_phase(&self, bin: usize, spot: Spot, w: usize) -> f32 {
        let n = self.n_wavelengths;
        let entry = spot.entry as usize;
        if entry + 1 < self.bin_phases.n_entries {
            let i = (bin * self.bin_phases.n_entries + entry) * n + w;
            let (low, high) = (self.bin_phases.values[i], self.bin_phases.values[i + n]);
            return low + spot.part * (high - low);
        }
        let (low, high) = self.phases.rows(spot);
        let at = |i: usize| low[i] + spot.part * (high[i] - low[i]);
        let deviations = self.mixture.coefficients(bin).iter().enumerate();
        let phase = at(w) + deviations.map(|(r, c)| c * at((r + 1) * n + w)).sum::<f32>();
        phase.max(0.0)
    }

    /// The source of a leaf's item.
    #[inline]
    pub(super) fn slot_of(&self, item: &Item) -> usize {
        self.tree.octets[item.node as usize / LEAF].child[item.node as usize % LEAF] as usize
    }

    #[inline(always)]
    fn air_of(&self, item: &Item, w: usize) -> f32 {
        let (low, high) = self.air.rows(item.air);
        let w = w.min(low.len() - 1);
        low[w] + item.air.part * (high[w] - low[w])
    }

    /// Where a sun's scattering angle is in the tables; the first sun's is known.
    #[inline(always)]
    fn spot_of(&self, eye: &Eye, item: &Item, sun: usize) -> Spot {
        if sun == 0 {
            return item.spot;
        }
        let (octet, k) = (&self.tree.octets[item.node as usize / LEAF], item.node as usize % LEAF);
        let [x, y, z] = [eye.x[0] - octet.x[k], eye.x[1] - octet.y[k], eye.x[2] - octet.z[k]];
        let d2 = (x * x + y * y + z * z).max(f32::MIN_POSITIVE);
        let inverse = 1.0 / d2.sqrt();
        let h = turn([x * inverse, y * inverse, z * inverse], eye.sun(self, sun));
        self.phases.spot(h, octet.variance[k] / d2.max(octet.variance[k]))
    }
}

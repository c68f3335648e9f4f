//! What happens at a collision: which droplets take part, how much they remove, where they send light.
//!
//! Legend: sigma_l, what acts at wavelength l (per metre in fog; on a droplet's disc the probability that it acts);
//! omega, albedo; p, phase function; h = 1 - cos of the scattering angle.

use glam::DVec3;

use super::collision::Place;
use super::forward::ForwardLobes;
use super::media::Media;
use crate::accel::{Body, Crossing, LocalRay};

/// A collision; buffers are reused from one to the next.
#[derive(Clone, Debug, Default)]
pub(super) struct Event {
    /// Where light is scattered, in the cloud's frame: a droplet's centre, or the place in the fog.
    pub point: DVec3,
    /// Distance along the ray, m.
    pub t_m: f64,
    /// sigma by wavelength.
    pub sigma: Vec<f64>,
    /// Size bins that take part, each with its droplets per cubic metre.
    acting: Vec<(u32, f64)>,
    on_disc: bool,
    /// Number of the droplet on whose disc it is; 0 in fog.
    pub disc_id: u32,
}

/// What a turn at a collision is worth, by wavelength.
#[derive(Clone, Debug, Default)]
pub(super) struct Turn {
    /// Light that is sent this way: sigma omega p(h).
    pub light: Vec<f64>,
    /// The common forward lobe's share of it.
    pub lobe: Vec<f64>,
    /// sigma times the density with which `Event::sample_h` draws it, were that wavelength the hero.
    pub drawn: Vec<f64>,
}

impl Turn {
    pub fn new(n_wavelengths: usize) -> Self {
        Self { light: vec![0.0; n_wavelengths], lobe: vec![0.0; n_wavelengths], drawn: vec![0.0; n_wavelengths] }
    }
}

impl Event {
    pub fn new(n_wavelengths: usize) -> Self {
        Self { sigma: vec![0.0; n_wavelengths], ..Self::default() }
    }

    /// Gathers what takes part in a collision at a place along a ray.
    pub fn gather(&mut self, media: &Media, ray: &LocalRay, place: Place, crossings: &[(Body, Crossing)]) {
        self.acting.clear();
        self.sigma.fill(0.0);
        match place {
            Place::Disc(index) => {
                let (body, crossing) = &crossings[index as usize];
                (self.point, self.t_m, self.on_disc) = (body.center, crossing.start(), true);
                self.disc_id = body.id;
                self.acting.push((body.bin() as u32, 1.0));
                for (sigma, depth) in self.sigma.iter_mut().zip(media.disc_depth(body.bin())) {
                    *sigma = -(-f64::from(body.load) * depth).exp_m1();
                }
            }
            Place::Fog(t_m) => {
                (self.point, self.t_m, self.on_disc) = (ray.origin + t_m * ray.direction, t_m, false);
                self.disc_id = 0;
                self.gather_fog(media, crossings);
            }
        }
    }

    /// A collision in the fog of one body alone, at a distance along a ray.
    #[inline]
    pub fn gather_one(&mut self, media: &Media, ray: &LocalRay, t_m: f64, body: &Body) {
        (self.point, self.t_m, self.on_disc, self.disc_id) = (ray.origin + t_m * ray.direction, t_m, false, 0);
        let load = f64::from(body.load);
        self.acting.clear();
        self.acting.push((body.bin() as u32, load));
        for (sigma, c_ext_m2) in self.sigma.iter_mut().zip(media.c_ext_m2(body.bin())) {
            *sigma = load * c_ext_m2;
        }
    }

    fn gather_fog(&mut self, media: &Media, crossings: &[(Body, Crossing)]) {
        for (body, crossing) in crossings {
            let inside = crossing.start() <= self.t_m && self.t_m <= crossing.end();
            if !inside || body.is_disc() {
                continue;
            }
            let (bin, load) = (body.bin() as u32, f64::from(body.load));
            match self.acting.iter_mut().find(|(known, _)| *known == bin) {
                Some((_, sum)) => *sum += load,
                None => self.acting.push((bin, load)),
            }
        }
        for (bin, load) in &self.acting {
            for (sigma, c_ext_m2) in self.sigma.iter_mut().zip(media.c_ext_m2(*bin as usize)) {
                *sigma += load * c_ext_m2;
            }
        }
    }

    /// sigma of one of the bins that take part.
    #[inline]
    fn part(&self, media: &Media, bin: usize, load: f64, wavelength: usize) -> f64 {
        if self.on_disc { self.sigma[wavelength] } else { load * media.c_ext_m2(bin)[wavelength] }
    }

    /// Fills `out` with what a turn by h is worth, summed over what takes part.
    pub fn turn(&self, media: &Media, lobes: Option<&ForwardLobes>, h: f64, out: &mut Turn) {
        let Turn { light: light_sum, lobe: lobe_sum, drawn: drawn_sum } = out;
        for (i, (bin, load)) in self.acting.iter().enumerate() {
            let bin = *bin as usize;
            let (albedo, phase) = (media.albedo(bin), media.phase(bin));
            for w in 0..self.sigma.len() {
                let (part, p) = (self.part(media, bin, *load, w), phase[w].eval(h));
                let (drawn, light) = (part * p, part * albedo[w] * p);
                let lobe = lobes.map_or(0.0, |lobes| part * albedo[w] * lobes.part(w, h, p));
                if i == 0 {
                    (light_sum[w], lobe_sum[w], drawn_sum[w]) = (light, lobe, drawn);
                } else {
                    light_sum[w] += light;
                    lobe_sum[w] += lobe;
                    drawn_sum[w] += drawn;
                }
            }
        }
    }

    /// Draws a scattering angle as the hero wavelength does: a bin by its share of sigma, then its phase function.
    pub fn sample_h(&self, media: &Media, hero: usize, u_bin: f64, u_angle: f64) -> f64 {
        let mut rest = u_bin * self.sigma[hero];
        let mut chosen = self.acting.first().map_or(0, |(bin, _)| *bin as usize);
        for (bin, load) in &self.acting {
            chosen = *bin as usize;
            rest -= self.part(media, chosen, *load, hero);
            if rest < 0.0 {
                break;
            }
        }
        media.phase(chosen)[hero].sample(u_angle)
    }
}

//! What `mie-cloud inspect` prints for programs.

use glam::DVec3;
use serde_json::{Map, Value, json};

use super::inspect_histogram::Histogram;
use super::inspect_light::{irradiance, lens};
use super::inspect_report::{Seen, count};
use super::inspect_sizes::{ClassSizes, drawn_radii_m, size_parameters};
use crate::optics::DropletClass;
use crate::plan::{Decision, SHARE_OF_TARGET};
use crate::scene::model::{Camera, Lens, ParticleKind, Sun};
use crate::scene::settings::Switch;

impl Seen<'_> {
    /// Everything, by key.
    pub fn json(&self) -> Value {
        let Self { scene, plan, sampling, sizes, .. } = self;
        let classes: Vec<Value> = scene.classes.iter().zip(sizes).map(class).collect();
        let n_bins: usize = sizes.iter().map(|sizes| sizes.n_bins).sum();
        json!({
            "version": env!("CARGO_PKG_VERSION"),
            "scene": scene.name,
            "hash": scene.hash,
            "droplets": count(scene, ParticleKind::Droplet),
            "parcels": count(scene, ParticleKind::Parcel),
            "fog_boxes": scene.fog_boxes.len(),
            "drawn_radius_m": drawn_radii_m(scene).map(|(least, most)| [least, most]),
            "classes": classes,
            "size_bins": n_bins,
            "wavelengths_m": sampling.wavelengths_m,
            "size_parameters": size_parameters(sizes, &sampling.wavelengths_m),
            "optical_depth": self.optical_depth(),
            "coverage": self.facts.cover,
            "suns": scene.suns.iter().map(|one| self.sun(one)).collect::<Vec<_>>(),
            "air": self.air_settings(),
            "background": self.background(),
            "camera": camera(&scene.camera),
            "resolution": scene.settings.image.resolution,
            "spectral_mode": sampling.mode().to_string(),
            "accuracy": { "target": self.target, "least_effect": SHARE_OF_TARGET * self.target },
            "effects": plan.decisions.iter().map(decision).collect::<Map<_, _>>(),
            "memory_bytes": self.memory_bytes(),
            "warnings": scene.warnings.iter().map(ToString::to_string).collect::<Vec<_>>(),
        })
    }

    fn optical_depth(&self) -> Value {
        let (facts, depths) = (&self.facts, &self.depths);
        json!({ "seen": depths.mean, "deepest_seen": depths.deepest, "across": self.across.mean,
            "deepest": facts.deepest_optical_depth, "meaning": {
                "seen": "about, mean over the camera's rays that meet droplets",
                "deepest_seen": "about, the largest along the camera's rays on a coarse grid",
                "across": "about, mean over parallel rays from the camera's right to its left that meet droplets",
                "deepest": "rough: extinction over the mean shadow of the box around all particles, along the longest way through that box, and every fog box along \
                            its diagonal; no ray is deeper",
            } })
    }

    fn sun(&self, sun: &Sun) -> Value {
        let scene = self.scene;
        json!({
            "name": sun.name, "direction": sun.direction.to_array(), "lux": sun.lux, "color": sun.color,
            "angular_diameter_deg": scene.sun_diameter_deg(sun),
            "spectrum": sun.spectrum.unwrap_or(scene.settings.sun.spectrum).name(),
            "irradiance_w_per_m2_nm": irradiance(scene, self.sampling, sun),
        })
    }

    fn air_settings(&self) -> Value {
        let air = &self.scene.settings.atmosphere;
        json!({
            "scattering_per_m": air.scattering_per_m, "absorption_per_m": air.absorption_per_m,
            "phase": self.air_phase(), "depth_m": air.depth_m, "step_m": air.step_m, "sunlight": air.sunlight,
        })
    }

    fn background(&self) -> Value {
        let background = &self.scene.settings.background;
        let image = background.image.as_ref().and_then(|path| path.file_name());
        json!({ "radiance": background.radiance, "image": image.map(|name| name.to_string_lossy()) })
    }

    fn memory_bytes(&self) -> Value {
        let items = self.need.items.iter();
        let parts: Vec<Value> = items.map(|item| json!({ "what": item.what, "bytes": item.bytes })).collect();
        json!({ "total": self.need.total(), "parts": parts })
    }
}

/// `distribution` is that of the class, whether any droplets have it or not: `sizes` says what they have.
fn class((class, sizes): (&DropletClass, &ClassSizes)) -> Value {
    let distribution = class.distribution.to_string();
    json!({
        "material": class.material.to_string(),
        "distribution": distribution,
        "phase": class.phase.to_string(),
        "albedo": class.albedo,
        "particles": sizes.n_particles,
        "fog_boxes": sizes.n_fog_boxes,
        "sizes": sizes.words(&distribution),
        "size_bins": sizes.n_bins,
        "own_radii": sizes.own.as_ref().map(|own| histogram(own, "counts", |count| json!(count as u64))),
        "distribution_radii": sizes.law.as_ref().map(|law| histogram(law, "shares", |share| json!(share))),
    })
}

fn histogram(histogram: &Histogram, what: &str, amount: fn(f64) -> Value) -> Value {
    let amounts: Vec<Value> = histogram.amounts.iter().copied().map(amount).collect();
    json!({
        "least_m": histogram.least_m, "effective_m": histogram.effective_m, "greatest_m": histogram.greatest_m,
        "edges_m": histogram.edges_m, what: amounts,
    })
}

fn camera(camera: &Camera) -> Value {
    let frame = camera.world_from_camera;
    // Not its negative: programs are spared -0.
    let direction = DVec3::ZERO - frame.z_axis;
    let (yfov_deg, size_m) = match camera.lens {
        Lens::Perspective { yfov_rad, .. } => (Some(yfov_rad.to_degrees()), None),
        Lens::Orthographic { xmag_m, ymag_m } => (None, Some([2.0 * xmag_m, 2.0 * ymag_m])),
    };
    json!({
        "name": camera.name, "position_m": camera.position_m.to_array(), "lens": lens(camera.lens),
        "direction": direction.to_array(), "up": frame.y_axis.to_array(), "yfov_deg": yfov_deg, "size_m": size_m,
    })
}

fn decision(decision: &Decision) -> (String, Value) {
    let value = json!({
        "on": decision.on, "reason": decision.reason, "estimate": decision.estimate, "time_share": decision.time_share,
        "switched": decision.switch != Switch::Auto,
    });
    (decision.effect.name().to_owned(), value)
}

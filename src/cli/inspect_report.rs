//! What `mie-cloud inspect` prints for people: a line or two about each thing, none wider than a terminal.

use std::collections::BTreeSet;

use crate::excerpt::{excerpt, printable};
use crate::plan::{Decision, EffectPlan, SHARE_OF_TARGET, SeenDepths};
use crate::scene::model::{Lens, Particle, ParticleKind, Scene};
use crate::scene::settings::Switch;
use crate::spectrum::SpectralSampling;
use crate::transport::need::Need;
use crate::units::format_bytes;
use crate::units::short::{amount, length, number, percent};

use super::job::DEFAULT_SPP;
use super::wrapped::beside;

/// What is reported.
pub struct Seen<'a> {
    pub scene: &'a Scene,
    pub plan: &'a EffectPlan,
    pub depths: SeenDepths,
    pub sampling: &'a SpectralSampling,
    pub need: &'a Need,
    /// Relative error that is aimed at.
    pub target: f64,
}

impl Seen<'_> {
    /// The whole report.
    pub fn report(&self) -> String {
        let scene = self.scene;
        let mut lines = vec![("particles", particles(scene))];
        lines.extend(drawn_radii_m(scene).map(|radii_m| ("radii", radii(radii_m))));
        lines.extend(classes(scene).into_iter().map(|class| ("droplets", droplets(scene, class))));
        lines.push(("depth", self.depth()));
        for sun in &scene.suns {
            lines.push((
                "sun",
                format!("{}: {} lx, shining along {}", sun.name, number(sun.lux), vector(sun.direction)),
            ));
        }
        lines.push(("air", self.air()));
        let camera = &scene.camera;
        lines.push((
            "camera",
            format!("{} at {} m, {}", excerpt(&camera.name), vector(camera.position_m), lens(camera.lens)),
        ));
        let [width, height] = scene.settings.image.resolution;
        let until = match scene.settings.accuracy.target {
            Some(target) => format!("until its noise is {}", percent(target)),
            None => format!("{DEFAULT_SPP} samples per pixel"),
        };
        lines.push(("picture", format!("{width}x{height}, {}, {until}", self.sampling.mode())));
        lines.push(("memory", self.memory()));
        let beside_label = |(label, text): (&str, String)| beside(&format!("{label:<12}"), &text);
        let lines: String = lines.into_iter().map(beside_label).collect();
        format!("{}\n{lines}\n{}", printable(&scene.name), self.effects())
    }

    fn depth(&self) -> String {
        let SeenDepths { mean, deepest } = self.depths;
        if self.scene.particles.is_empty() && self.scene.fog_boxes.is_empty() {
            return "0: there are no droplets".into();
        }
        if deepest == 0.0 {
            return "the camera sees no droplet: does it look their way?".into();
        }
        format!("about {} along the camera's rays, about {} at most", number(mean), number(deepest))
    }

    fn air(&self) -> String {
        let air = &self.scene.settings.atmosphere;
        if air.scattering_per_m == 0.0 && air.absorption_per_m == 0.0 {
            return "clear".into();
        }
        format!(
            "scatters {} /m, absorbs {} /m, within {} m of the camera",
            air.scattering_per_m, air.absorption_per_m, air.depth_m
        )
    }

    fn memory(&self) -> String {
        let need = self.need;
        let parts: Vec<String> =
            need.items.iter().take(3).map(|item| format!("{} for {}", format_bytes(item.bytes), item.what)).collect();
        format!("about {} to render: {}", format_bytes(need.total()), parts.join(", "))
    }

    fn effects(&self) -> String {
        let least = percent(SHARE_OF_TARGET * self.target);
        let head = format!(
            "on if they may change the picture by more than {least}; below, by how much they may at most, and what share of \
             the time they take"
        );
        let lines: String = self.plan.decisions.iter().map(effect).collect();
        beside("effects     ", &head) + &lines
    }
}

fn particles(scene: &Scene) -> String {
    let droplets = count(scene, ParticleKind::Droplet);
    let parcels = count(scene, ParticleKind::Parcel);
    let kinds = [
        (droplets, "droplet", "droplets"),
        (parcels, "parcel", "parcels"),
        (scene.fog_boxes.len(), "fog box", "fog boxes"),
    ];
    let some: Vec<String> =
        kinds.iter().filter(|kind| kind.0 > 0).map(|(n, one, many)| amount(*n, one, many)).collect();
    if some.is_empty() { "none".into() } else { some.join(", ") }
}

/// The classes that some droplets are of; all where there are no droplets.
fn classes(scene: &Scene) -> Vec<usize> {
    let of_particles = scene.particles.iter().map(|particle| usize::from(particle.class));
    let used: BTreeSet<usize> = of_particles.chain(scene.fog_boxes.iter().map(|fog| usize::from(fog.class))).collect();
    if used.is_empty() { (0..scene.classes.len()).collect() } else { used.into_iter().collect() }
}

/// Material, sizes and phase model of a class of droplets.
fn droplets(scene: &Scene, class: usize) -> String {
    let described = &scene.classes[class];
    let albedo = described.albedo.map_or(String::new(), |albedo| format!(", albedo {albedo}"));
    let sizes = sizes(scene, class).unwrap_or_else(|| described.distribution.to_string());
    format!("{}, {sizes}, phase {}{albedo}", described.material, described.phase)
}

/// The droplets' own radii, where some have radii of their own; others have those of the class's distribution.
fn sizes(scene: &Scene, class: usize) -> Option<String> {
    let particles = scene.particles.iter().filter(|particle| usize::from(particle.class) == class);
    let particles = particles.map(Particle::own_radius_m);
    let boxes = scene.fog_boxes.iter().filter(|fog| usize::from(fog.class) == class).map(|fog| fog.droplet_radius_m);
    let (mut own, mut by_law) = (None, false);
    for radius_m in particles.chain(boxes) {
        match (radius_m, own) {
            (None, _) => by_law = true,
            (Some(r_m), None) => own = Some((r_m, r_m)),
            (Some(r_m), Some((least, most))) => own = Some((r_m.min(least), r_m.max(most))),
        }
    }
    let (least, most) = own?;
    let own = match [least, most].map(length) {
        [least, most] if least == most => format!("radius {least}"),
        [least, most] => format!("radii {least} to {most}"),
    };
    Some(if by_law { format!("{own} and {}", scene.classes[class].distribution) } else { own })
}

fn radii((least, most): (f32, f32)) -> String {
    let [least, most] = [least, most].map(|radius_m| length(f64::from(radius_m)));
    if least == most { format!("{least} as drawn") } else { format!("{least} to {most} as drawn") }
}

fn effect(decision: &Decision) -> String {
    let state = if decision.on { "on" } else { "off" };
    let estimate = match decision.estimate {
        // Whoever switched it wants to know what that does; a plan that leaves nothing out has said so in words.
        Some(estimate) if decision.switch != Switch::Auto || estimate > 0.0 => percent(estimate),
        _ => String::new(),
    };
    // Of what is off, the share that it would take.
    let time = match decision.time_share {
        Some(share) if share >= 0.005 => format!("{:.0} %", 100.0 * share),
        _ => String::new(),
    };
    beside(&format!("  {state:<4}{:<13}{estimate:>8} {time:>5}  ", decision.effect.name()), &decision.reason)
}

fn vector(v: glam::DVec3) -> String {
    // What rounding has left of nothing is nothing.
    let near = |x: f64| if x.abs() > 1e-6 * v.length() { number(x) } else { "0".into() };
    format!("({}, {}, {})", near(v.x), near(v.y), near(v.z))
}

/// How many particles are of a kind.
pub fn count(scene: &Scene, kind: ParticleKind) -> usize {
    scene.particles.iter().filter(|particle| particle.kind == kind).count()
}

/// Smallest and largest drawn radius, m.
pub fn drawn_radii_m(scene: &Scene) -> Option<(f32, f32)> {
    scene.particles.iter().map(|p| (p.radius_m, p.radius_m)).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
}

/// The camera's lens in words.
pub fn lens(lens: Lens) -> String {
    match lens {
        Lens::Perspective { yfov_rad, .. } => format!("{:.2} degrees high", yfov_rad.to_degrees()),
        Lens::Orthographic { xmag_m, ymag_m } => format!("{} m x {} m", 2.0 * xmag_m, 2.0 * ymag_m),
    }
}

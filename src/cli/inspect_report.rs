//! What `mie-cloud inspect` prints for people: a line or two about each thing, none wider than a terminal.

use crate::excerpt::printable;
use crate::optics::DropletClass;
use crate::plan::{Decision, EffectPlan, SHARE_OF_TARGET, SceneFacts, SeenDepths};
use crate::scene::model::{ParticleKind, Scene};
use crate::scene::settings::Switch;
use crate::spectrum::SpectralSampling;
use crate::transport::need::Need;
use crate::units::format_bytes;
use crate::units::short::{amount, length, number, percent};

use super::inspect_light::{camera, sun};
use super::inspect_sizes::{ClassSizes, drawn_radii_m, size_parameters};
use super::job::DEFAULT_SPP;
use super::wrapped::beside;

/// More charts than this are no longer looked at: JSON has them all.
const MOST_CHARTS: usize = 4;

/// What is reported.
pub struct Seen<'a> {
    pub scene: &'a Scene,
    pub plan: &'a EffectPlan,
    pub facts: SceneFacts,
    pub across: SeenDepths,
    pub depths: SeenDepths,
    /// Of every class.
    pub sizes: Vec<ClassSizes>,
    pub sampling: &'a SpectralSampling,
    pub need: Need,
    /// Relative error that is aimed at.
    pub target: f64,
}

impl Seen<'_> {
    /// The whole report.
    pub fn report(&self) -> String {
        let scene = self.scene;
        let what = [("particles", Some(particles(scene))), ("radii", drawn_radii_m(scene).map(radii))];
        let how = [("bins", self.bins()), ("depth", Some(self.depth())), ("coverage", self.coverage())];
        let suns = scene.suns.iter().map(|one| ("sun", Some(sun(scene, self.sampling, one))));
        let rest = [
            ("air", Some(self.air())),
            ("camera", Some(camera(&scene.camera))),
            ("picture", Some(self.picture())),
            ("memory", Some(self.memory())),
        ];
        let (what, classes, how) = (lines(what), self.classes(), lines(how.into_iter().chain(suns).chain(rest)));
        format!("{}\n{what}{classes}{how}\n{}", printable(&scene.name), self.effects())
    }

    /// Droplets class by class, each with a chart of its radii.
    fn classes(&self) -> String {
        let is_any_used = self.sizes.iter().any(ClassSizes::is_used);
        let n_charts = self.sizes.iter().flat_map(ClassSizes::histograms).filter(|radii| !radii.is_single()).count();
        let mut out = String::new();
        for (class, sizes) in self.scene.classes.iter().zip(&self.sizes) {
            // Where there are no droplets, what they would be.
            if sizes.is_used() || !is_any_used {
                out += &beside(&label_of("droplets"), &droplets(class, sizes));
            }
            let remarks = if sizes.histograms().count() > 1 { [", their own", ", distribution"] } else { [""; 2] };
            let charts = sizes.histograms().zip(remarks).filter(|_| n_charts <= MOST_CHARTS);
            out.extend(charts.filter_map(|(radii, remark)| radii.chart(&label_of("sizes"), remark)));
        }
        out
    }

    fn bins(&self) -> Option<String> {
        let [least, most] = size_parameters(&self.sizes, &self.sampling.wavelengths_m)?.map(number);
        let bins = amount(self.sizes.iter().map(|sizes| sizes.n_bins).sum(), "size bin", "size bins");
        let wavelengths = amount(self.sampling.wavelengths_m.len(), "wavelength", "wavelengths");
        let range = if least == most { least } else { format!("{least} to {most}") };
        Some(format!("{bins} at {wavelengths}, size parameters {range}"))
    }

    fn picture(&self) -> String {
        let [width, height] = self.scene.settings.image.resolution;
        let until = match self.scene.settings.accuracy.target {
            Some(target) => format!("until its noise is {}", percent(target)),
            None => format!("{DEFAULT_SPP} samples per pixel"),
        };
        format!("{width}x{height}, {}, {until}", self.sampling.mode())
    }

    /// How much of what shines through the picture droplets take.
    fn coverage(&self) -> Option<String> {
        let cover = self.facts.cover;
        (cover > 0.0).then(|| format!("about {} of the picture, by the light that droplets take", percent(cover)))
    }

    /// The air's phase function as it is written.
    pub fn air_phase(&self) -> String {
        let settings = self.scene.settings.to_json();
        settings["atmosphere.phase"].as_str().unwrap_or_default().to_owned()
    }

    fn depth(&self) -> String {
        let SeenDepths { mean, deepest } = self.depths;
        if self.scene.particles.is_empty() && self.scene.fog_boxes.is_empty() {
            return "0: there are no droplets".into();
        }
        let across = format!("about {} across, from side to side", number(self.across.mean));
        if deepest == 0.0 {
            return format!("the camera sees no droplet: does it look their way? {across}");
        }
        format!("about {} along the camera's rays, about {} at most; {across}", number(mean), number(deepest))
    }

    fn air(&self) -> String {
        let air = &self.scene.settings.atmosphere;
        if air.scattering_per_m == 0.0 && air.absorption_per_m == 0.0 {
            return "clear".into();
        }
        let sunlight = if air.sunlight { "" } else { ", no sunlight" };
        format!(
            "scatters {} /m, absorbs {} /m, within {} m of the camera, phase {}{sunlight}",
            air.scattering_per_m,
            air.absorption_per_m,
            air.depth_m,
            self.air_phase()
        )
    }

    fn memory(&self) -> String {
        let need = &self.need;
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

/// What stands before a line.
fn label_of(name: &str) -> String {
    format!("{name:<12}")
}

/// Each text beside its label.
fn lines<'a>(lines: impl IntoIterator<Item = (&'a str, Option<String>)>) -> String {
    let line = |(label, text): (&str, Option<String>)| text.map(|text| beside(&label_of(label), &text));
    lines.into_iter().filter_map(line).collect()
}

/// Material, sizes and phase model of a class of droplets.
fn droplets(class: &DropletClass, sizes: &ClassSizes) -> String {
    let albedo = class.albedo.map_or(String::new(), |albedo| format!(", albedo {albedo}"));
    let distribution = class.distribution.to_string();
    let words = sizes.words(&distribution).unwrap_or(distribution);
    format!("{}, {words}, phase {}{albedo}", class.material, class.phase)
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

/// How many particles are of a kind.
pub fn count(scene: &Scene, kind: ParticleKind) -> usize {
    scene.particles.iter().filter(|particle| particle.kind == kind).count()
}

//! Settings written out again, every key with its value: what a picture records about how it was made.

use serde_json::{Map, Value, json};

use super::settings::{AirPhase, Effect, Settings, Switch};

impl Settings {
    /// All settings as an object of dotted keys, in alphabetical order.
    pub fn to_json(&self) -> Value {
        let mut keys = Map::new();
        let mut put = |key: &str, value: Value| {
            keys.insert(key.to_owned(), value);
        };
        let class = &self.droplets.class;
        put("droplets.material", class.material.name().into());
        put("droplets.materials", self.droplets.materials.iter().map(|m| Value::from(m.name())).collect());
        put("droplets.phase", class.phase.to_string().into());
        put("droplets.distribution", class.distribution.to_string().into());
        put("droplets.albedo", class.albedo.into());
        put("droplets.size_bins", self.droplets.size_bins.map_or("auto".into(), Value::from));
        put("sun.spectrum", self.sun.spectrum.name().into());
        put("sun.irradiance", self.sun.irradiance.into());
        put("sun.angular_diameter_deg", self.sun.angular_diameter_deg.into());
        let air = &self.atmosphere;
        put("atmosphere.scattering_per_m", air.scattering_per_m.into());
        put("atmosphere.absorption_per_m", air.absorption_per_m.into());
        put("atmosphere.phase", air_phase(&air.phase).into());
        put("atmosphere.depth_m", air.depth_m.into());
        put("atmosphere.step_m", air.step_m.into());
        put("atmosphere.sunlight", air.sunlight.into());
        put("background.radiance", json!(self.background.radiance));
        let image = self.background.image.as_ref().and_then(|path| path.file_name());
        put("background.image", image.map(|name| name.to_string_lossy().into_owned()).into());
        put("spectral.mode", self.spectral_mode.map(|mode| mode.to_string()).into());
        for (effect, name) in Effect::ALL {
            put(&format!("effects.{name}"), switch(self.effects.get(&effect).copied().unwrap_or_default()).into());
        }
        put("accuracy.target", self.accuracy.target.into());
        put("accuracy.size_parameter_cap", self.accuracy.size_parameter_cap.into());
        put("accuracy.glow_tolerance", self.accuracy.glow_tolerance.into());
        put("accuracy.angle_tolerance", self.accuracy.angle_tolerance.into());
        put("accuracy.peak_truncation_deg", self.accuracy.peak_truncation_deg.into());
        put("image.resolution", json!(self.image.resolution));
        Value::Object(keys)
    }
}

fn air_phase(phase: &AirPhase) -> String {
    match phase {
        AirPhase::Isotropic => "isotropic".into(),
        AirPhase::Rayleigh => "rayleigh".into(),
        AirPhase::HenyeyGreenstein { g } => format!("hg:{g}"),
        AirPhase::Haze(distribution) => format!("mie:{distribution}"),
    }
}

fn switch(switch: Switch) -> &'static str {
    match switch {
        Switch::Auto => "auto",
        Switch::On => "on",
        Switch::Off => "off",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::keys::SETTINGS;

    #[test]
    fn every_key_is_recorded() {
        let json = Settings::default().to_json();
        for key in SETTINGS {
            assert!(json.get(key.name).is_some(), "{}", key.name);
        }
        assert_eq!(json.as_object().map(serde_json::Map::len), Some(SETTINGS.len()));
    }
}

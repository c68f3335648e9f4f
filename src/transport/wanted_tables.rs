//! Which optical tables a scene wants: at which wavelengths, how finely, for its droplets, its fog and its air.

use std::sync::Arc;

use super::media::Absorption;
use crate::optics::DropletClass;
use crate::optics::bins::BinPlan;
use crate::optics::count::TableStore;
use crate::optics::distribution::{Shape, SizeDistribution};
use crate::optics::material::Material;
use crate::optics::phase_function::PhaseFunction;
use crate::optics::phase_model::PhaseModel;
use crate::optics::size_average::AverageAccuracy;
use crate::optics::tables::{OpticalTables, OpticsError, TableSettings};
use crate::plan::EffectPlan;
use crate::scene::fog::Measure;
use crate::scene::model::Scene;
use crate::scene::settings::{Accuracy, AirPhase, Effect};
use crate::spectrum::SpectralSampling;

/// The wavelength at which scenes give extinction coefficients of fog, m.
const FOG_WAVELENGTH_M: f64 = 550e-9;

/// Wavelengths that need tables, m.
#[derive(Clone, Copy, Default)]
pub(super) struct Wavelengths<'a> {
    pub middles_m: &'a [f64],
    /// Edges of the bands; none where each wavelength is meant alone.
    pub edges_m: &'a [f64],
}

/// What needs tables; without dispersion all wavelengths share the middle one.
pub(super) fn table_wavelengths<'a>(plan: &EffectPlan, sampling: &'a SpectralSampling) -> Wavelengths<'a> {
    let all = &sampling.wavelengths_m;
    if plan.is_on(Effect::Dispersion) {
        return Wavelengths { middles_m: all, edges_m: &sampling.band_edges_m };
    }
    let middle = all.len() / 2;
    let edges_m = sampling.band_edges_m.get(middle..middle + 2).unwrap_or_default();
    Wavelengths { middles_m: &all[middle..=middle], edges_m }
}

/// The tables of all size bins.
pub(super) fn build_tables(
    scene: &Scene,
    bins: &BinPlan,
    wavelengths: Wavelengths,
    store: TableStore,
) -> Result<OpticalTables, OpticsError> {
    OpticalTables::build(bins, &scene.classes, &table_settings(&scene.settings.accuracy, wavelengths, store))
}

/// The tables without their forward peaks, where the settings ask for it.
pub(super) fn cut_peaks(tables: OpticalTables, angle_deg: f64, absorption: Absorption) -> OpticalTables {
    if angle_deg == 0.0 {
        return tables;
    }
    tables.without_peaks(angle_deg.to_radians(), |optics| match absorption {
        Absorption::Simulated => optics.albedo,
        Absorption::LeftOut => 1.0,
    })
}

/// How finely tables are made for an accuracy.
pub(super) fn table_settings<'a>(
    accuracy: &Accuracy,
    wavelengths: Wavelengths<'a>,
    store: TableStore<'a>,
) -> TableSettings<'a> {
    let asked = accuracy.target.map_or_else(AverageAccuracy::picture, AverageAccuracy::for_target);
    let angle_tolerance = accuracy.angle_tolerance.unwrap_or(asked.angle_tolerance);
    TableSettings {
        wavelengths_m: wavelengths.middles_m,
        band_edges_m: wavelengths.edges_m,
        size_parameter_cap: accuracy.size_parameter_cap,
        accuracy: AverageAccuracy { angle_tolerance, ..asked },
        store,
    }
}

/// Gives every ball and box of fog its number of droplets, from their extinction at 550 nm and their mass.
pub(super) fn fill_fog(scene: &mut Scene) -> Result<(), OpticsError> {
    let settings = table_settings(
        &scene.settings.accuracy,
        Wavelengths { middles_m: &[FOG_WAVELENGTH_M], edges_m: &[] },
        TableStore::default(),
    );
    scene.fill_fog(|class, own_radius_m, measure| {
        let distribution = match own_radius_m {
            Some(r_m) => SizeDistribution { shape: Shape::Mono { r_m }, r_min_m: r_m, r_max_m: r_m },
            None => class.distribution.clone(),
        };
        if measure == Measure::MassG {
            return Ok(1e3 * class.material.density_kg_per_m3() * distribution.law().mean_volume_m3());
        }
        let class = DropletClass { distribution, phase: PhaseModel::Isotropic, ..class.clone() };
        let tables = OpticalTables::build(&BinPlan::of_distribution(&class), std::slice::from_ref(&class), &settings)?;
        Ok(tables.get(0, 0).c_ext_m2)
    })
}

/// The air's phase function at every wavelength.
pub(super) fn air_phases(
    scene: &Scene,
    wavelengths: Wavelengths,
    store: TableStore,
) -> Result<Vec<Arc<PhaseFunction>>, OpticsError> {
    let air = &scene.settings.atmosphere;
    let same = |phase: PhaseFunction| Ok(vec![Arc::new(phase)]);
    match &air.phase {
        _ if air.scattering_per_m == 0.0 => same(PhaseFunction::Isotropic),
        AirPhase::Isotropic => same(PhaseFunction::Isotropic),
        AirPhase::Rayleigh => same(PhaseFunction::Rayleigh),
        AirPhase::HenyeyGreenstein { g } => same(PhaseFunction::henyey_greenstein(*g)),
        AirPhase::Haze(distribution) => {
            let class = DropletClass {
                material: Material::Water,
                phase: PhaseModel::Mie,
                distribution: distribution.clone(),
                albedo: None,
            };
            let settings = table_settings(&scene.settings.accuracy, wavelengths, store);
            let tables = OpticalTables::build(&BinPlan::of_distribution(&class), &[class], &settings)?;
            Ok((0..wavelengths.middles_m.len()).map(|w| tables.get(0, w).phase.clone()).collect())
        }
    }
}

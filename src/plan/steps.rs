//! The steps of the march through the air: as the scene asks for, within bounds that hold whatever it asks for.

/// The march ends at this optical depth of air: 1e-20 of the light from beyond would arrive.
pub const LAST_OPTICAL_DEPTH: f64 = 46.0;

/// Most steps of a march, so that its time is bounded whatever a scene says; a longer way takes longer steps.
pub const MOST_STEPS: u32 = 4096;

/// Number and length in m of the steps of a march along a way of `way_m`, through air of an extinction above 0, each at most `step_m` long if it may be.
pub fn march_steps(extinction_per_m: f64, step_m: f64, way_m: f64) -> (u32, f64) {
    let way_m = way_m.min(LAST_OPTICAL_DEPTH / extinction_per_m);
    let n_steps = (way_m / step_m).ceil().clamp(1.0, f64::from(MOST_STEPS)) as u32;
    (n_steps, way_m / f64::from(n_steps))
}

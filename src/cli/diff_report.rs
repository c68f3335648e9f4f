//! What `mie-cloud diff` prints of a comparison.

use std::io::{Result, Write};

use crate::excerpt::excerpt;
use crate::image::compare::{Comparison, LayerDifference, ZScores};

/// Channels of a layer that are named; of more, such as wavelengths, their number is told.
const MOST_NAMED: usize = 4;

/// Prints everything there is; what is no number is left out.
pub fn print(c: &Comparison) -> Result<()> {
    let mut out = std::io::stdout().lock();
    let (different, non_finite) = (c.n_different, c.n_non_finite);
    writeln!(out, "pixels          {} ({different} differ in R, G or B, {non_finite} not finite)", c.n_pixels)?;
    if let Some(pixel) = &c.first_non_finite {
        let left_out = "left out of what follows, and never within --max-rel";
        writeln!(out, "not finite      ({}, {}): {:?} against {:?}; {left_out}", pixel.x, pixel.y, pixel.a, pixel.b)?;
    }
    if c.n_non_finite < c.n_pixels {
        colours(c, &mut out)?;
    }
    layers(c, &mut out)
}

/// R, G and B of the pixels that are finite.
fn colours(c: &Comparison, out: &mut impl Write) -> Result<()> {
    writeln!(out, "RMSE            {:.6e}", c.rmse)?;
    if let Some(relative) = c.relative_rmse {
        writeln!(out, "relative RMSE   {relative:.6e}  (of the second picture's mean luminance)")?;
    }
    if let Some(relative) = c.relative_mse {
        writeln!(out, "relative MSE    {relative:.6e}")?;
    }
    if let Some(ratio) = &c.mean_ratio {
        writeln!(out, "mean ratio      {:.6} +- {:.2e}", ratio.ratio, ratio.error)?;
    }
    if let Some(z) = &c.z {
        writeln!(out, "z-scores        {}", z_scores(z))?;
    }
    if let Some(worst) = c.worst.as_ref().filter(|_| c.n_different > 0) {
        writeln!(out, "worst pixel     ({}, {}): {:?} against {:?}", worst.x, worst.y, worst.a, worst.b)?;
    }
    Ok(())
}

fn z_scores(z: &ZScores) -> String {
    let share = 100.0 * z.share_beyond_3;
    let known = format!("mean {:.3}, RMS {:.3}, largest {:.2}, {share:.2} % beyond 3", z.mean, z.rms, z.max);
    let unexplained = format!("{} values differ without any recorded error", z.n_unexplained);
    match (z.n, z.n_unexplained) {
        (0, _) => unexplained,
        (_, 0) => known,
        _ => format!("{known}, {unexplained}"),
    }
}

/// A line about each layer that differs, and about those that one picture lacks.
fn layers(c: &Comparison, out: &mut impl Write) -> Result<()> {
    let layers = c.layers_that_differ();
    if !layers.is_empty() {
        writeln!(out, "layers that differ")?;
    }
    for layer in &layers {
        writeln!(out, "  {:<13} {}", excerpt(&layer.name), layer_difference(layer))?;
    }
    for (which, names) in [("first", c.layers_only_in_a()), ("second", c.layers_only_in_b())] {
        if !names.is_empty() {
            let names: Vec<String> = names.into_iter().map(excerpt).collect();
            writeln!(out, "only in the {which}: {}", names.join(", "))?;
        }
    }
    Ok(())
}

fn layer_difference(layer: &LayerDifference) -> String {
    let last = |name: &String| excerpt(name.rsplit_once('.').map_or(name, |(_, channel)| channel));
    let channels = match layer.channels.as_slice() {
        [one] if *one == layer.name => String::new(),
        few if few.len() <= MOST_NAMED => format!(", in {}", few.iter().map(last).collect::<Vec<_>>().join(", ")),
        many => format!(", in {} channels", many.len()),
    };
    let means = match layer.rmse.is_nan() {
        true => "no value to compare".into(),
        false => format!("mean {:.3e} against {:.3e}, RMSE {:.3e}", layer.mean_a, layer.mean_b, layer.rmse),
    };
    let non_finite = match layer.n_non_finite {
        0 => String::new(),
        n => format!("; {n} values not finite"),
    };
    format!("{means}{channels}{non_finite}")
}

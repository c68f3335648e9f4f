//! Differences of single channels, and of the layers that they belong to.

use std::collections::BTreeMap;

use super::COLOURS;
use super::overlap::Overlap;
use super::report::{ChannelDifference, Comparison, LayerDifference};

impl Comparison {
    /// What differs beside R, G and B, which all other numbers are about: layer by layer, in the order of their names.
    pub fn layers_that_differ(&self) -> Vec<LayerDifference> {
        let differ = self.channels.iter().filter(|channel| channel.n_different > 0 && !is_colour(&channel.name));
        let mut layers: BTreeMap<&str, Vec<&ChannelDifference>> = BTreeMap::new();
        differ.for_each(|channel| layers.entry(layer_of(&channel.name)).or_default().push(channel));
        layers.into_iter().map(|(name, channels)| of_layer(name, &channels)).collect()
    }

    /// Layers that only the first picture has, and channels that it alone has of shared layers.
    pub fn layers_only_in_a(&self) -> Vec<&str> {
        self.only_in(&self.only_in_a)
    }

    /// The same of the second.
    pub fn layers_only_in_b(&self) -> Vec<&str> {
        self.only_in(&self.only_in_b)
    }

    fn only_in<'a>(&'a self, names: &'a [String]) -> Vec<&'a str> {
        let is_shared = |layer: &str| self.channels.iter().any(|channel| layer_of(&channel.name) == layer);
        let short = |name: &'a String| if is_shared(layer_of(name)) { name.as_str() } else { layer_of(name) };
        let mut names: Vec<&str> = names.iter().map(short).collect();
        // Channels come sorted, those of a layer side by side.
        names.dedup();
        names
    }
}

/// The layer of a channel: what stands before the last dot; a channel without one is a layer of its own.
fn layer_of(channel: &str) -> &str {
    channel.rsplit_once('.').map_or(channel, |(layer, _)| layer)
}

fn is_colour(channel: &str) -> bool {
    COLOURS.contains(&channel)
}

fn of_layer(name: &str, channels: &[&ChannelDifference]) -> LayerDifference {
    let finite: Vec<&&ChannelDifference> = channels.iter().filter(|channel| channel.rmse.is_finite()).collect();
    let n = finite.len() as f64;
    let mean = |value: &dyn Fn(&ChannelDifference) -> f64| finite.iter().map(|channel| value(channel)).sum::<f64>() / n;
    LayerDifference {
        name: name.into(),
        channels: channels.iter().map(|channel| channel.name.clone()).collect(),
        mean_a: mean(&|channel| channel.mean_a),
        mean_b: mean(&|channel| channel.mean_b),
        rmse: mean(&|channel| channel.rmse.powi(2)).sqrt(),
        n_non_finite: channels.iter().map(|channel| channel.n_non_finite).sum(),
    }
}

/// Compares one channel of both pictures.
pub(super) fn channel_difference(name: &str, overlap: &Overlap, a: &[f32], b: &[f32]) -> ChannelDifference {
    let (mut n, mut n_different, mut n_non_finite) = (0_u64, 0, 0);
    let (mut sum_a, mut sum_b, mut squares, mut max) = (0.0, 0.0, 0.0, 0.0_f64);
    for (a, b) in overlap.pairs().map(|(i, j)| (a[i], b[j])) {
        n_different += u64::from(a.to_bits() != b.to_bits());
        if !(a.is_finite() && b.is_finite()) {
            n_non_finite += 1;
            continue;
        }
        let (a, b) = (f64::from(a), f64::from(b));
        n += 1;
        sum_a += a;
        sum_b += b;
        squares += (a - b).powi(2);
        max = max.max((a - b).abs());
    }
    // Nothing over nothing is not a number.
    let mean = |sum: f64| sum / n as f64;
    ChannelDifference {
        name: name.into(),
        n_different,
        n_non_finite,
        mean_a: mean(sum_a),
        mean_b: mean(sum_b),
        rmse: mean(squares).sqrt(),
        max: if n > 0 { max } else { f64::NAN },
    }
}

#[cfg(test)]
mod tests {
    use crate::image::Picture;
    use crate::image::compare::compare;

    fn picture(channels: &[(&str, f32)]) -> Picture {
        let mut picture = Picture::new(2, 1);
        for (name, value) in [("R", 1.0), ("G", 1.0), ("B", 1.0)].iter().chain(channels) {
            picture.push(*name, vec![*value; 2]);
        }
        picture
    }

    #[test]
    fn layers_are_named_once_with_the_means_of_what_differs() {
        let a = picture(&[
            ("direct.R", 2.0),
            ("direct.G", 4.0),
            ("direct.B", 1.0),
            ("A", 0.5),
            ("glow.R", 1.0),
            ("glow.G", 1.0),
        ]);
        let b = picture(&[("direct.R", 1.0), ("direct.G", 2.0), ("direct.B", 1.0), ("A", 0.5), ("depth.Z", 1.0)]);
        let difference = compare(&a, &b).expect("comparable");
        assert_eq!(difference.n_different, 0);
        let layers = difference.layers_that_differ();
        let [direct] = layers.as_slice() else { panic!("{layers:?}") };
        assert_eq!(
            (direct.name.as_str(), direct.channels.as_slice()),
            ("direct", &["direct.G".into(), "direct.R".into()][..])
        );
        assert_eq!((direct.mean_a, direct.mean_b, direct.rmse), (3.0, 1.5, 2.5_f64.sqrt()));
        assert_eq!(difference.layers_only_in_a(), ["glow"]);
        assert_eq!(difference.layers_only_in_b(), ["depth"]);
        // One channel of a layer that both have.
        let more = picture(&[("direct.R", 2.0), ("direct.G", 4.0), ("direct.B", 1.0), ("A", 0.5), ("glow.R", 1.0)]);
        assert_eq!(compare(&a, &more).expect("comparable").layers_only_in_a(), ["glow.G"]);
    }

    #[test]
    fn a_layer_without_a_finite_value_differs_from_one_that_has_some() {
        let (a, b) = (picture(&[("glow.R", f32::NAN)]), picture(&[("glow.R", 1.0)]));
        let layers = compare(&a, &b).expect("comparable").layers_that_differ();
        assert!(matches!(layers.as_slice(), [one] if one.rmse.is_nan() && one.n_non_finite == 2), "{layers:?}");
        assert!(compare(&a, &a).expect("comparable").layers_that_differ().is_empty());
    }
}

//! Generated clouds: they are distributed as asked, hold what was asked, and their files say the same.

use std::f64::consts::PI;

use glam::DVec3;
use mie_cloud::optics::distribution::{Shape, SizeDistribution};
use mie_cloud::optics::material::Material;
use mie_cloud::scene::generate::{Cloud, CloudShape, Content, Form, GenerateError, Recipe, generate};
use mie_cloud::scene::model::{Particle, ParticleKind};
use statrs::distribution::{ContinuousCDF, Gamma, LogNormal};

/// Extinction efficiency with the interference structure of water at 550 nm (van de Hulst 1957, section 11.22).
fn q_ext(radius_m: f64) -> f64 {
    let rho = 4.0 * PI * radius_m / 550e-9 * 0.333;
    2.0 - 4.0 / rho * rho.sin() + 4.0 / (rho * rho) * (1.0 - rho.cos())
}

fn shape(name: &str, lengths_m: &[f64]) -> CloudShape {
    CloudShape::new(name, lengths_m).expect("a valid shape")
}

fn distribution(text: &str) -> SizeDistribution {
    SizeDistribution::parse(text, &|name| Err(name.into())).expect("a valid distribution")
}

fn make(recipe: &Recipe) -> Cloud {
    generate(recipe, &q_ext).expect("a valid recipe")
}

/// Fails when the sample's distance from the cumulative distribution is larger than one sample in a thousand has
/// (Kolmogorov 1933; asymptotic).
fn assert_kolmogorov_smirnov(what: &str, mut sample: Vec<f64>, cdf: impl Fn(f64) -> f64) {
    sample.sort_by(f64::total_cmp);
    let n = sample.len() as f64;
    let distance = sample
        .iter()
        .enumerate()
        .map(|(i, &x)| (cdf(x) - i as f64 / n).abs().max(((i + 1) as f64 / n - cdf(x)).abs()))
        .fold(0.0, f64::max);
    let limit = (-(0.001_f64 / 2.0).ln() / 2.0).sqrt() / n.sqrt();
    assert!(distance < limit, "{what}: distance {distance} above {limit}");
}

fn uniform(x: f64) -> f64 {
    x.clamp(0.0, 1.0)
}

#[test]
fn droplets_fill_a_ball_evenly() {
    let cloud = make(&Recipe { count: 20_000, seed: 3, ..Recipe::new(shape("ball", &[2.0])) });
    let points: Vec<_> = cloud.particles().map(|particle| particle.center_m).collect();
    assert_kolmogorov_smirnov("radius", points.iter().map(|p| p.length().powi(3)).collect(), uniform);
    for axis in 0..3 {
        let cosines = points.iter().map(|p| 0.5 * (1.0 + p[axis] / p.length())).collect();
        assert_kolmogorov_smirnov("direction", cosines, uniform);
    }
}

#[test]
fn droplets_fill_boxes_and_slabs_evenly() {
    for (name, size) in [("box", [1.0, 2.0, 3.0]), ("slab", [50.0, 0.5, 20.0])] {
        let cloud = make(&Recipe { count: 20_000, seed: 4, ..Recipe::new(shape(name, &size)) });
        for (axis, length) in size.iter().enumerate() {
            let along = cloud.particles().map(|p| p.center_m[axis] / length + 0.5).collect();
            assert_kolmogorov_smirnov(name, along, uniform);
        }
    }
}

#[test]
fn droplet_radii_follow_their_distribution() {
    let radii = |text: &str| {
        let recipe = Recipe { count: 20_000, distribution: distribution(text), ..Recipe::new(shape("ball", &[1.0])) };
        let cloud = make(&recipe);
        cloud.droplet_radii_um.expect("droplets have radii").into_iter().map(f64::from).collect::<Vec<_>>()
    };
    assert!(radii("mono:r=5um").iter().all(|&r| r == 5.0));
    // Hansen & Travis (1974): a gamma distribution of shape (1 - 2 b) / b and scale a b.
    let gamma = Gamma::new(8.0, 1.0 / 0.6).expect("valid parameters");
    assert_kolmogorov_smirnov("gamma", radii("gamma:reff=6um,veff=0.1"), |r| gamma.cdf(r));
    let lognormal = LogNormal::new(3_f64.ln(), 0.4).expect("valid parameters");
    assert_kolmogorov_smirnov("lognormal", radii("lognormal:rg=3um,sigma=0.4"), |r| lognormal.cdf(r));
}

#[test]
fn real_droplets_are_drawn_as_large_as_they_are() {
    let cloud = make(&Recipe { count: 1000, ..Recipe::new(shape("ball", &[0.37])) });
    assert_eq!(cloud.summary.magnification, 1.0);
    for particle in cloud.particles() {
        // Two roundings to f32, 6e-8 each.
        assert!((particle.radius_m / particle.droplet_radius_m - 1.0).abs() < 3e-7);
        assert_eq!((particle.count, particle.kind), (1.0, ParticleKind::Droplet));
    }
}

#[test]
fn magnified_droplets_have_the_optical_depth_that_was_asked() {
    for (name, size, shadow_m2, chord_over_mean) in
        [("ball", vec![2.0], PI, 1.5), ("box", vec![2.0, 3.0, 4.0], 12.0, 1.0), ("slab", vec![9.0], 81.0, 1.0)]
    {
        for count in [300, 5000] {
            let recipe = Recipe { count, content: Content::OpticalDepth(2.5), ..Recipe::new(shape(name, &size)) };
            let cloud = make(&recipe);
            let discs: f64 = cloud
                .particles()
                .map(|p| q_ext(f64::from(p.droplet_radius_m)) * PI * f64::from(p.radius_m).powi(2))
                .sum();
            // 1e-3: the table of efficiencies that stands for more than a thousand droplets.
            assert!((discs / shadow_m2 * chord_over_mean / 2.5 - 1.0).abs() < 1e-3, "{name} {count}");
            assert!((cloud.summary.optical_depth / 2.5 - 1.0).abs() < 1e-12);
            // One factor for all, so that each keeps its own efficiency.
            for p in cloud.particles() {
                let drawn = f64::from(p.radius_m) / f64::from(p.droplet_radius_m);
                assert!((drawn / cloud.summary.magnification - 1.0).abs() < 3e-7);
            }
        }
    }
}

#[test]
fn the_mean_transmittance_of_magnified_droplets_is_that_of_their_optical_depth() {
    // Q_ext = 2: the extinction disc of a droplet has the radius sqrt(2) R, and is opaque.
    let (count, tau, n_rays) = (4000, 1.2, 40_000);
    let recipe = Recipe {
        count,
        distribution: distribution("mono:r=5um"),
        content: Content::OpticalDepth(tau),
        ..Recipe::new(shape("box", &[1.0]))
    };
    let cloud = generate(&recipe, &|_| 2.0).expect("a valid recipe");
    let discs: Vec<_> =
        cloud.particles().map(|p| (p.center_m.x, p.center_m.z, 2.0 * f64::from(p.radius_m).powi(2))).collect();
    // Rays along y through a regular grid, away from the faces by more than a disc.
    let side = (n_rays as f64).sqrt() as i32;
    let clear = (0..side * side)
        .filter(|i| {
            let at = |step: i32| 0.96 * ((f64::from(step) + 0.5) / f64::from(side) - 0.5);
            let (x, z) = (at(i / side), at(i % side));
            !discs.iter().any(|(cx, cz, r2)| (x - cx).powi(2) + (z - cz).powi(2) < *r2)
        })
        .count();
    let transmittance = clear as f64 / n_rays as f64;
    let expected = (-tau).exp();
    // A disc covers a = tau / N of the area; gaps are correlated over about one disc, so there are N / tau independent ones.
    let error = (expected * (1.0 - expected) * tau / count as f64).sqrt();
    assert!((transmittance - expected).abs() < 4.0 * error, "{transmittance} against {expected} +- {error}");
}

#[test]
fn parcels_share_out_the_liquid_water() {
    for patchiness in [0.0, 0.8] {
        let recipe = Recipe {
            count: 3000,
            kind: ParticleKind::Parcel,
            content: Content::LiquidWaterGPerM3(0.2),
            patchiness,
            ..Recipe::new(shape("slab", &[100.0, 10.0, 100.0]))
        };
        let cloud = make(&recipe);
        let droplets: f64 = cloud.particles().map(|p| f64::from(p.count)).sum();
        let grams = droplets * recipe.distribution.law().mean_volume_m3() * 998.2e3;
        // f32 counts, three thousand of them.
        assert!((grams / (0.2 * 1e5) - 1.0).abs() < 1e-6, "{grams}");
        assert!((cloud.summary.liquid_water_g_per_m3 - 0.2).abs() < 1e-12);
        let counts = cloud.droplet_counts.expect("parcels have counts");
        let spread = counts.iter().copied().fold(0.0, f32::max) / counts.iter().copied().fold(f32::INFINITY, f32::min);
        assert!(if patchiness == 0.0 { spread == 1.0 } else { spread > 4.0 }, "{spread}");
        assert!(cloud.droplet_radii_um.is_none());
    }
}

#[test]
fn a_gram_of_ice_makes_more_particles_than_a_gram_of_water() {
    let water = Recipe {
        kind: ParticleKind::Parcel,
        content: Content::LiquidWaterGPerM3(0.05),
        ..Recipe::new(shape("box", &[50.0]))
    };
    let ice = Recipe { material: Material::Ice, ..water.clone() };
    let (water, ice) = (make(&water), make(&ice));
    // Densities at 20 C and 0 C, kg/m^3.
    assert!((ice.summary.droplets / water.summary.droplets - 998.2 / 917.0).abs() < 1e-9);
    assert_eq!(
        (&water.settings["droplets"]["material"], &ice.settings["droplets"]["material"]),
        (&"water".into(), &"ice".into())
    );
}

#[test]
fn parcels_have_the_optical_depth_that_was_asked_through_the_centre() {
    for (name, size, n_seeds) in [
        ("ball", vec![8.0], 40),
        ("box", vec![8.0, 7.0, 9.0], 40),
        ("droplet", vec![3.0], 40),
        ("cumulus", vec![8.0], 6),
        ("puff", vec![9.0, 7.0, 8.0], 6),
    ] {
        let columns: Vec<f64> = (0..n_seeds)
            .map(|seed| {
                let recipe = Recipe {
                    count: 2000,
                    kind: ParticleKind::Parcel,
                    content: Content::OpticalDepth(3.0),
                    seed,
                    ..Recipe::new(shape(name, &size))
                };
                let c_ext_m2 = recipe.distribution.law().mean(|r| q_ext(r) * PI * r * r);
                let cloud = make(&recipe);
                let middle = cloud.particles().map(|p| {
                    let radius_m = f64::from(p.radius_m);
                    let off = (radius_m * radius_m - p.center_m.x.powi(2) - p.center_m.z.powi(2)).max(0.0);
                    f64::from(p.count) * c_ext_m2 / (4.0 / 3.0 * PI * radius_m.powi(3)) * 2.0 * off.sqrt()
                });
                middle.sum()
            })
            .collect();
        let n = columns.len() as f64;
        let mean = columns.iter().sum::<f64>() / n;
        let deviation = (columns.iter().map(|c| (c - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
        // Four standard errors, and the table of efficiencies.
        assert!((mean - 3.0).abs() < 4.0 * deviation / n.sqrt() + 3e-3, "{name}: {mean} +- {deviation}");
    }
}

#[test]
fn droplets_of_a_cumulus_have_the_optical_depth_that_was_asked_through_the_centre() {
    let (tau, half_m, n_seeds) = (2.0, 0.015, 5);
    let in_the_middle: Vec<f64> = (0..n_seeds)
        .flat_map(|seed| {
            let content = Content::OpticalDepth(tau);
            let cloud = make(&Recipe { count: 25_000, content, seed, ..Recipe::new(shape("cumulus", &[1.0])) });
            let near = |p: &Particle| p.center_m.x.abs() < half_m && p.center_m.z.abs() < half_m;
            let disc = |p: Particle| q_ext(f64::from(p.droplet_radius_m)) * PI * f64::from(p.radius_m).powi(2);
            cloud.particles().filter(near).map(disc).collect::<Vec<_>>()
        })
        .collect();
    let mean = in_the_middle.iter().sum::<f64>() / (4.0 * half_m * half_m) / n_seeds as f64;
    // Four standard errors of a sum of as many random discs (6 %), and 4 % for the cloud's change over the middle square.
    let deviation = in_the_middle.iter().map(|c| c * c).sum::<f64>().sqrt() / in_the_middle.iter().sum::<f64>();
    assert!(deviation < 0.08, "{deviation}");
    assert!((mean / tau - 1.0).abs() < 4.0 * deviation + 0.04, "{mean} +- {deviation}");
}

#[test]
fn grown_clouds_fill_their_box_and_no_more() {
    for (name, size) in [("cumulus", [3.0, 2.0, 4.0]), ("puff", [1.0, 2.0, 1.5])] {
        for seed in 0..4 {
            let cloud = make(&Recipe { count: 5000, seed, ..parcels_of(shape(name, &size)) });
            for (axis, length) in size.iter().enumerate() {
                let along = || cloud.particles().map(|p| p.center_m[axis] / (0.5 * length));
                let (low, high) = (along().fold(f64::INFINITY, f64::min), along().fold(f64::NEG_INFINITY, f64::max));
                // f32 rounding outside; thin outermost wisps may stay empty.
                assert!(low >= -1.000_001 && high <= 1.000_001, "{name} {seed}: {low} {high}");
                assert!(low < -0.7 && high > 0.7, "{name} {seed} {axis}: {low} {high}");
            }
        }
    }
}

fn parcels_of(shape: CloudShape) -> Recipe {
    Recipe { kind: ParticleKind::Parcel, ..Recipe::new(shape) }
}

#[test]
fn a_cumulus_has_a_flat_base_and_water_that_grows_evenly_with_height() {
    let cloud = make(&Recipe { count: 20_000, seed: 2, ..parcels_of(shape("cumulus", &[1000.0, 800.0, 1000.0])) });
    let height = |p: &Particle| p.center_m.y + 400.0;
    let bottom: Vec<_> = cloud.particles().filter(|p| height(p) < 40.0).collect();
    // The lowest twentieth is as wide as the cloud: a base, not a point.
    let reach = |axis: usize| bottom.iter().map(|p| p.center_m[axis].abs()).fold(0.0, f64::max);
    assert!(bottom.len() > 300 && reach(0) > 350.0 && reach(2) > 350.0, "{} {}", bottom.len(), reach(0));
    // Deep inside, where nothing mixes in, water per volume over height is one number.
    let largest = cloud.particles().map(|p| p.radius_m).fold(0.0, f32::max);
    let inner = cloud.particles().filter(|p| p.radius_m == largest && height(p) > 250.0);
    let adiabatic: Vec<f64> = inner.map(|p| f64::from(p.count) / height(&p)).collect();
    let mean = adiabatic.iter().sum::<f64>() / adiabatic.len() as f64;
    assert!(adiabatic.len() > 100, "{}", adiabatic.len());
    // Water is that of the middle of a cell, 9 m high: 4.5 m of 250.
    assert!(adiabatic.iter().all(|ratio| (ratio / mean - 1.0).abs() < 0.025));
}

#[test]
fn parcels_of_a_cumulus_overlap_to_a_smooth_cloud() {
    let cloud = make(&Recipe { seed: 5, ..parcels_of(shape("cumulus", &[1000.0])) });
    let parcels: Vec<_> = cloud.particles().collect();
    let largest = parcels.iter().map(|p| p.radius_m).fold(0.0, f32::max);
    let inner = parcels.iter().filter(|p| p.radius_m == largest && p.center_m.y > -150.0);
    // Between the centres of parcels, one surface radius beside each.
    let ratios: Vec<f64> = inner
        .map(|p| {
            let point = p.center_m + DVec3::new(1.0, 0.0, 1.0) * f64::from(p.radius_m) / 4.0;
            let per_m3 = |q: &Particle| f64::from(q.count) / f64::from(q.radius_m).powi(3);
            let covers = |q: &&Particle| (q.center_m - point).length() < f64::from(q.radius_m);
            parcels.iter().filter(covers).map(per_m3).sum::<f64>() / (point.y + 350.0)
        })
        .collect();
    let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
    let rms = (ratios.iter().map(|r| (r / mean - 1.0).powi(2)).sum::<f64>() / ratios.len() as f64).sqrt();
    // Fourteen parcels at random would vary by 27 %; that they take turns in space evens it out.
    assert!(ratios.len() > 60 && rms < 0.23, "{} {rms}", ratios.len());
}

#[test]
fn a_single_droplet_stands_in_the_middle_as_large_as_asked() {
    let recipe = Recipe { distribution: distribution("mono:r=1736nm"), ..Recipe::new(shape("droplet", &[1.0])) };
    let cloud = make(&recipe);
    let particles: Vec<_> = cloud.particles().collect();
    assert_eq!((particles.len(), particles[0].center_m.length(), particles[0].radius_m), (1, 0.0, 0.5));
    assert!((particles[0].droplet_radius_m / 1736e-9 - 1.0).abs() < 2e-7);
    assert!(cloud.warnings.iter().any(|warning| warning.what.contains("one droplet")));
    assert!(make(&Recipe { count: 1, ..recipe }).warnings.is_empty());
}

#[test]
fn parcels_of_a_table_hold_one_size_each_because_the_table_stays_behind() {
    let shape_of_table = Shape::Table {
        name: "sizes.csv".into(),
        r_m: [2e-6, 4e-6, 8e-6].into_iter().collect(),
        dn_dr: [0.0, 1.0, 0.0].into_iter().collect(),
    };
    let distribution = SizeDistribution::new(shape_of_table, None, None).expect("a valid table");
    let recipe = Recipe { count: 1000, kind: ParticleKind::Parcel, distribution, ..Recipe::new(shape("box", &[5.0])) };
    let cloud = make(&recipe);
    assert!(!cloud.settings["droplets"].as_object().is_some_and(|droplets| droplets.contains_key("distribution")));
    let radii = cloud.droplet_radii_um.expect("one size per parcel");
    assert!(radii.iter().all(|r| (2.0..=8.0).contains(r)) && radii[0] != radii[1]);
}

#[test]
fn positions_stay_in_a_comfortable_range_at_every_size() {
    for size in [1e-6, 3.7e-3, 1.0, 12_345.0, 1e8] {
        let cloud = make(&Recipe {
            count: 200,
            distribution: distribution("mono:r=1um"),
            content: Content::OpticalDepth(0.5),
            ..Recipe::new(shape("ball", &[size]))
        });
        let half = 0.5 * size / cloud.metres_per_unit;
        assert!(half > 50.0 && half <= 100.0, "{size}: {half}");
        assert!(cloud.radii.iter().all(|&r| (1.0..20.0).contains(&r)), "{size}: {:?}", cloud.radii[0]);
        let camera = &cloud.camera;
        assert!(camera.position_m.z > 0.5 * size && camera.position_m.z < 3.0 * size);
    }
}

#[test]
fn recipes_that_make_no_cloud_are_refused_with_the_flag_to_change() {
    let ball = Recipe::new(shape("ball", &[1.0]));
    let parcels = Recipe { kind: ParticleKind::Parcel, ..ball.clone() };
    let cases = [
        (Recipe { count: 0, ..ball.clone() }, "--count"),
        (Recipe { count: 1_000_000_000, ..ball.clone() }, "--count"),
        (Recipe { count: u64::MAX, form: Form::Instances, ..ball.clone() }, "--count"),
        (Recipe { count: 1000, memory_limit_bytes: 20_000, ..ball.clone() }, "--count"),
        (Recipe { shape: CloudShape::Ball { diameter_m: 0.0 }, ..ball.clone() }, "--size"),
        (Recipe { shape: CloudShape::Box { size_m: [1.0, f64::NAN, 1.0] }, ..ball.clone() }, "--size"),
        (Recipe { shape: CloudShape::Slab { size_m: [1.0, 1.0, f64::INFINITY] }, ..ball.clone() }, "--size"),
        (Recipe { content: Content::OpticalDepth(0.0), ..ball.clone() }, "--optical-depth"),
        (Recipe { content: Content::OpticalDepth(f64::NAN), ..parcels.clone() }, "--optical-depth"),
        (Recipe { content: Content::LiquidWaterGPerM3(-0.3), ..parcels.clone() }, "--liquid-water"),
        (Recipe { patchiness: 1.5, ..ball.clone() }, "--patchiness"),
        (Recipe { overlap: f64::NAN, ..parcels.clone() }, "--overlap"),
        (Recipe { shape: CloudShape::Ball { diameter_m: 1e-4 }, ..ball.clone() }, "--size"),
        (Recipe { count: 1, content: Content::OpticalDepth(9.0), ..ball.clone() }, "--count"),
        (Recipe { shape: CloudShape::Ball { diameter_m: 1e-3 }, ..parcels.clone() }, "--kind droplets"),
        (Recipe { content: Content::OpticalDepth(1e300), ..parcels.clone() }, "--optical-depth"),
        (Recipe { distribution: distribution("mono:r=9km"), ..ball.clone() }, "--distribution"),
    ];
    for (recipe, flag) in cases {
        match generate(&recipe, &q_ext) {
            Err(error) => assert!(error.to_string().contains(flag), "{error} does not name {flag}"),
            Ok(_) => panic!("accepted: {recipe:?}"),
        }
    }
    let error = generate(&ball, &|_| f64::NAN);
    assert!(matches!(error, Err(GenerateError::Extinction { .. })));
}

#[test]
fn too_many_droplets_are_counted_out_in_bytes() {
    let recipe = Recipe { count: 1_000_000_000, ..Recipe::new(shape("ball", &[1.0])) };
    match recipe.check() {
        Err(GenerateError::TooLarge { bytes, limit_bytes, max_count, .. }) => {
            assert_eq!(bytes, 24_000_000_000);
            assert!(u128::from(limit_bytes) < bytes && max_count * 24 <= limit_bytes);
            assert!(Recipe { count: max_count, ..recipe }.check().is_ok());
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn clouds_that_do_not_look_as_asked_come_with_a_warning() {
    let ball = Recipe::new(shape("ball", &[1.0]));
    let says = |recipe: &Recipe, part: &str| make(recipe).warnings.iter().any(|w| w.to_string().contains(part));
    assert!(make(&Recipe { content: Content::OpticalDepth(1.0), ..ball.clone() }).warnings.is_empty());
    assert!(says(&Recipe { shape: shape("ball", &[1.2e-3]), ..ball.clone() }, "independently"));
    assert!(says(&Recipe { content: Content::OpticalDepth(1e-9), ..ball.clone() }, "own size"));
    assert!(says(&Recipe { count: 3, content: Content::OpticalDepth(3.0), ..ball.clone() }, "stick out"));
    let thin = Recipe { count: 500, kind: ParticleKind::Parcel, ..Recipe::new(shape("slab", &[100.0, 1.0, 100.0])) };
    assert!(says(&thin, "too few"));
}

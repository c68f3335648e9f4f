//! The tree finds exactly what testing every body finds: random, coincident, nested and overlapping particles, in clouds
//! near and far, large and tiny.

use glam::{DMat3, DVec3};
use mie_cloud::accel::{Accel, BodyKind, Crossing, Placed, PlacedBox};
use proptest::prelude::*;

/// An independent, naive reading of what a ray meets: distances along it, in metres.
fn brute_force(particles: &[Placed], boxes: &[PlacedBox], origin: DVec3, direction: DVec3) -> Vec<(u32, f64, f64)> {
    let mut found = Vec::new();
    for (id, p) in particles.iter().enumerate() {
        let v = p.center_m - origin;
        let t = v.dot(direction);
        let offset = (v - t * direction).length();
        let r = f64::from(p.radius_m);
        if offset < r {
            let half = if p.kind == BodyKind::Ball { ((r - offset) * (r + offset)).sqrt() } else { 0.0 };
            if t + half > 0.0 {
                found.push((id as u32, t - half, t + half));
            }
        }
    }
    for (i, b) in boxes.iter().enumerate() {
        if let Some((t0, t1)) = clip_box(b, origin, direction).filter(|(_, t1)| *t1 > 0.0) {
            found.push(((particles.len() + i) as u32, t0, t1));
        }
    }
    found
}

fn clip_box(b: &PlacedBox, origin: DVec3, direction: DVec3) -> Option<(f64, f64)> {
    let inverse = b.half_edges_m.inverse();
    let (o, d) = (inverse * (origin - b.center_m), inverse * direction);
    let slabs = (0..3).map(|i| {
        let (a, c) = ((-1.0 - o[i]) / d[i], (1.0 - o[i]) / d[i]);
        (a.min(c), a.max(c))
    });
    let (t0, t1) = slabs.fold((f64::MIN, f64::MAX), |(lo, hi), (a, c)| (lo.max(a), hi.min(c)));
    (t0 < t1).then_some((t0, t1))
}

fn unit() -> impl Strategy<Value = DVec3> {
    (-1.0..1.0f64, 0.0..std::f64::consts::TAU).prop_map(|(z, phi)| {
        let s = (1.0 - z * z).sqrt();
        DVec3::new(s * phi.cos(), s * phi.sin(), z)
    })
}

fn point() -> impl Strategy<Value = DVec3> {
    (-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64).prop_map(|(x, y, z)| DVec3::new(x, y, z))
}

/// A particle on a coarse grid (so that many coincide), or anywhere, with radii over five decades.
fn particle() -> impl Strategy<Value = Placed> {
    (point(), any::<bool>(), -5.0..-0.3f64, any::<bool>()).prop_map(|(p, snap, log_r, droplet)| Placed {
        center_m: if snap { (p * 2.0).round() / 2.0 } else { p },
        radius_m: 10f64.powf(if snap { log_r.round() } else { log_r }) as f32,
        load: 1.0,
        bin: 0,
        kind: if droplet { BodyKind::Droplet } else { BodyKind::Ball },
    })
}

fn fog_box() -> impl Strategy<Value = PlacedBox> {
    (point(), unit(), 0.01..0.5f64).prop_map(|(center_m, axis, size)| {
        let rotation = DMat3::from_quat(glam::DQuat::from_axis_angle(axis, size * 7.0));
        let half_edges_m = rotation * DMat3::from_diagonal(DVec3::new(size, 0.5 * size, 2.0 * size));
        PlacedBox { center_m, half_edges_m, number_per_m3: 1.0, bin: 0 }
    })
}

/// Where the whole scene is put: its size and its distance from the origin.
fn placement() -> impl Strategy<Value = (f64, DVec3)> {
    (prop::sample::select(vec![1e-6, 1e-3, 1.0, 1e3, 1e6]), point(), prop::sample::select(vec![0.0, 1.0, 1e3]))
        .prop_map(|(scale, direction, distance)| (scale, direction * distance * scale))
}

/// Merged bodies stand for all that coincide; every member has the same crossing, so compare by crossing.
fn check(particles: Vec<Placed>, boxes: Vec<PlacedBox>, origin: DVec3, direction: DVec3, scale: f64) {
    let expected = brute_force(&particles, &boxes, origin, direction);
    let accel = Accel::build(particles, &boxes);
    let ray = accel.local_ray(origin, direction);
    let mut found = Vec::new();
    let mut number = 0.0;
    accel.all(&ray, 0.0, f64::INFINITY, |body, crossing| {
        found.push(body.id);
        number += if body.kind() == BodyKind::Box { 1.0 } else { f64::from(body.load) };
        let (_, t0, t1) = expected.iter().find(|(id, ..)| *id == body.id).expect("the tree found what is not there");
        // Positions are rounded once, when the cloud's origin is taken off: 1e-16 of the distance of 1e3 scales.
        assert!((crossing.start() - t0).abs() < 1e-9 * scale.max(t0.abs()), "{} {t0}", crossing.start());
        assert!((crossing.end() - t1).abs() < 1e-9 * scale.max(t1.abs()));
    });
    assert_eq!(number as usize, expected.len(), "bodies met, coincident ones included");
    found.sort_unstable();
    found.dedup();
    let first = accel.closest(&ray, 0.0, None, |_, crossing| Some(crossing.start().max(1e-12 * scale)));
    let nearest = expected.iter().map(|(_, t0, _)| t0.max(1e-12 * scale)).filter(|t| *t > 0.0).reduce(f64::min);
    match (first, nearest) {
        (Some(hit), Some(t)) => assert!((hit.t_m - t).abs() < 1e-9 * scale.max(t), "{} against {t}", hit.t_m),
        (None, None) => {}
        other => panic!("closest differs: {other:?}"),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 600, rng_seed: proptest::test_runner::RngSeed::Fixed(7), ..ProptestConfig::default() })]

    #[test]
    fn the_tree_finds_what_brute_force_finds(
        particles in prop::collection::vec(particle(), 0..200),
        boxes in prop::collection::vec(fog_box(), 0..4),
        target in point(),
        from in point(),
        distance in prop::sample::select(vec![0.0, 2.0, 1e3]),
        axis in prop::sample::select(vec![None, Some(DVec3::X), Some(DVec3::NEG_Y), Some(DVec3::NEG_Z)]),
        (scale, shift) in placement(),
    ) {
        let place = |p: DVec3| p * scale + shift;
        let particles: Vec<Placed> = particles.iter().map(|p| Placed { center_m: place(p.center_m), radius_m: p.radius_m * scale as f32, ..*p }).collect();
        let boxes: Vec<PlacedBox> = boxes.iter().map(|b| PlacedBox { center_m: place(b.center_m), half_edges_m: b.half_edges_m * scale, ..*b }).collect();
        let direction = axis.unwrap_or((target - from).normalize_or(DVec3::X));
        let origin = place(target - direction * distance);
        check(particles, boxes, origin, direction, scale);
    }
}

/// A ray from far away that grazes one small droplet of a large cloud, many times.
#[test]
fn no_droplet_is_lost_among_a_hundred_thousand() {
    use rand::{RngExt, SeedableRng};
    let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(3);
    for scale in [1e-5, 1.0, 1e4] {
        let mut uniform = || DVec3::new(rng.random(), rng.random(), rng.random()) * scale;
        let particles: Vec<Placed> = (0..100_000)
            .map(|_| Placed {
                center_m: uniform(),
                radius_m: (2e-4 * scale) as f32,
                load: 1.0,
                bin: 0,
                kind: BodyKind::Droplet,
            })
            .collect();
        let accel = Accel::build(particles.clone(), &[]);
        for (id, particle) in particles.iter().enumerate().step_by(4) {
            let origin = uniform() * 3.0 - scale;
            let aim = particle.center_m + (uniform() / scale - 0.5).normalize() * f64::from(particle.radius_m) * 0.5;
            let direction = (aim - origin).normalize();
            let ray = accel.local_ray(origin, direction);
            let mut met = false;
            accel.all(&ray, 0.0, f64::INFINITY, |body, _| met |= body.id == id as u32);
            assert!(met, "droplet {id} at scale {scale}");
            let hit = accel.closest(&ray, 0.0, None, |body, crossing| (body.id == id as u32).then(|| crossing.start()));
            assert_eq!(hit.map(|h| h.id), Some(id as u32));
        }
    }
}

#[test]
fn a_million_particles_in_one_point_are_one() {
    let one = Placed { center_m: DVec3::ONE, radius_m: 1e-5, load: 1.0, bin: 0, kind: BodyKind::Droplet };
    let accel = Accel::build(vec![one; 1_000_000], &[]);
    assert_eq!(accel.len(), 1);
    let ray = accel.local_ray(DVec3::ZERO, DVec3::ONE.normalize());
    let mut load = 0.0;
    accel.all(&ray, 0.0, f64::INFINITY, |body, crossing| {
        assert!(matches!(crossing, Crossing::Point(_)));
        load += f64::from(body.load);
    });
    assert_eq!(load, 1e6);
}

/// What is found does not depend on the processor's vector instructions.
#[test]
fn every_walk_finds_the_same() {
    use rand::{RngExt, SeedableRng};
    let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(11);
    let mut at = || DVec3::new(rng.random(), rng.random(), rng.random());
    let particles: Vec<Placed> = (0..20_000)
        .map(|_| Placed { center_m: at(), radius_m: 5e-3, load: 1.0, bin: 0, kind: BodyKind::Ball })
        .collect();
    let fast = Accel::build(particles.clone(), &[]);
    let plain = Accel::build(particles, &[]).without_simd();
    for _ in 0..2_000 {
        let (origin, direction) = (at() * 3.0 - 1.0, (at() - 0.5).normalize());
        let met = |accel: &Accel| {
            let mut found = Vec::new();
            let ray = accel.local_ray(origin, direction);
            accel.all(&ray, 0.0, f64::INFINITY, |body, crossing| found.push((body.id, crossing.start().to_bits())));
            (found, accel.closest(&ray, 0.0, None, |_, crossing| Some(crossing.start().max(1e-9))))
        };
        assert_eq!(met(&fast), met(&plain));
    }
}

/// Shells about one centre, and a chain of ever smaller neighbours: both make obvhs' own tree a list.
#[test]
fn nested_shells_and_geometric_chains_keep_the_tree_shallow() {
    let shells = (0..50_000).map(|i| (DVec3::ZERO, 1.0 + i as f64 * 1e-5));
    let chain = (0..2_000).map(|i| 0.98f64.powi(i)).map(|x| (DVec3::new(x, 0.0, 0.0), 0.5 * x));
    let particles: Vec<Placed> = shells
        .chain(chain)
        .map(|(center_m, r)| Placed { center_m, radius_m: r as f32, load: 1.0, bin: 0, kind: BodyKind::Ball })
        .collect();
    let (origin, direction) = (DVec3::new(-5.0, 0.3, 0.1), DVec3::new(5.2, -0.2, -0.1).normalize());
    check(particles, Vec::new(), origin, direction, 1.0);
}

#[test]
fn nothing_is_met_where_nothing_is() {
    let accel = Accel::build(Vec::new(), &[]);
    assert!(accel.is_empty() && accel.bounds_m().is_none());
    let ray = accel.local_ray(DVec3::ZERO, DVec3::X);
    assert_eq!(accel.closest(&ray, 0.0, None, |_, c| Some(c.start())), None);
}

/// Sums over what a ray meets are taken in the tree's order, so the tree must not depend on the number of threads.
#[test]
fn the_tree_is_the_same_for_any_number_of_threads() {
    use rand::{RngExt, SeedableRng};
    let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(9);
    let mut at = || DVec3::new(rng.random(), rng.random(), rng.random());
    let particles: Vec<Placed> = (0..200_000)
        .map(|_| Placed { center_m: at(), radius_m: 1e-3, load: 1.0, bin: 0, kind: BodyKind::Ball })
        .collect();
    let order = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let accel = pool.install(|| Accel::build(particles.clone(), &[]));
        (0..accel.len() as u32).map(|i| accel.body(i).id).collect::<Vec<_>>()
    };
    let one = order(1);
    assert_eq!(one, order(2));
    assert_eq!(one, order(7));
}

/// Rationale: what breaks builders: boxes that are all the same, clouds that are flat, thin, dots, as large as numbers go, and chains
/// in which each is a little smaller. Expected: found as by brute force, in bounded time and at most a node for each.
#[test]
fn degenerate_clouds_are_built_and_searched_in_bounded_time() {
    let n = 30_000;
    let ball = |center_m: DVec3, radius_m: f64| Placed {
        center_m,
        radius_m: radius_m as f32,
        load: 1.0,
        bin: 0,
        kind: BodyKind::Ball,
    };
    let of = |f: &dyn Fn(f64) -> (DVec3, f64)| -> Vec<Placed> {
        (0..n).map(|i| f(f64::from(i) / f64::from(n))).map(|(center_m, r)| ball(center_m, r)).collect()
    };
    let square = |t: f64| DVec3::new((t * 173.0).fract(), t, 0.0);
    let clouds: [(&str, f64, Vec<Placed>); 11] = [
        ("nearly one box", 1.0, of(&|t| (DVec3::new(1e-12 * t, 0.0, 0.0), 1.0))),
        ("one axis huge", 1e12, of(&|t| (DVec3::new(1e12 * t, t, -t), 0.5))),
        ("one axis huge, large balls", 1e12, of(&|t| (DVec3::new(1e12 * t, t, -t), 1e8))),
        ("a sheet", 1.0, of(&|t| (square(t), 0.01))),
        ("a thread", 1.0, of(&|t| (DVec3::new(t, 1e-9 * t, 0.0), 1e-6))),
        ("as large as it goes", 1e30, of(&|t| (1e30 * DVec3::new(t, (t * 31.0).fract(), (t * 173.0).fract()), 1e28))),
        ("as far as it goes", 1e30, of(&|t| (DVec3::splat(1e30) + t, 1.0))),
        ("as small as it goes", 1e-30, of(&|t| (1e-30 * square(t), 1e-32))),
        ("a chain to nothing", 1.0, of(&|t| (DVec3::new(f64::exp2(-900.0 * t), 0.0, 0.0), f64::exp2(-100.0 * t)))),
        ("one giant among dwarfs", 1e6, of(&|t| (square(t), if t == 0.0 { 1e6 } else { 1e-4 }))),
        ("powers of ten", 1e6, of(&|t| (f64::powf(10.0, 12.0 * t - 6.0) * DVec3::new(1.0, -1.0, 0.5), 1e-3))),
    ];
    for (name, scale, particles) in clouds {
        let start = std::time::Instant::now();
        let accel = Accel::build(particles.clone(), &[]);
        assert!(accel.tree_bytes() <= 64 * particles.len(), "{name}: {} bytes of tree", accel.tree_bytes());
        assert!(start.elapsed().as_secs() < 20, "{name}: {:?}", start.elapsed());
        let middle = particles[particles.len() / 2].center_m;
        for direction in [DVec3::X, DVec3::new(0.3, -0.8, 0.52).normalize(), DVec3::NEG_Z] {
            // From beyond the cloud, through a ball's middle.
            let origin_m = middle - direction * 3.0 * scale;
            let ray = accel.local_ray(origin_m, direction);
            let mut met = Vec::new();
            accel.all(&ray, 0.0, f64::INFINITY, |body, _| met.push(body.load));
            let expected = brute_force(&particles, &[], origin_m, direction).len() as f64;
            // A ray whose origin is rounded may pass what it only just touches.
            let found: f64 = met.iter().map(|load| f64::from(*load)).sum();
            assert!((found - expected).abs() <= 2.0 + 1e-3 * expected, "{name}: {found} of {expected}");
            assert!(accel.closest(&ray, 0.0, None, |_, crossing| Some(crossing.end())).is_some() || found == 0.0);
        }
    }
}

/// Dots without any size, boxes that are all the same, and boxes as thin as numbers go.
#[test]
fn dots_and_equal_boxes_are_no_trouble() {
    let dot = |i: usize| Placed {
        center_m: DVec3::splat(if i.is_multiple_of(2) { 0.25 } else { 0.0 }),
        radius_m: 0.0,
        load: 1.0,
        bin: 0,
        kind: BodyKind::Droplet,
    };
    for n in [1, 17, 1000] {
        for dots in [(0..n).map(dot).collect(), vec![dot(0); n]] as [Vec<Placed>; 2] {
            let accel = Accel::build(dots, &[]);
            let ray = accel.local_ray(DVec3::splat(0.25) - DVec3::X, DVec3::X);
            let hit = accel.closest(&ray, 0.0, None, |_, crossing| Some(crossing.start()));
            assert!(hit.is_none_or(|hit| (hit.t_m - 1.0).abs() < 1e-12), "{hit:?}");
        }
    }
    let start = std::time::Instant::now();
    for half_m in [DVec3::ONE, DVec3::new(1.0, 1e-12, 1.0), DVec3::splat(1e-9)] {
        let fog =
            PlacedBox { center_m: DVec3::ONE, half_edges_m: DMat3::from_diagonal(half_m), number_per_m3: 1.0, bin: 0 };
        let accel = Accel::build(Vec::new(), &vec![fog; 20_000]);
        let ray = accel.local_ray(DVec3::new(1.0, 1.0, 9.0), DVec3::NEG_Z);
        let mut met = 0;
        accel.all(&ray, 0.0, f64::INFINITY, |_, crossing| {
            met += 1;
            assert!((crossing.end() - crossing.start() - 2.0 * half_m.z).abs() < 1e-12);
        });
        assert_eq!(met, 20_000, "{half_m}");
    }
    assert!(start.elapsed().as_secs() < 20, "{:?}", start.elapsed());
}

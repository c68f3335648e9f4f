//! One sphere and tables of spheres against the crate `scatrs`: times of both and their ratio, in one run.
//!
//! `cargo bench --bench mie`. Both use one thread, memory kept between spheres, and real water-like m = 1.33 or
//! an absorbing 1.5 + 0.01i. The last table on standard output has the medians and the ratios.

use std::{
    cell::RefCell,
    collections::BTreeMap,
    f64::consts::PI,
    hint::black_box,
    time::{Duration, Instant},
};

use criterion::Criterion;
use mie_cloud::mie::{Angles, IntensitySum, Solver};
use num_complex::Complex64;
use scatrs::mie::{AmplitudeBuffers, AngularTable, Mie, MieOptions};

const SIZES: [f64; 5] = [1.0, 10.0, 100.0, 1000.0, 1e4];
const INDICES: [(&str, Complex64); 2] =
    [("m = 1.33", Complex64::new(1.33, 0.0)), ("m = 1.5 + 0.01i", Complex64::new(1.5, 0.01))];
const N_ANGLES: usize = 1801;
const OURS: &str = "mie-cloud";
const THEIRS: &str = "scatrs";
const THEIR_TABLE: &str = "scatrs, angular table";

/// Seconds per call of every sample, by task and program.
type Samples = RefCell<BTreeMap<(String, &'static str), Vec<f64>>>;

/// Measures `run` with criterion and keeps the samples.
fn measure(criterion: &mut Criterion, samples: &Samples, task: &str, program: &'static str, mut run: impl FnMut()) {
    criterion.bench_function(&format!("{task}, {program}"), |bencher| {
        bencher.iter_custom(|count| {
            let start = Instant::now();
            for _ in 0..count {
                run();
            }
            let elapsed = start.elapsed();
            let key = (task.to_owned(), program);
            samples.borrow_mut().entry(key).or_default().push(elapsed.as_secs_f64() / count as f64);
            elapsed
        });
    });
}

fn angles() -> Vec<f64> {
    (0..N_ANGLES).map(|i| i as f64 * PI / (N_ANGLES - 1) as f64).collect()
}

/// Size parameters and index of the table: 64 radii (0.05 - 50 um) by 16 wavelengths (380 - 780 nm).
fn table_spheres() -> Vec<f64> {
    let radius_um = |i: i32| 0.05 * 1000_f64.powf(f64::from(i) / 63.0);
    let wavelength_um = |j: i32| 0.38 + 0.40 * f64::from(j) / 15.0;
    (0..16).flat_map(|j| (0..64).map(move |i| 2.0 * PI * radius_um(i) / wavelength_um(j))).collect()
}

fn bench_efficiencies(criterion: &mut Criterion, samples: &Samples) {
    let (mut ours, mut theirs, options) = (Solver::new(), Mie::<f64>::new(), MieOptions::new());
    for (name, m) in INDICES {
        for x in SIZES {
            let task = format!("efficiencies, {name}, x = {x:>6}");
            measure(criterion, samples, &task, OURS, || {
                black_box(ours.efficiencies(black_box(x), m).unwrap());
            });
            measure(criterion, samples, &task, THEIRS, || {
                black_box(theirs.compute(black_box(x), m, &options).unwrap().efficiencies());
            });
        }
    }
}

fn bench_angles(criterion: &mut Criterion, samples: &Samples) {
    let theta = angles();
    let mu: Vec<f64> = theta.iter().map(|t| t.cos()).collect();
    let (mut ours, mut theirs, options) = (Solver::new(), Mie::<f64>::new(), MieOptions::new());
    let (mut s1, mut s2) = (vec![Complex64::default(); N_ANGLES], vec![Complex64::default(); N_ANGLES]);
    let m = INDICES[0].1;
    for x in SIZES {
        let task = format!("{N_ANGLES} angles, m = 1.33, x = {x:>6}");
        measure(criterion, samples, &task, OURS, || {
            let series = ours.series(black_box(x), m).unwrap();
            series.amplitudes(&theta, &mut s1, &mut s2).unwrap();
            black_box((&s1, &s2));
        });
        measure(criterion, samples, &task, THEIRS, || {
            let solution = theirs.compute(black_box(x), m, &options).unwrap();
            solution.amplitudes(&mu, AmplitudeBuffers { s1: &mut s1, s2: &mut s2 }).unwrap();
            black_box((&s1, &s2));
        });
    }
}

fn bench_table(criterion: &mut Criterion, samples: &Samples) {
    let theta = angles();
    let mu: Vec<f64> = theta.iter().map(|t| t.cos()).collect();
    let (spheres, m) = (table_spheres(), INDICES[0].1);
    let task = format!("table of {} spheres x {N_ANGLES} angles", spheres.len());
    let mut ours = Solver::new();
    let mut out = vec![0.0; N_ANGLES];
    measure(criterion, samples, &task, OURS, || {
        let angles = Angles::new(&theta).unwrap();
        for &x in &spheres {
            ours.series(x, m).unwrap().intensities_at(&angles, &mut out).unwrap();
            black_box(&out);
        }
    });
    let sum_task = format!("mean over the table's {} spheres", spheres.len());
    measure(criterion, samples, &sum_task, OURS, || {
        let angles = Angles::new(&theta).unwrap();
        let mut sum = IntensitySum::new(&angles);
        for &x in &spheres {
            sum.add(&ours.series(x, m).unwrap(), 1.0);
        }
        sum.write(&mut out).unwrap();
        black_box(&out);
    });
    let (mut theirs, options) = (Mie::<f64>::new(), MieOptions::new());
    let (mut s1, mut s2) = (vec![Complex64::default(); N_ANGLES], vec![Complex64::default(); N_ANGLES]);
    measure(criterion, samples, &task, THEIRS, || {
        for &x in &spheres {
            let solution = theirs.compute(x, m, &options).unwrap();
            solution.amplitudes(&mu, AmplitudeBuffers { s1: &mut s1, s2: &mut s2 }).unwrap();
            black_box((&s1, &s2));
        }
    });
    measure(criterion, samples, &task, THEIR_TABLE, || {
        let largest = spheres.iter().copied().fold(0.0, f64::max);
        let table = AngularTable::new(&mu, scatrs::mie::n_terms(largest, m, &options).unwrap()).unwrap();
        for &x in &spheres {
            let solution = theirs.compute(x, m, &options).unwrap();
            solution.amplitudes_from_table(&table, AmplitudeBuffers { s1: &mut s1, s2: &mut s2 }).unwrap();
            black_box((&s1, &s2));
        }
    });
}

fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted[sorted.len() / 2]
}

fn print_ratios(samples: &Samples) {
    let samples = samples.borrow();
    println!("\n{:<45} {:>12} {:>12} {:>8}", "task", OURS, THEIRS, "ratio");
    for ((task, program), values) in samples.iter() {
        let (time, own) = (median(values) * 1e6, samples.get(&(task.clone(), OURS)).map(|own| median(own) * 1e6));
        match own {
            Some(own) if *program != OURS => {
                println!("{task:<45} {own:>9.2} us {time:>9.2} us {:>7.1}x  ({program})", time / own);
            }
            _ if samples.contains_key(&(task.clone(), THEIRS)) => {}
            _ => println!("{task:<45} {time:>9.2} us"),
        }
    }
}

fn main() {
    let mut criterion = Criterion::default()
        .configure_from_args()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_millis(600));
    let samples = Samples::default();
    bench_efficiencies(&mut criterion, &samples);
    bench_angles(&mut criterion, &samples);
    bench_table(&mut criterion, &samples);
    criterion.final_summary();
    print_ratios(&samples);
}

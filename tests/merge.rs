//! The program as a process: parts of a picture, and the picture that they make.

mod program;

use program::{Bench, assert_says};

const ALL: &str = "--aov all --spectral --set spectral.mode=bands:4 -q";

fn part(bench: &Bench, range: &str) -> String {
    let name = format!("{range}.exr");
    bench.ok(&format!("render cloud.glb -o {name} --samples {range} {ALL}"));
    name
}

/// Expected: the bytes of one run, whatever the parts and the order in which they are named.
#[test]
fn parts_merge_to_the_bytes_of_one_run() {
    let bench = Bench::with_cloud();
    let cases: [(u32, &[&str]); 3] = [
        (128, &["0..32", "32..64", "64..96", "96..128"]),
        (112, &["64..112", "0..64"]),
        (176, &["0..1", "112..176", "1..24", "24..112"]),
    ];
    for (spp, ranges) in cases {
        bench.ok(&format!("render cloud.glb -o whole.exr --preview whole.png --spp {spp} {ALL}"));
        let parts: Vec<String> = ranges.iter().map(|range| part(&bench, range)).collect();
        bench.ok(&format!("merge {} -o merged.exr --preview merged.png", parts.join(" ")));
        assert_eq!(bench.read("merged.exr"), bench.read("whole.exr"), "{ranges:?}");
        assert_eq!(bench.read("merged.png"), bench.read("whole.png"), "{ranges:?}");
    }
    // A part is a picture of its own too, and independent of the others.
    let picture = bench.picture("32..64.exr");
    assert!(picture.channel("samples.N").expect("samples").iter().all(|n| *n == 32.0));
    assert_ne!(picture.channel("G"), bench.picture("0..32.exr").channel("G"));
    bench.ok("diff 32..64.exr whole.exr");
    bench.ok(&format!("render cloud.glb -o absolute.exr --absolute --spp 8 {ALL}"));
    bench.ok(&format!("render cloud.glb -o part.exr --absolute --samples 0..8 --threads 1 {ALL}"));
    bench.ok("merge part.exr -o merged.exr -q");
    // Machines may call the scene by other names.
    std::fs::create_dir(bench.path("there")).expect("created");
    std::fs::copy(bench.path("cloud.glb"), bench.path("there/fog.glb")).expect("copied");
    bench.ok("render there/fog.glb -q -o b.exr --samples 8..16");
    bench.ok("render cloud.glb -q -o a.exr --samples 0..8");
    bench.ok("merge a.exr b.exr -o c.exr -q");
    assert_eq!(bench.read("merged.exr"), bench.read("absolute.exr"));
}

#[test]
fn what_does_not_belong_together_is_refused() {
    let bench = Bench::with_cloud();
    let render = |name: &str, flags: &str| bench.ok(&format!("render cloud.glb -q -o {name} {flags}"));
    render("a.exr", "--samples 0..8");
    render("b.exr", "--samples 8..16");
    render("late.exr", "--samples 24..32");
    render("overlap.exr", "--samples 4..12");
    render("seed.exr", "--samples 8..16 --seed 1");
    render("air.exr", "--samples 8..16 --set atmosphere.scattering_per_m=0.5");
    render("crop.exr", "--samples 8..16 --crop 0,0,4,4");
    render("aov.exr", "--samples 8..16 --aov depth");
    render("plain.exr", "--spp 8 --checkpoint c");
    let cases: [(&str, i32, &[&str]); 10] = [
        ("a.exr overlap.exr", 2, &["a.exr", "overlap.exr", "4..8"]),
        ("a.exr a.exr", 2, &["0..8", "each may count once"]),
        ("a.exr late.exr", 2, &["8..24 are missing", "--allow-gaps"]),
        ("b.exr", 2, &["0..8 are missing"]),
        ("a.exr seed.exr", 2, &["seed.exr and a.exr", "--seed is 1, not 0"]),
        ("a.exr air.exr", 2, &["atmosphere.scattering_per_m is 0.5"]),
        ("a.exr crop.exr", 2, &["--crop is [0,0,4,4]"]),
        ("a.exr aov.exr", 2, &["other output flags"]),
        ("a.exr plain.exr", 1, &["plain.exr holds no sums"]),
        ("a.exr c", 2, &["c is a checkpoint", "--resume"]),
    ];
    for (parts, code, said) in cases {
        assert_says(&bench.fails(code, &format!("merge {parts} -o m.exr")), said);
        assert!(!bench.path("m.exr").exists(), "{parts}");
    }
    assert_says(&bench.fails(2, "merge a.exr b.exr -o ./b.exr"), &["b.exr is one of the parts"]);
    bench.ok("merge a.exr late.exr -o m.exr --allow-gaps -q");
    let mut damaged = bench.read("b.exr");
    let at = damaged.len() - 1000;
    damaged[at] ^= 1;
    std::fs::write(bench.path("b.exr"), damaged).expect("written");
    assert_says(&bench.fails(1, "merge a.exr b.exr -o m.exr"), &["b.exr is damaged", "checksum"]);
}

#[test]
fn ranges_that_cut_blocks_are_refused_with_the_nearest_that_do_not() {
    let bench = Bench::with_cloud();
    for (range, said) in [("64..100", "64..96, 64..112"), ("5..7", "4..8"), ("8..8", "empty"), ("8", "A..B")] {
        assert_says(&bench.fails(2, &format!("render cloud.glb -o a.exr --samples {range}")), &["--samples", said]);
    }
    for flags in ["--spp 4", "--noise 0.1", "--accuracy fine", "--time-limit 4"] {
        assert_says(&bench.fails(2, &format!("render cloud.glb -o a.exr --samples 0..8 {flags}")), &["--samples"]);
    }
}

/// Expected: a part of several runs of samples, kept and gone on from, is the part that was not interrupted.
#[test]
fn parts_have_checkpoints_too() {
    let bench = Bench::with_cloud();
    bench.ok("render cloud.glb -q -o a.exr --samples 48..176");
    bench.ok("render cloud.glb -q -o b.exr --samples 48..176 --checkpoint c --checkpoint-every 0.000001");
    assert_eq!(bench.read("a.exr"), bench.read("b.exr"));
    bench.ok("render cloud.glb -q -o b.exr --samples 48..176 --resume c");
    assert_eq!(bench.read("a.exr"), bench.read("b.exr"));
    assert_says(&bench.fails(2, "render cloud.glb -o b.exr --samples 0..16 --resume c"), &["--samples 48..176"]);
}

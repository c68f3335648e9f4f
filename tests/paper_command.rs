//! `mie-cloud paper`: its files, and pictures against what their formulas say of single pixels.

mod program;

use mie_cloud::image::Picture;
use mie_cloud::image::{Attribute, exr};
use mie_cloud::paper::formulas::{Caution, Variant, efficiencies, size_parameter};
use mie_cloud::paper::{FIGURES, INDEX, Method, WAVELENGTHS_NM, make};
use program::{Bench, assert_says, shipped, text};

const N_FILES: usize = 33;

/// Pictures of a quarter of the usual pixels; 45 of them are tan(20 degrees) from the middle to the upper edge.
const SMALL: [u32; 2] = [160, 90];

#[test]
fn the_command_writes_sheet_tables_and_pictures() {
    let bench = Bench::new();
    let output = bench.run("paper --resolution 80x45");
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert_says(&text(&output.stderr), &["figure 1 of 10: 201.5015 nm", "contact.png"]);
    let table = text(&output.stdout);
    assert_eq!(table.as_bytes(), bench.read("paper/table.txt"));
    assert_says(&table, &["\"blue evenly in all directions\": no", "24 to 1", "rises by 0.49 %", "at most 2.3 %"]);
    assert_eq!(std::fs::read_dir(bench.path("paper")).unwrap().count(), N_FILES);

    let csv = text(&bench.read("paper/table.csv"));
    let mut lines = csv.lines();
    let columns: Vec<&str> = lines.next().unwrap().split(',').collect();
    let column = |name: &str| columns.iter().position(|column| *column == name).unwrap();
    let rows: Vec<Vec<&str>> = lines.map(|line| line.splitn(columns.len(), ',').collect()).collect();
    assert_eq!(rows.len(), FIGURES.len() * Method::ALL.len() * WAVELENGTHS_NM.len());
    for row in &rows {
        for name in ["x", "q_sca", "q_abs", "g", "forward_over_backward", "hemispheres"] {
            assert!(row[column(name)].parse::<f64>().is_ok_and(f64::is_finite), "{row:?}");
        }
        assert!(["yes", "no", "no claim on record"].contains(&row[column("verdict")]), "{row:?}");
    }

    let reader = png::Decoder::new(std::io::Cursor::new(bench.read("paper/contact.png"))).read_info().unwrap();
    assert!(reader.info().width >= 3 * 80 && reader.info().height >= 10 * 45);

    // The exact column is what `render` makes of the same scene, byte for byte.
    let exact = bench.picture("paper/fig04-exact.exr");
    let Some(Attribute::Int(spp)) = exact.attribute("mieCloud:samples") else { panic!("samples are recorded") };
    bench.ok(&format!("render {} -o again.exr --resolution 80x45 --spp {spp} -q", shipped("scenes/paper/fig04.gltf")));
    let again = bench.picture("again.exr");
    for name in ["R", "G", "B", "A"] {
        assert_eq!(exact.channel(name), again.channel(name), "{name}");
    }

    // Nothing is overwritten where that was asked.
    let before = bench.read("paper/table.csv");
    assert_says(&bench.fails(1, "paper --no-clobber"), &["paper/", "exists"]);
    assert_eq!(bench.read("paper/table.csv"), before);
}

#[test]
fn an_output_that_cannot_be_a_folder_is_refused_before_any_work() {
    let bench = Bench::new();
    bench.write("file", "");
    assert_says(&bench.fails(2, "paper -o file"), &["--output file", "folder"]);
    assert_says(&bench.fails(1, "paper -o no/such/place"), &["no/such/place"]);
    assert_eq!(bench.files().len(), 1);
}

#[test]
fn inspect_understands_the_scenes_of_the_paper() {
    let bench = Bench::new();
    for figure in FIGURES {
        let said = bench.ok(&format!("inspect {}", shipped(&figure.scene_path())));
        assert_says(&said, &["1 droplet", "air"]);
    }
}

/// The value of a pixel.
fn at(picture: &Picture, name: &str, [x, y]: [u32; 2]) -> f64 {
    f64::from(picture.channel(name).unwrap()[(y * picture.width + x) as usize])
}

/// Expected: with one phase function for all colours, the published columns have one colour everywhere, that of
/// Q_sca (1 - Q_abs); light goes to the lower right; and rays that meet the droplet leave it again.
#[test]
fn the_published_columns_are_what_their_formulas_say() {
    let figure = &FIGURES[0];
    let study = make(figure, Some(SMALL)).unwrap();
    for (column, variant) in study.columns.iter().zip([Variant::Listing, Variant::Equations]) {
        let strength = WAVELENGTHS_NM.map(|wavelength| {
            let x = size_parameter(figure.diameter_nm, wavelength);
            efficiencies(variant, Caution::None, x, INDEX).strength()
        });
        let picture = &column.picture;
        let (width, height) = (picture.width, picture.height);
        for place in [[0, 0], [width / 2, height / 2], [width - 1, height - 1], [width - 10, 3]] {
            let blue_over_red = at(picture, "B", place) / at(picture, "R", place);
            assert!((blue_over_red / (strength[2] / strength[0]) - 1.0).abs() < 1e-5, "{place:?}");
        }
        let [forward, backward] =
            [[width / 2 + 30, height / 2 + 30], [width / 2 - 30, height / 2 - 30]].map(|place| at(picture, "G", place));
        assert!(forward > 50.0 * backward, "{forward} and {backward}");
        let droplet = picture.channel("state.G").unwrap().iter().filter(|state| **state == 1.0).count();
        let missed = picture.channel("state.G").unwrap().iter().filter(|state| **state == 0.0).count();
        assert_eq!(droplet + missed, (width * height) as usize);
        // The droplet's cone: tan = 0.5 / sqrt(36 - 0.25), on the scale of SMALL.
        let radius = 0.5 / 35.75_f64.sqrt() * 45.0 / 20_f64.to_radians().tan();
        let area = std::f64::consts::PI * radius * radius;
        assert!((droplet as f64 / area - 1.0).abs() < 0.12, "{droplet} and {area}");
    }
}

/// Expected: the sum over samples of sigma_s P(mu) exp(-sigma_a k s), written out for the ray through the middle of the
/// top edge, which passes the droplet at some distance.
#[test]
fn the_atmosphere_is_marched_as_published() {
    let study = make(&FIGURES[0], Some(SMALL)).unwrap();
    let picture = &study.columns[1].picture;
    let q = efficiencies(Variant::Equations, Caution::None, size_parameter(201.5015, 450.0), INDEX);
    let half = 20_f64.to_radians().tan();
    let mut expected = 0.0;
    for ray in [[0.25, 0.25], [0.75, 0.25], [0.25, 0.75], [0.75, 0.75]] {
        let (right, up) = ((80.0 + ray[0]) / 80.0 - 1.0, 1.0 - ray[1] / 45.0);
        let (dx, dy) = (right * half * 320.0 / 180.0, up * half);
        let length = (dx * dx + dy * dy + 1.0_f64).sqrt();
        for k in 1..=50 {
            let t = f64::from(k) * 0.2 / length;
            let (x, y, z) = (t * dx, t * dy, 6.0 - t);
            let mu = 0.5_f64.sqrt() * (x - y) / (x * x + y * y + z * z).sqrt();
            let p = 0.19 / (1.81 - 1.8 * mu).powf(1.5);
            expected += 0.25 * 0.025 * p * q.q_sca * (-0.1 * 0.2 * f64::from(k)).exp();
        }
    }
    let found = at(picture, "B", [80, 0]);
    assert!((found / expected - 1.0).abs() < 1e-5, "{found} and {expected}");
}

/// Expected: the same bytes for any number of threads.
#[test]
fn threads_do_not_change_the_pictures() {
    let bytes = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let study = pool.install(|| make(&FIGURES[8], Some([33, 20]))).unwrap();
        study.columns.each_ref().map(|column| exr::encode(&column.picture).unwrap())
    };
    assert!(bytes(1) == bytes(3));
}

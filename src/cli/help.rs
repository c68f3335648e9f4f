//! Examples at the end of each help text, in the order in which somebody comes to need them.

/// After the list of commands.
pub const PROGRAM: &str = "\
Examples:
  mie-cloud generate -o ball.glb --shape ball --size 2m --optical-depth 2
  mie-cloud inspect ball.glb
  mie-cloud render ball.glb -o ball.exr --preview ball.png --time-limit 30
  mie-cloud mie --radius 5um --wavelength 550nm --plot p.svg

Exit codes: 0 done, 1 failure, 2 flags at fault, 3 scene at fault, 130 interrupted
after saving.";

/// After `render`.
pub const RENDER: &str = "\
Examples:
  mie-cloud render fog.gltf -o fog.exr --preview fog.png
  mie-cloud render fog.gltf -o fog.exr --resolution 1920x1080 --noise 0.02
  mie-cloud render fog.gltf -o fog.exr --time-limit 60 --aov direct,multiple,stderr
  mie-cloud render fog.gltf -o fog.exr --set atmosphere.scattering_per_m=0.025
  mie-cloud render fog.gltf -o fog.exr --spp 4096 --checkpoint fog.checkpoint";

/// After `generate`.
pub const GENERATE: &str = "\
Examples:
  mie-cloud generate -o ball.glb --shape ball --size 2m --optical-depth 2
  mie-cloud generate -o bank.glb --shape slab --size 40m,2m,40m --patchiness 1
  mie-cloud generate -o cumulus.glb --shape cumulus --size 1km --count 1e5 --optical-depth 40
  mie-cloud generate -o drops.gltf --kind droplets --count 1e3 --size 10mm";

/// After `mie`.
pub const MIE: &str = "\
Examples:
  mie-cloud mie --size-parameter 10 --index 1.33,0
  mie-cloud mie --radius 5um --wavelength 450nm --angles 130:145:0.1 --format csv -o bow.csv
  mie-cloud mie --radius 10um --material ice --format json --plot ice.svg
  mie-cloud mie --distribution gamma:reff=6um,veff=0.1 --plot fog.svg
  mie-cloud mie --distribution lognormal:rg=0.1um,sigma=0.7,rmax=10um --index 1.45,0.01

Phase functions integrate to 1 over the sphere (sr^-1); the medium is air, taken as vacuum.
A CSV has comment lines, then a header: pandas.read_csv(FILE, comment='#'), or with NumPy
np.genfromtxt((l for l in open(FILE) if l[0] != '#'), delimiter=',', names=True).
One whose angles go from 0 to 180 serves as a scene's phase model, table:FILE.csv; give it
angles close enough for the forward peak: --angles 0:180:0.1 for fog, closer for larger drops.";

/// After `inspect`.
pub const INSPECT: &str = "\
Examples:
  mie-cloud inspect fog.gltf
  mie-cloud inspect fog.gltf --set accuracy.target=fine --json";

/// After `bench`.
pub const BENCH: &str = "\
Examples:
  mie-cloud bench particles --counts 1e3,1e4,1e5,1e6
  mie-cloud bench effects fog.gltf
  mie-cloud bench accuracy fog.gltf --plot price.svg";

/// After `bench particles`.
pub const BENCH_PARTICLES: &str = "\
Examples:
  mie-cloud bench particles --counts 1e3,1e4,1e5,1e6 --plot speed.svg
  mie-cloud bench particles --counts 1e7 --repeat 1 --yes";

/// After `bench effects`.
pub const BENCH_EFFECTS: &str = "\
Examples:
  mie-cloud bench effects fog.gltf
  mie-cloud bench effects fog.gltf --accuracy fine --to-target --json effects.json";

/// After `bench accuracy`.
pub const BENCH_ACCURACY: &str = "\
Examples:
  mie-cloud bench accuracy fog.gltf --plot price.svg
  mie-cloud bench accuracy fog.gltf --knobs bands,spp --csv price.csv";

/// After `diff`.
pub const DIFF: &str = "\
Examples:
  mie-cloud diff new.exr old.exr --picture where.png
  mie-cloud diff new.exr old.exr --max-rel 0.01 && echo equal";

/// After `merge`.
pub const MERGE: &str = "\
Examples:
  mie-cloud render fog.gltf -o part0.exr --samples 0..64
  mie-cloud render fog.gltf -o part1.exr --samples 64..128
  mie-cloud merge part0.exr part1.exr -o fog.exr --preview fog.png";

/// After `paper`.
pub const PAPER: &str = "\
Examples:
  mie-cloud paper -o paper
  mie-cloud paper -o paper --resolution 640x360";

/// After `completions`.
pub const COMPLETIONS: &str = "\
Examples:
  mie-cloud completions bash > ~/.local/share/bash-completion/completions/mie-cloud
  mie-cloud completions zsh > \"${fpath[1]}/_mie-cloud\"
  mie-cloud completions fish > ~/.config/fish/completions/mie-cloud.fish";

/// After `man`.
pub const MAN: &str = "\
Examples:
  mie-cloud man | man -l -
  mie-cloud man render > mie-cloud-render.1
  mie-cloud man --all ~/.local/share/man/man1";

"""What is compared with the discrete-ordinate slabs: radiances in single directions, and fluxes through both faces.

Not a program: `slabs.py` imports it. Every quantity knows its reference value and draws an estimate with its error.

A slab is a box of fog 2000 wide and 1 thick. A radiance is the mean of a narrow orthographic picture that looks against the
light's travel. Mie slabs are compared by their means over the azimuth: eight suns in a scene, and as many scenes as the peak
needs. A flux is the sum over pictures of a pinhole camera right at the slab's face, each pixel times its cosine and solid
angle: half a cube of pictures of 90 degrees covers the hemisphere, and samples at random places in the pixels find
forward peaks that quadratures over directions miss. The escaping share is that of surroundings of radiance 1, seen along the
sun's rays (theory (97)): one minus the absorbed share.
"""

import json
import math
import zlib
from dataclasses import dataclass

import numpy as np
from reference_scene import DATA, looking, orthographic, perspective, render, write_fog

RESOLUTION = 16
# Fine enough for the forward peak where it is seen.
FLUX_RESOLUTION = {"albedo": 128, "transmittance": 256}
# Many suns make each collision dear, few make many pictures.
SUNS_PER_SCENE = 8
FAINTEST = 1e-6
# Allowed error of the mean over suns in place of the azimuth, for light scattered once; far below the own standard error.
AZIMUTH_TOLERANCE = 5e-4
# The pinhole is this far from the slab's face.
GAP = 1e-3


@dataclass
class Quantity:
    """A number of the reference; `place` is what it is taken at: cosine and azimuth of a direction, or nothing."""

    case: dict
    kind: str
    place: tuple
    expected: float
    digits: float

    @property
    def key(self):
        case = self.case
        parts = [case["phase"], case["tau"], case["albedo"], case["sun_zenith_deg"], self.kind, *self.place]
        return "/".join(map(str, parts))

    @property
    def seed(self):
        """Of its own, whatever else is compared; leaves room for the seeds of many pictures."""
        return zlib.crc32(self.key.encode()) << 20

    @property
    def target(self):
        """Relative standard error that is wanted."""
        return 0.01 if self.expected < 1e-3 or self.case["tau"] == 64 else 0.005


def radiances(cases):
    """All directions that are bright enough."""
    for case in cases:
        for side, kind in enumerate(["reflected", "transmitted_diffuse"]):
            for i, mu in enumerate(case["view_mu"]):
                if case["phase"].startswith("mie"):
                    digits = case["agree_digits_azimuth_mean"][side][i]
                    rows = [("mean", case[f"{kind}_azimuth_mean"][i], digits)]
                else:
                    digits = case["agree_digits_" + kind.removesuffix("_diffuse")][i]
                    rows = zip(case["rel_azimuth_deg"], case[f"{kind}_radiance"][i], digits)
                for azimuth, expected, digits in rows:
                    if expected > FAINTEST and not (mu == 1 and azimuth not in (0, "mean")):
                        yield Quantity(case, kind, (mu, azimuth), expected, digits)


def fluxes(cases):
    """Albedo, diffuse transmittance and escaping share of each slab, as fractions of the incident flux."""
    for case in cases:
        values = [case["plane_albedo"], case["T_diffuse"], case["plane_albedo"] + case["T_total"]]
        for kind, expected in zip(["albedo", "transmittance", "escaping"], values):
            if expected > FAINTEST:
                yield Quantity(case, kind, (), expected, case["agree_digits_flux"])


def load_cases():
    return json.loads((DATA / "slab_reference.json").read_text())["cases"]


def azimuths_for_mean(case, mu, reflected):
    """So many azimuths on a half circle that the phase function's mean over them is good."""
    if case["sun_zenith_deg"] == 0:
        return [0.0]
    table = np.loadtxt(DATA / f"{case['phase']}_angles.csv", delimiter=",")
    cos_sun, cos_view = -case["mu0"], mu if reflected else -mu
    sines = math.sqrt((1 - cos_sun**2) * (1 - cos_view**2))

    def mean(azimuths):
        cos = cos_sun * cos_view + sines * np.cos(np.radians(azimuths))
        return np.interp(np.degrees(np.arccos(np.clip(cos, -1, 1))), table[:, 0], table[:, 1]).mean()

    def midpoints(n):
        return (np.arange(n) + 0.5) * 180 / n

    exact, count = mean(midpoints(4096)), 4
    while any(abs(mean(midpoints(n)) / exact - 1) > AZIMUTH_TOLERANCE for n in (count, 2 * count)):
        count *= 2
    return list(midpoints(count))


def sun(case, azimuth_deg=0.0):
    """The direction in which sunlight travels."""
    zenith, azimuth = math.radians(case["sun_zenith_deg"]), math.radians(azimuth_deg)
    return math.sin(zenith) * math.cos(azimuth), math.sin(zenith) * math.sin(azimuth), -math.cos(zenith)


class Studio:
    """Renders pictures of slabs with one program in one folder."""

    def __init__(self, program, folder, settings):
        self.program, self.folder, self.settings = program, folder, settings

    def picture(self, name, case, camera, matrix, suns, resolution, spp, seed, background=0, layers="stderr"):
        scene, picture = self.folder / f"{name}.gltf", self.folder / f"{name}.exr"
        write_fog(
            scene,
            scale=[2000, 2000, 1],
            extinction=case["tau"],
            albedo=case["albedo"],
            phase=case["phase"],
            camera=camera,
            camera_matrix=matrix,
            suns=suns,
            background=background,
        )
        result = render(self.program, scene, picture, resolution, spp, seed, self.settings, layers)
        scene.unlink()
        picture.unlink()
        return result

    def draw(self, quantity, spp, seed):
        """An estimate, its standard error, and the CPU seconds that it took."""
        kind = quantity.kind
        if kind == "escaping":
            return self.escaping(quantity, spp, seed)
        return (self.flux if kind in ("albedo", "transmittance") else self.radiance)(quantity, spp, seed)

    def radiance(self, quantity, spp, seed):
        case, (mu, azimuth), reflected = quantity.case, quantity.place, quantity.kind == "reflected"
        azimuths = azimuths_for_mean(case, mu, reflected) if azimuth == "mean" else [azimuth]
        travel = np.array([math.sqrt(1 - mu * mu), 0, mu if reflected else -mu])
        count = max(1, len(azimuths) // SUNS_PER_SCENE)
        name, results = f"{quantity.seed:x}", []
        for i in range(count):
            suns = [sun(case, a) for a in azimuths[i::count]]
            view = (orthographic(0.01), looking(-travel, 10 * travel))
            shot = self.picture(name, case, *view, suns, RESOLUTION, math.ceil(spp / count), seed + i)
            results.append((*mean_and_error(shot[0]["G"]), shot[1]))
        means, errors, seconds = np.array(results).T
        return means.mean(), np.sqrt((errors**2).sum()) / count, seconds.sum()

    def flux(self, quantity, spp, seed):
        case, name = quantity.case, f"{quantity.seed:x}"
        # Seen from above the slab lies down, from below up. Left and right of the sun's plane are alike.
        down = -1 if quantity.kind == "albedo" else 1
        position = (0, 0, -down * (0.5 + GAP))
        faces = [((0, 0, down), 1), ((1, 0, 0), 1), ((-1, 0, 0), 1), ((0, 1, 0), 2)]
        n = FLUX_RESOLUTION[quantity.kind]
        u = (np.arange(n) + 0.5) * 2 / n - 1
        x, y = np.meshgrid(u, u)
        # Cosine times solid angle of a pixel: r^-4 for the face along the normal, |y| r^-4 for the others.
        straight = (2 / n) ** 2 / (1 + x * x + y * y) ** 2
        total, variance, seconds = 0.0, 0.0, 0.0
        for i, (direction, weight) in enumerate(faces):
            view = (perspective(90), looking(direction, position, (1, 0, 0) if direction[2] else (0, 0, 1)))
            channels, cpu = self.picture(name, case, *view, [sun(case)], n, spp, seed + i)
            weights = weight * (straight if direction[2] else straight * abs(y))
            total += (weights * channels["G"]).sum()
            variance += ((weights * channels["stderr.G"]) ** 2).sum()
            seconds += cpu
        return total / case["mu0"], math.sqrt(variance) / case["mu0"], seconds

    def escaping(self, quantity, spp, seed):
        case, name = quantity.case, f"{quantity.seed:x}"
        travel = np.array(sun(case))
        view = (orthographic(0.01), looking(travel, -10 * travel))
        channels, cpu = self.picture(
            name, case, *view, [sun(case)], RESOLUTION, spp, seed, background=1, layers="background"
        )
        return *mean_and_error(channels["background.G"]), cpu


def mean_and_error(picture):
    """All pixels see the same: their spread is the error."""
    return picture.mean(), picture.std(ddof=1) / math.sqrt(picture.size)

#!/usr/bin/env python3
"""Compares OpenEXR files, as OpenEXR and OpenImageIO read them, with what should be in them.

usage: exr_check.py FOLDER FILE.exr=DUMP...

FOLDER holds the pictures of examples/write_test_picture.rs, whose values follow from a formula that stands here a
second time. DUMP.json and DUMP.bin are what examples/picture_dump.rs found in FILE.exr.
"""
import json
import sys
from pathlib import Path

import numpy as np
import OpenEXR
import OpenImageIO as oiio

CHANNELS = ["R", "G", "B", "A", "direct.R", "stderr.G", "samples.N", "depth.Z"]
SPECTRUM = ["S0.380,000000nm", "S0.550,000000nm", "S0.612,500000nm"]
BT709 = [0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290]
ATTRIBUTES = {
    "software": ("string", "mie-cloud test"),
    "comments": ("string", "two lines\nand µ"),
    "mie_cloud.seed": ("string", "18446744073709551615"),
    "mie_cloud.samples": ("int", 64),
    "mie_cloud.noise": ("float", 0.125),
    "mie_cloud.time": ("double", 0.1),
    "mie_cloud.a_name_of_more_than_31_characters": ("string", "long"),
    "mie_cloud.range": ("v2i", [-3, 7]),
    "mie_cloud.direction": ("v3f", [0.5, -0.25, 1.0]),
    "mie_cloud.effects": ("stringvector", ["direct", "glow"]),
}
SPECTRAL = {"spectralLayoutVersion": ("string", "1.0"), "emissiveUnits": ("string", "W.m^-2.sr^-1.nm^-1")}
# What the format or the libraries add themselves.
STRUCTURE = {
    "channels", "chromaticities", "compression", "dataWindow", "displayWindow", "lineOrder", "pixelAspectRatio",
    "screenWindowCenter", "screenWindowWidth", "type", "whiteLuminance",
}
# OpenImageIO's names for attributes of the format, and what it adds.
OIIO_NAMES = {
    "comments": "ImageDescription", "owner": "Copyright", "capDate": "DateTime",
    "pixelAspectRatio": "PixelAspectRatio", "lineOrder": "openexr:lineOrder",
}
OIIO_TYPES = {
    "string": "string", "int": "int", "float": "float", "double": "double", "v2i": "vector2i", "v2f": "vector2",
    "v3f": "vector", "stringvector": "string[{}]", "box2i": "box2i",
}

passed, failed = 0, 0


def check(what, found, expected):
    """Counts one comparison, and says what differs."""
    global passed, failed
    if found == expected:
        passed += 1
    else:
        failed += 1
        print(f"FAILED {what}: found {found!r}, expected {expected!r}")


def plain(value):
    """A value of either library as Python's own numbers, texts and lists."""
    if isinstance(value, np.ndarray):
        value = value.tolist()
        return value[0] if len(value) == 1 else value
    if isinstance(value, tuple):
        return [plain(item) for item in value]
    return value


def formula(width, height, x0, y0, index):
    """The values of channel number `index`: see examples/write_test_picture.rs."""
    x = np.arange(x0, x0 + width)[None, :]
    y = np.arange(y0, y0 + height)[:, None]
    sign = np.where(x % 2 == 0, 1.0, -1.0)
    return (((x + 1) * 0.5 + (y + 1) * 0.25 + index) * 2.0 ** (index - 4) * sign).astype(np.float32)


def from_formula(width, height, x=0, y=0, full=None, spectrum=()):
    names = CHANNELS + list(spectrum)
    return {
        "window": [x, y, width, height, *(full or (width, height))],
        "channels": {name: formula(width, height, x, y, index) for index, name in enumerate(names)},
        "attributes": ATTRIBUTES | (SPECTRAL if spectrum else {}),
        "chromaticities": BT709,
        "whiteLuminance": 42435.5,
    }


def from_dump(dump):
    """What our own reader found."""
    text = json.loads(Path(f"{dump}.json").read_text())
    width, height, frame = text["width"], text["height"], text["frame"]
    names = [channel["name"] for channel in text["channels"]]
    values = np.fromfile(f"{dump}.bin", dtype="<f4").reshape(len(names), height, width)
    return {
        "window": [frame["x"], frame["y"], width, height, frame["full_width"], frame["full_height"]],
        "channels": dict(zip(names, values)),
        "attributes": {name: tuple(value) for name, value in text["attributes"].items()},
        "chromaticities": text["chromaticities"],
        "whiteLuminance": text["white_luminance_cd_m2"],
    }


def as_float32(kind, value):
    """A single-precision value as the libraries hand it out: widened to double."""
    if kind in ("float", "v2f", "v3f") and value is not None:
        return np.float32(value).astype(float).tolist()
    return value


def check_values(where, found, expected):
    """All channels, bit for bit."""
    check(f"{where} channel names", sorted(found), sorted(expected))
    for name in set(found) & set(expected):
        bits = [np.ascontiguousarray(a, dtype="<f4").tobytes() for a in (found[name], expected[name])]
        same = found[name].dtype == np.float32 and found[name].shape == expected[name].shape and bits[0] == bits[1]
        check(f"{where} channel {name}", same, True)


def check_with_openexr(path, expected):
    where = f"{path.name} by OpenEXR:"
    check(f"{where} is an OpenEXR file", OpenEXR.isOpenExrFile(str(path)), True)
    file = OpenEXR.File(str(path), separate_channels=True)
    check(f"{where} parts", len(file.parts), 1)
    header, channels = file.header(), file.channels()
    check_values(where, {name: channel.pixels for name, channel in channels.items()}, expected["channels"])
    kinds = {(channel.xSampling, channel.ySampling, channel.pLinear, channel.type()) for channel in channels.values()}
    check(f"{where} channel kinds", kinds, {(1, 1, False, OpenEXR.FLOAT)})
    order = [channel.name for channel in header["channels"]]
    check(f"{where} order of channels", order, sorted(order))
    check(f"{where} compression", header["compression"], OpenEXR.ZIP_COMPRESSION)
    check(f"{where} line order", header["lineOrder"], OpenEXR.INCREASING_Y)
    check(f"{where} type", header["type"], OpenEXR.scanlineimage)
    x, y, width, height, full_width, full_height = expected["window"]
    check(f"{where} data window", plain(header["dataWindow"]), [[x, y], [x + width - 1, y + height - 1]])
    check(f"{where} display window", plain(header["displayWindow"]), [[0, 0], [full_width - 1, full_height - 1]])
    check(f"{where} aspect, centre, width", [plain(header[name]) for name in
          ("pixelAspectRatio", "screenWindowCenter", "screenWindowWidth")], [1.0, [0.0, 0.0], 1.0])
    check(f"{where} chromaticities", plain(header.get("chromaticities")),
          as_float32("v3f", expected["chromaticities"]))
    check(f"{where} whiteLuminance", header.get("whiteLuminance"), as_float32("float", expected["whiteLuminance"]))
    check(f"{where} attribute names", sorted(set(header) - STRUCTURE), sorted(expected["attributes"]))
    for name, (kind, value) in expected["attributes"].items():
        check(f"{where} attribute {name}", plain(header.get(name)), as_float32(kind, value))


def check_with_openimageio(path, expected):
    where = f"{path.name} by OpenImageIO:"
    image = oiio.ImageInput.open(str(path))
    if image is None:
        check(f"{where} opens", oiio.geterror(), "")
        return
    spec = image.spec()
    pixels = image.read_image(oiio.FLOAT)
    check(f"{where} one part", image.seek_subimage(1, 0), False)
    image.close()
    names = list(spec.channelnames)
    check_values(where, {name: pixels[:, :, index] for index, name in enumerate(names)}, expected["channels"])
    check(f"{where} format", str(spec.format), "float")
    window = [spec.x, spec.y, spec.width, spec.height, spec.full_width, spec.full_height]
    check(f"{where} windows", window, expected["window"])
    check(f"{where} origin of the full window", [spec.full_x, spec.full_y], [0, 0])
    if all(name in names for name in "RGBA"):
        check(f"{where} colours come first", names[:4], list("RGBA"))
        check(f"{where} opacity", spec.alpha_channel, 3)
    found = {attribute.name: attribute for attribute in spec.extra_attribs}
    check(f"{where} compression", found["compression"].value, "zip")
    check(f"{where} chromaticities", plain(found["chromaticities"].value) if "chromaticities" in found else None,
          as_float32("v3f", expected["chromaticities"]))
    check(f"{where} whiteLuminance", found["whiteLuminance"].value if "whiteLuminance" in found else None,
          as_float32("float", expected["whiteLuminance"]))
    for name, (kind, value) in expected["attributes"].items():
        attribute = found.get(OIIO_NAMES.get(name, name))
        check(f"{where} attribute {name}", plain(attribute.value) if attribute is not None else None, as_float32(kind, value))
        kind = OIIO_TYPES[kind].format(len(value) if kind == "stringvector" else "")
        check(f"{where} type of {name}", str(attribute.type) if attribute is not None else None, kind)
    known = {OIIO_NAMES.get(name, name) for name in STRUCTURE | set(expected["attributes"])}
    check(f"{where} no further attributes", sorted(n for n in set(found) - known if not n.startswith("oiio:")), [])


def main():
    folder = Path(sys.argv[1])
    pictures = [
        (folder / "whole.exr", from_formula(70, 37)),
        (folder / "pixel.exr", from_formula(1, 1)),
        (folder / "crop.exr", from_formula(17, 33, 12, 5, (64, 48))),
        (folder / "spectral.exr", from_formula(5, 18, spectrum=SPECTRUM)),
    ]
    for argument in sys.argv[2:]:
        file, _, dump = argument.rpartition("=")
        pictures.append((Path(file), from_dump(dump)))
    for path, expected in pictures:
        check_with_openexr(path, expected)
        check_with_openimageio(path, expected)
    print(f"{passed} passed, {failed} failed")
    return 1 if failed or not passed else 0


if __name__ == "__main__":
    sys.exit(main())

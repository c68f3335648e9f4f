"""Reads a picture of mie-cloud: python3 read_exr.py fog.exr (needs numpy and OpenEXR, 3.3 or newer)."""
import json, sys
import numpy as np
import OpenEXR

file = OpenEXR.File(sys.argv[1], separate_channels=True)
header, channels = file.header(), {name: channel.pixels for name, channel in file.channels().items()}


def rgb(layer=""):
    """An array (height, width, 3): the picture, or one of its layers."""
    return np.stack([channels[f"{layer}.{c}" if layer else c] for c in "RGB"], axis=-1)


height, width = channels["R"].shape
print(f"{width}x{height}, {header['mieCloud:samples']} samples per pixel, seed {header['mieCloud:seed']}")
print("accuracy target:", json.loads(header["mieCloud:settings"])["accuracy.target"])

# 1.0 is a white diffuser that faces the suns; `whiteLuminance` makes it absolute.
luminance = rgb() @ [0.2126, 0.7152, 0.0722]
if header.get("whiteLuminance"):
    print(f"mean luminance {luminance.mean():.4g}, or {luminance.mean() * header['whiteLuminance']:.4g} cd/m^2")
if "stderr.G" in channels:
    # As `--noise` and the closing summary count it: over pixels and R, G, B, relative to the mean luminance.
    print(f"noise {np.sqrt((rgb('stderr') ** 2).mean()) / luminance.mean():.2%}")

# The picture is the sum of its layers (--aov all).
names = ["direct", "multiple", "airlight", "glow", "air_multiple", "refraction", "background"]
if all(f"{name}.R" in channels for name in names):
    off = np.abs(rgb() - sum(rgb(name) for name in names)).max() / rgb().max()
    print(f"the layers add up to the picture within {off:.1e}")
    # Fog over another picture: what comes through of it, and the light of the fog itself.
    plate = np.full((height, width, 3), 0.18, np.float32)
    over = plate * rgb("transmittance") + rgb() - rgb("background")
    print(f"over a gray plate: mean {over.mean():.4g}")

# Radiance by wavelength (--spectral): names such as `S0.550,000000nm`.
spectrum = {float(name[3:-2].replace(",", ".")): values for name, values in channels.items() if name.startswith("S0.")}
for nm, values in sorted(spectrum.items()):
    print(f"{nm:7.1f} nm: mean {values.mean():.4g} {header['emissiveUnits']}")

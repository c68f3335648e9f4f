"""Writes a cloud as plain glTF: python3 cloud.py cloud.gltf (needs numpy only)."""
import base64, json, sys
import numpy as np

rng = np.random.default_rng(1)
n = 5000
turn = rng.uniform(0, 2 * np.pi, n)
ring = np.stack([np.cos(turn), 0.5 * np.sin(turn), np.sin(turn)], axis=1)
points = {
    "POSITION": ring + rng.normal(scale=0.08, size=(n, 3)),  # metres, y is up
    "_RADIUS": rng.uniform(0.04, 0.08, n),                   # radius of each ball of fog, metres
    "_DROPLET_RADIUS_UM": np.full(n, 10.0),                  # radius of the droplets in it, micrometres
    "_DROPLET_COUNT": np.full(n, 2e6),                       # how many; without it each point is one droplet
}
arrays = {name: np.ascontiguousarray(values, "<f4") for name, values in points.items()}
position = arrays["POSITION"]
data, views, accessors = b"", [], []
for array in arrays.values():
    views.append({"buffer": 0, "byteOffset": len(data), "byteLength": array.nbytes, "target": 34962})
    accessors.append({"bufferView": len(accessors), "componentType": 5126, "count": n,
                      "type": "VEC3" if array.ndim == 2 else "SCALAR"})
    data += array.tobytes()
accessors[0].update(min=position.min(0).tolist(), max=position.max(0).tolist())
primitive = {"mode": 0, "attributes": {name: index for index, name in enumerate(arrays)}}
settings = {"background": {"radiance": [0.05, 0.08, 0.12]}, "accuracy": {"target": "draft"}}
json.dump({
    "asset": {"version": "2.0"}, "scene": 0, "nodes": [{"mesh": 0}], "meshes": [{"primitives": [primitive]}],
    "scenes": [{"nodes": [0], "extras": {"mie_cloud": settings}}], "accessors": accessors, "bufferViews": views,
    "buffers": [{"byteLength": len(data), "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}],
}, open(sys.argv[1], "w"))

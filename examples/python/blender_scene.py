"""Makes a scene of droplets, a box of fog, a sun and a camera in Blender, and saves it as glTF.

blender -b -P blender_scene.py -- scene.glb       (or: pip install bpy; python3 blender_scene.py scene.glb)
"""
import sys

import bpy
import numpy as np

bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene

# Loose points with the float attribute _RADIUS (metres): one ball of a million droplets each.
rng = np.random.default_rng(1)
mesh = bpy.data.meshes.new("Puff")
mesh.from_pydata(rng.normal(scale=0.3, size=(500, 3)).tolist(), [], [])
radius = mesh.attributes.new("_RADIUS", "FLOAT", "POINT")
radius.data.foreach_set("value", np.full(500, 0.1, dtype=np.float32))
puff = bpy.data.objects.new("Puff", mesh)
puff["mie_cloud.droplet_count"] = 1e7
puff["mie_cloud.distribution"] = "mono:r=8um"
scene.collection.objects.link(puff)

# A cube as a bank of fog.
bpy.ops.mesh.primitive_cube_add(size=1, location=(0, 1, -1.2), scale=(6, 4, 0.6))
bank = bpy.context.object
bank["mie_cloud.kind"] = "fog"
bank["mie_cloud.extinction_per_m"] = 0.5

bpy.ops.object.light_add(type="SUN", rotation=(0.8, 0.3, 0.2))
bpy.context.object.data.energy = 100
bpy.ops.object.camera_add(location=(0, -5, 0.3), rotation=(1.5, 0, 0))
scene.camera = bpy.context.object

# Settings are custom properties of the scene.
scene["mie_cloud.background.radiance"] = [0.1, 0.2, 0.3]
scene["mie_cloud.accuracy.target"] = "draft"
scene["mie_cloud.image.resolution"] = [640, 360]

bpy.ops.export_scene.gltf(
    filepath=sys.argv[-1], export_format="GLB", export_extras=True, export_cameras=True, export_lights=True,
    export_attributes=True, use_mesh_vertices=True,
)

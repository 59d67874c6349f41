#!/usr/bin/env bash
# Mitsuba 3: the aov "depth" is the distance along the ray from the near plane, and not from the camera. Raising near_clip from 0.01
# to 0.5 makes every depth half a metre smaller on the axis, and more beside it. Expected: planar depth, or the distance from the
# camera's origin, which the aov "position" gives.
set -euo pipefail

. "$(dirname "$0")/python.sh" mitsuba==3.9.1 numpy==2.3.4
venv/bin/python - <<'PY'
import sys

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")


def frame(near):
    film = {"type": "hdrfilm", "width": 65, "height": 33, "rfilter": {"type": "box"}}
    sampler = {"type": "stratified", "sample_count": 1, "jitter": False}
    wall = mi.ScalarTransform4f().translate([0, 0, 4]).scale(50).rotate([0, 1, 0], 180)
    scene = mi.load_dict({
        "type": "scene", "integrator": {"type": "aov", "aovs": "d:depth,p:position"},
        "sensor": {"type": "perspective", "fov": 60.0, "near_clip": near, "film": film, "sampler": sampler},
        "wall": {"type": "rectangle", "to_world": wall, "bsdf": {"type": "diffuse"}},
    })
    image = np.array(mi.render(scene))
    return image[..., -4], image[..., -3:]


print("Mitsuba", mi.__version__)
holds = True
for near in (0.01, 0.5):
    depth, place = frame(near)
    distance = np.linalg.norm(place, axis=-1)
    from_near = distance - near * distance / place[..., 2]
    print(f"near_clip {near}: depth in the middle {depth[16, 32]:.4f}, in a corner {depth[0, 0]:.4f}; distance "
          f"{distance[16, 32]:.4f} and {distance[0, 0]:.4f}; off the distance from the near plane by {abs(depth - from_near).max():.1e}")
    holds &= abs(depth - from_near).max() < 1e-4
sys.exit(0 if holds else 1)
PY

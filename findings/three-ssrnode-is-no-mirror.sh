#!/bin/sh
# three.js, SSRNode as it is made by default: one would expect a perfect mirror to show a wall as bright as it is, once the ray is long
# enough and nothing fades at the screen's border. Each hit is dimmed by its distance from the mirror and by the angle, and no
# setting that was tried turns that off; only rays drawn at random (stochastic), pressed into one direction by mirrorBias 1, show it as it is.
# Seen (median brightness, 1 is right): defaults 0.00, long rays without fade 0.78, 1000 m 0.87, intensity 2 1.57, stochastic with
# mirrorBias 1 1.00.
set -eu
. "$(dirname "$0")/browser.sh"

league '
wall = np.array(boxes.colors["wall"])
truth = dict(np.load(folder / "boxes.npz"))
shows_wall = truth["floor"] & ~truth["edge"] & truth["known"] & (truth["picture"] == wall).all(2)


def brightness(settings):
    """The 10th, 50th and 90th percentile of how bright the wall is in the mirror, over how bright it is."""
    found = run.read(render("three-node", boxes, settings))[shows_wall]
    return np.percentile(scenes.linear(found[:, 2]) / scenes.linear(wall[2]), (10, 50, 90))


plain = {"quality": 1, "screenEdgeFade": 0, "maxDistance": 40, "thickness": 0.3}
rows = {
    "defaults": {}, "long rays, no fade": plain, "the same, 1000 m": plain | {"maxDistance": 1000},
    "the same, intensity 2": plain | {"intensity": 2}, "stochastic, mirrorBias 1": plain | {"stochastic": True, "mirrorBias": 1},
}
seen = {name: brightness(settings) for name, settings in rows.items()}
for name, values in seen.items():
    print(f"{name:26} " + " ".join(f"{v:5.2f}" for v in values))
*dimmed, mirror = seen.values()
is_as_said = all(abs(values - 1).max() > 0.05 for values in dimmed) and abs(mirror - 1).max() < 0.05
sys.exit(0 if is_as_said else "this has changed")
'

#!/bin/sh
# three.js, SSRPass with a renderer whose depth is logarithmic (logarithmicDepthBuffer). One would expect the same picture, or a word that
# the pass needs standard depth. It reads what is in the buffer as standard depth, says nothing, and reflects next to nothing.
# Seen: 99.73 % of the known pixels are right with standard depth, and 4.31 % with logarithmic depth.
set -eu
. "$(dirname "$0")/browser.sh"

league '
plain = {"opacity": 1, "distanceAttenuation": False, "fresnel": False, "blur": False}
standard, logarithmic = (known("three-pass", boxes, plain | {"logarithmicDepthBuffer": is_log}) for is_log in (False, True))
print(f"known pixels right: {standard:.2f} % with standard depth, {logarithmic:.2f} % with logarithmic depth")
sys.exit(0 if standard > 95 and logarithmic < 50 else "this has changed")
'

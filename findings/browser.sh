# Sourced by findings about engines in the browser: a temporary folder with the pinned packages, and `league CODE`, which runs Python
# code that has the scenes and the judge of the league, and in `render(peer, scene, settings)` its pictures. No program of this project runs.

here=$(cd "$(dirname "$0")/.." && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
. "$here/scripts/league/packages.sh"
install_packages "$folder"
echo "three.js $THREE, Babylon.js $BABYLON, $("$chromium" --version 2>/dev/null)"

league() {
    PYTHONDONTWRITEBYTECODE=1 PYTHONPATH="$here/scripts/league" "$python" - "$folder" "$chromium" <<PYTHON
import sys
from pathlib import Path

import numpy as np
import run
import scenes

folder, chromium = Path(sys.argv[1]), sys.argv[2]
peers = run.Peers(str(folder), chromium)


def render(peer, scene, settings):
    problem = peers.render(peer, folder / f"{scene.name}.json", settings, folder / "out.png")
    if problem:
        sys.exit(f"{peer}: {problem}")
    return folder / "out.png"


def known(peer, scene, settings):
    """Known pixels right, in per cent."""
    return run.judge(render(peer, scene, settings), dict(np.load(folder / f"{scene.name}.npz")))["known"]


boxes = scenes.boxes()
scenes.write(boxes, folder)
$1
peers.close()
PYTHON
}

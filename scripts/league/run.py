#!/usr/bin/env python3
"""The league: what people would use instead, beside this program, on scenes whose truth is exact (docs/findings/league.md).

Each contestant renders each scene with its defaults, and with the best setting that a search finds: from the defaults on, twice
over all settings, each setting in turn takes the value with the most known pixels right, and of equal ones the least error.
Needs numpy and Pillow. scripts/league.sh installs what it needs into a folder of its own, and calls it.

Usage: run.py OUT --ssct PROGRAM [--packages FOLDER --chromium PROGRAM] [--method FOLDER]...
"""

import argparse
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import scenes
from PIL import Image, ImageDraw, ImageFont

HERE = Path(__file__).resolve().parent
WITHIN = 8  # of 255: a pixel is right if no channel differs from the truth by more
PASSES = 2  # how often the search goes over all settings

# The methods of ssct. Each has its fixed options, and for each searched option the values to try, the default first.
OURS = {
    "ssct": (["--method", "ssct"], {"--fade": ["on", "off"], "--preset": ["published", "author"]}),
    "dda": (["--method", "dda"], {"--fade": ["on", "off"], "--dda-thickness": ["default", "0.02", "0.05", "0.1", "0.3"]}),
    "stochastic": (["--method", "stochastic"], {"--fade": ["on", "off"], "--oracle": ["1", "2"]}),
    "unified, screen alone": (["--method", "unified", "--beyond", "none"], {"--fade": ["on", "off"]}),
    "unified, screen alone, oracle 2": (
        ["--method", "unified", "--beyond", "none", "--oracle", "2"],
        {"--fade": ["on", "off"]},
    ),
    "unified": (["--method", "unified"], {}),
    "traced": (["--method", "traced"], {}),
}


class Peers:
    """The engines in the browser, which render one job after the other."""

    def __init__(self, packages, chromium):
        command = ["node", str(HERE / "drive.mjs"), str(HERE / "peers"), packages, chromium]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        first = self.process.stdout.readline()
        if not first:
            sys.exit("the browser did not start: see above")
        self.said = json.loads(first)
        versions = json.loads((Path(packages) / "package.json").read_text())["dependencies"]
        self.versions = {name: versions[peer["npm"]].lstrip("^") for name, peer in self.said["peers"].items()}

    def render(self, peer, scene, settings, out):
        """Renders a scene file with an engine to the picture `out`. Returns the error as a text, or None."""
        job = {"peer": peer, "scene": str(scene), "settings": settings, "out": str(out)}
        self.process.stdin.write(json.dumps(job) + "\n")
        self.process.stdin.flush()
        return json.loads(self.process.stdout.readline()).get("error")

    def close(self):
        self.process.stdin.close()
        self.process.wait()


class Peer:
    """A contestant: one engine in the browser."""

    def __init__(self, peers, name):
        self.peers, self.key = peers, name
        about = peers.said["peers"][name]
        self.name, self.search = f"{about['title']} {peers.versions[name]}", about["settings"]

    def render(self, scene, chosen, out):
        return self.peers.render(self.key, scene.with_suffix(".json"), chosen, out)


class Ours:
    """A contestant: a method of this program, or a method from a folder (docs/custom-methods.md).

    `options` are fixed, and `search` has for each searched option the values to try.
    """

    def __init__(self, program, name, options, search):
        self.program, self.name, self.options, self.search = program, name, options, search

    def render(self, scene, chosen, out):
        """Renders a scene with the chosen options, or without reflections for None. Returns the error as a text, or None."""
        options = ["--reflectivity", "0"] if chosen is None else list(self.options)
        for option, value in (chosen or {}).items():
            options += [option, value] if value != "default" else []
        size = f"{scenes.WIDTH}x{scenes.HEIGHT}"
        command = [self.program, "render", "--scene", str(scene.with_suffix(".gltf")), "--size", size, *options, "-o", str(out)]
        done = subprocess.run(command, capture_output=True, text=True)
        return (done.stderr.strip().splitlines() or ["it failed"])[-1] if done.returncode else None


def read(path):
    """Returns an image as an array of integers of shape (height, width, 3)."""
    return np.asarray(Image.open(path).convert("RGB")).astype(int)


def judge(path, truth):
    """Compares a picture with the truth. Returns shares of pixels in per cent, and root mean squared errors from 0 to 1.

    Pixels at the edge of a material are not judged. A pixel is known if the camera sees where its ray ends, and hidden
    otherwise. A share of no pixels is None.
    """
    found, right_colors = read(path), truth["picture"].astype(int)
    off = abs(found - right_colors).max(2)
    judged = truth["floor"] & ~truth["edge"]
    known, hidden = judged & truth["known"], judged & ~truth["known"]
    brightest = np.maximum(found.max(2), 1)
    scaled = found * (right_colors.max(2) / brightest)[..., None]
    is_hue = (abs(scaled - right_colors).max(2) <= 2 * WITHIN) & (found.max(2) > WITHIN)

    def share(mask, among):
        return 100 * float(mask[among].mean()) if among.any() else None

    def error(among):
        return float(np.sqrt(((found - right_colors)[among] ** 2).mean()) / 255)

    return {
        "right": share(off <= WITHIN, judged),
        "known": share(off <= WITHIN, known),
        "rmse": error(known),
        "rmse of all": error(judged),
        "hue": share(is_hue, known),
        "hidden right": share(off <= WITHIN, hidden),
        "hidden black": share(found.max(2) <= WITHIN, hidden),
        "direct": share(off <= WITHIN, ~truth["floor"] & ~truth["edge"]),
    }


def search(contestant, scene, truth, folder):
    """Returns the judgements of a scene by the defaults and by the best setting, and the number of tried settings."""
    tried = {}

    def measure(chosen):
        key = json.dumps(chosen, sort_keys=True)
        if key not in tried:
            out = folder / f"{contestant.name.replace(' ', '-').replace(',', '')}-{scene.name}-{len(tried)}.png"
            problem = contestant.render(scene, chosen, out)
            tried[key] = ({"problem": problem} if problem else judge(out, truth)) | {"picture": out.name, "settings": chosen}
        return tried[key]

    def merit(result):
        """Returns a key that is greater for a better result: first the known pixels that are right, then a small error."""
        return (-1.0, 0.0) if "problem" in result else (round(result["known"], 3), -result["rmse"])

    defaults = measure({})
    best, chosen = defaults, {}
    for _ in range(PASSES):
        for name, values in contestant.search.items():
            for value in values:
                other = {k: v for k, v in chosen.items() if k != name} | ({} if value == values[0] else {name: value})
                result = measure(other)
                if merit(result) > merit(best):
                    best, chosen = result, other
    return {"defaults": defaults, "best": best, "tried": len(tried)}


def table(rows, of_scenes):
    """Returns a table in Markdown: a row for each contestant and setting, and a column for each scene."""
    def cell(result):
        if "problem" in result:
            return "–"
        return f"{result['right']:.2f}; {result['known']:.2f}; {result['rmse']:.3f}"

    lines = ["| | " + " | ".join(s.title for s in of_scenes) + " |", "|---" * (len(of_scenes) + 1) + "|"]
    for name, per_scene in rows.items():
        for which in ("defaults", "best"):
            if which == "best" and all(r["best"]["settings"] == {} for r in per_scene.values() if "best" in r):
                continue
            cells = [cell(per_scene[s.name][which]) if which in per_scene[s.name] else "–" for s in of_scenes]
            lines.append(f"| {name}, {which} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def records(rows, of_scenes, peers):
    """Returns a record for each contestant, scene and setting (the defaults or the best). The record of a scene that was not
    judged says why."""
    made = []
    for name, per_scene in rows.items():
        for scene in of_scenes:
            about = {"kind": "league", "contestant": name, "scene": scene.name, "title": scene.title}
            result = per_scene[scene.name]
            if "best" not in result:
                made.append(about | {"problem": result["problem"], "direct": result["direct"]})
                continue
            about["tried"] = result["tried"]
            made += [about | {"setting": which} | result[which] for which in ("defaults", "best")]
    if peers:
        made.append({"kind": "browser", "chromium": peers.said["chromium"]})
    return made


def sheet(rows, of_scenes, folder):
    """Writes sheet.png: for each scene the truth, and for each contestant its best picture and the difference from the truth."""
    font, side, high = ImageFont.load_default(size=13), scenes.WIDTH // 2, scenes.HEIGHT // 2
    columns, caption = 2 * len(of_scenes), 18
    image = Image.new("RGB", (columns * (side + 4), (len(rows) + 1) * (high + caption)), "white")
    draw = ImageDraw.Draw(image)

    def put(column, row, picture, text):
        place = (column * (side + 4), row * (high + caption))
        draw.text((place[0] + 2, place[1] + 1), text, "black", font=font)
        image.paste(picture.resize((side, high), Image.Resampling.BOX), (place[0], place[1] + caption))

    for n, scene in enumerate(of_scenes):
        truth = np.load(folder / f"{scene.name}.npz")["picture"]
        put(2 * n, 0, Image.fromarray(truth), f"truth: {scene.title}")
        for row, (name, per_scene) in enumerate(rows.items(), 1):
            best = per_scene[scene.name].get("best", {})
            if "picture" in best and "problem" not in best:
                found = Image.open(folder / best["picture"]).convert("RGB")
                off = np.clip(abs(np.asarray(found).astype(int) - truth.astype(int)), 0, 255).astype(np.uint8)
                put(2 * n, row, found, name)
                put(2 * n + 1, row, Image.fromarray(off), "off by")
    image.save(folder / "sheet.png")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=Path)
    parser.add_argument("--ssct", required=True)
    parser.add_argument("--packages")
    parser.add_argument("--chromium")
    parser.add_argument("--method", action="append", default=[], help="a method's folder; as often as there are methods")
    options = parser.parse_args()
    out = options.out.resolve()
    out.mkdir(parents=True, exist_ok=True)
    of_scenes = scenes.all_scenes()
    for scene in of_scenes:
        scenes.write(scene, out)
    peers = Peers(options.packages, options.chromium) if options.packages else None
    contestants = [Peer(peers, name) for name in peers.said["peers"]] if peers else []
    contestants += [Ours(options.ssct, name, *rest) for name, rest in OURS.items()]
    contestants += [Ours(options.ssct, Path(m).name, ["--method", m], {}) for m in options.method]
    rows = {}
    for contestant in contestants:
        rows[contestant.name] = {}
        for scene in of_scenes:
            truth = dict(np.load(out / f"{scene.name}.npz"))
            place = out / scene.name
            direct = out / f"{contestant.name.replace(' ', '-').replace(',', '')}-{scene.name}-direct.png"
            place_of = type("Place", (), {"name": scene.name, "with_suffix": staticmethod(place.with_suffix)})
            problem = contestant.render(place_of, None, direct)
            shown = None if problem else judge(direct, truth)["direct"]
            if problem or shown < 99.9:
                print(f"{contestant.name}, {scene.title}: not judged: {problem or f'its direct picture is right in {shown:.2f} %'}")
                rows[contestant.name][scene.name] = {"problem": problem, "direct": shown}
                continue
            result = search(contestant, place_of, truth, out)
            rows[contestant.name][scene.name] = result
            best = result["best"]
            print(
                f"{contestant.name}, {scene.title}: known {result['defaults'].get('known', 0):.2f} -> {best.get('known', 0):.2f} % "
                f"with {best['settings']} of {result['tried']}",
                flush=True,
            )
    if peers:
        peers.close()
    (out / "league.json").write_text(json.dumps(records(rows, of_scenes, peers), indent=1) + "\n")
    (out / "league.md").write_text(table(rows, of_scenes) + "\n")
    print((out / "league.md").read_text())
    sheet(rows, of_scenes, out)
    print(out / "sheet.png")


if __name__ == "__main__":
    main()

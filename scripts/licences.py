#!/usr/bin/env python3
"""Writes the licences of all crates that the programs are built of into one file, for `make dist`.

    scripts/licences.py FILE      write
    scripts/licences.py --check   only check that each crate has a licence that may be passed on with the programs

A crate fails whose licence is none of ALLOWED, or that names none. Which licence is meant where a crate offers several is
the choice of whoever uses it; all of its texts are written."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

# Licences that only require that their text, or a notice, is passed on with the program.
ALLOWED = {
    "0BSD", "Apache-2.0", "Apache-2.0 WITH LLVM-exception", "BSD-2-Clause", "BSD-3-Clause", "BSL-1.0", "CC0-1.0", "ISC", "MIT",
    "MIT-0", "OFL-1.1", "Ubuntu-font-1.0", "Unicode-3.0", "Unlicense", "Zlib",
}
TEXTS = re.compile(r"^(licen[cs]e|copying|copyright|notice|unlicense|ofl|ufl)", re.IGNORECASE)


def allowed(expression):
    """Returns whether an SPDX expression can be met by licences of ALLOWED alone."""
    words = re.findall(r"[()]|[^\s()]+", expression.replace("/", " OR "))

    def joined(word, part, join):
        """Reads parts with a word between them, and joins their values: any for OR, all for AND."""
        values = [part()]
        while words[:1] == [word]:
            del words[0]
            values.append(part())
        return join(values)

    def choice():
        """Reads an expression, in which AND binds more strongly than OR."""
        return joined("OR", lambda: joined("AND", one, all), any)

    def one():
        """Reads the name of a licence, perhaps WITH an exception, or an expression in brackets."""
        name = words.pop(0)
        if name == "(":
            value = choice()
            del words[0]
            return value
        if words[:1] == ["WITH"]:
            name = f"{name} WITH {words[1]}"
            del words[:2]
        return name in ALLOWED

    return choice() and not words


def crates():
    """Returns the packages that the programs contain on x86-64 Linux, without packages that only build or test them."""
    cargo = os.environ.get("CARGO", "cargo")
    root = Path(__file__).resolve().parent.parent
    command = [cargo, "metadata", "--format-version", "1", "--filter-platform", "x86_64-unknown-linux-gnu"]
    found = json.loads(subprocess.run(command, cwd=root, check=True, capture_output=True).stdout)
    packages = {package["id"]: package for package in found["packages"]}
    nodes = {node["id"]: node for node in found["resolve"]["nodes"]}
    left, reached = list(found["workspace_members"]), set()
    while left:
        package = left.pop()
        if package in reached:
            continue
        reached.add(package)
        for dependency in nodes[package]["deps"]:
            if any(kind["kind"] is None for kind in dependency["dep_kinds"]):
                left.append(dependency["pkg"])
    others = (packages[package] for package in reached if packages[package]["source"])
    return sorted(others, key=lambda package: (package["name"], package["version"]))


def texts(package):
    """Yields the file name and the text of each licence of a crate."""
    folder = Path(package["manifest_path"]).parent
    named = [folder / package["license_file"]] if package["license_file"] else []
    for path in sorted(set(named + [path for path in folder.iterdir() if TEXTS.match(path.name)])):
        if path.is_file():
            yield path.name, path.read_text(encoding="utf-8", errors="replace").strip()


def main():
    if len(sys.argv) != 2 or sys.argv[1] in ("--help", "-h"):
        print(__doc__)
        return 0 if len(sys.argv) == 2 else 2
    all_crates = crates()
    wrong = [p for p in all_crates if not (p["license"] and allowed(p["license"]))]
    for package in wrong:
        print(f"licences: {package['name']} {package['version']} is under {package['license']}", file=sys.stderr)
    if wrong:
        return 1
    if sys.argv[1] != "--check":
        parts = []
        for package in all_crates:
            head = f"{package['name']} {package['version']}: {package['license']}\n{package['repository'] or ''}".strip()
            parts.append("\n\n".join([head] + [f"--- {name}\n\n{text}" for name, text in texts(package)]))
        rule = "\n\n" + "=" * 80 + "\n\n"
        Path(sys.argv[1]).write_text(rule.join(parts) + "\n", encoding="utf-8")
    print(f"licences: {len(all_crates)} crates")
    return 0


if __name__ == "__main__":
    sys.exit(main())

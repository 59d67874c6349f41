#!/usr/bin/env bash
# three.js, OBJLoader: one line element (l) makes lines of all faces of its object. The corners of the triangles are drawn in pairs, so
# that the surface is gone. A single point (p) makes points of them. Expected: a mesh, and the line or the point beside it.
# Seen, with three.js 0.187.0: a square of two triangles is a mesh of 6 corners. With one loose edge in the object it is no mesh, but
# LineSegments of 8 ends: two of the edge, and the 6 corners. Nothing is said.
set -euo pipefail

. "$(dirname "$0")/npm.sh" three@0.187.0
cat >load.mjs <<'JS'
import { OBJLoader } from "three/examples/jsm/loaders/OBJLoader.js";

const square = "o square\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 5 0\nf 1 2 3\nf 1 3 4\n";
const seen = { faces: square, "faces and a line": square + "l 4 5\n", "faces and a point": square + "p 5\n" };
for (const [name, text] of Object.entries(seen)) {
  const parts = new OBJLoader().parse(text).children;
  seen[name] = parts.map((part) => `${part.type} ${part.geometry.getAttribute("position").count}`).join(", ");
  console.log(`${name}: ${seen[name]}`);
}
const holds = Object.values(seen).join("; ") === "Mesh 6; LineSegments 8; Points 7";
if (!holds) console.error("this changed: it was Mesh 6; LineSegments 8; Points 7");
process.exit(holds ? 0 : 1);
JS
node load.mjs

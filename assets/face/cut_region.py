#!/usr/bin/env python3
"""Cuts the skin around the right eye out of the CC0 face and writes small text files.

Usage: cut_region.py FACE_DIR OUT_DIR

FACE_DIR holds `base.obj` (hm08, 1 unit = 1 dm, y up, z towards the viewer), `faceunits/*.target`
(lines `index dx dy dz`) and `macro/*.target.gz`. OUT_DIR receives `region.obj` and
`targets/*.target`. Only the standard library is used; the same input gives the same bytes.

The output is in the globe frame: mm, y up, the patient looks along -z, +x is the patient's right,
so hm08's (x, y, z) becomes (-x, y, -z) * 100, centred on hm08's own eyeball. Nothing is fitted here:
the fit of this face to an anatomical globe is the program's.
"""

import gzip
import sys
from pathlib import Path

ANCESTRIES = ("african", "asian", "caucasian")
SEXES = ("female", "male")
# Face units that move the skin around the right eye, and the names they ship under.
UNITS = {
    "eyeBlinkRight": "blink",
    "eyeLookDownRight": "look_down",
    "eyeLookUpRight": "look_up",
    "eyeLookInRight": "look_in",
    "eyeLookOutRight": "look_out",
    "eyeSquintRight": "squint",
    "eyeWideRight": "wide",
}
# Two neighbouring vertices on each closed edge loop around the fissure (28 vertices a loop).
LOOPS = {"lid_margin": (0, 1), "lid_border": (170, 171)}
REACH_MM = 56.0
FARTHEST_NASAL_MM = -44.0


def read_obj(path):
    """Vertices, and the body's faces as lists of (vertex, texture) indices."""
    vertices, textures, faces, group = [], [], [], ""
    for line in path.read_text().splitlines():
        words = line.split()
        if line.startswith("v "):
            vertices.append(tuple(map(float, words[1:4])))
        elif line.startswith("vt "):
            textures.append(tuple(map(float, words[1:3])))
        elif line.startswith("g "):
            group = words[1]
        elif line.startswith("f "):
            corners = [tuple(int(n) - 1 for n in w.split("/")[:2]) for w in words[1:]]
            faces.append((group, corners))
    return vertices, textures, faces


def read_target(path):
    """Vertex offsets, in decimetres."""
    opener = gzip.open if path.suffix == ".gz" else open
    offsets = {}
    with opener(path, "rt") as lines:
        for line in lines:
            words = line.split()
            if len(words) == 4 and not line.startswith("#"):
                offsets[int(words[0])] = tuple(map(float, words[1:]))
    return offsets


def neutral(vertices, macro_dir):
    """The mean of three ancestries and two sexes, young."""
    out = [list(v) for v in vertices]
    share = 1.0 / (len(ANCESTRIES) * len(SEXES))
    for ancestry in ANCESTRIES:
        for sex in SEXES:
            target = read_target(macro_dir / f"{ancestry}-{sex}-young.target.gz")
            for index, offset in target.items():
                for axis in range(3):
                    out[index][axis] += share * offset[axis]
    return out


def edges_of(face):
    return [tuple(sorted((a, b))) for a, b in zip(face, face[1:] + face[:1])]


def walk_loop(faces_at, neighbours, first, second):
    """Follows an edge loop straight through regular (valence four) vertices until it closes."""
    loop = [first, second]
    while True:
        previous, here = loop[-2:]
        if len(neighbours[here]) != 4:
            raise SystemExit(f"the edge loop through {first} meets an irregular vertex {here}")
        beside = set().union(*(f for f in faces_at[here] if previous in f))
        (onward,) = neighbours[here] - beside
        if onward == first:
            return loop
        loop.append(onward)


def grow(faces, loop_inside, keep):
    """Faces reached from outside the margin loop without crossing it."""
    by_edge = {}
    for number, face in enumerate(faces):
        for edge in edges_of(face):
            by_edge.setdefault(edge, []).append(number)
    barrier = set(edges_of(loop_inside))
    start = next(
        n for n, f in enumerate(faces) if keep(f) and LOOPS["lid_border"][0] in f and LOOPS["lid_border"][1] in f
    )
    reached, stack = {start}, [start]
    while stack:
        for edge in edges_of(faces[stack.pop()]):
            if edge in barrier:
                continue
            for number in by_edge[edge]:
                if number not in reached and keep(faces[number]):
                    reached.add(number)
                    stack.append(number)
    return sorted(reached)


def main(face_dir, out_dir):
    base, textures, groups = read_obj(face_dir / "base.obj")
    eyeball = {v for g, f in groups if g == "helper-r-eye" for v, _ in f}
    shape = neutral(base, face_dir / "macro")
    centre = [sum(extreme(shape[v][k] for v in eyeball) for extreme in (min, max)) / 2 for k in range(3)]

    def to_globe(p):
        return (-100 * (p[0] - centre[0]), 100 * (p[1] - centre[1]), -100 * (p[2] - centre[2]))

    points = [to_globe(p) for p in shape]
    body = [f for g, f in groups if g == "body"]
    faces = [[v for v, _ in f] for f in body]
    texture_of = {v: t for f in body for v, t in f}

    faces_at, neighbours = {}, {}
    for face in faces:
        for a, b in zip(face, face[1:] + face[:1]):
            neighbours.setdefault(a, set()).add(b)
            neighbours.setdefault(b, set()).add(a)
            faces_at.setdefault(a, []).append(set(face))
    loops = {name: walk_loop(faces_at, neighbours, *pair) for name, pair in LOOPS.items()}

    def keep(face):
        return all(
            sum(c * c for c in points[v]) < REACH_MM**2 and points[v][0] > FARTHEST_NASAL_MM and points[v][2] < 30.0
            for v in face
        )

    chosen = [faces[n] for n in grow(faces, loops["lid_margin"], keep)]
    order = sorted({v for f in chosen for v in f})
    new = {old: i for i, old in enumerate(order)}

    lines = ["# Skin around the right eye, cut from hm08 (CC0) by cut_region.py; globe frame, mm."]
    lines += ["v %.3f %.3f %.3f" % points[v] for v in order]
    lines += ["vt %.5f %.5f" % textures[texture_of[v]] for v in order]
    lines.append("g skin")
    lines += ["f " + " ".join(f"{new[v] + 1}/{new[v] + 1}" for v in f) for f in chosen]
    for name, loop in loops.items():
        lines.append(f"g {name}")
        lines.append("l " + " ".join(str(new[v] + 1) for v in loop))
    (out_dir / "targets").mkdir(parents=True, exist_ok=True)
    (out_dir / "region.obj").write_text("\n".join(lines) + "\n")

    for unit, name in UNITS.items():
        rows = [f"# {unit} of hm08 (CC0): region.obj vertex (from 0), offset in mm, globe frame."]
        for old, (dx, dy, dz) in sorted(read_target(face_dir / "faceunits" / f"{unit}.target").items()):
            moved = (-100 * dx, 100 * dy, -100 * dz)
            if old in new and any(abs(c) >= 0.005 for c in moved):
                rows.append("%d %.2f %.2f %.2f" % (new[old], *moved))
        (out_dir / "targets" / f"{name}.target").write_text("\n".join(rows) + "\n")
    print(f"{len(order)} vertices, {len(chosen)} faces")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit("usage: cut_region.py FACE_DIR OUT_DIR")
    main(Path(sys.argv[1]), Path(sys.argv[2]))

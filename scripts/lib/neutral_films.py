"""Neutral versions of the airplane and of the studio, which every renderer draws.

The bundled films are written in POV-Ray's language. These have the same weights: an
airplane over an aerodrome, a toy car before a sculpture of 20 000 triangles.
"""

import math


def look(r, g, b, solid):
    return f"material((colour: ({r}, {g}, {b})), {solid})\n"


def box(lower, upper):
    return f"box(min: {lower}, max: {upper})"


def cylinder(base, cap, radius):
    return f"cylinder(base: {base}, cap: {cap}, radius: {radius})"


def union(*solids):
    return f"union([{', '.join(solids)}])"


def painted(r, g, b, solid):
    return look(r, g, b, solid).strip()


AIRPLANE = union(
    painted(0.9, 0.9, 0.92, cylinder((-11, 0, 0), (9, 0, 0), 1.9)),
    painted(0.9, 0.9, 0.92, "translate((-11, 0, 0), scale((4, 1.9, 1.9), sphere(radius: 1)))"),
    painted(0.9, 0.9, 0.92, "cone(base: (9, 0, 0), base_radius: 1.9, cap: (18, 1.15, 0), cap_radius: 0.42)"),
    painted(0.5, 0.5, 0.55, box((-2.5, -1.1, -15), (2, -0.7, 15))),
    painted(0.05, 0.14, 0.48, box((13.5, 1.4, -0.2), (17.5, 7.6, 0.2))),
    painted(0.5, 0.5, 0.55, box((14, 0.9, -5.6), (17, 1.2, 5.6))),
    painted(0.05, 0.14, 0.48, cylinder((-4, -2.4, 5.2), (0, -2.4, 5.2), 1.05)),
    painted(0.05, 0.14, 0.48, cylinder((-4, -2.4, -5.2), (0, -2.4, -5.2), 1.05)),
)


def plane(folder, size, frames):
    """An airplane over an aerodrome, without shadows."""
    folder.mkdir(parents=True, exist_ok=True)
    slower = frames / 25
    windows = [painted(0.1, 0.14, 0.2, box((x, y, -8.1), (x + 3, y + 2.5, -7.9)))
               for x in range(-28, 28, 5) for y in (2, 7)]
    solids = {
        "airplane": AIRPLANE + "\n",
        "land": look(0.35, 0.5, 0.25, box((-850, -4, -100), (850, 0, 900))),
        "runway": look(0.35, 0.35, 0.37, box((-400, 0, -24), (400, 0.05, 24))),
        "hall": union(painted(0.6, 0.62, 0.66, box((-30, 0, -8), (30, 12, 8))), *windows) + "\n",
        "tower": union(painted(0.8, 0.78, 0.7, cylinder((0, 0, 0), (0, 40, 0), 5)),
                       painted(0.2, 0.3, 0.4, cylinder((0, 40, 0), (0, 48, 0), 10))) + "\n",
        "hangar": look(0.55, 0.57, 0.6, "scale((18, 20, 18), " + cylinder((0, 0, -1), (0, 0, 1), 1) + ")"),
        "mast": union(painted(0.5, 0.52, 0.55, cylinder((0, 0, 0), (0, 34, 0), 0.5)),
                      painted(0.9, 0.9, 0.8, box((-3, 32, -0.3), (3, 34, 0.3)))) + "\n",
        "tree": union(painted(0.3, 0.22, 0.12, cylinder((0, 0, 0), (0, 4, 0), 0.7)),
                      painted(0.15, 0.38, 0.15, "translate((0, 8, 0), scale((4, 6, 4), sphere(radius: 1)))")) + "\n",
    }
    for name, text in solids.items():
        (folder / f"{name}.ron").write_text(text)
    flight = [-4.75, -1.1, -4.3, 1.2, -0.1, -0.12]
    lines = [
        f"*size {size[0]} {size[1]}", f"*images {frames}", "*shadows 0", "*antialias off",
        "*background 0.45 0.62 0.85", "*eye 0 14 0", "*aim 0 24 150", "*angles 48 48",
        "*light -90 120 -100  0.95 0.90 0.78  sun 0 0 0",
        "!land.ron 0 0 0  0 0 0", "!runway.ron 0 0 128  0 0 0", "!tower.ron 14 0 205  0 0 0",
        "!hall.ron 62 0 225  0 0 0", "!hall.ron -20 0 320  0 10 0",
        *(f"!hangar.ron {x} 0 240  0 {turn} 0" for x, turn in ((-82, 8), (-44, 0), (-6, -6))),
        *(f"!mast.ron {x} 0 {z}  0 0 0" for x, z in ((17.5, 72), (-60, 190), (40, 196), (96, 196))),
        *(f"!tree.ron {7 * k - 140} 0 {290 + 13 * (k % 3)}  0 {40 * k} 0" for k in range(40)),
        "!airplane.ron -26 3.6 194  0 58 0",
        "!airplane.ron 80 40 215  -26 -42 4  " + " ".join(repr(v / slower) for v in flight) + "  name=plane",
    ]
    path = folder / "plane.anim"
    path.write_text("\n".join(lines) + "\n")
    return path


def knot(path, around=400, across=25):
    """A torus knot of 2 · around · across triangles."""
    def centre(t):
        r = 2 + math.cos(3 * t)
        return (0.45 * r * math.cos(2 * t), 0.45 * math.sin(3 * t), 0.45 * r * math.sin(2 * t))

    vertices = []
    for i in range(around):
        t = 2 * math.pi * i / around
        c, ahead = centre(t), centre(t + 1e-4)
        along = [a - b for a, b in zip(ahead, c)]
        side = (along[2], 0.0, -along[0])
        up = (along[1] * side[2] - along[2] * side[1], along[2] * side[0] - along[0] * side[2],
              along[0] * side[1] - along[1] * side[0])
        side, up = ([x / math.hypot(*v) for x in v] for v in (side, up))
        for j in range(across):
            a = 2 * math.pi * j / across
            vertices.append([p + 0.22 * (math.cos(a) * s + math.sin(a) * u) for p, s, u in zip(c, side, up)])
    faces = []
    for i in range(around):
        for j in range(across):
            a, b = i * across + j, i * across + (j + 1) % across
            c, d = (a + across) % len(vertices), (b + across) % len(vertices)
            faces += [(a, b, c), (b, d, c)]
    lines = ["ply", "format ascii 1.0", f"element vertex {len(vertices)}", "property float x", "property float y",
             "property float z", f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header"]
    lines += [" ".join(f"{x:.6f}" for x in v) for v in vertices]
    lines += ["3 " + " ".join(map(str, f)) for f in faces]
    path.write_text("\n".join(lines) + "\n")


CAR = union(
    painted(0.8, 0.1, 0.1, box((-0.9, 0.2, -0.45), (0.9, 0.6, 0.45))),
    painted(0.2, 0.25, 0.3, box((-0.5, 0.6, -0.4), (0.4, 0.95, 0.4))),
    *(painted(0.05, 0.05, 0.05, cylinder((x, 0.22, z - 0.08), (x, 0.22, z + 0.08), 0.22))
      for x in (-0.55, 0.55) for z in (-0.45, 0.45)),
)


def studio(folder, size, frames):
    """A toy car drives past a sculpture, with shadows and antialiasing."""
    folder.mkdir(parents=True, exist_ok=True)
    knot(folder / "knot.ply")
    solids = {
        "car": CAR + "\n",
        "wall": look(0.55, 0.5, 0.45, box((-40, -1, 9), (40, 30, 10))),
        "table": look(0.4, 0.28, 0.18, box((-40, -1, -30), (40, 0, 9))),
        "plinth": look(0.8, 0.8, 0.78, box((-1.6, 0, -1.6), (1.6, 3.2, 1.6))),
        "vase": look(0.2, 0.35, 0.6, union("scale((1.1, 1.6, 1.1), translate((0, 1, 0), sphere(radius: 1)))",
                                           cylinder((0, 2.8, 0), (0, 3.8, 0), 0.4))),
        "books": union(*(painted(0.3 + 0.2 * k, 0.5 - 0.1 * k, 0.3, box((-1.2, 0.4 * k, -0.9), (1.2, 0.4 * k + 0.36, 0.9)))
                         for k in range(4))) + "\n",
        "pear": look(0.6, 0.7, 0.2, union("translate((0, 0.55, 0), sphere(radius: 0.55))",
                                          "translate((0, 1.1, 0), scale((0.3, 0.5, 0.3), sphere(radius: 1)))")),
    }
    for name, text in solids.items():
        (folder / f"{name}.ron").write_text(text)
    lines = [
        f"*size {size[0]} {size[1]}", f"*images {frames}", "*shadows 1", "*antialias 0.3 2",
        "*background 0.02 0.02 0.025", "*eye -0.4 5.6 -17", "*aim 0.1 2.75 1.2", "*angles 38 38",
        "*light -9 13 -9  0.98 0.90 0.78  sun 0 0 0", "*light 11 9 -4  0.36 0.44 0.58  sun 0 0 0",
        "!wall.ron 0 0 0  0 0 0", "!table.ron 0 0 0  0 0 0", "!plinth.ron 0.2 0 2.4  0 24 0",
        "!knot.ply 0.2 4.6 2.4  0 -18 0", "!vase.ron -4.6 0 3.4  0 0 0", "!books.ron 5 0 2.6  0 -24 0",
        "!pear.ron -3.3 0 0.2  0 30 0", "!pear.ron -2.2 0 0.9  0 160 0",
        f"!car.ron -3.7 0 -2.4  0 -20 0  {5 / frames!r} 0 {-1 / frames!r}  0 {-40 / frames!r} 0  name=car",
    ]
    path = folder / "studio.anim"
    path.write_text("\n".join(lines) + "\n")
    return path


FILMS = {"plane": plane, "studio": studio}

#!/usr/bin/env python3
"""A renderer for decor in one file: spheres, boxes and planes, by ray casting.

    decor render film.anim -o frames --renderer 'exec:python3 raycast.py'

It is an example of the protocol of docs/adapters.md, not a fast renderer. decor
starts it anew for every call, with one JSON object on stdin, and reads one JSON
object from its stdout. Layers are files: see `write_exr`.

It needs numpy. All numbers of a picture are computed pixel by pixel, in the same
way wherever a window begins: that is why `crop_grid` may be 1.
"""

import json
import os
import struct
import sys

import numpy

PROTOCOL = 1
NEAREST = 1e-9  # A surface nearer to where a ray begins is that of its beginning.

HELLO = {
    "name": "raycast.py",
    "version": "1.0",
    "abilities": {
        "shadows": True,
        "hidden_casters": True,
        "coverage": True,
        "crop_grid": 1,
        # Computed with 53 bits, written with 24.
        "depth_quantum": [0.0, 1e-7],
        # It uses one core, and Python needs a moment to start.
        "jobs": os.cpu_count() or 1,
        "call_overhead_s": 0.3,
        "units": "scene units; lights fade only where the film says so",
    },
}

# What a solid without a look has.
PLAIN = {"colour": [0.8, 0.8, 0.8], "ambient": 0.1, "diffuse": 0.7}


class Unsupported(Exception):
    """Something that this renderer cannot draw: decor shows the words."""


# --- solids -----------------------------------------------------------------


def flatten(solid, matrix, look, parts):
    """Appends the primitives of a solid: (shape, from world to shape, look)."""
    kind = solid["type"]
    if kind in ("sphere", "box", "plane"):
        parts.append((solid, numpy.linalg.inv(matrix), look or PLAIN))
    elif kind == "union":
        for part in solid["of"]:
            flatten(part, matrix, look, parts)
    elif kind == "transform":
        flatten(solid["of"], matrix @ square(solid["matrix"]), look, parts)
    elif kind == "look":
        flatten(solid["of"], matrix, look or solid["material"], parts)
    else:
        raise Unsupported(f"a {kind}")


def square(rows):
    """Three rows of four, with the fourth that they leave out."""
    return numpy.array(rows + [[0.0, 0.0, 0.0, 1.0]])


def primitives(request, instances):
    """The primitives of some instances."""
    parts = []
    for instance in instances:
        prototype = request["prototypes"][instance["prototype"]]
        flatten(prototype["solid"], square(instance["matrix"]), None, parts)
    return parts


# --- rays -------------------------------------------------------------------
# Points and directions are arrays of 3 × n; distances, arrays of n.


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def apply(matrix, v, w):
    """A matrix times points (w = 1) or directions (w = 0)."""
    rows = [m[0] * v[0] + m[1] * v[1] + m[2] * v[2] + m[3] * w for m in matrix[:3]]
    return numpy.stack(rows)


def cut(shape, origin, along):
    """Where lines enter and leave a shape, in steps of `along`; NaN or a way out
    before the way in: they miss it."""
    with numpy.errstate(divide="ignore", invalid="ignore"):
        if shape["type"] == "sphere":
            to = numpy.array(shape["centre"])[:, None] - origin
            length2 = dot(along, along)
            middle = dot(to, along) / length2
            beside = to - along * middle
            half = numpy.sqrt((shape["radius"] ** 2 - dot(beside, beside)) / length2)
            return middle - half, middle + half
        if shape["type"] == "box":
            low = (numpy.array(shape["min"])[:, None] - origin) / along
            high = (numpy.array(shape["max"])[:, None] - origin) / along
            return numpy.fmin(low, high).max(0), numpy.fmax(low, high).min(0)
        normal = numpy.array(shape["normal"])[:, None]
        above = dot(normal, origin) - shape["distance"] * numpy.sqrt(dot(normal, normal))
        rises = dot(normal, along)
        crosses = -above / rises
        enters = numpy.where(rises < 0, crosses, -numpy.inf)
        return enters, numpy.where(rises < 0, numpy.inf, crosses)


def trace(parts, origin, along):
    """The distance to what is seen (infinite where nothing is), and its number."""
    nearest = numpy.full(along.shape[1], numpy.inf)
    which = numpy.full(along.shape[1], -1)
    for number, (shape, to_shape, _) in enumerate(parts):
        enters, leaves = cut(shape, apply(to_shape, origin, 1), apply(to_shape, along, 0))
        seen = numpy.where(enters > NEAREST, enters, leaves)
        hit = (leaves > enters) & (seen > NEAREST) & (seen < nearest)
        nearest = numpy.where(hit, seen, nearest)
        which = numpy.where(hit, number, which)
    return nearest, which


def normals(shape, to_shape, point):
    """Unit normals of a shape, out of it, at points of its surface."""
    local = apply(to_shape, point, 1)
    if shape["type"] == "sphere":
        out = local - numpy.array(shape["centre"])[:, None]
    elif shape["type"] == "box":
        low, high = numpy.array(shape["min"])[:, None], numpy.array(shape["max"])[:, None]
        place = (2 * local - low - high) / (high - low)
        largest = numpy.abs(place) >= numpy.abs(place).max(0)
        out = numpy.sign(place) * largest
    else:
        out = numpy.repeat(numpy.array(shape["normal"])[:, None], local.shape[1], 1)
    # A normal goes by the transposed inverse of what points go by.
    out = apply(to_shape[:3, :3].T @ numpy.eye(3, 4), out, 0)
    return out / numpy.sqrt(dot(out, out))


# --- light ------------------------------------------------------------------


def shade(scene, seen, casters, origin, along):
    """Colour and coverage of rays: ambient and diffuse light, hard shadows."""
    distance, which = trace(seen, origin, along)
    colour = numpy.zeros((4, along.shape[1]))
    for number in set(which[which >= 0]):
        shape, to_shape, look = seen[number]
        mine = which == number
        point = origin[:, mine] + along[:, mine] * distance[mine]
        normal = normals(shape, to_shape, point)
        normal = numpy.where(dot(normal, along[:, mine]) > 0, -normal, normal)
        light = numpy.full((3, point.shape[1]), look["ambient"])
        for lamp in scene["lights"]:
            light = light + look["diffuse"] * arriving(scene, casters, lamp, point, normal)
        colour[:3, mine] = numpy.array(look["colour"])[:, None] * light
        colour[3, mine] = 1.0
    return colour


def arriving(scene, casters, lamp, point, normal):
    """The light of a lamp that falls on surfaces, red, green, blue."""
    if lamp["type"] not in ("point", "sun"):
        raise Unsupported(f"a light of type {lamp['type']}")
    position = numpy.array(lamp["position"])[:, None]
    if lamp["type"] == "sun":
        way = position - numpy.array(lamp["towards"])[:, None] + 0 * point
        far = numpy.inf
    else:
        way = position - point
        far = numpy.sqrt(dot(way, way))
    way = way / numpy.sqrt(dot(way, way))
    strength = numpy.maximum(dot(normal, way), 0.0)
    if lamp["fade"] is not None and lamp["type"] == "point":
        fade = lamp["fade"]
        strength = strength * 2 / (1 + (far / fade["distance"]) ** fade["power"])
    if scene["shadows"]:
        # A step off the surface, so that it is not in its own shadow.
        step = 1e-9 * (1 + numpy.abs(point).max(0))
        blocked, _ = trace(casters, point + normal * step, way)
        strength = strength * (blocked >= far)
    return numpy.array(lamp["colour"])[:, None] * strength


# --- pictures ---------------------------------------------------------------


def rays(camera, size, x, y):
    """The rays through points of the picture, in pixels from the upper left."""
    right = camera["half_width"] * (2 * x / size[0] - 1)
    up = camera["half_height"] * (1 - 2 * y / size[1])
    axes = [numpy.array(camera[name])[:, None] for name in ("forward", "right", "up", "eye")]
    along = axes[0] + axes[1] * right + axes[2] * up
    return axes[3] + 0 * along, along / numpy.sqrt(dot(along, along))


def draw(request, shot):
    """Writes one layer."""
    left, top, columns, rows = shot["window"]
    y, x = numpy.divmod(numpy.arange(columns * rows), columns)
    x, y = x + left, y + top
    seen = primitives(request, shot["instances"])
    if request["output"] == "depth":
        distance, _ = trace(seen, *rays(shot["camera"], request["size"], x + 0.5, y + 0.5))
        channels = {"Z": distance}
    else:
        casters = seen + primitives(request, shot["hidden"])
        side = request["antialias"]["depth"] if request["antialias"] else 1
        colour = numpy.zeros((4, x.size))
        for sample in range(side * side):
            right, down = (sample % side + 0.5) / side, (sample // side + 0.5) / side
            ray = rays(shot["camera"], request["size"], x + right, y + down)
            colour += shade(shot, seen, casters, *ray)
        colour /= side * side
        if request["output"] == "colour":
            colour[:3] += numpy.array(shot["background"])[:, None] * (1 - colour[3])
            colour[3] = 1.0
        channels = dict(zip("RGBA", colour))
    write_exr(os.path.join(request["folder"], shot["file"]), columns, rows, channels)


def write_exr(path, columns, rows, channels):
    """OpenEXR as plain as it can be: 32-bit floats in scan lines, not compressed."""

    def attribute(name, kind, value):
        head = name.encode() + b"\0" + kind.encode() + b"\0"
        return head + struct.pack("<i", len(value)) + value

    names = sorted(channels)
    # Each channel: its name, type 2 (float), its subsampling.
    listed = b"".join(n.encode() + b"\0" + struct.pack("<iiii", 2, 0, 1, 1) for n in names)
    box = struct.pack("<iiii", 0, 0, columns - 1, rows - 1)
    header = struct.pack("<ii", 20000630, 2)
    header += attribute("channels", "chlist", listed + b"\0")
    header += attribute("compression", "compression", b"\0")
    header += attribute("dataWindow", "box2i", box)
    header += attribute("displayWindow", "box2i", box)
    header += attribute("lineOrder", "lineOrder", b"\0")
    header += attribute("pixelAspectRatio", "float", struct.pack("<f", 1.0))
    header += attribute("screenWindowCenter", "v2f", struct.pack("<ff", 0.0, 0.0))
    header += attribute("screenWindowWidth", "float", struct.pack("<f", 1.0))
    header += b"\0"
    planes = [numpy.asarray(channels[n], "<f4").reshape(rows, columns) for n in names]
    lines = numpy.stack(planes, 1).reshape(rows, -1)
    length = lines.shape[1] * 4
    first = len(header) + 8 * rows
    table = b"".join(struct.pack("<Q", first + k * (8 + length)) for k in range(rows))
    with open(path, "wb") as file:
        file.write(header + table)
        for k in range(rows):
            file.write(struct.pack("<ii", k, length) + lines[k].tobytes())


# --- the protocol -----------------------------------------------------------


def answer(request):
    """The reply to what decor asks."""
    if request.get("protocol") != PROTOCOL:
        return {"reply": "failed", "why": f"this speaks version {PROTOCOL} of the protocol"}
    if request["ask"] == "hello":
        return {"reply": "hello", **HELLO}
    if request["ask"] == "render":
        try:
            for shot in request["shots"]:
                draw(request, shot)
        except Unsupported as what:
            return {"reply": "unsupported", "what": str(what)}
        return {"reply": "done", "layers": len(request["shots"])}
    return {"reply": "failed", "why": f"it was asked for {request['ask']}"}


def main():
    reply = answer(json.load(sys.stdin))
    print(json.dumps({"protocol": PROTOCOL, **reply}))


if __name__ == "__main__":
    main()

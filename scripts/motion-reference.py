#!/usr/bin/env python3
"""Exact tables for the tests of the motion's measures, made with 80 digits.

    python3 scripts/motion-reference.py

writes fixtures/motion/ellipses.csv and fixtures/motion/measures.csv. The inputs
are doubles, written so that they read back exactly. The ellipse is computed
from its tangents and its foci, the thesis's rotation by rays that meet the
sphere and by points that are rotated and projected: not by the formulas of the
program. The bound is the program's formula, without its rounding terms.
"""

import csv
import math
import random
from decimal import Decimal as D
from decimal import getcontext
from pathlib import Path

getcontext().prec = 80
FOLDER = Path(__file__).resolve().parent.parent / "fixtures" / "motion"
ZERO, ONE, TWO = D(0), D(1), D(2)


# -- vectors and angles ------------------------------------------------------


def add(a, b):
    return [x + y for x, y in zip(a, b)]


def sub(a, b):
    return [x - y for x, y in zip(a, b)]


def mul(a, by):
    return [x * by for x in a]


def dot(a, b):
    return sum((x * y for x, y in zip(a, b)), ZERO)


def cross(a, b):
    return [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]


def length(a):
    return dot(a, a).sqrt()


def sin_cos(x):
    """By the series of a small part of the angle, doubled."""
    halvings = 12
    x = x / 2**halvings
    sin, term, n = x, x, 1
    while abs(term) > D(10) ** -100 and term != 0:
        term = -term * x * x / ((2 * n) * (2 * n + 1))
        sin += term
        n += 1
    versine, term, n = ZERO, D(-1), 1
    while abs(term) > D(10) ** -100 and n < 200:
        term = -term * x * x / ((2 * n - 1) * (2 * n))
        versine += term
        n += 1
    for _ in range(halvings):
        cos = 1 - versine
        versine, sin = 2 * sin * sin, 2 * sin * cos
    return sin, 1 - versine


def arc_sine(s):
    """By Newton's method from the double, in [0, 1]."""
    angle = D(math.asin(min(1.0, float(s))))
    if s == 1:
        angle = D(math.pi) / 2
        for _ in range(6):  # cos(angle) = 0
            sin, cos = sin_cos(angle)
            angle += cos / sin
        return angle
    for _ in range(8):
        sin, cos = sin_cos(angle)
        angle += (s - sin) / cos
    return angle


# -- the ellipse -------------------------------------------------------------


def ellipse(c, r):
    """Centre, unit direction of the major axis, semi-axes, in tangents."""
    rho = (c[0] * c[0] + c[1] * c[1]).sqrt()
    edge = (dot(c, c) - r * r).sqrt()
    far = (rho * edge + r * c[2]) / (c[2] * edge - r * rho)
    near = (rho * edge - r * c[2]) / (c[2] * edge + r * rho)
    major = (far - near) / 2
    foci = rho / (c[2] - r) - rho / (c[2] + r)
    minor = (major * major - foci * foci / 4).sqrt()
    direction = [c[0] / rho, c[1] / rho] if rho else [ONE, ZERO]
    return mul(direction, (far + near) / 2), direction, major, minor


def vertices(e):
    centre, (x, y), major, minor = e
    along, across = mul([x, y], major), mul([-y, x], minor)
    return [add(centre, along), sub(centre, along), add(centre, across), sub(centre, across)]


# -- the thesis's measure ----------------------------------------------------


def translation(e0, e1, f0, f1):
    e1 = list(e1)
    if dot(e0[1], e1[1]) < 0:
        e1[1] = mul(e1[1], -1)
    pairs = zip(vertices(e0), vertices(e1))
    return max(length(sub([b[i] * f1[i] for i in (0, 1)], [a[i] * f0[i] for i in (0, 1)])) for a, b in pairs)


def rotated(v, axis, sin, cos):
    along = mul(axis, dot(axis, v))
    return add(along, add(mul(sub(v, along), cos), mul(cross(axis, v), sin)))


def rotation(c, r, half, e, f):
    """The longest doublet, and how far the counts are from a change."""
    sin_half = length(half)
    if sin_half == 0 or r == 0:
        return ZERO, ONE
    axis, gamma = mul(half, 1 / sin_half), 2 * arc_sine(sin_half)
    sin_g, cos_g = sin_cos(gamma)
    centre, direction, major, _ = e
    wide = length([direction[i] * major * f[i] for i in (0, 1)])
    safe = abs(wide - round(wide))
    count = min(max(math.ceil(wide) + 1, 2), 256)
    longest = ZERO
    for i in range(count):
        image = add(centre, mul(direction, major * i / (count - 1)))
        ray = [image[0], image[1], ONE]
        d2, dc = dot(ray, ray), dot(ray, c)
        under = dc * dc - d2 * (dot(c, c) - r * r)
        t = (dc - max(under, ZERO).sqrt()) / d2
        m1 = mul(sub(mul(ray, t), c), 1 / r)
        way = gamma * length(cross(axis, m1)) * r * max(f) / (c[2] + r * m1[2])
        safe = min(safe, abs(way - round(way)))
        arcs = min(max(math.ceil(way), 1), 16)
        sin_d, cos_d = sin_cos(gamma / arcs)
        w = rotated(m1, axis, -sin_g, cos_g)
        for _ in range(arcs + 1):
            p = add(c, mul(w, r))
            q = add(c, mul(rotated(w, axis, sin_g, cos_g), r))
            longest = max(longest, length([f[k] * (q[k] / q[2] - p[k] / p[2]) for k in (0, 1)]))
            w = rotated(w, axis, sin_d, cos_d)
    return longest, safe


# -- the bound ---------------------------------------------------------------


def joint(x, c, delta, h, r, f, zoom):
    t = [f[i] * delta[i] + zoom[i] * c[i] - delta[2] * x[i] for i in (0, 1)]
    g = [cross([f[0], ZERO, -x[0]], h), cross([ZERO, f[1], -x[1]], h)]
    a, b, ab = dot(g[0], g[0]), dot(g[1], g[1]), dot(g[0], g[1])
    eigenvalue = (a + b) / 2 + (((a - b) / 2) ** 2 + ab * ab).sqrt()
    along = length(add(mul(g[0], t[0]), mul(g[1], t[1])))
    return (dot(t, t) + 4 * r * along + 4 * r * r * eigenvalue).sqrt()


def one_way(c, c1, r, delta, h, f0, f1):
    zoom = [f1[i] - f0[i] for i in (0, 1)]
    near1 = c1[2] - r
    at = lambda z: joint([f0[i] * c[i] / z for i in (0, 1)], c, delta, h, r, f1, zoom)
    j = max(at(c[2] - r), at(c[2] + r))
    g = 2 * (h[0] * h[0] + h[1] * h[1]).sqrt()
    k = c[2] ** 2 - r * r
    phi, psi, chi = r / k.sqrt() / near1, 2 * r * r / ((c[2] + k.sqrt()) * near1), r / near1
    low = min(c[2], c[2] + delta[2] - r * g)
    if low > r:
        k = low * low - r * r
        s = (1 + 8 * r * r / (low * low)).sqrt()
        peak = ((3 + s) ** 3 / (32 * (1 + s))).sqrt()
        phi = min(phi, r * low * peak / (k * k.sqrt()))
        psi, chi = min(psi, r * r / k), min(chi, r / k.sqrt())
    off = max(f0) * (abs(delta[2]) * phi + g * psi + g * g / 2 * r * phi)
    return j / near1 + off + max(abs(z) for z in zoom) * chi


def bound(c, delta, h, r, f0, f1, e0, e1):
    c1 = add(c, delta)
    forth = one_way(c, c1, r, delta, h, f0, f1)
    back = one_way(c1, c, r, mul(delta, -1), h, f1, f0)
    centres = sub([e1[0][i] * f1[i] for i in (0, 1)], [e0[0][i] * f0[i] for i in (0, 1)])
    return min(forth, back, length(centres) + max(f0) * e0[2] + max(f1) * e1[2])


# -- the tables --------------------------------------------------------------


def unit(rng):
    v = [rng.gauss(0, 1) for _ in range(3)]
    n = math.sqrt(sum(x * x for x in v))
    return [x / n for x in v]


def sphere(rng, ratio, gap=1e-3):
    """A centre and a radius, with (c_z - R)/D of `gap` at least."""
    while True:
        distance = 10 ** rng.uniform(-3, 3)
        c = [x * distance for x in unit(rng)]
        r = ratio * distance
        if (c[2] - r) / distance >= gap:
            return c, r


def digits(x):
    return f"{x:.25e}"


def ellipses(rng):
    ratios = [10.0**-k for k in range(1, 13)] + [0.2, 0.5, 0.8, 0.9, 0.99, 0.998]
    for ratio in ratios:
        for _ in range(10):
            yield sphere(rng, ratio)
        yield [0.0, 0.0, 2.0], 2.0 * ratio
    yield [0.0, 0.0, 2.0], 1.998
    # Just off the axis, and just in front of the eye's plane.
    yield [1e-12, -1e-13, 1.0], 0.5
    yield [3.0, 4.0, 0.00501], 1e-9


def main():
    FOLDER.mkdir(parents=True, exist_ok=True)
    rng = random.Random(1996)
    with open(FOLDER / "ellipses.csv", "w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow("cx cy cz radius centre_x centre_y semi_major semi_minor".split())
        for c, r in ellipses(rng):
            centre, _, major, minor = ellipse([D(x) for x in c], D(r))
            out.writerow([*map(repr, c), repr(r), *map(digits, [*centre, major, minor])])

    with open(FOLDER / "measures.csv", "w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow(
            "cx cy cz dx dy dz hx hy hz radius f0 f1 translation_px rotation_px bound_px".split()
        )
        rows = 0
        while rows < 60:
            c, r = sphere(rng, 10 ** rng.uniform(-9, -0.05), gap=0.05)
            step = math.sqrt(sum(x * x for x in c)) * 10 ** rng.uniform(-9, -1)
            delta = [x * step for x in unit(rng)]
            angle = 0.0 if rng.random() < 0.2 else 10 ** rng.uniform(-12, 0.4)
            half = [x * math.sin(angle / 2) for x in unit(rng)]
            # A moderate focal length: the table of points stays quick to make.
            f = 10 ** rng.uniform(1, 2)
            g = f if rng.random() < 0.7 else f * (1 + rng.uniform(-0.3, 0.3))
            c1 = [a + b for a, b in zip(c, delta)]
            if c1[2] <= r * 1.01:
                continue
            exact = [[D(x) for x in v] for v in (c, delta, half)]
            radius, f0, f1 = D(r), [D(f)] * 2, [D(g)] * 2
            e0, e1 = ellipse(exact[0], radius), ellipse(add(exact[0], exact[1]), radius)
            turned, safe = rotation(exact[0], radius, exact[2], e0, f0)
            if safe < D("1e-6"):
                continue  # The count of points could differ by one.
            moved = translation(e0, e1, f0, f1)
            limit = bound(*exact, radius, f0, f1, e0, e1)
            inputs = [*c, *delta, *half, r, f, g]
            out.writerow([*map(repr, inputs), *map(digits, [moved, turned, limit])])
            rows += 1


main()

"""How costs grow: with the film's length, the picture's size, the number of objects."""

import math
import random
import shutil

from decor_runs import say, side_by_side
from markdown import figure, percent, seconds, table, times

SETTINGS = {"stock": ["--baseline"], "full": ["--mode", "full"], "equivalent": ["--mode", "equivalent"]}
# A box of the cloud's ladybirds for each of so many.
SPACING = 12.0


def tables(quick):
    """What is measured: {title: (unit, [values])}."""
    return {
        "length": ("frame", [6, 12, 24] if quick else [25, 50, 100, 200, 400]),
        "size": ("pixel", [64, 96, 128] if quick else [128, 256, 512, 1024]),
        "objects": ("object", [10, 100, 1000] if quick else [10, 100, 1000, 10_000, 100_000]),
    }


def field(folder, count, frames, size, dice=13):
    """A film of so many ladybirds on a plain, seen from above; one of them walks."""
    shutil.copytree(folder.parent / "ladybirds", folder, dirs_exist_ok=True)
    side = math.ceil(math.sqrt(count))
    half = side * SPACING / 2
    dice = random.Random(dice)
    lines = [f"*size {size[0]} {size[1]}", f"*images {frames}", "*shadows 0", "*antialias off",
             "*background 0.50 0.68 0.84", f"*eye 0 {2.2 * half + 20:.2f} {-half - 15:.2f}", "*aim 0 0 0",
             "*angles 55 42.6", "*light -100 200 -150  0.95 0.90 0.82  sun 0 0 0"]
    for k in range(count):
        x, z = (k % side + 0.5) * SPACING - half, (k // side + 0.5) * SPACING - half
        walks = f" {SPACING / 20:.3f} 0 0 0 0 0" if k == count // 2 + side // 2 else ""
        lines.append(f"!ladybird.ron {x:.2f} 0 {z:.2f} 0 {dice.uniform(0, 360):.2f} 0{walks} name=l{k}")
    path = folder / f"field_{count}.anim"
    path.write_text("\n".join(lines) + "\n")
    return path


def run(title, value, decor, films, out, repeats, quick):
    say(f"growth: {title} {value}")
    shutil.rmtree(out, ignore_errors=True)
    settings = dict(SETTINGS)
    if title == "length":
        film = films.variant("plane", (64, 64) if quick else (256, 256), value, None, value / 25)
        frames = value
    elif title == "size":
        frames = 6 if quick else 25
        film = films.variant("plane", (value, value), frames, None, frames / 25)
    else:
        frames = 4 if quick else 10
        films.folder_of("ladybirds")
        film = field(films.folder / "field", value, frames, (64, 48) if quick else (320, 240))
    found = side_by_side(decor, film, settings, repeats, out)
    shutil.rmtree(out, ignore_errors=True)
    amount = {"length": frames, "size": value * value, "objects": value}[title]
    return {"amount": amount, "frames": frames, "runs": found}


def line(points):
    """Least squares of cost = start + slope · amount, each point weighed by its own
    size; and the power of the last step, 1 where growth is linear."""
    weights = [1 / max(cost, 1e-9) ** 2 for _, cost in points]
    total = sum(weights)
    mx = sum(w * x for w, (x, _) in zip(weights, points)) / total
    my = sum(w * y for w, (_, y) in zip(weights, points)) / total
    spread = sum(w * (x - mx) ** 2 for w, (x, _) in zip(weights, points))
    slope = sum(w * (x - mx) * (y - my) for w, (x, y) in zip(weights, points)) / spread if spread else 0.0
    start = my - slope * mx
    off = max(abs(start + slope * x - y) / y for x, y in points)
    (x0, y0), (x1, y1) = points[-2:]
    power = math.log(y1 / y0) / math.log(x1 / x0)
    return start, slope, off, power


def report(done):
    """Markdown of {title: {value: found}}."""
    parts = []
    for title, (unit, _) in tables(False).items():
        found = done.get(title, {})
        if not found:
            continue
        rows = []
        for value, one in found.items():
            runs = one["runs"]
            rows.append([value, *[f"{seconds(runs[n]['wall_s'])} / {seconds(runs[n]['cpu_s'])}" for n in SETTINGS],
                         times(runs["stock"]["wall_s"] / runs["equivalent"]["wall_s"]),
                         figure(1000 * runs["equivalent"]["own_cpu_s"] / one["frames"]),
                         f"{runs['equivalent']['own_peak_mib']:.0f}"])
        parts += [f"## Cost against {title}\n", "Seconds are wall / CPU.\n",
                  table([title, *SETTINGS, "faster than stock", "decor's own CPU ms a frame", "its memory, MiB"], rows)]
        if len(found) > 1:
            parts.append(slopes(found, unit))
    return "\n".join(parts)


def slopes(found, unit):
    rows = []
    for name in SETTINGS:
        points = [(one["amount"], one["runs"][name]["cpu_s"]) for one in found.values()]
        start, slope, off, power = line(points)
        rows.append([name, seconds(start), figure(1e6 * slope), percent(off), figure(power)])
    head = ["CPU", "at nothing, s", f"slope, µs per {unit}", "farthest from the line", "power of the last step"]
    return table(head, rows)

"""Plain POV-Ray animations: the frames of scripts/bench that know no film. Stock
is POV-Ray itself, called in the scene's folder, with all its threads."""

import shutil
from pathlib import Path

from decor_runs import Failed, measured, median_of, say
from markdown import seconds, table, times

EXAMPLES = Path("/usr/share/doc/povray/examples/animations")
SCENES = ("float1", "vect1", "splinefollow")
WANTED = 2


def scenes(quick):
    return SCENES[-1:] if quick else SCENES


def run(name, decor, folder, repeats, quick):
    """Stock and full in turns; their medians, and what differs."""
    say(f"plain {name}")
    source = EXAMPLES / name
    if not source.exists():
        raise Failed(f"{source} is missing: apt-get install povray-examples")
    scene = folder / "plain" / name
    shutil.rmtree(scene, ignore_errors=True)
    shutil.copytree(source, scene)
    size = ["+W80", "+H60"] if quick else ["+W320", "+H240"]
    runs = {"stock": [], "full": []}
    for _ in range(repeats):
        for how, found in runs.items():
            out = folder / "plain" / f"{name}-{how}"
            shutil.rmtree(out, ignore_errors=True)
            out.mkdir(parents=True)
            if how == "stock":
                command = ["povray", f"{name}.ini", *size, "+FN8", "-D", "-P", "-V", f"+O{out}/"]
                found.append(measured(command, folder=scene)[1])
            else:
                found.append(decor.render(scene / f"{name}.ini", out, "--mode", "full", "--", *size))
            say(f"  {how}: {found[-1]['wall_s']:.2f} s, {found[-1]['cpu_s']:.2f} s of CPU")
    found = {how: median_of(one) for how, one in runs.items()}
    ours, stock = folder / "plain" / f"{name}-full", folder / "plain" / f"{name}-stock"
    found["frames"] = len(list(stock.glob("*.png")))
    found["error"] = decor.compare(ours, stock)
    if len(list(ours.glob("*.png"))) != found["frames"]:
        raise Failed(f"{name}: frames are missing")
    return found


def report(done):
    """Markdown of {name: found}."""
    if not done:
        return ""
    rows = []
    for name, one in done.items():
        stock, full = one["stock"], one["full"]
        rows.append([name, one["frames"], seconds(stock["wall_s"]), seconds(full["wall_s"]),
                     times(stock["wall_s"] / full["wall_s"]), seconds(stock["cpu_s"]), seconds(full["cpu_s"]),
                     times(full["cpu_s"] / stock["cpu_s"]), "all" if one["error"]["max"] == 0 else "not all"])
    head = ["", "frames", "stock, wall s", "full, wall s", f"faster (≥ {WANTED})", "stock, CPU s", "full, CPU s",
            "CPU (≤ 1.05)", "frames identical"]
    return "## Plain animations\n\nPOV-Ray's own examples, unchanged, by `decor render scene.ini`.\n\n" + table(head, rows)

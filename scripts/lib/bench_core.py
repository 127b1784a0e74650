"""The cost of the core alone: runs Criterion's bench `core` and reads its figures."""

import json
import os
import subprocess
from pathlib import Path

from decor_runs import ROOT, say
from markdown import figure, table

PIXELS = 1024 * 1024


def run(quick):
    """{name: nanoseconds of CPU, and what was done in them}."""
    say("the core, by pixel (cargo bench --bench core)")
    short = ["--warm-up-time", "0.1", "--measurement-time", "0.3", "--sample-size", "10"] if quick else []
    subprocess.run(["cargo", "bench", "--quiet", "--bench", "core", "--", *short], cwd=ROOT, check=True,
                   stdout=subprocess.DEVNULL)
    return found_in(Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")))


def found_in(target):
    """What Criterion has left there."""
    found = {}
    for about in sorted(target.glob("criterion/core/*/new/benchmark.json")):
        estimates = about.parent / "estimates.json"
        about = json.loads(about.read_text())
        (unit, amount), = about["throughput"].items()
        found[about["function_id"]] = {
            "ns": json.loads(estimates.read_text())["median"]["point_estimate"], "unit": unit, "amount": amount,
        }
    return found


def report(found):
    """Markdown."""
    if not found:
        return ""
    rows, others = [], []
    for name, one in sorted(found.items()):
        if one["unit"] == "Bytes":
            others.append(f"{name}: {figure(one['amount'] / one['ns'])} GB/s read and as many written")
        elif one["amount"] < 1000:
            others.append(f"{name}: {figure(one['ns'] / one['amount'] / 1e6)} ms each")
        else:
            each = one["ns"] / one["amount"]
            rows.append([name, figure(each), figure(1000 / each), figure(each * PIXELS / 1e6)])
    head = ["", "ns of CPU a pixel", "megapixels/s a core", "ms for 1024×1024"]
    return ("## The core alone\n\nBy Criterion (`cargo bench --bench core`), in CPU time of all threads. Wanted: "
            "merge ≥ 300 megapixels/s; plan, read, merge, dissolve and encode ≤ 20 ms a frame of 1024×1024.\n\n"
            + table(head, rows) + "\nBeside them: " + "; ".join(others) + ".\n")

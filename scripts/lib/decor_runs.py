"""Runs decor and measures it: wall and CPU time, traced pixels, memory, error.

Shared by scripts/bench and scripts/thesis-tables. Only the standard library.
"""

import json
import os
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
# Memory is looked at so often while a run goes on, in seconds.
SAMPLE_S = 0.05


def say(text):
    print(text, file=sys.stderr, flush=True)


def build():
    """The release build of decor: its path."""
    say("building decor (release)")
    subprocess.run(["cargo", "build", "--release", "--quiet"], cwd=ROOT, check=True)
    target = os.environ.get("CARGO_TARGET_DIR", ROOT / "target")
    return Path(target) / "release" / "decor"


def busy_cores(seconds=1.0):
    """How many cores are kept busy, by a look of a second. The system's own load is a
    mean over a minute: after a measurement it tells of that."""
    def ticks():
        with open("/proc/stat") as file:
            fields = [int(field) for field in file.readline().split()[1:9]]
        return sum(fields), fields[3] + fields[4]  # all; idle, and waiting for a disk
    try:
        (all0, idle0), _, (all1, idle1) = ticks(), time.sleep(seconds), ticks()
    except OSError:
        return 0.0
    share = 1 - (idle1 - idle0) / max(all1 - all0, 1)
    return round(share * len(os.sched_getaffinity(0)), 2)


def machine():
    """What the figures were measured on."""
    model = "unknown"
    memory = 0
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                model = line.split(":", 1)[1].strip()
                break
        memory = int(Path("/proc/meminfo").read_text().split()[1])
    except (OSError, ValueError, IndexError):
        pass
    return {
        "cpu": model,
        "cores": len(os.sched_getaffinity(0)),
        "memory_gib": round(memory / 2**20, 1),
        "load": busy_cores(),
    }


def tree_kib(pid):
    """The resident memory of a process and all below it, in KiB."""
    total, open_ = 0, [pid]
    while open_:
        one = open_.pop()
        try:
            with open(f"/proc/{one}/statm") as file:
                total += int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") // 1024
            for task in os.listdir(f"/proc/{one}/task"):
                with open(f"/proc/{one}/task/{task}/children") as file:
                    open_ += map(int, file.read().split())
        except (OSError, ValueError, IndexError):
            continue  # It has just ended.
    return total


def own(pid, tick=os.sysconf("SC_CLK_TCK")):
    """The CPU seconds and the peak of memory (KiB) of a process without its
    children, so far; None where it has ended."""
    try:
        with open(f"/proc/{pid}/stat") as file:
            fields = file.read().rsplit(")", 1)[1].split()
        with open(f"/proc/{pid}/status") as file:
            peak = next(int(line.split()[1]) for line in file if line.startswith("VmHWM"))
        return (int(fields[11]) + int(fields[12])) / tick, peak
    except (OSError, ValueError, IndexError, StopIteration):
        return None


def measured(command, environment=None, folder=None):
    """Runs a program to its good end: its stdout, and wall and CPU time and memory
    as seen from outside. What is its own is without its children, and a tick or a
    look (50 ms) short."""
    peak, alone, over = [0], [(0.0, 0)], threading.Event()
    with tempfile.TemporaryFile() as stdout, tempfile.TemporaryFile() as stderr:
        begun = time.monotonic()
        process = subprocess.Popen(command, stdout=stdout, stderr=stderr, stdin=subprocess.DEVNULL,
                                   env=environment, cwd=folder)

        def watch():
            while not over.wait(SAMPLE_S):
                peak[0] = max(peak[0], tree_kib(process.pid))
                alone[0] = own(process.pid) or alone[0]

        watcher = threading.Thread(target=watch)
        watcher.start()
        _, status, usage = os.wait4(process.pid, 0)
        wall = time.monotonic() - begun
        over.set()
        watcher.join()
        process.returncode = os.waitstatus_to_exitcode(status)
        stderr.seek(0)
        stdout.seek(0)
        if process.returncode != 0:
            text = stderr.read().decode(errors="replace")
            raise Failed(f"{' '.join(command)}: {process.returncode}\n{text}")
        return stdout.read(), {
            "wall_s": wall,
            "cpu_s": usage.ru_utime + usage.ru_stime,
            "peak_mib": max(peak[0], usage.ru_maxrss) / 1024,
            "own_cpu_s": alone[0][0],
            "own_peak_mib": alone[0][1] / 1024,
        }


def with_mitsuba():
    """Names Mitsuba to the runs that follow, installed where it is missing."""
    script = '. scripts/setup.sh && ensure_mitsuba && printf %s "${DECOR_MITSUBA:-}"'
    found = subprocess.run(["bash", "-c", script], cwd=ROOT, capture_output=True, text=True)
    if found.returncode:
        raise Failed(f"Mitsuba cannot be installed\n{found.stderr}")
    if found.stdout:
        os.environ["DECOR_MITSUBA"] = found.stdout


class Failed(Exception):
    """A run that did not end well."""


class Decor:
    """The program, and a cache of what it learns that every run shares."""

    def __init__(self, program, folder):
        self.program, self.folder = Path(program).resolve(), Path(folder)
        self.environment = dict(os.environ, DECOR_CACHE=str(self.folder / "cache"))

    def version(self):
        text = subprocess.run([self.program, "--version"], capture_output=True, text=True, check=True)
        return text.stdout.strip()

    def json(self, *arguments, statuses=(0,)):
        """The lines of a verb's --json."""
        command = [self.program, *map(str, arguments), "--json"]
        ended = subprocess.run(command, capture_output=True, text=True, env=self.environment)
        if ended.returncode not in statuses:
            raise Failed(f"{' '.join(map(str, command))}: {ended.returncode}\n{ended.stderr}")
        return [json.loads(line) for line in ended.stdout.splitlines()]

    def render(self, film, out, *options):
        """One run: its summary, with wall, CPU and memory as seen from outside."""
        command = [str(self.program), "render", str(film), "-o", str(out), "--json", "-q", *map(str, options)]
        text, figures = measured(command, self.environment)
        summary = json.loads(text.splitlines()[-1])
        traced = summary["pixels_traced"]
        decors = [p for p in summary["periods"] if p["whole"] is None]
        return {
            **figures,
            "traced": sum(traced.values()),
            "traced_by_pass": traced,
            "pixels_full": summary["pixels_full"],
            "frames": summary["frames"],
            "decors": len(decors),
            "whole": sorted({p["whole"] for p in summary["periods"] if p["whole"]}),
            "fallback": summary["fallback"],
            "renderer": f"{summary['renderer']} {summary['renderer_version']}",
        }

    def compare(self, ours, theirs):
        """The error of a folder of frames against another."""
        lines = self.json("compare", ours, theirs, statuses=(0, 1, 2))
        pairs = [line for line in lines if line["type"] == "pair"]
        if not pairs or len(pairs) != len(lines) - 1:
            raise Failed(f"frames are missing: {ours} {theirs}")
        mse = sum(pair["rms"] ** 2 for pair in pairs) / len(pairs)
        return {
            "max": max(pair["max"] for pair in pairs),
            "rms": mse**0.5,
            "share_differing": sum(pair["share_above"] for pair in pairs) / len(pairs),
        }


def median_of(runs):
    """The medians of what varies; the rest is the first run's."""
    result = dict(runs[0])
    for key in ("wall_s", "cpu_s", "peak_mib", "own_cpu_s", "own_peak_mib"):
        values = [run[key] for run in runs]
        result[key] = statistics.median(values)
        result[f"{key}_all"] = [round(value, 4) for value in values]
    return result


def side_by_side(decor, film, settings, repeats, out):
    """The medians of every setting, {name: options}. The settings take turns, so
    that a machine that slows down slows all of them; frames are left in out/name."""
    runs = {name: [] for name in settings}
    for turn in range(repeats):
        for name, options in settings.items():
            runs[name].append(decor.render(film, Path(out) / name, *options))
            last = runs[name][-1]
            say(f"  {name} ({turn + 1}/{repeats}): {last['wall_s']:.2f} s, {last['cpu_s']:.2f} s of CPU")
    return {name: median_of(found) for name, found in runs.items()}

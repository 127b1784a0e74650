"""The races of scripts/bench: decor's modes against plain POV-Ray, film by film."""

import shutil
from dataclasses import dataclass, field

import neutral_films
from decor_runs import say, side_by_side
from films import FIXTURES
from markdown import figure, percent, seconds, table, times

SIZE = 1024
MODES = {
    "stock": ["--baseline"],
    "full": ["--mode", "full"],
    "exact": ["--mode", "exact"],
    "equivalent": ["--mode", "equivalent"],
    "preview": ["--mode", "preview"],
}
# A mode slower than this share of stock's speed in wall time is told of.
NEVER_BEHIND = 0.95
# So is `full` with more CPU time than stock's by this factor.
CPU_OVER = 1.05


@dataclass
class Race:
    """A film in one size and length, and who runs."""

    name: str
    film: str
    size: tuple = None  # None: the film's own
    frames: int = None
    shadows: bool = None
    # The thesis's speed-up and the one that is wanted, by mode.
    thesis: dict = field(default_factory=dict)
    wanted: dict = field(default_factory=dict)
    wanted_cpu: dict = field(default_factory=dict)
    settings: dict = field(default_factory=lambda: dict(MODES))
    speed: bool = False  # the observer's speed is --speed
    only: int = None  # so many frames of a film whose scenes are all stated
    renderer: str = None  # the film's neutral version, on another renderer than POV-Ray


def thresholds():
    """Stock, full and `equivalent` at the thesis's thresholds."""
    settings = {"stock": MODES["stock"], "full": MODES["full"]}
    for px in (1, 2, 4, 8):
        settings[f"equivalent {px} px"] = [*MODES["equivalent"], "--threshold", px, "--period", 25]
    return settings


def races(quick, everything):
    square = (160, 160) if quick else (SIZE, SIZE)
    many = 50 if quick else 100
    period = {"equivalent": [*MODES["equivalent"], "--threshold", 1, "--period", 25]}
    found = [
        Race("plane, 25 frames", "plane", square, 25, thesis={"equivalent": 7.3}, wanted={"equivalent": 8}),
        Race(f"plane, {many} frames", "plane", square, many, thesis={"equivalent": 9.1},
             wanted={"equivalent": 14, "exact": 10}),
        Race(f"plane, shadows, {many} frames", "plane", square, many, shadows=True,
             thesis={"equivalent": 8.9}, wanted={"equivalent": 12}),
        Race("studio", "studio", (96, 96) if quick else square, only=10 if quick else 50, wanted={"exact": 10},
             wanted_cpu={"exact": 8}),
        Race("ladybirds", "ladybirds", square, 25, thesis={"equivalent": 1.6}, wanted={"equivalent": 2.5},
             settings={**MODES, **period}, speed=True),
        Race("ladybirds 160×128", "ladybirds", (160, 128), 50 if quick else 200, settings=thresholds(), speed=True,
             thesis={"equivalent 1 px": 4.4, "equivalent 2 px": 8.1, "equivalent 4 px": 15.6, "equivalent 8 px": 20.6},
             wanted={"equivalent 1 px": 9, "equivalent 2 px": 12, "equivalent 4 px": 16, "equivalent 8 px": 21}),
        Race("shadows", "shadows", square, 25),
        Race("plane, small", "plane", (160, 120), 100, settings={"stock": MODES["stock"], "full": MODES["full"]},
             wanted={"full": 4}),
    ]
    side = (96, 96) if quick else (512, 512)
    three = {name: MODES[name] for name in ("stock", "full", "exact", "equivalent")}
    found += [Race(f"{film}, neutral, on {renderer}", film, side, 8 if quick else 25, settings=three, renderer=renderer)
              for film in neutral_films.FILMS for renderer in ("mitsuba", "povray")]
    if everything:
        names = sorted(path.parent.name for path in FIXTURES.glob("*/*.anim") if path.stem == path.parent.name)
        found += [Race(f"{name}, as it is", name) for name in names]
    return found


def film_of(films, race, speed):
    if race.renderer:
        return neutral_films.FILMS[race.film](films.folder / f"neutral_{race.film}", race.size, race.frames)
    if race.speed and speed is not None:
        return films.ladybirds(race.size, speed, race.frames)
    # A longer film of the airplane is the same flight in more frames.
    slower = race.frames / 25 if race.film == "plane" and race.frames else 1
    return films.variant(race.film, race.size, race.frames, race.shadows, slower)


def run(race, decor, films, out, repeats, speed):
    say(race.name)
    shutil.rmtree(out, ignore_errors=True)
    part = ["--frames", f"0-{race.only - 1}"] if race.only else []
    part += ["--renderer", race.renderer] if race.renderer else []
    settings = {name: [*options, *part] for name, options in race.settings.items()}
    found = side_by_side(decor, film_of(films, race, speed), settings, repeats, out)
    for name, one in found.items():
        one["wall_ratio"] = found["stock"]["wall_s"] / one["wall_s"]
        one["cpu_ratio"] = found["stock"]["cpu_s"] / one["cpu_s"]
        if name != "stock":
            one["error"] = decor.compare(out / name, out / "stock")
    shutil.rmtree(out, ignore_errors=True)
    return found


def off_by(error):
    if error is None:
        return "–"
    if error["max"] == 0:
        return "none"
    return f"{255 * error['max']:.0f}/255, {percent(error['share_differing'])} differ"


HEAD = ["", "wall s", "CPU s", "traced", "peak MiB", "decor's own: CPU ms a frame", "bytes a pixel",
        "wall to stock", "CPU to stock", "error to stock", "thesis", "wanted"]


def rows_of(race, found):
    rows = []
    for name, one in found.items():
        how = name + (" (fell back)" if one["fallback"] else "")
        pixels = one["pixels_full"] / one["frames"]
        goal = f"≥ {figure(race.wanted[name])}" if name in race.wanted else "–"
        if name in race.wanted_cpu:
            goal += f", ≥ {figure(race.wanted_cpu[name])} in CPU"
        rows.append([how, seconds(one["wall_s"]), seconds(one["cpu_s"]),
                     percent(one["traced"] / one["pixels_full"]), f"{one['peak_mib']:.0f}",
                     figure(1000 * one["own_cpu_s"] / one["frames"]), figure(one["own_peak_mib"] * 2**20 / pixels),
                     times(one["wall_ratio"]), times(one["cpu_ratio"]), off_by(one.get("error")),
                     times(race.thesis.get(name)), goal])
    return rows


def report(done):
    """Markdown of [(race, found)]."""
    parts = []
    for race, found in done:
        stock = found["stock"]
        words = f"{stock['frames']} frames, a stock frame costs {seconds(stock['cpu_s'] / stock['frames'])} s of CPU"
        parts += [f"## {race.name}\n", f"`{race.film}`, {words}.\n", table(HEAD, rows_of(race, found))]
    if done:
        told = [f"{race.name}, {name}: {times(one['wall_ratio'])} in wall time" for race, found in done
                for name, one in found.items() if one["wall_ratio"] < NEVER_BEHIND]
        told += [f"{race.name}, full: {times(1 / one['cpu_ratio'])} the CPU time" for race, found in done
                 for name, one in found.items() if name == "full" and 1 / one["cpu_ratio"] > CPU_OVER]
        parts.append(f"## Behind stock\n\nSlower than {NEVER_BEHIND} of stock in wall time, or `full` with more than "
                     f"{CPU_OVER} of its CPU time: " + ("; ".join(told) if told else "none") + ".\n")
    return "\n".join(parts)


def bars(done):
    """Groups of bars."""
    words = lambda one: f"{times(one['wall_ratio'])} wall, {times(one['cpu_ratio'])} CPU, {seconds(one['wall_s'])} s"
    return [(race.name, [(name, one["wall_ratio"], words(one)) for name, one in found.items()])
            for race, found in done]

"""Copies of the bundled films in other sizes, lengths and speeds."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

from decor_runs import ROOT

FIXTURES = ROOT / "fixtures"


def slowed(line, by):
    """An object's line with its six velocities divided."""
    fields = line.split()
    is_object = line.startswith("!") and '"' not in line
    numbers = [k for k, field in enumerate(fields) if k and "=" not in field]
    if not is_object or len(numbers) != 12:
        return line
    for k in numbers[6:]:
        fields[k] = repr(float(fields[k]) / by)
    return " ".join(fields)


class Films:
    """Variants of the bundled films, written into a folder of their own."""

    def __init__(self, folder):
        self.folder = Path(folder)
        self.count = 0

    def folder_of(self, name):
        copy = self.folder / name
        if not copy.exists():
            shutil.copytree(FIXTURES / name, copy)
        return copy

    def variant(self, name, size=None, frames=None, shadows=None, slower=1):
        """A bundled film with lines of its head replaced. The angles stay: in
        another shape of picture the same things are seen, by pixels that are
        not square, and what moves has the same share of the picture. `slower`
        divides the velocities of the objects: the same flight in more frames."""
        folder = self.folder_of(name)
        text = (folder / f"{name}.anim").read_text()
        wanted = [
            (r"\*(?:size|taille)\s+\d+\s+\d+", size and f"*size {size[0]} {size[1]}"),
            (r"\*(?:images|frames)\s+\d+", frames and f"*images {frames}"),
            (r"\*(?:shadows|ombres)\s+[01]", shadows is not None and f"*shadows {int(shadows)}"),
        ]
        for pattern, line in wanted:
            if line:
                text, count = re.subn(rf"^{pattern}", line, text, count=1, flags=re.M)
                if count != 1:
                    raise SystemExit(f"{name}: no line to replace by {line}")
        if slower != 1:
            text = "\n".join(slowed(line, slower) for line in text.splitlines()) + "\n"
        self.count += 1
        path = folder / f"variant_{self.count}.anim"
        path.write_text(text)
        return path

    def ladybirds(self, size, speed, frames, shadows=False):
        """The cloud, with another speed of the observer. Its pixels are square."""
        folder = self.folder_of("ladybirds")
        width, height = size
        text = subprocess.run(
            [sys.executable, folder / "generate.py", "--size", str(width), str(height),
             "--speed", repr(speed), "--frames", str(frames)],
            capture_output=True, text=True, check=True,
        ).stdout
        if shadows:
            text, count = re.subn(r"^\*shadows\s+0", "*shadows 1", text, count=1, flags=re.M)
            if count != 1:
                raise SystemExit("ladybirds: no line of shadows")
        path = folder / f"speed_{speed:g}_{width}x{height}_{frames}_{int(shadows)}.anim"
        path.write_text(text)
        return path

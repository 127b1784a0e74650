"""Tables and numbers in Markdown."""


def figure(value, digits=3):
    """A number with so many significant digits, and no exponent."""
    if value is None:
        return "–"
    if value == 0:
        return "0"
    text = f"{value:.{digits}g}"
    return f"{float(text):.0f}" if "e" in text else text


def seconds(value):
    return figure(value, 3)


def times(value):
    return "–" if value is None else f"{figure(value, 3)}×"


def percent(value):
    return "–" if value is None else f"{figure(100 * value, 3)} %"


def table(head, rows):
    """Lines of a table; the first column is text."""
    align = ["---"] + ["---:"] * (len(head) - 1)
    lines = [head, align, *rows]
    return "\n".join("| " + " | ".join(map(str, line)) + " |" for line in lines) + "\n"


def on(machine):
    """A machine in words, and a warning where it had other work."""
    words = f"{machine['cores']} cores of {machine['cpu']}, {machine['memory_gib']} GiB"
    busy = (f" **The machine was busy (up to {machine['load']} cores when a measurement began): "
            "wall times are not to be trusted.**")
    return words, busy if machine["load"] > 0.5 else ""


def where(machine, version, renderer, repeats):
    """What the figures were measured on, as a paragraph."""
    words, busy = on(machine)
    runs = "one run" if repeats == 1 else f"medians of {repeats} runs"
    return f"{version}, {renderer}, {words}; {runs}.{busy}\n"

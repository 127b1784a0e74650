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


def where(machine, version, renderer, repeats):
    """What the figures were measured on, as a paragraph."""
    busy = ""
    if machine["load"] > 0.5:
        busy = (f" **The machine was busy (up to {machine['load']} cores when a measurement began): "
                "wall times are not to be trusted.**")
    runs = "one run" if repeats == 1 else f"medians of {repeats} runs"
    return (f"{version}, {renderer}, {machine['cores']} cores of {machine['cpu']}, "
            f"{machine['memory_gib']} GiB; {runs}.{busy}\n")

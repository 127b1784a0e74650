"""Bars and curves as SVG, by hand: no library is needed."""

import math
from html import escape

COLOURS = ["#4c5a67", "#2f7ebc", "#2a9d6f", "#d9822b", "#b5487a", "#7a5fb5", "#8a8f2e"]
FONT = 'font-family="sans-serif" font-size="12" fill="#222"'


def text(x, y, words, anchor="start", extra=""):
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" {extra}>{escape(str(words))}</text>'


def picture(width, height, title, body):
    head = (f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" '
            f'viewBox="0 0 {width} {height}" {FONT}>')
    ground = f'<rect width="{width}" height="{height}" fill="#fff"/>'
    name = text(16, 24, title, extra='font-size="15" font-weight="bold"')
    return "\n".join([head, f"<title>{escape(title)}</title>", ground, name, *body, "</svg>"]) + "\n"


def ticks(high):
    """Round steps from 0 to at least `high`."""
    step = 10 ** math.floor(math.log10(high)) if high > 0 else 1
    for part in (0.2, 0.25, 0.5, 1, 2, 2.5, 5):
        if high / (step * part) <= 6:
            step *= part
            break
    return [step * k for k in range(math.ceil(high / step - 1e-9) + 1)]


def bars(title, groups, unit, note=""):
    """Horizontal bars: groups = [(name, [(label, value or None, words)])]."""
    left, width, row = 170, 880, 20
    values = [value for _, members in groups for _, value, _ in members if value]
    high = max(values, default=1)
    scale = (width - left - 250) / high
    # Settings of one mode ("equivalent 2 px") have its colour.
    modes = list(dict.fromkeys(label.split()[0] for _, members in groups for label, _, _ in members))
    body, y = [text(16, 44, note, extra='fill="#555"')], 66
    for name, members in groups:
        body.append(text(16, y + 13, name, extra='font-weight="bold"'))
        y += row
        for label, value, words in members:
            colour = COLOURS[modes.index(label.split()[0]) % len(COLOURS)]
            long = (value or 0) * scale
            body.append(text(left - 8, y + 13, label, "end"))
            body.append(f'<rect x="{left}" y="{y + 2}" width="{long:.1f}" height="{row - 5}" fill="{colour}"/>')
            body.append(text(left + long + 6, y + 13, words if value else "–"))
            y += row
        y += 8
    one = left + scale
    if high >= 1:
        body.append(f'<line x1="{one:.1f}" y1="56" x2="{one:.1f}" y2="{y}" stroke="#999" stroke-dasharray="3 3"/>')
        body.append(text(one, y + 14, f"1 {unit}", "middle", 'fill="#555"'))
    return picture(width, y + 28, title, body)


def curves(title, panels):
    """Line charts side by side. A panel: {"title", "x", "y", "lines"}; a line:
    (name, points [(x, y)], dashed). x is positive, its axis logarithmic."""
    wide, high, left, top = 400, 300, 52, 80
    body = []
    names = list(dict.fromkeys(name for panel in panels for name, _, _ in panel["lines"]))
    for k, panel in enumerate(panels):
        x0, y0 = 16 + left + k * (wide + 80), top + high
        points = [point for _, line, _ in panel["lines"] for point in line]
        xs = sorted({x for x, _ in points})
        ys = ticks(max([y for _, y in points] + [1]))
        low, span = math.log(xs[0]), math.log(xs[-1] / xs[0]) or 1

        def at(x, y):
            # A little room beside the axis.
            along = 0.04 + 0.92 * (math.log(x) - low) / span
            return x0 + wide * along, y0 - high * y / ys[-1]

        body.append(text(x0, top - 32, panel["title"], extra='font-weight="bold"'))
        for y in ys:
            _, py = at(xs[0], y)
            body.append(f'<line x1="{x0}" y1="{py:.1f}" x2="{x0 + wide}" y2="{py:.1f}" stroke="#ddd"/>')
            body.append(text(x0 - 6, py + 4, f"{y:g}", "end"))
        last = -math.inf
        for x in xs:
            px, _ = at(x, 0)
            if px - last < 30:
                continue  # Its number would stand in the last one.
            last = px
            body.append(f'<line x1="{px:.1f}" y1="{y0}" x2="{px:.1f}" y2="{y0 + 4}" stroke="#555"/>')
            body.append(text(px, y0 + 18, f"{x:.3g}", "middle"))
        if ys[-1] >= 1:
            _, py = at(xs[0], 1)
            body.append(f'<line x1="{x0}" y1="{py:.1f}" x2="{x0 + wide}" y2="{py:.1f}" stroke="#999" stroke-dasharray="3 3"/>')
        body.append(f'<path d="M{x0} {top}V{y0}H{x0 + wide}" fill="none" stroke="#555"/>')
        body.append(text(x0 + wide / 2, y0 + 36, panel["x"], "middle"))
        body.append(text(x0 - 40, top - 12, panel["y"], extra='fill="#555"'))
        for name, line, dashed in panel["lines"]:
            colour = COLOURS[names.index(name) % len(COLOURS)]
            dash = ' stroke-dasharray="6 4"' if dashed else ""
            way = " ".join("{:.1f},{:.1f}".format(*at(x, y)) for x, y in line)
            body.append(f'<polyline points="{way}" fill="none" stroke="{colour}" stroke-width="2"{dash}/>')
            for x, y in line:
                px, py = at(x, y)
                body.append(f'<circle cx="{px:.1f}" cy="{py:.1f}" r="2.6" fill="{colour}"/>')
    x, y = 16 + left, top + high + 60
    for k, name in enumerate(names):
        body.append(f'<rect x="{x}" y="{y - 9}" width="14" height="10" fill="{COLOURS[k % len(COLOURS)]}"/>')
        body.append(text(x + 20, y, name))
        x += 40 + 7.2 * len(name)
    return picture(16 + left + len(panels) * (wide + 80), top + high + 80, title, body)

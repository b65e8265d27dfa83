"""Line plots as plain SVG: several series on linear or logarithmic axes, nothing but the standard
library. Used by the report scripts of this folder."""
import math

WIDTH, HEIGHT, LEFT, TOP, RIGHT, BOTTOM = 760, 460, 64, 40, 190, 52
COLOURS = ("#d62728", "#1f77b4", "#2ca02c", "#9467bd", "#ff7f0e", "#8c564b", "#e377c2", "#7f7f7f",
           "#bcbd22", "#17becf", "#393b79", "#637939")


def escape(text):
    return str(text).replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")


def ticks(low, high, log):
    if log:
        first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
        between = (1, 2, 5) if high / low < 1000 else (1,)
        every = [m * 10.0 ** e for e in range(first, last + 1) for m in between]
        return [t for t in every if low * 0.999 <= t <= high * 1.001]
    span = high - low or 1.0
    step = 10.0 ** math.floor(math.log10(span / 4))
    step *= next((m for m in (1, 2, 5, 10) if span / (step * m) <= 6), 10)
    return [step * i for i in range(math.ceil(low / step), math.floor(high / step) + 1)]


class Axis:
    def __init__(self, values, log, start, end):
        low, high = min(values), max(values)
        if log:
            low, high = low / 1.15, high * 1.15
        else:
            low = min(low, 0.0)
            high += (high - low or 1.0) * 0.05
        self.low, self.high, self.log, self.start, self.end = low, high, log, start, end

    def at(self, value):
        f = (math.log10 if self.log else float)
        low, high = f(self.low), f(self.high)
        return self.start + (f(value) - low) / ((high - low) or 1.0) * (self.end - self.start)


def line_plot(path, title, x_name, y_name, series, log_x=False, log_y=False, bold=()):
    """`series`: [(name, [(x, y), ...])]; a series named in `bold` is drawn thicker. Points that a
    logarithmic axis cannot show are left out."""
    series = [(name, sorted((x, y) for x, y in points
                            if (x > 0 or not log_x) and (y > 0 or not log_y)))
              for name, points in series]
    series = [(name, points) for name, points in series if points]
    if not series:
        return
    x_axis = Axis([x for _, p in series for x, _ in p], log_x, LEFT, WIDTH - RIGHT)
    y_axis = Axis([y for _, p in series for _, y in p], log_y, HEIGHT - BOTTOM, TOP)
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" '
           f'font-family="sans-serif" font-size="12">',
           f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>',
           f'<text x="{LEFT}" y="22" font-size="14">{escape(title)}</text>']
    for t in ticks(x_axis.low, x_axis.high, log_x):
        x = x_axis.at(t)
        out.append(f'<path d="M{x:.1f} {TOP}V{HEIGHT - BOTTOM}" stroke="#ddd"/>'
                   f'<text x="{x:.1f}" y="{HEIGHT - BOTTOM + 16}" text-anchor="middle">{t:g}</text>')
    for t in ticks(y_axis.low, y_axis.high, log_y):
        y = y_axis.at(t)
        out.append(f'<path d="M{LEFT} {y:.1f}H{WIDTH - RIGHT}" stroke="#ddd"/>'
                   f'<text x="{LEFT - 6}" y="{y + 4:.1f}" text-anchor="end">{t:g}</text>')
    out.append(f'<text x="{(LEFT + WIDTH - RIGHT) / 2}" y="{HEIGHT - 14}" '
               f'text-anchor="middle">{escape(x_name)}</text>'
               f'<text transform="translate(16 {HEIGHT / 2}) rotate(-90)" '
               f'text-anchor="middle">{escape(y_name)}</text>')
    for i, (name, points) in enumerate(series):
        colour, width = COLOURS[i % len(COLOURS)], 3 if name in bold else 1.5
        way = "L".join(f"{x_axis.at(x):.1f} {y_axis.at(y):.1f}" for x, y in points)
        out.append(f'<path d="M{way}" fill="none" stroke="{colour}" stroke-width="{width}"/>')
        out += [f'<circle cx="{x_axis.at(x):.1f}" cy="{y_axis.at(y):.1f}" r="2.5" '
                f'fill="{colour}"/>' for x, y in points]
        y = TOP + 8 + 18 * i
        out.append(f'<path d="M{WIDTH - RIGHT + 12} {y}h18" stroke="{colour}" '
                   f'stroke-width="{width}"/><text x="{WIDTH - RIGHT + 36}" y="{y + 4}">'
                   f'{escape(name)}</text>')
    out.append("</svg>")
    with open(path, "w", encoding="utf-8") as file:
        file.write("\n".join(out) + "\n")

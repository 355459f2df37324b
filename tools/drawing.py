"""A small canvas that writes SVG: lines, arrows, boxes, words. Every drawing has a light panel of its own, so it can be
read on light and dark pages."""
import math

INK, GREY, PALE = "#1f2933", "#7b8794", "#e4e7eb"
BLUE, ORANGE, GREEN, RED = "#1769aa", "#d9730d", "#2e7d32", "#c62828"
BLUE_FILL, ORANGE_FILL, GREEN_FILL, RED_FILL = "#dbeafe", "#fdebd3", "#dcefdc", "#fbdcdc"
SIZE = 13  # of words [px]
WIDEST = 0.62  # of the size: width of a letter in a wide font
BORDER = 14  # [px] beside words


def number(value):
    return f"{value:.1f}".rstrip("0").rstrip(".")


def escape(text):
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")


class Drawing:
    def __init__(self, width, height, title):
        self.width, self.height, self.title, self.parts = width, height, title, []

    def add(self, part):
        self.parts.append("  " + part)

    def path(self, points, color=INK, width=1.6, fill="none", closed=False, dash=None, opacity=None):
        data = "M" + " L".join(f"{number(x)} {number(y)}" for x, y in points) + ("Z" if closed else "")
        more = (f' stroke-dasharray="{dash}"' if dash else "") + (f' fill-opacity="{opacity}"' if opacity else "")
        self.add(f'<path d="{data}" fill="{fill}" stroke="{color}" stroke-width="{number(width)}"'
                 f' stroke-linejoin="round" stroke-linecap="round"{more}/>')

    def line(self, a, b, color=INK, width=1.6, dash=None):
        self.path([a, b], color, width, dash=dash)

    def arrow(self, a, b, color=INK, width=1.6, dash=None, head=8):
        angle = math.atan2(b[1] - a[1], b[0] - a[0])
        base = (b[0] - 0.7 * head * math.cos(angle), b[1] - 0.7 * head * math.sin(angle))
        self.line(a, base, color, width, dash)
        wings = [(b[0] - head * math.cos(angle + s), b[1] - head * math.sin(angle + s)) for s in (0.42, -0.42)]
        self.path([b, *wings], color, 0.5, fill=color, closed=True)

    def polygon(self, points, color=INK, fill="none", width=1.6, dash=None, opacity=None):
        self.path(points, color, width, fill, closed=True, dash=dash, opacity=opacity)

    def box(self, x, y, width, height, color=INK, fill="none", radius=4, dash=None, stroke=1.4):
        more = f' stroke-dasharray="{dash}"' if dash else ""
        self.add(f'<rect x="{number(x)}" y="{number(y)}" width="{number(width)}" height="{number(height)}"'
                 f' rx="{radius}" fill="{fill}" stroke="{color}" stroke-width="{number(stroke)}"{more}/>')

    def circle(self, centre, radius, color=INK, fill="none", width=1.6, dash=None):
        more = f' stroke-dasharray="{dash}"' if dash else ""
        self.add(f'<circle cx="{number(centre[0])}" cy="{number(centre[1])}" r="{number(radius)}" fill="{fill}"'
                 f' stroke="{color}" stroke-width="{number(width)}"{more}/>')

    def dot(self, centre, color=INK, radius=3.2):
        self.circle(centre, radius, color, color, 0.5)

    def text(self, x, y, words, color=INK, anchor="start", size=SIZE, bold=False):
        weight = ' font-weight="bold"' if bold else ""
        for i, line in enumerate(words.split("\n")):
            reach = WIDEST * size * len(line) * {"start": 1, "middle": 0.5, "end": 0}[anchor]
            self.width = max(self.width, math.ceil(x + reach + BORDER))
            self.add(f'<text x="{number(x)}" y="{number(y + 1.3 * size * i)}" fill="{color}" text-anchor="{anchor}"'
                     f' font-size="{size}"{weight}>{escape(line)}</text>')

    def label(self, x, y, width, height, words, color=INK, fill="none", bold=False):
        """A box with words in its middle, small enough to fit."""
        lines = words.split("\n")
        size = min(SIZE, math.floor(width / (WIDEST * max(map(len, lines)))))
        self.box(x, y, width, height, color, fill)
        self.text(x + width / 2, y + height / 2 + 4.5 - 0.65 * size * (len(lines) - 1), words, anchor="middle", size=size,
                  bold=bold)

    def arc(self, centre, radius, begin, end, color=INK, width=1.4, dash=None):
        """From angle to angle [degrees], counterclockwise as seen."""
        steps = max(4, int(abs(end - begin) / 4))
        angles = [math.radians(begin + (end - begin) * i / steps) for i in range(steps + 1)]
        self.path([(centre[0] + radius * math.cos(a), centre[1] - radius * math.sin(a)) for a in angles], color, width,
                  dash=dash)

    def write(self):
        head = (f'<svg xmlns="http://www.w3.org/2000/svg" width="{self.width}" height="{self.height}"'
                f' viewBox="0 0 {self.width} {self.height}" font-family="Helvetica, Arial, sans-serif">')
        panel = f'  <rect width="{self.width}" height="{self.height}" rx="8" fill="#ffffff"/>'
        return "\n".join([head, f"  <title>{escape(self.title)}</title>", panel, *self.parts, "</svg>", ""])


def along(a, b, t):
    return (a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]))


def turned(point, centre, degrees):
    """Counterclockwise as seen."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    x, y = point[0] - centre[0], point[1] - centre[1]
    return (centre[0] + c * x + s * y, centre[1] - s * x + c * y)

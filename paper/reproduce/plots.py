"""Curves over a common axis, panel above panel, drawn by matplotlib as SVG."""
from __future__ import annotations

import io
from dataclasses import dataclass, field

from reproduce.session import Session, write_whole

WIDTH, PANEL_HEIGHT = 9.0, 3.3  # [inch]
PANEL_GAP = 0.08  # between panels, in heights of a panel
# Colors that eyes with any color vision tell apart.
COLORS = ("#1b6ab3", "#e8642c", "#2c9a57", "#8030a0", "#c0a020", "#444444", "#20a0b0", "#d04080")
MARKS_MOST = 64  # points that get marks; more are a line
PUBLISHED = "published"  # the series of the paper's numbers: marks without a line


@dataclass
class Panel:
    """A plot; series by name, each a list of points (x, y)."""

    title: str
    x_label: str
    y_label: str
    series: dict[str, list[tuple[float, float]]] = field(default_factory=dict)

    def add(self, name: str, x: float, y: float) -> None:
        """A point of the series of that name."""
        self.series.setdefault(name, []).append((x, y))


def draw(session: Session, panels: list[Panel], file: str) -> None:
    """Draws the panels that hold points to an SVG file in the directory of the results. An old plot beside new tables
    would tell another story, so it goes first; without matplotlib that is said once, and all goes on."""
    session.path(file).unlink(missing_ok=True)
    panels = [panel for panel in panels if panel.series]
    if not panels:
        return
    try:
        import matplotlib
        from matplotlib.figure import Figure
    except ImportError:
        session.lack("no plots are drawn: Python's matplotlib is not there (Debian's package is python3-matplotlib)")
        return
    # the same bytes for the same numbers: names within the file do not depend on chance, and no date is in it
    with matplotlib.rc_context({"font.family": "DejaVu Sans", "font.size": 9.0, "svg.hashsalt": file,
                                "svg.fonttype": "path"}):
        figure = Figure(figsize=(WIDTH, PANEL_HEIGHT * len(panels)), layout="constrained")
        figure.get_layout_engine().set(hspace=PANEL_GAP)
        for index, panel in enumerate(panels):
            _draw_panel(figure.add_subplot(len(panels), 1, index + 1), panel)
        picture = io.BytesIO()
        figure.savefig(picture, format="svg", metadata=dict.fromkeys(("Creator", "Date", "Format", "Type")))
    write_whole(session.path(file), picture.getvalue())


def _draw_panel(axes, panel: Panel) -> None:
    color = 0  # the same for the same series, whether published marks are there or not
    for name, points in panel.series.items():
        x, y = zip(*points)
        if name == PUBLISHED:
            axes.plot(x, y, "o", markersize=7.0, markerfacecolor="none", markeredgecolor="#000000",
                      markeredgewidth=1.6, label=name)
            continue
        axes.plot(x, y, marker="o" if len(points) <= MARKS_MOST else "", markersize=3.0, linewidth=1.4,
                  color=COLORS[color % len(COLORS)], label=name)
        color += 1
    axes.set(title=panel.title, xlabel=panel.x_label, ylabel=panel.y_label)
    axes.set_ylim(bottom=0.0)
    axes.grid(color="#dddddd", linewidth=0.6)
    axes.set_axisbelow(True)
    for spine in axes.spines.values():
        spine.set_color("#888888")
    axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), frameon=False)

"""Plots of what steps did, drawn by matplotlib, as `tulle info --plot` draws them."""
from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, Optional, Union

import numpy as np
from numpy.typing import NDArray

from tulle import structs
from tulle._library import ffi
from tulle.errors import InvalidArgumentError
from tulle.run import Run
from tulle.world import STAGES

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Reports = Union[Run, NDArray[Any], Iterable[structs.StepReport]]


def plot_report(run_or_reports: Reports, *, title: Optional[str] = None, width: float = 9.0) -> Figure:
    """Plots what each step did over simulated time: how long its stages took, contacts, the smallest gap, energies, solves and
    the largest stretch. Needs matplotlib.

    run_or_reports: a Run, its `reports`, or reports that `World.step` gave. title: of the figure. width: [inches]. Gives
    the figure, which a notebook shows where it is the last value of a cell; `savefig` writes it.
    """
    reports = _collect(run_or_reports)
    if not reports.size:
        raise InvalidArgumentError("there are no reports of steps to plot")
    if title is None:
        title = run_or_reports.path if isinstance(run_or_reports, Run) else ""
    import matplotlib
    import matplotlib.pyplot as plt
    figure = plt.figure(figsize=(width, 1.45 * width), layout="constrained")
    panels = figure.subplots(6, 1, sharex=True, gridspec_kw={"height_ratios": [2, 1, 1, 1, 1, 1]})
    figure.suptitle(title.replace("$", r"\$"))
    for draw, axes in zip((_draw_times, _draw_contacts, _draw_gaps, _draw_energies, _draw_solves, _draw_stretch), panels):
        draw(axes, reports, reports["time"])
        axes.grid(color="#dddddd", linewidth=0.6)
        axes.set_axisbelow(True)
    panels[-1].set_xlabel("simulated time [s]")
    figure.align_ylabels(panels)
    if "inline" in matplotlib.get_backend():  # it would show the figure once more, at the end of the cell
        plt.close(figure)
    return figure


def _collect(run_or_reports: Reports) -> NDArray[Any]:
    if isinstance(run_or_reports, Run):
        return run_or_reports.reports
    if isinstance(run_or_reports, np.ndarray):
        if not {"time", "stage_seconds", "smallest_gap"} <= set(run_or_reports.dtype.names or ()):
            raise InvalidArgumentError("an array of reports should hold STEP_REPORT records")
        return np.atleast_1d(run_or_reports)
    reports = [bytes(ffi.buffer(ffi.addressof(each._c) if ffi.typeof(each._c).kind != "pointer" else each._c))
               for each in run_or_reports]
    return np.frombuffer(b"".join(reports), np.dtype(structs.STEP_REPORT))


def _add_legend(axes: Any, handles: Any = None) -> None:
    """Beside the panel, where the axis of another scale leaves room."""
    axes.legend(handles=handles or axes.get_legend_handles_labels()[0], loc="upper left", bbox_to_anchor=(1.13, 1.03),
                fontsize="small", frameon=False, borderaxespad=0)


def _draw_times(axes: Any, reports: NDArray[Any], time: NDArray[Any]) -> None:
    stages = reports["stage_seconds"]
    rest = np.maximum(reports["total_seconds"] - stages.sum(axis=1), 0)
    colors = [f"C{i}" for i in range(stages.shape[1])] + ["#d0d0d0"]
    axes.stackplot(time, *(1e3 * stages.T), 1e3 * rest, labels=[*STAGES, "other"], colors=colors, linewidth=0)
    mark = 1.04e3 * reports["total_seconds"].max()
    marks = (("impact zones", "rescue_impact_zones", "^", "#d08000"),
             ("pieces scaled", "rescue_component_scalings", "o", "#8030a0"),
             ("time shortened", "rescue_global_scalings", "s", "#d02020"), ("pinched", "pinched", "x", "#000000"))
    for name, column, marker, color in marks:
        steps = reports[column] > 0
        if steps.any():
            label = f"{name}: {steps.sum()} steps"
            axes.plot(time[steps], np.full(steps.sum(), mark), marker, color=color, markersize=4, label=label)
    axes.set_ylabel("step time [ms]")
    axes.set_ylim(bottom=0)
    _add_legend(axes)


def _draw_contacts(axes: Any, reports: NDArray[Any], time: NDArray[Any]) -> None:
    axes.plot(time, reports["contacts"], color="#222222", linewidth=1.6, label="all")
    for name, color in (("stick", "#1b6ab3"), ("slip", "#e8642c"), ("new", "#c9a200"), ("hard", "#5b2a62")):
        axes.plot(time, reports[f"{name}_contacts"], color=color, linewidth=1.2, label=name)
    axes.set_ylabel("contacts")
    axes.set_ylim(bottom=0)
    _add_legend(axes)


def _draw_gaps(axes: Any, reports: NDArray[Any], time: NDArray[Any]) -> None:
    gaps = np.where(np.isfinite(reports["smallest_gap"]) & (reports["smallest_gap"] > 0), 1e3 * reports["smallest_gap"], np.nan)
    axes.set_ylabel("smallest gap [mm]")
    axes.set_yscale("log")
    if np.isfinite(gaps).any():
        least = float(np.nanmin(gaps))
        axes.plot(time, gaps, color="#1b6ab3", linewidth=1.3, label="smallest gap")
        axes.set_ylim(*_find_decades(gaps))
        axes.axhline(least, color="#c03020", linestyle="--", linewidth=1, label=f"least: {least:.3g} mm")
    else:
        axes.plot([], [], " ", label="nothing came near")
    _add_legend(axes)


def _find_decades(values: NDArray[Any]) -> tuple[float, float]:
    """The powers of ten around positive numbers."""
    return 10.0 ** np.floor(np.log10(np.nanmin(values))), 10.0 ** (np.floor(np.log10(2 * np.nanmax(values))) + 1)


def _draw_energies(axes: Any, reports: NDArray[Any], time: NDArray[Any]) -> None:
    parts = {name: reports[f"{name}_energy"] for name in ("gravity", "elastic", "kinetic")}
    axes.plot(time, sum(parts.values()), color="#222222", linewidth=1.8, label="total")
    for (name, energy), color in zip(parts.items(), ("#1b6ab3", "#e8642c", "#2c9a57")):
        axes.plot(time, energy, color=color, linewidth=1.3, label=name)
    axes.set_ylabel("energy [J]")
    _add_legend(axes)


def _draw_solves(axes: Any, reports: NDArray[Any], time: NDArray[Any]) -> None:
    lines = axes.plot(time, reports["cg_iterations"], color="#1b6ab3", linewidth=1.3, label="iterations")
    axes.set_ylabel("CG iterations")
    axes.set_ylim(bottom=0)
    right = axes.twinx()
    residuals = np.where(reports["cg_residual"] > 0, reports["cg_residual"], np.nan)
    lines += right.plot(time, residuals, color="#b97a10", linewidth=1, label="residual (right)")
    if np.isfinite(residuals).any():
        right.set_yscale("log")
        right.set_ylim(*_find_decades(residuals))
    right.set_ylabel("relative residual")
    _add_legend(axes, lines)


def _draw_stretch(axes: Any, reports: NDArray[Any], time: NDArray[Any]) -> None:
    axes.plot(time, 100 * (reports["max_stretch"] - 1), color="#b5308a", linewidth=1.3, label="longest")
    axes.set_ylabel("max stretch [%]")
    axes.set_ylim(bottom=0)
    _add_legend(axes)

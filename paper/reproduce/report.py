"""report.html: one page, well-formed as XML, without links out of it, of all that the directory of the results holds.
Tables show the text of the CSV files as it is; plots and stills are data URIs."""
from __future__ import annotations

import base64
import html
import os
import platform
import xml.etree.ElementTree as tree

from reproduce.children import call
from reproduce.conditions import get_processor
from reproduce.figures import FIGURES, Figure, list_runs
from reproduce.judge import Verdict, read_verdict
from reproduce.runs import has_scene, open_moving_run, open_run
from reproduce.scenes import SCENES, Run
from reproduce.session import Session, write_whole
from reproduce.stills import choose_stills, is_whole_picture, name_still

GIB = 1 << 30  # [bytes]

STYLE = (
    "body{font:15px/1.5 'DejaVu Sans',Helvetica,sans-serif;color:#222;background:#fff;max-width:980px;margin:2em auto;"
    "padding:0 1em}"
    "h1{font-size:1.7em}h2{font-size:1.3em;margin-top:2.4em;border-top:1px solid #ccc;padding-top:1em}"
    "h3{font-size:1em;margin:1.4em 0 .3em}"
    "table{border-collapse:collapse;font-size:12px;display:block;overflow-x:auto}"
    "th,td{border:1px solid #ddd;padding:2px 7px;text-align:right;white-space:nowrap}"
    "th{background:#f2f2f2;white-space:normal}td:first-child,th:first-child{text-align:left}"
    "tr:nth-child(even) td{background:#fafafa}img.plot{max-width:100%;height:auto}"
    ".stills{display:flex;flex-wrap:wrap;gap:6px}.stills figure{margin:0;width:32%}"
    ".stills img{width:100%;height:auto}figcaption{font-size:12px;color:#555}"
    ".bad{color:#b00020;font-weight:bold}dt{font-weight:bold}dd{margin:0 0 .6em 1.2em}"
)


def escape(text: str) -> str:
    """Text as HTML has it; what is no printable ASCII becomes '?'."""
    return html.escape("".join(c if " " <= c <= "~" else "?" for c in text))


def _make_uri(kind: str, data: bytes) -> str:
    return f"data:image/{kind};base64,{base64.b64encode(data).decode()}"


# ---- tables, plots and stills ----

def _format_row(line: str, is_head: bool) -> str:
    """Cells of one line; columns' names with blanks, so that they can be broken."""
    tag = "th" if is_head else "td"
    cells = (line.replace("_", " ") if is_head else line).split(",")
    return "<tr>" + "".join(f"<{tag}>{escape(cell)}</{tag}>" for cell in cells) + "</tr>\n"


def format_table(session: Session, file: str, caption: str) -> str:
    """A table, or nothing where its file is not there."""
    try:
        lines = session.path(file).read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return ""
    rows = "".join(_format_row(line, index == 0) for index, line in enumerate(lines))
    return f"<h3>{escape(caption)} ({file})</h3>\n<table id=\"{file.partition('.')[0]}\">\n{rows}</table>\n"


def _leave_out(session: Session, file: str) -> None:
    session.lack(f"{file} is not whole and left out of the report; without it, it is made again")


def format_plot(session: Session, file: str, caption: str) -> str:
    """A plot, or nothing where its file is not there or not whole."""
    try:
        data = session.path(file).read_bytes()
    except OSError:
        return ""
    try:
        tree.fromstring(data)
    except tree.ParseError:
        _leave_out(session, file)
        return ""
    return (f"<h3>{escape(caption)} ({file})</h3>\n<p><img class=\"plot\" alt=\"{escape(caption)}\" "
            f"src=\"{_make_uri('svg+xml', data)}\"/></p>\n")


def _format_still(session: Session, run: Run, frame: int) -> str:
    file = name_still(run, frame)
    try:
        data = session.path(file).read_bytes()
    except OSError:
        return ""
    if not is_whole_picture(data):
        _leave_out(session, file)
        return ""
    caption = f"{run.name}, frame {frame}"
    return (f"<figure><img alt=\"{caption}\" src=\"{_make_uri('png', data)}\"/><figcaption>{caption}</figcaption>"
            "</figure>\n")


def _format_stills(session: Session, figure: Figure) -> str:
    text = ""
    for run in figure.runs:
        recorded = open_run(session, run)
        stills = "".join(_format_still(session, run, frame)
                         for frame in (choose_stills(recorded, run) if recorded else []))
        text += f"<div class=\"stills\">\n{stills}</div>\n" if recorded else ""
    return text


# ---- the page ----

def _format_settings(session: Session) -> str:
    _, version, _ = call(session.interrupts, [str(session.program), "--version"])
    system = platform.uname()
    memory = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") / GIB
    rows = (("Tulle", f"{version.strip().removeprefix('tulle ')}, build {session.build}"),
            ("sizes", "--quick: coarse cloth and short runs" if session.is_quick else "those of the scene files"),
            ("threads", str(session.used_threads)),
            ("processor", f"{get_processor()}; {os.cpu_count()} of them, {memory:.1f} GiB of memory"),
            ("system", f"{system.system} {system.release}"),
            ("the paper's", "one 1.5 GHz Pentium 4, 1 GB, double precision"))
    return ("<h2>Settings and machine</h2>\n<table>\n"
            + "".join(f"<tr><th>{escape(name)}</th><td>{escape(text)}</td></tr>\n" for name, text in rows)
            + "</table>\n")


def _format_notes(session: Session) -> str:
    """What whoever made the results has to say of them: each line of notes.txt."""
    try:
        lines = session.path("notes.txt").read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return ""
    return "".join(f"<p>{escape(line)}</p>\n" for line in lines)


def _format_sums(verdicts: list[Verdict], rules: str) -> str:
    if not verdicts:
        return ""
    bad = sum(verdict.bad_frames for verdict in verdicts)
    style = " class=\"bad\"" if bad > 0 else ""
    return (f"<p>{len(verdicts)} runs by {rules}, {sum(verdict.frames for verdict in verdicts)} frames, each judged "
            f"with exact arithmetic: <span{style}>{bad} with intersections</span>.</p>\n")


def _format_verdicts(session: Session) -> str:
    """What the judge found over all runs, and what is missing."""
    found = [(run, read_verdict(session, run)) for run in list_runs()]
    proven = [verdict for run, verdict in found if verdict and run.is_proven]
    paper = [verdict for run, verdict in found if verdict and not run.is_proven]
    missing = [scene for scene in SCENES if not has_scene(session, Run(scene))]
    return (_format_sums(proven, "rules that miss nothing")
            + _format_sums(paper, "the paper's rules, which skip patches without proof")
            + "".join(f"<p class=\"bad\">The scene {scene}.yaml was missing.</p>\n" for scene in missing))


def _is_made(session: Session, figure: Figure) -> bool:
    """Whether anything of the figure was made."""
    if figure.items:
        return session.path(figure.items[0][0]).exists()
    return any(open_moving_run(session, run) for run in figure.runs)


def _format_figure(session: Session, figure: Figure) -> str:
    if not _is_made(session, figure):
        return ""
    items = "".join((format_plot if file.endswith(".svg") else format_table)(session, file, caption)
                    for file, caption in figure.items)
    return (f"<section id=\"section_{figure.name}\">\n<h2>{figure.title}</h2>\n<dl>\n<dt>The paper</dt>"
            f"<dd>{figure.paper}</dd>\n<dt>Here</dt><dd>{figure.ours}</dd>\n<dt>What differs, and why</dt>"
            f"<dd>{figure.differences}</dd>\n</dl>\n{items}"
            f"{_format_stills(session, figure) if figure.has_stills else ''}</section>\n")


def write_report(session: Session) -> None:
    """Writes report.html of all that the directory of the results holds."""
    write_whole(session.path("report.html"), (
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head><meta charset=\"utf-8\"/><title>The paper again</title>\n"
        f"<style>{STYLE}</style></head>\n<body>\n"
        "<h1>Dynamic Interaction between Deformable Surfaces and Nonsmooth Objects, again</h1>\n"
        "<p>The experiments of Wong and Baciu, IEEE Transactions on Visualization and Computer Graphics 11(3), 2005, "
        "made again with Tulle.</p>\n"
        + _format_verdicts(session) + _format_notes(session) + _format_settings(session)
        + format_table(session, "conditions.csv", "Conditions that things were measured under")
        + format_table(session, "runs.csv", "Runs")
        + "".join(_format_figure(session, figure) for figure in FIGURES)
        + "</body>\n</html>\n"))

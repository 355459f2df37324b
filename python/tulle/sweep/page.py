"""The page of a sweep: a table with a small picture of each run, in one file that asks nothing of a network.

The table can be read without a script. The script, which stands in the page, sorts the rows. On a narrow screen each
row becomes a card, and a list of the columns sorts in place of the headings."""
from __future__ import annotations

import base64
import re
from html import escape
from typing import Any
from urllib.parse import quote

from .layout import SweepDirectory

EMBEDDED_BYTES_MAX = 16 << 20  # of all pictures; larger sweeps link to their files

FIGURES = (("largest_stretch", "stretch", "largest length over rest length"),
           ("unconverged_steps", "unconverged", "steps with a solve that stopped at its limit"),
           ("rescues", "rescues", "rescues of impacts"), ("pinched_steps", "pinched", "steps in which cloth was pinched"),
           ("wall_seconds", "seconds", "time by the wall clock"))

STYLE = """
:root{color-scheme:light dark;--line:#8885;--soft:#8882}
body{font:16px/1.45 system-ui,sans-serif;margin:0 auto;max-width:100rem;padding:1rem}
h1{font-size:1.4rem;margin:0 0 .25rem}p{margin:.25rem 0 .75rem}
.sorter{display:flex;gap:.5rem;align-items:center;flex-wrap:wrap;margin:.75rem 0}
select,button{font:inherit;color:inherit}
.scroll{overflow-x:auto}
table{border-collapse:collapse;width:100%;font-variant-numeric:tabular-nums}
th,td{padding:.35rem .6rem;text-align:left;border-bottom:1px solid var(--line);vertical-align:middle}
td.n,td.code{white-space:nowrap}td.p{min-width:6rem;max-width:20rem;overflow-wrap:anywhere}
.why{display:block;min-width:14rem;overflow-wrap:anywhere;font-size:.85em}
th{vertical-align:bottom}
th button{background:none;border:0;padding:0;font-weight:600;cursor:pointer;text-align:left;white-space:nowrap}
th[aria-sort=ascending] button::after{content:" \\2191"}th[aria-sort=descending] button::after{content:" \\2193"}
td.n,th.n,th.n button{text-align:right}td.code{font-family:ui-monospace,monospace;font-size:.85em}
:focus-visible{outline:3px solid #0a84ff;outline-offset:2px}
img{display:block;width:160px;height:90px;object-fit:cover;background:var(--soft);border-radius:4px}
.none{display:grid;place-items:center;width:160px;height:90px;background:var(--soft);border-radius:4px;font-size:.85em}
.bad{font-weight:600;color:#b3261e}.good{color:#146c2e}
@media(prefers-color-scheme:dark){.bad{color:#ff8a80}.good{color:#7bd88f}}
@media(max-width:900px){
thead{display:none}table,tbody,tr,td{display:block}
tr{border:1px solid var(--line);border-radius:8px;margin:0 0 1rem;padding:.5rem}
td,td.n{border:0;padding:.15rem .25rem;text-align:left;display:flex;gap:.75rem;justify-content:space-between}
td::before{content:attr(data-name);font:1rem system-ui,sans-serif;opacity:.75;flex:none}
td.picture::before{content:none}td.picture a,td.picture .none{width:100%}td.picture img{width:100%;height:auto;aspect-ratio:16/9}
td>*{min-width:0;text-align:right}td[data-value=""]{display:none}
td.n,td.code{white-space:normal}td.p{max-width:none}.why{min-width:0}}
@media(min-width:901px){.sorter{display:none}}
"""

SCRIPT = """
"use strict";
const body=document.querySelector("tbody"),heads=[...document.querySelectorAll("thead th")];
const choice=document.getElementById("sort-by"),turn=document.getElementById("sort-turn"),said=document.getElementById("said");
function compare(a,b){
  if(a===b)return 0;if(a==="")return 1;if(b==="")return -1;
  const x=Number(a),y=Number(b);
  if(!Number.isNaN(x)&&!Number.isNaN(y))return (x-y)*way;
  return a.localeCompare(b,undefined,{numeric:true})*way;
}
let way=1,column=1;
function sort(){
  const rows=[...body.rows].map((row,i)=>[row.cells[column].dataset.value||"",i,row]);
  rows.sort((a,b)=>compare(a[0],b[0])||a[1]-b[1]);
  body.append(...rows.map(r=>r[2]));
  heads.forEach((head,i)=>i===column?head.setAttribute("aria-sort",way>0?"ascending":"descending"):head.removeAttribute("aria-sort"));
  choice.value=String(column);turn.textContent=way>0?"ascending":"descending";
  said.textContent="sorted by "+heads[column].textContent+", "+turn.textContent;
}
heads.forEach((head,i)=>{const button=head.querySelector("button");
  if(button)button.addEventListener("click",()=>{way=i===column?-way:1;column=i;sort();});});
choice.addEventListener("change",()=>{column=Number(choice.value);way=1;sort();});
turn.addEventListener("click",()=>{way=-way;sort();});
document.querySelector(".sorter").hidden=false;
"""


def make_page(directory: SweepDirectory, sweep: dict[str, Any], rows: list[dict[str, Any]]) -> str:
    """The text of index.html."""
    parameters = [one["name"] for one in sweep["parameters"]]
    heads = [("", ""), ("run", ""), *((name, "") for name in parameters), ("state", ""), ("verdict", "")]
    heads += [(title, meaning) for _, title, meaning in FIGURES] + [("state hash", "of the last frame")]
    sizes = sum(path.stat().st_size for path in (directory.path / "pictures").glob("[0-9]*.png"))
    is_embedding = sizes <= EMBEDDED_BYTES_MAX
    is_number = {name: has_numbers([str(row[name]) for row in rows]) for name in parameters}
    numeric = [False, True, *(is_number[name] for name in parameters), False, False, *(True for _ in FIGURES), False]
    head_cells = "".join(
        f'<th scope="col"{" class=n" if is_right else ""}>' +
        (f'<button type="button" title="{escape(meaning)}">{escape(name)}</button>' if name else "picture") + "</th>"
        for (name, meaning), is_right in zip(heads, numeric))
    options = "".join(f'<option value="{i}"{" selected" if i == 1 else ""}>{escape(name)}</option>'
                      for i, (name, _) in enumerate(heads) if name)
    body = "\n".join(make_row(directory, row, parameters, is_number, is_embedding) for row in rows)
    states: dict[str, int] = {}
    for row in rows:
        states[row["state"]] = states.get(row["state"], 0) + 1
    summary = ", ".join(f"{count} {state}" for state, count in states.items())
    title = escape(sweep["title"])
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title><link rel="icon" href="data:,"><style>{STYLE}</style></head>
<body><h1>{title}</h1>
<p>{len(rows)} runs: {summary}. <a href="table.csv">table.csv</a> has all figures.</p>
<div class="sorter" hidden><label for="sort-by">Sort by</label> <select id="sort-by">{options}</select>
<button type="button" id="sort-turn">ascending</button></div><div id="said" role="status" style="position:absolute;left:-99em"></div>
<div class="scroll" tabindex="0" role="region" aria-label="runs"><table><thead><tr>{head_cells}</tr></thead><tbody>
{body}
</tbody></table></div>
<script>{SCRIPT}</script></body></html>
"""


def make_row(directory: SweepDirectory, row: dict[str, Any], parameters: list[str], is_number: dict[str, bool],
             is_embedding: bool) -> str:
    """A row of the page's table."""
    number = row["run"]
    cells = [make_picture_cell(directory, row, is_embedding), make_cell("run", f"{number:04d}", number, "n")]
    cells += [make_cell(name, row[name], get_number(str(row[name])), "n") if is_number[name] else
              make_cell(name, row[name], None, "p") for name in parameters]
    state = escape(row["state"])
    if row["state"] != "whole":
        state = f'<span class="bad">{state}</span>' if row["state"] in ("failed", "lost") else state
        if row["reason"]:
            state += f'<span class="why">{escape(shorten(row["reason"]))}</span>'
    cells.append(f'<td data-name="state" data-value="{escape(row["state"])}"><div>{state}</div></td>')
    verdict = row["verdict"]
    kind = "good" if verdict == "clean" else "bad"
    cells.append(f'<td data-name="verdict" data-value="{escape(verdict or "")}">' +
                 (f'<span class="{kind}">{escape(verdict)}</span>' if verdict else "") + "</td>")
    for name, title, _ in FIGURES:
        cells.append(make_cell(title, format_figure(row[name]), row[name], "n"))
    cells.append(make_cell("state hash", row["state_hash"] or "", None, "code"))
    return "<tr>" + "".join(cells) + "</tr>"


def make_picture_cell(directory: SweepDirectory, row: dict[str, Any], is_embedding: bool) -> str:
    """The picture, which leads to the file."""
    path = directory.get_picture(row["run"])
    link = quote(f"pictures/{path.name}")
    try:
        data = path.read_bytes() if is_embedding else b""
        path.stat()
    except OSError:
        return '<td class="picture"><span class="none">no picture</span></td>'
    source = "data:image/png;base64," + base64.b64encode(data).decode() if data else link
    return (f'<td class="picture"><a href="{link}"><img loading="lazy" width="160" height="90" src="{source}" '
            f'alt="last frame of run {row["run"]:04d}"></a></td>')


def make_cell(name: str, text: Any, value: Any, kind: str) -> str:
    shown = escape("" if text is None else str(text))
    key = shown if value is None else escape(str(value))
    return f'<td{f" class={kind}" if kind else ""} data-name="{escape(name)}" data-value="{key}"><span>{shown}</span></td>'


NUMBER = re.compile(r"([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([a-zA-Z%][a-zA-Z0-9%^/* ]*)?")


def has_numbers(texts: list[str]) -> bool:
    """Whether all values are numbers of the same unit, so that they can be sorted as numbers."""
    found = [NUMBER.fullmatch(text) for text in texts]
    return all(found) and len({match.group(2) for match in found if match}) == 1


def get_number(text: str) -> float:
    match = NUMBER.match(text)
    return float(match.group(1)) if match else 0.0


def format_figure(value: Any) -> str:
    return "" if value is None else f"{value:.4g}" if isinstance(value, float) else str(value)


def shorten(text: str) -> str:
    return text if len(text) <= 140 else text[:139] + "…"

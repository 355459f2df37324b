"""The tables of bench-peers in Markdown, and what they say of the goals."""
from markdown_tables import fill, make_table, read_rows

COLUMNS = ["scene", "tool", "variant", "version", "settings", "motion", "cpu", "cpu_per_frame", "tulle_cpu", "self_pairs",
           "obstacle_pairs", "bad_frames", "frames", "stretch_99", "stretch_most", "lowest", "memory_mb", "message"]  # fmt: skip
HEAD = ["scene", "tool", "CPU per 1/24 s [s]", "against Tulle", "of motion [s]", "pairs: itself", "obstacles", "frames with pairs",
        "stretch 99 %", "largest", "MB"]  # fmt: skip
THROUGH = -0.01  # m: lower than this the cloth is under the ground, where no triangles of the surfaces need intersect


def get_ratio(row):
    """Processor time over Tulle's for the same motion; None where there is none."""
    return float(row["cpu"]) / float(row["tulle_cpu"]) if row["tulle_cpu"] and float(row["tulle_cpu"]) > 0 else None


def format_ratio(row):
    ratio = get_ratio(row)
    return "" if ratio is None else f"{ratio:.2g} x" if ratio < 100 else f"{ratio:.0f} x"


def format_stretch(text):
    return f"{100 * float(text):.1f} %" if float(text) < 10 else "over 1000 %"


def format_row(row):
    cells = [row["scene"], f"{row['tool']}, {row['variant']}"]
    if not row["stretch_99"]:
        return cells + [row["message"] or "nothing came of it"] + [""] * (len(HEAD) - 3)
    below = " (under the ground)" if float(row["lowest"]) < THROUGH else ""
    return cells + [
        f"{float(row['cpu_per_frame']):.3g}", format_ratio(row), f"{float(row['motion']):.2f}", row["self_pairs"],
        row["obstacle_pairs"] + below, f"{row['bad_frames']} of {row['frames']}", format_stretch(row["stretch_99"]),
        format_stretch(row["stretch_most"]), row["memory_mb"],
    ]  # fmt: skip


def make_settings(rows):
    seen = {}
    for row in rows:
        seen.setdefault((row["tool"], row["variant"]), row)
    shown = [[row["tool"], row["variant"], row["version"], row["settings"]] for row in seen.values()]
    return make_table(["tool", "variant", "version", "settings"], shown)


def make_messages(rows):
    said = [f"- {row['scene']}, {row['tool']}, {row['variant']}: {row['message']}" for row in rows if row["message"]]
    return "\n".join(said) or "No tool had anything to say."


def find(rows, scene, tool, variant):
    return next((row for row in rows if (row["scene"], row["tool"], row["variant"]) == (scene, tool, variant)), None)


def judge_ratio(rows, scene, tool, variant, goal):
    row = find(rows, scene, tool, variant)
    ratio = get_ratio(row) if row else None
    name = f"{scene}: {tool}, {variant}, takes {goal} times Tulle's processor time"
    if ratio is None:
        return [name, "not measured", "-"]
    return [name, f"{ratio:.2g} times over {float(row['motion']):.2f} s of motion", "holds" if ratio >= goal else "**does not hold**"]


def judge_long_steps(rows, scene, goal):
    """Of a run with one step a frame, beside Blender's."""
    blender, own = find(rows, scene, "Blender", "default quality"), find(rows, scene, "Tulle", "one step a frame")
    name = f"{scene}: Blender, default quality, takes {goal} times Tulle's processor time with one step a frame"
    if not (blender and own and blender["cpu_per_frame"] and own["cpu_per_frame"]):
        return [name, "not measured", "-"]
    ratio = float(blender["cpu_per_frame"]) / float(own["cpu_per_frame"])
    return [name, f"{ratio:.2g} times", "holds" if ratio >= goal else "**does not hold**"]


def judge_goals(rows):
    """Goal, what was measured, whether it holds."""
    lines = []
    for scene in dict.fromkeys(row["scene"] for row in rows):
        lines.append(judge_ratio(rows, scene, "Blender", "default quality", 2))
        lines.append(judge_long_steps(rows, scene, 8))
        lines.append(judge_ratio(rows, scene, "MuJoCo", "ipc", 50))
        own = [row for row in rows if row["scene"] == scene and row["tool"] == "Tulle"]
        pairs = max(int(row["self_pairs"]) + int(row["obstacle_pairs"]) for row in own)
        stretch = max(float(row["stretch_99"]) for row in own)
        lines.append([f"{scene}: no intersecting pairs in Tulle", f"{pairs}", "holds" if pairs == 0 else "**does not hold**"])
        holds = "holds" if stretch < 0.05 else "**does not hold**"
        lines.append([f"{scene}: stretch of Tulle's cotton under 5 % at the 99th percentile", f"{100 * stretch:.1f} %", holds])
    return make_table(["goal", "measured", ""], lines)


def make_texts(rows):
    return {
        "peers": make_table(HEAD, [format_row(row) for row in rows]),
        "peers goals": judge_goals(rows),
        "peers settings": make_settings(rows),
        "peers messages": make_messages(rows),
    }


def show(path, page):
    texts = make_texts(read_rows(path))
    if page:
        fill(page, texts)
    else:
        print("\n\n".join(texts.values()))

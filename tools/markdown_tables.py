"""Tables of measured figures in Markdown pages: CSV in, tables between marks out."""
import csv
import re


def read_rows(path):
    """Rows of a CSV file with a head, as dictionaries."""
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def make_table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    lines += ["| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |" for row in rows]
    return "\n".join(lines)


def fill(path, texts):
    """Puts each text between its marks `begin NAME` and `end NAME`; other marks stay as they are."""
    with open(path, encoding="utf-8") as file:
        page = file.read()
    for name, text in texts.items():
        marks = f"<!-- begin {name} -->", f"<!-- end {name} -->"
        pattern = re.escape(marks[0]) + ".*?" + re.escape(marks[1])
        page = re.sub(pattern, lambda _: f"{marks[0]}\n{text}\n{marks[1]}", page, flags=re.DOTALL)
    with open(path, "w", encoding="utf-8") as file:
        file.write(page)

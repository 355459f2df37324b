#!/usr/bin/env python3
"""Counts habits that make a reader read a sentence twice, in what users read.

usage: count_habits.py                    prints how many there are of each, for headers, messages, guide and method
       count_habits.py --places [WORD]    prints each place as well; only those whose path or habit contains WORD
       count_habits.py --sample COUNT AREA SEED    prints COUNT sentences of an area, chosen at random
       count_habits.py --self-test

Headers are the comments of include/. Messages are the string literals of src/ that have three words or more. The guide is
docs/guide/, docs/start/ and README.md; the method is docs/method/. Code is not counted. The habits (HABITS):

a   "what" where a noun is meant: `what deforms lags`; after a verb such as `says` it is counted no more than in a title
b   a pronoun that stands far from its noun: `that of`, `one that`, `ones`, `such` alone, `the same.`
c   a noun that is negated in place of the verb: `is no folder`, `are none`; `there is no` is plain
d   words in a sense that readers do not know: anew, to the bit, beside, go on, tell, `over 32`, `way` for a distance
e   conditions in one sentence, three or more, or more than 29 words up to a semicolon or a colon; parentheses are left out

The rules are patterns: they miss some and accuse a few. The counts are limits (tools/check_limits.py) that may only fall.
"""
import os
import random
import re
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
AREAS = {"headers": ("include",), "messages": ("src",), "guide": ("README.md", "docs/start", "docs/guide"), "method": ("docs/method",)}
MOST_WORDS = 29
VERB = r"(?:is|are|was|were|has|had|have|does|can|may|must|will|would|should|cannot|goes|(?!its\b|this\b|us\b|happens\b)[a-z]+[^s\W]s)\b"
ASKED = (r"(?:say|says|said|saying|show|shows|see|sees|know|knows|explain|explains|ask|asks|decide|decides|check|checks|find|finds|list|lists|"
         r"describe|describes|choose|chooses|learn|understand|matters?|print|prints|write|writes|report|reports|read|reads|name|names|for)")
NUMBER = r"(?:\d|two|three|four|five|six|seven|eight|nine|ten|twenty|a hundred|a thousand|a million|half|its limit|the limit|the number)"
HABITS = {
    "a": [rf"(?<!^)(?<!\b[Ss]ays )(?<!; )\bwhat {VERB}", rf"^What {VERB}(?=.* {VERB})"],
    "b": [r"\b(?:[Tt]hat|[Tt]hose|this) of\b|\b[Tt]hose (?:with|without|on|in|from)\b", r"\b[Oo]ne (?:that|which|who|whose|on|with|without|from|by|as|of which)\b(?! (?:one|another)\b)",
          r"\b(?:[Aa]n?) \w+ one\b|\bones\b", r"(?<!no )\b[Ss]uch\b(?! (?:as|an?)\b)", r"\bthe same(?=[.,;:)]|$)"],
    "c": [r"(?<![Tt]here )\b(?:is|are|was|were|be|been) (?:no(?! (?:longer|more|less|larger|smaller|nearer|farther|better|worse|further|need|doubt)\b)|none)\b(?! one\b)"],
    "d": [r"\banew\b", r"\bto the bit\b", r"\b[Bb]esides?\b", r"\b(?:go|goes|went|gone|going) on\b", r"\b(?:tells?|told|telling)\b",
          rf"\bover {NUMBER}", r"\b(?:[Ii]ts|[Tt]heir|[Aa]|[Tt]he|whose|each|this|longest|largest|whole|of) ways?\b(?! (?:that|to|in which|of \w+ing)\b)"],
    "e": [],
}
HABITS = {name: [re.compile(pattern) for pattern in patterns] for name, patterns in HABITS.items()}
PLAIN_WAY = re.compile(r"\b(?:[Bb]y the way|[Ii]n (?:a|the|its|their) way|on (?:its|their|the) way|the (?:same|other|long) way|gives way)\b")
AFTER_ASKED = re.compile(rf"\b{ASKED}(?: (?:you|it|them|us|and|exactly|there|here))? $")
CONDITION = re.compile(r"\b(?:if|when|where|unless|while|until|although|because|whose|which|whatever|wherever|whether|as long as|so that|else)\b", re.I)
COMMENT = re.compile(r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'', re.S)
LITERAL = re.compile(r'"(?:\\.|[^"\\\n])*"(?:(?:\s|PRI\w+)*"(?:\\.|[^"\\\n])*")*')
END = re.compile(r"(?<=[.!?:;])[\"')\]]* +(?=[\"'(\[]?[A-Z0-9`%X_])|(?<=[.!?]) +(?=[a-z])")
FENCE = re.compile(r"^ *(```|~~~)")


def split_sentences(line, text):
    """[(line, sentence)] of a paragraph whose lines are kept."""
    flat = re.sub(r"\s*\n\s*", "\n", text.strip())
    found, at = [], 0
    for match in [*END.finditer(flat.replace("\n", " ")), None]:
        end = match.end() if match else len(flat)
        sentence = " ".join(flat[at:end].split())
        if re.search(r"[A-Za-z]{2}", sentence):
            found.append((line + flat.count("\n", 0, at), sentence))
        at = end
    return found


def read_header(text):
    """Sentences of the comments. A comment ends a paragraph, and so does a blank line or an item in it."""
    found = []
    for match in COMMENT.finditer(text):
        if not match.group().startswith("/*"):
            continue
        line = text.count("\n", 0, match.start()) + 1
        body = re.sub(r"(?m)^ +\* ?", "", match.group()[2:-2])
        for part in re.finditer(r"(?:(?!^\s*$)(?!^- (?<!\A- )).*(?:\n|\Z))(?:(?!\s*\n)(?! *- ).+(?:\n|\Z))*", body, re.M):
            if part.group().strip():
                found += split_sentences(line + body.count("\n", 0, part.start()), part.group())
    return found


def read_messages(text):
    found = []

    def blank(match):
        return match.group() if match.group().startswith(('"', "'")) else re.sub(r"[^\n]", " ", match.group())

    text = re.sub(r"(?m)^[ \t]*#\s*include.*", "", COMMENT.sub(blank, text))
    for match in LITERAL.finditer(text):
        line = text.count("\n", 0, match.start()) + 1
        words = "".join(re.findall(r'"((?:\\.|[^"\\\n])*)"|PRI', match.group()))
        for part in re.split(r"\\n", words):
            if len(re.findall(r"(?<![\\%\w])[A-Za-z]{2,}", part)) >= 3 and " " in part:
                found += split_sentences(line, part.replace('\\"', '"'))
    return found


def read_page(text):
    """Sentences of paragraphs, items and cells of a page, without code; `x` is X, a link is its words."""
    found, part, first, is_code = [], [], 0, False

    def close():
        nonlocal part
        if part:
            flat = re.sub(r"(`+)[^`]+?\1", lambda code: "X" + "\n" * code.group().count("\n"), "\n".join(part))
            found.extend(split_sentences(first, re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", flat).replace("**", "").replace("*", "")))
        part = []

    for number, line in enumerate(text.split("\n"), 1):
        if FENCE.match(line):
            close()
            is_code = not is_code
        elif is_code or not line.strip() or line.startswith(("    ", "#", "<", "![")) and not (part and line.startswith(" ")):
            close()
        elif line.startswith("|"):
            close()
            for cell in re.split(r"(?<!\\)\|", line):
                if not re.fullmatch(r"[\s:-]*", cell):
                    part, first = [cell], number
                    close()
        else:
            if re.match(r" *([-*+]|\d+[.)]) ", line):
                close()
                line = re.sub(r"^ *([-*+]|\d+[.)]) ", "", line)
            if not part:
                first = number
            part.append(line)
    close()
    return found


def find_habits(sentence):
    """[(habit, words)] of a sentence."""
    found = []
    is_question = sentence.endswith("?")
    plain = PLAIN_WAY.sub("", sentence)
    for name, patterns in HABITS.items():
        for pattern in patterns:
            for match in pattern.finditer(plain):
                if name == "a" and (is_question or AFTER_ASKED.search(plain[:match.start()])):
                    continue
                found.append((name, match.group()))
    outside = re.sub(r"\([^()]*\)", "", sentence)
    words = max(len(re.findall(r"[A-Za-z%][\w'%.-]*", part)) for part in re.split("[;:]", outside))
    conditions = len(CONDITION.findall(outside))
    if words > MOST_WORDS or conditions > 2:
        found.append(("e", f"{words} words, {conditions} conditions"))
    return found


def list_files(root, area):
    ends = (".h",) if area == "headers" else (".c", ".h") if area == "messages" else (".md",)
    for top in AREAS[area]:
        if os.path.isfile(os.path.join(root, top)):
            yield top
        for folder, _, names in sorted(os.walk(os.path.join(root, top))):
            yield from (os.path.relpath(os.path.join(folder, name), root).replace(os.sep, "/") for name in sorted(names) if name.endswith(ends))


def read_area(root, area):
    """[(path, line, sentence)]."""
    read = {"headers": read_header, "messages": read_messages}.get(area, read_page)
    for path in list_files(root, area):
        with open(os.path.join(root, path), encoding="utf-8") as file:
            yield from ((path, line, sentence) for line, sentence in read(file.read()))


def count(root):
    """{area: number of habits}."""
    return {area: sum(len(find_habits(sentence)) for _, _, sentence in read_area(root, area)) for area in AREAS}


SELF_TEST = (  # sentence, the habits in it
    ("What deforms lags behind.", "a"), ("The forces on what holds them.", "a"), ("The message says what is wrong.", ""), ("What is new?", ""),
    ("What friction does at a contact.", ""), ("At most that of the cloth.", "b"), ("Give one with more triangles.", "b"), ("Draw them one by one.", ""),
    ("Files such as these, in such a folder.", ""), ("Such are refused.", "b"), ("A negative value means: the same.", "b"), ("It reads the same file.", ""),
    ("It is no folder.", "c"), ("There is no folder.", ""), ("Pairs that are none.", "c"), ("It is no longer there.", ""),
    ("It is made anew beside the step.", "dd"), ("The page tells more.", "d"), ("Cells with over 32 members.", "d"), ("Move it over the table.", ""),
    ("Its way in a step.", "d"), ("The way to do it.", ""), ("It is solved the same way.", ""),
    ("If it moves where it rests, it stops when it is told.", "de"), ("If it moves (when told, where it rests, if any), it stops.", "d"),
    ("word " * 30, "e"), ("word " * 29, ""),
)
SELF_TEST_HEADER = "/* One. Two\n * three\n *\n * - four\n * - five */\nint a; /* six seven */\n"
SELF_TEST_CODE = '#include "a b c d.h"\n/* "not a message here" */\nf("one two %d" PRIu64\n  " three. Four five six");\ng("a.b");\n'
SELF_TEST_PAGE = "# Head\n\nOne `a b`\ntwo. Three.\n\n```\ncode is here\n```\n\n- four\n- five [six\n  seven](x.md)\n\n| a cell | b cell |\n|---|---|\n"


def self_test():
    wrong = [f"{sentence!r}: {find_habits(sentence)}, expected {habits!r}" for sentence, habits in SELF_TEST
             if "".join(name for name, _ in find_habits(sentence)) != habits]
    for read, text, expected in (
            (read_header, SELF_TEST_HEADER, [(1, "One."), (1, "Two three"), (4, "four"), (5, "five"), (6, "six seven")]),
            (read_messages, SELF_TEST_CODE, [(3, "one two %d three."), (3, "Four five six")]),
            (read_page, SELF_TEST_PAGE, [(3, "One X two."), (4, "Three."), (10, "four"), (11, "five six seven"), (14, "a cell"), (14, "b cell")])):
        if read(text) != expected:
            wrong.append(f"{read.__name__}: {read(text)}, expected {expected}")
    print("\n".join(wrong or [f"self-test: {len(SELF_TEST)} sentences and three texts judged right"]))
    return int(bool(wrong))


def main():
    arguments = sys.argv[1:]
    if arguments == ["--self-test"]:
        return self_test()
    if len(arguments) == 4 and arguments[0] == "--sample" and arguments[1].isdigit() and arguments[2] in AREAS:
        sentences = [item for item in read_area(ROOT, arguments[2]) if len(item[2].split()) > 4]
        for path, line, sentence in random.Random(arguments[3]).sample(sentences, int(arguments[1])):
            print(f"{path}:{line}: {sentence}")
        return 0
    if arguments and (arguments[0] != "--places" or len(arguments) > 2):
        print(__doc__, file=sys.stderr)
        return 2
    table = {area: dict.fromkeys(HABITS, 0) for area in AREAS}
    for area in AREAS:
        for path, line, sentence in read_area(ROOT, area):
            for name, words in find_habits(sentence):
                table[area][name] += 1
                if arguments and (len(arguments) == 1 or arguments[1] in path or arguments[1] == name):
                    print(f"{path}:{line}: {name} '{words}': {sentence}")
    print(f"{'':10}" + "".join(f"{name:>6}" for name in HABITS) + "   all")
    for area, row in table.items():
        print(f"{area:10}" + "".join(f"{number:6}" for number in row.values()) + f"{sum(row.values()):6}")
    return 0


if __name__ == "__main__":
    sys.exit(main())

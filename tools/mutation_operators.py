"""Small changes of C code that a test should notice: a tokenizer, the functions of a file, and operators over them.

find_mutants(path, code) gives every Mutant of a C file. Comments, texts, preprocessor lines, asserts, declarations without a
value, the arguments of calls that hold a text (messages, names of keys), labels and everything outside functions are left
alone: a change there means nothing, or says something else to a reader only.

A mutant is known by its file, function, operator, change and the text of its line, not by the line's number. So what is known
of it outlives edits elsewhere.

The operators tell a binary operator from a sign or a pointer by the spaces around it, as .clang-format lays them.
"""
import hashlib
import re
from collections import namedtuple

OPERATORS = {
    "boundary": "< becomes <=, >= becomes >, and so on",
    "relational": "< becomes >=, == becomes !=, and so on",
    "arithmetic": "+ becomes -, * becomes /, << becomes >>, & becomes |, and so on",
    "logical": "&& becomes ||; a ! is dropped",
    "constant": "0 becomes 1, 1 becomes 0, another whole number grows by 1, another fraction changes its sign",
    "sign": "a minus sign is dropped",
    "statement": "a call or an assignment is dropped",
    "condition": "the condition of an if is always true or always false; a while never begins",
    "minmax": "min becomes max",
    "return": "an early return is dropped",
    "status": "the status of a call is ignored",
    "index": "an index grows by 1",
}
BOUNDARY = {"<": "<=", "<=": "<", ">": ">=", ">=": ">"}
RELATIONAL = {"<": ">=", "<=": ">", ">": "<=", ">=": "<", "==": "!=", "!=": "=="}
BINARY = {"+": "-", "-": "+", "*": "/", "/": "*", "%": "*", "<<": ">>", ">>": "<<", "&": "|", "|": "&", "^": "&"}
ASSIGNING = {"+=": "-=", "-=": "+=", "*=": "/=", "/=": "*=", "|=": "&=", "&=": "|=", "<<=": ">>=", ">>=": "<<="}
MINMAX = re.compile(r"^(?:f(min|max)f?|(?:\w+_)?(min|max))$")
# Calls whose arguments are for readers, or for the compiler alone.
SPOKEN = re.compile(r"^(assert|static_assert|_Static_assert|sizeof|_Alignof|offsetof|__attribute__|__builtin_\w+)$")
MESSAGES = re.compile(r"^(error_\w+|s?n?printf|fprintf|fputs|\w*_fail|\w*_refuse\w*)$")

TOKEN = re.compile(r"""
    (?P<space>\s+|/\*.*?\*/|//[^\n]*|^[ \t]*\#(?:\\\n|/\*.*?\*/|[^\n])*)
  | (?P<text>"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])*')
  | (?P<name>[A-Za-z_]\w*)
  | (?P<number>\.?\d(?:[eEpP][+-]|[\w.])*)
  | (?P<mark><<=|>>=|\.\.\.|->|\+\+|--|<<|>>|<=|>=|==|!=|&&|\|\||[-+*/%&|^]=|.)""", re.S | re.M | re.X)
Token = namedtuple("Token", "kind text start end")
Mutant = namedtuple("Mutant", "id file function operator change line start end text")
OPENING, CLOSING = {"(": ")", "[": "]", "{": "}"}, {")", "]", "}"}
NO_VALUE = {"return", "else", "case", "goto", "do", "in", "sizeof", "if", "while", "for", "switch", "break", "continue"}


def tokenize(code):
    """Tokens of C code without spaces, comments and preprocessor lines."""
    return [Token(match.lastgroup, match.group(), match.start(), match.end())
            for match in TOKEN.finditer(code) if match.lastgroup != "space"]


def match_brackets(tokens):
    """For each token: the index of the bracket that closes or opens it, else -1."""
    partner, stack = [-1] * len(tokens), []
    for i, token in enumerate(tokens):
        if token.text in OPENING:
            stack.append(i)
        elif token.text in CLOSING and stack:
            partner[i] = stack.pop()
            partner[partner[i]] = i
    return partner


def find_functions(tokens, partner):
    """(name, index of its {, index of its }) of each function."""
    functions, i = [], 0
    while i < len(tokens):
        if tokens[i].text == "{":
            head = partner[i - 1] if i > 0 and tokens[i - 1].text == ")" else -1
            if head > 0:
                name = head - 1
                if tokens[name].text == ")":  # TULLE_KERNEL(name)(...)
                    name -= 1
                functions.append((tokens[name].text, i, partner[i]))
            i = partner[i] if partner[i] > i else len(tokens)
        i += 1
    return functions


class Body:
    """A function's body: its statements, and which of its tokens are left alone."""

    def __init__(self, tokens, partner, begin, end):
        self.tokens, self.partner, self.begin, self.end = tokens, partner, begin, end
        self.left_alone, self.in_for_head = set(), set()
        self.statements, self.declarations = [], set()  # (first token, its ;)
        self.leave_calls_alone()
        self.split()

    def leave_calls_alone(self):
        for i in range(self.begin, self.end):
            opened = self.tokens[i].text == "(" and self.tokens[i - 1].kind == "name"
            if not opened:
                continue
            inside = range(i + 1, self.partner[i])
            name = self.tokens[i - 1].text
            if SPOKEN.match(name) or (name not in NO_VALUE and any(self.tokens[k].kind == "text" for k in inside)):
                self.left_alone.update(inside)
            if name == "for":
                self.in_for_head.update(inside)

    def split(self):
        """Finds statements, which end with ; outside of all parentheses."""
        i, first = self.begin + 1, self.begin + 1
        while i < self.end:
            text = self.tokens[i].text
            if text in ("if", "while", "for", "switch") and self.tokens[i + 1].text == "(":
                close = self.partner[i + 1]
                if text == "for":
                    self.judge_declaration(i + 2, close)
                i = close
                first = i + 1
            elif text in ("else", "do", "{", "}"):
                # The braces of a value, a list of values or a type belong to their statement.
                is_type = text == "{" and any(t.text in ("enum", "struct", "union") for t in self.tokens[first:i])
                if is_type:
                    self.left_alone.update(range(i, self.partner[i]))
                if is_type or (text == "{" and self.tokens[i - 1].text in ("=", ")", ",") and first < i):
                    i = self.partner[i]
                else:
                    first = i + 1
            elif text in ("case", "default"):
                while self.tokens[i].text != ":":
                    self.left_alone.add(i)
                    i += 1
                first = i + 1
            elif text == "(" or text == "[":
                i = self.partner[i]
            elif text == ";":
                if first < i:
                    self.statements.append((first, i))
                    self.judge_declaration(first, i)
                first = i + 1
            i += 1

    def judge_declaration(self, first, end):
        """Leaves what stands before the value of a declaration alone, and all of a table that never changes."""
        words = [token for token in self.tokens[first:min(first + 4, end)] if token.text != "*"]
        if len(words) < 2 or words[0].kind != "name" or words[0].text in NO_VALUE or words[1].kind != "name":
            return
        is_fixed = words[0].text in ("static", "typedef", "enum", "extern")
        depth, has_value = 0, False
        for k in range(first, end):
            text = self.tokens[k].text
            depth += (text in OPENING) - (text in CLOSING)
            if text in ("=", ";") and depth == 0:
                has_value = True
            elif text == "," and depth == 0:
                has_value = False
            if not has_value or is_fixed:
                self.left_alone.add(k)
        self.declarations.add((first, end))


def is_spaced(code, token):
    return code[token.start - 1].isspace() and code[token.end].isspace()


def change_number(text):
    """The number that takes its place, or none."""
    match = re.match(r"^(\d+)([uUlL]*)$", text)
    if match:
        value = int(match.group(1))
        return str(1 - value if value < 2 else value + 1) + match.group(2)
    match = re.match(r"^(\d*\.\d*(?:[eE][+-]?\d+)?|\d+[eE][+-]?\d+)([fF]?)$", text)
    if not match:
        return None
    return ("1.0" + match.group(2)) if float(match.group(1)) == 0.0 else f"(-{text})"


def change_tokens(code, body):
    """Yields (operator, start, end, text) of changes that take one token's place."""
    tokens = body.tokens
    for i in range(body.begin + 1, body.end):
        token, text = tokens[i], tokens[i].text
        if i in body.left_alone:
            continue
        before = tokens[i - 1]
        follows_value = before.kind in ("number", "text") or before.text in (")", "]") or (
            before.kind == "name" and before.text not in NO_VALUE)
        if token.kind == "number":
            changed = change_number(text)
            if changed:
                yield "constant", token.start, token.end, changed
        elif token.kind == "name" and MINMAX.match(text) and tokens[i + 1].text == "(":
            swapped = re.sub("min|max", lambda m: "max" if m.group() == "min" else "min", text)
            yield "minmax", token.start, token.end, swapped
        elif text in RELATIONAL:
            if text in BOUNDARY:
                yield "boundary", token.start, token.end, BOUNDARY[text]
            yield "relational", token.start, token.end, RELATIONAL[text]
        elif text in ("&&", "||"):
            yield "logical", token.start, token.end, "||" if text == "&&" else "&&"
        elif text == "!":
            yield "logical", token.start, token.end, ""
        elif text == "-" and not follows_value and not code[token.end].isspace():
            yield "sign", token.start, token.end, ""
        elif text in BINARY and is_spaced(code, token) and follows_value:
            yield "arithmetic", token.start, token.end, BINARY[text]
        elif text in ASSIGNING:
            yield "arithmetic", token.start, token.end, ASSIGNING[text]
        elif text in ("++", "--") and i not in body.in_for_head:
            yield "arithmetic", token.start, token.end, "--" if text == "++" else "++"
        elif text == "[" and follows_value and before.kind != "text":
            yield "index", token.start, tokens[body.partner[i]].end, \
                f"[({code[token.end:tokens[body.partner[i]].start]}) + 1]"


def change_statements(code, body):
    """Yields (operator, start, end, text) of changes of statements and conditions."""
    tokens, partner = body.tokens, body.partner
    for i in range(body.begin + 1, body.end):
        if tokens[i].text in ("if", "while") and tokens[i + 1].text == "(":
            start, end = tokens[i + 1].end, tokens[partner[i + 1]].start
            if tokens[i].text == "if":
                yield "condition", start, end, "1"
            if not code[start:end].isdigit() and tokens[partner[i + 1] + 1].text != ";":
                yield "condition", start, end, "0"
    for first, end in body.statements:
        texts = [tokens[k].text for k in range(first, end)]
        start, stop = tokens[first].start, tokens[end].end
        if texts[0] == "return":
            if end + 1 < body.end:
                yield "return", start, stop, ";"
        elif (first, end) in body.declarations or texts[0] in NO_VALUE or SPOKEN.match(texts[0]) or \
                texts[0] == "enum" or texts[:2] == ["(", "void"]:
            continue
        elif not (MESSAGES.match(texts[0]) and any(tokens[k].kind == "text" for k in range(first, end))):
            yield "statement", start, stop, ";"
            if texts[0] == "status" and texts[1] == "=" and texts[-1] == ")":
                yield "status", start, stop, f"(void){code[tokens[first + 2].start:stop]}"


def find_mutants(path, code):
    """All mutants of the C file `path`, whose text is `code`, in the order of their places."""
    tokens = tokenize(code)
    partner = match_brackets(tokens)
    mutants, times_seen = [], {}
    for function, begin, end in find_functions(tokens, partner):
        body = Body(tokens, partner, begin, end)
        changes = list(change_tokens(code, body)) + list(change_statements(code, body))
        for operator, start, stop, text in sorted(set(changes), key=lambda c: (c[1], c[0], c[3])):
            line_start = code.rfind("\n", 0, start) + 1
            line = code[line_start:code.find("\n", start)].strip()
            old, new = (re.sub(r"\s+", " ", part).strip() for part in (code[start:stop], text))
            change = f"{old} -> {new or 'nothing'}"
            column = len(code[line_start:start].strip())
            key = (path, function, operator, change, line, column)
            times_seen[key] = times_seen.get(key, 0) + 1
            digest = hashlib.sha1(repr(key + (times_seen[key],)).encode()).hexdigest()[:10]
            mutants.append(Mutant(digest, path, function, operator, change, line, start, stop, text))
    return mutants


def apply_mutant(code, mutant):
    return code[:mutant.start] + mutant.text + code[mutant.end:]

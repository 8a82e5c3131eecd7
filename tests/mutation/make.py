"""Makes mutations of C++: finds the places with libclang, and writes all of them as one text.

In that text each mutation has a switch (switch.h), so a program is built once for all of them.
"""

import bisect
import collections
import dataclasses
import difflib
import hashlib
import os
import pathlib
import re

from clang import cindex
from clang.cindex import CursorKind

RELATIONAL = {"<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "=="}
ARITHMETIC = {"+": "-", "-": "+", "*": "/", "/": "*", "%": "*",
              "+=": "-=", "-=": "+=", "*=": "/=", "/=": "*=", "%=": "*="}
LOGICAL = {"&&": "||", "||": "&&"}
BIT = {"&": "|", "|": "&", "^": "&", "<<": ">>", ">>": "<<",
       "&=": "|=", "|=": "&=", "^=": "&=", "<<=": ">>=", ">>=": "<<="}
SWAPS = [("relational", RELATIONAL), ("arithmetic", ARITHMETIC), ("logical", LOGICAL), ("bit", BIT)]
UNARY = {"!": ("logical", ""), "-": ("arithmetic", ""), "~": ("bit", ""),
         "++": ("arithmetic", "--"), "--": ("arithmetic", "++")}
NUMBER = re.compile(r"^(0[xX][0-9a-fA-F']+|0[bB][01']+|[0-9][0-9']*\.?[0-9']*([eE][-+]?[0-9]+)?)"
                    r"[a-zA-Z_]*$")
COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.DOTALL)

FUNCTIONS = {CursorKind.FUNCTION_DECL, CursorKind.CXX_METHOD, CursorKind.CONSTRUCTOR,
             CursorKind.DESTRUCTOR, CursorKind.CONVERSION_FUNCTION, CursorKind.FUNCTION_TEMPLATE}
# What the compiler must know: no switch can stand there.
FOR_THE_COMPILER = {CursorKind.STATIC_ASSERT, CursorKind.ENUM_DECL, CursorKind.TYPE_ALIAS_DECL,
                    CursorKind.TYPEDEF_DECL, CursorKind.TEMPLATE_NON_TYPE_PARAMETER,
                    CursorKind.TEMPLATE_TYPE_PARAMETER, CursorKind.TYPE_ALIAS_TEMPLATE_DECL,
                    CursorKind.CXX_UNARY_EXPR}
REFERENCES = {CursorKind.DECL_REF_EXPR, CursorKind.MEMBER_REF_EXPR}
CASTS = {CursorKind.CXX_STATIC_CAST_EXPR, CursorKind.CXX_REINTERPRET_CAST_EXPR,
         CursorKind.CXX_CONST_CAST_EXPR, CursorKind.CXX_DYNAMIC_CAST_EXPR}
LOOPS = {CursorKind.FOR_STMT, CursorKind.WHILE_STMT, CursorKind.DO_STMT,
         CursorKind.CXX_FOR_RANGE_STMT}
CASES = {CursorKind.CASE_STMT, CursorKind.DEFAULT_STMT}
JUMPS = {CursorKind.BREAK_STMT: "break", CursorKind.CONTINUE_STMT: "continue"}


@dataclasses.dataclass
class Mutation:
    file: str
    function: str
    # Such as "relational" or "statement".
    kind: str
    # Bytes of the source, and what stands there instead.
    start: int
    end: int
    instead: str
    line: int
    last_line: int
    # How its switch is written: "expression", "condition" or "statement".
    shape: str
    # In a function that the compiler itself may call.
    constexpr: bool
    key: str = ""


def read(path):
    """The text with one character for each byte, as libclang counts."""
    return path.read_bytes().decode("latin-1")


def last_child(cursor):
    return ([None] + list(cursor.get_children()))[-1]


def without_comments(text):
    return COMMENT.sub(" ", text)


def one_line(text):
    return re.sub(r"\s+", " ", without_comments(text)).strip()


class Finder:
    """Finds the mutations of one file."""

    def __init__(self, path, file, cursors):
        self.text = read(path)
        self.file = file
        self.found = {}
        # Jumps to where control goes anyway.
        self.idle = set()
        # Numbers that the compiler must know.
        self.fixed_numbers = 0
        self.line_starts = [0] + [match.end() for match in re.finditer("\n", self.text)]
        self.visit_all(cursors, "", False)

    def span(self, cursor):
        return cursor.extent.start.offset, cursor.extent.end.offset

    def of(self, cursor):
        start, end = self.span(cursor)
        return self.text[start:end]

    def line_of(self, offset):
        return bisect.bisect_right(self.line_starts, offset)

    def add(self, kind, change, span, instead, context, shape="expression", at=None):
        """`at` is where the change is, if that is less than the span."""
        start, end = span
        if start >= end or (start, end, instead) in self.found:
            return
        at = at or span
        function, constexpr = context
        self.found[start, end, instead] = (Mutation(
            self.file, function, kind, start, end, instead, self.line_of(at[0]),
            self.line_of(at[1] - 1), shape, constexpr), change)

    def visit_all(self, cursors, function, constexpr):
        for cursor in cursors:
            self.visit(cursor, function, constexpr)

    def visit(self, cursor, function, constexpr):
        kind = cursor.kind
        if kind in FOR_THE_COMPILER:
            return
        if kind in FUNCTIONS:
            self.visit_function(cursor)
        elif kind in (CursorKind.VAR_DECL, CursorKind.FIELD_DECL):
            self.visit_variable(cursor, function, constexpr)
        elif kind == CursorKind.LAMBDA_EXPR:
            body = list(cursor.get_children())[-1:]
            self.visit_all(cursor.get_children(), function, constexpr)
            for each in body:
                self.visit_returns(each, (function, constexpr), not self.returns_a_value(each))
        elif kind in CASES:
            # Not the constant. A case of a case has the statement.
            for each in list(cursor.get_children())[-1:]:
                self.leave_out(each, (function, constexpr))
                self.visit(each, function, constexpr)
        elif kind == CursorKind.PARM_DECL:
            return
        else:
            self.visit_code(cursor, function, constexpr)

    def visit_function(self, cursor):
        children = list(cursor.get_children())
        body = next((each for each in children if each.kind == CursorKind.COMPOUND_STMT), None)
        if body is None:
            return
        head = without_comments(self.text[cursor.extent.start.offset:body.extent.start.offset])
        if "consteval" in head:
            return
        names = []
        parent = cursor.semantic_parent
        while parent is not None and parent.kind != CursorKind.TRANSLATION_UNIT:
            if parent.spelling and parent.kind != CursorKind.NAMESPACE:
                names.append(parent.spelling)
            parent = parent.semantic_parent
        function = "::".join([*reversed(names), cursor.displayname])
        constexpr = re.search(r"\bconstexpr\b", head) is not None
        if cursor.kind == CursorKind.CONSTRUCTOR:
            self.visit_all([each for each in children if each.kind.is_expression()],
                           function, constexpr)
        self.visit(body, function, constexpr)
        returns_nothing = (cursor.result_type.spelling == "void" or
                           cursor.kind in (CursorKind.CONSTRUCTOR, CursorKind.DESTRUCTOR))
        self.visit_returns(body, (function, constexpr), returns_nothing)

    def visit_variable(self, cursor, function, constexpr):
        start = cursor.extent.start.offset
        head = self.text[start:cursor.location.offset]
        children = [each for each in cursor.get_children()
                    if each.extent.start.offset > cursor.location.offset]
        if cursor.kind == CursorKind.FIELD_DECL and cursor.is_bitfield():
            return
        if re.search(r"\b(constexpr|constinit)\b", head):
            self.count_fixed(children, function)
            return
        owner = cursor.semantic_parent
        if (cursor.kind == CursorKind.FIELD_DECL and owner.kind == CursorKind.STRUCT_DECL and
                all(each.kind != CursorKind.CONSTRUCTOR for each in owner.get_children())):
            # Each source that makes one compiles the value for itself.
            self.count_fixed(children, function)
            return
        function = function or f"{cursor.semantic_parent.spelling}::{cursor.spelling}"
        # The compiler makes objects of classes whose members have values in the class.
        self.visit_all(children, function, constexpr or cursor.kind == CursorKind.FIELD_DECL)

    def count_fixed(self, cursors, function):
        """Of a constant: its numbers; functions in it are mutated."""
        for cursor in cursors:
            if cursor.kind == CursorKind.LAMBDA_EXPR:
                self.visit(cursor, function or "constant", True)
                continue
            self.fixed_numbers += (cursor.kind in (CursorKind.INTEGER_LITERAL,
                                                   CursorKind.FLOATING_LITERAL) or
                                   cursor.kind == CursorKind.CALL_EXPR and
                                   NUMBER.match(self.of(cursor)) is not None)
            self.count_fixed(cursor.get_children(), function)

    def returns_a_value(self, cursor):
        for each in cursor.get_children():
            if each.kind == CursorKind.RETURN_STMT:
                if next(each.get_children(), None) is not None:
                    return True
            elif each.kind != CursorKind.LAMBDA_EXPR and self.returns_a_value(each):
                return True
        return False

    def visit_returns(self, body, context, returns_nothing):
        """Without an early return, control must come to the last one."""
        last = last_child(body)
        if last is None or not (returns_nothing or last.kind == CursorKind.RETURN_STMT):
            return
        todo = [each for each in body.get_children() if each != last or returns_nothing]
        while todo:
            cursor = todo.pop()
            if cursor.kind == CursorKind.RETURN_STMT:
                if cursor != last:
                    self.add_statement("return", cursor, context)
            elif cursor.kind != CursorKind.LAMBDA_EXPR:
                todo += cursor.get_children()

    def add_statement(self, change, cursor, context):
        start, end = self.span(cursor)
        rest = re.match(r"\s*;", self.text[end:])
        if rest:
            self.add("statement", change, (start, end + rest.end()), "", context, "statement")

    def visit_code(self, cursor, function, constexpr):
        context = (function, constexpr)
        kind = cursor.kind
        children = list(cursor.get_children())
        if function:
            self.mutate(cursor, children, context)
        if kind in (CursorKind.IF_STMT, CursorKind.WHILE_STMT, CursorKind.DO_STMT,
                    CursorKind.CONDITIONAL_OPERATOR):
            if re.match(r"if\s+constexpr", self.of(cursor)):
                self.visit_all(children[1:], function, constexpr)
                return
            self.negate(cursor, children, context)
        self.note_idle_jump(kind, children)
        if kind == CursorKind.COMPOUND_STMT:
            for each in children:
                self.leave_out(each, context)
        if kind in REFERENCES:
            children = [each for each in children if not self.is_number(each)]
        elif kind in CASTS or any(each.kind == CursorKind.TEMPLATE_REF for each in children):
            children = children[-1:]
        self.visit_all(children, function, constexpr)

    def leave_out(self, statement, context):
        kind = statement.kind
        if (kind.is_expression() and kind != CursorKind.PAREN_EXPR and
                not re.match(r"static_cast<void>|\(void\)", self.of(statement))):
            self.add_statement("expression", statement, context)
        elif kind in JUMPS and self.span(statement) not in self.idle:
            self.add_statement(JUMPS[kind], statement, context)

    def note_idle_jump(self, kind, children):
        """The last one of a switch or of a loop."""
        jump = CursorKind.BREAK_STMT if kind == CursorKind.SWITCH_STMT else \
            CursorKind.CONTINUE_STMT if kind in LOOPS else None
        for body in children if jump else []:
            last = last_child(body)
            while last is not None and last.kind in CASES:
                last = last_child(last)
            if body.kind == CursorKind.COMPOUND_STMT and last is not None and last.kind == jump:
                self.idle.add(self.span(last))

    def is_number(self, cursor):
        return NUMBER.match(self.of(cursor)) is not None

    def negate(self, cursor, children, context):
        if cursor.kind == CursorKind.DO_STMT:
            children = children[-1:]
        condition = next((each for each in children if each.kind != CursorKind.DECL_STMT), None)
        if condition is None or not condition.kind.is_expression():
            return
        start, end = self.span(condition)
        text = self.text[start:end]
        # The swapped operator says the same.
        if any(change in ("== to !=", "!= to ==", "! left out") and (start, end) == (begin, stop)
               for begin, stop, change in self.operators_of(condition)):
            return
        self.add("condition", "negated", (start, end), f"!({one_line(text)})", context, "condition")

    def operators_of(self, cursor):
        """The operator at the top: its span, and what a mutation would change."""
        todo = [cursor]
        span = self.span(cursor)
        while todo:
            each = todo.pop()
            if self.span(each) != span:
                continue
            children = list(each.get_children())
            swap = self.swap_of(each, children)
            if swap:
                yield *span, f"{swap[1]} to {swap[2]}"
            if each.kind == CursorKind.UNARY_OPERATOR and self.text[span[0]] == "!":
                yield *span, "! left out"
            todo += children

    def swap_of(self, cursor, children):
        """Kind, operator, the other one, and where the operator is; of a binary operator."""
        start, end = self.span(cursor)
        if len(children) < 2:
            return None
        left, right = self.span(children[0]), self.span(children[-1])
        if left[0] != start or right[1] != end or left[1] >= right[0]:
            return None
        between = self.text[left[1]:right[0]]
        operator = one_line(between)
        for kind, swaps in SWAPS:
            if operator in swaps:
                at = left[1] + between.find(operator)
                return kind, operator, swaps[operator], (at, at + len(operator))
        return None

    def mutate(self, cursor, children, context):
        start, end = self.span(cursor)
        swap = self.swap_of(cursor, children)
        if swap:
            kind, operator, other, at = swap
            if kind in ("relational", "logical") or self.computes(cursor):
                instead = f"{one_line(self.text[start:at[0]])} {other} " \
                          f"{one_line(self.text[at[1]:end])}"
                self.add(kind, f"{operator} to {other}", (start, end), instead, context, at=at)
            return
        if len(children) in (1, 2) and cursor.kind in (CursorKind.UNARY_OPERATOR,
                                                       CursorKind.CALL_EXPR):
            self.mutate_unary(cursor, children, context)
        elif cursor.kind == CursorKind.CXX_BOOL_LITERAL_EXPR:
            other = {"true": "false", "false": "true"}.get(self.text[start:end])
            if other:
                self.add("constant", "other", (start, end), other, context)
        if (cursor.kind in (CursorKind.INTEGER_LITERAL, CursorKind.FLOATING_LITERAL) or
                cursor.kind == CursorKind.CALL_EXPR and cursor.spelling.startswith('operator""')):
            self.mutate_number(cursor, context)

    def mutate_unary(self, cursor, children, context):
        start, end = self.span(cursor)
        operand = max(children, key=lambda child: child.extent.end.offset -
                      child.extent.start.offset)
        inner = self.span(operand)
        before, behind = self.text[start:inner[0]].strip(), self.text[inner[1]:end].strip()
        if before in UNARY and not behind:
            kind, other = UNARY[before]
            change = f"{before} to {other}" if other else f"{before} left out"
            inner = one_line(self.of(operand))
            # Beside a negation an optional would be the type of both, with a value for each.
            instead = f"static_cast<bool>({inner})" if before == "!" else f"{other}{inner}"
            self.add(kind, change, (start, end), instead, context)
        elif behind in ("++", "--") and not before:
            other = UNARY[behind][1]
            self.add("arithmetic", f"{behind} to {other}", (start, end),
                     f"{one_line(self.of(operand))}{other}", context)

    def mutate_number(self, cursor, context):
        start, end = self.span(cursor)
        text = self.text[start:end]
        number = NUMBER.match(text)
        if not number:
            return
        digits = re.sub("[^1-9a-fA-F]", "", number[1].removeprefix("0x").removeprefix("0X"))
        self.add("constant", "+1", (start, end), f"({text} + decltype({text})(1))", context)
        if digits:
            self.add("constant", "0", (start, end), f"({text} - {text})", context)

    def computes(self, cursor):
        """Texts are added and paths divided, too."""
        name = cursor.type.get_canonical().spelling
        return not re.search(r"basic_string|filesystem|stream|expected|optional|ranges|_view", name)

    def mutations(self):
        """All of them, in the order of the source, with keys that survive changes elsewhere."""
        seen = collections.Counter()
        all_of_them = []
        for mutation, change in sorted(self.found.values(),
                                       key=lambda each: (each[0].start, -each[0].end,
                                                         each[0].instead)):
            text = one_line(self.text[mutation.start:mutation.end])
            place = (mutation.function, mutation.kind, change, text)
            words = "|".join([self.file, *place, str(seen[place])])
            seen[place] += 1
            mutation.key = hashlib.sha256(words.encode()).hexdigest()[:10]
            all_of_them.append(mutation)
        return all_of_them


def find(source, arguments, files):
    """The mutations of files that a source includes, or is: {path: name}.

    Returns for each name the mutations, and how many numbers only the compiler sees.
    """
    unit = cindex.Index.create().parse(str(source), args=arguments)
    errors = [each for each in unit.diagnostics if each.severity >= cindex.Diagnostic.Error]
    if errors:
        raise ValueError(f"{source}: {errors[0]}")
    paths = {}
    cursors = collections.defaultdict(list)
    for cursor in unit.cursor.get_children():
        place = cursor.location.file
        if place is not None:
            if place.name not in paths:
                paths[place.name] = os.path.realpath(place.name)
            if paths[place.name] in files:
                cursors[paths[place.name]].append(cursor)
    found = {}
    for path, file in files.items():
        finder = Finder(pathlib.Path(path), file, cursors[path])
        found[file] = finder.mutations(), finder.fixed_numbers
    return found


def mutated(text, mutation):
    """The text with this mutation alone."""
    return text[:mutation.start] + mutation.instead + text[mutation.end:]


def difference(text, mutation):
    """As a person reads it: the lines before and after."""
    lines = difflib.unified_diff(text.splitlines(), mutated(text, mutation).splitlines(),
                                 n=0, lineterm="")
    return "\n".join(line for line in lines if not line.startswith(("---", "+++", "@@")))


class Switched:
    """The text of a file with a switch for each of these mutations.

    Each line stays on its line. `numbers` gives the switch of a mutation.
    """

    def __init__(self, text, mutations, numbers):
        self.original = text
        self.numbers = numbers
        self.pieces = []
        self.length = 0
        # Where in the text a mutation is: (start, end, mutation), of what stands instead and all.
        self.instead = []
        self.whole = []
        sites = {}
        for mutation in mutations:
            sites.setdefault((mutation.start, -mutation.end), []).append(mutation)
        self.sites = [sites[place] for place in sorted(sites)]
        self.next_site = 0
        self.write_up_to(len(text), 0)
        self.text = "".join(self.pieces)
        self.line_starts = [0] + [match.end() for match in re.finditer("\n", self.text)]

    def write(self, text):
        self.pieces.append(text)
        self.length += len(text)

    def write_up_to(self, end, at):
        while self.next_site < len(self.sites):
            site = self.sites[self.next_site]
            if site[0].start >= end:
                break
            self.next_site += 1
            self.write(self.original[at:site[0].start])
            self.write_site(site)
            at = site[0].end
        self.write(self.original[at:end])

    def switch(self, mutation):
        name = "mutated_at_run_time" if mutation.constexpr else "mutated"
        return f"::tribus_mutation::{name}({self.numbers[mutation.key]})"

    def write_site(self, site):
        start, end = site[0].start, site[0].end
        begin = self.length
        if site[0].shape == "statement":
            self.write(f"if (!{self.switch(site[0])}) {{ ")
            self.write_up_to(end, start)
            self.write(" }")
        else:
            # One of an expression may have the same place as the condition.
            conditions = [each for each in site if each.shape == "condition"]
            for mutation in conditions:
                self.write(f"({self.switch(mutation)} != static_cast<bool>(")
            others = [each for each in site if each.shape == "expression"]
            for mutation in others:
                self.write(f"({self.switch(mutation)} ? (")
                inside = self.length
                self.write(mutation.instead)
                self.instead.append((inside, self.length, mutation))
                self.write(") : ")
            self.write("(")
            self.write_up_to(end, start)
            self.write(")" + ")" * len(others) + "))" * len(conditions))
        self.whole += [(begin, self.length, mutation) for mutation in site]

    def to_blame(self, line, column):
        """The mutations that a compiler complains of at this place."""
        offset = self.line_starts[line - 1] + column - 1
        for places in (self.instead, self.whole):
            around = [(end - start, mutation) for start, end, mutation in places
                      if start <= offset <= end]
            if around:
                least = min(length for length, _ in around)
                return [mutation for length, mutation in around if length == least]
        return [mutation for start, end, mutation in self.whole
                if bisect.bisect_right(self.line_starts, start) <= line <=
                bisect.bisect_right(self.line_starts, end)]

"""Every message that a user can meet, read from the source.

``python -m tests.contracts.messages`` prints them as one list, to be read aloud.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from types import MappingProxyType
from typing import Final

import remanent

#: The parts of a message about an argument, in the order in which they are read.
PARTS: Final = ("must", "got", "why", "fix")
#: Functions whose arguments by position are parts of a message.
POSITIONAL: Final[Mapping[str, tuple[str | None, ...]]] = MappingProxyType(
    {
        "Rule": ("must", None, "why", "fix"),
        "finite_rule": ("why", "fix"),
        "positive_rule": ("why", "fix"),
        "not_negative_rule": ("why", "fix"),
        "Fault": (None, "must", "got", "why", "fix"),
    }
)
#: Functions whose argument is a whole message, by its place and its name.
WHOLE: Final[Mapping[str, tuple[int, str]]] = MappingProxyType(
    {
        "RemanentError": (0, "message"),
        "RefusalError": (1, "message"),
        "UsageError": (0, "message"),
        "ClickException": (0, "message"),
        "warn": (0, "message"),
        "warn_of_input": (0, "message"),
        "echo": (0, "message"),
        "fail": (0, "message"),
    }
)
#: Names of the parts under which those functions take them.
SYNONYMS: Final[Mapping[str, str]] = MappingProxyType({"reason": "why", "remedy": "fix"})


@dataclass(frozen=True)
class Message:
    """One message, or as much of it as one call says.

    Attributes
    ----------
    file, line
        Where it is.
    call
        The function that is called with it.
    parts
        Texts by the names of :data:`PARTS`, or one text, ``whole``; what is put in
        when it is raised stands in braces.
    """

    file: str
    line: int
    call: str
    parts: Mapping[str, str]

    @property
    def text(self) -> str:
        """As it is read."""
        if "whole" in self.parts:
            return self.parts["whole"]
        shown = {name: self.parts.get(name, "...") for name in PARTS}
        return f"`{{name}}` must {shown['must']}; got {{got}}. {shown['why']} {shown['fix']}"


def collected() -> list[Message]:
    """Messages of the whole package, by file and line."""
    root = Path(remanent.__file__).parent
    return [
        message
        for path in sorted(root.rglob("*.py"))
        for message in messages_of(path.relative_to(root).as_posix(), path.read_text("utf-8"))
    ]


def messages_of(file: str, source: str) -> Iterator[Message]:
    """Messages in one source file, each way that a choice in it may go."""
    tree = ast.parse(source)
    known = constants(tree)
    for name, expression in known.items():
        if name.endswith("_REASON"):
            for text in written(expression, {}):
                yield Message(file, expression.lineno, "reason", {"whole": text})
    for node in ast.walk(tree):
        if isinstance(node, ast.Call):
            name = called_name(node)
            texts = dict(part_texts(node, name, known))
            for chosen in product(*texts.values()) if texts else ():
                yield Message(file, node.lineno, name, dict(zip(texts, chosen, strict=True)))


def constants(tree: ast.Module) -> dict[str, ast.expr]:
    """Texts that a module gives a name."""
    found: dict[str, ast.expr] = {}
    for node in tree.body:
        target = node.targets[0] if isinstance(node, ast.Assign) else getattr(node, "target", None)
        value = getattr(node, "value", None)
        if isinstance(target, ast.Name) and isinstance(value, ast.Constant | ast.JoinedStr):
            found[target.id] = value
    return found


def called_name(node: ast.Call) -> str:
    """The last word of what is called."""
    return node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")


def part_texts(
    node: ast.Call, name: str, known: Mapping[str, ast.expr]
) -> Iterator[tuple[str, list[str]]]:
    """Parts of a message among the arguments of a call, with the texts that each may have."""
    found: dict[str, ast.expr] = {}
    for keyword in node.keywords:
        part = str(keyword.arg)
        if name in POSITIONAL:
            part = SYNONYMS.get(part, part)
        if part in PARTS:
            found[part] = keyword.value
    for place_of, argument in zip(POSITIONAL.get(name, ()), node.args, strict=False):
        if place_of is not None:
            found[place_of] = argument
    if name in WHOLE:
        place, keyword_name = WHOLE[name]
        by_name = {str(one.arg): one.value for one in node.keywords}
        text = node.args[place] if len(node.args) > place else by_name.get(keyword_name)
        found = {} if text is None else {"whole": text}
    for part, expression in found.items():
        texts = [one for one in written(expression, known) if any(c.isalpha() for c in bare(one))]
        if texts and part != "got":
            yield part, texts


def written(node: ast.expr, known: Mapping[str, ast.expr]) -> list[str]:
    """Texts that an expression may give; what is known only when it runs is in braces."""
    match node:
        case ast.Constant(value=str(text)):
            found = [text]
        case ast.JoinedStr(values=values):
            found = ["".join(parts) for parts in product(*(written(v, known) for v in values))]
        case ast.Name(id=name) if name in known:
            found = written(known[name], {})
        case ast.FormattedValue(value=ast.IfExp() | ast.Constant() | ast.Name() as inner):
            found = written(inner, known)
        case ast.IfExp(body=body, orelse=other):
            found = [*written(body, known), *written(other, known)]
        case ast.BoolOp(op=ast.Or(), values=values):
            found = [text for value in values for text in written(value, known)]
        case ast.BinOp(left=left, op=ast.Add(), right=right):
            found = [a + b for a, b in product(written(left, known), written(right, known))]
        case ast.FormattedValue(value=inner):
            found = [f"{{{ast.unparse(inner)}}}"]
        case _:
            found = [f"{{{ast.unparse(node)}}}"]
    return found


def bare(text: str) -> str:
    """A text without what is put in when it is raised."""
    depth, kept = 0, []
    for character in text:
        depth += character == "{"
        if depth == 0:
            kept.append(character)
        depth -= character == "}"
    return "".join(kept)


def main() -> None:
    """Print every message."""
    for message in collected():
        print(f"{message.file}:{message.line}  {message.call}\n    {message.text}")


if __name__ == "__main__":
    main()

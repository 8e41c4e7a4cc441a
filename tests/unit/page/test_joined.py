"""Modules that are joined behave as they do apart, and forms that are not joined are refused."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

from remanent._errors import RemanentError
from remanent.page.files import module_sources
from remanent.page.joined import joined_modules

SOURCES = {
    "app/main.js": """\
import { double, LIMIT as most } from "./inner/numbers.js";
import * as words from "../words.js";
import {
  half,
  later as soon,
} from "./inner/numbers.js";
import "./inner/effect.js";

const found = await import("/fields/one.js");
console.log(double(4), most, words.greet("all"), half(3), await soon(), found.answer, globalThis.x);
""",
    "app/inner/numbers.js": """\
import { factor } from "../../words.js";
/** export const hidden = 1; and import { a } from "b"; in words only
export function alsoHidden() {}
 */
export const LIMIT = 7;
export function double(x) {
  return factor * x;
}
const half = (x) => x / factor;
export async function later() {
  return "soon";
}
export { half };
""",
    "app/inner/effect.js": "globalThis.x = 3;\n",
    "words.js": """\
export const factor = 2;
export class Greeting {}
function hello(name) { return `hello ${name}`; }
export { hello as greet };
""",
}
FURTHER = {"/fields/one.js": "export const answer = 42;\n"}


def node(path: Path) -> str:
    if shutil.which("node") is None:
        pytest.skip("node is not installed")
    return subprocess.run(["node", str(path)], check=True, capture_output=True, text=True).stdout


def test_joined_modules_do_what_they_do_apart(tmp_path: Path) -> None:
    """Law: every form of import and export, asked for in any order, gives the same."""
    text = joined_modules(SOURCES, "app/main.js", FURTHER)
    joined = tmp_path / "joined.mjs"
    joined.write_text(text, encoding="utf-8")
    for name, source in {**SOURCES, **FURTHER}.items():
        path = tmp_path / "apart" / name.lstrip("/")
        path.parent.mkdir(parents=True, exist_ok=True)
        folder = tmp_path / "apart"
        path.write_text(source.replace('"/fields', f'"{folder}/fields'), encoding="utf-8")
    (tmp_path / "apart" / "package.json").write_text('{"type": "module"}')
    assert node(joined) == node(tmp_path / "apart" / "app" / "main.js")
    assert node(joined) == "8 7 hello all 1.5 soon 42 3\n"


def test_joining_is_the_same_every_time() -> None:
    """Law: equal modules, in any order, make equal texts."""
    again = dict(reversed(SOURCES.items()))
    first = joined_modules(SOURCES, "app/main.js", FURTHER)
    assert joined_modules(again, "app/main.js", FURTHER) == first


@pytest.mark.parametrize(
    ("source", "said"),
    [
        ("export default 3;", "form that is not joined"),
        ("export let count = 0;", "form that is not joined"),
        ("export * from './a.js';", "form that is not joined"),
        ("import thing from './words.js';", "form that is not joined"),
        ('import { a } from "elsewhere";', "form that is not joined"),
        ('  import { factor } from "./words.js";', "form that is not joined"),
        ('import { factor } from "./missing.js";', "is not there"),
        ('import { factor as } from "./words.js";', "list of names"),
        ('import { factor } from "./main.js";', "needs itself"),
        ("console.log(import.meta.url);", "its own address"),
    ],
)
def test_other_forms_are_refused(source: str, said: str) -> None:
    """Law: what is not joined exactly is refused with the module and the form."""
    sources = {"main.js": source, "words.js": "export const factor = 2;"}
    with pytest.raises(RemanentError, match=said):
        joined_modules(sources, "main.js", {})


def test_a_module_that_is_not_held_is_missed_in_words(tmp_path: Path) -> None:
    """Law: asking for another address while the page runs is an error that names it."""
    text = joined_modules(
        {"main.js": 'import("/b.js").catch((error) => console.log(error.message));'}, "main.js", {}
    )
    path = tmp_path / "joined.mjs"
    path.write_text(text, encoding="utf-8")
    assert node(path) == "This page holds no module /b.js.\n"


def test_the_engine_of_the_page_is_joined() -> None:
    """Law: the package's own modules have only forms that are joined."""
    sources = module_sources()
    for entry in ("engine/motion.js", "engine/potential.js"):
        text = joined_modules(sources, entry, {})
        assert 'from "' not in text
        assert text.count("await (async () => {") >= 3

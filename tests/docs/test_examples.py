"""Every example in the documentation runs, every link leads somewhere, and the site has every page."""

import ast
import os
import re
import shlex
import tomllib
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from urllib.parse import unquote, urlsplit

import matplotlib
import pytest
import typer
from markdown_it import MarkdownIt
from markdown_it.token import Token
from sybil import Document, Example
from sybil.parsers.markdown import CodeBlockParser, PythonCodeBlockParser, SkipParser

import exudyn_crawler
from docs import conf, rooms
from exudyn_crawler import Terrain, cli
from studies.commands import app as studies

ROOT = Path(__file__).parents[2]
PARTS = ("docs", "meshes", "benchmarks")
PAGES = sorted([*ROOT.glob("*.md"), *(page for part in PARTS for page in (ROOT / part).rglob("*.md"))])
NAMES = [str(page.relative_to(ROOT)) for page in PAGES]
LONG = {
    "python.md",
    "machine_in_python.md",
    "own_shoe_mesh.md",
    "own_load_cycle.md",
    "reading_results.md",
    "own_model.md",
}
"""Pages whose examples are whole runs or meshes: a quarter of a minute and more."""
LANGUAGES = {"python", "toml", "sh", "csv", "math", "text", "{toctree}", "{eval-rst}", "{index}"}
"""Of fenced blocks: the first two are checked here, the others are for reading."""


def run_toml(example: Example) -> None:
    """Parse a block; one that begins with a comment such as ``# cycle.toml`` becomes that file."""
    tomllib.loads(example.parsed)
    if name := re.match(r"# (\w+\.toml)\n", example.parsed):
        Path(name[1]).write_text(example.parsed, encoding="utf-8")


def tokens_of(page: Path) -> list[Token]:
    return MarkdownIt("commonmark").enable("table").parse(page.read_text(encoding="utf-8"))


def fences_of(page: Path) -> list[Token]:
    return [token for token in tokens_of(page) if token.type == "fence"]


def programs_of(page: Path) -> list[Token]:
    """Blocks of Python that are no sessions at its prompt."""
    fences = fences_of(page)
    return [one for one in fences if one.info == "python" and not one.content.startswith(">>>")]


def links_of(page: Path) -> Iterator[str]:
    for token in tokens_of(page):
        for child in token.children or []:
            target = child.attrGet("href") if child.type == "link_open" else child.attrGet("src")
            if isinstance(target, str):
                yield target


def anchors_of(page: Path) -> set[str]:
    """Anchors of a page's headings, as GitHub names them."""
    tokens = tokens_of(page)
    headings = [text.content for one, text in pairwise(tokens) if one.type == "heading_open"]
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.simulation
@pytest.mark.parametrize(
    "page",
    [pytest.param(page, marks=pytest.mark.slow) if page.name in LONG else page for page in PAGES],
    ids=NAMES,
)
def test_examples_run(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    matplotlib.use("Agg")
    parsers = PythonCodeBlockParser(), CodeBlockParser("toml", run_toml), SkipParser()
    for example in Document.parse(str(page), *parsers):
        example.evaluate()


@pytest.mark.parametrize("page", PAGES, ids=NAMES)
def test_commands_in_blocks_and_text_have_their_options(page):
    """All commands of the program and of make are known, with the options and values that they are given."""
    text = page.read_text(encoding="utf-8")
    blocks = "".join(fence.content for fence in fences_of(page) if fence.info == "sh")
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
    assert set(re.findall(r"^make ([a-z-]+)", blocks, re.MULTILINE)) <= targets
    for program, app in (("exudyn-crawler", cli.app), ("python -m studies", studies)):
        known, inline = typer.main.get_command(app), re.findall(rf"`{program} ([a-z][^`]+)`", text)
        for line in re.findall(rf"^{program} ([^#\n]+)", blocks, re.MULTILINE) + inline:
            name, *words = shlex.split(line)
            command = known.get_command(typer.Context(known), name)
            assert command is not None, name
            if words and not {"--help", "..."} & set(words):
                given = ["1" if word in ("SHOE", "X", "Y", "Z") else word for word in words]
                command.make_context(name, given)


def public_names_by_module(nodes):
    """Public names that some code takes from the module in which they are, and not from the package."""
    imports = [node for node in nodes if isinstance(node, ast.ImportFrom)]
    inner = [node for node in imports if (node.module or "").startswith("exudyn_crawler.")]
    return {alias.name for node in inner for alias in node.names} & set(exudyn_crawler.__all__)


@pytest.mark.parametrize("page", PAGES, ids=NAMES)
def test_every_block_is_of_a_known_language_and_takes_public_names_from_the_package(page):
    assert {fence.info.partition(" ")[0] for fence in fences_of(page)} <= LANGUAGES
    for fence in programs_of(page):
        compile(fence.content, f"{page}:{fence.map[0] + 1}", "exec")
    nodes = [node for fence in programs_of(page) for node in ast.walk(ast.parse(fence.content))]
    imported = {alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names}
    imported |= {node.module for node in nodes if isinstance(node, ast.ImportFrom)}
    ours = {name for name in imported if name.split(".")[0] in ("fem", "meshes", "studies")}
    # drawing another shoe needs gmsh, which the package does without
    studies = {f"studies.{name}" for name in ("balance", "grounds", "sliding_modes")}
    assert ours <= {"fem", "meshes", "meshes.build_shoe"} | studies
    assert not public_names_by_module(nodes)


@pytest.mark.parametrize("page", PAGES, ids=NAMES)
def test_links_lead_somewhere(page):
    broken = []
    for link in links_of(page):
        parts = urlsplit(link)
        if parts.scheme:
            continue
        target = page if not parts.path else page.parent / unquote(parts.path)
        if not target.exists() or (parts.fragment and parts.fragment not in anchors_of(target)):
            broken.append(link)
    assert not broken


def test_api_reference_tells_units_and_defaults_of_parameters():
    lines: list[str] = []
    conf.tell_parameters(None, "class", "Terrain", Terrain, {}, lines)
    assert "spring_stiffness : float, [N/m]" in lines[lines.index("Parameters") :]
    assert not [line for line in lines if "Undefined" in line or "FieldInfo" in line]


def test_every_page_is_in_the_site():
    handbook = (ROOT / "docs" / "README.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```{toctree}(.*?)```", handbook, re.DOTALL)
    listed = {name for block in blocks for name in block.split()}
    pages = {Path(os.path.relpath(page, ROOT / "docs")).with_suffix("").as_posix() for page in PAGES}
    assert pages - {"README"} <= listed


def test_messages_of_the_troubleshooting_page_are_those_of_the_code():
    modules = rooms.modules().items()
    code = [rooms.tree(path) for name, path in modules if name.startswith(("exudyn_crawler", "fem"))]
    constants = [node.value for tree in code for node in ast.walk(tree) if isinstance(node, ast.Constant)]
    told = {one for one in constants if isinstance(one, str)}
    rows = re.findall(r"^\| (.*?) \|", (ROOT / "docs/troubleshooting.md").read_text(), re.MULTILINE)
    quoted = [message for row in rows for message in re.findall(r'"([^"]+)"', row)]
    assert len(quoted) > 10
    for message in quoted:
        for part in filter(None, map(str.strip, message.split("..."))):
            assert any(part in one for one in told), message

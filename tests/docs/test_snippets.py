"""What the documentation shows runs, prints what it says, and points at what exists."""

import contextlib
import io
import re
from pathlib import Path

import pytest

from stillreach.errors import MissingExtraError, PageNotBuiltError
from tests.docs.pages import PAGES, ROOT, Block, blocks, name

LINK = re.compile(r"\]\(([^()\s]+)\)")
HEADING = re.compile(r"^#+ (.+)$", re.MULTILINE)
WITH_CODE = [page for page in PAGES if blocks(page.read_text(encoding="utf-8"), "python")]


def run_blocks(found: list[Block], file: str) -> None:
    """Runs the blocks of a page in one namespace; what one prints must be the output shown after it."""
    namespace = {"__name__": "__main__"}
    for block in found:
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(compile("\n" * (block.line - 1) + block.code, file, "exec"), namespace)
        assert printed.getvalue() == (block.output or ""), f"{file}:{block.line}"


def anchors(text: str) -> set[str]:
    """The names that headings get as targets of links."""
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in HEADING.findall(text)}


def broken_links(text: str, folder: Path) -> list[str]:
    """The links to files or headings that are not there."""
    broken = []
    for target in LINK.findall(re.sub(r"^```.*?^```$|`[^`\n]*`", "", text, flags=re.MULTILINE | re.DOTALL)):
        path, _, anchor = target.partition("#")
        if "://" in target:
            continue
        file = folder / path
        page = file.read_text(encoding="utf-8") if path and anchor and file.exists() else text
        if (path and not file.exists()) or (anchor and anchor not in anchors(page)):
            broken.append(target)
    return broken


@pytest.mark.parametrize("page", WITH_CODE, ids=name)
def test_the_code_of_a_page_runs(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    try:
        run_blocks(blocks(page.read_text(encoding="utf-8"), "python"), str(page))
    except (MissingExtraError, PageNotBuiltError) as missing:
        pytest.skip(str(missing))


def test_readme_and_every_guide_to_python_have_code() -> None:
    guides = ("conventions", "laws", "controller", "paper", "interoperation", "robots")
    expected = {"README.md", *(f"docs/{page}.md" for page in guides)}
    assert expected <= {name(page) for page in WITH_CODE}


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_links_lead_somewhere(page: Path) -> None:
    assert broken_links(page.read_text(encoding="utf-8"), page.parent) == []


@pytest.mark.parametrize(
    ("page", "error"),
    [
        ("```python\nassert 1 == 2\n```\n", AssertionError),
        ("```python\nx = 1\n```\n\n```python\nprint(x)\n```\n\n```text\n2\n```\n", AssertionError),
        ("```python\nprint('not shown')\n```\n", AssertionError),
        ("```python\nimport stillreach as sr\nsr.no_such_name\n```\n", AttributeError),
    ],
)
def test_code_that_fails_is_seen(page: str, error: type[Exception]) -> None:
    with pytest.raises(error):
        run_blocks(blocks(page, "python"), "page")


def test_output_that_is_right_passes() -> None:
    run_blocks(blocks("```python\nx = 1\nprint(x)\n```\n\n```text\n1\n```\n", "python"), "page")


def test_a_broken_link_is_seen() -> None:
    text = "# One heading\n[a](README.md) [b](nowhere.md) [c](#one-heading) [d](#two) [e](README.md#nothing-like-it)"
    assert broken_links(text, ROOT) == ["nowhere.md", "#two", "README.md#nothing-like-it"]

"""Text between markers of a page."""

from pathlib import Path


def put(path: Path, name: str, text: str) -> None:
    """Puts the text between the lines ``<!-- name -->`` and ``<!-- /name -->``.

    Raises:
        ValueError: the file does not have each of them once, in this order.
    """
    page, begin, end = path.read_text(encoding="utf-8"), f"<!-- {name} -->", f"<!-- /{name} -->"
    if page.count(begin) != 1 or page.count(end) != 1 or page.index(begin) > page.index(end):
        raise ValueError(f"{path}: expected one line {begin} and, after it, one line {end}")
    before, rest = page.split(begin)
    path.write_text(f"{before}{begin}\n{text}\n{end}{rest.split(end)[1]}", encoding="utf-8")

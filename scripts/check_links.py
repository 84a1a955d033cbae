"""Checks that every relative link and anchor of a built site leads somewhere; `make docs` runs it. No network."""

import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

LINKS = {"href", "src", "poster", "data"}


class Page(HTMLParser):
    """The links of one page, with their lines, and the anchors in it."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.links: list[tuple[int, str]] = []
        self.anchors = {"", "top"}
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Collects what leads elsewhere, and what a link may lead to."""
        for name, value in attrs:
            if value is None:
                continue
            if name == "id" or (name == "name" and tag == "a"):
                self.anchors.add(value)
            if name in LINKS:
                self.links.append((self.getpos()[0], value))


def broken_links(site: Path) -> list[str]:
    """What leads nowhere, a line each; links with a scheme or a host are not followed."""
    site = site.resolve()
    pages = {path: Page(path.read_text(encoding="utf-8")) for path in sorted(site.rglob("*.html"))}
    broken = []
    for path, page in pages.items():
        for line, link in page.links:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            target = target / "index.html" if target.is_dir() else target
            where = f"{path.relative_to(site)}:{line}: {link}"
            if not target.is_relative_to(site):
                broken.append(f"{where} leads out of the site")
            elif not target.exists():
                broken.append(f"{where}: no such file")
            elif target in pages and unquote(parts.fragment) not in pages[target].anchors:
                broken.append(f"{where}: no such anchor")
    return broken


def main(folder: str) -> int:
    """Prints what is broken; 1 where anything is."""
    site = Path(folder)
    pages = len(list(site.rglob("*.html")))
    if pages == 0:
        print(f"no site in {site}: `make docs` builds it", file=sys.stderr)
        return 1
    broken = broken_links(site)
    print("\n".join([*broken, f"{pages} pages, {len(broken)} broken links"]))
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))

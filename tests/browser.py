"""A browser for tests: Playwright's own, or the system's."""

import shutil

import pytest

SOFTWARE = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"]
"""WebGL without a graphics card."""


def chromium(library):
    """Chromium; without one the test is skipped."""
    for path in (None, shutil.which("chromium")):
        try:
            return library.chromium.launch(executable_path=path, args=SOFTWARE)
        except Exception as error:
            if "Executable doesn't exist" not in str(error):
                raise
    pytest.skip("no Chromium: apt-get install chromium, or playwright install chromium")

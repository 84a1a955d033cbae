"""Films the live page: an arm draws an eight, loses three joints, and goes on. Needs playwright, Chromium and Pillow.

Argument: the picture, by default docs/images/live.webp.
"""

import io
import shutil
import sys
import tempfile
from pathlib import Path

from PIL import Image
from playwright.sync_api import sync_playwright

import stillreach as sr

SOFTWARE = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"]
BREAKS = {12: 3, 26: 6, 40: 1}
"""The joint that breaks at a frame."""
FRAMES, SHOWN = 56, 0.16
"""Frames, and the time between two [s]."""


def main(path: Path) -> None:
    arm = sr.arms.nasa_modular()
    page = arm.page()
    frames = []
    with sync_playwright() as library, tempfile.TemporaryDirectory() as folder:
        page.save(Path(folder) / "arm.html")
        browser = library.chromium.launch(executable_path=shutil.which("chromium"), args=SOFTWARE)
        tab = browser.new_page(viewport={"width": 1000, "height": 640}, color_scheme="light")
        tab.on("console", lambda message: print(message.text))
        tab.goto((Path(folder) / "arm.html").as_uri())
        tab.evaluate("() => stillreach.ready.then(() => stillreach.viewer.setMotion('eight'))")
        tab.evaluate("() => { stillreach.viewer.timeInput.value = 5; stillreach.viewer.setMotion('eight'); }")
        tab.wait_for_function("() => stillreach.viewer.latest?.time > 0.2")
        tab.evaluate("() => stillreach.viewer.run(false)")
        for frame in range(FRAMES):
            if frame in BREAKS:
                tab.locator("button.joint").nth(BREAKS[frame]).click()
            ticks = round(SHOWN / 0.005)
            goal = tab.evaluate("() => stillreach.viewer.latest.tick") + ticks
            tab.evaluate(f"() => stillreach.viewer.step({ticks})")
            tab.wait_for_function(f"() => stillreach.viewer.latest.tick >= {goal}")
            tab.wait_for_timeout(120)
            frames.append(Image.open(io.BytesIO(tab.screenshot())).convert("RGB"))
        browser.close()
    first, *others = frames
    options = {"save_all": True, "append_images": others, "duration": round(1000 * SHOWN), "loop": 0}
    first.save(path, format="WEBP", quality=40, method=4, **options)
    print(f"{path}: {path.stat().st_size / 1e6:.2f} MB, {len(frames)} frames")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "docs/images/live.webp"))

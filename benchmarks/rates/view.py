"""The page of `dualcam view`: how fast it opens, and how many pictures a second it draws.

Headless Chromium opens the page of the default mechanism from disk and plays the first scene, with WebGL in
software (no GPU) and without WebGL. `script` is the time of the page's own JavaScript for one picture: a
machine with a GPU draws 60 pictures a second while this time is below 16.7 ms.
"""

from __future__ import annotations

import shutil
import statistics
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from rich.console import Console

from benchmarks.rates.measure import Group, Measure
from dualcam import write_view

SIZE = {"width": 1400, "height": 900}  # pixels of the window
PLAYED = 3.0  # s of real time
CONFIGURATIONS = {
    "WebGL in software": ["--disable-gpu", "--enable-unsafe-swiftshader"],
    "without WebGL": ["--disable-gpu", "--disable-3d-apis"],
}
# Notes the duration of each callback of requestAnimationFrame, ms, and how many there are.
WATCH = """
const ask = window.requestAnimationFrame.bind(window);
window.noted = [];
window.requestAnimationFrame = callback => ask(time => {
  const begin = performance.now();
  callback(time);
  window.noted.push(performance.now() - begin);
});
"""


def play(browser: Any, page: Path) -> dict[str, float]:  # noqa: ANN401
    """Seconds of one opening, until a script may step and the first picture stands, and of one picture."""
    context = browser.new_context(viewport=SIZE)
    tab = context.new_page()
    tab.add_init_script(WATCH)
    begin = time.perf_counter()
    tab.goto(page.as_uri())
    tab.evaluate("dualcam.ready.then(() => new Promise(requestAnimationFrame))")
    opened = time.perf_counter() - begin
    tab.locator("#presets button").first.click()
    tab.wait_for_timeout(1000)  # the page finds its quality
    tab.evaluate("noted.length = 0")
    begin = time.perf_counter()
    tab.wait_for_timeout(1000 * PLAYED)
    noted = tab.evaluate("noted")
    passed = time.perf_counter() - begin
    context.close()
    script = 1e-3 * statistics.median(noted)
    return {"opens": opened, "one picture": passed / len(noted), "script of a picture": script}


def take(rounds: int, _console: Console) -> Iterator[Group]:
    from playwright.sync_api import sync_playwright

    program = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        page = write_view(None, Path(folder) / "cam.html")
        for name, options in CONFIGURATIONS.items():
            browser = playwright.chromium.launch(executable_path=program, args=["--no-sandbox", *options])
            runs = [play(browser, page) for _ in range(rounds)]
            what = f"{name}, Chromium {browser.version}"
            browser.close()
            yield Group(what, {key: [run[key] for run in runs] for key in runs[0]})


MEASURE = Measure("view", "The page of dualcam view", take, 5)

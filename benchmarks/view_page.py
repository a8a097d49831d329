"""The page of `dualcam view`: how fast it opens, and how many pictures a second it draws.

    ./build.sh view

Headless Chromium opens the page of the default mechanism from disk and plays the first scene, with WebGL in
software (no GPU) and without WebGL. `script` is the time of the page's own JavaScript for one picture: a
machine with a GPU draws 60 pictures a second while this time is below 16.7 ms. Times are medians over the
rounds.
"""

from __future__ import annotations

import shutil
import statistics
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from benchmarks.harness import results as harness
from benchmarks.harness.circumstances import circumstances
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
    """One opening: seconds until a script may step and the first picture stands; then the pictures."""
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
    return {
        "open": opened,
        "pictures": len(noted) / passed,
        "script": statistics.median(noted),
    }


def main() -> int:
    arguments = harness.options(__doc__, "view_page", 5).parse_args()
    console = harness.new_console()
    from playwright.sync_api import sync_playwright

    program = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if program is None:
        harness.say(console, "view_page: Chromium is not installed: install the package chromium")
        return 1
    columns = ("browser", "opens [s]", "pictures per s", "script [ms]", "size [MB]")
    table = harness.table("The page of dualcam view", *columns)
    rows = []
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        page = write_view(None, Path(folder) / "cam.html")
        size = page.stat().st_size / 1e6
        for name, options in CONFIGURATIONS.items():
            browser = playwright.chromium.launch(executable_path=program, args=["--no-sandbox", *options])
            runs = [play(browser, page) for _ in range(arguments.rounds)]
            version = browser.version
            browser.close()
            opened, pictures, script = (
                statistics.median(run[key] for run in runs) for key in ("open", "pictures", "script")
            )
            table.add_row(name, f"{opened:.2f}", f"{pictures:.0f}", f"{script:.1f}", f"{size:.2f}")
            rows.append(
                {"browser": f"{name}, Chromium {version}", "open_s": f"{opened:.3f}"}
                | {
                    "pictures_per_s": f"{pictures:.1f}",
                    "script_ms": f"{script:.2f}",
                    "size_MB": f"{size:.3f}",
                }
            )
    console.print(table)
    harness.publish(rows, circumstances("view"), arguments.output, console)
    return 0


if __name__ == "__main__":
    sys.exit(main())

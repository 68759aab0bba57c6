"""A browser shows the page of a run, with its ensemble in three dimensions, at three widths, light and dark.

PYTHONPATH=build/package python tests/long_report_page.py [--pictures FOLDER]

It needs Chromium and the package playwright, and takes minutes where the browser draws without a graphics card.
"""

import argparse
import shutil
import tempfile
from pathlib import Path

from openmmchaintree.command.cli import main as command
from playwright.sync_api import sync_playwright

_WIDTHS = (400, 900, 1600)  # pixels
_PATIENCE = 300000  # ms


def check(page, folder):
    """Open the page in each way; save pictures in a folder, if given."""
    browser = shutil.which("chromium") or shutil.which("google-chrome")
    arguments = ["--no-sandbox", "--enable-unsafe-swiftshader"]
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=browser, args=arguments)
        for width in _WIDTHS:
            for scheme in ("light", "dark"):
                tab = chromium.new_page(viewport={"width": width, "height": 1200}, color_scheme=scheme, offline=True)
                errors = []
                tab.on("pageerror", lambda error, errors=errors: errors.append(error))
                tab.goto(page.as_uri())
                tab.wait_for_selector("body[data-viewer=shown] canvas", timeout=_PATIENCE)
                assert not errors, errors
                assert tab.evaluate("document.documentElement.scrollWidth") <= width, "wider than the window"
                if folder:
                    tab.screenshot(path=folder / f"{width}-{scheme}.png", full_page=True, timeout=_PATIENCE)
                tab.close()


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--pictures", type=Path, metavar="FOLDER")
    folder = parser.parse_args().pictures
    with tempfile.TemporaryDirectory() as temporary:
        prefix = str(Path(temporary, "run"))
        run = ["sample", "--trials", "20000", "--frames", "100", "--seed", "1", "-o", prefix]
        force = ["--forcefield", "amber14-all.xml", "implicit/gbn2.xml"]
        assert command([*run, *force, "--report", f"{prefix}.html"]) == 0
        check(Path(f"{prefix}.html"), folder)
    print("the page is shown")


if __name__ == "__main__":
    main()

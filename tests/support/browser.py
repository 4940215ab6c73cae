"""A headless browser for tests of pages: Chromium of the machine, driven by playwright."""

import contextlib
import shutil

import pytest

PROGRAMS = ("chromium", "chromium-browser", "google-chrome", "chrome")
# Drawn by the processor: machines of tests have no graphics hardware.
OPTIONS = (
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
)


@contextlib.contextmanager
def running():
    """A browser; skips the test where there is none."""
    sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    program = next(filter(None, map(shutil.which, PROGRAMS)), None)
    if program is None:
        pytest.skip(f"no browser is installed ({', '.join(PROGRAMS)})")
    with sync_api.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=program, args=list(OPTIONS))
        yield browser
        browser.close()


@contextlib.contextmanager
def opened(browser, path, width=760, height=520):
    """The page of a file, and the list of its errors."""
    page = browser.new_page(viewport={"width": width, "height": height})
    errors = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.on(
        "console",
        lambda said: errors.append(said.text) if said.type in ("error", "warning") else None,
    )
    page.on("request", lambda sent: _refuse_network(sent, errors))
    page.goto(path.as_uri())
    page.wait_for_function("window.attitudeViewer && attitudeViewer.frames.count > 1")
    yield page, errors
    page.close()


def _refuse_network(sent, errors):
    if not sent.url.startswith(("file:", "data:", "blob:")):
        errors.append(f"the page loads {sent.url}")

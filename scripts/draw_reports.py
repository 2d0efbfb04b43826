#!/usr/bin/env python3
"""Draw the reports of logs as a browser shows them: python scripts/draw_reports.py FOLDER LOG...

One picture a log, named as the log is. It needs Chromium and its driver, as the browser's tests do.
"""

import argparse
import shutil
import tempfile
import time
from pathlib import Path
from typing import Any

import cv2
from selenium import webdriver

from flightstack.logs.cli import main as logs

WIDTH_PX = 1240
PATIENCE_S = 30.0
DRAWN = "return document.querySelectorAll('.figure .main-svg').length"


def open_browser(height_px: int) -> Any:
    """Return a browser without a window that is so high."""
    driver = shutil.which("chromedriver")
    if driver is None:
        raise SystemExit("no chromedriver: install the packages chromium and chromium-driver")
    options = webdriver.ChromeOptions()
    for argument in ("--headless=new", "--no-sandbox", f"--window-size={WIDTH_PX},{height_px}"):
        options.add_argument(argument)
    return webdriver.Chrome(options=options, service=webdriver.ChromeService(driver))


def draw(browser: Any, log: Path, picture: Path, scale: float) -> None:
    """Write the report of a log as a picture."""
    with tempfile.TemporaryDirectory() as folder:
        page = Path(folder) / "report.html"
        if logs(["report", str(log), "-o", str(page)]):
            raise SystemExit(f"{log} has no report")
        browser.get(page.as_uri())
        deadline_s = time.monotonic() + PATIENCE_S
        while browser.execute_script(DRAWN) < 2 and time.monotonic() < deadline_s:
            time.sleep(0.1)
        whole = Path(folder) / "whole.png"
        browser.save_screenshot(str(whole))
        image = cv2.imread(str(whole))
    if image is None:
        raise SystemExit(f"{log}: the browser took no picture")
    small = cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    cv2.imwrite(str(picture), small)


def main() -> None:
    """Draw one picture a log."""
    parser = argparse.ArgumentParser(description="Draw reports as a browser shows them.")
    parser.add_argument("folder", type=Path)
    parser.add_argument("logs", type=Path, nargs="+", metavar="LOG")
    parser.add_argument("--height", type=int, default=2000, help="of the page, pixels")
    parser.add_argument("--scale", type=float, default=0.5, help="of the picture")
    arguments = parser.parse_args()
    arguments.folder.mkdir(parents=True, exist_ok=True)
    browser = open_browser(arguments.height)
    try:
        for log in arguments.logs:
            draw(browser, log, arguments.folder / f"{log.stem}.png", arguments.scale)
    finally:
        browser.quit()


if __name__ == "__main__":
    main()

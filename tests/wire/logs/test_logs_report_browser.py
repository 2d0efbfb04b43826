"""The report in a real browser: it draws, zooms and hovers, without an error or a network."""

import json
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from flightstack.logs.cli import main
from tests.paths import GOLDEN
from tests.unit.flightstack.logs.made_flights import make_flight

webdriver = pytest.importorskip("selenium.webdriver")
support = pytest.importorskip("selenium.webdriver.support.ui")
pytest.importorskip("plotly")

PATIENCE_S = 60.0
DRAWN = "return document.querySelectorAll('.figure .main-svg').length"
RANGE = "return document.getElementById('figure-%s').layout.xaxis.range.slice()"


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    driver = shutil.which("chromedriver")
    if driver is None:
        pytest.skip("no chromedriver: install the Debian packages chromium and chromium-driver")
    options = webdriver.ChromeOptions()
    for argument in ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage"):
        options.add_argument(argument)
    options.add_argument("--window-size=1280,1000")
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    service = webdriver.ChromeService(driver)
    running = webdriver.Chrome(options=options, service=service)
    running.set_script_timeout(PATIENCE_S)
    yield running
    running.quit()


@pytest.fixture(params=["made", "golden"])
def page(request: pytest.FixtureRequest, browser: Any, tmp_path: Path) -> Any:
    log, report = tmp_path / "flight.tlog", tmp_path / "report.html"
    log.write_bytes(make_flight(20.0) if request.param == "made" else GOLDEN.read_bytes())
    assert main(["report", str(log), "-o", str(report)]) == 0
    browser.get(report.as_uri())
    wait = support.WebDriverWait(browser, PATIENCE_S)
    wait.until(lambda driver: driver.execute_script(DRAWN) >= 4)
    return browser


def drag(page: Any, name: str) -> None:
    """Drag over a part of a figure's plot, as a person zooms."""
    area = page.find_element("css selector", f"#figure-{name} .nsewdrag")
    page.execute_script("arguments[0].scrollIntoView({block: 'center'})", area)
    actions = webdriver.ActionChains(page)
    actions.move_to_element_with_offset(area, -80, -20).click_and_hold()
    actions.move_by_offset(90, 30).move_by_offset(90, 30).release().perform()


def errors(page: Any) -> list[str]:
    return [entry["message"] for entry in page.get_log("browser") if entry["level"] == "SEVERE"]


def requests(page: Any) -> list[str]:
    """Return the addresses that the page asked for, over any network."""
    entries = [json.loads(entry["message"])["message"] for entry in page.get_log("performance")]
    sent = [e for e in entries if e["method"] == "Network.requestWillBeSent"]
    addresses = [e["params"]["request"]["url"] for e in sent]
    return [a for a in addresses if a.startswith(("http", "ws"))]


def test_draws_and_zooms_without_an_error(page: Any) -> None:
    paths = page.execute_script("return document.querySelectorAll('#figure-time .js-line').length")
    assert paths >= 10
    wait = support.WebDriverWait(page, PATIENCE_S)
    for name in ("course", "time"):
        before = page.execute_script(RANGE % name)
        drag(page, name)
        wait.until(lambda driver, name=name, b=before: driver.execute_script(RANGE % name) != b)
        after = page.execute_script(RANGE % name)
        assert after[1] - after[0] < before[1] - before[0]
    assert errors(page) == []
    assert requests(page) == []


def test_hovering_with_the_mouse_shows_values(page: Any) -> None:
    area = page.find_elements("css selector", "#figure-time .nsewdrag")[1]
    page.execute_script("arguments[0].scrollIntoView({block: 'center'})", area)
    wait = support.WebDriverWait(page, PATIENCE_S)

    def shows(driver: Any) -> bool:
        for offset in (-30, 0, 30, 60):
            actions = webdriver.ActionChains(driver)
            actions.move_to_element_with_offset(area, offset, 0).pause(0.2).perform()
            if driver.find_elements("css selector", "#figure-time .hoverlayer .hovertext"):
                return True
        return False

    wait.until(shows)
    assert errors(page) == []


def test_the_page_says_what_happened(page: Any) -> None:
    text = page.find_element("tag name", "body").text
    assert "Why did it miss?" in text
    assert "Missed gate" in text
    assert page.find_elements("css selector", ".verdict.error")
    assert len(page.find_elements("css selector", ".moment svg.dots")) == 8
    assert page.execute_script("return document.documentElement.scrollWidth") <= 1280

#!/usr/bin/env python3
"""Opens a page that `ondine compare --html` or `ondine bench --html` wrote in Chromium, and uses it.

    check_report.py REPORT.html [PICTURE.png] [--width N] [--dark] [--view KEY]

The page says nothing wrong in the console and asks the network for nothing; on a telephone nothing is wider than the screen. Of a comparison
the verdict stands first; the flip key, the button and each view change what is shown; zoom and exposure too. Of a benchmark every plot and table
has something in it. Prints one line and exits 0, or
1 with what is wrong. With a second name, takes a picture of the page instead. Needs the package selenium, Chromium and its driver.
"""

import argparse
import hashlib
import json
import pathlib
import shutil
import sys

from selenium import webdriver
from selenium.common.exceptions import WebDriverException
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.support.ui import WebDriverWait


def browser():
    options = webdriver.ChromeOptions()
    options.binary_location = shutil.which("chromium") or shutil.which("google-chrome") or ""
    # CI runs as root, where Chromium has no sandbox.
    for flag in ["--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--force-color-profile=srgb"]:
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    driver = shutil.which("chromedriver")
    return webdriver.Chrome(options=options, service=webdriver.ChromeService(executable_path=driver))


def expect(truth, message):
    if not truth:
        raise ValueError(message)


class Page:
    def __init__(self, driver, path, width, dark):
        self.driver = driver
        self.metrics(width, 900)
        scheme = [{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}]
        driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": scheme})
        driver.get(path.resolve().as_uri())
        # A page with a script says when it is ready; one without is once it is loaded.
        ready = "return document.scripts.length === 0 || 'ready' in document.documentElement.dataset"
        WebDriverWait(driver, 30).until(lambda d: d.execute_script(ready))

    def metrics(self, width, height):
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)

    def shown(self):
        """A hash of what the canvas shows."""
        url = self.driver.execute_script("return document.getElementById('canvas').toDataURL()")
        return hashlib.sha256(url.encode()).hexdigest()

    def text(self, selector):
        return self.driver.find_element(By.CSS_SELECTOR, selector).text

    def press(self, key):
        ActionChains(self.driver).send_keys(key).perform()

    def click(self, identity):
        self.driver.find_element(By.ID, identity).click()

    def changes(self, what, act):
        before = self.shown()
        act()
        expect(self.shown() != before, f"{what} does not change what is shown")


def read(page):
    """A benchmark's page: no script, but plots and tables."""
    expect(page.text("h1").startswith(("Score ", "No score")), "no score, and no word of there being none")
    sizes = page.driver.execute_script("""
        return [...document.querySelectorAll('.plot svg')].map(plot => {
            const marks = [...plot.querySelectorAll('circle, rect[fill], polyline')].map(mark => mark.getBoundingClientRect());
            return marks.filter(mark => mark.width > 1 || mark.height > 1).length;
        })""")
    expect(len(sizes) >= 5 and min(sizes) > 3, f"marks in the plots: {sizes}")
    for table in page.driver.find_elements(By.CSS_SELECTOR, "main table"):
        cells = [cell.text for cell in table.find_elements(By.CSS_SELECTOR, "tbody td")]
        expect(cells and not any("NaN" in cell or "inf" in cell for cell in cells), f"a table has the cells {cells}")


def use(page):
    expect(page.text("h1") in ("Biased", "Consistent", "Bit-equal"), "no verdict")
    equal = page.text("h1") == "Bit-equal"
    expect(page.text("#badge") == "Reference", "the reference is not shown first")
    first = page.shown()
    page.press("f")
    expect(page.text("#badge") == "Test", "the flip key does not show the test image")
    expect((page.shown() != first) != equal, "the flip key does not show other pixels")
    page.click("flip")
    expect(page.text("#badge") == "Reference" and page.shown() == first, "the flip button does not bring the reference back")
    views = page.driver.find_elements(By.CSS_SELECTOR, ".views input")
    for number in range(3, len(views) + 1):
        page.changes(f"view {number}", lambda: page.press(str(number)))
    page.press("1")
    page.changes("zoom", lambda: page.press("+"))
    page.press("0")
    expect(page.shown() == first, "fit does not bring the whole image back")
    page.changes("exposure", lambda: page.press("["))
    page.press("]")
    expect(page.shown() == first, "exposure does not come back")
    canvas = page.driver.find_element(By.ID, "canvas")
    ActionChains(page.driver).move_to_element(canvas).perform()
    expect("reference ≈" in page.text("#readout"), "no values under the cursor")
    expect(page.driver.find_elements(By.CSS_SELECTOR, "#histogram rect"), "no histogram")


def narrow(page):
    """A telephone: tables scroll in their frames, and nothing else is wider than the screen."""
    page.metrics(360, 740)
    wide = page.driver.execute_script("return document.documentElement.scrollWidth")
    expect(wide <= 360, f"at 360 pixels the page is {wide} wide")


def complaints(driver):
    """What the console says, and what was asked of the network."""
    for entry in driver.get_log("browser"):
        yield entry["message"]
    for entry in driver.get_log("performance"):
        message = json.loads(entry["message"])["message"]
        if message["method"] == "Network.requestWillBeSent":
            url = message["params"]["request"]["url"]
            if not url.startswith(("file:", "data:")):
                yield f"the page asks for {url}"


def main():
    arguments = argparse.ArgumentParser(description="Opens a page of `ondine compare --html` or `ondine bench --html` in Chromium, and uses it.")
    arguments.add_argument("page", type=pathlib.Path)
    arguments.add_argument("picture", type=pathlib.Path, nargs="?", help="where to put a picture of the page")
    arguments.add_argument("--width", type=int, default=1280)
    arguments.add_argument("--dark", action="store_true")
    arguments.add_argument("--view", default="1", help="the key of the view in the picture")
    given = arguments.parse_args()
    driver = browser()
    try:
        page = Page(driver, given.page, given.width, given.dark)
        if given.picture:
            if driver.find_elements(By.ID, "viewer"):
                page.press(given.view)
            height = driver.execute_script("return document.documentElement.scrollHeight")
            page.metrics(given.width, height)
            driver.save_screenshot(str(given.picture))
        else:
            is_benchmark = not driver.find_elements(By.ID, "viewer")
            (read if is_benchmark else use)(page)
            narrow(page)
        wrong = list(complaints(driver))
        expect(not wrong, "; ".join(wrong))
    finally:
        driver.quit()
    print(f"{given.page}: opened and used in {driver.capabilities['browserName']} {driver.capabilities['browserVersion']}")


if __name__ == "__main__":
    try:
        main()
    except (ValueError, WebDriverException) as error:
        sys.exit(f"FAILED: {str(error).strip() or type(error).__name__}")

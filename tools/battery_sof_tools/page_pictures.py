"""Pictures of a diagnosis page for docs/reading-a-diagnosis.md, by headless Chromium: page_pictures PAGE.html FOLDER"""

import base64
import os
import sys
import tempfile

WIDTH = 1100
# file: selector whose lowest end is the picture's, and whether it begins at the top of the page
PICTURES = {"diagnosis_page.png": ("#drive .dygraph-rangesel-fgcanvas", True), "diagnosis_regimes.png": ("#where", False), "diagnosis_weighed.png": ("#evidence", False),
            "diagnosis_discrepancy.png": ("#unexplained", False), "diagnosis_before_after.png": ("#comparison", False)}


def browser(profile):
    """One whose pages are WIDTH wide; ends with its block. SystemExit where there is none."""
    try:
        from selenium import webdriver
        from selenium.webdriver.chrome.service import Service
    except ImportError:
        raise SystemExit("page_pictures: python3-selenium is missing (package python3-selenium)") from None
    options = webdriver.ChromeOptions()
    options.binary_location = "/usr/bin/chromium"
    for argument in ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--disable-gpu", "--hide-scrollbars", "--no-first-run", "--user-data-dir=" + profile):
        options.add_argument(argument)
    driver = webdriver.Chrome(service=Service("/usr/bin/chromedriver"), options=options)
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {"width": WIDTH, "height": 900, "deviceScaleFactor": 1, "mobile": False})
    return driver


def shoot(driver, top, bottom, path):
    clip = {"x": 0, "y": top, "width": WIDTH, "height": bottom - top + 8, "scale": 1}
    image = driver.execute_cdp_cmd("Page.captureScreenshot", {"captureBeyondViewport": True, "clip": clip})
    with open(path, "wb") as file:
        file.write(base64.b64decode(image["data"]))


def main():
    if len(sys.argv) != 3:
        print(__doc__, file=sys.stderr)
        return 2
    page, folder = sys.argv[1:]
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile, browser(profile) as driver:
        driver.get("file://" + os.path.abspath(page))
        for name, (selector, whole) in PICTURES.items():
            boxes = driver.execute_script("return [...document.querySelectorAll(arguments[0])].map((one) => one.getBoundingClientRect()).map((box) => [box.top + scrollY, box.bottom + scrollY])", selector)
            if not boxes:
                raise SystemExit(f"page_pictures: {page} has no {selector}")
            top, bottom = 0 if whole else boxes[0][0], max(box[1] for box in boxes)
            shoot(driver, top, bottom, os.path.join(folder, name))
    return 0

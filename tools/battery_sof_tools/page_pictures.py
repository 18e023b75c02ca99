"""Pictures of a diagnosis page, by headless Chromium.

    page_pictures PAGE.html FOLDER             those of docs/reading-a-diagnosis.md, diagnosis_*.png
    page_pictures PAGE.html FOLDER worked      those of docs/worked-diagnosis.md, worked_*.png

Each picture has the summary of its diagnosis as the text "Description" (summary_of()), by which a test compares it with its page.
"""

import base64
import io
import os
import sys
import tempfile

from PIL import Image, PngImagePlugin

WIDTH = 1100
# file: selector whose lowest end is the picture's, and whether it begins at the top of the page
PICTURES = {"diagnosis_page.png": ("#drive .dygraph-rangesel-fgcanvas", True), "diagnosis_regimes.png": ("#where", False), "diagnosis_weighed.png": ("#evidence", False),
            "diagnosis_discrepancy.png": ("#unexplained", False), "diagnosis_before_after.png": ("#comparison", False)}
WORKED = ("diagnosis_page.png", "diagnosis_weighed.png", "diagnosis_before_after.png")  # worked_*.png
DESCRIPTION = "Description"


def shoot(driver, clip, path, summary):
    """A part of the page as a PNG file with a text."""
    image = driver.execute_cdp_cmd("Page.captureScreenshot", {"captureBeyondViewport": True, "clip": {"x": 0, "width": WIDTH, "scale": 1, **clip}})
    text = PngImagePlugin.PngInfo()
    text.add_text(DESCRIPTION, summary)
    Image.open(io.BytesIO(base64.b64decode(image["data"]))).save(path, pnginfo=text)


def summary_of(path):
    """The text of a PNG file; empty without one."""
    with Image.open(path) as image:
        return image.info.get(DESCRIPTION, "")


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


def main():
    if len(sys.argv) not in (3, 4) or sys.argv[3:] not in ([], ["worked"]):
        print(__doc__, file=sys.stderr)
        return 2
    page, folder, *worked = sys.argv[1:]
    wanted = {name: PICTURES[name] for name in (WORKED if worked else PICTURES)}
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile, browser(profile) as driver:
        driver.get("file://" + os.path.abspath(page))
        summary = driver.execute_script("return document.querySelector('h1').textContent.trim()")
        for name, (selector, whole) in wanted.items():
            boxes = driver.execute_script("return [...document.querySelectorAll(arguments[0])].map((one) => one.getBoundingClientRect()).map((box) => [box.top + scrollY, box.bottom + scrollY])", selector)
            if not boxes:
                raise SystemExit(f"page_pictures: {page} has no {selector}")
            top, bottom = 0 if whole else boxes[0][0], max(box[1] for box in boxes)
            shoot(driver, {"y": top, "height": bottom - top + 8}, os.path.join(folder, name.replace("diagnosis", "worked") if worked else name), summary)
    return 0

#!/usr/bin/env python3
"""Opens the diagnosis page in headless Chromium: what is drawn, whether zoom works, what it looks like.

Usage: browser_test.py MADE_PAGES FOLDER; MADE_PAGES writes the pages into FOLDER, screenshots go there too.
Exit 77 (skipped) only where Chromium cannot be had.
"""
import base64
import os
import shutil
import subprocess
import sys
import tempfile
import unittest

SKIPPED = 77
NOETIC = os.path.isdir('/opt/ros/noetic')  # Ubuntu 20.04: Chromium is a snap there, and dygraphs is not packaged


def skip_or_fail(reason):
    print(('SKIPPED: ' if NOETIC else 'FAILED: ') + reason, flush=True)
    sys.exit(SKIPPED if NOETIC else 1)


try:
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service
    from selenium.webdriver.common.action_chains import ActionChains
except ImportError:
    skip_or_fail('python3-selenium is not installed')


def tool(name):
    return shutil.which(name, path='/usr/bin:/usr/local/bin') or skip_or_fail(name + ' is not installed')


class DiagnosisPage(unittest.TestCase):
    folder = None
    made_pages = None

    @classmethod
    def setUpClass(cls):
        subprocess.run([cls.made_pages, cls.folder], check=True)
        cls.profile = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        options = webdriver.ChromeOptions()
        options.binary_location = tool('chromium')
        for argument in ('--headless=new', '--no-sandbox', '--disable-dev-shm-usage', '--disable-gpu', '--hide-scrollbars',
                         '--no-first-run', '--user-data-dir=' + cls.profile.name):
            options.add_argument(argument)
        options.set_capability('goog:loggingPrefs', {'browser': 'ALL'})
        cls.driver = webdriver.Chrome(service=Service(tool('chromedriver')), options=options)

    @classmethod
    def tearDownClass(cls):
        cls.driver.quit()
        cls.profile.cleanup()

    def open(self, name, width=1400, height=900, dark=False):
        self.driver.execute_cdp_cmd('Emulation.setDeviceMetricsOverride', {
            'width': width, 'height': height, 'deviceScaleFactor': 1, 'mobile': False})
        self.driver.execute_cdp_cmd('Emulation.setEmulatedMedia', {'features': [
            {'name': 'prefers-color-scheme', 'value': 'dark' if dark else 'light'}]})
        self.driver.get('file://' + os.path.join(self.folder, name))

    def run_js(self, script):
        return self.driver.execute_script('return ' + script)

    def severe(self):
        return [entry for entry in self.driver.get_log('browser') if entry['level'] == 'SEVERE']

    def ranges(self):
        return self.run_js('window.diagnosisPlots.map((graph) => graph.xAxisRange())')

    def shot(self, name):
        height = self.run_js('document.documentElement.scrollHeight')
        width = self.run_js('window.innerWidth')
        image = self.driver.execute_cdp_cmd('Page.captureScreenshot', {
            'captureBeyondViewport': True, 'clip': {'x': 0, 'y': 0, 'width': width, 'height': height, 'scale': 1}})
        with open(os.path.join(self.folder, name), 'wb') as file:
            file.write(base64.b64decode(image['data']))

    def drag(self, plot, start, end):
        surface = self.run_js('window.diagnosisPlots[%d].canvas_' % plot)
        self.run_js('window.diagnosisPlots[%d].graphDiv.scrollIntoView({block: "center"})' % plot)
        box = surface.rect
        ActionChains(self.driver, duration=50).move_to_element(surface).move_by_offset(
            (start - 0.5) * box['width'], 0).click_and_hold().move_by_offset(
            (end - start) * box['width'], 3).release().perform()

    def double_click(self, plot):
        ActionChains(self.driver).double_click(self.run_js('window.diagnosisPlots[%d].canvas_' % plot)).perform()

    def wait_for(self, condition):
        self.assertTrue(self.driver.execute_async_script(
            'const done = arguments[0], end = Date.now() + 3000;'
            '(function look() { if (%s) done(true); else if (Date.now() > end) done(false); else setTimeout(look, 20); })()'
            % condition), condition)

    def test_every_page_loads_without_a_word_on_the_console_and_fetches_nothing(self):
        for name in ('named.html', 'no_mismatch.html', 'unknown.html', 'without_library.html'):
            self.open(name)
            self.assertEqual(self.severe(), [], name)
            self.assertEqual(self.run_js('performance.getEntriesByType("resource").length'), 0, name)

    def test_three_plots_are_drawn(self):
        self.open('named.html')
        self.assertEqual(self.run_js('window.diagnosisPlots.length'), 3)
        painted = self.run_js(
            'window.diagnosisPlots.map((graph) => { const canvas = graph.hidden_; return canvas.getContext("2d")'
            '.getImageData(0, 0, canvas.width, canvas.height).data.filter((value, k) => k % 4 === 3 && value > 0).length; })')
        for pixels in painted:
            self.assertGreater(pixels, 1000)

    def test_the_voltage_plot_is_hatched_where_a_source_imposes_the_voltage(self):
        self.open('named.html')
        alpha = ('(() => { const graph = window.diagnosisPlots[%d], area = graph.getArea(), canvas = graph.hidden_;'
                 'const scale = canvas.width / canvas.clientWidth, x = scale * graph.toDomXCoord(%f);'
                 'const data = canvas.getContext("2d").getImageData(x - 3, scale * (area.y + area.h - 3), 6, 1).data;'
                 'return data.filter((value, k) => k %% 4 === 1 && value > 120 && data[k - 1] < 60).length; })()')
        self.assertGreater(self.run_js(alpha % (0, 50.0)), 3)
        self.assertEqual(self.run_js(alpha % (0, 110.0)), 0)
        self.assertEqual(self.run_js(alpha % (2, 50.0)), 0)
        self.assertIn('hatched', self.run_js('document.querySelector("#drive .note").textContent'))
        self.assertRegex(self.run_js('document.querySelector("#controlled .strip").getAttribute("aria-label")'), r'voltage controlled \d')

    def test_a_drag_zooms_every_plot_and_a_double_click_shows_all_again(self):
        self.open('named.html')
        whole = self.ranges()
        for plot in range(3):
            self.drag(plot, 0.3, 0.5)
            zoomed = self.ranges()
            self.assertLess(zoomed[0][1] - zoomed[0][0], 0.4 * (whole[0][1] - whole[0][0]))
            self.assertEqual(zoomed[0], zoomed[1])
            self.assertEqual(zoomed[0], zoomed[2])
            self.double_click(plot)
            self.wait_for('window.diagnosisPlots.every((graph) => !graph.isZoomed())')
            self.assertEqual(self.ranges(), whole)
        self.assertEqual(self.severe(), [])

    def test_buttons_jump_from_stretch_to_stretch(self):
        self.open('named.html')
        whole = self.ranges()[0]
        seen = []
        for name in ('zoom-mismatch', 'zoom-mismatch', 'zoom-crank', 'zoom-crank', 'zoom-holdout'):
            self.run_js('document.getElementById("%s").click()' % name)
            self.assertEqual(self.ranges()[0], self.ranges()[2])
            self.assertNotIn(self.ranges()[0], seen)
            seen.append(self.ranges()[0])
        self.run_js('document.getElementById("zoom-all").click()')
        self.assertEqual(self.ranges()[0], whole)
        self.run_js('document.querySelector("button.show").click()')
        self.assertNotEqual(self.ranges()[0], whole)

    def test_pointing_at_one_plot_tells_the_values_of_all(self):
        self.open('named.html')
        ActionChains(self.driver).move_to_element(self.run_js('window.diagnosisPlots[0].canvas_')).perform()
        for legend in ('plot-voltage', 'plot-error', 'plot-current'):
            self.assertRegex(self.run_js('document.getElementById("%s-legend").textContent' % legend), r'\d s')

    def test_nothing_sticks_out_on_a_phone_or_on_a_desk(self):
        for page in ('named', 'no_mismatch', 'unknown', 'without_library'):
            for width, dark in ((400, True), (1400, False)) + (((400, False), (1400, True)) if page == 'named' else ()):
                self.open(page + '.html', width, dark=dark)
                self.assertLessEqual(self.run_js('document.documentElement.scrollWidth'), width, page)
                self.shot('%s_%d_%s.png' % (page, width, 'dark' if dark else 'light'))


if __name__ == '__main__':
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    DiagnosisPage.made_pages, DiagnosisPage.folder = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2])
    os.makedirs(DiagnosisPage.folder, exist_ok=True)
    tool('chromium')
    tool('chromedriver')
    if NOETIC:
        skip_or_fail('the plot library is no package here')
    unittest.main(argv=sys.argv[:1], verbosity=2)

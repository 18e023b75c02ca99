#!/usr/bin/env python3
"""Two batteries, a bag that plays, and the live page in headless Chromium; and who is not let in.

Usage: live_test.py DEVEL FOLDER; DEVEL is the devel space, screenshots go to FOLDER. To be called in DEVEL's environment (env.sh).
Exit 77 (skipped) only where Chromium cannot be had.
"""
import base64
import os
import subprocess
import time

from live_server import LiveServer, is_closed, main, wait_until
from selenium.webdriver.common.keys import Keys

SCENARIO = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..', 'config', 'scenarios', 'city_drive.yaml')
NODES = ('/front/battery_sof_node', '/rear/battery_sof_node')
PARAMETERS = ('_window_s:=120.0', '_buffer_s:=400.0', '_identify_period_s:=200.0')


class LivePage(LiveServer):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        bag = os.path.join(cls.work.name, 'drive.bag')
        subprocess.check_call([cls.program('sof'), 'simulate', SCENARIO, bag, '--duration', '1200'])
        cls.rosparam('set', '/use_sim_time', 'true')
        for node in NODES:
            cls.begin(cls.program('battery_sof_node'), '__ns:=' + os.path.dirname(node), 'battery_state:=/battery_state', *PARAMETERS)
        cls.serve(NODES)
        cls.begin('rosbag', 'play', '--clock', '--hz', '100', '--quiet', '--wait-for-subscribers', '--rate', '10', bag)
        cls.browse()

    def size(self, width, height=1000, dark=False):
        self.driver.execute_cdp_cmd('Emulation.setDeviceMetricsOverride', {'width': width, 'height': height, 'deviceScaleFactor': 1, 'mobile': False})
        self.driver.execute_cdp_cmd('Emulation.setEmulatedMedia', {'features': [{'name': 'prefers-color-scheme', 'value': 'dark' if dark else 'light'}]})
        time.sleep(0.6)

    def shot(self, name):
        width, height = self.run_js('window.innerWidth'), self.run_js('document.documentElement.scrollHeight')
        image = self.driver.execute_cdp_cmd('Page.captureScreenshot', {'captureBeyondViewport': True,
                                                                       'clip': {'x': 0, 'y': 0, 'width': width, 'height': height, 'scale': 1}})
        with open(os.path.join(self.folder, name), 'wb') as file:
            file.write(base64.b64decode(image['data']))

    def test_1_answers_plots_and_past_events_appear_while_the_bag_plays(self):
        wait_until(lambda: self.text('state') == 'ready', 90, 'ready')
        wait_until(lambda: self.run_js('document.querySelectorAll("#cranks tbody tr th").length') >= 3, 90, 'three past cranks')
        self.assertRegex(self.text('answers'), r'lowest voltage\d+\.\d\d V holds')
        words = '[...document.querySelectorAll("#answers .word")].map((word) => word.textContent)'
        messages = '[window.livePage.batteries[0].status].flatMap((s) => [s.crank.message, s.stop_time.message, s.charge.message])'
        wait_until(lambda: self.run_js(words) == [message.partition(':')[0] for message in self.run_js(messages)], 10, 'the words of the messages')
        self.assertEqual(self.run_js('document.querySelectorAll("#answers svg[role=img][aria-label]").length'), 3)
        self.assertRegex(self.text('figures'), r'Answers rest onthis tripModel age\d')
        self.assertRegex(self.text('cranks'), r'\d+ % inside, mean error 0\.\d')
        self.assertGreater(self.run_js('window.livePage.batteries[0].expected.length'), 20)
        answers = self.run_js('window.livePage.batteries[0].answers')
        self.assertEqual(answers, sorted(answers))
        self.assertLess(answers[-1][3] - answers[-1][1], 0.5 * (answers[0][3] - answers[0][1]))
        painted = self.run_js('Object.values(window.livePage.graphs).map((graph) => { const c = graph.hidden_; return c.getContext("2d")'
                              '.getImageData(0, 0, c.width, c.height).data.filter((value, k) => k % 4 === 3 && value > 0).length; })')
        for pixels in painted:
            self.assertGreater(pixels, 1000)
        expected, bins = self.run_js('[window.livePage.batteries[0].expected, window.livePage.batteries[0].bins]')
        near = [(e, b) for e in expected for b in bins if abs(b[0] - e[0]) < 0.05]
        self.assertGreater(len(near), 20)
        self.assertLess(sorted(abs(e[1] - b[1]) for e, b in near)[len(near) // 2], 0.05)

    def test_2_nothing_sticks_out_in_two_widths(self):
        for width, dark in ((1400, False), (400, False), (1400, True), (320, False)):
            self.size(width, dark=dark)
            self.assertLessEqual(self.run_js('document.documentElement.scrollWidth'), width)
            self.shot('live_%d_%s.png' % (width, 'dark' if dark else 'light'))
        self.size(1400)

    def test_3_tabs_are_chosen_by_keyboard_and_everything_has_a_name(self):
        tabs = self.driver.find_elements('css selector', '[role=tab]')
        self.assertEqual([tab.text for tab in tabs], list(NODES))
        tabs[0].send_keys(Keys.ARROW_RIGHT)
        self.assertEqual([tab.get_attribute('aria-selected') for tab in tabs], ['false', 'true'])
        self.assertEqual(self.run_js('document.activeElement.id'), 'tab-1')
        self.assertEqual(self.run_js('document.getElementById("panel").getAttribute("aria-labelledby")'), 'tab-1')
        wait_until(lambda: self.text('state') == 'ready', 30, 'the other battery')
        self.driver.switch_to.active_element.send_keys(Keys.HOME)
        self.assertEqual(self.run_js('document.activeElement.id'), 'tab-0')
        names = self.driver.execute_cdp_cmd('Accessibility.getFullAXTree', {})['nodes']
        for role in ('button', 'combobox', 'tab', 'tabpanel', 'table', 'image'):
            found = [n for n in names if n.get('role', {}).get('value') == role and not n.get('ignored')]
            self.assertTrue(found, role)
            self.assertFalse([n for n in found if not n.get('name', {}).get('value')], role)
        self.driver.find_element('id', 'hold').send_keys(Keys.SPACE)
        self.assertEqual(self.driver.find_element('id', 'hold').get_attribute('aria-pressed'), 'true')
        self.driver.find_element('id', 'hold').send_keys(Keys.SPACE)

    def test_4_other_hosts_origins_paths_and_too_much_are_refused(self):
        for host in ('example.com', 'example.com:%d' % self.port, '127.0.0.1', ''):
            self.assertIn(b' 403 ', self.answer('GET / HTTP/1.1', host)[:20], host)
        self.assertIn(b' 403 ', self.answer('GET / HTTP/1.1', None, 'Origin: http://example.com')[:20])
        for path in ('/../package.xml', '/..%2fpackage.xml', '/%2e%2e/package.xml', '//etc/passwd', '/live_page', '/index.html'):
            self.assertIn(b' 404 ', self.answer('GET %s HTTP/1.1' % path)[:20], path)
        self.assertIn(b' 405 ', self.answer('POST / HTTP/1.1')[:20])
        for origin in ('http://example.com', 'http://127.0.0.1', 'null', None):
            self.assertIn(b' 403 ', self.socket_answer(origin), origin)
        self.assertIn(b' 403 ', self.socket_answer(self.own(), 'example.com'))
        connections = [self.upgraded(self.own()) for _ in range(10)]
        answers = [line.split()[1] for line, _ in connections]
        self.assertEqual((answers.count(b'101'), answers.count(b'503')), (7, 3), answers)  # the browser has one of eight
        _, first = connections[0]
        first.sendall(b'\x81\xfe\x10\x00\x00\x00\x00\x00' + b'a' * 4096)
        wait_until(lambda: is_closed(first), 20, 'a frame that is too long ends the connection')
        for _, connection in connections:
            connection.close()
        wait_until(lambda: b' 101 ' in self.socket_answer(self.own()), 20, 'places are free again')

    def test_5_only_this_computer_is_served(self):
        with open('/proc/net/tcp') as table:
            listening = [line.split()[1] for line in table if line.split()[3] == '0A']
        self.assertIn('0100007F:%04X' % self.port, listening)
        self.assertNotIn('00000000:%04X' % self.port, listening)

    def test_6_diagnosis_appears_when_it_comes_and_a_lost_connection_is_said(self):
        self.assertIn('None yet', self.text('diagnosis'))
        asked = ("import sys, actionlib, rospy; from battery_sof.msg import DiagnoseAction, DiagnoseGoal; rospy.init_node('asker', anonymous=True); "
                 "client = actionlib.SimpleActionClient(sys.argv[1], DiagnoseAction); client.wait_for_server(); client.send_goal(DiagnoseGoal()); "
                 "client.wait_for_result()")
        subprocess.run(['/usr/bin/python3', '-c', asked, NODES[0] + '/diagnose'], env=self.environment, stdout=self.log, stderr=self.log, timeout=90)
        wait_until(lambda: 'None yet' not in self.text('diagnosis'), 30, 'the diagnosis')
        self.assertEqual([entry for entry in self.driver.get_log('browser') if entry['level'] == 'SEVERE'], [])
        self.size(1400)
        self.shot('live_diagnosed.png')
        subprocess.run(['rosnode', 'kill', '/live_page'], env=self.environment, stdout=self.log, stderr=self.log, timeout=30)
        wait_until(lambda: 'lost' in self.text('connection'), 20, 'the connection is lost')


if __name__ == '__main__':
    main(LivePage, __doc__)

"""A roscore, scripts/live_page and headless Chromium of their own on loopback, for tests; and requests as raw bytes."""
import os
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

from browser_test import NOETIC, Service, skip_or_fail, tool, webdriver


def free_port():
    with socket.socket() as one:
        one.bind(('127.0.0.1', 0))
        return one.getsockname()[1]


def wait_until(condition, deadline, what):
    end = time.monotonic() + deadline
    while time.monotonic() < end:
        value = condition()
        if value:
            return value
        time.sleep(0.05)
    raise AssertionError('not within {} s: {}'.format(deadline, what))


def is_closed(connection):
    try:
        return connection.recv(65536) == b''
    except ConnectionError:
        return True


class LiveServer(unittest.TestCase):
    """A subclass sets devel, folder and what is served (serve()) before its tests."""
    devel = folder = None
    log_name = 'live.log'

    @classmethod
    def setUpClass(cls):
        cls.started, cls.port, cls.driver = [], free_port(), None
        cls.log = open(os.path.join(cls.folder, cls.log_name), 'w')
        master = free_port()
        cls.work = tempfile.TemporaryDirectory(prefix='live page ', ignore_cleanup_errors=True)
        cls.environment = dict(os.environ, ROS_MASTER_URI='http://127.0.0.1:%d' % master, ROS_IP='127.0.0.1', ROS_HOME=cls.work.name)
        cls.begin('roscore', '-p', str(master))
        wait_until(lambda: cls.rosparam('list') is not None, 30, 'roscore')

    @classmethod
    def serve(cls, nodes):
        """The page of some nodes, as its launch file starts it; all samples on one topic."""
        cls.page = cls.begin('roslaunch', '--wait', 'battery_sof', 'live.launch', 'port:=%d' % cls.port, 'nodes:=' + ','.join(nodes), 'topics:=/battery_state')
        wait_until(lambda: cls.answer('GET / HTTP/1.1').startswith(b'HTTP/1.1 200'), 30, 'the page')

    @classmethod
    def browse(cls):
        options = webdriver.ChromeOptions()
        options.binary_location = tool('chromium')
        for argument in ('--headless=new', '--no-sandbox', '--disable-dev-shm-usage', '--disable-gpu', '--hide-scrollbars', '--no-first-run',
                         '--user-data-dir=' + os.path.join(cls.work.name, 'profile')):
            options.add_argument(argument)
        options.set_capability('goog:loggingPrefs', {'browser': 'ALL'})
        cls.driver = webdriver.Chrome(service=Service(tool('chromedriver')), options=options)
        cls.driver.get('http://127.0.0.1:%d/' % cls.port)

    @classmethod
    def tearDownClass(cls):
        if cls.driver:
            cls.driver.quit()
        for process in reversed(cls.started):
            process.send_signal(signal.SIGINT)
        for process in cls.started:
            try:
                process.wait(timeout=20)
            except subprocess.TimeoutExpired:
                process.kill()
        cls.log.close()
        cls.work.cleanup()

    @classmethod
    def begin(cls, *command):
        process = subprocess.Popen(command, env=cls.environment, stdin=subprocess.DEVNULL, stdout=cls.log, stderr=cls.log)
        cls.started.append(process)
        return process

    @classmethod
    def program(cls, name):
        return os.path.join(cls.devel, 'lib', 'battery_sof', name)

    @classmethod
    def rosparam(cls, *arguments):
        done = subprocess.run(['rosparam', *arguments], env=cls.environment, capture_output=True, text=True)
        return done.stdout if done.returncode == 0 else None

    @classmethod
    def connect(cls):
        try:
            return socket.create_connection(('127.0.0.1', cls.port), timeout=20)
        except OSError:
            return None

    @classmethod
    def answer(cls, first, host=None, *headers):
        """The beginning of what the server answers to a request."""
        connection = cls.connect()
        if not connection:
            return b''
        with connection:
            host = '127.0.0.1:%d' % cls.port if host is None else host
            connection.sendall('\r\n'.join((first, 'Host: ' + host, *headers, 'Connection: close', '', '')).encode())
            connection.settimeout(20)
            return connection.recv(4096)

    @classmethod
    def socket_answer(cls, origin, host=None):
        return cls.upgraded(origin, host)[0]

    @classmethod
    def upgraded(cls, origin, host=None):
        """The status line of an answer to the request for a websocket, and the connection."""
        connection = cls.connect()
        headers = ['GET /news HTTP/1.1', 'Host: ' + (host or '127.0.0.1:%d' % cls.port), 'Connection: Upgrade', 'Upgrade: websocket',
                   'Sec-WebSocket-Version: 13', 'Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==']
        if origin:
            headers.append('Origin: ' + origin)
        connection.sendall('\r\n'.join(headers + ['', '']).encode())
        connection.settimeout(20)
        return connection.recv(4096).split(b'\r\n')[0], connection

    def own(self):
        return 'http://127.0.0.1:%d' % self.port

    def run_js(self, script):
        return self.driver.execute_script('return ' + script)

    def text(self, element):
        return self.run_js('document.getElementById("%s").textContent' % element)


def main(case, usage):
    """Runs a subclass of LiveServer as the program that it is called as: PROGRAM DEVEL FOLDER."""
    if len(sys.argv) != 3:
        sys.exit(usage)
    case.devel, case.folder = (os.path.abspath(path) for path in sys.argv[1:])
    os.makedirs(case.folder, exist_ok=True)
    tool('chromium')
    tool('chromedriver')
    if NOETIC:
        skip_or_fail('the plot library is no package here')
    unittest.main(argv=sys.argv[:1], verbosity=2)

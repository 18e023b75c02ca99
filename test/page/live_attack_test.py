#!/usr/bin/env python3
"""What a foreign page, another program on the computer and hostile messages can do to the live page: nothing but be refused.

Usage: live_attack_test.py DEVEL FOLDER; DEVEL is the devel space, the log goes to FOLDER. To be called in DEVEL's environment (env.sh).
Exit 77 (skipped) only where Chromium cannot be had.
"""
import asyncio
import hashlib
import os
import struct
import subprocess
import threading
import time
import types
import xmlrpc.client
from unittest import mock

from live_server import LiveServer, free_port, is_closed, main, wait_until

HOSTILE = '<img src=x onerror="window.broken=1"><script>window.broken=1</script>"\'></svg><svg onload="window.broken=1">'
NODES = ('/front', '/<img src=x onerror=window.broken=1>')
SOURCES = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..', 'live')
SOCKETS = 200
MAX_GROWTH = 30e6  # [byte] of resident memory that all attacks together may leave


def frame(opcode, payload, is_last=True, claimed=None):
    """A masked frame of a browser. @param claimed length that it says; that of the payload when not given."""
    length = len(payload) if claimed is None else claimed
    head = bytes([(0x80 if is_last else 0) | opcode])
    head += bytes([0x80 | length]) if length < 126 else bytes([0xfe]) + struct.pack('>H', length) if length < 65536 else bytes([0xff]) + struct.pack('>Q', length)
    return head + b'\0\0\0\0' + payload


def send(connection, data):
    try:
        connection.sendall(data)
    except ConnectionError:
        pass  # the server had enough


class Attacks(LiveServer):
    log_name = 'live_attack.log'

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.master = xmlrpc.client.ServerProxy(cls.environment['ROS_MASTER_URI'])
        for name, value in (('nodes', ','.join(NODES)), ('topics', '/battery_state'), ('port', cls.port), ('page', SOURCES)):
            cls.master.setParam('/attacks', '/live_page/' + name, value)
        cls.server = cls.begin(cls.program('live_page'))
        wait_until(lambda: cls.answer('GET / HTTP/1.1').startswith(b'HTTP/1.1 200'), 30, 'the page')
        cls.before, cls.files = cls.memory(), cls.digests()
        cls.browse()

    @classmethod
    def memory(cls):
        with open('/proc/%d/statm' % cls.server.pid) as file:
            return int(file.read().split()[1]) * os.sysconf('SC_PAGESIZE')

    @staticmethod
    def digests():
        return {name: hashlib.sha256(open(os.path.join(SOURCES, name), 'rb').read()).hexdigest() for name in sorted(os.listdir(SOURCES))}

    def require_served(self):
        begun = time.monotonic()
        self.assertIn(b' 200 ', self.answer('GET / HTTP/1.1')[:20])
        self.assertLess(time.monotonic() - begun, 2.0)

    def test_1_two_hundred_sockets_get_the_places_there_are_and_the_page_goes_on(self):
        connections = [self.upgraded(self.own()) for _ in range(SOCKETS)]
        answers = [line.split()[1] for line, _ in connections]
        self.assertEqual((answers.count(b'101'), answers.count(b'503')), (7, SOCKETS - 7))  # the browser has one of eight
        self.require_served()
        for _, connection in connections:
            connection.close()
        wait_until(lambda: b' 101 ' in self.socket_answer(self.own()), 20, 'places are free again')

    def test_2_connections_that_say_nothing_are_ended(self):
        silent = [self.connect() for _ in range(SOCKETS)]
        for k, connection in enumerate(silent):
            connection.sendall(b'GET / HTTP/1.1\r\nHost: x' if k % 2 else b'')
            connection.setblocking(False)
        self.require_served()
        end = time.monotonic() + 30.0
        while silent and time.monotonic() < end:
            time.sleep(0.1)
            silent = [connection for connection in silent if not self.is_ended(connection)]
        self.assertEqual(len(silent), 0, 'still open')

    @staticmethod
    def is_ended(connection):
        try:
            ended = is_closed(connection)
        except BlockingIOError:
            return False
        if ended:
            connection.close()
        return ended

    def test_3_frames_that_are_too_long_endless_or_wrong_end_their_connection(self):
        endless = frame(1, b'a' * 100, is_last=False) + 2000 * frame(0, b'a' * 100, is_last=False)
        for name, data in (('longer than allowed', frame(1, b'a' * 4096)), ('claims 64 bits', frame(2, b'', claimed=1 << 62)),
                           ('claims a sign', b'\x82\xff' + b'\xff' * 8 + b'\0\0\0\0'), ('endless pieces', endless),
                           ('not masked', b'\x81\x05hello'), ('reserved bits', bytes([0xf1, 0x80, 0, 0, 0, 0])), ('unknown opcode', frame(0x7, b'')),
                           ('long ping', frame(0x9, b'a' * 1000)), ('something to say', frame(1, b'{"batteries": []}'))):
            line, connection = self.upgraded(self.own())
            self.assertIn(b' 101 ', line)
            send(connection, data)
            wait_until(lambda: is_closed(connection), 20, name)
            connection.close()
        self.require_served()

    def test_4_headers_and_bodies_that_are_too_long_are_refused(self):
        for name, data in (('header', b'GET / HTTP/1.1\r\n' + b'X: ' + b'a' * 100000), ('path', b'GET /' + b'a' * 100000),
                           ('body', b'POST / HTTP/1.1\r\nHost: x\r\nContent-Length: 4000000000\r\n\r\n'),
                           ('pieces', b'POST / HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: chunked\r\n\r\nfffffff0\r\n')):
            connection = self.connect()
            send(connection, data)
            wait_until(lambda: is_closed(connection), 20, name)
            connection.close()
        self.require_served()

    def test_5_nothing_can_be_written(self):
        for method in ('POST', 'PUT', 'DELETE', 'PATCH', 'OPTIONS', 'HEAD'):
            for path in ('/', '/live.js', '/news'):
                self.assertRegex(self.answer('%s %s HTTP/1.1' % (method, path))[:20], b' 40[35] ', method + path)
        for path in ('/../live_page', '/%2e%2e%2flive_page', '/..\\live_page', '/live.js%00.html', '/./index.html', '/etc/passwd', '/live.js/', '/__proto__'):
            self.assertIn(b' 404 ', self.answer('GET %s HTTP/1.1' % path)[:20], path)
        topics, _, services = self.master.getSystemState('/attacks')[2]
        self.assertEqual([topic for topic, nodes in topics if '/live_page' in nodes], ['/rosout'])
        offered = [service for service, nodes in services if '/live_page' in nodes]
        self.assertEqual(sorted(offered), ['/live_page/get_loggers', '/live_page/set_logger_level'])  # rospy's own
        self.assertEqual(self.digests(), self.files)

    def test_6_names_and_messages_are_shown_as_text(self):
        self.publish_hostile()
        tabs = wait_until(lambda: self.run_js('[...document.querySelectorAll("[role=tab]")].map((tab) => tab.textContent)'), 20, 'tabs')
        self.assertEqual(tabs, list(NODES))
        wait_until(lambda: HOSTILE in self.text('diagnosis'), 20, 'the diagnosis')
        wait_until(lambda: HOSTILE in self.text('reason'), 20, 'the status')
        for element, count in (('diagnosis', 5), ('figures', 1), ('answers', 2)):
            self.assertEqual(self.text(element).count(HOSTILE), count, element)
        self.assertIsNone(self.run_js('window.broken'))
        self.assertEqual(self.run_js('document.querySelectorAll("img, script:not([src]), svg[onload], [onerror]").length'), 0)
        self.assertEqual([entry for entry in self.driver.get_log('browser') if entry['level'] == 'SEVERE'], [])

    @classmethod
    def publisher(cls, name, kind):
        os.environ.update((one, cls.environment[one]) for one in ('ROS_MASTER_URI', 'ROS_IP', 'ROS_HOME'))
        import rospy
        rospy.init_node('attacks', anonymous=True, disable_signals=True)
        topic = rospy.Publisher(name, kind, queue_size=100, latch=True)
        wait_until(topic.get_num_connections, 20, 'the page listens to ' + name)
        return topic

    def publish_hostile(self):
        """A status and a diagnosis as a node would publish, every text of them hostile."""
        from battery_sof.msg import Diagnosis, DiagnosisEffect, SofStatus
        status = SofStatus(reason=HOSTILE, effects=[HOSTILE])
        for answer in (status.crank, status.stop_time, status.charge):
            answer.message = HOSTILE
        status.stop_time.outcome = HOSTILE
        status.stop_time.t_stop, status.stop_time.valid = 1.0, True
        status.crank.u_min = status.charge.i_boost = 1.0
        status.past_cranks.time = status.past_charges.time = float('nan')
        diagnosis = Diagnosis(verdict=HOSTILE, summary=HOSTILE, adopted=True, adoption=HOSTILE, next_experiment=HOSTILE)
        diagnosis.effects = [DiagnosisEffect(id=HOSTILE, probability=1.0)]
        for name, message in (('/status', status), ('/diagnosis', diagnosis)):
            self.publisher(NODES[0] + name, type(message)).publish(message)

    def test_7_messages_that_cannot_be_shown_are_dropped_and_logged_and_pages_go_on(self):
        from battery_sof.msg import EventRecord, SofStatus
        nan, inf = float('nan'), float('inf')
        bad = [SofStatus(expected_voltage=12.0, expected_time=time_) for time_ in (nan, inf, -1.0, 1e300)]
        bad += [SofStatus(expected_voltage=voltage) for voltage in (-inf, 1e308)]
        bad += [SofStatus(expected_voltage=nan, past_cranks=EventRecord(time=inf)), SofStatus(expected_voltage=nan, past_charges=EventRecord(time=-1e9))]
        topic = self.publisher(NODES[0] + '/status', SofStatus)
        for status in bad + [self.filled(SofStatus(), value) for value in (inf, -inf, 1e308, -1e308, 5e-324)]:
            status.reason = 'bad'
            topic.publish(status)
        last = self.filled(SofStatus(reason='the last one', expected_voltage=12.0, expected_time=8.0, past_cranks=EventRecord(time=7.0)), nan)
        for event in (last.past_cranks, last.past_charges):
            event.measured, event.expected, event.lower, event.upper = 9.0, 1e308, -inf, inf
        topic.publish(last)
        self.run_js('document.getElementById("tab-0").click()')
        wait_until(lambda: self.text('reason') == 'the last one', 20, 'the status after the bad ones')
        self.assertEqual(self.run_js('[window.livePage.batteries[0].expected, window.livePage.batteries[0].cranks.length]'), [[[0, 0], [5e-324, 5e-324], [8, 12]], 2])
        self.run_js('document.getElementById("span").value = "0"')
        self.run_js('document.getElementById("span").dispatchEvent(new Event("change"))')
        self.assertEqual([entry for entry in self.driver.get_log('browser') if entry['level'] == 'SEVERE'], [])
        for _ in range(12):
            line, connection = self.upgraded(self.own())
            self.assertIn(b' 101 ', line)
            send(connection, frame(8, b''))
            wait_until(lambda: is_closed(connection), 20, 'it is ended by the page alone')
            connection.close()
        with open(self.log.name) as log:
            self.assertRegex(log.read(), 'a message of .*/status is dropped, it cannot be shown: expected_time is nan, expected 0 to 4.29497e')

    @staticmethod
    def filled(message, value):
        """Every number with a fraction in it that was not given, those of the messages in it too."""
        for name, kind in zip(message.__slots__, message._slot_types):
            if kind in ('float32', 'float64') and getattr(message, name) == 0.0:
                setattr(message, name, value)
            elif '/' in kind and kind != 'std_msgs/Header':
                Attacks.filled(getattr(message, name), value)
        return message

    def test_8_what_is_no_port_is_refused(self):
        for port in ('99999', '-1', '80.5', 'http', 'true'):
            done = subprocess.run([self.program('live_page'), '__name:=no_port', '_port:=' + port], env=self.environment, capture_output=True, text=True, timeout=30)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertRegex(done.stderr, r'live_page: ~port is .*, expected 0 to 65535\n$')

    def test_8_places_of_pages_whose_beginning_fails_are_free_again(self):
        script = os.path.join(SOURCES, '..', 'scripts', 'live_page')
        page = types.ModuleType('live_page')
        exec(compile(open(script).read(), script, 'exec'), page.__dict__)
        loops = []

        def serve(port):
            asyncio.set_event_loop(asyncio.new_event_loop())
            server = page.Server(SOURCES)
            server.hosts = ('127.0.0.1:%d' % port,)
            server.batteries = [mock.Mock(node='/broken', whole=mock.Mock(side_effect=ValueError('broken')))]
            server.listen(port, '127.0.0.1')
            loops.append(server.loop)
            server.loop.start()

        with mock.patch.object(Attacks, 'port', free_port()):
            thread = threading.Thread(target=serve, args=(self.port,), daemon=True)
            thread.start()
            wait_until(lambda: self.answer('GET / HTTP/1.1').startswith(b'HTTP/1.1 200'), 20, 'the page')
            self.assertEqual([self.socket_answer(self.own()).split()[1] for _ in range(12)], [b'101'] * 12)
        loops[0].add_callback(loops[0].stop)
        thread.join(20)

    def test_9_memory_has_not_grown(self):
        self.assertLess(self.memory() - self.before, MAX_GROWTH)


if __name__ == '__main__':
    main(Attacks, __doc__)

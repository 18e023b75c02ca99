#!/usr/bin/env python3
"""What a foreign page, another program on the computer and hostile messages can do to the live page: nothing but be refused.

Usage: live_attack_test.py DEVEL FOLDER; DEVEL is the devel space, the log goes to FOLDER. To be called in DEVEL's environment (env.sh).
Exit 77 (skipped) only where Chromium cannot be had.
"""
import hashlib
import os
import struct
import time
import xmlrpc.client

from live_server import LiveServer, is_closed, main, wait_until

HOSTILE = '<img src=x onerror="window.broken=1"><script>window.broken=1</script>"\'></svg><svg onload="window.broken=1">'
NODES = ('/front', '/<img src=x onerror=window.broken=1>')
SOURCES = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..', 'live')
SOCKETS = 200
MOST_GROWTH = 30e6  # [byte] of resident memory that all attacks together may leave


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
        for element, count in (('diagnosis', 5), ('figures', 3), ('answers', 3)):
            self.assertEqual(self.text(element).count(HOSTILE), count, element)
        self.assertIsNone(self.run_js('window.broken'))
        self.assertEqual(self.run_js('document.querySelectorAll("img, script:not([src]), svg[onload], [onerror]").length'), 0)
        self.assertEqual([entry for entry in self.driver.get_log('browser') if entry['level'] == 'SEVERE'], [])

    def publish_hostile(self):
        """A status and a diagnosis as a node would publish, every text of them hostile."""
        os.environ.update((name, self.environment[name]) for name in ('ROS_MASTER_URI', 'ROS_IP', 'ROS_HOME'))
        import rospy
        from battery_sof.msg import Diagnosis, DiagnosisEffect, SofStatus
        rospy.init_node('attacks', anonymous=True, disable_signals=True)
        status = SofStatus(reason=HOSTILE, effects=[HOSTILE], extension=HOSTILE)
        for answer in (status.crank, status.stop_time, status.charge):
            answer.message = HOSTILE
        status.stop_time.outcome = HOSTILE
        status.stop_time.t_stop, status.stop_time.valid = 1.0, True
        status.crank.u_min = status.charge.i_boost = 1.0
        status.past_cranks.answered_by = status.past_charges.answered_by = HOSTILE
        status.past_cranks.time = status.past_charges.time = float('nan')
        diagnosis = Diagnosis(verdict=HOSTILE, summary=HOSTILE, adopted=True, adoption=HOSTILE, next_experiment=HOSTILE)
        diagnosis.effects = [DiagnosisEffect(id=HOSTILE, probability=1.0)]
        self.topics = [rospy.Publisher(NODES[0] + '/status', SofStatus, queue_size=1, latch=True), rospy.Publisher(NODES[0] + '/diagnosis', Diagnosis, queue_size=1, latch=True)]
        for topic, message in zip(self.topics, (status, diagnosis)):
            topic.publish(message)

    def test_7_memory_has_not_grown(self):
        self.assertLess(self.memory() - self.before, MOST_GROWTH)


if __name__ == '__main__':
    main(Attacks, __doc__)

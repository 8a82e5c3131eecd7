# Debian packages: libfaketime mosquitto openssl python3-paho-mqtt
"""tribus-mqtt between a real mosquitto and real daemons, read by a client of others."""
import glob
import json
import os
import pathlib
import random
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

from board import (PROGRAMS, RADIO_TO_SERVOS, Board, Wire, end_with_this_process, eventually,
                   ibus_frame)
from broker import Broker, Reader

BOARD = "boat"
# Before a program: its clock is a year behind. In its own process, so that signals reach it.
YEAR_S = 365 * 24 * 3600
A_YEAR_AGO = ["env", "LD_PRELOAD=" + glob.glob("/usr/lib/*/faketime/libfaketime.so.1")[0],
              f"FAKETIME=-{YEAR_S}", "FAKETIME_DONT_FAKE_MONOTONIC=1"]


class Bridge:
    def __init__(self, folder, *options, before=()):
        self.log = folder / f"bridge-{time.monotonic_ns()}.log"
        environment = os.environ | {"XDG_RUNTIME_DIR": str(folder / "run")}
        with open(self.log, "wb") as log:
            self.process = subprocess.Popen(  # pylint: disable=consider-using-with
                [*before, PROGRAMS / "tribus-mqtt", "run", "--board", BOARD, *options],
                stdout=log, stderr=log, env=environment, preexec_fn=end_with_this_process)

    def says(self, text):
        return eventually(lambda: text in self.log.read_text())

    def memory_kib(self):
        status = pathlib.Path(f"/proc/{self.process.pid}/status").read_text()
        return int(next(line for line in status.splitlines() if line.startswith("VmRSS")).split()[1])

    def stop(self, number=signal.SIGTERM):
        if self.process.poll() is None:
            self.process.send_signal(number)
        return self.process.wait(30)


def authority(folder, name):
    """A certificate that signs others, and one for 127.0.0.1 that it signed."""
    def openssl(*words):
        subprocess.run(["openssl", *words], check=True, capture_output=True, cwd=folder)
    openssl("req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", f"/CN={name}",
            "-keyout", f"{name}-ca.key", "-out", f"{name}-ca.pem")
    openssl("req", "-newkey", "rsa:2048", "-nodes", "-subj", "/CN=127.0.0.1",
            "-keyout", f"{name}.key", "-out", f"{name}.csr")
    (folder / f"{name}.ext").write_text("subjectAltName=IP:127.0.0.1\n")
    openssl("x509", "-req", "-in", f"{name}.csr", "-CA", f"{name}-ca.pem", "-CAkey",
            f"{name}-ca.key", "-CAcreateserial", "-days", "2", "-extfile", f"{name}.ext",
            "-out", f"{name}.pem")


class Told(unittest.TestCase):
    """One board, one broker, one bridge, one reader; each test begins with all of them well."""

    def setUp(self):
        self.board = Board()
        self.addCleanup(self.board.close)
        self.broker = Broker(self.board.folder, "allow_anonymous true")
        self.addCleanup(self.broker.stop)
        self.reader = Reader(self.broker.port, "tribus/#", "homeassistant/#")
        self.addCleanup(self.reader.close)
        self.of_car = f"tribus/{BOARD}/{self.board.car}"
        self.event, self.status = f"{self.of_car}/event", f"{self.of_car}/status"
        self.bridge = self.start_bridge()
        self.assertTrue(eventually(self.is_good), self.story())

    def start_bridge(self, *options, before=()):
        bridge = Bridge(self.board.folder, "--broker", f"127.0.0.1:{self.broker.port}", *options,
                        before=before)
        self.addCleanup(bridge.stop)
        return bridge

    def newest(self):
        return json.loads(self.reader.last(self.status) or "{}")

    def is_good(self):
        outputs = self.newest().get("outputs", {})
        return outputs.get("servos", {}).get("state") == "control" and self.available()

    def available(self, topic=None):
        return self.reader.last(f"{topic or self.of_car}/availability") == "online"

    def story(self):
        logs = self.board.folder.glob("*.log")
        return "\n".join([*(file.read_text() for file in logs), str(self.newest().get("outputs")),
                          *map(str, self.events()[-9:])])

    def events(self, **wanted):
        return [event for event in self.reader.objects(self.event) if wanted.items() <= event.items()]

    def test_a_status_comes_each_second_with_values_and_ages_and_is_not_retained(self):
        begun = len(self.reader.of(self.status))
        time.sleep(5)
        came = self.reader.of(self.status)[begun:]
        self.assertIn(len(came), range(3, 8))
        self.assertTrue(all(not message[3].retain and message[3].qos == 0 for message in came))
        status = self.newest()
        self.assertEqual(status["inputs"]["radio"]["cause"], "good")
        self.assertLess(status["inputs"]["radio"]["age_s"], 0.5)
        self.assertEqual(status["values"]["pack.battery.voltage"]["number"], 12.5)
        self.assertLess(abs(status["unix_time_us"] / 1e6 - time.time()), 2)
        late = Reader(self.broker.port, f"{self.of_car}/status", f"{self.of_car}/availability")
        self.addCleanup(late.close)
        time.sleep(0.3)
        self.assertFalse([message for message in late.of(self.status) if message[3].retain])
        self.assertTrue(eventually(lambda: late.last(f"{self.of_car}/availability") == "online"))

    def test_a_pulled_wire_is_an_event_with_its_cause_and_a_status_at_once(self):
        self.assertTrue(eventually(lambda: self.newest()["inputs"]["radio"]["good"]))
        pulled = time.time()
        self.board.radio.talks = False
        self.assertTrue(eventually(lambda: self.events(name="radio", now="wire_silent")))
        event = self.events(name="radio", now="wire_silent")[0]
        self.assertEqual((event["before"], event["late"]), ("good", False))
        self.assertLess(abs(event["unix_time_us"] / 1e6 - pulled), 5)
        self.assertTrue(eventually(lambda: self.events(name="servos", now="failsafe")))
        self.assertTrue(eventually(lambda: not self.newest()["inputs"]["radio"]["good"]))
        self.assertTrue(self.available(), "the daemon itself is well")

    def test_a_broker_killed_during_a_failsafe_gets_the_event_once_with_its_time(self):
        self.broker.stop(signal.SIGKILL)
        happened = time.time()
        self.board.radio.talks = False
        time.sleep(6)
        self.broker.start()
        self.assertTrue(eventually(lambda: self.events(name="servos", now="failsafe")))
        time.sleep(3)
        for name, now in (("radio", "wire_silent"), ("servos", "hold"), ("servos", "failsafe")):
            told = self.events(name=name, now=now)
            self.assertEqual(len(told), 1, (name, now, told))
            self.assertTrue(told[0]["late"])
            self.assertLess(abs(told[0]["unix_time_us"] / 1e6 - happened), 4)
            self.assertGreater(told[0]["age_s"], 2)
        self.assertTrue(eventually(lambda: self.newest()["outputs"]["servos"]["state"] == "failsafe"))

    def test_each_short_loss_comes_exactly_once_in_its_order(self):
        """With TRIBUS_LONG=1 there are 10,000 losses instead of 60."""
        radio, servos = Wire(ibus_frame([1500] * 14), 0.005), Wire()
        self.addCleanup(servos.close)
        self.addCleanup(radio.close)
        quick = self.board.start_another("quick", RADIO_TO_SERVOS.replace("500ms", "30ms").format(
            radio=radio, servos=servos))
        event = f"tribus/{BOARD}/{quick}/event"
        self.assertTrue(eventually(lambda: self.available(f"tribus/{BOARD}/{quick}")))
        changes = self.board.watch(quick)
        for _ in range(10_000 if os.environ.get("TRIBUS_LONG") else 60):
            radio.talks = True
            time.sleep(0.06)
            radio.talks = False
            time.sleep(random.uniform(0.05, 0.09))
        radio.talks = True

        def losses():
            return [(one["unix_time_us"], one["name"]) for one in changes()
                    if one["now"] == "wire_silent"]

        def came():
            return [(one["unix_time_us"], one["name"]) for one in self.reader.objects(event)
                    if one["now"] == "wire_silent"]
        self.assertTrue(eventually(lambda: len(losses()) > 50 and came() == losses()))
        told = self.reader.objects(event)
        print(f"{len(came())} losses came", file=sys.stderr)
        self.assertEqual(len({one["id"] for one in told}), len(told))
        self.assertEqual([one for one in told if one.get("lost_before") or one["late"]], [])

    def test_a_bridge_that_is_killed_goes_off_by_its_last_will(self):
        self.assertTrue(self.available(f"tribus/{BOARD}"))
        self.bridge.stop(signal.SIGKILL)
        self.assertTrue(eventually(lambda: self.reader.last(f"tribus/{BOARD}/availability") == "offline"))

    def test_a_bridge_that_is_stopped_says_so(self):
        self.assertEqual(self.bridge.stop(), 0)
        self.assertEqual(self.reader.last(f"tribus/{BOARD}/availability"), "offline")

    def test_a_daemon_that_hangs_or_ends_is_not_available(self):
        off = lambda: self.reader.last(f"{self.of_car}/availability") == "offline"
        self.board.send(self.board.car, signal.SIGSTOP)
        self.assertTrue(eventually(off))
        self.assertTrue(eventually(lambda: self.events(event_type="daemon", now="silent")))
        told = len(self.reader.of(self.status))
        time.sleep(3)
        self.assertEqual(len(self.reader.of(self.status)), told, "an old status was told again")
        self.board.send(self.board.car, signal.SIGCONT)
        self.assertTrue(eventually(self.is_good), self.story())
        self.board.stop(self.board.car)
        self.assertTrue(eventually(off))
        self.assertTrue(eventually(lambda: self.events(event_type="daemon", now="gone")))
        self.board.start_daemon(self.board.car)
        self.assertTrue(eventually(self.is_good), self.story())

    def test_home_assistant_gets_its_discovery_again_when_it_is_born(self):
        topic = f"homeassistant/device/tribus--{BOARD}--{self.board.car.replace('-', '-2D')}/config"
        self.assertTrue(eventually(lambda: self.reader.of(topic)))
        components = self.reader.objects(topic)[-1]["components"].values()
        topics = {component["state_topic"] for component in components}
        self.assertEqual(topics, {self.status, self.event})
        late = Reader(self.broker.port, topic)
        self.addCleanup(late.close)
        self.assertTrue(eventually(lambda: late.of(topic)))
        self.assertTrue(late.of(topic)[0][3].retain)
        told = len(self.reader.of(topic))
        self.reader.say("homeassistant/status", "online")
        self.assertTrue(eventually(lambda: len(self.reader.of(topic)) > told))

    def test_nothing_that_the_broker_sends_changes_anything(self):
        for topic in (self.status, self.event, f"{self.of_car}/set", f"tribus/{BOARD}/reload"):
            self.reader.say(topic, '{"inputs":{"radio":{"cause":"good"}},"reload":true}')
        time.sleep(2)
        self.assertTrue(eventually(self.is_good))
        self.assertFalse([event for event in self.reader.objects(self.event)
                          if event.get("event_type") in ("configuration", "daemon")])

    def test_a_clock_that_is_wrong_by_a_year_leaves_the_age_of_an_event_right(self):
        self.bridge.stop()
        car = self.board.car
        self.board.stop(car)
        self.board.start_daemon(car, A_YEAR_AGO)
        self.broker.stop(signal.SIGKILL)
        self.start_bridge(before=A_YEAR_AGO)
        time.sleep(5)
        self.board.radio.talks = False
        happened = time.time()
        time.sleep(5)
        self.broker.start()
        came = lambda: [m for m in self.reader.of(self.event)
                        if json.loads(m[2]).get("now") == "wire_silent"]
        self.assertTrue(eventually(came), self.board.programs[car].poll())
        received, _, payload, _ = came()[-1]
        event = json.loads(payload)
        self.assertLess(abs(event["unix_time_us"] / 1e6 + YEAR_S - happened), 5)
        self.assertLess(abs(received - event["age_s"] - happened), 5)


class Refused(unittest.TestCase):
    """Brokers that do not want this program, and the reverse."""

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="tribus-mqtt-"))
        self.addCleanup(shutil.rmtree, self.folder)

    def broker(self, *lines):
        broker = Broker(self.folder, *lines)
        self.addCleanup(broker.stop)
        return broker

    def bridge(self, broker, *options, before=()):
        bridge = Bridge(self.folder, "--broker", f"127.0.0.1:{broker.port}", *options, before=before)
        self.addCleanup(bridge.stop)
        return bridge

    def expect(self, bridge, text):
        self.assertTrue(bridge.says(text), bridge.log.read_text())

    def test_certificates(self):
        for name in ("right", "wrong"):
            authority(self.folder, name)
        plain = ("allow_anonymous true", f"cafile {self.folder}/right-ca.pem",
                 f"certfile {self.folder}/right.pem", f"keyfile {self.folder}/right.key")
        broker, strict = self.broker(*plain), self.broker(*plain, "require_certificate true")
        right, wrong = self.folder / "right-ca.pem", self.folder / "wrong-ca.pem"
        own = ("--certificate", self.folder / "right.pem", "--key", self.folder / "right.key")
        foreign = ("--certificate", self.folder / "wrong.pem", "--key", self.folder / "wrong.key")
        self.expect(self.bridge(broker, "--ca", right), ": connected")
        self.expect(self.bridge(broker, "--ca", wrong), "its certificate is refused: it is not signed")
        self.expect(self.bridge(broker, "--tls"), "its certificate is refused: it is not signed")
        self.expect(self.bridge(broker, "--ca", right, before=A_YEAR_AGO),
                    "its certificate is refused")
        self.expect(self.bridge(strict, "--ca", right, *own), ": connected")
        self.expect(self.bridge(strict, "--ca", right), "it wants a certificate of this program")
        self.expect(self.bridge(strict, "--ca", right, *foreign), "it refuses the certificate in")
        no_tls = self.broker("allow_anonymous true")
        self.expect(self.bridge(no_tls, "--ca", right), "trying again")

    def test_passwords(self):
        passwords = self.folder / "passwords"
        passwords.touch(0o600)
        subprocess.run(["mosquitto_passwd", "-b", passwords, "boat", "right"], check=True)
        broker = self.broker("allow_anonymous false", f"password_file {passwords}")
        for word, said in (("right", ": connected"), ("wrong", "see --user and --password-file")):
            file = self.folder / word
            file.write_text(f"{word}\n")
            file.chmod(0o600)
            self.expect(self.bridge(broker, "--user", "boat", "--password-file", file), said)
        self.expect(self.bridge(broker), "see --user and --password-file")

    def test_wrong_use_says_what_is_allowed(self):
        secret = self.folder / "secret"
        secret.write_text("x")
        secret.chmod(0o644)
        for options, said in ((("--broker", "broker.local"), "--unencrypted"),
                              (("--broker", "mqtt://a"), "allowed: a name or an address"),
                              (("--certificate", "x"), "belong together"),
                              (("--prefix", "a/#"), "--prefix \"a/#\": allowed: 1 to 64 letters"),
                              (("--board", "b" * 65), "--board: allowed: a name of at most 64"),
                              (("--discovery", "+"), "--discovery \"+\": allowed: 1 to 64"),
                              (("--user", "u", "--password-file", str(secret)), "--password-file"),
                              (("--ca", "/nowhere", "--broker", "a"), "cannot be used")):
            ran = subprocess.run([PROGRAMS / "tribus-mqtt", "run", *options], capture_output=True,
                                 text=True, timeout=30, check=False)
            self.assertIn(ran.returncode, (1, 2), options)
            self.assertIn(said, ran.stderr, options)

    def test_a_broker_that_announces_256_mib_takes_no_memory(self):
        with socket.create_server(("127.0.0.1", 0)) as hostile:
            bridge = Bridge(self.folder, "--broker", f"127.0.0.1:{hostile.getsockname()[1]}")
            self.addCleanup(bridge.stop)
            hostile.settimeout(30)
            for _ in range(2):
                client, _ = hostile.accept()
                with client:
                    client.recv(1000)
                    # CONNACK; PUBLISH with the longest remaining length (MQTT 3.1.1, 2.2.3).
                    client.sendall(b"\x20\x02\x00\x00" + b"\x30\xff\xff\xff\x7f\x00\x01a")
                    try:
                        for _ in range(100):
                            client.sendall(bytes(1_000_000))
                    except OSError:
                        pass
                self.assertLess(bridge.memory_kib(), 20_000)
            self.expect(bridge, "announces a message for which this program has no memory")
            self.assertEqual(bridge.stop(), 0)

    def test_a_broker_that_never_answers_costs_little_and_holds_nothing_up(self):
        with socket.socket() as silent:
            silent.bind(("127.0.0.1", 0))
            silent.listen()
            bridge = Bridge(self.folder, "--broker", f"127.0.0.1:{silent.getsockname()[1]}")
            self.addCleanup(bridge.stop)
            time.sleep(5)
            self.assertLess(bridge.memory_kib(), 20_000)
            begun = time.monotonic()
            self.assertEqual(bridge.stop(), 0)
            self.assertLess(time.monotonic() - begun, 10)


if __name__ == "__main__":
    unittest.main()

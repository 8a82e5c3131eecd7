# Debian packages: mosquitto prometheus python3-paho-mqtt
"""200 boards on one mosquitto and one Prometheus: nothing is lost, and what it costs.

Each board has a real `tribus-mqtt` and a real `tribus-web`; its daemon is replayed, because 200 of
them and their wires are too much for two processors. TRIBUS_BOARDS is another number of boards."""
import collections
import ctypes
import json
import os
import pathlib
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.request

from board import PROGRAMS, Prometheus, end_with_this_process, eventually
from broker import Broker, Reader
from replayed_boards import METRIC, NAME, record

BOARDS = int(os.environ.get("TRIBUS_BOARDS", "200"))
SEED = 26
# All in seconds from the first failsafe on.
BROKER_AWAY = (15, 25)
ALERTS_ARE_COMPARED = 48
LAST_SHORT_FAILSAFE, LONG_FAILSAFE = 50, 52
QUIET = (65, 125)
# An alert of a failsafe that is over lasts a minute, and a scrape and its judgement take 5 s each.
ALERT_LASTS_S = 60
SLACK_S = 15
SCRAPES_S = 5
NEW_NAMESPACE_OF_MOUNTS = 0x00020000  # CLONE_NEWNS


def plan_episodes():
    """For each board the times at which its wire is pulled and returns. Half of them never lose it;
    a tenth is in failsafe at the end."""
    chance = random.Random(SEED)
    for at in range(BOARDS):
        episodes, begin = [], chance.uniform(0, 15)
        while at % 2 == 0 and begin < LAST_SHORT_FAILSAFE - 3:
            end = min(begin + chance.uniform(2, 12), LAST_SHORT_FAILSAFE)
            episodes.append((begin, end))
            begin = end + chance.uniform(3, 20)
        if at % 10 == 0:
            episodes.append((LONG_FAILSAFE, 1e9))
        yield episodes


def hide_other_daemons():
    """Each of the boards would see what root runs on this machine, and take its places for clients.
    Daemons of root are in /run, which is another one from here on for this process."""
    if os.geteuid() == 0 and ctypes.CDLL(None).unshare(NEW_NAMESPACE_OF_MOUNTS) == 0:
        subprocess.run(["mount", "--make-rprivate", "/"], check=True)
        subprocess.run(["mount", "-t", "tmpfs", "none", "/run"], check=True)


class Cost:
    """Processor time and memory of some processes of one kind."""

    def __init__(self, processes):
        self.ids = [process.pid for process in processes]

    def processor_s(self):
        """Of all of them together. The kernel counts nanoseconds here, and not ticks, which short
        work falls between."""
        return sum(int(file.read_text().split()[0]) for one in self.ids
                   for file in pathlib.Path(f"/proc/{one}/task").glob("*/schedstat")) / 1e9

    def resident_kib(self):
        """Of each, on average."""
        return sum(self._kib(one, "Rss") for one in self.ids) / len(self.ids)

    def share_kib(self):
        """Of each, on average: what several processes share is divided among them."""
        return sum(self._kib(one, "Pss") for one in self.ids) / len(self.ids)

    @staticmethod
    def _kib(one, field):
        text = pathlib.Path(f"/proc/{one}/smaps_rollup").read_text()
        return int(re.search(rf"^{field}: +(\d+)", text, re.M)[1])


class Fleet:
    """All boards with their bridges and pages, the broker, its reader, and Prometheus."""

    def __init__(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="tribus-scale-"))
        self.processes = collections.defaultdict(list)
        self.names = [f"board{at:05}" for at in range(BOARDS)]
        for name in self.names:
            (self.folder / name / "tribus").mkdir(parents=True)
        for name in ("configurations", "page"):
            (self.folder / name).mkdir()
        (self.folder / "page/index.html").write_text("the page")
        self.broker = self.reader = self.counts = self.prometheus = None

    def start(self):
        self._start_boards()
        # mosquitto drops what exceeds 1000 messages for a reader that is slow or not there.
        self.broker = Broker(self.folder, "allow_anonymous true", "max_queued_messages 100000",
                             keeps=("autosave_interval 3600",))
        self.reader = Reader(self.broker.port, "tribus/#", "homeassistant/#")
        for name in self.names:
            self._start("bridge", name, "tribus-mqtt", "run", "--board", name, "--broker",
                        f"127.0.0.1:{self.broker.port}")
            self._start("web", name, "tribus-web", "serve", "--metrics", "--listen", "127.0.0.1:0",
                        "--configurations", self.folder / "configurations",
                        "--state", self.folder / name / "state", "--page", self.folder / "page")
        self.ports = {self._port(name): name for name in self.names}
        self.prometheus = Prometheus(*self.ports, impatient=False,
                                     options=["--web.enable-admin-api"])
        assert eventually(self.prometheus.is_ready), "Prometheus does not answer"

    def _start_boards(self):
        recorded = self.folder / "recorded"
        recorded.mkdir()
        recording = record(recorded)
        # Each sample, and that the daemon answers.
        self.samples = 1 + len(METRIC.findall(recording["moments"][0][1]))
        boards = [{"name": name, "socket": str(self.folder / name / "tribus" / f"{NAME}.sock"),
                   "episodes": episodes} for name, episodes in zip(self.names, plan_episodes())]
        (self.folder / "plan.json").write_text(
            json.dumps({"recording": recording, "boards": boards}))
        self.boards = subprocess.Popen(  # pylint: disable=consider-using-with
            [sys.executable, pathlib.Path(__file__).with_name("replayed_boards.py"), self.folder],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
            preexec_fn=end_with_this_process)
        assert self.boards.stdout.readline() == "ready\n", "the boards do not start"

    def _start(self, kind, name, program, *options):
        with open(self.folder / name / f"{kind}.log", "wb") as log:
            self.processes[kind].append(subprocess.Popen(  # pylint: disable=consider-using-with
                [PROGRAMS / program, *options], stdin=subprocess.DEVNULL, stdout=log, stderr=log,
                env=os.environ | {"XDG_RUNTIME_DIR": str(self.folder / name)},
                preexec_fn=end_with_this_process))

    def _port(self, name):
        log = self.folder / name / "web.log"
        found = eventually(lambda: re.search(r"http://127\.0\.0\.1:(\d+)", log.read_text()))
        assert found, log.read_text()
        return int(found[1])

    def go(self):
        self.boards.stdin.write("go\n")
        self.boards.stdin.flush()
        self.begin, self.begin_wall = time.monotonic(), time.time()

    def wait_until(self, since_go):
        time.sleep(max(0, self.begin + since_go - time.monotonic()))

    def journal(self):
        """What happened at each board: kind, part, now, before, its time in us, and when it was
        said."""
        happened = collections.defaultdict(list)
        for line in (self.folder / "journal").read_text().splitlines():
            name, *change = json.loads(line)
            happened[name].append(tuple(change))
        return happened

    def in_failsafe(self, begin, end):
        """Names of the boards that were in failsafe between two times of the clock."""
        found = set()
        for name, happened in self.journal().items():
            since = None
            for kind, _, now, _, at_us, _ in [*happened, ("output", "", "end", "", 1e18, 0)]:
                if kind == "output":
                    if since is not None and since < end and at_us / 1e6 > begin:
                        found.add(name)
                    since = at_us / 1e6 if now == "failsafe" else None
        return found

    def alarmed(self):
        """Names of the boards for which the alert of a failsafe fires."""
        return {self.ports[int(labels["instance"].rpartition(":")[2])]
                for labels in self.prometheus.firing(alertname="TribusOutputInFailsafe")}

    def available(self):
        """Names of the boards whose bridge and daemon are there, as the reader was told last."""
        with self.reader.lock:
            last = {message[1]: message[2] for message in self.reader.messages
                    if message[1].endswith("/availability")}
        return {name for name in self.names
                if last.get(f"tribus/{name}/availability")
                == last.get(f"tribus/{name}/{NAME}/availability") == "online"}

    def events(self):
        """Those that arrived, by boards: each with the time at which it came."""
        came = collections.defaultdict(list)
        with self.reader.lock:
            messages = list(self.reader.messages)
        for at, topic, payload, _ in messages:
            if topic.endswith("/event"):
                came[topic.split("/")[1]].append((at, json.loads(payload)))
        return came

    def close(self):
        if self.prometheus:
            self.prometheus.close()
        everything = [one for kind in self.processes.values() for one in kind]
        for one in everything:
            one.terminate()
        for one in everything:
            one.wait(60)
        for one in (self.reader, self.counts):
            if one:
                one.close()
        if self.broker:
            self.broker.stop()
        self.boards.stdin.close()
        self.boards.wait(30)
        self.boards.stdout.close()
        shutil.rmtree(self.folder)


def quantile(numbers, part):
    ordered = sorted(numbers)
    return ordered[min(int(len(ordered) * part), len(ordered) - 1)] if ordered else float("nan")


class Scale(unittest.TestCase):
    """One run, of which each test looks at something else."""

    @classmethod
    def setUpClass(cls):
        hide_other_daemons()
        cls.table = [("boards", f"{BOARDS}")]
        cls.fleet = Fleet()
        cls.addClassCleanup(cls.fleet.close)
        cls.addClassCleanup(cls.print_table)
        cls.fleet.start()
        assert eventually(lambda: len(cls.fleet.available()) == BOARDS, 120, 1)
        assert eventually(lambda: cls.up() == BOARDS, 60, 1)
        # Subscriptions outlive the kill.
        cls.fleet.broker.process.send_signal(signal.SIGUSR1)
        time.sleep(2)
        cls.fleet.go()
        cls.kill_the_broker()
        cls.fleet.wait_until(ALERTS_ARE_COMPARED)
        cls.alarmed, cls.compared = cls.fleet.alarmed(), time.time()
        cls.measure_the_quiet_time()

    @classmethod
    def kill_the_broker(cls):
        cls.fleet.wait_until(BROKER_AWAY[0])
        cls.fleet.broker.stop(signal.SIGKILL)
        cls.fleet.wait_until(BROKER_AWAY[1])
        cls.fleet.broker.start()
        restarted = time.time()

        def back():
            """When each bridge said again that it is there."""
            first = {}
            with cls.fleet.reader.lock:
                for at, topic, payload, message in cls.fleet.reader.messages:
                    if (at > restarted and not message.retain and payload == "online"
                            and re.fullmatch(r"tribus/[^/]+/availability", topic)):
                        first.setdefault(topic, at)
            return first
        eventually(lambda: len(back()) == BOARDS, 60, 0.5)
        cls.back = back()
        times = sorted(cls.back.values())
        busiest = max(sum(begin <= one < begin + 1 for one in times) for begin in times)
        cls.table += [
            ("bridges back: the first, the last", " and ".join(
                f"{one - restarted:.1f}" for one in (times[0], times[-1])) + " s after the start"),
            ("of these in the busiest second", f"{busiest}")]

    @classmethod
    def up(cls):
        return sum(value for _, value in cls.fleet.prometheus.now('up{job="tribus"}'))

    @classmethod
    def own_metric(cls, name):
        address = f"http://{cls.fleet.prometheus.address}/metrics"
        with urllib.request.urlopen(address, timeout=10) as answer:
            return sum(float(value) for value in re.findall(
                rf"^{name}(?:\{{.*\}})? (\S+)$", answer.read().decode(), re.M))

    @classmethod
    def broker_counts(cls):
        """The broker's newest counts, and when it told them."""
        last = {}
        with cls.fleet.counts.lock:
            for at, topic, payload, _ in cls.fleet.counts.messages:
                last[topic.removeprefix("$SYS/broker/")] = (at, payload)
        return last

    @classmethod
    def measure_the_quiet_time(cls):
        fleet = cls.fleet
        costs = {"mosquitto": Cost([fleet.broker.process]),
                 "Prometheus": Cost([fleet.prometheus.process]),
                 "a tribus-mqtt": Cost(fleet.processes["bridge"]),
                 "a tribus-web": Cost(fleet.processes["web"]),
                 "all replayed daemons": Cost([fleet.boards])}
        fleet.wait_until(QUIET[0])
        fleet.counts = Reader(fleet.broker.port, "$SYS/broker/#")
        # mosquitto tells its counts each 10 s.
        begun = eventually(lambda: "bytes/sent" in cls.broker_counts() and cls.broker_counts())
        load, began = os.getloadavg(), time.monotonic()
        before = {name: cost.processor_s() for name, cost in costs.items()}
        samples = cls.own_metric("prometheus_tsdb_head_samples_appended_total")
        fleet.wait_until(QUIET[1])
        lasted = time.monotonic() - began
        used = {name: cost.processor_s() - before[name] for name, cost in costs.items()}
        cls.samples_s = (cls.own_metric("prometheus_tsdb_head_samples_appended_total")
                         - samples) / lasted
        cls.table.append(("load of the machine before and after", "%.1f and %.1f" % (
            load[0], os.getloadavg()[0])))
        ended = cls.broker_counts()
        for title, topic in (("messages a second to the broker", "publish/messages/received"),
                             ("messages a second to the reader", "publish/messages/sent"),
                             ("bytes a second to the broker", "bytes/received"),
                             ("bytes a second from the broker", "bytes/sent")):
            (first, low), (last, high) = begun[topic], ended[topic]
            rate = (int(high) - int(low)) / (last - first) if last > first else float("nan")
            cls.table.append((title, f"{rate:.0f}"))
        for name, cost in costs.items():
            cls.table.append((name, "%.3f %% of a processor, %.0f KiB resident, share %.0f KiB" % (
                100 * used[name] / lasted / len(cost.ids), cost.resident_kib(), cost.share_kib())))

    @classmethod
    def print_table(cls):
        width = max(len(title) for title, _ in cls.table)
        print("\n" + "\n".join(f"{title:{width}}  {said}" for title, said in cls.table), flush=True)

    def test_each_event_arrives_once_in_order_with_its_time(self):
        happened = self.fleet.journal()
        expected = sum(map(len, happened.values()))
        self.assertGreater(expected, BOARDS)

        def ids():
            return {event["id"] for told in self.fleet.events().values() for _, event in told}
        eventually(lambda: len(ids()) >= expected, 60, 1)
        came = self.fleet.events()
        self.assertFalse(set(came) - set(happened), "events of boards at which nothing happened")
        delays, late, twice = [], 0, 0
        for name, changes in happened.items():
            told = {}
            for at, event in came[name]:
                twice += event["id"] in told
                told.setdefault(event["id"], (at, event))
            late += sum(event["late"] for _, event in told.values())
            with self.subTest(name):
                self.assertEqual(
                    [(event["event_type"], event["name"], event["now"], event["before"],
                      event["unix_time_us"]) for _, event in told.values()],
                    [change[:5] for change in changes])
                self.assertFalse([event for _, event in told.values() if "lost_before" in event])
                delays += [at - change[5] / 1e6 for (at, event), change
                           in zip(told.values(), changes) if not event["late"]]
        self.assertGreater(late, 0, "nothing happened while the broker was away")
        self.table += [
            ("events: happened, arrived", f"{expected}, {len(ids())}"),
            ("of these late, and twice", f"{late}, {twice}"),
            ("from a status of the daemon to the reader", "%.1f ms (p50), %.1f (p99)" % (
                1000 * quantile(delays, 0.5), 1000 * quantile(delays, 0.99)))]

    def test_each_board_is_available_after_the_broker_was_away(self):
        self.assertEqual(len(self.back), BOARDS)
        self.assertEqual(len(self.fleet.available()), BOARDS)

    def test_prometheus_has_each_series_of_each_board(self):
        self.assertEqual(self.up(), BOARDS)
        series = int(self.fleet.prometheus.now(
            'count({job="tribus",__name__=~"tribus_.*"})')[0][1])
        self.assertEqual(series, self.fleet.samples * BOARDS)
        # Five that Prometheus adds for each target: up, the duration, and three counts.
        series += 5 * BOARDS
        head = self.own_metric("prometheus_tsdb_head_series")
        self.assertGreater(head, series)
        # The rest comes from rules.
        self.assertGreater(self.samples_s, series / SCRAPES_S * 0.8)
        failed = self.fleet.prometheus.now('sum(count_over_time(up[3m]) - sum_over_time(up[3m]))')
        took = [self.fleet.prometheus.now(query % 'scrape_duration_seconds{job="tribus"}')[0][1]
                for query in ("quantile(0.5, %s)", "quantile(0.99, %s)", "max(%s)")]
        self.table += [
            ("samples a scrape of a board", f"{self.fleet.samples}"),
            ("samples a second", f"{self.samples_s:.0f}; of scrapes {series / SCRAPES_S:.0f}"),
            ("series in memory", f"{head:.0f}; of scrapes {series}"),
            ("a scrape", "%.1f ms (p50), %.1f (p99), %.1f at most" % tuple(
                1000 * one for one in took)),
            ("scrapes that failed", f"{failed[0][1]:.0f}")]
        self.measure_the_disk()

    def measure_the_disk(self):
        """A snapshot writes what is in memory as Prometheus does each two hours."""
        request = urllib.request.Request(
            f"http://{self.fleet.prometheus.address}/api/v1/admin/tsdb/snapshot", method="POST")
        with urllib.request.urlopen(request, timeout=60) as answer:
            name = json.load(answer)["data"]["name"]
        data = self.fleet.prometheus.folder / "data"
        counts, chunks = collections.Counter(), 0
        for block in (data / "snapshots" / name).iterdir():
            counts.update(json.loads((block / "meta.json").read_text())["stats"])
            chunks += sum(file.stat().st_size for file in (block / "chunks").iterdir())
        log = sum(file.stat().st_size for file in (data / "wal").iterdir() if file.is_file())
        self.table.append(("bytes a sample", "%.2f in a block, %.1f in the log before" % (
            chunks / counts["numSamples"], log / counts["numSamples"])))

    def test_alerts_fire_for_boards_in_failsafe_and_for_no_other(self):
        surely = self.fleet.in_failsafe(self.compared - ALERT_LASTS_S + SLACK_S,
                                        self.compared - SLACK_S)
        perhaps = self.fleet.in_failsafe(self.compared - ALERT_LASTS_S - SLACK_S, self.compared)
        self.assertTrue(surely)
        self.assertLess(len(perhaps), BOARDS)
        self.assertLessEqual(surely, self.alarmed)
        self.assertLessEqual(self.alarmed, perhaps)
        now = time.time()
        remain = self.fleet.in_failsafe(now, now)
        self.assertEqual(len(remain), (BOARDS + 9) // 10)
        eventually(lambda: self.fleet.alarmed() == remain, ALERT_LASTS_S, 1)
        self.assertEqual(self.fleet.alarmed(), remain)
        others = {labels["alertname"] for labels in self.fleet.prometheus.firing()}
        self.table.append(("alerts amid the failsafes, at the end", "%d and %d boards; fire: %s" % (
            len(self.alarmed), len(remain), ", ".join(sorted(others)))))


if __name__ == "__main__":
    unittest.main()

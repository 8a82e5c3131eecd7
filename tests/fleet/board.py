"""A board whose wires are pseudo-terminals, its page's server, and a Prometheus that scrapes it."""
import ctypes
import json
import os
import pathlib
import pty
import re
import shutil
import signal
import socket
import subprocess
import tempfile
import threading
import time
import tty
import urllib.error
import urllib.parse
import urllib.request

ROOT = pathlib.Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "deploy/prometheus"
PROGRAMS = pathlib.Path(os.environ["TRIBUS_PROGRAMS"])


def eventually(answer, seconds=60, pause_s=0.2):
    """What `answer` says as soon as that is true, or at the end of the time."""
    until = time.monotonic() + seconds
    while not (said := answer()) and time.monotonic() < until:
        time.sleep(pause_s)
    return said


def ibus_frame(channels):
    """An i.Bus frame of 14 channels, by the layout of docs/protocols/ibus.md."""
    body = b"\x20\x40" + b"".join(pulse.to_bytes(2, "little") for pulse in channels)
    return body + (0xFFFF - sum(body)).to_bytes(2, "little")


def battery_frame(volts):
    """A CRSF frame of the battery, by the layout of docs/protocols/crsf.md."""
    body = b"\x08" + round(volts * 10).to_bytes(2, "big") + bytes(6)
    check = 0
    for byte in body:
        check ^= byte
        for _ in range(8):
            check = (check << 1 ^ (0xD5 if check & 0x80 else 0)) & 0xFF
    return bytes([0xC8, len(body) + 1]) + body + bytes([check])


def end_with_this_process():
    """A daemon that outlives its test opens the ptys of others under its old names."""
    ctypes.CDLL(None).prctl(1, signal.SIGKILL)  # PR_SET_PDEATHSIG


class Wire:
    """A pseudo-terminal: the program has `device`, the other end is here."""

    def __init__(self, frame=None, period_s=None):
        self.end, self.inner = pty.openpty()
        tty.setraw(self.inner)
        os.set_blocking(self.end, False)
        self.device = os.ttyname(self.inner)
        self.frame, self.period_s = frame, period_s
        self.talks = frame is not None
        self.ended = False
        self.thread = threading.Thread(target=self._run)
        self.thread.start()

    def _run(self):
        """Sends while it talks, and takes what comes, so that the wire never fills."""
        while not self.ended:
            try:
                if self.talks:
                    os.write(self.end, self.frame)
                os.read(self.end, 4096)
            except BlockingIOError:
                pass
            time.sleep(self.period_s or 0.02)

    def close(self):
        self.ended = True
        self.thread.join()
        os.close(self.end)
        os.close(self.inner)


class Thread:
    """A thread of another process that stands still, as one that hangs: while `with`."""
    SEIZE, INTERRUPT, DETACH, ALL_THREADS = 0x4206, 0x4207, 17, 0x40000000

    def __init__(self, process, name):
        tasks = pathlib.Path(f"/proc/{process.pid}/task").iterdir()
        self.id = next(int(task.name) for task in tasks
                       if (task / "comm").read_text().strip() == name)
        self.ptrace = ctypes.CDLL(None, use_errno=True).ptrace
        self.ptrace.argtypes = [ctypes.c_long, ctypes.c_long, ctypes.c_void_p, ctypes.c_void_p]

    def _ask(self, request):
        if self.ptrace(request, self.id, None, None) != 0:
            raise OSError(ctypes.get_errno(), f"ptrace {request:#x} of thread {self.id}")

    def __enter__(self):
        self._ask(self.SEIZE)
        self._ask(self.INTERRUPT)
        os.waitpid(self.id, self.ALL_THREADS)

    def __exit__(self, *_):
        self._ask(self.DETACH)


RADIO_TO_SERVOS = """
[input.radio]
protocol = "ibus"
device   = "{radio.device}"
timeout  = "500ms"
[output.servos]
protocol = "sbus"
device   = "{servos.device}"
[pipeline.main]
from = "radio"
to   = "servos"
"""
# The daemon `car` has all that it needs. `spare` waits for a receiver that never comes and for a bus
# that this machine does not have.
CAR = RADIO_TO_SERVOS + """
[values.pack]
protocol = "crsf-telemetry"
device   = "{pack.device}"
timeout  = "2s"
[sensor_bus.handset]
device = "{handset.device}"
role   = "sensor"
[[sensor_bus.handset.sensor]]
type  = "external_voltage"
value = "pack.battery.voltage"
"""
SPARE = """
[input.late]
protocol = "ibus"
address  = "127.0.0.1:{port}"
[output.bus]
protocol  = "can"
interface = "nobus0"
[pipeline.main]
from = "late"
to   = "bus"
"""


def free_port(kind=socket.SOCK_STREAM):
    with socket.socket(socket.AF_INET, kind) as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


class Board:
    """Two daemons and `tribus-web serve --metrics`. Its daemons have names of their own on this machine."""

    def __init__(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="tribus-fleet-"))
        self.radio = Wire(ibus_frame([1500] * 14), 0.007)
        self.servos = Wire()
        self.pack = Wire(battery_frame(12.5), 0.2)
        self.handset = Wire()
        self.car, self.spare = f"car-{os.getpid()}", f"spare-{os.getpid()}"
        for folder in ("configurations", "state", "page", "run/tribus"):
            (self.folder / folder).mkdir(parents=True)
        (self.folder / "page/index.html").write_text("the page")
        self._file(self.car).write_text(CAR.format(**vars(self)))
        self._file(self.spare).write_text(SPARE.format(port=free_port(socket.SOCK_DGRAM)))
        self.programs = {}
        self.start_daemon(self.car)
        self.start_daemon(self.spare)
        self.port = 0
        self.start_web()
        self.port = int(self._says("web", r"the page is at http://127\.0\.0\.1:(\d+)")[1])

    def _file(self, name):
        return self.folder / "configurations" / f"{name}.toml"

    def _start(self, name, command):
        log = open(self.folder / f"{name}.log", "ab")  # pylint: disable=consider-using-with
        environment = os.environ | {"XDG_RUNTIME_DIR": str(self.folder / "run")}
        self.programs[name] = subprocess.Popen(  # pylint: disable=consider-using-with
            command, stdin=subprocess.DEVNULL, stdout=log, stderr=log, env=environment,
            preexec_fn=end_with_this_process)
        log.close()

    def _says(self, name, pattern):
        """The first place in the log of a program that runs."""
        log = self.folder / f"{name}.log"
        found = eventually(lambda: re.search(pattern, log.read_text())
                           or self.programs[name].poll() is not None and "ended")
        if not isinstance(found, re.Match):
            raise RuntimeError(f"{name} does not run: {log.read_text()}")
        return found

    def start_daemon(self, name, before=()):
        self._start(name, [*before, PROGRAMS / "tribus", "run", self._file(name), "--socket",
                           self.folder / "run/tribus" / f"{name}.sock"])
        self._says(name, r" info started ")

    def start_another(self, word, text):
        """A daemon with that configuration; its name."""
        name = f"{word}-{os.getpid()}"
        self._file(name).write_text(text)
        self.start_daemon(name)
        return name

    def watch(self, name):
        """A function that says all changes that the daemon has told from now on."""
        file = self.folder / f"{name}.changes"
        with open(file, "wb") as out:
            self.programs[f"watch of {name}"] = subprocess.Popen(  # pylint: disable=consider-using-with
                [PROGRAMS / "tribus", "status", "--watch", "--format", "json", "--socket",
                 self.folder / "run/tribus" / f"{name}.sock"],
                stdin=subprocess.DEVNULL, stdout=out, stderr=out, preexec_fn=end_with_this_process)
        assert eventually(lambda: file.stat().st_size), "the watch says nothing"
        return lambda: [one for one in map(json.loads, file.read_text().splitlines()[:-1])
                        if one["type"] == "change"]

    def start_web(self):
        self._start("web", [PROGRAMS / "tribus-web", "serve", "--metrics", "--listen",
                            f"127.0.0.1:{self.port}", "--configurations",
                            self.folder / "configurations", "--state", self.folder / "state",
                            "--page", self.folder / "page"])

    def send(self, name, number):
        self.programs[name].send_signal(number)

    def stop(self, name, number=signal.SIGTERM):
        if self.programs[name].poll() is None:
            self.send(name, number)
            self.send(name, signal.SIGCONT)
        self.programs[name].wait(30)

    def metrics(self):
        with urllib.request.urlopen(f"http://127.0.0.1:{self.port}/metrics", timeout=10) as answer:
            return answer.read().decode()

    def close(self):
        for name in self.programs:
            self.stop(name)
        for wire in (self.radio, self.servos, self.pack, self.handset):
            wire.close()
        shutil.rmtree(self.folder)


class Prometheus:
    """Debian's, with the example's configuration and rules. An impatient one scrapes each 3 s, the
    least for daemons that hang, and its alerts wait 1 s."""

    def __init__(self, *ports, impatient=True, options=()):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="tribus-prometheus-"))
        targets = json.dumps([f"127.0.0.1:{port}" for port in ports])
        changes = [(r'targets: \["127.0.0.1:8480"\]', f"targets: {targets}")]
        if impatient:
            changes += [(r"scrape_interval: \w+", "scrape_interval: 3s"),
                        (r"scrape_timeout: \w+", "scrape_timeout: 3s"),
                        (r"evaluation_interval: \w+", "evaluation_interval: 1s")]
        self._copy("prometheus.yml", changes)
        self._copy("tribus.rules.yml", [(r" for: \w+", " for: 1s")] if impatient else [])
        self.address = f"127.0.0.1:{free_port()}"
        with open(self.folder / "log", "wb") as log:
            self.process = subprocess.Popen(  # pylint: disable=consider-using-with
                ["prometheus", f"--config.file={self.folder}/prometheus.yml",
                 f"--storage.tsdb.path={self.folder}/data", f"--web.listen-address={self.address}",
                 "--log.level=warn", *options], stdout=log, stderr=log,
                preexec_fn=end_with_this_process)

    def _copy(self, name, changes):
        text = (EXAMPLES / name).read_text()
        for pattern, instead in changes:
            text, count = re.subn(pattern, instead, text)
            assert count > 0, f"{name} has no {pattern}"
        (self.folder / name).write_text(text)

    def ask(self, path, **parameters):
        address = f"http://{self.address}/api/v1/{path}?{urllib.parse.urlencode(parameters)}"
        try:
            with urllib.request.urlopen(address, timeout=10) as answer:
                return json.load(answer)["data"]
        except urllib.error.HTTPError as error:
            raise AssertionError(f"{parameters}: {error.read().decode()}") from error

    def is_ready(self):
        try:
            with urllib.request.urlopen(f"http://{self.address}/-/ready", timeout=10) as answer:
                return answer.status == 200
        except OSError:
            return False

    def now(self, query):
        """The samples of an instant query: a list of labels, and of numbers."""
        return [(sample["metric"], float(sample["value"][1]))
                for sample in self.ask("query", query=query)["result"]]

    def range(self, query, seconds=5):
        """The series of a query over the last seconds."""
        end = time.time()
        return self.ask("query_range", query=query, start=end - seconds, end=end, step=1)["result"]

    def firing(self, **labels):
        """Labels of the alerts that fire and have these."""
        return [alert["labels"] for alert in self.ask("alerts")["alerts"]
                if alert["state"] == "firing" and labels.items() <= alert["labels"].items()]

    def close(self):
        self.process.terminate()
        self.process.wait(30)
        shutil.rmtree(self.folder)

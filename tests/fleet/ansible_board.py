"""A board on this machine: a daemon on ptys, a receiver that sends i.Bus, servos that hear SBUS."""

import ctypes
import fcntl
import json
import os
import pathlib
import pty
import signal
import subprocess
import termios
import threading
import time
import tty

SOURCES = pathlib.Path(__file__).resolve().parents[2]
TRIBUS = str(pathlib.Path(os.environ.get("TRIBUS_PROGRAMS", SOURCES / "build/app")) / "tribus")
PATIENCE_S = 60


def ibus_frame(first_us):
    body = bytes([0x20, 0x40]) + first_us.to_bytes(2, "little") + (1500).to_bytes(2, "little") * 13
    return body + (0xFFFF - sum(body)).to_bytes(2, "little")


def wait_for(what, done, patience_s=PATIENCE_S):
    end = time.monotonic() + patience_s
    while True:
        result = done()
        if result:
            return result
        if time.monotonic() > end:
            raise AssertionError("not within %d s: %s" % (
                patience_s, what() if callable(what) else what))
        time.sleep(0.1)


def die_with_the_test():
    """One that outlives its test opens ptys of later tests, when their numbers come again."""
    ctypes.CDLL(None).prctl(1, signal.SIGKILL)  # PR_SET_PDEATHSIG


class Wire:
    """A pty whose near end is a device of the daemon, under a name of its own."""

    def __init__(self, path):
        self.path = path
        self.far, self.near = pty.openpty()
        tty.setraw(self.near, termios.TCSANOW)
        flags = fcntl.fcntl(self.far, fcntl.F_GETFL)
        fcntl.fcntl(self.far, fcntl.F_SETFL, flags | os.O_NONBLOCK)
        os.symlink(os.ttyname(self.near), path)

    def close(self):
        os.close(self.far)
        os.close(self.near)


class Board:
    """Two receivers, of which the second is silent unless told, and one bank of servos."""

    def __init__(self, folder, name):
        self.name = name
        self.folder = folder / name
        self.folder.mkdir()
        self.file = self.folder / "servos.toml"
        self.socket = self.folder / "control"
        self.wires = {part: Wire(self.folder / part) for part in ("main", "spare", "servos")}
        self.sends = {"main"}
        self.heard = b""
        self.ends = False
        self.file.write_text(self.configuration())
        self.log = open(self.folder / "log", "w", encoding="utf-8")
        self.thread = threading.Thread(target=self._live, daemon=True)
        self.thread.start()
        self.start()

    def start(self):
        self.daemon = subprocess.Popen(
            [TRIBUS, "run", self.file, "--socket", self.socket], stderr=self.log,
            preexec_fn=die_with_the_test)
        wait_for(lambda: "control at the start; the daemon says:\n" + self.said(),
                 self.in_control)

    def configuration(self, main="", spare="", pipeline="", sources=("main", "spare"), extra=""):
        """Long timeouts: a busy machine must not look like a loss."""
        text = ""
        for name, more in (("main", main), ("spare", spare)):
            if name not in sources:
                continue
            protocol = "" if "protocol" in more else 'protocol = "ibus"\n'
            text += '[input.%s]\n%sdevice = "%s"\ntimeout = "5s"\n%s\n' % (
                name, protocol, self.wires[name].path, more)
        text += '[output.servos]\nprotocol = "sbus"\ndevice = "%s"\n' % self.wires["servos"].path
        return text + '[pipeline.main]\nfrom = %s\nto = "servos"\n%s\n%s' % (
            json.dumps(sources), pipeline, extra)

    def _live(self):
        frame = ibus_frame(1100)
        while not self.ends:
            for name in tuple(self.sends):
                try:
                    os.write(self.wires[name].far, frame)
                except BlockingIOError:
                    pass
            try:
                self.heard = (self.heard + os.read(self.wires["servos"].far, 4096))[-200:]
            except BlockingIOError:
                pass
            time.sleep(0.007)

    def status(self):
        asked = subprocess.run([TRIBUS, "status", "--socket", self.socket, "--format", "json"],
                               stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=False)
        return json.loads(asked.stdout) if asked.returncode == 0 else None

    def in_control(self):
        status = self.status()
        return status and status["outputs"][0]["state"] == "control"

    def said(self):
        return (self.folder / "log").read_text(encoding="utf-8")

    def names(self):
        """What is in its folder, but for the place of drafts, which the daemon makes."""
        return sorted(path.name for path in self.folder.iterdir())

    def end(self):
        if self.daemon.poll() is None:
            self.daemon.send_signal(signal.SIGTERM)
            self.daemon.wait(PATIENCE_S)
        self.ends = True
        self.thread.join()
        for wire in self.wires.values():
            wire.close()
        self.log.close()

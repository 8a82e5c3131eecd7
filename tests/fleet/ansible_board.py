"""A board for configurations: one daemon with two receivers, of which the second is silent unless
told, and one bank of servos."""
import json
import signal
import subprocess

from board import PROGRAMS, ROOT, Wire, end_with_this_process, eventually, ibus_frame

TRIBUS = str(PROGRAMS / "tribus")
PATIENCE_S = 60


def wait_for(what, done):
    result = eventually(done, PATIENCE_S)
    assert result, "not within %d s: %s" % (PATIENCE_S, what() if callable(what) else what)
    return result


class Board:
    def __init__(self, folder, name):
        self.name = name
        self.folder = folder / name
        self.folder.mkdir()
        self.file = self.folder / "servos.toml"
        self.socket = self.folder / "control"
        frame = ibus_frame([1100] + [1500] * 13)
        self.wires = {"main": Wire(frame, 0.007), "spare": Wire(frame, 0.007), "servos": Wire()}
        self.wires["spare"].talks = False
        self.file.write_text(self.configuration())
        self.log = open(self.folder / "log", "w", encoding="utf-8")
        self.start()

    def start(self):
        self.daemon = subprocess.Popen(
            [TRIBUS, "run", self.file, "--socket", self.socket], stderr=self.log,
            preexec_fn=end_with_this_process)
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
                name, protocol, self.wires[name].device, more)
        text += '[output.servos]\nprotocol = "sbus"\ndevice = "%s"\n' % self.wires["servos"].device
        return text + '[pipeline.main]\nfrom = %s\nto = "servos"\n%s\n%s' % (
            json.dumps(sources), pipeline, extra)

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
        for wire in self.wires.values():
            wire.close()
        self.log.close()

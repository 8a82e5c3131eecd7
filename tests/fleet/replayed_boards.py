"""Many boards on one machine: what one real daemon said is recorded and said again by each of them,
with names, clocks, ages and counters of its own. As a program: serves their control sockets."""
import asyncio
import json
import pathlib
import re
import socket
import subprocess
import sys
import time

from board import PROGRAMS, RADIO_TO_SERVOS, Wire, end_with_this_process, eventually, ibus_frame

NAME = "servos"
PERIOD_S = 0.2
# Fields of a status that count from the daemon's start (docs/status.md).
COUNTERS = {"bytes", "frames", "frame_lost_frames", "failsafe_frames", "skipped_bytes",
            "device_losses", "overruns", "deadline_misses", "foreign_frames", "failsafe_entries",
            "recoveries", "changeovers", "rejected", "losses", "dropped"}
SLOT = re.compile(r'"slot ([a-z]+) ?(\d*)"')
METRIC = re.compile(r"^(tribus_(\w+?)(?:\{.*\})?) (\S+)$", re.M)


class Daemon:
    """A real one: i.Bus in, SBUS out, on pseudo-terminals."""

    def __init__(self, folder):
        self.radio, self.servos = Wire(ibus_frame([1500] * 14), 0.007), Wire()
        (folder / f"{NAME}.toml").write_text(RADIO_TO_SERVOS.format(**vars(self)))
        self.socket = folder / "control"
        with open(folder / "daemon.log", "wb") as log:
            self.process = subprocess.Popen(  # pylint: disable=consider-using-with
                [PROGRAMS / "tribus", "run", folder / f"{NAME}.toml", "--socket", self.socket],
                stderr=log, preexec_fn=end_with_this_process)
        assert eventually(self.socket.exists), (folder / "daemon.log").read_text()

    def link(self, request=b""):
        """Lines in both directions."""
        with socket.socket(socket.AF_UNIX) as link:
            link.connect(str(self.socket))
            lines = link.makefile("rwb", buffering=0)
        lines.write(request)
        return lines

    def close(self):
        self.process.terminate()
        self.process.wait(30)
        self.radio.close()
        self.servos.close()


def record(folder):
    """Statuses and metrics from control through a failsafe into control, by parts of which the
    first and the third can be said again and again: control, lost, failsafe, back."""
    daemon = Daemon(folder)
    try:
        statuses = daemon.link(b"watch 200ms\n")
        metrics = daemon.link()
        moments = []

        def until(done, at_least=1):
            begun = len(moments)
            for line in statuses:
                metrics.write(b"metrics\n")
                moments.append((json.loads(line), json.loads(metrics.readline())["text"]))
                if len(moments) - begun >= at_least and done(moments[-1][0]):
                    return
                assert len(moments) < 500, moments[-1][0]["outputs"]

        def is_in(state):
            return lambda status: status["outputs"][0]["state"] == state
        until(lambda status: is_in("control")(status) and status["uptime_us"] > 3e6)
        del moments[:]
        until(is_in("control"), 15)
        lost = len(moments)
        daemon.radio.talks = False
        until(is_in("failsafe"))
        failsafe = len(moments) - 1
        until(is_in("failsafe"), 15)
        back = len(moments)
        daemon.radio.talks = True
        until(is_in("control"))
    finally:
        daemon.close()
    return {"moments": moments, "lost": lost, "failsafe": failsafe, "back": back}


def changes(before, after):
    """What a reader has to be told of: type, name, state now, state before; by docs/fleet.md."""
    told = []
    for kind, part, key in (("input", "inputs", "cause"), ("output", "outputs", "state"),
                            ("device", "ports", "present")):
        for old, new in zip(before[part], after[part]):
            if old[key] != new[key]:
                told.append((kind, new["name"], new[key], old[key]))
    return told


class Moment:
    """One recorded status and its metrics as texts with places for what differs from board to
    board."""

    def __init__(self, status, metrics, before):
        self.counters = []
        self.told = changes(before, status) if before else []
        radio = status["inputs"][0]
        self.cause, self.cause_age_us = radio["cause"], radio["state_age_us"]
        self.age_us = radio["age_us"]
        # A frame came since the status before.
        self.heard = self.age_us < PERIOD_S * 1e6
        status = status | {"name": NAME, "file": f"/etc/tribus/{NAME}.toml", "t_us": "slot t",
                           "unix_time_us": "slot unix", "uptime_us": "slot uptime"}
        status["inputs"] = [radio | {"state_age_us": "slot since", "age_us": "slot age"}]
        status = {key: self._moved(part) if key in ("inputs", "outputs") else part
                  for key, part in status.items()}
        self.status = self._pieces(json.dumps(status, separators=(",", ":")) + "\n")
        text = METRIC.sub(self._metric, metrics)
        self.metrics = self._pieces(text)

    def _moved(self, part):
        """With places for counters."""
        if isinstance(part, list):
            return [self._moved(one) for one in part]
        if not isinstance(part, dict):
            return part
        return {key: self._counters(value) if key in COUNTERS else self._moved(value)
                for key, value in part.items()}

    def _counters(self, value):
        if isinstance(value, dict):
            return {key: self._counters(one) for key, one in value.items()}
        self.counters.append(value)
        return f"slot counter {len(self.counters) - 1}"

    def _metric(self, line):
        head, name, value = line.groups()
        if name.endswith("_total"):
            value = '"%s"' % self._counters(int(value))
        elif name in ("uptime_seconds", "start_since_boot_seconds"):
            value = '"slot %s"' % name.split("_", maxsplit=1)[0]
        head = re.sub(r'daemon="[^"]*"', f'daemon="{NAME}"', head)
        return f"{head} {value}"

    @staticmethod
    def _pieces(text):
        """Text, and in every second place what belongs there: a name, or a counter's number."""
        parts = SLOT.split(text)
        pieces = []
        for at in range(0, len(parts) - 1, 3):
            pieces += [parts[at], int(parts[at + 2]) if parts[at + 2] else parts[at + 1]]
        return pieces + [parts[-1]]

    @staticmethod
    def fill(pieces, values, counters):
        return "".join(
            piece if at % 2 == 0 else str(counters[piece] if isinstance(piece, int)
                                          else values[piece])
            for at, piece in enumerate(pieces))


class Recording:
    def __init__(self, recorded):
        said = recorded["moments"]
        self.moments = [Moment(*said[at], said[at - 1][0] if at else None)
                        for at in range(len(said))]
        self.lost, self.failsafe, self.back = (
            recorded[part] for part in ("lost", "failsafe", "back"))
        counts = {len(moment.counters) for moment in self.moments}
        assert len(counts) == 1, counts
        still = self.moments[1:self.lost] + self.moments[self.failsafe + 1:self.back]
        assert not any(moment.told for moment in still), "the recorded daemon was disturbed"

    def after(self, at, loses):
        """The moment after that one, of a board whose wire is pulled or not. A round begins one
        moment after its part, so that the moment before is known."""
        following = at + 1
        if at < self.lost:
            return self.lost if loses else following if following < self.lost else 1
        if self.failsafe <= at < self.back:
            again = following if following < self.back else self.failsafe + 1
            return again if loses else self.back
        return following if following < len(self.moments) else 1


class ReplayedBoard:
    """Says what a daemon would say. Its wire is pulled at times that it is given."""

    def __init__(self, recording, place, journal):
        self.recording, self.journal = recording, journal
        self.name, self.socket = place["name"], place["socket"]
        self.episodes = [tuple(episode) for episode in place["episodes"]]
        self.begin = time.monotonic()
        self.at = 1
        self.shift = [0] * len(recording.moments[0].counters)
        self.since = self.begin - recording.moments[1].cause_age_us / 1e6
        self.heard = self.begin
        self.watchers = set()

    def loses(self, since_go):
        return any(begin <= since_go < end for begin, end in self.episodes)

    def step(self, now, since_go):
        moments, before = self.recording.moments, self.at
        self.at = self.recording.after(before, self.loses(since_go))
        moment = moments[self.at]
        if self.at != before + 1:
            # Counters go on as if the moment before had led here.
            led = moments[self.at - 1].counters
            self.shift = [shift + here - there for shift, here, there in
                          zip(self.shift, moments[before].counters, led)]
        if moment.cause != moments[before].cause:
            self.since = now - moment.cause_age_us / 1e6
        if moment.heard:
            self.heard = now - moment.age_us / 1e6
        unix_us = time.time_ns() // 1000
        since_us = int((now - self.since) * 1e6)
        text = self.status(now, unix_us, since_us).encode()
        for watcher in self.watchers:
            watcher.write(text)
        for kind, name, state, old in moment.told:
            at_us = unix_us - (since_us if kind == "input" else 0)
            self.journal.write(json.dumps([self.name, kind, name, state, old, at_us,
                                           unix_us]) + "\n")

    def status(self, now, unix_us, since_us):
        return self._fill("status", {
            "t": int(now * 1e6), "unix": unix_us, "uptime": int((now - self.begin) * 1e6),
            "since": since_us, "age": int((now - self.heard) * 1e6)})

    def answer(self, request, now):
        if request == "metrics":
            text = self._fill("metrics", {"uptime": now - self.begin, "start": self.begin})
            return json.dumps({"type": "metrics", "text": text})
        if request.startswith(("status", "watch")):
            return self.status(now, time.time_ns() // 1000,
                               int((now - self.since) * 1e6)).rstrip()
        return json.dumps({"type": "error", "error": f"{request} is not replayed"})

    def _fill(self, part, values):
        moment = self.recording.moments[self.at]
        counters = [one + shift for one, shift in zip(moment.counters, self.shift)]
        return Moment.fill(getattr(moment, part), values, counters)

    async def serve(self, reader, writer):
        try:
            while line := await reader.readline():
                request = line.decode().strip()
                writer.write((self.answer(request, time.monotonic()) + "\n").encode())
                if request.startswith("watch"):
                    self.watchers.add(writer)
        except ConnectionError:
            pass
        finally:
            self.watchers.discard(writer)
            writer.close()


async def replay(plan, journal):
    """Until the standard input ends. Its first line lets the episodes begin."""
    recording = Recording(plan["recording"])
    boards = [ReplayedBoard(recording, place, journal) for place in plan["boards"]]
    for board in boards:
        await asyncio.start_unix_server(board.serve, board.socket, backlog=16)
    loop = asyncio.get_running_loop()
    ends, go = asyncio.Event(), []

    def hear():
        if sys.stdin.readline():
            go.append(time.monotonic())
        else:
            loop.remove_reader(sys.stdin)
            ends.set()
    loop.add_reader(sys.stdin, hear)

    def step(board, due):
        now = time.monotonic()
        board.step(now, now - go[0] if go else -1)
        loop.call_at(due + PERIOD_S, step, board, due + PERIOD_S)
    for at, board in enumerate(boards):
        # Their periods begin one after the other, as those of boards do.
        due = loop.time() + PERIOD_S * at / len(boards)
        loop.call_at(due, step, board, due)
    print("ready", flush=True)
    await ends.wait()


if __name__ == "__main__":
    FOLDER = pathlib.Path(sys.argv[1])
    with open(FOLDER / "journal", "w", encoding="utf-8", buffering=1) as told:
        asyncio.run(replay(json.loads((FOLDER / "plan.json").read_text()), told))

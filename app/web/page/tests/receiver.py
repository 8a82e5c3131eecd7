#!/usr/bin/env python3
"""A simulated i.Bus receiver and SBUS servos at the far ends of two ptys, for board.mjs.

Prints the paths of the ptys, then a line whenever what the servos get changes: their flags
("control", "frame-lost" or "failsafe") and the first four channels in us. Commands, one a line:
"pulses US...", "sweep" (channel 1 never stands still), "cut", "mend". A process of its own, so that
frames come in time whatever the tests do meanwhile.
"""
import contextlib
import os
import pty
import select
import sys
import time
import tty

PERIOD_S = 0.007
CHANNELS = 14
SBUS_BYTES = 25


def ibus_frame(pulses):
    """docs/protocols/ibus.md, "Servo frame"."""
    frame = bytearray(b"\x20\x40")
    for us in pulses:
        frame += us.to_bytes(2, "little")
    return bytes(frame) + (0xFFFF - sum(frame)).to_bytes(2, "little")


def sbus_words(frame):
    bits = int.from_bytes(frame[1:23], "little")
    us = [round(((bits >> (11 * i)) & 0x7FF) * 0.625 + 880) for i in range(4)]
    flags = frame[23]
    state = "failsafe" if flags & 8 else "frame-lost" if flags & 4 else "control"
    return " ".join([state, *map(str, us)])


def open_pty():
    master, slave = pty.openpty()
    tty.setraw(slave)
    os.set_blocking(master, False)
    return master, slave, os.ttyname(slave)


class Wires:
    def __init__(self):
        self.receiver, self.kept_1, receiver = open_pty()
        self.servos, self.kept_2, servos = open_pty()
        print(receiver, servos, flush=True)
        self.pulses = [1100] + [1500] * (CHANNELS - 1)
        self.sends = True
        self.sweeps = False
        self.came = b""
        self.said = ""

    def obey(self, line):
        word, *more = line.split()
        if word == "pulses":
            self.sweeps = False
            self.pulses = [int(us) for us in more] + [1500] * (CHANNELS - len(more))
        elif word == "sweep":
            self.sweeps = True
        else:
            self.sends = word == "mend"

    def send(self):
        if self.sweeps:
            self.pulses[0] = 1000 + int(time.monotonic() * 400) % 1000
        if self.sends:
            with contextlib.suppress(BlockingIOError):  # nobody reads, and a wire keeps nothing
                os.write(self.receiver, ibus_frame(self.pulses))

    def read_servos(self):
        self.came = (self.came + os.read(self.servos, 4096))[-4 * SBUS_BYTES:]
        while len(self.came) >= SBUS_BYTES:
            if self.came[0] != 0x0F or self.came[24] != 0:
                self.came = self.came[1:]
                continue
            words = sbus_words(self.came)
            self.came = self.came[SBUS_BYTES:]
            if words != self.said and not self.sweeps:
                self.said = words
                print(words, flush=True)


def main():
    wires = Wires()
    commands = ""
    due = time.monotonic()
    while True:
        wait = max(0.0, due - time.monotonic())
        ready, _, _ = select.select([0, wires.servos], [], [], wait)
        if wires.servos in ready:
            wires.read_servos()
        if 0 in ready:
            text = os.read(0, 4096).decode()
            if not text:
                return
            *lines, commands = (commands + text).split("\n")
            for line in lines:
                wires.obey(line)
        if time.monotonic() >= due:
            wires.send()
            due = max(due + PERIOD_S, time.monotonic())


if __name__ == "__main__":
    sys.exit(main())

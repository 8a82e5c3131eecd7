"""Decodes frames with canmatrix, for canmatrix_test.cpp.

Arguments: a DBC file, and a file with one frame a line: the id as in the DBC file (bit 31 set for 29
bits) and the data in hexadecimal. Prints one JSON object a line for each frame: what canmatrix knows
of its message, and the raw and physical value of each signal that it finds in the frame. Numbers
that JSON does not have are strings.
"""

import json
import math
import sys

import canmatrix.formats


def number(value):
    if isinstance(value, float) and not math.isfinite(value):
        return repr(value)
    return value


def decoded(matrix, line):
    compound_id, _, data = line.strip().partition(" ")
    frame = matrix.frame_by_id(canmatrix.ArbitrationId.from_compound_integer(int(compound_id)))
    signals = frame.decode(bytes.fromhex(data))
    return {
        "message": frame.name,
        "length": frame.size,
        "fd": frame.is_fd,
        "cycle_time_ms": int(frame.cycle_time),
        "signals": {
            name: {"raw": number(signal.raw_value), "physical": number(float(signal.phys_value))}
            for name, signal in signals.items()
        },
    }


def main():
    with open(sys.argv[1], "rb") as text:
        matrix = canmatrix.formats.load_flat(text, "dbc")
    with open(sys.argv[2], encoding="ascii") as frames:
        for line in frames:
            print(json.dumps(decoded(matrix, line)))


main()

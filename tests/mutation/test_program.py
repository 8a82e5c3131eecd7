"""Runs a program of googletest that may hang, crash or leave processes behind."""

import os
import re
import signal
import subprocess


def run(command, log, seconds, **settings):
    """Returns its exit status, or None if it did not end in time, and what it printed into `log`."""
    process = subprocess.Popen(command, stdout=log, stderr=subprocess.STDOUT,
                               start_new_session=True, **settings)
    try:
        status = process.wait(timeout=seconds)
    except subprocess.TimeoutExpired:
        status = None
    try:
        os.killpg(process.pid, signal.SIGKILL)
    except ProcessLookupError:
        pass
    process.wait()
    log.seek(0)
    return status, log.read()


def failed_test(text):
    """The first test that failed, or None."""
    failed = re.search(r"^\[  FAILED  \] (\S+?),? ", text, re.MULTILINE)
    return failed[1] if failed else None


def last_test(text):
    """The last test that began, or None."""
    begun = re.findall(r"^\[ RUN      \] (\S+)", text, re.MULTILINE)
    return begun[-1] if begun else None

"""Judges a board by what `tribus status --format json` said before and during a trial."""

import json

# A device that is in one of these states works.
WORKING = ("there", "ready", "warning")


def summary_in(text):
    """Returns the summary, or None if there is none."""
    try:
        found = json.loads(text) if isinstance(text, str) else text
    except ValueError:
        return None
    return found if isinstance(found, dict) and found.get("type") == "summary" else None


def parts(summary, kind):
    return {part["name"]: part for part in summary[kind]}


def of_daemon(now, settled, number):
    if now["figures_old"]:
        yield "", "its figures are %d us old" % now["figures_age_us"]
    if str(now["trial"]) != str(number):
        yield "", "trial %s is over" % number
    if settled and now["uptime_us"] < settled["uptime_us"]:
        yield "", "the daemon started again"


def of_parts(now, before):
    then = parts(before, "outputs")
    for name, output in parts(now, "outputs").items():
        was = then[name]["state"] if name in then else "control"
        if output["state"] != was:
            yield "output " + name, "is in %s, %s" % (
                output["state"], "was in " + was if name in then else "a new one has to be in control")
    then = parts(before, "inputs")
    for name, found in parts(now, "inputs").items():
        was = then[name]["cause"] if name in then else "good"
        if found["cause"] not in ("good", was):
            yield "input " + name, "is %s, %s" % (
                found["cause"], "was " + was if name in then else "a new one has to be good")
    then = parts(before, "devices")
    for name, device in parts(now, "devices").items():
        was = then[name]["state"] if name in then else "there"
        if device["state"] not in WORKING + (was,):
            yield "device " + name, "is %s, was %s" % (device["state"], was)


def since(now, settled):
    """Losses that came and went while it was watched."""
    for kind, word, counter, text in (("inputs", "input ", "times_lost", "was lost for a while"),
                                      ("outputs", "output ", "failsafe_entries",
                                       "was in failsafe for a while")):
        then = parts(settled, kind)
        for name, part in parts(now, kind).items():
            if name in then and part[counter] > then[name][counter]:
                yield word + name, text


def complaints(now, before, number, settled=None, accept=()):
    """What is worse than before the trial, as sentences; an empty list: the board is good.

    now, before: the summaries; number: of the trial; settled: the summary since when nothing may
    have happened; accept: parts, such as "input backup", that may differ.
    """
    now, before = summary_in(now), summary_in(before)
    if now is None or before is None:
        return ["the daemon does not answer"]
    earlier = summary_in(settled) if settled else None
    found = list(of_daemon(now, earlier, number)) + list(of_parts(now, before))
    found += list(since(now, earlier)) if earlier else []
    return [("%s %s" % (part, text)).strip() for part, text in found if part not in accept]


class FilterModule:
    def filters(self):
        return {"tribus_complaints": complaints}

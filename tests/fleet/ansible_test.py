# Debian packages: ansible-core
"""The role of deploy/ansible with the real ansible-playbook and two real daemons on ptys."""

import importlib.util
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import unittest

from ansible_board import PATIENCE_S, ROOT, TRIBUS, Board, wait_for

ROLE = ROOT / "deploy/ansible/roles/tribus"
REVERSED = "[pipeline.main.channels]\n1 = { from = 1, reverse = true }"
LONGEST_PLAY_S = 400
# In the place of ssh: runs the command here, until the file LOST is there.
SSH = """#!/bin/sh
if [ -e LOST ]; then
    echo "ssh: connect to host board1 port 22: No route to host" >&2
    exit 255
fi
for command; do :; done
exec sh -c "$command"
"""


class Fleet(unittest.TestCase):
    def setUp(self):
        place = tempfile.TemporaryDirectory(prefix="tribus-fleet-")
        self.addCleanup(place.cleanup)
        self.folder = pathlib.Path(place.name)
        (self.folder / "none.cfg").touch()
        self.boards = []
        for name in ("board1", "board2"):
            board = Board(self.folder, name)
            self.addCleanup(board.end)
            self.boards.append(board)
        self.first, self.second = self.boards
        self.before = [board.status()["fingerprint"] for board in self.boards]
        self.texts = [board.file.read_text() for board in self.boards]
        lines = "".join(
            "%s tribus_file=%s tribus_socket=%s\n" % (board.name, board.file, board.socket)
            for board in self.boards)
        (self.folder / "inventory.ini").write_text(
            "[boards]\n%s[boards:vars]\nansible_connection=local\nansible_become=false\n"
            "ansible_python_interpreter=/usr/bin/python3\ntribus_program=%s\ntribus_trial=40\n"
            "tribus_settle=5\ntribus_watch=2\ntribus_margin=5\n" % (lines, TRIBUS))

    def candidate(self, board, text):
        folder = self.folder / "configurations" / board.name
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "servos.toml").write_text(text)

    def begin(self, *arguments, playbook=None, path=None):
        keep = {name: os.environ[name] for name in ("PATH", "HOME") if name in os.environ}
        keep.update(
            ANSIBLE_HOME=str(self.folder / "ansible"), ANSIBLE_ROLES_PATH=str(ROLE.parent),
            ANSIBLE_CONFIG=str(self.folder / "none.cfg"), ANSIBLE_PIPELINING="1",
            ANSIBLE_NOCOLOR="1", LC_ALL="C.UTF-8", PYTHONDONTWRITEBYTECODE="1",
            ANSIBLE_LOCAL_TEMP=str(self.folder / "ansible/local"),
            ANSIBLE_REMOTE_TEMP=str(self.folder / "ansible/remote"))
        if path:
            keep["PATH"] = "%s:%s" % (path, keep["PATH"])
        return subprocess.Popen(
            ["/usr/bin/ansible-playbook", "-i", self.folder / "inventory.ini",
             playbook or ROOT / "deploy/ansible/boards.yml", *arguments],
            env=keep, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
            text=True, start_new_session=True, cwd=self.folder)

    def play(self, *arguments, **more):
        """Returns the exit status and what was printed."""
        started = self.begin(*arguments, **more)
        printed, _ = started.communicate(timeout=LONGEST_PLAY_S)
        return started.returncode, printed

    def both_at_once(self):
        playbook = self.folder / "both.yml"
        playbook.write_text("- hosts: boards\n  gather_facts: false\n  roles: [tribus]\n")
        return playbook

    def expect_old(self, board, printed=""):
        at = self.boards.index(board)
        wait_for(lambda: "%s runs what it ran before; %s\n%s" % (board.name, board.said(), printed),
                 lambda: (lambda now: now and now["fingerprint"] == self.before[at]
                          and now["trial"] is None and board.in_control())(board.status()))
        self.assertEqual(board.file.read_text(), self.texts[at])

    def expect_untouched(self, board, printed=""):
        self.expect_old(board, printed)
        self.assertNotIn("on trial", board.said())
        self.assertNotIn("servos.toml.candidate", " ".join(board.names()))

    def expect_kept(self, board, text, printed):
        at = self.boards.index(board)
        now = board.status()
        self.assertNotEqual(now["fingerprint"], self.before[at], printed)
        self.assertIsNone(now["trial"], printed)
        self.assertEqual(board.file.read_text(), text)
        self.assertTrue(board.in_control())

    def expect_refused(self, change, words, *arguments):
        """The first board gets what is bad, the second what is good; neither keeps anything."""
        self.candidate(self.first, change)
        self.candidate(self.second, self.second.configuration(pipeline=REVERSED))
        status, printed = self.play(*arguments)
        self.assertNotEqual(status, 0, printed)
        self.assertIn(words, " ".join(printed.split()))
        self.expect_old(self.first, printed)
        self.assertNotIn("the trial was not confirmed", self.first.said(), "it went back too late")
        self.expect_untouched(self.second, printed)
        self.assertNotIn(".servos.toml.candidate", self.first.names())
        return printed

    def test_a_good_change_is_kept_on_both_and_then_there_is_nothing_to_do(self):
        texts = [board.configuration(pipeline=REVERSED) for board in self.boards]
        for board, text in zip(self.boards, texts):
            self.candidate(board, text)
        status, printed = self.play("--diff")
        self.assertEqual(status, 0, printed)
        self.assertIn("channel 1: channel 1 before, now channel 1, reverse", printed)
        for board, text in zip(self.boards, texts):
            self.expect_kept(board, text, printed)
            self.assertNotIn(".servos.toml.candidate", board.names())
        before = [board.status()["uptime_us"] for board in self.boards]
        status, printed = self.play()
        self.assertEqual(status, 0, printed)
        self.assertEqual(printed.count("changed=0"), 2, printed)
        for board, uptime in zip(self.boards, before):
            self.assertGreater(board.status()["uptime_us"], uptime)
            self.assertEqual(board.said().count("on trial for"), 1)
        for board, text in zip(self.boards, texts):
            board.daemon.kill()
            board.daemon.wait(PATIENCE_S)
            board.start()
            self.expect_kept(board, text, "after a restart")

    def test_an_output_that_goes_into_failsafe_takes_it_back(self):
        change = self.first.configuration(sources=["spare"])
        self.expect_refused(change, "output servos is in failsafe, was in control")
        self.assertIn("on trial for 40 s", self.first.said())

    def test_an_input_that_is_lost_takes_it_back_though_the_output_is_in_control(self):
        self.first.wires["spare"].talks = True
        wait_for("a second receiver", lambda: self.first.status()["inputs"][1]["good"])
        change = self.first.configuration(spare='protocol = "sbus"')
        self.expect_refused(change, "input spare is garbled, was good")

    def test_a_difference_that_is_accepted_is_none(self):
        self.first.wires["spare"].talks = True
        wait_for("a second receiver", lambda: self.first.status()["inputs"][1]["good"])
        text = self.first.configuration(spare='protocol = "sbus"')
        self.candidate(self.first, text)
        status, printed = self.play("--limit", "board1", "-e", '{"tribus_accept": ["input spare"]}')
        self.assertEqual(status, 0, printed)
        self.expect_kept(self.first, text, printed)

    def test_a_configuration_with_a_mistake_never_runs(self):
        change = self.first.configuration(pipeline="form = 1")
        printed = self.expect_refused(change, "form")
        self.assertNotIn("Compare it with what runs", printed)
        self.assertNotIn("on trial", self.first.said())

    def test_a_configuration_that_the_daemon_refuses_does_not_run(self):
        change = self.first.configuration(
            extra='[output.lamp]\nprotocol = "sbus"\ndevice = "/nowhere/lamp"\n'
                  '[pipeline.lamp]\nfrom = "main"\nto = "lamp"\n')
        self.expect_refused(change, "/nowhere/lamp")
        self.assertNotIn("on trial", self.first.said())

    def test_a_daemon_that_is_not_there_ends_the_play(self):
        self.first.daemon.terminate()
        self.first.daemon.wait(PATIENCE_S)
        for board in self.boards:
            self.candidate(board, board.configuration(pipeline=REVERSED))
        status, printed = self.play()
        self.assertNotEqual(status, 0)
        self.assertIn("no daemon answers at", printed)
        self.assertEqual(self.first.file.read_text(), self.texts[0])
        self.expect_untouched(self.second, printed)

    def test_a_trial_of_somebody_else_ends_the_play_and_goes_on(self):
        other = self.folder / "other.toml"
        other.write_text(self.first.configuration(pipeline="[pipeline.main.channels]\n1 = 2"))
        subprocess.run([TRIBUS, "reload", "--socket", self.first.socket, "--trial", "3600s",
                        "--draft", other], check=True, stdin=subprocess.DEVNULL)
        for board in self.boards:
            self.candidate(board, board.configuration(pipeline=REVERSED))
        status, printed = self.play()
        self.assertNotEqual(status, 0)
        self.assertIn("trial 1,", " ".join(printed.split()))
        self.assertEqual(self.first.status()["trial"], 1)
        self.expect_untouched(self.second, printed)

    def test_boards_of_one_batch_stand_or_fall_together(self):
        self.candidate(self.first, self.first.configuration(sources=["spare"]))
        self.candidate(self.second, self.second.configuration(pipeline=REVERSED))
        status, printed = self.play(playbook=self.both_at_once())
        self.assertNotEqual(status, 0)
        self.expect_old(self.first, printed)
        self.expect_old(self.second, printed)
        self.assertIn("on trial for 40 s", self.second.said())
        self.assertIn("not kept, because of board1", " ".join(printed.split()))

    def test_the_playbook_tries_one_board_first_and_stops_at_the_first_that_fails(self):
        text = (ROOT / "deploy/ansible/boards.yml").read_text()
        for line in ('serial: [1, "25%", "100%"]', "any_errors_fatal: true",
                     "max_fail_percentage: 0"):
            self.assertIn("\n  %s\n" % line, text)

    def test_a_play_that_is_killed_in_the_trial_leaves_the_old_configuration(self):
        self.candidate(self.second, self.second.configuration(pipeline=REVERSED))
        play, _ = self.begin_and_wait_for_the_watch(
            self.first.configuration(pipeline=REVERSED), "-e", "tribus_trial=40", "-e",
            "tribus_watch=600", "-e", "tribus_margin=-600")
        os.killpg(play.pid, signal.SIGKILL)
        play.wait(PATIENCE_S)
        play.stdout.close()
        self.assertNotEqual(self.first.status()["fingerprint"], self.before[0])
        self.expect_old(self.first)
        self.assertIn("the trial was not confirmed", self.first.said())
        self.expect_untouched(self.second)

    def test_a_board_that_the_controller_loses_in_the_trial_goes_back_by_itself(self):
        lost = self.folder / "lost"
        ssh = self.folder / "ssh"
        ssh.write_text(SSH.replace("LOST", str(lost)))
        ssh.chmod(0o755)
        self.candidate(self.second, self.second.configuration(pipeline=REVERSED))
        play, printed = self.begin_and_wait_for_the_watch(
            self.first.configuration(pipeline=REVERSED), "-e", "tribus_trial=40", "-e",
            "ansible_connection=ssh", "-e", "ansible_ssh_transfer_method=piped", "-e",
            "ansible_ssh_executable=%s" % ssh)
        lost.touch()
        printed += play.communicate(timeout=LONGEST_PLAY_S)[0]
        self.assertNotEqual(play.returncode, 0, printed)
        self.assertIn("unreachable=1", printed)
        self.expect_old(self.first, printed)
        self.assertIn("the trial was not confirmed", self.first.said())
        self.expect_untouched(self.second, printed)

    def test_a_daemon_that_starts_anew_in_the_trial_runs_the_old_configuration(self):
        self.candidate(self.first, self.first.configuration(pipeline=REVERSED))
        play = self.begin("--limit", "board1", "-e", "tribus_watch=15", "-e", "tribus_margin=0")
        wait_for("a trial", lambda: self.first.status()["trial"])
        self.first.daemon.kill()
        self.first.daemon.wait(PATIENCE_S)
        self.first.start()
        printed = play.communicate(timeout=LONGEST_PLAY_S)[0]
        self.assertNotEqual(play.returncode, 0, printed)
        self.expect_old(self.first, printed)

    def test_a_trial_that_is_over_before_it_is_confirmed_is_not_kept(self):
        self.candidate(self.first, self.first.configuration(pipeline=REVERSED))
        status, printed = self.play("--limit", "board1", "-e", "tribus_trial=20", "-e",
                                    "tribus_watch=25", "-e", "tribus_margin=-30")
        self.assertNotEqual(status, 0)
        self.assertIn("trial 1 is over", " ".join(printed.split()))
        self.expect_old(self.first, printed)

    def begin_and_wait_for_the_watch(self, text, *arguments):
        """Returns the play, and what it printed so far."""
        self.candidate(self.first, text)
        play = self.begin(*(arguments or ("--limit", "board1", "-e", "tribus_trial=60", "-e",
                                          "tribus_watch=15")))
        printed = ""
        for line in play.stdout:
            printed += line
            if "Watch it" in line:
                break
        return play, printed

    def test_a_candidate_that_was_changed_in_the_trial_is_not_kept(self):
        play, printed = self.begin_and_wait_for_the_watch(
            self.first.configuration(pipeline=REVERSED))
        (self.first.folder / ".servos.toml.candidate").write_text("[input.other]\n")
        printed += play.communicate(timeout=LONGEST_PLAY_S)[0]
        self.assertNotEqual(play.returncode, 0, printed)
        self.expect_old(self.first, printed)

    def test_a_loss_while_it_is_watched_takes_it_back(self):
        play, printed = self.begin_and_wait_for_the_watch(
            self.first.configuration(pipeline=REVERSED).replace('"5s"', '"1s"'))
        self.first.wires["main"].talks = False
        wait_for("a loss", lambda: not self.first.status()["inputs"][0]["good"])
        self.first.wires["main"].talks = True
        wait_for("control again", self.first.in_control)
        printed += play.communicate(timeout=LONGEST_PLAY_S)[0]
        self.assertNotEqual(play.returncode, 0, printed)
        self.assertIn("input main was lost for a while", " ".join(printed.split()))
        self.expect_old(self.first, printed)

    def test_a_file_that_cannot_be_replaced_takes_it_back(self):
        tools = self.folder / "tools"
        tools.mkdir()
        (tools / "mv").write_text("#!/bin/sh\nexit 1\n")
        (tools / "mv").chmod(0o755)
        self.candidate(self.first, self.first.configuration(pipeline=REVERSED))
        status, printed = self.play("--limit", "board1", path=tools)
        self.assertNotEqual(status, 0, printed)
        self.expect_old(self.first, printed)

    def test_check_mode_shows_the_difference_and_changes_nothing(self):
        names = [board.names() for board in self.boards]
        for board in self.boards:
            self.candidate(board, board.configuration(pipeline=REVERSED))
        status, printed = self.play("--check", "--diff")
        self.assertEqual(status, 0, printed)
        self.assertEqual(printed.count("channel 1: channel 1 before, now channel 1, reverse"), 2)
        self.assertEqual(printed.count("changed=1"), 2, printed)
        for board, before in zip(self.boards, names):
            self.expect_untouched(board, printed)
            self.assertEqual(board.names(), before)

    def test_a_candidate_may_be_a_template(self):
        self.candidate(self.first, self.first.configuration(
            pipeline="[pipeline.main.channels]\n1 = { fixed = {{ pulse }} }"))
        status, printed = self.play("--limit", "board1", "-e", "tribus_template=true", "-e",
                                    "pulse=1300")
        self.assertEqual(status, 0, printed)
        self.expect_kept(self.first, self.first.configuration(
            pipeline="[pipeline.main.channels]\n1 = { fixed = 1300 }"), printed)


def summary(**changes):
    found = {
        "type": "summary", "uptime_us": 9000000, "figures_age_us": 40000, "figures_old": False,
        "trial": 1, "inputs": [{"name": "main", "cause": "good", "times_lost": 2}],
        "outputs": [{"name": "servos", "state": "control", "failsafe_entries": 1}],
        "devices": [{"name": "can0", "state": "ready"}]}
    found.update(changes)
    return found


class Judge(unittest.TestCase):
    """Each rule of the filter alone."""

    def complaints(self, now, before=None, number=1, **more):
        spec = importlib.util.spec_from_file_location(
            "tribus_judge", ROLE / "filter_plugins/tribus_judge.py")
        module = importlib.util.module_from_spec(spec)
        sys.dont_write_bytecode = True
        spec.loader.exec_module(module)
        return module.complaints(now, before or summary(trial=None), number, **more)

    def output(self, state, name="servos", entries=1):
        return [{"name": name, "state": state, "failsafe_entries": entries}]

    def input(self, cause, name="main", lost=2):
        return [{"name": name, "cause": cause, "times_lost": lost}]

    def test_as_before_is_good(self):
        self.assertEqual(self.complaints(summary()), [])
        off = {"outputs": self.output("failsafe"), "inputs": self.input("radio_lost")}
        self.assertEqual(self.complaints(summary(**off), summary(trial=None, **off)), [])

    def test_no_answer_is_bad(self):
        for answer in ("", "{", "[]", "null", '{"type": "status"}'):
            self.assertEqual(self.complaints(answer), ["the daemon does not answer"])

    def test_old_figures_are_bad(self):
        self.assertEqual(self.complaints(summary(figures_old=True, figures_age_us=3000000)),
                         ["its figures are 3000000 us old"])

    def test_another_trial_is_bad(self):
        self.assertEqual(self.complaints(summary(trial=None)), ["trial 1 is over"])
        self.assertEqual(self.complaints(summary(trial=2)), ["trial 1 is over"])
        self.assertEqual(self.complaints(summary(trial=1), number="1"), [])
        self.assertEqual(self.complaints(summary(trial=None), number=""), ["trial  is over"])

    def test_an_output_in_another_state_is_bad_also_a_better_one(self):
        self.assertEqual(self.complaints(summary(outputs=self.output("hold"))),
                         ["output servos is in hold, was in control"])
        before = summary(outputs=self.output("failsafe"))
        self.assertEqual(self.complaints(summary(), before),
                         ["output servos is in control, was in failsafe"])

    def test_an_input_with_a_new_cause_is_bad(self):
        self.assertEqual(self.complaints(summary(inputs=self.input("stale"))),
                         ["input main is stale, was good"])
        before = summary(inputs=self.input("never_seen"))
        self.assertEqual(self.complaints(summary(inputs=self.input("garbled")), before),
                         ["input main is garbled, was never_seen"])
        self.assertEqual(self.complaints(summary(), before), [])

    def test_a_device_that_is_newly_gone_is_bad(self):
        gone = [{"name": "can0", "state": "gone"}]
        self.assertEqual(self.complaints(summary(devices=gone)), ["device can0 is gone, was ready"])
        self.assertEqual(self.complaints(summary(devices=gone), summary(devices=gone)), [])

    def test_new_parts_have_to_work(self):
        self.assertEqual(self.complaints(summary(outputs=self.output("failsafe", "lamp"))),
                         ["output lamp is in failsafe, a new one has to be in control"])
        self.assertEqual(self.complaints(summary(inputs=self.input("never_seen", "third"))),
                         ["input third is never_seen, a new one has to be good"])

    def test_a_loss_since_it_settled_is_bad(self):
        now = summary(inputs=self.input("good", lost=3), outputs=self.output("control", entries=2))
        self.assertEqual(self.complaints(now, settled=summary()),
                         ["input main was lost for a while",
                          "output servos was in failsafe for a while"])
        self.assertEqual(self.complaints(summary(uptime_us=5), settled=summary()),
                         ["the daemon started again"])

    def test_what_is_accepted_is_not_bad(self):
        now = summary(inputs=self.input("stale"), outputs=self.output("hold"))
        self.assertEqual(self.complaints(now, accept=["input main"]),
                         ["output servos is in hold, was in control"])

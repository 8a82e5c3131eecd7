# Debian packages: prometheus python3-yaml
"""deploy/prometheus before a real Prometheus, which scrapes a real `tribus-web` and real daemons."""
import json
import re
import signal
import subprocess
import unittest

import yaml

from board import EXAMPLES, ROOT, Board, Prometheus, Thread, eventually

RULES = yaml.safe_load((EXAMPLES / "tribus.rules.yml").read_text())
TRIALS = yaml.safe_load((EXAMPLES / "tribus.rules.test.yml").read_text())["tests"]
DASHBOARD = json.loads((EXAMPLES / "dashboard.json").read_text())
ALERTS = {rule["alert"] for group in RULES["groups"] for rule in group["rules"] if "alert" in rule}
AGES = ("up", "answers", "age")


def promtool(*arguments, stdin=None):
    ran = subprocess.run(["promtool", *arguments], input=stdin, capture_output=True, text=True,
                         check=False)
    return ran.returncode, ran.stdout + ran.stderr


def panels():
    return [panel for panel in DASHBOARD["panels"] if panel["type"] != "row"]


def targets():
    return [(panel["title"], target) for panel in panels() for target in panel["targets"]]


class Files(unittest.TestCase):
    """What needs no board."""

    def test_promtool_takes_configuration_and_rules(self):
        code, said = promtool("check", "config", str(EXAMPLES / "prometheus.yml"))
        self.assertEqual(code, 0, said)

    def test_rules_pass_their_tests(self):
        code, said = promtool("test", "rules", str(EXAMPLES / "tribus.rules.test.yml"))
        self.assertEqual(code, 0, said)

    def test_each_alert_is_tried_where_it_fires_and_where_not(self):
        fires, silent, spares = set(), set(), set()
        for trial in TRIALS:
            boards = {re.search('instance="([^"]*)"', series["series"])[1]
                      for series in trial["input_series"]}
            for check in trial["alert_rule_test"]:
                name, expected = check["alertname"], check.get("exp_alerts", [])
                (fires if expected else silent).add(name)
                # One board at least that has figures and no alert.
                if boards - {alert["exp_labels"].get("instance") for alert in expected}:
                    spares.add(name)
        self.assertEqual(fires, ALERTS)
        self.assertEqual(silent, ALERTS)
        self.assertEqual(spares, ALERTS)

    def test_the_page_explains_each_alert(self):
        rows = re.findall(r"^\| `(Tribus\w+)` \|", (ROOT / "docs/fleet.md").read_text(), re.M)
        self.assertEqual(set(rows), ALERTS)

    def test_each_panel_shows_up_and_the_age_of_its_figures(self):
        self.assertGreater(len(panels()), 10)
        for panel in panels():
            with self.subTest(panel["title"]):
                references = [target["refId"] for target in panel["targets"]]
                self.assertEqual(tuple(references[-3:]), AGES)
                self.assertGreater(len(references), 3)
                self.assertIn("figures", panel["description"])

    def test_no_panel_shows_the_last_value_of_a_range(self):
        for panel in panels():
            with self.subTest(panel["title"]):
                if panel["type"] == "table":
                    self.assertTrue(all(target["instant"] for target in panel["targets"]))
                else:
                    self.assertEqual(panel["type"], "timeseries")
                    self.assertEqual(panel["options"]["legend"]["calcs"], [])
                    self.assertFalse(panel["fieldConfig"]["defaults"]["custom"]["spanNulls"])

    def test_panels_have_numbers_and_places_of_their_own(self):
        self.assertEqual(len({panel["id"] for panel in DASHBOARD["panels"]}),
                         len(DASHBOARD["panels"]))
        taken = set()
        for panel in DASHBOARD["panels"]:
            place = panel["gridPos"]
            cells = {(place["x"] + x, place["y"] + y)
                     for x in range(place["w"]) for y in range(place["h"])}
            self.assertFalse(cells & taken, panel["title"])
            self.assertLessEqual(place["x"] + place["w"], 24)
            taken |= cells

    def test_each_query_asks_the_chosen_data_source(self):
        self.assertEqual(DASHBOARD["templating"]["list"][0]["type"], "datasource")
        for title, target in targets():
            self.assertEqual(target["datasource"],
                             {"type": "prometheus", "uid": "${datasource}"}, title)


class Scraped(unittest.TestCase):
    """A board and its Prometheus."""

    @classmethod
    def setUpClass(cls):
        cls.board = Board()
        cls.addClassCleanup(cls.board.close)
        cls.prometheus = Prometheus(cls.board.port)
        cls.addClassCleanup(cls.prometheus.close)
        assert eventually(cls.prometheus.is_ready), "Prometheus does not answer"

    def setUp(self):
        self.board.radio.talks = self.board.pack.talks = True
        self.of_car = f'daemon="{self.board.car}"'
        in_control = (f'tribus_output_in_control{{{self.of_car}}} == 1 and on (daemon) '
                      f'tribus_figures_age_seconds < 1')
        self.assertTrue(eventually(lambda: self.prometheus.now(in_control)), self.logs())

    def logs(self):
        scrapes = [(target["health"], target["lastError"], target["lastScrapeDuration"])
                   for target in self.prometheus.ask("targets")["activeTargets"]]
        return "\n".join([str(scrapes), str(self.prometheus.now(f"{{{self.of_car}}}")[:9]),
                          *(file.read_text() for file in self.board.folder.glob("*.log"))])

    def expect_alert(self, **labels):
        fires = eventually(lambda: self.prometheus.firing(**labels))
        self.assertTrue(fires, f"{labels} among {self.prometheus.firing()}\n{self.logs()}")
        return fires[0]

    def expect_no_alert(self, **labels):
        self.assertTrue(eventually(lambda: not self.prometheus.firing(**labels), 100),
                        self.prometheus.firing(**labels))

    def filled(self, query):
        """A query of the dashboard with its variables."""
        mine = f"{self.board.car}|{self.board.spare}"
        for name, value in (("$__rate_interval", "10s"), ("$job", "tribus"), ("$instance", ".*"),
                            ("$daemon", mine), ("$longest_gap", "15")):
            query = query.replace(name, value)
        self.assertNotIn("$", query)
        return query

    def answer(self, target):
        """The labels of what a query of the dashboard shows."""
        query = self.filled(target["expr"])
        if target["instant"]:
            return [labels for labels, _ in self.prometheus.now(query)]
        return [series["metric"] for series in self.prometheus.range(query)]

    def test_promtool_finds_nothing_to_say_about_the_metrics(self):
        text = self.board.metrics()
        for family in ("input_frames_total", "output_frames_total", "can_bus_offs_total", "value"):
            self.assertIn(f"\ntribus_{family}{{", text)
        code, said = promtool("check", "metrics", stdin=text)
        self.assertEqual((code, said), (0, ""))

    def test_every_query_of_the_dashboard_answers(self):
        silent = targets()

        def all_answered():
            silent[:] = [one for one in silent if not self.answer(one[1])]
            # Something to count: losses, and alerts.
            self.board.radio.talks = not self.board.radio.talks
            return not silent

        self.assertTrue(eventually(all_answered, pause_s=3), silent)

    def rows(self, target):
        """The labels of what a query of a table shows, without the name of the metric."""
        return [labels.items() - {("__name__", labels.get("__name__"))}
                for labels in self.answer(target)]

    def test_each_row_of_a_table_has_its_up_answers_and_age(self):
        def surplus(panel, reference):
            """What has no partner: rows of figures, rows that say how old figures are."""
            asked = {target["refId"]: target for target in panel["targets"]}
            figures = {frozenset(row) for name in asked if name not in AGES
                       for row in self.rows(asked[name])}
            ages = self.rows(asked[reference])
            return ([row for row in figures if sum(age <= row for age in ages) != 1],
                    [age for age in ages if not any(age <= row for row in figures)],
                    len(ages) - len(figures))

        for panel in panels():
            if panel["type"] == "table":
                self.assertTrue(eventually(lambda one=panel: self.answer(one["targets"][0])))
                for reference in AGES:
                    with self.subTest(panel["title"], beside=reference):
                        # A scrape may come between two queries.
                        eventually(lambda one=panel, name=reference: not any(surplus(one, name)), 9)
                        self.assertEqual(surplus(panel, reference), ([], [], 0))

    def test_every_variable_of_the_dashboard_has_values(self):
        for variable in DASHBOARD["templating"]["list"]:
            if variable["type"] == "query":
                of, label = re.fullmatch(r"label_values\((.*), (\w+)\)",
                                         variable["definition"]).groups()
                series = self.prometheus.ask("series", **{"match[]": self.filled(of)})
                self.assertTrue([one for one in series if label in one], variable["name"])

    def test_every_selector_of_the_rules_finds_figures(self):
        rules = [rule for group in self.prometheus.ask("rules")["groups"] for rule in group["rules"]]
        self.assertEqual({rule["health"] for rule in rules}, {"ok"})
        selectors = {selector for rule in rules for selector in
                     re.findall(r'[a-z:]*tribus_[\w:]+(?:\{[^}]*\})?|up\{[^}]*\}', rule["query"])}
        self.assertGreater(len(selectors), 15)
        for selector in sorted(selectors):
            self.assertTrue(eventually(lambda one=selector: self.prometheus.now(one)), selector)
        for rule in rules:
            if rule["type"] == "recording":
                self.assertTrue(eventually(lambda one=rule: self.prometheus.now(one["name"])),
                                rule["name"])

    def test_a_receiver_that_falls_silent(self):
        # What other tests did shows for a minute.
        for name in ("TribusInputLost", "TribusOutputInFailsafe"):
            self.expect_no_alert(alertname=name, daemon=self.board.car)
        self.board.radio.talks = False
        self.expect_alert(alertname="TribusInputLost", daemon=self.board.car, input="radio",
                          cause="wire_silent")
        self.expect_alert(alertname="TribusOutputInFailsafe", daemon=self.board.car,
                          output="servos")
        # A cause has one alert, not one for each value of this input.
        stale = f'tribus_value_age_seconds{{{self.of_car}}} unless tribus_value'
        self.assertTrue(eventually(lambda: self.prometheus.now(stale)))
        self.assertFalse(eventually(lambda: self.prometheus.firing(alertname="TribusValueStale"),
                                    6))

    def test_a_value_that_comes_no_more(self):
        voltage = f'tribus_value{{{self.of_car},name="pack.battery.voltage",unit="V"}}'
        self.assertTrue(eventually(lambda: self.prometheus.now(voltage)), self.board.metrics())
        self.assertEqual(self.prometheus.now(voltage)[0][1], 12.5)
        self.board.pack.talks = False
        self.expect_alert(alertname="TribusValueStale", daemon=self.board.car,
                          name="pack.battery.voltage")
        self.assertEqual(self.prometheus.now(voltage), [])

    def shown_of_car(self):
        """Panels that show a figure of the car, beside those that say how old figures are."""
        return {title for title, target in targets() if target["refId"] not in AGES
                and any(labels.get("daemon") == self.board.car
                        for labels, _ in self.prometheus.now(self.filled(target["expr"])))}

    def ages_of_car(self, reference):
        query = next(target["expr"] for title, target in targets()
                     if title == "Outputs now" and target["refId"] == reference)
        return [value for labels, value in self.prometheus.now(self.filled(query))
                if labels.get("daemon") == self.board.car]

    def test_a_data_thread_that_hangs(self):
        self.assertIn("Outputs now", self.shown_of_car())
        with Thread(self.board.programs[self.board.car], "tribus-data"):
            alert = self.expect_alert(alertname="TribusFiguresStale", daemon=self.board.car)
            self.assertEqual(alert["severity"], "critical")
            # The figures still say "control"; no panel repeats that.
            in_control = f"tribus_output_in_control{{{self.of_car}}}"
            self.assertEqual(self.prometheus.now(in_control)[0][1], 1)
            self.assertEqual(self.shown_of_car(), set())
            self.assertEqual((self.ages_of_car("up"), self.ages_of_car("answers")), ([1], [1]))
            self.assertGreater(self.ages_of_car("age")[0], 1)
        self.expect_no_alert(alertname="TribusFiguresStale", daemon=self.board.car)

    def test_a_daemon_that_is_stopped(self):
        self.board.send(self.board.car, signal.SIGSTOP)
        self.addCleanup(self.board.send, self.board.car, signal.SIGCONT)
        self.expect_alert(alertname="TribusDaemonSilent", daemon=self.board.car)
        self.assertEqual(self.shown_of_car(), set())
        # A busy machine may take longer for a scrape than Prometheus waits.
        self.assertTrue(eventually(lambda: [self.ages_of_car(name) for name in AGES]
                                   == [[1], [0], []]))

    def test_a_board_that_is_unreachable(self):
        self.board.stop("web")
        self.addCleanup(self.board.start_web)
        self.expect_alert(alertname="TribusBoardUnreachable")
        self.assertEqual(self.shown_of_car(), set())
        up = next(target["expr"] for title, target in targets()
                  if title == "Boards and daemons" and target["refId"] == "up")
        self.assertEqual([value for _, value in self.prometheus.now(self.filled(up))], [0])

    def test_a_daemon_that_starts_again_and_again(self):
        self.assertEqual(self.prometheus.firing(alertname="TribusRestarted"), [])
        for start in (1, 2, 3):
            self.board.stop(self.board.car, signal.SIGKILL)
            self.board.start_daemon(self.board.car)
            restarts = f"changes(tribus_start_since_boot_seconds{{{self.of_car}}}[10m]) >= {start}"
            self.assertTrue(eventually(lambda query=restarts: self.prometheus.now(query)))
            if start == 1:
                self.expect_alert(alertname="TribusRestarted", daemon=self.board.car)
                self.assertEqual(self.prometheus.firing(alertname="TribusRestartsAgain"), [])
        self.expect_alert(alertname="TribusRestartsAgain", daemon=self.board.car)


if __name__ == "__main__":
    unittest.main()

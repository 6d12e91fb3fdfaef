"""Runs that are kept: their list, comparisons with one, metrics over runs, reports by study, the index."""
import base64
import csv
import json
import os
import re
import resource
import shutil
import signal
import sqlite3
import subprocess
import sys
import time
import unittest
import zlib

from case import ATWOOD, Case

PART = ("--scenario", "kepler-e0.6", "--method", "atwood/rk4", "--steps", "240", "--no-timing")
STUDY = """id = "{id}"
[[cells]]
scenarios = ["kepler-e0.6"]
methods = [{methods}]
steps = [{steps}]
timing = false
"""


class History(Case):
    def study(self, name, id, methods='"atwood/rk4"', steps="240"):
        return self.path(name, STUDY.format(id=id, methods=methods, steps=steps))

    def runs(self, *words):
        return json.loads(self.ask("history", "--json", *words).stdout)

    def database(self):
        return sqlite3.connect(self.path("atwood-out/history.db"))

    def page(self, name):
        with open(self.path("atwood-out/" + name)) as file:
            return file.read()

    def report_of(self, name):
        """A report without its links to other pages, which differ with the folder."""
        return re.sub('<p class="pages">.*?</p>', "", self.page(name))

    def test_no_run_yet(self):
        self.ask("history", told=["no run in atwood-out/history.db", "`atwood run` records one"])
        self.assertEqual(self.runs(), [])
        self.assertFalse(os.path.exists(self.path("atwood-out")), "reading makes nothing")
        self.ask("history", "--metric", "error-position-end", code=2, told=["no run in"])
        self.ask("history", "--scenario", "x", code=2, told=["expected --metric"])
        self.ask("history", "--metric", "x", "-o", "csv:f", code=2, told=["expected html:FILE"])

    def test_runs_are_listed_newest_first(self):
        for _ in range(2):  # two runs in one second
            self.ask("run", *PART, code=[0, 1])
        runs = self.runs()
        self.assertEqual([run["run"] for run in runs], [2, 1])
        self.assertEqual(runs[0]["study"], "default")
        self.assertEqual(runs[0]["selection"], "--scenario kepler-e0.6 --method atwood/rk4 --steps 240")
        self.assertEqual(runs[0]["cells"], 1)
        self.assertNotIn(runs[0]["verdict"], ["", "not finished"])
        self.assertTrue(runs[0]["machine"] and runs[0]["commit"])
        self.assertEqual(self.runs("nothing"), [])
        # Figures that did not change are stored once.
        self.assertEqual(self.database().execute("SELECT count(*), count(DISTINCT content) FROM figures").fetchone(), (2, 1))

    def test_rows_outlive_recordings_and_the_store(self):
        self.ask("run", *PART, "--keep", "none", code=[0, 1])
        os.remove(self.path("atwood-out/store.db"))
        shutil.rmtree(self.path("atwood-out/reports"))
        trend = json.loads(self.ask("history", "--metric", "error-position-end", "--json").stdout)[0]
        self.assertGreater(trend["points"][0]["value"], 0)
        self.ask("run", *PART, code=[0, 1])
        self.ask("report", *PART[:-1], "--against", "1", told=["0 worse, 0 better, 0 vanished, 0 appeared"])

    def test_against_tells_what_changed(self):
        small = self.study("s.toml", "s")
        self.ask("run", small, code=[0, 1])
        self.ask("report", small, "--against", "previous", code=2, told=["1 finished run is of this study", "expected two or more"])
        self.study("s.toml", "s", '"atwood/rk4", "atwood/explicit-euler"', "240, 480")
        self.ask("run", small, code=[0, 1])
        told = self.ask("report", small, "--against", "previous", "-o", "json:r.json", "-o", "markdown:r.md")
        self.expect(told, 0, "Against run 1 (s, ", "appeared  kepler-e0.6:", "0 worse, 0 better, 0 vanished")
        with open(self.path("r.json")) as file:
            self.assertEqual({change["kind"] for change in json.load(file)["baseline"]}, {"added"})
        with open(self.path("r.md")) as file:
            self.assertIn("run 1 (s, ", file.read())
        # A baseline in which one figure was better, one worse, and one is not measured here.
        self.ask("bless", small, "--reason", "test", "--baseline", "b.tsv")
        with open(self.path("b.tsv")) as file:
            lines = file.read().splitlines()
        figures = [i for i, line in enumerate(lines) if "\terror-position-end\t" in line]
        for i, factor in zip(figures, (0.5, 2)):
            words = lines[i].split("\t")
            words[4] = repr(float(words[4]) * factor)
            lines[i] = "\t".join(words)
        extra = lines[figures[0]].replace("error-position-end", "error-position-gone")
        lines[-1] = "# end " + str(int(lines[-1].split()[-1]) + 1)
        self.path("b.tsv", "\n".join(lines[:-1] + [extra, lines[-1]]) + "\n")
        told = self.ask("report", small, "--against", "b.tsv").stdout
        self.assertRegex(told, r"worse     kepler-e0.6  atwood/explicit-euler  error-position-end at 240 steps: .*, 2 x")
        self.assertRegex(told, r"better    kepler-e0.6  atwood/explicit-euler  error-position-end at 480 steps: .*, 2 x")
        self.assertRegex(told, r"vanished  kepler-e0.6: 1 figure of")
        self.assertIn("1 worse, 1 better, 1 vanished, 0 appeared", told)

    def embedded(self, name):
        """The data of a report."""
        coded = re.search('<script[^>]*id="data"[^>]*>(.*?)</script>', self.page(name), re.S).group(1)
        return json.loads(zlib.decompress(base64.b64decode(coded), -15))

    def changes(self, name):
        """What a report embeds: against which run, the counts, whether it was the first run."""
        data = self.embedded(name)
        return data.get("changes_against", ""), data.get("change_counts", {}), data.get("first_run", False)

    def test_a_report_says_what_changed_since_the_last_run(self):
        study = self.study("mine.toml", "mine")
        self.ask("run", study, code=[0, 1])
        self.assertEqual(self.changes("report.html"), ("", {}, True))
        told = self.ask("run", study, code=[0, 1])
        against, counts, first = self.changes("report.html")
        self.assertIn("run 1 (mine", against)
        self.assertEqual(set(counts.values()), {0})
        self.assertFalse(first)
        self.assertIn("against run 1 (mine", told.stdout)
        self.study("mine.toml", "mine", methods='"atwood/rk4", "atwood/heun"')
        self.ask("run", study, code=[0, 1])
        against, counts, first = self.changes("report.html")
        self.assertIn("run 2 (mine", against)
        self.assertEqual((counts["regression"], counts["improvement"], counts["missing"]), (0, 0, 0))
        self.assertGreater(counts["added"], 3)
        self.ask("report", study)  # shows what run 3 measured: against run 2
        self.assertIn("run 2 (mine", self.changes("report.html")[0])
        self.ask("bless", study, "--reason", "test", "--baseline", "b.tsv")
        self.ask("run", study, "--baseline", "b.tsv", code=[0, 1])  # a baseline is what the reader chose
        self.assertIn("b.tsv", self.changes("report.html")[0])
        with self.database() as file:
            file.execute("update contents set bytes = x'00'")
        self.ask("run", study, code=[0, 1])  # a damaged history ends no run
        self.assertEqual(self.changes("report.html")[0], "")
        self.assertIn("What changed since the last run is not known", " ".join(self.embedded("report.html")["notes"]))

    def test_a_part_is_compared_with_its_part_of_a_whole(self):
        whole = self.study("w.toml", "w", '"atwood/rk4", "atwood/explicit-euler"')
        self.ask("run", whole, code=[0, 1])
        told = self.ask("report", whole, "--method", "atwood/rk4", "--against", "1")
        self.expect(told, 0, "0 worse, 0 better, 0 vanished, 0 appeared", "left out by the filter")
        # Also cells of a method that the study does not have.
        part = ("--scenario", "kepler-e0.6", "--method", "atwood/rk4")
        self.ask("run", *part, "--method", "atwood/rk4@quad", "--steps", "240", "--no-timing", code=[0, 1])
        told = self.ask("report", *part, "--steps", "240", "--against", "2")
        self.expect(told, 0, "0 worse, 0 better, 0 vanished, 0 appeared", "left out by the filter")

    def test_times_are_of_one_machine(self):
        timed = ("--scenario", "kepler-e0.6", "--method", "atwood/rk4", "--steps", "240")
        self.ask("run", *timed, code=[0, 1])
        with self.database() as database:
            database.execute("UPDATE runs SET host='another'")
        told = self.ask("report", *timed, "--against", "1")
        self.expect(told, 0, "Times are not compared: they are of another machine.", "0 worse, 0 better")
        self.ask("run", *timed, "--fresh", code=[0, 1])
        trend = json.loads(self.ask("history", "--metric", "step-time", "--json").stdout)[0]
        self.assertEqual([point["run"] for point in trend["points"]], [2])

    def test_a_time_that_a_run_found_in_the_store_is_no_new_point(self):
        timed = ("--scenario", "kepler-e0.6", "--method", "atwood/rk4", "--steps", "240")
        def points(metric):
            return [point["run"] for point in json.loads(self.ask("history", "--metric", metric, "--json").stdout)[0]["points"]]
        for _ in range(2):
            self.ask("run", *timed, code=[0, 1])
        self.assertEqual(points("error-position-end"), [1, 2])
        self.assertEqual(points("step-time"), [1])
        self.ask("run", *timed, "--fresh", code=[0, 1])
        self.assertEqual(points("step-time"), [1, 3])
        # A comparison with the run that measured no time has it nonetheless.
        self.ask("report", *timed, "--against", "2", told=["0 vanished, 0 appeared"])

    def test_joined_shards_are_judged_by_the_first_report(self):
        two = self.study("two.toml", "two", '"atwood/rk4", "atwood/explicit-euler"', "240, 480")
        for number in "12":
            self.ask("run", two, "--shard", number + "/2", "--out", "shards")
        self.assertFalse(os.path.exists(self.path("shards/history.db")), "a share alone is judged by nothing")
        shards = [self.path(f"shards/shard-{number}-of-2.db") for number in "12"]
        self.ask("merge", *shards, "-o", "elsewhere.db")
        self.assertFalse(os.path.exists(self.path("history.db")), "no store is at this place")
        self.ask("merge", *shards, "-o", "atwood-out/store.db")
        (merged,) = self.runs()
        self.assertEqual((merged["study"], merged["cells"], merged["verdict"]), ("two", 4, "merged"))
        self.ask("history", told=["merged, not judged"])
        self.ask("report", two, "--against", "1", code=2, told=["joined stores that are not judged yet"])
        self.ask("report", two, "--method", "atwood/rk4")  # a part leaves it as it is
        self.assertEqual([run["verdict"] for run in self.runs()], ["merged"])
        self.ask("report", two)
        (judged,) = self.runs()
        self.assertIn(judged["verdict"], ["pass", "fail", "no gates"])
        self.ask("report", two, "--against", "1", told=["0 worse, 0 better, 0 vanished, 0 appeared"])
        trend = json.loads(self.ask("history", "--metric", "error-position-end", "--json").stdout)
        self.assertEqual(len(trend), 4)

    def test_half_of_the_shards_is_not_judged(self):
        two = self.study("two.toml", "two", '"atwood/rk4", "atwood/explicit-euler"', "240, 480")
        self.ask("run", two, "--shard", "1/2", "--out", "shards")
        self.ask("merge", "shards/shard-1-of-2.db", "-o", "atwood-out/store.db")
        self.ask("report", two)
        self.assertEqual([run["verdict"] for run in self.runs()], ["merged"])

    def test_pruning_keeps_the_newest_of_each_study(self):
        one, other = self.study("one.toml", "one"), self.study("other.toml", "other")
        for study in (one, one, other, one):
            self.ask("run", study, code=[0, 1])
        self.ask("run", one, "--method", "atwood/rk4", code=[0, 1])
        listed = self.runs()
        self.ask("history", "--prune-keep", "1", "--dry-run", told=["2 of 5 runs would be removed"])
        self.assertEqual(self.runs(), listed)
        self.ask("history", "other", "--prune-keep", "1", told=["0 runs removed, 5 left"])
        self.ask("history", "--prune-keep", "1", told=["2 runs removed, 3 left"])
        self.assertEqual([run["run"] for run in self.runs()], [5, 4, 3])
        for name, runs in (("index.html", ["5", "4", "3"]), ("reports/one.trends.html", ["4"])):
            self.assertEqual(re.findall(r'data-name="run">(\d+)<', self.page(name)), runs, name)
        self.ask("report", one, "--against", "4", told=["0 worse, 0 better, 0 vanished, 0 appeared"])
        self.ask("report", one, "--against", "1", code=2, told=["found no such run"])
        self.ask("run", one, code=[0, 1])
        self.assertEqual(self.runs()[0]["run"], 6, "a number is not given twice")

    def test_pruning_by_age(self):
        self.ask("run", *PART, code=[0, 1])
        self.ask("run", self.study("other.toml", "other", '"atwood/explicit-euler"'), code=[0, 1])
        with self.database() as database:  # ten days ago; one was killed then, one seems to go on
            database.execute("UPDATE runs SET begun_ns=begun_ns-864000000000000 WHERE id=1")
            columns = "study, selection, cells, command, commit_id, host, cpu, verdict, passed, failed, unverifiable, not_run, environment"
            for begun in ("begun_ns", "begun_ns+864000000000000"):
                database.execute(f"INSERT INTO runs(begun_ns, ended_ns, {columns}) SELECT {begun}, 0, {columns} FROM runs WHERE id=1")
        contents = self.database().execute("SELECT count(*) FROM contents").fetchone()[0]
        self.ask("history", "--prune-older", "11", told=["0 runs removed"])
        self.ask("history", "--prune-older", "9.5", told=["2 runs removed, 2 left"])
        self.assertEqual([run["run"] for run in self.runs()], [4, 2])
        left = self.database().execute("SELECT count(*) FROM contents").fetchone()[0]
        self.assertLess(left, contents, "what no run has is removed too")
        self.ask("report", "other.toml", "--against", "2", told=["0 worse, 0 better, 0 vanished, 0 appeared"])
        self.ask("history", "--prune-older", "0.01", told=["0 runs removed"])

    def test_pruning_refuses_nonsense(self):
        for words, told in ((["--prune-keep", "0"], "from 1"), (["--prune-keep", "-1"], "from 1"), (["--prune-keep", "1.5"], "whole number"),
                            (["--prune-older", "0"], "from 0.01"), (["--prune-older", "nan"], "expected a number"),
                            (["--prune-keep", "1", "--prune-older", "1"], "excludes"), (["--dry-run"], "expected --prune-keep"),
                            (["--prune-keep", "1", "--metric", "x"], "expected one of them"),
                            (["--prune-keep", "1", "--scenario", "x"], "expected --metric"), (["--prune-keep", "1"], "no runs are kept at")):
            self.ask("history", *words, code=2, told=[told])
        self.assertFalse(os.path.exists(self.path("atwood-out")))

    def test_a_run_whose_entry_was_removed_meanwhile_ends_nonetheless(self):
        slow = self.study("slow.toml", "slow", '"atwood/rk4", "atwood/explicit-euler"', "240, 3840")
        process = subprocess.Popen([ATWOOD, "run", slow], cwd=self.here, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                   env=self.environment, text=True)
        while not os.path.exists(self.path("atwood-out/history.db")) or not self.runs():
            self.assertIsNone(process.poll(), "the run ended before it was recorded")
            time.sleep(0.005)
        with self.database() as database:
            database.execute("DELETE FROM runs")
        told, _ = process.communicate()
        self.assertIn("run 1 was removed from the history", told)
        self.assertIn("report: ", told)
        self.assertEqual(self.database().execute("SELECT count(*) FROM figures").fetchone(), (0,))

    def test_names_of_runs_are_refused_clearly(self):
        self.ask("report", *PART[:-1], "--against", "1", code=2, told=["no store at"])
        self.ask("run", *PART, code=[0, 1])
        for word in ("0", "2", "99999999999999999999", "-1", "zzzz", "' OR 1"):
            self.ask("report", *PART[:-1], f"--against={word}", code=2, told=["found no such run", "from 1 to 1"])
        self.ask("report", *PART[:-1], "--against", "gone.tsv", code=4, told=["no baseline at gone.tsv"])
        commit = self.runs()[0]["commit"]
        self.ask("report", *PART[:-1], "--against", commit[:8], told=["Against run 1"])
        os.remove(self.path("atwood-out/history.db"))
        self.ask("report", *PART[:-1], "--against", "1", code=2, told=["has no run yet"])

    def test_a_commit_means_its_newest_run_of_this_study(self):
        one, other, third = (self.study(f"{id}.toml", id) for id in ("one", "other", "third"))
        self.ask("run", one, code=[0, 1])
        self.ask("run", one, "--method", "atwood/rk4", code=[0, 1])
        self.ask("run", other, code=[0, 1])
        commit = self.runs()[0]["commit"]
        self.ask("report", one, "--against", commit, told=["Against run 1 (one, "])
        self.ask("report", one, "--method", "atwood/rk4", "--against", commit, told=["Against run 2 (one "])
        self.ask("report", one, "--steps", "240", "--against", commit, told=["Against run 2 (one "])
        self.ask("report", third, "--against", commit, code=2, told=["no run of the study `third`", "runs of `one`, `other`"])

    def test_a_frequency_is_a_filter(self):
        self.ask("run", *PART[:4], "--steps", "240", "--steps", "480", "--no-timing", code=[0, 1])
        (row,) = [row for row in self.exported(*PART[:-1]) if row["metric"] == "error-position-end"]
        hz = repr(1 / float(row["h_s"]))
        self.ask("run", *PART[:4], "--hz", hz, "--no-timing", code=[0, 1])
        told = self.ask("report", *PART[:4], "--hz", hz, "--against", "1")
        self.expect(told, 0, "0 worse, 0 better, 0 vanished, 0 appeared", "left out by the filter")
        self.ask("bless", *PART[:4], "--steps", "240", "--steps", "480", "--reason", "test", "--baseline", "b.tsv")
        self.ask("gate", *PART[:4], "--hz", hz, "--baseline", "b.tsv", told=["left out by the filter"])

    def exported(self, *words):
        self.ask("report", *words, "-o", "csv:rows.csv")
        with open(self.path("rows.csv"), newline="") as file:
            return list(csv.DictReader(file))

    def test_the_index_links_to_reports_that_are_there(self):
        for id in ("one", "other"):
            self.ask("run", self.study(f"{id}.toml", id), code=[0, 1])
        page, trends = self.page("reports/one.html"), self.page("reports/one.trends.html")
        self.assertIn('href="../index.html"', page)
        self.assertIn('href="one.trends.html"', page)
        self.assertIn('href="one.html"', trends)
        self.assertIn('href="../index.html"', trends)
        self.assertIn("1 run of this study and selection has figures", trends)
        self.assertIn('href="reports/one.trends.html"', self.page("index.html"))
        for name, folder in (("report.html", "atwood-out/"), ("index.html", "atwood-out/"), ("reports/one.html", "atwood-out/reports/"),
                             ("reports/one.trends.html", "atwood-out/reports/")):
            for target in re.findall(r'<a href="([^"#]+)"', self.page(name).split("<main", 1)[0] if name.endswith("one.html") else self.page(name)):
                self.assertTrue(target.startswith("https:") or os.path.exists(self.path(folder + target)), f"{name}: {target}")
        os.remove(self.path("atwood-out/reports/one.html"))
        self.ask("report", "other.toml")
        self.assertNotIn("reports/one.html", self.page("index.html"))
        self.assertIn("reports/other.html", self.page("index.html"))

    def test_a_run_that_ends_by_an_error_says_so(self):
        self.ask("run", *PART, code=[0, 1])
        self.path("atwood-out/store.db", "not a store, but long enough to be one: " + "x" * 4096)
        self.assertNotIn(self.ask("run", *PART, code=list(range(2, 9))).returncode, [0, 1])
        self.assertEqual([run["verdict"] == "error" for run in self.runs()], [True, False])
        os.remove(self.path("atwood-out/store.db"))
        self.ask("run", *PART, code=[0, 1])
        self.ask("report", *PART[:-1], "--against", "2", code=2, told=["did not finish: it has no figures"])

    def test_a_journal_of_a_killed_run_is_rolled_back(self):
        self.ask("run", *PART, code=[0, 1])
        killed = ("import os, sqlite3; d = sqlite3.connect('atwood-out/history.db'); d.execute('PRAGMA cache_size=1'); "
                  "d.execute('UPDATE runs SET study=?', ('half',)); "
                  "d.executemany('INSERT INTO contents VALUES(?, zeroblob(4000))', [(str(i),) for i in range(200)]); "
                  "os.kill(os.getpid(), 9)")
        subprocess.run([sys.executable, "-c", killed], cwd=self.here)
        self.assertGreater(os.path.getsize(self.path("atwood-out/history.db-journal")), 0)
        self.assertEqual([run["study"] for run in self.runs()], ["default"])

    def test_a_killed_run_stays_in_the_list(self):
        slow = self.study("slow.toml", "slow", '"atwood/*"', "61440")
        process = subprocess.Popen([ATWOOD, "run", slow], cwd=self.here, stdout=subprocess.DEVNULL,
                                   stderr=subprocess.DEVNULL, env=self.environment, start_new_session=True)
        while not os.path.exists(self.path("atwood-out/history.db")) or not self.runs():
            self.assertIsNone(process.poll(), "the run ended before it was recorded")
            time.sleep(0.02)
        os.kill(process.pid, signal.SIGKILL)
        process.wait()
        self.assertEqual([run["verdict"] for run in self.runs()], ["not finished"])
        self.ask("history", told=["not finished"])
        self.ask("run", *PART, code=[0, 1])
        self.ask("report", *PART[:-1], "--against", "1", code=2, told=["did not finish: it has no figures"])

    def test_another_schema_and_another_file(self):
        self.ask("run", *PART, code=[0, 1])
        with self.database() as database:
            database.execute("PRAGMA user_version=7")
        self.ask("history", code=5, told=["has schema 7; this program reads and writes 1"])
        self.ask("run", *PART, code=[0, 1], told=["schema 7", "this run is not kept in the history", "report: "])
        self.path("atwood-out/history.db", "not a database, but long enough to be one: " + "x" * 4096)
        self.ask("history", code=5, told=["file is not a database"])
        other = sqlite3.connect(self.path("out/history.db")) if os.makedirs(self.path("out")) is None else None
        other.execute("CREATE TABLE mine(x)")
        other.commit()
        self.ask("run", *PART, "--out", "out", code=[0, 1], told=["another kind of database"])
        self.assertEqual(other.execute("SELECT name FROM sqlite_master").fetchall(), [("mine",)])

    def test_damaged_figures_are_named(self):
        two = self.study("two.toml", "two", '"atwood/rk4", "atwood/explicit-euler"')
        self.ask("run", two, code=[0, 1])
        with self.database() as database:  # figures of the one method under the hash of the other's
            (one,), (other,) = database.execute("SELECT content FROM figures ORDER BY method").fetchall()
            database.execute("UPDATE contents SET bytes=(SELECT bytes FROM contents WHERE hash=?) WHERE hash=?", (one, other))
        self.ask("report", two, "--against", "1", code=5, told=["is damaged: an entry differs from its checksum"])

    def test_a_small_run_overwrites_no_big_report(self):
        big = self.study("big.toml", "big", '"atwood/rk4", "atwood/explicit-euler"', "240, 480")
        small = self.study("small.toml", "small")
        self.ask("run", big, code=[0, 1], told=["report: atwood-out/report.html"])
        whole = self.report_of("report.html")
        self.ask("run", small, code=[0, 1], told=["report: atwood-out/reports/small.html"])
        self.ask("run", big, "--steps", "240", code=[0, 1])
        self.assertEqual(self.report_of("report.html"), whole)
        self.assertEqual(self.report_of("reports/big.html"), whole)
        names = sorted(name for name in os.listdir(self.path("atwood-out/reports")) if not name.endswith(".trends.html"))
        self.assertEqual([re.sub("part-[0-9a-f]{8}", "part", name) for name in names], ["big.html", "big.part.html", "small.html"])
        index = self.page("index.html")
        for name in names:
            self.assertIn(f'href="reports/{name}"', index)
        self.assertEqual(index.count('href="report.html"'), 1)
        self.study("big.toml", "big", '"atwood/rk4"')  # the same study, smaller now: its newest report is shown
        self.ask("run", big, code=[0, 1], told=["report: atwood-out/report.html"])
        self.assertNotEqual(self.report_of("report.html"), whole)

    def test_hostile_names_of_studies_stay_names(self):
        ids = ["../../escape", "a/b", "..", "x" * 300, "<script>alert(1)</script>", "a.b", "A b", "-rf"]
        for i, id in enumerate(ids):
            self.ask("run", self.study(f"study{i}.toml", id), code=[0, 1])
        names = os.listdir(self.path("atwood-out/reports"))
        self.assertEqual(len(names), 2 * len(ids))
        for name in names:
            self.assertRegex(name, r"^[A-Za-z0-9_][A-Za-z0-9_-]{0,65}(\.id-[0-9a-f]{8})?(\.trends)?\.html$")
        self.assertFalse(os.path.exists(self.path("escape.html")))
        for name in ["index.html", *("reports/" + name for name in names if name.endswith(".trends.html"))]:
            self.assertNotIn("<script>alert", self.page(name))

    def test_a_full_disk_leaves_the_old_index(self):
        self.ask("run", *PART, code=[0, 1])
        before = self.page("index.html")
        os.chmod(self.path("atwood-out/index.html"), 0o644)

        def limit():  # below the size of any report, above that of what SQLite writes beside the store
            resource.setrlimit(resource.RLIMIT_FSIZE, (60000, 60000))
        result = self.run_in("report", *PART[:-1], preexec_fn=limit)
        self.assertEqual(result.returncode, 5, result.stderr)
        self.assertIn("cannot write", result.stderr)
        self.assertEqual(self.page("index.html"), before)
        self.assertEqual([name for name in os.listdir(self.path("atwood-out")) if name.startswith("index.html.")], [])

    def test_the_studys_page_plots_what_changed_level(self):
        self.ask("run", *PART, code=[0, 1])
        with self.database() as database:  # ten more runs; from run 7 on the errors are those of another method
            self.ask("run", *PART[:2], "--method", "atwood/explicit-euler", *PART[4:], code=[0, 1])
            columns = "begun_ns, ended_ns, study, selection, cells, command, commit_id, host, cpu, verdict, passed, failed, unverifiable, not_run, environment"
            database.executemany(f"INSERT INTO runs({columns}) SELECT {columns} FROM runs WHERE id=1 AND ?", [(1,)] * 10)
            database.execute("INSERT INTO figures SELECT runs.id, 'kepler-e0.6', 'atwood/rk4', 'errors', content FROM figures, runs "
                             "WHERE runs.id>2 AND figures.run=iif(runs.id<7, 1, 2)")
        self.ask("report", *PART[:-1])
        (name,) = [name for name in os.listdir(self.path("atwood-out/reports")) if re.search(r"part-\w+\.trends", name)
                   and "rk4" in self.page("reports/" + name).split("</h1>")[0]]
        page = self.page("reports/" + name)
        self.assertIn("run 7</text>", page)
        self.assertIn("error-position-end at 240 steps", page)
        self.assertNotIn("explicit-euler", page)
        self.assertRegex(page, r"\d+ figures were measured by 8 runs or more; the level of \d+ changed")

    def test_a_metric_over_many_runs(self):
        self.ask("run", *PART, code=[0, 1])
        self.ask("history", "--metric", "error-position-end", told=["1 run: change points need 8 or more"])
        with self.database() as database:
            columns = "begun_ns, ended_ns, study, selection, cells, command, commit_id, host, cpu, verdict, passed, failed, unverifiable, not_run, environment"
            database.executemany(f"INSERT INTO runs({columns}) SELECT {columns} FROM runs WHERE id=1 AND ?", [(1,)] * 499)
            database.execute("INSERT INTO figures SELECT runs.id, scenario, method, kind, content FROM figures, runs WHERE runs.id>1")
        self.ask("history", told=["and earlier ones: --json has them all"])
        self.assertEqual(len(self.runs()), 500)
        self.ask("history", "--metric", "error-position-end", "-o", "html:t.html", told=["460 earlier runs", "one level: no change point"])
        with open(self.path("t.html")) as file:
            page = file.read()
        self.assertEqual(page.count("<circle"), 500)
        self.assertNotIn("NaN", page.replace("<nan", ""))
        self.ask("run", *PART, code=[0, 1])  # the index stays short
        self.assertEqual(self.page("index.html").count('data-name="run">501</td>'), 1)
        self.assertEqual(self.page("index.html").count("kepler-e0.6 --method"), 201)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0]] + sys.argv[3:])

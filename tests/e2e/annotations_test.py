#!/usr/bin/python3
"""Edits, segments, filters, search, history and watch, by the command line.

    annotations_test.py MOTIONDBD MOTIONDB DATA_FOLDER
"""

import json
import os
import signal
import subprocess
import threading
import time

from command_line import CommandLine
from programs import MOTIONDB, Server, main

# The clips of CommandLine have 120 frames at 60 Hz.
SECONDS = 2.0


def short(name):
    """"databases/walks/clips/clip0/segments/a" -> "clip0/a"."""
    return name.split("/clips/")[-1].replace("/segments/", "/")


class Annotations(CommandLine):
    def clip(self, name):
        clip, = [each for each in self.server.ask("list", "walks") if short(each["name"]) == name]
        return clip

    def clips(self, *options):
        return [short(clip["name"]) for clip in self.server.ask("list", "walks", *options)]

    def segments(self, *options):
        """Returns {(name, track, start, end, label)}."""
        return {(short(each["name"]), each["track"], each["start_seconds"], each.get("end_seconds"),
                 each["label"]) for each in self.server.ask("segments", "list", "walks", *options)}

    def revision(self):
        """Returns the revision that a watch ends with."""
        return int(self.server.ask("watch", "walks", "--until-current")[-1]["revision"])

    def etags(self):
        """Returns the etags of all clips and segments. A new model changes none."""
        return {each["name"]: each["etag"] for command in (["list"], ["segments", "list"])
                for each in self.server.ask(*command, "walks")}

    def write(self, name, text):
        path = self.path(name)
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        return path


class Updates(Annotations):
    def test_an_update_changes_what_is_given(self):
        before = self.clip("clip0")
        self.server.ask_one("update", "walks", "clip0", "--title", "A big step", "--description", "Two\nlines",
                            "--tag", "slow", "--tag", "outdoor", "--field", "weight=70.5", "--field", "ok=true",
                            "--field", "run:text=07", "--field", "day=2026-01-31T10:00:00Z")
        after = self.clip("clip0")
        self.assertEqual(after["label"], before["label"])
        self.assertEqual(after["title"], "A big step")
        self.assertEqual(after["description"], "Two\nlines")
        self.assertEqual(after["tags"], ["outdoor", "slow"])
        self.assertEqual(after["fields"], {"weight": {"number": 70.5}, "ok": {"flag": True}, "run": {"text": "07"},
                                           "day": {"time": "2026-01-31T10:00:00Z"}})
        self.assertNotEqual(after["etag"], before["etag"])
        self.server.ask_one("update", "walks", "clip0", "--remove-tag", "slow", "--remove-field", "run")
        last = self.clip("clip0")
        self.assertEqual(last["tags"], ["outdoor"])
        self.assertNotIn("run", last["fields"])
        self.refuse("", "update", "walks", "clip0", "--label", "x", "--etag", after["etag"], code=1)
        self.assertEqual(self.clip("clip0")["label"], before["label"])
        self.server.ask_one("update", "walks", "clip0", "--label", "x", "--etag", last["etag"])
        self.assertEqual(self.clip("clip0")["label"], "x")

    def test_a_new_label_is_in_answers(self):
        self.server.ask_one("update", "walks", "clip1", "--label", "crouch")
        self.server.ask_one("update", "walks", "clip3", "--label", "crouch")
        answer = self.server.ask_one("recognize", "walks", self.files[1], "--window", "all")
        labels = {label["label"] for label in answer["windows"][0]["labels"]}
        self.assertEqual(labels, {"big step", "crouch"})

    def test_concurrent_tags_are_all_kept(self):
        def tag(number):
            for i in range(3):
                self.server.ask_one("update", "walks", "clip0", "--tag", f"t{number}-{i}")

        writers = [threading.Thread(target=tag, args=(number,)) for number in range(2)]
        for writer in writers:
            writer.start()
        for writer in writers:
            writer.join()
        self.assertEqual(self.clip("clip0")["tags"], sorted(f"t{n}-{i}" for n in range(2) for i in range(3)))

    def test_a_filter_updates_many_clips_in_one_edit(self):
        self.assertEqual(self.server.ask_one("update", "walks", "--filter", 'label = "sit"', "--tag", "low",
                                             "--dry-run"), {"clip_count": 2})
        self.assertEqual(self.clip("clip1")["tags"], [])
        edit = self.server.ask_one("update", "walks", "--filter", 'label = "sit"', "--tag", "low")["edit"]
        self.assertEqual(len(edit["objects"]), 2)
        self.assertEqual(self.clips("--filter", 'tags:"low"'), ["clip1", "clip3"])
        self.refuse("", "update", "walks", "--filter", "label ==", "--tag", "x", code=1)

    def test_a_list_sets_all_fields(self):
        self.server.ask_one("delete", "walks", "clip0")
        path = self.write("list.tsv", "path\tlabel\tsubject\ttitle\tdescription\ttags\tfield.weight\tfield.run:text\n"
                          f"{self.files[0]}\tstep\tann\tA step\tLong.\tslow,outdoor\t70\t07\n")
        self.server.ask("ingest", "walks", "--list", path)
        clip = self.clip("clip0")
        self.assertEqual((clip["label"], clip["subject"], clip["title"], clip["description"], clip["tags"]),
                         ("step", "ann", "A step", "Long.", ["outdoor", "slow"]))
        self.assertEqual(clip["fields"], {"weight": {"number": 70}, "run": {"text": "07"}})


    def test_an_ingest_stores_annotations_in_the_same_edit(self):
        self.server.ask_one("delete", "walks", "clip0")
        revision = self.revision()
        options = ("--title", "A step", "--description", "Long.", "--tag", "slow", "--tag", "outdoor",
                   "--field", "weight=70", "--field", "run:text=07")
        self.server.ask("ingest", "walks", self.files[0], "--label", "step", "--no-wait", *options)
        clip = self.clip("clip0")
        self.assertEqual((clip["title"], clip["description"], clip["tags"]), ("A step", "Long.", ["outdoor", "slow"]))
        self.assertEqual(clip["fields"], {"weight": {"number": 70}, "run": {"text": "07"}})
        self.assertEqual(int(clip["etag"]), revision + 1)  # one change, not one for each annotation
        # A replaced clip keeps what is not given.
        self.server.ask("ingest", "walks", self.files[0], "--replace", "--title", "Another", "--no-wait")
        clip = self.clip("clip0")
        self.assertEqual((clip["title"], clip["description"], clip["tags"]), ("Another", "Long.", ["outdoor", "slow"]))
        self.assertEqual((clip["label"], clip["fields"]["weight"]), ("step", {"number": 70}))
        self.refuse("header.tags[0]", "ingest", "walks", self.files[0], "--replace", "--tag", "Not good", code=1)


class Selection(Annotations):
    def setUp(self):
        super().setUp()
        self.server.ask_one("update", "walks", "clip0", "--title", "slow walk outside", "--tag", "a", "--tag", "b")
        self.server.ask_one("update", "walks", "clip1", "--title", "walk slowly", "--tag", "a", "--subject", "ann")

    def test_lists_are_filtered_sorted_and_counted(self):
        self.assertEqual(self.clips("--filter", 'label = "sit" AND subject != "ann"'), ["clip3"])
        self.assertEqual(self.clips("--order-by", "name desc"), ["clip3", "clip2", "clip1", "clip0"])
        facets = {facet["field"]: {value["value"]: value["clip_count"] for value in facet["values"]}
                  for facet in self.server.ask("list", "walks", "--facets", "label,tags")}
        self.assertEqual(facets["label"], {"big step": 2, "sit": 2})
        self.assertEqual({key: count for key, count in facets["tags"].items() if key}, {"a": 2, "b": 1})
        shown = self.show("list", "walks")
        self.assertIn("TITLE", shown)
        self.assertNotIn("TITLE", self.show("list", "walks", "--filter", 'label = "sit" AND subject = ""'))

    def test_search_finds_words_beginnings_and_phrases(self):
        def found(*words):
            return {short(match["clip"]["name"]) for match in self.server.ask("search", "walks", *words)}

        self.assertEqual(found("walk"), {"clip0", "clip1"})
        self.assertEqual(found("slow*", "walk"), {"clip0", "clip1"})
        self.assertEqual(found('"slow walk"'), {"clip0"})
        self.assertEqual(found("walk", "--filter", 'subject = "ann"'), {"clip1"})
        self.assertEqual(len(self.server.ask("search", "walks", "walk", "--top", "1")), 1)
        self.assertEqual(found("nothing"), set())

    def test_queries_use_only_clips_that_pass(self):
        seen = self.files[0]
        answer = self.server.ask_one("recognize", "walks", seen, "--window", "all", "--filter", 'label = "sit"')
        self.assertEqual({label["label"] for label in answer["windows"][0]["labels"]}, {"sit"})
        for command in ("estimate", "predict"):
            self.server.ask_one(command, "walks", seen, "--filter", 'label = "sit"')
        self.server.ask("observe", "walks", seen, "--frames-per-message", "60", "--filter", 'label = "sit"')
        self.server.ask_one("plan", "walks", "--goal", "0.1,0,0", "--tolerance", "1,1", "--filter", 'label = "big step"')
        for command in ("recognize", "estimate", "predict", "find"):
            self.refuse("", command, "walks", seen, "--filter", 'label = "none"', code=1)

    def test_a_query_waits_for_a_revision(self):
        revision = self.server.ask_one("update", "walks", "clip0", "--label", "hop", "--no-wait")["revision"]
        answer = self.server.ask_one("recognize", "walks", self.files[0], "--window", "all", "--min-revision",
                                     revision)
        self.assertGreaterEqual(int(answer["revision"]), int(revision))
        self.assertIn("hop", {label["label"] for label in answer["windows"][0]["labels"]})

    def test_filtered_clips_are_exported_and_deleted(self):
        out = self.path("out")
        self.server.ask("export", "walks", "--filter", 'label = "sit"', "--out", out)
        self.assertEqual(sorted(os.listdir(out)), ["clip1.bvh", "clip3.bvh"])
        self.assertEqual(self.server.ask_one("delete", "walks", "--filter", 'label = "sit"', "--dry-run"),
                         {"clip_count": 2})
        self.server.ask_one("delete", "walks", "--filter", 'label = "sit"', "--yes")
        self.assertEqual(self.clips(), ["clip0", "clip2"])
        self.refuse("expected a filter", "delete", "walks", "--filter", "")


class Segments(Annotations):
    def test_segments_are_added_changed_and_deleted(self):
        self.assertEqual(self.segments("--clip", "clip0"), {("clip0/" + name.split("/")[1], "action", 0, end, label)
                         for name, _, _, end, label in self.segments("--clip", "clip0")})
        added = self.server.ask_one("segments", "add", "walks", "clip0", "--from", "0", "--to", "1", "--label", "left",
                                    "--id", "a", "--confidence", "0.5")
        self.assertEqual(added["segment"]["source"], "SEGMENT_SOURCE_PERSON")
        self.server.ask_one("segments", "add", "walks", "clip0", "--from", "1", "--label", "right", "--id", "b")
        self.server.ask_one("segments", "add", "walks", "clip0", "--from", "0.5", "--to", "1.5", "--label", "box",
                            "--track", "carries", "--id", "c")
        self.refuse("overlap", "segments", "add", "walks", "clip0", "--from", "0.5", "--to", "0.6", "--label", "x",
                    code=1)
        self.refuse("", "segments", "add", "walks", "clip0", "--from", "1.6", "--label", "x", "--track", "carries",
                    "--id", "a", code=1)
        names = {(name, track, label) for name, track, _, _, label in self.segments("--clip", "clip0")}
        self.assertEqual(names, {("clip0/a", "action", "left"), ("clip0/b", "action", "right"),
                                 ("clip0/c", "carries", "box")})
        self.assertEqual(self.clip("clip0")["label"], "")
        self.server.ask_one("segments", "update", "walks", "clip0/a", "--to", "0.75", "--label", "start")
        self.assertIn(("clip0/a", "action", 0, 0.75, "start"), self.segments("--filter", 'label = "start"'))
        self.server.ask_one("segments", "delete", "walks", "clip0/a", "clip0/c")
        self.assertEqual({name for name, *_ in self.segments("--clip", "clip0")}, {"clip0/b"})
        self.refuse("", "segments", "delete", "walks", "clip0/b", "clip0/none", code=1)
        self.assertEqual({name for name, *_ in self.segments("--clip", "clip0")}, {"clip0/b"})

    def test_labels_of_a_track_are_recognized(self):
        for clip in ("clip0", "clip2"):
            self.server.ask_one("segments", "add", "walks", clip, "--from", "0", "--label", "box", "--track", "carries")
        seen = self.files[0]
        window = self.server.ask_one("recognize", "walks", seen, "--window", "all")["windows"][0]
        self.assertEqual([track["track"] for track in window["other_tracks"]], ["carries"])
        window = self.server.ask_one("recognize", "walks", seen, "--window", "all", "--track", "carries")["windows"][0]
        self.assertEqual({label["label"] for label in window["labels"]}, {"box"})
        self.assertIn("track carries: ", self.server.run("recognize", "walks", seen).stdout)

    TSV = ("clip\tstart\tend\tlabel\ttrack\tconfidence\tsource\n"
           "clip0\t0\t0.5\tlift\taction\t0.5\tperson\n"
           "clip0.bvh\t0.5\t\tstep\taction\t\t\n"
           "clip1\t0.25\t1.75\tbag\tcarries\t\tsuggestion\n")

    def test_an_import_is_repeatable(self):
        path = self.write("labels.tsv", self.TSV)
        self.assertEqual(self.server.ask_one("segments", "import", "walks", path, "--dry-run")["created_count"], 3)
        self.server.ask_one("segments", "import", "walks", path)
        stored = self.segments()
        self.assertIn(("clip0/action-0-500", "action", 0, 0.5, "lift"), stored)
        etags = self.etags()
        self.assertEqual(self.server.ask("segments", "import", "walks", path), [])
        self.assertEqual(self.etags(), etags)
        self.write("labels.tsv", self.TSV.replace("lift", "raise"))
        self.server.ask_one("segments", "import", "walks", path)
        self.assertIn(("clip0/action-0-500", "action", 0, 0.5, "raise"), self.segments())

    def test_each_format_is_exported_and_imported_unchanged(self):
        self.server.ask_one("segments", "import", "walks", self.write("labels.tsv", self.TSV))
        etags = self.etags()
        for name in ("a.tsv", "a.json"):
            path = self.path(name)
            self.server.ask("segments", "export", "walks", "--out", path)
            self.assertEqual(self.server.ask("segments", "import", "walks", path), [], name)
        babel = self.path("babel.json")
        self.server.ask("segments", "export", "walks", "--filter", 'track = "action"', "--format", "babel", "--out", babel)
        with open(babel, encoding="utf-8") as file:
            self.assertEqual({sequence["feat_p"] for sequence in json.load(file).values()},
                             {f"clip{i}.bvh" for i in range(4)})
        self.assertEqual(self.server.ask("segments", "import", "walks", babel), [])
        grids = self.path("grids")
        self.server.ask("segments", "export", "walks", "--format", "textgrid", "--out", grids)
        self.assertEqual(sorted(os.listdir(grids)), [f"clip{i}.TextGrid" for i in range(4)])
        self.assertEqual(self.server.ask("segments", "import", "walks",
                                         *[os.path.join(grids, name) for name in os.listdir(grids)]), [])
        self.assertEqual(self.etags(), etags)

    def test_the_error_of_an_import_names_the_line_and_stores_nothing(self):
        self.server.ask_one("segments", "add", "walks", "clip0", "--from", "0.2", "--to", "0.4", "--label", "x",
                            "--track", "carries")
        before = self.segments()
        for line, expected in (("clip0\tsoon\t\tx\taction\t\t", "start: expected a number"),
                               ("clip9\t0\t\tx\taction\t\t", "clip9; did you mean"),
                               ("clip0\t0\t9\tx\taction\t\t", "end: expected at most 2 s"),
                               ("clip0\t0.4\t1\tx\taction\t\t", "overlaps"),
                               ("clip0\t0.3\t1\tx\tcarries\t\t", "overlap")):
            path = self.write("wrong.tsv", self.TSV + line + "\n")
            result = self.refuse(expected, "segments", "import", "walks", path, code=1)
            if "clip9" not in expected:
                self.assertIn("wrong.tsv:5: ", result.stderr)
            self.assertEqual(self.segments(), before)


class History(Annotations):
    def test_edits_are_listed_and_undone(self):
        self.server.ask_one("update", "walks", "clip0", "--label", "hop", "--tag", "x")
        self.server.ask_one("segments", "add", "walks", "clip1", "--from", "0", "--label", "bag", "--track", "carries",
                            "--id", "a")
        edits = self.server.ask("history", "walks")
        self.assertEqual(short(edits[0]["objects"][0]["name"]), "clip1/a")
        self.assertEqual(edits[1]["objects"][0]["clip_after"]["label"], "hop")
        self.assertEqual([edit["name"] for edit in self.server.ask("history", "walks", "clip0")][0], edits[1]["name"])
        self.assertIn("label 'big step' -> 'hop'", self.server.run("history", "walks").stdout)
        number = edits[1]["name"].rsplit("/", 1)[1]
        undone = self.server.ask_one("undo", "walks", number)
        self.assertEqual((self.clip("clip0")["label"], self.clip("clip0")["tags"]), ("big step", []))
        # An undo is an edit, which can be undone.
        self.server.ask_one("undo", "walks", undone["edit"]["name"])
        self.assertEqual(self.clip("clip0")["label"], "hop")
        self.server.ask_one("update", "walks", "clip0", "--label", "skip")
        self.refuse("clip0", "undo", "walks", number, code=1)
        self.assertEqual(self.clip("clip0")["label"], "skip")


class Watching(Annotations):
    def start_watch(self, *options):
        return self.start("watch", "walks", *options)

    def start(self, *arguments):
        process = subprocess.Popen([MOTIONDB, "--server", self.server.address, "--json", *arguments],
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.stderr.close)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        return process

    @staticmethod
    def next_change(process):
        """Returns the next message that is not of a model and has a change."""
        while True:
            message = json.loads(process.stdout.readline())
            if "clip" in message or "segment" in message or message.get("deleted"):
                return message

    def test_the_present_state_is_printed_first(self):
        messages = self.server.ask("watch", "walks", "--until-current")
        self.assertEqual({short(message["clip"]["name"]) for message in messages if "clip" in message},
                         {f"clip{i}" for i in range(4)})
        self.assertTrue(messages[-1]["up_to_date"])
        self.assertTrue(any(message.get("model_version") for message in messages))
        lines = self.server.run("watch", "walks", "--until-current").stdout.splitlines()
        self.assertTrue(any(line.split()[1:3] == ["clip", "clip0"] for line in lines), lines)

    def test_changes_are_printed_as_they_happen_until_ctrl_c(self):
        process = self.start_watch("--from", str(self.revision()))
        self.server.ask_one("update", "walks", "clip0", "--title", "first")
        self.assertEqual(self.next_change(process)["clip"]["title"], "first")
        self.server.ask_one("segments", "add", "walks", "clip0", "--from", "0", "--label", "bag", "--track", "carries",
                            "--id", "a")
        self.assertEqual(self.next_change(process)["segment"]["label"], "bag")
        self.server.ask_one("segments", "delete", "walks", "clip0/a")
        self.assertEqual(short(self.next_change(process)["deleted"]), "clip0/a")
        process.send_signal(signal.SIGINT)
        self.assertEqual(process.wait(timeout=30), 0)

    def test_a_watch_survives_a_kill_of_the_server(self):
        process = self.start_watch("--from", str(self.revision()))
        self.server.ask_one("update", "walks", "clip0", "--title", "before")
        self.assertEqual(self.next_change(process)["clip"]["title"], "before")
        address = self.server.address
        self.server.stop(signal.SIGKILL)
        self.assertIn("trying again in", process.stderr.readline())
        self.server = Server(self.store, address=address)
        self.server.ask_one("update", "walks", "clip1", "--title", "after")
        message = self.next_change(process)  # the first one is not printed again
        self.assertEqual((short(message["clip"]["name"]), message["clip"]["title"]), ("clip1", "after"))
        process.send_signal(signal.SIGINT)
        self.assertEqual(process.wait(timeout=30), 0)

    def test_a_watch_ends_with_its_database(self):
        process = self.start_watch()
        self.server.run("delete", "walks", "--yes")
        self.assertEqual(process.wait(timeout=60), 1)

    def test_a_running_stream_is_listed_and_watched(self):
        self.assertEqual(self.server.ask("streams", "list", "walks"), [])
        self.start("observe", "walks", self.files[0], "--realtime", "--rate-multiplier", "0.2")
        while not self.server.ask("streams", "list", "walks"):
            time.sleep(0.1)
        stream, = self.server.ask("streams", "list", "walks")
        self.assertEqual(stream["frame_rate_hz"], 60)
        number = short(stream["name"]).rsplit("/", 1)[1]
        self.assertIn("STARTED", self.show("streams", "list", "walks"))
        watching = self.start("streams", "watch", "walks", number)
        first, *answers = [json.loads(line) for line in watching.stdout]
        self.assertEqual(watching.wait(timeout=60), 0)
        self.assertEqual(first["stream"]["name"], stream["name"])
        frames = [int(answer["answer"]["frame"]) for answer in answers]
        skipped = [int(answer["skipped_count"]) for answer in answers]
        self.assertEqual(frames[-1], 119)
        self.assertEqual(frames[1:], [before + 1 + left_out for before, left_out in zip(frames, skipped[1:])])
        self.assertEqual(len(answers[-1]["marker_positions"]) % 3, 0)
        self.refuse("", "streams", "watch", "walks", number, code=1)

    def test_names_are_completed_and_suggested(self):
        self.server.ask_one("segments", "add", "walks", "clip0", "--from", "0", "--label", "bag", "--track", "carries",
                            "--id", "bag1")

        def completions(*words):
            result = subprocess.run([MOTIONDB, "__complete", *words], capture_output=True, text=True,
                                    env={**os.environ, "MOTIONDB_SERVER": self.server.address})
            return [line.split("\t")[0] for line in result.stdout.splitlines()]

        self.assertEqual(completions("update", "walks", "clip"), [f"clip{i}" for i in range(4)])
        self.assertEqual(completions("segments", "update", "walks", "clip0/b"), ["clip0/bag1"])
        edit = self.server.ask("history", "walks")[0]["name"].rsplit("/", 1)[1]
        self.assertIn(edit, completions("undo", "walks", ""))
        self.refuse("did you mean 'clip0'?", "update", "walks", "cilp0", "--label", "x", code=1)
        self.refuse("did you mean 'clip0/bag1'?", "segments", "delete", "walks", "clip0/bga1", code=1)


main()

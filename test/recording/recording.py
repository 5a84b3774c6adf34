#!/usr/bin/env python3
"""The recording: what the tools, the Python module and the node answer to recorded input, byte for byte.

usage: recording.py tools|python|node [--programs DIR] [--module DIR] [--gtest_output=xml:FILE]

cases/PART.txt is a list of questions, each a line, in groups; answers/PART/GROUP.txt has what was answered. With PROXIMITY_RECORD=1
in the environment the answers are written anew. Long ones are recorded as their first lines and a hash; PROXIMITY_RECORD_WHOLE=DIR
writes them whole into a folder: a diff of two such folders, of before and after a change, shows all of it.
"""

import argparse
import hashlib
import importlib
import os
import pathlib
import re
import sys
import tempfile
import unittest

HERE = pathlib.Path(__file__).resolve().parent
SOURCE = HERE.parents[1]
sys.path.insert(0, str(HERE))
import robots  # noqa: E402

RECORDS = os.environ.get("PROXIMITY_RECORD") == "1"
WHOLE = os.environ.get("PROXIMITY_RECORD_WHOLE") and pathlib.Path(os.environ["PROXIMITY_RECORD_WHOLE"]).resolve()

LINES, WIDTH = 12, 1500  # of what is kept of an answer
QUESTION = "=== "  # begins the line of a question in the files of answers


VARYING = [(r"[0-9.e+]+ states per core-hour", "<speed>"), (r'("program": {\n *"version": .*\n *"digest": ").*"', r'\1<of the library>"'),
           (r'("seconds": )[0-9.e+-]+', r"\1<time>"), (r"\S*/proximity_replay_\w+", "<folder>"),
           (r"(folders that are searched: )[^'\"\n]*", r"\1<folders>")]


def without_what_differs(text):
    """Without places of files, the version, times, and the hash of the programs."""
    for varying, name in ((os.getcwd(), "<here>"), (str(SOURCE), "<source>"), (str(SOURCE.parent / "shared/robots"), "<robots>"),
                          (f"proximity_server {robots.version()}", "proximity_server <version>")):
        text = text.replace(varying, name)
    for varying, name in VARYING:
        text = re.sub(varying, name, text)
    return text


def digest(data):
    return hashlib.sha256(data).hexdigest()[:16]


def shortened(text):
    """Its first lines, and a hash of all."""
    lines = text.split("\n")
    kept = [line if len(line) <= WIDTH else f"{line[:WIDTH]}... {len(line)} characters, sha256 {digest(line.encode())}"
            for line in lines]
    if len(lines) > LINES + 2:
        kept[LINES:] = [f"... {len(lines)} lines, sha256 {digest(text.encode())}"]
    return "\n".join(kept)


class Blocks:
    """An answer of several texts, each shortened by itself."""

    def __init__(self):
        self.blocks = []

    def add(self, title, text):
        if text:
            self.blocks.append((title, without_what_differs(text).rstrip("\n")))

    def text(self, form):
        return "\n".join(f"--- {title}\n{form(text)}" if title else form(text) for title, text in self.blocks)


def questions(part):
    """The groups of a part: name -> list of questions. A question goes on in lines that are indented."""
    groups, group = {}, None
    for line in (HERE / "cases" / f"{part}.txt").read_text().splitlines():
        if line.startswith("[") and line.endswith("]"):
            group = groups.setdefault(line[1:-1], [])
        elif line.startswith(" "):
            group[-1] += "\n" + line
        elif line and not line.startswith("#"):
            group.append(line)
    return groups


def read(path):
    """Question -> answer, of a file of answers."""
    if not path.exists():
        return {}
    pieces = ("\n" + path.read_text()).split("\n" + QUESTION)[1:]
    parts = (piece.partition("\n:::\n") for piece in pieces)
    return {question: answer.rstrip("\n") for question, _, answer in parts}


def write(path, answers):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("".join(f"{QUESTION}{question}\n:::\n{answer}\n" for question, answer in answers.items()))


def first_difference(recorded, now):
    recorded, now = recorded.split("\n"), now.split("\n")
    count = max(len(recorded), len(now))
    before, after = (lines + ["(nothing)"] * (count - len(lines)) for lines in (recorded, now))
    at = next(i for i in range(count) if before[i] != after[i])
    return f"line {at + 1}\n  recorded: {before[at]}\n  now:      {after[at]}"


def differences(recorded, now):
    for question in {**recorded, **now}:
        if question not in now:
            yield f"{question}\n  is recorded, but asked no more"
        elif question not in recorded:
            yield f"{question}\n  has no recorded answer"
        elif recorded[question] != now[question]:
            yield f"{question}\n  differs in {first_difference(recorded[question], now[question])}"


def answers_of(part, group, asked):
    """The answers whole, and as they are recorded. A question that is there twice gets the number of its repetition."""
    whole, short = {}, {}
    for question, blocks in part.answers(group, asked):
        repeated = sum(1 for key in whole if key.split("  # again")[0] == question)
        key = f"{question}  # again {repeated}" if repeated else question
        whole[key] = blocks.text(str)
        short[key] = "\n".join(line.rstrip() for line in blocks.text(shortened).split("\n"))
    return whole, short


def check(test, part, name, group, asked):
    reason = part.missing(group)
    if reason:
        test.skipTest(reason)
    whole, now = answers_of(part, group, asked)
    path = HERE / "answers" / name / f"{group}.txt"
    if WHOLE:
        write(WHOLE / name / path.name, whole)
    if RECORDS:
        write(path, now)
    found = list(differences(read(path), now))
    if found:
        test.fail(f"{len(found)} of {len(now)} answers are not those of {path}:\n" + "\n".join(found[:20]) +
                  "\n(test/README.md tells how to see them whole, and how to record anew)")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("part", choices=["tools", "python", "node"])
    parser.add_argument("--programs", type=os.path.abspath)
    parser.add_argument("--module", type=os.path.abspath)
    options, others = parser.parse_known_args()
    sys.argv[1:] = others

    with tempfile.TemporaryDirectory(prefix="recording_") as folder:
        os.chdir(folder)
        part = importlib.import_module(f"{options.part}_part")
        part.prepare(options)

        class Recording(unittest.TestCase):
            pass

        for number, (group, asked) in enumerate(questions(options.part).items()):
            def test(self, group=group, asked=asked):
                check(self, part, options.part, group, asked)
            setattr(Recording, f"test_{number:02}_{group}", test)
        try:
            part.run("proximity_server", f"recording_{options.part}", Recording)
        finally:
            os.chdir("/")


if __name__ == "__main__":
    main()

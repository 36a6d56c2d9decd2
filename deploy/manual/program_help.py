"""Parses the output of --help in the layout of CLI11, also if descriptions are wrapped."""

import re
import subprocess
from dataclasses import dataclass, field

COLUMN = 30  # first column of the descriptions of CLI11


@dataclass
class Entry:
    """An option, a positional argument or a command."""
    names: list      # ["-h", "--help"], ["DB"], ["ingest"]
    value: str       # text after the names: "FILE", "N:INT in [0 - 10]=0"
    description: str

    @property
    def flag(self):
        return self.names[-1]

    @property
    def takes_value(self):
        """The value of a flag is empty or only its variable: "(Env:NAME)"."""
        return bool(self.value) and not self.value.startswith("(")

    @property
    def choices(self):
        """The allowed words, if the value has a fixed set."""
        found = re.search(r"\{([^{}]*)\}", self.value)
        return found.group(1).split(",") if found else []


@dataclass
class Help:
    words: list                                   # the command: ["operations", "list"]; []: the program
    description: str = ""
    usage: str = ""
    groups: dict = field(default_factory=dict)    # heading -> entries
    examples: list = field(default_factory=list)  # command lines
    footer: str = ""
    commands: list = field(default_factory=list)  # of Help

    @property
    def options(self):
        return [entry for group in self.groups.values() for entry in group
                if entry.flag.startswith("-")]

    @property
    def positionals(self):
        return self.groups.get("Positionals", [])

    def walk(self):
        """Yields this and all commands below it."""
        yield self
        for command in self.commands:
            yield from command.walk()


def parse_entry(lines):
    first = lines[0]
    # Names are at least two spaces before a description on the same line; names have no two spaces.
    has_description = len(first) > COLUMN and (len(lines) == 1 or first[COLUMN - 2:COLUMN] == "  ")
    left, right = (first[:COLUMN], first[COLUMN:]) if has_description else (first, "")
    right = " ".join([right, *(line.strip() for line in lines[1:])])
    names, _, value = left.strip().partition(" ")
    return Entry(names.split(","), value.strip(), right.strip())


def parse(words, text):
    result = Help(words)
    heading, before, after = None, [], []
    entries = []  # (heading, lines)
    for line in text.splitlines():
        if line.startswith("Usage: "):
            result.usage = line.removeprefix("Usage: ")
        elif line == "Examples:":
            heading = None
        elif heading is None and line.startswith("  ") and result.usage:
            result.examples.append(line.strip())
        elif re.fullmatch(r"[A-Z][A-Za-z ]*:", line):
            heading = line[:-1]
            result.groups[heading] = []
        elif line.startswith(" " * COLUMN) and entries:
            entries[-1][1].append(line)
        elif line.startswith("  ") and heading:
            entries.append((heading, [line]))
        elif line.strip():
            (after if result.usage else before).append(line)
    for group, lines in entries:
        result.groups[group].append(parse_entry(lines))
    result.description, result.footer = " ".join(before), "\n".join(after)
    return result


def read(program, words=()):
    """Returns the Help of the program or command, with all commands below it."""
    answer = subprocess.run([program, *words, "--help"], capture_output=True, text=True, check=True)
    result = parse(list(words), answer.stdout)
    result.commands = [read(program, [*words, entry.flag])
                       for entry in result.groups.pop("Subcommands", [])]
    return result


def version(program):
    answer = subprocess.run([program, "--version"], capture_output=True, text=True, check=True)
    return answer.stdout.split()[-1]

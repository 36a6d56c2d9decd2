#!/usr/bin/python3
"""Writes a manual page from a template, --help of the program, and the sample configuration.

    write_man.py TEMPLATE PROGRAM SAMPLE > page

Replaces the lines @OPTIONS@, @COMMANDS@ and @SETTINGS@ of the template, and @VERSION@ in all lines.
"""

import re
import sys

import program_help


def escape(text):
    text = text.replace("\\", "\\e").replace("-", "\\-").replace("'", "\\(aq")
    return re.sub(r"(?m)^\.", r"\\&.", text)


def entry_lines(entry):
    names = ", ".join(f"\\fB{escape(name)}\\fR" for name in entry.names)
    value = f" \\fI{escape(entry.value)}\\fR" if entry.value else ""
    return [".TP", names + value, escape(entry.description)]


def option_lines(program):
    lines = []
    for heading, entries in program.groups.items():
        if heading != "Options":
            lines.append(f".SS {escape(heading)}")
        for entry in entries:
            lines += entry_lines(entry)
    return lines


def command_lines(program):
    lines = []
    for command in list(program.walk())[1:]:
        lines += [f".SS {escape(' '.join(command.words))}", escape(command.description) + ".",
                  ".PP", f"\\fB{escape(command.usage)}\\fR"]
        for entry in command.positionals:
            lines += entry_lines(entry)
        for entry in command.options:
            if entry.flag != "--help":
                lines += entry_lines(entry)
        lines += [".PP", "Examples:", ".nf", *map(escape, command.examples), ".fi"]
    return lines


def setting_lines(sample):
    """Returns the settings of the sample; the comment above a setting is its description."""
    lines, comment = [], []
    for line in sample.splitlines():
        if heading := re.fullmatch(r"## (.*?) -+", line):
            lines.append(f".SS {escape(heading.group(1))}")
            comment = []
        elif setting := re.fullmatch(r"#?([a-z][a-z0-9-]*) = (.*)", line):
            lines += [".TP", f"\\fB{escape(setting.group(1))}\\fR = \\fI{escape(setting.group(2))}\\fR",
                      escape(" ".join(comment))]
            comment = []
        elif line.startswith("# "):
            comment.append(line[2:])
        elif not line:
            comment = []
    return lines


def main():
    template, program, sample = sys.argv[1:]
    described = program_help.read(program)
    blocks = {"@OPTIONS@": option_lines(described), "@COMMANDS@": command_lines(described),
              "@SETTINGS@": setting_lines(open(sample, encoding="utf-8").read())}
    version = program_help.version(program)
    for line in open(template, encoding="utf-8").read().splitlines():
        print("\n".join(blocks.get(line, [line.replace("@VERSION@", version)])))


main()

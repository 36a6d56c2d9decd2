"""Runs a program with its standard output on a terminal of a given size."""

import fcntl
import os
import pty
import re
import struct
import subprocess
import termios

COLOUR = re.compile("\x1b\\[[0-9;]*m")


def run_on_terminal(command, columns=80, rows=24, environment=None):
    """Returns exit code, standard output with colours, and standard error."""
    master, slave = pty.openpty()
    fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))
    variables = {**os.environ, "TERM": "xterm", **(environment or {})}
    if environment is None:
        variables.pop("NO_COLOR", None)
    process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=slave,
                               stderr=subprocess.PIPE, env=variables)
    os.close(slave)
    shown = b""
    while True:
        try:
            block = os.read(master, 65536)
        except OSError:  # the last process closed the terminal
            break
        if not block:
            break
        shown += block
    os.close(master)
    error = process.stderr.read().decode()
    process.stderr.close()
    return process.wait(timeout=60), shown.decode().replace("\r\n", "\n"), error

"""Runs a program with its standard output on a terminal of a given size."""

import fcntl
import os
import pty
import re
import struct
import subprocess
import termios
import threading

COLOUR = re.compile("\x1b\\[[0-9;]*m")


# Written to the terminal after the program has ended. No program of motiondb writes it.
END = b"\x00end\x00"


def run_on_terminal(command, columns=80, rows=24, environment=None):
    """Returns exit code, standard output with colours, and standard error."""
    master, slave = pty.openpty()
    fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))
    variables = {**os.environ, "TERM": "xterm", **(environment or {})}
    if environment is None:
        variables.pop("NO_COLOR", None)
    process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=slave,
                               stderr=subprocess.PIPE, env=variables)
    error = []

    def wait():
        try:
            error.append(process.stderr.read().decode())
            process.wait(timeout=60)
        finally:
            os.write(slave, END)

    waiting = threading.Thread(target=wait)
    waiting.start()
    # Until END, and not until the terminal is closed: a read may fail with EIO as soon as the last
    # process has closed it, before all that was written has arrived.
    shown = b""
    while not shown.endswith(END):
        shown += os.read(master, 65536)
    waiting.join()
    process.stderr.close()
    os.close(slave)
    os.close(master)
    return process.returncode, shown.removesuffix(END).decode().replace("\r\n", "\n"), error[0]

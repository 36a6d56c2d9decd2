"""The files of deploy/ that the tests compare with motiondbd, the first argument of each test."""

import os
import re
import subprocess
import sys

try:
    import yaml  # noqa: F401: the tests import it from here
except ImportError:
    print("skipped: no python3-yaml; deploy/install_packages.sh deploy-test")
    sys.exit(77)

MOTIONDBD = sys.argv[1]
DEPLOY = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../deploy")


def read(*path):
    with open(os.path.join(DEPLOY, *path), encoding="utf-8") as file:
        return file.read()


def settings():
    text = subprocess.run([MOTIONDBD, "--help"], capture_output=True, text=True, check=True).stdout
    return set(re.findall(r"^ +--([a-z][-a-z]*)", text, re.MULTILINE))


def variable_of(setting):
    return "MOTIONDBD_" + setting.upper().replace("-", "_")


class Image:
    """The last stage of the Dockerfile."""
    def __init__(self):
        text = read("docker/Dockerfile").replace("\\\n", " ")
        last = text[text.rindex("\nFROM "):]
        self.lines = re.findall(r"^([A-Z]+) (.*)$", last, re.MULTILINE)
        self.all_lines = re.findall(r"^([A-Z]+) (.*)$", text, re.MULTILINE)
        self.variables = dict(re.findall(r"(MOTIONDBD_\w+)=(\S+)", " ".join(self.of("ENV"))))
        self.ports = {int(port) for line in self.of("EXPOSE") for port in line.split()}
        self.user, self.volume = self.of("USER")[0], self.of("VOLUME")[0]

    def of(self, instruction):
        return [rest for name, rest in self.lines if name == instruction]


IMAGE = Image()

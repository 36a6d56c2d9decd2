"""Certificates, and motiondbd with any flags, for security tests."""

import os
import subprocess

import programs


def openssl(*arguments):
    subprocess.run(["openssl", *arguments], check=True, capture_output=True)


NEW_KEY = ["-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes"]


class Authority:
    """A certificate authority; its files are in a folder."""

    def __init__(self, folder, name):
        self.folder = folder
        self.certificate, self.key = self.path(name + ".crt"), self.path(name + ".key")
        openssl("req", "-x509", *NEW_KEY, "-days", "2", "-subj", "/CN=" + name,
                "-keyout", self.key, "-out", self.certificate)

    def path(self, name):
        return os.path.join(self.folder, name)

    def issue(self, file, common_name, names="DNS:localhost,IP:127.0.0.1"):
        """Writes file.crt and file.key, each atomically, as a replacement should be."""
        with open(self.path("names"), "w") as names_file:
            names_file.write("subjectAltName = " + names + "\n")
        openssl("req", *NEW_KEY, "-subj", "/CN=" + common_name,
                "-keyout", self.path("new.key"), "-out", self.path("new.csr"))
        openssl("x509", "-req", "-days", "2", "-in", self.path("new.csr"), "-CA", self.certificate,
                "-CAkey", self.key, "-CAcreateserial", "-extfile", self.path("names"),
                "-out", self.path("new.crt"))
        for suffix in (".key", ".crt"):
            os.rename(self.path("new" + suffix), self.path(file + suffix))
        return self.path(file + ".crt"), self.path(file + ".key")


class SecureServer:
    """motiondbd with any flags; its log is in a file."""

    def __init__(self, store, *flags, listen="127.0.0.1:0"):
        self.log_path = store + ".log"
        self.log_file = open(self.log_path, "a")
        self.process = subprocess.Popen(
            [programs.MOTIONDBD, "--store", store, "--listen", listen, "--log-level", "debug",
             "--rebuild-delay", "0.05", *flags],
            stdout=subprocess.PIPE, stderr=self.log_file, text=True)
        self.web = None  # address of its HTTP API, if enabled
        for line in self.process.stdout:
            self.address = line.strip().rsplit(" ", 1)[-1]
            if line.startswith("motiondbd: listening on "):
                break
            if line.startswith("motiondbd: HTTP API at "):
                self.web = self.address
            else:
                self.metrics = self.address  # the metrics address, if enabled

    def stop(self):
        self.process.terminate()
        code = self.process.wait(timeout=60)
        self.process.stdout.close()
        self.log_file.close()
        return code

    def log(self):
        with open(self.log_path) as log:
            return log.read()

    def run(self, *arguments, token=None, flags=(), address=None):
        environment = {key: value for key, value in os.environ.items()
                       if not key.startswith("MOTIONDB_")}
        if token:
            environment["MOTIONDB_TOKEN"] = token
        return subprocess.run(
            [programs.MOTIONDB, "--server", address or self.address, *flags, *arguments],
            capture_output=True, text=True, env=environment)

"""motiondbd as in production, with TLS and tokens, and statistics of its process from the
kernel."""

import contextlib
import os

import programs
from figure import write_bvh
from secure_server import Authority

MB = 1e6


class Measured:
    """motiondbd with a database, measured through /proc."""

    def __init__(self, folder, plain, group, options):
        self.folder, self.group = folder, group
        self.options = ["--http-listen", "127.0.0.1:0", "--web-listen", "127.0.0.1:0", *options]
        self.store = os.path.join(folder, "motion.db")
        self.client_options, self.token, self.reader_token = [], "", ""
        self.fill()
        if not plain:
            authority = Authority(folder, "authority")
            certificate, key = authority.issue("server", "localhost")
            self.options += ["--tls-certificate", certificate, "--tls-key", key,
                             "--authentication", "token"]
            self.client_options = ["--tls-ca", authority.certificate, "--token", self.reader]
            self.token, self.reader_token = self.stranger, self.reader

    def fill(self):
        """Creates the database and two tokens, on a server without authentication."""
        server = programs.Server(self.store, "--http-listen", "none")
        files = f"{programs.DATA}/sets/database1.train.tsv"
        if os.path.exists(files):
            self.motion = f"{programs.DATA}/cmu/10/10_01.bvh"
            server.ask_one("create", "motion")
            server.ask("ingest", "motion", "--list", files)
        else:
            files = [os.path.join(self.folder, f"figure{seed}.bvh") for seed in range(6)]
            for seed, file in enumerate(files):
                write_bvh(file, seed, frames=600)
            self.motion = files[0]
            server.ask_one("create", "motion", "--marker-set", "source", "--min-frames", "4")
            server.ask("ingest", "motion", *files)
        self.reader, self.stranger = [
            server.run("token", "create", "--role", "reader").stdout.strip() for _ in range(2)]
        server.stop()

    def start(self):
        """AssertionError if it listens on a port that it did not announce."""
        self.server = programs.Server(self.store, *self.options, group=self.group)
        self.pid = self.server.process.pid
        announced = {host_and_port(address)[1] for address in
                     (self.server.address, self.server.http, self.server.web)}
        assert self.listening_ports() == announced, self.listening_ports()

    def runs(self):
        return self.server.process.poll() is None

    def stop(self, kill=False):
        """Stops the server. Returns whether it exited with 0."""
        if self.runs() and not kill:
            return self.server.stop() == 0
        self.server.process.kill()
        self.server.process.wait()
        self.server.process.stdout.close()
        return False

    def memory(self, field):
        """Returns VmRSS, or VmHWM: the peak since forget_peak. In MB; 0 if the server has ended."""
        try:
            with open(f"/proc/{self.pid}/status", encoding="ascii") as status:
                return next((int(line.split()[1]) * 1024 / MB for line in status
                             if line.startswith(field)), 0)
        except OSError:
            return 0

    def forget_peak(self):
        with open(f"/proc/{self.pid}/clear_refs", "w", encoding="ascii") as file:
            file.write("5")

    def listening_ports(self):
        inodes = set()
        for descriptor in os.listdir(f"/proc/{self.pid}/fd"):
            with contextlib.suppress(OSError):
                inodes.add(os.readlink(f"/proc/{self.pid}/fd/{descriptor}"))
        ports = set()
        for table in ("tcp", "tcp6"):
            with open(f"/proc/{self.pid}/net/{table}", encoding="ascii") as file:
                for row in [line.split() for line in list(file)[1:]]:
                    if row[3] == "0A" and f"socket:[{row[9]}]" in inodes:
                        ports.add(int(row[1].rsplit(":", 1)[1], 16))
        return ports


def host_and_port(address):
    host, port = address.split("//")[-1].rsplit(":", 1)
    return host, int(port)

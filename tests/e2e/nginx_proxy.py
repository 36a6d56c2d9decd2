"""nginx with deploy/nginx/motiondb.conf, and with the addresses and the certificate of a test; and
processes that end with the tests of a class."""

import os
import shutil
import socket
import subprocess
import time
import unittest

FRONT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../deploy/nginx/motiondb.conf")
PATH = os.environ["PATH"] + ":/usr/sbin"

FRAME = """\
daemon off;
pid {folder}/nginx.pid;
error_log {folder}/error.log warn;
worker_processes 2;
events {{ worker_connections 256; }}
http {{
  access_log {folder}/access.log;
  client_body_temp_path {folder}/body;
  proxy_temp_path {folder}/proxy;
  fastcgi_temp_path {folder}/fastcgi;
  uwsgi_temp_path {folder}/uwsgi;
  scgi_temp_path {folder}/scgi;
  include {folder}/motiondb.conf;
}}
"""


def free_port():
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return listener.getsockname()[1]


def write_certificate(key, certificate):
    """Writes a certificate of motion.example.org, which is its own authority."""
    subprocess.run(["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2",
                    "-subj", "/CN=motion.example.org",
                    "-addext", "subjectAltName=DNS:motion.example.org",
                    "-keyout", key, "-out", certificate], check=True, capture_output=True)


def replace(text, old, new):
    assert old in text, f"{FRONT} has no {old}"
    return text.replace(old, new)


class WithProcesses(unittest.TestCase):
    @classmethod
    def start(cls, *command, **options):
        process = subprocess.Popen(command, **options)

        def end():
            process.terminate()
            process.wait(timeout=60)
            if process.stdout:
                process.stdout.close()
        cls.addClassCleanup(end)
        return process


class Nginx:
    """nginx before the servers at the given addresses. Its files are in `folder`."""

    def __init__(self, folder, servers):
        self.folder = folder
        os.chmod(folder, 0o755)  # the worker processes of root are another user
        self.port = free_port()
        # The options of motiondb.
        self.options = ("--server", f"127.0.0.1:{self.port}", "--tls-ca", self.path("motiondb.crt"),
                        "--tls-server-name", "motion.example.org")
        write_certificate(self.path("motiondb.key"), self.path("motiondb.crt"))
        with open(FRONT, encoding="utf-8") as file:
            text = file.read()
        text = replace(text, "  server 127.0.0.1:50051;",
                       "\n".join(f"  server {server};" for server in servers))
        text = replace(text, "listen 443 ssl http2;", f"listen 127.0.0.1:{self.port} ssl http2;")
        text = replace(text, "/etc/nginx/tls/motiondb.", self.path("motiondb."))
        with open(self.path("motiondb.conf"), "w", encoding="utf-8") as file:
            file.write(text)
        with open(self.path("nginx.conf"), "w", encoding="utf-8") as file:
            file.write(FRAME.format(folder=folder))
        command = [shutil.which("nginx", path=PATH), "-p", folder, "-e", self.path("error.log"),
                   "-c", self.path("nginx.conf")]
        subprocess.run([*command, "-t", "-q"], check=True)
        self.process = subprocess.Popen(command)
        for _ in range(600):
            try:
                socket.create_connection(("127.0.0.1", self.port), timeout=1).close()
                return
            except OSError:
                time.sleep(0.1)
        self.stop()
        raise AssertionError("nginx does not listen")

    def path(self, name):
        return os.path.join(self.folder, name)

    def stop(self):
        self.process.terminate()
        self.process.wait(timeout=60)

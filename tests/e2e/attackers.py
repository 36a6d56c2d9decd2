"""Attacker processes. Each plays the script of an attack (floods.py) on its own connections, and
reopens a connection that the server has closed."""

import dataclasses
import multiprocessing
import select
import socket
import ssl
import time
import typing

from http2 import WINDOW_UPDATE

# Not the address of the well-behaved client: the limits of one address must not affect both.
SOURCE = "127.0.0.2"
CHUNK_BYTES = 1 << 16
ENDED = select.POLLHUP | select.POLLERR | select.POLLRDHUP | select.POLLNVAL
CONNECTIONS, BYTES, ENDED_BY_SERVER, REFUSED = range(4)  # indices of the counters


@dataclasses.dataclass(frozen=True)
class Attack:
    # script(connection, aim) yields bytes to send or seconds to pause. It may wait for
    # connection.window. At its end the connection is closed and reopened.
    script: typing.Callable
    reads: bool = True  # reads the server's bytes
    sockets: int = 1  # per attacker
    port: str = "listen"  # listen: gRPC; web: the HTTP API; http: metrics and probes
    tls: bool = True  # does a TLS handshake if the port uses TLS; otherwise writes to the bare socket
    max_attackers: int = 1000
    allowed: bool = False  # the server must not end these connections


@dataclasses.dataclass(frozen=True)
class Aim:
    """Target of an attack."""
    address: tuple  # host, port
    tls: typing.Optional[ssl.SSLContext]
    token: str  # a valid token; empty if none is needed
    database: str


def context(protocol):
    """TLS for "h2" or "http/1.1"."""
    tls = ssl.create_default_context()
    tls.check_hostname, tls.verify_mode = False, ssl.CERT_NONE
    tls.set_alpn_protocols([protocol])
    return tls


class Connection:
    def __init__(self, attack, aim, counts, poller):
        self.attack, self.aim, self.counts, self.poller = attack, aim, counts, poller
        self.socket = None
        self.pause_until = 0

    def open(self):
        self.chunk, self.received = memoryview(b""), b""
        self.window = 65535  # of the connection, updated by WINDOW_UPDATE frames
        try:
            self.socket = socket.create_connection(self.aim.address, 3, (SOURCE, 0))
            if self.aim.tls and self.attack.tls:
                self.socket = self.aim.tls.wrap_socket(self.socket)
            self.socket.setblocking(False)
        except OSError:
            self.counts[REFUSED] += 1
            self.close()
            self.pause_until = time.monotonic() + 0.02
            return
        self.counts[CONNECTIONS] += 1
        self.pause_until = 0
        self.script = self.attack.script(self, self.aim)
        self.poller.register(self.socket, self.interest())

    def close(self):
        if self.socket is not None:
            try:
                self.poller.unregister(self.socket)
            except (KeyError, ValueError):
                pass
            self.socket.close()
        self.socket = None

    def interest(self):
        paused = self.pause_until > time.monotonic()
        return (select.POLLRDHUP | (select.POLLIN if self.attack.reads else 0) |
                (0 if paused else select.POLLOUT))

    def handle(self, events):
        try:
            if events & select.POLLIN:
                self.receive()
            if events & ENDED:
                raise ConnectionResetError
            if events & select.POLLOUT:
                self.send()
        except (BlockingIOError, ssl.SSLWantReadError, ssl.SSLWantWriteError):
            pass
        except OSError:
            self.counts[ENDED_BY_SERVER] += 1
            self.close()
        except StopIteration:
            self.close()

    def send(self):
        for _ in range(8):
            while not self.chunk:
                step = next(self.script)
                if isinstance(step, float):
                    self.pause_until = time.monotonic() + step
                    return
                self.chunk = memoryview(step)
            sent = self.socket.send(self.chunk[:CHUNK_BYTES])
            self.counts[BYTES] += sent
            self.chunk = self.chunk[sent:]

    def receive(self):
        try:
            while received := self.socket.recv(1 << 18):
                self.count_window(received)
        except (BlockingIOError, ssl.SSLWantReadError, ssl.SSLWantWriteError):
            return
        raise ConnectionResetError

    def count_window(self, received):
        self.received += received
        while len(self.received) >= 9:
            end = 9 + int.from_bytes(self.received[:3], "big")
            if len(self.received) < end:
                break
            if self.received[3] == WINDOW_UPDATE and self.received[5:9] == bytes(4):
                self.window += int.from_bytes(self.received[9:13], "big")
            self.received = self.received[end:]
        self.received = self.received[-(1 << 16):]  # bounds the buffer if the peer does not send HTTP/2


def _attack(attack, aim, counts, seconds, group, share):
    """Runs one attacker. Without a cgroup it limits itself to `share` of a core."""
    if group:
        group.join()
    poller = select.poll()
    connections = [Connection(attack, aim, counts, poller) for _ in range(attack.sockets)]
    began, worked_before = time.monotonic(), time.process_time()
    while (elapsed := time.monotonic() - began) < seconds:
        for connection in connections:
            if connection.socket is None and connection.pause_until < time.monotonic():
                connection.open()
            if connection.socket is not None:
                poller.modify(connection.socket, connection.interest())
            if time.monotonic() - began > seconds:
                return
        events = dict(poller.poll(20))
        for connection in connections:
            if connection.socket is not None and (happened := events.get(connection.socket.fileno())):
                connection.handle(happened)
        ahead = time.process_time() - worked_before - share * elapsed
        if not group and ahead > 0:
            time.sleep(ahead / share)


class Attackers:
    """Starts `count` attacker processes that run for `seconds`."""

    def __init__(self, attack, aim, count, seconds, cores, group):
        count = min(count, attack.max_attackers)
        processes = multiprocessing.get_context("fork")
        self.counts = [processes.RawArray("Q", 4) for _ in range(count)]
        self.processes = [
            processes.Process(target=_attack, daemon=True,
                              args=(attack, aim, counts, seconds, group, cores / count))
            for counts in self.counts]
        for process in self.processes:
            process.start()

    def stop(self):
        """Returns totals: connections, bytes sent, connections closed by the server, connections
        refused."""
        for process in self.processes:
            process.terminate()
        for process in self.processes:
            process.join()
        return [sum(counts[i] for counts in self.counts) for i in range(4)]

    def wait(self):
        for process in self.processes:
            process.join()

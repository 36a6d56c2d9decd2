#!/usr/bin/python3
"""Attacks every TCP port of motiondbd (floods.py) while a well-behaved client measures latency.

    flood_test.py MOTIONDBD MOTIONDB DATA_FOLDER STEADY_CLIENT [--short] [--attack NAME]...

The server uses TLS and tokens, or neither with --plain, and has 512 MiB. All attackers together have
half a core. Each attack starts with a new server. Prints one line per attack. Exit code 1 if a bar
is missed.
"""

import argparse
import contextlib
import shlex
import sys
import tempfile
import time

import control_group
import programs
from attackers import Aim, Attackers, context
from floods import ATTACKS, MOST_IMPORTANT
from measured_server import MB, Measured, host_and_port
from steady_clients import Repeated, SteadyClient, WebClient, livez

PEAK_MB = 300  # resident memory of the server
SERVER_BYTES = 512 << 20
ATTACKER_CORES = 0.5
P99_MS = {"health": 250, "livez": 250, "recognize": 1000, "web": 1000}
MAX_MS = 3000  # of any call, and of a new connection with a health check
ROW = "{:<24}{:>7}{:>9}{:>8}{:>8}{:>7}{:>6}{:>13}{:>13}{:>13}{:>13}{:>13}{:>6}  {}"


def watch(measured, seconds):
    """Returns the server's peak memory within `seconds`. Kills the server above SERVER_BYTES if no
    cgroup limits it."""
    until, peak = time.monotonic() + seconds, 0
    while time.monotonic() < until and measured.runs():
        peak = max(peak, measured.memory("VmHWM"))
        if peak * MB > SERVER_BYTES and not measured.group and programs.SLOWNESS == 1:
            measured.stop(kill=True)
        time.sleep(0.05)
    return peak


def problems(attack, peak, totals, latencies, ran):
    found = [] if ran else ["the server ended"]
    if peak > PEAK_MB and programs.SLOWNESS == 1:
        found.append(f"{peak:.0f} MB")
    for kind, statistics in latencies.items():
        if statistics["failures"]:
            found.append(f"{statistics['failures']} of {kind} failed ({statistics['error']})")
        if statistics["count"] == 0:
            found.append(f"no {kind}")
        if (statistics["p99_ms"] > P99_MS.get(kind, MAX_MS) * programs.SLOWNESS or
                statistics["max_ms"] > MAX_MS * programs.SLOWNESS):
            found.append(f"{kind} is late")
    connections, sent, ended, _ = totals
    if not connections or not sent and not attack.sockets > 1:
        found.append("the attack sent nothing")
    if attack.allowed and ended:
        found.append("the server closed an allowed connection")
    return found


def measure(name, measured, options, group):
    """Prints the line of one attack. Returns whether all bars were kept."""
    attack = ATTACKS[name]
    seconds = max(options.seconds, 6.5) if attack.allowed else options.seconds
    measured.start()
    steady = SteadyClient(options.steady_client, measured)
    web = WebClient(host_and_port(measured.server.web),
                    None if options.plain else context("http/1.1"), measured.reader_token,
                    "databases/motion", measured.motion)
    measured.forget_peak()
    addresses = {"listen": measured.server.address, "web": measured.server.web,
                 "http": measured.server.http}
    tls = None
    if not options.plain and attack.port != "http":
        tls = context("http/1.1" if attack.port == "web" else "h2")
    aim = Aim(host_and_port(addresses[attack.port]), tls, measured.token, "motion")
    attackers = Attackers(attack, aim, options.connections, seconds, ATTACKER_CORES, group)
    repeated = {"livez": Repeated(livez(host_and_port(measured.server.http))),
                "web": Repeated(web.recognize)}
    peak = watch(measured, seconds)
    totals = attackers.stop()
    latencies = steady.stop() | {kind: each.stop() for kind, each in repeated.items()}
    peak = max(peak, watch(measured, 5 if seconds >= 10 else 0.5))
    after, ran = measured.memory("VmRSS"), measured.runs()
    found = problems(attack, peak, totals, latencies, ran)
    if not measured.stop(kill=bool(found)) and not found:
        found = ["it did not exit with 0 on SIGTERM"]
    pairs = [f"{latencies[kind]['p99_ms']:.0f}/{latencies[kind]['max_ms']:.0f}"
             for kind in ("health", "recognize", "connect", "livez", "web")]
    print(ROW.format(name, totals[0], f"{totals[1] / MB:.1f}", totals[2], totals[3],
                     f"{peak:.0f}", f"{after:.0f}", *pairs,
                     sum(statistics["failures"] for statistics in latencies.values()),
                     "FAILED: " + "; ".join(found) if found else "ok"), flush=True)
    return not found


def parse_options():
    parser = argparse.ArgumentParser()
    parser.add_argument("steady_client")
    parser.add_argument("--plain", action="store_true", help="no TLS, no tokens")
    parser.add_argument("--tls", action="store_false", dest="plain", help="the default")
    parser.add_argument("--attack", action="append", choices=["all", *ATTACKS], metavar="NAME")
    parser.add_argument("--short", action="store_true", help="only the most important attacks, 2.5 s each")
    parser.add_argument("--seconds", type=float, help="duration of each attack; default 60")
    parser.add_argument("--connections", type=int, default=8, help="number of attackers")
    parser.add_argument("--memory-parent", metavar="FOLDER",
                        help="parent of the server's cgroup; default: the root, if this "
                             "process is in it")
    parser.add_argument("--server-options", type=shlex.split, default=[],
                        help="more options of motiondbd, as one argument")
    options = parser.parse_args(sys.argv[4:])
    short = 2.5 if programs.SLOWNESS == 1 else 1  # a sanitizer run looks for faults, not at the bars
    options.seconds = options.seconds or (short if options.short else 60)
    names = options.attack or (MOST_IMPORTANT if options.short else ["all"])
    options.names = list(ATTACKS) if "all" in names else names
    if options.plain:  # there is no handshake
        options.names = [name for name in options.names if name != "handshakes"]
    return options


@contextlib.contextmanager
def limit(make, *arguments, instead):
    """Yields a cgroup; yields None and prints the reason if it cannot be created."""
    group = None
    try:
        group = make(*arguments)
    except OSError as error:
        print(f"no cgroup: {error}; {instead}")
    try:
        yield group
    finally:
        if group:
            group.remove()


def server_group(options):
    if programs.SLOWNESS > 1:
        raise OSError("memory bars do not apply to sanitizers")
    return control_group.memory_group(SERVER_BYTES, options.memory_parent)


def run(options):
    with (tempfile.TemporaryDirectory() as folder,
          limit(control_group.processor_group, ATTACKER_CORES,
                instead="attackers limit their own processor time") as attackers_group,
          limit(server_group, options, instead="a release build is killed above 512 MiB") as group):
        measured = Measured(folder, options.plain, group, options.server_options)
        print(ROW.format("attack", "conns", "MB sent", "ended", "refused", "peak", "after",
                         "health", "recognize", "connect", "livez", "web", "fail",
                         "MB of memory; p99/max in ms"), flush=True)
        try:
            kept = [measure(name, measured, options, attackers_group) for name in options.names]
        except BaseException:
            measured.stop(kill=True)
            raise
    print(f"{sum(kept)} of {len(kept)} attacks kept every bar")
    return 0 if all(kept) else 1


if __name__ == "__main__":
    sys.exit(run(parse_options()))

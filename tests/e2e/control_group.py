"""CPU and memory limits for processes, with cgroups version 1 or 2."""

import os

ROOT = "/sys/fs/cgroup"


def _own_path(controller):
    """Returns mount, path in it and version of this process's cgroup with the controller; None if
    there is none."""
    with open("/proc/self/cgroup", encoding="ascii") as file:
        lines = [line.rstrip("\n").split(":", 2) for line in file]
    for number, controllers, path in lines:
        if controller in controllers.split(","):
            return f"{ROOT}/{controller}", path, 1
        if number == "0" and os.path.exists(f"{ROOT}/cgroup.controllers"):
            return ROOT, path, 2
    return None


class ControlGroup:
    """A cgroup below `parent`, or below the root if this process is in the root. A service or a
    container owns any other cgroup, so this process must not leave or split it. Raises OSError with
    the reason if the cgroup cannot be created."""

    def __init__(self, controller, limits, parent=None):
        own = _own_path(controller)
        if own is None:
            raise OSError(f"no cgroup has the controller {controller}")
        mount, path, version = own
        if parent is None and path != "/":
            raise OSError(f"this process is in the cgroup {path} of {mount}, which is not its own")
        self.folder = os.path.join(parent or mount, f"motiondb-test-{os.getpid()}")
        os.mkdir(self.folder)
        try:
            for file, value in limits[version]:
                self.write(file, value)
        except OSError:
            self.remove()
            raise

    def write(self, file, value):
        with open(os.path.join(self.folder, file), "w", encoding="ascii") as target:
            target.write(str(value))

    def join(self):
        self.write("cgroup.procs", os.getpid())

    def remove(self):
        os.rmdir(self.folder)


def processor_group(cores):
    period = 20_000  # microseconds: short, so that the share is even
    return ControlGroup("cpu", {
        1: [("cpu.cfs_period_us", period), ("cpu.cfs_quota_us", int(cores * period))],
        2: [("cpu.max", f"{int(cores * period)} {period}")]})


def memory_group(size, parent=None):
    return ControlGroup("memory", {
        1: [("memory.limit_in_bytes", size)],
        2: [("memory.max", size), ("memory.swap.max", 0)]}, parent)

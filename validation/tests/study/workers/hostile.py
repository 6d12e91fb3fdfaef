#!/usr/bin/env -S python3 -B
# Methods that reach for what an engine has no business with. What they got they tell as the reason of a refusal.
import errno
import mmap
import os
import select
import signal
import socket
import sys
import time

from speak import done, sample, say, serve, well


def tell(request, *words):
    say(done(request, "unsupported", " ".join(words)))


def tried(action):
    try:
        action()
        return "done"
    except OSError as error:
        return errno.errorcode.get(error.errno, "unknown")


def write(path):
    with open(path, "w") as file:
        file.write("written by the worker\n")


def writes_outside(request):
    """HOSTILE_TARGET: a folder with the file `kept`."""
    target = os.environ["HOSTILE_TARGET"]
    kept = os.path.join(target, "kept")
    write("moved")
    actions = {"new": lambda: write(os.path.join(target, "new")), "over": lambda: write(kept),
               "append": lambda: open(kept, "a").close(), "remove": lambda: os.remove(kept),
               "folder": lambda: os.mkdir(os.path.join(target, "folder")),
               "link": lambda: os.symlink("kept", os.path.join(target, "link")),
               "move": lambda: os.rename("moved", os.path.join(target, "moved")),
               "scratch": lambda: write(os.path.join(os.environ["TMPDIR"], "file")), "null": lambda: write("/dev/null")}
    os.makedirs("locked/inside", exist_ok=True)
    os.chmod("locked", 0)
    tell(request, *(name + ":" + tried(action) for name, action in actions.items()))


def changes_attributes(request):
    """HOSTILE_TARGET: a folder with the file `kept`."""
    target = os.environ["HOSTILE_TARGET"]
    kept = os.path.join(target, "kept")
    scratch = os.getcwd() == os.environ.get("TMPDIR")
    own = os.path.join(os.getcwd() if scratch else target, "own")
    write(own)
    actions = {"mode": lambda: os.chmod(kept, 0o640), "folder": lambda: os.chmod(target, 0o700), "times": lambda: os.utime(kept, (1, 1)),
               "attribute": lambda: os.setxattr(kept, "user.a", b"1"), "scratch": lambda: os.chmod(own, 0o600)}
    tell(request, *(name + ":" + tried(action) for name, action in actions.items()))


def connects(request):
    """HOSTILE_PORT: of a server on this machine."""
    port = int(os.environ["HOSTILE_PORT"])
    server = ("127.0.0.1", port)
    kinds = {"tcp": lambda: socket.create_connection(server, 1).close(),
             "udp": lambda: socket.socket(socket.AF_INET, socket.SOCK_DGRAM).sendto(b"hello", server),
             "abstract": lambda: socket.socket(socket.AF_UNIX).connect("\0atwood-test-%d" % port)}
    tell(request, *(name + ":" + tried(action) for name, action in kinds.items()))


def reads_home(request):
    home = os.environ["HOME"]
    same = home == os.environ.get("TMPDIR") == os.getcwd()
    tell(request, home, "same" if same else "different", *sorted(os.listdir(home)))


def signals_parent(request):
    tell(request, tried(lambda: os.kill(os.getppid(), signal.SIGURG)))


def drips(request):
    text = '{"cell":%d,"t_s":0,' % request["cell"]
    for k in range(10**6):
        sys.stdout.write(text[k] if k < len(text) else " ")
        sys.stdout.flush()
        time.sleep(0.01)


def ignores_signals(request):
    for each in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGPIPE, signal.SIGQUIT):
        signal.signal(each, signal.SIG_IGN)
    child = os.fork()
    if child == 0:
        os.setsid()  # its own session: not in the group that is killed
    else:
        say(sample(request, request["scene"]["bodies"], 0))
    while True:
        time.sleep(1)


def grow(to_mib, every_s=0.0):
    taken = []
    while len(taken) < to_mib:
        taken.append(b"x" * (1 << 20))
        time.sleep(every_s)
    return taken


def takes_memory(request):
    grow(1 << 20)


def takes_memory_in_children(request):
    """Each of them less than the limit of the test, in a session of its own."""
    for _ in range(6):
        if os.fork() == 0:
            os.setsid()
            kept = grow(60)
            time.sleep(1000)
            del kept
    time.sleep(1000)


def takes_memory_later(request):
    """After its answer, when nothing waits for it."""
    well(request)
    grow(1 << 20)


def shares_memory(request):
    """Children that change nothing of what the parent has."""
    kept = grow(80)
    children = []
    for _ in range(6):
        children.append(os.fork())
        if children[-1] == 0:
            time.sleep(1.5)
            os._exit(0)
    for child in children:
        os.waitpid(child, 0)
    del kept
    well(request)


def daemon(action):
    """In a session of its own, an orphan. Returns a pipe that ends with it."""
    ours, its = os.pipe()
    if os.fork() == 0:
        os.setsid()
        if os.fork() == 0:
            os.close(ours)
            os.set_inheritable(its, True)
            action()
        os._exit(0)
    os.close(its)
    os.wait()
    return ours


def leaves_a_daemon(request):
    """It sleeps without an environment."""
    end = daemon(lambda: os.execve("/bin/sleep", ["sleep", "1000"], {}))
    tell(request, "ended" if select.select([end], [], [], 20)[0] else "runs")


def leaves_a_named_daemon(request):
    """It sleeps with the worker's environment."""
    end = daemon(lambda: os.execv("/bin/sleep", ["sleep", "1000"]))
    tell(request, "ended" if select.select([end], [], [], 2)[0] else "runs")


def memory_file(mib):
    file = os.memfd_create("held")
    for _ in range(mib):
        os.write(file, b"x" * (1 << 20))
    return file


def holds_memory_files(request):
    """Pages that are in the size of no process."""
    kept = [memory_file(64) for _ in range(8)]
    time.sleep(1000)
    del kept


def maps_a_memory_file(request):
    """Its pages count once: as mapped and as held they would be more than the limit of the test."""
    file = memory_file(150)
    with mmap.mmap(file, 150 << 20) as pages:
        for at in range(0, 150 << 20, 4096):
            pages[at]
        time.sleep(1)
    well(request)


METHODS = [writes_outside, changes_attributes, connects, reads_home, signals_parent, drips, ignores_signals, takes_memory,
           takes_memory_in_children, takes_memory_later, shares_memory, leaves_a_daemon, leaves_a_named_daemon,
           holds_memory_files, maps_a_memory_file, well]
serve("hostile", [f.__name__ for f in METHODS], lambda request: globals()[request["method"].split("/")[1]](request))

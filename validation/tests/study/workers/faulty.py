#!/usr/bin/env -S python3 -B
# One method a fault; `faulty/well` in between shows that the worker is started again.
import math
import os
import signal
import sys
import time

from speak import done, sample, say, serve, well


def two_samples(request):
    for k in range(2):
        say(sample(request, request["scene"]["bodies"], k))


def dies(request):
    two_samples(request)
    sys.stderr.write("before the end: \x1b[31mred\x1b[0m \x07 words\n")
    sys.stderr.flush()
    os.kill(os.getpid(), 11)


def exits(request):
    two_samples(request)
    os._exit(3)


def hangs(request):
    two_samples(request)
    child = os.fork()  # of its own, which must go too
    if child and os.environ.get("CHILD_LOG"):
        with open(os.environ["CHILD_LOG"], "w") as log:
            log.write("%d\n" % child)
    time.sleep(1000)


def raw(text):
    sys.stdout.write(text)
    sys.stdout.flush()


def garbage(request):
    raw("Segmentation fault is what I would say if I could\n")


def half_a_line(request):
    raw('{"cell":%d,"t_s":0,"bod' % request["cell"])
    os._exit(0)


def endless_line(request):
    while True:
        raw("x" * (1 << 20))


def wrong_cell(request):
    say({**sample(request, request["scene"]["bodies"], 0), "cell": request["cell"] + 1})


def wrong_time(request):
    say({**sample(request, request["scene"]["bodies"], 0), "t_s": 0.5})


def too_many_samples(request):
    for k in range(request["samples"] + 1):
        say(sample(request, request["scene"]["bodies"], k))
    while True:
        say(sample(request, request["scene"]["bodies"], request["samples"]))


def too_few_samples(request):
    two_samples(request)
    say(done(request))


def body_missing(request):
    say({"cell": request["cell"], "t_s": 0, "bodies": []})


def nan_late(request):
    if request["pass"] == "timing":
        return well(request)
    for k in range(request["samples"] + 1):
        answer = sample(request, request["scene"]["bodies"], k)
        if k == request["samples"]:
            answer["bodies"][0][0] = "nan"
        say(answer)
    say(done(request))


def bare_nan(request):
    answer = sample(request, request["scene"]["bodies"], 0)
    answer["bodies"][0][0] = math.nan  # Python writes NaN, which is not JSON
    say(answer)


def chatter(request):
    for _ in range(4096):
        sys.stderr.write("chatter " * 32 + "\n")
    sys.stderr.flush()
    well(request)


def chatter_then_exit(request):
    for i in range(4096):
        sys.stderr.write("chatter %d %s\n" % (i, "." * 100))
    sys.stderr.write("the last words\n")
    sys.stderr.flush()
    os._exit(4)


def not_utf8(request):
    sys.stderr.buffer.write(b"caf\xe9\n")
    sys.stderr.flush()
    os._exit(5)


def refuses(request):
    say(done(request, "unsupported", "faulty has no springs"))


def timed(request, busy_ns, wait_s=0):
    time.sleep(wait_s)
    return say(done(request, busy_ns=busy_ns)) if request["pass"] == "timing" else well(request)


def busy_negative(request):
    timed(request, [-5] * request["repeats"])


def busy_zero(request):
    timed(request, [1000] * (request["repeats"] - 1) + [0])


def busy_missing(request):
    timed(request, [1000] * (request["repeats"] - 1))


def busy_too_long(request):
    timed(request, [10**10] * request["repeats"])


def busy_seconds(request):
    timed(request, [0.25] * request["repeats"])


def busy_milliseconds(request):
    timed(request, [100] * request["repeats"], 0.1 * request["repeats"])


def steps_negative(request):
    say({"cell": request["cell"], "done": {"status": "diverged", "reason": "", "steps_taken": -3}})


def altered(request, change, first=0):
    for k in range(request["samples"] + 1):
        answer = sample(request, request["scene"]["bodies"], k)
        if k >= first:
            change(answer)
        say(answer)
    say(done(request))


def norm_two(request):
    altered(request, lambda a: a["bodies"][0].__setitem__(slice(3, 7), [2, 0, 0, 0]))


def norm_two_later(request):
    altered(request, lambda a: a["bodies"][0].__setitem__(slice(3, 7), [2, 0, 0, 0]), 3)


def other_scene(request):
    altered(request, lambda a: a["bodies"][0].__setitem__(0, a["bodies"][0][0] + 1))


def other_velocity(request):
    altered(request, lambda a: a["bodies"][0].__setitem__(8, 0))


def nan_at_once(request):
    altered(request, lambda a: a["bodies"][0].__setitem__(slice(0, 13), ["nan"] * 13))


def times(request, of):
    altered(request, lambda a: a.__setitem__("t_s", of(a["t_s"])))


def milliseconds(request):
    times(request, lambda t: 1e3 * t)


def sample_indices(request):
    times(request, lambda t: round(t * request["samples"] / request["t_end_s"]))


def deep(request):
    raw('{"cell":%d,"t_s":0,"bodies":%s%s}\n' % (request["cell"], "[" * 100000, "]" * 100000))


def many_bodies(request):  # a line of 60 MB
    raw('{"cell":%d,"t_s":0,"bodies":[%s[]]}\n' % (request["cell"], "[0,0,0,1,0,0,0,0,0,0,0,0,0]," * 2200000))


def many_unknown(request):
    raw('{"cell":%d,"x":[%s0],"t_s":0,"bodies":[]}\n' % (request["cell"], "[]," * 20000000))


def early(request):
    well(request)
    say({**sample(request, request["scene"]["bodies"], 0), "cell": request["cell"] + 1})
    if os.environ.get("EARLY_LOG"):
        open(os.environ["EARLY_LOG"], "w").close()


def late(request):  # what it says comes after the next request
    well(request)
    sys.stdin.readline()
    say({**sample(request, request["scene"]["bodies"], 0), "cell": request["cell"]})


def dies_later(request):
    well(request)
    os.kill(os.getpid(), signal.SIGSEGV)


def in_parts(request):
    if request["pass"] == "timing":
        return well(request)
    for k in range(request["samples"] + 1):
        answer = sample(request, request["scene"]["bodies"], k)
        say({**answer, "bodies": [], "more": True})
        say({"cell": request["cell"], "events": [], "more": True})
        say(answer)
    say(done(request))


def part_missing(request):
    answer = sample(request, request["scene"]["bodies"], 0)
    say({**answer, "from": 1})


def part_unfinished(request):
    say({**sample(request, request["scene"]["bodies"], 0), "more": True})
    say(done(request))


def leaves_children(request):
    """Children in its group, in a group of their own, and one that made itself independent."""
    for escape in (lambda: None, lambda: os.setpgid(0, 0), os.setsid):
        child = os.fork()
        if child == 0:
            escape()
            if escape is os.setsid and os.fork():
                os._exit(0)
            with open(os.environ["CHILD_LOG"], "a") as log:
                log.write("%d %s\n" % (os.getpid(), ",".join(sorted(os.listdir("/proc/self/fd")))))
            for descriptor in range(3):
                os.close(descriptor)
            time.sleep(1000)
    def told():
        return open(os.environ["CHILD_LOG"]).read().count("\n") if os.path.exists(os.environ["CHILD_LOG"]) else 0
    while told() < 3:
        time.sleep(0.01)
    well(request)


FAULTS = [busy_negative, busy_zero, busy_missing, busy_too_long, busy_seconds, busy_milliseconds, steps_negative, norm_two,
          norm_two_later, other_scene, other_velocity, nan_at_once, milliseconds, sample_indices, deep, many_bodies,
          many_unknown, early, late, dies_later, in_parts, part_missing, part_unfinished, leaves_children]
FAULTS += [dies, exits, hangs, garbage, half_a_line, endless_line, wrong_cell, wrong_time, too_many_samples,
           too_few_samples, body_missing, nan_late, bare_nan, chatter, chatter_then_exit, not_utf8, refuses, well]
serve("faulty", [f.__name__ for f in FAULTS], lambda request: globals()[request["method"].split("/")[1]](request))

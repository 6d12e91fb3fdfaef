#!/usr/bin/env -S python3 -B
# One method a fault; `faulty/well` in between shows that the worker is started again.
import math
import os
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


FAULTS = [dies, exits, hangs, garbage, half_a_line, endless_line, wrong_cell, wrong_time, too_many_samples,
          too_few_samples, body_missing, nan_late, bare_nan, chatter, chatter_then_exit, not_utf8, refuses, well]
serve("faulty", [f.__name__ for f in FAULTS], lambda request: globals()[request["method"].split("/")[1]](request))

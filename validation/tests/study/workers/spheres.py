#!/usr/bin/env -S python3 -B
# Contacts of two spheres, in double; it generates no poses of a sweep.
import math

from speak import done, say, serve


def answer(request):
    if request["request"] != "contacts":
        return say(done(request, "unsupported", "spheres answers contacts"))
    one, other = request["scene"]["bodies"]
    if not all("sphere" in body["shape"] for body in (one, other)):
        return say(done(request, "unsupported", "spheres has no other shape"))
    apart = [b - a for a, b in zip(one["position_m"], other["position_m"])]
    distance = math.hypot(*apart)
    radii = [body["shape"]["sphere"]["radius_m"] for body in (one, other)]
    depth = sum(radii) - distance
    normal = [x / distance for x in apart]
    at = [p + (radii[0] - depth / 2) * n for p, n in zip(one["position_m"], normal)]
    say({"cell": request["cell"], "contacts": [[0, 1, *at, *normal, depth]] if depth >= 0 else []})
    say(done(request))


serve("spheres", ["straight"], answer)

"""One run of a PySPH scheme on a fluid: arrays, solver, steps, what is observed."""
import contextlib
import fcntl
import glob
import os
import time

import numpy
from compyle.config import get_config
from pysph.base import kernels
from pysph.base.nnps import DomainManager, LinkedListNNPS
from pysph.base.utils import get_particle_array
from pysph.sph import integrator as integrators

import schemes
from outcome import Ended, Refusal
from scene import density_behind, wall_points

FASTEST = 20  # a particle that moves faster than this many times the sound speed: the run has diverged


def set_property(array, name, value):
    if name in array.properties:
        array.get(name)[:] = value


def particle_array(name, x, u, mass, h):
    return get_particle_array(name=name, x=x[:, 0], y=x[:, 1], z=x[:, 2], u=u[:, 0], v=u[:, 1], w=u[:, 2], m=mass,
                              h=numpy.full(len(x), h))


def initial_state(array, rho, pressure, fluid):
    """What a scheme's properties begin with, where it has them."""
    set_property(array, "rho", rho)
    set_property(array, "p", pressure)
    set_property(array, "cs", fluid.c)
    set_property(array, "V", fluid.rho0 / array.m)  # the inverse of the volume
    set_property(array, "gid", numpy.arange(len(rho)))
    for hat, own in (("uhat", "u"), ("vhat", "v"), ("what", "w")):
        set_property(array, hat, array.get(own))


def arrays_of(fluid, scheme, h, reach):
    """PySPH's arrays: `fluid`, then one of each kind of wall that the scene has."""
    walls = wall_points(fluid, reach)
    parts = [particle_array("fluid", fluid.x, fluid.u, numpy.array(fluid.mass), h)]
    points_of = {}
    for name in fluid.solids:
        points_of[name] = numpy.vstack([points for boundary, points in walls if boundary.array == name])
        velocities = [numpy.tile(boundary.velocity, (len(points), 1)) for boundary, points in walls if boundary.array == name]
        mass = numpy.full(len(points_of[name]), fluid.rho0 * fluid.spacing**fluid.dimensions)
        parts.append(particle_array(name, points_of[name], numpy.vstack(velocities), mass, h))
    scheme.setup_properties(parts)
    initial_state(parts[0], fluid.rho, fluid.pressure(fluid.rho), fluid)
    for array in parts[1:]:
        rho = density_behind(fluid, points_of[array.name])
        initial_state(array, rho, fluid.pressure(rho), fluid)
    return parts


# The equations that let a wall hold the fluid back along itself; a free-slip wall is not among their sources.
FRICTION = {"SolidWallNoSlipBC", "LaminarViscosity", "LaminarViscosityDeltaSPH", "MomentumEquationViscosity"}


def without_friction(groups, free):
    """The groups of equations, in place, without friction at the arrays named."""
    for group in groups:
        if isinstance(group, list):
            without_friction(group, free)
            continue
        for equation in list(group.equations):
            if type(equation).__name__ not in FRICTION or not set(equation.sources or ()) & set(free):
                continue
            equation.sources = [source for source in equation.sources if source not in free]
            if not equation.sources:
                group.equations.remove(equation)


class Run:
    def __init__(self, fluid, kind, settings, t_end_s, steps):
        get_config().use_openmp = False
        self.fluid, self.kind, self.t_end_s, self.steps = fluid, kind, t_end_s, steps
        kernel = getattr(kernels, schemes.KERNELS[settings["kernel"]])(dim=fluid.dimensions)
        h = settings["hdx"] * fluid.spacing
        reach = kernel.radius_scale * h
        narrow = [axis for axis in range(3) if 0 < fluid.period[axis] < 2 * reach]
        if narrow:
            raise Refusal(f"the kernel reaches {reach:.3g} m, more than half of the period of {fluid.period[narrow[0]]:.3g} m")
        scheme = kind.make(settings, fluid, h)
        chosen = settings.get("integrator")
        more = {"integrator_cls": getattr(integrators, schemes.INTEGRATORS[chosen])} if chosen else {}
        scheme.configure_solver(kernel=kernel, dt=t_end_s / steps, tf=2 * t_end_s, **more)  # ended by the number of steps
        self.solver = solver = scheme.get_solver()
        solver.set_max_steps(steps)
        solver.set_disable_output(True)
        solver.set_parallel_manager(None)
        arrays = arrays_of(fluid, scheme, h, reach)
        equations = scheme.get_equations()
        without_friction(getattr(equations, "groups", equations), [name for name in fluid.solids if name == "free_slip"])
        nnps = LinkedListNNPS(dim=fluid.dimensions, particles=arrays, radius_scale=kernel.radius_scale, domain=domain(fluid))
        with use_of_cache():
            solver.setup(particles=arrays, equations=equations, nnps=nnps, kernel=kernel)
        self.array = arrays[0]
        self.turns = numpy.zeros((len(fluid.x), 3))  # through the periods
        self.wrapped = fluid.x
        self.evaluations = 1 + steps * kind.evaluations[chosen or ""]

    def state(self):
        """x, u, density, pressure of the fluid's particles in the scene's order; x within the periods."""
        array = self.array
        order = numpy.argsort(array.get("gid"))
        x, u = (numpy.stack([array.get(name) for name in names], axis=1)[order] for names in ("xyz", "uvw"))
        rho, p = array.get("rho")[order], array.get("p")[order]
        return x, u, rho, self.fluid.pressure(rho) if self.kind.continuity else p

    def check(self, x, u, t_s):
        if not numpy.isfinite(x.sum() + u.sum()):
            bad = int(numpy.argmin(numpy.isfinite(x.sum(axis=1) + u.sum(axis=1))))
            raise Ended("not finite", f"particle {bad} of the fluid `{self.fluid.name}` at t = {t_s:.6g} s")
        speed = numpy.sqrt((u**2).sum(axis=1))
        if speed.max() > FASTEST * self.fluid.c:
            raise Ended("diverged", f"particle {int(speed.argmax())} of the fluid `{self.fluid.name}` moves at {speed.max():.3g} "
                        f"m/s at t = {t_s:.6g} s, more than {FASTEST} times the sound speed")

    def unwrapped(self, x):
        period = self.fluid.period
        self.turns += numpy.where(period > 0, numpy.round((self.wrapped - x) / numpy.where(period > 0, period, 1)), 0)
        self.wrapped = x
        return x + self.turns * period

    def observe(self, samples, put):
        """Solves, and calls put(k, x, u, rho, p) with every sample."""
        fluid, stride = self.fluid, self.steps // samples
        put(0, fluid.x, fluid.u, fluid.rho, fluid.pressure(fluid.rho))

        def after_step(solver):
            x, u, rho, p = self.state()
            n = solver.count + 1
            self.check(x, u, self.t_end_s * n / self.steps)
            x = self.unwrapped(x)
            if n % stride == 0:
                put(n // stride, x, u, rho, p)

        self.solver.add_post_step_callback(after_step)
        self.solver.solve(show_progress=False)

    def busy_ns(self):
        """Nanoseconds of the solve, with nothing observed."""
        start = time.perf_counter_ns()
        self.solver.solve(show_progress=False)
        busy = time.perf_counter_ns() - start
        x, u, _, _ = self.state()
        self.check(x, u, self.t_end_s)
        return busy


@contextlib.contextmanager
def use_of_cache():
    """Processes compile beside each other. One that was killed has left its locks, and PySPH would wait for them: they are
    removed by a process that finds itself alone."""
    root = os.path.join(os.path.expanduser("~"), ".pysph")
    os.makedirs(root, exist_ok=True)
    with open(os.path.join(root, "atwood.lock"), "w") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            for stale in glob.glob(os.path.join(root, "source", "*", "*.lock")):
                os.rmdir(stale)
        except BlockingIOError:
            pass
        fcntl.flock(lock, fcntl.LOCK_SH)
        yield


def domain(fluid):
    if not fluid.period.any():
        return None
    ends = {}
    for name, period in zip("xyz", fluid.period):
        if period > 0:
            ends.update({f"{name}min": 0.0, f"{name}max": float(period), f"periodic_in_{name}": True})
    return DomainManager(**ends)

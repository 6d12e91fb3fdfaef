#include "scene/fluid_points.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <unordered_map>

#include "scene/files.hpp"
#include "scene/fluid_fields.hpp"
#include "scene/fluid_walls.hpp"
#include "scene/split_mix.hpp"
#include "scene/value.hpp"

namespace atwood {
namespace {

constexpr double kFillTolerance = 1e-9;

std::string in_words(double x) { return describe(Value(x)); }

// Why a length is not a whole number of spacings; empty: it is.
std::string remainder_words(double length_m, double spacing_m, const std::string& what) {
  const double count = length_m / spacing_m;
  if (count > 1e9) return what + " is more than 10^9 spacings of " + in_words(spacing_m) + " m";
  const double nearest = std::max(1.0, std::round(count));
  if (std::abs(count - nearest) <= kFillTolerance * nearest) return "";
  char in_spacings[32];
  std::snprintf(in_spacings, sizeof in_spacings, "%.6g", count);
  return what + " is " + in_spacings + " spacings of " + in_words(spacing_m) + " m";
}

double volume_m(const FluidRegion& region, int dimensions) {
  if (const auto* ball = std::get_if<BallRegion>(&region)) {
    const double r = ball->radius_m;
    return dimensions == 2 ? std::numbers::pi * r * r : 4 * std::numbers::pi / 3 * r * r * r;
  }
  if (const auto* e = std::get_if<EllipsoidRegion>(&region)) {
    const Real3& a = e->semi_axes_m;
    return dimensions == 2 ? std::numbers::pi * a[0] * a[1] : 4 * std::numbers::pi / 3 * a[0] * a[1] * a[2];
  }
  return 0;
}

void refuse_count(const Fluid& fluid, double count) {
  if (count > static_cast<double>(kMaxParticles))
    throw InputError("the fluid `" + fluid.name + "` has " + in_words(count) + " particles at a spacing of " +
                     in_words(fluid.spacing_m) + " m; expected at most " + std::to_string(kMaxParticles));
}

// ---- lattices and rings ------------------------------------------------------------------------------------------
struct Axis {
  double first_m = 0, pitch_m = 0;
  std::int64_t count = 1;
};

std::vector<Real3> lattice(const std::array<Axis, 3>& axes) {
  std::vector<Real3> points;
  for (std::int64_t i = 0; i < axes[0].count; ++i)
    for (std::int64_t j = 0; j < axes[1].count; ++j)
      for (std::int64_t k = 0; k < axes[2].count; ++k) {
        const std::array<std::int64_t, 3> at{i, j, k};
        Real3& x = points.emplace_back();
        for (std::size_t axis = 0; axis < 3; ++axis)
          x[axis] = axes[axis].first_m + (static_cast<double>(at[axis]) + 0.5) * axes[axis].pitch_m;
      }
  return points;
}

std::array<Axis, 3> axes_between(const Fluid& fluid, const RegionBounds& bounds, int dimensions, bool centred) {
  std::array<Axis, 3> axes;
  const auto cells_along = [&](std::size_t i) {
    const double length = bounds.max_m[i] - bounds.min_m[i];
    return centred ? 2 * std::ceil(length / 2 / fluid.spacing_m) : std::round(length / fluid.spacing_m);
  };
  double count = 1;
  for (std::size_t i = 0; i < static_cast<std::size_t>(dimensions); ++i) count *= cells_along(i);
  refuse_count(fluid, count);
  for (std::size_t i = 0; i < static_cast<std::size_t>(dimensions); ++i) {
    const double length = bounds.max_m[i] - bounds.min_m[i], cells = cells_along(i);
    axes[i].count = static_cast<std::int64_t>(cells);
    axes[i].pitch_m = centred ? fluid.spacing_m : length / cells;
    axes[i].first_m = centred ? (bounds.min_m[i] + bounds.max_m[i]) / 2 - cells / 2 * fluid.spacing_m : bounds.min_m[i];
  }
  return axes;
}

bool inside_round(const FluidRegion& region, const Real3& x, int dimensions) {
  Real3 center{}, axes{1, 1, 1};
  if (const auto* ball = std::get_if<BallRegion>(&region))
    center = ball->center_m, axes = {ball->radius_m, ball->radius_m, ball->radius_m};
  if (const auto* e = std::get_if<EllipsoidRegion>(&region)) center = e->center_m, axes = e->semi_axes_m;
  double sum = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(dimensions); ++i)
    sum += (x[i] - center[i]) * (x[i] - center[i]) / (axes[i] * axes[i]);
  return sum <= 1;
}

std::vector<Real3> rings(const Fluid& fluid) {
  Real3 center{}, axes{};
  if (const auto* ball = std::get_if<BallRegion>(&fluid.region))
    center = ball->center_m, axes = {ball->radius_m, ball->radius_m, 0};
  if (const auto* e = std::get_if<EllipsoidRegion>(&fluid.region)) center = e->center_m, axes = e->semi_axes_m;
  const double count = std::round(std::sqrt(axes[0] * axes[1]) / fluid.spacing_m);
  refuse_count(fluid, 3 * count * count);
  std::vector<Real3> points;
  for (std::int64_t k = 1; k <= static_cast<std::int64_t>(count); ++k) {
    const double radius = (static_cast<double>(k) - 0.5) / count;  // of the circle of radius 1
    const std::int64_t members = 6 * k - 3;
    for (std::int64_t j = 0; j < members; ++j) {
      const double angle = 2 * std::numbers::pi * (static_cast<double>(j) + 0.5 * static_cast<double>(k % 2)) /
                           static_cast<double>(members);
      points.push_back(
          {center[0] + axes[0] * radius * std::cos(angle), center[1] + axes[1] * radius * std::sin(angle), 0});
    }
  }
  return points;
}

std::vector<Real3> positions_of(const Fluid& fluid, const Domain& domain) {
  const int dimensions = domain.dimensions;
  if (std::holds_alternative<PointsRegion>(fluid.region)) {
    std::vector<Real3> sorted = fluid.particles.position_m;
    for (Real3& x : sorted)  // places that are whole periods apart are the same
      for (std::size_t a = 0; a < 3; ++a)
        if (const double period = domain.periodic_m[a]; period > 0) x[a] -= period * std::floor(x[a] / period);
    std::sort(sorted.begin(), sorted.end());
    if (const auto twice = std::adjacent_find(sorted.begin(), sorted.end()); twice != sorted.end())
      throw InputError("two points of the fluid `" + fluid.name + "` are at the same place, " + in_words((*twice)[0]) +
                       ", " + in_words((*twice)[1]) + ", " + in_words((*twice)[2]) + " m; expected different places");
    return fluid.particles.position_m;
  }
  const std::string gap = unfilled(fluid, dimensions, fluid.spacing_m);
  if (!gap.empty()) throw InputError("the spacing does not fill the region of the fluid `" + fluid.name + "`: " + gap);
  std::vector<Real3> points;
  if (fluid.arrangement == Arrangement::rings) {
    points = rings(fluid);
  } else {
    const bool box = std::holds_alternative<BoxRegion>(fluid.region);
    points = lattice(axes_between(fluid, bounds_of(fluid), dimensions, !box));
    if (!box) std::erase_if(points, [&](const Real3& x) { return !inside_round(fluid.region, x, dimensions); });
  }
  return points;
}

// ---- boundaries --------------------------------------------------------------------------------------------------
// Removes the points that lie in a body, which displaces the fluid. A point behind a plane is an error of the scene.
void displace(const Scene& scene, const Fluid& fluid, std::vector<Real3>& points) {
  for (const FluidBoundary& boundary : scene.fluid_boundaries) {
    const Body& body = scene.bodies[static_cast<std::size_t>(boundary.body)];
    const auto within = [&](const Real3& x) { return distance_outside_m(body, x) <= 0; };
    if (!std::holds_alternative<Plane>(body.shape)) {
      std::erase_if(points, within);
      continue;
    }
    if (const auto found = std::find_if(points.begin(), points.end(), within); found != points.end())
      throw InputError("the fluid `" + fluid.name + "` has a particle at [" + in_words((*found)[0]) + ", " +
                       in_words((*found)[1]) + ", " + in_words((*found)[2]) +
                       "] m, behind the plane of the boundary `" + body.name +
                       "`; expected it on the side of the normal");
  }
}

// ---- particles of two fluids ----------------------------------------------------------------------------------------
struct CellKey {
  std::array<std::int64_t, 3> at{};
  bool operator==(const CellKey&) const = default;
};
struct CellHash {
  std::size_t operator()(const CellKey& key) const {
    std::uint64_t h = 0;
    for (const std::int64_t i : key.at) h = (h ^ static_cast<std::uint64_t>(i)) * 0x9e3779b97f4a7c15u;
    return static_cast<std::size_t>(h ^ (h >> 29));
  }
};

// Cells of the distance: particles of the first fluid nearer to one of the second than it.
void refuse_overlap(const Scene& scene, const Fluid& a, const Fluid& b) {
  const double near = 0.5 * std::min(a.spacing_m, b.spacing_m);
  const auto& period = scene.domain.periodic_m;
  // Cells of at least `near`, a whole number of them in each period.
  std::array<std::int64_t, 3> cells{};
  Real3 size{near, near, near};
  for (std::size_t i = 0; i < 3; ++i) {
    if (!(period[i] > 0)) continue;
    cells[i] = std::max<std::int64_t>(1, static_cast<std::int64_t>(std::floor(period[i] / near)));
    size[i] = period[i] / static_cast<double>(cells[i]);
  }
  const auto cell_of = [&](const Real3& x) {
    CellKey key;
    for (std::size_t i = 0; i < 3; ++i) {
      key.at[i] = static_cast<std::int64_t>(std::floor(x[i] / size[i]));
      if (cells[i] > 0) key.at[i] = ((key.at[i] % cells[i]) + cells[i]) % cells[i];
    }
    return key;
  };
  std::unordered_map<CellKey, std::vector<std::size_t>, CellHash> grid;
  for (std::size_t n = 0; n < a.particles.position_m.size(); ++n) grid[cell_of(a.particles.position_m[n])].push_back(n);
  for (const Real3& x : b.particles.position_m) {
    const CellKey middle = cell_of(x);
    for (int code = 0; code < 27; ++code) {
      CellKey key = middle;
      const std::array<int, 3> step{code / 9 - 1, code / 3 % 3 - 1, code % 3 - 1};
      for (std::size_t i = 0; i < 3; ++i) {
        key.at[i] += step[i];
        if (cells[i] > 0) key.at[i] = (key.at[i] + cells[i]) % cells[i];
      }
      const auto found = grid.find(key);
      if (found == grid.end()) continue;
      for (const std::size_t n : found->second) {
        double sum = 0;
        for (std::size_t i = 0; i < 3; ++i) {
          double d = x[i] - a.particles.position_m[n][i];
          if (period[i] > 0) d -= period[i] * std::round(d / period[i]);
          sum += d * d;
        }
        if (std::sqrt(sum) < near)
          throw InputError("the fluids `" + a.name + "` and `" + b.name + "` overlap: two particles are " +
                           in_words(std::sqrt(sum)) + " m apart at [" + in_words(x[0]) + ", " + in_words(x[1]) + ", " +
                           in_words(x[2]) + "] m; expected at least half a spacing, " + in_words(near) + " m");
      }
    }
  }
}

}  // namespace

std::string unfilled(const Fluid& fluid, int dimensions, double spacing_m) {
  if (const auto* box = std::get_if<BoxRegion>(&fluid.region)) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(dimensions); ++i) {
      const double length = box->max_m[i] - box->min_m[i];
      const std::string gap =
          remainder_words(length, spacing_m, in_words(length) + " m along " + std::string(1, "xyz"[i]));
      if (!gap.empty()) return gap;
    }
    return "";
  }
  if (fluid.arrangement != Arrangement::rings) return "";
  if (const auto* ball = std::get_if<BallRegion>(&fluid.region))
    return remainder_words(ball->radius_m, spacing_m, "the radius of " + in_words(ball->radius_m) + " m");
  if (const auto* e = std::get_if<EllipsoidRegion>(&fluid.region)) {
    const double radius = std::sqrt(e->semi_axes_m[0] * e->semi_axes_m[1]);
    return remainder_words(radius, spacing_m, "the mean radius sqrt(a b) of " + in_words(radius) + " m");
  }
  return "";
}

// A boundary is filled with what stands for the wall, to the depth that a kernel reaches: a plane is infinitely deep, a
// solid as deep as it is thick. A solid thinner than two spacings, and a rectangle, let particles act through.
std::string leaking(const Scene& scene, std::size_t boundary) {
  constexpr double min_spacings = 2;
  const Body& body = scene.bodies[static_cast<std::size_t>(scene.fluid_boundaries[boundary].body)];
  double coarsest = 0;
  for (const Fluid& fluid : scene.fluids) coarsest = std::max(coarsest, fluid.spacing_m);
  const double thickness = thickness_m(body, scene.domain.dimensions), least = min_spacings * coarsest;
  if (thickness >= least * (1 - 1e-12)) return "";
  return "the boundary `" + body.name + "` is " + in_words(thickness) + " m thick and leaks at a spacing of " +
         in_words(coarsest) + " m; expected at least two spacings, " + in_words(least) + " m, or a plane";
}

double thickness_m(const Body& body, int dimensions) {
  constexpr double unbounded = std::numeric_limits<double>::infinity();
  if (std::holds_alternative<Rectangle>(body.shape)) return 0;
  if (const auto* sphere = std::get_if<Sphere>(&body.shape)) return 2 * sphere->radius_m;
  if (const auto* capsule = std::get_if<Capsule>(&body.shape)) return 2 * capsule->radius_m;
  if (const auto* cylinder = std::get_if<Cylinder>(&body.shape))
    return 2 * (dimensions == 2 ? cylinder->radius_m : std::min(cylinder->radius_m, cylinder->half_length_m));
  if (const auto* box = std::get_if<Box>(&body.shape)) {
    const Real3& a = box->half_extents_m;
    return 2 * (dimensions == 2 ? std::min(a[0], a[1]) : std::min({a[0], a[1], a[2]}));
  }
  return unbounded;
}

double distance_outside_m(const Body& body, const Real3& x) {
  if (const auto* plane = std::get_if<Plane>(&body.shape))
    return plane->normal[0] * x[0] + plane->normal[1] * x[1] + plane->normal[2] * x[2] - plane->offset_m;
  const Real3 p = to_body(body, x);
  if (const auto* sphere = std::get_if<Sphere>(&body.shape)) return std::hypot(p[0], p[1], p[2]) - sphere->radius_m;
  if (const auto* capsule = std::get_if<Capsule>(&body.shape))
    return std::hypot(p[0], p[1], std::max(0.0, std::abs(p[2]) - capsule->half_length_m)) - capsule->radius_m;
  const auto of_gaps = [](double a, double b, double c) {
    return std::hypot(std::max(a, 0.0), std::max(b, 0.0), std::max(c, 0.0)) + std::min(std::max({a, b, c}), 0.0);
  };
  if (const auto* cylinder = std::get_if<Cylinder>(&body.shape)) {
    const double side = std::hypot(p[0], p[1]) - cylinder->radius_m;
    return of_gaps(side, std::abs(p[2]) - cylinder->half_length_m, -std::numeric_limits<double>::infinity());
  }
  if (const auto* box = std::get_if<Box>(&body.shape)) {
    const Real3& a = box->half_extents_m;
    return of_gaps(std::abs(p[0]) - a[0], std::abs(p[1]) - a[1], std::abs(p[2]) - a[2]);
  }
  return std::numeric_limits<double>::infinity();
}

void place_particles(Scene& scene) {
  const int dimensions = scene.domain.dimensions;
  std::size_t total = 0;
  for (Fluid& fluid : scene.fluids) {
    std::vector<Real3> points = positions_of(fluid, scene.domain);
    const bool round =
        std::holds_alternative<BallRegion>(fluid.region) || std::holds_alternative<EllipsoidRegion>(fluid.region);
    const double volume =
        round ? volume_m(fluid.region, dimensions) / static_cast<double>(std::max<std::size_t>(1, points.size()))
              : std::pow(fluid.spacing_m, dimensions);
    displace(scene, fluid, points);
    if (points.empty())
      throw InputError("the fluid `" + fluid.name + "` has no particle at a spacing of " + in_words(fluid.spacing_m) +
                       " m; expected a finer spacing");
    total += points.size();
    refuse_count(fluid, static_cast<double>(total));
    if (fluid.arrangement == Arrangement::disturbed) {
      SplitMix64 random{static_cast<std::uint64_t>(fluid.seed)};
      for (Real3& x : points)
        for (std::size_t i = 0; i < static_cast<std::size_t>(dimensions); ++i)
          x[i] += fluid.disturbance * fluid.spacing_m * random.next_unit();
    }
    Particles particles;
    for (const Real3& x : points) {
      const FluidState state = initial_state(scene, fluid, x);
      const double density = state.density_kg_per_m3;
      if (!(density > 0) || !std::isfinite(density))
        throw InputError("the initial density of the fluid `" + fluid.name + "` is " + in_words(density) + " at [" +
                         in_words(x[0]) + ", " + in_words(x[1]) + ", " + in_words(x[2]) +
                         "] m; expected a positive one: a larger sound speed");
      particles.velocity_m_per_s.push_back(state.velocity_m_per_s);
      particles.density_kg_per_m3.push_back(density);
      particles.mass_kg.push_back(density * volume);
      particles.temperature_K.push_back(state.temperature_K);
    }
    particles.position_m = std::move(points);
    fluid.particles = std::move(particles);
  }
  for (std::size_t a = 0; a < scene.fluids.size(); ++a)
    for (std::size_t b = a + 1; b < scene.fluids.size(); ++b) refuse_overlap(scene, scene.fluids[a], scene.fluids[b]);
}

Scene at_resolution(const Scenario& scenario, double spacing_m, double sound_speed_m_per_s) {
  Scene scene = scenario.scene;
  for (Fluid& fluid : scene.fluids) {
    if (spacing_m > 0) fluid.spacing_m = spacing_m;
    if (sound_speed_m_per_s > 0) fluid.sound_speed_m_per_s = sound_speed_m_per_s;
  }
  for (std::size_t i = 0; i < scene.fluid_boundaries.size(); ++i)
    if (const std::string leak = leaking(scene, i); !leak.empty()) throw InputError(leak);
  place_particles(scene);
  if (const auto beyond = too_many_wall_points(scene, kCountedSpacings * scene.fluids.front().spacing_m))
    throw InputError(beyond->words);
  return scene;
}

}  // namespace atwood

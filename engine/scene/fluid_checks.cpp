// From [domain], [[fluid]], [[fluid_boundary]], [[probe]] to fluids with particles, and the checks that span keys.
#include <algorithm>
#include <charconv>
#include <cmath>

#include "scene/csv.hpp"
#include "scene/fluid_fields.hpp"
#include "scene/fluid_keys.hpp"
#include "scene/fluid_points.hpp"
#include "scene/fluid_walls.hpp"
#include "scene/input_file.hpp"

namespace atwood {
namespace {

std::string number_words(double x) { return describe(Value(x)); }

SourceLocation location_of(const Value& table, const char* key) {
  const Value* found = table.find(key);
  return found ? found->location : table.location;
}

// ---- parameters of fields ----------------------------------------------------------------------------------------
void check_field(Reading& r, const Value& table, const char* key, const Fluid& fluid, InitialField& field) {
  if (field.name.empty()) return;
  const FieldInfo& info = *find_field(field.name);
  const SourceLocation location = location_of(table, key);
  const std::string whose = "of the field `" + field.name + "` in " + r.where;
  if (info.needs_heat && !(fluid.heat_capacity_J_per_kg_K > 0))
    fail(r, location,
         "the field `" + field.name + "` in " + r.where +
             " is a temperature; expected `heat_capacity_J_per_kg_K` above 0 beside it");
  if (field.name == "elliptic-drop" && !std::holds_alternative<BallRegion>(fluid.region))
    fail(r, location, "the field `elliptic-drop` in " + r.where + " starts as a circle; expected `region.circle`");
  if (field.name == "square-patch" && !std::holds_alternative<BoxRegion>(fluid.region))
    fail(r, location, "the field `square-patch` in " + r.where + " is a square's; expected `region.box`");
  if ((field.name == "mms-3d") != (r.scene->domain.dimensions == 3) && field.name.starts_with("mms-"))
    fail(r, location,
         "the field `" + field.name + "` in " + r.where + " has " + (field.name == "mms-3d" ? "three" : "two") +
             " dimensions; the domain has " + std::to_string(r.scene->domain.dimensions) + "; expected the same");
  for (const FieldParameter& parameter : info.parameters) {
    const auto found = field.parameters.find(parameter.name);
    const double value =
        found == field.parameters.end() ? default_parameter(*r.scene, fluid, field, parameter) : found->second;
    if (std::isnan(value))
      fail(r, location,
           "the parameter `" + parameter.name + "` " + whose +
               " is not given, and the domain has no such period; expected it: " + parameter.doc);
    if ((parameter.positive && !(value > 0)) || (parameter.whole && value != std::floor(value)))
      fail(r, location,
           "the parameter `" + parameter.name + "` " + whose + " is " + number_words(value) + "; expected " +
               (parameter.whole ? "a whole number above 0" : "a number above 0"));
    field.parameters[parameter.name] = value;
  }
}

// ---- regions -----------------------------------------------------------------------------------------------------
bool within_period(double x_m, double period_m) {
  const double slack = 1e-12 * period_m;
  return x_m >= -slack && x_m <= period_m + slack;
}

void check_region(Reading& r, const Value& table, Fluid& fluid) {
  const SourceLocation location = location_of(table, "region");
  const auto d = static_cast<std::size_t>(r.scene->domain.dimensions);
  const bool points = std::holds_alternative<PointsRegion>(fluid.region);
  const bool round =
      std::holds_alternative<BallRegion>(fluid.region) || std::holds_alternative<EllipsoidRegion>(fluid.region);
  if (points && !table.find("arrangement")) fluid.arrangement = Arrangement::file;
  if (points != (fluid.arrangement == Arrangement::file))
    fail(r, location,
         points ? "`region.file` in " + r.where + " requires `arrangement = \"file\"`; found another"
                : "`arrangement` in " + r.where + " is \"file\"; expected `region.file` with it");
  if (fluid.arrangement == Arrangement::rings && (!round || d == 3))
    fail(r, location, "`arrangement` in " + r.where + " is \"rings\"; expected a circle or an ellipse with it");
  if (points && fluid.particles.position_m.empty()) return;
  const RegionBounds bounds = bounds_of(fluid);
  for (std::size_t i = 0; i < d; ++i) {
    const std::string axis(1, "xyz"[i]);
    if (!points && !(bounds.min_m[i] < bounds.max_m[i]))
      fail(r, location,
           "the region of " + r.where + " reaches from " + number_words(bounds.min_m[i]) + " to " +
               number_words(bounds.max_m[i]) + " m along " + axis + "; expected a positive extent");
    const double period = r.scene->domain.periodic_m[i];
    if (period > 0 && !(within_period(bounds.min_m[i], period) && within_period(bounds.max_m[i], period)))
      fail(r, location,
           "the region of " + r.where + " reaches from " + number_words(bounds.min_m[i]) + " to " +
               number_words(bounds.max_m[i]) + " m along " + axis +
               ", outside the domain; expected it within the period, 0 to " + number_words(period) + " m");
  }
}

// x_m,y_m (z_m in three dimensions) under a header of these names.
std::vector<Real3> read_points(Reading& r, const std::string& path, double spacing_m) {
  constexpr double max_spacings = 1e9;  // beyond, a double knows a place to less than 10^-7 of a spacing
  std::string whole = read_input_file(path, "tables of points (CSV)", largest::kPoints - r.point_bytes);
  r.point_bytes += whole.size();
  CsvReader table(std::move(whole), path);
  std::vector<std::string> header{"x_m", "y_m"}, cells;
  const Domain& domain = r.scene->domain;
  if (domain.dimensions == 3) header.push_back("z_m");
  const auto joined = [](const std::vector<std::string>& all) {
    std::string text;
    for (const std::string& one : all) text += (text.empty() ? "" : ",") + one;
    return text;
  };
  const auto refuse = [&](const std::string& expected) {
    throw InputError(path + ":" + std::to_string(table.line()) + ":1: found `" + joined(cells).substr(0, 100) +
                     "`; expected " + expected);
  };
  std::vector<Real3> points;
  if (table.next(cells) && cells != header) refuse("the header " + joined(header));
  while (table.next(cells)) {
    Real3& x = points.emplace_back();
    if (cells.size() != header.size()) refuse(std::to_string(header.size()) + " finite numbers");
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const char *begin = cells[i].data(), *end = begin + cells[i].size();
      const auto [at, error] = std::from_chars(begin, end, x[i]);
      if (error != std::errc() || at != end || !std::isfinite(x[i]))
        refuse(std::to_string(header.size()) + " finite numbers");
      if (std::abs(x[i]) > max_spacings * spacing_m)
        refuse("coordinates up to 10^9 spacings of " + number_words(spacing_m) + " m");
      const double period = domain.periodic_m[i];
      if (period > 0 && !within_period(x[i], period))
        refuse(std::string(1, "xyz"[i]) + " from 0 to " + number_words(period) + " m, within the period");
    }
    if (points.size() > kMaxParticles) refuse("at most " + std::to_string(kMaxParticles) + " points");
  }
  if (points.empty())
    throw InputError(path + ":1:1: found no point; expected " + joined(header) + " and a point a line");
  return points;
}

// ---- the ladders -------------------------------------------------------------------------------------------------
// The spacing and the sound speed of a fluid stand in it, or as ladders of all fluids in [run].
void take_ladder(Reading& r, const Value& table, const char* key, const std::vector<double>& ladder,
                 const char* ladder_key, double Fluid::*member, Fluid& fluid) {
  const Value* given = table.find(key);
  if (given && !ladder.empty())
    fail(r, given->location,
         std::string("found `") + key + "` in " + r.where + " beside `" + ladder_key +
             "` in [run]; expected one of them");
  if (!given && ladder.empty())
    fail(r, table.location,
         std::string("missing key `") + key + "` in " + r.where + "; expected it, or `" + ladder_key + "` in [run]");
  if (!given) fluid.*member = ladder.front();
}

void check_ladders(Reading& r, const Value& run, const Scenario& scenario) {
  const auto refuse = [&](const char* key, const std::string& what) { fail(r, location_of(run, key), what); };
  const auto& spacings = scenario.spacings_m;
  const auto& speeds = scenario.sound_speeds_m_per_s;
  for (std::size_t i = 1; i < spacings.size(); ++i)
    if (!(spacings[i] < spacings[i - 1]))
      refuse("spacings_m", "`spacings_m` in [run] has " + number_words(spacings[i]) + " after " +
                               number_words(spacings[i - 1]) + "; expected spacings from the coarsest to the finest");
  for (std::size_t i = 1; i < speeds.size(); ++i)
    if (!(speeds[i] > speeds[i - 1]))
      refuse("sound_speeds_m_per_s", "`sound_speeds_m_per_s` in [run] has " + number_words(speeds[i]) + " after " +
                                         number_words(speeds[i - 1]) + "; expected growing speeds");
  for (const Fluid& fluid : scenario.scene.fluids) {
    if (std::holds_alternative<PointsRegion>(fluid.region) && spacings.size() > 1)
      refuse("spacings_m", "`spacings_m` in [run] has " + std::to_string(spacings.size()) +
                               " spacings, and the particles of the fluid `" + fluid.name +
                               "` come from a file; expected one spacing");
    for (const double spacing : spacings) {
      const std::string gap = unfilled(fluid, scenario.scene.domain.dimensions, spacing);
      if (!gap.empty())
        refuse("spacings_m", "`spacings_m` in [run] has " + number_words(spacing) +
                                 ", which does not fill the region of the fluid `" + fluid.name + "`: " + gap +
                                 "; expected a spacing that divides it");
    }
  }
}

// ---- walls -------------------------------------------------------------------------------------------------------
// Keys by which one would ask for what no boundary does.
void refuse_open_boundary(Reading& r, const Value& table) {
  for (const char* key : {"kind", "type", "open", "inflow", "outflow", "inlet", "outlet", "velocity_profile",
                          "velocity_m_per_s", "pressure_Pa"})
    if (const Value* found = table.find(key))
      fail(r, found->location,
           std::string("found `") + key + "` in " + r.where +
               "; open boundaries (inflow, outflow) are not simulated; expected a wall, `body` and `slip`" +
               (std::string(key).starts_with("velocity_")
                    ? ", and the velocity of the wall in its [[body]], `velocity_m_per_s`"
                    : ""));
}

void check_walls(Reading& r, const Value* boundaries, const Scene& scene) {
  for (std::size_t i = 0; i < scene.fluid_boundaries.size(); ++i)
    if (const std::string leak = leaking(scene, i); !leak.empty())
      fail(r, location_of((*boundaries->list())[i], "body"), leak);
}

}  // namespace

void check_fluid(Reading& r, const Value& table, Fluid& fluid) {
  if (const Value* exponent = table.find("tait_exponent");
      exponent && fluid.equation_of_state != EquationOfState::tait && r.form == Form::file)
    fail(r, exponent->location,
         "`tait_exponent` in " + r.where +
             " is given beside a linear equation of state; expected `equation_of_state = \"tait\"`");
  if (fluid.arrangement == Arrangement::disturbed && !table.find("disturbance")) fluid.disturbance = 0.2;
  if (const Value* disturbance = table.find("disturbance"); disturbance && fluid.arrangement != Arrangement::disturbed)
    fail(r, disturbance->location,
         "`disturbance` in " + r.where + " is given; expected it with `arrangement = \"disturbed\"` only");
  if (!(fluid.heat_capacity_J_per_kg_K > 0))
    for (const char* heat : {"conductivity_W_per_m_K", "viscous_heat", "expansion_per_K", "viscosity_decay_per_K"})
      if (const Value* given = table.find(heat))
        fail(r, given->location,
             std::string("`") + heat + "` in " + r.where +
                 " is given without a temperature; expected `heat_capacity_J_per_kg_K` above 0");
  if (!fluid.initial.name.empty())
    for (const char* uniform : {"velocity_m_per_s", "velocity_gradient_per_s"})
      if (const Value* given = table.find(uniform))
        fail(r, given->location,
             std::string("found `") + uniform + "` beside `initial` in " + r.where + "; expected one of them");
  check_region(r, table, fluid);
  check_field(r, table, "initial", fluid, fluid.initial);
  check_field(r, table, "source", fluid, fluid.source);
}

void check_boundary(Reading& r, const Value& table, const FluidBoundary& boundary) {
  if (boundary.temperature_K && boundary.heat_flux_W_per_m2)
    fail(r, location_of(table, "heat_flux_W_per_m2"),
         "found `heat_flux_W_per_m2` beside `temperature_K` in " + r.where + "; expected at most one");
  const auto& fluids = r.scene->fluids;
  const auto no_fluid_has = [&](double Fluid::*member) {
    return std::none_of(fluids.begin(), fluids.end(), [&](const Fluid& f) { return f.*member > 0; });
  };
  const bool cold = no_fluid_has(&Fluid::heat_capacity_J_per_kg_K);
  const auto refuse_heat = [&](const char* heat) {
    fail(r, location_of(table, heat),
         std::string("`") + heat + "` in " + r.where + " is given, and no fluid " +
             (cold ? "has a temperature; expected a fluid with `heat_capacity_J_per_kg_K` above 0"
                   : "conducts heat; expected a fluid with `conductivity_W_per_m_K` above 0"));
  };
  const bool insulating = cold || no_fluid_has(&Fluid::conductivity_W_per_m_K);
  if (boundary.temperature_K && insulating) refuse_heat("temperature_K");
  if (boundary.heat_flux_W_per_m2 && (cold || (insulating && *boundary.heat_flux_W_per_m2 != 0)))
    refuse_heat("heat_flux_W_per_m2");
  for (const FluidBoundary& earlier : r.scene->fluid_boundaries)
    if (earlier.body == boundary.body)
      fail(r, location_of(table, "body"),
           "found a second [[fluid_boundary]] of the body `" +
               r.scene->bodies[static_cast<std::size_t>(boundary.body)].name + "`; expected one");
  const Body& body = r.scene->bodies[static_cast<std::size_t>(boundary.body)];
  if (std::holds_alternative<std::monostate>(body.shape))
    fail(r, location_of(table, "body"),
         "the body `" + body.name + "` in " + r.where + " has no shape; expected one whose surface bounds the fluid");
  if (const auto* plane = std::get_if<Plane>(&body.shape)) {
    const Real3& n = plane->normal;
    if (normal_axis(*plane, r.scene->domain.dimensions) < 0)
      fail(r, location_of(table, "body"),
           "the plane of the body `" + body.name + "` in " + r.where +
               " is not perpendicular to a coordinate axis: its normal is [" + number_words(n[0]) + ", " +
               number_words(n[1]) + ", " + number_words(n[2]) +
               "]; expected a normal along an axis: no method fills a tilted wall");
  }
}

void check_probe(Reading& r, const Value& table, const FluidProbe& probe) {
  const bool of_body = probe.kind == ProbeKind::force_on_body, placed = !of_body && probe.kind != ProbeKind::front;
  if (placed && !table.find("position_m"))
    fail(r, table.location, "missing key `position_m` in " + r.where + "; expected the position of the probe");
  const Domain& domain = r.scene->domain;
  for (int axis = 0; placed && axis < domain.dimensions; ++axis) {
    const double at = probe.position_m[axis], period = domain.periodic_m[axis];
    if (period > 0 && !(at >= 0 && at <= period))
      fail(r, location_of(table, "position_m"),
           "`position_m` in " + r.where + " is " + describe(Value(at)) + " along " + "xyz"[axis] +
               ", outside the period; expected 0 to " + describe(Value(period)));
  }
  if (of_body != (probe.body >= 0))
    fail(r, of_body ? table.location : location_of(table, "body"),
         of_body ? "missing key `body` in " + r.where + "; expected the body of the force"
                 : "found `body` in " + r.where + "; expected it with kind \"force-on-body\" only");
  for (const FluidProbe& earlier : r.scene->probes)
    if (earlier.name == probe.name)
      fail(r, table.location,
           "found the name `" + probe.name + "` a second time in [[probe]]; expected each name once");
}

void check_sliding_walls(Reading& r, SourceLocation at) {
  const Scene& scene = *r.scene;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Body& body = scene.bodies[i];
    const Real3 &v = body.velocity_m_per_s, &w = body.angular_velocity_body_rad_per_s;
    if (!body.fixed || (v == Real3{} && w == Real3{})) continue;
    const bool wall = std::any_of(scene.fluid_boundaries.begin(), scene.fluid_boundaries.end(),
                                  [&](const FluidBoundary& b) { return b.body == static_cast<int>(i); });
    if (!wall)
      fail(r, at,
           "the velocity of the body `" + body.name +
               "` is not 0 for a fixed body; expected 0 (it never moves), or a [[fluid_boundary]] of the body");
    const auto* plane = std::get_if<Plane>(&body.shape);
    if (plane && v[0] * plane->normal[0] + v[1] * plane->normal[1] + v[2] * plane->normal[2] != 0)
      fail(r, at,
           "the velocity of the fixed plane `" + body.name +
               "` has a component along the plane's normal; a fixed plane can only slide within itself");
  }
}

void check_plane_scene(Reading& r, const Value& at) {
  const Scene& scene = *r.scene;
  if (scene.domain.dimensions != 2) return;
  const auto refuse = [&](const std::string& what, double found) {
    fail(r, at.location, what + " is " + number_words(found) + " along z; expected 0: the domain has two dimensions");
  };
  if (scene.gravity_m_per_s2[2] != 0) refuse("`gravity_m_per_s2` in [world]", scene.gravity_m_per_s2[2]);
  for (const Body& body : scene.bodies) {
    const std::string whose = " of the body `" + body.name + "`";
    if (const auto* plane = std::get_if<Plane>(&body.shape); plane && plane->normal[2] != 0)
      refuse("the normal" + whose, plane->normal[2]);
    if (body.position_m[2] != 0) refuse("`position_m`" + whose, body.position_m[2]);
    if (body.velocity_m_per_s[2] != 0) refuse("`velocity_m_per_s`" + whose, body.velocity_m_per_s[2]);
    const Real3& w = body.angular_velocity_body_rad_per_s;
    if (w[0] != 0 || w[1] != 0)
      fail(r, at.location,
           "`angular_velocity_body_rad_per_s`" + whose +
               " turns out of the plane; expected a turn about z: the domain has two dimensions");
    const Real4& q = body.orientation_wxyz;
    if (q[1] != 0 || q[2] != 0)
      fail(r, at.location,
           "`orientation_wxyz`" + whose + " is turned out of the plane; expected a turn about z in two dimensions");
  }
}

void resolve_fluids(Reading& r, const Value& document, FileDraft& draft) {
  Scenario& scenario = draft.scenario;
  Scene& scene = scenario.scene;
  if (!draft.fluid) {
    for (const char* other : {"domain", "fluid_boundary", "probe"})
      if (const Value* found = document.find(other))
        fail(r, found->location, std::string("found `") + other + "` without [[fluid]]; expected a fluid with it");
    for (const char* ladder : {"spacings_m", "sound_speeds_m_per_s"})
      if (const Value* found = draft.run->find(ladder))
        fail(r, found->location,
             std::string("found `") + ladder + "` in [run] without [[fluid]]; expected a fluid with it");
    return;
  }
  if (!draft.domain)
    fail(r, draft.fluid->location, "found [[fluid]] without [domain]; expected its dimensions and periods");
  r.where = "[domain]";
  r.key.clear();
  if (const Value* dimensions = draft.domain->find("dimensions"))  // what vectors of [domain] may be follows from it
    if (const auto* d = std::get_if<std::int64_t>(&dimensions->data)) scene.domain.dimensions = static_cast<int>(*d);
  read_table(r, *draft.domain, domain_keys(), {}, scene.domain);
  require_few(r, draft.fluid, "[[fluid]]", kMaxFluids);
  require_few(r, draft.fluid_boundary, "[[fluid_boundary]]", kMaxTables);
  require_few(r, draft.probe, "[[probe]]", kMaxTables);
  each_table(r, draft.fluid, "[[fluid]]", [&](const Value& table) {
    if (const Value* name = table.find("name"); name && name->text()) r.where += " `" + *name->text() + "`";
    Fluid fluid;
    read_table(r, table, fluid_keys(), {}, fluid);
    for (const Fluid& earlier : scene.fluids)
      if (earlier.name == fluid.name)
        fail(r, location_of(table, "name"),
             "found the name `" + fluid.name + "` a second time in [[fluid]]; expected each once");
    take_ladder(r, table, "spacing_m", scenario.spacings_m, "spacings_m", &Fluid::spacing_m, fluid);
    take_ladder(r, table, "sound_speed_m_per_s", scenario.sound_speeds_m_per_s, "sound_speeds_m_per_s",
                &Fluid::sound_speed_m_per_s, fluid);
    if (const auto* points = std::get_if<PointsRegion>(&fluid.region))
      fluid.particles.position_m = read_points(r, points->file, fluid.spacing_m);
    check_fluid(r, table, fluid);
    if (const std::string gap = unfilled(fluid, scene.domain.dimensions, fluid.spacing_m);
        !gap.empty() && scenario.spacings_m.empty())
      fail(r, location_of(table, "spacing_m"),
           "`spacing_m` in " + r.where + " is " + number_words(fluid.spacing_m) +
               ", which does not fill its region: " + gap + "; expected a spacing that divides it");
    scene.fluids.push_back(std::move(fluid));
  });
  each_table(r, draft.fluid_boundary, "[[fluid_boundary]]", [&](const Value& table) {
    FluidBoundary boundary;
    refuse_open_boundary(r, table);
    read_table(r, table, fluid_boundary_keys(), {}, boundary);
    check_boundary(r, table, boundary);
    scene.fluid_boundaries.push_back(boundary);
  });
  each_table(r, draft.probe, "[[probe]]", [&](const Value& table) {
    FluidProbe probe;
    read_table(r, table, fluid_probe_keys(), {}, probe);
    if (probe.name.empty()) probe.name = *table.find("kind")->text();
    check_probe(r, table, probe);
    scene.probes.push_back(std::move(probe));
  });
  check_sliding_walls(r, draft.domain->location);
  check_plane_scene(r, *draft.domain);
  r.where = "[run]";
  check_ladders(r, *draft.run, scenario);
  check_walls(r, draft.fluid_boundary, scene);
  try {
    place_particles(scene);
  } catch (const InputError& error) {
    fail(r, draft.fluid->list()->front().location, error.what());
  }
  if (const auto beyond = too_many_wall_points(scene, kCountedSpacings * scene.fluids.front().spacing_m))
    fail(r, location_of((*draft.fluid_boundary->list())[beyond->boundary], "body"), beyond->words);
}

}  // namespace atwood

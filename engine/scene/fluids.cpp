// The keys of [domain], [[fluid]], [[fluid_boundary]] and [[probe]].
#include <algorithm>
#include <cmath>

#include "scene/fluid_fields.hpp"
#include "scene/fluid_keys.hpp"

namespace atwood {
namespace {

// An enum by its words, in its order.
template <class T, class E>
Key<T> choice(std::string name, E T::*member, std::vector<std::string> words, std::string doc) {
  Key<T> k;
  const auto codec = choice_of(words);
  k.name = std::move(name), k.doc = std::move(doc), k.schema = codec.schema;
  k.read = [codec, words, member](Reading& r, const Value& v, T& out) {
    std::string word;
    codec.read(r, v, word);
    out.*member = static_cast<E>(std::find(words.begin(), words.end(), word) - words.begin());
  };
  k.write = [words, member](const Scene&, const T& from) {
    return Value(words[static_cast<std::size_t>(from.*member)]);
  };
  return k;
}

template <class T, class M> Key<T> unless(Key<T> k, M T::*member, M otherwise) {
  k.write = [write = k.write, member, otherwise](const Scene& s, const T& from) {
    return from.*member == otherwise ? Value() : write(s, from);
  };
  return k;
}

Range between_zero_and_one() {
  Range r = positive();
  r.expected = "a number above 0 and below 1";
  r.high = std::nextafter(1.0, 0.0);
  return r;
}

// ---- regions -----------------------------------------------------------------------------------------------------
template <class R> const Keys<R>& region_keys();
template <> const Keys<BoxRegion>& region_keys<BoxRegion>() {
  static const Keys<BoxRegion> keys = {
      required(key<BoxRegion>("min_m", &BoxRegion::min_m, domain_vector(), "the least coordinates [m]")),
      required(key<BoxRegion>("max_m", &BoxRegion::max_m, domain_vector(), "the largest coordinates [m]"))};
  return keys;
}
template <> const Keys<BallRegion>& region_keys<BallRegion>() {
  static const Keys<BallRegion> keys = {
      key<BallRegion>("center_m", &BallRegion::center_m, domain_vector(), "the centre [m]; 0 unless given"),
      required(key<BallRegion>("radius_m", &BallRegion::radius_m, number(positive()), "radius [m]"))};
  return keys;
}
template <> const Keys<EllipsoidRegion>& region_keys<EllipsoidRegion>() {
  static const Keys<EllipsoidRegion> keys = {
      key<EllipsoidRegion>("center_m", &EllipsoidRegion::center_m, domain_vector(), "the centre [m]; 0 unless given"),
      required(key<EllipsoidRegion>("semi_axes_m", &EllipsoidRegion::semi_axes_m, domain_vector(non_negative()),
                                    "half the lengths of the axes, along x, y (and z) [m]"))};
  return keys;
}

template <class R> void read_region(Reading& r, const Value& v, FluidRegion& out) {
  R region;
  read_table(r, v, region_keys<R>(), {}, region);
  out = region;
}

const std::vector<std::string> kRegions = {"box", "circle", "ellipse", "ball", "ellipsoid", "file"};

Value region_schema() {
  Value properties{Value::Table{}};
  for (const std::string& name : kRegions) {
    if (name == "box") add(properties, name, object_schema(region_keys<BoxRegion>(), Form::file));
    else if (name == "circle" || name == "ball")
      add(properties, name, object_schema(region_keys<BallRegion>(), Form::file));
    else if (name == "file") add(properties, name, table_of({{"type", "string"}}));
    else add(properties, name, object_schema(region_keys<EllipsoidRegion>(), Form::file));
  }
  Value schema = object_schema(std::move(properties), {});
  add(schema, "minProperties", 1);
  add(schema, "maxProperties", 1);
  return schema;
}

Key<Fluid> region_key() {
  Key<Fluid> k;
  k.name = "region", k.required = true;
  k.doc = "what the fluid fills at t = 0: box; circle or ellipse (two dimensions), ball or ellipsoid (three); file";
  k.schema = region_schema();
  k.read = [](Reading& r, const Value& v, Fluid& out) {
    const auto* members = v.table();
    if (!members || members->size() != 1) fail_value(r, v, "one of " + listed(kRegions));
    const std::string& kind = members->front().key;
    const Value& inner = members->front().value;
    const bool flat = r.scene->domain.dimensions == 2;
    if (std::find(kRegions.begin(), kRegions.end(), kind) == kRegions.end())
      fail(r, members->front().location,
           "unknown region `" + kind + "` in " + r.where + "; expected one of " + listed(kRegions) +
               did_you_mean(kind, kRegions));
    if ((flat && (kind == "ball" || kind == "ellipsoid")) || (!flat && (kind == "circle" || kind == "ellipse")))
      fail(r, members->front().location,
           "the region `" + kind + "` in " + r.where + " has " + (flat ? "three" : "two") +
               " dimensions; expected one of " + (flat ? "two: box, circle, ellipse" : "three: box, ball, ellipsoid"));
    const std::string outer = r.where;
    r.where += ", region." + kind;
    if (kind == "box") read_region<BoxRegion>(r, inner, out.region);
    else if (kind == "circle" || kind == "ball") read_region<BallRegion>(r, inner, out.region);
    else if (kind != "file") read_region<EllipsoidRegion>(r, inner, out.region);
    else {
      PointsRegion points;
      text().read(r, inner, points.file);
      if (r.form == Form::file) points.file = path_in_folder(r, inner);
      out.region = points;
    }
    r.where = outer;
  };
  k.write = [](const Scene& s, const Fluid& from) {
    const bool flat = s.domain.dimensions == 2;
    Value table{Value::Table{}}, inner{Value::Table{}};
    if (const auto* box = std::get_if<BoxRegion>(&from.region)) {
      write_table(s, *box, region_keys<BoxRegion>(), inner);
      add(table, "box", inner);
    } else if (const auto* ball = std::get_if<BallRegion>(&from.region)) {
      write_table(s, *ball, region_keys<BallRegion>(), inner);
      add(table, flat ? "circle" : "ball", inner);
    } else if (const auto* ellipsoid = std::get_if<EllipsoidRegion>(&from.region)) {
      write_table(s, *ellipsoid, region_keys<EllipsoidRegion>(), inner);
      add(table, flat ? "ellipse" : "ellipsoid", inner);
    } else {
      add(table, "file", std::get<PointsRegion>(from.region).file);
    }
    return table;
  };
  return k;
}

// ---- fields ------------------------------------------------------------------------------------------------------
std::vector<std::string> field_names(bool sources) {
  std::vector<std::string> names;
  for (const FieldInfo& field : fluid_fields())
    if (!sources || field.has_source) names.push_back(field.name);
  return names;
}

Value field_schema(bool sources) {
  Value::List forms{choice_of(field_names(sources)).schema};
  for (const FieldInfo& field : fluid_fields()) {
    if (sources && !field.has_source) continue;
    Value properties = table_of({{"field", table_of({{"const", Value(field.name)}})}});
    for (const FieldParameter& parameter : field.parameters) {
      Value number = table_of({{"type", "number"}, {"description", Value(parameter.doc)}});
      if (parameter.whole) add(number, "multipleOf", Value(1.0));
      if (parameter.positive) add(number, "exclusiveMinimum", Value(0.0));
      add(properties, parameter.name, std::move(number));
    }
    forms.push_back(table_of({{"type", "object"},
                              {"description", Value(field.doc)},
                              {"properties", std::move(properties)},
                              {"required", Value::List{Value("field")}},
                              {"additionalProperties", false}}));
  }
  return table_of({{"oneOf", std::move(forms)}});
}

// "taylor-green", or { field = "taylor-green", speed_m_per_s = 2 }. Parameters left out are filled in check_fluid().
void read_field(Reading& r, const Value& v, bool sources, InitialField& out) {
  const Value* name = v.table() ? v.find("field") : &v;
  if (!name) fail_value(r, v, "the name of a field, or { field = \"...\", and its parameters }");
  choice_of(field_names(sources)).read(r, *name, out.name);
  if (!v.table()) return;
  std::vector<std::string> known{"field"};
  for (const FieldParameter& parameter : find_field(out.name)->parameters) known.push_back(parameter.name);
  const std::string outer = r.key;
  for (const Member& member : *v.table()) {
    if (member.key == "field") continue;
    if (std::find(known.begin(), known.end(), member.key) == known.end())
      fail(r, member.location,
           "unknown parameter `" + member.key + "` of the field `" + out.name + "` in " + r.where +
               "; expected one of " + listed(known) + did_you_mean(member.key, known));
    r.key = member.key;
    out.parameters[member.key] = read_number(r, member.value, any_number());
  }
  r.key = outer;
}

Key<Fluid> field_key(std::string name, InitialField Fluid::*member, bool sources, std::string doc) {
  Key<Fluid> k;
  k.name = std::move(name), k.doc = std::move(doc), k.schema = field_schema(sources);
  k.read = [member, sources](Reading& r, const Value& v, Fluid& out) { read_field(r, v, sources, out.*member); };
  k.write = [member](const Scene&, const Fluid& from) {
    const InitialField& field = from.*member;
    if (field.name.empty()) return Value();
    Value table = table_of({{"field", Value(field.name)}});
    for (const auto& [parameter, value] : field.parameters) add(table, parameter, Value(value));
    return table;
  };
  return k;
}

Key<Fluid> velocity_key() {
  Key<Fluid> k;
  const auto codec = domain_vector();
  k.name = "velocity_m_per_s", k.schema = codec.schema;
  k.doc = "uniform velocity in place of a named field [m/s]; 0 unless given";
  k.read = [codec](Reading& r, const Value& v, Fluid& out) { codec.read(r, v, out.initial.velocity_m_per_s); };
  k.write = [codec](const Scene& s, const Fluid& from) {
    return from.initial.velocity_m_per_s == Real3{} ? Value() : codec.write(s, from.initial.velocity_m_per_s);
  };
  return k;
}

// d rows of d numbers, d the domain's dimensions.
Key<Fluid> gradient_key() {
  Key<Fluid> k;
  k.name = "velocity_gradient_per_s";
  k.doc = "rows of the velocity's gradient, v_i = velocity_i + sum_j gradient_ij x_j [1/s]; 0 unless given";
  const Value row = domain_vector().schema;
  k.schema = table_of({{"type", "array"}, {"items", row}, {"minItems", 2}, {"maxItems", 3}});
  k.read = [](Reading& r, const Value& v, Fluid& out) {
    const auto d = static_cast<std::size_t>(r.scene->domain.dimensions);
    const auto* rows = v.list();
    if (!rows || (rows->size() != d && rows->size() != 3))
      fail_value(r, v, std::to_string(d) + " rows of " + std::to_string(d) + " numbers");
    for (std::size_t i = 0; i < rows->size(); ++i) {
      Real3 row_of{};
      domain_vector().read(r, (*rows)[i], row_of);
      if (i >= d && row_of != Real3{}) fail_value(r, v, "a third row of zeros, since the domain has two dimensions");
      for (std::size_t j = 0; j < 3; ++j) out.initial.velocity_gradient_per_s[3 * i + j] = row_of[j];
    }
  };
  k.write = [](const Scene& s, const Fluid& from) {
    const auto& g = from.initial.velocity_gradient_per_s;
    if (g == std::array<double, 9>{}) return Value();
    Value::List rows;
    for (std::size_t i = 0; i < 3; ++i)
      rows.push_back(domain_vector().write(s, Real3{g[3 * i], g[3 * i + 1], g[3 * i + 2]}));
    return Value(std::move(rows));
  };
  return k;
}

// ---- particles, of the resolved form -----------------------------------------------------------------------------
// { position_m = [[x, y], ...], velocity_m_per_s = [[u, v], ...], mass_kg, density_kg_per_m3, temperature_K }: vectors
// of the domain's dimensions; a number in place of a list of numbers says that all are equal, of vectors that all are
// 0.
Value vectors(const std::vector<Real3>& from, std::size_t d) {
  if (std::all_of(from.begin(), from.end(), [](const Real3& x) { return x == Real3{}; })) return Value(0.0);
  Value::List all;
  all.reserve(from.size());
  for (const Real3& x : from) all.emplace_back(Value::List(x.begin(), x.begin() + static_cast<std::ptrdiff_t>(d)));
  return Value(std::move(all));
}

Value numbers(const std::vector<double>& from) {
  if (!from.empty() && std::all_of(from.begin(), from.end(), [&](double x) { return x == from.front(); }))
    return Value(from.front());
  return Value(Value::List(from.begin(), from.end()));
}

const Value& part(Reading& r, const Value& v, const char* name) {
  const Value* found = v.find(name);
  if (!found) fail(r, v.location, std::string("missing key `") + name + "` in `particles` of " + r.where);
  r.key = name;
  return *found;
}

void read_vectors(Reading& r, const Value& v, std::size_t count, std::vector<Real3>& out) {
  out.assign(count, Real3{});
  if (std::holds_alternative<double>(v.data) || std::holds_alternative<std::int64_t>(v.data)) {
    if (read_number(r, v, any_number()) != 0) fail_value(r, v, "a list of vectors, or 0");
    return;
  }
  const auto* items = v.list();
  if (!items || items->size() != count) fail_value(r, v, std::to_string(count) + " vectors");
  const auto codec = domain_vector();
  for (std::size_t i = 0; i < count; ++i) codec.read(r, (*items)[i], out[i]);
}

void read_numbers(Reading& r, const Value& v, std::size_t count, const Range& range, std::vector<double>& out) {
  const auto* items = v.list();
  if (!items) {
    out.assign(count, read_number(r, v, range));
    return;
  }
  if (items->size() != count) fail_value(r, v, std::to_string(count) + " numbers");
  out.resize(count);
  for (std::size_t i = 0; i < count; ++i) out[i] = read_number(r, (*items)[i], range);
}

Key<Fluid> particles_key() {
  Key<Fluid> k;
  k.name = "particles", k.in = In::resolved, k.required = true;
  k.doc =
      "state at t = 0: position_m, velocity_m_per_s (lists of vectors of the domain's dimensions), mass_kg (per metre of "
      "depth in two dimensions), density_kg_per_m3, temperature_K; a number stands for all particles, a 0 for vectors";
  const Value lists = table_of({{"type", Value(Value::List{Value("array"), Value("number")})}});
  k.schema = object_schema(table_of({{"position_m", lists},
                                     {"velocity_m_per_s", lists},
                                     {"mass_kg", lists},
                                     {"density_kg_per_m3", lists},
                                     {"temperature_K", lists}}),
                           {Value("position_m"), Value("velocity_m_per_s"), Value("mass_kg"),
                            Value("density_kg_per_m3"), Value("temperature_K")});
  k.read = [](Reading& r, const Value& v, Fluid& out) {
    const Value& positions = part(r, v, "position_m");
    if (!positions.list() || positions.list()->empty()) fail_value(r, positions, "a list of positions");
    const std::size_t count = positions.list()->size();
    Particles& p = out.particles;
    read_vectors(r, positions, count, p.position_m);
    read_vectors(r, part(r, v, "velocity_m_per_s"), count, p.velocity_m_per_s);
    read_numbers(r, part(r, v, "mass_kg"), count, positive(), p.mass_kg);
    read_numbers(r, part(r, v, "density_kg_per_m3"), count, positive(), p.density_kg_per_m3);
    read_numbers(r, part(r, v, "temperature_K"), count, any_number(), p.temperature_K);
    r.key = "particles";
  };
  k.write = [](const Scene& s, const Fluid& from) {
    const auto d = static_cast<std::size_t>(s.domain.dimensions);
    const Particles& p = from.particles;
    Value::List positions;  // never a single 0: it tells the count
    positions.reserve(p.position_m.size());
    for (const Real3& x : p.position_m)
      positions.emplace_back(Value::List(x.begin(), x.begin() + static_cast<std::ptrdiff_t>(d)));
    return table_of({{"position_m", Value(std::move(positions))},
                     {"velocity_m_per_s", vectors(p.velocity_m_per_s, d)},
                     {"mass_kg", numbers(p.mass_kg)},
                     {"density_kg_per_m3", numbers(p.density_kg_per_m3)},
                     {"temperature_K", numbers(p.temperature_K)}});
  };
  return k;
}

template <class T>
Key<T> optional_number(std::string name, std::optional<double> T::*member, std::string doc,
                       Range range = any_number()) {
  Key<T> k;
  const auto codec = number(std::move(range));
  k.name = std::move(name), k.doc = std::move(doc), k.schema = codec.schema;
  k.read = [codec, member](Reading& r, const Value& v, T& out) { codec.read(r, v, (out.*member).emplace()); };
  k.write = [member](const Scene&, const T& from) { return from.*member ? Value(*(from.*member)) : Value(); };
  return k;
}

}  // namespace

Codec<Real3> domain_vector(Range range) {
  Codec<Real3> c;
  c.schema = table_of({{"type", "array"}, {"items", number(range).schema}, {"minItems", 2}, {"maxItems", 3}});
  c.read = [range](Reading& r, const Value& v, Real3& out) {
    const bool flat = r.scene->domain.dimensions == 2;
    const auto* items = v.list();
    if (!items || items->size() > 3 || items->size() < (flat ? 2u : 3u))
      fail_value(r, v, flat ? "a list of 2 numbers (the domain has two dimensions)" : "a list of 3 numbers");
    out = {};
    for (std::size_t i = 0; i < items->size(); ++i) out[i] = read_number(r, (*items)[i], range);
    if (flat && out[2] != 0) fail_value(r, v, "2 numbers, or 0 along z: the domain has two dimensions");
  };
  c.write = [](const Scene& s, const Real3& v) {
    return Value(Value::List(v.begin(), v.begin() + (s.domain.dimensions == 2 ? 2 : 3)));
  };
  return c;
}

const Keys<Domain>& domain_keys() {
  static const Keys<Domain> keys = [] {
    Key<Domain> dimensions;
    const auto codec = integer(2, 3);
    dimensions.name = "dimensions", dimensions.doc = "2 (the plane z = 0) or 3; 3 unless given";
    dimensions.schema = codec.schema;
    dimensions.read = [codec](Reading& r, const Value& v, Domain& out) {
      std::int64_t found = 0;
      codec.read(r, v, found);
      out.dimensions = r.scene->domain.dimensions = static_cast<int>(found);
    };
    dimensions.write = [](const Scene&, const Domain& from) { return Value(from.dimensions); };
    return Keys<Domain>{dimensions,
                        key<Domain>("periodic_m", &Domain::periodic_m, domain_vector(non_negative()),
                                    "period along each axis [m], 0: not periodic; the periodic cell begins at the "
                                    "origin; 0 unless given")};
  }();
  return keys;
}

const Keys<Fluid>& fluid_keys() {
  static const Keys<Fluid> keys = [] {
    const auto scalar = [](const char* name, double Fluid::*member, Range range, const char* doc) {
      return key<Fluid>(name, member, number(std::move(range)), doc);
    };
    const auto left_out_at_0 = [&](const char* name, double Fluid::*member, Range range, const char* doc) {
      return unless(scalar(name, member, std::move(range), doc), member, 0.0);
    };
    return Keys<Fluid>{
        required(key<Fluid>("name", &Fluid::name, name_text(), "unique among the fluids")),
        region_key(),
        choice<Fluid>("arrangement", &Fluid::arrangement, {"lattice", "disturbed", "rings", "file"},
                      "lattice, disturbed, rings (of circles and ellipses), file; lattice unless given"),
        unless(scalar("disturbance", &Fluid::disturbance, between_zero_and_one(),
                      "disturbed: each coordinate moves by a random part of this many spacings; 0.2 unless given"),
               &Fluid::disturbance, 0.0),
        unless(key<Fluid>("seed", &Fluid::seed, integer(0, INT64_MAX), "of SplitMix64; 1 unless given"), &Fluid::seed,
               std::int64_t{1}),
        scalar("spacing_m", &Fluid::spacing_m, positive(), "of the particles [m], unless [run] has spacings_m"),
        required(
            scalar("density_kg_per_m3", &Fluid::density_kg_per_m3, positive(), "density rho0 at no pressure [kg/m^3]")),
        scalar("sound_speed_m_per_s", &Fluid::sound_speed_m_per_s, positive(),
               "sound speed at rho0 [m/s], unless [run] has sound_speeds_m_per_s"),
        choice<Fluid>("equation_of_state", &Fluid::equation_of_state, {"linear", "tait"},
                      "linear: p = c^2 (rho - rho0); tait: p = rho0 c^2 / n ((rho / rho0)^n - 1); linear unless given"),
        unless(scalar("tait_exponent", &Fluid::tait_exponent, positive(), "n of tait; 7 unless given"),
               &Fluid::tait_exponent, 7.0),
        left_out_at_0("viscosity_m2_per_s", &Fluid::viscosity_m2_per_s, non_negative(),
                      "kinematic viscosity [m^2/s]; 0 unless given"),
        left_out_at_0("heat_capacity_J_per_kg_K", &Fluid::heat_capacity_J_per_kg_K, non_negative(),
                      "specific heat [J/(kg K)]; 0, no temperature, unless given"),
        left_out_at_0("conductivity_W_per_m_K", &Fluid::conductivity_W_per_m_K, non_negative(),
                      "heat conductivity [W/(m K)]; 0 unless given"),
        left_out_at_0("temperature_K", &Fluid::temperature_K, non_negative(),
                      "at t = 0, and the reference of expansion and viscosity decay [K]; 0 unless given"),
        unless(key<Fluid>("viscous_heat", &Fluid::viscous_heat, boolean(),
                          "viscous dissipation raises the temperature; false unless given"),
               &Fluid::viscous_heat, false),
        left_out_at_0("expansion_per_K", &Fluid::expansion_per_K, any_number(),
                      "Boussinesq: gravity acts as g (1 - expansion (T - temperature_K)) [1/K]; 0 unless given"),
        left_out_at_0("viscosity_decay_per_K", &Fluid::viscosity_decay_per_K, any_number(),
                      "viscosity exp(-decay (T - temperature_K)) [1/K]; 0 unless given"),
        field_key("initial", &Fluid::initial, false,
                  "a named field at t = 0, or { field = ..., and its parameters }; at rest unless given"),
        velocity_key(),
        gradient_key(),
        field_key("source", &Fluid::source, true, "a named body acceleration beside gravity; none unless given"),
        particles_key(),
    };
  }();
  return keys;
}

const Keys<FluidBoundary>& fluid_boundary_keys() {
  static const Keys<FluidBoundary> keys = [] {
    auto slip = choice<FluidBoundary>("slip", &FluidBoundary::slip, {"no-slip", "free-slip"},
                                      "no-slip or free-slip; no-slip unless given");
    slip.read = [read = slip.read](Reading& r, const Value& v, FluidBoundary& out) {
      for (const char* open : {"inflow", "outflow", "open"})
        if (v.text() && *v.text() == open)
          fail_value(r, v, "no-slip or free-slip: open boundaries (inflow, outflow) are not simulated");
      read(r, v, out);
    };
    return Keys<FluidBoundary>{
        required(key<FluidBoundary>("body", &FluidBoundary::body, body_name(), "a body of the scene")), slip,
        optional_number<FluidBoundary>("temperature_K", &FluidBoundary::temperature_K, "of its surface [K]",
                                       non_negative()),
        optional_number<FluidBoundary>("heat_flux_W_per_m2", &FluidBoundary::heat_flux_W_per_m2,
                                       "through its surface into the fluid [W/m^2]")};
  }();
  return keys;
}

const Keys<FluidProbe>& fluid_probe_keys() {
  static const Keys<FluidProbe> keys = [] {
    auto body = key<FluidProbe>("body", &FluidProbe::body, body_name(), "force-on-body: a body of the scene");
    body.write = [write = body.write](const Scene& s, const FluidProbe& from) {
      return from.body < 0 ? Value() : write(s, from);
    };
    auto position = key<FluidProbe>("position_m", &FluidProbe::position_m, domain_vector(),
                                    "pressure, velocity, column-height: where [m]; marker: where it begins");
    return Keys<FluidProbe>{
        key<FluidProbe>("name", &FluidProbe::name, name_text(), "unique among the probes; its kind unless given"),
        required(choice<FluidProbe>("kind", &FluidProbe::kind,
                                    {"pressure", "velocity", "front", "column-height", "force-on-body", "marker"},
                                    "pressure, velocity, front (largest x of a particle), column-height, "
                                    "force-on-body, marker (distance of a material point from the origin)")),
        position, body};
  }();
  return keys;
}

}  // namespace atwood

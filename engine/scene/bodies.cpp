// Materials, pairs, bodies: their keys, and the checks of a body that span keys.
#include <algorithm>
#include <cmath>

#include "scene/declarations.hpp"
#include "scene/inertia.hpp"
#include "scene/orientation.hpp"

namespace atwood {
namespace {

template <class T> Codec<std::optional<T>> optional(Codec<T> inner) {
  Codec<std::optional<T>> c;
  c.schema = inner.schema;
  c.read = [inner](Reading& r, const Value& v, std::optional<T>& out) {
    T value{};
    inner.read(r, v, value);
    out = value;
  };
  c.write = [inner](const Scene& s, const std::optional<T>& from) { return from ? inner.write(s, *from) : Value(); };
  return c;
}

// [Ixx, Iyy, Izz], 3 x 3 in rows, or nine numbers row by row.
Codec<Real33> inertia() {
  Codec<Real33> c;
  const Value three = vector3().schema;
  const Value nine =
      table_of({{"type", "array"}, {"items", table_of({{"type", "number"}})}, {"minItems", 9}, {"maxItems", 9}});
  const Value rows = table_of({{"type", "array"}, {"items", three}, {"minItems", 3}, {"maxItems", 3}});
  c.schema = table_of({{"oneOf", Value::List{three, rows, nine}}});
  c.read = [](Reading& r, const Value& v, Real33& out) {
    const char* expected = "three principal moments, a 3 x 3 matrix or its nine numbers";
    const auto* items = v.list();
    if (!items || (items->size() != 3 && items->size() != 9)) fail_value(r, v, expected);
    out = {};
    for (std::size_t i = 0; i < items->size(); ++i) {
      const auto* row = (*items)[i].list();
      const bool nested = items->size() == 3 && items->front().list();
      if (nested != (row != nullptr) || (row && row->size() != 3)) fail_value(r, (*items)[i], expected);
      for (std::size_t j = 0; nested && j < 3; ++j) out[3 * i + j] = read_number(r, (*row)[j], any_number());
      if (!nested) out[items->size() == 9 ? i : 4 * i] = read_number(r, (*items)[i], any_number());
    }
  };
  c.write = [](const Scene&, const Real33& v) { return Value(Value::List(v.begin(), v.end())); };
  return c;
}

Range mass() {
  Range r = non_negative();
  r.expected = "a number above 0 (only a fixed body needs no mass)";
  return r;
}

Key<BodyDraft> shape_key() {
  Key<BodyDraft> k;
  k.name = "shape";
  k.doc = "what touches, and what inertia follows from; none: a point";
  k.schema = table_of({{"$ref", "#/$defs/shape"}});
  k.resolved_schema = table_of({{"$ref", "#/$defs/resolved_shape"}});
  k.read = [](Reading& r, const Value& v, BodyDraft& out) { out.shape = read_shape(r, v); };
  k.write = [](const Scene& s, const BodyDraft& from) {
    Value table{Value::Table{}};
    for (const auto& alternative : shapes()) {
      if (!alternative.holds(from.shape)) continue;
      Value inner{Value::Table{}};
      alternative.write(s, from.shape, inner);
      add(table, alternative.name, std::move(inner));
    }
    return table.table()->empty() ? Value() : table;
  };
  return k;
}

Key<ContactDraft> between_key() {
  Key<ContactDraft> k;
  k.name = "between";
  k.doc = "the names of two materials (or twice one)";
  const Value item = table_of({{"type", "string"}});
  k.schema = table_of({{"type", "array"}, {"items", item}, {"minItems", 2}, {"maxItems", 2}});
  k.required = true;
  k.read = [](Reading& r, const Value& v, ContactDraft& out) {
    const auto* items = v.list();
    if (!items || items->size() != 2) fail_value(r, v, "a list of two materials");
    const Codec<int> material = material_name();
    material.read(r, (*items)[0], out.a);
    material.read(r, (*items)[1], out.b);
    if (out.a > out.b) std::swap(out.a, out.b);
  };
  return k;
}

Key<PairLaw> pair_between_key() {
  Key<PairLaw> k;
  k.name = "between";
  k.doc = "the names of two materials";
  k.schema = between_key().schema;
  k.required = true;
  k.read = [](Reading& r, const Value& v, PairLaw& out) {
    ContactDraft draft;
    between_key().read(r, v, draft);
    out.a = draft.a, out.b = draft.b;
  };
  k.write = [](const Scene& s, const PairLaw& from) {
    return Value(Value::List{Value(s.materials.at(static_cast<std::size_t>(from.a)).name),
                             Value(s.materials.at(static_cast<std::size_t>(from.b)).name)});
  };
  return k;
}

const std::vector<std::string> kContactLaws = {"rigid", "linear", "hertz"};  // as in ContactLaw

// Left out of a resolved scene where the pair is rigid.
const Keys<PairLaw>& compliance_keys() {
  static const Keys<PairLaw> keys = [] {
    Key<PairLaw> law;
    law.name = "contact_law";
    law.doc = "contact law of the surfaces: linear (a spring and a dashpot), hertz; rigid unless given";
    const auto codec = choice_of(kContactLaws);
    law.schema = codec.schema;
    law.read = [codec](Reading& r, const Value& v, PairLaw& out) {
      std::string word;
      codec.read(r, v, word);
      out.contact_law =
          static_cast<ContactLaw>(std::find(kContactLaws.begin(), kContactLaws.end(), word) - kContactLaws.begin());
    };
    law.write = [](const Scene&, const PairLaw& from) {
      return Value(kContactLaws[static_cast<std::size_t>(from.contact_law)]);
    };
    Keys<PairLaw> all{
        law,
        key<PairLaw>("stiffness_N_per_m", &PairLaw::stiffness_N_per_m, number(positive()), "linear [N/m]"),
        key<PairLaw>("damping_N_s_per_m", &PairLaw::damping_N_s_per_m, number(non_negative()),
                     "linear [N s/m]; 0 unless given"),
        key<PairLaw>("pull", &PairLaw::pull, boolean(),
                     "linear: the force may pull until the overlap ends; false unless given"),
        key<PairLaw>("modulus_Pa", &PairLaw::modulus_Pa, number(positive()),
                     "hertz: 1 / ((1 - nu_a^2) / E_a + (1 - nu_b^2) / E_b) [Pa]"),
        key<PairLaw>("damping_s_per_m", &PairLaw::damping_s_per_m, number(non_negative()),
                     "hertz: the force is its static part times 1 + damping d' [s/m]; 0 unless given")};
    for (std::size_t k = 0; k < all.size(); ++k) {
      const ContactLaw owner = k == 0 ? ContactLaw::rigid : k < 4 ? ContactLaw::linear : ContactLaw::hertz;
      all[k].write = [owner, write = all[k].write](const Scene& s, const PairLaw& from) {
        const bool shown = owner == ContactLaw::rigid ? from.contact_law != owner : from.contact_law == owner;
        return shown ? write(s, from) : Value();
      };
    }
    return all;
  }();
  return keys;
}

void fail_body(Reading& r, const Value& table, const char* at, const std::string& message) {
  const Value* value = table.find(at);
  fail(r, value ? value->location : table.location, message + " in " + r.where);
}

void check_plane(Reading& r, const Value& table, BodyDraft& body) {
  if (!std::holds_alternative<Plane>(body.shape) || r.form != Form::file) return;
  if (table.find("fixed") && !body.fixed)
    fail(r, table.find("fixed")->location,
         "`fixed` in " + r.where + " is false for a plane; expected true (a plane never moves)");
  for (const char* unused : {"position_m", "orientation_wxyz", "axis_angle_deg", "euler_xyz_deg"})
    if (const Value* value = table.find(unused))
      fail(r, value->location,
           std::string("`") + unused + "` in " + r.where +
               " is given for a plane; expected `normal` and `offset_m`, which are the pose of a plane");
  body.fixed = true;
}

void check_fixed(Reading& r, const Value& table, BodyDraft& body) {
  const bool slides = body.velocity_m_per_s != Real3{} || body.angular_velocity_body_rad_per_s != Real3{};
  if (slides && !r.has_fluids) {  // of walls of fluids: check_sliding_walls()
    const bool linear = body.velocity_m_per_s != Real3{};
    const char* which = linear ? "velocity_m_per_s" : "angular_velocity_body_rad_per_s";
    fail(r, table.find(which)->location,
         std::string("`") + which + "` in " + r.where + " is not 0 for a fixed body; expected 0 (it never moves)");
  }
  if (r.form == Form::file) body.mass_kg = 0, body.inertia_kg_m2 = {};
}

// Mass from mass_kg or density and volume, inertia as given or from the shape.
void resolve_mass(Reading& r, const Value& table, BodyDraft& body) {
  const Value* mass = table.find("mass_kg");
  if (mass && body.density_kg_per_m3)
    fail(r, table.find("density_kg_per_m3")->location,
         "`density_kg_per_m3` in " + r.where + " is given beside `mass_kg`; expected one of the two");
  if (!mass && !body.density_kg_per_m3)
    fail(r, table.location,
         "missing key `mass_kg` in " + r.where + "; expected a mass above 0, `density_kg_per_m3`, or `fixed = true`");
  if (mass && !(body.mass_kg > 0)) {
    r.key = "mass_kg";
    fail_value(r, *mass, "a number above 0 (only a fixed body needs no mass)");
  }
  const Value* shape = table.find("shape");
  MassProperties unit;
  std::string problem;
  if (shape) problem = mass_properties(body.shape, unit);
  const SourceLocation shape_at = shape ? shape->location : table.location;
  if (body.density_kg_per_m3) {
    if (problem.empty() && !(unit.volume_m3 > 0))
      problem = "has no volume, so a density gives no mass; expected `mass_kg`";
    if (!shape)
      fail(r, table.find("density_kg_per_m3")->location,
           "`density_kg_per_m3` in " + r.where + " is given without a shape; expected `mass_kg`");
    if (!problem.empty()) fail(r, shape_at, "the shape in " + r.where + " " + problem);
    body.mass_kg = *body.density_kg_per_m3 * unit.volume_m3;
  }
  if (body.inertia) {
    body.inertia_kg_m2 = *body.inertia;
  } else if (shape) {
    if (!problem.empty()) fail(r, shape_at, "the shape in " + r.where + " " + problem);
    for (std::size_t i = 0; i < 9; ++i) body.inertia_kg_m2[i] = body.mass_kg * unit.inertia_per_kg_m2[i];
  }
  if (!std::isfinite(body.mass_kg) || !(body.mass_kg > 0))
    fail(r, table.location,
         "the mass of " + r.where + " comes out as " + describe(Value(body.mass_kg)) +
             "; expected a finite number above 0");
}

}  // namespace

const Keys<Material>& material_keys() {
  static const Keys<Material> keys = {
      required(only(In::resolved, key<Material>("name", &Material::name, name_text(), "its name"))),
      key<Material>("restitution", &Material::restitution, number(closed_range(0, 1)),
                    "Newton's, 0 to 1; 0 unless given"),
      key<Material>("friction", &Material::friction, number(non_negative()), "Coulomb's; 0 unless given"),
      key<Material>("rolling_friction_m", &Material::rolling_friction_m, number(non_negative()),
                    "lever of rolling resistance [m]; 0 unless given"),
  };
  return keys;
}

void check_contact_law(Reading& r, const Value& table, const PairLaw& law) {
  const auto& keys = compliance_keys();
  const std::string& named = kContactLaws[static_cast<std::size_t>(law.contact_law)];
  for (std::size_t k = 1; k < keys.size(); ++k) {
    const ContactLaw owner = k < 4 ? ContactLaw::linear : ContactLaw::hertz;
    if (const Value* given = table.find(keys[k].name); given && law.contact_law != owner)
      fail(r, given->location,
           "`" + keys[k].name + "` in " + r.where + " is given beside the contact law " + named +
               "; expected it with `" + kContactLaws[static_cast<std::size_t>(owner)] + "` only");
  }
  const bool lacks = (law.contact_law == ContactLaw::linear && !(law.stiffness_N_per_m > 0)) ||
                     (law.contact_law == ContactLaw::hertz && !(law.modulus_Pa > 0));
  if (lacks)
    fail(r, table.find("contact_law")->location,
         std::string("missing key `") + (law.contact_law == ContactLaw::linear ? "stiffness_N_per_m" : "modulus_Pa") +
             "` in " + r.where + "; expected it with the contact law " + named);
}

const Keys<ContactDraft>& contact_keys() {
  static const Keys<ContactDraft> keys = [] {
    Keys<ContactDraft> all = {
        between_key(),
        key<ContactDraft>("restitution", &ContactDraft::restitution, optional(number(closed_range(0, 1))),
                          "of the pair; the geometric mean unless given"),
        key<ContactDraft>("friction", &ContactDraft::friction, optional(number(non_negative())),
                          "of the pair; the geometric mean unless given"),
        key<ContactDraft>("rolling_friction_m", &ContactDraft::rolling_friction_m, optional(number(non_negative())),
                          "of the pair [m]; the geometric mean unless given"),
    };
    for (const Key<PairLaw>& law : compliance_keys()) {
      Key<ContactDraft> own;
      own.name = law.name;
      own.doc = law.doc;
      own.schema = law.schema;
      own.read = [read = law.read](Reading& r, const Value& v, ContactDraft& out) { read(r, v, out.compliance); };
      all.push_back(own);
    }
    return all;
  }();
  return keys;
}

const Keys<PairLaw>& pair_keys() {
  static const Keys<PairLaw> keys = [] {
    Keys<PairLaw> all = {
        pair_between_key(),
        required(key<PairLaw>("restitution", &PairLaw::restitution, number(closed_range(0, 1)), "Newton's")),
        required(key<PairLaw>("friction", &PairLaw::friction, number(non_negative()), "Coulomb's")),
        required(key<PairLaw>("rolling_friction_m", &PairLaw::rolling_friction_m, number(non_negative()),
                              "lever of rolling resistance [m]")),
    };
    for (const Key<PairLaw>& law : compliance_keys()) all.push_back(law);
    return all;
  }();
  return keys;
}

const Keys<BodyDraft>& body_keys() {
  static const Keys<BodyDraft> keys = [] {
    Keys<BodyDraft> all = {
        required(key<BodyDraft>("name", &Body::name, name_text(), "a name, used once")),
        key<BodyDraft>("mass_kg", &Body::mass_kg, number(mass()), "mass [kg]; above 0 unless fixed"),
        only(In::file, key<BodyDraft>("density_kg_per_m3", &BodyDraft::density_kg_per_m3, optional(number(positive())),
                                      "in place of a mass: times the volume of the shape [kg/m^3]")),
        key<BodyDraft>(
            "inertia_kg_m2", &BodyDraft::inertia, optional(inertia()),
            "about the centre of mass in body axes [kg m^2]; from the shape unless given, a point mass without both"),
        key<BodyDraft>("material", &Body::material, material_name(), "name of a material; `default` unless given"),
        shape_key(),
        key<BodyDraft>("position_m", &Body::position_m, vector3(), "of the centre of mass [m]; 0 unless given"),
        key<BodyDraft>("orientation_wxyz", &Body::orientation_wxyz, unit_quaternion(),
                       "unit quaternion, body to world; identity unless given"),
        key<BodyDraft>("velocity_m_per_s", &Body::velocity_m_per_s, vector3(),
                       "of the centre of mass [m/s]; 0 unless given"),
        key<BodyDraft>("angular_velocity_body_rad_per_s", &Body::angular_velocity_body_rad_per_s, vector3(),
                       "in body axes [rad/s]; 0 unless given"),
        key<BodyDraft>("charge_C", &Body::charge_C, number(), "charge [C]; 0 unless given"),
        key<BodyDraft>("fixed", &Body::fixed, boolean(), "never moves; false unless given (a plane: true)"),
        key<BodyDraft>("release_s", &Body::release_s, number(non_negative()), "held until then [s]; 0 unless given"),
    };
    add_degree_keys(all, &Body::orientation_wxyz);
    return all;
  }();
  return keys;
}

void finish_body(Reading& r, const Value& table, BodyDraft& body) {
  require_one_orientation(r, table);
  check_plane(r, table, body);
  if (body.fixed) return check_fixed(r, table, body);
  if (r.form == Form::resolved) {
    body.inertia_kg_m2 = body.inertia.value_or(Real33{});
    if (!(body.mass_kg > 0))
      fail_body(r, table, "mass_kg", "found a mass of " + describe(Value(body.mass_kg)) + "; expected one above 0,");
  } else {
    resolve_mass(r, table, body);
  }
  const Value* given = table.find("inertia_kg_m2");
  if (!given && !rotates(body) && table.find("shape") && r.form == Form::file)
    fail(r, table.find("shape")->location, "the inertia of " + r.where + " underflows to 0; expected a larger body");
  if (rotates(body))
    if (const std::string problem = inertia_problem(body.inertia_kg_m2); !problem.empty())
      fail(r, given ? given->location : table.location, "`inertia_kg_m2` in " + r.where + " " + problem);
  if (!rotates(body) && body.angular_velocity_body_rad_per_s != Real3{})
    fail(r, table.find("angular_velocity_body_rad_per_s")->location,
         "`angular_velocity_body_rad_per_s` in " + r.where +
             " is not 0 for a point mass; expected a shape or `inertia_kg_m2`");
}

}  // namespace atwood

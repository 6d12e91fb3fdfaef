#include "scene/scenario_keys.hpp"

#include <algorithm>
#include <cmath>

#include "scene/fluid_keys.hpp"
#include "scene/joint_keys.hpp"

namespace atwood {
namespace {

// As in TruthKind.
const std::vector<std::string> kTruthKinds = {"closed-form",         "extended",      "cvode",     "values", "none",
                                              "weakly-compressible", "semi-discrete", "literature"};
const std::vector<std::string> kQuantities = {
    "energy",          "momentum",           "angular-momentum", "angular-momentum-center", "center-of-mass",
    "jacobi-constant", "laplace-runge-lenz", "magnetic-moment",  "swinging-atwood"};

// Calls `read` with another `where` for messages.
template <class F> void within(Reading& r, const std::string& where, F read) {
  const std::string outer_where = r.where, outer_key = r.key;
  r.where = where, r.key.clear();
  read();
  r.where = outer_where, r.key = outer_key;
}

// ---- parts of the file ------------------------------------------------------------------------------------------
Value array_of(Value item) { return table_of({{"type", "array"}, {"items", std::move(item)}}); }
Value reference(const char* name) { return table_of({{"$ref", name}}); }

Key<FileDraft> later(std::string name, const Value* FileDraft::*member, Value schema, std::string doc) {
  Key<FileDraft> k;
  k.name = std::move(name);
  k.doc = std::move(doc);
  k.schema = std::move(schema);
  k.read = [member](Reading&, const Value& v, FileDraft& out) { out.*member = &v; };
  return k;
}

template <class T>
Key<T> words(std::string name, std::string Scenario::*member, Codec<std::string> codec, std::string doc,
             Scenario& (*scenario_of)(T&)) {
  Key<T> k;
  k.name = std::move(name);
  k.doc = std::move(doc);
  k.schema = codec.schema;
  k.read = [=](Reading& r, const Value& v, T& out) { codec.read(r, v, scenario_of(out).*member); };
  k.write = [=](const Scene&, const T& from) { return Value(scenario_of(const_cast<T&>(from)).*member); };
  return k;
}

// ---- truth and invariants ---------------------------------------------------------------------------------------
const Keys<TruthSpec>& truth_keys() {
  static const Keys<TruthSpec> keys = [] {
    Key<TruthSpec> kind;
    kind.name = "kind";
    kind.doc = "where the truth comes from";
    kind.required = true;
    const auto codec = choice_of(kTruthKinds);
    kind.schema = codec.schema;
    kind.read = [codec](Reading& r, const Value& v, TruthSpec& out) {
      std::string word;
      codec.read(r, v, word);
      out.kind = static_cast<TruthKind>(std::find(kTruthKinds.begin(), kTruthKinds.end(), word) - kTruthKinds.begin());
    };
    kind.write = [](const Scene&, const TruthSpec& from) {
      return Value(kTruthKinds[static_cast<std::size_t>(from.kind)]);
    };
    auto solution =
        key<TruthSpec>("solution", &TruthSpec::solution, text(),
                       "closed-form, weakly-compressible, semi-discrete, literature: the id of the solution");
    auto file = key<TruthSpec>("file", &TruthSpec::file, text(), "values: a CSV file in the scene's folder");
    for (auto* each : {&solution, &file})
      each->write = [write = each->write](const Scene& s, const TruthSpec& from) {
        Value v = write(s, from);
        return v.text()->empty() ? Value() : v;
      };
    return Keys<TruthSpec>{kind, solution, file};
  }();
  return keys;
}

void read_truth(Reading& r, const Value& v, TruthSpec& out) {
  within(r, "[truth]", [&] {
    read_table(r, v, truth_keys(), {}, out);
    const Value &kind = *v.find("kind"), *solution = v.find("solution"), *file = v.find("file");
    const bool values = out.kind == TruthKind::values;
    const bool named = out.kind == TruthKind::closed_form || out.kind == TruthKind::literature;
    const bool of_fluid = out.kind == TruthKind::weakly_compressible || out.kind == TruthKind::semi_discrete;
    if (named && out.solution.empty())
      fail(r, kind.location,
           "missing key `solution` in [truth]; expected the id of a " +
               std::string(out.kind == TruthKind::literature ? "published result" : "closed form"));
    if (values && out.file.empty())
      fail(r, kind.location, "missing key `file` in [truth]; expected a CSV file in the scene's folder");
    if (solution && !named && !of_fluid)
      fail(r, solution->location,
           "`solution` in [truth] is given beside kind " + describe(kind) +
               "; expected it with \"closed-form\" and truths of fluids only");
    if (file && !values)
      fail(r, file->location,
           "`file` in [truth] is given beside kind " + describe(kind) + "; expected it with \"values\" only");
    if (file && r.form == Form::file) {
      r.key = "file";
      out.file = path_in_folder(r, *file);
    }
  });
}

const Keys<Invariant>& invariant_keys() {
  static const Keys<Invariant> keys = {
      required(key<Invariant>("quantity", &Invariant::quantity, choice_of(kQuantities), "what the motion keeps"))};
  return keys;
}

void read_invariants(Reading& r, const Value& v, std::vector<Invariant>& out) {
  const auto* items = v.list();
  if (!items) fail_value(r, v, "a list of tables ([[invariant]])");
  for (const Value& item : *items)
    within(r, "[[invariant]]", [&] {
      Invariant invariant;
      read_table(r, item, invariant_keys(), {}, invariant);
      for (const Invariant& earlier : out)
        if (earlier.quantity == invariant.quantity)
          fail(r, item.location,
               "found the quantity `" + invariant.quantity + "` a second time in [[invariant]]; expected it once");
      out.push_back(std::move(invariant));
    });
}

// The keys that file and resolved form share; `scenario_of` finds the scenario in either draft.
template <class T> Keys<T> shared_keys(Scenario& (*scenario_of)(T&)) {
  Keys<T> keys = {
      required(words<T>("id", &Scenario::id, kebab_text(), "a unique id in kebab-case", scenario_of)),
      words<T>("title", &Scenario::title, text(), "one line", scenario_of),
      words<T>("claim", &Scenario::claim, text(), "what should hold", scenario_of),
      words<T>("source", &Scenario::source, text(), "where it comes from", scenario_of),
  };
  Key<T> tags, truth, invariants;
  const auto tag_list = list_of(kebab_text(), 100);
  tags.name = "tags", tags.doc = "kebab-case words to select by", tags.schema = tag_list.schema;
  tags.read = [=](Reading& r, const Value& v, T& out) { tag_list.read(r, v, scenario_of(out).tags); };
  tags.write = [=](const Scene& s, const T& from) { return tag_list.write(s, scenario_of(const_cast<T&>(from)).tags); };
  truth.name = "truth", truth.doc = "what the motion is judged by; none unless given";
  truth.schema = object_schema(truth_keys(), Form::file);
  truth.read = [=](Reading& r, const Value& v, T& out) { read_truth(r, v, scenario_of(out).truth); };
  truth.write = [=](const Scene& s, const T& from) {
    Value table{Value::Table{}};
    write_table(s, scenario_of(const_cast<T&>(from)).truth, truth_keys(), table);
    return table;
  };
  invariants.name = std::is_same_v<T, Scenario> ? "invariants" : "invariant";
  invariants.doc = "what the motion keeps";
  invariants.schema = array_of(object_schema(invariant_keys(), Form::file));
  invariants.read = [=](Reading& r, const Value& v, T& out) { read_invariants(r, v, scenario_of(out).invariants); };
  invariants.write = [=](const Scene& s, const T& from) {
    Value::List items;
    for (const Invariant& each : scenario_of(const_cast<T&>(from)).invariants) {
      Value table{Value::Table{}};
      write_table(s, each, invariant_keys(), table);
      items.push_back(std::move(table));
    }
    return Value(std::move(items));
  };
  keys.push_back(std::move(tags));
  keys.push_back(std::move(truth));
  keys.push_back(std::move(invariants));
  return keys;
}

const std::vector<std::string> kSimultaneousImpacts = {"sequential", "together"};  // as in SimultaneousImpacts, from 1

// A resolved scene without a convention does not have this key.
Key<Scene> simultaneous_impacts_key() {
  Key<Scene> impacts;
  impacts.name = "simultaneous_impacts";
  impacts.doc =
      "impacts at one instant: sequential (pair by pair) or together (one solve); absent: a truth ends where "
      "the outcome would depend on it";
  const auto codec = choice_of(kSimultaneousImpacts);
  impacts.schema = codec.schema;
  impacts.read = [codec](Reading& r, const Value& v, Scene& out) {
    std::string word;
    codec.read(r, v, word);
    const auto at = std::find(kSimultaneousImpacts.begin(), kSimultaneousImpacts.end(), word);
    out.simultaneous_impacts = static_cast<SimultaneousImpacts>(1 + (at - kSimultaneousImpacts.begin()));
  };
  impacts.write = [](const Scene&, const Scene& from) {
    if (from.simultaneous_impacts == SimultaneousImpacts::unspecified) return Value();
    return Value(kSimultaneousImpacts[static_cast<std::size_t>(from.simultaneous_impacts) - 1]);
  };
  return impacts;
}

const Keys<Scene>& world_keys() {
  static const Keys<Scene> keys = {
      key<Scene>("gravity_m_per_s2", &Scene::gravity_m_per_s2, vector3(), "uniform gravity [m/s^2]; 0 unless given"),
      simultaneous_impacts_key()};
  return keys;
}

Value material_schema(Form form) { return object_schema(material_keys(), form); }

std::vector<Key<FileDraft>> parts() {
  Key<FileDraft> world;
  world.name = "world";
  world.doc = "what acts everywhere";
  world.schema = object_schema(world_keys(), Form::file);
  world.read = [](Reading& r, const Value& v, FileDraft& out) {
    within(r, "[world]", [&] { read_table(r, v, world_keys(), {}, out.scenario.scene); });
  };
  // Not kept: reports read it from the file (named_metric.hpp).
  Key<FileDraft> metric;
  metric.name = "metric";
  metric.doc = "the metric that the scene is about, with which reports open it; they choose one unless it is given";
  metric.schema = kebab_text().schema;
  metric.read = [](Reading& r, const Value& v, FileDraft&) {
    std::string name;
    kebab_text().read(r, v, name);
  };
  Key<FileDraft> problem;
  problem.name = "problem";
  problem.doc = "a bare system of equations in place of [world] and bodies";
  problem.schema = choice_of({"lorenz"}).schema;
  problem.read = [](Reading& r, const Value& v, FileDraft& out) {
    choice_of({"lorenz"}).read(r, v, out.scenario.scene.problem);
  };
  Key<FileDraft> initial;
  initial.name = "initial_state";
  initial.doc = "where a bare problem starts; [1, 0, 0] unless given";
  initial.schema = vector3().schema;
  initial.read = [](Reading& r, const Value& v, FileDraft& out) { vector3().read(r, v, out.initial_state.emplace()); };
  return {
      required(later("run", &FileDraft::run, object_schema(run_keys(), Form::file),
                     "a table [run] with t_end_s, steps and samples")),
      metric,
      problem,
      initial,
      world,
      later("material", &FileDraft::material,
            table_of({{"type", "object"}, {"additionalProperties", material_schema(Form::file)}}),
            "[material.NAME] tables"),
      later("contact", &FileDraft::contact, array_of(object_schema(contact_keys(), Form::file)),
            "laws of pairs of materials"),
      later("body", &FileDraft::body, array_of(object_schema(body_keys(), Form::file)), "the bodies"),
      later("grid", &FileDraft::grid, array_of(object_schema(grid_keys(), Form::file)),
            "copies of a body in a grid, in its place"),
      later("joint", &FileDraft::joint, array_of(object_schema(joint_keys(), Form::file)),
            "what ties two bodies together, or a body to the world"),
      later("rope", &FileDraft::rope, array_of(object_schema(rope_keys(), Form::file)),
            "inextensible ropes between bodies, over fixed points and pulleys"),
      later("force", &FileDraft::force, array_of(reference("#/$defs/force")), "the forces"),
      later("domain", &FileDraft::domain, object_schema(domain_keys(), Form::file), "the space of fluids"),
      later("fluid", &FileDraft::fluid, array_of(object_schema(fluid_keys(), Form::file)), "the fluids"),
      later("fluid_boundary", &FileDraft::fluid_boundary, array_of(object_schema(fluid_boundary_keys(), Form::file)),
            "bodies whose surfaces bound the fluids"),
      later("probe", &FileDraft::probe, array_of(object_schema(fluid_probe_keys(), Form::file)),
            "what is measured of the fluids"),
  };
}

template <class T> void read_list(Reading& r, const Value& v, const std::string& what, T each) {
  const auto* items = v.list();
  if (!items) fail_value(r, v, "a list");
  for (std::size_t i = 0; i < items->size(); ++i)
    within(r, what + "[" + std::to_string(i) + "]", [&] { each((*items)[i]); });
}

void read_pair(Reading& r, const Value& v, Scene& scene) {
  PairLaw law;
  read_table(r, v, pair_keys(), {}, law);
  check_contact_law(r, v, law);
  for (const PairLaw& earlier : scene.pairs)
    if (earlier.a == law.a && earlier.b == law.b)
      fail(r, v.location, "found a pair of materials a second time in " + r.where + "; expected it once");
  scene.pairs.push_back(law);
}

template <class Item, class Write> Value list_value(const std::vector<Item>& items, Write write) {
  Value::List out;
  out.reserve(items.size());
  for (const Item& item : items) out.push_back(write(item));
  return out;
}

template <class Write>
Key<Scene> part_of_scene(std::string name, std::string doc, Value schema,
                         std::function<void(Reading&, const Value&, Scene&)> read, Write write) {
  Key<Scene> k;
  k.name = std::move(name), k.doc = std::move(doc), k.schema = std::move(schema), k.read = std::move(read);
  k.write = [write](const Scene& s, const Scene&) { return write(s); };
  return k;
}

BodyDraft draft_of(const Body& body) {
  BodyDraft draft;
  static_cast<Body&>(draft) = body;
  draft.inertia = body.inertia_kg_m2;
  return draft;
}

template <class T> Value written(const Scene& scene, const T& from, const Keys<T>& keys) {
  Value table{Value::Table{}};
  write_table(scene, from, keys, table);
  return table;
}

// Parts that only scenes with fluids have.
Key<Scene> domain_key() {
  Key<Scene> k;
  k.name = "domain", k.doc = "the space of fluids; absent without fluids";
  k.schema = object_schema(domain_keys(), Form::resolved);
  k.read = [](Reading& r, const Value& v, Scene& out) {
    within(r, "domain", [&] { read_table(r, v, domain_keys(), {}, out.domain); });
  };
  k.write = [](const Scene& s, const Scene& from) {
    return from.fluids.empty() ? Value() : written(s, from.domain, domain_keys());
  };
  return k;
}

// Parts that only scenes with mechanisms have. `read` appends to the scene that is being read.
template <class T>
Key<Scene> mechanism_part(std::string name, std::string doc, std::vector<T> Scene::*member, Value item_schema,
                          void (*read)(Reading&, const Value&), Value (*write)(const Scene&, const T&)) {
  Key<Scene> k;
  k.name = std::move(name), k.doc = std::move(doc), k.schema = array_of(std::move(item_schema));
  k.read = [read](Reading& r, const Value& v, Scene&) { read(r, v); };
  k.write = [member, write](const Scene& s, const Scene& from) {
    if ((from.*member).empty()) return Value();
    return list_value(from.*member, [&](const T& one) { return write(s, one); });
  };
  return k;
}

template <class T, class Check>
Key<Scene> fluid_part(std::string name, std::string doc, std::vector<T> Scene::*member, const Keys<T>& keys,
                      Check check) {
  Key<Scene> k;
  k.name = name, k.doc = std::move(doc), k.schema = array_of(object_schema(keys, Form::resolved));
  k.read = [name, member, &keys, check](Reading& r, const Value& v, Scene& out) {
    read_list(r, v, name, [&](const Value& item) {
      T one;
      read_table(r, item, keys, {}, one);
      check(r, item, one);
      (out.*member).push_back(std::move(one));
    });
  };
  k.write = [member, &keys](const Scene& s, const Scene& from) {
    if ((from.*member).empty()) return Value();
    return list_value(from.*member, [&](const T& one) { return written(s, one, keys); });
  };
  return k;
}

}  // namespace

void add_material(Reading& r, SourceLocation location, Material material) {
  if (r.scene->materials.size() >= kMaxMaterials)
    fail(r, location, "found more than " + std::to_string(kMaxMaterials) + " materials; expected fewer");
  const auto index = static_cast<int>(r.scene->materials.size());
  if (!r.materials.emplace(material.name, index).second)
    fail(r, location, "found the material `" + material.name + "` a second time; expected each name once");
  r.scene->materials.push_back(std::move(material));
}

namespace {

constexpr std::size_t kMaxCorners = 1 << 20;

// What each copy of the shape takes memory for.
std::size_t corners_of(const Shape& shape) {
  if (const auto* convex = std::get_if<Convex>(&shape)) return convex->points_m.size();
  if (const auto* mesh = std::get_if<Mesh>(&shape)) return mesh->points_m.size() + mesh->triangles.size();
  if (const auto* compound = std::get_if<Compound>(&shape)) return compound->boxes.size();
  return 0;
}

}  // namespace

void add_body(Reading& r, SourceLocation location, Body body) {
  if (r.scene->bodies.size() >= kMaxBodies)
    fail(r, location, "found more than " + std::to_string(kMaxBodies) + " bodies; expected fewer");
  if (r.corners += corners_of(body.shape); r.corners > kMaxCorners)
    fail(r, location,
         "found bodies whose shapes have more than " + std::to_string(kMaxCorners) +
             " points, triangles and boxes together; expected fewer");
  const auto index = static_cast<int>(r.scene->bodies.size());
  if (!r.bodies.emplace(body.name, index).second)
    fail(r, location, "two [[body]] tables have the name `" + body.name + "`; expected unique names");
  r.scene->bodies.push_back(std::move(body));
}

void require_few(Reading& r, const Value* tables, const std::string& where, std::size_t most) {
  const auto* items = tables ? tables->list() : nullptr;
  if (items && items->size() > most)
    fail(r, (*items)[most].location, "found more than " + std::to_string(most) + " of " + where + "; expected fewer");
}

const Keys<GridDraft>& grid_keys() {
  static const Keys<GridDraft> keys = {
      required(key<GridDraft>("body", &GridDraft::body, text(), "the [[body]] to copy")),
      required(
          key<GridDraft>("counts", &GridDraft::counts, list_of(integer(1, kMaxBodies), 3), "how many along x, y, z")),
      required(
          key<GridDraft>("spacing_m", &GridDraft::spacing_m, vector3(), "distance of neighbours along x, y, z [m]")),
      key<GridDraft>("jitter_m", &GridDraft::jitter_m, number(non_negative()),
                     "largest random offset along each axis [m]; 0 unless given"),
      key<GridDraft>("seed", &GridDraft::seed, integer(0, INT64_MAX), "of SplitMix64; 0 unless given"),
  };
  return keys;
}

const Keys<FileDraft>& file_keys() {
  static const Keys<FileDraft> keys = [] {
    Keys<FileDraft> all = shared_keys<FileDraft>([](FileDraft& d) -> Scenario& { return d.scenario; });
    for (auto& part : parts()) all.push_back(std::move(part));
    return all;
  }();
  return keys;
}

const Keys<Scene>& scene_keys() {
  static const Keys<Scene> keys = {
      key<Scene>("problem", &Scene::problem, text(), "name of a bare system of equations, or empty"),
      key<Scene>("gravity_m_per_s2", &Scene::gravity_m_per_s2, vector3(), "uniform gravity [m/s^2]"),
      simultaneous_impacts_key(),
      required(part_of_scene(
          "materials", "the materials", array_of(material_schema(Form::resolved)),
          [](Reading& r, const Value& v, Scene&) {
            read_list(r, v, "materials", [&](const Value& item) {
              Material material;
              read_table(r, item, material_keys(), {}, material);
              add_material(r, item.location, std::move(material));
            });
          },
          [](const Scene& s) {
            return list_value(s.materials, [&](const Material& m) { return written(s, m, material_keys()); });
          })),
      required(part_of_scene(
          "pairs", "the law of every pair of materials", array_of(object_schema(pair_keys(), Form::resolved)),
          [](Reading& r, const Value& v, Scene& out) {
            read_list(r, v, "pairs", [&](const Value& item) { read_pair(r, item, out); });
          },
          [](const Scene& s) {
            return list_value(s.pairs, [&](const PairLaw& p) { return written(s, p, pair_keys()); });
          })),
      required(part_of_scene(
          "bodies", "the bodies", array_of(object_schema(body_keys(), Form::resolved)),
          [](Reading& r, const Value& v, Scene&) {
            read_list(r, v, "bodies", [&](const Value& item) {
              BodyDraft body;
              read_table(r, item, body_keys(), {}, body);
              finish_body(r, item, body);
              add_body(r, item.location, std::move(body));
            });
          },
          [](const Scene& s) {
            return list_value(s.bodies, [&](const Body& b) { return written(s, draft_of(b), body_keys()); });
          })),
      mechanism_part<Joint>(
          "joints", "the joints; absent where there are none", &Scene::joints,
          object_schema(joint_keys(), Form::resolved), read_resolved_joints,
          [](const Scene& s, const Joint& joint) { return written(s, draft_of(joint), joint_keys()); }),
      mechanism_part<Rope>("ropes", "the ropes; absent where there are none", &Scene::ropes,
                           object_schema(rope_keys(), Form::resolved), read_resolved_ropes,
                           [](const Scene& s, const Rope& rope) { return written(s, rope, rope_keys()); }),
      part_of_scene(
          "forces", "the forces", array_of(force_schema(Form::resolved)),
          [](Reading& r, const Value& v, Scene&) {
            read_list(r, v, "forces", [&](const Value& item) { add_force(r, item.location, read_force(r, item)); });
          },
          [](const Scene& s) { return list_value(s.forces, [&](const Force& f) { return write_force(s, f); }); }),
      mechanism_part<JointForce>(
          "joint_forces", "springs, dampers and torques along joints; absent where there are none",
          &Scene::joint_forces, table_of({{"oneOf", joint_force_schemas(Form::resolved)}}),
          [](Reading& r, const Value& v) {
            read_list(r, v, "joint_forces", [&](const Value& item) { add_joint_force(r, item); });
          },
          write_joint_force),
      domain_key(),
      fluid_part<Fluid>("fluids", "the fluids, with their particles", &Scene::fluids, fluid_keys(), check_fluid),
      fluid_part<FluidBoundary>("fluid_boundaries", "bodies whose surfaces bound the fluids", &Scene::fluid_boundaries,
                                fluid_boundary_keys(), check_boundary),
      fluid_part<FluidProbe>("probes", "what is measured of the fluids", &Scene::probes, fluid_probe_keys(),
                             check_probe),
  };
  return keys;
}

Scene read_resolved_scene(Reading& r, const Value& v) {
  Scene scene;
  r.scene = &scene;
  r.has_fluids = v.find("fluids") != nullptr;
  within(r, "the scene", [&] { read_table(r, v, scene_keys(), {}, scene); });
  if (r.has_fluids) check_sliding_walls(r, v.location);
  if (scene.materials.empty()) fail(r, v.location, "found no material in the scene; expected at least one");
  const std::size_t n = scene.materials.size();
  if (scene.pairs.size() != n * (n + 1) / 2)
    fail(r, v.location,
         "found " + std::to_string(scene.pairs.size()) + " pairs of " + std::to_string(n) + " materials; expected " +
             std::to_string(n * (n + 1) / 2));
  return scene;
}

Value write_scene(const Scene& scene) { return written(scene, scene, scene_keys()); }

const Keys<Scenario>& scenario_keys() {
  static const Keys<Scenario> keys = [] {
    Keys<Scenario> all = shared_keys<Scenario>([](Scenario& s) -> Scenario& { return s; });
    Key<Scenario> run, scene;
    run.name = "run", run.doc = "end, ladder and samples", run.required = true;
    run.schema = object_schema(run_keys(), Form::resolved);
    run.read = [](Reading& r, const Value& v, Scenario& out) {
      within(r, "[run]", [&] {
        read_table(r, v, run_keys(), {}, out);
        check_run(r, v, out);
      });
    };
    run.write = [](const Scene& s, const Scenario& from) { return written(s, from, run_keys()); };
    scene.name = "scene", scene.doc = "the resolved scene", scene.required = true;
    scene.schema = reference("#/$defs/resolved_scene");
    scene.read = [](Reading& r, const Value& v, Scenario& out) { out.scene = read_resolved_scene(r, v); };
    scene.write = [](const Scene& s, const Scenario&) { return write_scene(s); };
    all.push_back(std::move(run));
    all.push_back(std::move(scene));
    return all;
  }();
  return keys;
}

}  // namespace atwood

// From the contents of a file to a resolved scene: pair laws are tabulated, grids expanded, names converted to indices.
#include <cmath>

#include "scene/fluid_keys.hpp"
#include "scene/joint_keys.hpp"
#include "scene/scenario_keys.hpp"
#include "scene/split_mix.hpp"

namespace atwood {
namespace {

void resolve_materials(Reading& r, const FileDraft& draft) {
  const Value::Table none;
  const Value::Table* tables = &none;
  if (draft.material) {
    r.where = "[material]";
    tables = draft.material->table();
    if (!tables) fail_value(r, *draft.material, "tables [material.NAME]");
  }
  // Index 0 is the material of bodies without `material`.
  Material otherwise{"default", 0, 0, 0};
  bool declared = false;
  for (const Member& member : *tables) declared = declared || member.key == otherwise.name;
  if (!declared) add_material(r, {}, otherwise);
  for (const bool first : {true, false})
    for (const Member& member : *tables) {
      if ((member.key == otherwise.name) != first) continue;
      r.where = "[material." + member.key + "]";
      r.key.clear();
      Material material;
      read_table(r, member.value, material_keys(), {}, material);
      r.key = "name";
      Value name(member.key);
      name.location = member.location;
      name_text().read(r, name, material.name);
      add_material(r, member.location, std::move(material));
    }
}

// Exact for equal values, also if the product overflows or underflows.
double geometric_mean(double a, double b) { return a == b ? a : std::sqrt(a) * std::sqrt(b); }

void resolve_pairs(Reading& r, const FileDraft& draft) {
  Scene& scene = *r.scene;
  for (std::size_t a = 0; a < scene.materials.size(); ++a)
    for (std::size_t b = a; b < scene.materials.size(); ++b) {
      const Material &m = scene.materials[a], &n = scene.materials[b];
      scene.pairs.push_back({static_cast<int>(a), static_cast<int>(b), geometric_mean(m.restitution, n.restitution),
                             geometric_mean(m.friction, n.friction),
                             geometric_mean(m.rolling_friction_m, n.rolling_friction_m)});
    }
  std::vector<bool> given(scene.pairs.size());
  each_table(r, draft.contact, "[[contact]]", [&](const Value& table) {
    ContactDraft contact;
    read_table(r, table, contact_keys(), {}, contact);
    check_contact_law(r, table, contact.compliance);
    const auto a = static_cast<std::size_t>(std::min(contact.a, contact.b));
    const auto b = static_cast<std::size_t>(std::max(contact.a, contact.b));
    const std::size_t i = a * (2 * scene.materials.size() - a + 1) / 2 + b - a;  // of the upper triangle, row by row
    PairLaw& law = scene.pairs[i];
    if (given[i])
      fail(r, table.find("between")->location,
           "found a pair of materials a second time in [[contact]]; expected each pair once");
    given[i] = true;
    PairLaw made = contact.compliance;
    made.a = law.a, made.b = law.b;
    made.restitution = contact.restitution.value_or(law.restitution);
    made.friction = contact.friction.value_or(law.friction);
    made.rolling_friction_m = contact.rolling_friction_m.value_or(law.rolling_friction_m);
    law = made;
  });
}

struct WrittenGrid {
  GridDraft grid;
  const Value* table;
};

std::vector<WrittenGrid> read_grids(Reading& r, const FileDraft& draft) {
  std::vector<WrittenGrid> grids;
  std::size_t copies = 0;
  require_few(r, draft.grid, "[[grid]]", kMaxTables);
  each_table(r, draft.grid, "[[grid]]", [&](const Value& table) {
    GridDraft grid;
    read_table(r, table, grid_keys(), {}, grid);
    const Value& counts = *table.find("counts");
    r.key = "counts";
    if (grid.counts.size() != 3) fail_value(r, counts, "a list of 3 whole numbers");
    std::size_t product = 1;  // each factor is at most kMaxBodies, so no step overflows
    for (const std::int64_t n : grid.counts) {
      product *= static_cast<std::size_t>(n);
      if (product > kMaxBodies || copies + product > kMaxBodies)
        fail(r, counts.location,
             "`counts` in [[grid]] makes more than " + std::to_string(kMaxBodies) + " bodies; expected fewer");
    }
    copies += product;
    for (const WrittenGrid& earlier : grids)
      if (earlier.grid.body == grid.body)
        fail(r, table.find("body")->location, "found a second [[grid]] of the body `" + grid.body + "`; expected one");
    grids.push_back({std::move(grid), &table});
  });
  return grids;
}

// The copies replace the body, with x as the slowest index; each uses three random numbers, in the order x, y, z.
void expand(Reading& r, const WrittenGrid& written, const Body& body) {
  const GridDraft& grid = written.grid;
  SplitMix64 random{static_cast<std::uint64_t>(grid.seed)};
  const auto first = static_cast<int>(r.scene->bodies.size());
  for (std::int64_t i = 0; i < grid.counts[0]; ++i)
    for (std::int64_t j = 0; j < grid.counts[1]; ++j)
      for (std::int64_t k = 0; k < grid.counts[2]; ++k) {
        Body copy = body;
        copy.name += "." + std::to_string(i) + "." + std::to_string(j) + "." + std::to_string(k);
        const std::array<std::int64_t, 3> at{i, j, k};
        for (std::size_t axis = 0; axis < 3; ++axis) {
          copy.position_m[axis] += static_cast<double>(at[axis]) * grid.spacing_m[axis];
          copy.position_m[axis] += grid.jitter_m * (2 * random.next_unit() - 1);
          if (!std::isfinite(copy.position_m[axis]))
            fail(r, written.table->location,
                 "found a [[grid]] whose positions overflow; expected a smaller spacing or jitter");
        }
        add_body(r, written.table->location, std::move(copy));
      }
  r.grids[body.name] = {first, static_cast<int>(r.scene->bodies.size()) - first};
}

void resolve_bodies(Reading& r, const Value& document, const FileDraft& draft) {
  const std::vector<WrittenGrid> grids = read_grids(r, draft);
  std::vector<bool> used(grids.size());
  std::vector<std::string> names;
  each_table(r, draft.body, "[[body]]", [&](const Value& table) {
    if (const Value* name = table.find("name"); name && name->text()) r.where += " `" + *name->text() + "`";
    BodyDraft body;
    read_table(r, table, body_keys(), {}, body);
    finish_body(r, table, body);
    names.push_back(body.name);
    bool copied = false;
    for (std::size_t g = 0; g < grids.size(); ++g)
      if (grids[g].grid.body == body.name) {
        if (used[g])
          fail(r, table.find("name")->location,
               "found the name `" + body.name + "` a second time; expected each name once");
        copied = used[g] = true;
        expand(r, grids[g], body);
      }
    if (!copied) add_body(r, table.find("name")->location, std::move(body));
  });
  for (std::size_t g = 0; g < grids.size(); ++g)
    if (!used[g]) {
      const Value& at = *grids[g].table->find("body");
      fail(r, at.location,
           "`body` in [[grid]] is " + describe(at) + "; expected the name of a [[body]]" +
               did_you_mean(grids[g].grid.body, names));
    }
  if (r.scene->bodies.empty() && !draft.fluid)
    fail(r, document.location, "found no [[body]]; expected at least one, or `problem`, or a [[fluid]]");
}

// Position: the three unknowns. Velocity: their rates, Lorenz 1963 with sigma = 10, rho = 28, beta = 8/3.
void resolve_problem(Reading& r, const Value& document, const FileDraft& draft) {
  for (const char* other : {"world", "material", "contact", "body", "grid", "force", "joint", "rope", "fluid"})
    if (const Value* value = document.find(other))
      fail(r, value->location,
           std::string("found `") + other + "` beside `problem`; expected neither world nor bodies nor forces");
  Body body;
  body.name = r.scene->problem;
  body.mass_kg = 1;
  body.position_m = draft.initial_state.value_or(Real3{1, 0, 0});
  const auto [x, y, z] = body.position_m;
  body.velocity_m_per_s = {10 * (y - x), x * (28 - z) - y, x * y - 8 * z / 3};
  for (const double rate : body.velocity_m_per_s)
    if (!std::isfinite(rate))
      fail(r, document.find("initial_state")->location,
           "`initial_state` has rates that overflow; expected a smaller state");
  add_body(r, document.location, std::move(body));
}

}  // namespace

void resolve(Reading& r, const Value& document, FileDraft& draft) {
  r.scene = &draft.scenario.scene;
  r.where = "[run]";
  r.key.clear();
  read_table(r, *draft.run, run_keys(), {}, draft.scenario);
  check_run(r, *draft.run, draft.scenario);
  resolve_materials(r, draft);
  resolve_pairs(r, draft);
  if (!draft.scenario.scene.problem.empty()) return resolve_problem(r, document, draft);
  if (const Value* state = document.find("initial_state"))
    fail(r, state->location, "found `initial_state` without `problem`; expected it with a bare problem only");
  r.has_fluids = draft.fluid != nullptr;
  resolve_bodies(r, document, draft);
  resolve_mechanisms(r, draft);
  each_table(r, draft.force, "[[force]]", [&](const Value& table) {
    if (is_joint_force(table)) add_joint_force(r, table);
    else read_forces(r, table);
  });
  resolve_fluids(r, document, draft);
  if (draft.scenario.truth.kind == TruthKind::values)
    check_values_file(r, *document.find("truth")->find("file"), draft.scenario);
}

}  // namespace atwood

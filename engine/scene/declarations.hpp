// What a scene is made of, declared once: the keys of materials, contacts, bodies, shapes and forces.
#pragma once

#include <optional>

#include "scene/keys.hpp"

namespace atwood {

// One member of a variant: the shapes by their key, the forces by `kind` (and `model`).
struct Tag {
  std::string key, value;
};
template <class V> struct Alternative {
  std::string name, doc;
  std::vector<Tag> tags;
  std::function<void(Reading&, const Value&, V&)> read;
  std::function<bool(const V&)> holds;
  std::function<void(const Scene&, const V&, Value& table)> write;
  std::function<Value(Form)> schema;
};

// A body as it is written: what follows from other keys is kept apart from what was given.
struct BodyDraft : Body {
  std::optional<double> density_kg_per_m3;
  std::optional<Real33> inertia;
};

// Coefficients left out follow from the combination rule.
struct ContactDraft {
  int a = 0, b = 0;
  std::optional<double> restitution, friction, rolling_friction_m;
  PairLaw compliance;  // only its contact law and that law's numbers
};

const Keys<Material>& material_keys();
const Keys<ContactDraft>& contact_keys();
const Keys<PairLaw>& pair_keys();
// A contact law has its own numbers and no other's.
void check_contact_law(Reading& r, const Value& table, const PairLaw& law);
const Keys<BodyDraft>& body_keys();
const std::vector<Alternative<Shape>>& shapes();
const std::vector<Alternative<Force>>& forces();

// The intervals under `on_s` of a force are in order and apart.
void check_intervals(const Reading& r, const Value& table, const std::vector<Interval>& on_s);

// Checks of a body that span keys; mass and inertia from density and shape when a file leaves them out.
void finish_body(Reading& r, const Value& table, BodyDraft& body);

Shape read_shape(Reading& r, const Value& v);
Force read_force(Reading& r, const Value& v);
// Adds a force to the scene. Throws InputError past the number of forces (with those of joints), of the bodies that all
// of them name, or of the intervals in which they act.
void add_force(Reading& r, SourceLocation location, Force force);
// Fails where the scene has as many forces as it may have; counts the intervals of one more.
void count_force(Reading& r, SourceLocation location, std::size_t intervals);
// Of a [[force]] of a file: one, or one for each body where a force of a single body (a thruster) names several.
void read_forces(Reading& r, const Value& table);
Value write_force(const Scene& scene, const Force& force);
Value shape_schema(Form form);
Value force_schema(Form form);

// Fills points and triangles from an OBJ file inside the scene's folder.
void load_mesh(Reading& r, const Value& file, Mesh& mesh);
// A table of a truth's values has the columns that its bodies need, each with its bar, and at least one row.
void check_values_file(Reading& r, const Value& file, const Scenario& scenario);
// The full path of a `file` key: it exists and lies inside the scene's folder, links followed.
std::string path_in_folder(Reading& r, const Value& file);

}  // namespace atwood

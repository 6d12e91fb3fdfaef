#include "forces/gravity_many.hpp"

#include "forces/gravity_tree.hpp"
#include "parallel/team.hpp"

namespace atwood {
namespace {

constexpr std::int64_t kMinSharedInteractions = 1 << 16;  // interactions: some 25 us

// The arrays are the term's working memory, so that a step allocates nothing. Only one thread at a time evaluates a
// model's rates.
template <class S> struct ManyBodyGravity final : ForceTerm<S> {
  std::vector<int> bodies;
  std::vector<S> Gm;
  S softening2{};
  VectorWidth width = widest_vectors();
  Team* team = nullptr;
  S opening{};
  mutable std::unique_ptr<GravityTree<S>> tree;  // null: direct sums
  mutable std::vector<S> room;  // x y z of the bodies, then their accelerations: six arrays of whole blocks

  void add_loads(const Motion<S>& motion, Load<S>* loads) const override {
    const int count = static_cast<int>(bodies.size()), padded = whole_blocks(count) * kGravityBlock;
    S* const x = room.data();
    S *const y = x + padded, *const z = y + padded;
    const Accelerations<S> sums{z + padded, z + 2 * padded, z + 3 * padded};
    for (int i = 0; i < count; ++i) {
      const Vec3<S> p = motion.p_WB(bodies[i]), a = loads[bodies[i]].acceleration_W;
      x[i] = p.x, y[i] = p.y, z[i] = p.z;
      sums.x[i] = a.x, sums.y[i] = a.y, sums.z[i] = a.z;
    }
    const PointMasses<S> masses{x, y, z, Gm.data()};
    if (tree != nullptr) tree->add_gravity(width, masses, softening2, opening, team, sums);
    else sum_directly(masses, count, sums);
    for (int i = 0; i < count; ++i) loads[bodies[i]].acceleration_W = {sums.x[i], sums.y[i], sums.z[i]};
  }

  void sum_directly(const PointMasses<S>& masses, int count, const Accelerations<S>& sums) const {
    const auto part = [&](int p, int parts) {
      const Share blocks = share(whole_blocks(count), p, parts);
      add_gravity(width, masses, 0, count, softening2, blocks.first, blocks.last, sums);
    };
    if (team == nullptr) part(0, 1);
    else team->run(std::int64_t(count) * count >= kMinSharedInteractions, [&](int p) { part(p, team->size()); });
  }
};

}  // namespace

template <class S>
TermPointer<S> make_many_body_gravity(const MutualGravity& force, const Scene& scene, const GravityOptions& options) {
  if constexpr (has_vector_lanes<S>) {
    const int count = static_cast<int>(force.bodies.size());
    const bool tree = options.sum == GravityOptions::Sum::tree ||
                      (options.sum == GravityOptions::Sum::automatic && count > kDirectBodies);
    if (count < kManyBodies && !(tree && count > 0)) return nullptr;
    auto term = std::make_unique<ManyBodyGravity<S>>();
    term->bodies = force.bodies;
    for (const int i : force.bodies) term->Gm.push_back(S(force.constant_m3_per_kg_s2) * S(scene.bodies[i].mass_kg));
    term->softening2 = S(force.softening_m) * S(force.softening_m);
    term->team = options.team;
    term->opening = S(options.opening);
    if (tree) term->tree = std::make_unique<GravityTree<S>>(count, options.team == nullptr ? 1 : options.team->size());
    term->room.resize(std::size_t(6) * whole_blocks(count) * kGravityBlock);
    return term;
  } else {
    if (options.sum == GravityOptions::Sum::tree)
      throw Unsupported{"atwood sums gravity by a tree in float and double only"};
    return nullptr;
  }
}

template TermPointer<float> make_many_body_gravity(const MutualGravity&, const Scene&, const GravityOptions&);
template TermPointer<double> make_many_body_gravity(const MutualGravity&, const Scene&, const GravityOptions&);
template TermPointer<long double> make_many_body_gravity(const MutualGravity&, const Scene&, const GravityOptions&);
template TermPointer<Quad> make_many_body_gravity(const MutualGravity&, const Scene&, const GravityOptions&);

}  // namespace atwood

#include "rigid/model.hpp"

#include <algorithm>
#include <cmath>

#include "joints/constraints.hpp"
#include "rigid/bare_problems.hpp"
#include "rigid/joint_rates.hpp"

namespace atwood {
namespace {

constexpr int kPointSize = 6, kRotatingSize = kBodyScalars;

// I^-1 by cofactors over the determinant: row i is the cross product of the other two columns (I is symmetric).
template <class S> MassProperties<S> mass_properties(const Body& body) {
  MassProperties<S> m;
  if (body.fixed) return m;
  m.mass_kg = S(body.mass_kg);
  m.inverse_mass_per_kg = S(1) / m.mass_kg;
  if (!rotates(body)) return m;
  const auto& I = body.inertia_kg_m2;
  for (int i = 0; i < 3; ++i) m.I_row[i] = {S(I[3 * i]), S(I[3 * i + 1]), S(I[3 * i + 2])};
  m.diagonal = I[1] == 0 && I[2] == 0 && I[3] == 0 && I[5] == 0 && I[6] == 0 && I[7] == 0;
  if (m.diagonal) {
    m.I_inverse_row[0].x = S(1) / m.I_row[0].x;
    m.I_inverse_row[1].y = S(1) / m.I_row[1].y;
    m.I_inverse_row[2].z = S(1) / m.I_row[2].z;
  } else {
    const S determinant = dot(m.I_row[0], cross(m.I_row[1], m.I_row[2]));
    for (int i = 0; i < 3; ++i)
      m.I_inverse_row[i] = (S(1) / determinant) * cross(m.I_row[(i + 1) % 3], m.I_row[(i + 2) % 3]);
  }
  m.principal = principal_axes<S>(I);
  return m;
}

bool is_on(const std::vector<Interval>& on_s, double t_s) {
  return on_s.empty() ||
         std::any_of(on_s.begin(), on_s.end(), [&](const Interval& i) { return i.from_s <= t_s && t_s < i.to_s; });
}

}  // namespace

template <class S>
RigidModel<S>::RigidModel(const Scene& scene, const ModelOptions& options)
    : team_(options.threads > 1 ? std::make_unique<Team>(options.threads) : nullptr),
      project_constraints_(options.project_constraints), gravity_(narrow3<S>(scene.gravity_m_per_s2)),
      conservative_(scene), series_forces_(scene) {
  system_.context = this;
  build_bodies(scene);
  if (!scene.problem.empty()) {
    bare_problem_ = true;
    system_.rate_of = bare_problem_rate<S>(scene.problem);
    if (system_.rate_of == nullptr) unsupported_ = "atwood has no equations for problem `" + scene.problem + "`";
    system_.size = state_size_ = 3;
    moving_.push_back(0);
    return;
  }
  try {
    GravityOptions gravity = options.gravity;
    gravity.team = team_.get();
    build_forces(scene, gravity);
  } catch (const Unsupported& u) {
    unsupported_ = u.reason;
  }
  system_.rate_of = &RigidModel::rate_of;
  system_.rates_of = &RigidModel::rates_of;
  if (!scene.joints.empty() || !scene.ropes.empty()) build_joints(scene);
  system_.size = state_size_;
  one_.resize(2 * static_cast<std::size_t>(state_size_));
  select_interval(S(0), S(0));
  const auto turns = [](const Slot<S>& s) { return s.rotates && s.offset >= 0; };
  const auto is_ball = [](const Joint& j) { return j.kind == JointKind::ball && !j.closes_loop; };
  if (std::any_of(slots_.begin(), slots_.end(), turns) ||
      std::any_of(scene.joints.begin(), scene.joints.end(), is_ball) || constraints_ != nullptr) {
    system_.project_of = &RigidModel::project_of;
    system_.projection_of = &RigidModel::projection_of;
  }
}

template <class S> RigidModel<S>::~RigidModel() = default;

template <class S> void RigidModel<S>::build_bodies(const Scene& scene) {
  const std::size_t count = scene.bodies.size();
  resting_.resize(count * kRotatingSize);
  loads_.resize(count);
  placed_.resize(scene.joints.empty() ? 0 : count * kRotatingSize);
  std::vector<char> placed(count, 0);
  for (const Joint& joint : scene.joints)
    if (!joint.closes_loop) placed[joint.child] = 1;
  load_lanes_.resize(count * kLoadScalars);
  moving_.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const Body& body = scene.bodies[i];
    Slot<S> slot;
    slot.rotates = atwood::rotates(body) || body.fixed;  // a fixed body has an attitude too
    if (!body.fixed && !(body.mass_kg > 0) && scene.problem.empty())
      unsupported_ = "a body that moves needs a mass: `" + body.name + "` has none";
    if (placed[i]) {
      slot.on_joint = true;
      slot.resting = placed_.data() + i * kRotatingSize;
      on_joints_.push_back(static_cast<int>(i));
    } else if (!body.fixed) {
      slot.offset = state_size_;
      state_size_ += slot.rotates ? kRotatingSize : kPointSize;
    }
    BodyState<S> start{narrow3<S>(body.position_m),
                       narrow3<S>(body.velocity_m_per_s),
                       {},
                       narrow3<S>(body.angular_velocity_body_rad_per_s)};
    const Real4& q = body.orientation_wxyz;  // of unit length to round-off of double; normalised again in S
    start.q_WB = normalised(Quat<S>{S(q[0]), S(q[1]), S(q[2]), S(q[3])});
    S* rest = resting_.data() + i * kRotatingSize;
    store3(start.p_WB, rest + kAtPosition);
    store4(start.q_WB, rest + kAtAttitude);
    initial_.push_back(start);
    slots_.push_back(slot);
    mass_.push_back(mass_properties<S>(body));
    release_s_.push_back(body.release_s);
    if (!body.fixed && body.release_s > 0) switch_times_s_.push_back(body.release_s);
  }
  resting_lanes_.resize(resting_.size() + kRotatingSize);  // and a body at the origin with identity attitude
  for (std::size_t i = 0; i < resting_.size(); ++i)
    std::fill(resting_lanes_[i].lane, resting_lanes_[i].lane + kLaneCount, resting_[i]);
  LaneBlock<S>& identity_w = resting_lanes_[resting_.size() + kAtAttitude];
  std::fill(identity_w.lane, identity_w.lane + kLaneCount, S(1));
}

template <class S> void RigidModel<S>::build_forces(const Scene& scene, const GravityOptions& gravity) {
  std::vector<Vec3<S>> unused(slots_.size());
  for (const Force& force : scene.forces) {
    terms_.push_back(std::visit(
        [&](const auto& f) {
          if constexpr (std::is_same_v<decltype(f), const MutualGravity&>) return make_term<S>(f, scene, gravity);
          else return make_term<S>(f, scene);
        },
        force));
    velocity_dependent_ = velocity_dependent_ || terms_.back()->velocity_dependent();
    forces_depend_on_velocities_ = velocity_dependent_;
    magnetic_only_ = magnetic_only_ && terms_.back()->add_magnetic(unused.data());
    for (const Interval& on : terms_.back()->on_s)
      for (double t : {on.from_s, on.to_s})
        if (t > 0 && std::isfinite(t)) switch_times_s_.push_back(t);
  }
  active_.reserve(terms_.size());
  std::sort(switch_times_s_.begin(), switch_times_s_.end());
  switch_times_s_.erase(std::unique(switch_times_s_.begin(), switch_times_s_.end()), switch_times_s_.end());
}

template <class S> void RigidModel<S>::add_term(TermPointer<S> term, const std::string& what) {
  velocity_dependent_ = velocity_dependent_ || term->velocity_dependent();
  forces_depend_on_velocities_ = forces_depend_on_velocities_ || term->velocity_dependent();
  magnetic_only_ = magnetic_only_ && !term->velocity_dependent();
  terms_.push_back(std::move(term));
  active_.reserve(terms_.size());
  conservative_.refuse(what);
  series_forces_.refusal = what;
  interval_ = -1;
  select_interval(S(0), S(0));
}

template <class S> int RigidModel<S>::interval_of(S from_s, S to_s) const {
  const double middle_s = static_cast<double>((from_s + to_s) / S(2));
  return static_cast<int>(std::upper_bound(switch_times_s_.begin(), switch_times_s_.end(), middle_s) -
                          switch_times_s_.begin());
}

// The force law is the same between two neighbouring switch times, so only a change of interval rebuilds the lists.
template <class S> void RigidModel<S>::select_interval(S from_s, S to_s) {
  if (interval_ >= 0 && switch_times_s_.empty()) return;
  const double middle_s = static_cast<double>((from_s + to_s) / S(2));
  const int interval = interval_of(from_s, to_s);
  if (interval == interval_) return;
  interval_ = interval;
  ++system_.epoch;
  active_.clear();
  for (const auto& term : terms_)
    if (is_on(term->on_s, middle_s)) active_.push_back(term.get());
  lanes_ = std::all_of(active_.begin(), active_.end(), [](const ForceTerm<S>* term) { return term->has_lanes(); });
  moving_.clear();
  holds_ = false;
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    if (slots_[i].on_joint) continue;
    const bool stands = slots_[i].offset < 0 || middle_s < release_s_[i];
    slots_[i].resting = stands ? resting_.data() + i * kRotatingSize : nullptr;
    if (!stands) moving_.push_back(static_cast<int>(i));
    holds_ = holds_ || (stands && slots_[i].offset >= 0);
    if (tree_ != nullptr) tree_->set_held(static_cast<int>(i), stands);
  }
  if (joint_forces_ != nullptr) joint_forces_->select(middle_s);
  find_components();
}

// What changes at present, apart by how it changes.
template <class S> void RigidModel<S>::find_components() {
  attitudes_.clear();
  plain_.clear();
  for (const int i : moving_) {
    const int at = slots_[i].offset;
    for (int k = at + kAtPosition; k < at + kAtAttitude; ++k) plain_.push_back(k);
    if (!slots_[i].rotates) continue;
    attitudes_.push_back({at + kAtAttitude, at + kAtBodyRate});
    for (int k = at + kAtBodyRate; k < at + kRotatingSize; ++k) plain_.push_back(k);
  }
  if (tree_ == nullptr) return;
  for (const Link<S>& link : tree_->links()) {
    if (link.joint < 0) continue;
    if (link.kind == JointKind::ball) attitudes_.push_back({link.at_q, link.at_u});
    else
      for (int k = 0; k < link.rates; ++k) plain_.push_back(link.at_q + k);
    for (int k = 0; k < link.rates; ++k) plain_.push_back(link.at_u + k);
  }
}

template <class S> void RigidModel<S>::initial_state(S* y) const {
  if (bare_problem_) return store3(initial_[0].p_WB, y);
  for (int i = 0; i < body_count(); ++i) set_body(i, initial_[i], y);
  if (tree_ != nullptr) tree_->initial_state(y);
  if (!start_.empty()) std::copy(start_.begin(), start_.end(), y);
}

template <class S> BodyState<S> RigidModel<S>::body(int body, const S* y) const {
  const Slot<S>& slot = slots_[body];
  if (slot.on_joint) {
    tree_->kinematics(S(0), y, DrivenJoints::from_state);
    S placed[kRotatingSize];
    tree_->write_body(tree_->link_of(body), placed);
    return {load3(placed + kAtPosition), load3(placed + kAtVelocity), load4(placed + kAtAttitude),
            load3(placed + kAtBodyRate)};
  }
  if (slot.offset < 0) return {initial_[body].p_WB, {}, initial_[body].q_WB, {}};
  const S* at = y + slot.offset;
  BodyState<S> state{load3(at + kAtPosition), load3(at + kAtVelocity), initial_[body].q_WB, {}};
  if (slot.rotates) {
    state.q_WB = load4(at + kAtAttitude);
    state.w_WB_B = load3(at + kAtBodyRate);
  }
  return state;
}

template <class S> void RigidModel<S>::set_body(int body, const BodyState<S>& state, S* y) const {
  const Slot<S>& slot = slots_[body];
  if (slot.offset < 0) return;
  S* at = y + slot.offset;
  store3(state.p_WB, at + kAtPosition);
  store3(state.v_WB, at + kAtVelocity);
  if (!slot.rotates) return;
  store4(state.q_WB, at + kAtAttitude);
  store3(state.w_WB_B, at + kAtBodyRate);
}

template <class S> void RigidModel<S>::gyration(std::vector<Vec3<S>>& omega_W) const {
  omega_W.assign(slots_.size(), {});
  for (const ForceTerm<S>* term : active_) term->add_magnetic(omega_W.data());
  for (std::size_t i = 0; i < slots_.size(); ++i) omega_W[i] = mass_[i].inverse_mass_per_kg * omega_W[i];
}

// The state's driven coordinates carry the rounding of their sums: a sample has those of its time, its loops closed
// there.
template <class S> const S* RigidModel<S>::at_driven_coordinates(S t_s, const S* y) {
  if (constraints_ == nullptr || !project_constraints_) return y;
  const auto is_driven = [](const Link<S>& link) { return link.driven; };
  if (std::none_of(tree_->links().begin(), tree_->links().end(), is_driven)) return y;
  std::copy(y, y + state_size_, projected_.begin());
  for (const Link<S>& link : tree_->links()) {
    if (!link.driven) continue;
    projected_[link.at_q] = link.driven_start + t_s * link.driven_rate;
    projected_[link.at_u] = link.driven_rate;
  }
  return constraints_->project(projected_.data()) ? projected_.data() : y;
}

template <class S> void RigidModel<S>::write(S t_s, const S* y, Sample& sample) {
  y = at_driven_coordinates(t_s, y);
  sample.bodies.resize(slots_.size());
  if (tree_ != nullptr) write_joints(t_s, y, sample);  // places the bodies
  for (int i = 0; i < body_count(); ++i) {
    BodyState<S> state;
    if (slots_[i].on_joint) {
      const S* at = placed_.data() + i * kRotatingSize;
      state = {load3(at + kAtPosition), load3(at + kAtVelocity), load4(at + kAtAttitude), load3(at + kAtBodyRate)};
    } else if (bare_problem_) {  // the unknowns are the position, their rates the velocity
      S dydt[3];
      system_.rate_of(this, t_s, y, dydt);
      state.p_WB = load3(y);
      state.v_WB = load3(dydt);
    } else {
      state = body(i, y);
    }
    BodySample& out = sample.bodies[i];
    out.p_m = {state.p_WB.x, state.p_WB.y, state.p_WB.z};
    out.q_wxyz = {state.q_WB.w, state.q_WB.x, state.q_WB.y, state.q_WB.z};
    out.v_m_per_s = {state.v_WB.x, state.v_WB.y, state.v_WB.z};
    out.w_rad_per_s = {state.w_WB_B.x, state.w_WB_B.y, state.w_WB_B.z};
  }
}

template <class S> void RigidModel<S>::normalise(S* y) const {
  for (const Attitude& attitude : attitudes_) store4(normalised(load4(y + attitude.q_at)), y + attitude.q_at);
}

template <class S> void RigidModel<S>::project_of(void* context, S* y) {
  RigidModel& model = *static_cast<RigidModel*>(context);
  model.normalise(y);
  if (model.constraints_ == nullptr || !model.project_constraints_) return;
  model.constraints_->project(y);
  model.system_.solvers.add(IterativeSolver::invariant_projection, model.constraints_->report());
}

// q / |q| - q = q (1 / n - 1) with n = sqrt(1 + e), e = |q|^2 - 1: -q e / (n (1 + n)), without the cancellation.
template <class S> void RigidModel<S>::projection_of(void* context, const S* y, S* change) {
  RigidModel& model = *static_cast<RigidModel*>(context);
  std::fill(change, change + model.state_size_, S(0));
  if (model.constraints_ != nullptr && model.project_constraints_) {
    std::copy(y, y + model.state_size_, model.projected_.begin());
    project_of(context, model.projected_.data());
    for (int i = 0; i < model.state_size_; ++i) change[i] = model.projected_[i] - y[i];
    return;
  }
  for (const Attitude& attitude : model.attitudes_) {
    const S* q = y + attitude.q_at;
    const S excess = (q[0] * q[0] - S(1)) + (q[1] * q[1] + q[2] * q[2] + q[3] * q[3]), n = real::sqrt(S(1) + excess);
    const S factor = -excess / (n * (S(1) + n));
    for (int k = 0; k < 4; ++k) change[attitude.q_at + k] = factor * q[k];
  }
}

template class RigidModel<float>;
template class RigidModel<double>;
template class RigidModel<long double>;
template class RigidModel<Quad>;

}  // namespace atwood

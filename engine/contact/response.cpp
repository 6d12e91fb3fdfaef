#include "contact/response.hpp"

namespace atwood {

template <class S> ContactRun<S> make_contact_run(RigidModel<S>& model, Stepper<S>& stepper, const Scene& scene, std::string& why) {
  ContactRun<S> run{model, stepper, contact_pairs<S>(scene, why), {}, {}, {}, {}, {}, {}, {}, S(0), S(0), S(0), nullptr, {}};
  for (const Force& force : scene.forces) {
    const auto* drag = std::get_if<QuadraticDrag>(&force);
    if (!drag) continue;
    for (const int body : drag->bodies) run.winds.push_back({body, narrow3<S>(drag->wind_m_per_s)});
  }
  const auto size = static_cast<std::size_t>(model.state_size());
  for (auto* y : {&run.y, &run.y_new, &run.y_try, &run.y_probe, &run.dydt}) y->resize(size);
  run.resting.reserve(run.pairs.size());
  model.initial_state(run.y.data());
  return run;
}

template <class S> Gap<S> gap_of(const ContactRun<S>& run, const ContactPair<S>& pair, const S* y) {
  return gap_between(pair, run.model.body(pair.a, y).p_WB, run.model.body(pair.b, y).p_WB);
}

// The gap's rate is the relative velocity of the centres along the normal, spin or not: both bodies are balls or planes.
template <class S> S gap_rate(const ContactRun<S>& run, const ContactPair<S>& pair, const S* y) {
  const Gap<S> gap = gap_of(run, pair, y);
  return dot(run.model.body(pair.b, y).v_WB - run.model.body(pair.a, y).v_WB, gap.normal_W);
}

namespace {

// I^-1 in world axes, R I_B^-1 R^T, by its action on the world's axes (it is symmetric, so columns are rows).
template <class S>
void load_body(const RigidModel<S>& model, int body, const Vec3<S>& point_W, const S* y, ImpactBody<S>& out) {
  const BodyState<S> state = model.body(body, y);
  const MassProperties<S>& mass = model.mass(body);
  const bool moves = model.offset(body) >= 0;
  out = {};
  out.inverse_mass_per_kg = moves ? S(1) / mass.mass_kg : S(0);
  out.r_W = point_W - state.p_WB;
  out.v_W = state.v_WB;
  if (!moves || !model.rotates(body)) return;
  out.w_W = rotate(state.q_WB, state.w_WB_B);
  const Vec3<S> axes[3] = {{S(1), S(0), S(0)}, {S(0), S(1), S(0)}, {S(0), S(0), S(1)}};
  for (int i = 0; i < 3; ++i) {
    out.I_inverse_W_row[i] = rotate(state.q_WB, mass.times_inverse_inertia(rotate_back(state.q_WB, axes[i])));
  }
}

template <class S> void store_body(const RigidModel<S>& model, int body, const ImpactBody<S>& from, S* y) {
  if (model.offset(body) < 0) return;
  BodyState<S> state = model.body(body, y);
  state.v_WB = from.v_W;
  if (model.rotates(body)) state.w_WB_B = rotate_back(state.q_WB, from.w_W);
  model.set_body(body, state, y);
}

}  // namespace

template <class S>
void load_impact(const ContactRun<S>& run, const ContactPair<S>& pair, const Gap<S>& gap, const S* y, ImpactBody<S>& a,
                 ImpactBody<S>& b) {
  load_body(run.model, pair.a, gap.point_W, y, a);
  load_body(run.model, pair.b, gap.point_W, y, b);
}

template <class S>
void store_impact(const ContactRun<S>& run, const ContactPair<S>& pair, const ImpactBody<S>& a, const ImpactBody<S>& b, S* y) {
  store_body(run.model, pair.a, a, y);
  store_body(run.model, pair.b, b, y);
}

template <class S>
void report_event(const ContactRun<S>& run, EventKind kind, const ContactPair<S>& pair, const Gap<S>& gap,
                  const Impulse<S>& impulse, S t_s) {
  if (!run.observer || !run.observer->event) return;
  Event event;
  event.t_s = Wide(t_s);
  event.kind = kind;
  event.body_a = pair.a;
  event.body_b = pair.b;
  event.x_m = {Wide(gap.point_W.x), Wide(gap.point_W.y), Wide(gap.point_W.z)};
  event.normal = {Wide(gap.normal_W.x), Wide(gap.normal_W.y), Wide(gap.normal_W.z)};
  event.impulse_n_N_s = Wide(impulse.normal_N_s);
  event.impulse_t_N_s = Wide(impulse.tangential_N_s);
  event.vn_before_m_per_s = Wide(impulse.vn_before_m_per_s);
  event.vn_after_m_per_s = Wide(impulse.vn_after_m_per_s);
  run.observer->event(event);
}

template <class S> bool is_resting(const ContactRun<S>& run, int pair) {
  for (const Resting& resting : run.resting) {
    if (resting.pair == pair) return true;
  }
  return false;
}

template <class S> S normal_acceleration(ContactRun<S>& run, const ContactPair<S>& pair, S t_s, const S* y) {
  run.model.system().rate(t_s, y, run.dydt.data());
  const Gap<S> gap = gap_of(run, pair, y);
  auto acceleration = [&](int body) {
    const int offset = run.model.offset(body);
    return offset < 0 ? Vec3<S>{} : load3(run.dydt.data() + offset + at_velocity);
  };
  return dot(acceleration(pair.b) - acceleration(pair.a), gap.normal_W);
}

#define ATWOOD_RESPONSE(S)                                                                                                  \
  template ContactRun<S> make_contact_run<S>(RigidModel<S>&, Stepper<S>&, const Scene&, std::string&);                       \
  template Gap<S> gap_of<S>(const ContactRun<S>&, const ContactPair<S>&, const S*);                                          \
  template S gap_rate<S>(const ContactRun<S>&, const ContactPair<S>&, const S*);                                             \
  template void load_impact<S>(const ContactRun<S>&, const ContactPair<S>&, const Gap<S>&, const S*, ImpactBody<S>&,         \
                               ImpactBody<S>&);                                                                              \
  template void store_impact<S>(const ContactRun<S>&, const ContactPair<S>&, const ImpactBody<S>&, const ImpactBody<S>&, S*); \
  template void report_event<S>(const ContactRun<S>&, EventKind, const ContactPair<S>&, const Gap<S>&, const Impulse<S>&, S); \
  template bool is_resting<S>(const ContactRun<S>&, int);                                                                    \
  template S normal_acceleration<S>(ContactRun<S>&, const ContactPair<S>&, S, const S*);
ATWOOD_RESPONSE(float)
ATWOOD_RESPONSE(double)
ATWOOD_RESPONSE(long double)
#undef ATWOOD_RESPONSE

}  // namespace atwood

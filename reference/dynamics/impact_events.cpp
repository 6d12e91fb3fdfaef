#include "dynamics/impact_events.hpp"

#include <type_traits>

namespace atwood::dynamics {

namespace {

constexpr int kMaxStalled = 1000;
// Smaller than one unit in the last place of 1.
template <class S> constexpr S kUlp = std::is_same_v<S, Wide> ? S(0x1p-112) : S(0x1p-52);

}  // namespace

template <class S> Event event_at(S t_s, EventKind kind, const ContactPair& pair, const Gap<S>& where) {
  Event made;
  made.t_s = t_s;
  made.kind = kind;
  made.body_a = pair.a;
  made.body_b = pair.b;
  for (int k = 0; k < 3; ++k) {
    made.x_m[k] = where.x_m[k];
    made.normal[k] = where.normal[k];
  }
  return made;
}

template <class S>
void append_impacts(const Scene& scene, const Layout& layout, const Impact<S>& impact, const S* after, S t_s,
                    std::vector<Event>& events) {
  for (std::size_t k = 0; k < impact.pairs.size(); ++k) {
    if (!(impact.impulses[k].normal_N_s > 0)) continue;
    const Gap<S> before = gap(scene, layout, impact.pairs[k], impact.before.data());
    Event made = event_at(t_s, EventKind::impact, impact.pairs[k], before);
    made.impulse_n_N_s = impact.impulses[k].normal_N_s;
    made.impulse_t_N_s = impact.impulses[k].tangential_N_s;
    made.vn_before_m_per_s = before.rate_m_per_s;
    made.vn_after_m_per_s = gap(scene, layout, impact.pairs[k], after).rate_m_per_s;
    events.push_back(made);
  }
}

template <class S>
ImpactRefusal impact_refusal(const Scene& scene, const Layout& layout, const ContactPair& pair,
                             const std::vector<ContactPair>& held, S t_s, const S* y) {
  ImpactRefusal made;
  const auto name = [&](int body) { return "`" + scene.bodies[body].name + "`"; };
  for (const int body : {pair.a, pair.b})
    if (!scene.bodies[body].fixed && scene.bodies[body].release_s > t_s)
      made.why = "an impact on " + name(body) + " before its release is not covered";
  for (const ContactPair& other : held)
    for (const int body : {pair.a, pair.b})
      if (body == ball_of(scene, other) && coupled(scene, layout, pair, other, y))
        made = {"an impact on " + name(body) + " while it rests on " + name(plane_of(scene, other)) + " is not covered",
                true};
  if (const std::string why = impact_unsupported(scene, pair); !why.empty()) made.why = why + " is not covered";
  return made;
}

template <class S> bool ImpactProgress<S>::advances(S t_s) {
  stalled_ = last_impact_s_ >= 0 && t_s - last_impact_s_ <= kUlp<S> * t_s ? stalled_ + 1 : 0;
  last_impact_s_ = t_s;
  return stalled_ <= kMaxStalled;
}

template <class S> std::string ImpactProgress<S>::failure(S t_s) {
  return "the time does not advance over " + std::to_string(kMaxStalled) +
         " impacts at t = " + format_double(static_cast<double>(t_s)) + " s";
}

#define ATWOOD_IMPACT_EVENTS(S)                                                                                  \
  template Event event_at(S, EventKind, const ContactPair&, const Gap<S>&);                                      \
  template void append_impacts(const Scene&, const Layout&, const Impact<S>&, const S*, S, std::vector<Event>&); \
  template ImpactRefusal impact_refusal(const Scene&, const Layout&, const ContactPair&,                         \
                                        const std::vector<ContactPair>&, S, const S*);                           \
  template class ImpactProgress<S>;
ATWOOD_IMPACT_EVENTS(double)
ATWOOD_IMPACT_EVENTS(Wide)
#undef ATWOOD_IMPACT_EVENTS

}  // namespace atwood::dynamics

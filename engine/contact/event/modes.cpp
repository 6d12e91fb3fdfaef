// Which contacts touch, which carry, which slip and which hold, at one instant.
//
// First all contacts carry, and what has no slip holds: where the forces for that obey the laws, they are it. Else who
// pulls lets go, who would leave his cone slips along what held him, and so on, as long as what follows agrees with
// the laws. Where it does not, forces are settled contact by contact (settle.cpp), and tell who lets go, who slips and
// along what; redundant contacts may stand at the edge of their cones while others hold the body.
#include <algorithm>

#include "contact/event/run.hpp"

namespace atwood::event {

namespace {

enum class Standing : unsigned char { apart, smooth, slips, sticks, rolls };

template <class S> Vec3<S> across(const Vec3<S>& v, const Vec3<S>& n) { return v - dot(v, n) * n; }

// Of the bodies' accelerations without contacts, plus what circling gives.
template <class S> S acceleration_scale(const EventRun<S>& run, const S* dydt) {
  S size = S(0);
  for (const int body : run.contact_bodies) {
    if (!run.moves[body]) continue;
    const Vec3<S> a = load3(dydt + run.model.offset(body) + kAtVelocity);
    const S w = norm(run.poses[body].w);
    size = real::max(size, norm(a) + w * w * run.reach[body]);
  }
  return size;
}

// What circles at a speed of round-off: after a dead impact far from any force nothing else is left.
template <class S> S circling_of_round_off(const EventRun<S>& run) {
  S most = S(0);
  for (const int body : run.contact_bodies)
    if (run.moves[body] && run.reach[body] > S(0))
      most = real::max(most, run.slip_round_off() * run.slip_round_off() / run.reach[body]);
  return most;
}

template <class S> Standing standing_of(const EventRun<S>& run, int pair) {
  Standing standing = Standing::apart;
  for (const Contact<S>& contact : run.contacts) {
    if (run.features[contact.feature].pair != pair || !contact.carries) continue;
    if (contact.mode == Mode::slips && !contact.waits) return Standing::slips;
    if (contact.mode == Mode::smooth) standing = Standing::smooth;
    else if (standing != Standing::rolls)
      standing = norm(across(contact.w, contact.sight.normal)) > run.slip_round_off() / run.pairs[pair].reach
                     ? Standing::rolls
                     : Standing::sticks;
  }
  return standing;
}

template <class S> void see_all(EventRun<S>& run) {
  for (const int body : run.contact_bodies) run.poses[body] = pose_of(run, body, run.y.data());
  for (Contact<S>& contact : run.contacts) {
    const Feature<S>& feature = run.features[contact.feature];
    const Pose<S>&of = run.poses[feature.knob_body], &on = run.poses[feature.surface_body];
    contact.sight = watch(feature.knob, of, run.surfaces[feature.surface], contact.facet, on);
    contact.u = (of.v + cross(of.w, contact.sight.x - of.p)) - (on.v + cross(on.w, contact.sight.x - on.p));
    contact.w = of.w - on.w;
  }
}

// Features that touch and neither approach nor leave join the contacts.
template <class S> void gather(EventRun<S>& run) {
  for (const int p : run.near) {
    const ShapePair<S>& pair = run.pairs[p];
    if (!run.moves[pair.a] && !run.moves[pair.b]) continue;
    for (int f = pair.first; f < pair.first + pair.count; ++f) {
      Feature<S>& feature = run.features[f];
      if (feature.lasting) continue;
      const Sight<S> sight = sight_of(run, feature, run.y.data());
      if (!(sight.gap <= run.gap_round_off()) || real::abs(sight.rate) > run.slip_round_off()) continue;
      pose_bodies(run, feature, run.y.data());
      Contact<S> contact;
      contact.feature = f;
      S beside{};
      contact.facet = facet_under(run, feature, beside);
      if (sight.gap < -run.gap_round_off()) contact.rest_gap = sight.gap;
      feature.lasting = true;
      run.contacts.push_back(contact);
    }
  }
}

template <class S> void list_bodies(EventRun<S>& run) {
  run.contact_bodies.clear();
  for (const Contact<S>& contact : run.contacts)
    for (const int body : {run.features[contact.feature].knob_body, run.features[contact.feature].surface_body})
      if (run.model.offset(body) >= 0 &&
          std::find(run.contact_bodies.begin(), run.contact_bodies.end(), body) == run.contact_bodies.end())
        run.contact_bodies.push_back(body);
}

template <class S> void first_modes(EventRun<S>& run) {
  for (Contact<S>& contact : run.contacts) contact.slip_speed = norm(across(contact.u, contact.sight.normal));
  for (Contact<S>& contact : run.contacts) {
    const int p = run.features[contact.feature].pair;
    const ShapePair<S>& pair = run.pairs[p];
    const Vec3<S> slip = across(contact.u, contact.sight.normal), roll = across(contact.w, contact.sight.normal);
    const S speed = norm(slip), rolling = norm(roll), still = run.slip_round_off();
    // Corners of one body stop together: where one has stopped, the others' round-off may be somewhat more.
    const bool stops =
        !(speed > S(64) * still) && std::any_of(run.contacts.begin(), run.contacts.end(), [&](const Contact<S>& other) {
          return run.features[other.feature].pair == p && !(other.slip_speed > still);
        });
    contact.carries = true;
    contact.slip_speed = speed;
    contact.roll_speed = rolling;
    if (!(pair.friction > S(0))) contact.mode = Mode::smooth;
    else if (!stops) {
      contact.mode = Mode::slips;
      contact.slip_direction = (S(1) / speed) * slip;
      contact.waits = false;
    } else if (!contact.gives_way) {
      contact.mode = Mode::sticks;
      contact.waits = false;
    }
    if (!(pair.rolling_friction_m > S(0))) contact.turning = Turning::free;
    else if (rolling * pair.reach > still) {
      contact.turning = Turning::rolls;
      contact.roll_direction = (S(1) / rolling) * roll;
    } else if (!contact.turns_over) {
      contact.turning = Turning::held;
    }
    contact.turns_over = false;
  }
}

template <class S> void forget_who_gave_way(EventRun<S>& run) {
  for (Contact<S>& contact : run.contacts) contact.gives_way = false;
}

template <class S> void count_carrying(EventRun<S>& run) {
  run.carrying = static_cast<int>(
      std::count_if(run.contacts.begin(), run.contacts.end(), [](const Contact<S>& c) { return c.carries; }));
}

// Do the forces of the linear solve, all contacts carrying and what has no slip holding, obey the laws as they are?
template <class S> bool obeys(const EventRun<S>& run, S tiny_N) {
  return run.solvable && std::all_of(run.contacts.begin(), run.contacts.end(), [&](const Contact<S>& contact) {
           const ShapePair<S>& pair = run.pairs[run.features[contact.feature].pair];
           if (!contact.carries || contact.waits || contact.normal_N < tiny_N) return false;
           if (pair.count == 1 && !(contact.normal_N > tiny_N)) return false;
           if (contact.mode == Mode::sticks && norm(contact.friction_N) > pair.friction * contact.normal_N)
             return false;
           return contact.turning != Turning::held ||
                  norm(contact.couple_N_m) <= pair.rolling_friction_m * contact.normal_N;
         });
}

// ---- from linear solve to linear solve ------------------------------------------------------------------------------
constexpr int kMostGuesses = 12;

// Who pulls lets go, who is past his cone slips; true: somebody did.
template <class S> bool let_go(EventRun<S>& run, S tiny_N) {
  bool changed = false;
  for (Contact<S>& contact : run.contacts) {
    if (!contact.carries || contact.normal_N > tiny_N) continue;
    contact.carries = false;
    changed = true;
  }
  if (changed) return true;
  for (Contact<S>& contact : run.contacts) {
    if (!contact.carries) continue;
    const ShapePair<S>& pair = run.pairs[run.features[contact.feature].pair];
    const S held = norm(contact.friction_N), turned = norm(contact.couple_N_m);
    if (contact.mode == Mode::sticks && held > pair.friction * contact.normal_N) {
      contact.mode = Mode::slips;
      contact.slip_direction = (S(-1) / held) * contact.friction_N;
      changed = true;
    }
    if (contact.turning == Turning::held && turned > pair.rolling_friction_m * contact.normal_N) {
      contact.turning = Turning::rolls;
      contact.roll_direction = (S(-1) / turned) * contact.couple_N_m;
      changed = true;
    }
  }
  return changed;
}

// What sets in must go where its friction says, or nowhere: then others hold it at the edge of its cone.
template <class S> bool goes_along(const Vec3<S>& sets_in, const Vec3<S>& direction, S tiny, bool& waits) {
  const S along = dot(sets_in, direction), aside = norm(sets_in - along * direction);
  waits = !(norm(sets_in) > tiny);
  return waits || (along > S(0) && aside <= real::sqrt(real::epsilon<S>()) * along + tiny);
}

// Does what has been let go go, and along what its friction says? Who is pressed again carries again: `pressed`.
template <class S> bool lets_agree(EventRun<S>& run, S tiny_acceleration, bool& pressed) {
  pressed = false;
  for (Contact<S>& contact : run.contacts) {
    if (contact.carries) continue;
    if (normal_acceleration(run, contact, run.dydt.data()) < -tiny_acceleration) contact.carries = pressed = true;
  }
  if (pressed) return true;
  for (Contact<S>& contact : run.contacts) {
    if (!contact.carries) continue;
    const Vec3<S>& n = contact.sight.normal;
    bool waits = false;
    if (contact.mode == Mode::slips && !(contact.slip_speed > run.slip_round_off())) {
      const Vec3<S> sets_in = across(relative_acceleration(run, contact, run.dydt.data()), n);
      if (!goes_along(sets_in, contact.slip_direction, tiny_acceleration, waits)) return false;
      contact.waits = waits;
    }
    const S reach = run.pairs[run.features[contact.feature].pair].reach;
    if (contact.turning == Turning::rolls && !(contact.roll_speed * reach > run.slip_round_off())) {
      const Vec3<S> sets_in = reach * across(relative_turning(run, contact, run.dydt.data()), n);
      if (!goes_along(sets_in, contact.roll_direction, tiny_acceleration, waits) || waits) return false;
    }
  }
  return true;
}

// Forces that obey the laws, and modes with them; false: none was found, modes are as they were.
template <class S> bool guess_modes(EventRun<S>& run, S t_s, S tiny_N, S tiny_acceleration) {
  if (std::any_of(run.contacts.begin(), run.contacts.end(), [](const Contact<S>& c) { return c.waits; })) return false;
  run.contacts_guessed = run.contacts;
  for (int guess = 0; guess < kMostGuesses && run.solvable; ++guess) {
    if (let_go(run, tiny_N)) {
      run.free_rate_of(run.free_context, t_s, run.y.data(), run.dydt.data());
      contact_rates(run, t_s, run.y.data(), run.dydt.data());
      continue;
    }
    bool pressed = false;
    if (!lets_agree(run, tiny_acceleration, pressed)) break;
    if (!pressed) return true;
    run.free_rate_of(run.free_context, t_s, run.y.data(), run.dydt.data());
    contact_rates(run, t_s, run.y.data(), run.dydt.data());
  }
  run.contacts.swap(run.contacts_guessed);
  run.solvable = true;
  return false;
}

// Modes from settled forces.
template <class S> void take_modes(EventRun<S>& run, S tiny_N, S tiny_acceleration) {
  for (Contact<S>& contact : run.contacts) {
    const ShapePair<S>& pair = run.pairs[run.features[contact.feature].pair];
    const Vec3<S>& n = contact.sight.normal;
    contact.carries = contact.normal_N > tiny_N;
    contact.share_N = contact.normal_N;
    contact.largest_N = real::max(contact.largest_N, contact.normal_N);
    if (contact.mode != Mode::smooth && (contact.mode == Mode::sticks || contact.waits)) {
      const Vec3<S> sets_in = across(contact.u_dot, n);
      const S size = norm(sets_in), held = norm(contact.friction_N);
      contact.mode = Mode::sticks;
      contact.waits = false;
      if (size > tiny_acceleration) {
        contact.mode = Mode::slips;
        contact.slip_direction = (S(1) / size) * sets_in;
      } else if (held > S(0) && (contact.gives_way || held > pair.friction * contact.normal_N - tiny_N)) {
        contact.mode = Mode::slips;
        contact.waits = true;
        contact.slip_direction = (S(-1) / held) * contact.friction_N;
      }
    }
    if (contact.turning == Turning::held) {
      const Vec3<S> sets_in = across(contact.alpha, n);
      const S size = norm(sets_in);
      if (size * pair.reach > tiny_acceleration) {
        contact.turning = Turning::rolls;
        contact.roll_direction = (S(1) / size) * sets_in;
      }
    }
  }
}

// A pair whose contacts all stand at the edge of their cones has nothing left that holds it.
template <class S> void start_sliding(EventRun<S>& run) {
  for (Contact<S>& contact : run.contacts) {
    if (!contact.waits) continue;
    const int pair = run.features[contact.feature].pair;
    contact.waits = std::any_of(run.contacts.begin(), run.contacts.end(), [&](const Contact<S>& other) {
      return other.carries && other.mode == Mode::sticks && run.features[other.feature].pair == pair;
    });
  }
}

template <class S> void drop_leaving(EventRun<S>& run, S tiny_acceleration) {
  std::erase_if(run.contacts, [&](const Contact<S>& contact) {
    const bool leaves = !contact.carries && normal_acceleration(run, contact, run.dydt.data()) > tiny_acceleration;
    if (leaves) run.features[contact.feature].lasting = false;
    return leaves;
  });
}

template <class S>
void report_change(EventRun<S>& run, const Contact<S>& contact, Standing before, Standing now, S t_s) {
  if (before == now || before == Standing::apart) return;
  const Feature<S>& feature = run.features[contact.feature];
  const ShapePair<S>& pair = run.pairs[feature.pair];
  EventKind kind = EventKind::separate;
  if (now == Standing::slips) kind = EventKind::slip;
  else if (now == Standing::sticks && before == Standing::slips) kind = EventKind::stick;
  else if (now == Standing::rolls && before == Standing::slips) kind = EventKind::roll;
  else if (now != Standing::apart) return;
  report_event(run, kind, pair, contact.sight, feature.knob_body == pair.a, Impulse<S>{}, t_s);
}

}  // namespace

template <class S>
void report_event(const EventRun<S>& run, EventKind kind, const ShapePair<S>& pair, const Sight<S>& sight,
                  bool knob_is_a, const Impulse<S>& impulse, S t_s) {
  if (!run.observer || !run.observer->event) return;
  const Vec3<S> normal = knob_is_a ? -sight.normal : sight.normal, x = sight.x - (sight.gap / S(2)) * sight.normal;
  Event event;
  event.t_s = Wide(t_s);
  event.kind = kind;
  event.body_a = pair.a;
  event.body_b = pair.b;
  event.x_m = {Wide(x.x), Wide(x.y), Wide(x.z)};
  event.normal = {Wide(normal.x), Wide(normal.y), Wide(normal.z)};
  event.impulse_n_N_s = Wide(impulse.normal_N_s);
  event.impulse_t_N_s = Wide(impulse.tangential_N_s);
  event.vn_before_m_per_s = Wide(impulse.vn_before_m_per_s);
  event.vn_after_m_per_s = Wide(impulse.vn_after_m_per_s);
  run.observer->event(event);
}

template <class S> bool review_contacts(EventRun<S>& run, S t_s, bool report) {
  run.sights_at_start = false;
  run.inconsistent = -1;
  const std::vector<Contact<S>>& old = run.contacts_before;
  run.contacts_before = run.contacts;
  std::vector<unsigned char>& standing = run.standing_before;  // of each old contact's pair
  standing.clear();
  if (report)
    for (const Contact<S>& contact : old) {
      const int pair = run.features[contact.feature].pair;
      standing.push_back(static_cast<unsigned char>(standing_of(run, pair)));
    }
  std::erase_if(run.contacts, [](const Contact<S>& contact) { return contact.left; });
  gather(run);
  run.carrying = 0;
  if (!run.contacts.empty()) {
    list_bodies(run);
    see_all(run);
    first_modes(run);
    start_sliding(run);
    count_carrying(run);
    run.solvable = true;
    run.free_rate_of(run.free_context, t_s, run.y.data(), run.dydt.data());
    const S size = acceleration_scale(run, run.dydt.data());
    S heaviest = S(0);
    for (const int body : run.contact_bodies) heaviest = real::max(heaviest, run.model.mass(body).mass_kg);
    const S unseen = circling_of_round_off(run);
    const S tiny_acceleration = real::max(S(1e6) * real::epsilon<S>() * size, unseen);
    const S tiny_N = real::max(S(1e5) * real::epsilon<S>() * size, unseen) * heaviest;
    for (Contact<S>& contact : run.contacts) {
      contact.share_N = contact.largest_N = S(0);
      contact.share_friction_N = contact.share_couple_N_m = {};
    }
    if (run.carrying > 0) contact_rates(run, t_s, run.y.data(), run.dydt.data());
    if (!obeys(run, tiny_N) && !guess_modes(run, t_s, tiny_N, tiny_acceleration)) {
      run.free_rate_of(run.free_context, t_s, run.y.data(), run.dydt.data());
      settle_forces(run, run.dydt.data(), S(0));
      take_modes(run, tiny_N, tiny_acceleration);
      start_sliding(run);
      count_carrying(run);
      run.solvable = true;
      if (run.carrying > 0) contact_rates(run, t_s, run.y.data(), run.dydt.data());
    }
    forget_who_gave_way(run);
    if (!run.solvable) {
      run.outcome = {Status::diverged, "atwood's +event found no contact forces that obey Coulomb's law", 0, 0, {}};
      return false;
    }
    // Of several contacts, forces are known to no more than that.
    const S coarse = run.contacts.size() > 1 ? real::sqrt(real::epsilon<S>()) * size : S(0);
    run.rises_enough = S(4) * real::max(tiny_acceleration, coarse);
    if (!judge_forces(run, t_s, real::max(tiny_acceleration, coarse), real::max(tiny_N, coarse * heaviest)))
      return false;
    drop_leaving(run, tiny_acceleration);
    count_carrying(run);
    list_bodies(run);
  }
  ++run.model.system().epoch;
  run.seen_epoch = run.model.system().epoch;
  if (!report) return true;
  for (std::size_t i = 0; i < old.size(); ++i) {
    const int pair = run.features[old[i].feature].pair;
    if (i > 0 && run.features[old[i - 1].feature].pair == pair)
      continue;  // one event a pair; its contacts stand together
    report_change(run, old[i], static_cast<Standing>(standing[i]), standing_of(run, pair), t_s);
  }
  return true;
}

#define ATWOOD_MODES(S)                                                                                    \
  template void report_event<S>(const EventRun<S>&, EventKind, const ShapePair<S>&, const Sight<S>&, bool, \
                                const Impulse<S>&, S);                                                     \
  template bool review_contacts<S>(EventRun<S>&, S, bool);
ATWOOD_MODES(float)
ATWOOD_MODES(double)
ATWOOD_MODES(long double)
#undef ATWOOD_MODES

}  // namespace atwood::event

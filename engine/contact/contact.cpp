#include "contact/contact.hpp"

#include "contact/event/event.hpp"
#include "contact/stepping/run.hpp"

namespace atwood {

Outcome run_with_contacts(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer,
                          int repeats) {
  if (id.response == "impulse") return run_impulse(id, scene, plan, observer, repeats);
  if (id.response == "event") return run_event(id, scene, plan, observer, repeats);
  return {Status::unsupported,
          "atwood has no contact response `+" + id.response + "`; it has +impulse and +event",
          0,
          0,
          {}};
}

}  // namespace atwood

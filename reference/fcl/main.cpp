// FCL as a worker: contact queries only, no simulation.
#include "fcl/contacts.hpp"
#include "protocol/worker.hpp"
#include "rivals/unit_size.hpp"

int main() {
  atwood::Engine engine;
  engine.name = "fcl";
  engine.version = FCL_VERSION_TEXT;
  engine.scalar = "double";
  engine.run = [](const atwood::MethodId&, const atwood::Scene&, const atwood::Plan&, const atwood::Observer&, int) {
    return atwood::Outcome{
        atwood::Status::unsupported, "fcl answers contact queries only and does not simulate motion", 0, 0, {}};
  };
  engine.contacts = atwood::fcl_adapter::find_contacts;
  return atwood::serve(engine, {&atwood::fcl_adapter::find_gap,
                                false,
                                {{"unit-size", atwood::rivals::at_unit_size(atwood::fcl_adapter::find_contacts)}}});
}

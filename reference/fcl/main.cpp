// FCL as a worker: a rival in contact queries, no engine of motion.
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
        atwood::Status::unsupported, "fcl answers questions about contacts, it moves nothing", 0, 0, {}};
  };
  engine.contacts = atwood::fcl_adapter::find_contacts;
  return atwood::serve(engine, {&atwood::fcl_adapter::find_gap,
                                false,
                                {{"unit-size", atwood::rivals::at_unit_size(atwood::fcl_adapter::find_contacts)}}});
}

// libccd as a worker: a rival in contact queries, no engine of motion.
#include "libccd/contacts.hpp"
#include "protocol/worker.hpp"
#include "rivals/unit_size.hpp"

int main() {
  atwood::Engine engine;
  engine.name = "libccd";
  engine.version = "2.1";
  engine.scalar = "double";
  engine.run = [](const atwood::MethodId&, const atwood::Scene&, const atwood::Plan&, const atwood::Observer&, int) {
    return atwood::Outcome{
        atwood::Status::unsupported, "libccd answers questions about contacts, it moves nothing", 0, 0, {}};
  };
  engine.contacts = atwood::libccd::find_contacts;
  const auto at_unit_size = atwood::rivals::at_unit_size(atwood::libccd::find_contacts);
  return atwood::serve(engine, {{}, false, {{"unit-size", at_unit_size}}});
}

#include "ode/contacts.hpp"
#include "ode/ode.hpp"
#include "protocol/worker.hpp"
#include "rivals/unit_size.hpp"

int main() {
  return atwood::serve(atwood::ode_engine(),
                       {{}, false, {{"unit-size", atwood::rivals::at_unit_size(atwood::ode::find_contacts)}}});
}

#include "bullet/bullet.hpp"
#include "bullet/contacts.hpp"
#include "protocol/worker.hpp"
#include "rivals/unit_size.hpp"

int main() {
  return atwood::serve(atwood::bullet_engine(),
                       {{},
                        false,
                        {{"closest-points", atwood::bullet::closest_points},
                         {"unit-size", atwood::rivals::at_unit_size(atwood::bullet::find_contacts)}}});
}

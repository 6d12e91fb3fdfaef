target_sources(atwood_engine PRIVATE
  collision/compound_pairs.cpp
  collision/contacts.cpp
  collision/gap.cpp
  collision/geometry.cpp
  collision/hull.cpp
  collision/plane_pairs.cpp
  collision/sphere_pairs.cpp
  contact/contact.cpp
  contact/impulse.cpp
  contact/located.cpp
  contact/options.cpp
  contact/response.cpp
  contact/slip_path.cpp
  contact/time_stepping.cpp)

target_sources(atwood_engine PRIVATE
  collision/gap.cpp
  collision/hull.cpp
  contact/contact.cpp
  contact/impulse.cpp
  contact/located.cpp
  contact/options.cpp
  contact/response.cpp
  contact/time_stepping.cpp)

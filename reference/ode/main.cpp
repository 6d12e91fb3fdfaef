#include "ode/ode.hpp"
#include "protocol/worker.hpp"

int main() { return atwood::serve(atwood::ode_engine()); }

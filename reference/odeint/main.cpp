#include "odeint/odeint.hpp"
#include "protocol/worker.hpp"

int main() { return atwood::serve(atwood::odeint_engine()); }

// The in-house engine as a worker process.
#include "protocol/worker.hpp"
#include "simulation.hpp"

int main() { return atwood::serve(atwood::atwood_engine()); }

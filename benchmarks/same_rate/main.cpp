#include "benchmarks/same_rate/same_rate.hpp"
#include "protocol/worker.hpp"

int main() { return atwood::serve(atwood::same_rate_engine()); }

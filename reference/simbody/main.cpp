#include "protocol/worker.hpp"
#include "simbody/simbody.hpp"

int main() { return atwood::serve(atwood::simbody_engine()); }

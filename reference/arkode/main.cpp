#include "arkode/arkode.hpp"
#include "protocol/worker.hpp"

int main() { return atwood::serve(atwood::arkode_engine()); }

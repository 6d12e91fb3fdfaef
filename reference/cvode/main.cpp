#include "cvode/cvode.hpp"
#include "protocol/worker.hpp"

int main() { return atwood::serve(atwood::cvode_engine()); }

#include "dart/engine.hpp"
#include "protocol/worker.hpp"

int main() { return atwood::serve(atwood::dart_engine()); }

#include "ida/ida.hpp"
#include "protocol/worker.hpp"

int main() { return atwood::serve(atwood::ida_engine()); }
